# SPDX-License-Identifier: Apache-2.0
"""The controller ``pins``: the whole RTL at its pins, clock by clock, with a switching bridge.

ADC bits, encoder edges and gates are what a board would see. The motor is advanced only when the
bridge's voltage changes, when the ADC samples and at the ends of ticks, each time exactly, by a
table of matrix exponentials for whole numbers of clocks.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wavehaptics import bus_scale, formats, sigma_delta, verilated
from wavehaptics.adc_parts import (
    KINDS,
    MODULATORS,
    PARTS,
    Frame,
    PartError,
    frame,
    modulator_frame,
    plain_frame,
)
from wavehaptics.anchor import FOLLOWER_TICKS, SEEN_CELLS
from wavehaptics.bridge import bridge_voltage, half_bridge_voltage
from wavehaptics.bridge_modes import HALF_BRIDGE, LOCKED, MODE_WORDS, UNIPOLAR
from wavehaptics.compiled import compiled, compiled_counting
from wavehaptics.early import slope_fits
from wavehaptics.hand import hand_path
from wavehaptics.lines import FAULTY, cell_of, edge_place, line_count
from wavehaptics.modulator import width_bounds
from wavehaptics.motor import motor_step
from wavehaptics.native_call import call2
from wavehaptics.pins_timing import (
    CENTRED_LEAD,
    EARLY_PREPARE_CLOCKS,
    GATE_CLOCKS,
    early_tick_clocks,
    latency_clocks,
)
from wavehaptics.plant import OMEGA, TIME, C, I, P, Plant, X, load_words, plant_step
from wavehaptics.real import (
    AMPLIFIED,
    DRAWN,
    EDGE,
    LAG,
    LAG_TABLE,
    LEAD,
    LINE_MEMORY,
    LINES,
    LOAD,
    MOTOR,
    SUPPLY,
    VOLTS,
    real_parts,
    warm_real,
)
from wavehaptics.scene import Drive, Scene, SceneError, encoder_end
from wavehaptics.sensor import (
    COMMON_MODE,
    FULL_SCALE,
    LAG_RATE,
    NOISE,
    NOISE_SEED,
    OFFSET,
    SETTLE_RATE,
    Sensor,
    disturbed,
    lagged,
    sample_code,
)
from wavehaptics.settings import Settings, settings
from wavehaptics.sigma_delta import next_bit
from wavehaptics.supply import BUS_V, SAG_OHM, STEP_PART, STEP_S
from wavehaptics.thermal import Winding
from wavehaptics.trace import Column, Word

DEFAULT_BUS_V = 12.0
"""Bus of a scene whose drive has no limit; a switching bridge has to have one."""

CLOCK_HZ = 48e6
"""Clock of the simulated board unless the scene names another."""

NEVER_TRIP = 0xFFFF
"""Threshold of the fast path of the current that no word reaches."""

WORD_NOISE = 0.55
"""Noise power of a word of a third-order sinc filter, in that of a bit over OSR: Σh²·OSR."""

FASTEST_CLOCK_HZ = 100e6
"""A part that needs a faster clock than the usual one gets it, up to this."""

MIN_TICK_CLOCKS = 48
"""Clocks of the shortest tick: an ADC frame of 16 bits at half the clock and its quiet time."""

MOST_TICK_CLOCKS = 48_000
"""Clocks of the longest tick unless the scene names a clock; the RTL counts 16 bits."""

SLOW_HALF_CLOCKS = 96
"""Longest carrier half period chosen when the scene names no ``pwm_hz``."""

FINE_COUNTS_PER_REV = 65_536
"""Encoder where the scene has none: A and B must come from somewhere."""

MOST_SAMPLES = 16
"""Samples in a tick. Their sum is scaled by a word of 27 bits, which more would make too coarse."""

FILTER_CLOCKS = 2
MOST_DEAD_CLOCKS = 255
MOST_MIN_PULSE = 255
SETTLE_TICKS = 5
"""Ticks between two changes of side of the dead-time compensation, besides the scene's latency."""
DELAY_LOG2 = 10
MIN_WALLS = 4

_STEPS = 128
_WAVE = formats.WAVE.step
_VOLT = formats.VOLTAGE.step
_BUS_SCALE = 2.0**formats.BUS_Q
_PENDING = 8

# Bits of the pins, as sim/verilated/pins_shim.cpp packs them.
_AH, _AL, _BH, _BL, _CS_N, _SCLK, _TICK, _CORE_VALID, _TOUCHING = range(9)

# Places in the loop's integer parameters.
(
    _MODEL, _CLOCK, _WORDS, _TICK_CLOCKS, _CODE_SHIFT, _DATA_BITS, _U_MAX, _SUBSTEP_CLOCKS,
    _LAUNCH_LEVEL, _PIPELINE, _OSR, _HALF_BRIDGE, _SET_BUS, _ANCHORED, _START_COUNT,
) = range(15)  # fmt: skip
# Places in the loop's float parameters.
(
    _DT, _CELL, _BUS, _GAIN, _K_T, _RESISTANCE, _ETA_CONTACT, _ETA_FREE, _ENCODER_END, _RIPPLE,
    _RIPPLE_RAD_S,
) = range(11)  # fmt: skip
# Places in the integers that the loop keeps.
(
    _NOW, _ADVANCED, _PINS, _SHIFT, _HELD, _COUNT, _EDGE, _CLOSED, _EMITTED, _TICK_START, _FAULTS,
    _CORRECTION,
) = range(12)  # fmt: skip
# Places in the sums of the tick that is running.
_CHARGE, _SQUARE, _WORK, _VOLT_SECONDS, _LOW, _HIGH, _X0, _HAND0, _T0 = range(9)


