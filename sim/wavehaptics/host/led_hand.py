# SPDX-License-Identifier: Apache-2.0
"""A hand that is led from outside: the side channel of a virtual board, which no real one has.

A socket at a path takes lines, each a position in rad, and tells lines ``TIME POSITION`` (simulated
s, rad) of where the hand is. At the tip of an arm a position is ``X Y`` in m.
"""

from __future__ import annotations

import math
import os
import socket
import time
from contextlib import suppress
from pathlib import Path

SETTLE_S = 0.01
"""Time constant with which the hand comes to where it is led, simulated s."""

MOST_RAD_S = 10.0
"""Fastest that it goes, rad/s."""

MOST_M_S = 0.1
"""Fastest that it goes at the tip of an arm, m/s."""

FURTHEST_RAD = 1000.0
"""Places beyond it, as a scene's, are refused."""

TELL_S = 0.01
"""Wall-clock time from one line about it to the next."""

_MOST_BYTES = 4096
_PARTS = 8


class Follower:
    """Where a hand is that follows a place: critically damped, no faster than ``most``."""

    def __init__(self, position: float, most: float = MOST_RAD_S) -> None:
        self.position = self.target = position
        self.speed, self._most = 0.0, most

    def follow(self, step_s: float) -> float:
        """Go on for ``step_s``; its mean speed in that time, rad/s."""
        before = self.position
        parts = max(1, math.ceil(step_s * _PARTS / SETTLE_S))
        part_s = step_s / parts
        for _ in range(parts):
            pull = (self.target - self.position) / SETTLE_S - 2.0 * self.speed
            speed = self.speed + pull * part_s / SETTLE_S
            self.speed = min(max(speed, -self._most), self._most)
            self.position += self.speed * part_s
        return (self.position - before) / step_s


class LedHand:
    """The socket at ``path`` for one guide at a time, as a context; the hand is at ``position``.

    The path is removed at the end, unless it is another board's by then. ``OSError`` where there is
    something else than a socket.
    """

    def __init__(self, path: Path, *position: float, most: float = MOST_RAD_S) -> None:
        self._path = path
        self._followers = [Follower(place, most) for place in position]
        self._guide: socket.socket | None = None
        self._text = b""
        self._told = 0.0

    def __enter__(self) -> LedHand:
        if self._path.is_socket():
            self._path.unlink()
        self._door = socket.socket(socket.AF_UNIX)
        self._door.bind(os.fspath(self._path))
        self._own = os.stat(self._path).st_ino
        self._door.listen(1)
        self._door.setblocking(False)
        return self

    def __exit__(self, *_: object) -> None:
        self._leave()
        self._door.close()
        # Another board may have taken the path over, or removed it.
        with suppress(OSError):
            if os.stat(self._path).st_ino == self._own:
                self._path.unlink()

    def speed(self, time_s: float, step_s: float) -> list[float]:
        """How fast the hand goes in the ``step_s`` after ``time_s``, rad/s; tells its guide."""
        self._listen()
        now = time.monotonic()
        if self._guide is not None and now - self._told >= TELL_S:
            self._told = now
            places = " ".join(f"{one.position:.9g}" for one in self._followers)
            self._tell(f"{time_s:.9f} {places}\n")
        return [one.follow(step_s) for one in self._followers]

    def _listen(self) -> None:
        if self._guide is None:
            try:
                self._guide, _ = self._door.accept()
            except BlockingIOError:
                return
            self._guide.setblocking(False)
            self._text = b""
        try:
            data = self._guide.recv(_MOST_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._leave()
            return
        *lines, self._text = (self._text + data).split(b"\n")
        self._text = self._text[-_MOST_BYTES:]
        for line in lines:
            try:
                places = [float(place) for place in line.split()]
            except ValueError:
                continue
            known = len(places) == len(self._followers)
            if known and all(abs(place) <= FURTHEST_RAD for place in places):
                for follower, place in zip(self._followers, places, strict=True):
                    follower.target = place

    def _tell(self, line: str) -> None:
        assert self._guide is not None
        try:
            self._guide.send(line.encode())
        except BlockingIOError:  # the guide doesn't read: what it gets is whole lines or none
            return
        except OSError:
            self._leave()

    def _leave(self) -> None:
        if self._guide is not None:
            self._guide.close()
            self._guide = None
