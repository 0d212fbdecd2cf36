# SPDX-License-Identifier: Apache-2.0
"""A serial ADC as its data sheet has it, to be wired to a bench at the pins.

The part knows time in ns, not the FPGA's clock: it is told of the levels at its pins and asked for
its output. Between a fall of SCLK and the end of the access time the output is wrong on purpose,
and what the data sheet forbids is an error: a clock too fast for the part fails the test.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass


class TimingError(AssertionError):
    """The part was used outside its limits."""


@dataclass(frozen=True)
class Limits:
    """A part's frame and limits, ns."""

    name: str
    data_bits: int
    lead_bits: int
    """Zeros before the data; the first is put out by the fall of CS."""
    frame_falls: int
    """Falls of SCLK before CS may rise."""
    sclk_period: float
    sclk_duty: float
    """Least part of the period that SCLK is high, and low."""
    cs_high: float
    cs_to_sclk: float
    cs_access: float
    sclk_access: float
    quiet: float
    """From the last fall of SCLK that the frame needs, where the output is let go, to CS's fall."""
    acquire: float
    """Least time for the input before CS falls, from the same fall of SCLK."""


AD7476A = Limits(
    name="AD7476A", data_bits=12, lead_bits=4, frame_falls=16, sclk_period=50.0, sclk_duty=0.4,
    cs_high=10.0, cs_to_sclk=10.0, cs_access=22.0, sclk_access=40.0, quiet=50.0, acquire=0.0,
)  # fmt: skip
"""12 bits, 1 MSPS, SCLK to 20 MHz (data sheet)."""

AD7276 = Limits(
    name="AD7276", data_bits=12, lead_bits=2, frame_falls=14, sclk_period=1e3 / 48, sclk_duty=0.4,
    cs_high=4.0, cs_to_sclk=6.0, cs_access=15.0, sclk_access=15.0, quiet=4.0, acquire=60.0,
)  # fmt: skip
"""12 bits, 3 MSPS, SCLK to 48 MHz. Data sheet but for the access times and the duty, which are
taken from memory, and cs_high, which is taken as the quiet time: check before relying on them."""


class AdcPart:
    """One converter; ``code_of`` gives its input as a code at the fall of CS."""

    def __init__(self, limits: Limits, code_of: Callable[[], int]) -> None:
        self.limits = limits
        self.code_of = code_of
        self.held = 0
        """Code of the frame that began last."""
        self.complete = 0
        """Frames that were read to their end, and those that were not."""
        self.aborted = 0
        self._cs_n = 1
        self._sclk = 1
        self._falls = 0
        self._ready = -math.inf
        self._cs_rise = -math.inf
        self._cs_fall = -math.inf
        self._sclk_fall = -math.inf
        self._sclk_rise = -math.inf
        self._released = -math.inf

    def _least(self, what: str, time: float, least: float) -> None:
        # Times are sums of periods in binary; a femtosecond is not a violation.
        if time < least - 1e-6:
            raise TimingError(f"{self.limits.name}: {what} {time:.1f} ns, least {least:.1f} ns")

    def pins(self, now: float, cs_n: int, sclk: int) -> None:
        """The levels at CS and SCLK from ``now`` on."""
        if cs_n != self._cs_n:
            self._cs_n = cs_n
            self._frame_starts(now, sclk) if cs_n == 0 else self._frame_ends(now)
        if sclk != self._sclk:
            self._sclk = sclk
            self._edge(now, sclk)

    def _frame_starts(self, now: float, sclk: int) -> None:
        limits = self.limits
        self._least("CS high", now - self._cs_rise, limits.cs_high)
        self._least("quiet time", now - self._released, limits.quiet)
        self._least("acquisition", now - self._released, limits.acquire)
        if not sclk:
            raise TimingError(f"{limits.name}: SCLK is low when CS falls")
        self._cs_fall = now
        self._ready = now + limits.cs_access
        self._falls = 0
        self.held = self.code_of()
        assert 0 <= self.held < 1 << limits.data_bits

    def _frame_ends(self, now: float) -> None:
        self._cs_rise = now
        if self._falls >= self.limits.frame_falls:
            self.complete += 1
        else:
            self._released = now
            self.aborted += 1

    def _edge(self, now: float, sclk: int) -> None:
        limits = self.limits
        least = limits.sclk_duty * limits.sclk_period
        if sclk:
            self._least("SCLK low", now - self._sclk_fall, least)
            self._sclk_rise = now
            return
        self._least("SCLK high", now - self._sclk_rise, least)
        if self._cs_n:
            raise TimingError(f"{limits.name}: SCLK falls outside a frame")
        if self._falls:
            self._least("SCLK period", now - self._sclk_fall, limits.sclk_period)
        else:
            self._least("CS to SCLK", now - self._cs_fall, limits.cs_to_sclk)
        self._sclk_fall = now
        self._falls += 1
        self._ready = now + limits.sclk_access
        if self._falls == limits.frame_falls:
            self._released = now

    def sdata(self, now: float) -> int:
        """The output as it stands at ``now``; wrong before its access time is over."""
        limits = self.limits
        place = limits.lead_bits + limits.data_bits - 1 - self._falls
        bit = (self.held >> place) & 1 if 0 <= place < limits.data_bits else 0
        if self._cs_n or place < 0:
            # The output is let go; a pull-up on the line.
            return 1
        return bit if now >= self._ready - 1e-6 else 1 - bit
