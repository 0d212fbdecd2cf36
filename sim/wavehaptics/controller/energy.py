# SPDX-License-Identifier: Apache-2.0
"""The energy that a contact delivers to the shaft, as ``rtl/wh_energy.v`` counts it in integers.

``E = Σ ±i_n`` in A·counts, over the counts of a contact, each with the mean current of its period;
times k_T·Δ it is joules, Δ being the angle of a count. Force along the motion makes it larger. A
count after a turn goes back through the edge of the one before: no way was made, and it is not
added.
"""

from __future__ import annotations

from wavehaptics.words import formats

_CUT = formats.CURRENT.fraction - formats.ENERGY.fraction
_LIMIT_CUT = formats.ENERGY.fraction - formats.ENERGY_LIMIT.fraction
_MOVES = 1 << formats.HEADER_VALUES["MOVE_W"]


class ContactEnergy:
    """State of the observer. ``energy`` and ``peak`` are raw words of ``formats.ENERGY``, ``limit``
    one of ``formats.ENERGY_LIMIT``; ``over`` says that the contact delivered more than it."""

    def __init__(self, limit: int = 0) -> None:
        self.limit = limit
        self.energy = self.peak = self.position = 0
        self.contact = self.full = self.back = False

    @property
    def over(self) -> bool:
        return self.contact and not self.full and self.peak >> _LIMIT_CUT > self.limit

    def period(self, contact: bool, position: int, current: int) -> None:
        """A period at whose end the rotor is at ``position``, counts; ``current`` is its raw mean.

        It moves by less than half of what ``WH_MOVE_W`` bits hold.
        """
        moved = (position - self.position + _MOVES // 2) % _MOVES - _MOVES // 2
        if contact and not self.contact:
            self.energy = self.peak = 0
            self.full = False
        elif self.contact:
            part = (current >> _CUT) * (1 if moved > 0 else -1)
            turned = moved != 0 and (moved < 0) != self.back
            for _ in range(abs(moved) - turned):
                if formats.ENERGY.holds(self.energy + part):
                    self.energy += part
                    self.peak = max(self.peak, self.energy)
                else:
                    self.full = True
        self.contact, self.position = contact, position
        if moved:
            self.back = moved < 0

    def off(self) -> None:
        """The bridges are off: what was delivered stays, and the next contact is a new one."""
        self.contact = False
