# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_modulator.v``: the widths of every half against integers."""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from itertools import accumulate

import cocotb
from bench import Bench, random_source
from simulators import parameters
from wavehaptics.controller.modulator import duty_of, half_width, new_modulator
from wavehaptics.words import formats

FRACTION = formats.DUTY.fraction
STEP = 1 << FRACTION
EXTRA_SHIFT = FRACTION - formats.EXTRA.fraction
MULTIPLY_CLOCKS = 3
MIN_PULSE = parameters().get("MIN_PULSE", 0)
LATENCY = 4
"""Clocks from the voltage to where take_i finds its duty, if the multiplier is free."""


class Model:
    """One half after another; counts those that were clipped."""

    def __init__(
        self, half_clocks: int, second_order: bool = False, least: int = 0, spare: int = 0
    ) -> None:
        self.half_clocks, self.second_order = half_clocks, second_order
        self.least, self.spare = least, spare
        self.clipped = 0
        self._state = new_modulator()

    def width(self, duty: int, extra: int = 0) -> int:
        """Width of a half with the duty in 1/65536 clock; the rest is carried over."""
        rest, older = (int(word) for word in self._state)
        total = duty + (extra << EXTRA_SHIFT) + (2 * rest - older if self.second_order else rest)
        width = half_width.py_func(
            self._state, duty, extra, self.half_clocks, self.second_order, self.least, self.spare
        )
        self.clipped += abs(total - width * STEP) > (self.least + 1) * STEP // 2
        return width


@dataclass
class Tick:
    """What happens in a tick: a voltage at a clock, or none, and how long the grant takes."""

    voltage: int | None = None
    at: int = 0
    grant_after: int = 0
    extra: int | None = None


@dataclass
class Shown:
    """Widths at each half's end, for the half after it, and the duties that they came from."""

    widths: list[int] = field(default_factory=list)
    duties: list[int] = field(default_factory=list)
    clipped: int = 0


class ModulatorBench(Bench):
    """Plays carrier, wave core and multiplier; checks every half's width."""

    async def run(
        self, half_clocks: int, tick_halves: int, clocks_per_volt: int, ticks: list[Tick],
        second_order: bool = False, least: int = 0, spare: int = 0,
    ) -> Shown:  # fmt: skip
        await self.start(
            valid_i=0, voltage_i=0, clocks_per_volt_i=clocks_per_volt, half_clocks_i=half_clocks,
            grant_i=0, done_i=0, product_i=0, take_i=0, update_i=0,
            second_order_i=int(second_order), extra_i=0, least_i=least, spare_i=spare,
        )  # fmt: skip
        if not MIN_PULSE:
            least = spare = 0
        model, shown = Model(half_clocks, second_order, least, spare), Shown()
        pending = active = extra = 0
        tick_clocks = half_clocks * tick_halves
        wait = -1
        in_work: list[tuple[int, int]] = []
        clock = 0
        for tick in ticks:
            if tick.extra is not None:
                extra = tick.extra
                self.drive(extra_i=extra)
            for in_tick in range(tick_clocks):
                clock += 1
                valid = tick.voltage is not None and in_tick == tick.at
                if valid:
                    self.drive(voltage_i=tick.voltage)
                    wait = tick.grant_after
                grant = wait == 0
                done = bool(in_work) and in_work[0][0] == clock
                take = in_tick == tick_clocks - 5
                update = in_tick % half_clocks == half_clocks - 1
                product = in_work[0][1] if done else 0x2AAAAAAAAAAAAAA
                await self.settle(
                    valid_i=int(valid), grant_i=int(grant), done_i=int(done),
                    product_i=product, take_i=int(take), update_i=int(update),
                )  # fmt: skip
                assert self.word("request_o") == int(wait >= 0)
                if grant:
                    assert self.signed("factor_o") == tick.voltage
                    assert self.signed("coefficient_o") == clocks_per_volt
                    in_work.append((clock + MULTIPLY_CLOCKS, tick.voltage * clocks_per_volt))
                wait -= 1 if wait >= 0 else 0
                if take:
                    active = pending
                if update:
                    expected = model.width(active, extra)
                    width = self.signed("width_o")
                    assert width == expected, (in_tick, width, expected)
                    shown.widths.append(width)
                    shown.duties.append(active + (extra << EXTRA_SHIFT))
                await self.step()
                # A product shows as the pending duty one clock later.
                if done:
                    pending = duty_of.py_func(1, in_work.pop(0)[1])
        shown.clipped = model.clipped
        return shown


