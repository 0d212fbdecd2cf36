# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_step_watch.v``: silent where each tick has its start, not otherwise."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source

FIRST_TICKS, LATER_TICKS = 8, 2
"""Ticks' ends that may pass before the first start, and from one to the next, its own included."""
TICK = 10


async def ticks(bench: Bench, count: int, starts: set[int] | frozenset[int] = frozenset()) -> None:
    """``count`` ticks, with starts at these clocks from the first one's beginning on."""
    for clock in range(count * TICK):
        await bench.step(tick_i=clock % TICK == TICK - 1, start_i=clock in starts)
    bench.drive(tick_i=0, start_i=0)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_start_in_each_tick_is_enough(dut: object) -> None:
    """Wherever it is, and however it wanders over the tick's end."""
    bench, rng = Bench(dut), random_source("starts")
    for place in range(TICK):
        await bench.start(start_i=0, tick_i=0)
        starts = {n * TICK + place + rng.choice((0, 0, 1, 2)) for n in range(60)}
        await ticks(bench, 60, starts)
        assert not bench.word("overrun_o"), place


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def the_first_one_too_many_is_told(dut: object) -> None:
    """Before the first start and after any, one clock after the tick's end; until reset."""
    bench = Bench(dut)
    for first in (None, 0, 5, TICK - 1, 7 * TICK, FIRST_TICKS * TICK + TICK - 1):
        await bench.start(start_i=0, tick_i=0)
        if first is not None:
            await ticks(bench, first // TICK + 1, {first})
            assert not bench.word("overrun_o")
        allowed = FIRST_TICKS if first is None else LATER_TICKS - 1
        await ticks(bench, allowed)
        assert not bench.word("overrun_o"), first
        await bench.step(TICK)
        assert not bench.word("overrun_o"), first
        await bench.step(tick_i=1)
        assert bench.word("overrun_o"), first
        await ticks(bench, 3, {3, TICK + 3})
        assert bench.word("overrun_o")
    await bench.start(start_i=0, tick_i=0)
    assert not bench.word("overrun_o")


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def steps_that_are_lost_now_and_then_are_told(dut: object) -> None:
    """The second, however many ticks have had their start between it and the first."""
    bench = Bench(dut)
    for place in range(TICK):
        for between in (1, 2, 5, 30):
            await bench.start(start_i=0, tick_i=0)
            lost = {10, 11 + between}
            starts = {n * TICK + place for n in range(60) if n not in lost}
            await ticks(bench, 11 + between, starts)
            assert not bench.word("overrun_o"), (place, between)
            await ticks(bench, 3, {clock - (11 + between) * TICK for clock in starts})
            assert bench.word("overrun_o"), (place, between)
