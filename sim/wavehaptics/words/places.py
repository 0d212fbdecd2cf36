# SPDX-License-Identifier: Apache-2.0
"""Every copy of a word of the table, with its address and its limits as raw words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from wavehaptics.words.table import MOST, WORDS, Sizes, Word


@dataclass(frozen=True)
class Place:
    """One copy of a word."""

    word: Word
    address: int
    bits: int

    @property
    def limits(self) -> tuple[int, int]:
        """Least and greatest word."""
        fixed = self.word.fixed
        low, high = self.word.range
        if self.bits != fixed.width:
            return 0, (1 << self.bits) - 1
        return fixed.to_raw(low), fixed.to_raw(high)

    @property
    def outside(self) -> list[int]:
        """Words that are out of range, just so and by far, as far as 32 bits hold them."""
        low, high = self.limits
        signed = self.word.fixed.signed
        least, most = (-(1 << 31), (1 << 31) - 1) if signed else (0, (1 << 32) - 1)
        found = {low - 1, high + 1, least, most, low - (1 << 20), high + (1 << 20)}
        return sorted(raw for raw in found if least <= raw <= most and not low <= raw <= high)


def places(sizes: Sizes, kind: str) -> Iterator[Place]:
    """Every copy of the words of a kind that hardware of these sizes has."""
    for word in WORDS.values():
        if word.row.kind != kind:
            continue
        each = {"wall": sizes.walls, "section": sizes.sections}.get(word.row.per, 1)
        for motor in word.port_numbers(sizes.motors, sizes.legs):
            for index in range(each * word.row.count):
                assert index < MOST[word.row.per] * word.row.count
                yield Place(word, word.at(motor, index), word.width(sizes))
