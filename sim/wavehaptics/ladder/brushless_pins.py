# SPDX-License-Identifier: Apache-2.0
"""The controller ``pins`` of a brushless motor: its whole RTL at its pins, and a bridge of 3 legs.

ADC bits of two phases, encoder edges and six gates are what a board would see. The motor is
advanced where a gate changes, where the ADC samples and at the ends of ticks, by tables for whole
numbers of clocks.

A leg with both gates off, in dead time, follows its current through its diodes: a current out of
the leg comes from ground, one into it goes to the bus. One that has run out stays at zero until a
gate is on: the leg floats, as what a turning rotor adds to it is less than a diode's drop.
"""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np

from wavehaptics.controller import guard
from wavehaptics.controller.anchor import FOLLOWER_TICKS, SEEN_CELLS
from wavehaptics.controller.pins_timing import GATE_CLOCKS
from wavehaptics.controller.ports import Ports
from wavehaptics.ladder import pins_loop as loop
from wavehaptics.ladder import verilated
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.brushless import clear_sums, magnet_words, put_axes
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.ladder.turns_pins import new_ports
from wavehaptics.motor.brushless import (
    F_A,
    F_B,
    I_A,
    I_B,
    Q_A,
    Q_B,
    QF_A,
    QF_B,
    BrushlessPlant,
    along_q,
    brushless_step,
)
from wavehaptics.motor.plant import TIME, C, I, P, X
from wavehaptics.motor.sensor import (
    HOLD_S,
    NOISE,
    RESTARTS,
    held_output,
    hold_at_edge,
    new_holds,
    sample_code,
)
from wavehaptics.parts.adcs import Frame
from wavehaptics.runtime.compiled import compiled, compiled_drawing
from wavehaptics.runtime.native_call import call2
from wavehaptics.scene import Scene
from wavehaptics.trace.columns import Column, Word, put_anchor, put_estimate, put_port
from wavehaptics.words import formats
from wavehaptics.words.table import AXES, THREE_PHASE_LEGS, Values

_WAVE = formats.WAVE.step
_VOLT = formats.VOLTAGE.step
_ROOT3 = math.sqrt(3.0)

# Bits of the pins, as sim/verilated/ports_steps.h packs them; gates below.
_GATES = (1 << 6) - 1
_CS_N, _SCLK, _TICK, _CORE_VALID, _TOUCHING, _COMPLAINTS = range(6, 12)
_GUARD = _COMPLAINTS + 2
_ANCHOR_LOST = _GUARD + int(guard.Fault.ANCHOR)
# Places in the integers that the loop keeps, behind those of pins_loop, whose SHIFT and HELD are of
# phase a.
_SHIFT_B, _HELD_B, _DONE = range(loop.OFF_AT + 1, loop.OFF_AT + 4)
# Places in the words of a step: i, u, v and e of alpha and of beta, the limit, of the anchors c, χ
# and the lag of both, their fault, the position, whether a value was at its end, and the contact.
_ALPHA, _BETA, _LIMITED, _C, _CHI, _LAG, _LOST, _PLACE = 0, 4, 8, 9, 11, 13, 15, 16
_CLIPPED, _CONTACT = 17, 18
_STEP_I, _STEP_U, _STEP_V, _STEP_E = range(4)

BRUSHLESS_TOP = "wh_ports"

_RUN_OUT_A = 1e-12
"""A current that rounding leaves of none."""


@compiled(inline="always")
def _phase(z: np.ndarray, n: int) -> float:
    """Current of phase ``n`` out of its leg, A."""
    first: float = z[I_A]
    if n == 0:
        return first
    side: float = 0.5 * _ROOT3 * z[I_B]
    return -0.5 * first + (side if n == 1 else -side)


@compiled()
def _bridge(pins: int, currents: np.ndarray, bus: float, volts: np.ndarray) -> None:
    """Set the voltages of the three legs for the gates in ``pins``."""
    held, total = 0, 0.0
    for n in range(3):
        volts[n] = 0.0
        if (pins >> n) & 1 or (not (pins >> (n + 3)) & 1 and currents[n] < -_RUN_OUT_A):
            volts[n] = bus
        elif not (pins >> (n + 3)) & 1 and currents[n] <= _RUN_OUT_A:
            volts[n] = np.nan
            continue
        held += 1
        total += volts[n]
    # A leg that floats drives its phase by nothing: it is where the others' mean is.
    for n in range(3):
        if np.isnan(volts[n]):
            volts[n] = total / held if held else 0.0