FrameAt = Callable[[float, int], Frame]
"""An ADC's frame for a clock in Hz and the clocks of a tick."""


@dataclass(frozen=True)
class Timing:
    """How ticks, carrier and ADC are laid on the clock; see ``rtl/wh_carrier.v``.

    ``early`` is whether ``rtl/wh_early.v`` makes the duty.
    """

    clock_hz: float
    half_clocks: int
    tick_halves: int
    sample_clocks: int
    samples: int
    extra_ticks: int
    hold_ticks: int
    latency_clocks: int
    frame: Frame
    early: bool

    @property
    def tick_clocks(self) -> int:
        return self.half_clocks * self.tick_halves

    @property
    def tick_s(self) -> float:
        return self.tick_clocks / self.clock_hz


def _mode(scene: Scene) -> str:
    """How the scene's bridge switches."""
    return scene.drive.mode if scene.drive else UNIPOLAR


def _pulse_halves(scene: Scene) -> int:
    """Carrier halves that one pulse takes, which a tick has a whole number of: ``wh_pwm``."""
    return 1 if _mode(scene) == UNIPOLAR else 2


def _whole_part(total: int, longest: int) -> int:
    """Largest divisor of ``total`` that is at most ``longest``."""
    return next(d for d in range(min(total, longest), 0, -1) if total % d == 0)


def scene_frame(scene: Scene) -> FrameAt:
    """The ADC's frame on a clock, for the scene's ADC or the finest one that the reader takes."""
    if scene.adc is None:
        return lambda clock_hz, _: plain_frame(0, formats.SAMPLE_W)
    part, bits = scene.adc.part, scene.adc.bits
    if part is None:
        return lambda clock_hz, _: plain_frame(2, bits)
    if part in MODULATORS:
        return lambda clock_hz, clocks: modulator_frame(MODULATORS[part], clock_hz, clocks)
    return lambda clock_hz, _: frame(PARTS[part], clock_hz)


def natural_ticks(
    tick_clocks: int, samples: int, lead: int, frame: Frame, ports: int = 1, sections: int = 0,
    early: bool = False,
) -> int:  # fmt: skip
    """Whole ticks from a tick's end until the voltage made of its samples can be driven."""
    sample_clocks = tick_clocks // samples
    last_sample = tick_clocks - sample_clocks + sample_clocks // 2 - lead
    word_strobe = last_sample + frame.pipeline * sample_clocks
    latency = latency_clocks(frame.conversion_clocks, ports, sections, early)
    return (word_strobe + latency) // tick_clocks


def _sample_lead(made: Frame, pulse_delay: int) -> int:
    """Clocks that the ADC's starts come early, for pulses that are ``pulse_delay`` clocks late.

    A code is held in the middle of the gates' pulse. A modulator's word is of three intervals
    between starts, and its middle one and a half before the start: here is what is left of that
    when the delay of the bits is taken off (``rtl/wh_sinc3.v``; a bit is decided with the clock's
    rise, taken with its fall, and goes through two registers), in whole periods of its clock.
    """
    if not made.osr:
        return CENTRED_LEAD + made.pad_clocks - pulse_delay
    periods = round(1 + (1 + GATE_CLOCKS + pulse_delay) / made.bit_clocks)
    return made.cycle_clocks // 2 - periods * made.bit_clocks


def _soonest(tick_clocks: int, made: Frame, lead: int, sections: int, early: bool) -> int:
    """Fewest ticks of latency that the ADC allows."""
    samples = tick_clocks // made.cycle_clocks if made.osr else 1
    return natural_ticks(tick_clocks, samples, lead, made, 1, sections, early)


def _check_early(scene: Scene, tick_clocks: int, made: Frame) -> None:
    """:class:`SceneError` where ``rtl/wh_early.v`` has no time for its words."""
    place = f"{scene.scene.name}: controller.early_duty"
    if made.conversion_clocks < EARLY_PREPARE_CLOCKS:
        raise SceneError(
            f"{place}: the ADC's word is there {made.conversion_clocks} clocks after its frame's "
            f"start, sooner than the {EARLY_PREPARE_CLOCKS} that are needed; take another adc.part"
        )
    needed = early_tick_clocks(anchored=scene.controller.anchored)
    if tick_clocks < needed:
        with_anchor = " with a port anchor" if scene.controller.anchored else ""
        raise SceneError(
            f"{place}: a tick of {tick_clocks} clocks is shorter than the {needed} that are "
            f"needed{with_anchor}; lower controller.tick_hz or take a faster clock_hz"
        )


def _tick_clocks(scene: Scene, tick_hz: float, halves: int, frame_at: FrameAt) -> tuple[int, Frame]:
    """Clocks of a tick, and the ADC's frame on that clock."""
    named = scene.controller.clock_hz
    if named is not None:
        clocks = round(named / tick_hz)
        return clocks, frame_at(clocks * tick_hz, clocks)
    usual = min(max(MIN_TICK_CLOCKS, round(CLOCK_HZ / tick_hz)), MOST_TICK_CLOCKS)
    found = None
    clocks = usual
    while clocks == usual or clocks * tick_hz <= FASTEST_CLOCK_HZ:
        try:
            made = frame_at(clocks * tick_hz, clocks)
        except PartError:
            made = None
        if made is not None and made.cycle_clocks <= clocks and clocks % halves == 0:
            if not made.osr:
                return clocks, made
            # A modulator: the more bits a tick, the better.
            if found is None or clocks // made.bit_clocks > found[0] // found[1].bit_clocks:
                found = clocks, made
        if clocks - usual > MOST_TICK_CLOCKS // 40:
            break
        clocks += 1
    return found or (usual, frame_at(usual * tick_hz, usual))


