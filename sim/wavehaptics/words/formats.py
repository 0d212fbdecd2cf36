# SPDX-License-Identifier: Apache-2.0
"""Word lengths and binary points, read from ``rtl/wh_formats.vh``: none is typed twice.

The widths that the header lets a tool set can be set here by environment variables of the same
names, ``WH_DATA_W=24``; what numba compiles is kept by them (:mod:`wavehaptics.runtime.compiled`).
"""

from __future__ import annotations

import ast
import operator
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from wavehaptics.runtime.repository import RTL_DIR

HEADER = RTL_DIR / "wh_formats.vh"

_DEFINE = re.compile(r"^\s*`define\s+WH_(\w+)\s+([^/\n]+?)\s*(?://.*)?$", re.MULTILINE)
_GUARDED = re.compile(r"^\s*`ifndef\s+WH_(\w+)", re.MULTILINE)
_OPERATORS: dict[type, Callable[[int, int], int]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
}  # fmt: skip


def _evaluate(node: ast.expr) -> int:
    if isinstance(node, ast.Constant) and isinstance(node.value, int):
        return node.value
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        return _OPERATORS[type(node.op)](_evaluate(node.left), _evaluate(node.right))
    raise ValueError(f"{HEADER}: only sums and products of integers are understood")


def settable_macros(header: str) -> list[str]:
    """Macros, without ``WH_``, that a header defines only where they are not set yet."""
    guarded = _GUARDED.findall(header)
    return [name for name, _ in _DEFINE.findall(header) if name in guarded]


def read_header(path: Path = HEADER, environment: Mapping[str, str] = os.environ) -> dict[str, int]:
    """Macros ``WH_<name>`` of the header as ``{name: integer}``, in the order of the file.

    Macros guarded by ```ifndef`` may be set in ``environment``.
    """
    values: dict[str, int] = {}
    header = path.read_text(encoding="utf-8")
    settable = settable_macros(header)
    for name, text in _DEFINE.findall(header):
        if name in settable and f"WH_{name}" in environment:
            text = environment[f"WH_{name}"]
        for known, value in values.items():
            text = re.sub(rf"`WH_{known}\b", str(value), text)
        values[name] = _evaluate(ast.parse(text.strip(), mode="eval").body)
    return values


@dataclass(frozen=True)
class Fixed:
    """A fixed-point format s<width>q<fraction>, or u for unsigned: value = raw / 2**fraction."""

    width: int
    fraction: int
    signed: bool = True

    @property
    def raw_max(self) -> int:
        return (1 << (self.width - self.signed)) - 1

    @property
    def raw_min(self) -> int:
        return -(1 << (self.width - 1)) if self.signed else 0

    def holds(self, raw: int) -> bool:
        """Whether a word is one of this format."""
        return self.raw_min <= raw <= self.raw_max

    @property
    def step(self) -> float:
        """Value of the last place, in the word's unit."""
        return 2.0**-self.fraction

    @property
    def largest(self) -> float:
        """Largest positive value, in the word's unit."""
        return self.raw_max * self.step

    def to_raw(self, value: float) -> int:
        """Nearest word to ``value``; ``OverflowError`` where the format can't hold it."""
        raw = round(value * 2.0**self.fraction)
        if not self.holds(raw):
            least = "±" if self.signed else "0..."
            raise OverflowError(f"{value:g} is outside {least}{self.largest:g}")
        return raw

    def to_value(self, raw: int) -> float:
        """Value of a word, in its unit."""
        return raw * self.step


HEADER_VALUES = read_header()

SETTABLE = tuple(settable_macros(HEADER.read_text(encoding="utf-8")))
"""Macros that the tools take from their command line, and Python from the environment."""

DATA_W = HEADER_VALUES["DATA_W"]
COEF_W = HEADER_VALUES["COEF_W"]
STATE_GUARD = HEADER_VALUES["STATE_GUARD"]
COUNT_W = HEADER_VALUES["COUNT_W"]
SAMPLE_W = HEADER_VALUES["SAMPLE_W"]
SUM_W = HEADER_VALUES["SUM_W"]
TICK_W = HEADER_VALUES["TICK_W"]
MODE_W = HEADER_VALUES["MODE_W"]

AT_HIGH, AT_LOW = 1, 2
"""Bits that say at which end of its range a current is, or a sample that it is made of."""

