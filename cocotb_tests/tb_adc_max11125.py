# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_adc_max11125.v``, wired to a model of the part in real time."""

from __future__ import annotations

import dataclasses

import cocotb
import pytest
from adc_part import DIN_SETUP_NS, RESET_WORD, AdcPart, TimingError
from bench import Bench, random_source, unpack
from simulators import parameters
from wavehaptics.parts.adcs import PARTS, Frame, Part, frame
from wavehaptics.words import formats

LINES = parameters().get("LINES", 1)
FIRST = parameters().get("FIRST_CHANNEL", 0)
PINS_NS = 2.0
CLOCK_MHZ = 96.0


class MaxBench(Bench):
    """The block with the part on its pins."""

    async def begin(self, part: Part, clock_mhz: float, made: Frame | None = None) -> None:
        """Reset, and wait until the part is set up."""
        self.model = AdcPart(part, lambda channel: self.codes[channel])
        self.made, self.period_ns = made or frame(part, 1e6 * clock_mhz), 1e3 / clock_mhz
        self.codes = [0] * 16
        self.out: list[tuple[int, int, list[int]]] = []
        """Clock, first_o and words of each valid_o."""
        words = self.made.words()
        del words["calibrate_bits"]
        inputs = {f"{name}_i": word for name, word in words.items()}
        await self.start(start_i=0, first_i=0, adc_sdata_i=0, **inputs)
        waited = 0
        while self.word("busy_o"):
            assert not self.word("ready_o")
            await self.clock()
            waited += 1
            assert waited < 5000
        assert self.word("ready_o")
        assert self.model.commands == [RESET_WORD, 0x0800 | FIRST << 7]
        assert not self.out

    async def clock(self, start: int = 0, first: int = 0, rst: int = 0) -> None:
        edge = self.clocks * self.period_ns
        levels = self.word("adc_cs_n_o"), self.word("adc_sclk_o"), self.word("adc_din_o")
        self.model.pins(edge + PINS_NS, *levels)
        sdata = self.model.sdata(edge + self.period_ns - PINS_NS)
        await self.step(start_i=start, first_i=first, adc_sdata_i=sdata, rst=rst)
        if self.word("valid_o"):
            words = unpack(self.word("sample_o"), formats.SAMPLE_W, LINES)
            self.out.append((self.clocks, self.word("first_o"), words))

    async def round(self, first: int) -> int:
        """One start and all its frames; the clock of the start."""
        began = self.clocks
        await self.clock(start=1, first=first)
        while self.word("busy_o"):
            await self.clock()
            assert self.clocks - began < 20_000
        return began

    async def rounds(self, count: int, rng: object) -> None:
        """Random codes: each set of words comes one start late, the first start brings none."""
        bits = self.model.part.bits
        top = (1 << bits) - 1
        expected = []
        self.out.clear()
        for n in range(count):
            self.codes = [rng.choice((0, top, top // 2 + 1, rng.randint(0, top)))
                          for _ in range(16)]  # fmt: skip
            first = rng.randint(0, 1)
            began = await self.round(first)
            assert self.clocks - began == LINES * self.made.cycle_clocks
            words = [(code - (1 << (bits - 1))) << (formats.SAMPLE_W - bits)
                     for code in self.codes[FIRST : FIRST + LINES]]  # fmt: skip
            expected.append((first, words))
            assert len(self.out) == n
            if n:
                clock, *got = self.out[-1]
                assert tuple(got) == expected[n - 1]
                assert clock - began == self.made.conversion_clocks
        assert self.word("overrun_o") == 0


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(name=["MAX11125", "MAX11123"])
async def words_come_a_frame_late(dut: object, name: str) -> None:
    """At 96 MHz, so at 16 MHz and a million frames a second: the part's very limits."""
    bench = MaxBench(dut)
    part = PARTS[name]
    await bench.begin(part, CLOCK_MHZ)
    assert bench.made.cycle_clocks == CLOCK_MHZ
    await bench.rounds(20, random_source(name))
    await bench.clock()
    asked = [0x0800 | (FIRST + n) << 7 for n in range(LINES)]
    assert bench.model.commands[2:] == asked * 20
    assert bench.model.aborted == 0


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(clock_mhz=[32.0, 48.0, 80.0])
async def other_clocks(dut: object, clock_mhz: float) -> None:
    bench = MaxBench(dut)
    await bench.begin(PARTS["MAX11125"], clock_mhz)
    await bench.rounds(6, random_source(f"{clock_mhz:g} MHz"))


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_frame_as_slow_as_it_gets(dut: object) -> None:
    """Waits of any length before, behind and between frames."""
    good = frame(PARTS["MAX11125"], 1e6 * CLOCK_MHZ)
    for waits in (
        {"setup_clocks": 70, "hold_clocks": 45, "quiet_clocks": 200},
        {"setup_clocks": 131, "hold_clocks": 255, "quiet_clocks": 255},
    ):
        bench = MaxBench(dut)
        await bench.begin(PARTS["MAX11125"], CLOCK_MHZ, dataclasses.replace(good, **waits))
        await bench.rounds(3, random_source("slow"))


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def the_part_complains(dut: object) -> None:
    """A clock too fast, and each other limit broken alone."""
    part = PARTS["MAX11125"]
    good = frame(part, 1e6 * CLOCK_MHZ)
    waits = dataclasses.replace(good, quiet_clocks=60)
    for judge, made, clock_mhz, complaint in (
        (part, waits, 1.05 * CLOCK_MHZ, "SCLK"),
        (part, good, 48.0 * 1.05, "cycle|SCLK"),
        (part, dataclasses.replace(waits, sclk_half_clocks=2), CLOCK_MHZ, "SCLK"),
        (dataclasses.replace(part, cs_high_s=25e-9, rate_hz=2e6), good, CLOCK_MHZ, "CS high"),
        (dataclasses.replace(part, setup_s=25e-9), waits, CLOCK_MHZ, "CS to SCLK"),
        (part, dataclasses.replace(waits, hold_clocks=0), CLOCK_MHZ, "last edge to CS"),
    ):
        bench = MaxBench(dut)
        if clock_mhz < CLOCK_MHZ:
            made = dataclasses.replace(made, sclk_half_clocks=1)
        with pytest.raises(TimingError, match=f"MAX11125: ({complaint})"):
            await bench.begin(judge, clock_mhz, made)
    assert DIN_SETUP_NS < 3e3 / CLOCK_MHZ


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_late_output_is_read_wrong(dut: object) -> None:
    bench = MaxBench(dut)
    part = PARTS["MAX11125"]
    slow = dataclasses.replace(part, access_s=35e-9)
    await bench.begin(slow, CLOCK_MHZ)
    bench.codes = [0x5A5] * 16
    for _ in range(3):
        await bench.round(0)
    assert bench.out[-1][2] != [(0x5A5 - 0x800) << 4] * LINES


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def starts_that_come_early(dut: object) -> None:
    """Before the part is ready they are nothing; while frames run they are overruns."""
    bench = MaxBench(dut)
    part = PARTS["MAX11125"]
    await bench.begin(part, CLOCK_MHZ)
    bench.model = AdcPart(part, lambda channel: bench.codes[channel])
    await bench.clock(rst=1)
    bench.drive(rst=0)
    while not bench.word("ready_o"):
        await bench.clock(start=1)
    assert bench.word("overrun_o") == 0
    await bench.rounds(3, random_source("early"))
    await bench.clock(start=1)
    for _ in range(LINES * bench.made.cycle_clocks - 2):
        await bench.clock()
    assert bench.word("overrun_o") == 0
    await bench.clock(start=1)
    assert bench.word("overrun_o") == 1
    await bench.clock()
    frames = len(bench.model.commands)
    for _ in range(20):
        await bench.clock()
    assert len(bench.model.commands) == frames


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def reset_in_a_frame(dut: object) -> None:
    """Everything starts anew: set-up, and no word of before."""
    bench = MaxBench(dut)
    part = PARTS["MAX11125"]
    rng = random_source("reset")
    for _ in range(4):
        await bench.begin(part, CLOCK_MHZ)
        await bench.rounds(2, rng)
        await bench.clock(start=1)
        for _ in range(rng.randint(0, LINES * 90)):
            await bench.clock()
        await bench.clock(rst=1)
        bench.model.cut_off()
        assert (bench.word("adc_cs_n_o"), bench.word("adc_sclk_o")) == (1, 1)
