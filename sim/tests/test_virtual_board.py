# SPDX-License-Identifier: Apache-2.0
"""The virtual board, and the commands that talk to it as to one with a real port."""

from __future__ import annotations

import errno
import itertools
import os
import random
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import typer
from device_pins import BrushlessDevicePins, DevicePins
from wavehaptics.cli import board, shared
from wavehaptics.cli.shared import CommandError
from wavehaptics.host import session
from wavehaptics.host.led_hand import LedHand
from wavehaptics.host.names import HostError, Shape, number, places, settings
from wavehaptics.host.scope.bench import Known
from wavehaptics.host.scope.feed import Feed
from wavehaptics.host.scope.plug import VirtualPlug
from wavehaptics.host.virtual import VirtualBoard
from wavehaptics.ladder.linked_pins import LinkedBrushlessPins, LinkedPins
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.terminals import check_terminals
from wavehaptics.runtime.toolchain import ToolError
from wavehaptics.scene import SceneError, find_scene, load_scene
from wavehaptics.trace.columns import Column, Word, load_trace
from wavehaptics.words import modbus, table
from wavehaptics.words.faults import ARM_REFUSALS, FAULTS
from wavehaptics.words.formats import RTL_DIR
from wavehaptics.words.table import WORDS

BOARD = ("drive.bus_v=12", "adc.bits=12", "adc.full_scale_a=2.5", "encoder.counts_per_rev=10000")
COUNTS = 10_000
AMPLITUDE_RAD = 0.15
TOP = round(AMPLITUDE_RAD * COUNTS / (2 * np.pi))
"""Counts at which the hand turns round."""
SLOW = ("controller.tick_hz=250e3", "controller.clock_hz=16e6")
"""A slow board: a simulated one takes a third of the time for it."""
SWINGS = (
    *BOARD, *SLOW, "hand.path=sine", f"hand.amplitude_rad={AMPLITUDE_RAD}", "hand.frequency_hz=50",
)  # fmt: skip
SHAPE = Shape(1, 4, 0, 10)
TABLE = f'table = "{table.crc():08x}"\n'
"""The first line of a file of settings."""
START_S = 600
"""The RTL is built first, where that hasn't been done."""
END_S = 300
TRIES = 20
"""A simulated board on a busy machine is slow."""


def command(*words: str, env: dict[str, str] | None = None) -> subprocess.Popen:
    if "--virtual" in words:
        check_terminals()
    return subprocess.Popen(
        [sys.executable, "-m", "wavehaptics", "board", *words], text=True, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "COLUMNS": "80", **(env or {})},
    )  # fmt: skip


def start(*words: str, scene: str = "press_hold") -> tuple[subprocess.Popen, str]:
    """A board and the path that it tells."""
    sets = [word for text in SWINGS for word in ("--set", text)]
    process = command("--virtual", scene, *sets, *words)
    path = process.stdout.readline().strip()
    assert re.fullmatch(r"/dev/\S+", path), process.stderr.read()
    return process, path


def stop(process: subprocess.Popen, number: int = signal.SIGTERM) -> int:
    process.send_signal(number)
    try:
        return process.wait(END_S)
    finally:
        process.kill()
        process.communicate()


@pytest.fixture(scope="module")
def port() -> Iterator[str]:
    process, path = start()
    yield path
    assert stop(process) == 0


def run(port: str, *words: str) -> tuple[int, str, str]:
    """Status, stdout and stderr of a command at the port, patient as the board is slow."""
    process = command(*words, env={"WH_PORT": port})
    out, err = process.communicate(timeout=END_S)
    return process.returncode, out, err


def told(port: str, *words: str) -> str:
    status, out, err = run(port, *words, "--timeout", "60")
    assert (status, err) == (0, "")
    return out


def refused(port: str, *words: str) -> str:
    """The one line of a refusal."""
    status, out, err = run(port, *words)
    assert (status, out) == (2, "")
    assert re.fullmatch(r"wavehaptics: [^\n]+\n", err), err
    return err.removeprefix("wavehaptics: ").strip()


def value(port: str, name: str) -> float:
    return float(told(port, "get", name).split()[1])


def until(port: str, name: str, wanted: float) -> None:
    end = time.monotonic() + END_S
    while value(port, name) != wanted:
        assert time.monotonic() < end, name


@pytest.fixture
def armed(port: str) -> Iterator[subprocess.Popen]:
    """A host that renews the arming."""
    process = command("arm", "--timeout", "60", env={"WH_PORT": port})
    assert process.stdout.readline() == "armed; Ctrl-C disarms\n"
    yield process
    if process.poll() is None:
        assert stop(process, signal.SIGINT) == 0
    until(port, "armed", 0)


# ---- The simulation.


@pytest.mark.parametrize(
    ("scene", "kinds"),
    [
        (("press_hold", BOARD), (DevicePins, LinkedPins)),
        (("brushless_hold", ()), (BrushlessDevicePins, LinkedBrushlessPins)),
    ],
)
def test_left_alone_it_is_the_device(scene, kinds):
    """Bit for bit, with settings that came as frames over the line, and the bridges on."""
    name, sets = scene
    loaded = load_scene(find_scene(name), sets)
    found = []
    for simulation in (kinds[0](loaded), kinds[1](loaded, arm=False)):
        rows = np.zeros((20_000, len(Column)))
        words = np.zeros((20_000, len(Word)), dtype=np.int64)
        simulation.advance(rows, words)
        found.append((rows, words))
    assert np.abs(found[0][1][:, Word.V]).max() > 1000
    np.testing.assert_array_equal(found[0][1], found[1][1])
    np.testing.assert_array_equal(found[0][0], found[1][0])


