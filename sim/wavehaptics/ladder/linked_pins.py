# SPDX-License-Identifier: Apache-2.0
"""`pins` with a serial line: ``rtl/wh_linked_device.v``, whose settings come over it as frames."""

from __future__ import annotations

import ctypes

import numpy as np
from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU
from pymodbus.pdu.register_message import WriteMultipleRegistersRequest

from wavehaptics.ladder import pins_loop, verilated
from wavehaptics.ladder.brushless_pins import BrushlessPinsSimulation
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.motor.plant import RAMP_END, C, P, R, S
from wavehaptics.scene import Scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats
from wavehaptics.words.memory import settings_requests
from wavehaptics.words.modbus import IDENTIFICATION, MOST_WRITTEN, halves, runs, word_register
from wavehaptics.words.table import WORDS

UNIT = 1
ANSWER_BYTES = 8
"""Of a write: unit, function, register, number, CRC."""

_RATES_HZ = (6e6, 9e6, 18e6)
"""Least clock of rates 1, 2 and 3, as ``rtl/wh_link.v`` has it."""

CAPTURE = 12
"""Words of the capture's memory, 2^this."""

ZERO_PART = 1 / 16
"""Largest zero that is permitted, of the ADC's full scale."""


def write_frame(first: int, raws: list[int]) -> bytes:
    """The question that writes words from an address of the table on."""
    return _write(word_register(first), halves(raws))


def _rate_frame(rate: int) -> bytes:
    return _write(2 * IDENTIFICATION.index("rate"), [0, rate])


def _write(register: int, registers: list[int]) -> bytes:
    request = WriteMultipleRegistersRequest(address=register, registers=registers, dev_id=UNIT)
    return FramerRTU(DecodePDU(False)).buildFrame(request)


