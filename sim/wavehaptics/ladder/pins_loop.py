# SPDX-License-Identifier: Apache-2.0
"""The loop of `pins`: the RTL clock by clock, and the motor whenever that matters to it.

The motor is advanced only when the bridge's voltage changes, when the ADC samples and at the ends
of ticks, each time exactly, by a table of matrix exponentials for whole numbers of clocks.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from wavehaptics.controller.anchor import FOLLOWER_TICKS, SEEN_CELLS
from wavehaptics.controller.guard import Fault
from wavehaptics.controller.pins_timing import GATE_CLOCKS
from wavehaptics.motor.absolute import PERIOD_S, absolute_count
from wavehaptics.motor.bridge import bridge_voltage, half_bridge_voltage
from wavehaptics.motor.encoder_lines import FAULTY, cell_of, edge_place, line_count
from wavehaptics.motor.imperfections import (
    AMPLIFIED,
    DRAWN,
    HOLDS,
    LAG,
    LAG_TABLE,
    LEAD,
    LEAD_EDGE,
    LINE_MEMORY,
    LINES,
    LOAD,
    MOTOR,
    READING,
    READINGS,
    SUPPLY,
    VOLTS,
    Real,
)
from wavehaptics.motor.plant import OMEGA, TIME, C, I, P, X, plant_step
from wavehaptics.motor.sensor import (
    COMMON_MODE,
    FULL_SCALE,
    HOLD_S,
    LAG_RATE,
    NOISE,
    OFFSET,
    RESTARTS,
    SETTLE_RATE,
    disturbed,
    held_output,
    hold_at_edge,
    lagged,
    sample_code,
)
from wavehaptics.motor.sigma_delta import next_bit
from wavehaptics.motor.step import motor_step
from wavehaptics.motor.supply import BUS_V, SAG_OHM, STEP_PART, STEP_S
from wavehaptics.motor.tip_hand import put_hand_torque
from wavehaptics.runtime.compiled import compiled, compiled_drawing
from wavehaptics.runtime.native_call import call2
from wavehaptics.trace.columns import Word, put_anchor, put_estimate, put_motion, put_port
from wavehaptics.words import formats

WORD_NOISE = 0.55
"""Noise power of a word of a third-order sinc filter, in that of a bit over OSR: Σh²·OSR."""

_WAVE = formats.WAVE.step
_VOLT = formats.VOLTAGE.step
_BUS_SCALE = 2.0**formats.BUS_Q
PENDING = 8
# Bits of the pins, as sim/verilated/pins_shim.cpp packs them.
AH, AL, BH, BL, CS_N, SCLK, TICK, CORE_VALID, TOUCHING = range(9)
_COMPLAINTS = TOUCHING + 1
_GUARD = _COMPLAINTS + 2
_ANCHOR_LOST = _GUARD + int(Fault.ANCHOR)
_PORT = 31
"""Of several motors: whose step is done, 3 bits."""
_OTHERS = 34
"""And the second motor's gates, 4 bits each."""
_SURFACES = 62
"""And how many surfaces act in a step, 2 bits."""
assert _GUARD + len(Fault) <= _PORT
_WIRES = (1 << TICK) - 1 | (1 << 28) - 1 << _OTHERS
_SEEN = (1 << _PORT) - 1
MOTOR_INPUTS = 3
"""Inputs of a motor, as :func:`advance` gives them."""
WORDS_OF, PORT_WORD, ACTING = 13, 11, 12
"""Words of a step in a buffer. PORT_WORD asks for those of a motor and becomes its contact
(``sim/verilated/ports_shim.cpp``); ACTING is how many surfaces act."""
POSITION_WORD = 9
# Places in the loop's integer parameters.
(
    MODEL, CLOCK, WORDS, TICK_CLOCKS, CODE_SHIFT, DATA_BITS, U_MAX, SUBSTEP_CLOCKS,
    LAUNCH_LEVEL, PIPELINE, OSR, HALF_BRIDGE, SET_BUS, ANCHORED, START_COUNT,
) = range(15)  # fmt: skip
# Places in the loop's float parameters.
(
    DT, CELL, BUS, GAIN, K_T, RESISTANCE, ETA_CONTACT, ETA_FREE, ENCODER_END, RIPPLE,
    RIPPLE_RAD_S, FARAD,
) = range(12)  # fmt: skip
# Places in the integers that the loop keeps.
(
    NOW, ADVANCED, PINS, SHIFT, HELD, COUNT, NEXT_LOOK, CLOSED, EMITTED, TICK_START, FAULTS,
    CORRECTION, WAITS, TOUCHED, OFF_AT,
) = range(15)  # fmt: skip
# Places in what the loop has of a motor.
STATE, KEPT, SUMS, TICKS, TABLES, INTS, FLOATS, PLANT, ADC, DRAWS, STEP, MODULATOR, REAL = range(13)
Motor = tuple[Any, ...]
# Places in the sums of the tick that is running. Behind them, where the supply takes nothing back
# (FARAD): what the bus' capacitors hold, and the highest bus so far, V. At last the torque that a
# hand at the tip of several motors has against this rotor, N·m.
CHARGE, SQUARE, WORK, VOLT_SECONDS, LOW, HIGH, X0, HAND0, T0, HELD_V, HIGHEST_V, HAND_NM = range(12)
# Places in what the loop has of a hand at the tip: the arm, the hand's words, [the clock at which
# its torque is computed again, clocks between two of these], how many surfaces act in each tick;
# and room: angles, speeds, J, places, torques.
ARM, HAND, HAND_CLOCKS, ACTIVE, Q, OMEGAS, JACOBIAN, PLACES, TORQUES = range(9)