CURRENT = Fixed(DATA_W, HEADER_VALUES["CURRENT_Q"])
"""Current, A."""
VOLTAGE = Fixed(DATA_W, HEADER_VALUES["VOLTAGE_Q"])
"""Voltage, V."""
WAVE = Fixed(DATA_W, HEADER_VALUES["WAVE_Q"])
"""Waves u and v, √W."""
ROOT = Fixed(COEF_W, HEADER_VALUES["ROOT_Q"])
"""s = √(2R̂), √Ω."""
ETA = Fixed(COEF_W, HEADER_VALUES["ETA_Q"])
"""η, no unit."""
A = Fixed(COEF_W, HEADER_VALUES["A_Q"])
"""The λ filter's coefficient a, no unit."""
GAIN = Fixed(COEF_W, HEADER_VALUES["GAIN_Q"])
"""Amperes per unit of a tick's sum of ADC words."""
ENERGY = Fixed(HEADER_VALUES["ENERGY_W"], HEADER_VALUES["ENERGY_Q"])
"""Energy of a contact, A·counts."""
ENERGY_LIMIT = Fixed(HEADER_VALUES["ENERGY_LIMIT_W"], HEADER_VALUES["ENERGY_LIMIT_Q"], signed=False)
"""Most that a contact may deliver, A·counts."""
DUTY = Fixed(COEF_W, HEADER_VALUES["DUTY_Q"])
"""Clocks of half pulse width per volt."""
BUS_W = HEADER_VALUES["BUS_W"]
BUS_Q = HEADER_VALUES["BUS_Q"]
"""Fraction bits of the measured bus, an unsigned word of BUS_W bits, V."""
BUS_SHARE = Fixed(COEF_W, HEADER_VALUES["BUS_SHARE_Q"])
"""Inverse of the bus that a voltage limit takes, 1/V."""
SHAPE = Fixed(HEADER_VALUES["SHAPE_W"], HEADER_VALUES["SHAPE_Q"])
"""Coefficient of the shaper W, no unit."""
SHAPE_HEADROOM = HEADER_VALUES["SHAPE_HEADROOM"]
SHAPE_LOSS_W = HEADER_VALUES["SHAPE_LOSS_W"]
SHAPE_STATE = Fixed(DATA_W + STATE_GUARD, WAVE.fraction - SHAPE_HEADROOM + STATE_GUARD)
"""State of the shaper W, √W."""
EXTRA = Fixed(HEADER_VALUES["EXTRA_W"], HEADER_VALUES["EXTRA_Q"])
"""Clocks by which dead time shortens the half pulse width."""
LONG = Fixed(HEADER_VALUES["LONG_W"], HEADER_VALUES["LONG_Q"])
"""What the port anchor sums up: cells, V or A."""
LONG_GUARD = HEADER_VALUES["LONG_GUARD"]
"""Low bits of a long word that its factor is without."""
FLUX = Fixed(COEF_W, HEADER_VALUES["FLUX_Q"])
"""Cells that a wave of 1 √W moves the flux of the port in a tick."""
CELLS = Fixed(COEF_W, HEADER_VALUES["CELLS_Q"])
"""Cells of the flux L̂·i, per A."""
PULL = Fixed(COEF_W, HEADER_VALUES["PULL_Q"])
"""Correction of the port anchor, V per cell."""
LEARN = Fixed(COEF_W, HEADER_VALUES["LEARN_Q"])
"""What the port anchor learns in a period, V per count and count."""
SEEN = Fixed(DATA_W, HEADER_VALUES["SEEN_Q"])
"""What is shown of a long word: cells."""
SURFACE = Fixed(COEF_W, HEADER_VALUES["SURFACE_Q"])
"""A surface's direction in the waves of a group, or in its counts, no unit."""
MIX = Fixed(COEF_W, HEADER_VALUES["MIX_Q"])
"""Share of a surface's wall velocity in a direction of a set, no unit."""
DISTANCE = Fixed(HEADER_VALUES["DISTANCE_W"], HEADER_VALUES["DISTANCE_Q"])
"""Where a surface's plane lies, counts."""
REST_W = HEADER_VALUES["REST_W"]
FOLLOW_W = HEADER_VALUES["FOLLOW_W"]
MOVE_W = HEADER_VALUES["MOVE_W"]
ANCHOR_W = HEADER_VALUES["ANCHOR_W"]
