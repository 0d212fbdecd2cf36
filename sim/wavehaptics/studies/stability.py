# SPDX-License-Identifier: Apache-2.0
"""The stiffest wall that a controller can render without oscillation.

A wall is called *stable*, as in the literature on haptic walls, if pressing on it and tapping it
neither leaves a sustained oscillation nor lets motion grow:

- *press*: from 0.3 to 0.6 s after the hand has begun to move, the rotor's position (less a
  straight line, as a wall may creep) swings by less than :data:`SWING_CELLS` encoder cells, or by
  less in the second half than :data:`DECAY` of the first. Swings of a count or two are what
  quantisation leaves of any wall, and are not held against it here; :func:`at_rest` does not
  forgive them.
- *tap*: the rotor never moves more than :data:`SPEED_GAIN` times as fast as against an ideal spring
  of the same stiffness.

Known bounds for the encoder's wall, both sufficient: viscous friction b gives ``K < 2b/T`` (Colgate
and Schenkel), Coulomb friction f_c and an encoder cell Δ give ``K < 2f_c/Δ`` (Diolaiti, Niemeyer,
Barbagli and Salisbury).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from wavehaptics.ladder.encoder import FASTEST_AMPLIFIER, EncoderSimulation
from wavehaptics.ladder.run import CONTROLLERS, Simulation
from wavehaptics.laws import closed_forms
from wavehaptics.scene import Scene
from wavehaptics.scene.tables.motor import Motor
from wavehaptics.scene.tables.servo import Servo
from wavehaptics.trace.columns import Column, Word

SWING_CELLS = 2.5
"""A swing of two counts, and a little more: what is below is quantisation."""
IDEAL_SWING_RAD = 1e-5
"""What takes the place of :data:`SWING_CELLS` cells where there is no encoder."""
DECAY = 0.8
SPEED_GAIN = 1.5
REST_CELLS = 0.02
"""A rotor that moves less than this part of a cell is at rest."""

PRESS_S = 0.6
TAP_S = 0.4
TAP_HZ = 5.0

LOWEST, HIGHEST = 1e-3, 100.0
"""Stiffnesses between which the limit is looked for, N·m/rad at the rotor."""


def simulate(simulation: Simulation, duration_s: float) -> np.ndarray:
    """Rows (Column) of a simulation's next ``duration_s``."""
    ticks = max(1, round(duration_s / simulation.tick_s))
    rows = np.zeros((ticks, len(Column)))
    simulation.advance(rows, np.zeros((ticks, len(Word)), dtype=np.int64))
    return rows


def swings(scene: Scene, controller: str) -> tuple[float, float]:
    """Swing of x in the third and in the last quarter of a press, peak to peak, rad."""
    assert scene.hand is not None
    hand = scene.hand.model_copy(update={"path": "press", "frequency_hz": None})
    rows = simulate(CONTROLLERS[controller](scene.model_copy(update={"hand": hand})), PRESS_S)
    x = rows[:, Column.X]
    quarter = len(x) // 4
    return _swing(x[2 * quarter : 3 * quarter]), _swing(x[3 * quarter :])


def _swing(x: np.ndarray) -> float:
    n = np.arange(len(x))
    return float(np.ptp(x - np.polyval(np.polyfit(n, x, 1), n)))


def peak_tap_speed(simulation_of: Callable[[Scene], Simulation], scene: Scene) -> float:
    """Largest speed of the rotor while the hand taps the wall, rad/s."""
    assert scene.hand is not None
    hand = scene.hand.model_copy(update={"path": "taps", "frequency_hz": TAP_HZ})
    simulation = simulation_of(scene.model_copy(update={"hand": hand}))
    return float(np.abs(simulate(simulation, TAP_S)[:, Column.OMEGA]).max())


def ideal_spring(scene: Scene, stiffness: float) -> Scene:
    """The scene with a servo that has no encoder, no delay, every tick and a fast amplifier.

    A brushless motor becomes the motor with brushes that feels the same.
    """
    control = scene.controller.model_copy(update={"tick_hz": max(1e5, scene.controller.tick_hz)})
    servo = Servo(
        rate_hz=control.tick_hz,
        stiffness=stiffness,
        amplifier_hz=min(FASTEST_AMPLIFIER * control.tick_hz, 4e5),
    )
    motor = scene.motor
    if motor.brushless:
        motor = Motor(R_ohm=motor.R_ohm, L_h=motor.L_h, k_t=motor.felt_k_t, J_kgm2=motor.J_kgm2)
    return scene.model_copy(
        update={"servo": servo, "encoder": None, "controller": control, "drive": None,
                "motor": motor}
    )  # fmt: skip


def cell_rad(scene: Scene) -> float | None:
    """Δ of the scene's encoder, rad."""
    return 2 * math.pi / scene.encoder.counts_per_rev if scene.encoder else None


def stable(scene: Scene, controller: str, stiffness: float) -> bool:
    """Whether the wall, of ``stiffness`` by design, is stable (see the head of the module)."""
    earlier, later = swings(scene, controller)
    cell = cell_rad(scene)
    small = IDEAL_SWING_RAD if cell is None else SWING_CELLS * cell
    if later > small and later > DECAY * earlier:
        return False
    speed = peak_tap_speed(CONTROLLERS[controller], scene)
    ideal = peak_tap_speed(EncoderSimulation, ideal_spring(scene, stiffness))
    return speed <= SPEED_GAIN * ideal


def at_rest(scene: Scene, controller: str, stiffness: float) -> bool:
    """Whether a pressed rotor comes to rest, without even the swing of a single count."""
    del stiffness
    cell = cell_rad(scene)
    return swings(scene, controller)[1] <= REST_CELLS * (IDEAL_SWING_RAD if cell is None else cell)


def with_stiffness(scene: Scene, controller: str, stiffness: float) -> Scene:
    """The scene with a wall of ``stiffness`` N·m/rad: the servo's K, or the wave wall's λ."""
    if controller == "encoder":
        servo = (scene.servo or Servo()).model_copy(update={"stiffness": stiffness})
        return scene.model_copy(update={"servo": servo})
    motor = scene.motor
    tau = 2.0 * (motor.felt_k_t**2 / stiffness - motor.L_h) / motor.R_ohm
    control = scene.controller.model_copy(update={"lambda_": 1.0 / tau})
    return scene.model_copy(update={"controller": control})


def stiffest_wave_wall(scene: Scene) -> float:
    """K of the wave wall with the largest a, N·m/rad: nothing stiffer can be asked of it."""
    motor, control = scene.motor, scene.controller
    tau = closed_forms.tau(1.0 / control.tick_hz, 1.0, control.extra_ticks)
    return closed_forms.stiffness(motor.felt_k_t, motor.L_h, motor.R_ohm, tau)


def largest_stiffness(
    scene: Scene,
    controller: str,
    holds: Callable[[Scene, str, float], bool] = stable,
    halvings: int = 10,
) -> tuple[float | None, bool]:
    """The largest K for which ``holds``, N·m/rad, by bisection of its logarithm.

    None where not even the softest holds. The second value tells that the stiffest that the
    controller can be asked for still holds. Ten halvings find K to 1 %.
    """
    low = LOWEST
    high = HIGHEST if controller == "encoder" else stiffest_wave_wall(scene) * (1 - 1e-9)

    def fine(k: float) -> bool:
        return holds(with_stiffness(scene, controller, k), controller, k)

    if fine(high):
        return high, True
    if not fine(low):
        return None, False
    for _ in range(halvings):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if fine(middle) else (low, middle)
    return low, False
