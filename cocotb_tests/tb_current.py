# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_current.v``: its words are :func:`wavehaptics.motor.sensor.scale_sum`'s."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source
from wavehaptics.motor.sensor import scale_sum
from wavehaptics.words import formats

LATENCY = 6
MULTIPLY_CLOCKS = 3
SAMPLE_MIN, SAMPLE_MAX = -(1 << (formats.SAMPLE_W - 1)), (1 << (formats.SAMPLE_W - 1)) - 1
SUM_MIN, SUM_MAX = -(1 << (formats.SUM_W - 1)), (1 << (formats.SUM_W - 1)) - 1


class CurrentBench(Bench):
    """Feeds sums of samples and plays the shared multiplier."""

    gain = 0
    range_word = 0xFFFF

    async def begin(self) -> None:
        await self.start(
            valid_i=0,
            first_i=0,
            sample_i=0,
            samples_i=1,
            range_i=self.range_word,
            zero_i=0,
            grant_i=0,
            done_i=0,
            product_i=0,
            offset_i=0,
        )

    async def word_of(
        self, samples: list[int], zero: int, gain: int, grant_after: int = 0, gap: int = 0
    ) -> int:
        """Current word of a tick; the multiplier is granted ``grant_after`` clocks late."""
        self.drive(samples_i=len(samples), zero_i=zero)
        for place, sample in enumerate(samples):
            assert self.word("request_o") == 0
            await self.step(valid_i=1, first_i=int(place == 0), sample_i=sample)
            if place + 1 < len(samples):
                await self.step(gap, valid_i=0, first_i=0)
        clocks = 1
        self.drive(valid_i=0, first_i=0)
        for _ in range(grant_after):
            assert self.word("request_o") == 1
            await self.step()
        assert self.word("request_o") == 1
        factor = self.signed("factor_o")
        assert factor == sum(samples) - zero
        await self.step(grant_i=1)
        self.drive(grant_i=0)
        clocks += 1
        assert self.word("request_o") == 0
        await self.step(MULTIPLY_CLOCKS - 1)
        clocks += MULTIPLY_CLOCKS - 1
        await self.step(done_i=1, product_i=factor * gain)
        # A product that belongs to another user follows.
        self.drive(done_i=0, product_i=0x155555555555555)
        clocks += 1
        assert self.word("valid_o") == 0
        await self.step()
        clocks += 1
        assert clocks == LATENCY
        assert self.word("valid_o") == 1
        word = self.signed("current_o")
        assert word == scale_sum.py_func(factor, gain)
        ends = self.ends_of(samples)
        if word in (formats.CURRENT.raw_max, formats.CURRENT.raw_min):
            # One unit of the gain is less than half a place: a word there may be just there.
            beyond = abs(factor * gain) / 2.0 ** (formats.GAIN.fraction - formats.CURRENT.fraction)
            if beyond > abs(word) + 0.5:
                ends |= formats.AT_HIGH if word > 0 else formats.AT_LOW
        assert self.word("ends_o") == ends
        await self.step()
        assert self.word("valid_o") == 0
        assert self.signed("current_o") == word
        assert self.word("ends_o") == ends
        return word

    def ends_of(self, samples: list[int]) -> int:
        """Which ends of the range the samples reach."""
        high = max(samples) >= self.range_word
        low = min(samples) <= -self.range_word
        return high * formats.AT_HIGH | low * formats.AT_LOW


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def corners(dut: object) -> None:
    """Most negative and most positive samples, zeros and gains; halves; saturation."""
    bench = CurrentBench(dut)
    await bench.begin()
    gains = [0, 1, 1 << 10, (1 << 10) - 1, formats.GAIN.raw_max, formats.GAIN.raw_min, -1]
    words = set()
    for sample in (SAMPLE_MIN, -1, 0, 1, SAMPLE_MAX):
        for zero in (SUM_MIN, -1, 0, 1, SUM_MAX):
            for gain in gains:
                words.add(await bench.word_of([sample], zero, gain))
    assert {formats.CURRENT.raw_min, formats.CURRENT.raw_max, 0, 1, -1} <= words


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def full_sums(dut: object) -> None:
    """256 samples at either end of their range don't wrap, with the zero at the other end."""
    bench = CurrentBench(dut)
    await bench.begin()
    for sample, zero in ((SAMPLE_MIN, SUM_MAX), (SAMPLE_MAX, SUM_MIN)):
        word = await bench.word_of([sample] * 256, zero, 3)
        assert (word < 0) == (sample < 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def random_ticks(dut: object) -> None:
    """Random ticks with gaps and late grants equal the model."""
    bench = CurrentBench(dut)
    rng = random_source("ticks")
    await bench.begin()
    words = set()
    for _ in range(300):
        samples = [rng.randint(SAMPLE_MIN, SAMPLE_MAX) for _ in range(rng.choice((1, 1, 2, 3, 8)))]
        gain = rng.randint(formats.GAIN.raw_min, formats.GAIN.raw_max) >> rng.randint(0, 26)
        word = await bench.word_of(
            samples, rng.randint(-2000, 2000), gain, rng.randint(0, 5), rng.randint(0, 2)
        )
        words.add(word)
    assert len(words) > 100


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def ends_of_the_range(dut: object) -> None:
    """One word at an end of the range, wherever in the sum, and beside it; both ends in a sum."""
    bench = CurrentBench(dut)
    rng = random_source("ends")
    seen = set()
    for bits in (8, 12, 16):
        bench.range_word = SAMPLE_MAX + 1 - (1 << (formats.SAMPLE_W - bits))
        await bench.begin()
        end = bench.range_word
        for count in (1, 2, 5):
            for ends in ([end], [end - 1], [-end], [1 - end], [SAMPLE_MIN], [end, -end], []):
                samples = [rng.randint(-100, 100) for _ in range(count)]
                for place, word in zip(rng.sample(range(count), count), ends, strict=False):
                    samples[place] = word
                await bench.word_of(samples, rng.randint(-9, 9), 77, grant_after=rng.randint(0, 3))
                seen.add(bench.ends_of(samples))
    assert seen == {0, formats.AT_HIGH, formats.AT_LOW, formats.AT_HIGH | formats.AT_LOW}


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def first_begins_anew(dut: object) -> None:
    """A sum that was cut short leaves nothing behind, neither does a reset in mid-sum."""
    bench = CurrentBench(dut)
    await bench.begin()
    await bench.step(valid_i=1, first_i=1, sample_i=1000, samples_i=3)
    await bench.step(valid_i=1, first_i=0, sample_i=1000)
    assert await bench.word_of([5, 6, 7], 0, 1 << 11) == 18
    await bench.step(valid_i=1, first_i=1, sample_i=1000, samples_i=2)
    await bench.begin()
    assert await bench.word_of([1, 2], 0, 1 << 11) == 3
