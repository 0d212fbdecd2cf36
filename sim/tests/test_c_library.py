# SPDX-License-Identifier: Apache-2.0
"""The C library on a line that is what it should be, and on one that isn't; its wall on the RTL.

All of it runs under the compiler's sanitizers, where there are some.
"""

from __future__ import annotations

import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from test_client import Board, sealed
from test_host_planes import CELL_RAD, MOTOR
from test_host_planes import Device as SurfaceDevice
from test_host_planes import frame as surface_frame
from wavehaptics.controller.planes import as_writes
from wavehaptics.host.client import Client
from wavehaptics.host.planes import Planes
from wavehaptics.host.virtual import VirtualBoard
from wavehaptics.ladder.linked_pins import LinkedPins
from wavehaptics.laws import closed_forms
from wavehaptics.laws.kinematics import PHANTOM, linked_arm
from wavehaptics.laws.shapes import Shape
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats, modbus, table
from wavehaptics.words.table import WORDS

SOURCES = ROOT / "sim" / "c"
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
SANITIZERS = ("-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
CC = shutil.which("cc") or shutil.which("gcc")
TIMEOUT_S = 0.15
FASTEST = 0.05
"""Seconds of a simulated board in one of real time, which the hosts' timeouts keep to."""
PATIENT_S = 60

pytestmark = pytest.mark.skipif(CC is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path], str]:
    """The path of a program of the library and one more file."""
    folder = tmp_path_factory.mktemp("c")
    empty = folder / "empty.c"
    empty.write_text("int main(void) { return 0; }\n")
    assert CC is not None
    found = subprocess.run([CC, *SANITIZERS, str(empty), "-o", str(folder / "empty")])
    flags = SANITIZERS if found.returncode == 0 else ()

    def build(source: Path) -> str:
        program = folder / source.stem
        if not program.exists():
            command = [CC, *STRICT, *flags, f"-I{SOURCES}", str(SOURCES / "wavehaptics.c")]
            subprocess.run([*command, str(source), "-o", str(program)], check=True)
        return str(program)

    return build


@pytest.fixture(scope="module")
def wall(built) -> str:
    return built(SOURCES / "wall.c")


class Session:
    """The library's calls, one after another, in a process of its own."""

    def __init__(self, program: str) -> None:
        self.process = subprocess.Popen(
            [program], text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )  # fmt: skip

    def call(self, *words: object) -> tuple[int, str]:
        """The result and what is told; a crash is told by the sanitizer."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        assert self.process.stderr is not None
        self.process.stdin.write(" ".join(map(str, words)) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        assert line, self.process.stderr.read()
        result, _, told = line.partition(" ")
        return int(result), told.strip()

    def get(self, *words: object) -> str:
        """What is told, of a call that works."""
        result, told = self.call(*words)
        assert result == 0, told
        return told

    def close(self) -> str:
        """Ended, with what a sanitizer says of it."""
        return self.process.communicate("end\n", timeout=PATIENT_S)[1]


@pytest.fixture
def session(built) -> Iterator[Session]:
    found = Session(built(Path(__file__).with_name("c_session.c")))
    yield found
    assert found.close() == ""
    assert found.process.returncode == 0


@pytest.fixture
def board() -> Iterator[Board]:
    found = Board()
    options = 1 | 4 << 4 | 2 << 11 | 1 << 21 | 1 << 27
    found.put(2 * modbus.IDENTIFICATION.index("options"), [options])
    for name, raw in (("root", 2 << 22), ("half_clocks", 750), ("tick_halves", 2)):
        found.put(modbus.word_register(WORDS[name].at()), [raw])
    found.put(modbus.word_register(WORDS["host_period_log2"].at()), [5, 20])
    found.start()
    yield found
    found.close()


def opened(session: Session, board: Board, baud: int = 115200) -> None:
    session.get("open", board.path, 1, baud, TIMEOUT_S)


def put(board: Board, name: str, *raws: int) -> None:
    board.put(modbus.word_register(WORDS[name].at()), [raw & 0xFFFFFFFF for raw in raws])


# ---- Surfaces.


@pytest.mark.parametrize("count", [0, 1, 2, 4, 8])
def test_planes_go_as_pythons_do(session, board, count):
    """The same frames on the line as the package's own; a refusal says which row."""
    opened(session, board)
    registers = surface_frame(np.random.default_rng(count), count)
    words = " ".join(f"{address}={word}" for address, word in registers)
    put(board, "surfaces", 8, 1, 0, 0, 777)
    board.asked.clear()
    assert session.get("planes", 777, words) == "8 1 0 0 777"
    wanted = as_writes(registers, 777)
    found = [frame for frame in board.asked if frame[1] == 16]
    assert len(found) == len(wanted)
    for frame, (first, raws) in zip(found, wanted, strict=True):
        register, number = struct.unpack(">HH", frame[2:6])
        assert register == modbus.word_register(first)
        assert list(struct.unpack(f">{number}H", frame[7:-2])) == modbus.halves(raws)
    put(board, "surfaces", 8, 1, 0, 128 + 3, 776)
    told = "planes: the device refuses row 3; what it had before is in force"
    assert session.call("planes", 777, words) == (-4, told)
    told = "stamp = 65536: it has 16 bits; give 0...65535"
    assert session.call("planes", 65536, words) == (-5, told)


