# SPDX-License-Identifier: Apache-2.0
"""The controller ``encoder`` of a brushless motor: the servo on field-oriented current control.

At the rate of ``[servo] foc_hz`` a sampled current control turns the currents of the phases a and b
by the encoder's angle into the rotor's frame (Clarke, Park), where two PI controllers hold i_d at
zero and i_q at what the servo asks for,

    v = K_p (i* − i) + I        I += K_i T (i* − i)        K_p = ω_c L̂,  K_i = ω_c R̂

so that the zero cancels the winding's pole, as the amplifier of a motor with brushes does it. As in
the open design FPGA-FOC nothing decouples the axes or feeds the back-EMF forward. What a sample
comes to is on the bridge one period later, and stays, in the windings' frame, for one. Space-vector
PWM gives any vector up to the bus over √3; one that is longer is shortened, and while it is, an
integral only falls. What the bridge does between its edges is averaged.

The servo is that of :mod:`wavehaptics.ladder.encoder`. It takes counts for the middle of their
cells, and the magnets to be where the scene's ``magnet_hat_rad`` says.
"""

from __future__ import annotations

import math

import numpy as np

from wavehaptics.controller import wave_core
from wavehaptics.controller.settings import Settings, settings
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.brushless import clear_sums, put_axes
from wavehaptics.ladder.encoder import (
    CELL,
    SERVO_FLOATS,
    check_rates,
    servo_floats,
    servo_stiffness,
    servo_torque,
)
from wavehaptics.motor.brushless import F_A, F_B, I_A, I_B, BrushlessPlant, brushless_step
from wavehaptics.motor.plant import TIME, C, I, P, X
from wavehaptics.motor.sensor import (
    BITS,
    FULL_SCALE,
    IDEAL,
    NOISE_SEED,
    Sensor,
    draw_noise,
    noise_at,
    sample_code,
)
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene, drive_gain, without_anchor
from wavehaptics.scene.tables.servo import Servo
from wavehaptics.trace.columns import put_port

SPACE_VECTOR_REACH = (math.sqrt(3.0) + 1.0) / 2.0
"""Longest vector of a bus, V/√3, over what each axis has of it at once, ``drive.limit_v``."""

_ROOT3 = math.sqrt(3.0)

# Places in the loop's integer parameters, and in its float parameters behind those of the servo.
_SUBSTEPS, _SERVO_TICKS, _DELAY_TICKS, _FOC_TICKS = range(4)
_GAIN, _AMPS, _KP, _KI, _LIMIT, _TURN, _ZERO = range(SERVO_FLOATS, SERVO_FLOATS + 7)
# Places in what the loop keeps: voltages of α and β on the bridge and those to come, integrals of d
# and q (V), the servo's command (A), whether it touches, its last count, ticks so far, whether the
# newest vector was too long.
(
    _ON_A, _ON_B, _NEXT_A, _NEXT_B, _SUM_D, _SUM_Q, _COMMAND, _TOUCHING, _COUNT, _TICKS, _LIMITED,
    _CLIPPED,
) = range(12)  # fmt: skip


@compiled(inline="always")
def _measured(current: float, sensor: np.ndarray, noise: float) -> float:
    """A phase's current as its converter has it, A."""
    if sensor[IDEAL] != 0.0:
        return current
    code = sample_code(current, sensor, noise)
    measured: float = code * sensor[FULL_SCALE] / (1 << (int(sensor[BITS]) - 1))
    return measured


@compiled(inline="always")
def _at_end(measured: float, sensor: np.ndarray) -> bool:
    """Whether a current of :func:`_measured` is at the end of the converter's range."""
    half = 1 << (int(sensor[BITS]) - 1)
    ends: bool = sensor[IDEAL] == 0.0 and abs(measured) * half > (half - 1.5) * sensor[FULL_SCALE]
    return ends


