# SPDX-License-Identifier: Apache-2.0
"""The controller ``pins``: the whole RTL at its pins, clock by clock, with a switching bridge.

ADC bits, encoder edges and gates are what a board would see. The motor is advanced only when the
bridge's voltage changes, when the ADC samples and at the ends of ticks, each time exactly, by a
table of matrix exponentials for whole numbers of clocks.
"""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass

import numba
import numpy as np

from wavehaptics import formats, verilated
from wavehaptics.bridge import bridge_voltage
from wavehaptics.hand import hand_path
from wavehaptics.native_call import call2
from wavehaptics.pins_timing import CENTRED_LEAD, GATE_CLOCKS, latency_clocks
from wavehaptics.plant import OMEGA, TIME, C, I, P, Plant, X, load_words, plant_step
from wavehaptics.scene import Scene, SceneError
from wavehaptics.sensor import NOISE_SEED, Sensor, sample_code
from wavehaptics.settings import Settings, settings
from wavehaptics.trace import Column, Word

DEFAULT_BUS_V = 12.0
"""Bus of a scene whose drive has no limit; a switching bridge has to have one."""

CLOCK_HZ = 48e6
"""Clock of the simulated board unless the scene names another."""

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

SCLK_HALF_CLOCKS = 1
QUIET_CLOCKS = 2
FILTER_CLOCKS = 2
DELAY_LOG2 = 10
MIN_WALLS = 4

_STEPS = 128
_WAVE = formats.WAVE.step
_PENDING = 8

# Bits of the pins, as sim/verilated/pins_shim.cpp packs them.
_AH, _AL, _BH, _BL, _CS_N, _SCLK, _TICK, _CORE_VALID, _TOUCHING = range(9)

# Places in the loop's integer parameters.
_MODEL, _CLOCK, _WORDS, _TICK_CLOCKS, _LEAD_BITS, _DATA_BITS, _U_MAX, _SUBSTEP_CLOCKS = range(8)
# Places in the loop's float parameters.
_DT, _CELL, _BUS, _GAIN, _K_T, _RESISTANCE, _ETA_CONTACT, _ETA_FREE = range(8)
# Places in the integers that the loop keeps.
(
    _NOW, _ADVANCED, _PINS, _SHIFT, _COUNT, _EDGE, _CLOSED, _EMITTED, _TICK_START, _FAULTS,
) = range(10)  # fmt: skip
# Places in the sums of the tick that is running.
_CHARGE, _SQUARE, _WORK, _VOLT_SECONDS, _LOW, _HIGH, _X0, _HAND0, _T0 = range(9)


@dataclass(frozen=True)
class Timing:
    """How ticks, carrier and ADC are laid on the clock; see ``rtl/wh_carrier.v``."""

    clock_hz: float
    half_clocks: int
    tick_halves: int
    sample_clocks: int
    samples: int
    hold_ticks: int
    latency_clocks: int

    @property
    def tick_clocks(self) -> int:
        return self.half_clocks * self.tick_halves

    @property
    def tick_s(self) -> float:
        return self.tick_clocks / self.clock_hz


def _whole_part(total: int, longest: int) -> int:
    """Largest divisor of ``total`` that is at most ``longest``."""
    return next(d for d in range(min(total, longest), 0, -1) if total % d == 0)