class LinkedPins(PinsSimulation):
    """``rtl/wh_linked_device.v`` with a scene's settings, motor and hand.

    A scene with a ``[host]`` has HOST = 1. With ``arm`` the bridges stay off until the line arms
    them, as the board has it; without, they are on, as those of
    :class:`~wavehaptics.ladder.device_pins.DevicePins`. enable_i is high.
    """

    TOP = "wh_linked_device"
    SHIM = "linked_shim.cpp"
    SHOWS: tuple[str, ...] = ("device_shim.vlt", "linked_shim.vlt", "ports_steps.vlt")
    PREFIX = "wh_linked"
    motors = turns = 1

    def __init__(self, scene: Scene, *, arm: bool = True) -> None:
        self._arm = arm
        self._own = 0
        super().__init__(scene, host=scene.host is not None)

    def _parameters(self) -> dict[str, int]:
        clock_hz = round(self.timing.clock_hz)
        return {
            "ARM": int(self._arm), "CLOCK_HZ": clock_hz, "CAPTURE": CAPTURE, "STREAM": 1,
        }  # fmt: skip

    def _port_words(self, design: verilated.Design) -> ctypes.Array[ctypes.c_uint32]:
        return (ctypes.c_uint32 * 0)()  # it has none: settings come by the line

    def _new_model(self, words: ctypes.Array[ctypes.c_uint32], inputs: int) -> int | None:
        self._declare()
        inputs = sum(inputs << pins_loop.MOTOR_INPUTS * n for n in range(self.motors))
        model: int = self._library.wh_linked_new(inputs, self.timing.tick_clocks)
        gain = self._values["gain"]
        assert isinstance(gain, int)
        largest = WORDS["zero_limit"].fixed.raw_max
        zero_a = self.sensor.full_scale_a * ZERO_PART
        zero_limit = min(round(zero_a / formats.GAIN.to_value(gain)), largest)
        values = {**self._values, "zero_limit": zero_limit}
        # At the fastest rate that the clock has; that of a reset comes back at the end.
        fastest = sum(self.timing.clock_hz >= least for least in _RATES_HZ)
        self._tell(model, _rate_frame(fastest))
        for motor in range(self.motors):
            for first, raws in runs(settings_requests(values, self.LEGS, motor), MOST_WRITTEN):
                self._tell(model, write_frame(first, raws))
        self._tell(model, _rate_frame(0))
        if not self.turns:
            self._tell(model, write_frame(WORDS["magnet_start"].at(), [1]))
        self._library.wh_linked_bus(model, self._values["bus"])
        frame = write_frame(WORDS["restart"].at(), [1])
        if not self._library.wh_linked_begin(model, frame, len(frame)):
            return None
        # Its answer is still under way, and nobody's who comes to the line.
        self._own = ANSWER_BYTES
        if "guard_mask" in self._values:
            # It has watched an ADC that nobody had set up.
            frame = write_frame(WORDS["clear"].at(), [1])
            self._library.wh_linked_send(model, frame, len(frame))
            self._own += ANSWER_BYTES
        return model

    def _tell(self, model: int, frame: bytes) -> None:
        self._library.wh_linked_send(model, frame, len(frame))
        if not self._library.wh_linked_await(model, ANSWER_BYTES - 3):
            raise RuntimeError("the device's RTL doesn't answer")
        self._library.wh_linked_await(model, ANSWER_BYTES)
        answer = self._take(model)
        if answer[1] & 0x80:
            raise RuntimeError(f"the device's RTL refuses {frame.hex()}: {answer.hex()}")

    def _declare(self) -> None:
        library, model, count = self._library, ctypes.c_void_p, ctypes.c_int64
        text = ctypes.c_char_p
        for name, arguments in (
            ("new", [count, count]),
            ("send", [model, text, count]),
            ("waiting", [model]),
            ("received", [model, text, count]),
            ("await", [model, count]),
            ("begin", [model, text, count]),
            ("running", [model]),
            ("bus", [model, count]),
        ):
            function = getattr(library, f"wh_linked_{name}")
            function.argtypes = arguments
            function.restype = model if name == "new" else count

    def _take(self, model: int) -> bytes:
        room = 4096
        buffer = ctypes.create_string_buffer(room)
        count = self._library.wh_linked_received(model, buffer, room)
        return buffer.raw[:count]

    def send(self, data: bytes) -> None:
        """Put bytes before the line, which sends them at the device's rate, one after another."""
        self._library.wh_linked_send(self._model, data, len(data))

    @property
    def waiting(self) -> int:
        """Bytes that are still before the line."""
        return int(self._library.wh_linked_waiting(self._model))

    def received(self) -> bytes:
        """Bytes that came since the last time, 4096 at most; none of the answer to the start."""
        data = self._take(self._model or 0)
        own, self._own = min(self._own, len(data)), max(0, self._own - len(data))
        return data[own:]

    @property
    def running(self) -> bool:
        """Whether the bridges are on."""
        return bool(self._library.wh_linked_running(self._model))

    @property
    def time_s(self) -> float:
        """Simulated time since the motor was let go, s."""
        return self.clock_cycles / self.timing.clock_hz

    @property
    def hand_rad(self) -> float:
        """Where the hand is, rad."""
        return float(self._state[P] + self._state[C])

    def lead_hand(self, *speed: float) -> None:
        """From now on the hand goes at this speed in rad/s, and its path is forgotten."""
        state, (speed_rad_s,) = self._state, speed
        state[P] += state[C]
        state[C] = state[S] = 0.0
        state[R] = speed_rad_s
        self._load[RAMP_END] = np.inf

    def elapse(self, ticks: int) -> None:
        """Let ticks of the scene pass, with the bridges on or off. Nothing is kept of them."""
        rows = np.zeros((ticks, len(Column)))
        self.advance(rows, np.zeros((ticks, len(Word)), dtype=np.int64))
        if not self.running:
            # What stood in for steps may not have been one a tick.
            self._kept[pins_loop.EMITTED] = self._kept[pins_loop.CLOSED]


class LinkedBrushlessPins(LinkedPins, BrushlessPinsSimulation):
    """``wh_linked_device`` with two axes, and a scene's brushless motor. It knows no host."""

    turns = 0

    def __init__(self, scene: Scene, *, arm: bool = True) -> None:
        if scene.host is not None:
            raise scene.refusal("[host] is not for a brushless motor yet; leave it out", "host")
        super().__init__(scene, arm=arm)

    def _parameters(self) -> dict[str, int]:
        return {**super()._parameters(), **BrushlessPinsSimulation._parameters(self)}


def linked_pins(scene: Scene, *, arm: bool = True) -> LinkedPins:
    """The device with the scene's motor, of either kind."""
    kind = LinkedBrushlessPins if scene.motor.brushless else LinkedPins
    return kind(scene, arm=arm)
