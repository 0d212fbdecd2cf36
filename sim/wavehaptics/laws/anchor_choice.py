# SPDX-License-Identifier: Apache-2.0
"""What ``controller.anchor_auto`` chooses, and why; SI values.

Everything is in proportion to the motor's numbers as the controller knows them, R̂, L̂, k̂_T and Ĵ,
so that one choice serves all:

- **ρ = 4 R̂.** It pulls an error of the flux back with the rate ρ/L. The larger, the less a voltage
  moves the wall, by ``V/ρ·L/(k_T Δ)`` cells, and the shorter the lag with which a wrong L̂ or k̂_T
  is made good: that lag is negative damping, 1 % of the speed in a bounce at L̂ −10 %.
  Beyond a fraction of the tick rate the loop swings by itself, so a slow tick takes less.
- **γ = 22.5 ρ a second**: what stays is learned within 44 ms, a dozen periods of a motor on its
  wall. While the rotor moves it learns an eighth as fast, or what it learns on the way in pushes on
  the way out.
- **For swings the resistance that loses most.** A bar of the commutator of 4 % less R, just where
  the rotor rests, feeds a swing of 1.3 mN·m; with this it is a tenth of that. It counts only while
  the rotor rests, or it would take from a bounce. Beside the inductor, on ``i`` less its mean of a
  time τ, it makes of the wall a spring that is softer for what is slow, inside a cell:
  ``K(s) = K/(1 + (R_s/L̂)·τ/(1 + sτ))``. Most is lost at ``ω = √(1 + R_s·τ/L̂)/τ``, and that is to
  be the rotor's ω on the wall. With more a light hand swings by a cell, over a wall that gives
  way: 0.25 mN·m on an RE 25 at 2 MHz, 9 % of the force on a motor that is slow on its wall. More
  than ρ/2 it needn't be.
- **R̂ at 0.85 of the winding's**: too little only damps, too much swings. With R̂ 10 % and the
  drive's gain 5 % too high that is less than R.
- **A rebound loses 3.5 % of its speed**: what c gives late, with all of L̂, k̂_T, R̂ and gain wrong,
  is no more than that on a motor with brushes.
- **c_0 = 0.8 V**: brushes of 0.5 V and a rest of dead time; what grows with the current, a wrong R̂
  and a wrong gain, is in the half of the waves' voltage that is added: R̂ at 0.77 R, R(θ) + 4 %
  and a gain that lacks 5 % ask for 0.43 of it.
- **η in free space a little below 1.** The waves hold the current at zero, and the winding swings
  on their delay at ``ω² = 2R̂/(L̂·(k + 1)·T)``, which nothing damps but what R̂ lacks of R. There an L̂
  that is too small by 10 % makes of ρ a negative resistance of ρ/10, and an amplifier's lag one of
  ``ω²·L̂·lag``: once begun, as by a contact's end, the swing goes on at the voltage limit. What
  returns has to be less by as much as they give, but for what the λ filter takes there.
"""

from __future__ import annotations

import cmath
import math
from typing import NamedTuple

ANCHOR_OF_R = 4.0
"""ρ over R̂."""
MOST_OF_TICK = 0.15
"""Largest ρ·T/L̂ with no more than one tick of extra latency: the correction acts two ticks late."""
LESS_BY_LATENCY = 1.45
"""With k of them it is less by k to this power. Held walls at 10 to 100 kHz swung at the voltage
limit from 0.075 on with k = 2, from 0.06 with 3 and from 0.03 with 4."""
LEARN_PER_S = 22.5
"""γ over ρ."""
SWING_OF_ANCHOR = 0.5
"""Largest resistance for swings over ρ."""
LIMIT_V = 0.8
LIMIT_PART = 1.0 / 3.0
"""Largest c_0: this, or that part of the drive's limit."""
REST_OF_SWING = 0.4
"""Shortest time between two edges the same way of a rotor at rest, times its ω on the wall."""
SLOW_RAD_S = 1.0
"""Speed below which the sensor's offset is tracked, rad/s."""
ZERO_PER_S = 200.0
"""Largest rate with which the offset follows c/R̂: a rotor that it pushes must not get faster than
that."""
TAUGHT_OF_SCALE = 8e-4
"""What a rotor that begins to move may teach of an offset, in parts of the sensor's full scale:
until its edges tell of motion, its k_T·ω looks like R·offset."""
STRANGE_CELLS = 4.5
"""Error of the flux beyond the limit of c, in cells, that no motor makes; two of them are what the
resistance for swings may want."""
STRANGE_PART = 0.5
"""What c may want beyond its limit at least, in parts of the drive's: cells may be small, and in a
hit a wrong L̂ asks for as much of the force as it is wrong, four times."""
MOST_HELD_UP = 0.02
"""Part of the depth that may be on its way in k ticks, k·T·R̂/2L̂, where a wall is set anew."""
LEAST_ETA_FREE = 0.9
WRONG_L = 0.1
"""Part by which L̂ may be wrong."""


