# SPDX-License-Identifier: Apache-2.0
"""The motors of a device in one loop, a step a tick, with a hand at their tip.

``golden``: the port of each as integers, as in :mod:`wavehaptics.ladder.sampled`, and between
environment and λ filter the surfaces of the group (:mod:`wavehaptics.controller.surfaces`).

``analog``: the same law in real numbers and in steps of at most a tenth of 1/λ, with the motors'
true angles and currents. A discrete port that takes the mean current has the delay T/a
(:func:`wavehaptics.laws.closed_forms.tau`), so that ``a = λ·dt`` has 1/λ for whatever dt. It has
neither encoder nor ADC nor port anchor, and no budget of energy.

Both get their planes from the same host, as late as the scene says.

``encoder``: the usual way, a Cartesian spring at the rate of ``[servo]``. It reads the encoders,
makes a force of the depth in each surface, brings it to the motors by Jᵀ, and the current
amplifiers of :mod:`wavehaptics.ladder.encoder` make it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from wavehaptics.controller import anchor, coupling, surfaces, wave_core
from wavehaptics.controller.planes import Planes, as_words
from wavehaptics.controller.settings import IDEAL_ANCHOR_CELL_RAD, settings
from wavehaptics.ladder.analog import inside
from wavehaptics.ladder.encoder import amplifier_step, check_rates
from wavehaptics.ladder.joint_host import Events, JointLoop
from wavehaptics.laws.kinematics import put_tip, put_tip_force
from wavehaptics.motor.imperfections import (
    AMPLIFIED,
    LAG,
    LAG_TABLE,
    MOTOR,
    amplified,
    counted,
    real_parts,
    supplied,
)
from wavehaptics.motor.plant import OMEGA, TIME, I, Plant, X, load_words
from wavehaptics.motor.sensor import (
    LAG_RATE,
    NOISE_SEED,
    Sensor,
    current_word,
    draw_noise,
    lagged,
    noise_at,
    range_ends,
)
from wavehaptics.motor.step import motor_step
from wavehaptics.motor.tip_hand import hand_room, hand_substeps, hand_words, put_hand_torque
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Device, Scene, drive_gain, encoder_end, without_anchor
from wavehaptics.scene.tables.servo import Servo
from wavehaptics.trace.columns import Word, put_anchor, put_estimate, put_motion, put_port
from wavehaptics.trace.tip import put_tip_row
from wavehaptics.words import formats

_VOLT = formats.VOLTAGE.step
_ROOT_WATT = formats.WAVE.step
_ETA = formats.ETA.step
_ETA_Q = formats.ETA.fraction
_ETA_ONE = 1 << _ETA_Q
_LONG_GUARD = formats.LONG_GUARD
_PORTS = surfaces.PORTS

OF_LAMBDA = 0.1
"""Longest step of ``analog`` in parts of 1/λ."""

# Columns of what each port has in integers, and in floats.
_A, _EXTRA, _ETA_CONTACT, _ETA_FREE, _HYSTERESIS, _ROOT, _U_MAX, _ANCHORED = range(8)
(
    _CELL, _GAIN, _K_T, _RESISTANCE, _ENCODER_END, _S, _LIMIT, _FREE, _CONTACT, _A_PART,
) = range(10)  # fmt: skip
# Columns of what each port keeps.
_VOLTAGE_WORD, _POSITION, _WAVE_VOLTAGE, _CORRECTION = range(4)
# Rows of the tick's sums of each motor, (_SUMS, motors).
(
    _CHARGE, _SQUARE, _LOW, _HIGH, _X_BEFORE, _LAG_BEFORE, _VOLTS, _SAG, _FLUX, _WORK, _STEP,
    _WAVE, _LIMITED,
) = range(13)  # fmt: skip
_SUMS = 13
# Rows of what the law in real numbers has of each port, (_LAW, PORTS): angle in cells, mean
# current, wall velocities, v before it is reflected, η of a wall of the port's own.
_PLACE, _CURRENT, _VELOCITY, _RAW, _WALL = range(5)
_LAW = 5
# What a surface keeps: in contact, its filter's f, what of ε the currents were at the beginning.
_TOUCHED, _FILTERED, _REST = range(3)
# Rows of the room for places and forces, (_ROOM, 3): the first three are put_hand_torque's.
_BEFORE, _AFTER, _FORCE = 3, 4, 5
_ROOM = 6


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _move(
    states: np.ndarray, dt: float, arm: tuple[np.ndarray, ...], motors: tuple[Any, ...],
    sums: np.ndarray, q: np.ndarray, omega: np.ndarray, jacobian: np.ndarray, room: np.ndarray,
    torque: np.ndarray,
) -> None:  # fmt: skip
    """A step of ``dt`` s of all motors at the voltages in ``sums``, with the hand in its middle."""
    geometry, hand = arm
    matrices, loads, reals, sensors = motors
    for n in range(states.shape[0]):
        q[n] = states[n, X] + 0.5 * dt * states[n, OMEGA]
        omega[n] = states[n, OMEGA]
    put_hand_torque(geometry, hand, states[0, TIME] + 0.5 * dt, q, omega, jacobian, room, torque)
    for n in range(states.shape[0]):
        state, real = states[n], reals[n]
        before = state[I]
        charge, square = motor_step(
            state, matrices[n], dt, sums[_VOLTS, n], loads[n], real[MOTOR], -torque[n]
        )
        if sensors[n, LAG_RATE] != 0.0:
            real[LAG][AMPLIFIED] = lagged(
                real[LAG][AMPLIFIED], before, state[I], charge / dt, real[LAG_TABLE][0]
            )
        sums[_STEP, n] = charge
        sums[_CHARGE, n] += charge
        sums[_FLUX, n] += sums[_VOLTS, n] * dt
        sums[_WORK, n] += sums[_VOLTS, n] * charge
        sums[_SQUARE, n] += square
        sums[_LOW, n] = min(sums[_LOW, n], state[I])
        sums[_HIGH, n] = max(sums[_HIGH, n], state[I])


@compiled(inline="always")
def _begin(states: np.ndarray, sums: np.ndarray, motors: tuple[Any, ...]) -> None:
    """The first moment of a tick."""
    for n in range(states.shape[0]):
        sums[_CHARGE, n] = sums[_SQUARE, n] = sums[_FLUX, n] = sums[_WORK, n] = 0.0
        sums[_LOW, n] = sums[_HIGH, n] = states[n, I]
        sums[_X_BEFORE, n] = states[n, X]
        sums[_LAG_BEFORE, n] = motors[2][n][LAG][AMPLIFIED]


@compiled(inline="always")
def _put_motors(
    rows: np.ndarray, n: int, tip_row: np.ndarray, begin: float, tick: float, states: np.ndarray,
    floats: np.ndarray, sums: np.ndarray, arm: tuple[np.ndarray, ...], q: np.ndarray,
    jacobian: np.ndarray, room: np.ndarray, torque: np.ndarray, active: int,
) -> None:  # fmt: skip
    """The motors' part of a tick's rows, and the tip's."""
    for motor in range(states.shape[0]):
        mean, k_t = sums[_CHARGE, motor] / tick, floats[motor, _K_T]
        put_motion(
            rows[motor, n], begin, tick, sums[_X_BEFORE, motor], states[motor, X], mean,
            sums[_FLUX, motor] / tick - sums[_SAG, motor] * mean, k_t * mean, 0.0,
            sums[_WORK, motor] - floats[motor, _RESISTANCE] * sums[_SQUARE, motor],
            sums[_HIGH, motor] - sums[_LOW, motor],
        )  # fmt: skip
        torque[motor] = k_t * mean
        q[motor] = sums[_X_BEFORE, motor]
    put_tip(arm[0], q, room[_BEFORE])
    for motor in range(states.shape[0]):
        q[motor] = states[motor, X]
    put_tip(arm[0], q, room[_AFTER])
    put_tip_force(jacobian, torque, room[_FORCE])
    put_tip_row(tip_row, begin, tick, room[_BEFORE], room[_AFTER], room[1], room[_FORCE], active)


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _advance_golden(
    rows: np.ndarray, words: np.ndarray, tips: np.ndarray, states: np.ndarray, kept: np.ndarray,
    cores: np.ndarray, lines: np.ndarray, contacts: np.ndarray, walls: tuple[np.ndarray, ...],
    anchors: tuple[np.ndarray, ...], group: tuple[np.ndarray, ...], between: tuple[np.ndarray, ...],
    ints: np.ndarray, floats: np.ndarray, dt: float, substeps: int, arm: tuple[np.ndarray, ...],
    motors: tuple[Any, ...], noises: np.ndarray, sums: np.ndarray, q: np.ndarray, omega: np.ndarray,
    jacobian: np.ndarray, room: np.ndarray, torque: np.ndarray,
) -> None:  # fmt: skip
    """Fill the rows, the words and the tip's rows; ``group`` is what the surfaces have, ``between``
    the line of a virtual shaft and its next row, −1 without one."""
    line, line_at = between
    surface_states, spent, active, planes, vectors, limits, positions, currents, waves = group
    wall_min, wall_max = walls
    anchor_words, anchor_states = anchors
    reals, sensors = motors[2], motors[3]
    count_ = states.shape[0]
    tick = dt * substeps
    for n in range(tips.shape[0]):
        begin = states[0, TIME]
        _begin(states, sums, motors)
        for motor in range(count_):
            e_a = kept[motor, _VOLTAGE_WORD] * _VOLT * floats[motor, _GAIN]
            sums[_VOLTS, motor], sums[_SAG, motor] = supplied(e_a, begin, reals[motor])
        for _ in range(substeps):
            _move(states, dt, arm, motors, sums, q, omega, jacobian, room, torque)
        free, faulty = _ETA_ONE, False
        for motor in range(count_):
            state, real, sensor = states[motor], reals[motor], sensors[motor]
            sensed = amplified(
                sums[_CHARGE, motor] / tick, 0, sums[_LAG_BEFORE, motor], tick, sums[_VOLTS, motor],
                state[TIME], sensor, real,
            )  # fmt: skip
            current = current_word(sensed, sensor, noise_at(noises[motor], n))
            ends = range_ends(current, sensor)
            kept[motor, _POSITION] = counted(
                kept[motor, _POSITION], state[X], state[TIME], floats[motor, _CELL],
                floats[motor, _ENCODER_END], real,
            )  # fmt: skip
            touching, _ = wave_core.contact_step(
                contacts[motor], kept[motor, _POSITION], wall_min[motor], wall_max[motor],
                ints[motor, _HYSTERESIS] != 0,
            )  # fmt: skip
            if ints[motor, _ANCHORED] != 0:
                held = anchor_states[motor]
                current = wave_core.saturate(current - held[anchor.OFFSET])
                faulty = faulty or held[anchor.FAULT] != 0
            positions[motor], currents[motor] = kept[motor, _POSITION], current
            u_n, v_n = wave_core.incoming(
                cores[motor], lines[motor], current, ints[motor, _ROOT], ints[motor, _EXTRA], ends
            )
            waves[motor] = v_n
            if touching:
                waves[motor] = wave_core.saturate(
                    wave_core.truncate(ints[motor, _ETA_CONTACT] * v_n, _ETA_Q)
                )
            free = min(free, ints[motor, _ETA_FREE])
            row = words[motor, n]
            row[Word.I], row[Word.U], row[Word.V] = current, u_n, v_n
        acting = 0
        if not faulty and line_at[0] >= 0:
            coupling.cross(line, line_at, waves)
            acting = 1
        elif not faulty:
            acting = surfaces.surfaces_step(
                surface_states, spent, active, planes, vectors, limits, positions, currents, free,
                waves,
            )  # fmt: skip
        for motor in range(count_):
            core, row = cores[motor], words[motor, n]
            current, u_n, v_n = row[Word.I], row[Word.U], row[Word.V]
            walled = contacts[motor, 0] >= 0
            touching = walled or acting > 0
            eta, outside, shown = ints[motor, _ETA_FREE], 0, ints[motor, _ETA_FREE]
            if walled:
                eta = shown = ints[motor, _ETA_CONTACT]
            if faulty:
                eta = shown = 0
            elif acting > 0:
                eta, outside, shown = 0, waves[motor], -_ETA_ONE
            left_u = ints[motor, _U_MAX]
            withheld = core[wave_core.STATE_WITHHELD]
            saturated = core[wave_core.STATE_SATURATED] != 0
            held = anchor_states[motor]
            if ints[motor, _ANCHORED] != 0:
                left_u = anchor.left(left_u, held)
            e_next = wave_core.outgoing(
                core, lines[motor], v_n, eta, outside, ints[motor, _ROOT], ints[motor, _A], left_u,
                ints[motor, _EXTRA],
            )  # fmt: skip
            if ints[motor, _ANCHORED] != 0:
                correction = held[anchor.CORRECTION]
                anchor.anchor_step(
                    held, anchor_words[motor], kept[motor, _POSITION], touching, current, u_n, v_n,
                    withheld, kept[motor, _WAVE_VOLTAGE], saturated,
                    core[wave_core.STATE_CLIPPED] != 0,
                )  # fmt: skip
                kept[motor, _WAVE_VOLTAGE] = e_next
                e_next = wave_core.saturate(e_next + correction)
                out, cell = rows[motor, n], floats[motor, _CELL]
                put_anchor(out, kept[motor, _CORRECTION] * _VOLT, held[anchor.FAULT])
                kept[motor, _CORRECTION] = correction
                chi = (held[anchor.CHI] >> _LONG_GUARD) * anchor.SEEN_CELLS
                lag = (held[anchor.LAG] >> _LONG_GUARD) * anchor.SEEN_CELLS
                put_estimate(
                    out, chi, (kept[motor, _POSITION] + 0.5 - chi) * cell,
                    lag * cell / (anchor.FOLLOWER_TICKS * tick),
                )  # fmt: skip
            row[Word.E] = e_next
            kept[motor, _VOLTAGE_WORD] = e_next
            put_port(
                rows[motor, n], shown * _ETA, u_n * _ROOT_WATT, v_n * _ROOT_WATT, touching,
                core[wave_core.STATE_SATURATED] != 0, core[wave_core.STATE_CLIPPED] != 0,
            )  # fmt: skip
        _put_motors(
            rows, n, tips[n], begin, tick, states, floats, sums, arm, q, jacobian, room, torque,
            acting,
        )  # fmt: skip


