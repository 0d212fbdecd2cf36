# SPDX-License-Identifier: Apache-2.0
"""The netlist that was placed and routed, as Verilog that a simulator takes.

nextpnr writes it (``--write``) together with the file that becomes the bitstream: the cells are
those of the FPGA, logic cells with their tables, carries and flip-flops, the multipliers, pads,
PLL and clock networks, wired as they were routed. What comes after it is not in here: that the
router may swap a table's inputs on the ECP5, and the packing of the bits.

An agreement with the RTL rests on the models of the cells. Those of Yosys' library are taken where
it has them; ``sim/cells`` has the others, made from the vendors' descriptions. Pins that nothing
drives have the level that the FPGA gives them (``_OPEN``), and the cells begin as the configuration
leaves them.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from wavehaptics.runtime.repository import CELLS, ROOT
from wavehaptics.runtime.toolchain import Toolchain

from wavetools.fpga.synthesis import SynthesisError

_OPEN: dict[str, dict[str, str]] = {
    "ICESTORM_LC": {"CEN": "1"},
    "ICESTORM_DSP": {"CE": "1"},
    "ICESTORM_RAM": {"RCLKE": "1", "WCLKE": "1"},
    "TRELLIS_COMB": dict.fromkeys("ABCD", "1"),
    "TRELLIS_FF": {"CE": "1"},
    "DCCA": {"CE": "1"},
    "DP16KD": dict.fromkeys(("CEA", "CEB", "WEA", "WEB"), "1"),
}
"""Levels of pins that nothing drives; 0 where not named."""

_UNUSED: dict[str, str] = {
    # Cascades, and pins that only the modes have which the models don't.
    "MULT18X18D": r"SR[IO][AB]\d+|RO[ABC]\d+|SIGNEDP|C\d+",
    "TRELLIS_COMB": r"DI[01]",
    "SIOLOGIC": r"TXDATA[1-6]|TSDATA[01]|IOLDO[ID]|DI|INDD|DIRECTION|MOVE|LOADN|CFLAG|RXDATA[0-6]"
    r"|IOLTO|(?:WR|RD)PNTR\d|DQS\w+|SLIP|ECLK",
    "EHXPLLL": r"(?!CLKI$|CLKFB$|CLKOP$|CLKOS$|LOCK$)\w+",
    "ICESTORM_PLL": r"(?!REFERENCECLK$|PLLOUT_A_GLOBAL$|PLLOUT_A$|LOCK$)\w+",
}
"""Pins that a model hasn't got, by a pattern."""

_SETTLED: dict[str, str] = {
    # What the models don't need to know: rates, standards, and what a pin's own table says.
    "MULT18X18D": r"[ABC]\d+MUX|(?:CLK|CE|RST)\dMUX|CLK\d_DIV|MULT_BYPASS|GSR|RESETMODE|.*MUX",
    "ICESTORM_RAM": r"INIT_\w",
    "DP16KD": r".*MUX|RESETMODE|ASYNC_RESET_RELEASE|GSR|INITVAL_\w\w",
    "TRELLIS_COMB": r"W(?:RE|CK)MUX",
    "TRELLIS_FF": r"SD",
    "SIOLOGIC": r"DELAY\..*|GSR|CE\w*MUX|LSR\w*MUX|CLK\w*MUX|SRMODE|IOLTOMUX|\w+DRX\w*\..*",
    "EHXPLLL": r".*",
    "ICESTORM_PLL": r".*",
    "OSCG": r".*",
}  # fmt: skip

_PADS = {
    ("SB_IO", 0b000001): ("input", {"PACKAGE_PIN": "PIN", "D_IN_0": "IN"}),
    ("SB_IO", 0b011001): ("output", {"PACKAGE_PIN": "PIN", "D_OUT_0": "OUT"}),
    ("TRELLIS_IO", "INPUT"): ("input", {"B": "PIN", "O": "IN"}),
    ("TRELLIS_IO", "OUTPUT"): ("output", {"B": "PIN", "I": "OUT"}),
    ("TRELLIS_IO", "OUTPUT", "IOLDO"): ("output", {"B": "PIN", "IOLDO": "OUT"}),
    ("TRELLIS_IO", "OUTPUT", "T"): ("output", {"B": "PIN", "I": "OUT", "T": "OFF"}),
}
"""Kinds of pads: direction, and pins of the models ``placed_input``, ``placed_output`` and, with
one that switches it off, ``placed_tristate``."""

_PLACEHOLDERS = ("RAMW_BLOCK",)
"""Modes of logic cells that only keep a place free."""


