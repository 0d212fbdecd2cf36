# SPDX-License-Identifier: Apache-2.0
"""A serial ADC as its data sheet has it, to be wired to a bench at the pins.

The part knows time in ns, not the FPGA's clock: it is told of the levels at its pins and asked for
its output. Between an edge that launches a bit and the end of the access time the output is wrong
on purpose, and what the data sheet forbids is an error: a clock too fast for the part fails the
test. The figures are those of :mod:`wavehaptics.parts.adcs`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from wavehaptics.parts.adcs import PARTS, Part

AD7276 = PARTS["AD7276"]
AD7476A = PARTS["AD7476A"]

UNCALIBRATED = 37
"""Codes by which a part is off that was not let measure its own offset."""

RESET_WORD = 0x0040
"""Command of the MAX11125 that resets it."""

DIN_SETUP_NS = 4.0
"""DIN before SCLK's rise, least: from memory."""


class TimingError(AssertionError):
    """The part was used outside its limits."""


class AdcPart:
    """One converter; ``code_of`` gives its input as a code at the fall of CS.

    A part with commands (``din``) is asked for the channel by ``code_of(channel)``.
    """

    def __init__(self, part: Part, code_of: Callable[..., int]) -> None:
        self.part = part
        self.code_of = code_of
        self.held = 0
        """Code of the frame that began last."""
        self.codes: list[int] = []
        """Code of every complete frame that held the input, in turn."""
        self.complete = 0
        """Frames that were read to their end, and those that were not."""
        self.aborted = 0
        self.calibrated = part.calibrate_bits == 0
        self.commands: list[int] = []
        """Words that came by DIN."""
        self.channel = 0
        self._inputs: list[int] = []
        self._out = 0
        self.cut_off()

    def cut_off(self) -> None:
        """The FPGA is reset: what that does to the pins is not judged."""
        self._invalid = False
        self._cs_n = 1
        self._sclk = self.part.idle
        self._din = 0
        self._word = 0
        self._edges = 0
        self.pulses = 0
        """Of SCLK, in the last frame."""
        self._ready = -math.inf
        self._cs_rise = -math.inf
        self._cs_fall = -math.inf
        self._edge_at = -math.inf
        self._leading_at = -math.inf
        self._din_at = -math.inf
        self._released = -math.inf
        self._tracking = -math.inf

    def _least(self, what: str, time: float, least_s: float) -> None:
        # Times are sums of periods in binary; a femtosecond is not a violation.
        if time < 1e9 * least_s - 1e-6:
            raise TimingError(f"{self.part.name}: {what} {time:.1f} ns, least {1e9 * least_s:.1f}")

    def pins(self, now: float, cs_n: int, sclk: int, din: int = 0) -> None:
        """The levels at CS, SCLK and DIN from ``now`` on."""
        if cs_n != self._cs_n and cs_n == 0:
            self._cs_n = 0
            self._frame_starts(now, sclk)
        if sclk != self._sclk:
            self._sclk = sclk
            self._edge(now)
        if cs_n != self._cs_n:
            self._cs_n = 1
            self._frame_ends(now)
        if din != self._din:
            self._din, self._din_at = din, now

    def _frame_starts(self, now: float, sclk: int) -> None:
        part = self.part
        self._least("CS high", now - self._cs_rise, part.cs_high_s)
        self._least("quiet time", now - self._released, part.quiet_s)
        self._least("acquisition", now - self._tracking, part.acquire_s)
        self._least("cycle", now - self._cs_fall, 1 / part.rate_hz)
        if sclk != part.idle or self._sclk != part.idle:
            raise TimingError(f"{part.name}: SCLK is not at {part.idle} when CS falls")
        self._cs_fall = now
        self._ready = now + 1e9 * part.cs_access_s
        self._edges = 0
        self._word = 0
        if part.kind == "command":
            self._inputs = [self.code_of(channel) for channel in range(16)]
            self.held = self._inputs[self.channel]
        else:
            self.held = self._out = self._disturbed(self.code_of())
        assert 0 <= self.held < 1 << part.bits

    def _disturbed(self, code: int) -> int:
        """The code that the part makes: off without calibration, nonsense after a short frame."""
        top = (1 << self.part.bits) - 1
        if not self.calibrated:
            code = min(code + UNCALIBRATED, top)
        return code ^ top if self._invalid else code

    def _frame_ends(self, now: float) -> None:
        part = self.part
        self._cs_rise = now
        pulses = self.pulses = self._edges // 2
        self._invalid = False
        if not self.calibrated and pulses >= part.calibrate_bits:
            # The frame was for the offset, not for a code.
            self.calibrated = True
        elif pulses < part.frame_bits or self._edges % 2:
            self._released = self._tracking = now
            self._invalid = True
            self.aborted += 1
            return
        else:
            self.complete += 1
            self.codes.append(self.held)
        self._least("last edge to CS", now - self._edge_at, part.hold_s)
        if part.kind == "command":
            self._obey(self._word)

    def _obey(self, word: int) -> None:
        """A word has come: what was asked for by hand is converted, and comes in the next frame."""
        self.commands.append(word)
        if word & 0x8000:
            return
        if word == RESET_WORD:
            self.channel = 0
        elif word >> 11 == 1:
            self.channel = (word >> 7) & 15
            assert not word & 4, "the frame with the channel's number is another"
            self._out = self.held = self._inputs[self.channel]
            self.codes[-1] = self.held

    def _edge(self, now: float) -> None:
        part = self.part
        if self._cs_n:
            raise TimingError(f"{part.name}: SCLK moves outside a frame")
        self._edges += 1
        leading = self._edges % 2 == 1
        if self._edges == 1:
            self._least("CS to SCLK", now - self._cs_fall, part.setup_s)
        else:
            name = "low" if self._sclk else "high"
            self._least(f"SCLK {name}", now - self._edge_at, part.duty / part.sclk_hz)
            if leading:
                self._least("SCLK period", now - self._leading_at, 1 / part.sclk_hz)
        self._edge_at = now
        if leading:
            self._leading_at = now
        if leading != part.launch_trailing:
            self._ready = now + 1e9 * part.access_s
        if part.kind == "command" and self._sclk and self._edges <= 32:
            if now - self._din_at < DIN_SETUP_NS - 1e-6:
                raise TimingError(f"{part.name}: DIN changes {now - self._din_at:.1f} ns early")
            self._word = self._word << 1 | self._din
        if self._edges == 2 * part.frame_bits - 1:
            self._released = now + 1e9 * part.release_s
        if self._edges == part.track_edge:
            self._tracking = now

    def sdata(self, now: float) -> int:
        """The output as it stands at ``now``; wrong before its access time is over."""
        part = self.part
        if self._cs_n:
            # The output is let go; a pull-up on the line.
            return 1
        launched = (self._edges + 1) // 2 if not part.launch_trailing else self._edges // 2
        index = launched + (0 if part.launch_late else 1)
        place = part.lead_bits + part.bits - index
        bit = (self._out >> place) & 1 if 0 <= place < part.bits else 0
        return bit if now >= self._ready - 1e-6 else 1 - bit
