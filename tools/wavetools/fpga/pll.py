# SPDX-License-Identifier: Apache-2.0
"""The PLLs of the FPGAs: what a cell of a netlist makes, and the limits of its data sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

CELLS = ("SB_PLL40", "EHXPLLL")
"""What the types of PLL cells begin with."""


class PllError(ValueError):
    """A PLL outside its data sheet. The message is one line."""


@dataclass(frozen=True)
class Range:
    """Least and most of a rate, Hz; ``cure`` says what to change in the top."""

    low_hz: float
    high_hz: float
    cure: str


LIMITS: dict[str, dict[str, Range]] = {
    # iCE40 LP/HX and UltraPlus data sheets, "sysCLOCK PLL timing".
    "ice40": {
        "input": Range(10e6, 133e6, "take another oscillator"),
        "phase detector": Range(10e6, 133e6, "lower DIVR"),
        "VCO": Range(533e6, 1066e6, "choose DIVF and DIVQ together"),
        "output": Range(16e6, 275e6, "choose DIVF and DIVQ together"),
    },
    # ECP5 and ECP5-5G family data sheet, "sysCLOCK PLL timing".
    "ecp5": {
        "input": Range(8e6, 400e6, "take another oscillator"),
        "phase detector": Range(10e6, 400e6, "lower CLKI_DIV"),
        "VCO": Range(400e6, 800e6, "choose CLKFB_DIV * CLKOP_DIV and CLKOS_DIV together"),
        "output": Range(3.125e6, 400e6, "choose another CLKOS_DIV"),
    },
}
"""Rates of each family's PLL."""

_FILTER_BELOW_HZ = (17e6, 26e6, 44e6, 66e6, 101e6)
"""Phase detector's rates below which an iCE40's FILTER_RANGE is 1, 2, ...: Project IceStorm's
icepll, made of the vendor's tool."""


@dataclass(frozen=True)
class Pll:
    """Rates of a PLL, Hz."""

    family: str
    input_hz: float
    phase_detector_hz: float
    vco_hz: float
    clock_hz: float
    filter_range: int | None
    """What the cell says, of an iCE40."""

    def check(self) -> None:
        """:class:`PllError` at the first rate that the data sheet doesn't allow."""
        rates = {
            "input": self.input_hz,
            "phase detector": self.phase_detector_hz,
            "VCO": self.vco_hz,
            "output": self.clock_hz,
        }
        for name, allowed in LIMITS[self.family].items():
            if not allowed.low_hz <= rates[name] <= allowed.high_hz:
                raise PllError(
                    f"the PLL's {name} runs at {rates[name] / 1e6:g} MHz; it must be "
                    f"{allowed.low_hz / 1e6:g} to {allowed.high_hz / 1e6:g} MHz: {allowed.cure}"
                )
        if self.filter_range is not None:
            wanted = 1 + sum(self.phase_detector_hz >= limit for limit in _FILTER_BELOW_HZ)
            if self.filter_range != wanted:
                raise PllError(
                    f"the PLL's FILTER_RANGE is {self.filter_range}; for a phase detector at "
                    f"{self.phase_detector_hz / 1e6:g} MHz set {wanted}"
                )


DIVIDERS = {
    "DIVR": (0, 15), "DIVF": (0, 127), "DIVQ": (1, 6),
    "CLKI_DIV": (1, 128), "CLKFB_DIV": (1, 128), "CLKOP_DIV": (1, 128), "CLKOS_DIV": (1, 128),
}  # fmt: skip
"""Least and most of each divider's parameter, by the same data sheets."""


def is_whole(cell: dict[str, Any]) -> bool:
    """Whether a cell says each divider, so that none of them may have been misspelt."""
    said = cell["parameters"].keys()
    if cell["type"].startswith("SB_PLL40"):
        return {"DIVR", "DIVF", "DIVQ", "FILTER_RANGE"} <= said
    more = {"CLKOS_DIV"} if cell["connections"].get("CLKOS") else set()
    return {"CLKI_DIV", "CLKFB_DIV", "CLKOP_DIV"} | more <= said


def _divider(cell: dict[str, Any], name: str, default: int) -> int:
    value, (least, most) = parameter(cell, name, default), DIVIDERS[name]
    if not least <= value <= most:
        raise PllError(f"the PLL's {name} is {value}; it must be {least} to {most}")
    return value


def parameter(cell: dict[str, Any], name: str, default: int) -> int:
    """A number among a cell's parameters, which Yosys writes in binary."""
    text = cell["parameters"].get(name)
    return default if text is None else int(text, 2)


def of_cell(cell: dict[str, Any], input_hz: float) -> Pll:
    """What a PLL cell of Yosys' netlist makes of ``input_hz``.

    An ECP5's is fed back from CLKOP; its clock is CLKOS where that is used, CLKOP otherwise.
    :class:`PllError` where it has no such divider.
    """
    if cell["type"].startswith("SB_PLL40"):
        detector_hz = input_hz / (_divider(cell, "DIVR", 0) + 1)
        vco_hz = detector_hz * (_divider(cell, "DIVF", 0) + 1)
        clock_hz = vco_hz / 2 ** _divider(cell, "DIVQ", 0)
        return Pll(
            "ice40", input_hz, detector_hz, vco_hz, clock_hz, parameter(cell, "FILTER_RANGE", 0)
        )
    feedback = cell["parameters"].get("FEEDBK_PATH", "CLKOP")
    if feedback != "CLKOP":
        raise PllError(f"the PLL's FEEDBK_PATH is {feedback}; take CLKOP")
    detector_hz = input_hz / _divider(cell, "CLKI_DIV", 1)
    back_div = _divider(cell, "CLKOP_DIV", 8)
    vco_hz = detector_hz * _divider(cell, "CLKFB_DIV", 1) * back_div
    used = cell.get("connections", {}).get("CLKOS")
    out_div = _divider(cell, "CLKOS_DIV", 8) if used else back_div
    return Pll("ecp5", input_hz, detector_hz, vco_hz, vco_hz / out_div, None)