def timing(scene: Scene, frame_bits: int) -> Timing:
    """Lay the scene's tick and carrier on a clock.

    A carrier slower than half the tick rate sets the pace: the tick is then its half period, and
    the current is the mean of the samples that fit in. :class:`SceneError` where the carrier can't
    be had or the scene's latency is shorter than the hardware's.
    """
    control, drive = scene.controller, scene.drive
    tick_hz = control.tick_hz
    pwm_hz = drive.pwm_hz if drive else None
    if pwm_hz is not None and 2 * pwm_hz < tick_hz:
        tick_hz = 2 * pwm_hz
    clock_hz = control.clock_hz
    if clock_hz is None:
        clocks = min(max(MIN_TICK_CLOCKS, round(CLOCK_HZ / tick_hz)), MOST_TICK_CLOCKS)
        clock_hz = tick_hz * clocks
    tick_clocks = round(clock_hz / tick_hz)
    frame_clocks = 2 * SCLK_HALF_CLOCKS * (frame_bits + 1) + QUIET_CLOCKS
    if pwm_hz is None:
        half_clocks = _whole_part(tick_clocks, max(SLOW_HALF_CLOCKS, MIN_TICK_CLOCKS))
        if half_clocks < MIN_TICK_CLOCKS:
            half_clocks = tick_clocks
    else:
        halves = max(1, round(2 * pwm_hz / tick_hz))
        if abs(halves * tick_hz / (2 * pwm_hz) - 1) > 0.01 or tick_clocks % halves:
            raise SceneError(
                f"{scene.scene.name}: drive.pwm_hz = {pwm_hz:g} Hz doesn't fit "
                f"controller.tick_hz = {control.tick_hz:g} Hz on `pins`; "
                "twice pwm_hz must be slower than tick_hz, or a multiple of it that divides its "
                f"{tick_clocks} clocks"
            )
        half_clocks = tick_clocks // halves
    limit = (1 << formats.TICK_W) - 1
    if tick_clocks > limit:
        raise SceneError(
            f"{scene.scene.name}: a tick of {tick_clocks} clocks is longer than `pins` can count; "
            f"take controller.clock_hz <= {limit * tick_hz:g}"
        )
    latency = latency_clocks(SCLK_HALF_CLOCKS, frame_bits, 1)

    def natural_ticks(samples: int) -> int:
        """Whole ticks from a tick's end until the voltage made of its samples can be driven."""
        sample_clocks = tick_clocks // samples
        last_sample = tick_clocks - sample_clocks + sample_clocks // 2 - CENTRED_LEAD
        return (last_sample + latency) // tick_clocks

    # As many samples as the ADC can make and the scene's latency allows, but each in the middle of
    # as many whole pulses as any other, or several within the only one.
    parts = tick_clocks if tick_clocks == half_clocks else tick_clocks // half_clocks
    samples = next(
        n
        for n in range(MOST_SAMPLES, 0, -1)
        if n == 1
        or (
            parts % n == 0
            and tick_clocks // n >= frame_clocks
            and natural_ticks(n) <= control.extra_ticks
        )
    )
    sample_clocks = tick_clocks // samples
    natural = natural_ticks(samples)
    if control.extra_ticks < natural:
        raise SceneError(
            f"{scene.scene.name}: controller.extra_ticks = {control.extra_ticks} is less than "
            f"`pins` needs: {latency} clocks from sample to duty are {natural} ticks of "
            f"{tick_clocks} clocks; set extra_ticks = {natural} or more"
        )
    return Timing(
        clock_hz, half_clocks, tick_clocks // half_clocks, sample_clocks, samples,
        control.extra_ticks - natural, latency,
    )  # fmt: skip


@numba.njit(cache=True)
def _catch_up(state, kept, sums, tables, floats, ints, load):
    """Advance the motor to the present clock."""
    clocks = kept[_NOW] - kept[_ADVANCED]
    while clocks > 0:
        part = min(clocks, ints[_SUBSTEP_CLOCKS])
        before = state[I]
        step_s = part * floats[_DT]
        floating = kept[_PINS] & 3 == 0 or kept[_PINS] & 12 == 0
        if floating and before == 0.0:
            # The diodes of the open leg block: no current, and the voltage is the back-EMF.
            e = floats[_K_T] * state[OMEGA]
        else:
            e = floats[_GAIN] * bridge_voltage(kept[_PINS], before, floats[_BUS])
        charge, square = plant_step(state, tables[part], step_s, e, load)
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


@numba.njit(cache=True)
def _next_edge(state, kept, cell, dt):
    """Set the count, and the clock at which it is to be looked at again.

    The rotor is taken to keep its speed until then, for at most 32 clocks; it can't change by more
    than 1e-8 rad in that time.
    """
    ahead = (kept[_NOW] - kept[_ADVANCED]) * dt
    x = state[X] + state[OMEGA] * ahead
    kept[_COUNT] = int(np.floor(x / cell))
    speed = state[OMEGA]
    wait = 32
    if speed != 0.0:
        edge = (kept[_COUNT] + (1 if speed > 0.0 else 0)) * cell
        until = (edge - x) / (speed * dt)
        if until < wait:
            wait = max(1, int(np.ceil(until)))
    kept[_EDGE] = kept[_NOW] + wait


@numba.njit(cache=True)
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


