# SPDX-License-Identifier: Apache-2.0
"""A plug that is pulled: what was received is written, and the first error is reported.

The pseudo-terminal is closed, or its board killed, wherever a host may be at it: no later error, of
the clean-up, may take the place of the first.
"""

from __future__ import annotations

import re
import signal
import struct
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from quick_board import QuickBoard
from test_client import Board
from test_identify import COUNTS, REAL
from test_streamed import packet, stuffed
from test_virtual_board import command, start, stop
from wavehaptics.cli import board as commands
from wavehaptics.cli import main
from wavehaptics.cli.shared import CommandError
from wavehaptics.host import capture, session
from wavehaptics.host.client import Client
from wavehaptics.host.identify.driver import Driver
from wavehaptics.host.identify.identification import identify
from wavehaptics.host.identify.steps import Wishes
from wavehaptics.host.names import HostError, Place, places, settings
from wavehaptics.host.port import HostPort
from wavehaptics.host.scope.bench import Known
from wavehaptics.host.scope.feed import Feed
from wavehaptics.host.scope.plug import Plug
from wavehaptics.host.stream import Stream
from wavehaptics.trace.columns import load_trace
from wavehaptics.words import modbus
from wavehaptics.words.table import WORDS

TIMEOUT_S = 1.0
ROWS = 30
"""Of a packet of two words."""
END_S = 60.0


def at(name: str, index: int = 0) -> int:
    """Register of a word of motor 0."""
    return modbus.word_register(WORDS[name].at(0, index))


def registers(frame: bytes) -> range:
    first, count = struct.unpack(">HH", frame[2:6])
    return range(first, first + count)


def reads(name: str, nth: int = 1) -> Callable[[bytes], bool]:
    """Whether a question reads a word, for the n-th time."""
    return _nth(lambda frame: frame[1] == 3 and at(name) in registers(frame), nth)


def writes(name: str, nth: int = 1) -> Callable[[bytes], bool]:
    return _nth(lambda frame: frame[1] == 16 and at(name) in registers(frame), nth)


def _nth(true: Callable[[bytes], bool], nth: int) -> Callable[[bytes], bool]:
    seen = []

    def found(frame: bytes) -> bool:
        if true(frame):
            seen.append(frame)
        return len(seen) == nth

    return found


