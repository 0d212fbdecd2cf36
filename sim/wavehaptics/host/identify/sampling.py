# SPDX-License-Identifier: Apache-2.0
"""What is not known because a current is sampled once a pulse, and not its mean.

The sample is taken in the middle between two of the bridge's pulses, T apart. With pulses as long
as a part d of T it is less than the mean by d (1 − d²) (T R/L)²/24 of V/R, which counts where L/R
is no more than a few T. A current about zero changes its sign with each pulse, so that the brushes'
voltage does as well: a triangle of current, of V_b T/4L at the samples. The waves see both as the
samples have them, and R̂ is right as found; values for a data sheet are not. From record to record
it is all the same: the spreads of :func:`~wavehaptics.host.identify.segments.fit` don't have it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from wavehaptics.host.identify.back_emf import BackEmf
from wavehaptics.host.identify.mechanics import Mechanics
from wavehaptics.host.identify.resistance import Resistance
from wavehaptics.host.identify.segments import Estimate


def unseen_part(pulse_s: float, ohm: float, henry: float) -> float:
    """(T R/L)²/24: most of it that a small current is seen too small."""
    return (pulse_s * ohm / henry) ** 2 / 24.0


@dataclass(frozen=True)
class Sampling:
    """Pulses ``pulse_s`` apart, the winding as found, L in H, and the least test current.

    Each method gives what was found with its spread so much larger.
    """

    pulse_s: float
    found: Resistance
    henry: float
    least_a: float

    @property
    def part(self) -> float:
        """:func:`unseen_part` of it."""
        return unseen_part(self.pulse_s, self.found.ohm.value, self.henry)

    def winding(self) -> Resistance:
        """R, and V_b by R's error at the least current."""
        ohm = self.part * self.found.ohm.value
        return replace(
            self.found,
            ohm=self.found.ohm.widened(ohm),
            drop_v=self.found.drop_v.widened(ohm * self.least_a),
        )

    def back_emf(self, turn: BackEmf) -> BackEmf:
        """k_T either way."""
        return BackEmf(*map(self._by_part, (turn.k_t, turn.forward, turn.backward)))

    def inductance(self, found: Estimate) -> Estimate:
        """L."""
        return self._by_part(found)

    def mechanics(self, motion: Mechanics) -> Mechanics:
        """Friction by the torque of a current that isn't seen, the back-EMF's and V_b's, and J.

        What is said to be friction is no part of the torque that J has at the least current.
        """
        k_t, ohm = self.found.k_t.value, self.found.ohm.value
        unseen_a = self.pulse_s * abs(self.found.drop_v.value) / (4.0 * self.henry)
        part_of_j = unseen_a / self.least_a
        return replace(
            motion,
            inertia=self._by_part(motion.inertia).widened(part_of_j * motion.inertia.value),
            coulomb=motion.coulomb.widened(abs(k_t) * unseen_a),
            viscous=motion.viscous.widened(k_t**2 * self.part / ohm),
        )

    def _by_part(self, value: Estimate) -> Estimate:
        return value.widened(self.part * value.value)