@compiled(inline="always")
def _of_phases(volts: np.ndarray, a: float, b: float) -> float:
    """Sum over the legs of voltage by what flows out, which is ``a`` and ``b`` in α, β."""
    side = 0.5 * _ROOT3 * b
    drawn: float = volts[0] * a + volts[1] * (side - 0.5 * a) - volts[2] * (side + 0.5 * a)
    return drawn


@compiled()
def _end_run_out(z: np.ndarray, pins: int, before: np.ndarray) -> None:
    """Hold at zero the phases whose leg floats, or whose current ran out in the step.

    Along a phase and across it the windings know nothing of each other: what lies across stays.
    """
    ended = 0
    last = 0
    for n in range(3):
        if not (pins >> n) & 1 and not (pins >> (n + 3)) & 1:
            now = _phase(z, n)
            if abs(before[n]) <= _RUN_OUT_A or before[n] * now <= 0.0:
                ended += 1
                last = n
    if ended == 1:
        now = _phase(z, last)
        cos = 1.0 if last == 0 else -0.5
        sin = 0.0 if last == 0 else 0.5 * _ROOT3 if last == 1 else -0.5 * _ROOT3
        z[I_A] -= now * cos
        z[I_B] -= now * sin
    elif ended > 1:
        z[I_A] = z[I_B] = z[I] = 0.0


@compiled()
def _sensed(z: np.ndarray, kept: np.ndarray, n: int, holds: np.ndarray | None) -> float:
    """The current of phase ``n`` as its ADC gets it, A, but for noise and offset."""
    if holds is None:
        return _phase(z, n)
    else:
        return held_output(holds, n, kept[loop.NOW], _phase(z, n))


@compiled()
def leads_move(
    pins: int, currents: np.ndarray, clock: float, dt: float, sensor: np.ndarray,
    holds: np.ndarray | None,
) -> None:  # fmt: skip
    """Let the amplifiers of phases a and b hold their outputs at the edges of their own leads.

    A leg that floats is no edge: its lead is not driven.
    """
    if holds is not None:
        for n in range(2):
            high, low = (pins >> n) & 1, (pins >> (n + 3)) & 1
            if high or (not low and currents[n] < -_RUN_OUT_A):
                level = 1.0
            elif low or currents[n] > _RUN_OUT_A:
                level = -1.0
            else:
                continue
            hold_at_edge(
                holds, n, level, clock, currents[n], sensor[HOLD_S] / dt, sensor[RESTARTS]
            )  # fmt: skip


@compiled()
def _catch_up(
    z: np.ndarray, kept: np.ndarray, marks: np.ndarray, room: np.ndarray, tables: np.ndarray,
    steps: np.ndarray, floats: np.ndarray, ints: np.ndarray, load: np.ndarray, sensor: np.ndarray,
    holds: np.ndarray | None,
) -> None:  # fmt: skip
    """Advance the motor to the present clock. ``room`` is for three currents and three voltages.

    ``holds`` is the memory of amplifiers that hold, None without.
    """
    clocks = kept[loop.NOW] - kept[loop.ADVANCED]
    pins = kept[loop.PINS]
    currents, volts = room[0], room[1]
    # Dead time's currents run out within a step: its length is by how fast they do.
    floating = (pins | pins >> 3) & 7 != 7
    while clocks > 0:
        part = 1 if floating else min(clocks, ints[loop.SUBSTEP_CLOCKS])
        for n in range(3):
            currents[n] = _phase(z, n)
        bus = loop.held_bus(
            loop.bus_at(z[TIME] + 0.5 * part * floats[loop.DT], floats), floats, marks
        )
        _bridge(pins, currents, floats[loop.GAIN] * bus, volts)
        leads_move(pins, currents, kept[loop.NOW] - clocks, floats[loop.DT], sensor, holds)
        z[F_A] = (2.0 * volts[0] - volts[1] - volts[2]) / 3.0
        z[F_B] = (volts[1] - volts[2]) / _ROOT3
        charge_a, charge_b = z[Q_A], z[Q_B]
        brushless_step(z, tables[part], tables[part], steps[part], load)
        drawn = _of_phases(volts, z[Q_A] - charge_a, z[Q_B] - charge_b)
        loop.draw_charge(bus, drawn / (floats[loop.GAIN] * bus), floats, marks)
        if floating:
            _end_run_out(z, pins, currents)
        marks[loop.LOW] = min(marks[loop.LOW], z[I])
        marks[loop.HIGH] = max(marks[loop.HIGH], z[I])
        clocks -= part
    kept[loop.ADVANCED] = kept[loop.NOW]


