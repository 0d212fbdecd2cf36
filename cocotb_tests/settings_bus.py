# SPDX-License-Identifier: Apache-2.0
"""A master on the bus of the settings memory, and what the table says of its words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from bench import Bench
from wavehaptics.words.table import MOST, WORDS, Sizes, Word

DONE, UNKNOWN, RANGE, NOT_NOW = range(4)
"""Errors of the bus."""

COMMIT, DISCARD, BUSY, STAGED = (
    WORDS[name].at() for name in ("commit", "discard", "settings_busy", "settings_staged")
)
REQUEST_CLOCKS = 8
"""No request lasts longer, once the defaults have been given."""


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
        for motor in range(1 if word.row.per == "board" else sizes.motors):
            for index in range(each * word.row.count):
                assert index < MOST[word.row.per] * word.row.count
                yield Place(word, word.at(motor, index), word.width(sizes))


class BusBench(Bench):
    """A design with the bus."""

    async def begin(self, **inputs: int) -> None:
        await self.start(
            bus_valid_i=0, bus_write_i=0, bus_address_i=0, bus_data_i=0, **inputs
        )  # fmt: skip

    async def request(self, write: int, address: int, data: int, most: int) -> tuple[int, int]:
        """(data, error) of a request; the bus ends it in ``most`` clocks."""
        self.drive(bus_valid_i=1, bus_write_i=write, bus_address_i=address, bus_data_i=data)
        for _ in range(most):
            await self.step()
            if self.word("bus_ready_o"):
                break
        else:
            raise AssertionError(f"no answer from 0x{address:03x} in {most} clocks")
        error = self.word("bus_error_o")
        read = self.word("bus_data_o") if not (error or write) else 0
        self.drive(bus_valid_i=0)
        await self.step()
        assert not self.word("bus_ready_o")
        return read, error

    async def write(self, address: int, raw: int, most: int = REQUEST_CLOCKS) -> int:
        return (await self.request(1, address, raw, most))[1]

    async def read(self, address: int, most: int = REQUEST_CLOCKS) -> tuple[int, int]:
        return await self.request(0, address, 0, most)

    async def value(self, address: int) -> int:
        """A word that can be read."""
        raw, error = await self.read(address)
        assert error == DONE, hex(address)
        return raw

    async def rests(self, most: int = 20_000) -> None:
        """Wait until nothing is under way."""
        for _ in range(most):
            if not await self.value(BUSY):
                return
        raise AssertionError("the settings are busy")
