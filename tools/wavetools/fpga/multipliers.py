# SPDX-License-Identifier: Apache-2.0
"""The paths through multiplier blocks, which nextpnr doesn't time on the iCE40.

nextpnr-ice40 takes the pins of an SB_MAC16 for those of a register: out 0.1 ns after the clock, set
up in 0.1 ns. In truth a multiplier stands between them, with registers at its operands, in its
middle (where Yosys puts the register behind a product), at its output, or nowhere. Here the
vendor's figures take the place of the 0.1 ns, on the delays that nextpnr wrote for everything else.
"""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# Slowest figures of the vendor's tool for the UP5K's SB_MAC16, ns, as Project IceStorm has them
# (icefuzz/timings_up5k.txt): 16 x 16 and 8 x 8 without registers, and an output register's clock.
_FULL_NS = 9.05
_EIGHT_NS = (5.71, 5.96)
_CLOCK_TO_OUT_NS = 2.12
_SETUP_NS = 0.02

# There is no figure for a register in the middle alone. What comes before it is the 8 x 8 products,
# which take at most what the 8 x 8 mode takes to the pins; what comes after is the sum of them, at
# most what a 16 x 16 takes longer than the fastest-counted 8 x 8, behind a register.
_TO_MIDDLE_NS = _EIGHT_NS[1]
_FROM_MIDDLE_NS = _CLOCK_TO_OUT_NS + _FULL_NS - _EIGHT_NS[0]

_BLOCKS = ("SB_MAC16", "MULT18X18D")
_FLIP_FLOPS = ("SB_DFF", "TRELLIS_FF")
_DATA_PINS = ("D", "DI", "M")


class MultiplierError(ValueError):
    """A multiplier block that can't be timed. The message is one line."""


def check_registers(netlist: dict[str, Any]) -> None:
    """Registers stand directly before and behind every multiplier block, or in it.

    ``netlist`` is a module of Yosys' JSON. :class:`MultiplierError` names the first block that has
    logic, or a pin of the top, between itself and a register.
    """
    registered: set[Any] = {"0", "1", "x", "z"}
    logic: set[Any] = {net for port in netlist["ports"].values() for net in port["bits"]}
    for cell in netlist["cells"].values():
        is_register = cell["type"].startswith(_FLIP_FLOPS)
        for pin, nets in cell["connections"].items():
            if is_register and pin == "Q":
                registered.update(nets)
            elif not (is_register and pin in _DATA_PINS) and not _is_output(cell, pin):
                logic.update(nets)
    for name, cell in netlist["cells"].items():
        if cell["type"] not in _BLOCKS:
            continue
        for operand in "AB":
            from_register = registered.issuperset(_nets(cell, operand))
            if not from_register and not _is_on(cell, f"{operand}_REG"):
                raise MultiplierError(
                    f"operand {operand} of the multiplier {_short(name)} doesn't come from a "
                    "register; give it one without a reset"
                )
        if cell["type"] == "SB_MAC16":
            to_register = _has_middle_register(cell) or _has_output_register(cell)
        else:
            to_register = logic.isdisjoint(_nets(cell, "P"))
        if not to_register:
            raise MultiplierError(
                f"the product of the multiplier {_short(name)} doesn't go to a register; "
                "give it one without a reset"
            )


def _nets(cell: dict[str, Any], bus: str) -> set[Any]:
    """Nets at a block's pins of one letter: a bus on the iCE40, single pins on the ECP5."""
    pins = cell["connections"].items()
    return {net for pin, nets in pins if re.fullmatch(rf"{bus}\d*", pin) for net in nets}


def _is_output(cell: dict[str, Any], pin: str) -> bool:
    return cell.get("port_directions", {}).get(pin) == "output"


def _is_on(cell: dict[str, Any], parameter: str) -> bool:
    return "1" in cell["parameters"].get(parameter, "0")


def _has_middle_register(cell: dict[str, Any]) -> bool:
    return _is_on(cell, "PIPELINE_16x16_MULT_REG1")


def _has_output_register(cell: dict[str, Any]) -> bool:
    # 01 takes the output register, 11 the multiplier itself.
    return cell["parameters"].get("TOPOUTPUT_SELECT") == "01"


def _short(name: str) -> str:
    """The source's part of the name that Yosys gave a cell."""
    return re.sub(r"_?(?:SB_|TRELLIS_|MULT18X18D|DI_).*", "", name.replace("\\", "")) or name


# ---- Timing, from the delays that nextpnr wrote.

