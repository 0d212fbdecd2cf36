# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_sinc3.v``: words and trips equal convolutions of the bits that it has taken."""

from __future__ import annotations

import math
import random

import cocotb
import numpy as np
import pytest
from adc_part import TimingError
from bench import Bench, random_source, unpack
from modulator_part import ModulatorPart
from simulators import parameters
from wavehaptics.parts.adcs import MODULATORS, SINC_CLOCKS, SINC_PIPELINE, Frame, Modulator
from wavehaptics.words import formats

OSR = parameters().get("OSR", 32)
RISE = parameters().get("CAPTURE_RISE", 0)
TRIP_OSR = parameters().get("TRIP_OSR", 8)
LINES = parameters().get("LINES", 1)

PINS_NS = 2.0
NEVER = 0xFFFF
TOP = (1 << (formats.SAMPLE_W - 1)) - 1

SINC3 = np.convolve(np.convolve(np.ones(OSR, int), np.ones(OSR, int)), np.ones(OSR, int))
SINC2 = np.convolve(np.ones(TRIP_OSR, int), np.ones(TRIP_OSR, int))
LOG2 = math.ceil(math.log2(OSR**3))


def word_of(bits: list[int], end: int) -> int:
    """The word made of the bits up to, but not with, place ``end``; zeros stand before them."""
    ones = [2 * bit - 1 for bit in bits[max(0, end - len(SINC3)) : end]]
    total = int(np.dot(ones, SINC3[len(SINC3) - len(ones) :]))
    shift = LOG2 - (formats.SAMPLE_W - 1)
    if shift == 1:
        return total >> 1
    if shift > 1:
        half = 1 << (shift - 1)
        size = (abs(total) + half) >> shift
        total = size if total >= 0 else -size
    else:
        total <<= -shift
    return min(max(total, -TOP - 1), TOP)


def trip_level(bits: list[int], end: int) -> int:
    """Size of the fast sum of the bits up to ``end``, in the unit of the threshold."""
    ones = [2 * bit - 1 for bit in bits[max(0, end - len(SINC2)) : end]]
    total = int(np.dot(ones, SINC2[len(SINC2) - len(ones) :]))
    return abs(total) * (1 << 15) // TRIP_OSR**2


class SincBench(Bench):
    """The block with streams of bits: a modulator's, or any."""

    async def begin(
        self, sclk_half: int = 2, trip: int = NEVER, part: Modulator | None = None,
        clock_mhz: float = 80.0,
    ) -> None:  # fmt: skip
        self.half, self.period_ns = sclk_half, 1e3 / clock_mhz
        self.level = [0.0] * LINES
        self.stream: random.Random | None = None
        self.density = [0.5] * LINES
        self.parts = []
        if part is not None:
            self.parts = [ModulatorPart(part, lambda n=n: self.level[n]) for n in range(LINES)]
        self.taken: list[list[int]] = [[] for _ in range(LINES)]
        """Bits that the block has taken, seen at its own clock edge."""
        self.pin = [0] * LINES
        self.trips: list[tuple[int, list[int]]] = []
        await self.start(
            start_i=0, first_i=0, adc_sdata_i=0, sclk_half_clocks_i=sclk_half, trip_i=trip
        )
        self._sclk = self.word("adc_sclk_o")
        assert self._sclk == 0

    async def clock(self, start: int = 0, first: int = 0) -> None:
        edge = self.clocks * self.period_ns
        if self.parts:
            for n, part in enumerate(self.parts):
                part.pins(edge + PINS_NS, self._sclk)
                self.pin[n] = part.output(edge + self.period_ns - PINS_NS)
        elif self.stream is not None:
            self.pin = [int(self.stream.random() < density) for density in self.density]
        await self.step(
            start_i=start, first_i=first, adc_sdata_i=sum(b << n for n, b in enumerate(self.pin))
        )
        sclk = self.word("adc_sclk_o")
        if sclk != self._sclk and sclk == RISE:
            for n in range(LINES):
                self.taken[n].append(self.pin[n])
        self._sclk = sclk

    async def settle(self) -> None:
        clocks = 0
        while not self.word("ready_o"):
            await self.clock()
            clocks += 1
            assert clocks < 2 * (2 * TRIP_OSR + 4) * self.half
            assert not self.word("valid_o")
        assert len(self.taken[0]) == 2 * TRIP_OSR + 2

    async def words(self, count: int, firsts: list[int]) -> list[list[int]]:
        """``count`` starts, OSR bits apart; the words of each line that came, all checked."""
        got = []
        for n in range(count):
            ends = [len(bits) - 2 for bits in self.taken]
            for clock in range(OSR * 2 * self.half):
                await self.clock(start=int(clock == 0), first=firsts[n] if clock == 0 else 0)
                valid = self.word("valid_o")
                assert valid == int(clock == SINC_CLOCKS - 1 and n >= SINC_PIPELINE)
                if valid:
                    assert self.word("first_o") == firsts[n - SINC_PIPELINE]
                    words = unpack(self.word("sample_o"), formats.SAMPLE_W, LINES)
                    settled = n > SINC_PIPELINE
                    assert words == [
                        word_of(self.taken[m], ends[m]) if settled else 0 for m in range(LINES)
                    ]
                    got.append(words)
        return got


