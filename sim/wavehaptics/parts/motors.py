# SPDX-License-Identifier: Apache-2.0
"""Motors by name, for ``[motor] preset`` of a scene.

``re25-118743``
    Maxon RE 25, 12 V. R and k_T from the data sheet. L is 0.24 mH (0.238 mH in the data sheet): it
    gives the K_L = k_T²/L = 2.2815 N·m/rad that the wave haptics paper states for this motor. J is
    the 10.3 g·cm² that belongs to k_T = 23.4 mN·m/A; another edition of the data sheet has 10.8
    beside 23.5.
``re25-phantom``
    The RE 25 of the paper's Phantom, whose 8:1 drive and 0.14 m arm give a tip stiffness of
    7500 N/m (``[transmission] ratio = 8, lever_m = 0.14``). The paper gives no inertia: J is that
    of the RE 25 above, which has the same rotor size and another winding.
``re30-48v``
    Maxon RE 30, 48 V winding, data sheet.
``re40-148877``
    Maxon RE 40, 148877, data sheet.
"""

from __future__ import annotations

from typing import NamedTuple


class MotorConstants(NamedTuple):
    """Constants of a DC motor, named as the keys of ``[motor]``."""

    R_ohm: float
    """Winding resistance at room temperature, Ω."""
    L_h: float
    """Winding inductance, H."""
    k_t: float
    """Torque constant, N·m/A; the same number is the back-EMF constant in V·s/rad."""
    J_kgm2: float
    """Rotor inertia, kg·m²."""


PRESETS: dict[str, MotorConstants] = {
    "re25-118743": MotorConstants(R_ohm=2.18, L_h=0.24e-3, k_t=23.4e-3, J_kgm2=10.3e-7),
    "re25-phantom": MotorConstants(R_ohm=7.6, L_h=0.83e-3, k_t=43.8e-3, J_kgm2=10.3e-7),
    "re30-48v": MotorConstants(R_ohm=2.45, L_h=0.513e-3, k_t=53.8e-3, J_kgm2=34.7e-7),
    "re40-148877": MotorConstants(R_ohm=1.16, L_h=0.33e-3, k_t=60.3e-3, J_kgm2=137e-7),
}
"""Constants by preset name."""
