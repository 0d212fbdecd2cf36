# SPDX-License-Identifier: Apache-2.0
"""A sigma-delta modulator as its data sheet has it, to be wired to a bench at the pins."""

from __future__ import annotations

import math
from collections.abc import Callable

from adc_part import TimingError
from wavehaptics.motor import sigma_delta
from wavehaptics.parts.adcs import Modulator


class ModulatorPart:
    """One modulator; ``level_of`` gives its input in parts of full scale at a rise of its clock.

    After a rise the old bit stays for the hold time, and the new one is there after the access
    time; between them the output is wrong on purpose.
    """

    def __init__(self, part: Modulator, level_of: Callable[[], float]) -> None:
        self.part = part
        self.level_of = level_of
        self.bits: list[int] = []
        """Every bit, with each rise of the clock."""
        self._state = sigma_delta.new_state()
        self._clock = 0
        self._rise = -math.inf
        self._edge = -math.inf

    def pins(self, now: float, clock: int) -> None:
        """The level of the clock from ``now`` on."""
        if clock == self._clock:
            return
        part, name = self.part, self.part.name
        if self._edge > -math.inf and now - self._edge < 1e9 * part.level_s - 1e-6:
            level = "high" if self._clock else "low"
            raise TimingError(f"{name}: clock {level} {now - self._edge:.1f} ns")
        self._clock, self._edge = clock, now
        if not clock:
            return
        period = now - self._rise
        if not 1e9 / part.most_hz - 1e-6 <= period <= 1e9 / part.least_hz + 1e-6 and (
            self._rise > -math.inf
        ):
            raise TimingError(f"{name}: clock period {period:.1f} ns")
        self._rise = now
        self.bits.append(sigma_delta.next_bit(self._state, self.level_of()))

    def output(self, now: float) -> int:
        """The output as it stands at ``now``."""
        since = now - self._rise
        if not self.bits:
            return 0
        old = self.bits[-2] if len(self.bits) > 1 else 0
        if since < 1e9 * self.part.data_hold_s:
            return old
        return self.bits[-1] if since >= 1e9 * self.part.access_s - 1e-6 else 1 - self.bits[-1]