@pytest.mark.parametrize(("count", "damped"), [(0, 0), (1, 0), (1, 1), (3, 0), (3, 2), (8, 5)])
def test_planes_in_metres_are_pythons(session, count, damped):
    """The frame of the package's own host, to the last place of each word, and its force."""
    device, rng = SurfaceDevice(), np.random.default_rng(count)
    arm = linked_arm(PHANTOM, (0.14, 0.14), (8.0,) * 3, (0.1, 0.2, -0.1))
    device.start()
    try:
        client = Client(device.path, timeout_s=1.0)
        made = Planes(client, [MOTOR] * 3, arm)
        tip, angles, force = made.tip(), made.angles(), made.tip_force()
        jacobian = arm.jacobian(angles)
        normals = rng.normal(size=(count, 3))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        distances = rng.uniform(-0.01, 0.01, count)
        hard, lost = rng.uniform(100, 20_000, count), rng.uniform(0, 1, count)
        # Of a damped one by 0.1 N·s/m the ports' delay would take more than there is.
        damping = np.where(np.arange(count) < damped, np.resize([30.0, 0.1], count), 0.0)
        hard[damped : damped + 1] = 0.0
        shapes = [Shape("plane", tip - d * n, n) for d, n in zip(distances, normals, strict=True)]
        made.set_shapes(shapes, [one or None for one in hard], lost.tolist(), damping.tolist())
        client.write([("surface_budget", 0)])
        session.get("open", device.path, 1, 115200, 1.0)
        motor = (MOTOR.k_t, MOTOR.inductance, MOTOR.counts_per_rev)
        turned = session.get("space", 3, 0.1, *motor)
        assert np.array(turned.split(), float) == pytest.approx(angles, rel=1e-9)
        assert angles[0] == pytest.approx(1000.5 * CELL_RAD)
        planes = np.column_stack([3.0 * normals, distances, hard, lost, damping])
        numbers = [repr(float(one)) for one in (*jacobian.ravel(), *planes.ravel())]
        found = session.get("solid", 9, *numbers)
        assert np.array(found.split(), float) == pytest.approx(force, rel=1e-6)
        (pythons, _), (cs, stamp) = device.frames
        assert stamp == 9
        assert list(cs) == list(pythons)
        for address, raw in cs.items():
            place = 1 << (5 if address >= 768 and address % 16 in (5, 6, 7, 8) else 0)
            place = 1 << 3 if address < 768 and address % 8 > 2 else place
            assert abs(raw - pythons[address]) <= place, address
        words = modbus.word_register(WORDS["surface_budget"].at())
        budget = [device.registers[words + n] for n in (0, 1)]
        assert modbus.whole(budget) == [round(1e-3 / (416 / 48e6) * 2**16)]
        if count == 3:
            flat = [repr(float(one)) for one in (*(0.0 * jacobian).ravel(), *planes[:1].ravel())]
            told = "plane 0: no motor moves the tip along its normal; leave it out or move the arm"
            assert session.call("solid", 10, *flat) == (-5, told)
            flat = [*flat[:-3], "0", "0", "5"]  # stiffness, loss, damping
            told = "plane 0: damping has to be 0, or above that with a stiffness"
            assert session.call("solid", 10, *flat) == (-5, told)
            told = "4 motors: planes lie across 2 or 3"
            assert session.call("space", 4, 0.1, *motor) == (-5, told)
    finally:
        device.close()


# ---- Words.