@cocotb.test(timeout_time=100, timeout_unit="ms")
@cocotb.parametrize(half=[1, 2, 3])
async def any_bits(dut: object, half: int) -> None:
    """Random streams of every density, ones only and zeros only: the convolution, to the bit."""
    bench = SincBench(dut)
    rng = random_source(f"bits {half}")
    await bench.begin(half)
    bench.stream = rng
    await bench.settle()
    seen = set()
    count = 12 if OSR < 100 else 5
    for density in (0.5, 0.9, 1.0, 0.0, 0.11):
        bench.density = [density] * LINES
        firsts = [rng.randint(0, 1) for _ in range(count)]
        if density != 0.5:
            # Starts go on; all further ones bring words.
            for _ in range(count):
                ends = [len(bits) - 2 for bits in bench.taken]
                for clock in range(OSR * 2 * half):
                    await bench.clock(start=int(clock == 0))
                    if bench.word("valid_o"):
                        words = unpack(bench.word("sample_o"), formats.SAMPLE_W, LINES)
                        assert words == [word_of(bench.taken[m], ends[m]) for m in range(LINES)]
                        seen.update(words)
        else:
            seen.update(*await bench.words(count, firsts))
        assert bench.word("overrun_o") == 0
    full = min(TOP, OSR**3 * 2 ** (15 - LOG2)) if LOG2 != 16 else OSR**3 >> 1
    assert max(seen) >= int(full) - 1
    assert min(seen) <= -int(full) + 1
    assert len(seen) > 12


