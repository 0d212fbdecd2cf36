# SPDX-License-Identifier: Apache-2.0
"""The guard's watch of a motor that turns without a count, in integers."""

from __future__ import annotations

MEAN_LOG2 = 8
"""The mean of u + v forgets this part of it in a tick: ``wh_guard``'s MEAN_LOG2."""


class LostEncoder:
    """Of one motor. ``limit`` and waves are the upper 16 bits of words, ``enough`` is in ticks."""

    def __init__(self, limit: int, enough: int) -> None:
        self.limit, self.enough = limit, enough
        self.mean = self.still = 0
        self.negative = self.lost = False

    @property
    def turning(self) -> int:
        return self.mean >> MEAN_LOG2

    def tick(self, u: int, v: int, *, moved: bool = False) -> bool:
        """A tick's waves, and whether a count came; whether the encoder is lost by now."""
        turning = self.turning
        if moved:
            self.still, self.negative = 0, False
        over = turning < -self.limit if self.negative else turning > self.limit
        if self.still == 0:
            self.negative = turning < -self.limit
        self.still = self.still + 1 if over else max(0, self.still - 1)
        self.mean += u + v - turning
        self.lost = self.lost or self.still >= self.enough
        return self.lost
