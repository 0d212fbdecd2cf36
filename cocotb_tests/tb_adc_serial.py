# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_adc_serial.v``, wired to models of its parts in real time."""

from __future__ import annotations

import dataclasses
import random

import cocotb
import pytest
from adc_part import AD7276, AD7476A, AdcPart, TimingError
from bench import Bench, random_source, unpack
from simulators import parameters
from wavehaptics.parts.adcs import PARTS, Frame, Part, frame
from wavehaptics.words import formats

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

    def _code(self, part: int) -> int:
        if self.codes is not None:
            return self.codes[part]
        top = (1 << self.part.bits) - 1
        corners = (0, top, 1 << (self.part.bits - 1))
        return self.rng.choice(corners + (self.rng.randint(0, top),) * 3)

    async def begin(
        self, part: Part, clock_mhz: float, made: Frame | None = None, **settings: int
    ) -> None:
        """Reset with the part's frame, or another; ``settings`` override single inputs."""
        self.part, self.frame = part, made or frame(part, 1e6 * clock_mhz)
        self.period_ns = 1e3 / clock_mhz
        self.parts = [AdcPart(part, lambda n=n: self._code(n)) for n in range(LINES)]
        inputs = {f"{name}_i": word for name, word in self.frame.words().items()}
        await self.start(start_i=0, first_i=0, adc_sdata_i=0, **(inputs | settings))
        # The quiet time passes after a reset as well, and then the frame that calibrates.
        while self.word("busy_o"):
            await self.clock()
            assert not self.word("valid_o")

    async def clock(self, start: int = 0, **inputs: int) -> None:
        """One clock: the parts see the pins, then the block sees their outputs."""
        edge = self.clocks * self.period_ns
        levels = self.word("adc_cs_n_o"), self.word("adc_sclk_o")
        sdata = 0
        for n, part in enumerate(self.parts):
            part.pins(edge + PINS_NS, *levels)
            sdata |= part.sdata(edge + self.period_ns - PINS_NS) << n
        await self.step(start_i=start, adc_sdata_i=sdata, **inputs)

    async def convert(self, first: int = 0) -> tuple[list[int], int]:
        """Words of one conversion and the clocks from the start strobe until the next may come."""
        await self.clock(start=1, first_i=first)
        clocks = 1
        while not self.word("valid_o"):
            assert self.word("busy_o")
            await self.clock(first_i=1 - first)
            clocks += 1
            assert clocks < 1000
        assert clocks == self.frame.conversion_clocks
        assert self.word("first_o") == first
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
        seen = set()
        for _ in range(count):
            words, clocks = await self.convert(self.rng.randint(0, 1))
            assert clocks == self.frame.cycle_clocks
            for part, word in zip(self.parts, words, strict=True):
                assert word == word_of(part.held, self.part.bits)
                seen.add(word)
        await self.clock()
        assert [part.complete for part in self.parts] == [count] * LINES
        assert self.word("overrun_o") == 0
        return seen

    async def convert_twice(self, part: Part, clock_mhz: float, made: Frame) -> None:
        """Set up and use at full speed."""
        await self.begin(part, clock_mhz, made)
        await self.conversions(2)


SERIAL_PARTS = [
    # part, clock in MHz, samples a second that it must reach there
    ("AD7476A", 36.0, 1e6),
    ("AD7476A", 48.0, 0.7e6),
    ("AD7476A", 80.0, 1e6),
    ("AD7276", 30.0, 1e6),
    ("AD7276", 48.0, 1.6e6),
    ("AD7276", 96.0, 3e6),
    ("AD7277", 96.0, 3e6),
    ("AD7278", 96.0, 3e6),
    ("ADS7042", 64.0, 1e6),
    ("ADS7046", 96.0, 2.5e6),
    ("ADS7046", 120.0, 3e6),
    ("ADS7052", 48.0, 1e6),
    ("ADS7052", 96.0, 1e6),
    ("ADS7056", 96.0, 2e6),
    ("ADS7056", 120.0, 2.5e6),
]


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(which=list(range(len(SERIAL_PARTS))))
async def parts_within_their_limits(dut: object, which: int) -> None:
    """Every code arrives as the part held it, no limit of the part is broken, at the full rate."""
    name, clock_mhz, rate_hz = SERIAL_PARTS[which]
    part = PARTS[name]
    bench = AdcBench(dut, random_source(f"{name} {clock_mhz:g}"))
    await bench.begin(part, clock_mhz)
    assert 1e6 * clock_mhz / bench.frame.cycle_clocks >= rate_hz * (1 - 1e-9)
    seen = await bench.conversions(40)
    assert len(seen) > 10
    assert {word_of(0, part.bits), word_of((1 << part.bits) - 1, part.bits), 0} <= seen


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_frame_as_slow_as_it_gets(dut: object) -> None:
    """Waits of any length before, behind and between frames, and a slow SCLK."""
    bench = AdcBench(dut, random_source("slow"))
    good = frame(PARTS["AD7276"], 96e6)
    for waits in (
        {"setup_clocks": 37, "hold_clocks": 41, "quiet_clocks": 90},
        {"setup_clocks": 130, "hold_clocks": 200, "quiet_clocks": 255},
        {"setup_clocks": 255, "sclk_half_clocks": 19},
    ):
        await bench.begin(PARTS["AD7276"], 96.0, dataclasses.replace(good, **waits))
        await bench.conversions(2)


