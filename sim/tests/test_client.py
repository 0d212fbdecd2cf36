# SPDX-License-Identifier: Apache-2.0
"""The client on a line whose answers are late, lost, of somebody else, or of another question."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import select
import socket
import struct
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import serial
from pymodbus.framer import FramerRTU
from wavehaptics.host import client as client_module
from wavehaptics.host.client import Client
from wavehaptics.host.names import HostError, Place, places
from wavehaptics.words import modbus, table

TIMEOUT_S = 0.15


def sealed(frame: bytes) -> bytes:
    return frame + FramerRTU.compute_CRC(frame).to_bytes(2, "big")


class Board(threading.Thread):
    """A board on a pseudo-terminal: registers, answered one question after another.

    ``late`` are delays of the next answers, s; ``instead`` what comes in the place of the next
    ones, None for nothing. The plug is pulled by :meth:`gone`, or by the first question that
    ``pulled_by`` is true of, in place of its answer.
    """

    IDLE_S = 1.0
    """From one call of :meth:`idle` to the next, while nobody asks."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self._master, self._slave = os.openpty()
        self._waker, self._woken = os.pipe()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        self.pulled_by: Callable[[bytes], bool] = lambda frame: False
        self.pulled = False
        self.registers: dict[int, int] = {}
        self.late: list[float] = []
        self.instead: list[bytes | None] = []
        self.asked: list[bytes] = []
        words = dict.fromkeys(modbus.IDENTIFICATION, 0) | {
            "table": table.crc(), "options": 1 | 4 << 4, "clock_hz": 48_000_000, "motors": 1,
            "version": modbus.MAP_VERSION, "rates": 4,
        }  # fmt: skip
        self.put(0, list(words.values()))

    def put(self, register: int, raws: list[int]) -> None:
        self.registers |= enumerate(modbus.halves(raws), register)

    def run(self) -> None:
        found = b""
        while not self.pulled:
            ready, _, _ = select.select([self._master, self._waker], [], [], self.IDLE_S)
            if self._waker in ready:
                break
            if self._master in ready:
                found += os.read(self._master, 4096)
            self.idle()
            while len(found) >= 8 and not self.pulled:
                length = 9 + found[6] if found[1] == 16 else 8
                if len(found) < length:
                    break
                frame, found = found[:length], found[length:]
                if self.pulled_by(frame):
                    self.pulled = True
                else:
                    self._answer(frame)
        # A read that another thread waits in would keep the pseudo-terminal open.
        os.close(self._slave)
        os.close(self._master)

    def idle(self) -> None:
        """What the board does by itself."""

    def _answer(self, frame: bytes) -> None:
        self.asked.append(frame)
        unit, function, register, count = struct.unpack(">BBHH", frame[:6])
        if function == 3:
            data = [self.registers.get(register + n, 0) for n in range(count)]
            body = struct.pack(f">BBB{count}H", unit, 3, 2 * count, *data)
        else:
            values = struct.unpack(f">{count}H", frame[7:-2])
            self.registers |= enumerate(values, register)
            body = frame[:6]
        time.sleep(self.late.pop(0) if self.late else 0.0)
        answer = self.instead.pop(0) if self.instead else sealed(body)
        if answer:
            self.send(answer)

    def send(self, data: bytes) -> None:
        os.write(self._master, data)

    def gone(self) -> None:
        """Pull the plug: both ends of the pseudo-terminal are closed."""
        self.pulled = True
        os.write(self._woken, b"x")
        self.join()

    def close(self) -> None:
        if self.is_alive():
            self.gone()
        os.close(self._waker)
        os.close(self._woken)


@pytest.fixture
def board() -> Iterator[Board]:
    found = Board()
    found.start()
    yield found
    found.close()


@pytest.fixture
def client(board: Board) -> Client:
    return Client(board.path, timeout_s=TIMEOUT_S)


def place(client: Client, name: str) -> Place:
    return places(name, client.shape)[0]


def there(board: Board, client: Client, **raws: int) -> None:
    for name, raw in raws.items():
        board.put(modbus.word_register(place(client, name).address), [raw])


