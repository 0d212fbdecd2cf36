# SPDX-License-Identifier: Apache-2.0
"""Where the scope's device is: a port, or a virtual board in a process of its own.

A virtual board can be unplugged and plugged in again, and tells simulated time and the hand.
"""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from wavehaptics.host.names import HostError
from wavehaptics.runtime.terminals import check_terminals

_MOST_AHEAD_S = 0.05
"""How long after its last word the simulated time is taken to go on."""
_ENDS_S = 2.0


@dataclass(frozen=True)
class Told:
    """What the side channel said last."""

    heard: float
    """``time.monotonic()`` then."""
    time_s: float
    hand: tuple[float, ...]
    """Where it is: rad, or x and y in m at the tip of an arm."""
    speed: float
    """Simulated time over real time."""

    @property
    def hand_rad(self) -> float:
        return self.hand[0]


class HandLine:
    """The side channel of a virtual board (:mod:`wavehaptics.host.led_hand`): leads and listens."""

    def __init__(self, path: Path) -> None:
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(1.0)
        try:
            self._socket.connect(os.fspath(path))
        except OSError as error:
            self._socket.close()
            raise HostError(f"{path}: no hand to lead: {error.strerror or error}") from None
        self._socket.settimeout(None)
        self.told: Told | None = None
        threading.Thread(target=self._listen, name="hand", daemon=True).start()

    def lead(self, *place: float) -> None:
        """Say where the hand is to go."""
        with contextlib.suppress(OSError):
            self._socket.send((" ".join(f"{one:.9g}" for one in place) + "\n").encode())

    def close(self) -> None:
        """End it."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _listen(self) -> None:
        first: tuple[float, float] | None = None
        speed = 0.0
        with contextlib.suppress(OSError, ValueError), self._socket.makefile("r") as lines:
            for line in lines:
                moment, *place = map(float, line.split())
                now = time.monotonic()
                if first is None:
                    first = now, moment
                elif now - first[0] >= 0.5:
                    speed = (moment - first[1]) / (now - first[0])
                    first = now, moment
                self.told = Told(now, moment, tuple(place), speed)

    def time_s(self) -> float | None:
        """Simulated time now, s: the last that was told, and what has passed since."""
        told = self.told
        if told is None:
            return None
        return told.time_s + told.speed * min(time.monotonic() - told.heard, _MOST_AHEAD_S)


class Plug:
    """A device on a port; ``hand`` is the side channel of a virtual board, if it is one."""

    virtual = False

    def __init__(self, port: str, hand: Path | None = None) -> None:
        self.port, self._hand_path = port, hand
        self.hand: HandLine | None = None

    @property
    def problem(self) -> str:
        """Why there can't be a device now, "" if there may be one."""
        return ""

    @property
    def plugged(self) -> bool:
        """Whether there is a device, or who knows."""
        return True

    def connect_hand(self) -> None:
        """Take the side channel, if there is one."""
        self.disconnect_hand()
        if self._hand_path is not None:
            self.hand = HandLine(self._hand_path)

    def disconnect_hand(self) -> None:
        """Leave the side channel."""
        if self.hand is not None:
            self.hand.close()
            self.hand = None

    def set_in(self, there: bool) -> None:
        """Plug in, or pull the plug; of a port that is for people."""
        raise HostError("this board has a plug of its own")

    def close(self) -> None:
        """Leave the device."""
        self.disconnect_hand()


class VirtualPlug(Plug):
    """A virtual board with a scene, in a process that ends with this one, however that is.

    The hand is that of ``motor``, None with an arm; ``more`` are options of ``wavehaptics board``.
    :class:`ToolError` where there can't be such a board.
    """

    virtual = True

    def __init__(
        self,
        scene: str,
        overrides: tuple[str, ...],
        motor: int | None = 0,
        more: Sequence[str] = (),
    ) -> None:
        check_terminals()
        self._folder = tempfile.TemporaryDirectory(
            prefix="wavehaptics-", ignore_cleanup_errors=True
        )
        folder = Path(self._folder.name)
        super().__init__(str(folder / "port"), folder / "hand")
        sets = [word for text in overrides for word in ("--set", text)]
        self._command = [
            sys.executable, "-m", "wavehaptics", "board", "--virtual", scene, *sets, "--paced",
            "--tied", "--link", self.port, "--hand", str(folder / "hand"),
            *(() if motor is None else ("--hand-of", str(motor))), *more,
        ]  # fmt: skip
        self._process: subprocess.Popen[str] | None = None
        self._wanted = True
        self._ready = False
        self._start()

    def _start(self) -> None:
        self._ready = False
        process = subprocess.Popen(
            self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, start_new_session=True,
        )  # fmt: skip
        self._process, self._last_words = process, ""
        for work in (self._await, self._listen):
            threading.Thread(target=work, args=(process,), name="board", daemon=True).start()

    def _await(self, process: subprocess.Popen[str]) -> None:
        """Its first line is the port's path."""
        assert process.stdout is not None
        if process.stdout.readline() and process is self._process:
            self._ready = True

    def _listen(self, process: subprocess.Popen[str]) -> None:
        """What it says of itself, until it has ended."""
        assert process.stderr is not None
        for line in process.stderr:
            if process is self._process:
                self._last_words = line.strip()
        process.wait()
        if process is self._process:
            self._ready = False

    @property
    def pid(self) -> int | None:
        """Of the board's process, if it runs."""
        process = self._process
        return process.pid if process is not None and process.poll() is None else None

    @property
    def plugged(self) -> bool:
        return self.pid is not None

    @property
    def problem(self) -> str:
        if not self._wanted:
            return "the plug is out"
        if self.pid is None:
            return f"the virtual board has ended: {self._last_words or 'nobody knows why'}"
        if self._ready:
            return ""
        return f"the virtual board starts: {self._last_words or 'the first time it is built'}"

    def set_in(self, there: bool) -> None:
        if there and self.pid is None:
            self._wanted = True
            self._start()
        elif not there:
            self._wanted = False
            if self._process is not None:
                self._process.kill()

    def close(self) -> None:
        super().close()
        process, self._process = self._process, None
        if process is not None and process.poll() is None:
            process.terminate()
            try:
                process.wait(_ENDS_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._folder.cleanup()