def timing(scene: Scene, frame_at: FrameAt, most_samples: int = MOST_SAMPLES) -> Timing:
    """Lay the scene's tick and carrier on a clock, for an ADC with the frame ``frame_at(clock)``.

    A carrier slower than half the tick rate sets the pace: the tick is then its half period, and
    the current is the mean of the samples that fit in. :class:`SceneError` where the carrier can't
    be had, the ADC is too slow or the scene's latency is shorter than the hardware's.
    """
    control, drive = scene.controller, scene.drive
    tick_hz = control.tick_hz
    pwm_hz = drive.pwm_hz if drive else None
    pulse_halves = _pulse_halves(scene)
    pulse_hz = None if pwm_hz is None else 2 * pwm_hz / pulse_halves
    if pulse_hz is not None and pulse_hz < tick_hz:
        tick_hz = pulse_hz
    pulses = 1 if pulse_hz is None else max(1, round(pulse_hz / tick_hz))
    halves = pulses * pulse_halves
    try:
        tick_clocks, made = _tick_clocks(scene, tick_hz, halves, frame_at)
    except PartError as error:
        raise SceneError(f"{scene.scene.name}: adc.part: {error}; take another clock_hz") from None
    clock_hz = control.clock_hz if control.clock_hz is not None else tick_hz * tick_clocks
    if pwm_hz is None:
        if tick_clocks % pulse_halves:
            raise SceneError(
                f"{scene.scene.name}: drive.mode = {drive.mode} needs an even number of clocks in "
                f"a tick, not {tick_clocks}; take another controller.clock_hz"
            )
        pulse_clocks = pulse_halves * _whole_part(
            tick_clocks // pulse_halves, SLOW_HALF_CLOCKS // pulse_halves
        )
        if pulse_clocks < MIN_TICK_CLOCKS:
            pulse_clocks = tick_clocks
    else:
        if abs(pulses * tick_hz / pulse_hz - 1) > 0.01 or tick_clocks % halves:
            twice = "twice pwm_hz" if pulse_halves == 1 else f"with mode = {drive.mode} pwm_hz"
            raise SceneError(
                f"{scene.scene.name}: drive.pwm_hz = {pwm_hz:g} Hz doesn't fit "
                f"controller.tick_hz = {control.tick_hz:g} Hz on `pins`; "
                f"{twice} must be slower than tick_hz, or a multiple of it that divides its "
                f"{tick_clocks} clocks{'' if pulse_halves == 1 else ', in two halves each'}"
            )
        pulse_clocks = tick_clocks // pulses
    half_clocks = pulse_clocks // pulse_halves
    limit = (1 << formats.TICK_W) - 1
    if tick_clocks > limit:
        raise SceneError(
            f"{scene.scene.name}: a tick of {tick_clocks} clocks is longer than `pins` can count; "
            f"take controller.clock_hz <= {limit * tick_hz:g}"
        )
    if scene.adc is not None and made.cycle_clocks > tick_clocks:
        name = scene.adc.part or "the ADC"
        raise SceneError(
            f"{scene.scene.name}: {name} needs {made.cycle_clocks} clocks of {clock_hz:g} Hz from "
            f"sample to sample, and controller.tick_hz leaves {tick_clocks}; lower it or take "
            "another clock_hz"
        )
    sections = scene.shaper.sections if scene.shaper else 0

    # The scene's latency, or without one in it, as much as is needed.
    lead = _sample_lead(made, (_pulse_delay(scene, clock_hz, half_clocks) + 1) // 2)
    extra = control.extra_ticks
    early = control.early_duty
    if early:
        _check_early(scene, tick_clocks, made)
    soonest = _soonest(tick_clocks, made, lead, sections, early)
    if "extra_ticks" not in control.model_fields_set:
        extra = soonest if early else max(extra, soonest)
    # A voltage that has to wait is made in turn.
    early = early and extra <= soonest
    # As many samples as the ADC can make and the latency allows, but each in the middle of
    # as many whole pulses as any other, or several within the only one. A modulator has its own
    # number, of words that follow each other.
    parts = tick_clocks if tick_clocks == pulse_clocks else tick_clocks // pulse_clocks
    samples = next(
        n
        for n in range(most_samples, 0, -1)
        if n == 1
        or (
            not made.osr
            and (
                parts % n == 0
                and tick_clocks // n >= made.cycle_clocks
                and natural_ticks(tick_clocks, n, lead, made, 1, sections, early) <= extra
            )
        )
    )
    if made.osr:
        samples = tick_clocks // made.cycle_clocks
    natural = natural_ticks(tick_clocks, samples, lead, made, 1, sections, early)
    latency = latency_clocks(made.conversion_clocks, 1, sections, early)
    if extra < natural:
        late = " and a sample" if made.pipeline else ""
        raise SceneError(
            f"{scene.scene.name}: controller.extra_ticks = {extra} is less than "
            f"`pins` needs: {latency} clocks{late} from sample to duty are {natural} ticks of "
            f"{tick_clocks} clocks; set extra_ticks = {natural} or more"
        )
    return Timing(
        clock_hz, half_clocks, tick_clocks // half_clocks, tick_clocks // samples, samples,
        extra, extra - natural, latency, made, early,
    )  # fmt: skip


@compiled(inline="always")
def _bus_at(time, floats):
    """The true bus, V."""
    if floats[_RIPPLE] == 0.0:
        return floats[_BUS]
    return floats[_BUS] + floats[_RIPPLE] * np.sin(floats[_RIPPLE_RAD_S] * time)


@compiled()
def _true_bus(time, floats, real):
    """The bus, V. It sags by the last tick's load: between two ticks its capacitors hold it."""
    bus = _bus_at(time, floats)
    if real is not None:
        supply = real[SUPPLY]
        if time >= supply[STEP_S]:
            bus += (supply[STEP_PART] - 1.0) * supply[BUS_V]
        bus = max(0.0, bus - supply[SAG_OHM] * real[LAG][LOAD])
    return bus


@compiled()
def _sensed(state, sensor, real):
    """The current as the ADC gets it, A, but for noise and offset."""
    current = state[I]
    if real is not None:
        if sensor[LAG_RATE] != 0.0:
            current = real[LAG][AMPLIFIED]
        current = disturbed(current, real[LAG][VOLTS], state[TIME], sensor) + real[LAG][EDGE]
    return current


@compiled()
def _step(state, table, step_s, clocks, e, legs, load, sensor, real):
    """One step at ``e`` V, which is ``legs`` times the bus; ∫i dt and ∫i² dt."""
    if real is None:
        return plant_step(state, table, step_s, e, load)
    else:
        first = state[I]
        charge, square = motor_step(state, table, step_s, e, load, real[MOTOR])
        memory = real[LAG]
        memory[DRAWN] += legs * charge
        if legs != 0.0:
            memory[VOLTS] = e
        if sensor[SETTLE_RATE] != 0.0:
            memory[EDGE] *= np.exp(-sensor[SETTLE_RATE] * step_s)
        if sensor[LAG_RATE] != 0.0:
            memory[AMPLIFIED] = lagged(
                memory[AMPLIFIED], first, state[I], charge / step_s, real[LAG_TABLE][clocks]
            )
        return charge, square


@compiled(inline="always")
def _lead_moves(lead, sensor, memory):
    """What an edge of lead A, at ``lead`` from now on, adds to the amplifier's output."""
    if sensor[SETTLE_RATE] != 0.0 and lead != memory[LEAD]:
        if memory[LEAD] != 0.0:
            memory[EDGE] += (lead - memory[LEAD]) * sensor[COMMON_MODE]
        memory[LEAD] = lead


@compiled()
def _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real):
    """Advance the motor to the present clock."""
    clocks = kept[_NOW] - kept[_ADVANCED]
    while clocks > 0:
        part = min(clocks, ints[_SUBSTEP_CLOCKS])
        before = state[I]
        step_s = part * floats[_DT]
        half_bridge = ints[_HALF_BRIDGE]
        floating = kept[_PINS] & 3 == 0 or (kept[_PINS] & 12 == 0 and not half_bridge)
        legs = 0.0
        if floating and before == 0.0:
            # The diodes of the open leg block: no current, and the voltage is the back-EMF.
            e = floats[_K_T] * state[OMEGA]
        else:
            bus = _true_bus(state[TIME] + 0.5 * step_s, floats, real)
            if half_bridge:
                e = floats[_GAIN] * half_bridge_voltage(kept[_PINS], before, bus)
            else:
                e = floats[_GAIN] * bridge_voltage(kept[_PINS], before, bus)
            if real is not None and bus > 0.0:
                legs = e / (floats[_GAIN] * bus)
                _lead_moves(half_bridge_voltage(kept[_PINS], before, 1.0), sensor, real[LAG])
        charge, square = _step(state, tables[part], step_s, part, e, legs, load, sensor, real)
        if floating and before * state[I] <= 0.0:
            # The current ran out within the step and stays at zero: a triangle is left of it.
            if before != 0.0:
                charge = 0.5 * before * step_s * before / (before - state[I])
            state[I] = 0.0
        sums[_CHARGE] += charge
        sums[_SQUARE] += square
        sums[_WORK] += e * charge
        sums[_VOLT_SECONDS] += e * step_s
        sums[_LOW] = min(sums[_LOW], state[I])
        sums[_HIGH] = max(sums[_HIGH], state[I])
        clocks -= part
    kept[_ADVANCED] = kept[_NOW]


