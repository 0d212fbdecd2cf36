# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_guard.v``: the latch against its equation, each cause at its limits."""

from __future__ import annotations

import random

import cocotb
from bench import CLOCK_NS, Bench, pack, random_source
from cocotb.triggers import Timer
from lost_encoder import LostEncoder
from simulators import parameters
from wavehaptics.controller.guard import DAMPABLE, FIELDS, HEAT_SQUARES, Fault
from wavehaptics.controller.guard import pack as settings
from wavehaptics.words import formats

N = parameters().get("N", 1)
LAST = N - 1
TOP = (1 << 16) - 1
MASK_TOP = FIELDS["MASK"].fixed.raw_max
LEVELS = 0b11  # a pin that is high is a fault

# Limits that nothing reaches, but for the faults of the test.
CALM = {
    "LEVELS": LEVELS, "CURRENT": TOP, "RANGE": TOP, "STUCK": TOP, "ZERO": TOP, "ZERO_TICKS": TOP,
    "LOST": TOP, "LOST_TICKS": TOP, "HOST": (1 << 24) - 1, "BUS_MIN": 0, "BUS_MAX": TOP,
    "HEAT_TICKS": 1, "HEAT": (1 << 32) - 1, "ENERGY": 1,
}  # fmt: skip

# Causes at an input, by turns: its value at fault, and clocks until the fault shows.
LEVEL_CAUSES = {
    Fault.ADC_STUCK: ("stuck_i", 1 << LAST, 1),
    Fault.ADC_RANGE: ("range_i", 1 << LAST, 1),
    Fault.ZERO: ("zero_i", 1 << LAST, 1),
    Fault.TRIP: ("trip_i", 1 << LAST, 1),
    Fault.ENCODER: ("encoder_i", 1 << LAST, 1),
    Fault.DRIVER: ("driver_i", 1 << LAST, 3),
    Fault.STOP: ("stop_i", 1, 3),
    Fault.SETTING: ("setting_i", 1, 1),
    Fault.OVERRUN: ("overrun_i", 1, 1),
    Fault.ANCHOR: ("anchor_i", 1 << LAST, 1),
    Fault.ENERGY: ("energy_i", 1 << LAST, 1),
    Fault.OVERSPEED: ("overspeed_i", 1, 1),
    Fault.WINDOW: ("outside_i", 1, 1),
}


