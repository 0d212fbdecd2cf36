# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_setting_group.v``: words are staged one by one, and become active together."""

from __future__ import annotations

import cocotb
from bench import CLOCK_NS, Bench, random_source
from cocotb.clock import Clock
from simulators import defines, parameters

STAGED = parameters()["STAGED"]
FIXED = {1: 0x0D} if "WH_BOARD_ROM" in defines() else {}
"""Words, by their places in the group, that test_setting_group.py's header has as fixed."""
FIRST, WIDTHS = 0x4E, (1, 5, 32)  # bench_setting_group.v


def side_by_side(words: list[int]) -> int:
    total = place = 0
    for word, width in zip(words, WIDTHS, strict=True):
        total |= (word & (1 << width) - 1) << place
        place += width
    return total


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def words_change_together_as_they_were_copied(dut: object) -> None:
    """Random copies and change-overs, also in one clock, of its own words and of others."""
    bench = Bench(dut)
    rng = random_source("group")
    cocotb.start_soon(Clock(dut.clk, CLOCK_NS, unit="ns").start())
    staged = [rng.getrandbits(32) for _ in WIDTHS]
    for word, data in enumerate(staged):
        await bench.step(copy_i=1, address_i=FIRST + word, data_i=data, change_i=0)
    await bench.step(copy_i=0, change_i=1)
    active = list(staged)
    changes = both = 0
    for _ in range(4000):
        word = rng.randrange(len(WIDTHS))
        elsewhere = rng.choice((0, 0, 0, 1 << 8, 2 << 8, 8 << 8, 1 << rng.randrange(8)))
        at, data = FIRST + word ^ elsewhere, rng.getrandbits(32)
        mine = [n for n in range(len(WIDTHS)) if FIRST + n == at]
        copy, change = int(rng.random() < 0.5), int(rng.random() < 0.3)
        await bench.step(copy_i=copy, address_i=at, data_i=data, change_i=change)
        if STAGED and change:
            changes += active != staged
            active = list(staged)
        for n in mine if copy else ():
            both += change
            staged[n] = data
            if not STAGED:
                changes += active[n] != data
                active[n] = data
        held = [FIXED.get(n, word) for n, word in enumerate(active)]
        assert bench.word("words_o") == side_by_side(held)
    assert changes > 50
    assert both > 50
