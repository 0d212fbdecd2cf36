# SPDX-License-Identifier: Apache-2.0
"""The controller ``encoder``: a virtual spring from a sampled encoder, and a current amplifier.

It is what the paper's Fig. 1 shows, and what people use today: a servo reads the encoder at its own
rate, asks for the torque ``−K·(x − x_w) − B·ω`` inside a wall and for none outside, and after a
delay an analog PI amplifier makes the current of it. Its zero cancels the winding's pole, so that
without back-EMF the current follows like a low-pass filter of the stated bandwidth. It measures the
current without error, and knows of the motor R̂, L̂ and k̂_T. The amplifier
is stepped with the scene's tick, which therefore has to be far shorter than its response; the servo
period and the delay are whole ticks.
"""

from __future__ import annotations

import math

import numpy as np

from wavehaptics.controller import wave_core
from wavehaptics.controller.settings import Settings, settings
from wavehaptics.ladder.abilities import refuse
from wavehaptics.laws import closed_forms
from wavehaptics.motor.imperfections import (
    MOTOR,
    Real,
    counted,
    look,
    real_parts,
    supplied,
    warm_real,
)
from wavehaptics.motor.plant import TIME, C, I, P, Plant, X, load_words, plant_step
from wavehaptics.motor.step import motor_step
from wavehaptics.motor.thermal import Winding
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene, drive_gain, encoder_end, without_anchor
from wavehaptics.scene.tables.servo import Servo
from wavehaptics.trace.columns import put_motion, put_port

FASTEST_AMPLIFIER = 0.1
"""Most of the amplifier's bandwidth in Hz over the tick rate: it stands for an analog circuit."""

# Places in the loop's integer parameters.
_SUBSTEPS, _SERVO_TICKS, _DELAY_TICKS = range(3)
# Places in the loop's float parameters, first those of :func:`servo_floats`.
CELL, _STIFFNESS, _DAMPING, _RATE = range(4)
SERVO_FLOATS = 4
"""How many float parameters :func:`servo_torque` takes."""
(
    _DT, _DRIVE_GAIN, _K_T, _RESISTANCE, _KP, _KI, _LIMIT, _ENCODER_END, _K_T_HAT,
) = range(SERVO_FLOATS, SERVO_FLOATS + 9)  # fmt: skip
# Places in the numbers that the loop keeps: voltage, the PI's integral (V), the servo's command (A)
# and whether it touches, its last count, ticks so far.
_VOLTAGE, _INTEGRAL, _COMMAND, _TOUCHING, _COUNT, _TICKS = range(6)


@compiled(inline="always")
def servo_torque(position: int, last: int, depth: int, touching: bool, floats: np.ndarray) -> float:
    """Torque that the servo asks for, N·m, from its counts at this sample and the one before.

    ``depth`` is the position less the wall's edge in counts, negative behind an upper edge, whose
    outermost cell has no depth just as a lower edge's has none.
    """
    if not touching:
        return 0.0
    if depth < 0:
        depth += 1
    omega = (position - last) * floats[CELL] * floats[_RATE]
    torque: float = -floats[_STIFFNESS] * depth * floats[CELL] - floats[_DAMPING] * omega
    return torque