# ---- The commands.


def test_what_it_is(port):
    shown = told(port, "info")
    assert f"table of words  {table.crc():08x}\n" in shown
    assert "delay_log2 10, anchor 1, guard 1, sense 1, dead_time 1, arm 1, capture 12" in shown
    assert "16 MHz" in shown


def test_set_and_get(port):
    """In units and raw; words of one group by one frame, those of two by two."""
    assert told(port, "set", "root=1.9375", "u_max=2.5") == ""
    assert told(port, "get", "root", "u_max").splitlines() == ["root   1.9375 √Ω", "u_max  2.5 √W"]
    raw = WORDS["root"].fixed.to_raw(1.9375)
    assert told(port, "get", "root", "--raw") == f"root  0x{raw:08x}\n"
    assert told(port, "set", "--raw", f"root=0x{raw + 1:x}") == ""
    assert value(port, "root") > 1.9375
    assert told(port, "set", "eta_free=0.5", "root=2").startswith("2 frames")
    told(port, "set", "eta_free=1")
    lines = told(port, "watch", "--csv", "-n", "2", "--every", "0", "root", "armed").splitlines()
    assert lines[0] == "t_s,root,armed"
    assert [line.split(",")[1:] for line in lines[1:]] == [["2", "0"]] * 2
    assert "root" in told(port, "watch", "-n", "1", "root")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("set", "root=99"), r"root = 99 is out of range; it takes 0\.\.\.16 √Ω"),
        (("set", "samples=2.5"), r"samples = 2.5 is no whole number; it takes 1\.\.\.256"),
        (("set", "root"), r"root: write NAME=NUMBER, as in root=2.0"),
        (("set", "rot=1"), r"rot: there is no such word; did you mean root\?"),
        (("set", "position=1"), r"position can't be set; it is what the device tells"),
        (("set", "commit=1"), r"commit can't be set; the link gives"),
        (("set", "wall_min=1"), r"wall_min=1: which one\? Take wall_min\[0\]...wall_min\[3\]"),
        (("get", "wall_min[4]"), r"wall_min\[4\]: .*take wall_min\[0...3\]"),
        (("get", "root", "--motor", "1"), r"root: the device has no motor 1; take --motor 0...0"),
        (("get", "arm"), r"arm can't be read; it is a command"),
        (("get", "root", "--unit", "7", "--timeout", "0.2"), r".*no answer within 0.2 s; .*unit 7"),
        (("load", "/nowhere.toml"), r"/nowhere.toml: can't be read: No such file"),
        (("get", "root", "--port", "/nowhere"), r"/nowhere: can't be opened: No such file"),
        (("get", "root", "--port", ""), r"no port: name one with --port PATH, or in WH_PORT"),
        ((), r"board: give a command, or --virtual SCENE"),
        (("--virtual", "no_such"), r"no_such.*"),
        (("--virtual", "press_hold", "info"), r"board --virtual runs by itself"),
        (("--link", "x", "info"), r"--link goes with --virtual; leave it out, .*board info"),
        (("--set", "a.b=1", "info"), r"--set goes with --virtual; leave it out"),
        (("--paced",), r"--paced goes with --virtual; leave it out, or name a scene with"),
    ],
)
def test_refusals(port, words, message):
    patient = () if not words or words[0].startswith("--") or "--timeout" in words else (
        "--timeout", "60")  # fmt: skip
    assert re.match(message, refused(port, *words, *patient))


def test_a_session(port, tmp_path):
    """Saved, changed, loaded: as it was. A file with wrong words changes nothing."""
    file, bad = tmp_path / "all.toml", tmp_path / "bad.toml"
    count = len(settings(SHAPE))
    assert told(port, "save", str(file)) == f"{file}: {count} words\n"
    before = value(port, "a")
    told(port, "set", "a=0.25", "wall_max[3]=-7")
    assert told(port, "load", str(file)) == f"{file}: {count} words, of which 2 were others\n"
    assert (value(port, "a"), value(port, "wall_max[3]")) == (before, 0)
    bad.write_text(f"{TABLE}[motor.0]\na = 0.5\nroot = 99\nposition = 1\n[board]\ntrip = 'x'\n")
    status, _, err = run(port, "load", str(bad), "--timeout", "60")
    assert status == 2
    assert [line.split(": ")[-2:] for line in err.splitlines()] == [
        [f"{bad}:4", "root = 99 is out of range; it takes 0...16 √Ω"],
        [f"{bad}:5", "position is no setting"],
        [f"{bad}:7", 'trip = "x" is no number; it takes 0...65535'],
    ]
    assert value(port, "a") == before


def test_what_a_board_leaves_out_is_told():
    """And nothing that it does: it has the link of a scene with [host]."""
    words = ("--virtual", "hosted_wall", "--seconds", "0.001")
    for more, told in (((), ""), (("--set", "servo.rate_hz=5000"), "[servo]")):
        process = command(*words, *more)
        _, err = process.communicate(timeout=END_S)
        assert process.returncode == 0
        assert re.findall(r"the board leaves out (.*)", err) == [told] * bool(told)


# ---- What takes long.