@compiled()
def _next_edge(state, kept, cell, dt, end_s, real):
    """Set the count, until ``end_s``, and the clock at which it is to be looked at again.

    The rotor is taken to keep its speed until then, for at most 32 clocks; it can't change by more
    than 1e-8 rad in that time.
    """
    if kept[_NOW] * dt >= end_s:
        kept[_EDGE] = 1 << 62
        return
    ahead = (kept[_NOW] - kept[_ADVANCED]) * dt
    x = state[X] + state[OMEGA] * ahead
    below = int(np.floor(x / cell))
    kept[_COUNT] = below
    if real is not None and real[LINES][FAULTY] != 0.0:
        below = cell_of(x, cell, real[LINES])
        time = kept[_NOW] * dt
        kept[_COUNT] = line_count(x, time, cell, real[LINES], real[LINE_MEMORY])
    speed = state[OMEGA]
    wait = 32
    if speed != 0.0:
        edge = (below + (1 if speed > 0.0 else 0)) * cell
        if real is not None:
            edge = edge_place(below + (1 if speed > 0.0 else 0), real[LINES]) * cell
        until = (edge - x) / (speed * dt)
        if until < wait:
            wait = max(1, int(np.ceil(until)))
    kept[_EDGE] = kept[_NOW] + wait


@compiled(inline="always")
def _encoder_levels(count):
    """A and B at their places in the inputs: Gray code, A leads B when the count rises."""
    quarter = count & 3
    a = 1 if quarter == 1 or quarter == 2 else 0
    return a << 1 | (quarter >> 1) << 2


