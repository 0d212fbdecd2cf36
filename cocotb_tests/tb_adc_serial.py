# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_adc_serial.v``, wired to models of its parts in real time."""

from __future__ import annotations

import dataclasses
import math
import random

import cocotb
import pytest
from adc_part import AD7276, AD7476A, AdcPart, Limits, TimingError
from bench import Bench, random_source, unpack
from simulators import parameters
from wavehaptics import formats

LINES = parameters().get("LINES", 1)

PINS_NS = 2.0
"""From a clock edge to the levels at the part and from the part's output to the next edge, ns."""


def word_of(code: int, data_bits: int) -> int:
    """The block's word of a straight binary code: signed, left-justified."""
    return (code - (1 << (data_bits - 1))) << (formats.SAMPLE_W - data_bits)


class AdcBench(Bench):
    """The block with LINES parts on its pins at a real clock rate."""

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut)
        self.rng = rng
        self.parts: list[AdcPart] = []
        self.period_ns = 0.0
        self.codes: list[int] | None = None

    def _code(self, part: int, limits: Limits) -> int:
        if self.codes is not None:
            return self.codes[part]
        top = (1 << limits.data_bits) - 1
        corners = (0, top, 1 << (limits.data_bits - 1))
        return self.rng.choice(corners + (self.rng.randint(0, top),) * 3)

    async def begin(
        self, limits: Limits, clock_mhz: float, sclk_half: int, quiet: int, **settings: int
    ) -> None:
        """Reset with the part's frame; ``settings`` override single inputs."""
        self.period_ns = 1e3 / clock_mhz
        self.parts = [AdcPart(limits, lambda n=n: self._code(n, limits)) for n in range(LINES)]
        inputs = {
            "sclk_half_clocks_i": sclk_half,
            "frame_bits_i": limits.frame_falls,
            "lead_bits_i": limits.lead_bits,
            "data_bits_i": limits.data_bits,
            "quiet_clocks_i": quiet,
        }
        await self.start(start_i=0, adc_sdata_i=0, **(inputs | settings))
        # The quiet time passes after a reset as well.
        while self.word("busy_o"):
            await self.clock()

    async def clock(self, start: int = 0, **inputs: int) -> None:
        """One clock: the parts see the pins, then the block sees their outputs."""
        edge = self.clocks * self.period_ns
        levels = self.word("adc_cs_n_o"), self.word("adc_sclk_o")
        sdata = 0
        for n, part in enumerate(self.parts):
            part.pins(edge + PINS_NS, *levels)
            sdata |= part.sdata(edge + self.period_ns - PINS_NS) << n
        await self.step(start_i=start, adc_sdata_i=sdata, **inputs)

    async def convert(self) -> tuple[list[int], int]:
        """Words of one conversion and the clocks from the start strobe to valid_o."""
        await self.clock(start=1)
        clocks = 1
        while not self.word("valid_o"):
            assert self.word("busy_o")
            await self.clock()
            clocks += 1
            assert clocks < 1000
        words = unpack(self.word("sample_o"), formats.SAMPLE_W, LINES)
        while self.word("busy_o"):
            await self.clock()
            assert self.word("valid_o") == 0
            assert unpack(self.word("sample_o"), formats.SAMPLE_W, LINES) == words
            clocks += 1
            assert clocks < 2000
        return words, clocks

    async def conversions(self, count: int) -> set[int]:
        """Convert back to back and compare with the parts' codes; the words seen."""
        limits = self.parts[0].limits
        half = int(self.word("sclk_half_clocks_i"))
        bits = limits.lead_bits + limits.data_bits
        seen = set()
        for _ in range(count):
            words, _ = await self.convert()
            for part, word in zip(self.parts, words, strict=True):
                assert word == word_of(part.held, limits.data_bits)
                seen.add(word)
        # The latency is said in the header: the last data bit's fall.
        await self.clock(start=1)
        assert [part.complete for part in self.parts] == [count] * LINES
        clocks = 1
        while not self.word("valid_o"):
            await self.clock()
            clocks += 1
        assert clocks == 1 + (2 * bits - 1) * half
        assert self.word("overrun_o") == 0
        return seen


