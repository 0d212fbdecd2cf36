# SPDX-License-Identifier: Apache-2.0
"""Streams: the device's packets beside the simulation's words, and what a host makes of them."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import threading
import time
import tty

import numpy as np
import pytest
import serial
from pymodbus.client import ModbusSerialClient
from pymodbus.framer import FramerRTU
from test_captured import BOARD, COLUMNS, NAMES, Line, Told
from test_virtual_board import run, start, stop
from wavehaptics.host import stream
from wavehaptics.host.capture import Captured
from wavehaptics.host.captured_trace import Device, trace_arrays
from wavehaptics.host.client import Client
from wavehaptics.host.framed_line import FramedLine, echo, is_right, unstuffed
from wavehaptics.host.names import HostError, places
from wavehaptics.host.stream import PACKET_WORDS, Stream, Wanted
from wavehaptics.ladder.linked_pins import LinkedPins
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.trace.columns import load_trace
from wavehaptics.words import modbus, table
from wavehaptics.words.table import WORDS


def crc(data: bytes) -> bytes:
    return data + FramerRTU.compute_CRC(data).to_bytes(2, "big")


def stuffed(data: bytes) -> bytes:
    """A frame of up to 254 bytes, by the rule and with its zero."""
    assert len(data) < 255
    pieces = data.split(b"\0")
    return b"".join(bytes([len(piece) + 1]) + piece for piece in pieces) + b"\0"


def packet(number: int, rows: list[list[int]]) -> bytes:
    words = [word for row in rows for word in row]
    head = bytes([247 + len(rows[0])]) + number.to_bytes(2, "big")
    return crc(head + np.array(words, dtype=">i2").tobytes())


# ---- The device.


def test_a_stream_is_what_the_simulation_had():
    """Row for row the mean of 32 ticks, cut and limited, each packet in its turn."""
    scene = load_scene(find_scene("press_hold"), BOARD)
    line = Line(LinkedPins(scene, arm=False))
    log2, shifts = 5, (9, 12, 15, 15)
    line.ask(bytes(crc(bytes.fromhex("01 10 000a 0002 04 0000 0003"))), 8)  # 3 Mbit/s
    line.write("stream_channel", *(WORDS[name].at() for name in NAMES), 3, log2)
    line.write("stream_shift", *shifts)
    line.simulation.send(crc(bytes.fromhex("01 10 20ec 0002 04 0000 0001")))
    data = b""
    for _ in range(100):
        line.elapse()
        data += line.simulation.received()
    *found, _ = data.split(b"\0")
    first = unstuffed(found[0])
    assert first == echo(bytes.fromhex("01 10 20ec 0002"))
    packets = [unstuffed(frame) for frame in found[1:]]
    assert len(packets) > 5
    assert all(is_right(each) and each[0] == 251 for each in packets)
    assert [int.from_bytes(each[1:3], "big") for each in packets] == [*range(len(packets))]
    rows = np.concatenate([np.frombuffer(each, ">i2", 60, 3) for each in packets]).reshape(-1, 4)
    words = np.concatenate(line.words)[:, COLUMNS]
    length = len(rows) << log2
    same = []
    for n in range(len(words) - length):
        means = words[n : n + length].reshape(len(rows), -1, 4).sum(axis=1) >> log2
        cut = np.clip(means >> np.array(shifts), -32768, 32767)
        if np.array_equal(cut, rows):
            same.append(n)
    assert len(same) == 1
    assert np.ptp(rows, axis=0).min() > 0


# ---- A host, beside a port that is made up.


class Port:
    """A pseudo-terminal and a thread that answers questions as a device that streams."""

    def __init__(self) -> None:
        self.master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)

    def close(self) -> None:
        for end in (self.master, self._slave) if self.master >= 0 else ():
            os.close(end)
        self.master = -1


@pytest.fixture
def port():
    made = Port()
    yield made
    made.close()


def framed(port: Port, got: list[bytes]) -> FramedLine:
    return FramedLine(serial.Serial(port.path, timeout=1.0), got.append)


def until(true, seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(1e-3)


QUESTION = crc(bytes.fromhex("01 10 20ec 0002 04 0000 0002"))
ANSWER = crc(bytes.fromhex("01 03 04 0000 1234"))


def test_answers_and_packets_are_told_apart(port):
    got: list[bytes] = []
    line = framed(port, got)
    told = packet(7, [[0, -1, 2, 256]] * 15)
    data = stuffed(told) + stuffed(ANSWER) + b"\x05\x01\0" + stuffed(packet(8, [[3]] * 60))
    broken = bytearray(stuffed(packet(9, [[1]] * 60)))
    broken[20] ^= 4
    data += bytes(broken)
    for n in range(0, len(data), 11):
        os.write(port.master, data[n : n + 11])
        time.sleep(1e-3)
    until(lambda: line.broken == 2)
    assert [each[:3] for each in got] == [b"\xfb\0\7", b"\xf8\0\x08"]
    assert line.in_waiting == len(ANSWER)
    assert (line.read(4), line.read(99), line.in_waiting) == (ANSWER[:4], ANSWER[4:], 0)

    def answer() -> None:
        """The echo of the question that ends the frames, not before it was asked."""
        found = b""
        while len(found) < len(QUESTION):
            found += os.read(port.master, 100)
        os.write(port.master, echo(QUESTION))

    board = threading.Thread(target=answer, daemon=True)
    board.start()
    assert line.end(QUESTION, 20.0)
    board.join(20.0)


def test_credit_is_renewed_by_itself(port):
    """While nobody asks; its answers aren't anybody's; without credit it says so."""
    line = framed(port, [])
    line.renew(QUESTION, 0.02)
    for _ in range(3):
        found = b""
        while len(found) < len(QUESTION):
            found += os.read(port.master, 100)
        assert found == QUESTION
        os.write(port.master, stuffed(echo(QUESTION)))
    time.sleep(0.05)
    assert line.in_waiting == 0
    plain = echo(QUESTION)
    os.write(port.master, plain[:5])
    time.sleep(0.05)
    assert not line.lapsed
    os.write(port.master, plain[5:])
    until(lambda: line.lapsed)
    assert not line.end(QUESTION, 0.1) or line.lapsed


def test_a_port_that_is_pulled(port):
    """While nothing is asked; then nobody waits for an answer."""
    line = framed(port, [])
    line.renew(QUESTION, 10.0)
    port.close()
    until(lambda: line.error is not None)
    with pytest.raises(OSError, match=r"Input/output error|returned no data"):
        _ = line.in_waiting
    began = time.monotonic()
    assert not line.end(QUESTION, 20.0)
    assert time.monotonic() - began < 15.0


def test_a_port_that_is_pulled_meanwhile(port):
    """Between the question that ends the frames and its answer."""
    line = framed(port, [])
    puller = threading.Timer(0.3, port.close)
    puller.start()
    began = time.monotonic()
    ended = line.end(QUESTION, 20.0)
    puller.join()
    assert not ended
    assert time.monotonic() - began < 15.0
    assert line.error is not None


class Streams(Told):
    """A device whose stream is a list of packets."""

    def __init__(self, packets: list[bytes], **words: int) -> None:
        super().__init__(stream_state=1, **words)
        self._baud = modbus.BAUDS[3]
        self.packets = packets

    @contextlib.contextmanager
    def streaming(self, take):
        for each in self.packets:
            take(each)
        line = FramedLine.__new__(FramedLine)
        line.lapsed, line.error, line.broken = False, None, 1
        yield line


def taken(packets: list[bytes], *names: str, **words: int) -> stream.Streamed:
    with Stream(Streams(packets, **words), names) as live:
        pass
    return live.found()


def test_lost_packets_are_rows_without_numbers():
    """Counted, in their places, through a wrap of the numbers."""
    numbers = [0, 1, 4, 65_535, 0, 2]
    packets = [packet(number, [[number % 99, 0x11]] * 30) for number in numbers]
    found = taken(packets, "current", "flags", stream_lost=2)
    assert len(found.t) == (65_536 + 3) * 30
    assert found.lost_packets == 65_536 + 3 - 6
    assert (found.left_out, found.broken) == (2, 1)
    assert found.lost.sum() == found.lost_packets * 30
    assert np.isnan(found["current"][found.lost]).all()
    assert not np.isnan(found["current"][~found.lost]).any()
    # A raw word of 16 bits stands for the middle of what it was cut from.
    step = WORDS["current"].fixed.step
    assert found["current"][4 * 30] == (4 * 2**15 + 16_383.5) * step
    assert found["current"][65_538 * 30] == (2 * 2**15 + 16_383.5) * step
    assert (found["flags"][found.lost] == 0).all()
    arrays = trace_arrays(found, Device())
    assert arrays["lost"].sum() == found.lost.sum()
    assert arrays["contact"].sum() == 6 * 30


def test_positions_go_on_beyond_16_bits():
    """From where a read of the whole word has it, over every wrap, through gaps."""
    counts = 70_000 + np.cumsum(np.full(240, -2500))
    rows = [[int(np.int16(count & 0xFFFF if count % 65536 < 32768 else count % 65536 - 65536))]
            for count in counts]  # fmt: skip
    packets = [packet(n, rows[60 * n : 60 * n + 60]) for n in range(4)]
    found = taken(packets, "position", position=67_000)
    np.testing.assert_array_equal(found["position"], counts)
    negative = taken(packets[:1], "position", position=(1 << 32) - 65_536 * 3 + 67_000 % 65536)
    np.testing.assert_array_equal(np.diff(negative["position"]), -2500)
    assert negative["position"][0] == -3 * 65_536 + 67_500 - 65_536 + 65_536 * (67_000 < 65_536)


def test_a_stream_that_lasts_is_taken_in_parts():
    """Together they are what one call gives: times, positions, packets lost between two parts."""
    numbers = [0, 1, 3, 4, 8]
    packets = [packet(number, [[(4000 * number + n) % 30_000, 7] for n in range(30)])
               for number in numbers]  # fmt: skip
    whole = taken(packets, "position", "current", position=(1 << 32) - 2)
    live = Stream(Streams([], position=(1 << 32) - 2), ("position", "current"))
    parts = []
    with live:
        for several in (packets[:2], packets[2:3], [], packets[3:]):
            for each in several:
                live._take(each)
            parts.append(live.fresh())
            assert live._packets == []
    assert [part.lost_packets for part in parts] == [0, 1, 0, 3]
    assert live.lost == whole.lost_packets == 4
    assert live.seconds == pytest.approx(len(whole.t) * whole.plan.row_s)
    for values in (lambda found: found.t, lambda found: found.lost,
                   lambda found: found["position"], lambda found: found["current"]):  # fmt: skip
        np.testing.assert_array_equal(np.concatenate([values(part) for part in parts]),
                                      values(whole))  # fmt: skip
    assert len(live.found().t) == 0


def test_words_at_their_ends_are_told():
    rows = [[0x7FFF, -0x8000]] * 2 + [[5, 6]] * 28
    found = taken([packet(0, rows)], "current:4", "u")
    assert found.at_end == {"current": 2, "u": 2}
    assert isinstance(found, Captured)
    assert found["current"][2] == (5 * 2**11 + 1023.5) * WORDS["current"].fixed.step


@pytest.mark.parametrize(
    ("names", "options", "message"),
    [
        ([], {}, "0 words: a stream takes 1 to 4"),
        (["u", "v", "current", "flags", "bus"], {}, "5 words: a stream takes 1 to 4"),
        (["root"], {}, "root: can't be streamed; take voltage"),
        (["u", "u:4"], {}, "a word is there twice"),
        (["flags:4"], {}, "flags:4: flags has no range; leave :4 out"),
        (["u:x"], {}, "u:x: write u:RANGE, a number above 0 in"),
        (["u:-1"], {}, "u:-1: write u:RANGE"),
        (["u:0"], {}, "u:0: write u:RANGE"),
        (["u:nan"], {}, "u:nan: write u:RANGE"),
        (["u"], {"decimation": 3}, "decimation 3: take 1, 2, 4"),
        (["u", "v"], {"decimation": 8}, r"decimation 8: 125000 rows of 2 words a second, and "
         r"3000000 bits a second carry 6\d{4}; take 16 or more"),
        (["u@5"], {}, "no motor 5"),
    ],
)  # fmt: skip
def test_streams_that_are_refused(names, options, message):
    with pytest.raises(HostError, match=message) as error:
        stream.plan(Streams([]), names, **options)
    assert "\n" not in str(error.value)


def test_a_device_without_a_stream():
    with pytest.raises(HostError, match="the device has no stream"):
        stream.plan(Told(), ["u"])


def test_the_line_sets_the_decimation():
    """Four words come at more than 30 kHz with ticks of a microsecond."""
    wanted = stream.plan(Streams([]), ["u", "v", "current", "position"])
    assert isinstance(wanted, Wanted)
    assert wanted.rows.decimation == 32
    assert 1 / wanted.rows.row_s == pytest.approx(31_250)
    assert wanted.shifts == (15, 15, 15, 0)
    slow = Streams([])
    slow._baud = modbus.BAUDS[0]
    assert stream.plan(slow, ["u", "v", "current", "position"]).rows.decimation == 1024
    for most_hz, ticks in ((1e3, 1024), (2e5, 32)):
        fewer = stream.plan(Streams([]), ["u", "v", "current", "position"], most_hz=most_hz)
        assert fewer.rows.decimation == ticks
    one = stream.plan(Streams([]), "bus")
    assert (one.rows.decimation, one.shifts, one.packet_rows) == (8, (1,), PACKET_WORDS)


# ---- On the virtual board.


def test_a_stream_of_the_virtual_board(tmp_path):
    """Words and pictures over the line; settings meanwhile; a host that dies, and one after it."""
    process, path = start()
    try:
        code, told, problems = run(
            path, "stream", "current", "position", "--seconds", "0.004", "--out", str(tmp_path),
            "--counts-per-rev", "10000", "--timeout", "100",
        )  # fmt: skip
        assert code == 0, problems
        assert re.search(r"rows of \d+ µs, \d+ a second", told)
        trace = load_trace(tmp_path)
        assert len(trace["t"]) >= 0.004 * 30_000
        assert not trace["lost"].any()
        assert np.ptp(trace["x"]) > 0
        assert (tmp_path / "stream.png").stat().st_size > 10_000
        client = Client(path, timeout_s=100.0)
        with Stream(client, ["current"]) as live:
            place = places("guard_heat_ticks", client.shape)[0]
            client.write([(place, 77)])
            assert client.read([place]) == [77]
            until(lambda: live.seconds > 0.001, 200.0)
        assert live.found().lost_packets == 0
        assert client.read(places("stream_state", client.shape)) == [stream.REST]
        # Whoever dies renews no more, and a master that knows of no stream reads.
        begin = crc(bytes.fromhex("01 10 20ec 0002 04 0000 0001"))
        with serial.Serial(path, timeout=100.0) as line:
            line.write(begin)
            assert line.read(1000).count(0) > 3
        with serial.Serial(path, timeout=5.0) as line:
            while line.read(4096):
                pass
        master = ModbusSerialClient(path, baudrate=115200, timeout=100.0, retries=0)
        assert master.connect()
        answer = master.read_holding_registers(0, count=2, device_id=1)
        master.close()
        assert answer.registers[0] << 16 | answer.registers[1] == table.crc()
    finally:
        assert stop(process) == 0
