# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_three_phase.v``: six gates in every clock, from the voltages of three legs."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

import cocotb
import numpy as np
from bench import Bench, pack, random_source, unpack
from simulators import parameters
from tb_modulator import Model, clocks_per_volt
from wavehaptics.controller.modulator import (
    dead_time_extra,
    duty_of,
    new_dead_time,
    width_bounds,
)
from wavehaptics.controller.pins_timing import GATE_CLOCKS
from wavehaptics.words import formats
from wavehaptics.words.bridge_modes import HALF_BRIDGE

MIN_PULSE = parameters().get("MIN_PULSE", 0)
DEAD_TIME = parameters().get("DEAD_TIME", 1)
MULTIPLY_CLOCKS = 3
PACE = 3
SETTLE_MOST = 255 - 2 * PACE
"""Ticks that each leg waits longer between two changes of side than the one before it."""
CURRENT_AT = 1
"""Clock of a tick with its currents: they count at its first end of a period."""
LEAST, MOST = formats.VOLTAGE.raw_min, formats.VOLTAGE.raw_max
Legs = tuple[int, int, int]


@dataclass
class Drive:
    """Settings of a run."""

    half_clocks: int
    bus_v: float = 24.0
    tick_halves: int = 2
    dead_clocks: int = 0
    min_pulse: int = 0
    second_order: bool = False
    compensate: bool = False
    side_current: int = 0
    settle_ticks: int = 0

    @property
    def per_volt(self) -> int:
        """Of a leg, which reaches half the bus either way."""
        return clocks_per_volt(self.half_clocks, self.bus_v / 2)

    @property
    def tick_clocks(self) -> int:
        return self.half_clocks * self.tick_halves

    def model(self) -> Model:
        least, spare = width_bounds(HALF_BRIDGE, self.min_pulse if MIN_PULSE else 0)
        return Model(self.half_clocks, self.second_order, least, spare)

    def extra(self, n: int, state: np.ndarray, current: int) -> int:
        """What leg ``n`` is longer by from a tick's current on."""
        if not (DEAD_TIME and self.compensate):
            return 0
        settle = min(self.settle_ticks, SETTLE_MOST) + PACE * n
        return dead_time_extra.py_func(state, current, self.dead_clocks, self.side_current, settle)

    def period(self, width: int) -> list[int]:
        """A leg's levels in a period of the carrier: high around its end."""
        half = self.half_clocks
        first = half // 2 + width
        last = half - half // 2 + width
        return [1] * first + [0] * (2 * half - first - last) + [1] * last


def gates_of(levels: list[int], dead: int) -> list[tuple[int, int]]:
    """The gates of a leg after a reset, low: on once its level has stood for the dead time."""
    gates, stood, before = [], -1, 0
    for level in levels:
        stood = stood + 1 if level == before else 0
        before = level
        gates.append((level, 1 - level) if stood >= dead else (0, 0))
    return gates