@compiled()
def _close_tick(state, kept, sums, pending, floats, ints):
    """Keep the row of the tick that ends now until its waves are known."""
    tick = ints[_TICK_CLOCKS] * floats[_DT]
    mean = sums[_CHARGE] / tick
    hand = state[P] + state[C]
    row = pending[kept[_CLOSED] % _PENDING]
    row[Column.T] = sums[_T0] + 0.5 * tick
    row[Column.X] = 0.5 * (sums[_X0] + state[X])
    row[Column.OMEGA] = (state[X] - sums[_X0]) / tick
    row[Column.I] = mean
    row[Column.E_A] = sums[_VOLT_SECONDS] / tick
    row[Column.TORQUE] = floats[_K_T] * mean
    row[Column.X_HAND] = 0.5 * (sums[_HAND0] + hand)
    row[Column.ENERGY_OUT] = sums[_WORK] - floats[_RESISTANCE] * sums[_SQUARE]
    row[Column.RIPPLE] = sums[_HIGH] - sums[_LOW]
    kept[_CLOSED] += 1
    sums[:_LOW] = 0.0
    sums[_LOW] = sums[_HIGH] = state[I]
    sums[_X0], sums[_HAND0], sums[_T0] = state[X], hand, state[TIME]


@compiled_counting(inline="always")
def _level(current, sensor, osr, rng):
    """Input of a modulator in parts of its full scale; the noise of a bit makes that of a word."""
    if sensor[NOISE] > 0.0:
        current += sensor[NOISE] * np.sqrt(osr / WORD_NOISE) * rng.standard_normal()
    return (current + sensor[OFFSET]) / sensor[FULL_SCALE]


@compiled_counting()  # which draws from a generator
def _advance(
    rows, words, state, kept, sums, pending, tables, ints, floats, load, sensor, rng, buffer, bits,
    real,
):  # fmt: skip
    """Clock the RTL until ``rows`` are filled; False if its core falls silent."""
    done = 0
    dt, cell, end_s = floats[_DT], floats[_CELL], floats[_ENCODER_END]
    data_bits = ints[_DATA_BITS]
    silent = 0
    while done < rows.shape[0]:
        if kept[_NOW] >= kept[_EDGE]:
            _next_edge(state, kept, cell, dt, end_s, real)
        inputs = ((kept[_SHIFT] >> 63) & 1) | _encoder_levels(kept[_COUNT])
        pins = call2(ints[_CLOCK], ints[_MODEL], inputs)
        old = kept[_PINS]
        changed = old ^ pins
        if changed & 15:
            _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real)
            _next_edge(state, kept, cell, dt, end_s, real)
        kept[_PINS] = pins
        if ints[_OSR]:
            if changed & pins & 1 << _SCLK:
                _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real)
                level = _level(_sensed(state, sensor, real), sensor, ints[_OSR], rng)
                kept[_SHIFT] = next_bit(bits, level) << 63
        elif changed & (1 << _CS_N | 1 << _SCLK):
            if changed & 1 << _CS_N:
                if not pins & 1 << _CS_N:
                    _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real)
                    noise = rng.standard_normal() if sensor[NOISE] > 0.0 else 0.0
                    current = _sensed(state, sensor, real)
                    code = sample_code(current, sensor, noise) + (1 << (data_bits - 1))
                    # Bit 63 is on the wire; a late part puts out the code that it held before.
                    shown = kept[_HELD] if ints[_PIPELINE] else code
                    kept[_SHIFT] = shown << ints[_CODE_SHIFT]
                    kept[_HELD] = code
            elif (pins >> _SCLK) & 1 == ints[_LAUNCH_LEVEL]:
                kept[_SHIFT] <<= 1
        if pins & 1 << _CORE_VALID:
            call2(ints[_WORDS], ints[_MODEL], buffer.ctypes.data)
            touching = (pins >> _TOUCHING) & 1
            row = pending[kept[_EMITTED] % _PENDING]
            row[Column.ETA] = floats[_ETA_CONTACT] if touching else floats[_ETA_FREE]
            row[Column.U] = buffer[1] * _WAVE
            row[Column.V] = buffer[2] * _WAVE
            row[Column.CONTACT] = touching
            limited = abs(buffer[1]) >= ints[_U_MAX]
            if ints[_SET_BUS] or ints[_ANCHORED]:  # the limit is not the same in every tick
                limited = buffer[4] != 0
            row[Column.SATURATED] = 1.0 if limited else 0.0
            if ints[_ANCHORED]:
                # The voltage of the measured tick was made in the step before.
                row[Column.CORRECTION] = kept[_CORRECTION] * _VOLT
                kept[_CORRECTION] = buffer[5]
                chi = buffer[6] * SEEN_CELLS
                row[Column.FLUX] = chi
                row[Column.X_HAT] = (ints[_START_COUNT] + buffer[9] + 0.5 - chi) * cell
                lag = buffer[7] * SEEN_CELLS * cell
                row[Column.OMEGA_HAT] = lag / (FOLLOWER_TICKS * ints[_TICK_CLOCKS] * dt)
                row[Column.FAULT] = buffer[8]
                if buffer[8]:
                    row[Column.ETA] = 0.0
            rows[done] = row
            words[done, Word.I] = buffer[0]
            words[done, Word.U] = buffer[1]
            words[done, Word.V] = buffer[2]
            words[done, Word.E] = buffer[3]
            kept[_EMITTED] += 1
            done += 1
            silent = 0
        if pins & 1 << _TICK:
            # The strobe marks the carrier's last clock of a tick; the gates follow it later.
            kept[_FAULTS] |= pins >> 9
            kept[_TICK_START] = kept[_NOW] + 1 + GATE_CLOCKS
        kept[_NOW] += 1
        if kept[_NOW] == kept[_TICK_START]:
            _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real)
            _close_tick(state, kept, sums, pending, floats, ints)
            if real is not None:
                real[LAG][LOAD] = real[LAG][DRAWN] / (ints[_TICK_CLOCKS] * dt)
                real[LAG][DRAWN] = 0.0
            if ints[_SET_BUS]:
                word = int(np.round(_true_bus(state[TIME], floats, real) * _BUS_SCALE))
                call2(ints[_SET_BUS], ints[_MODEL], word)
            silent += 1
            if silent > _PENDING - 2:
                return False
    return True


