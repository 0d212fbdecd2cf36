# SPDX-License-Identifier: Apache-2.0
"""`pins` with the guard in the RTL, and hands on its inputs."""

from __future__ import annotations

import ctypes
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from wavehaptics.controller.bus_scale import bus_word
from wavehaptics.controller.guard import WIDTH, Limits, settings
from wavehaptics.controller.ports import controller_ports
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.scene import Scene
from wavehaptics.trace.columns import Column, Word

Injection = IntEnum(
    "Injection",
    "STOP DRIVER BUS TRIP ANCHOR HOST_SILENT ADC_REPEATS ADC_LEVEL ENCODER_FLIPS ENCODER_HOLDS "
    "ROOT_WORD SCLK_HALF ENABLE CLEAR OUTSIDE ENCODER_GLITCHES ADC_FLIP RESET",
    start=0,
)
"""What can be done to the controller's inputs, in the order of guarded_pins_shim.cpp; CLEAR and
RESET last as many clocks as their value."""


class Report(NamedTuple):
    """Clocks of the newest cause and of the gates' going off for a fault, −1 for not yet; state,
    clocks so far, those with a gate on since the cause, and what the contact, or the last one,
    delivered to the shaft and the most that it was, as raw words."""

    cause: int
    off: int
    faults: int
    running: bool
    clocks: int
    on: int
    energy: int
    peak: int


class GuardedPins(PinsSimulation):
    """`pins` with the guard in the RTL, and hands on its inputs."""

    PREFIX = "wh_guarded"
    SHIM = "guarded_pins_shim.cpp"

    def __init__(self, scene: Scene, limits: Limits, bus_v: float = 12.0) -> None:
        self._limits, self._bus_v = limits, bus_v
        super().__init__(scene)
        self._tick_clocks = controller_ports(scene).timing.tick_clocks

    def _parameters(self) -> dict[str, int]:
        return {"GUARD": 1}

    def _new_model(self, words: ctypes.Array[ctypes.c_uint32], inputs: int) -> int | None:
        unity = self.timing.frame.unity
        word = settings(self._limits, self.tick_s, self.sensor, self.settings.s, unity)
        count = (WIDTH + 31) // 32
        guard = (ctypes.c_uint32 * count)(*(word >> 32 * n & 0xFFFFFFFF for n in range(count)))
        new = self._library.wh_guarded_new
        words_type = ctypes.POINTER(ctypes.c_uint32)
        new.argtypes = [words_type, ctypes.c_int64, words_type, *[ctypes.c_int64] * 3]
        new.restype = ctypes.c_void_p
        self._library.wh_guarded_inject.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64]
        self._library.wh_guarded_report.argtypes = [
            ctypes.c_void_p, ctypes.POINTER(ctypes.c_int64)
        ]  # fmt: skip
        levels = self._limits.stop_level | self._limits.driver_level << 1
        model: int | None = new(words, inputs, guard, count, levels, bus_word(self._bus_v))
        return model

    def inject(self, kind: Injection, value: int = 1) -> None:
        """Do something to the inputs from the next clock on, and keep its clock as the cause's."""
        self._library.wh_guarded_inject(self._model, kind, value)

    def report(self) -> Report:
        """What came of it."""
        words = (ctypes.c_int64 * 8)()
        self._library.wh_guarded_report(self._model, words)
        return Report(words[0], words[1], words[2], bool(words[3]), *words[4:])

    @property
    def motor(self) -> np.ndarray:
        """The motor's state (:mod:`wavehaptics.motor.plant`), to be changed between two ticks."""
        return self._state

    @property
    def sensor_words(self) -> np.ndarray:
        """The sensor's constants (:mod:`wavehaptics.motor.sensor`), likewise."""
        return self._sensor

    def elapse(self, ticks: int) -> None:
        """Let as much time pass, whether the core is running or not."""
        end = self.report().clocks + ticks * self._tick_clocks
        while self.report().clocks < end:
            self.run(min(ticks, 100))

    def run(self, ticks: int) -> bool:
        """Simulate ``ticks``; False if the core fell silent, as it does with the gates off."""
        rows = np.zeros((ticks, len(Column)))
        words = np.zeros((ticks, len(Word)), dtype=np.int64)
        try:
            self.advance(rows, words)
        except RuntimeError:
            return False
        return True
