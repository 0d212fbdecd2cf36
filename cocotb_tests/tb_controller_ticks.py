# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_controller.v``: ticks of any length, with steps at any place in them.

What is said of walls and of lost steps has to hold for every tick and every sample's phase that the
settings allow, so that here they are gone through; the words are :mod:`tb_controller`'s business.
"""

from __future__ import annotations

from dataclasses import replace

import cocotb
from bench import Bench, pack, random_source
from tb_controller import PART_FRAME, SHAPER, WALLS, N, Settings
from tb_quadrature import levels
from wavehaptics.controller.pins_timing import CORE_CLOCKS, SECTION_CLOCKS
from wavehaptics.words import formats

FRAME = replace(PART_FRAME, frame_bits=8, lead_bits=0, data_bits=8, quiet_clocks=1)
"""A frame that leaves the core the tick."""
STEP_CLOCKS = (CORE_CLOCKS + SECTION_CLOCKS * SHAPER) * N
TICKS = (STEP_CLOCKS, STEP_CLOCKS + 1, STEP_CLOCKS + 2, STEP_CLOCKS + 6, STEP_CLOCKS + 8,
         2 * STEP_CLOCKS, 2 * STEP_CLOCKS + 1)  # fmt: skip
COUNT_CLOCKS = 8
"""Clocks in which the encoder's filter lets a count pass."""
FELT_CLOCKS = 2 * WALLS + 2 + STEP_CLOCKS + COUNT_CLOCKS
"""A round that has begun, one of the new position, and a step."""

FIRST_TICKS, LATER_TICKS = 8, 2
"""Ticks' ends that may pass without a step: before the first, and from one to the next."""


class TicksBench(Bench):
    """Nothing on the pins but encoders; the steps are counted."""

    async def begin(self, settings: Settings, enable: int = 1, **inputs: int) -> None:
        self.position = 0
        self.ticks = 0
        self.steps: list[int] = []
        await self.start(
            enable_i=enable, adc_sdata_i=0, enc_a_i=0, enc_b_i=0,
            **{**settings.inputs(), **inputs},
        )  # fmt: skip
        while not self.word("adc_ready_o"):
            await self.step()

    async def run(self, clocks: int) -> None:
        for _ in range(clocks):
            await self.step()
            self.ticks += self.word("tick_o")
            if self.word("core_valid_o"):
                self.steps.append(self.clocks)

    async def turn(self, position: int) -> None:
        """All rotors, a count at a time."""
        while self.position != position:
            self.position += 1 if position > self.position else -1
            a, b = levels(self.position)
            every = (1 << N) - 1
            self.drive(enc_a_i=every * a, enc_b_i=every * b)
            await self.run(COUNT_CLOCKS)


def phases(tick_clocks: int) -> list[int]:
    """Leads with which the sample is at every place of the tick that ``sample_lead_i`` reaches."""
    first, last = tick_clocks // 2 - tick_clocks + 1, tick_clocks // 2
    return list(range(max(-128, first), min(127, last) + 1))


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def every_wall_is_felt(dut: object) -> None:
    """In time, on every rotor, whatever the tick and the sample's place in it."""
    bench, rng = TicksBench(dut), random_source("walls")
    together = 0
    for tick_clocks in TICKS:
        leads = phases(tick_clocks)
        for lead in rng.sample(leads, min(16, len(leads))):
            settings = Settings(half_clocks=tick_clocks, lead=lead, frame=FRAME)
            wall = rng.randrange(WALLS)
            await bench.begin(
                settings,
                wall_min_i=pack([3] * N * WALLS, formats.COUNT_W),
                wall_max_i=pack([9] * N * WALLS, formats.COUNT_W),
                wall_enable_i=sum(1 << n * WALLS + wall for n in range(N)),
            )
            await bench.run(3 * tick_clocks)
            for position, felt in ((2, 0), (4, 1), (1, 0), (3, 1)):
                await bench.turn(position)
                await bench.run(FELT_CLOCKS)
                assert bench.word("contact_o") == ((1 << N) - 1) * felt, (tick_clocks, lead)
            assert {b - a for a, b in zip(bench.steps, bench.steps[1:], strict=False)} == {
                tick_clocks
            }
            assert not bench.word("overrun_o")
            together += tick_clocks == STEP_CLOCKS
    assert together > 10


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def ticks_without_a_step_are_told(dut: object) -> None:
    """A sum that never completes, for more samples than the tick has room for; gates on or off."""
    bench = TicksBench(dut)
    tick_clocks = 2 * STEP_CLOCKS + 20
    for enable in (1, 0):
        settings = Settings(half_clocks=tick_clocks, samples=1, frame=FRAME)
        await bench.begin(settings, enable, samples_i=2)
        while bench.ticks <= FIRST_TICKS:
            assert not bench.word("overrun_o")
            await bench.run(1)
        await bench.run(1)
        assert bench.word("overrun_o")
        # The same when it begins later; with one sample a tick it goes on until then.
        await bench.begin(settings, enable)
        await bench.run(20 * tick_clocks)
        assert not bench.word("overrun_o")
        bench.drive(samples_i=2)
        await bench.run(LATER_TICKS * tick_clocks)
        assert not bench.word("overrun_o")
        await bench.run(2 * tick_clocks)
        assert bench.word("overrun_o")


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def late_samples_are_no_lost_steps(dut: object) -> None:
    """With every other sample a clock later, steps start now before, now behind a tick's end."""
    bench = TicksBench(dut)
    tick_clocks = STEP_CLOCKS + 4
    last, *leads = phases(tick_clocks)
    for lead in leads:
        settings = Settings(half_clocks=tick_clocks, lead=lead, frame=FRAME)
        await bench.begin(settings, sample_late_i=1)
        await bench.run(12 * tick_clocks)
        assert not bench.word("overrun_o"), lead
        assert len(bench.steps) > 8
    # A sample that is so late that every other tick has none: each second step is lost.
    await bench.begin(Settings(half_clocks=tick_clocks, lead=last, frame=FRAME), sample_late_i=1)
    await bench.run(8 * tick_clocks)
    assert bench.word("overrun_o")