def test_progress_while_a_board_is_built(monkeypatch, capsys, tmp_path):
    """Also where there is no terminal: what it does, and for how long."""
    monkeypatch.setattr(shared, "FIRST_TOLD_S", 0.05)
    monkeypatch.setattr(shared, "TOLD_S", 0.05)

    def built(*_: object) -> None:
        time.sleep(0.5)
        raise ZeroDivisionError

    monkeypatch.setattr("wavehaptics.ladder.linked_pins.linked_pins", built)
    with pytest.raises(ZeroDivisionError):
        board.app(["board", "--virtual", "press_hold"], standalone_mode=False)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("building the simulated board, which takes minutes the first time: ") > 3
    shown = capsys.readouterr().err
    time.sleep(0.2)
    assert capsys.readouterr().err == shown == ""


def test_the_scope_shows_what_its_board_does(monkeypatch, tmp_path):
    """While it starts, and once it has ended."""
    script = tmp_path / "board.sh"
    script.write_text("#!/bin/sh\necho building >&2\nread line\necho /dev/x\nread line\nexit 1\n")
    script.chmod(0o755)
    monkeypatch.setattr(VirtualPlug, "_start", lambda plug: None)
    plug = VirtualPlug("press_hold", ())
    monkeypatch.undo()
    plug._command = [str(script)]
    plug._start()

    def wait(problem: str) -> None:
        end = time.monotonic() + END_S
        while plug.problem != problem:
            assert time.monotonic() < end, plug.problem
            time.sleep(0.01)

    try:
        wait("the virtual board starts: building")
        for problem in ("", "the virtual board has ended: building"):
            plug._process.stdin.write("\n")
            plug._process.stdin.flush()
            wait(problem)
    finally:
        plug.close()


# ---- A machine without pseudo-terminals.


def test_a_virtual_board_without_pseudo_terminals(monkeypatch):
    """One line with the cure, before anything is built."""

    def none() -> None:
        raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))

    monkeypatch.setattr(os, "openpty", none)
    line = r"^there are no pseudo-terminals here \(No such device\); mount them: mount -t devpts .*"
    for words in (("--virtual", "press_hold"), ("scope",), ("scope", "--virtual", "press_hold")):
        with pytest.raises(ToolError, match=line) as error:
            board.app(["board", *words], standalone_mode=False)
        assert "\n" not in str(error.value)
    with pytest.raises(ToolError, match=line), VirtualBoard(SimpleNamespace()):
        pass


WITHOUT = """
import errno, os, sys

def none():
    raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))

os.openpty = none
import pytest
sys.exit(pytest.main(sys.argv[1:]))
"""