@dataclass(frozen=True)
class Ports:
    """What the ports of ``rtl/wh_controller.v`` are given for a scene.

    ``words`` are the settings by the name of their port, without ``_i``; ``walls`` are (min, max)
    in counts from where the rotor starts. All are raw words.
    """

    timing: Timing
    settings: Settings
    sensor: Sensor
    start_count: int
    words: dict[str, int]
    walls: list[tuple[int, int]]


def controller_ports(
    scene: Scene, frame_at: FrameAt | None = None, most_samples: int = MOST_SAMPLES
) -> Ports:
    """Settings of the whole RTL for a scene; :class:`SceneError` where it can't do it.

    ``frame_at`` takes the place of the scene's ADC, for a board that has its own.
    """
    sensor = Sensor.of_scene(scene)
    if sensor.ideal:
        sensor = _fine_sensor(scene)
    cell_rad = None if scene.encoder else 2 * math.pi / FINE_COUNTS_PER_REV
    time = timing(scene, frame_at or scene_frame(scene), most_samples)
    bus_v = bus_voltage(scene)
    controller = scene.controller.model_copy(update={"extra_ticks": time.extra_ticks})
    scene = scene.model_copy(update={"controller": controller})
    dead = _dead_time_words(scene, time, bus_v)
    delay = _pulse_delay(scene, time.clock_hz, time.half_clocks)
    reach_v = bus_v * (scene.drive.reach if scene.drive else 1.0)
    shortest = _min_pulse(scene, time)
    # What the pulse is longer by and what a leg's shortest pulse takes, the voltage can't have.
    _, spare = width_bounds(_mode(scene), shortest)
    lost = (dead["dead_clocks"] if dead["compensate"] else 0) + 2 * spare
    set_ = settings(scene, time.tick_s, cell_rad, reach_v * (1.0 - lost / time.half_clocks))
    start_count = math.floor(hand_path(scene).x0 / set_.cell_rad)
    words = {
        "half_clocks": time.half_clocks,
        "tick_halves": time.tick_halves,
        "sample_clocks": time.sample_clocks,
        "samples": time.samples,
        "sample_lead": _sample_lead(time.frame, delay // 2),
        "sample_late": 0 if time.frame.osr else delay % 2,
        **time.frame.words(),
        "trip": NEVER_TRIP,
        "zero": 0,
        "gain": sensor.gain_word(time.samples * time.frame.unity),
        "filter_clocks": FILTER_CLOCKS,
        "eta_contact": set_.eta_contact,
        "eta_free": set_.eta_free,
        "root": set_.root,
        "a": set_.a,
        "u_max": set_.u_max,
        "extra_ticks": set_.extra_ticks,
        "hold_ticks": time.hold_ticks,
        "mode": MODE_WORDS[_mode(scene)],
        "min_pulse": shortest,
        "clocks_per_volt": formats.DUTY.to_raw(time.half_clocks / (2 * reach_v)),
        "bus_share": bus_scale.bus_share_word(
            set_.limit_v, reach_v / bus_v * (1.0 - lost / time.half_clocks)
        ),
        **dead,
        "second_order": 0,
    }
    largest = words["clocks_per_volt"]
    if scene.drive and scene.drive.bus_measured:
        lowest = bus_scale.bus_word(scene.drive.true_bus_v - scene.drive.bus_ripple_v)
        half_bridge = _mode(scene) == HALF_BRIDGE
        largest = bus_scale.clocks_per_volt(time.half_clocks, lowest, half_bridge)
    if time.early and not slope_fits(words["root"], words["gain"], largest):
        raise SceneError(
            f"{scene.scene.name}: controller.early_duty: a step of the ADC is worth too many "
            "clocks of the pulse; take a shorter tick or leave early_duty out"
        )
    return Ports(time, set_, sensor, start_count, words, _port_walls(set_, start_count))


def _dead_clocks(scene: Scene, clock_hz: float) -> int:
    """Dead time of the scene's drive in clocks; :class:`SceneError` where they are too many."""
    clocks = round(scene.drive.dead_time_s * clock_hz) if scene.drive else 0
    if clocks > MOST_DEAD_CLOCKS:
        raise SceneError(
            f"{scene.scene.name}: drive.dead_time_s = {scene.drive.dead_time_s:g} s is {clocks} "
            f"clocks of `pins`, which counts {MOST_DEAD_CLOCKS}; "
            f"take controller.clock_hz <= {MOST_DEAD_CLOCKS / scene.drive.dead_time_s:g}"
        )
    return clocks


def _min_pulse(scene: Scene, time: Timing) -> int:
    """Clocks that a leg stays, so that its gate is on for the scene's time after the dead time."""
    if not scene.drive or not scene.drive.min_pulse_s:
        return 0
    # A part in 1e9 of a clock is the floats'.
    clocks = math.ceil(scene.drive.min_pulse_s * time.clock_hz - 1e-9)
    clocks += _dead_clocks(scene, time.clock_hz)
    most = min(MOST_MIN_PULSE, time.half_clocks // 4)
    if clocks > most:
        raise SceneError(
            f"{scene.scene.name}: drive.min_pulse_s = {scene.drive.min_pulse_s:g} s and the dead "
            f"time are {clocks} clocks of `pins`, of which a carrier half of {time.half_clocks} "
            f"has room for {most}; take a slower drive.pwm_hz or a shorter min_pulse_s"
        )
    return clocks


def _pulse_delay(scene: Scene, clock_hz: float, half_clocks: int) -> int:
    """How late the pulse's middle is, in half clocks.

    Dead time delays it by half of itself. Where half the half is on at 0 V, an odd clock makes the
    end of a period the longer one (``rtl/wh_pwm.v``).
    """
    odd = half_clocks % 2 if _mode(scene) in (LOCKED, HALF_BRIDGE) else 0
    return _dead_clocks(scene, clock_hz) - odd


def _dead_time_words(scene: Scene, time: Timing, bus_v: float) -> dict[str, int]:
    """Words of the dead time and of its compensation, ``rtl/wh_dead_time.v``."""
    clocks = _dead_clocks(scene, time.clock_hz)
    compensate = clocks > 0 and scene.drive.compensate
    if compensate and _mode(scene) != UNIPOLAR:
        raise SceneError(
            f"{scene.scene.name}: drive.compensate: what dead time takes depends on the ripple in "
            f"the mode {scene.drive.mode}, and can't be made good; set drive.compensate = false or "
            "take drive.mode = unipolar"
        )
    # Half the current that one dead time's voltage changes.
    side_a = 0.5 * bus_v * clocks / time.clock_hz / scene.controller.l_hat
    return {
        "dead_clocks": clocks,
        "compensate": int(compensate),
        "side_current": formats.CURRENT.to_raw(min(side_a, 0.5 * formats.CURRENT.largest)),
        "settle_ticks": min(255, scene.controller.extra_ticks + SETTLE_TICKS),
    }


def _bridge_parameters(words: dict[str, int]) -> dict[str, int]:
    """Both in one build of the RTL, which takes longer than the run."""
    if words["mode"] == MODE_WORDS[UNIPOLAR] and not words["min_pulse"]:
        return {}
    return {"MODES": 1, "MIN_PULSE": 1}


class PinsSimulation:
    """A scene on the whole RTL, with the ADC's bits, the encoder's edges and a switching bridge.

    ``most_samples`` limits the samples in a tick: 1 is point sampling in its middle.
    """

    SHIM = "pins_shim.cpp"
    PREFIX = "wh_pins"
    """What the shim's functions begin with."""

    def __init__(
        self, scene: Scene, *, host: bool = False, most_samples: int = MOST_SAMPLES
    ) -> None:
        ports = controller_ports(scene, most_samples=most_samples)
        self.timing = ports.timing
        set_, time, sensor = ports.settings, ports.timing, ports.sensor
        if host:
            set_ = set_.for_a_host()
        self.settings: Settings = set_
        self.sensor = sensor
        self.tick_s = time.tick_s
        self.winding = Winding(scene, self.tick_s)
        plant = self.winding.plant
        self._dt = dt = 1.0 / time.clock_hz
        drive = scene.drive or Drive.model_validate({})
        true_bus_v = drive.true_bus_v or bus_voltage(scene)
        walls = ports.walls
        parameters = [
            *ports.words.values(), bus_scale.bus_word(true_bus_v),
            _encoder_levels.py_func(ports.start_count),
            len(walls), *(edge for wall in walls for edge in wall),
            *verilated.anchor_words(set_.anchor),
        ]  # fmt: skip
        design = verilated.Design(
            "wh_controller",
            self.SHIM,
            {
                "N": 1,
                "WALLS": max(MIN_WALLS, len(walls)),
                "DELAY_LOG2": DELAY_LOG2,
                "ADC": KINDS.index(time.frame.kind),
                "SHAPER": len(set_.shaper.words),
                **_bridge_parameters(ports.words),
                **({"EARLY": 1} if time.early else {}),
                **({"OSR": time.frame.osr} if time.frame.osr else {}),
                **({"BUS": 1} if drive.bus_measured else {}),
                **({"HOST": 1} if host else {}),
                **({"ANCHOR": 1} if set_.anchored else {}),
                **self._parameters(),
            },
        )
        self._library = verilated.load(design)
        verilated.declare_destructor(self._function("delete"))
        self._model = self._new_model(parameters)
        if not self._model:
            raise RuntimeError("the controller's RTL never got its ADC ready")
        shaped = sum(1 << n for n, wall in enumerate(set_.shaped.tolist()) if wall)
        verilated.set_shaper(
            self._function("shape"), self._model, set_.shaper.words, shaped,
            int(set_.edge_hysteresis),
        )  # fmt: skip
        self._state = plant.start.copy()
        self._tables = self._transitions(plant)
        self._kept = np.zeros(_CORRECTION + 1, dtype=np.int64)
        self._kept[_COUNT] = ports.start_count
        self._kept[_TICK_START] = -1
        self._kept[_PINS] = 1 << _CS_N | time.frame.sclk_idle << _SCLK
        self._kept[_HELD] = 1 << (sensor.bits - 1)
        self._sums = np.zeros(_T0 + 1)
        self._sums[_X0] = self._state[X]
        self._sums[_HAND0] = self._state[P] + self._state[C]
        self._pending = np.zeros((_PENDING, len(Column)))
        code_shift, launch_level = _wire(scene, time.frame)
        longest = min(_STEPS, max(1, math.floor(time.clock_hz * plant.longest_step_s)))
        self._ints = np.array(
            [self._model, verilated.address(self._function("clock")),
             verilated.address(self._function("words")), time.tick_clocks,
             code_shift, sensor.bits, set_.u_max, longest, launch_level, time.frame.pipeline,
             time.frame.osr, _mode(scene) == HALF_BRIDGE,
             verilated.address(self._function("bus")) if drive.bus_measured else 0,
             set_.anchored, ports.start_count],
            dtype=np.int64,
        )  # fmt: skip
        self._floats = np.array(
            [dt, set_.cell_rad, true_bus_v, 1.0 + drive.gain_error, plant.k_t,
             plant.resistance, scene.controller.eta_contact, scene.controller.eta_free,
             encoder_end(scene), drive.bus_ripple_v,
             2 * math.pi * (drive.bus_ripple_hz or 0.0)]
        )  # fmt: skip
        self._load = load_words(plant)
        steps_s = [n * dt for n in range(_STEPS + 1)]
        self._real = real_parts(scene, plant, set_.cell_rad, steps_s, switching=True)
        self._sensor = sensor.constants()
        self._rng = np.random.default_rng(NOISE_SEED)
        self._buffer = np.zeros(10, dtype=np.int64)
        self._bits = sigma_delta.new_state()

    def connect_host(self, period_log2: int, timeout: int) -> None:
        """Say how long a period of the link to a host is, and how many may pass in silence."""
        self._library.wh_pins_host.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64]
        self._library.wh_pins_answer.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64]
        self._library.wh_pins_packet.argtypes = [ctypes.c_void_p, ctypes.POINTER(ctypes.c_int64)]
        self._library.wh_pins_host(self._model, period_log2, timeout)

    def host_answer(self, sequence: int, u: int) -> None:
        """The host's answer u to packet ``sequence``, in the coming clock."""
        self._library.wh_pins_answer(self._model, sequence, u)

    def host_packet(self) -> tuple[int, int, int, int]:
        """(packets so far, number and mean v of the newest, whether the host is in force)."""
        words = (ctypes.c_int64 * 4)()
        self._library.wh_pins_packet(self._model, words)
        return tuple(words)

    @property
    def faults(self) -> int:
        """What was seen: bit 0 a tick too short for its work or ticks without, bit 1 an encoder's
        illegal move.
        """
        return int(self._kept[_FAULTS])

    @property
    def clock_cycles(self) -> int:
        """Clocks of the RTL so far."""
        return int(self._kept[_NOW])

    def _transitions(self, plant: Plant) -> np.ndarray:
        return np.stack([plant.transition(n * self._dt) for n in range(_STEPS + 1)])

    def _function(self, name: str) -> ctypes._CFuncPtr:
        return getattr(self._library, f"{self.PREFIX}_{name}")

    def _parameters(self) -> dict[str, int]:
        """Parameters of the RTL besides the scene's."""
        return {}

    def _new_model(self, parameters: list[int]) -> int | None:
        return verilated.new_model(self._library.wh_pins_new, parameters)

    def advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column) and ``words`` (Word)."""
        self.winding.advance(rows, lambda part: self._advance(rows[part], words[part]), self._warm)

    def _warm(self, plant: Plant) -> None:
        self._tables = self._transitions(plant)
        self._floats[_RESISTANCE] = plant.resistance
        warm_real(self._real, plant)

    def _advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        done = _advance(
            rows, words, self._state, self._kept, self._sums, self._pending, self._tables,
            self._ints, self._floats, self._load, self._sensor, self._rng, self._buffer,
            self._bits, self._real,
        )  # fmt: skip
        if not done:
            raise RuntimeError("the controller's RTL stopped answering")

    def __del__(self) -> None:
        if getattr(self, "_model", None):
            self._function("delete")(self._model)


def bus_voltage(scene: Scene) -> float:
    """Bus of the scene's bridge, V."""
    drive = scene.drive
    return DEFAULT_BUS_V if drive is None or drive.bus_v is None else drive.bus_v