def test_every_word_is_read_in_its_unit(session, board):
    """At both ends of its range, by its constant; the values are those of the table."""
    opened(session, board)
    rng = random.Random(1)
    for word in WORDS.values():
        if word.row.kind == "command":
            result, told = session.call("get", word.name.upper(), 0, 0)
            assert (result, told) == (-5, f"{word.name} can't be read; it is a command")
            continue
        if word.row.per == "section":
            continue  # this board has none
        fixed = word.fixed
        for raw in (fixed.raw_min, fixed.raw_max, rng.randint(fixed.raw_min, fixed.raw_max)):
            put(board, word.name, raw)
            told = session.get("get", word.name.upper(), 0, 0)
            assert float(told) == pytest.approx(fixed.to_value(raw), rel=1e-11), word.name


def test_every_setting_is_written_as_the_table_has_it(session, board):
    opened(session, board)
    rng = random.Random(2)
    for word in WORDS.values():
        if word.row.kind != "setting" or word.row.per == "section":
            continue
        low, high = word.range
        for value in (low, high, word.fixed.to_value(rng.randint(*(
            word.fixed.to_raw(bound) for bound in (low, high)
        )))):  # fmt: skip
            session.get("set", word.name.upper(), 0, 0, repr(value))
            register = modbus.word_register(word.at())
            raw = board.registers[register] << 16 | board.registers[register + 1]
            assert raw == word.fixed.to_raw(value) & 0xFFFFFFFF, (word.name, value)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("set", "ROOT", 0, 0, 99), "root = 99 is out of range; it takes 0...15.9999998 √Ω"),
        (("set", "ROOT", 0, 0, "nan"), "root = nan is out of range"),
        (("set", "ROOT", 0, 0, "-inf"), "root = -inf is out of range"),
        (("set", "SAMPLES", 0, 0, 2.5), "samples = 2.5 is no whole number; it takes 1...256"),
        (("set", "EXTRA_TICKS", 0, 0, 4), "extra_ticks = 4 is out of range; it takes 0...3 ticks"),
        (("set", "POSITION", 0, 0, 1), "position can't be set; it is what the device tells"),
        (("set", "COMMIT", 0, 0, 1), "commit can't be set; the link gives"),
        (("get", "WALL_MIN", 0, 4), "wall_min: the device has 4, and no index 4"),
        (("get", "SHAPE_LOSS", 0, 0), "shape_loss: the device has 0, and no index 0"),
        (("get", "ROOT", 1, 0), "root: the device has no motor 1"),
        (("get", "NONE", 0, 0), "there is no word"),
        (("port", 0, 0, 10000), "a motor needs k_t above 0"),
        (("exchange", 0), "there is no packet to be answered"),
    ],
)
def test_what_no_word_is_asked_for(session, board, words, message):
    opened(session, board)
    session.get("port", 0, 0.06, 10000)
    result, told = session.call(*words)
    assert result == -5
    assert told.startswith(message)


# ---- Opening.


def one_line(session: Session, *words: object) -> str:
    result, told = session.call("open", *words)
    assert result < 0
    assert len(told) < 250
    return told


def test_ports_that_are_none(session, tmp_path):
    told = one_line(session, tmp_path / "none")
    assert told == (
        f"{tmp_path / 'none'}: can't be opened: No such file or directory; is it plugged in? Else "
        "name the device's port"
    )
    (tmp_path / "file").write_text("")
    assert "is no serial line" in one_line(session, tmp_path / "file")
    assert "can't be opened" in one_line(session, tmp_path)
    assert one_line(session, "x", 300) == "unit 300: there are units 1...247"
    result, told = session.call("get", "ROOT", 0, 0)
    assert (result, told) == (-5, "root: the device has no motor 0")
    result, told = session.call("arm")
    assert (result, told) == (-1, "x: is closed")


def test_a_port_that_somebody_has(built, session, board):
    opened(session, board)
    other = Session(built(Path(__file__).with_name("c_session.c")))
    assert other.call("open", board.path)[1].endswith(
        "can't be opened: somebody else has it; end that program, or name another port"
    )
    session.get("close")
    assert other.call("open", board.path, 1, 115200, TIMEOUT_S)[0] == 0
    assert other.close() == ""


def test_a_device_that_is_silent(session):
    master, slave = os.openpty()
    tty.setraw(slave)
    path = os.ttyname(slave)
    told = one_line(session, path, 7, 0, 0.05)
    assert told.startswith(f"{path}: no answer within 0.05 s; is it the right port")
    assert "unit 7" in told
    os.close(slave)
    os.close(master)