def test_tests_without_pseudo_terminals():
    """One line at the beginning, one at the end, and no failure; what needs none is run."""
    files = ("test_client.py", "test_streamed.py", "test_several_motors.py", "test_scope_stream.py")
    chosen = "board or port or answer or three or words or lost"
    ended = subprocess.run(
        [sys.executable, "-c", WITHOUT, "-p", "no:cacheprovider", "-k", chosen,
         *(f"sim/tests/{file}" for file in files)],
        cwd=ROOT, capture_output=True, text=True, timeout=END_S,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stdout
    found = re.search(r"(\d+) passed, (\d+) skipped", ended.stdout)
    passed, skipped = map(int, found.groups())
    assert passed > 2
    assert skipped > 20
    lines = [line for line in ended.stdout.splitlines() if "no pseudo-terminals" in line]
    begin, end = lines
    assert begin.startswith("tests that need a pseudo-terminal are skipped: ")
    assert end.startswith(f"SKIPPED [{skipped}] conftest.py:1: ")


# ---- Arming.


def test_a_wall_that_is_moved(port, armed):
    """The motor that a hand swings is in the wall now and then; moved, the wall lets it swing."""

    def rows() -> list[tuple[int, int]]:
        """Places, and whether a wall is felt there, once what the move stirred up is over."""
        read = ("watch", "--csv", "-n", "60", "--every", "0", "position", "flags")
        lines = [line.split(",") for line in told(port, *read).splitlines()]
        return [(int(place), int(flags) & 1) for _, place, flags in lines[21:]]

    told(port, "set", "wall_min[0]=0", "a=0.99")
    assert {felt for _, felt in rows()} >= {1}
    # Without an anchor a hand drags the rotor through a wave wall, but not as far as that.
    told(port, "set", f"wall_min[0]={10 * TOP}", f"wall_max[0]={20 * TOP}")
    places, felt = zip(*rows(), strict=True)
    assert not any(felt)
    assert min(places) < -0.5 * TOP
    assert 0.5 * TOP < max(places) < 2 * TOP
    assert "the bridges are on" in told(port, "faults")
    problem = refused(port, "set", "half_clocks=50", "--timeout", "60")
    assert problem.startswith("half_clocks: the device refuses with exception 6: not now")
    assert value(port, "running") == 1
    assert told(port, "disarm") == ""
    _, err = armed.communicate(timeout=END_S)
    assert armed.returncode == 2
    assert err.startswith("wavehaptics: disarmed: somebody has disarmed it")


def test_a_host_that_dies_leaves_nothing_running(port, armed):
    assert value(port, "running") == 1
    armed.kill()
    armed.communicate()
    until(port, "running", 0)
    shown = told(port, "faults")
    assert "not armed: it wasn't renewed in time\n" in shown
    assert shown.endswith("the bridges are off\n")


def test_a_fault_disarms_and_refuses(port):
    """A bus below its limit: seen at once, not cleared while it lasts, and no arming meanwhile."""
    told(port, "set", "guard_mask=1024", "guard_bus_min=20")
    try:
        assert "BUS_LOW\n" in told(port, "faults")
        problem = refused(port, "arm", "--timeout", "60")
        assert problem.startswith("not armed: there is a fault; `board faults` tells more")
        assert "BUS_LOW" in told(port, "faults", "--clear")
    finally:
        told(port, "set", "guard_mask=0", "guard_bus_min=0")
    lines = told(port, "faults", "--clear").splitlines()
    assert lines == ["no faults", "a fault was against arming, and is over", "the bridges are off"]


# ---- A capture.


def test_a_capture_of_the_swing(port, tmp_path):
    """The hand's 50 Hz in the position, with the bridges off."""
    until(port, "running", 0)
    shown = told(
        port, "capture", "position", "--trigger", "position rises -50", "--pre", "0.002",
        "--seconds", "0.024", "--counts-per-rev", str(COUNTS), "--out", str(tmp_path),
    ).splitlines()  # fmt: skip
    assert shown[0] == str(tmp_path / "trace.npz")
    assert (tmp_path / "capture.png").stat().st_size > 10_000
    assert shown[2] == "3000 rows of 8 µs; the trigger's is row 250"
    trace = load_trace(tmp_path)
    assert np.allclose(np.diff(trace["t"]), 8e-6)
    ends = trace["x"] + 0.5 * 8e-6 * trace["omega"]  # of the rows
    counts = np.round(ends / (2 * np.pi / COUNTS))
    assert np.allclose(counts, ends / (2 * np.pi / COUNTS), atol=1e-6)
    rising = np.flatnonzero((counts[1:] >= -50) & (counts[:-1] < -50)) + 1
    assert rising[0] == 250
    assert trace["t"][250] == 0.0
    assert abs(trace["t"][rising[-1]] - 0.02) < 1e-3


def test_a_capture_lets_the_arming_be_renewed(port, armed, tmp_path):
    """Which another program does, while this one reads at a fast rate."""
    shown = told(port, "capture", "--seconds", "0.001", "--out", str(tmp_path)).splitlines()
    assert shown[2] == "250 rows of 4 µs; the trigger's is row 0"
    assert "running" in shown[-1]
    assert armed.poll() is None, armed.stderr.read()
    assert value(port, "armed") == 1


def test_captures_that_are_refused(port, tmp_path):
    for words, message in (
        (("root",), "root: can't be captured; take voltage, u, v"),
        (("--trigger", "current=1"), "trigger current=1: write now, contact"),
        (("--decimate", "3"), "decimation 3: take 1, 2, 4"),
        (("--preset", "none"), "--preset none: there is none; take re25-118743"),
        (("--preset", "re25-118743", "--k-t", "1"), "--preset and --k-t: give one of them"),
        (("--seconds", "0.001", "--pre", "0.001"), "250 rows before the trigger's: take 0...249"),
    ):
        problem = refused(port, "capture", *words, "--out", str(tmp_path), "--timeout", "60")
        assert problem.startswith(message)


# ---- The line.


def test_garbage_on_the_line(port):
    """Bytes that are no frames, and none of which is answered: the next question is."""

    def errors() -> int:
        """Broken frames, counted by their CRC or their length."""
        return sum(map(int, re.findall(r"(?:crc errors|overruns) +(\d+)", told(port, "info"))))

    noise, before = random.Random(20), errors()
    line = os.open(port, os.O_RDWR | os.O_NOCTTY)
    try:
        os.write(line, bytes(noise.randrange(256) for _ in range(700)))
    finally:
        os.close(line)
    # Without a gap behind it, the noise may take the first question with it; it is asked again.
    status, out, err = run(port, "get", "root", "--timeout", "5")
    assert (status, err) == (0, "")
    assert float(out.split()[1]) == value(port, "root")
    assert errors() > before


def test_a_board_is_silent_until_it_is_asked():
    """Nothing is on the line of a new board, for one who reads all that comes."""
    process, path = start()
    line = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        assert not select.select([line], [], [], 3.0)[0], os.read(line, 256).hex()
    finally:
        os.close(line)
        stop(process)


@pytest.mark.skipif(shutil.which("mbpoll") is None, reason="mbpoll is not installed: make setup")
def test_a_master_that_is_not_ours(port):
    """mbpoll reads the identification as docs/link.md has it."""
    master = subprocess.run(
        ["mbpoll", "-m", "rtu", "-a", "1", "-b", "115200", "-P", "none", "-0", "-1", "-o", "10",
         "-t", "4:hex", "-r", "0x0", "-c", "2", port],
        capture_output=True, text=True, timeout=END_S,
    )  # fmt: skip
    assert master.returncode == 0, master.stdout + master.stderr
    words = [int(text, 16) for text in re.findall(r"^\[\d+\]:\s+(0x\w+)", master.stdout, re.M)]
    assert modbus.whole(words) == [table.crc()]


def test_how_a_board_ends(tmp_path):
    """Killed, it leaves hosts with one line; asked to end, no link and status 0."""
    link, hand = tmp_path / "port", tmp_path / "hand"
    for asks in (signal.SIGINT, signal.SIGHUP):
        process, path = start("--link", str(link), "--hand", str(hand), "--paced")
        assert os.readlink(link) == path
        assert told(str(link), "get", "armed") == "armed  0\n"
        assert stop(process, asks) == 0
        assert [*tmp_path.iterdir()] == []
    process, path = start()
    stop(process, signal.SIGKILL)
    assert re.match(rf"{path}: (can't be opened|no answer|.*was it unplugged)",
                    refused(path, "get", "armed", "--timeout", "1"))  # fmt: skip
    process, _ = start("--tied")
    process.stdin.close()
    process.stdin = None
    assert process.wait(END_S) == 0
    process.communicate()
    process, _ = start("--seconds", "0.001")
    assert process.wait(END_S) == 0
    process.communicate()
    there = tmp_path / "there"
    there.write_text("")
    assert "is there and no link" in refused("", "--virtual", "press_hold", "--link", str(there))


# ---- What needs no board.


@pytest.mark.parametrize(
    ("refused", "there", "lines"),
    [
        (0, {}, ["no faults"]),
        (2, {}, ["no faults", "a fault was against arming, and is over"]),
        (2, {"faults": 1 << 10}, ["BUS_LOW", "not armed: there is a fault"]),
        (2, {"overrun": 1}, ["a tick is too short.*", "not armed: there is a fault"]),
        (18, {}, ["no faults", "not armed: it wasn't renewed in time",
                  "a fault was against arming, and is over"]),
        (16, {}, ["no faults", "not armed: it wasn't renewed in time"]),
    ],
)  # fmt: skip
def test_a_fault_that_is_over_is_told_as_such(capsys, monkeypatch, refused, there, lines):
    """``arm_refused`` keeps its reasons until the next arming; faults are what there is now."""
    now = {"arm_refused": refused, **there}
    device = SimpleNamespace(
        shape=SHAPE, read=lambda found: [now.get(place.word.name, 0) for place in found]
    )
    monkeypatch.setattr(board.common, "connected", lambda *_: device)
    board.app(["board", "faults", "--port", "x"], standalone_mode=False)
    shown = capsys.readouterr().out.splitlines()
    assert shown[-1] == "the bridges are off"
    for line, wanted in zip(shown[:-1], lines, strict=True):
        assert re.match(rf"{wanted}(:|$)", line), line


def test_a_table_that_is_piped_ends_with_its_line(capsys, monkeypatch):
    device = SimpleNamespace(shape=SHAPE, read=lambda found: [0 for _ in found])
    monkeypatch.setattr(board.common, "connected", lambda *_: device)
    told = ["board", "watch", "-n", "2", "--every", "0", "root", "--port", "x"]
    board.app(told, standalone_mode=False)
    out = capsys.readouterr().out
    assert out.count("root") == 1
    assert re.search(r"\S\n$", out)


def test_every_command_is_on_the_page():
    """The table of docs/board.md has each once."""
    page = (ROOT / "docs" / "board.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`[^|]*) \|", page.partition("## The scope")[0], re.M)
    listed = [name for row in rows for name in re.findall(r"`([a-z]+)[^`]*`", row)]
    commands = board.common.board.registered_commands
    assert sorted(listed) == sorted(c.name or c.callback.__name__ for c in commands)


def test_every_setting_goes_through_a_file(tmp_path):
    """Words at both ends of their ranges come back as they were, whatever the sizes."""
    shape = Shape(2, 3, 2, 5)
    file = tmp_path / "all.toml"
    for end in (0, 1):
        words = []
        for place in settings(shape):
            fixed = place.word.fixed
            low, high = (round(bound * 2**fixed.fraction) for bound in place.range)
            words.append((place, (low, min(high, fixed.raw_max))[end]))
        file.write_text(session.to_text((p, raw & 0xFFFFFFFF) for p, raw in words), "utf-8")
        assert sorted(session.read(file, shape), key=lambda pair: pair[0].address) == sorted(
            words, key=lambda pair: pair[0].address
        )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('table = "0"\n', r':1: table = "0" is another table of words than'),
        ("table = true\n", r":1: table = true is another table of words than"),
        ("[motor.0]\na = 1\n", r":1: no table = .* tells of which table of words .*save .*"),
        ("", r": there is no word in it; take a file that `board save` wrote"),
        (TABLE, r": there is no word in it; take a file that `board save` wrote"),
        (TABLE + "[motor.0]\n[board]\n", r": there is no word in it; take a file"),
        (TABLE + "words = 2\n[motor.0]\na = 1\n", r":2: it has 1 of its 2 words; was it cut\?"),
        (TABLE + "words = 1\n[motor.0]\na = 1", r":2: its last line has no end; was it cut\?"),
        (TABLE + "words = 1\n[motor.0]\na = 1\nroot = 1\n", r":2: words = 1, but it has 2;"),
        (TABLE + "words = 1.5\n[motor.0]\na = 1\n", r":2: words = 1.5 is no number of words"),
        (TABLE + "[motor.1]\na = 1\n", r":2: \[motor.1\]: the device has motors 0...0"),
        (TABLE + '[motor."²"]\na = 1\n', r":2: \[motor.²\]: the device has motors 0...0"),
        (TABLE + "[motor.00]\na = 1\n", r":2: \[motor.00\]: the device has motors 0...0"),
        (TABLE + "[more]\n", r":2: more: there are \[board\] and"),
        (TABLE + "[board]\nroot = 1\n", r":3: root stands in \[motor.0\]"),
        (TABLE + "[motor.0]\nwall_min = [1, 2]\n", r":3: wall_min takes a list of 4 numbers"),
        (TABLE + "[motor.0]\nwall_min = 1\n", r":3: wall_min takes a list of 4 numbers"),
        (TABLE + '[motor.0]\nroot = "2"\n', r':3: root = "2" is no number'),
        (TABLE + "[motor.0]\nroot = true\n", r":3: root = true is no number"),
        (TABLE + "[motor.0]\nroot = [2]\n", r":3: root = an array is no number"),
        (TABLE + "[motor.0]\nroot = nan\n", r":3: root = nan is no number"),
        (TABLE + "[motor.0]\nwall_min = [1, '2', 3, 4]\n", r':3: wall_min\[1\] = "2" is no'),
        ("[board\n", r":1: "),
        (
            TABLE + '[motor.0]\nwall_min = [1, 2, 3, 4]\n"wall_min[2]" = [5]\n',
            r":4: wall_min\[2\] is given twice",
        ),
    ],
)
def test_files_that_are_refused(tmp_path, text, message):
    file = tmp_path / "bad.toml"
    file.write_text(text)
    with pytest.raises(HostError, match=message) as error:
        session.read(file, SHAPE)
    assert "\n" not in str(error.value)


