# SPDX-License-Identifier: Apache-2.0
"""What ``controller.anchor_auto`` chooses, and why; SI values.

Everything is in proportion to the motor's own R̂ and L̂, so that one choice serves all. No
inertia is needed:

- **ρ = 8 R̂.** It pulls an error of the flux back with the rate ρ/L. The larger, the less a
  voltage moves the wall, and the shorter the lag L/ρ with which the force changes at an edge.
  That lag is negative damping: with 4 R̂ a lever of ten times the rotor's inertia never came to
  rest. Beyond a fraction of the control rate the loop swings by itself, so a slow period takes
  less.
- **R̂ at 0.7 of the winding's.** Too little only damps, too much swings. With R̂ 10 % and the
  drive's gain 5 % too high, and a winding at −20 °C, that is still less than R. What it lacks is
  learned as θ.
- **γ = 16 ρ a second** at a current of 0.93·c_0/R̂: what stays is learned within 60 ms.
- **θ ≤ 1.5 R̂ of the port**: a winding of 125 °C has 1.41 R. With R̂ and gain too low that lacks
  0.8 R, and brushes ask for the rest. A quarter of it is what a new port begins with.
- **y' follows within 8 ms**: fast beside a hand's press (4 Hz), slow beside the slowest load on
  its wall. In a fast hit it also follows with each count (:mod:`wavehaptics.controller.anchor`).
- **Brushes: 0.55·c_0 as a current of R̂.** θ then has to supply less at small currents than at
  large ones. A brushless motor has none.
- **c_0 = 1.2 V**: with it the first press holds a winding of 125 °C at rated torque, before θ is
  learned.
- **η in free space a little below 1.** The waves hold the current at zero, and the winding swings
  on their delay at ``ω² = 2R̂/(L̂·(k + 1)·T)``, which nothing damps but what R̂ lacks of R. There
  an L̂ that is too small by 10 % makes of ρ a negative resistance of ρ/10, and an amplifier's lag
  one of ``ω²·L̂·lag``: once begun, as by a contact's end, the swing goes on at the voltage limit.
  What returns has to be less by as much as they give, but for what the λ filter takes there.
"""

from __future__ import annotations

import cmath
import math
from typing import NamedTuple

ANCHOR_OF_R = 8.0
"""ρ over R̂."""
MOST_OF_TICK = 0.15
"""Largest ρ·T/L̂ with at most one period of extra latency: the correction acts two periods late."""
LESS_BY_LATENCY = 1.45
"""With k of them it is less by k to this power. Held walls at 10 to 100 kHz swung at the voltage
limit from 0.075 on with k = 2, from 0.06 with 3 and from 0.03 with 4."""
LEARN_PER_S = 16.0
"""γ over ρ."""
LEARN_OF_LIMIT = 0.93
"""R̂ times the current at which it is so, over c_0."""
BRUSH_OF_LIMIT = 0.55
"""R̂ times the current that stands for the brushes, over c_0."""
MOST_LEARNED = 1.5
"""Largest θ over the port's R̂."""
FOLLOW_S = 8e-3
"""Time constant of y', s."""
LIMIT_V = 1.2
LIMIT_PART = 1.0 / 3.0
"""Largest c_0: this, or that part of the drive's limit."""
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
LEAST_ETA_FREE = 0.9
WRONG_L = 0.1
"""Part by which L̂ may be wrong."""


class AnchorChoice(NamedTuple):
    """Values of a port anchor, SI."""

    ohm: float
    ohm_per_s: float
    learn_a: float
    """Current at which θ·i is learned with ``ohm_per_s``."""
    most_ohm: float
    brush_a: float
    limit_v: float
    follow_s: float


def choose_anchor(
    r_hat: float, port_ohm: float, l_hat: float, tick_s: float, extra_ticks: int, drive_v: float,
    *, brushed: bool,
) -> AnchorChoice:  # fmt: skip
    """The values for a motor as the controller knows it; ``drive_v`` in V.

    ``r_hat`` is the winding's, ``port_ohm`` the port's.
    """
    ohm = _usual_ohm(r_hat, l_hat, tick_s, extra_ticks)
    limit_v = min(LIMIT_V, LIMIT_PART * drive_v)
    return AnchorChoice(
        ohm=ohm,
        ohm_per_s=LEARN_PER_S * ohm,
        learn_a=LEARN_OF_LIMIT * limit_v / r_hat,
        most_ohm=MOST_LEARNED * port_ohm,
        brush_a=BRUSH_OF_LIMIT * limit_v / r_hat if brushed else 0.0,
        limit_v=limit_v,
        follow_s=FOLLOW_S,
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


def choose_zero_rate(r_hat: float, cell_vs: float, full_scale_a: float) -> float:
    """Rate with which the offset follows c/R̂, 1/s; ``cell_vs`` is a cell's flux, k̂_T·Δ, in V·s.

    From rest a rotor goes a cell, whatever its speed, before it is known to move.
    """
    return min(ZERO_PER_S, TAUGHT_OF_SCALE * full_scale_a * r_hat / cell_vs)


def _usual_ohm(r_hat: float, l_hat: float, tick_s: float, extra_ticks: int) -> float:
    most = MOST_OF_TICK / max(1, extra_ticks) ** LESS_BY_LATENCY
    return min(ANCHOR_OF_R * r_hat, most * l_hat / tick_s)