@pytest.mark.parametrize("late", [1.5, 2.5])
def test_late_answers_are_nobody_elses(board, client, late):
    """However late an answer is, later questions get theirs, or none."""
    there(board, client, root=11, a=22, u_max=33)
    board.late = [late * TIMEOUT_S]
    found, wanted = [], [("root", [11]), ("a", [22]), ("u_max", [33])] * 3
    for name, raws in wanted:
        with contextlib.suppress(HostError):
            found.append(client.read([place(client, name)]) == raws)
    assert all(found)
    assert len(found) >= len(wanted) - 1


def test_a_write_is_acknowledged_by_its_own_answer(board, client):
    """The answer to another write isn't one, nor is that to a read."""
    root, a = place(client, "root"), place(client, "a")
    echo = struct.pack(">BBHH", 1, 16, modbus.word_register(root.address), 2)
    for wrong in (sealed(echo), sealed(b"\1\3\4\0\0\0\1"), sealed(b"\1\x83\2")):
        before = len(board.asked)
        board.instead = [wrong]
        client.write([(a, 5)])
        writes = [frame for frame in board.asked[before:] if frame[1] == 16]
        assert len(writes) == 2


@pytest.mark.parametrize(
    "wrong",
    [b"\1\3\0", b"\1\3\2\0\1", b"\1\3\6\0\0\0\1\0\2", b"\1\3\3\0\1\2", b"\1\x90\2",
     struct.pack(">BBHH", 1, 16, 0x2000, 2)],
)  # fmt: skip
def test_an_answer_that_doesnt_fit(board, client, wrong):
    """Of another number of registers or another function: it is asked again."""
    there(board, client, root=7)
    board.instead = [sealed(wrong)]
    assert client.read([place(client, "root")]) == [7]


def test_a_lost_answer_is_asked_for_again(board, client):
    there(board, client, root=7, a=8)
    board.instead = [None]
    assert client.read([place(client, "root")]) == [7]
    board.instead = [None] * 3
    with pytest.raises(HostError, match="no answer within"):
        client.read([place(client, "root")])
    board.instead = [None] * 3
    with pytest.raises(HostError, match="no answer within"):
        client.write([(place(client, "root"), 5)])
    assert board.registers[modbus.word_register(place(client, "root").address) + 1] == 5
    board.instead = []
    assert client.read([place(client, "a")]) == [8]


def test_an_exchange_that_is_broken_off(board, client, monkeypatch):
    """By Ctrl-C, and its answer comes later."""
    there(board, client, root=7, a=8)

    def broken(*_: object) -> None:
        raise KeyboardInterrupt

    board.late = [0.1]
    with monkeypatch.context() as patched:
        patched.setattr("pymodbus.client.ModbusSerialClient.recv", broken)
        with pytest.raises(KeyboardInterrupt):
            client.read([place(client, "root")])
    assert client.read([place(client, "a")]) == [8]


def test_a_refusal_is_not_asked_again(board, client):
    board.instead = [sealed(b"\1\x90\6")]
    before = len(board.asked)
    with pytest.raises(HostError, match="a: the device refuses with exception 6: not now"):
        client.write([(place(client, "a"), 5)])
    assert len(board.asked) == before + 1


def test_words_by_their_names(board, client):
    """As places are, and what no name means is one line."""
    there(board, client, root=7, a=8, position=0xFFFFFFFF)
    board.put(modbus.word_register(place(client, "wall_min").address), [1, 2, 3, 4])
    assert client.read(["position"]) == [0xFFFFFFFF]
    assert client.read("root") == [7]
    wanted = ["wall_min", place(client, "a"), "wall_min[2]"]
    assert client.read(wanted) == [1, 2, 3, 4, 8, 3]
    client.write([("root", 9), (place(client, "a"), 5)])
    assert client.read(["root", "a"]) == [9, 5]
    for wrong, message in (
        ("rot", "rot: there is no such word; did you mean root"),
        ("arm", "arm can't be read; it is a command"),
        (7, "7: there is no such word"),
    ):
        with pytest.raises(HostError, match=message):
            client.read([wrong])
    for wrong, message in (
        ("wall_min", r"wall_min: which one\? Take wall_min\[0\]...wall_min\[3\]"),
        ("position", "position can't be set"),
    ):
        with pytest.raises(HostError, match=message):
            client.write([(wrong, 1)])