def test_a_file_that_was_cut(tmp_path):
    """Wherever: refused as a whole, also within its last number, and nothing is written."""
    file = tmp_path / "all.toml"
    text = session.to_text((place, place.raw(place.range[1])) for place in settings(SHAPE))
    file.write_text(text)
    count = len(session.read(file, SHAPE))
    assert count == len(settings(SHAPE))
    size = len(text.encode())
    device = SimpleNamespace(
        shape=SHAPE, read=lambda _: pytest.fail("it was asked"),
        write=lambda _: pytest.fail("it was written"),
    )  # fmt: skip
    for length in (*range(0, size, 23), *range(size - 40, size)):
        file.write_bytes(text.encode()[:length])
        with pytest.raises(HostError, match=rf"^{re.escape(str(file))}") as error:
            session.load(device, file)
        assert "\n" not in str(error.value), length
    half = text.encode()[: size // 2].rpartition(b"\n")[0] + b"\n"
    file.write_bytes(half)
    with pytest.raises(HostError, match=rf"it has \d+ of its {count} words; was it cut\? Save it"):
        session.load(device, file)
    file.write_text(text.replace(f"words = {count}\n", ""))  # by a person
    assert len(session.read(file, SHAPE)) == count


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("", r"{}: is a folder; name a file in it, as in {}/settings.toml$"),
        ("file/x", r"{}/file/x: can't be written: {}/file is a file and no folder; name another"),
        ("file/x/y", r"{}/file/x/y: can't be written: {}/file is a file and no folder; name"),
        ("x" * 300, r"{}/x+: can't be written: File name too long; name another file$"),
    ],
)
def test_files_that_cant_be_saved(tmp_path, name, message):
    """One line with the path and the cure, before the device is asked; what is there stays."""
    (tmp_path / "file").write_text("kept")
    device = SimpleNamespace(shape=SHAPE, read=lambda _: pytest.fail("it was asked"))
    with pytest.raises(HostError, match=message.replace("{}", re.escape(str(tmp_path)))) as error:
        session.save(device, tmp_path / name)
    assert "\n" not in str(error.value)
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("file", "kept")]