_TOKEN = re.compile(
    r'\(CELLTYPE "(?P<type>[^"]+)"\)\s*\(INSTANCE (?P<instance>[^\s)]*)\s*\)'
    r"|\(INTERCONNECT (?P<source>\S+) (?P<sink>\S+) (?P<wire>\([^)]*\) \([^)]*\))\)"
    r"|\(IOPATH (?:\((?:pos|neg)edge )?(?P<start>[^\s)]+)\)? (?P<end>\S+) "
    r"(?P<delay>\([^)]*\) \([^)]*\))\)"
    r"|\(SETUPHOLD \((?:pos|neg)edge (?P<data>\S+)\) \((?:pos|neg)edge \S+\) \((?P<setup>[^)]*)\)"
)
_CLOCKS = ("CLK", "CLOCK")


def _slowest_ns(text: str) -> float:
    return max(float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", text)) / 1000


@dataclass(frozen=True)
class _Block:
    """What an SB_MAC16 adds to paths, ns: at its operands, and at its output."""

    operands: dict[str, float]
    output: float

    @classmethod
    def of_cell(cls, cell: dict[str, Any]) -> _Block:
        behind = _TO_MIDDLE_NS if _has_middle_register(cell) else _FULL_NS
        operands = {x: _SETUP_NS if _is_on(cell, f"{x}_REG") else behind for x in "AB"}
        output = _CLOCK_TO_OUT_NS if _has_output_register(cell) else _FROM_MIDDLE_NS
        return cls(operands, output)


def reached_hz(netlist: dict[str, Any], sdf: Path) -> float | None:
    """Clock that the paths to and from SB_MAC16 blocks allow, Hz; None where there is no block.

    ``netlist`` is a module of Yosys' JSON that :func:`check_registers` has passed, ``sdf`` what
    nextpnr-ice40 wrote for ``--sdf``; like nextpnr, this knows no clock skew.
    """
    blocks = {
        f"{name}_DSP": _Block.of_cell(cell)
        for name, cell in netlist["cells"].items()
        if cell["type"] == "SB_MAC16"
    }
    if not blocks:
        return None
    ahead: dict[str, list[tuple[str, float]]] = defaultdict(list)
    behind: dict[str, list[tuple[str, float]]] = defaultdict(list)
    launched: dict[str, float] = {}
    setups: dict[str, float] = {}
    operands: dict[str, float] = {}
    outputs: dict[str, float] = {}

    def edge(start: str, end: str, delay_ns: float) -> None:
        ahead[start].append((end, delay_ns))
        behind[end].append((start, delay_ns))

    instance = ""
    for found in _TOKEN.finditer(sdf.read_text(encoding="utf-8").replace("\\", "")):
        kind = found.lastgroup
        if kind == "instance":
            instance = found["instance"]
            block = blocks.get(instance)
            if (block is None) == (found["type"] == "ICESTORM_DSP"):
                raise MultiplierError(f"{sdf.name} and the netlist disagree about {instance}")
        elif kind == "wire":
            edge(found["source"], found["sink"], _slowest_ns(found["wire"]))
        elif kind == "delay":
            start, end = f"{instance}/{found['start']}", f"{instance}/{found['end']}"
            if block is not None:
                outputs[end] = block.output
            elif found["start"] in _CLOCKS:
                launched[end] = _slowest_ns(found["delay"])
            else:
                edge(start, end, _slowest_ns(found["delay"]))
        elif kind == "setup":
            pin = f"{instance}/{found['data']}"
            if block is None:
                setups[pin] = max(setups.get(pin, 0.0), _slowest_ns(found["setup"]))
            else:
                operands[pin] = block.operands.get(found["data"][0], _FULL_NS)
    # A block may be at both ends of a path.
    setups |= operands
    launched |= outputs
    period_ns = max(
        *(own + _longest(pin, ahead, setups) for pin, own in outputs.items()),
        *(own + _longest(pin, behind, launched) for pin, own in operands.items()),
    )
    return 1e9 / period_ns


def _longest(
    start: str, edges: dict[str, list[tuple[str, float]]], ends: dict[str, float]
) -> float:
    """Longest way from ``start`` to any of ``ends``, whose own length counts, ns."""
    known: dict[str, float] = {}
    open_nodes = [start]
    while open_nodes:
        node = open_nodes[-1]
        missing = [next_ for next_, _ in edges.get(node, ()) if next_ not in known]
        if missing and node not in known:
            open_nodes += missing
            continue
        open_nodes.pop()
        ways = [known[next_] + ns for next_, ns in edges.get(node, ())]
        own = ends.get(node, float("-inf")) if node != start else float("-inf")
        known[node] = max([own, *ways])
    return max(known[start], 0.0)
