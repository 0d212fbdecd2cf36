# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_early.v``: every duty against integers, and those against the wave core's own.

The bench plays carrier, ADC and core: a frame begins, its word comes, the sum is there.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

import cocotb
from bench import Bench, random_source
from wavehaptics.controller import wave_core
from wavehaptics.controller.early import Early, prepare, slope_fits
from wavehaptics.controller.modulator import duty_of
from wavehaptics.controller.pins_timing import EARLY_PREPARE_CLOCKS
from wavehaptics.words import formats

DUTY_CLOCKS = 4
"""Clocks from the sum to the duty's strobe."""


@dataclass
class Tick:
    """One tick's words, by the names of ``rtl/wh_early.v``."""

    f: int
    u_n: int
    u_max: int
    root: int
    a: int
    gain: int
    clocks_per_volt: int
    eta: int
    wave: int
    total: int
    offset: int = 0
    correction: int = 0
    ends: int = 0

    def words(self) -> Early:
        return prepare(
            self.f, self.u_n, self.u_max, self.root, self.a, self.gain, self.clocks_per_volt,
            self.eta, self.wave, self.offset, self.correction,
        )  # fmt: skip

    def inputs(self) -> dict[str, int]:
        names = (
            "f", "u_n", "u_max", "root", "a", "gain", "clocks_per_volt", "eta", "wave", "offset",
            "correction",
        )  # fmt: skip
        return {f"{name}_i": getattr(self, name) for name in names}

    def duty(self) -> int:
        """The duty of its sum."""
        return self.words().duty(self.total, self.ends)


def any_tick(rng: random.Random) -> Tick:
    """Words from the whole of their ranges, the ends often."""

    def word(width: int, lowest: int | None = None) -> int:
        low = -(1 << (width - 1)) if lowest is None else lowest
        high = (1 << (width - 1)) - 1
        return rng.choice((low, high, 0, rng.randint(low, high), rng.randint(low, high) >> 12))

    data, coef = formats.DATA_W, formats.COEF_W
    return Tick(
        f=word(data), u_n=word(data), u_max=word(data, 0), root=word(coef, 0), a=word(coef, 0),
        gain=word(coef, 0), clocks_per_volt=word(coef, 0), eta=word(coef), wave=word(data),
        # A small sum as well: with large slopes it alone is within the limits.
        total=word(formats.SUM_W + 1) >> rng.choice((0, 0, 8, 16)), offset=word(data),
        correction=word(data), ends=rng.choice((0, 0, 0, 1, 2, 3)),
    )  # fmt: skip


def real_tick(rng: random.Random) -> Tick:
    """Words as a motor has them: 0.5 to 20 Ω, 5 to 48 V, ADCs of 1 to 20 A, fast carriers."""
    r_hat = 0.5 * 40.0 ** rng.random()
    root = math.sqrt(2 * r_hat)
    bus_v = rng.uniform(5.0, 48.0)
    limit = bus_v / root
    half_clocks = rng.randint(48, 480)
    samples = rng.choice((1, 1, 2, 4, 16))
    full_scale_a = rng.uniform(1.0, 20.0)
    gain_a = full_scale_a / ((1 << 15) * samples)
    u_max = formats.WAVE.to_raw(limit)
    anchored = rng.choice((0.0, 1.0))
    return Tick(
        f=rng.randint(-u_max, u_max),
        u_n=rng.randint(-u_max, u_max),
        u_max=u_max,
        root=formats.ROOT.to_raw(root),
        a=formats.A.to_raw(10.0 ** rng.uniform(-3.0, 0.0)),
        gain=formats.GAIN.to_raw(gain_a),
        clocks_per_volt=formats.DUTY.to_raw(half_clocks / (2.0 * bus_v)),
        eta=formats.ETA.to_raw(rng.choice((-1.0, 1.0, 0.0, rng.uniform(-1.0, 1.0)))),
        wave=formats.WAVE.to_raw(rng.choice((0.0, rng.uniform(-0.2, 0.2) * limit))),
        total=rng.randint(-(1 << 15), 1 << 15) * samples,
        offset=formats.CURRENT.to_raw(anchored * rng.uniform(-0.1, 0.1) * full_scale_a),
        correction=formats.VOLTAGE.to_raw(anchored * rng.uniform(-0.2, 0.2) * bus_v),
        ends=rng.choice((0, 0, 0, 1, 2, 3)),
    )


def in_turn(tick: Tick) -> tuple[int, bool]:
    """The duty that current, wave core and modulator make of it, and whether u was limited."""
    state, line = wave_core.new_state(), wave_core.new_line(0)
    state[wave_core.STATE_F] = tick.f << formats.STATE_GUARD
    state[wave_core.STATE_FILLED] = 1
    line[0] = tick.u_n
    product = tick.total * tick.gain
    shift = formats.GAIN.fraction - formats.CURRENT.fraction
    current = (abs(product) + (1 << (shift - 1))) >> shift
    current = wave_core.saturate.py_func((current if product >= 0 else -current) - tick.offset)
    voltage, *_ = wave_core.wave_core_step(
        state, line, current, tick.eta, tick.wave, tick.root, tick.a, tick.u_max, 0, 0,
        tick.ends,
    )  # fmt: skip
    limited = bool(state[wave_core.STATE_SATURATED])
    voltage = wave_core.saturate.py_func(int(voltage) + tick.correction)
    return duty_of.py_func(voltage, tick.clocks_per_volt), limited