@compiled(inline="always")
def bus_at(time: float, floats: np.ndarray) -> float:
    """The true bus, V."""
    bus: float = floats[BUS]
    if floats[RIPPLE] != 0.0:
        bus += floats[RIPPLE] * np.sin(floats[RIPPLE_RAD_S] * time)
    return bus


@compiled(inline="always")
def held_bus(bus: float, floats: np.ndarray, sums: np.ndarray) -> float:
    """The bus where the supply has ``bus`` V: one that takes nothing back lets it be higher."""
    return max(bus, sums[HELD_V]) if floats[FARAD] != 0.0 else bus


@compiled(inline="always")
def draw_charge(bus: float, charge: float, floats: np.ndarray, sums: np.ndarray) -> None:
    """The bridge has drawn ``charge`` from ``bus`` V, or returned it: less than 0."""
    if floats[FARAD] != 0.0:
        sums[HELD_V] = bus - charge / floats[FARAD]
        sums[HIGHEST_V] = max(sums[HIGHEST_V], bus, sums[HELD_V])


@compiled()
def _true_bus(time: float, floats: np.ndarray, real: Real | None, sums: np.ndarray) -> float:
    """The bus, V. It sags by the last tick's load: between two ticks its capacitors hold it."""
    bus = bus_at(time, floats)
    if real is not None:
        supply = real[SUPPLY]
        if time >= supply[STEP_S]:
            bus += (supply[STEP_PART] - 1.0) * supply[BUS_V]
        bus = max(0.0, bus - supply[SAG_OHM] * real[LAG][LOAD])
    return held_bus(bus, floats, sums)


@compiled()
def _end_load(real: Real | None, tick_s: float) -> None:
    """The bus has the mean load of the tick that ends from now on."""
    if real is not None:
        real[LAG][LOAD] = real[LAG][DRAWN] / tick_s
        real[LAG][DRAWN] = 0.0


@compiled()
def _followed(state: np.ndarray, sensor: np.ndarray, real: Real | None) -> float:
    """The amplifier's output where it isn't held, A."""
    current: float = state[I]
    if real is not None:
        if sensor[LAG_RATE] != 0.0:
            current = real[LAG][AMPLIFIED]
        current = disturbed(current, real[LAG][VOLTS], state[TIME], sensor) + real[LAG][LEAD_EDGE]
    return current


@compiled()
def _sensed(state: np.ndarray, clock: int, sensor: np.ndarray, real: Real | None) -> float:
    """The current as the ADC gets it, A, but for noise and offset."""
    current = _followed(state, sensor, real)
    if real is not None and sensor[HOLD_S] != 0.0:
        current = held_output(real[HOLDS], 0, clock, current)
    return current