@compiled(inline="always")
def amplifier_step(
    error: float, integral: float, kp: float, ki: float, limit: float, tick: float
) -> tuple[float, float, float]:
    """A tick of the PI amplifier for a current that is ``error`` A too small.

    Returns the voltage within ±``limit`` V, the one that it asks for, and its integral, V.
    """
    asked = kp * error + integral
    voltage = min(max(asked, -limit), limit)
    if voltage == asked or error * asked < 0.0:  # a saturated integral would wind up
        integral += ki * error * tick
    return voltage, asked, integral


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _advance(
    rows: np.ndarray, state: np.ndarray, kept: np.ndarray, line: np.ndarray, contact: np.ndarray,
    wall_min: np.ndarray, wall_max: np.ndarray, ints: np.ndarray, floats: np.ndarray,
    load: np.ndarray, matrix: np.ndarray, real: Real | None,
) -> None:  # fmt: skip
    dt = floats[_DT]
    substeps = ints[_SUBSTEPS]
    tick = dt * substeps
    for n in range(rows.shape[0]):
        e_a = kept[_VOLTAGE] * floats[_DRIVE_GAIN]
        sag = 0.0
        if real is not None:
            e_a, sag = supplied(e_a, state[TIME], real)
        x_before, hand_before, t_before = state[X], state[P] + state[C], state[TIME]
        charge, square = 0.0, 0.0
        low, high = state[I], state[I]
        for _ in range(substeps):
            if real is None:
                part, part_square = plant_step(state, matrix, dt, e_a, load)
            else:
                part, part_square = motor_step(state, matrix, dt, e_a, load, real[MOTOR])
            charge += part
            square += part_square
            low, high = min(low, state[I]), max(high, state[I])
        ticks = int(kept[_TICKS])
        if real is not None:
            look(state[X], state[TIME], floats[CELL], real)
        if ticks % ints[_SERVO_TICKS] == 0:
            position = int(kept[_COUNT])
            if real is not None:
                position = counted(
                    position, state[X], state[TIME], floats[CELL], floats[_ENCODER_END], real
                )
            elif state[TIME] < floats[_ENCODER_END]:
                position = int(np.floor(state[X] / floats[CELL]))
            touching, depth = wave_core.contact_step(contact, position, wall_min, wall_max)
            last = position if ticks == 0 else int(kept[_COUNT])
            torque = servo_torque(position, last, depth, touching, floats)
            kept[_COMMAND] = torque / floats[_K_T_HAT]
            kept[_TOUCHING] = 1.0 if touching else 0.0
            kept[_COUNT] = position
        line[ticks % line.shape[0]] = kept[_COMMAND]
        wanted = line[(ticks - ints[_DELAY_TICKS]) % line.shape[0]]
        kept[_TICKS] = ticks + 1
        voltage, asked, kept[_INTEGRAL] = amplifier_step(
            wanted - state[I], kept[_INTEGRAL], floats[_KP], floats[_KI], floats[_LIMIT], tick
        )
        row = rows[n]
        mean = charge / tick
        put_motion(
            row, t_before, tick, x_before, state[X], mean, e_a - sag * mean,
            floats[_K_T] * charge / tick, 0.5 * (hand_before + state[P] + state[C]),
            e_a * charge - floats[_RESISTANCE] * square, high - low,
        )  # fmt: skip
        put_port(row, 0.0, 0.0, 0.0, kept[_TOUCHING] != 0.0, voltage != asked)
        kept[_VOLTAGE] = voltage