def every_tick(voltages: list[int], at: int = 0) -> list[Tick]:
    return [Tick(voltage, at) for voltage in voltages]


def clocks_per_volt(half_clocks: int, bus_v: float) -> int:
    return formats.DUTY.to_raw(half_clocks / (2 * bus_v))


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def mean_is_kept(dut: object) -> None:
    """Duties far below a clock: the sum of the widths stays within half a clock of the duties'."""
    bench = ModulatorBench(dut)
    for fraction in (1, 333, STEP // 2, STEP // 2 + 1, STEP - 1):
        for sign in (1, -1):
            # With one clock a volt, the duty in 1/65536 clock is the voltage in 1/65536 V.
            voltage = sign * (3 * STEP + fraction) << (formats.VOLTAGE.fraction - FRACTION)
            shown = await bench.run(24, 1, STEP, every_tick([voltage] * 50, at=4))
            error = 0
            for width, duty in zip(shown.widths, shown.duties, strict=True):
                error += duty - width * STEP
                assert abs(error) <= STEP // 2
            assert set(shown.widths[1:]) <= {0, sign * 3, sign * 4}
            assert shown.clipped == 0


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def random_voltages(dut: object) -> None:
    """Random voltages, halves a tick, late grants and silent ticks: widths equal the model's."""
    bench = ModulatorBench(dut)
    rng = random_source("voltages")
    widths, clipped = set(), 0
    for _ in range(8):
        half_clocks, tick_halves = rng.choice((6, 7, 24, 37, 48)), rng.choice((1, 2, 3))
        gain = clocks_per_volt(half_clocks, rng.choice((12.0, 24.0, 48.0)))
        ticks = [random_tick(rng, half_clocks * tick_halves) for _ in range(60)]
        second_order = rng.random() < 0.5
        shown = await bench.run(half_clocks, tick_halves, gain, ticks, second_order)
        error = 0
        if not shown.clipped:
            for width, duty in zip(shown.widths, shown.duties, strict=True):
                error += duty - width * STEP
                assert abs(error) <= (STEP if second_order else STEP // 2)
        widths |= set(shown.widths)
        clipped += shown.clipped
    assert len(widths) > 20
    assert clipped > 20


def random_tick(rng: random.Random, tick_clocks: int) -> Tick:
    # A voltage comes when the one before is done with the multiplier, as ticks have it.
    latest = tick_clocks - 1 - LATENCY - 3
    extra = rng.choice((None, 0, rng.randint(-(1 << 15), 1 << 15) >> rng.choice((0, 5, 9))))
    if rng.random() < 0.1 or latest < 0:
        return Tick(extra=extra)
    voltage = rng.randint(formats.VOLTAGE.raw_min, formats.VOLTAGE.raw_max)
    shift = rng.choice((0, 3, 4, 6, 12))
    return Tick(voltage >> shift, rng.randint(0, latest), rng.randint(0, 3), extra)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def no_pulse_is_too_short(dut: object) -> None:
    """Random voltages and shortest widths: none between, the mean kept; off without MIN_PULSE."""
    bench = ModulatorBench(dut)
    rng = random_source("shortest")
    short = stretched = 0
    for least, spare, half_clocks, count in (
        (2, 0, 24, 60), (7, 4, 40, 60), (5, 3, 49, 60), (70, 100, 340, 12), (255, 128, 1100, 6),
    ):  # fmt: skip
        for second_order in (False, True):
            limit = half_clocks // 2 - spare
            top = min(127 * STEP, rng.choice((least * STEP // 3, 2 * least * STEP)))
            # One clock a volt, as above; a tick is a half.
            voltages = [
                rng.randint(-top, top) << (formats.VOLTAGE.fraction - FRACTION)
                for _ in range(count)
            ]
            voltages += [formats.VOLTAGE.raw_max, formats.VOLTAGE.raw_min]
            ticks = [
                Tick(voltage, extra=rng.randint(-1, 1) * rng.randint(0, 1 << 10))
                for voltage in voltages
            ]
            shown = await bench.run(half_clocks, 1, STEP, ticks, second_order, least, spare)
            sizes = {abs(width) for width in shown.widths}
            if not MIN_PULSE:
                short += any(0 < size < least for size in sizes)
                continue
            assert not any(0 < size < least for size in sizes)
            assert max(sizes) <= limit
            stretched += least in sizes
            error, bound = 0, (least + 1) * STEP // 2
            for width, duty in zip(shown.widths, shown.duties, strict=True):
                if abs(width) == limit:
                    break
                error += duty - width * STEP
                assert abs(error) <= bound * (2 if second_order else 1)
    assert (stretched if MIN_PULSE else short) >= 4


@cocotb.test(timeout_time=20, timeout_unit="ms", skip=not MIN_PULSE)
async def where_no_pulse_fits_there_is_none(dut: object) -> None:
    """Legs that have to stay for longer than half a half: no width, whatever is asked for."""
    bench = ModulatorBench(dut)
    low, high = formats.VOLTAGE.raw_min, formats.VOLTAGE.raw_max
    for half_clocks, least, spare in (
        (48, 100, 50), (48, 0, 24), (48, 0, 25), (49, 255, 128), (6, 4, 3), (7, 0, 4),
    ):  # fmt: skip
        for second_order in (False, True):
            ticks = [Tick(voltage, extra=extra) for voltage in (0, low, high, 1 << 20, 0)
                     for extra in (0, 1 << 13, -(1 << 13))]  # fmt: skip
            shown = await bench.run(half_clocks, 1, STEP, ticks, second_order, least, spare)
            assert shown.widths == [0] * len(ticks), (half_clocks, least, spare)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def order_of_the_feedback(dut: object) -> None:
    """A constant duty: the error's sum, or with order 2 the sum of its sums, stays bounded."""
    bench = ModulatorBench(dut)
    voltage = (3 * STEP + 12345) << (formats.VOLTAGE.fraction - FRACTION)
    patterns = []
    for second_order in (False, True):
        shown = await bench.run(24, 1, STEP, every_tick([voltage] * 200), second_order)
        errors = [d - w * STEP for w, d in zip(shown.widths, shown.duties, strict=True)]
        once = list(accumulate(errors))
        twice = list(accumulate(once))
        assert max(map(abs, once)) <= (STEP if second_order else STEP // 2)
        assert (max(map(abs, twice)) <= STEP // 2) == second_order
        patterns.append(shown.widths)
    assert patterns[0] != patterns[1]


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def odd_in_the_voltage(dut: object) -> None:
    """The negated voltages give the negated widths, exact halves included."""
    bench = ModulatorBench(dut)
    rng = random_source("signs")
    voltages = [rng.randint(0, 1 << 27) for _ in range(60)]
    voltages += [(1 << formats.VOLTAGE.fraction) // 2 * n for n in range(9)]
    gain = STEP
    shown = await bench.run(24, 2, gain, every_tick(voltages))
    mirror = await bench.run(24, 2, gain, every_tick([-voltage for voltage in voltages]))
    assert mirror.widths == [-width for width in shown.widths]
    assert any(shown.widths)
    # A duty that lacks half a last place to half a clock is cut to less, so its width is 0.
    voltage = STEP // 2 - 1 << (formats.VOLTAGE.fraction - FRACTION)
    voltage += 1 << (formats.VOLTAGE.fraction - FRACTION - 1)
    for sign in (1, -1):
        assert (await bench.run(24, 1, gain, [Tick(sign * voltage)])).widths == [0]


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def clips_and_forgets(dut: object) -> None:
    """Beyond the half a width is clipped at once, both signs, and nothing is owed afterwards."""
    bench = ModulatorBench(dut)
    low, high = formats.VOLTAGE.raw_min, formats.VOLTAGE.raw_max
    for half_clocks in (24, 25):
        gain = clocks_per_volt(half_clocks, 12.0)
        voltages = [low, low, 0, 0, high, high, high, 0, 0, low, high, 0, 0]
        shown = await bench.run(half_clocks, 1, gain, every_tick(voltages, at=2))
        limit = half_clocks // 2
        signs = [-1, -1, 0, 0, 1, 1, 1, 0, 0, -1, 1, 0, 0]
        assert shown.widths == [sign * limit for sign in signs]
    # Each bit of a half's clocks.
    for half_clocks in (341, 682):
        gain = clocks_per_volt(half_clocks, 12.0)
        shown = await bench.run(half_clocks, 1, gain, every_tick([low, high, 0], at=2))
        assert shown.widths == [-(half_clocks // 2), half_clocks // 2, 0]
    # The largest gain and the largest voltage: the product fits.
    shown = await bench.run(48, 1, formats.DUTY.raw_max, every_tick([low, high, low, low]))
    assert shown.widths == [-24, 24, -24, -24]


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def latency(dut: object) -> None:
    """A voltage LATENCY clocks before take_i makes the next tick, one a clock later doesn't."""
    bench = ModulatorBench(dut)
    half_clocks, tick_halves = 24, 2
    take = half_clocks * tick_halves - 5
    for at, expected in ((take - LATENCY, [0, 5, 5, 5]), (take - LATENCY + 1, [0, 0, 0, 5])):
        volts = 5 << formats.VOLTAGE.fraction
        ticks = [Tick(volts, at), Tick()]
        assert (await bench.run(half_clocks, tick_halves, STEP, ticks)).widths == expected


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def reset_of_one_clock(dut: object) -> None:
    """In any clock, at any duty and rest: no width from then on, until there is a voltage."""
    bench = ModulatorBench(dut)
    half_clocks = 24
    for second_order in (False, True):
        for at in range(half_clocks):
            volts = [(7 << formats.VOLTAGE.fraction) + 12345 * n for n in range(5)]
            await bench.run(half_clocks, 1, STEP, every_tick(volts), second_order)
            await bench.step(at)
            assert bench.signed("width_o") == 7
            await bench.step(rst=1)
            for after in range(2 * half_clocks):
                assert bench.signed("width_o") == 0, (at, after)
                await bench.step(rst=0, update_i=int(after % 7 == at % 7))
            bench.drive(update_i=0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def reset_clears(dut: object) -> None:
    """A reset in mid-stream leaves no width, no duty and nothing owed."""
    bench = ModulatorBench(dut)
    await bench.run(24, 1, STEP, every_tick([(7 << formats.VOLTAGE.fraction) + 12345] * 5))
    await bench.step(rst=1, update_i=0)
    assert bench.signed("width_o") == 0
    shown = await bench.run(24, 1, STEP, [Tick()] * 4)
    assert shown.widths == [0] * 4
    # The last place less than what makes a clock of half a one: nothing at all was left.
    voltage = STEP // 2 - 1 << (formats.VOLTAGE.fraction - FRACTION)
    shown = await bench.run(24, 1, STEP, [Tick(), Tick(voltage), Tick(), Tick()])
    assert shown.widths == [0, 0, 1, 0]