@compiled()
def _step(
    state: np.ndarray, table: np.ndarray, step_s: float, clocks: int, e: float, legs: float,
    load: np.ndarray, besides: float, sensor: np.ndarray, real: Real | None,
) -> tuple[float, float]:  # fmt: skip
    """One step at ``e`` V, which is ``legs`` times the bus; ∫i dt and ∫i² dt.

    ``besides`` acts against the rotor, N·m.
    """
    if real is None:
        return plant_step(state, table, step_s, e, load, besides)
    else:
        first = state[I]
        charge, square = motor_step(state, table, step_s, e, load, real[MOTOR], besides)
        memory = real[LAG]
        memory[DRAWN] += legs * charge
        if legs != 0.0:
            memory[VOLTS] = e
        if sensor[SETTLE_RATE] != 0.0:
            memory[LEAD_EDGE] *= np.exp(-sensor[SETTLE_RATE] * step_s)
        if sensor[LAG_RATE] != 0.0:
            memory[AMPLIFIED] = lagged(
                memory[AMPLIFIED], first, state[I], charge / step_s, real[LAG_TABLE][clocks]
            )
        return charge, square


@compiled(inline="always")
def _lead_moves(lead: float, sensor: np.ndarray, memory: np.ndarray) -> None:
    """What an edge of lead A, at ``lead`` from now on, adds to the amplifier's output."""
    if sensor[SETTLE_RATE] != 0.0 and lead != memory[LEAD]:
        if memory[LEAD] != 0.0:
            memory[LEAD_EDGE] += (lead - memory[LEAD]) * sensor[COMMON_MODE]
        memory[LEAD] = lead


@compiled()
def _catch_up(
    state: np.ndarray, kept: np.ndarray, sums: np.ndarray, tables: np.ndarray, floats: np.ndarray,
    ints: np.ndarray, load: np.ndarray, sensor: np.ndarray, real: Real | None,
) -> None:  # fmt: skip
    """Advance the motor to the present clock."""
    clocks = kept[NOW] - kept[ADVANCED]
    while clocks > 0:
        part = min(clocks, ints[SUBSTEP_CLOCKS])
        before = state[I]
        step_s = part * floats[DT]
        half_bridge = ints[HALF_BRIDGE]
        floating = kept[PINS] & 3 == 0 or (kept[PINS] & 12 == 0 and not half_bridge)
        legs, bus = 0.0, 0.0
        if floating and before == 0.0:
            # The diodes of the open leg block: no current, and the voltage is the back-EMF.
            e = floats[K_T] * state[OMEGA]
        else:
            bus = _true_bus(state[TIME] + 0.5 * step_s, floats, real, sums)
            if half_bridge:
                e = floats[GAIN] * half_bridge_voltage(kept[PINS], before, bus)
            else:
                e = floats[GAIN] * bridge_voltage(kept[PINS], before, bus)
            if bus > 0.0:
                legs = e / (floats[GAIN] * bus)
            if real is not None and bus > 0.0:
                lead = half_bridge_voltage(kept[PINS], before, 1.0)
                if sensor[HOLD_S] != 0.0:
                    hold_at_edge(
                        real[HOLDS], 0, lead, kept[NOW] - clocks, _followed(state, sensor, real),
                        sensor[HOLD_S] / floats[DT], sensor[RESTARTS],
                    )  # fmt: skip
                _lead_moves(lead, sensor, real[LAG])
        charge, square = _step(
            state, tables[part], step_s, part, e, legs, load, sums[HAND_NM], sensor, real
        )
        if floating and before * state[I] <= 0.0:
            # The current ran out within the step and stays at zero: a triangle is left of it.
            if before != 0.0:
                charge = 0.5 * before * step_s * before / (before - state[I])
            state[I] = 0.0
        if bus > 0.0:
            draw_charge(bus, legs * charge, floats, sums)
        sums[CHARGE] += charge
        sums[SQUARE] += square
        sums[WORK] += e * charge
        sums[VOLT_SECONDS] += e * step_s
        sums[LOW] = min(sums[LOW], state[I])
        sums[HIGH] = max(sums[HIGH], state[I])
        clocks -= part
    kept[ADVANCED] = kept[NOW]


STEP_CLOCKS = 8
"""More than the filter of A and B needs by default."""

