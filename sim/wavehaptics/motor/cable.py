# SPDX-License-Identifier: Apache-2.0
"""The cable from the rotor to the hand: a spring and a damper with a gap between them.

The place y where the hand holds the cable has no mass, unless the hand has one. Without, both carry
the same torque:
``K_c dz(x − y) + B_c (ω − dy/dt) = K_h (y − x_h) + B_h (dy/dt − dx_h/dt)``, dz being the dead zone
of ± half the backlash. In the gap, and where the damper would pull what the gap lets go, it is 0.
Within a step rotor and hand move evenly, and then y is known in closed form: an exponential towards
a straight line, whatever the two dampers are; without any it is on that line at once.

With a mass, ``m d²y/dt²`` is the cable's torque less the hand's, stepped by the implicit midpoint
rule: rotor – cable – mass – the hand's spring and damper – x_h(t).
"""

from __future__ import annotations

import numpy as np

from wavehaptics.motor.plant import C, P, Plant, R, S
from wavehaptics.runtime.compiled import compiled

CABLE_K, CABLE_B, HALF_GAP, HAND_K, HAND_B, HAND_OMEGA, END_INERTIA = range(7)


def cable_words(plant: Plant) -> np.ndarray:
    """Constants of the functions below; all zero without a cable."""
    if plant.cable is None:
        return np.zeros(END_INERTIA + 1)
    return np.array(
        [plant.cable.cable_stiffness, plant.cable.cable_damping, 0.5 * plant.cable.backlash_rad,
         plant.cable_hand_stiffness, plant.cable_hand_damping, plant.hand_omega,
         plant.cable_end_inertia]
    )  # fmt: skip


@compiled(inline="always")
def _toward_line(
    y: float, start: float, slope: float, time_constant: float, step_s: float
) -> tuple[float, float]:
    """(y at the end, its mean) of ``T dy/dt = line − y`` for a line of that start and slope."""
    first = start - slope * time_constant
    if time_constant <= 1e-6 * step_s:
        return start + slope * step_s, start + 0.5 * slope * step_s
    fallen = -np.expm1(-step_s / time_constant)
    off = y - first
    end = first + slope * step_s + off * (1.0 - fallen)
    return end, first + 0.5 * slope * step_s + off * fallen * time_constant / step_s


@compiled(inline="always")
def _side(way: float, gap: float) -> float:
    """On which side of the play the cable pulls, ±1, or 0 within it; 0 without any as well."""
    if gap == 0.0:
        return 0.0
    return 1.0 if way > gap else (-1.0 if way < -gap else 0.0)


@compiled()
def cable_torque(
    state: np.ndarray, x: float, omega: float, y: float, step_s: float, words: np.ndarray
) -> tuple[float, float]:
    """Mean torque of the cable against the rotor over a step, N·m, and y at its end.

    ``state`` is the motor's, for the hand's path; the rotor begins at ``x`` and moves at ``omega``.
    """
    k_c, b_c, k_h, b_h = words[CABLE_K], words[CABLE_B], words[HAND_K], words[HAND_B]
    hand = state[P] + state[C]
    hand_speed = state[R] - words[HAND_OMEGA] * state[S]
    gap = words[HALF_GAP]
    side = _side(x - y, gap)
    if gap == 0.0 or side != 0.0:
        k = k_c + k_h
        start = (k_c * (x - side * gap) + b_c * omega + k_h * hand + b_h * hand_speed) / k
        slope = (k_c * omega + k_h * hand_speed) / k
        end, mean = _toward_line(y, start, slope, (b_c + b_h) / k, step_s)
        torque = k_c * (x + 0.5 * step_s * omega - side * gap - mean)
        torque += b_c * (omega - (end - y) / step_s)
        if gap == 0.0 or torque * side > 0.0:
            return torque, end
    # ``T dy/dt = x_h + T dx_h/dt − y``: y nears the hand.
    lag = b_h / k_h
    end, _ = _toward_line(y, hand + lag * hand_speed, hand_speed, lag, step_s)
    return 0.0, end


@compiled()
def massive_end_torque(
    state: np.ndarray, x: float, omega: float, y: float, speed: float, step_s: float,
    words: np.ndarray,
) -> tuple[float, float, float]:  # fmt: skip
    """As :func:`cable_torque` where the end has a mass and a ``speed``; that at its end as well."""
    k_c, b_c, k_h, b_h = words[CABLE_K], words[CABLE_B], words[HAND_K], words[HAND_B]
    half = 0.5 * step_s
    hand_speed = state[R] - words[HAND_OMEGA] * state[S]
    hand = state[P] + state[C] + half * hand_speed
    gap = words[HALF_GAP]
    side = _side(x - y, gap)
    rotor = x + half * omega - side * gap
    inertia = words[END_INERTIA] / half
    push = inertia * speed + k_h * (hand - y) + b_h * hand_speed
    against = inertia + half * k_h + b_h
    if gap == 0.0 or side != 0.0:
        mean = push + k_c * (rotor - y) + b_c * omega
        mean /= against + half * k_c + b_c
        torque = k_c * (rotor - y - half * mean) + b_c * (omega - mean)
        if gap == 0.0 or torque * side > 0.0:
            return torque, y + step_s * mean, 2.0 * mean - speed
    mean = push / against
    return 0.0, y + step_s * mean, 2.0 * mean - speed
