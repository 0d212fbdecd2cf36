# SPDX-License-Identifier: Apache-2.0
"""`pins` with the settings memory in the RTL: its words go over the bus, also while it runs.

No command runs it: by it tests hold ``wh_device`` row by row to the controller that is in it,
without a line between.
"""

from __future__ import annotations

import ctypes
from typing import NamedTuple

from wavehaptics.ladder.brushless_pins import BrushlessPinsSimulation
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.words.memory import requests, settings_requests
from wavehaptics.words.table import WORDS, Values

COMMIT = WORDS["commit"].at()
DISCARD = WORDS["discard"].at()


class Answer(NamedTuple):
    """Clock in which a request ended, the word that was read, and the bus's error."""

    clock: int
    data: int
    error: int


class DevicePins(PinsSimulation):
    """`pins` as ``rtl/wh_device.v``."""

    TOP = "wh_device"
    SHIM = "device_shim.cpp"
    SHOWS: tuple[str, ...] = ("device_shim.vlt", "ports_steps.vlt")
    PREFIX = "wh_device"
    turns = 1

    def _new_model(self, words: ctypes.Array, inputs: int) -> int | None:
        library = self._library
        new = library.wh_device_new
        new.argtypes = [ctypes.POINTER(ctypes.c_uint32), *[ctypes.c_int64] * 4]
        new.restype = ctypes.c_void_p
        library.wh_device_request.argtypes = [ctypes.c_void_p, *[ctypes.c_int64] * 4]
        library.wh_device_request.restype = None
        library.wh_device_clocks.argtypes = [ctypes.c_void_p]
        library.wh_device_clocks.restype = ctypes.c_int64
        library.wh_device_answers.argtypes = [
            ctypes.c_void_p, ctypes.POINTER(ctypes.c_int64), ctypes.c_int64
        ]  # fmt: skip
        library.wh_device_answers.restype = ctypes.c_int64
        pairs = [*settings_requests(self._values, self.LEGS), (COMMIT, 1)]
        flat = [word for pair in pairs for word in pair]
        words = (ctypes.c_uint32 * len(flat))(*flat)
        restart, magnet_start = (WORDS[name].at() for name in ("restart", "magnet_start"))
        return new(words, len(pairs), restart, magnet_start, inputs)

    @property
    def bus_clock(self) -> int:
        """The clock that comes, for :meth:`ask`; ticks begin at any."""
        return int(self._library.wh_device_clocks(self._model))

    def ask(self, address: int, data: int | None = None, clock: int = 0) -> None:
        """Write ``data``, or read, from ``clock`` on, or as soon as the bus is free."""
        self._library.wh_device_request(self._model, clock, data is not None, address, data or 0)

    def write(self, values: Values, clock: int = 0) -> None:
        """Write words by their names, and give them: from ``clock`` on."""
        for address, raw in [*requests(values, self.LEGS), (COMMIT, 1)]:
            self.ask(address, raw, clock)

    def answers(self) -> list[Answer]:
        """What the bus has answered since it was asked last."""
        room = 4096
        words = (ctypes.c_int64 * (3 * room))()
        count = self._library.wh_device_answers(self._model, words, room)
        return [Answer(*words[3 * n : 3 * n + 3]) for n in range(count)]


class BrushlessDevicePins(DevicePins, BrushlessPinsSimulation):
    """`pins` of a brushless motor as ``rtl/wh_device.v`` with two axes."""

    turns = 0