FIRST_LOOK = 32
"""Clock until which an encoder shows the count at which its rotor starts. After a reset
``rtl/wh_quadrature.v`` follows A and B for 15 clocks without counting: an edge would be lost."""


@compiled()
def next_edge(
    state: np.ndarray, kept: np.ndarray, cell: float, dt: float, end_s: float, real: Real | None
) -> None:
    """Set the count, until ``end_s``, and the clock at which it is to be looked at again.

    The rotor is taken to keep its speed until then, for at most 32 clocks; it can't change by more
    than 1e-8 rad in that time. An absolute encoder's A and B follow its count in steps of one,
    STEP_CLOCKS apart. Until FIRST_LOOK the count stays that at which the rotor starts.
    """
    if kept[NOW] < FIRST_LOOK:
        kept[NEXT_LOOK] = FIRST_LOOK
        return
    if kept[NOW] * dt >= end_s:
        kept[NEXT_LOOK] = 1 << 62
        return
    ahead = (kept[NOW] - kept[ADVANCED]) * dt
    x = state[X] + state[OMEGA] * ahead
    if real is not None and real[READING][PERIOD_S] != 0.0:
        count = absolute_count(x, kept[NOW] * dt, cell, real[READING], real[READINGS])
        moved = count != kept[COUNT]
        if moved:
            kept[COUNT] += 1 if count > kept[COUNT] else -1
        kept[NEXT_LOOK] = kept[NOW] + (STEP_CLOCKS if moved else 32)
        return
    below = int(np.floor(x / cell))
    kept[COUNT] = below
    if real is not None and real[LINES][FAULTY] != 0.0:
        below = cell_of(x, cell, real[LINES])
        time = kept[NOW] * dt
        kept[COUNT] = line_count(x, time, cell, real[LINES], real[LINE_MEMORY])
    speed = state[OMEGA]
    wait = 32
    if speed != 0.0:
        edge = (below + (1 if speed > 0.0 else 0)) * cell
        if real is not None:
            edge = edge_place(below + (1 if speed > 0.0 else 0), real[LINES]) * cell
        until = (edge - x) / (speed * dt)
        if until < wait:
            wait = max(1, int(np.ceil(until)))
    kept[NEXT_LOOK] = kept[NOW] + wait


@compiled(inline="always")
def encoder_levels(count: int) -> int:
    """A and B at their places in the inputs: Gray code, A leads B when the count rises."""
    quarter = count & 3
    a = 1 if quarter == 1 or quarter == 2 else 0
    return a << 1 | (quarter >> 1) << 2


@compiled()
def _close_tick(
    state: np.ndarray, kept: np.ndarray, sums: np.ndarray, pending: np.ndarray, floats: np.ndarray,
    ints: np.ndarray,
) -> None:  # fmt: skip
    """Keep the row of the tick that ends now until its waves are known."""
    tick = ints[TICK_CLOCKS] * floats[DT]
    mean = sums[CHARGE] / tick
    hand = state[P] + state[C]
    row = pending[kept[CLOSED] % PENDING]
    put_motion(
        row, sums[T0], tick, sums[X0], state[X], mean, sums[VOLT_SECONDS] / tick,
        floats[K_T] * mean, 0.5 * (sums[HAND0] + hand),
        sums[WORK] - floats[RESISTANCE] * sums[SQUARE], sums[HIGH] - sums[LOW],
    )  # fmt: skip
    kept[CLOSED] += 1
    sums[:LOW] = 0.0
    sums[LOW] = sums[HIGH] = state[I]
    sums[X0], sums[HAND0], sums[T0] = state[X], hand, state[TIME]