@compiled()
def _close_tick(
    z: np.ndarray, kept: np.ndarray, marks: np.ndarray, pending: np.ndarray, angles: np.ndarray,
    floats: np.ndarray, ints: np.ndarray, load: np.ndarray,
) -> None:  # fmt: skip
    """Keep the row of the tick that ends now until its waves are known."""
    tick = ints[loop.TICK_CLOCKS] * floats[loop.DT]
    place = kept[loop.CLOSED] % loop.PENDING
    angles[place] = put_axes(
        pending[place], z, load, marks[loop.T0], tick, marks[loop.X0], marks[loop.HAND0],
        z[QF_A] / tick, z[QF_B] / tick, marks[loop.HIGH] - marks[loop.LOW],
    )  # fmt: skip
    kept[loop.CLOSED] += 1
    clear_sums(z)
    marks[loop.LOW] = marks[loop.HIGH] = z[I]
    marks[loop.X0], marks[loop.HAND0], marks[loop.T0] = z[X], z[P] + z[C], z[TIME]


@compiled()
def _emit(
    row: np.ndarray, words: np.ndarray, place: int, pending: np.ndarray, angles: np.ndarray,
    waves: np.ndarray, floats: np.ndarray, ints: np.ndarray,
) -> None:  # fmt: skip
    """A tick's row and words, of what the motor did and of the step that measured it."""
    for n in range(row.shape[0]):
        row[n] = pending[place, n]
    step, theta = waves[place], angles[place]
    eta = floats[loop.ETA_CONTACT] if step[_CONTACT] else floats[loop.ETA_FREE]
    u = along_q(step[_ALPHA + _STEP_U], step[_BETA + _STEP_U], theta) * _WAVE
    v = along_q(step[_ALPHA + _STEP_V], step[_BETA + _STEP_V], theta) * _WAVE
    largest = max(abs(step[_ALPHA + _STEP_U]), abs(step[_BETA + _STEP_U]))
    limited = largest >= ints[loop.U_MAX]
    if ints[loop.ANCHORED]:
        limited = step[_LIMITED] != 0  # which isn't the same in every tick
        # The voltage of the measured tick was made in the step before.
        made = waves[(place - 1) % loop.PENDING]
        put_anchor(row, along_q(made[_C], made[_C + 1], theta) * _VOLT, step[_LOST])
        chi = along_q(step[_CHI], step[_CHI + 1], theta) * SEEN_CELLS
        lag = along_q(step[_LAG], step[_LAG + 1], theta) * SEEN_CELLS * floats[loop.CELL]
        put_estimate(
            row, chi, (ints[loop.START_COUNT] + step[_PLACE] + 0.5 - chi) * floats[loop.CELL],
            lag / (FOLLOWER_TICKS * ints[loop.TICK_CLOCKS] * floats[loop.DT]),
        )  # fmt: skip
        if step[_LOST]:
            eta = 0.0
    put_port(row, eta, u, v, step[_CONTACT], limited, step[_CLIPPED] != 0)
    words[Word.I] = step[_ALPHA + _STEP_I]
    words[Word.U] = step[_ALPHA + _STEP_U]
    words[Word.V] = step[_ALPHA + _STEP_V]
    words[Word.E] = step[_ALPHA + _STEP_E]


@compiled(inline="always")
def _wires(
    z: np.ndarray, kept: np.ndarray, pins: int, changed: int, ints: np.ndarray, sensor: np.ndarray,
    rng: np.random.Generator, holds: np.ndarray | None,
) -> None:  # fmt: skip
    """What both ADCs do at this change of the pins: they hold their inputs, or put out a bit."""
    if changed & 1 << _CS_N:
        if not pins & 1 << _CS_N:
            middle = 1 << (ints[loop.DATA_BITS] - 1)
            noisy = sensor[NOISE] > 0.0
            noise = rng.standard_normal() if noisy else 0.0
            code = sample_code(_sensed(z, kept, 0, holds), sensor, noise) + middle
            noise = rng.standard_normal() if noisy else 0.0
            code_b = sample_code(_sensed(z, kept, 1, holds), sensor, noise) + middle
            # Bit 63 is on the wire; a late part puts out the code that it held before.
            late = ints[loop.PIPELINE]
            kept[loop.SHIFT] = (kept[loop.HELD] if late else code) << ints[loop.CODE_SHIFT]
            kept[_SHIFT_B] = (kept[_HELD_B] if late else code_b) << ints[loop.CODE_SHIFT]
            kept[loop.HELD], kept[_HELD_B] = code, code_b
    elif changed & 1 << _SCLK and (pins >> _SCLK) & 1 == ints[loop.LAUNCH_LEVEL]:
        kept[loop.SHIFT] <<= 1
        kept[_SHIFT_B] <<= 1