def _wire(scene: Scene, frame: Frame) -> tuple[int, int]:
    """Place of the code on the simulated ADC's wire, and the level of SCLK that launches a bit."""
    part = PARTS.get(scene.adc.part or "") if scene.adc is not None else None
    late = part is not None and part.launch_late
    trailing = part is not None and part.launch_trailing
    bits = frame.lead_bits + frame.data_bits + late
    return 64 - bits, frame.sclk_idle if trailing else 1 - frame.sclk_idle


def _fine_sensor(scene: Scene) -> Sensor:
    """The finest ADC that the reader takes, for a scene without one: 16 bits."""
    set_ = settings(scene)
    largest = 2 * min(set_.limit_v, bus_voltage(scene)) / min(scene.motor.R_ohm, set_.r_hat)
    return Sensor(ideal=False, full_scale_a=min(largest, 0.99 * formats.CURRENT.largest))


def _port_walls(set_: Settings, start_count: int) -> list[tuple[int, int]]:
    """Walls in the RTL's own counts, which begin at 0 where the rotor starts."""
    low, high = -(1 << (formats.COUNT_W - 1)), (1 << (formats.COUNT_W - 1)) - 1
    walls = []
    for wall_min, wall_max in zip(set_.wall_min.tolist(), set_.wall_max.tolist(), strict=True):
        walls.append((max(low, wall_min - start_count), min(high, wall_max - start_count)))
    return walls