@pytest.mark.parametrize("kind", ["file", "folder", "pipe", "socket", "/dev/null"])
def test_a_port_that_is_none(tmp_path, kind):
    """One line that says so, at once, and no tuple of a library's."""
    path = tmp_path / "a lock"  # a name that a message of the system's could have
    if kind == "file":
        path.write_text("")
    elif kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as door:
            door.bind(str(path))
    else:
        path = Path(kind)
    with pytest.raises(HostError) as error:
        Client(str(path), timeout_s=TIMEOUT_S)
    assert str(error.value) == f"{path}: is no serial port; name the device's with --port"


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (errno.ENOENT, "No such file or directory; is it plugged in? Else name its port with"),
        (errno.EACCES, "Permission denied; let your user into the port's group, which often is"),
        (errno.EBUSY, "somebody else has it; name the port with --port"),
        (errno.EIO, "Input/output error; is it plugged in? Else name its port with --port"),
    ],
)
def test_a_port_that_cant_be_opened(board, monkeypatch, number, message):
    opens = os.open

    def refuse(path, *more, **others):
        if path == board.path:
            raise OSError(number, os.strerror(number), path)
        return opens(path, *more, **others)

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(HostError, match=re.escape(f"{board.path}: can't be opened: {message}")):
        Client(board.path, timeout_s=TIMEOUT_S)


def test_a_port_named_after_a_lock(tmp_path):
    """It isn't taken for one that somebody has, which is waited for."""
    began = time.monotonic()
    with pytest.raises(HostError, match="can't be opened: No such file"):
        Client(str(tmp_path / "clock"), timeout_s=60.0)
    assert time.monotonic() - began < 30.0


def test_a_port_that_goes(board, tmp_path):
    """Where it was there, it is the plug that is asked for; else its name as well."""
    port = tmp_path / "port"
    with pytest.raises(HostError, match=r"port: can't be opened: No such file or directory; is it "
                       r"plugged in\? Else name its port with --port$"):  # fmt: skip
        Client(str(port), timeout_s=TIMEOUT_S)
    port.symlink_to(board.path)
    client = Client(str(port), timeout_s=TIMEOUT_S)
    port.unlink()
    with pytest.raises(HostError, match=r"port: can't be opened: No such file or directory; was "
                       r"it unplugged\?$"):  # fmt: skip
        client.read([place(client, "root")])
    port.symlink_to(board.path)
    assert client.read([place(client, "root")]) == [0]


def test_a_port_that_goes_while_it_is_held(client, board):
    """Each exchange says so, also those that give settings back."""
    found = []
    with client.hurry():
        board.gone()
        for _ in range(3):
            with pytest.raises(HostError) as problem:
                client.read([place(client, "root")])
            found.append(str(problem.value))
    assert all(re.search(r"was it unplugged\?|no answer within", text) for text in found), found


@pytest.mark.parametrize("error", [ValueError("rate"), termios.error(22, "rate"), OSError("rate")])
def test_a_rate_that_the_driver_refuses(board, client, monkeypatch, error):
    """It stays at the first rate, now and later."""
    there(board, client, root=7)
    monkeypatch.setattr(client_module, "_FALLBACK_S", 0.0)
    baudrate, tries = serial.Serial.baudrate, []

    def speak(line: serial.Serial, baud: int) -> None:
        if baud != client_module.BAUD:
            tries.append(baud)
            raise error
        baudrate.fset(line, baud)

    monkeypatch.setattr(serial.Serial, "baudrate", property(baudrate.fget, speak))
    for _ in range(2):
        with client.hurry():
            assert client.read([place(client, "root")]) == [7]
    assert tries == [modbus.BAUDS[3]]
    assert client.read([place(client, "root")]) == [7]


def test_whoever_waits_for_the_port_is_next(board, client):
    """However often another one asks: who renews the arming would come too late."""
    first, second = (Client(board.path, timeout_s=40 * TIMEOUT_S) for _ in range(2))

    def asks(who: Client, name: str) -> threading.Thread:
        thread = threading.Thread(target=who.read, args=([place(who, name)],))
        thread.start()
        time.sleep(0.02)
        return thread

    for _ in range(10):
        with serial.Serial(board.path, exclusive=True):
            waiting = [asks(first, "a"), asks(second, "root")]
        for thread in waiting:
            thread.join()
        order = [struct.unpack(">H", frame[2:4])[0] for frame in board.asked[-2:]]
        assert order == [modbus.word_register(place(client, n).address) for n in ("a", "root")]
