# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_zero.v``: the mean of whole ticks, rounded to the nearest, or a fault."""

from __future__ import annotations

import random

import cocotb
from bench import Bench, random_source
from simulators import parameters
from wavehaptics.words import formats

LOG2 = parameters().get("LOG2_TICKS", 10)
TICKS = 1 << LOG2
LATENCY = 3
"""Clocks from the next tick's first word to the zero."""
LOW, TOP = -(1 << 15), (1 << 15) - 1
WIDEST = (1 << (formats.SUM_W - 1)) - 1


def mean_of(total: int) -> int:
    """Nearest word, halves away from zero."""
    size = (abs(total) + TICKS // 2) >> LOG2
    return size if total >= 0 else -size


class ZeroBench(Bench):
    """Feeds words tick by tick."""

    async def begin(self, limit: int = WIDEST) -> None:
        await self.start(valid_i=0, first_i=0, sample_i=0, start_i=0, bridge_off_i=1, limit_i=limit)

    async def tick(self, words: list[int], idle: int = 0) -> None:
        for n, word in enumerate(words):
            await self.step(valid_i=1, first_i=int(n == 0), sample_i=word)
            self.drive(valid_i=0)
            await self.step(idle, first_i=1, sample_i=LOW)

    async def measure(self, rng: random.Random, samples: int, low: int, top: int) -> int:
        """The whole of a measurement with random words; the sum of all of them."""
        # A tick is under way when the start comes: it doesn't count.
        await self.step(valid_i=1, first_i=1, sample_i=TOP)
        self.drive(valid_i=0)
        await self.step(start_i=1)
        self.drive(start_i=0)
        assert self.word("busy_o") == 1
        await self.step(valid_i=1, first_i=0, sample_i=TOP)
        total = 0
        for _ in range(TICKS):
            words = [rng.randint(low, top) for _ in range(samples)]
            total += sum(words)
            await self.tick(words, rng.choice((0, 1)))
            assert self.word("busy_o") == 1
            assert self.word("done_o") == 0
        # The next tick's first word ends it.
        await self.step(valid_i=1, first_i=1, sample_i=TOP)
        self.drive(valid_i=0)
        for _ in range(LATENCY - 1):
            assert (self.word("done_o"), self.word("busy_o")) == (0, 1)
            await self.step()
        assert (self.word("done_o"), self.word("busy_o")) == (1, 0)
        await self.step()
        assert self.word("done_o") == 0
        return total


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def means(dut: object) -> None:
    """Random words, all most negative and all most positive, one to 256 in a tick."""
    bench = ZeroBench(dut)
    rng = random_source("means")
    await bench.begin()
    assert (bench.word("measured_o"), bench.signed("zero_o")) == (0, 0)
    seen = set()
    for samples, low, top in (
        (1, -5, 5), (1, LOW, TOP), (3, -1, 1), (2, LOW, LOW), (256, TOP, TOP),
        (256, LOW + 1, LOW + 1),
        (4, 7, 90), (5, -90, -7),
    ):  # fmt: skip
        total = await bench.measure(rng, samples, low, top)
        assert bench.signed("zero_o") == mean_of(total)
        assert (bench.word("measured_o"), bench.word("fault_o")) == (1, 0)
        seen.add(mean_of(total))
    assert len(seen) == 8


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def halves(dut: object) -> None:
    """An exact half goes away from zero on both sides."""
    bench = ZeroBench(dut)
    await bench.begin()
    for sign in (1, -1):
        await bench.step(start_i=1)
        bench.drive(start_i=0)
        for n in range(TICKS):
            await bench.tick([sign * int(n < TICKS // 2)])
        await bench.tick([0])
        await bench.step(LATENCY - 1)
        assert bench.signed("zero_o") == sign


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def limits(dut: object) -> None:
    """A zero at the limit is taken, one beyond is a fault and leaves the one before."""
    bench = ZeroBench(dut)
    rng = random_source("limits")
    await bench.begin(limit=100)
    for word, good in ((100, True), (101, False), (-100, True), (-101, False), (LOW, False)):
        before = bench.signed("zero_o")
        await bench.measure(rng, 1, word, word)
        assert bench.word("fault_o") == int(not good)
        assert bench.signed("zero_o") == (word if good else before)
        assert bench.word("measured_o") == 1
    await bench.begin(limit=0)
    await bench.measure(rng, 1, 3, 3)
    assert (bench.word("fault_o"), bench.word("measured_o")) == (1, 0)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def bridge_goes_on(dut: object) -> None:
    """At any time of the measurement: a fault, nothing measured, and the next one is right."""
    bench = ZeroBench(dut)
    rng = random_source("bridge")
    await bench.begin()
    await bench.measure(rng, 1, 7, 7)
    for ticks in (0, 1, TICKS // 2, TICKS - 1):
        await bench.step(start_i=1)
        bench.drive(start_i=0)
        for _ in range(ticks):
            await bench.tick([900])
        await bench.step(bridge_off_i=0)
        assert (bench.word("fault_o"), bench.word("busy_o"), bench.word("done_o")) == (1, 0, 1)
        bench.drive(bridge_off_i=1)
        for _ in range(TICKS + 2):
            await bench.tick([900])
            assert bench.word("busy_o") == 0
        assert bench.signed("zero_o") == 7
    await bench.measure(rng, 1, -4, -4)
    assert (bench.word("fault_o"), bench.signed("zero_o")) == (0, -4)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_start_forgets_the_fault(dut: object) -> None:
    """Whatever it was, from the next clock on; the zero of before is still there."""
    bench = ZeroBench(dut)
    rng = random_source("forgets")
    await bench.begin(limit=100)
    await bench.measure(rng, 1, 9, 9)
    for strange in (True, False):
        if strange:
            await bench.measure(rng, 1, 101, 101)
        else:
            await bench.step(start_i=1)
            await bench.step(2, start_i=0, bridge_off_i=0)
            bench.drive(bridge_off_i=1)
        assert (bench.word("fault_o"), bench.signed("zero_o")) == (1, 9)
        await bench.step(start_i=1)
        bench.drive(start_i=0)
        assert (bench.word("fault_o"), bench.word("busy_o")) == (0, 1)
    assert (bench.signed("zero_o"), bench.word("measured_o")) == (9, 1)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def again_and_reset(dut: object) -> None:
    """A start in mid-measurement begins anew; a reset leaves no zero."""
    bench = ZeroBench(dut)
    rng = random_source("again")
    await bench.begin()
    await bench.step(start_i=1)
    bench.drive(start_i=0)
    for _ in range(TICKS // 2):
        await bench.tick([1000])
    total = await bench.measure(rng, 2, -20, 30)
    assert bench.signed("zero_o") == mean_of(total)
    await bench.step(rst=1)
    bench.drive(rst=0)
    assert (bench.word("measured_o"), bench.signed("zero_o"), bench.word("busy_o")) == (0, 0, 0)