def test_a_link_is_tried_where_it_points_to(tmp_path):
    """Its folder is made, as the write would."""
    link = tmp_path / "all.toml"
    link.symlink_to(tmp_path / "there" / "all.toml")
    session.save(SimpleNamespace(shape=SHAPE, read=lambda found: [0 for _ in found]), link)
    assert link.is_symlink()
    assert (tmp_path / "there" / "all.toml").is_file()
    (tmp_path / "file").write_text("kept")
    link.unlink()
    link.symlink_to(tmp_path / "file" / "all.toml")
    device = SimpleNamespace(shape=SHAPE, read=lambda _: pytest.fail("it was asked"))
    with pytest.raises(HostError, match=r"all\.toml: can't be written: "):
        session.save(device, link)


def test_what_is_no_file_is_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    device = SimpleNamespace(shape=SHAPE, read=lambda _: pytest.fail("it was asked"))
    with pytest.raises(HostError, match=r"pipe: is no file that can be replaced; name"):
        session.save(device, tmp_path / "pipe")


def test_an_identification_that_couldnt_be_kept(tmp_path):
    """Its file is tried before anything turns, and before the port."""
    words = ["board", "identify", "--counts", "4", "--out", str(tmp_path), "--port", "/nowhere"]
    with pytest.raises(CommandError, match=rf"^{re.escape(str(tmp_path))}: is a folder; name a"):
        board.app(words, standalone_mode=False)
    words[words.index("--out") + 1] = str(tmp_path / "m.toml")
    beside = tmp_path / "m.words.toml"
    beside.mkdir()
    with pytest.raises(CommandError, match=rf"^{re.escape(str(beside))}: is a folder; name a"):
        board.app(words, standalone_mode=False)


def test_a_disk_that_fills_meanwhile(tmp_path, monkeypatch):
    """What the check before can't know is one line as well, and the old file stays."""
    file = tmp_path / "all.toml"
    file.write_text("kept")

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(session, "write_text", full)
    device = SimpleNamespace(shape=SHAPE, read=lambda found: [0 for _ in found])
    with pytest.raises(HostError, match=r"all.toml: can't be written: No space left on device; "):
        session.save(device, file)
    assert file.read_text() == "kept"


