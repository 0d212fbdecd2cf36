# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_host_link.v``: equal to its model, and never in debt.

The model is :mod:`wavehaptics.controller.host_link`.
"""

from __future__ import annotations

import math
import random

import cocotb
from bench import Bench, random_source
from wavehaptics.controller import host_link
from wavehaptics.words import formats

TICK_CLOCKS = 24
LATE_CLOCKS = 100
"""An answer that comes later than this before a period's end may count for the next one."""
WAVE = formats.WAVE


class LinkBench(Bench):
    """Feeds ticks and answers, and compares every word with the model's."""

    async def begin(self, period_log2: int, timeout: int) -> None:
        self.log2, self.timeout = period_log2, timeout
        self.state = host_link.new_state()
        self.paid_in = self.paid_out = 0
        self.packets = self.halved = 0
        await self.start(
            valid_i=0, v_i=0, strobe_i=0, sequence_i=0, u_i=0,
            period_log2_i=period_log2, timeout_i=timeout,
        )  # fmt: skip

    def shown(self) -> tuple[int, int]:
        return self.word("active_o"), self.signed("u_o")

    async def period(self, waves: list[int], answers: dict[int, tuple[int, int]]) -> None:
        """One period of ticks, with answers (number, u) at the given clocks of it."""
        assert len(waves) == 1 << self.log2
        heard = None
        for clock in range(TICK_CLOCKS * len(waves)):
            tick, phase = divmod(clock, TICK_CLOCKS)
            last = phase == TICK_CLOCKS - 1
            inputs = {"valid_i": last, "v_i": waves[tick], "strobe_i": clock in answers}
            if clock in answers:
                inputs["sequence_i"], inputs["u_i"] = answers[clock]
                host_link.answer(self.state, *answers[clock])
            await self.step(1, **inputs)
            if self.word("strobe_o"):
                heard = self.word("sequence_o"), self.signed("v_mean_o")
        if self.expected is not None:
            assert heard == self.expected
            self.packets += 1
        wanted = self.state[host_link.PENDING_U], self.state[host_link.PENDING]
        for wave in waves:
            sent, sequence, mean = host_link.tick(self.state, wave, self.log2, self.timeout)
        assert sent
        self.expected = sequence, mean
        active, u = int(self.state[host_link.ACTIVE]), int(self.state[host_link.U])
        self.halved += bool(wanted[1] and active and wanted[0] != u)
        assert self.shown() == (active, u), self.packets

    expected: tuple[int, int] | None = None