def test_a_line_at_another_rate(session):
    """Bytes that are no answer: at another rate than the device's each is broken."""
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    path, rng = os.ttyname(slave), random.Random(3)
    ended = threading.Event()

    def babble() -> None:
        while not ended.wait(0.02):
            with suppress(BlockingIOError):
                if os.read(master, 100):
                    os.write(master, rng.randbytes(9))

    thread = threading.Thread(target=babble)
    thread.start()
    told = one_line(session, path, 1, 0, 0.1)
    ended.set()
    thread.join()
    assert re.search(r": \d+ bytes came, but no answer with a right CRC; is it unit 1, at 1", told)
    os.close(slave)
    os.close(master)


def test_rates_that_a_device_has_not(session, board):
    told = one_line(session, board.path, 1, 460800, TIMEOUT_S)
    assert "no 460800 bits a second; take 115200, 1000000, 1500000 or 3000000" in told
    board.put(2 * modbus.IDENTIFICATION.index("rates"), [2])
    told = one_line(session, board.path, 1, 3000000, TIMEOUT_S)
    assert told.endswith("the device's clock is too slow for 3000000 bits a second; take 1000000")
    session.get("open", board.path, 1, 0, TIMEOUT_S)
    assert board.registers[2 * modbus.IDENTIFICATION.index("rate") + 1] == 1
    session.get("close")
    assert board.registers[2 * modbus.IDENTIFICATION.index("rate") + 1] == 0


def test_another_table_of_words(session, board):
    board.put(0, [table.crc() ^ 1])
    told = one_line(session, board.path, 1, 115200, TIMEOUT_S)
    assert f"another table of words, CRC {table.crc() ^ 1:08x} and not {table.crc():08x}" in told
    board.put(0, [table.crc()])
    board.put(2 * modbus.IDENTIFICATION.index("version"), [9])
    told = one_line(session, board.path, 1, 115200, TIMEOUT_S)
    assert "map of registers is of version 9, not 1" in told


def test_a_device_without_a_host(session, board):
    board.put(2 * modbus.IDENTIFICATION.index("options"), [1 | 4 << 4])
    opened(session, board)
    session.get("port", 0, 0.06, 10000)
    for call in ("next", "exchange 0"):
        result, told = session.call(call)
        assert result == -3
        assert "has no link to a host; take a bitstream with HOST = 1" in told


def test_a_port_that_is_pulled(session, board):
    opened(session, board)
    board.gone()
    result, told = session.call("get", "ROOT", 0, 0)
    assert result == -1
    assert told.endswith("was it unplugged?")


@pytest.mark.parametrize(("question", "baud"), [(1, 0), (2, 0), (3, 0), (3, 3_000_000)])
def test_a_port_that_is_pulled_while_it_is_opened(session, board, question, baud):
    """At the write of the rate, and at the questions behind it: the first error is reported."""
    asked: list[bytes] = []

    def pulled_by(frame: bytes) -> bool:
        rate = 2 * modbus.IDENTIFICATION.index("rate")
        if asked or (frame[1] == 16 and frame[2:4] == rate.to_bytes(2, "big")):
            asked.append(frame)
        if len(asked) == 2 and question == 3:
            board.instead = [None]
        return len(asked) == question

    board.pulled_by = pulled_by
    result, told = session.call("open", board.path, 1, baud, TIMEOUT_S)
    if question == 3:
        assert (result, told[: told.find(" within")]) == (-2, f"{board.path}: no answer")
    else:
        assert (result, told[-len("was it unplugged?") :]) == (-1, "was it unplugged?")
        assert told.startswith(f"{board.path}: ")


def test_a_wall_whose_port_is_pulled(wall, board):
    """What was served is told, then the error, and the status is 2."""
    put(board, "armed", 1, 0)
    put(board, "running", 1)
    numbers = iter(range(10**6))

    def pulled_by(frame: bytes) -> bool:
        number = next(numbers)
        put(board, "host_packet_sequence", number & 0xFF, 0, 1)
        return number == 300

    board.pulled_by = pulled_by
    host = subprocess.run(
        [wall, board.path, "-t", "1", "-x", "100"], capture_output=True, text=True,
        timeout=PATIENT_S,
    )  # fmt: skip
    assert host.returncode == 2
    assert re.fullmatch(rf"wall: {board.path}: [^\n]*; was it unplugged\?\n", host.stderr)
    assert int(re.match(r"(\d+) packets, \d+ missed, ", host.stdout)[1]) > 50