class ThreePhaseBench(Bench):
    """Plays the carrier and the shared multiplier; compares all six gates in every clock."""

    async def begin(self, drive: Drive) -> None:
        await self.start(
            enable_i=1, half_clocks_i=drive.half_clocks, phase_i=0, remaining_i=0, half_i=0,
            update_i=0, take_i=0, clocks_per_volt_i=drive.per_volt, min_pulse_i=drive.min_pulse,
            dead_clocks_i=drive.dead_clocks, second_order_i=int(drive.second_order), valid_i=0,
            compensate_i=int(drive.compensate), side_current_i=drive.side_current,
            settle_ticks_i=drive.settle_ticks, current_valid_i=0, currents_i=0, legs_i=0,
            grant_i=0, done_i=0, product_i=0,
        )  # fmt: skip

    def gates(self) -> tuple[int, int]:
        return self.word("gate_high_o"), self.word("gate_low_o")

    async def run(
        self, drive: Drive, ticks: list[Legs | None], at: int = 0, wait: int = 0,
        currents: Sequence[Legs] = (),
    ) -> list[list[int]]:  # fmt: skip
        """Run ticks with the legs' voltages, or none, ``at`` a clock of each; grants are late.

        ``currents`` are those of the ticks.

        Returns the widths of each leg, a period each.
        """
        await self.begin(drive)
        models = [drive.model() for _ in range(3)]
        dead_times = [new_dead_time() for _ in range(3)]
        pending, active, extra = [0, 0, 0], [0, 0, 0], [0, 0, 0]
        widths: list[list[int]] = [[0], [0], [0]]
        shown: list[tuple[int, int]] = []
        queue: list[int] = []
        in_work: list[tuple[int, int, int]] = []
        half, clock, waits, legs = drive.half_clocks, 0, 0, (0, 0, 0)
        for tick, given in enumerate(ticks):
            for in_tick in range(drive.tick_clocks):
                phase, parity = in_tick % half, in_tick // half % 2
                valid = given is not None and in_tick == at
                if given is not None and valid:
                    legs, queue, waits = given, [0, 1, 2], wait
                    self.drive(legs_i=pack(legs, formats.DATA_W))
                measured = tick < len(currents) and in_tick == CURRENT_AT
                if measured:
                    self.drive(currents_i=pack(currents[tick], formats.DATA_W))
                    for n in range(3):
                        extra[n] = drive.extra(n, dead_times[n], currents[tick][n])
                grant = queue[0] if queue and waits == 0 else None
                done = in_work[0] if in_work and in_work[0][0] == clock else None
                take = in_tick == drive.tick_clocks - 5
                await self.settle(
                    phase_i=phase, remaining_i=half - 1 - phase, half_i=parity,
                    update_i=int(phase == half - 1), take_i=int(take), valid_i=int(valid),
                    current_valid_i=7 * measured,
                    grant_i=0 if grant is None else 1 << grant,
                    done_i=0 if done is None else 1 << done[1],
                    product_i=0x2AAAAAAAAAAAAAA if done is None else done[2],
                )  # fmt: skip
                assert self.word("request_o") == sum(1 << user for user in queue)
                if grant is not None:
                    factor = unpack(self.word("factor_o"), formats.DATA_W, 3)[grant]
                    assert factor == legs[grant]
                    coefficient = unpack(self.word("coefficient_o"), formats.COEF_W, 3)[grant]
                    assert coefficient == drive.per_volt
                    in_work.append((clock + MULTIPLY_CLOCKS, grant, factor * coefficient))
                    queue.pop(0)
                    waits = wait
                elif queue:
                    waits -= 1
                if take:
                    active = [*pending]
                if phase == half - 1 and parity:
                    for n in range(3):
                        widths[n].append(models[n].width(active[n], extra[n]))
                if done is not None:
                    # A product shows as the pending duty one clock later.
                    pending[done[1]] = duty_of.py_func(1, in_work.pop(0)[2])
                await self.step()
                clock += 1
                shown.append(self.gates())
        for n in range(3):
            levels = [level for width in widths[n] for level in drive.period(width)]
            # Low in reset, and late by the way to the gates: its last clock is this one's first.
            expected = gates_of([0] * (GATE_CLOCKS - 1) + levels, drive.dead_clocks)
            for now, (high, low) in enumerate(shown):
                found = high >> n & 1, low >> n & 1
                assert found != (1, 1)
                assert found == expected[now], (n, now, found, expected[now])
        if MIN_PULSE and drive.min_pulse:
            for n in range(3):
                for width in widths[n]:
                    assert abs(width) <= half // 2 - (drive.min_pulse + 1) // 2
        return widths


def random_legs(rng: random.Random, drive: Drive) -> Legs:
    """Legs within the bus mostly, and now and then far beyond it."""
    reach = round(0.6 * drive.bus_v / formats.VOLTAGE.step)
    if rng.random() < 0.1:
        reach = MOST
    a, b, c = (max(LEAST, min(MOST, rng.randint(-reach, reach))) for _ in range(3))
    return a, b, c


