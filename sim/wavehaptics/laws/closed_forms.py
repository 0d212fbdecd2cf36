# SPDX-License-Identifier: Apache-2.0
"""Closed forms of the wave-haptic drive, scalars in SI units.

"Paper" is Niemeyer, Diolaiti and Tanner, *Wave Haptics: Encoderless Virtual Stiffnesses*, whose
symbols are kept. The motor is ``e_a = R i + L di/dt + k_T ω``; the wave transform is
``e_a = s u``, ``v = u − s i`` with ``s = √(2R̂)``; the virtual environment is
``u = η · λ/(s+λ) · v``.  Stiffnesses are torques over angles, N·m/rad.

The discrete forms hold for a controller of period T that reads the *mean* current of each tick,
filters with ``f += a (η v_n − f)`` and applies ``s f`` after k whole ticks of extra latency. They
are low-frequency expansions: the first two terms of the impedance that the port renders at the
frequencies of the mechanics, far below ``1/τ``.
"""

from __future__ import annotations

import math

MOST_A = 0.99
"""Largest filter coefficient. With a = 1 any lag of the current's amplifier is exactly unstable
near a quarter of the tick rate; this costs 0.01 % of the stiffness at 1 MHz."""


def k_l(k_t: float, inductance: float) -> float:
    """Spring of the inductor seen through the motor, ``K_L = k_T²/L``, N·m/rad (paper, sec. II).

    ``k_t`` in N·m/A, ``inductance`` in H.
    """
    return k_t**2 / inductance


def b_r(k_t: float, resistance: float) -> float:
    """Damper of the winding seen through the motor, ``B_R = k_T²/R``, N·m·s/rad (paper, sec. II).

    It is in series with the spring K_L. ``k_t`` in N·m/A, ``resistance`` in Ω.
    """
    return k_t**2 / resistance


def root(r_hat: float) -> float:
    """Scale of the wave transform, ``s = √(2R̂)``, √Ω, for a winding estimated at ``r_hat`` Ω.

    With it ``e·i = ½u² − ½v²``, where ``e = e_a − R̂ i``.
    """
    return math.sqrt(2.0 * r_hat)


def tau(tick_s: float, a: float, extra_ticks: int) -> float:
    """Delay from v to u at low frequency, ``τ = T/a + k T``, s.

    ``tick_s`` is T in s, ``a`` in (0, 1] the filter's coefficient, ``extra_ticks`` is k. The analog
    circuit has τ = 1/λ.
    """
    return tick_s / a + extra_ticks * tick_s


def _check_g(g: float) -> None:
    if not -1.0 < g <= 1.0:
        raise ValueError(f"g = −η must lie in (−1, 1], not {g:g}: at η = 1 no current flows")


def series_resistance(resistance: float, g: float = 1.0) -> float:
    """Resistance in series with the inductor for η = −g, ``R (1 − g)/(1 + g)``, Ω.

    Zero in rigid contact, g = 1. ``ValueError`` outside −1 < g ≤ 1.
    """
    _check_g(g)
    return resistance * (1.0 - g) / (1.0 + g)


def l_extra(resistance: float, tau_s: float, g: float = 1.0) -> float:
    """Inductance that the delay ``tau_s`` adds for η = −g, ``R τ · 2g/(1 + g)²``, H.

    It is negative where g < 0. ``ValueError`` outside −1 < g ≤ 1.
    """
    _check_g(g)
    return resistance * tau_s * 2.0 * g / (1.0 + g) ** 2


def l_eff(inductance: float, resistance: float, tau_s: float, g: float = 1.0) -> float:
    """Inductance that the user feels for η = −g, ``L + L_extra``, H.

    It is ``L + R τ/2`` in rigid contact, g = 1. ``inductance`` in H, ``resistance`` in Ω,
    ``tau_s`` the delay of :func:`tau` in s.
    """
    return inductance + l_extra(resistance, tau_s, g)


def stiffness(
    k_t: float, inductance: float, resistance: float, tau_s: float, g: float = 1.0
) -> float:
    """Stiffness of a wall, ``K = k_T²/L_eff``, N·m/rad, with :func:`l_eff` for η = −g.

    With g < 1 this spring is in series with the damper ``k_T²`` over :func:`series_resistance`.
    """
    return k_t**2 / l_eff(inductance, resistance, tau_s, g)


def free_space_inertia(k_t: float, resistance: float, tau_s: float) -> float:
    """Inertia that the delay adds to the rotor in free space (η = 1), ``k_T² τ/(2R)``, kg·m²."""
    return k_t**2 * tau_s / (2.0 * resistance)