# ---- Answers.


def test_answers_fit_their_questions(session, board):
    """Late ones, those to other questions, broken ones: the next question gets its own, or none."""
    opened(session, board)
    put(board, "root", 1 << 22)
    put(board, "a", 1 << 24)
    right = {"ROOT": "1", "A": "0.5"}
    others = [sealed(b"\1\3\4\0\0\0\1"), sealed(b"\1\x90\2"), sealed(b"\2\3\4\0\0\0\0"), b"\1\3"]
    for wrong in (None, *others, sealed(b"\1\3\2\0\0"), b"\xff" * 200):
        board.instead = [wrong]
        for name in ("ROOT", "A", "ROOT"):
            result, told = session.call("get", name, 0, 0)
            # An answer to another read of as many words can't be told from the right one.
            if not (wrong == others[0] and told == "2.38418579102e-07"):
                assert (result, told) in ((0, right[name]), (-2, told)), wrong
    for late in (1.5, 2.5):
        board.late = [late * TIMEOUT_S]
        found = [(name, *session.call("get", name, 0, 0)) for name in ("ROOT", "A") * 3]
        assert all(told == right[name] or result == -2 for name, result, told in found)
        assert sum(result == 0 for _, result, _ in found) >= 5


def test_refusals_are_told(session, board):
    opened(session, board)
    board.instead = [sealed(b"\1\x90\6")]
    result, told = session.call("set", "SAMPLES", 0, 0, 4)
    assert result == -4
    assert told.startswith("samples: the device refuses with exception 6: not now")
    board.instead = [sealed(b"\1\x83\x63")]
    assert session.call("get", "ROOT", 0, 0)[1].endswith("exception 99: unknown")


def test_arming_says_why_not(session, board):
    opened(session, board)
    put(board, "armed", 0, 2)
    put(board, "faults", 1 | 1 << 9)
    result, told = session.call("arm")
    assert result == -6
    assert told.endswith(
        "can't be armed: there is a fault: a sample beyond the limit, emergency stop"
    )
    assert session.get("faults") == "a sample beyond the limit, emergency stop"
    put(board, "armed", 1, 0)
    session.get("arm")
    session.get("renew")
    assert [frame[1] for frame in board.asked[-2:]] == [16, 16]
    result, told = session.call("disarm")
    assert result == -4
    assert "switch" in told
    before = len(board.asked)
    session.get("stop")
    time.sleep(0.1)
    off = modbus.word_register(WORDS["arm"].at()).to_bytes(2, "big") + b"\0\2\4\0\0\0\0"
    assert [frame[2:-2] for frame in board.asked[before:]] == [off] * 2


def test_what_a_port_knows(session, board):
    """s, b and the period of the words; ω and x of the state."""
    opened(session, board)
    s, b, period, timeout = map(float, session.get("port", 0, 0.06, 10000).split())
    assert s == 2.0
    assert b == pytest.approx(0.06**2 / closed_forms_r(s))
    assert period == pytest.approx(32 * 1500 / 48e6)
    assert timeout == 20
    put(board, "voltage", 0, 1 << 22, 1 << 21, 1 << 24, -3, 1, 0)
    put(board, "contact_energy", formats.ENERGY.to_raw(-5.25))
    count, x, omega, torque, contact, energy = map(float, session.get("state").split())
    assert (count, contact) == (-3, 1)
    assert x == pytest.approx(-2.5 * 2 * np.pi / 10000)
    assert omega == pytest.approx(s * (0.5 + 0.25) / (2 * 0.06))
    assert torque == pytest.approx(0.06)
    assert energy == pytest.approx(-5.25 * 0.06 * 2 * np.pi / 10000)


def closed_forms_r(s: float) -> float:
    return s * s / 2


def test_an_exchange_is_one_piece(session, board):
    """The answer in one frame of three words, with the number of the packet that it is to."""
    opened(session, board)
    session.get("port", 0, 0.06, 10000)
    put(board, "host_packet_sequence", 255, formats.WAVE.to_raw(0.25), 0)
    threading.Timer(
        0.3, put, (board, "host_packet_sequence", 1, formats.WAVE.to_raw(-0.5), 1)
    ).start()
    put(board, "armed", 1, 0)
    session.get("set", "HOST_ALIVE", 0, 0, 1)
    result, told = session.call("next")
    while result:
        assert "no new packet" in told
        result, told = session.call("next")
    assert told == "1 2 -0.5 1"
    threading.Timer(0.1, put, (board, "host_packet_sequence", 2, 0, 1)).start()
    before = len(board.asked)
    assert session.get("exchange", -0.125) == "2 1 0 1"
    writes = [frame for frame in board.asked[before:] if frame[1] == 16]
    register = modbus.word_register(WORDS["host_answer_sequence"].at())
    body = b"".join(raw.to_bytes(4, "big") for raw in (1, -(1 << 20) & 0xFFFFFFFF, 1))
    assert writes[-1][2:-2] == register.to_bytes(2, "big") + b"\0\6\x0c" + body
    assert session.call("exchange", 128)[1].startswith("host_u = 128 is out of range")


