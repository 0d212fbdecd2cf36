# SPDX-License-Identifier: Apache-2.0
"""The hand: a path x_h(t) as a linear system, so that the plant can be advanced exactly with it.

``x_h = p + c`` with ``p' = r``, ``r' = 0``, ``c' = −Ω s``, ``s' = Ω c``: a ramp and an oscillation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from wavehaptics.scene import Scene

PRESS_RAMP_S = 0.05
"""Time that the path ``press`` takes from −A/10 to A, s."""


@dataclass(frozen=True)
class HandPath:
    """Where the hand starts and how it moves.

    ``start`` holds (p, r, c, s) at t = 0 in rad and rad/s, ``omega`` is Ω in rad/s, and
    ``ramp_end_s`` the time at which r becomes zero (infinite where it never changes).
    """

    start: tuple[float, float, float, float]
    omega: float = 0.0
    ramp_end_s: float = math.inf

    @property
    def x0(self) -> float:
        """x_h(0), rad."""
        return self.start[0] + self.start[2]

    @property
    def v0(self) -> float:
        """dx_h/dt at t = 0, rad/s."""
        return self.start[1] - self.omega * self.start[3]


def hand_path(scene: Scene) -> HandPath:
    """Path of the scene's hand; without a hand, a rotor at rest at 0.

    The path ``impact`` has no hand: its start says where and how fast the rotor is released.
    """
    hand = scene.hand
    if hand is None:
        return HandPath((0.0, 0.0, 0.0, 0.0))
    amplitude = hand.amplitude_rad
    if hand.path == "impact":
        assert hand.speed_rad_s is not None
        return HandPath((-amplitude, hand.speed_rad_s, 0.0, 0.0))
    if hand.path == "press":
        speed = 1.1 * amplitude / PRESS_RAMP_S
        return HandPath((-amplitude / 10, speed, 0.0, 0.0), ramp_end_s=PRESS_RAMP_S)
    assert hand.frequency_hz is not None
    omega = 2 * math.pi * hand.frequency_hz
    if hand.path == "taps":
        return HandPath((0.0, 0.0, -amplitude, 0.0), omega)
    if hand.path == "free":
        return HandPath((-2 * amplitude, 0.0, 0.0, -amplitude), omega)
    return HandPath((0.0, 0.0, 0.0, -amplitude), omega)
