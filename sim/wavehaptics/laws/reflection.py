# SPDX-License-Identifier: Apache-2.0
"""A target impedance as the reflection W(s) that renders it.

An environment of mechanical impedance Z(s), torque over speed in N·m·s/rad, answers a wave with
``D = (B − Z)/(B + Z)``, ``B = k_T²/R̂`` (:func:`wavehaptics.laws.closed_forms.b_r`): +1 is
free space, −1 a rigid wall. In contact η is −1, so ``W = (Z − B)/(Z + B)``. The motor's
inductance is in series as the spring K_L, and the delay τ adds ``R̂ τ/2`` to the inductance. So a
felt spring K₁ needs ``1/K = 1/K₁ − 1/K_L,eff`` behind them. Nothing stiffer than K_L,eff is
possible.

All target impedances are a mass m, a damper b and a spring K in parallel, ``Z = m s + b + K/s``.
Polynomials are of s, the highest power first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wavehaptics.laws import closed_forms


class WishError(ValueError):
    """A target impedance that can't be rendered; one line with the cure."""


@dataclass(frozen=True)
class Wish:
    """A mass, a damper and a spring in parallel, SI units, and the spring in series with them."""

    mass: float
    damping: float
    spring: float
    """K of the environment itself, N·m/rad; the user feels it in series with K_L,eff."""
    front: float
    """K_L,eff, the motor's and the delay's spring, N·m/rad."""

    def environment(self, s: np.ndarray) -> np.ndarray:
        """Z(s) of the environment alone, N·m·s/rad."""
        return self.mass * s + self.damping + self.spring / s

    def felt(self, s: np.ndarray) -> np.ndarray:
        """Z(s) at the shaft: the environment behind K_L,eff, N·m·s/rad."""
        z = self.environment(s)
        felt: np.ndarray = z * self.front / (self.front + s * z)
        return felt


def front_stiffness(k_t: float, inductance: float, r_hat: float, tau_s: float) -> float:
    """K_L,eff, the largest possible stiffness, N·m/rad: :func:`closed_forms.stiffness`."""
    return closed_forms.stiffness(k_t, inductance, r_hat, tau_s)


def spring_behind(felt: float, front: float) -> float:
    """K that is ``felt`` in series with ``front``, N·m/rad; :class:`WishError` if there is none."""
    if not felt < front:
        raise WishError(
            f"shaper.stiffness = {felt:.6g} is stiffer than the motor and its delay allow, "
            f"K_L,eff = {front:.6g} N·m/rad; choose less, or omit [shaper] for the stiffest wall"
        )
    return 1.0 / (1.0 / felt - 1.0 / front)


def reflection(wish: Wish, wave_damper: float) -> tuple[np.ndarray, np.ndarray]:
    """Numerator and denominator of ``W(s) = (Z − B)/(Z + B)`` for B = ``wave_damper``."""
    m, b, k = wish.mass, wish.damping, wish.spring
    if k > 0.0:
        top = np.array([m, b - wave_damper, k])
        bottom = np.array([m, b + wave_damper, k])
    else:
        top, bottom = np.array([0.0, m, b - wave_damper]), np.array([0.0, m, b + wave_damper])
    return top, bottom


def excess(top: np.ndarray, bottom: np.ndarray) -> np.ndarray:
    """``|bottom(jω)|² − |top(jω)|²`` as a polynomial of ω², below zero where ``|W| > 1``."""
    found: np.ndarray = _square(bottom) - _square(top)
    return found


def worst_frequency(top: np.ndarray, bottom: np.ndarray) -> tuple[float, float]:
    """Largest ``|W(jω)|`` over all ω, and its ω in rad/s, infinite if it is only reached there.

    ``d|W|²/dω² = 0`` is a quadratic in ω², so no grid can miss the place.
    """
    n, m = _square(top), _square(bottom)
    turning: np.ndarray = np.polysub(np.polymul(np.polyder(n), m), np.polymul(n, np.polyder(m)))
    turning = np.where(np.abs(turning) < 1e-13 * np.abs(turning).max(initial=0.0), 0.0, turning)
    places = [0.0]
    if np.any(turning):
        roots = np.roots(np.trim_zeros(turning, "f"))
        places += [math.sqrt(r.real) for r in roots if abs(r.imag) < 1e-6 * abs(r) < r.real]
    gains = [(abs(np.polyval(top, 1j * w)) / abs(np.polyval(bottom, 1j * w)), w) for w in places]
    order = np.flatnonzero(bottom)[0]
    higher = np.any(top[:order])
    gains.append((math.inf if higher else abs(top[order] / bottom[order]), math.inf))
    return max(gains, key=lambda pair: pair[0])


def _square(p: np.ndarray) -> np.ndarray:
    """``|p(jω)|²`` of a quadratic p(s), as a quadratic of ω²."""
    p2, p1, p0 = p
    return np.array([p2 * p2, p1 * p1 - 2.0 * p0 * p2, p0 * p0])