@compiled(inline="always")
def _along(words: np.ndarray, first: int, ports: np.ndarray) -> float:
    total = 0.0
    for port in range(_PORTS):
        total += words[first + port] * ports[port]
    return total


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _reflect(
    touching: np.ndarray, memory: np.ndarray, planes: np.ndarray, vectors: np.ndarray, most: float,
    law: np.ndarray, free: float, waves: np.ndarray,
) -> int:  # fmt: skip
    """The law of :mod:`wavehaptics.controller.surfaces` in real numbers; how many surfaces act.

    ``touching`` int64 (MOST_ACTIVE,) are their numbers, ``memory`` (MOST_SURFACES, 3) what each
    keeps and ``law`` float64 (_LAW, PORTS) what the ports have.
    """
    acting = 0
    for surface in range(planes.shape[0]):
        plane = planes[surface]
        if plane[surfaces.PRESENT] == 0.0 or acting == surfaces.MOST_ACTIVE or (
            _along(plane, surfaces.G, law[_PLACE]) < plane[surfaces.D]
        ):  # fmt: skip
            memory[surface, _FILTERED] = memory[surface, _TOUCHED] = 0.0
            continue
        if memory[surface, _TOUCHED] == 0.0:
            memory[surface, _TOUCHED] = 1.0
            memory[surface, _REST] = _along(plane, surfaces.C, law[_CURRENT])
        touching[acting] = surface
        acting += 1
    if acting == 0:
        return 0
    if acting == 1:
        memory[touching[0], _REST] = 0.0
    for order in range(acting):
        plane = planes[touching[order]]
        error = _along(plane, surfaces.G, law[_PLACE]) - plane[surfaces.D]
        error += _along(plane, surfaces.C, law[_CURRENT]) - memory[touching[order], _REST]
        beyond = max(error - 0.5, 0.0) + min(error + 0.5, 0.0)
        law[_VELOCITY, order] = min(max(-plane[surfaces.GAIN] * beyond, -most), most)
    eta = min(free, planes[touching[0], surfaces.ACROSS]) if acting == 1 else free
    for port in range(_PORTS):
        law[_RAW, port] = waves[port]
        waves[port] *= eta
    for order in range(acting):
        surface, row = touching[order], touching[order]
        if order == 1:
            row = surfaces.PAIR_ROW[touching[0], surface]
        elif order == 2:
            row = surfaces.TRIPLE_ROW[touching[0], touching[1], surface]
        vector, plane, velocity = vectors[row], planes[surface], 0.0
        taken, p = _along(vector, 0, waves), _along(vector, 0, law[_RAW])
        for share in range(order + 1):
            velocity += vector[surfaces.MIX + share] * law[_VELOCITY, share]
        goal = plane[surfaces.ETA] * p
        memory[surface, _FILTERED] += plane[surfaces.A] * (goal - memory[surface, _FILTERED])
        y = memory[surface, _FILTERED] + min(max(velocity, -most), most)
        for port in range(_PORTS):
            waves[port] += vector[port] * (y - taken)
    return acting


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _advance_analog(
    rows: np.ndarray, tips: np.ndarray, states: np.ndarray, kept: np.ndarray,
    walls: tuple[np.ndarray, ...], group: tuple[np.ndarray, ...], floats: np.ndarray, dt: float,
    substeps: int, arm: tuple[np.ndarray, ...], motors: tuple[Any, ...], sums: np.ndarray,
    q: np.ndarray, omega: np.ndarray, jacobian: np.ndarray, room: np.ndarray, torque: np.ndarray,
) -> None:  # fmt: skip
    """Fill the rows and the tip's rows."""
    touching, memory, planes, vectors, most, law, waves = group
    wall_min, wall_max = walls
    reals, count_ = motors[2], states.shape[0]
    tick = dt * substeps
    for n in range(tips.shape[0]):
        begin = states[0, TIME]
        _begin(states, sums, motors)
        acting = 0
        for motor in range(count_):
            sums[_LIMITED, motor] = sums[_WAVE, motor] = 0.0
        for _ in range(substeps):
            free = 1.0
            for motor in range(count_):
                e_a = floats[motor, _GAIN] * floats[motor, _S] * kept[motor]
                sums[_VOLTS, motor], sums[_SAG, motor] = supplied(
                    e_a, states[motor, TIME], reals[motor]
                )
                sums[_WAVE, motor] += kept[motor] * dt
                free = min(free, floats[motor, _FREE])
            _move(states, dt, arm, motors, sums, q, omega, jacobian, room, torque)
            for motor in range(count_):
                x, mean = states[motor, X], sums[_STEP, motor] / dt
                law[_PLACE, motor], law[_CURRENT, motor] = x / floats[motor, _CELL], mean
                law[_WALL, motor] = 1.0
                if inside(x, wall_min[motor], wall_max[motor]):
                    law[_WALL, motor] = floats[motor, _CONTACT]
                waves[motor] = law[_WALL, motor] * (kept[motor] - floats[motor, _S] * mean)
            acting = _reflect(touching, memory, planes, vectors, most[0], law, free, waves)
            for motor in range(count_):
                goal = waves[motor]
                if acting == 0 and law[_WALL, motor] == 1.0:
                    goal *= floats[motor, _FREE]
                wanted = kept[motor] + floats[motor, _A_PART] * (goal - kept[motor])
                limit = floats[motor, _LIMIT]
                kept[motor] = min(max(wanted, -limit), limit)
                if kept[motor] != wanted:
                    sums[_LIMITED, motor] = 1.0
        for motor in range(count_):
            u = sums[_WAVE, motor] / tick
            walled = law[_WALL, motor] != 1.0
            eta = -1.0 if acting > 0 else law[_WALL, motor] if walled else floats[motor, _FREE]
            put_port(
                rows[motor, n], eta, u, u - floats[motor, _S] * sums[_CHARGE, motor] / tick,
                walled or acting > 0, sums[_LIMITED, motor] != 0.0,
            )  # fmt: skip
        _put_motors(
            rows, n, tips[n], begin, tick, states, floats, sums, arm, q, jacobian, room, torque,
            acting,
        )  # fmt: skip


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _advance_encoder(
    rows: np.ndarray, tips: np.ndarray, states: np.ndarray, kept: np.ndarray, commands: np.ndarray,
    acting: int, amplifiers: np.ndarray, floats: np.ndarray, dt: float, substeps: int,
    arm: tuple[np.ndarray, ...], motors: tuple[Any, ...], sums: np.ndarray, q: np.ndarray,
    omega: np.ndarray, jacobian: np.ndarray, room: np.ndarray, torque: np.ndarray,
) -> None:  # fmt: skip
    """Fill the rows and the tip's rows; ``kept`` float64 (2, motors) are voltages and integrals,
    ``commands`` (motors,) in A."""
    count_ = states.shape[0]
    tick = dt * substeps
    for n in range(tips.shape[0]):
        begin = states[0, TIME]
        _begin(states, sums, motors)
        for motor in range(count_):
            e_a = kept[0, motor] * floats[motor, _GAIN]
            sums[_VOLTS, motor], sums[_SAG, motor] = supplied(e_a, begin, motors[2][motor])
        for _ in range(substeps):
            _move(states, dt, arm, motors, sums, q, omega, jacobian, room, torque)
        for motor in range(count_):
            voltage, asked, kept[1, motor] = amplifier_step(
                commands[motor] - states[motor, I], kept[1, motor], amplifiers[motor, 0],
                amplifiers[motor, 1], amplifiers[motor, 2], tick,
            )  # fmt: skip
            kept[0, motor] = voltage
            put_port(rows[motor, n], 0.0, 0.0, 0.0, acting > 0, voltage != asked)
        _put_motors(
            rows, n, tips[n], begin, tick, states, floats, sums, arm, q, jacobian, room, torque,
            acting,
        )  # fmt: skip


