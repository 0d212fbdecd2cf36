# SPDX-License-Identifier: Apache-2.0
"""Words of a device by their names, and their values in text and numbers."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from wavehaptics.scene.keys import as_written
from wavehaptics.words.table import AXES, LEGS, MEMORY, MOST, THREE_PHASE_LEGS, WORDS, Word

_NAME = re.compile(r"(\w+)(?:\[([0-9]{1,9})\])?")

_FAR = 2.0**64
"""Beyond all words, raw and not. Far beyond, a number fits neither a float nor a line of text."""


class HostError(ValueError):
    """What a host can't do, in one line with the cure."""


@dataclass(frozen=True)
class Shape:
    """How many motors, walls, sections and places of a delay a device has, and a motor of legs."""

    motors: int
    walls: int
    sections: int
    delay_log2: int
    legs: int = LEGS

    @property
    def brushless(self) -> bool:
        """Whether its motors are brushless ones, whose axes have the places of two each."""
        return self.legs == THREE_PHASE_LEGS

    @property
    def parts(self) -> int:
        """Motors, or axes of brushless ones."""
        return self.motors * (AXES if self.brushless else 1)

    def has(self, word: Word) -> Sequence[int]:
        """Parts that have a word; one of the board, and none where there is no such word."""
        return word.port_numbers(self.motors, self.legs)

    def copies(self, word: Word) -> int:
        """Words of a row in one motor, or of the board."""
        each = {"wall": self.walls, "section": self.sections}.get(word.row.per, 1)
        return min(each, MOST[word.row.per]) * word.row.count


@dataclass(frozen=True)
class Place:
    """One word of a device."""

    word: Word
    motor: int
    index: int
    shape: Shape

    @property
    def address(self) -> int:
        """Where it stands in the table."""
        return self.word.at(self.motor, self.index)

    @property
    def text(self) -> str:
        """Its name, with its index where the row has several words."""
        several = MOST[self.word.row.per] * self.word.row.count > 1
        return f"{self.word.name}[{self.index}]" if several else self.word.name

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest value, in the word's unit."""
        low, high = self.word.range
        if "DELAY_LOG2" in self.word.row.format:
            high = float((1 << self.shape.delay_log2) - 1)
        return low, high

    @property
    def range_text(self) -> str:
        """The range with the unit."""
        digits = 6 if self.word.fixed.fraction else 10
        low, high = self.range
        return f"{low:.{digits}g}...{high:.{digits}g} {self.word.row.unit}".rstrip()

    def value(self, raw: int) -> float | int:
        """Value of a raw word without a sign, in the word's unit."""
        fixed = self.word.fixed
        if fixed.signed and raw >> 31:
            raw -= 1 << 32
        return fixed.to_value(raw) if fixed.fraction else raw

    def raw(self, value: Any, *, is_raw: bool = False) -> int:
        """The raw word of a number in the word's unit, or of a raw one.

        :class:`HostError` with the range for what it can't be.
        """
        if isinstance(value, int) and not abs(value) < _FAR:
            raise HostError(f"{self.text} is out of range; it takes {self.range_text}")
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            shown = as_written(value)
            raise HostError(f"{self.text} = {shown} is no number; it takes {self.range_text}")
        fixed, named = self.word.fixed, f"{self.text} = {value}"
        whole = is_raw or not fixed.fraction
        low, high = self.range
        if not math.isfinite(value) or (whole and value != int(value)):
            kind = "whole number" if whole else "number"
            raise HostError(f"{named} is no {kind}; it takes {self.range_text}")
        if abs(value) >= _FAR:
            raise HostError(f"{named} is out of range; it takes {self.range_text}")
        found = int(value) if whole else round(value * 2.0**fixed.fraction)
        if found and self.shape.brushless and self.word.name == "guard_energy":
            raise HostError(
                f"{named} can't be had: the energy of a brushless motor's contacts is not "
                "observed; set it to 0"
            )
        # A bound that is no word itself is met by the word next to it.
        least, most = math.ceil(low * 2.0**fixed.fraction), math.floor(high * 2.0**fixed.fraction)
        if not least <= found <= most:
            shown = f"{least}...{most} as a raw word" if is_raw else self.range_text
            raise HostError(f"{named} is out of range; it takes {shown}")
        return found


def number(text: str) -> float | int:
    """A number as it is typed: 12, 0x0c, 1.2e1. ``ValueError`` for others."""
    try:
        return int(text, 0)
    except ValueError:
        return float(text)


def places(text: str, shape: Shape, motor: int = 0) -> list[Place]:
    """The words that ``NAME`` or ``NAME[INDEX]`` means: without an index all copies of one motor.

    :class:`HostError` for a name, an index or a motor that the device doesn't have.
    """
    found = _NAME.fullmatch(text)
    word = WORDS.get(found[1]) if found else None
    if word is None or found is None:
        near = difflib.get_close_matches(found[1] if found else text, WORDS, n=1)
        meant = f"did you mean {near[0]}?" if near else "docs/words.md lists the words"
        raise HostError(f"{text}: there is no such word; {meant}")
    copies = shape.copies(word) if shape.has(word) else 0
    if copies and word.row.per != "board" and motor not in shape.has(word):
        alpha = motor - motor % AXES
        cure = f"take --motor {alpha}" if alpha else f"leave --motor {motor} out"
        raise HostError(
            f"{text}: a brushless motor has one, for both axes; {cure}"
            if shape.brushless and 0 <= motor < shape.parts
            else f"{text}: the device has no motor {motor}; take --motor 0...{shape.parts - 1}"
        )
    motor = 0 if word.row.per == "board" else motor
    if not copies:
        raise HostError(f"{text}: this device has none; its bitstream was made without")
    if found[2] is None:
        return [Place(word, motor, index, shape) for index in range(copies)]
    index = int(found[2])
    if index >= copies:
        raise HostError(f"{text}: the device has no such one; take {word.name}[0...{copies - 1}]")
    return [Place(word, motor, index, shape)]


def listed(names: Iterable[Any]) -> Iterable[Any]:
    """Names and places; a name alone is no list of its letters."""
    return [names] if isinstance(names, str) else names


def settable(place: Place) -> Place:
    """The place, if it can be written. :class:`HostError` if not."""
    if place.word.block == MEMORY:
        raise HostError(f"{place.text} can't be set; the link gives what it has written itself")
    if place.word.row.kind == "live":
        raise HostError(f"{place.text} can't be set; it is what the device tells")
    return place


def readable(place: Place) -> Place:
    """The place, if it can be read. :class:`HostError` if not."""
    if place.word.row.kind == "command":
        raise HostError(f"{place.text} can't be read; it is a command")
    return place


def settings(shape: Shape) -> list[Place]:
    """Every setting of a device."""
    found = []
    for motor in range(shape.parts):
        for word in WORDS.values():
            if word.row.kind == "setting" and motor in shape.has(word):
                found += [Place(word, motor, n, shape) for n in range(shape.copies(word))]
    return found