@numba.njit(cache=True)
def _advance(
    rows, words, state, kept, sums, pending, tables, ints, floats, load, sensor, rng, buffer
):
    """Clock the RTL until ``rows`` are filled; False if its core falls silent."""
    done = 0
    dt, cell = floats[_DT], floats[_CELL]
    data_bits = ints[_DATA_BITS]
    silent = 0
    while done < rows.shape[0]:
        if kept[_NOW] >= kept[_EDGE]:
            _next_edge(state, kept, cell, dt)
        # Gray code of the count's last two bits, A leading B when the count rises.
        quarter = kept[_COUNT] & 3
        a = 1 if quarter == 1 or quarter == 2 else 0
        inputs = ((kept[_SHIFT] >> 63) & 1) | a << 1 | (quarter >> 1) << 2
        pins = call2(ints[_CLOCK], ints[_MODEL], inputs)
        old = kept[_PINS]
        changed = old ^ pins
        if changed & 15:
            _catch_up(state, kept, sums, tables, floats, ints, load)
            _next_edge(state, kept, cell, dt)
        kept[_PINS] = pins
        if changed & (1 << _CS_N | 1 << _SCLK):
            if changed & 1 << _CS_N:
                if not pins & 1 << _CS_N:
                    _catch_up(state, kept, sums, tables, floats, ints, load)
                    code = sample_code(state[I], sensor, rng) + (1 << (data_bits - 1))
                    # Bit 63 is on the wire; the first lead zero comes with the fall of CS.
                    kept[_SHIFT] = code << (64 - ints[_LEAD_BITS] - data_bits)
            elif not pins & 1 << _SCLK:
                kept[_SHIFT] <<= 1
        if pins & 1 << _CORE_VALID:
            call2(ints[_WORDS], ints[_MODEL], buffer.ctypes.data)
            touching = (pins >> _TOUCHING) & 1
            row = pending[kept[_EMITTED] % _PENDING]
            row[Column.ETA] = floats[_ETA_CONTACT] if touching else floats[_ETA_FREE]
            row[Column.U] = buffer[1] * _WAVE
            row[Column.V] = buffer[2] * _WAVE
            row[Column.CONTACT] = touching
            row[Column.SATURATED] = 1.0 if abs(buffer[1]) >= ints[_U_MAX] else 0.0
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
            _catch_up(state, kept, sums, tables, floats, ints, load)
            _close_tick(state, kept, sums, pending, floats, ints)
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


def controller_ports(scene: Scene) -> Ports:
    """Settings of the whole RTL for a scene; :class:`SceneError` where it can't do it."""
    sensor = Sensor.of_scene(scene)
    if sensor.ideal:
        sensor = _fine_sensor(scene)
    frame_bits = sensor.lead_bits + sensor.bits
    cell_rad = None if scene.encoder else 2 * math.pi / FINE_COUNTS_PER_REV
    time = timing(scene, frame_bits)
    bus_v = bus_voltage(scene)
    set_ = settings(scene, time.tick_s, cell_rad, bus_v)
    start_count = math.floor(hand_path(scene).x0 / set_.cell_rad)
    dead_s = scene.drive.dead_time_s if scene.drive else 0.0
    words = {
        "half_clocks": time.half_clocks,
        "tick_halves": time.tick_halves,
        "sample_clocks": time.sample_clocks,
        "samples": time.samples,
        "sample_lead": CENTRED_LEAD,
        "sclk_half_clocks": SCLK_HALF_CLOCKS,
        "frame_bits": frame_bits,
        "lead_bits": sensor.lead_bits,
        "data_bits": sensor.bits,
        "quiet_clocks": QUIET_CLOCKS,
        "zero": 0,
        "gain": sensor.gain_word(time.samples),
        "filter_clocks": FILTER_CLOCKS,
        "eta_contact": set_.eta_contact,
        "eta_free": set_.eta_free,
        "root": set_.root,
        "a": set_.a,
        "u_max": set_.u_max,
        "extra_ticks": set_.extra_ticks,
        "hold_ticks": time.hold_ticks,
        "clocks_per_volt": formats.DUTY.to_raw(time.half_clocks / (2 * bus_v)),
        "dead_clocks": round(dead_s * time.clock_hz),
    }
    return Ports(time, set_, sensor, start_count, words, _port_walls(set_, start_count))


