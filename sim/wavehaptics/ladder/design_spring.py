# SPDX-License-Identifier: Apache-2.0
"""The spring that a controller's settings are made to render."""

from __future__ import annotations

import math

from wavehaptics.laws import closed_forms
from wavehaptics.scene import Scene


def rendered_stiffness(
    scene: Scene, r_hat: float, tau_s: float, eta: float, anchored: bool, spring: float | None
) -> float:
    """K of the design spring for a contact with ``eta``, N·m/rad; 0 where nothing is pushed back.

    ``r_hat`` in Ω and the delay ``tau_s`` are the port's; ``spring`` is W's, N·m/rad, or None.
    """
    k_t, inductance, k_t_hat = scene.motor.felt_k_t, scene.motor.L_h, scene.controller.k_t_hat
    wished = (k_t / k_t_hat) ** 2
    if anchored:
        wished = k_t / k_t_hat
        k_t, inductance = math.sqrt(k_t * k_t_hat), scene.controller.l_hat
    g = -eta
    if g <= -1.0:
        return 0.0
    if spring is not None:
        spring *= wished
        front = closed_forms.stiffness(k_t, inductance, r_hat, tau_s)
        return spring * front / (spring + front)
    return closed_forms.stiffness(k_t, inductance, r_hat, tau_s, g)
