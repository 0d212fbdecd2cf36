# SPDX-License-Identifier: Apache-2.0
"""Speed and position of a rotor against their limits, as ``rtl/wh_motion.v`` has them in integers.

A speed is a number of counts in a span of :data:`SPAN` control periods.
"""

from __future__ import annotations

from wavehaptics.controller.guard import SPAN
from wavehaptics.words.table import WORDS


class Motion:
    """State of one port; the limits are those of the registers of the same names.

    ``fast`` and ``outside`` are what raises ``OVERSPEED`` and ``WINDOW``.
    """

    def __init__(
        self,
        overspeed: int = 0,
        window_low: int = WORDS["window_low"].default,
        window_high: int = WORDS["window_high"].default,
        span: int = SPAN,
    ) -> None:
        self.overspeed, self.window_low, self.window_high = overspeed, window_low, window_high
        self.span = span
        self.fast = self.outside = False
        self._far = False
        self._began = 0
        self.restart()

    def restart(self) -> None:
        """The next period begins a span, whatever the rotor did before it."""
        self._periods, self._fresh = 0, True

    def period(self, position: int) -> None:
        """A control period in which the rotor is at ``position``, counts."""
        way = abs(position - self._began)
        far = not self._fresh and 0 < self.overspeed < way
        if self._fresh or self._periods == self.span:
            self.fast = far or (self.fast if self._fresh else self._far)
            self._far, self._fresh = False, False
            self._periods, self._began = 0, position
        else:
            self._far |= far
            self.fast |= far
        self._periods += 1
        self.outside = not self.window_low <= position <= self.window_high
