# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_setting_group.v``: words are staged one by one, and become active together."""

from __future__ import annotations

import random

import cocotb
from bench import Bench, random_source
from simulators import defines, parameters

STAGED = parameters()["STAGED"]
FIXED = {1: 0x0D} if "WH_BOARD_ROM" in defines() else {}
"""Words, by their places in the group, that test_setting_group.py's header has as fixed."""
PART, FIRST, STRIDE, WIDTHS = 2, 0x40, 4, (1, 5, 32)  # bench_setting_group.v
QUIET = {
    "write_i": 0, "copy_i": 0, "address_i": 0, "data_i": 0, "change_i": 0, "discard_i": 0,
    "hold_i": 0,
}  # fmt: skip


def address(word: int) -> int:
    return PART << 8 | FIRST + STRIDE * word


def side_by_side(words: list[int]) -> int:
    total = place = 0
    for word, width in zip(words, WIDTHS, strict=True):
        total |= (word & (1 << width) - 1) << place
        place += width
    return total


class Group(Bench):
    """A group and what it ought to hold."""

    async def begin(self, rng: random.Random) -> None:
        await self.start(**QUIET)
        self.staged = [rng.getrandbits(32) for _ in WIDTHS]
        for word, data in enumerate(self.staged):
            await self.step(copy_i=1, address_i=address(word), data_i=data)
        await self.step(**QUIET | {"change_i": 1})
        await self.step(change_i=0)
        self.active = list(self.staged)
        self.expect()

    def expect(self) -> None:
        held = [FIXED.get(n, word) for n, word in enumerate(self.active)]
        assert self.word("words_o") == side_by_side(held)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def words_change_together_and_never_while_held(dut: object) -> None:
    """Random writes, copies, change-overs, holds and discards, to its own words and to others'.

    Nothing but a write makes it wait.
    """
    bench = Group(dut)
    rng = random_source("group")
    await bench.begin(rng)
    pending = False
    changes = idle = 0
    for _ in range(4000):
        word = rng.randrange(len(WIDTHS))
        elsewhere = rng.choice((0, 0, 0, 1 << 8, 2 << 8, 8 << 8, 1 << rng.randrange(8)))
        at, data = address(word) ^ elsewhere, rng.getrandbits(32)
        mine = [n for n in range(len(WIDTHS)) if address(n) == at]
        write, copy = rng.choice(((0, 0), (1, 0), (0, 1)))
        change, hold = int(rng.random() < 0.3), int(rng.random() < 0.4)
        discard = int(rng.random() < 0.05)
        await bench.step(
            write_i=write, copy_i=copy, address_i=at, data_i=data, change_i=change,
            discard_i=discard, hold_i=hold,
        )  # fmt: skip
        if STAGED:
            if change and not hold:
                changes += bench.active != bench.staged
                bench.active = list(bench.staged)
            idle += change and hold and not pending
            if write and mine:
                pending = True
            elif (change and not hold) or discard:
                pending = False
            for n in mine if write or copy else ():
                bench.staged[n] = data
        else:
            for n in mine if copy and not hold else ():
                changes += bench.active[n] != data
                bench.active[n] = data
        bench.expect()
        assert bench.word("pending_o") == int(pending)
    assert changes > 50
    assert idle > 50 or not STAGED


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def after_a_reset_all_words_are_to_come(dut: object) -> None:
    """What was on its way is not made active by the reset, and what comes then waits for the readers."""
    bench = Group(dut)
    await bench.begin(random_source("reset"))
    assert bench.word("pending_o") == 0
    await bench.step(write_i=1, address_i=address(0), data_i=~bench.active[0] & 0xFFFFFFFF)
    await bench.step(write_i=0, change_i=1, hold_i=1)
    assert bench.word("pending_o") == STAGED
    await bench.step(change_i=0, rst=1)
    await bench.step(rst=0, hold_i=0)
    await bench.step(2)
    assert bench.word("pending_o") == STAGED
    bench.expect()