@compiled()
def _emit(
    rows: np.ndarray, words: np.ndarray, done: int, kept: np.ndarray, pending: np.ndarray,
    floats: np.ndarray, ints: np.ndarray, buffer: np.ndarray,
) -> None:  # fmt: skip
    """The oldest tick that has ended, with the words of its step."""
    cell = floats[CELL]
    touching = kept[TOUCHED]
    row = pending[kept[EMITTED] % PENDING]
    eta = floats[ETA_CONTACT] if touching else floats[ETA_FREE]
    if buffer[ACTING]:
        eta = -1.0
    limited = abs(buffer[1]) >= ints[U_MAX]
    if ints[SET_BUS] or ints[ANCHORED]:  # the limit is not the same in every tick
        limited = buffer[4] != 0
    if ints[ANCHORED]:
        # The voltage of the measured tick was made in the step before.
        put_anchor(row, kept[CORRECTION] * _VOLT, buffer[8])
        kept[CORRECTION] = buffer[5]
        chi = buffer[6] * SEEN_CELLS
        lag = buffer[7] * SEEN_CELLS * cell
        put_estimate(
            row, chi, (ints[START_COUNT] + buffer[9] + 0.5 - chi) * cell,
            lag / (FOLLOWER_TICKS * ints[TICK_CLOCKS] * floats[DT]),
        )  # fmt: skip
        if buffer[8]:
            eta = 0.0
    put_port(
        row, eta, buffer[1] * _WAVE, buffer[2] * _WAVE, touching, limited, buffer[10] != 0
    )  # fmt: skip
    for column in range(row.shape[0]):  # a slice's copy would count references
        rows[done, column] = row[column]
    words[done, Word.I] = buffer[0]
    words[done, Word.U] = buffer[1]
    words[done, Word.V] = buffer[2]
    words[done, Word.E] = buffer[3]
    kept[EMITTED] += 1
    kept[WAITS] = 0


@compiled(inline="always")
def modulated(current: float, sensor: np.ndarray, osr: int, rng: np.random.Generator) -> float:
    """Input of a modulator in parts of its full scale; the noise of a bit makes that of a word."""
    if sensor[NOISE] > 0.0:
        current += sensor[NOISE] * np.sqrt(osr / WORD_NOISE) * rng.standard_normal()
    level: float = (current + sensor[OFFSET]) / sensor[FULL_SCALE]
    return level


@compiled(inline="always")
def _follow(
    changed: int, pins: int, state: np.ndarray, kept: np.ndarray, sums: np.ndarray,
    tables: np.ndarray, ints: np.ndarray, floats: np.ndarray, load: np.ndarray, sensor: np.ndarray,
    rng: np.random.Generator, bits: np.ndarray, real: Real | None,
) -> None:  # fmt: skip
    """What a motor and its ADC make of the pins, of which these have changed in this clock."""
    if changed & 15:
        _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real)
        next_edge(state, kept, floats[CELL], floats[DT], floats[ENCODER_END], real)
    kept[PINS] = pins
    if ints[OSR]:
        if changed & pins & 1 << SCLK:
            _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real)
            sensed = _sensed(state, kept[NOW], sensor, real)
            level = modulated(sensed, sensor, ints[OSR], rng)
            kept[SHIFT] = next_bit(bits, level) << 63
    elif changed & (1 << CS_N | 1 << SCLK):
        if changed & 1 << CS_N:
            if not pins & 1 << CS_N:
                _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real)
                noise = rng.standard_normal() if sensor[NOISE] > 0.0 else 0.0
                current = _sensed(state, kept[NOW], sensor, real)
                code = sample_code(current, sensor, noise) + (1 << (ints[DATA_BITS] - 1))
                # Bit 63 is on the wire; a late part puts out the code that it held before.
                shown = kept[HELD] if ints[PIPELINE] else code
                kept[SHIFT] = shown << ints[CODE_SHIFT]
                kept[HELD] = code
        elif (pins >> SCLK) & 1 == ints[LAUNCH_LEVEL]:
            kept[SHIFT] <<= 1


@compiled(inline="always")
def _of_motor(pins: int, n: int) -> int:
    """Pins as a single motor has them: what all share, and the gates of motor ``n``."""
    if n == 0:
        return pins & _SEEN
    return pins & _SEEN & ~15 | (pins >> (_OTHERS - 4 + 4 * n)) & 15


@compiled(inline="always")
def _inputs(kept: np.ndarray) -> int:
    """Inputs of all motors."""
    found = 0
    for n in range(kept.shape[0]):
        own = ((kept[n, SHIFT] >> 63) & 1) | encoder_levels(kept[n, COUNT])
        found |= own << MOTOR_INPUTS * n
    return found


