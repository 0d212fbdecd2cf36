# SPDX-License-Identifier: Apache-2.0
"""The values that ``controller.anchor_auto`` chooses, and why; SI units.

All are proportional to the motor's own R̂ and L̂, so one choice serves all motors. No inertia is
needed:

- **ρ = 8 R̂.** It corrects an error of the flux at the rate ρ/L. With a larger ρ a voltage error
  moves the wall less, and the force changes at an edge with a shorter lag L/ρ. That lag is
  negative damping: with 4 R̂ a lever of ten times the rotor's inertia never came to rest. Beyond
  a fraction of the control rate the loop oscillates by itself, so a slow rate needs a smaller ρ.
- **R̂ at 0.7 of the winding's.** An R̂ that is too small only damps; one that is too large
  oscillates. With R̂ 10 % and the drive's gain 5 % too high, and a winding at −20 °C, 0.7 is still
  less than R. The missing resistance is learned as θ.
- **γ = 16 ρ a second** at a current of 0.93·c_0/R̂: a constant error is learned within 60 ms.
- **θ ≤ 1.5 R̂ of the port**: a winding of 125 °C has 1.41 R. With R̂ and gain too low 0.8 R are
  missing, and brushes need the rest. A new port begins with a quarter of it.
- **y' follows within 8 ms**: fast compared with a hand's press (4 Hz), slow compared with the
  slowest load on its wall. In a fast hit it also follows with each count
  (:mod:`wavehaptics.controller.anchor`).
- **Brushes: 0.55·c_0 as a current of R̂.** So θ need not be larger at small currents than at large
  ones. A brushless motor has none.
- **c_0 = 1.2 V**: it holds the first press on a winding of 125 °C at rated torque, before θ is
  learned.
- **η in free space slightly below 1.** The waves hold the current at zero, and with their delay
  the winding oscillates at ``ω² = 2R̂/(L̂·(k + 1)·T)``. Only the resistance that R̂ lacks damps
  this. At this frequency an L̂ that is too small by 10 % turns ρ into a negative resistance of
  ρ/10, and an amplifier's lag adds ``ω²·L̂·lag``. An oscillation that has begun, for instance as a
  contact ends, would continue at the voltage limit. So the reflected wave is reduced by as much as
  these two give, less what the λ filter takes at this frequency.
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
"""With k of them it is divided by k to this power. Held walls at 10 to 100 kHz oscillated at the
voltage limit from 0.075 on with k = 2, from 0.06 with 3 and from 0.03 with 4."""
LEARN_PER_S = 16.0
"""γ over ρ."""
LEARN_OF_LIMIT = 0.93
"""R̂ times the current for which γ holds, over c_0."""
BRUSH_OF_LIMIT = 0.55
"""R̂ times the current that stands for the brushes, over c_0."""
MOST_LEARNED = 1.5
"""Largest θ over the port's R̂."""
FOLLOW_S = 8e-3
"""Time constant of y', s."""
LIMIT_V = 1.2
LIMIT_PART = 1.0 / 3.0
"""Largest c_0: this, or this fraction of the drive's limit, whichever is less."""
SLOW_RAD_S = 1.0
"""Speed below which the sensor's offset is tracked, rad/s."""
ZERO_PER_S = 200.0
"""Largest rate with which the offset follows c/R̂: a rotor that it pushes must not get faster than
that."""
TAUGHT_OF_SCALE = 8e-4
"""Largest error of the offset that a starting rotor may cause, as a fraction of the sensor's full
scale: until the next edge, its k_T·ω looks like R·offset."""
STRANGE_CELLS = 4.5
"""Error of the flux beyond the limit of c, in counts, that no motor makes. Two of them may be due
to the resistance 2θ that damps oscillations."""
STRANGE_PART = 0.5
"""Least plausibility limit, as a fraction of the drive's limit: counts may be small, and in a hit
an error of L̂ needs four times that fraction of the force."""
LEAST_ETA_FREE = 0.9
WRONG_L = 0.1
"""Relative error that L̂ may have."""


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
    """The values for the controller's estimates of a motor; ``drive_v`` in V.

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
    """η in free space for an anchor of ρ = ``ohm``, by default that of :func:`choose_anchor`.

    ``lag_s`` is the amplifier's, ``a`` the λ filter's coefficient.
    A moving rotor meets ``(1 − η)/(1 + η)`` of the damping of a short-circuited winding.
    """
    loop_s = (extra_ticks + 1) * tick_s
    if ohm is None:
        ohm = _usual_ohm(r_hat, l_hat, tick_s, extra_ticks)
    given = (WRONG_L * ohm * loop_s + 2.0 * r_hat * lag_s) / l_hat
    turn = tick_s * math.sqrt(2.0 * r_hat / (l_hat * loop_s))
    left = a / abs(1.0 - (1.0 - a) * cmath.exp(-1j * turn))
    return min(1.0, max(LEAST_ETA_FREE, 1.0 - given + 1.0 - left))


def choose_zero_rate(r_hat: float, cell_vs: float, full_scale_a: float) -> float:
    """Rate with which the offset follows c/R̂, 1/s; ``cell_vs`` is a count's flux, k̂_T·Δ, in V·s.

    A rotor that starts from rest shows its motion only after a count, whatever its speed.
    """
    return min(ZERO_PER_S, TAUGHT_OF_SCALE * full_scale_a * r_hat / cell_vs)


def _usual_ohm(r_hat: float, l_hat: float, tick_s: float, extra_ticks: int) -> float:
    most: float = MOST_OF_TICK / max(1, extra_ticks) ** LESS_BY_LATENCY
    return min(ANCHOR_OF_R * r_hat, most * l_hat / tick_s)