@cocotb.test(timeout_time=100, timeout_unit="ms", skip=OSR > 100)
async def modulators(dut: object) -> None:
    """50 % at 0, 89.06 % at +250 mV of 320: the words are the input's, once settled."""
    bench = SincBench(dut)
    part = MODULATORS["AMC1306M25"]
    await bench.begin(2, part=part)
    unity = Frame(2, 16, 0, 16, osr=OSR).unity
    await bench.settle()
    tolerance = 3.0 / OSR**1.5
    for level in (0.0, 250 / 320, -250 / 320, 0.1, 1.2, -1.2):
        bench.level = [level] * LINES
        firsts = [0] * 12
        total = 0.0
        for n in range(12):
            for clock in range(OSR * 4):
                await bench.clock(start=int(clock == 0), first=firsts[n])
                if bench.word("valid_o") and n >= 4:
                    total += unpack(bench.word("sample_o"), formats.SAMPLE_W, LINES)[0] / 8
        wanted = min(max(level, -127 / 128), 127 / 128) * unity * (1 << 15)
        assert abs(total - wanted) < tolerance * (1 << 15), (level, total, wanted)
    ones = sum(bench.parts[0].bits[-10:])
    assert ones <= 1


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def modulator_complains(dut: object) -> None:
    """Too fast a clock and too slow a one fail; a bit taken in the access time is another."""
    bench = SincBench(dut)
    for name, clock_mhz, half, complaint in (
        ("AMC1306M25", 88.0, 2, "clock period"),
        ("AD7403", 84.0, 2, "clock period"),
        ("AMC1306M25", 40.0, 5, "clock period"),
        ("AMC1306M25", 60.0, 1, "clock (low|high)"),
    ):
        await bench.begin(half, part=MODULATORS[name], clock_mhz=clock_mhz)
        with pytest.raises(TimingError, match=f"{name}: {complaint}"):
            await bench.settle()


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def trips(dut: object) -> None:
    """The fast path equals its convolution at every bit, and its delay is the header's."""
    bench = SincBench(dut)
    rng = random_source("trips")
    for threshold in (1 << 15, (1 << 15) * 3 // 4, 1 << 14, 1):
        await bench.begin(2, trip=threshold)
        bench.stream = rng
        await bench.settle()
        changes, last = 0, None
        due: list[tuple[int, int]] = []
        taken = len(bench.taken[0])
        for _ in range(400 * 4):
            if rng.random() < 0.01:
                bench.density = [rng.choice((0.0, 0.05, 0.5, 0.95, 1.0))] * LINES
            await bench.clock()
            bits = len(bench.taken[0])
            if bits != taken:
                taken = bits
                if bits % TRIP_OSR == 0:
                    # This bit and the one before aren't in the sums that are looked at now.
                    level = trip_level(bench.taken[0], bits - 2)
                    due.append((bench.clocks + 2, int(level >= threshold)))
            while due and due[0][0] <= bench.clocks:
                last = due.pop(0)[1]
                changes += 1
            if last is not None:
                assert bench.word("trip_o") & 1 == last, (threshold, bench.clocks)
        assert changes > 1500 // (TRIP_OSR * 4)
    await bench.begin(2, trip=NEVER)
    bench.stream, bench.density = rng, [1.0] * LINES
    await bench.settle()
    for _ in range(40 * TRIP_OSR):
        await bench.clock()
        assert bench.word("trip_o") == 0


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def time_to_trip(dut: object) -> None:
    """From a step to full scale to the trip: at most 3 TRIP_OSR bits and some clocks."""
    bench = SincBench(dut)
    rng = random_source("step")
    worst = 0
    for _ in range(12):
        await bench.begin(2, trip=(1 << 15) * 9 // 10)
        bench.stream = rng
        await bench.settle()
        for _ in range(rng.randint(0, 4 * TRIP_OSR)):
            await bench.clock()
        bench.density = [1.0] * LINES
        clocks = 0
        while not bench.word("trip_o") & 1:
            await bench.clock()
            clocks += 1
            assert clocks < 1000
        worst = max(worst, clocks)
    dut._log.info("worst time to trip: %d bits of TRIP_OSR %d", worst // 4, TRIP_OSR)
    assert worst <= (3 * TRIP_OSR + 3) * 4 + 3


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def starts_out_of_step(dut: object) -> None:
    """A start that is a bit early or late is told, until reset; one before ready is nothing."""
    bench = SincBench(dut)
    rng = random_source("out of step")
    for wrong in (-1, 1):
        await bench.begin(2)
        bench.stream = rng
        await bench.clock(start=1)
        await bench.settle()
        await bench.words(4, [0] * 4)
        assert bench.word("overrun_o") == 0
        await bench.clock(start=1)
        for _ in range((OSR + wrong) * 4 - 1):
            await bench.clock()
        assert bench.word("overrun_o") == 0
        await bench.clock(start=1)
        assert bench.word("overrun_o") == 1
    await bench.begin(2)
    assert bench.word("overrun_o") == 0


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def reset_in_a_word(dut: object) -> None:
    """Nothing of before is left: the same bits give the same words again."""
    bench = SincBench(dut)
    runs = []
    for clocks in (1, OSR * 4, OSR * 6 + 1):
        await bench.begin(2)
        bench.stream = random.Random(7)
        bench.density = [0.7] * LINES
        await bench.settle()
        runs.append(await bench.words(5, [1, 0, 0, 1, 0]))
        for _ in range(clocks):
            await bench.clock(start=1)
    assert runs[1:] == runs[:1] * 2