class Device(Board):
    """A board that has a host's link, live words, a capture of 4096 words and a stream."""

    IDLE_S = 0.005

    def __init__(self) -> None:
        super().__init__()
        options = {"motors": 1, "walls": 4, "delay_log2": 10, "host": 1, "arm": 1,
                   "guard": 1, "capture": 12}  # fmt: skip
        raw = sum(value << modbus.OPTIONS[name][0] for name, value in options.items())
        self.put(2 * modbus.IDENTIFICATION.index("options"), [raw])
        for name, raw in {
            "half_clocks": 24, "tick_halves": 2, "stream_state": 1, "capture_state": capture.DONE,
            "armed": 1, "running": 1, "root": 1 << 23, "host_packet_sequence": 7,
        }.items():  # fmt: skip
            self.put(at(name), [raw])
        self.words = 2
        """Of a row that is streamed."""
        self.sent = 0
        """Packets."""
        self.pulled_after = 0
        """Packets after which the plug is pulled; 0: never."""
        self._streams = False

    def idle(self) -> None:
        if self._streams:
            rows = [[self.sent] * self.words] * (60 // self.words)
            self.send(stuffed(packet(self.sent, rows)))
            self.sent += 1
            if self.sent == self.pulled_after:
                time.sleep(0.1)  # what isn't read by then is gone with the plug
                self.pulled = True

    def _answer(self, frame: bytes) -> None:
        if frame[1] == 16 and at("stream") in registers(frame):
            self._streams = frame[-3] != 0
        if at("capture_data") in registers(frame):
            offset = self.registers.get(at("capture_offset") + 1, 0)
            self.put(at("capture_data"), [*range(offset, offset + 64)])
        super()._answer(frame)

    def send(self, data: bytes) -> None:
        if self._streams and data[0] == 1 and b"\0" in data:  # an answer
            data = stuffed(data)
        super().send(data)


@pytest.fixture
def board() -> Iterator[Device]:
    found = Device()
    found.start()
    yield found
    found.close()


@pytest.fixture
def client(board: Device) -> Client:
    return Client(board.path, timeout_s=TIMEOUT_S)


def unplugged(board: Board, problem: object) -> None:
    """That it is one line with the port and the cure."""
    text = str(problem)
    assert re.fullmatch(rf"{board.path}: [^\n]*; was it unplugged\?[^\n]*", text), text
    assert "Errno" not in text
    assert "(5," not in text


def fails_after(work: Callable[[], None]) -> None:
    """An error that has nothing to do with the port."""
    work()
    raise ZeroDivisionError


# ---- The client.


def test_an_exchange(board, client):
    """It is the plug that is asked for, and no other device's patience."""
    board.pulled_by = reads("root")
    with pytest.raises(HostError) as problem:
        client.read(places("root", client.shape))
    unplugged(board, problem.value)


def test_a_port_that_is_kept(board, client):
    """The exchange's error, though going back to the first rate fails as well."""
    board.pulled_by = reads("root")
    seen = []
    with pytest.raises(HostError) as problem, client.hurry():
        seen += [client.baud, client.read(places("root", client.shape))]
    unplugged(board, problem.value)
    assert client.baud == modbus.BAUDS[0]


def test_a_rate_that_is_tried(board, client):
    """It isn't the driver that refuses the rate."""
    rate = 2 * modbus.IDENTIFICATION.index("rate")
    board.pulled_by = _nth(lambda frame: frame[1] == 16 and rate in registers(frame), 1)
    with pytest.raises(HostError) as problem, client.hurry():
        client.read(places("root", client.shape))
    unplugged(board, problem.value)


def test_an_error_of_ones_own(board, client):
    """No error of the clean-up hides it."""
    with pytest.raises(ZeroDivisionError), client.hurry():
        fails_after(board.gone)
    with pytest.raises(HostError, match="can't be opened"):
        client.read(places("root", client.shape))


def test_a_host_of_a_port(board, client):
    board.pulled_by = writes("host_u", 3)
    port = HostPort(client, 0.02)
    port._sequence, port.next = 7, lambda: SimpleNamespace(v=0.1)
    with pytest.raises(HostError) as problem, client.hurry():
        port.serve(SimpleNamespace(step=lambda v: v), lambda: False)
    unplugged(board, problem.value)


# ---- Streams.


def test_rows_that_came_are_there(board, client):
    """And the end of the context says that more would have come."""
    live = Stream(client, ["current:4", "position"])
    board.pulled_after = 20
    with pytest.raises(HostError) as problem, live:
        time.sleep(2.0)
    unplugged(board, problem.value)
    assert len(live.found().t) == 20 * ROWS
    with pytest.raises(HostError) as problem:
        live.check()
    unplugged(board, problem.value)


def test_a_stream_and_an_error_of_ones_own(board, client):
    live = Stream(client, ["current:4", "position"])
    board.pulled_after = 20
    with pytest.raises(ZeroDivisionError), live:
        fails_after(board.join)
    assert len(live.found().t) == 20 * ROWS


@pytest.mark.parametrize("name", ["stream_channel", "stream", "position", "stream_lost"])
def test_a_stream_that_doesnt_begin_or_end(board, client, name):
    """At any of its exchanges."""
    is_written = name in ("stream_channel", "stream")
    board.pulled_by = writes(name) if is_written else reads(name)
    with pytest.raises(HostError) as problem, Stream(client, ["current:4", "position"]):
        pass
    unplugged(board, problem.value)


def told(*words: str) -> str:
    """The one line of a command that fails, run in this process."""
    with pytest.raises(CommandError) as problem:
        commands.app(["board", *words, "--timeout", str(TIMEOUT_S)], standalone_mode=False)
    return str(problem.value)


@pytest.mark.parametrize("more", [(), ("--seconds", "1000"), ("--arm",)])
def test_a_stream_to_a_file(board, tmp_path, capsys, more):
    board.pulled_after = 50
    names = ("current:4", "position")
    words = ("stream", *names, *more, "--port", board.path, "--out", str(tmp_path))
    unplugged(board, told(*words))
    assert len(load_trace(tmp_path)["t"]) == 50 * ROWS
    assert (tmp_path / "stream.png").stat().st_size > 10_000
    out = capsys.readouterr().out
    assert str(tmp_path / "trace.npz") in out
    assert f"{50 * ROWS} rows of" in out


def test_a_stream_without_a_row(board, tmp_path):
    """Nothing is written, and the error is the first one."""
    board.pulled_by = writes("stream")
    unplugged(board, told("stream", "--port", board.path, "--out", str(tmp_path)))
    assert [*tmp_path.iterdir()] == []


def test_a_stream_that_falls_silent(board, tmp_path, monkeypatch):
    """Without a plug that is pulled it is the same: the rows before are written."""
    monkeypatch.setattr(commands.stream, "STILL_S", 0.5)
    idle = board.idle
    board.idle = lambda: idle() if board.sent < 30 else None
    words = ("stream", "current:4", "position", "--port", board.path, "--out", str(tmp_path))
    assert told(*words).startswith("no packet comes; are there ticks")
    assert len(load_trace(tmp_path)["t"]) == 30 * ROWS


def test_a_killed_board(tmp_path, capsys, monkeypatch):
    """The RTL's process, with SIGKILL: rows, one line and status 2."""
    process, path = start()
    takes = Stream._take

    def take(live: Stream, data: bytes) -> None:
        takes(live, data)
        if live.seconds > 0.001:
            process.kill()

    monkeypatch.setattr(Stream, "_take", take)
    words = ("stream", "current:4", "position", "--port", path, "--timeout", "60")
    monkeypatch.setattr(sys, "argv", ["wavehaptics", "board", *words, "--out", str(tmp_path)])
    try:
        with pytest.raises(SystemExit) as ended:
            main.main()
    finally:
        stop(process, signal.SIGKILL)
    out, err = capsys.readouterr()
    assert ended.value.code == 2
    assert re.fullmatch(rf"wavehaptics: {path}: [^\n]*; was it unplugged\?\n", err), err
    rows = len(load_trace(tmp_path)["t"])
    assert rows > 0
    assert f"\n{rows} rows of" in out


# ---- Captures.


def test_a_capture_that_is_read(board, tmp_path, capsys):
    """Its first rows, in the order of time, with the time from the trigger on."""
    count, first = 1000, 700
    names = ("capture_count", "capture_first", "capture_left")
    for name, raw in zip(names, (count, first, 0), strict=True):
        board.put(at(name), [raw])
    board.pulled_by = reads("capture_data", 9)
    problem = told("capture", "current", "u", "--seconds", "0.001", "--pre", "0.0001",
                   "--port", board.path, "--out", str(tmp_path))  # fmt: skip
    unplugged(board, problem)
    trace = load_trace(tmp_path)
    rows = 8 * modbus.MOST_READ // 2
    assert len(trace["t"]) == rows
    raws = 2 * ((np.arange(rows) + first) % count)
    np.testing.assert_allclose(trace["i"] / WORDS["current"].fixed.step, raws)
    assert trace["t"][100] == 0.0
    assert (tmp_path / "capture.png").stat().st_size > 10_000
    assert f"{rows} of {count} rows of 1 µs; the trigger's is row 100" in capsys.readouterr().out


@pytest.mark.parametrize("pulled_by", [writes("capture"), reads("capture_data")])
def test_a_capture_without_a_row(board, tmp_path, pulled_by):
    board.put(at("capture_count"), [100])
    board.pulled_by = pulled_by
    words = ("capture", "current", "--seconds", "0.0001", "--port", board.path)
    unplugged(board, told(*words, "--out", str(tmp_path)))
    assert [*tmp_path.iterdir()] == []


# ---- Arming.


def test_a_renewal(board):
    board.pulled_by = writes("arm", 4)
    unplugged(board, told("arm", "--port", board.path))


def test_a_disarming(board):
    """Without another error that of the end is the first."""
    board.pulled_by = _nth(lambda f: f[1] == 16 and at("arm") in registers(f) and not f[-3], 1)
    unplugged(board, told("arm", "--seconds", "0.2", "--port", board.path))


def test_what_is_watched(board, capsys):
    board.pulled_by = reads("root", 4)
    words = ("watch", "--csv", "--every", "0", "root", "--port", board.path)
    unplugged(board, told(*words))
    assert len(capsys.readouterr().out.splitlines()) == 4


# ---- Settings.


@pytest.fixture
def saved(board: Device, client: Client, tmp_path: Path) -> Path:
    """A file of settings that the device doesn't have."""
    board.put(at("running"), [0])
    file = tmp_path / "all.toml"
    words = ((p, p.raw(p.range[1]) & 0xFFFFFFFF) for p in settings(client.shape)
             if p.word.name.startswith(("wall", "eta", "root")))  # fmt: skip
    file.write_text(session.to_text(words), encoding="utf-8")
    return file


def test_settings_that_are_loaded(board, client, saved):
    """The first error, and that a part of the words may be the file's."""
    before = len(board.asked)
    board.pulled_by = _nth(lambda frame: frame[1] == 16, 3)
    with pytest.raises(HostError) as problem:
        session.load(client, saved)
    unplugged(board, problem.value)
    assert len([frame for frame in board.asked[before:] if frame[1] == 16]) == 2
    assert "may have some of the file's words; load it again" in str(problem.value)


def test_settings_that_are_saved(board, saved):
    """The file that is there stays as it is."""
    text = saved.read_text()
    board.pulled_by = reads("root")
    unplugged(board, told("save", str(saved), "--port", board.path))
    assert saved.read_text() == text
    assert [*saved.parent.iterdir()] == [saved]


# ---- An identification.


class QuickLine(Board):
    """The integer controller with its motor, at a pseudo-terminal."""

    def __init__(self, quick: QuickBoard) -> None:
        super().__init__()
        self.quick = quick
        words = quick.identification.words
        for name in ("clock_hz", "options"):
            self.put(2 * modbus.IDENTIFICATION.index(name), [words[name]])
        self._places = {
            place.address: place
            for word in WORDS.values()
            if quick.shape.has(word)
            for index in range(quick.shape.copies(word))
            for place in [Place(word, 0, index, quick.shape)]
        }

    def _answer(self, frame: bytes) -> None:
        found = registers(frame)
        if found[0] >= modbus.TABLE:
            first, count = (found[0] - modbus.TABLE) // 2, len(found) // 2
            wanted = [self._places[first + n] for n in range(count)]
            if frame[1] == 3:
                self.put(found[0], self.quick.read(wanted))
            else:
                raws = struct.unpack(f">{count}I", frame[7:-2])
                signed = (
                    raw - (1 << 32) if place.word.fixed.signed and raw >> 31 else raw
                    for place, raw in zip(wanted, raws, strict=True)
                )
                self.quick.write(zip(wanted, signed, strict=True))
        super()._answer(frame)


@pytest.fixture
def motor(make_scene) -> Iterator[QuickLine]:
    found = QuickLine(QuickBoard(make_scene(*REAL)))
    found.start()
    yield found
    found.close()


def test_a_motor_that_is_identified(motor, tmp_path, monkeypatch):
    """The first error, and the settings from before in a file."""
    monkeypatch.chdir(tmp_path)
    motor.pulled_by = reads("capture_data", 30)
    problem = told("identify", "--counts", str(COUNTS), "--port", motor.path, "--out", "m.toml")
    unplugged(motor, problem)
    kept = tmp_path / "m.before.toml"
    assert "`board load m.before.toml` gives it those that it had" in problem
    assert len(session.read(kept, motor.quick.shape)) > 10


def test_an_identification_that_cant_give_back(motor, tmp_path, monkeypatch):
    """All was measured: it is written, and then the error is told."""
    monkeypatch.chdir(tmp_path)

    def last(frame: bytes) -> bool:
        """The write of the settings at the end, behind that which disarms."""
        if frame[1] != 16:
            return False
        if at("arm") in registers(frame):
            last.disarmed = frame[-3] == 0
        return last.disarmed and at("zero") in registers(frame)

    last.disarmed = False
    motor.pulled_by = last
    problem = told("identify", "--counts", str(COUNTS), "--port", motor.path, "--out", "m.toml")
    unplugged(motor, problem)
    assert "m.before.toml" in problem
    assert "R_ohm" in (tmp_path / "m.toml").read_text()
    assert (tmp_path / "m.words.toml").is_file()


def test_an_identification_that_is_ended(motor):
    """By Ctrl-C, which is no error; that the plug is pulled then is one."""
    asked: list[bool] = []
    motor.pulled_by = lambda frame: bool(asked)
    client = Client(motor.path, timeout_s=TIMEOUT_S)
    driver = Driver(client, ended=lambda: bool(asked))
    with pytest.raises(HostError) as problem:
        identify(driver, Wishes(COUNTS), show=lambda stage, part: asked.append(stage == "pulses"))
    unplugged(motor, problem.value)
    assert not driver.restored


# ---- The scope.


def test_the_scope(board, client):
    """It shows the port and the cure, has all rows, and switches off what it can."""
    board.words = 4
    board.pulled_after = 60
    feed = Feed(Plug(board.path), Known(), unit=1, motor=0, timeout_s=TIMEOUT_S)
    feed.start()
    try:
        end = time.monotonic() + END_S
        while not feed.state()["problem"]:
            assert time.monotonic() < end
            time.sleep(0.01)
        unplugged(board, feed.state()["problem"])
        assert len(feed.kept) >= 60 * 15
    finally:
        feed.end()


def test_a_scope_that_cant_switch_off(board):
    """Its end tells that."""
    board.put(at("stream_state"), [0])
    feed = Feed(Plug(board.path), Known(), unit=1, motor=0, timeout_s=TIMEOUT_S)
    feed.start()
    page, end = object(), time.monotonic() + END_S
    while not feed.state()["live"]:
        assert time.monotonic() < end
        time.sleep(0.01)
    feed.arm(page).result(END_S)
    board.pulled_by = _nth(lambda f: f[1] == 16 and at("arm") in registers(f) and not f[-3], 1)
    with pytest.raises(HostError) as problem:
        feed.end()
    unplugged(board, problem.value)


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGTERM])
def test_signals_that_end_the_scope(board, number):
    """The terminal is closed, or somebody kills it: switched off by its own hand."""
    board.put(at("stream_state"), [0])
    words = ("scope", "--port", board.path, "--http-port", "0", "--no-browser")
    process = command(*words)
    assert process.stdout.readline().startswith("http://")
    end = time.monotonic() + END_S
    while len(board.asked) < 20:
        assert time.monotonic() < end
        time.sleep(0.01)
    assert stop(process, number) == 0
    off = [f for f in board.asked if f[1] == 16 and at("arm") in registers(f) and not f[-3]]
    assert off