@compiled(inline="always")
def _next_look(kept: np.ndarray) -> int:
    """Clock at which the first of the encoders has to be looked at again."""
    found: int = kept[0, NEXT_LOOK]
    for n in range(1, kept.shape[0]):
        found = min(found, kept[n, NEXT_LOOK])
    return found


@compiled()
def _wires(told: int, changed: int, motors: tuple[Motor, ...]) -> None:
    """What the motors and their ADCs make of pins that have changed."""
    for n in range(len(motors)):
        own = _of_motor(changed, n) & _WIRES
        if own:
            state, kept, sums, _, tables, ints, floats, load, sensor, rng, _, bits, real = motors[n]
            _follow(
                own, _of_motor(told, n), state, kept, sums, tables, ints, floats, load, sensor, rng,
                bits, real,
            )  # fmt: skip


@compiled()
def _edges(now: int, motors: tuple[Motor, ...]) -> None:
    """Look at the encoders whose time it is."""
    for n in range(len(motors)):
        state, kept, _, _, _, _, floats, _, _, _, _, _, real = motors[n]
        if now >= kept[NEXT_LOOK]:
            next_edge(state, kept, floats[CELL], floats[DT], floats[ENCODER_END], real)


@compiled()
def _pull(now: int, motors: tuple[Motor, ...], tip: tuple[Any, ...]) -> None:
    """The hand at the tip pulls by what it is in the middle of its coming step."""
    half_s = 0.5 * tip[HAND_CLOCKS][1] * motors[0][FLOATS][DT]
    for n in range(len(motors)):
        state, kept, sums, _, tables, ints, floats, load, sensor, _, _, _, real = motors[n]
        _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real)
        tip[Q][n] = state[X] + half_s * state[OMEGA]
        tip[OMEGAS][n] = state[OMEGA]
    put_hand_torque(
        tip[ARM], tip[HAND], motors[0][STATE][TIME] + half_s, tip[Q], tip[OMEGAS], tip[JACOBIAN],
        tip[PLACES], tip[TORQUES],
    )  # fmt: skip
    for n in range(len(motors)):
        motors[n][SUMS][HAND_NM] = -tip[TORQUES][n]
    tip[HAND_CLOCKS][0] = now + tip[HAND_CLOCKS][1]


@compiled(inline="always")
def _put_acting(n: int, at: int, buffer: np.ndarray, tip: tuple[Any, ...] | None) -> None:
    """How many surfaces act in a tick, which all motors have in common."""
    if tip is not None and n == 0:
        tip[ACTIVE][at] = buffer[ACTING]


@compiled()
def _step_done(
    told: int, rows: tuple[np.ndarray, ...], words: tuple[np.ndarray, ...], done: np.ndarray,
    motors: tuple[Motor, ...], tip: tuple[Any, ...] | None,
) -> bool:  # fmt: skip
    """A step's words are there; whether the row that waited for them is made."""
    n = (told >> _PORT) & 7
    _, kept, _, pending, _, ints, floats, _, _, _, buffer, _, _ = motors[n]
    buffer[PORT_WORD] = n
    call2(ints[WORDS], ints[MODEL], buffer.ctypes.data)
    kept[WAITS] = 1
    kept[TOUCHED] = (told >> TOUCHING) & 1
    buffer[ACTING] = (told >> _SURFACES) & 3
    # In a slow tick its last step is done before it ends, and waits for its row.
    if kept[EMITTED] < kept[CLOSED] and done[n] < rows[n].shape[0]:
        _emit(rows[n], words[n], done[n], kept, pending, floats, ints, buffer)
        _put_acting(n, done[n], buffer, tip)
        done[n] += 1
        return True
    return False


