# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_controller.v`` with bit streams of modulators: the currents and their times."""

from __future__ import annotations

import random
from dataclasses import replace

import cocotb
from bench import Bench, random_source, unpack
from simulators import parameters
from tb_controller import Settings
from tb_sinc3 import word_of
from wavehaptics.controller.pins_timing import latency_clocks
from wavehaptics.motor.sensor import scale_sum
from wavehaptics.parts.adcs import SINC_PIPELINE, Frame
from wavehaptics.words import formats

N = parameters().get("N", 1)
OSR = parameters().get("OSR", 12)
FRAME = Frame(2, 16, 0, 16, sclk_idle=0, kind="sigma_delta", pipeline=SINC_PIPELINE, osr=OSR)
DUTY_CLOCKS = 8


class StreamBench(Bench):
    """Random bits on the pins, and what the controller has taken of them."""

    async def begin(self, settings: Settings, rng: random.Random) -> None:
        self.rng, self.density = rng, [0.5] * N
        self.taken: list[list[int]] = [[] for _ in range(N)]
        self.taken_at: list[int] = []
        self.ticks: list[int] = []
        self.steps: list[tuple[int, list[int]]] = []
        await self.start(enable_i=1, adc_sdata_i=0, enc_a_i=0, enc_b_i=0, **settings.inputs())
        self.clocks = 0
        self._sclk = 0

    async def clock(self) -> None:
        bits = [int(self.rng.random() < density) for density in self.density]
        await self.step(adc_sdata_i=sum(bit << n for n, bit in enumerate(bits)))
        sclk = self.word("adc_sclk_o")
        if self._sclk and not sclk:
            self.taken_at.append(self.clocks)
            for n, bit in enumerate(bits):
                self.taken[n].append(bit)
        self._sclk = sclk
        assert self.word("adc_cs_n_o") == 1
        if self.word("tick_o"):
            self.ticks.append(self.clocks)
        if self.word("core_valid_o"):
            self.steps.append((self.clocks, unpack(self.word("current_o"), formats.DATA_W, N)))


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def currents_and_their_times(dut: object) -> None:
    """One and two words a tick: every current is its bits', latency_clocks after its strobe."""
    bench = StreamBench(dut)
    rng = random_source("streams")
    for samples in (1, 2):
        tick = samples * FRAME.cycle_clocks
        for lead in (FRAME.cycle_clocks // 2, FRAME.cycle_clocks // 2 - 5):
            settings = Settings(
                half_clocks=tick, samples=samples, lead=lead, frame=FRAME, extra_ticks=3
            )
            await bench.begin(settings, rng)
            while len(bench.steps) < 9:
                if rng.random() < 0.01:
                    bench.density = [rng.choice((0.0, 0.2, 0.5, 1.0)) for _ in range(N)]
                await bench.clock()
                assert bench.clocks < 40 * tick + 500
            first_tick = bench.ticks[0] - tick + 1
            strobes = [
                first_tick + n * FRAME.cycle_clocks + FRAME.cycle_clocks // 2 - lead
                for n in range(200)
            ]
            # All of the latency but the duty's.
            core = latency_clocks(FRAME.conversion_clocks, N) - DUTY_CLOCKS - (N - 1)
            seen = set()
            for n, (clock, currents) in enumerate(bench.steps):
                # The words of tick n come with the strobes of two intervals later.
                own = strobes[n * samples + 2 : (n + 1) * samples + 2]
                assert clock - own[-1] == core, (n, clock - own[-1], core)
                for port in range(N):
                    total = 0
                    for strobe in own:
                        end = sum(at <= strobe for at in bench.taken_at) - 2
                        settled = strobe >= strobes[3]
                        total += word_of(bench.taken[port], end) if settled else 0
                    word = scale_sum.py_func(total, settings.gain(port))
                    assert currents[port] == word
                    seen.add(word)
            assert len(seen) > 4
            assert bench.word("overrun_o") == 0


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def the_fast_path_trips(dut: object) -> None:
    """Full scale is told within 3 TRIP_OSR bits, of the port that has it alone."""
    bench = StreamBench(dut)
    settings = replace(
        Settings(half_clocks=FRAME.cycle_clocks, lead=FRAME.cycle_clocks // 2, frame=FRAME),
        trip=(1 << 15) * 9 // 10, extra_ticks=3,
    )  # fmt: skip
    await bench.begin(settings, random_source("trip"))
    for _ in range(400):
        await bench.clock()
        assert bench.word("overcurrent_o") == 0
    bench.density[N - 1] = 1.0
    clocks = 0
    while not bench.word("overcurrent_o"):
        await bench.clock()
        clocks += 1
        assert clocks <= (3 * 8 + 3) * 4 + 3
    assert bench.word("overcurrent_o") == 1 << (N - 1)
