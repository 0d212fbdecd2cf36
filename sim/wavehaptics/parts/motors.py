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

Brushless motors, all values of one phase of the star. Where a maker gives values between two
terminals, R and L are half of them. ψ follows from what is given of the voltage between two
terminals, whose peak is √3 p ψ ω: KV is taken for that peak, ``p ψ = 60/(2π √3 KV)``, as in the
usual torque constant 8.27/KV = 1.5 p ψ, and maxon's k_M for its mean over the sixth of a turn in
which two phases carry the current, ``p ψ = k_M π/(3√3)``.

``gbm2804-100t``
    A camera gimbal's motor, as small haptic knobs have it: R, L, KV 206.2 and pole pairs from the
    preset ``GBM2804H_100T.h`` of the motor library javnson/gmp_pro (L_d = L_q there). J is an
    estimate, a ring of 15 g at 12.5 mm: the 497 g·cm² there can't be the bare rotor's.
``ec45-flat-70w``
    Maxon EC 45 flat, 70 W, 24 V: 0.573 Ω, 0.301 mH, 40.4 mN·m/A and 181 g·cm² of maxon's catalogue
    (its edition with the part numbers 651614 to 651621). The 8 pole pairs are from memory.
``mini-cheetah``
    The drone motor of the MIT Mini Cheetah's joints, without its gear: R, L, ψ = 2.4 mV·s and 21
    pole pairs of ``motor_config.h`` in its controller's firmware, by B. Katz; J, 63 kg·mm², from
    ``MiniCheetah.h`` of the Cheetah-Software, which has pψ = 0.05 as well, but R = 0.173 Ω.
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


class BrushlessConstants(NamedTuple):
    """Constants of a permanent-magnet motor of three phases, named as the keys of ``[motor]``."""

    R_ohm: float
    """Resistance of a phase, Ω."""
    L_h: float
    """Inductance of a phase, H."""
    pole_pairs: int
    psi_vs: float
    """Amplitude of the flux that the magnets send through a phase, V·s."""
    J_kgm2: float
    """Rotor inertia, kg·m²."""


BRUSHLESS_PRESETS: dict[str, BrushlessConstants] = {
    "gbm2804-100t": BrushlessConstants(4.7, 0.96e-3, 7, 3.820e-3, 23e-7),
    "ec45-flat-70w": BrushlessConstants(0.2865, 0.1505e-3, 8, 3.053e-3, 181e-7),
    "mini-cheetah": BrushlessConstants(0.105, 0.03e-3, 21, 2.4e-3, 630e-7),
}
"""Constants of brushless motors by preset name."""