class PinsSimulation:
    """A scene on the whole RTL, with the ADC's bits, the encoder's edges and a switching bridge."""

    def __init__(self, scene: Scene) -> None:
        ports = controller_ports(scene)
        set_, time, sensor = ports.settings, ports.timing, ports.sensor
        self.settings: Settings = set_
        self.tick_s = time.tick_s
        plant = Plant.of_scene(scene)
        dt = 1.0 / time.clock_hz
        gain_error = scene.drive.gain_error if scene.drive else 0.0
        walls = ports.walls
        parameters = [*ports.words.values(), len(walls), *(edge for wall in walls for edge in wall)]
        design = verilated.Design(
            "wh_controller",
            "pins_shim.cpp",
            {"N": 1, "WALLS": max(MIN_WALLS, len(walls)), "DELAY_LOG2": DELAY_LOG2},
        )
        self._library = verilated.load(design)
        verilated.declare_destructor(self._library.wh_pins_delete)
        self._library.wh_pins_new.argtypes = [ctypes.POINTER(ctypes.c_int64)]
        self._library.wh_pins_new.restype = ctypes.c_void_p
        self._model = self._library.wh_pins_new((ctypes.c_int64 * len(parameters))(*parameters))
        self._state = plant.start.copy()
        self._tables = np.stack([plant.transition(n * dt) for n in range(_STEPS + 1)])
        self._kept = np.zeros(_FAULTS + 1, dtype=np.int64)
        self._kept[_COUNT] = ports.start_count
        self._kept[_TICK_START] = -1
        self._kept[_PINS] = 1 << _CS_N | 1 << _SCLK
        self._sums = np.zeros(_T0 + 1)
        self._sums[_X0] = self._state[X]
        self._sums[_HAND0] = self._state[P] + self._state[C]
        self._pending = np.zeros((_PENDING, len(Column)))
        longest = min(_STEPS, max(1, math.floor(time.clock_hz * plant.longest_step_s)))
        self._ints = np.array(
            [self._model, verilated.address(self._library.wh_pins_clock),
             verilated.address(self._library.wh_pins_words), time.tick_clocks,
             sensor.lead_bits, sensor.bits, set_.u_max, longest],
            dtype=np.int64,
        )  # fmt: skip
        self._floats = np.array(
            [dt, set_.cell_rad, bus_voltage(scene), 1.0 + gain_error, plant.k_t, plant.resistance,
             scene.controller.eta_contact, scene.controller.eta_free]
        )  # fmt: skip
        self._load = load_words(plant)
        self._sensor = sensor.constants()
        self._rng = np.random.default_rng(NOISE_SEED)
        self._buffer = np.zeros(4, dtype=np.int64)

    @property
    def clock_cycles(self) -> int:
        """Clocks of the RTL so far."""
        return int(self._kept[_NOW])

    def advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column) and ``words`` (Word)."""
        done = _advance(
            rows, words, self._state, self._kept, self._sums, self._pending, self._tables,
            self._ints, self._floats, self._load, self._sensor, self._rng, self._buffer,
        )  # fmt: skip
        if not done:
            raise RuntimeError("the controller's RTL stopped answering")

    def __del__(self) -> None:
        if getattr(self, "_model", None):
            self._library.wh_pins_delete(self._model)


def bus_voltage(scene: Scene) -> float:
    """Bus of the scene's bridge, V."""
    drive = scene.drive
    return DEFAULT_BUS_V if drive is None or drive.bus_v is None else drive.bus_v


def _fine_sensor(scene: Scene) -> Sensor:
    """The finest ADC that the reader takes, for a scene without one: 16 bits."""
    set_ = settings(scene)
    largest = 2 * min(set_.limit_v, bus_voltage(scene)) / min(scene.motor.R_ohm, set_.r_hat)
    return Sensor(
        ideal=False, lead_bits=0, full_scale_a=min(largest, 0.99 * formats.CURRENT.largest)
    )


def _port_walls(set_: Settings, start_count: int) -> list[tuple[int, int]]:
    """Walls in the RTL's own counts, which begin at 0 where the rotor starts."""
    low, high = -(1 << (formats.COUNT_W - 1)), (1 << (formats.COUNT_W - 1)) - 1
    walls = []
    for wall_min, wall_max in zip(set_.wall_min.tolist(), set_.wall_max.tolist(), strict=True):
        walls.append((max(low, wall_min - start_count), min(high, wall_max - start_count)))
    return walls