def some_wave(rng: random.Random) -> int:
    corners = (WAVE.raw_min, WAVE.raw_min + 1, -1, 0, 1, WAVE.raw_max)
    if rng.random() < 0.2:
        return rng.choice(corners)
    return rng.randint(WAVE.raw_min, WAVE.raw_max) >> rng.randint(0, 30)


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def equals_the_integer_model(dut: object) -> None:
    """Answers new, old, twice, forged and none; any waves; silence to the timeout and back."""
    rng = random_source("link")
    bench = LinkBench(dut)
    activity = set()
    halved = packets = 0
    for log2, timeout, periods in ((4, 5, 80), (3, 1, 80), (5, 20, 30)):
        bench.expected = None
        await bench.begin(log2, timeout)
        clocks = TICK_CLOCKS << log2
        silent = 0
        for _ in range(periods):
            shift = rng.randint(0, 24)
            waves = [some_wave(rng) >> shift for _ in range(1 << log2)]
            answers = {}
            silent = silent - 1 if silent else (rng.randint(0, 8) if rng.random() < 0.1 else 0)
            for _ in range(0 if silent else rng.choice((0, 1, 1, 1, 2, 5))):
                age = rng.choice((0, 0, 0, 1, 2, 3, 127, 128, -1, rng.randint(0, 255)))
                number = int(bench.state[host_link.SEQUENCE] - age) & 255
                # Beyond the packet's own way out no host can know it, but a forger may.
                answers[rng.randrange(2, clocks - LATE_CLOCKS)] = number, some_wave(rng) >> shift
            await bench.period(waves, answers)
            activity.add(bench.shown()[0])
        packets += bench.packets
        halved += bench.halved
    assert packets == 79 + 79 + 29
    assert activity == {0, 1}
    assert halved > 10


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def never_pays_out_more_than_came_in(dut: object) -> None:
    """A host that always answers with the largest wave gets what came in, and not more.

    The waves grow, so that each place of a budget is once the one that decides.
    """
    rng = random_source("greed")
    bench = LinkBench(dut)
    await bench.begin(3, 3)
    came = went = 0
    spent = 0
    for period in range(120):
        scale = 1 << min(period // 4, 28)
        waves = [rng.randint(0, scale) + scale // 2 for _ in range(8)]
        active, u = bench.shown()
        # What is applied during the coming period.
        went += 8 * u * u if active else 0
        spent += bool(active and u)
        came += sum(wave * wave for wave in waves)
        answer = int(bench.state[host_link.SEQUENCE]), WAVE.raw_max
        await bench.period(waves, {10: answer})
        assert went <= came
    assert spent > 100
    assert went > 0.05 * came


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def what_came_in_is_there_later(dut: object) -> None:
    """A budget of any size outlasts small answers, and then covers one nearly as large as it is."""
    rng = random_source("savings")
    bench = LinkBench(dut)
    for size in range(4, WAVE.width):
        bench.expected = None
        await bench.begin(3, 100)
        wave = rng.randint(1 << (size - 1), (1 << size) - 1)
        late = wave - (wave >> 3)
        for came, went in ((0, 1), (wave, 1), (0, 1), (0, -1), (0, late), (0, 0)):
            shown = bench.shown()[1]
            answer = int(bench.state[host_link.SEQUENCE]), went
            await bench.period([came] * 8, {10: answer})
        assert shown == late, size


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_full_budget_to_its_last_place(dut: object) -> None:
    """As much as it holds is paid out, wave by wave, until nothing is left."""
    bench = LinkBench(dut)
    await bench.begin(3, 100)
    largest = -WAVE.raw_min
    for _ in range(8):
        await bench.period([-largest] * 8, {10: (int(bench.state[host_link.SEQUENCE]), 0)})
    left, periods = 4 * largest * largest - 1, 0
    while left:
        wave = min(math.isqrt(left), largest)
        left -= wave * wave
        periods += 1
        await bench.period([0] * 8, {10: (int(bench.state[host_link.SEQUENCE]), -wave)})
        assert bench.shown() == (1, -wave)
    assert periods > 5
    await bench.period([0] * 8, {10: (int(bench.state[host_link.SEQUENCE]), 1)})
    assert bench.shown() == (1, 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def the_mean_of_long_periods(dut: object) -> None:
    """Of up to 2^15 ticks, a tick in each clock: the whole sum's, toward zero."""
    bench, rng = LinkBench(dut), random_source("long")
    for log2 in range(6, 16):
        await bench.begin(log2, 5)
        for number in range(1, 5):
            left, total = 1 << log2, 0
            shift = rng.choice((0, 0, 7))
            while left:
                ticks, wave = min(left, rng.randint(1, 1 << (log2 - 3))), some_wave(rng) >> shift
                await bench.step(ticks, valid_i=1, v_i=wave)
                left, total = left - ticks, total + ticks * wave
            await bench.step(2 + log2, valid_i=0)
            assert not bench.word("strobe_o")
            await bench.step()
            assert bench.word("strobe_o")
            assert bench.word("sequence_o") == number
            mean = abs(total) >> log2
            assert bench.signed("v_mean_o") == (-mean if total < 0 else mean), log2
            await bench.step(150)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_late_answer_waits_for_the_next_period(dut: object) -> None:
    """At every clock before the period's end: it counts in this one or the next, never in none."""
    bench = LinkBench(dut)
    clocks = 8 * TICK_CLOCKS
    taken = []
    for before in (1, 2, 3, *range(10, LATE_CLOCKS + 10, 9)):
        await bench.begin(3, 100)
        bench.expected = None
        for _ in range(3):
            number = int(bench.state[host_link.SEQUENCE])
            await bench.period([1 << 20] * 8, {10: (number, 1 << 16)})
        number = int(bench.state[host_link.SEQUENCE])
        seen = []
        for clock in range(3 * clocks):
            last = clock % TICK_CLOCKS == TICK_CLOCKS - 1
            strobe = clock == clocks - before
            await bench.step(
                1, valid_i=last, v_i=1 << 20, strobe_i=strobe, sequence_i=number, u_i=-(1 << 15)
            )
            if clock % clocks == clocks - 1:
                seen.append(bench.signed("u_o"))
        assert -(1 << 15) in seen[:2], before
        assert seen[-1] == -(1 << 15)
        taken.append(seen[0] == -(1 << 15))
    assert taken[-1]
    assert not taken[0]


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def reset_in_mid_stream(dut: object) -> None:
    """Nothing is left of an answer, a budget or a period that was under way."""
    bench = LinkBench(dut)
    for clocks in (3, 40, 100, 180):
        bench.expected = None
        await bench.begin(3, 4)
        for _ in range(4):
            number = int(bench.state[host_link.SEQUENCE])
            await bench.period([1 << 22] * 8, {10: (number, 1 << 21)})
        assert bench.shown()[0] == 1
        for clock in range(clocks):
            last = clock % TICK_CLOCKS == TICK_CLOCKS - 1
            await bench.step(1, valid_i=last, v_i=5, strobe_i=clock == 2, sequence_i=4, u_i=77)
        bench.expected = None
        await bench.begin(3, 4)
        assert bench.shown() == (0, 0)
        for _ in range(3):
            await bench.period([1 << 22] * 8, {})
            assert bench.shown() == (0, 0)