def matched_a(tick_s: float, lambda_: float, extra_ticks: int) -> float:
    """Filter coefficient that gives the whole delay of the analog filter, ``a = T/(1/λ − k T)``.

    With it τ = 1/λ despite k = ``extra_ticks`` ticks of latency. If the latency is too long for
    that, the result is :data:`MOST_A`, the stiffest wall.
    ``tick_s`` in s, ``lambda_`` in rad/s.
    """
    left = 1.0 / lambda_ - extra_ticks * tick_s
    return MOST_A if MOST_A * left <= tick_s else tick_s / left


def filter_stiffness(k_t: float, resistance: float, lambda_: float) -> float:
    """Stiffness that the λ filter alone would have, ``2 k_T² λ/R``, N·m/rad.

    It is in series with K_L: ``1/K = 1/K_L + 1/filter_stiffness``. The paper's equation (14)
    prints half of this, ``k_T² λ/R``; the filter's delay 1/λ adds ``R/(2λ)`` to the inductance
    (:func:`l_extra`), so the factor 2 belongs there.
    """
    return 2.0 * k_t**2 * lambda_ / resistance


def brushless_torque_constant(pole_pairs: int, psi_vs: float) -> float:
    """Torque over the torque's current of a permanent-magnet motor, ``1.5 p ψ``, N·m/A.

    The current is the phases' amplitude, in the amplitude-invariant frame of Clarke and Park
    (Krishnan, *Permanent Magnet Synchronous and Brushless DC Motor Drives*, the torque
    ``3/2 · P/2 · λ_af · i_q`` of a machine without saliency; P poles are P/2 pairs).
    """
    return 1.5 * pole_pairs * psi_vs


def brushless_k_l(pole_pairs: int, psi_vs: float, inductance: float) -> float:
    """Spring of the inductances of three phases, ``K_L = 1.5 (pψ)²/L``, N·m/rad.

    Two ports hold the flux of the windings still, (11) of the paper for a vector: ``L i = ψ
    (e^{jpx₀} − e^{jpx})``, and the torque ``1.5 pψ i_q = −1.5 pψ²/L · sin p(x − x₀)`` has this
    slope at x₀, whatever x₀ is. It is :func:`k_l` of ``k_T = √1.5·pψ``, so that every form above
    holds with that k_T; ``inductance`` is a phase's, in H, along the axis q.
    """
    return k_l(brushless_k_t(pole_pairs, psi_vs), inductance)


def brushless_k_t(pole_pairs: int, psi_vs: float) -> float:
    """k_T of a motor with brushes that feels like the brushless one, ``√1.5 · pψ``, N·m/A."""
    return math.sqrt(1.5) * pole_pairs * psi_vs


def brushless_own_k_t(theta: float, fifth: float, seventh: float) -> float:
    """Torque for an ampere along q at the electrical angle ``theta``, over ``1.5 pψ``.

    A phase's back-EMF with a fifth and a seventh harmonic of these parts is, as a vector, ``jψpω
    (e^{jθ} − fifth·e^{−5jθ} + seventh·e^{7jθ})``; of that the part along q is ``1 − (fifth −
    seventh) cos 6θ``.
    """
    return 1.0 - (fifth - seventh) * math.cos(6.0 * theta)


def brushless_wall_torque(
    pole_pairs: int, psi_vs: float, inductance: float, resistance: float, tau_s: float, depth: float
) -> float:
    """Torque of a rigid contact at ``depth`` rad, ``−1.5 pψ²/L_eff · sin(p·depth)``, N·m.

    Unlike a wall on a motor with brushes this one gives way: beyond a quarter of an electrical turn
    the torque falls, and beyond a half the rotor falls into the next pole.
    """
    spring = brushless_k_t(pole_pairs, psi_vs) ** 2 / l_eff(inductance, resistance, tau_s)
    return -spring * math.sin(pole_pairs * depth) / pole_pairs


def brushless_drag(
    pole_pairs: int, psi_vs: float, inductance: float, resistance: float, tau_s: float,
    omega: float, g: float = 1.0,
) -> float:  # fmt: skip
    """Mean torque against a rotor that turns at ``omega`` rad/s in contact of η = −g, N·m.

    The magnets turn a voltage of ``pψω`` at pω through the series resistance r and L_eff of
    contact: ``1.5 (pψ)² ω r/(r² + (pω L_eff)²)``. It is to first order in pω·τ, as these forms are.
    """
    series = series_resistance(resistance, g)
    reactance = pole_pairs * omega * l_eff(inductance, resistance, tau_s, g)
    square = brushless_k_t(pole_pairs, psi_vs) ** 2
    return -square * omega * series / (series**2 + reactance**2)