def placed_verilog(
    name: str, family: str, placed: Path, folder: Path, tools: Toolchain
) -> tuple[Path, ...]:
    """Files to simulate in the place of the top ``name``, from what nextpnr wrote, ``placed``.

    Both are from the root. :class:`SynthesisError` where there is a cell without a model.
    """
    whole = json.loads((ROOT / placed).read_bytes())
    (top,) = whole["modules"].values()
    known = {"ice40": _ice40, "ecp5": _ecp5}[family](top)
    cells = {}
    for number, cell in enumerate(top["cells"].values()):
        if cell["parameters"].get("MODE") in _PLACEHOLDERS:
            continue
        if cell["type"] not in known:
            raise SynthesisError(f"{name}: no model of the placed cell {cell['type']}")
        is_pad = cell["type"] in ("SB_IO", "TRELLIS_IO")
        cells[f"c{number}"] = _pad(name, cell, top["ports"]) if is_pad else _plain_cell(cell)
    plain = {"ports": top["ports"], "cells": cells, "netnames": {}}
    made = folder / "placed.json"
    (ROOT / made).write_text(
        json.dumps({"creator": "wavehaptics", "modules": {name: plain}}), encoding="utf-8"
    )
    verilog = folder / "placed.v"
    script = f"read_json {made}; write_verilog -noattr -noexpr {verilog}"
    log = ROOT / folder / "write.log"
    if tools.run("yosys", ["-p", script], ROOT, log):
        raise SynthesisError(f"{name}: Yosys can't write the placed netlist; see {log}")
    (ROOT / made).unlink()
    return (ROOT / verilog, *models(family, ROOT / folder, tools, placed=True))


def _plain_cell(cell: dict[str, Any]) -> dict[str, Any]:
    """A cell with all its inputs driven, and what its model knows of its pins and parameters."""
    kind, parameters = cell["type"], dict(cell["parameters"])
    if kind == "IOLOGIC":
        # With gears, of which the model of the plain cell stops the simulation where MODE says one.
        kind = "SIOLOGIC"
    contents = {
        key: value
        for key, value in parameters.items()
        if re.match(r"INIT(?:VAL)?_", key) and "1" in value
    }
    if contents and kind != "DP16KD":
        raise SynthesisError(f"no model of a placed {kind} with contents")
    directions = dict(cell["port_directions"])
    levels = _OPEN.get(kind, {})
    unused, settled = _UNUSED.get(kind), _SETTLED.get(kind)
    wired = dict(cell["connections"])
    if kind == "TRELLIS_COMB" and wired.get("FXA"):
        # A slice's second half joins pairs; nextpnr says so by the place alone.
        parameters["IS_Z1"] = "1"
    if kind == "TRELLIS_FF" and str(parameters.get("SD")).strip() == "0":
        # Its data comes past the table, and the library's model has one pin for both.
        wired["DI"] = wired.pop("M")
        directions["DI"] = "input"
    connections = {}
    for pin, bits in wired.items():
        if unused and re.fullmatch(unused, pin):
            continue
        if not bits and directions[pin] == "input":
            tied = str(parameters.get(f"{pin}MUX", "")).strip()
            level = tied if tied in ("0", "1") else levels.get(pin, "0")
            bits = ["0" if tied == "INV" else level]
        elif kind == "DP16KD" and parameters.get(f"{pin}MUX") == "INV":
            raise SynthesisError(f"no model of a placed DP16KD with {pin} inverted")
        connections[pin] = bits
    return {
        "type": kind,
        "parameters": contents
        | {
            key.replace(".", "_"): value
            for key, value in parameters.items()
            if not (settled and re.fullmatch(settled, key))
        },
        "attributes": {},
        "port_directions": {pin: directions[pin] for pin in connections},
        "connections": connections,
    }


def _pad(name: str, cell: dict[str, Any], ports: dict[str, Any]) -> dict[str, Any]:
    """A pad as an input or output, as the top's port is one, or has one; all else has no model."""
    parameters = cell["parameters"]
    kind: tuple[Any, ...] = ("SB_IO", int(parameters.get("PIN_TYPE", "0"), 2))
    if cell["type"] == "TRELLIS_IO":
        register = parameters.get("DATAMUX_OREG")
        switched = "T" if cell["connections"].get("T") else None
        kind = ("TRELLIS_IO", parameters.get("DIR"), *filter(None, (register, switched)))
    direction, pins = _PADS.get(kind, ("", {}))
    connections = {
        pins[pin]: bits for pin, bits in cell["connections"].items() if pin in pins and bits
    }
    ends = {
        port["direction"]: port_name for port_name, port in ports.items()
        if connections.get("PIN") in [[bit] for bit in port["bits"]]
    }  # fmt: skip
    if len(connections) != len(pins) or list(ends) != [direction]:
        raise SynthesisError(f"{name}: no model of the placed pad {kind} at {[*ends.values()]}")
    directions = {"PIN": direction, "IN": "output", "OUT": "input", "OFF": "input"}
    return {
        "type": "placed_tristate" if "OFF" in connections else f"placed_{direction}",
        "parameters": {},
        "attributes": {},
        "port_directions": {pin: directions[pin] for pin in connections},
        "connections": connections,
    }


