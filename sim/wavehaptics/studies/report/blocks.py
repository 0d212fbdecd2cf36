# SPDX-License-Identifier: Apache-2.0
"""What a section of the report is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Text:
    """A paragraph of plain text."""

    text: str


@dataclass(frozen=True)
class Table:
    """Rows of text or numbers below a heading; numbers stand to the right."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[Any]]


@dataclass(frozen=True)
class Picture:
    """A PNG, with what there is to see in it."""

    path: Path
    caption: str


Block = Text | Table | Picture


def number(value: float | None, digits: int = 3) -> str:
    """A number for a table; what does not exist is a dash."""
    if value is None:
        return "–"
    rounded = float(f"{value:.{digits}g}")
    if rounded != 0 and not 1e-3 <= abs(rounded) < 10**digits:
        mantissa, exponent = f"{value:.{max(digits - 2, 0)}e}".split("e")
        power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        return f"{mantissa}·10{power}".replace("-", "−")
    return f"{value:.{digits}g}".replace("-", "−")


def percent(value: float | None, digits: int = 2) -> str:
    """A part of one as per cent."""
    if value is None:
        return "–"
    part = 100 * value
    whole = 10**digits - 0.5 <= abs(part) < 1e5
    return f"{part:.0f} %".replace("-", "−") if whole else f"{number(part, digits)} %"
