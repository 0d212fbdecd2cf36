# SPDX-License-Identifier: Apache-2.0
"""The cable from the rotor to the hand: a spring and a damper with a gap between them.

The place y where the hand holds the cable has no mass, so that both carry the same torque:
``K_c dz(x − y) + B_c (ω − dy/dt) = K_h (y − x_h) + B_h (dy/dt − dx_h/dt)``, dz being the dead zone
of ± half the backlash. In the gap, and where the damper would pull what the gap lets go, it is 0.
Within a step rotor and hand move evenly, and then y is known in closed form: an exponential towards
a straight line, whatever the two dampers are; without any it is on that line at once.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.motor.plant import C, P, Plant, R, S
from wavehaptics.runtime.compiled import compiled

CABLE_K, CABLE_B, HALF_GAP, HAND_K, HAND_B, HAND_OMEGA = range(6)


def cable_words(plant: Plant) -> np.ndarray:
    """Constants of :func:`cable_torque`; all zero without a cable."""
    if plant.cable is None:
        return np.zeros(HAND_OMEGA + 1)
    return np.array(
        [plant.cable.cable_stiffness, plant.cable.cable_damping, 0.5 * plant.cable.backlash_rad,
         plant.cable_hand_stiffness, plant.cable_hand_damping, plant.hand_omega]
    )  # fmt: skip


@compiled(inline="always")
def _toward_line(y, start, slope, time_constant, step_s):
    """(y at the end, its mean) of ``T dy/dt = line − y`` for a line of that start and slope."""
    first = start - slope * time_constant
    if time_constant <= 1e-6 * step_s:
        return start + slope * step_s, start + 0.5 * slope * step_s
    fallen = -np.expm1(-step_s / time_constant)
    off = y - first
    end = first + slope * step_s + off * (1.0 - fallen)
    return end, first + 0.5 * slope * step_s + off * fallen * time_constant / step_s


@compiled()
def cable_torque(state, x, omega, y, step_s, words):
    """Mean torque of the cable against the rotor over a step, N·m, and y at its end.

    ``state`` is the motor's, for the hand's path; the rotor begins at ``x`` and moves at ``omega``.
    """
    k_c, b_c, k_h, b_h = words[CABLE_K], words[CABLE_B], words[HAND_K], words[HAND_B]
    hand = state[P] + state[C]
    hand_speed = state[R] - words[HAND_OMEGA] * state[S]
    gap = words[HALF_GAP]
    side = 0.0
    if gap > 0.0:
        side = 1.0 if x - y > gap else (-1.0 if x - y < -gap else 0.0)
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
