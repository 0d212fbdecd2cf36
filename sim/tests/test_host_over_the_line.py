# SPDX-License-Identifier: Apache-2.0
"""A host's packets as plain Modbus frames: what the RTL makes of them, clock by clock."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU
from pymodbus.pdu.register_message import ReadHoldingRegistersRequest, WriteMultipleRegistersRequest
from wavehaptics.ladder.linked_motors import LinkedMotors
from wavehaptics.ladder.linked_pins import LinkedPins
from wavehaptics.scene import SceneError, find_scene, load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats, modbus
from wavehaptics.words.table import WORDS

WAVE = formats.WAVE
PACKET = ("host_packet_sequence", "host_v", "host_active")
ANSWER = ("host_answer_sequence", "host_u", "host_answer")
MOST_TICKS = 4000


def scene_of(*settings: str):
    return load_scene(find_scene("hosted_wall"), ("hand.path=sine", *settings))


class Line:
    """A device of a scene with its bridges on, asked frame by frame; ``words`` are the ticks'.

    Of several motors there are no words.
    """

    def __init__(self, *settings: str, motors: int = 1) -> None:
        scene = scene_of(*settings)
        self.pins = LinkedPins(scene) if motors == 1 else LinkedMotors(scene, motors)
        self._kept: list[np.ndarray] = []
        self._first = 0
        self.elapse(64)
        self.write("arm", [1])
        for _ in range(MOST_TICKS):
            if self.pins.running:
                return
            self._first = len(self._kept)
            self.elapse(1)
        raise AssertionError("never armed")

    @property
    def words(self) -> np.ndarray:
        """Words of the ticks since the bridges are on, as (ticks, Word)."""
        return np.concatenate(self._kept[self._first :])

    def elapse(self, ticks: int) -> None:
        words = np.zeros((ticks, len(Word)), dtype=np.int64)
        if self.pins.motors > 1:
            self.pins.elapse(ticks)
        else:
            self.pins.advance(np.zeros((ticks, len(Column))), words)
        self._kept.append(words)

    def _ask(self, request, length: int) -> bytes:
        self.pins.send(FramerRTU(DecodePDU(False)).buildFrame(request))
        answer = b""
        for _ in range(MOST_TICKS):
            self.elapse(1)
            answer += self.pins.received()
            if len(answer) >= length:
                assert not answer[1] & 0x80, answer.hex()
                return answer
        raise AssertionError("no answer")

    def read(self, first: str, count: int, later: int = 0, motor: int = 0) -> list[int]:
        """Words from ``first`` on; ``later`` frames to another unit go before, so that the frame
        comes at other clocks of a tick."""
        register = modbus.word_register(WORDS[first].at(motor))
        other = ReadHoldingRegistersRequest(address=0, count=2, dev_id=2)
        for _ in range(later):
            self.pins.send(FramerRTU(DecodePDU(False)).buildFrame(other))
        request = ReadHoldingRegistersRequest(address=register, count=2 * count, dev_id=1)
        answer = self._ask(request, 5 + 4 * count)
        return list(struct.unpack(f">{count}i", answer[3:-2]))

    def write(self, first: str, raws: list[int], motor: int = 0) -> None:
        register = modbus.word_register(WORDS[first].at(motor))
        request = WriteMultipleRegistersRequest(
            address=register, registers=modbus.halves(raws), dev_id=1
        )
        self._ask(request, 8)


def test_words_of_a_packet_and_of_an_answer_stand_side_by_side():
    for names in (PACKET, ANSWER):
        first = WORDS[names[0]].at()
        assert [WORDS[name].at() for name in names] == [first, first + 1, first + 2]


def test_a_packets_number_and_its_mean_are_of_one_packet():
    """A period of one tick, so short that each frame's words are read while packets pass.

    The mean of each number is that of the trace: of the tick, the number-th since the bridges are
    on, as the ticks of 200 clocks are each a period.
    """
    line = Line("host.rate_hz=32e3")
    found = []
    for n in range(180):
        found.append(line.read(PACKET[0], 2, n % 9))
        if n % 20 == 0:
            line.write("arm", [2])
    waves = line.words[:, Word.V]
    assert np.unique(waves).size > 200
    # A step is a tick: the number counts them, modulo 256, and the newest one is near the end.
    by_number = {}
    torn = 0
    for n, (sequence, v) in enumerate(found):
        ticks = np.flatnonzero(waves == v)
        by_number.setdefault(sequence, set()).update(ticks.tolist())
        torn += not any((tick + 1 - sequence) % 256 == 0 for tick in ticks)
        assert ticks.size, (n, sequence, v)
    assert torn == 0
    assert len(by_number) > 90


def test_an_answer_of_one_frame_is_taken_whole():
    """Its own u, and not that of the frame before."""
    line = Line("host.rate_hz=500")
    # The budget fills while the answers are 0.
    sequence, _, active = line.read(PACKET[0], 3)
    line.write(ANSWER[0], [sequence, 0, 1])
    line.elapse(10 * 64)
    line.write("arm", [2])
    sequence, _, active = line.read(PACKET[0], 3)
    assert active
    u = WAVE.to_raw(0.02)
    line.write(ANSWER[0], [sequence, u, 1])
    line.elapse(3 * 64)
    # a = 0.99: a few ticks after a period begins the core's u is the goal, but for its last places.
    assert np.abs(line.words[-8:, Word.U] - u).max() < 0.01 * u


def test_each_of_several_motors_has_a_host():
    """Packets are whole, whenever they are read; who answers for one motor has that one alone."""
    line = Line("host.rate_hz=2e3", motors=2)
    line.pins.lead_hand(1.0)  # of motor 0; the other's goes on as the scene has it
    found = []
    for n in range(120):
        if n % 20 == 0:
            line.write("arm", [2])
        found.append([line.read(PACKET[0], 3, n % 3, motor) for motor in range(2)])
    for motor in range(2):
        packets = [tuple(each[motor]) for each in found]
        assert not any(active for _, _, active in packets)
        changes = [n for n in range(1, len(packets)) if packets[n] != packets[n - 1]]
        assert len(changes) > 40
        assert all(packets[n][0] != packets[n - 1][0] for n in changes)
    assert sum(first[1] != second[1] for first, second in found) > 40
    line.write("arm", [2])
    sequence, _, _ = line.read(PACKET[0], 3, motor=1)
    line.write(ANSWER[0], [sequence, 0, 1], motor=1)
    line.elapse(4)
    assert [line.read(PACKET[0], 3, motor=motor)[2] for motor in range(2)] == [0, 1]


def test_a_scene_without_a_host_has_none():
    scene = load_scene(find_scene("live_wall"))
    pins = LinkedPins(scene)
    register = modbus.word_register(WORDS["host_packet_sequence"].at())
    request = ReadHoldingRegistersRequest(address=register, count=6, dev_id=1)
    pins.send(FramerRTU(DecodePDU(False)).buildFrame(request))
    pins.elapse(400)
    assert pins.received()[3:-2] == bytes(12)


@pytest.mark.parametrize(
    "settings",
    [
        ("host.rate_hz=1e5",),
        ("host.rate_hz=1", "controller.tick_hz=128e3"),
        ("host.rate_hz=32e3", "controller.clock_hz=3.2e6"),
    ],
)
def test_periods_that_the_link_has_not_are_refused(settings):
    with pytest.raises(SceneError, match=r"host.rate_hz = .*: a period is .* Hz here"):
        LinkedPins(scene_of(*settings))