class AnchorChoice(NamedTuple):
    """Values of a port anchor, SI."""

    ohm: float
    ohm_per_s: float
    limit_v: float
    rest_s: float
    """Two edges the same way within this: the rotor moves."""


def choose_anchor(
    r_hat: float, l_hat: float, k_t_hat: float, j_hat: float, tick_s: float, extra_ticks: int,
    drive_v: float,
) -> AnchorChoice:  # fmt: skip
    """The values for a motor as the controller knows it; ``j_hat`` in kg·m², ``drive_v`` in V.

    ``r_hat`` is the winding's, not the port's.
    """
    ohm = _usual_ohm(r_hat, l_hat, tick_s, extra_ticks)
    return AnchorChoice(
        ohm=ohm,
        ohm_per_s=LEARN_PER_S * ohm,
        limit_v=min(LIMIT_V, LIMIT_PART * drive_v),
        rest_s=REST_OF_SWING * math.sqrt(j_hat * l_hat) / k_t_hat,
    )


def choose_eta_free(
    r_hat: float, l_hat: float, lag_s: float, a: float, extra_ticks: int, tick_s: float,
    ohm: float | None = None,
) -> float:  # fmt: skip
    """η in free space for an anchor of ρ = ``ohm``, or the usual one.

    ``lag_s`` is the amplifier's, ``a`` the λ filter's coefficient.
    A rotor that is moved meets ``(1 − η)/(1 + η)`` of the damper that a short circuit is.
    """
    loop_s = (extra_ticks + 1) * tick_s
    if ohm is None:
        ohm = _usual_ohm(r_hat, l_hat, tick_s, extra_ticks)
    given = (WRONG_L * ohm * loop_s + 2.0 * r_hat * lag_s) / l_hat
    turn = tick_s * math.sqrt(2.0 * r_hat / (l_hat * loop_s))
    left = a / abs(1.0 - (1.0 - a) * cmath.exp(-1j * turn))
    return min(1.0, max(LEAST_ETA_FREE, 1.0 - given + 1.0 - left))


def choose_swing(ohm: float, l_hat: float, k_t_hat: float, j_hat: float, mean_s: float) -> float:
    """Resistance for swings, Ω, beside an anchor of ρ = ``ohm``; ``mean_s`` is the mean's τ."""
    loses_most = k_t_hat**2 * mean_s / j_hat - l_hat / mean_s
    return min(SWING_OF_ANCHOR * ohm, max(0.0, loses_most))


def choose_rebound(r_hat: float, l_hat: float, k_t_hat: float, j_hat: float, loss: float) -> float:
    """Magnitude of η of a rebound that leaves ``loss`` of its speed; ``r_hat`` is the port's.

    A quarter of a period of the rotor on its wall, and only that, sees the resistance
    ``R̂(1 − g)/(1 + g)`` beside the inductor's L̂·ω: π/4 of what they are to each other is lost.
    """
    ohm = 4.0 / math.pi * loss * k_t_hat * math.sqrt(l_hat / j_hat)
    return (r_hat - ohm) / (r_hat + ohm)


def choose_zero_rate(r_hat: float, cell_vs: float, full_scale_a: float) -> float:
    """Rate with which the offset follows c/R̂, 1/s; ``cell_vs`` is a cell's flux, k̂_T·Δ, in V·s.

    From rest a rotor goes a cell, whatever its speed, before it is known to move.
    """
    return min(ZERO_PER_S, TAUGHT_OF_SCALE * full_scale_a * r_hat / cell_vs)


def _usual_ohm(r_hat: float, l_hat: float, tick_s: float, extra_ticks: int) -> float:
    most = MOST_OF_TICK / max(1, extra_ticks) ** LESS_BY_LATENCY
    return min(ANCHOR_OF_R * r_hat, most * l_hat / tick_s)
