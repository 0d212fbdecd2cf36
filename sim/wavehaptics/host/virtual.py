# SPDX-License-Identifier: Apache-2.0
"""A board without hardware: the device's RTL with a motor, its line a pseudo-terminal."""

from __future__ import annotations

import errno
import math
import os
import select
import time
import tty
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from wavehaptics.host.led_hand import LedHand
from wavehaptics.ladder.linked_pins import LinkedPins
from wavehaptics.runtime.terminals import open_terminal

BLOCK_S = 2e-3
"""Wall-clock time that is simulated at a stretch: bytes wait no longer."""

_MOST_TICKS = 4096
_MOST_BYTES = 4096
_MOST_WAITING = 4096
"""Bytes before the line from which on the pseudo-terminal has to wait."""


class VirtualBoard:
    """The pseudo-terminal and what is behind it, as a context.

    ``path`` is where a host opens it. Its rate means nothing: bytes go at the rate that the device
    has. ``link`` becomes a symbolic link to it, and is removed at the end, unless it is another
    board's by then; ``OSError`` where it is something else. With ``hand`` the scene's hand is led
    by it.
    """

    def __init__(
        self, pins: LinkedPins, link: Path | None = None, hand: LedHand | None = None
    ) -> None:
        self._pins = pins
        self._link = link
        self._hand = hand
        self._ticks = 16

    def __enter__(self) -> VirtualBoard:
        self._master, self._slave, self.path = open_terminal()
        # Kept open, so that the line outlives its hosts.
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        if self._link is not None:
            if self._link.is_symlink():
                self._link.unlink()
            self._link.symlink_to(self.path)
        return self

    def __exit__(self, *_: object) -> None:
        if self._link is not None:
            # Another board may have taken the link over, or removed it.
            with suppress(OSError):
                if os.readlink(self._link) == self.path:
                    self._link.unlink()
        os.close(self._slave)
        os.close(self._master)

    def run(
        self, ended: Callable[[], bool], seconds: float | None = None, *, fastest: float = math.inf
    ) -> None:
        """Simulate until ``ended`` says so, or for ``seconds`` of simulated time.

        ``fastest``: seconds that are simulated in one of real time, at most.
        """
        first, start = self._pins.time_s, time.monotonic()
        most = max(1, round(min(_MOST_TICKS, fastest * BLOCK_S / self._pins.tick_s)))
        self._ticks = min(self._ticks, most)
        while not ended():
            before = time.monotonic()
            ahead = (self._pins.time_s - first) / fastest - (before - start)
            if ahead > 0:
                select.select([], [], [], min(ahead, BLOCK_S))
                continue
            self._take()
            if self._hand is not None:
                step_s = self._ticks * self._pins.tick_s
                self._pins.lead_hand(*self._hand.speed(self._pins.time_s, step_s))
            self._pins.elapse(self._ticks)
            self._give()
            passed = time.monotonic() - before
            self._ticks = round(min(max(1, self._ticks * BLOCK_S / passed), most))
            if seconds is not None and self._pins.time_s - first >= seconds:
                return

    def _take(self) -> None:
        if self._pins.waiting >= _MOST_WAITING:
            return
        if select.select([self._master], [], [], 0.0)[0]:
            self._pins.send(os.read(self._master, _MOST_BYTES))

    def _give(self) -> None:
        data = self._pins.received()
        if not data:
            return
        try:
            os.write(self._master, data)
        except OSError as error:  # nobody reads: as on a line, what isn't taken is lost
            if error.errno != errno.EAGAIN:
                raise