def _ice40(top: dict[str, Any]) -> tuple[str, ...]:
    """Wire the PLL to the clock network, and the pad, that it has by its place alone.

    A pad that isn't the PLL's own (SB_PLL40_CORE) is wired to it already.
    """
    cells = top["cells"].values()
    fresh = 1 + max(bit for cell in cells for bits in cell["connections"].values() for bit in bits)
    for pll in [cell for cell in cells if cell["type"] == "ICESTORM_PLL"]:
        networks = [cell for cell in cells if "FOR_PAD_IN" in cell["attributes"]]
        wired = bool(pll["connections"].get("REFERENCECLK"))
        pad_at = pll["attributes"].get("BEL_PAD_INPUT")
        pads = [cell for cell in cells if cell["attributes"].get("NEXTPNR_BEL") == pad_at]
        if (len(pads) != 1 and not wired) or len(networks) != 1:
            raise SynthesisError("the PLL's pad or clock network can't be told")
        if not wired:
            _join(fresh, (pads[0], "D_IN_0", "output"), (pll, "REFERENCECLK", "input"))
        network = networks[0], "USER_SIGNAL_TO_GLOBAL_BUFFER", "input"
        _join(fresh + 1, (pll, "PLLOUT_A_GLOBAL", "output"), network)
    return ("ICESTORM_LC", "ICESTORM_DSP", "ICESTORM_RAM", "ICESTORM_PLL", "SB_GB", "SB_IO")


def _join(bit: int, *ends: tuple[dict[str, Any], str, str]) -> None:
    for cell, pin, direction in ends:
        if cell["connections"].get(pin):
            raise SynthesisError(f"{pin} of the placed {cell['type']} is wired already")
        cell["connections"][pin] = [bit]
        cell["port_directions"][pin] = direction


def _ecp5(_: dict[str, Any]) -> tuple[str, ...]:
    return ("TRELLIS_COMB", "TRELLIS_FF", "TRELLIS_IO", "TRELLIS_RAMW", "MULT18X18D", "DP16KD",
            "SIOLOGIC", "IOLOGIC", "DCCA", "EHXPLLL", "OSCG")  # fmt: skip


_LIBRARY = {
    ("ice40", True): ("ice40/cells_sim.v", ("SB_MAC16", "SB_GB")),
    ("ice40", False): ("ice40/cells_sim.v", ()),
    ("ecp5", True): ("ecp5/common_sim.vh", ("TRELLIS_FF",)),
    ("ecp5", False): ("ecp5/common_sim.vh", ("TRELLIS_FF",)),
}
"""Yosys' file and the cells of it, of a placed netlist and of the board's sources."""

_OWN = {
    ("ice40", True): ("ice40_pads.v", "ice40_placed.v", "placed_common.v"),
    ("ice40", False): ("ice40_pads.v",),
    ("ecp5", True): (
        "ecp5_clocks.v",
        "ecp5_placed.v",
        "mult18x18d.v",
        "dp16kd.v",
        "placed_common.v",
    ),
    ("ecp5", False): ("ecp5_clocks.v", "ecp5_pads.v"),
}
"""Files of ``sim/cells``, likewise."""


def models(family: str, folder: Path, tools: Toolchain, *, placed: bool) -> tuple[Path, ...]:
    """Models of the cells in a placed netlist, or of those that a board's own sources name."""
    name, wanted = _LIBRARY[family, placed]
    library = (tools.share() / name).read_text(encoding="utf-8")
    modules = ["`timescale 1ns / 1ps"]
    for cell in wanted:
        found = re.search(rf"^module {cell}\b.*?^endmodule$", library, re.MULTILINE | re.DOTALL)
        if found is None:
            raise SynthesisError(f"Yosys' library has no {cell}")
        text = re.sub(r"^`ifdef TIMING.*?^`endif$", "", found[0], flags=re.M | re.S)
        text = re.sub(r"^\s*specify\b.*?\bendspecify\b", "", text, flags=re.M | re.S)
        # A wire has no value yet when the initial blocks are run.
        modules.append(text.replace("initial Q = srval;", 'initial Q = (REGSET == "SET");'))
    path = folder / "cells.v"
    path.write_text("\n\n".join(modules) + "\n", encoding="utf-8")
    return (path, *(CELLS / own for own in _OWN[family, placed]))