def test_clocks(part: Part) -> float:
    """A clock in MHz of which SCLK is a half, at the part's limit."""
    return 2 * part.sclk_hz / 1e6


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(name=[name for name, part in PARTS.items() if part.kind == "serial"])
async def each_part_complains(dut: object, name: str) -> None:
    """A clock a tenth too fast, too little acquisition, set-up or CS high fail for each part."""
    part = PARTS[name]
    rng = random_source(f"{name} complains")
    clock_mhz = test_clocks(part)
    good = frame(part, 1e6 * clock_mhz)
    assert good.sclk_half_clocks == 1
    bench = AdcBench(dut, rng)
    await bench.begin(part, clock_mhz, good)
    await bench.conversions(3)
    waits = dataclasses.replace(good, quiet_clocks=good.quiet_clocks + 40)
    short = dataclasses.replace(good, quiet_clocks=1)
    slow = dataclasses.replace(part, acquire_s=0.0, rate_hz=1e9, cs_high_s=0.0)
    late = 1.1e9 * good.setup_clocks / (1e6 * clock_mhz)
    for judge, made, mhz, complaint in (
        (part, waits, 1.1 * clock_mhz, "SCLK"),
        (dataclasses.replace(part, setup_s=late * 1e-9), waits, clock_mhz, "CS to SCLK"),
        (dataclasses.replace(part, rate_hz=1e9, acquire_s=part.acquire_s + 200e-9, quiet_s=0.0),
         good, clock_mhz, "acquisition"),
        (dataclasses.replace(slow, cs_high_s=60e-9, quiet_s=0.0), short, clock_mhz, "CS high"),
        (dataclasses.replace(slow, quiet_s=150e-9), short, clock_mhz, "quiet time"),
        (dataclasses.replace(slow, rate_hz=part.rate_hz / 2, quiet_s=0.0), good, clock_mhz,
         "cycle"),
        (dataclasses.replace(part, hold_s=60e-9), waits, clock_mhz, "last edge to CS"),
    ):  # fmt: skip
        with pytest.raises(TimingError, match=rf"{name}: {complaint}"):
            await bench.convert_twice(judge, mhz, made)


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(name=[name for name, part in PARTS.items() if part.kind == "serial"])
async def too_slow_an_output(dut: object, name: str) -> None:
    """An output that isn't there yet when the next bit is launched is read wrong."""
    part = PARTS[name]
    slow = dataclasses.replace(part, access_s=1 / part.sclk_hz)
    bench = AdcBench(dut, random_source("slow output"))
    await bench.begin(slow, test_clocks(part), frame(part, 1e6 * test_clocks(part)))
    code = 0x15A5 & ((1 << part.bits) - 1)
    bench.codes = [code] * LINES
    words, _ = await bench.convert()
    assert words != [word_of(code, part.bits)] * LINES


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def offset_calibration(dut: object) -> None:
    """Without its long first frame an ADS7056 is off; a frame too short spoils the next code."""
    part = PARTS["ADS7056"]
    bench = AdcBench(dut, random_source("calibration"))
    bench.codes = [0x1234] * LINES
    await bench.begin(part, 96.0)
    assert [p.calibrated for p in bench.parts] == [True] * LINES
    assert [p.complete for p in bench.parts] == [0] * LINES
    assert (await bench.convert())[0] == [word_of(0x1234, 14)] * LINES
    await bench.begin(part, 96.0, calibrate_bits_i=0)
    assert (await bench.convert())[0] != [word_of(0x1234, 14)] * LINES
    await bench.begin(part, 96.0, calibrate_bits_i=23)
    assert (await bench.convert())[0] != [word_of(0x1234, 14)] * LINES
    await bench.begin(part, 96.0, quiet_clocks_i=20)
    bench.drive(frame_bits_i=17)
    await bench.convert()
    bench.drive(frame_bits_i=18)
    assert (await bench.convert())[0] != [word_of(0x1234, 14)] * LINES
    assert (await bench.convert())[0] == [word_of(0x1234, 14)] * LINES


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def not_ready(dut: object) -> None:
    """A start before the part has been calibrated is no overrun and starts nothing."""
    part = PARTS["ADS7052"]
    bench = AdcBench(dut, random_source("not ready"))
    bench.codes = [5] * LINES
    await bench.begin(part, 48.0)
    bench.parts = [AdcPart(part, lambda: 5) for _ in range(LINES)]
    await bench.clock(rst=1)
    bench.drive(rst=0)
    clocks = 0
    while not bench.word("ready_o"):
        await bench.clock(start=1)
        clocks += 1
        assert clocks < 100
    assert clocks > 2 * 24
    for _ in range(20):
        await bench.clock()
    assert [p.calibrated for p in bench.parts] == [True] * LINES
    assert bench.word("overrun_o") == 0
    await bench.conversions(2)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def wrong_frames(dut: object) -> None:
    """A frame too short for the part doesn't complete; zeros counted wrong shift the word."""
    bench = AdcBench(dut, random_source("wrong frames"))
    made = frame(AD7476A, 40e6)
    await bench.begin(AD7476A, 40.0, dataclasses.replace(made, frame_bits=15, data_bits=11))
    bench.codes = [0x2A5] * LINES
    await bench.convert()
    await bench.clock()
    assert all((part.aborted, part.complete) == (1, 0) for part in bench.parts)
    await bench.begin(AD7476A, 40.0, dataclasses.replace(made, lead_bits=3))
    words, _ = await bench.convert()
    assert words == [word_of(0x2A5 >> 1, 12)] * LINES


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def every_resolution(dut: object) -> None:
    """1 to 16 bits, with and without zeros in front, both levels and edges, a longer frame."""
    bench = AdcBench(dut, random_source("resolutions"))
    seen = 0
    for data_bits, lead_bits, tail in ((1, 0, 0), (8, 2, 4), (10, 2, 2), (14, 1, 3), (16, 0, 0)):
        for idle, trailing in ((1, 0), (1, 1), (0, 0), (0, 1)):
            part = dataclasses.replace(
                AD7276,
                name=f"{data_bits} bits",
                bits=data_bits,
                lead_bits=lead_bits,
                frame_bits=lead_bits + data_bits + tail,
                idle=idle,
                launch_trailing=bool(trailing),
                read_trailing=bool(trailing),
                track_edge=1,
            )
            await bench.begin(part, 48.0)
            # A longer code before a shorter one leaves none of its bits.
            seen += len(await bench.conversions(6))
    assert seen > 60