def spoiled(rng: random.Random, right: bytes) -> bytes:
    """An answer as a bad line makes it: other bytes, flipped, cut, doubled, or with some before."""
    kind = rng.randrange(6)
    if kind == 0:
        return rng.randbytes(rng.randint(1, 600))
    if kind == 1:
        at = rng.randrange(len(right))
        return right[:at] + bytes([right[at] ^ 1 << rng.randrange(8)]) + right[at + 1 :]
    if kind == 2:
        return right[: rng.randrange(len(right))] or b"\1"
    if kind == 3:
        return right + right
    if kind == 4:
        return rng.randbytes(rng.randint(1, 5)) + right
    # A right CRC over what no device says.
    return sealed(
        bytes([1, rng.choice((3, 16, 0x83, 0x90, 4)), *rng.randbytes(rng.randint(1, 250))])
    )


def test_random_bytes_never_crash_it_and_are_never_believed(session, board, monkeypatch):
    """Of each kind at random: the value is right or there is none, in one line."""
    opened(session, board)
    session.get("port", 0, 0.06, 10000)
    seed = 11
    rng = random.Random(seed)
    put(board, "root", 3 << 21)
    put(board, "a", 1 << 24)
    put(board, "armed", 1, 0)
    right = {"ROOT": (5, (3 << 21).to_bytes(4, "big"), "1.5"),
             "A": (5, (1 << 24).to_bytes(4, "big"), "0.5")}  # fmt: skip
    answered = 0
    for n in range(70):
        name = rng.choice(list(right))
        answer = sealed(b"\1\3\4" + right[name][1])
        # The first answer, and often those to what settles the line.
        board.instead = [spoiled(rng, answer) for _ in range(rng.choice((1, 1, 2, 3)))]
        if n % 7 == 6:
            result, told = session.call(rng.choice(("arm", "faults", "next", "state", "renew")))
        else:
            result, told = session.call("get", name, 0, 0)
            answered += result == 0
            assert result != 0 or told == right[name][2], (seed, n, told)
        assert len(told) < 250, (seed, n)
        board.instead = []
    assert answered > 25
    assert session.get("get", "ROOT", 0, 0) == "1.5"


# ---- The wall, on the RTL.


class Traced(LinkedPins):
    """The device, with all its ticks kept."""

    def __init__(self, scene) -> None:
        self.past: list[tuple[np.ndarray, np.ndarray, bool]] = []
        super().__init__(scene)

    def advance(self, rows, words) -> None:
        super().advance(rows, words)
        self.past.append((rows.copy(), words.copy(), self.running))

    @property
    def ticks(self) -> int:
        """Ticks so far."""
        return sum(len(rows) for rows, _, _ in self.past)

    def latest(self, ticks: int) -> np.ndarray:
        """Words of the last ticks, so many or some more."""
        found: list[np.ndarray] = []
        for _, words, _ in reversed(self.past):
            found.insert(0, words)
            if sum(map(len, found)) >= ticks:
                break
        return np.concatenate(found)

    def on(self) -> tuple[np.ndarray, np.ndarray, int]:
        """Rows and words of the ticks with the bridges on, and how many were before."""
        first = next(n for n, kept in enumerate(self.past) if kept[2])
        last = max(n for n, kept in enumerate(self.past) if kept[2])
        part = self.past[first : last + 1]
        before = sum(len(rows) for rows, _, _ in self.past[:first])
        return (np.concatenate([rows for rows, _, _ in part]),
                np.concatenate([words for _, words, _ in part]), before)  # fmt: skip