class EarlyBench(Bench):
    """Plays ticks of one or more words."""

    async def begin(self) -> None:
        names = Tick(*[0] * 10).inputs()
        await self.start(
            frame_i=0, word_valid_i=0, word_first_i=0, samples_i=1, busy_i=0, sum_valid_i=0,
            sum_i=0, sum_ends_i=0, **names,
        )  # fmt: skip
        assert self.word("duty_valid_o") == 0
        assert self.signed("eta_o") == self.signed("wave_o") == 0

    async def tick(
        self, tick: Tick, samples: int = 1, busy_clocks: int = 0, spare: int = 0
    ) -> int | None:
        """Frames and words of one tick; its duty, or None where no strobe came.

        ``busy_clocks`` pass after the last frame's start before the state is settled, and
        ``spare`` clocks more than needed before the sum.
        """
        self.drive(samples_i=samples)
        for n in range(samples - 1):
            await self.step(frame_i=1)
            await self.step(3, frame_i=0)
            await self.step(word_valid_i=1, word_first_i=int(n == 0))
            await self.step(word_valid_i=0)
        # Before the state is settled its words are some others'.
        noise = {name: ~value for name, value in tick.inputs().items()}
        if busy_clocks:
            await self.step(frame_i=1, busy_i=1, **noise)
            await self.step(busy_clocks, frame_i=0)
            await self.step(busy_i=0, **tick.inputs())
        else:
            await self.step(frame_i=1, busy_i=0, **tick.inputs())
        taken = {name: noise[name] for name in ("eta_i", "wave_i", "offset_i", "correction_i")}
        self.drive(frame_i=0, **taken)
        # These four are kept; eta and the wave for the core as well.
        assert self.signed("eta_o") == tick.eta
        assert self.signed("wave_o") == tick.wave
        await self.step(EARLY_PREPARE_CLOCKS - 2 + spare)
        await self.step(word_valid_i=1, word_first_i=int(samples == 1))
        await self.step(word_valid_i=0, sum_valid_i=1, sum_i=tick.total, sum_ends_i=tick.ends)
        # The multiplier of the current isn't free at once: the sum stays.
        await self.step(2)
        self.drive(sum_valid_i=0, sum_i=~tick.total)
        for clock in range(3, DUTY_CLOCKS + 8):
            if self.word("duty_valid_o"):
                assert clock == DUTY_CLOCKS
                return self.signed("duty_o")
            await self.step()
        return None


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def equals_the_integers(dut: object) -> None:
    bench, rng = EarlyBench(dut), random_source("early")
    await bench.begin()
    kinds, ends = set(), set()
    for n in range(600):
        tick = any_tick(rng) if n % 3 else real_tick(rng)
        words = tick.words()
        expected = tick.duty()
        limits = {words.low: -2, words.high: 2}
        kinds.add(limits.get(expected, (expected > 0) - (expected < 0)))
        ends.add((tick.ends, words.back, expected == words.still, words.low < words.still))
        samples, busy = rng.choice((1, 1, 2, 5)), rng.choice((0, 0, 1, 2, 9))
        duty = await bench.tick(tick, samples, busy, spare=rng.choice((0, 0, 1, 7)))
        assert duty == expected, (tick, duty, expected)
    assert kinds >= {-2, -1, 1, 2}
    for back in (False, True):
        # The side that is known, and the other, within limits that leave both.
        assert {(end, back, held, True) for end in (1, 2) for held in (False, True)} <= ends
        assert (3, back, True, True) in ends
    assert bench.word("overrun_o") == 0


@cocotb.test()
async def is_what_the_core_makes_in_turn(_dut: object) -> None:
    """With a motor's numbers the two ways differ by less than a part in 10⁵ of the pulse."""
    rng = random_source("in turn")
    limited = refused = 0
    for _ in range(3000):
        tick = real_tick(rng)
        if not slope_fits(tick.root, tick.gain, tick.clocks_per_volt):
            refused += 1
            continue
        words = tick.words()
        duty, saturated = in_turn(tick)
        limited += saturated
        assert abs(tick.duty() - duty) <= 8 + 1e-5 * (words.high - words.low), tick
    assert limited > 100
    assert refused < 600


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_sum_that_comes_too_soon_is_told(dut: object) -> None:
    bench, rng = EarlyBench(dut), random_source("too soon")
    await bench.begin()
    assert await bench.tick(real_tick(rng), spare=-1) is None
    assert bench.word("overrun_o") == 1
    await bench.step(20)
    tick = real_tick(rng)
    assert await bench.tick(tick) == tick.duty()
    assert bench.word("overrun_o") == 1
    await bench.step(rst=1)
    await bench.step(rst=0)
    assert bench.word("overrun_o") == 0


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_sum_without_a_frame_makes_nothing(dut: object) -> None:
    """So it is for the first tick after an enable in mid-conversion."""
    bench = EarlyBench(dut)
    await bench.begin()
    await bench.step(sum_valid_i=1, sum_i=1000)
    for _ in range(10):
        await bench.step(sum_valid_i=0)
        assert bench.word("duty_valid_o") == 0
    assert bench.word("overrun_o") == 0