EASY = dataclasses.replace(AD7476A, rate_hz=1e9, acquire_s=0.0, quiet_s=0.0)
"""A part that doesn't mind being used again at once."""


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def start_while_busy(dut: object) -> None:
    """A start that comes too early changes nothing but overrun_o, which stays until reset."""
    made = dataclasses.replace(frame(EASY, 40e6), quiet_clocks=5)
    bench = AdcBench(dut, random_source("overrun"))
    await bench.begin(EASY, 40.0, made)
    await bench.clock(start=1)
    for _ in range(32):
        await bench.clock()
    # In the quiet time after the frame: the next one doesn't begin.
    assert (bench.word("adc_cs_n_o"), bench.word("busy_o"), bench.word("overrun_o")) == (1, 1, 0)
    await bench.clock(start=1)
    for _ in range(6):
        assert (bench.word("adc_cs_n_o"), bench.word("overrun_o")) == (1, 1)
        await bench.clock()
    await bench.begin(EASY, 40.0, made)
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
    await bench.begin(EASY, 40.0, made)
    assert bench.word("overrun_o") == 0


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def reset_in_a_frame(dut: object) -> None:
    """CS and SCLK go high at once, no word comes, and the quiet time is kept all the same."""
    made = dataclasses.replace(frame(EASY, 40e6), quiet_clocks=3)
    bench = AdcBench(dut, random_source("reset"))
    for clocks in (1, 2, 7, 20, 33):
        await bench.begin(EASY, 40.0, made)
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