class BadLine(threading.Thread):
    """A pseudo-terminal before another one, whose pieces come late, broken or never."""

    def __init__(self, path: str, seed: int, late_s: float, loss: float, broken: float) -> None:
        super().__init__(daemon=True)
        self._far = os.open(path, os.O_RDWR | os.O_NOCTTY)
        self._near, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        self._random = random.Random(seed)
        self._late_s, self._loss, self._broken = late_s, loss, broken
        self.lost = self.spoiled = 0
        self.ended = False

    def run(self) -> None:
        import select

        while not self.ended:
            for file in select.select([self._near, self._far], [], [], 0.05)[0]:
                with suppress(OSError):
                    data = os.read(file, 4096)
                    self._pass(data, self._far if file == self._near else self._near)

    def _pass(self, data: bytes, to: int) -> None:
        rng = self._random
        time.sleep(rng.random() * self._late_s)
        if not data:  # it was flushed meanwhile
            return
        if rng.random() < self._loss:
            self.lost += 1
            return
        if rng.random() < self._broken:
            self.spoiled += 1
            at = rng.randrange(len(data))
            data = data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :]
        os.write(to, data)

    def close(self) -> None:
        self.ended = True
        self.join()
        for file in (self._near, self._slave, self._far):
            os.close(file)


class Bench:
    """The device of a scene with its line, and programs at it."""

    def __init__(self, *settings: str) -> None:
        self.scene = load_scene(find_scene("hosted_wall"), settings)
        self.pins = Traced(self.scene)
        self.pins.elapse(1)
        self.board = VirtualBoard(self.pins)

    def __enter__(self) -> Bench:
        self.board.__enter__()
        return self

    def __exit__(self, *what) -> None:
        self.board.__exit__(*what)

    def run(self, ended: Callable[[], bool], seconds: float = 20.0) -> None:
        first = self.pins.time_s
        # Else a fast machine's board is off before a host, which waits half a second, asks again.
        self.board.run(ended, seconds, fastest=FASTEST)
        assert self.pins.time_s - first < seconds, "the host never ended"

    @property
    def period_ticks(self) -> int:
        return 32


def energy_given_out(rows: np.ndarray) -> float:
    """The most that the port has given out net since the bridges came on, J.

    It is ∫ e i dt of the plant's own voltage and current, with no word of the device in it.
    """
    return float(np.cumsum(rows[:, Column.ENERGY_OUT]).max())


def missed(words: np.ndarray, scene, settings) -> np.ndarray:
    """How far u is from what the port's own law makes of v, each tick, √W.

    f += a (η v − f), u 1 + k ticks later: in floats, with nothing of the controller's own models.
    """
    a = WORDS["a"].fixed.to_value(settings.a)
    v, u = words[:, Word.V] * formats.WAVE.step, words[:, Word.U] * formats.WAVE.step
    late = 1 + settings.extra_ticks
    eta = scene.controller.eta_free
    # One step each from the u that there was: nothing from before is left in it.
    predicted = u[late - 1 : -1] + a * (eta * v[: len(v) - late] - u[late - 1 : -1])
    return np.abs(u[late:] - predicted)