@compiled()
def _end_tick(
    told: int, rows: tuple[np.ndarray, ...], words: tuple[np.ndarray, ...], done: np.ndarray,
    motors: tuple[Motor, ...], tip: tuple[Any, ...] | None,
) -> int:  # fmt: skip
    """A tick of all motors ends; how many rows are made. Without rows the motors move on alone."""
    made = 0
    for n in range(len(motors)):
        one = motors[n]
        state, kept, sums, pending, tables, ints, floats, load, sensor, _, buffer, _, real = one
        _catch_up(state, kept, sums, tables, floats, ints, load, sensor, real)
        if rows[n].shape[0]:
            _close_tick(state, kept, sums, pending, floats, ints)
            if (told & _SEEN) >> _GUARD:
                # No steps while the gates are off, so no waves: the rows show what the motor does.
                if kept[OFF_AT] == 0:
                    kept[OFF_AT] = kept[NOW]
                buffer[PORT_WORD] = n
                call2(ints[WORDS], ints[MODEL], buffer.ctypes.data)
                buffer[:5] = 0
                buffer[ACTING] = 0
                kept[TOUCHED] = buffer[PORT_WORD]
                if len(motors) == 1:
                    buffer[8] = (told >> _ANCHOR_LOST) & 1
                    kept[TOUCHED] = (told >> TOUCHING) & 1
                kept[WAITS] = 1
            if kept[WAITS] and done[n] < rows[n].shape[0]:
                _emit(rows[n], words[n], done[n], kept, pending, floats, ints, buffer)
                _put_acting(n, done[n], buffer, tip)
                done[n] += 1
                made += 1
        _end_load(real, ints[TICK_CLOCKS] * floats[DT])
        if ints[SET_BUS]:
            word = int(np.round(_true_bus(state[TIME], floats, real, sums) * _BUS_SCALE))
            call2(ints[SET_BUS], ints[MODEL], word)
    return made


@compiled_drawing
def advance(
    rows: tuple[np.ndarray, ...], words: tuple[np.ndarray, ...], clocks: int, done: np.ndarray,
    kept: np.ndarray, motors: tuple[Motor, ...], tip: tuple[Any, ...] | None,
) -> bool:  # fmt: skip
    """Clock the RTL until ``rows`` and ``words`` are filled; False if a core falls silent.

    They are of each motor; without ticks ``clocks`` pass. ``motors`` are tuples in the order of
    STATE...REAL, ``kept`` the arrays at KEPT as the rows of one, and ``done`` how many ticks each
    motor has, 0 at first. ``tip`` is a tuple in the order of ARM...TORQUES where a hand holds the
    tip of all motors, and None where each has its own.
    """
    count = len(motors)
    ints = motors[0][INTS]
    function, model, launch = ints[CLOCK], ints[MODEL], ints[LAUNCH_LEVEL]
    shifts = ints[OSR] == 0
    now = kept[0, NOW]
    end = now + clocks
    missing = count * rows[0].shape[0]
    tick_start = kept[0, TICK_START]
    silent = 0
    before = kept[0, PINS]
    for n in range(1, count):
        before |= (kept[n, PINS] & 15) << (_OTHERS - 4 + 4 * n)
    look = _next_look(kept)
    inputs = _inputs(kept)
    while missing > 0 or now < end:
        if tip is not None and now >= tip[HAND_CLOCKS][0]:
            _pull(now, motors, tip)
        if now >= look:
            _edges(now, motors)
            look = _next_look(kept)
            inputs = _inputs(kept)
        told = call2(function, model, inputs)
        changed = (told ^ before) & _WIRES
        before = told
        if changed:
            high = (told >> SCLK) & 1
            if changed == 1 << SCLK and (shifts or not high):  # a modulator's bits come as it rises
                for n in range(count):
                    kept[n, PINS] ^= 1 << SCLK
                    if shifts and high == launch:
                        kept[n, SHIFT] <<= 1
            else:
                _wires(told, changed, motors)
                look = _next_look(kept)
            inputs = _inputs(kept)
        if told & 1 << CORE_VALID and _step_done(told, rows, words, done, motors, tip):
            missing -= 1
            silent = 0
        if told & 1 << TICK:
            # The strobe marks the carrier's last clock of a tick; the gates follow it later.
            tick_start = now + 1 + GATE_CLOCKS
            for n in range(count):
                kept[n, FAULTS] |= (told & _SEEN) >> _COMPLAINTS
                kept[n, TICK_START] = tick_start
        now += 1
        for n in range(count):
            kept[n, NOW] = now
        if now == tick_start:
            made = _end_tick(told, rows, words, done, motors, tip)
            missing -= made
            silent = 0 if made else silent + 1
            if silent > PENDING - 2 and rows[0].shape[0]:
                return False
    return True