class GuardBench(Bench):
    """Plays everything around the guard; a word is the last motor's."""

    async def begin(
        self, mask: int = MASK_TOP, damp: int = 0, running_i: int = 1, **limits: int
    ) -> None:
        fields = {**CALM, "MASK": mask, "DAMP": damp, **limits}
        await self.start(
            settings_i=settings(fields), clear_i=0, running_i=running_i, stop_i=0, driver_i=0,
            host_alive_i=0, bus_i=100, sample_valid_i=0, sample_i=0, trip_i=0, encoder_i=0,
            range_i=0, stuck_i=0, zero_i=0, zero_start_i=0, zero_busy_i=0,
            moved_i=0, direction_i=0, anchor_i=0, energy_i=0, saturated_i=0, overspeed_i=0,
            outside_i=0, setting_i=0, overrun_i=0, tick_i=0, valid_i=0, current_i=0, u_i=0, v_i=0,
        )  # fmt: skip
        await self.step(3)
        assert self.faults() == (0, 0, 0)

    def faults(self) -> tuple[int, int, int]:
        return self.word("faults_o"), self.word("off_o"), self.word("damp_o")

    async def clear(self) -> None:
        await self.step(clear_i=1)
        await self.step(clear_i=0)

    async def sample(self, word: int) -> int:
        """A sample, and two clocks for its judgement; the faults."""
        others = [self.clocks % 1000] * LAST  # converters with noise
        await self.step(sample_valid_i=1, sample_i=pack([*others, word], formats.SAMPLE_W))
        await self.step(1, sample_valid_i=0)
        await self.step(1)
        return self.word("faults_o")

    async def tick(
        self, current: int = 0, u: int = 0, v: int = 0, moved: int = 0, saturated: int = 0
    ) -> int:
        """A tick of 24 clocks with words of 16 bits, the highest of the data words; the faults."""
        shift = formats.DATA_W - 16
        words = {
            name: pack([0] * LAST + [word << shift], formats.DATA_W)
            for name, word in (("current_i", current), ("u_i", u), ("v_i", v))
        }
        bits = {"moved_i": moved << LAST, "saturated_i": saturated << LAST}
        await self.step(tick_i=1, valid_i=1, **bits, **words)
        await self.step(23, tick_i=0, valid_i=0, moved_i=0)
        return self.word("faults_o")


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def latches_until_cleared(dut: object) -> None:
    """Each level: its bit and no other, after its clocks; it stays; clear forgets what is over."""
    bench = GuardBench(dut)
    for fault, (name, value, clocks) in LEVEL_CAUSES.items():
        await bench.begin()
        bench.drive(**{name: value})
        for _ in range(clocks - 1):
            await bench.step()
            assert bench.faults() == (0, 0, 0)
        await bench.step()
        assert bench.faults() == (1 << fault, 1, 0)
        await bench.clear()
        assert bench.word("faults_o") == 1 << fault, "what is still the case stays"
        await bench.step(5, **{name: 0})
        assert bench.faults() == (1 << fault, 1, 0)
        await bench.clear()
        assert bench.faults() == (0, 0, 0)
        # Left out by the mask, it is none; reset forgets, too.
        await bench.begin(mask=MASK_TOP & ~(1 << fault))
        await bench.step(4, **{name: value})
        assert bench.faults() == (0, 0, 0)
        await bench.begin()
        await bench.step(4, **{name: value})
        await bench.step(1, rst=1)
        assert bench.faults() == (0, 0, 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def off_or_damp(dut: object) -> None:
    """Random causes, masks and wishes: the equation, and damping only where it is allowed."""
    bench = GuardBench(dut)
    rng = random_source("off or damp")
    direct = [fault for fault, (_, _, clocks) in LEVEL_CAUSES.items() if clocks == 1]
    seen = set()
    for _ in range(40):
        mask = rng.randint(0, MASK_TOP)
        damp = rng.choice((0, MASK_TOP, DAMPABLE, rng.randint(0, MASK_TOP)))
        await bench.begin(mask=mask, damp=damp)
        latched = 0
        for _ in range(30):
            on = [fault for fault in direct if rng.random() < 0.05]
            clear = int(rng.random() < 0.2)
            inputs = {LEVEL_CAUSES[f][0]: LEVEL_CAUSES[f][1] if f in on else 0 for f in direct}
            await bench.step(clear_i=clear, **inputs)
            latched = (0 if clear else latched) | sum(1 << fault for fault in on) & mask
            off = int(latched & ~(damp & DAMPABLE) != 0)
            assert bench.faults() == (latched, off, int(latched != 0 and not off))
            seen.add(bench.faults()[1:])
    assert seen == {(0, 0), (1, 0), (0, 1)}


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def limits_of_samples(dut: object) -> None:
    """Samples just within and just beyond, both signs and the most negative; a stuck converter."""
    bench = GuardBench(dut)
    for fault, limit in ((Fault.CURRENT, "CURRENT"), (Fault.ADC_RANGE, "RANGE")):
        for sign in (1, -1):
            await bench.begin(**{limit: 20_000})
            assert await bench.sample(sign * 20_000) == 0
            assert await bench.sample(sign * 20_001) == 1 << fault
        await bench.begin(**{limit: 32_767})
        assert await bench.sample(32_767) == 0
        assert await bench.sample(-32_768) == 1 << fault
    await bench.begin(STUCK=5)
    for word in (1, 1, 1, 1, 2, 7, 7, 7, 7):
        assert await bench.sample(word) == 0
    assert await bench.sample(7) == 1 << Fault.ADC_STUCK
    # The largest number of equal samples, one a clock; their count doesn't begin anew.
    await bench.begin(STUCK=TOP)
    await bench.step(sample_valid_i=1, sample_i=pack([9] * N, formats.SAMPLE_W))
    await Timer(CLOCK_NS * (TOP - 100), "ns")
    await bench.step(1)
    assert bench.word("faults_o") == 0
    await bench.step(100)
    assert bench.word("faults_o") == 1 << Fault.ADC_STUCK
    await bench.step(2)
    await bench.clear()
    assert bench.word("faults_o") == 1 << Fault.ADC_STUCK


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def limits_of_any_value(dut: object) -> None:
    """Each bit of a limit decides somewhere: what reaches it is no fault, one more is."""
    bench = GuardBench(dut)
    rng = random_source("limits")
    for n in range(48):
        width = 1 + n % 16
        limit = rng.getrandbits(width) | 1 << (width - 1)
        await bench.begin()
        bench.drive(settings_i=settings({**CALM, "MASK": MASK_TOP, "BUS_MAX": limit}), bus_i=limit)
        await bench.step(2)
        assert bench.faults()[0] == 0
        await bench.step(2, bus_i=min(TOP, limit + 1))
        assert bench.faults()[0] == (limit < TOP) << Fault.BUS_HIGH
        await bench.begin()
        bench.drive(settings_i=settings({**CALM, "MASK": MASK_TOP, "BUS_MIN": limit}), bus_i=limit)
        await bench.step(2)
        assert bench.faults()[0] == 0
        await bench.step(2, bus_i=limit - 1)
        assert bench.faults()[0] == 1 << Fault.BUS_LOW
        # The other motors' samples are noise of up to 1000.
        if limit > 32_766 or (LAST and limit < 1000):
            continue
        sign = rng.choice((1, -1))
        for fault, field in ((Fault.CURRENT, "CURRENT"), (Fault.ADC_RANGE, "RANGE")):
            await bench.begin(**{field: limit})
            assert await bench.sample(sign * limit) == 0
            assert await bench.sample(sign * (limit + 1)) == 1 << fault
        await bench.begin(running_i=0, ZERO=limit, ZERO_TICKS=0)
        assert await bench.tick(sign * limit) == 0
        assert await bench.tick(sign * (limit + 1)) == 1 << Fault.ZERO


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_judgement_stands_until_the_next(dut: object) -> None:
    """Cleared in any clock between two samples or ticks, the fault stays; after a good one it goes.

    Nothing is judged before the first sample.
    """
    bench = GuardBench(dut)
    for fault, limits in (
        (Fault.CURRENT, {"CURRENT": 20_000}),
        (Fault.ADC_RANGE, {"RANGE": 20_000}),
        (Fault.ADC_STUCK, {"STUCK": 3}),
        (Fault.ZERO, {"ZERO": 50, "ZERO_TICKS": 2}),
    ):
        await bench.begin(running_i=0, **limits)

        async def word(bad: bool, fault: Fault = fault) -> int:
            if fault == Fault.ZERO:
                return await bench.tick(-51 if bad else 50)
            return await bench.sample(-20_001 if bad else bench.clocks % 1000)

        assert bench.faults() == (0, 0, 0)
        for _ in range(3):
            faults = await word(True)
        assert faults == 1 << fault
        for gap in range(12):
            await bench.step(gap)
            bench.drive(clear_i=1)
            await bench.step()
            assert bench.faults() == (1 << fault, 1, 0), (fault, gap)
            await bench.step(clear_i=0)
            assert bench.faults() == (1 << fault, 1, 0), (fault, gap)
        assert await word(False) == 1 << fault, "over, but not cleared"
        await bench.clear()
        assert bench.faults() == (0, 0, 0)
    # With no sample yet the lowest limits are none; nor is the last of an off bridge one that runs.
    await bench.begin(CURRENT=0, RANGE=0, STUCK=0, ZERO=0)
    await bench.step(5)
    assert bench.faults() == (0, 0, 0)
    await bench.begin(mask=MASK_TOP & ~(1 << Fault.ZERO), running_i=0, ZERO=50, ZERO_TICKS=0)
    await bench.tick(51)
    await bench.step(3, running_i=1, settings_i=settings({**CALM, "MASK": MASK_TOP, "ZERO": 50}))
    assert bench.faults() == (0, 0, 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def what_comes_with_the_clear_is_kept(dut: object) -> None:
    """A cause of one clock, in the clock of a clear, is latched; the next clear forgets it."""
    bench = GuardBench(dut)
    for fault, (name, value, clocks) in LEVEL_CAUSES.items():
        await bench.begin()
        await bench.step(**{name: value})
        await bench.step(clocks - 1, **{name: 0})
        await bench.step(2)
        assert bench.faults() == (1 << fault, 1, 0)
        await bench.clear()
        assert bench.faults() == (0, 0, 0)
        for at in range(clocks):
            await bench.step(**{name: value}, clear_i=int(at == 0))
            for clock in range(1, clocks):
                await bench.step(**{name: 0}, clear_i=int(at == clock))
            bench.drive(**{name: 0}, clear_i=0)
            await bench.step(2)
            assert bench.faults() == (1 << fault, 1, 0), (fault, at)
            await bench.clear()
            assert bench.faults() == (0, 0, 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_limit_of_0_for_the_energy_is_no_check(dut: object) -> None:
    """Any other counts, whichever of its bits it has."""
    bench = GuardBench(dut)
    for bit in range(-1, FIELDS["ENERGY"].fixed.width):
        await bench.begin(ENERGY=0 if bit < 0 else 1 << bit)
        await bench.step(3, energy_i=1 << LAST)
        assert bench.faults()[0] == (bit >= 0) << Fault.ENERGY


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def limits_of_the_rest(dut: object) -> None:
    """The bus, the host, and the current of a bridge that is off."""
    bench = GuardBench(dut)
    await bench.begin(BUS_MIN=100, BUS_MAX=200)
    for bus, fault in ((200, 0), (201, 1 << Fault.BUS_HIGH), (99, 1 << Fault.BUS_LOW)):
        await bench.step(2, bus_i=bus)
        await bench.step(2, bus_i=100)
        assert bench.word("faults_o") == fault
        await bench.clear()
    await bench.begin(HOST=7)
    for _ in range(3):
        for _ in range(6):
            assert await bench.tick() == 0
        await bench.step(host_alive_i=1)
        bench.drive(host_alive_i=0)
    for _ in range(6):
        assert await bench.tick() == 0
    assert await bench.tick() == 1 << Fault.HOST
    for sign in (1, -1):
        await bench.begin(ZERO=50, ZERO_TICKS=4)
        assert await bench.tick(sign * 3000) == 0, "the bridge is on"
        bench.drive(running_i=0)
        for _ in range(3):
            assert await bench.tick(sign * 3000) == 0, "the current is still dying away"
        assert await bench.tick(sign * 50) == 0
        assert await bench.tick(sign * 51) == 1 << Fault.ZERO


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_zero_that_is_measured_anew(dut: object) -> None:
    """Its start forgets ZERO alone; until it counts, no current is judged by the old one."""
    bench = GuardBench(dut)
    zero, other = 1 << Fault.ZERO, 1 << Fault.TRIP
    await bench.begin(running_i=0, ZERO=50, ZERO_TICKS=0)
    bench.drive(zero_i=1)
    await bench.step(trip_i=1)
    await bench.step(trip_i=0)
    assert bench.word("faults_o") == zero | other
    await bench.step(zero_start_i=1)
    await bench.step(zero_start_i=0, zero_i=0)
    assert bench.word("faults_o") == other
    # Neither while it is measured, nor in the tick that had begun with the old one.
    await bench.begin(running_i=0, ZERO=50, ZERO_TICKS=0)
    assert await bench.tick(60) == zero
    await bench.step(zero_start_i=1)
    await bench.step(zero_start_i=0, zero_busy_i=1)
    for _ in range(4):
        assert await bench.tick(60) == 0
    bench.drive(zero_busy_i=0)
    assert await bench.tick(60) == 0
    assert await bench.tick(50) == 0
    assert await bench.tick(-51) == zero
    # A zero that is none is a fault as soon as that is known.
    await bench.step(zero_start_i=1)
    await bench.step(2, zero_start_i=0, zero_busy_i=1)
    await bench.step(zero_busy_i=0, zero_i=1 << LAST)
    assert bench.word("faults_o") == zero
    await bench.clear()
    assert bench.word("faults_o") == zero


def warmer(total: int, current: int) -> int:
    """The sum behind the winding's heat after one more square."""
    return total + current * current - total // HEAT_SQUARES


def barely_too_hot(rng: random.Random) -> tuple[list[int], int]:
    """Currents, and a limit that their heat passes with the last one, by a few units of its sum.

    So each bit of the sum decides.
    """
    while True:
        currents = [rng.randint(-32_768, 32_767) for _ in range(8)]
        total = 0
        for current in currents:
            total = warmer(total, current)
        for last in range(20_000, 32_768):
            heat, rest = divmod(warmer(total, last), HEAT_SQUARES)
            if rest < 4:
                return [*currents, last], heat - 1


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def heat(dut: object) -> None:
    """The winding's heat is the integer model's, with the fault where it passes the limit."""
    bench = GuardBench(dut)
    rng = random_source("heat")
    currents = [
        rng.choice((0, 500, -3000, -32_768, 32_767, rng.randint(-32_768, 32_767)))
        for _ in range(60)
    ]
    sums, total = [], 0
    for current in currents:
        total = warmer(total, current)
        sums.append(total // HEAT_SQUARES)
    for at, every in ((10, 1), (40, 1), (59, 1), (40, 0)):  # 0 is as 1
        await bench.begin(HEAT=sums[at] - 1 if sums[at] else 0, HEAT_TICKS=every)
        first = next(n for n, heat in enumerate(sums) if heat > max(0, sums[at] - 1))
        for n, current in enumerate(currents):
            assert await bench.tick(current) == (n >= first) << Fault.HEAT, n
    for _ in range(4):
        currents, limit = barely_too_hot(rng)
        await bench.begin(HEAT=limit)
        shown = [await bench.tick(current) for current in currents]
        assert shown == [0] * (len(currents) - 1) + [1 << Fault.HEAT], currents
    await bench.begin(HEAT_TICKS=3, HEAT=0)
    shown = [await bench.tick(300 if n % 3 else 0) for n in range(30)]
    assert not any(shown), "one square in three ticks, all of them of 0 A"


class Swings:
    """The law of SATURATED in integers: turns back at the limit, in a row."""

    def __init__(self, most: int) -> None:
        self.most = most
        self.newest = self.way = self.row = self.since = 0

    def tick(self, moved: int, direction: int, saturated: int, running: int) -> bool:
        turned = moved and direction == self.newest and direction != self.way
        if moved:
            self.way = direction if direction == self.newest else self.way
            self.newest = direction
        if not running:
            self.row = self.since = 0
        elif turned:
            self.row = min(16, self.row + 1) if saturated else 0
            self.since = 0
        elif self.since >= self.most:
            self.row = 0
        else:
            self.since += 1
        return self.most > 0 and self.row == 16


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_rotor_that_swings_at_the_limit(dut: object) -> None:
    """Random swings, of one count too, with gaps, misses of the limit and stops: as integers."""
    bench = GuardBench(dut)
    rng = random_source("saturated")
    found = {False: 0, True: 0}
    for trial in range(24):
        most = rng.choice((0, 3, 6, 9, TOP))
        misses, stops = rng.choice((0.0, 0.03)), rng.choice((0.0, 0.01))
        longest = rng.choice((2, 2, 4))
        await bench.begin(SATURATED=most)
        law, told = Swings(most), False
        ticks: list[int] = []  # of the present swing: whether a count comes
        direction = trial % 2
        for _ in range(150):
            if not ticks:
                direction ^= 1
                ticks = [1] * rng.choice((1, 2, 2, 2, 2, 2, 3)) + [0] * rng.randint(0, longest)
            moved, saturated = ticks.pop(0), int(rng.random() >= misses)
            running = int(rng.random() >= stops)
            bench.drive(running_i=running, direction_i=direction << LAST)
            faults = await bench.tick(moved=moved, saturated=saturated)
            told |= law.tick(moved, direction, saturated, running)
            assert faults == told << Fault.SATURATED, (most, law.row, law.since)
        found[told] += 1
    assert min(found.values()) >= 5, found
    # The time is exact, whichever of its bits it has: one tick more, and the row begins anew.
    for bit in range(7):
        await bench.begin(SATURATED=1 << bit)
        for ticks, fault in (((1 << bit) + 2, 0), ((1 << bit) + 1, 1 << Fault.SATURATED)):
            for swing in range(17):
                bench.drive(direction_i=(swing % 2) << LAST)
                for moved in [1, 1, *[0] * (ticks - 2)]:
                    await bench.tick(moved=moved, saturated=1)
            assert bench.word("faults_o") == fault, (bit, ticks)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def encoder_that_stands_still(dut: object) -> None:
    """u + v over its limit for long enough, either way; counts, a stop or a calm motor reset it."""
    bench = GuardBench(dut)
    for sign in (1, -1):
        await bench.begin(LOST=100, LOST_TICKS=50)
        ticks = 0
        while not await bench.tick(u=sign * 300, v=sign * 300):
            ticks += 1
            assert ticks < 200
        # A sixth of 256 ticks' mean, and then fifty.
        assert 50 < ticks < 110
        assert bench.word("faults_o") == 1 << Fault.LOST
    for words, running, moves in (((300, 300), 1, 1), ((300, -300), 1, 0), ((300, 300), 0, 0)):
        await bench.begin(LOST=100, LOST_TICKS=50)
        bench.drive(running_i=running)
        for n in range(300):
            assert not await bench.tick(u=words[0], v=words[1], moved=moves * (n % 40 == 0))


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def still_is_counted_as_in_integers(dut: object) -> None:
    """Any waves, limits and moves: the fault in the very tick in which integers have it."""
    bench = GuardBench(dut)
    rng = random_source("still")
    shift = formats.DATA_W - 16
    found = 0
    for _ in range(40):
        size = rng.randint(4, 15)
        # Mostly one way, so that it lasts; and anything at all.
        waves = []
        for _tick in range(60):
            wave = rng.choice((1, 1, 1, -1)) * rng.randint(0, (1 << size) - 1)
            other = rng.choice((wave, -wave, rng.randint(-(1 << 15), (1 << 15) - 1)))
            waves.append((wave, other))
        # A limit that the mean has just reached in one of them: the last bit decides.
        endless, means = LostEncoder(0, 0), []
        for u, v in waves:
            means.append(abs(endless.turning))
            endless.tick(u, v)
        limit = min(rng.choice(means), 65_535)
        enough = rng.choice((1, rng.randint(1, 30)))
        await bench.begin(LOST=limit, LOST_TICKS=enough)
        model = LostEncoder(limit, enough)
        for u, v in waves:
            moved = rng.random() < 0.02
            words = {
                name: pack([0] * LAST + [word << shift], formats.DATA_W)
                for name, word in (("u_i", u), ("v_i", v))
            }
            await bench.step(tick_i=1, valid_i=1, moved_i=moved << LAST, **words)
            await bench.step(tick_i=0, valid_i=0, moved_i=0)
            model.tick(u, v, moved=moved)
            await bench.step(2)
            assert bench.word("faults_o") == model.lost << Fault.LOST
        found += model.lost
    assert 5 < found < 35