@compiled(inline="always")
def _inputs(kept: np.ndarray) -> int:
    """Levels of the ADCs' wires and of the encoder."""
    inputs: int = (
        ((kept[loop.SHIFT] >> 63) & 1)
        | ((kept[_SHIFT_B] >> 63) & 1) << 1
        | loop.encoder_levels(kept[loop.COUNT]) << 1
    )
    return inputs


@compiled_drawing
def rest(
    z: np.ndarray, kept: np.ndarray, ints: np.ndarray, sensor: np.ndarray, rng: np.random.Generator,
    clocks: int,
) -> int:  # fmt: skip
    """Clock a board with the motor at rest; the clocks until a gate went on, else ``clocks``."""
    for n in range(clocks):
        pins = call2(ints[loop.CLOCK], ints[loop.MODEL], _inputs(kept))
        changed = kept[loop.PINS] ^ pins
        kept[loop.PINS] = pins
        _wires(z, kept, pins, changed, ints, sensor, rng, None)
        if pins & _GATES:
            return n
    return clocks


@compiled_drawing
def _advance(
    rows: np.ndarray, words: np.ndarray, z: np.ndarray, kept: np.ndarray, marks: np.ndarray,
    room: np.ndarray, pending: np.ndarray, angles: np.ndarray, waves: np.ndarray,
    tables: np.ndarray, steps: np.ndarray, ints: np.ndarray, floats: np.ndarray, load: np.ndarray,
    sensor: np.ndarray, rng: np.random.Generator, buffer: np.ndarray, holds: np.ndarray | None,
) -> bool:  # fmt: skip
    """Clock the RTL until ``rows`` are filled; False if its core falls silent."""
    done = 0
    dt, cell, end_s = floats[loop.DT], floats[loop.CELL], floats[loop.ENCODER_END]
    while done < rows.shape[0]:
        if kept[loop.NOW] >= kept[loop.NEXT_LOOK]:
            loop.next_edge(z, kept, cell, dt, end_s, None)
        pins = call2(ints[loop.CLOCK], ints[loop.MODEL], _inputs(kept))
        changed = kept[loop.PINS] ^ pins
        if changed & _GATES:
            _catch_up(z, kept, marks, room, tables, steps, floats, ints, load, sensor, holds)
            loop.next_edge(z, kept, cell, dt, end_s, None)
        kept[loop.PINS] = pins
        if changed & ~pins & 1 << _CS_N:
            _catch_up(z, kept, marks, room, tables, steps, floats, ints, load, sensor, holds)
        _wires(z, kept, pins, changed, ints, sensor, rng, holds)
        if pins & 1 << _CORE_VALID:
            call2(ints[loop.WORDS], ints[loop.MODEL], buffer.ctypes.data)
            step = waves[kept[loop.EMITTED] % loop.PENDING]
            for n in range(_CONTACT):
                step[n] = buffer[n]
            step[_CONTACT] = (pins >> _TOUCHING) & 1
            kept[loop.EMITTED] += 1
        if pins & 1 << _TICK:
            # The strobe marks the carrier's last clock of a tick; the gates follow it later.
            kept[loop.FAULTS] |= pins >> _COMPLAINTS
            kept[loop.TICK_START] = kept[loop.NOW] + 1 + GATE_CLOCKS
        kept[loop.NOW] += 1
        if kept[loop.NOW] == kept[loop.TICK_START]:
            _catch_up(z, kept, marks, room, tables, steps, floats, ints, load, sensor, holds)
            _close_tick(z, kept, marks, pending, angles, floats, ints, load)
            if pins >> _GUARD:
                # No steps while the gates are off, so no waves: the rows show what the motor does.
                if kept[loop.OFF_AT] == 0:
                    kept[loop.OFF_AT] = kept[loop.NOW]
                if kept[loop.EMITTED] < kept[loop.CLOSED]:
                    call2(ints[loop.WORDS], ints[loop.MODEL], buffer.ctypes.data)
                    step = waves[kept[loop.EMITTED] % loop.PENDING]
                    for n in range(_CONTACT):
                        step[n] = buffer[n]
                    step[: _LIMITED + 1] = 0
                    step[_LOST] = (pins >> _ANCHOR_LOST) & 1
                    step[_CONTACT] = (pins >> _TOUCHING) & 1
                    kept[loop.EMITTED] += 1
            if kept[loop.CLOSED] - kept[loop.EMITTED] > loop.PENDING - 2:
                return False
        if kept[_DONE] < min(kept[loop.CLOSED], kept[loop.EMITTED]):
            _emit(
                rows[done],
                words[done],
                kept[_DONE] % loop.PENDING,
                pending,
                angles,
                waves,
                floats,
                ints,
            )
            kept[_DONE] += 1
            done += 1
    return True