class JointSimulation(JointLoop):
    """The motors of ``device`` with a hand at their tip on ``analog``, ``golden`` or ``encoder``.

    :class:`~wavehaptics.scene.SceneError` where a servo's rate doesn't fit the tick.
    """

    def __init__(self, device: Device, controller: str) -> None:
        assert device.space is not None
        space = device.space
        self.golden = controller == "golden"
        self._servo = controller == "encoder"
        scenes = device.scenes if self.golden else [without_anchor(one) for one in device.scenes]
        settings_ = [
            settings(scene, cell_rad=None if scene.encoder else IDEAL_ANCHOR_CELL_RAD)
            for scene in scenes
        ]
        tick_s = settings_[0].tick_s
        plants = [Plant.of_scene(scene) for scene in scenes]
        self._substeps = max(plant.substeps(tick_s) for plant in plants)
        self._substeps *= hand_substeps(plants, space, tick_s / self._substeps)
        if not self.golden and not self._servo:
            fastest = max(scene.controller.lambda_ for scene in scenes)
            self._substeps *= math.ceil(tick_s / self._substeps * fastest / OF_LAMBDA - 1e-9)
        self._dt = tick_s / self._substeps
        super().__init__(
            space, scenes, settings_, None if self.golden else self._dt, servo=self._servo
        )
        self._prepare(scenes, plants)
        if self._servo:
            servo = scenes[0].servo or Servo()
            every, _ = check_rates(scenes[0])
            self._servo_s = every * self.tick_s
            start = space.arm.tip(0.5 * self._floats[:, _CELL])[None, :]
            self._depths = np.array([shape.depth(start)[0][0] for shape in space.shapes])
            self._events = Events(every, servo.delay_s / self.tick_s, 0.0)
        else:
            self._events = self.updates()
        self._commit(self._look())  # the host knows where the arm is before the run

    def _prepare(self, scenes: Sequence[Scene], plants: Sequence[Plant]) -> None:
        motors = len(plants)
        self._states = np.array([plant.start for plant in plants])
        reals = tuple(
            real_parts(scene, plant, set_.cell_rad, [self._dt], always=True)
            for scene, plant, set_ in zip(scenes, plants, self.settings, strict=True)
        )
        sensors = np.array([
            Sensor.of_scene(scene).constants() if self.golden else Sensor(ideal=True).constants()
            for scene in scenes
        ])  # fmt: skip
        self._motors: tuple[Any, ...] = (
            np.array([plant.transition(self._dt) for plant in plants]),
            np.array([load_words(plant) for plant in plants]), reals, sensors,
        )  # fmt: skip
        self._arm = (self.space.arm.geometry, hand_words(self.space))
        self._floats = np.array([
            [set_.cell_rad, drive_gain(scene), plant.k_t, plant.resistance, encoder_end(scene),
             set_.s, set_.limit_v / set_.s, scene.controller.eta_free, scene.controller.eta_contact,
             self._dt * scene.controller.lambda_]
            for scene, plant, set_ in zip(scenes, plants, self.settings, strict=True)
        ])  # fmt: skip
        self._ints = np.array([
            [set_.a, set_.extra_ticks, set_.eta_contact, set_.eta_free, set_.edge_hysteresis,
             set_.root, set_.u_max, set_.anchored]
            for set_ in self.settings
        ], dtype=np.int64)  # fmt: skip
        most = max(len(set_.wall_min) for set_ in self.settings)
        walls = np.full((2, motors, most), 1 << 62, dtype=np.int64)
        for n, set_ in enumerate(self.settings):
            walls[0, n, : len(set_.wall_min)] = set_.wall_min
            walls[1, n, : len(set_.wall_max)] = set_.wall_max
        cells = self._floats[None, :, None, _CELL]
        self._walls = (walls[0], walls[1]) if self.golden else tuple(walls * cells)
        self._room = np.zeros((_SUMS, motors)), *hand_room(motors, _ROOM)
        if self._servo:
            omegas = [2.0 * math.pi * (scene.servo or Servo()).analog_hz for scene in scenes]
            self._amplifiers = np.array([
                [omega * (scene.controller.l_hat or 0.0), omega * (scene.controller.r_hat or 0.0),
                 set_.limit_v]
                for omega, scene, set_ in zip(omegas, scenes, self.settings, strict=True)
            ])  # fmt: skip
            self._servo_kept = np.zeros((2, motors))
            self._commands, self._acting = np.zeros(motors), 0
            self._counts = np.floor(self._states[:, X] / self._floats[:, _CELL]).astype(np.int64)
            self._k_t_hat = np.array([scene.controller.k_t_hat for scene in scenes])
            return
        if not self.golden:
            self._volts = np.zeros(motors)
            self._law = (
                np.zeros(surfaces.MOST_ACTIVE, dtype=np.int64),
                np.zeros((surfaces.MOST_SURFACES, 3)),
                np.zeros((surfaces.MOST_SURFACES, surfaces.PLANE_WORDS)),
                np.zeros((surfaces.VECTORS, surfaces.VECTOR_WORDS)), np.zeros(1),
                np.zeros((_LAW, _PORTS)), np.zeros(_PORTS),
            )  # fmt: skip
            return
        self._rngs = [np.random.default_rng(NOISE_SEED + n) for n in range(motors)]
        self._kept = np.zeros((motors, 4), dtype=np.int64)
        self._kept[:, _POSITION] = np.floor(self._states[:, X] / self._floats[:, _CELL])
        self._cores = np.array([wave_core.new_state() for _ in range(motors)])
        extra = self.settings[0].extra_ticks
        self._lines = np.array([wave_core.new_line(extra) for _ in range(motors)])
        self._contacts = np.array([[-1, 0]] * motors, dtype=np.int64)
        self._anchors = (
            np.array([set_.anchor for set_ in self.settings]),
            np.array([anchor.new_state() for _ in range(motors)]),
        )
        self._between = (
            coupling.new_line(max(self.line_ticks, 0)), np.array([min(self.line_ticks, 0)]),
        )  # fmt: skip
        self._group = (
            surfaces.new_state(), np.zeros(1, dtype=np.int64),
            np.zeros(surfaces.MOST_ACTIVE, dtype=np.int64), surfaces.new_planes(),
            surfaces.new_vectors(), np.array([0, self.budget], dtype=np.int64),
            np.zeros(_PORTS, dtype=np.int64), np.zeros(_PORTS, dtype=np.int64),
            np.zeros(_PORTS, dtype=np.int64),
        )  # fmt: skip

    def _look(self) -> Planes | Command:
        if self._servo:
            return self._serve()
        if self.golden:
            return self.host.look(self._kept[:, _POSITION])
        return self.host.look(self._states[:, X] / self._floats[:, _CELL], middle=0.0)

    def _serve(self) -> Command:
        """What the servo makes of the encoders' counts: currents, and surfaces that are touched."""
        cell = self._floats[:, _CELL]
        for n, (state, real) in enumerate(zip(self._states, self._motors[2], strict=True)):
            self._counts[n] = counted(
                self._counts[n], state[X], state[TIME], cell[n], self._floats[n, _ENCODER_END], real
            )
        q = (self._counts + 0.5) * cell
        place, torque, acting = self.space.arm.tip(q)[None, :], np.zeros(len(q)), 0
        jacobian = self.space.arm.jacobian(q)
        depths = np.zeros(len(self.springs))
        for n, (shape, spring) in enumerate(zip(self.space.shapes, self.springs, strict=True)):
            depth, normal = shape.depth(place)
            depths[n] = depth[0]
            if depth[0] > 0.0:
                speed = (depth[0] - self._depths[n]) / self._servo_s
                push = spring * depth[0] + self.space.solids[n].damping * speed
                torque -= push * (jacobian.T @ normal[0])
                acting += 1
        self._depths = depths
        return Command(torque / self._k_t_hat, acting)

    def _commit(self, update: Planes | Command) -> None:
        if isinstance(update, Command):
            self._commands[:], self._acting = update
            return
        self.singular_updates += len(update.singular)
        if self.golden:
            planes, vectors, most = as_words(update)
            if surfaces.accepts(planes, vectors):
                self._group[3][:], self._group[4][:] = planes, vectors
                self._group[5][surfaces.VELOCITY_MAX] = most
            return
        self._law[2][:], self._law[3][:], self._law[4][0] = update[:3]

    def _run(self, rows: np.ndarray, words: np.ndarray, tips: np.ndarray) -> None:
        if self._servo:
            _advance_encoder(
                rows, tips, self._states, self._servo_kept, self._commands, self._acting,
                self._amplifiers, self._floats, self._dt, self._substeps, self._arm, self._motors,
                *self._room,
            )  # fmt: skip
            return
        if not self.golden:
            _advance_analog(
                rows, tips, self._states, self._volts, self._walls, self._law, self._floats,
                self._dt, self._substeps, self._arm, self._motors, *self._room,
            )  # fmt: skip
            return
        noises = np.zeros((len(self._states), len(tips)))
        for n, rng in enumerate(self._rngs):
            if len(drawn := draw_noise(rng, self._motors[3][n], len(tips))):
                noises[n] = drawn
        _advance_golden(
            rows, words, tips, self._states, self._kept, self._cores, self._lines, self._contacts,
            self._walls, self._anchors, self._group, self._between, self._ints, self._floats,
            self._dt, self._substeps, self._arm, self._motors, noises, *self._room,
        )  # fmt: skip


class Command(NamedTuple):
    """What a servo asks for: currents (motors,) in A, and how many surfaces it is in."""

    currents: np.ndarray
    acting: int