def random_currents(rng: random.Random) -> Legs:
    """Currents that sum up to zero, often so small that they have no side."""
    size = 1 << rng.choice((8, 14, 18, 28))
    a, b = rng.randint(-size, size), rng.randint(-size, size)
    return a, b, -a - b


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def random_voltages(dut: object) -> None:
    """Random voltages, carriers, dead times and late grants: every gate in every clock."""
    bench = ThreePhaseBench(dut)
    rng = random_source("three phases")
    seen = set()
    for half in (6, 7, 26, 25, 48):
        for dead in (0, 1, 3):
            drive = Drive(
                half, rng.choice((12.0, 24.0, 48.0)), rng.choice((2, 4)), dead,
                rng.choice((0, 2, 4)) if half > 20 else 0, rng.random() < 0.5,
                rng.random() < 0.7, rng.choice((0, 1000, 40_000)), rng.randint(0, 3),
            )  # fmt: skip
            latest = drive.tick_clocks - 5 - MULTIPLY_CLOCKS - 4
            ticks = [
                random_legs(rng, drive) if rng.random() < 0.9 and latest >= 0 else None
                for _ in range(20)
            ]
            wait = rng.randint(0, 2) if latest > 8 else 0
            at = rng.randint(0, max(0, latest - 3 * wait))
            currents = [random_currents(rng) for _ in ticks]
            widths = await bench.run(drive, ticks, at, wait, currents)
            seen |= {width for leg in widths for width in leg}
    assert {-24, 24} <= seen
    assert len(seen) > 30
    # Words of a bus of any size, of which no leg is to lose a bit.
    for _ in range(6):
        drive = Drive(rng.choice((26, 48)), 10 ** rng.uniform(-1.2, 0.5))
        await bench.run(drive, [random_legs(rng, drive) for _ in range(20)])


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def mean_is_the_voltage(dut: object) -> None:
    """Far below a clock: between two legs, the mean of the periods is what was asked for."""
    bench = ThreePhaseBench(dut)
    drive = Drive(25)
    volts = (0.777, -0.2345, -0.5001)
    legs = tuple(formats.VOLTAGE.to_raw(v) for v in volts)
    widths = await bench.run(drive, [legs] * 120, at=3)
    for n in range(3):
        mean = sum(widths[n][2:]) / len(widths[n][2:]) * drive.bus_v / drive.half_clocks
        clock_v = drive.bus_v / drive.half_clocks
        assert abs(mean - volts[n]) <= clock_v / len(widths[n][2:])
    assert all(len(set(widths[n][2:])) == 2 for n in range(3))


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def equal_legs_switch_together(dut: object) -> None:
    """At 0 V all three are high, or all low, in every clock: the winding sees no carrier."""
    bench = ThreePhaseBench(dut)
    drive = Drive(26)
    await bench.run(drive, [(0, 0, 0)] * 3)
    for clock in range(200):
        phase = clock % 26
        await bench.step(
            phase_i=phase, remaining_i=25 - phase, half_i=clock // 26 % 2,
            update_i=int(phase == 25), take_i=0,
        )  # fmt: skip
        assert bench.gates() in ((7, 0), (0, 7))


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def legs_without_a_side_try_apart(dut: object) -> None:
    """No current at all: the three legs are soon at different sides, which drives the winding."""
    if not DEAD_TIME:
        return
    bench = ThreePhaseBench(dut)
    drive = Drive(26, dead_clocks=4, compensate=True, side_current=1000, settle_ticks=4)
    ticks = 120
    widths = await bench.run(drive, [(0, 0, 0)] * ticks, currents=[(0, 0, 0)] * ticks)
    sides = {tuple(width[n] > 0 for width in widths) for n in range(2, ticks)}
    assert len(sides) == 8


@cocotb.test(timeout_time=20, timeout_unit="ms", skip=not DEAD_TIME)
async def the_longest_settling(dut: object) -> None:
    """No leg changes its side any sooner, and later legs still wait for longer than the first."""
    bench = ThreePhaseBench(dut)
    for settle in (SETTLE_MOST, SETTLE_MOST + 1, 255):
        drive = Drive(13, dead_clocks=2, compensate=True, side_current=1000, settle_ticks=settle)
        ticks = 2 * 255 + 20
        widths = await bench.run(drive, [(0, 0, 0)] * ticks, currents=[(0, 0, 0)] * ticks)
        changes = [[at for at in range(1, len(leg)) if leg[at] * leg[at - 1] < 0] for leg in widths]
        assert all(1 <= len(at) <= 3 for at in changes), (settle, changes)
        apart = [at[-1] - at[0] for at in changes if len(at) > 1]
        assert apart == sorted(set(apart)), (settle, changes)
        assert min(apart) >= SETTLE_MOST


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def off_in_any_clock(dut: object) -> None:
    """Reset, and enable_i = 0, in every clock of a period: six gates off, and dead time after."""
    bench = ThreePhaseBench(dut)
    drive = Drive(8, dead_clocks=2)
    for name, off, on in (("rst", 1, 0), ("enable_i", 0, 1)):
        for clock in range(17):
            await bench.begin(drive)
            for now in range(clock + 40):
                phase = now % 8
                bench.drive(
                    phase_i=phase, remaining_i=7 - phase, half_i=now // 8 % 2,
                    update_i=int(phase == 7), take_i=0,
                )  # fmt: skip
                await bench.step(**{name: off if clock + 20 <= now < clock + 23 else on})
                high, low = bench.gates()
                assert high & low == 0
                if clock + 20 <= now < clock + 23 + drive.dead_clocks:
                    assert (high, low) == (0, 0)
                if now == clock + 19 and clock % 8 == 4:
                    assert high | low == 7
            assert high | low == 7 or clock % 8 != 4