class EncoderSimulation:
    """A scene on the servo of its ``[servo]`` table; without one, on a servo with its defaults.

    It has no waves: η, u and v of its rows are 0. :class:`SceneError` where the servo doesn't fit
    the scene's tick.
    """

    clock_cycles: int | None = None

    def __init__(self, scene: Scene) -> None:
        refuse(scene, "encoder")
        if scene.motor.brushless:
            raise scene.refusal(
                "a brushless motor has three phases and this amplifier one", "motor.kind"
            )
        self.settings: Settings = settings(without_anchor(scene))
        self.tick_s = self.settings.tick_s
        self.stiffness = servo_stiffness(scene)
        servo = scene.servo or Servo()
        servo_ticks, _ = check_rates(scene)
        delay_ticks = round(servo.delay_s / self.tick_s)
        self.winding = Winding(scene, self.tick_s)
        plant = self.winding.plant
        substeps = plant.substeps(self.tick_s)
        dt = self.tick_s / substeps
        omega_c = 2 * math.pi * servo.analog_hz
        self._state = plant.start.copy()
        self._kept = np.zeros(_TICKS + 1)
        self._kept[_COUNT] = math.floor(plant.start[X] / self.settings.cell_rad)
        self._line = np.zeros(delay_ticks + 1)
        self._contact = np.array([-1, 0], dtype=np.int64)
        self._ints = np.array([substeps, servo_ticks, delay_ticks], dtype=np.int64)
        self._floats = np.array(
            [*servo_floats(self.settings.cell_rad, self.stiffness, servo.damping,
                           servo_ticks * self.tick_s),
             dt, drive_gain(scene), plant.k_t, plant.resistance,
             omega_c * scene.controller.l_hat, omega_c * scene.controller.r_hat,
             self.settings.limit_v, encoder_end(scene), scene.controller.k_t_hat]
        )  # fmt: skip
        self._load = load_words(plant)
        self._dt = dt
        self._matrix = plant.transition(dt)
        self._real = real_parts(scene, plant, self.settings.cell_rad, [dt])

    def advance(self, rows: np.ndarray, words: np.ndarray | None = None) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column); it has no words."""
        del words
        self.winding.advance(rows, lambda part: self._advance(rows[part]), self._warm)

    def _warm(self, plant: Plant) -> None:
        self._matrix = plant.transition(self._dt)
        self._load = load_words(plant)
        self._floats[_RESISTANCE], self._floats[_K_T] = plant.resistance, plant.k_t
        warm_real(self._real, plant)

    def _advance(self, rows: np.ndarray) -> None:
        _advance(
            rows, self._state, self._kept, self._line, self._contact, self.settings.wall_min,
            self.settings.wall_max, self._ints, self._floats, self._load, self._matrix,
            self._real,
        )  # fmt: skip


def servo_floats(
    cell_rad: float, stiffness: float, damping: float, period_s: float
) -> tuple[float, float, float, float]:
    """What :func:`servo_torque` takes: cell in rad, K in N·m/rad, B in N·m·s/rad, and 1/T in Hz."""
    return cell_rad, stiffness, damping, 1.0 / period_s


def servo_stiffness(scene: Scene) -> float:
    """The servo's K, N·m/rad: the scene's, or else what its wave wall has on the analog circuit.

    Of a motor as the controller knows it.
    """
    if scene.servo is not None and scene.servo.stiffness is not None:
        return scene.servo.stiffness
    control = scene.controller
    return closed_forms.stiffness(
        control.k_t_hat, control.l_hat, control.r_hat, 1.0 / control.lambda_
    )


def _whole_ticks(scene: Scene, key: str, rate_hz: float) -> int:
    """Ticks of a period of ``servo.key``, ``rate_hz``. :class:`SceneError` if they aren't whole."""
    tick_hz = scene.controller.tick_hz
    ticks = max(1, round(tick_hz / rate_hz))
    if not math.isclose(ticks * rate_hz, tick_hz, rel_tol=1e-6):
        raise scene.refusal(
            f"servo.{key} = {rate_hz:g} does not divide "
            f"controller.tick_hz = {tick_hz:g} Hz; the nearest that does is {tick_hz / ticks:.9g}",
            f"servo.{key}",
            "controller.tick_hz",
        )
    return ticks


def check_rates(scene: Scene) -> tuple[int, int]:
    """Ticks of a period of the servo, and of the current control, which an analog amplifier does
    in each. :class:`SceneError` where they aren't whole, or the control is too fast for them."""
    servo = scene.servo or Servo()
    servo_ticks = _whole_ticks(scene, "rate_hz", servo.rate_hz)
    if not scene.motor.brushless:
        _check_bandwidth(scene, servo.analog_hz, "controller.tick_hz", scene.controller.tick_hz)
        return servo_ticks, 1
    foc_ticks = _whole_ticks(scene, "foc_hz", servo.foc_hz)
    _check_bandwidth(scene, servo.field_oriented_hz, "servo.foc_hz", servo.foc_hz)
    return servo_ticks, foc_ticks


def _check_bandwidth(scene: Scene, bandwidth_hz: float, key: str, rate_hz: float) -> None:
    """:class:`SceneError` where the current control is too fast for what steps it, ``key``."""
    if bandwidth_hz > FASTEST_AMPLIFIER * rate_hz:
        raise scene.refusal(
            f"servo.amplifier_hz = {bandwidth_hz:g} is too fast for "
            f"{key} = {rate_hz:g} Hz, with which it is stepped; "
            f"it may be at most {FASTEST_AMPLIFIER * rate_hz:g} Hz",
            "servo.amplifier_hz",
            key,
        )