class BrushlessPinsSimulation(PinsSimulation):
    """A scene's brushless motor on the whole of its RTL, with a switching bridge of three legs."""

    TOP = BRUSHLESS_TOP
    SHIM = "ports_shim.cpp"
    SHOWS: tuple[str, ...] = ("ports_steps.vlt",)
    PREFIX = "wh_ports"
    LEGS = THREE_PHASE_LEGS
    INPUTS_SHIFT = 1
    KEPT = _DONE + 1

    def __init__(self, scene: Scene, *, host: bool = False) -> None:
        super().__init__(scene, host=host)
        self._kept[_HELD_B] = self._kept[loop.HELD]
        self._angles = np.zeros(loop.PENDING)
        self._buffer = np.zeros(_CONTACT + 1, dtype=np.int64)
        self._waves = np.zeros((loop.PENDING, len(self._buffer)), dtype=np.int64)
        self._room = np.zeros((2, 3))
        self._holds = new_holds(2) if self.sensor.edge_hold_s else None

    def _ports_of(self, scene: Scene, most_samples: int) -> Ports:
        refuse(scene, "pins", device=self.TOP != BRUSHLESS_TOP)
        return super()._ports_of(scene, most_samples)

    def _plant_of(self, scene: Scene) -> BrushlessPlant:
        return BrushlessPlant.of_scene(scene)

    def _idle_pins(self, frame: Frame) -> int:
        return 1 << _CS_N | frame.sclk_idle << _SCLK

    def _imperfections(self, scene: Scene, *, always: bool = False) -> None:
        """It has none yet."""

    def _hardware(self, scene: Scene, ports: Ports, host: bool) -> dict[str, int]:
        sections = len(self.settings.shaper.words)
        pulse = scene.drive is not None and bool(scene.drive.min_pulse_s)
        return {"MIN_PULSE": int(pulse), "SHAPER": sections}

    def _stations(self, scene: Scene) -> dict[str, int]:
        return {}

    def _parameters(self) -> dict[str, int]:
        return {"N": AXES, "AXES": 1}

    def _magnet(self, scene: Scene, ports: Ports) -> Values:
        return magnet_words(scene, self.settings, ports.start_count)

    def _port_words(self, design: verilated.Design) -> ctypes.Array[ctypes.c_uint32]:
        return (ctypes.c_uint32 * 0)()  # they are written

    def _new_model(self, words: ctypes.Array[ctypes.c_uint32], inputs: int) -> int | None:
        return new_ports(self._library, self._design.sizes, [self._values] * AXES, inputs)

    def warm(self, plant: Any) -> None:
        steps_s = [n * self._dt for n in range(self._longest + 1)]
        self._load = plant.words()
        self._tables = np.stack([plant.axis_table(step_s) for step_s in steps_s])
        self._steps = np.stack([plant.step_words(step_s) for step_s in steps_s])

    def forget_the_past(self) -> None:
        """Let time begin with the tick that runs."""
        before = self._sums[loop.T0]
        self._state[TIME] -= before
        self._sums[loop.T0] = 0.0
        self._sums[loop.X0], self._sums[loop.HAND0] = (
            self._state[X],
            self._state[P] + self._state[C],
        )
        self._pending[:, Column.T] -= before

    @property
    def step_words(self) -> list[int]:
        """i, u, v and e of α, then of β, and the contact, of the step that made the newest row."""
        step = self._waves[(int(self._kept[_DONE]) - 1) % loop.PENDING]
        return [*step[: 2 * _BETA].tolist(), int(step[_CONTACT])]

    def advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column) and ``words`` (Word)."""
        done = _advance(
            rows, words, self._state, self._kept, self._sums, self._room, self._pending,
            self._angles, self._waves, self._tables, self._steps, self._ints, self._floats,
            self._load, self._sensor, self._rng, self._buffer, self._holds,
        )  # fmt: skip
        if not done:
            raise RuntimeError("the controller's RTL stopped answering")