@pytest.mark.parametrize(
    ("option", "name", "message"),
    [
        ("--link", "none/x", r"--link {}/none/x: there is no folder {}/none; make it, or name"),
        ("--hand", "none/h", r"--hand {}/none/h: there is no folder {}/none; make it, or name"),
        ("--link", "file/x", r"--link {}/file/x: {}/file is no folder; name another path$"),
        ("--hand", "file", r"--hand {}/file: is there and no socket; name another path$"),
        ("--hand", "h" * 200, r"--hand {}/h+: is too long for a socket; name a shorter path$"),
        ("--link", "l" * 300, r"--link {}/l+: can't be made: File name too long; name another"),
    ],
)
def test_places_where_a_board_cant_be(tmp_path, option, name, message):
    """One line that names the option, before anything is built."""
    (tmp_path / "file").write_text("")
    words = ["board", "--virtual", "press_hold", option, str(tmp_path / name)]
    with pytest.raises(CommandError, match=message.replace("{}", re.escape(str(tmp_path)))):
        board.app(words, standalone_mode=False)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_two_boards_with_one_link(tmp_path):
    """The link is the later one's, and stays when the earlier one ends."""
    link, pins = tmp_path / "port", SimpleNamespace()
    with ExitStack() as later:
        with VirtualBoard(pins, link) as first:
            assert os.readlink(link) == first.path
            second = later.enter_context(VirtualBoard(pins, link))
            assert os.readlink(link) == second.path
        assert os.readlink(link) == second.path
    assert not link.is_symlink()
    with VirtualBoard(pins, link):
        link.unlink()


def test_two_boards_with_one_hand(tmp_path):
    """The socket is the later one's, and stays when the earlier one ends."""
    path = tmp_path / "hand"
    with ExitStack() as later:
        with LedHand(path, 0.0):
            later.enter_context(LedHand(path, 0.0))
        with socket.socket(socket.AF_UNIX) as guide:
            guide.connect(str(path))
    assert not path.exists()
    with LedHand(path, 0.0):
        path.unlink()


def test_an_error_is_told_though_the_socket_cant_be_removed(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(ZeroDivisionError), LedHand(folder / "hand", 0.0):
        fails_without(folder)


def fails_without(folder: Path) -> None:
    shutil.rmtree(folder)
    folder.write_text("no folder")
    raise ZeroDivisionError


def test_numbers_and_names():
    assert (number("0x10"), number("-3"), number("1.5e1")) == (16, -3, 15.0)
    (place,) = places("extra_ticks", SHAPE)
    assert place.range == (0, 1023)
    (wall,) = places("wall_min[2]", Shape(3, 4, 0, 2), 2)
    assert wall.address == WORDS["wall_min"].at(2, 2)
    assert wall.value(0xFFFFFFFF) == -1
    with pytest.raises(HostError, match="this device has none"):
        places("shape_loss", SHAPE)


@pytest.mark.parametrize(
    "text",
    ["1e305", "-1e305", "nan", "inf", "1e19", str(10**400), str(-(10**400)), "0x" + "f" * 5000],
)
@pytest.mark.parametrize("name", ["root", "samples", "wall_min[0]"])
@pytest.mark.parametrize("is_raw", [False, True])
def test_numbers_that_no_word_has(text, name, is_raw):
    (place,) = places(name, SHAPE)
    with pytest.raises(HostError, match=r"is (out of range|no (whole )?number); it takes") as error:
        place.raw(number(text), is_raw=is_raw)
    assert "\n" not in str(error.value)


def test_an_index_that_is_no_number():
    for text in ("wall_min[²]", "wall_min[" + "9" * 5000 + "]"):
        with pytest.raises(HostError, match="there is no such word"):
            places(text, SHAPE)


def test_bits_that_the_rtl_has():
    """Faults and refusals by the files that make them; the options' places by their list."""
    assert FAULTS[10][0] == "BUS_LOW"
    assert FAULTS[16][0] == "ENERGY"
    assert sorted(FAULTS) == list(range(20))
    rtl = (RTL_DIR / "wh_arm.v").read_text(encoding="utf-8")
    width = re.search(r"output wire \[(\d+):0\] refused_o", rtl)[1]
    assert int(width) + 1 == len(ARM_REFUSALS)
    rtl = (RTL_DIR / "wh_linked_device.v").read_text(encoding="utf-8")
    listed = dict(re.findall(r"(?:\d+:)?(\d+) ([A-Z][A-Z_0-9]*)(?=   |\n)", rtl))
    for name, (low, _) in modbus.OPTIONS.items():
        assert listed[str(low)] == name.upper(), name


@pytest.mark.parametrize("text", ["nan", "inf"])
@pytest.mark.parametrize(
    "words",
    [
        ("arm", "--seconds"), ("capture", "--seconds"), ("capture", "--pre"), ("capture", "--k-t"),
        ("identify", "--counts", "4", "--travel"), ("identify", "--counts", "4", "--current"),
        ("watch", "root", "--every"), ("info", "--timeout"), ("scope", "--k-t"),
        ("--virtual", "press_hold", "--seconds"),
    ],
)  # fmt: skip
def test_options_that_are_no_numbers(words, text):
    """Before anything is opened, let alone armed."""
    with pytest.raises(typer.BadParameter) as error:
        board.app(["board", *words, text], standalone_mode=False)
    problem = error.value.format_message()
    assert re.search(r"is not a finite number|Input should be (less|greater) than", problem)


# ---- A brushless motor, whose axes have the places of two.


@pytest.fixture(scope="module")
def brushless_port() -> Iterator[str]:
    process = command("--virtual", "live_brushless", "--set", "hand.amplitude_rad=0.3")
    path = process.stdout.readline().strip()
    assert re.fullmatch(r"/dev/\S+", path), process.stderr.read()
    yield path
    assert stop(process) == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("get", "mode"), "mode: this device has none; its bitstream was made without"),
        (("get", "root", "--motor", "1"), "root: a brushless motor has one, for both axes; leave "
         "--motor 1 out"),
        (("get", "gain", "--motor", "2"), "gain: the device has no motor 2; take --motor 0...1"),
        (("identify", "--counts", "40000", "--motor", "1"), "eta_contact: a brushless motor .*"),
        (("set", "host_timeout=1"), "host_timeout: this device has none; .*"),
    ],
)  # fmt: skip
def test_what_a_brushless_board_refuses(brushless_port, words, message):
    assert re.fullmatch(message, refused(brushless_port, *words, "--timeout", "60"))