@compiled(inline="always")
def field_oriented_step(
    kept: np.ndarray, floats: np.ndarray, i_a: float, i_b: float, theta: float, wanted: float
) -> None:
    """One period of the current control, from two phases' currents in A and the angle in rad.

    What the last period came to goes on the bridge.
    """
    kept[_ON_A], kept[_ON_B] = kept[_NEXT_A], kept[_NEXT_B]
    cos, sin = math.cos(theta), math.sin(theta)
    alpha, beta = i_a, (i_a + 2.0 * i_b) / _ROOT3
    error_d = -(cos * alpha + sin * beta)
    error_q = wanted - (cos * beta - sin * alpha)
    v_d = floats[_KP] * error_d + kept[_SUM_D]
    v_q = floats[_KP] * error_q + kept[_SUM_Q]
    length = math.sqrt(v_d * v_d + v_q * v_q)
    kept[_LIMITED] = 1.0 if length > floats[_LIMIT] else 0.0
    if kept[_LIMITED] == 0.0 or error_d * v_d < 0.0:  # a saturated integral would wind up
        kept[_SUM_D] += floats[_KI] * error_d
    if kept[_LIMITED] == 0.0 or error_q * v_q < 0.0:
        kept[_SUM_Q] += floats[_KI] * error_q
    if kept[_LIMITED] != 0.0:
        v_d *= floats[_LIMIT] / length
        v_q *= floats[_LIMIT] / length
    kept[_NEXT_A] = cos * v_d - sin * v_q
    kept[_NEXT_B] = sin * v_d + cos * v_q


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _advance(
    rows: np.ndarray, z: np.ndarray, kept: np.ndarray, line: np.ndarray, contact: np.ndarray,
    wall_min: np.ndarray, wall_max: np.ndarray, ints: np.ndarray, floats: np.ndarray,
    load: np.ndarray, table: np.ndarray, step: np.ndarray, sensor: np.ndarray, noise: np.ndarray,
) -> None:  # fmt: skip
    substeps = ints[_SUBSTEPS]
    tick = step[0] * substeps
    for n in range(rows.shape[0]):
        e_a, e_b = floats[_GAIN] * kept[_ON_A], floats[_GAIN] * kept[_ON_B]
        before, hand = z[X], z[P] + z[C]
        clear_sums(z)
        z[F_A], z[F_B] = e_a, e_b
        low, high = z[I], z[I]
        for _ in range(substeps):
            brushless_step(z, table, table, step, load)
            low, high = min(low, z[I]), max(high, z[I])
        ticks = int(kept[_TICKS])
        position = int(np.floor(z[X] / floats[CELL]))
        if ticks % ints[_SERVO_TICKS] == 0:
            touching, depth = wave_core.contact_step(contact, position, wall_min, wall_max)
            last = position if ticks == 0 else int(kept[_COUNT])
            torque = servo_torque(position, last, depth, touching, floats)
            kept[_COMMAND] = torque * floats[_AMPS]
            kept[_TOUCHING] = 1.0 if touching else 0.0
            kept[_COUNT] = position
        line[ticks % line.shape[0]] = kept[_COMMAND]
        if ticks % ints[_FOC_TICKS] == 0:
            phase_b = 0.5 * (_ROOT3 * z[I_B] - z[I_A])
            seen_a = _measured(z[I_A], sensor, noise_at(noise, 2 * n))
            seen_b = _measured(phase_b, sensor, noise_at(noise, 2 * n + 1))
            clipped = _at_end(seen_a, sensor) or _at_end(seen_b, sensor)
            kept[_CLIPPED] = 1.0 if clipped else 0.0
            field_oriented_step(
                kept, floats, seen_a, seen_b,
                floats[_TURN] * (position + 0.5) - floats[_ZERO],
                line[(ticks - ints[_DELAY_TICKS]) % line.shape[0]],
            )  # fmt: skip
        kept[_TICKS] = ticks + 1
        put_axes(rows[n], z, load, z[TIME] - tick, tick, before, hand, e_a, e_b, high - low)
        put_port(
            rows[n], 0.0, 0.0, 0.0, kept[_TOUCHING] != 0.0, kept[_LIMITED] != 0.0,
            kept[_CLIPPED] != 0.0,
        )  # fmt: skip


class FieldOrientedSimulation:
    """A scene's brushless motor on the servo of its ``[servo]`` table, or on one with defaults.

    It has no waves: η, u and v of its rows are 0. :class:`SceneError` where servo or current
    control don't fit the scene's tick.
    """

    clock_cycles: int | None = None

    def __init__(self, scene: Scene) -> None:
        refuse(scene, "encoder")
        self.settings: Settings = settings(without_anchor(scene))
        self.tick_s = self.settings.tick_s
        self.stiffness = servo_stiffness(scene)
        servo = scene.servo or Servo()
        servo_ticks, foc_ticks = check_rates(scene)
        delay_ticks = round(servo.delay_s / self.tick_s)
        plant = BrushlessPlant.of_scene(scene)
        substeps = plant.substeps(self.tick_s)
        dt = self.tick_s / substeps
        cell = self.settings.cell_rad
        control = scene.controller
        omega_c = 2 * math.pi * servo.field_oriented_hz
        # k̂_T is what both axes feel as together; an ampere of a phase's amplitude makes √1.5 of it.
        torque_constant = math.sqrt(1.5) * control.k_t_hat
        self._z = plant.start
        self._kept = np.zeros(_CLIPPED + 1)
        self._kept[_COUNT] = math.floor(self._z[X] / cell)
        self._line = np.zeros(delay_ticks + 1)
        self._contact = np.array([-1, 0], dtype=np.int64)
        self._ints = np.array([substeps, servo_ticks, delay_ticks, foc_ticks], dtype=np.int64)
        own = [
            drive_gain(scene), 1.0 / torque_constant, omega_c * control.l_hat,
            omega_c * control.r_hat * foc_ticks * self.tick_s,
            SPACE_VECTOR_REACH * self.settings.limit_v, plant.pole_pairs * cell,
            plant.pole_pairs * control.magnet_hat_rad,
        ]  # fmt: skip
        servo_s = servo_ticks * self.tick_s
        self._floats = np.array([*servo_floats(cell, self.stiffness, servo.damping, servo_s), *own])
        self._load = plant.words()
        self._table, self._step = plant.axis_table(dt), plant.step_words(dt)
        self._sensor = Sensor.of_scene(scene).constants()
        self._rng = np.random.default_rng(NOISE_SEED)

    def advance(self, rows: np.ndarray, words: np.ndarray | None = None) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column); it has no words."""
        del words
        _advance(
            rows, self._z, self._kept, self._line, self._contact, self.settings.wall_min,
            self.settings.wall_max, self._ints, self._floats, self._load, self._table, self._step,
            self._sensor, draw_noise(self._rng, self._sensor, 2 * len(rows)),
        )  # fmt: skip