PARTS = [
    # part, clock in MHz, SCLK's half period and CS high in clocks
    (AD7476A, 36.0, 1, 2),
    (AD7476A, 40.0, 1, 2),
    (AD7476A, 48.0, 2, 2),
    (AD7476A, 100.0, 3, 4),
    (AD7276, 30.0, 1, 2),
    (AD7276, 48.0, 1, 2),
    (AD7276, 96.0, 1, 6),
]


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(which=list(range(len(PARTS))))
async def parts_within_their_limits(dut: object, which: int) -> None:
    """Every code arrives as the part held it, and no limit of the part is broken."""
    limits, clock_mhz, sclk_half, quiet = PARTS[which]
    bench = AdcBench(dut, random_source(f"{limits.name} {clock_mhz:g}"))
    await bench.begin(limits, clock_mhz, sclk_half, quiet)
    seen = await bench.conversions(40)
    assert len(seen) > 10
    assert {word_of(0, 12), word_of(4095, 12), 0} <= seen


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def too_fast_for_the_part(dut: object) -> None:
    """The model notices what this bench exists to notice: each limit, broken alone."""
    rng = random_source("too fast")
    for limits, clock_mhz, sclk_half, quiet, complaint in (
        (AD7476A, 48.0, 1, 4, "SCLK"),
        (AD7476A, 60.0, 1, 4, "SCLK"),
        (AD7276, 120.0, 1, 9, "SCLK"),
        (dataclasses.replace(AD7476A, quiet=70.0), 40.0, 1, 1, "quiet time"),
        (AD7276, 96.0, 1, 2, "acquisition"),
        (dataclasses.replace(AD7276, cs_high=60.0, acquire=0.0), 48.0, 1, 2, "CS high"),
        (dataclasses.replace(AD7276, cs_to_sclk=30.0), 48.0, 1, 3, "CS to SCLK"),
    ):
        bench = AdcBench(dut, rng)
        await bench.begin(limits, clock_mhz, sclk_half, quiet)
        with pytest.raises(TimingError, match=complaint):
            await bench.conversions(3)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def too_slow_an_output(dut: object) -> None:
    """An output that isn't there yet at the next fall of SCLK is read wrong."""
    bench = AdcBench(dut, random_source("slow output"))
    slow = dataclasses.replace(AD7276, sclk_access=40.0)
    await bench.begin(slow, 48.0, 1, 3)
    bench.codes = [0x5A5] * LINES
    words, _ = await bench.convert()
    assert words != [word_of(0x5A5, 12)] * LINES


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def wrong_frames(dut: object) -> None:
    """A frame too short for the part doesn't complete; zeros counted wrong shift the word."""
    bench = AdcBench(dut, random_source("wrong frames"))
    await bench.begin(AD7476A, 40.0, 1, 4, frame_bits_i=15, data_bits_i=11)
    bench.codes = [0x2A5] * LINES
    await bench.convert()
    await bench.clock()
    assert all((part.aborted, part.complete) == (1, 0) for part in bench.parts)
    await bench.begin(AD7476A, 40.0, 1, 4, lead_bits_i=3)
    words, _ = await bench.convert()
    assert words == [word_of(0x2A5 >> 1, 12)] * LINES


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def every_resolution(dut: object) -> None:
    """1 to 16 bits, with and without zeros in front, and a frame longer than its data."""
    bench = AdcBench(dut, random_source("resolutions"))
    seen = 0
    for data_bits, lead_bits, tail in ((1, 0, 0), (8, 2, 4), (10, 2, 2), (14, 1, 3), (16, 0, 0)):
        limits = dataclasses.replace(
            AD7276,
            name=f"{data_bits} bits",
            data_bits=data_bits,
            lead_bits=lead_bits,
            frame_falls=lead_bits + data_bits + tail,
        )
        await bench.begin(limits, 48.0, 1, 3)
        seen += len(await bench.conversions(12))
        # A longer code before a shorter one leaves none of its bits.
    assert seen > 30


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def start_while_busy(dut: object) -> None:
    """A start that comes too early changes nothing but overrun_o, which stays until reset."""
    bench = AdcBench(dut, random_source("overrun"))
    await bench.begin(AD7476A, 40.0, 1, 5)
    await bench.clock(start=1)
    for _ in range(32):
        await bench.clock()
    # In the quiet time after the frame: the next one doesn't begin.
    assert (bench.word("adc_cs_n_o"), bench.word("busy_o"), bench.word("overrun_o")) == (1, 1, 0)
    await bench.clock(start=1)
    for _ in range(6):
        assert (bench.word("adc_cs_n_o"), bench.word("overrun_o")) == (1, 1)
        await bench.clock()
    await bench.begin(AD7476A, 40.0, 1, 5)
    await bench.clock(start=1)
    for clock in range(1, 32 + 5):
        assert bench.word("busy_o")
        assert bench.word("overrun_o") == int(clock > 20)
        await bench.clock(start=int(clock == 20))
        if clock == 31:
            # The last bit is read in the last fall.
            assert bench.word("valid_o")
    await bench.clock()
    assert not bench.word("busy_o")
    assert [part.complete for part in bench.parts] == [1] * LINES
    words, _ = await bench.convert()
    assert words == [word_of(part.held, 12) for part in bench.parts]
    assert bench.word("overrun_o") == 1
    await bench.begin(AD7476A, 40.0, 1, 5)
    assert bench.word("overrun_o") == 0


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def reset_in_a_frame(dut: object) -> None:
    """CS and SCLK go high at once, no word comes, and the quiet time is kept all the same."""
    bench = AdcBench(dut, random_source("reset"))
    for clocks in (1, 2, 7, 20, 33):
        await bench.begin(AD7476A, 40.0, 1, 3)
        await bench.clock(start=1)
        for _ in range(clocks):
            await bench.clock()
        await bench.clock(rst=1)
        assert (bench.word("adc_cs_n_o"), bench.word("adc_sclk_o")) == (1, 1)
        bench.drive(rst=0)
        waited = 0
        while bench.word("busy_o"):
            await bench.clock()
            assert not bench.word("valid_o")
            waited += 1
        assert waited == 2
        words, _ = await bench.convert()
        assert words == [word_of(part.held, 12) for part in bench.parts]


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def rate(dut: object) -> None:
    """Clocks a conversion takes: the AD7476A reaches 1 MSPS at 36 MHz."""
    bench = AdcBench(dut, random_source("rate"))
    await bench.begin(AD7476A, 36.0, 1, 2)
    _, clocks = await bench.convert()
    assert clocks == 1 + 2 * 16 + 1
    assert clocks + 1 <= 36
    await bench.begin(AD7276, 96.0, 1, 5)
    _, clocks = await bench.convert()
    assert clocks + 1 <= math.ceil(96 / 2.6)