def test_a_brushless_board_over_the_line(brushless_port, tmp_path):
    """What it is; its settings through a file; armed, tapped, moved a wall, captured, stopped."""
    port = brushless_port
    shown = told(port, "info")
    assert "motors          1, brushless\n" in shown
    assert "shaper" not in shown
    assert value(port, "magnet_found") == 1
    shape = Shape(1, 4, 0, 10, table.THREE_PHASE_LEGS)
    count, file = len(settings(shape)), tmp_path / "all.toml"
    assert told(port, "save", str(file)) == f"{file}: {count} words\n"
    text = file.read_text()
    assert text.count("\ngain = ") == text.count("[motor.") == 2
    assert "wall_shaped" not in text
    told(port, "set", "a=0.25")
    assert told(port, "load", str(file)) == f"{file}: {count} words, of which 1 were others\n"

    process = command("arm", "--timeout", "60", env={"WH_PORT": port})
    try:
        assert process.stdout.readline() == "armed; Ctrl-C disarms\n"
        assert value(port, "running") == 1
        problem = refused(port, "set", "find_magnet=1", "--timeout", "60")
        assert problem.startswith("find_magnet: the device refuses with exception 6: not now")
        # A current of the wall's, in both axes as the magnets lie.
        for axis in ("0", "1"):
            read = ("watch", "--csv", "-n", "60", "--every", "0", "--motor", axis, "current")
            # A busy machine's board may come no further than free space in so many reads.
            tries = (told(port, *read).splitlines()[1:] for _ in range(TRIES))
            rows = itertools.chain.from_iterable(tries)
            assert any(abs(float(row.split(",")[1])) > 0.03 for row in rows)
        told(port, "set", "wall_min[0]=100000", "wall_max[0]=200000")
        time.sleep(0.5)
        assert value(port, "contact") == 0
        rows = told(port, "watch", "--csv", "-n", "30", "--every", "0", "current", "position")
        currents = [abs(float(line.split(",")[1])) for line in rows.splitlines()[1:]]
        assert max(currents) < 0.02
        assert value(port, "running") == 1
        told(port, "disarm")
    finally:
        process.kill()
        process.communicate()
    until(port, "running", 0)


def test_rows_of_a_brushless_board(brushless_port, tmp_path):
    """Both axes' words by their own names: none of them is the current that the torque is of."""
    names = ("current", "current@1", "position", "flags")
    for kind in ("capture", "stream"):
        told(brushless_port, kind, *names, "--seconds", "0.05", "--counts-per-rev", "40000",
             "--out", str(tmp_path))  # fmt: skip
        trace = load_trace(tmp_path)
        assert len(trace["t"]) > 20
        assert np.nanstd(trace["current"]) > 0.0
        assert np.nanstd(trace["current@1"]) > 0.0
        assert np.isfinite(trace["x"]).any()
        assert np.isnan(trace["i"]).all()
        assert np.isnan(trace["torque"]).all()


def test_the_scope_shows_a_brushless_motors_wall():
    """Led into the wall place by place: torque by both axes' currents, and the closed form's K."""
    path = find_scene("live_brushless")
    scene = load_scene(path)
    known = Known.of_scene(path, (), starts=True)
    feed = Feed(VirtualPlug(str(path), ()), known, unit=1, motor=0, timeout_s=60.0)
    feed.start()
    try:
        page = object()

        def wait(done: Callable[[], bool]) -> None:
            end = time.monotonic() + END_S
            while not done():
                assert time.monotonic() < end, feed.state()
                feed.beat(page)
                time.sleep(0.05)

        def elapse(device_s: float) -> list[dict[str, float]]:
            """Rows of the later half of so much of the device's time: eight are an ADC's noise."""
            rows: list[dict[str, float]] = []

            def passed() -> bool:
                rows.extend(feed.fresh())
                return bool(rows) and rows[-1]["t"] - rows[0]["t"] > device_s

            wait(passed)
            return [row for row in rows if row["t"] > rows[-1]["t"] - device_s / 2]

        wait(lambda: feed.state()["live"])
        feed.lead(-0.05)
        elapse(0.2)
        feed.arm(page).result(END_S)
        wait(lambda: feed.state()["running"])
        places, torques = [], []
        for place in (0.1, 0.2, 0.3):
            feed.lead(place)
            rows = elapse(0.8)
            places.append(np.mean([row["x"] for row in rows]))
            torques.append(-np.mean([row["torque"] for row in rows]))
            pushed = scene.hand.stiffness * (place - places[-1])
            # Some places of the ADC, of 0.5 mA, and as much that the anchors take for an offset.
            assert torques[-1] == pytest.approx(pushed, abs=scene.motor.k_t * 4e-3)
        slope = np.polyfit(places, torques, 1)[0]
        assert slope == pytest.approx(feed.state()["stiffness"], rel=0.025)
        feed.stop()
        wait(lambda: not feed.state()["armed"])
    finally:
        feed.end()


def test_a_brushless_scene_with_a_host_is_refused():
    scene = load_scene(find_scene("brushless_hold"), ["host.rate_hz=1000"])
    with pytest.raises(SceneError, match=r"\[host\] is not for a brushless motor"):
        LinkedBrushlessPins(scene)
