# SPDX-License-Identifier: Apache-2.0
"""How to choose the anchor: ρ, its values on release and at the surface, γ and the limits of R̂.

Everything follows from the estimate R̂, the design spring's L_eff, the tick and the voltage limit.
"""

from __future__ import annotations

from dataclasses import dataclass

ANCHOR_OF_R = 0.15
RELEASE_OF_R = 7.0
SURFACE_OF_R = 0.2
FREE_OF_R = 0.65
RESPONSE_TICKS = 2.0
"""The anchor's time constant L_eff/ρ lasts at least so many times its own delay."""
TRACKING_S = 0.012
"""Time constant of the tracking at the reference current, s."""


@dataclass(frozen=True)
class AnchorChoice:
    """Resistances in Ω, γ in Ω/(A·s)."""

    anchor_ohm: float
    release_ohm: float
    surface_ohm: float
    track_gain: float


def choose_anchor(
    r_hat: float, l_eff: float, tick_s: float, extra_ticks: int, limit_v: float
) -> AnchorChoice:
    """Anchor for a motor estimated at ``r_hat`` Ω behind a design spring of ``l_eff`` H.

    * ``ρ = 0.15 R̂`` at rest: enough against ``|R − R̂|`` once the tracking has taken its part, and
      so little that its kick at an encoder's edge does not keep a soft hand's rotor swinging; in
      motion an eighth of the release stands in its place.
    * ``ρ_release = 7 R̂``: a rotor that comes back in the time π·√(J/K) leaves the force no
      time; the energy that it may gain is what passes in ``L_eff/ρ_release``.
    * ``ρ_surface = 0.2 R̂``: between two edges the encoder can't tell a rotor that turns from one
      that goes on. An R̂ above R would let the force grow meanwhile, and the more of that, the
      longer the bounce lasts beside L_eff/R; a series resistance larger than ``|R − R̂|``, here
      10 % of R̂ and 5 % of the drive's gain, lets it fall instead.
    * ``R̂_free = 0.65 R̂`` out of contact: there η = 1 drives the current to zero whatever R̂ is, but
      an R̂ above R makes the loop ring up; a lower one costs nothing but its share of the inertia
      ``k_T² τ/(2 R̂)``.
    * ``γ = ρ/(t·i)``, with t = 12 ms and the reference current ``i = limit/(4 R̂)``: the tracking
      is slower than the anchor by far, as ``γ·i ≪ ρ²/(4 L_eff)`` demands for no overshoot.

    No ρ exceeds ``L_eff/(2 (k + 2) T)``: the anchor acts ``k + 2`` ticks late.
    """
    fastest = l_eff / (RESPONSE_TICKS * (extra_ticks + 2) * tick_s)
    anchor = min(ANCHOR_OF_R * r_hat, fastest)
    return AnchorChoice(
        anchor_ohm=anchor,
        release_ohm=min(RELEASE_OF_R * r_hat, fastest),
        surface_ohm=min(SURFACE_OF_R * r_hat, fastest),
        track_gain=anchor / (TRACKING_S * limit_v / (4.0 * r_hat)),
    )