@pytest.mark.long
def test_the_wall_of_a_computer(wall):
    """Taps on a spring of 0.5 N·m/rad: passive, and as stiff as its delays let it.

    What stands before the spring is what one to five periods of delay make of the motor:
    K = k_T²/(L + R τ/2).
    """
    with Bench() as bench:
        host = subprocess.Popen(
            [wall, bench.board.path, "-x", "0.1", "-t", "5"],
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        bench.run(lambda: host.poll() is not None or bench.pins.time_s > 0.8)
        host.send_signal(signal.SIGINT)
        bench.run(lambda: host.poll() is not None)
        out, err = host.communicate()
        assert not bench.pins.running
    assert (host.returncode, err) == (0, "")
    packets, lost = map(int, re.match(r"(\d+) packets, (\d+) missed", out).groups())
    assert packets > 500
    assert lost < 0.3 * packets
    rows, _, _ = bench.pins.on()
    assert energy_given_out(rows) <= 1e-8
    motor, period_s = bench.scene.motor, bench.period_ticks * bench.pins.tick_s
    # The second contact: in the first one the budget has yet to fill.
    pressed = rows[len(rows) // 2 :]
    deepest = pressed[np.argmax(pressed[:, Column.X])]
    assert deepest[Column.X] > 0.03
    soft, stiff = (
        1 / (1 / 0.5 + 1 / closed_forms.stiffness(motor.k_t, motor.L_h, motor.R_ohm, n * period_s))
        for n in (5, 1)
    )
    assert soft < -deepest[Column.TORQUE] / deepest[Column.X] < stiff
    free = rows[rows[:, Column.X] < -0.02]
    assert np.sqrt(np.mean(free[-3000:, Column.TORQUE] ** 2)) < 1e-3


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_a_bad_line_and_a_killed_host(wall, seed):
    """Pieces late, lost and broken: passive. Killed: its own η again, and then no torque at all."""
    with Bench() as bench:
        line = BadLine(bench.board.path, seed, late_s=4e-3, loss=0.02, broken=0.01)
        line.start()
        host = subprocess.Popen(
            [wall, line.path, "-x", "0.1", "-t", "0.5"],
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        armed = []

        def enough() -> bool:
            if bench.pins.running and not armed:
                armed.append(bench.pins.time_s)
            # In the wall, with the host in force.
            return host.poll() is not None or bool(
                armed and bench.pins.time_s > armed[0] + 0.45 and in_force(bench)
            )

        bench.run(enough)
        assert host.poll() is None, host.communicate()
        host.send_signal(signal.SIGKILL)
        host.wait()
        killed = bench.pins.ticks
        bench.run(lambda: not bench.pins.running, 1.0)
        off = bench.pins.ticks
        line.close()
    assert line.lost + line.spoiled > 3, seed
    rows, words, before = bench.pins.on()
    assert energy_given_out(rows) <= 1e-8
    wrong = missed(words, bench.scene, bench.pins.settings)
    own = np.flatnonzero(wrong > 1e-5)[-1] + 1 + before - killed
    # What was under way counts for a period more, or two.
    assert own / bench.period_ticks < bench.scene.host.timeout + 3
    assert own > 0  # it was in force
    assert (off - killed) * bench.pins.tick_s < 0.2 + 0.02


def in_force(bench: Bench) -> bool:
    """Whether the last tick wasn't the port's own."""
    last = bench.pins.latest(bench.period_ticks)
    return bool(missed(last, bench.scene, bench.pins.settings)[-1] > 1e-4)


@pytest.mark.long
def test_a_host_that_steals_gets_what_went_in(built):
    """The largest wave each time, with the sign that helps the motion."""
    with Bench("hand.path=sine") as bench:
        session = Session(built(Path(__file__).with_name("c_session.c")))
        calls = [("open", bench.board.path, 1, 0, 5), ("port", 0, 0.0603, 10000), ("arm",),
                 ("steal", 300), ("disarm",)]  # fmt: skip
        told: list[str] = []
        thread = threading.Thread(target=lambda: told.extend(session.get(*c) for c in calls))
        thread.start()
        bench.run(lambda: not thread.is_alive())
        assert len(told) == len(calls)
        assert session.close() == ""
    rows, words, _ = bench.pins.on()
    assert energy_given_out(rows) <= 1e-8
    u, v = (words[:, word].astype(float) for word in (Word.U, Word.V))
    assert np.sum(u**2) > 0.3 * np.sum(v**2)


PYTHON_HOST = """
import sys
from wavehaptics.host.client import Client
from wavehaptics.host.port import HostPort
from wavehaptics.ladder.hosted import PowerEnvironment

client = Client(sys.argv[1], timeout_s=30)
with client.hurry():
    port = HostPort(client, 60.3e-3)
    wall = PowerEnvironment(0.3, 1e-3, port.k_t, 0.5 * port.s**2, port.period_s)
    port.arm()
    count = []
    done = port.serve(wall, lambda: len(count) == 60 or count.append(1))
    packet = port.exchange(0.0)
    port.disarm()
    print(done, port.s, port.b, port.period_s, port.timeout, packet.active)
"""


def test_the_same_in_python():
    with Bench("host.timeout=200") as bench:
        host = subprocess.Popen(
            [sys.executable, "-c", PYTHON_HOST, bench.board.path],
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        bench.run(lambda: host.poll() is not None, 60.0)
        out, err = host.communicate()
    assert (host.returncode, err) == (0, "")
    done, s, b, period_s, timeout, active = out.split()
    motor = bench.scene.motor
    assert (done, timeout, active) == ("60", "200", "True")
    assert float(s) == pytest.approx(closed_forms.root(motor.R_ohm), rel=1e-6)
    assert float(b) == pytest.approx(closed_forms.b_r(motor.k_t, motor.R_ohm), rel=1e-3)
    assert float(period_s) == pytest.approx(1e-3)
    rows, _, _ = bench.pins.on()
    assert energy_given_out(rows) <= 1e-8
