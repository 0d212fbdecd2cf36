# SPDX-License-Identifier: Apache-2.0
"""Netlists of a block as Verilog that simulators take, with models of the FPGA's cells."""

from __future__ import annotations

import json
import re
from pathlib import Path

from wavehaptics.runtime.repository import CELLS, ROOT
from wavehaptics.runtime.toolchain import Toolchain

from wavetools.fpga.synthesis import Design, SynthesisError, synthesise

OUT = Path("build", "netlists")
"""Where netlists go, from the root."""

DEVICES = {"up5k": "ice40", "hx8k": "ice40", "25k": "ecp5"}
"""Devices whose netlists are simulated, and their family; the HX8K has no multiplier blocks."""

# What the ECP5's netlists are made of; Yosys' own file as a whole is more than Icarus 11 takes.
_ECP5_CELLS = ("LUT2", "LUT4", "PFUMX", "L6MUX21", "TRELLIS_FF", "TRELLIS_DPR16X4", "CCU2C")


def netlist(
    block: str, device: str, parameters: dict[str, int], tools: Toolchain
) -> tuple[Path, ...]:
    """Synthesise ``block`` for a device; files to simulate in the place of ``rtl/<block>.v``.

    The netlist keeps the block's name and parameters. These can't be changed any more: a bench that
    sets others gets an error of elaboration. :class:`SynthesisError` as in a board's build.
    """
    family = DEVICES[device]
    name = "-".join([block, device, *(f"{key}{value}" for key, value in parameters.items())])
    folder = ROOT / OUT / name
    folder.mkdir(parents=True, exist_ok=True)
    design = Design(
        name=name,
        top=block,
        root=ROOT,
        sources=tuple(path.relative_to(ROOT) for path in sorted((ROOT / "rtl").glob("*.v"))),
        includes=(Path("rtl"),),
        constraints=Path("none"),
        family=family,
        device=device,
        package="none",
        speed=None,
        input_hz=1.0,
        clock_hz=1.0,
        seeds=(0,),
        parameters=tuple(parameters.items()),
    )
    made = OUT / name / "netlist.json"
    synthesise(design, made, tools, folder / "yosys.log")
    inner = f"{block}_netlist"
    verilog = OUT / name / "netlist.v"
    script = f"read_json {made}; rename {block} {inner}; write_verilog -noattr -noexpr {verilog}"
    if tools.run("yosys", ["-p", script], ROOT, folder / "write.log"):
        raise SynthesisError(f"{name}: Yosys can't write the netlist; see {folder / 'write.log'}")
    ports = json.loads((ROOT / made).read_bytes())["modules"][block]["ports"]
    wrapper = folder / f"{block}.v"
    directions = {port: (p["direction"], len(p["bits"])) for port, p in ports.items()}
    wrapper.write_text(_wrapper(block, inner, directions, parameters), encoding="utf-8")
    return (wrapper, ROOT / verilog, *_cells(family, device, folder, tools))


def _wrapper(
    block: str, inner: str, ports: dict[str, tuple[str, int]], parameters: dict[str, int]
) -> str:
    """A module with the block's own name and parameters around the netlist, which has none."""
    names = ", ".join(f"parameter integer {name} = {value}" for name, value in parameters.items())
    lines = [
        f"{direction} wire [{width - 1}:0] {port}" for port, (direction, width) in ports.items()
    ]
    guards = " || ".join(f"{name} != {value}" for name, value in parameters.items()) or "0"
    pins = ", ".join(f".{port}({port})" for port in ports)
    return (
        f"`timescale 1ns / 1ps\nmodule {block} #({names}) (\n    "
        + ",\n    ".join(lines)
        + f"\n);\n    generate\n        if ({guards}) begin : other_parameters\n"
        f"            wh_netlist_has_other_parameters stop ();\n        end\n    endgenerate\n"
        f"    {inner} netlist ({pins});\nendmodule\n"
    )


def _cells(family: str, device: str, folder: Path, tools: Toolchain) -> tuple[Path, ...]:
    """Models of a family's cells."""
    share, path = tools.share(), folder / "cells.v"
    if family == "ice40":
        macros = ("NO_ICE40_DEFAULT_ASSIGNMENTS", "ICE40_U" if device == "up5k" else "ICE40_HX")
        library = (share / "ice40" / "cells_sim.v").read_text(encoding="utf-8")
        defines = "".join(f"`define {macro} 1\n" for macro in macros)
        path.write_text(defines + library, encoding="utf-8")
        return (path,)
    library = "".join(
        (share / "ecp5" / name).read_text(encoding="utf-8")
        for name in ("common_sim.vh", "ccu2c_sim.vh")
    )
    modules = ["`timescale 1ns / 1ps"]
    for cell in _ECP5_CELLS:
        found = re.search(rf"^module {cell}\b.*?^endmodule$", library, re.MULTILINE | re.DOTALL)
        if found is None:
            raise SynthesisError(f"Yosys' library of the ECP5 has no {cell}")
        modules.append(re.sub(r"^\s*specify\b.*?\bendspecify\b", "", found[0], flags=re.M | re.S))
    path.write_text("\n\n".join(modules) + "\n", encoding="utf-8")
    return (path, CELLS / "mult18x18d.v")
