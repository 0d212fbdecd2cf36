# SPDX-License-Identifier: Apache-2.0
"""Millions of bytes into the link of rtl/wh_linked_device.v, most of them nonsense.

Bursts of a kind, each followed by silence and a question for the counters:

- random bytes, alone or behind the beginning of a frame;
- every beginning of every kind of frame; every one of its bits flipped;
- frames with bytes dropped, doubled, or exchanged, with pauses between, at rates up to 8 % off;
- frames glued together; edges at any time; more questions than can be answered.

What the UART makes of the line goes through :mod:`wavetools.checks.link_model`, which says what
is to be written and answered. Of each burst is watched that

- what was written on the bus is just that, word for word and in turn;
- what was answered is just that, the question behind the silence and its counters among it;
- bytes that were sent at the right rate, 2 % off or less, were all received;
- the bridges' gates and ``running_o`` stayed low, and each byte of an answer had its stop bit;

and now and then that every setting reads as the model has it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from wavehaptics.ladder import verilated
from wavehaptics.studies.report.runs import STORE
from wavehaptics.studies.sweeps import Task
from wavehaptics.words.places import Place
from wavehaptics.words.table import WORDS, Sizes

from wavetools.checks.link_model import COMMIT, RATE, Slave, Undecided, crc, identity

TASK_BYTES = 500_000
WHOLE_BYTES = 100_000_000
"""What `make soak-link` asks for."""

__all__ = ["STORE", "Task", "soak", "summary", "tasks"]

CLOCK_HZ, SILENCE, FALLBACK, BUILD, UNIT = 18_000_000, 3000, 511, 0x20261122, 1
"""The slowest clock with all rates, at which a bit of the fastest takes 6 clocks; a silence
longer than the 2,200 that the memory is busy for with what it is given."""
RATES = (115_200, 1_000_000, 1_500_000, 3_000_000)
FASTEST = 3
SIZES = Sizes(motors=1, walls=4, sections=0, delay_log2=2)
DESIGN = verilated.Design(
    "wh_linked_device", "link_shim.cpp",
    {"CLOCK_HZ": CLOCK_HZ, "SILENCE": SILENCE, "FALLBACK": FALLBACK, "BUILD": BUILD,
     "UNIT": UNIT, "WALLS": 4, "DELAY_LOG2": 2},
    ("link_shim.vlt",),
)  # fmt: skip
OPTIONS = SIZES.motors | SIZES.walls << 4 | SIZES.delay_log2 << 11 | 7 << 18 | 5 << 25

BYTE_BITS = 10
_REST = 2 * SILENCE + 400
_GIVES_UP = 60
_RECEIVED, _WRITTEN, _ANSWERED = range(3)
_WRONG = ((1, "a gate was on"), (2, "the bridges were on"), (4, "an answer lacked a stop bit"))
_QUESTION = bytes([UNIT, 3, 0, 16, 0, 8])
_FLOOD = 80


@dataclass
class Burst:
    """What goes out on the line: bytes with pauses, or edges."""

    data: bytes = b""
    pauses: list[int] = field(default_factory=list)
    factor: float = 1.0
    edges: list[int] = field(default_factory=list)


def framed(body: bytes) -> bytes:
    return body + crc(body)


def read(register: int, count: int, function: int = 3, unit: int = UNIT) -> bytes:
    head = bytes([unit, function])
    return framed(head + register.to_bytes(2, "big") + count.to_bytes(2, "big"))


def write_one(register: int, value: int, unit: int = UNIT) -> bytes:
    return framed(bytes([unit, 6]) + register.to_bytes(2, "big") + value.to_bytes(2, "big"))


def write(register: int, values: list[int], unit: int = UNIT) -> bytes:
    body = bytes([unit, 16]) + register.to_bytes(2, "big") + (2 * len(values)).to_bytes(2, "big")
    return framed(body + bytes([4 * len(values)]) + b"".join(v.to_bytes(4, "big") for v in values))


class Failure(Exception):
    """What went wrong, in a line."""


class Line:
    """The device at its line, beside what has to come of it."""

    def __init__(self) -> None:
        self.library = verilated.load(DESIGN)
        self.library.wh_link_new.restype = ctypes.c_void_p
        self.library.wh_link_clocks.restype = ctypes.c_int64
        self.library.wh_link_wrong.restype = ctypes.c_int64
        self.library.wh_link_count.restype = ctypes.c_int64
        verilated.declare_destructor(self.library.wh_link_delete)
        self.model = ctypes.c_void_p(self.library.wh_link_new())
        self.slave = Slave(
            SIZES, identity(SIZES, OPTIONS, BUILD, CLOCK_HZ, len(RATES)), UNIT, SILENCE
        )
        self.bytes = self.bursts = 0
        self.to_rate(0)
        self.wait(3 * SILENCE)
        self.go(Burst(write_one(RATE + 1, FASTEST)))

    def close(self) -> None:
        self.library.wh_link_delete(self.model)

    def to_rate(self, rate: int) -> None:
        self.bit = (16 * CLOCK_HZ + RATES[rate] // 2) // RATES[rate] / 16
        self.library.wh_link_bit(self.model, ctypes.c_double(self.bit))

    def wait(self, clocks: int) -> None:
        self.library.wh_link_rest(self.model, ctypes.c_int64(clocks))

    def clocks(self) -> int:
        return self.library.wh_link_clocks(self.model)

    def count(self, which: int) -> int:
        return self.library.wh_link_count(self.model, ctypes.c_int64(which))

    def take(self, which: int) -> list[int]:
        count = self.count(which)
        found = np.zeros(count, dtype=np.int64)
        self.library.wh_link_take(
            self.model, ctypes.c_int64(which), ctypes.c_void_p(found.ctypes.data)
        )
        return found.tolist()

    def send(self, burst: Burst) -> None:
        if burst.edges:
            lengths = np.array(burst.edges, dtype=np.int64)
            self.library.wh_link_edges(
                self.model, ctypes.c_void_p(lengths.ctypes.data), ctypes.c_int64(len(lengths))
            )
        if burst.data:
            pauses = np.zeros(len(burst.data), dtype=np.int64)
            pauses[: len(burst.pauses)] = burst.pauses
            self.library.wh_link_send(
                self.model, burst.data, ctypes.c_void_p(pauses.ctypes.data),
                ctypes.c_int64(len(burst.data)), ctypes.c_double(self.bit * burst.factor),
            )  # fmt: skip
        self.bytes += len(burst.data)
        self.bursts += 1

    def go(self, burst: Burst) -> None:
        """Send it, and the question for the counters; :class:`Failure` if anything is wrong."""
        self.send(burst)
        self.settle(burst)
        question = Burst(framed(_QUESTION))
        self.send(question)
        self.settle(question)

    def settle(self, burst: Burst) -> None:
        """Silence, and all that has come of the burst."""
        self.wait(_REST)
        received = self.take(_RECEIVED)
        clocks, words = received[::2], received[1::2]
        if burst.data and abs(burst.factor - 1.0) <= 0.02 and not burst.edges:
            self.expect("what was received", list(burst.data), words)
        rate = self.slave.rate
        for clock, word in zip(clocks, words, strict=True):
            self.slave.receive(clock, word & 0xFF, bool(word >> 8))
        self.slave.rest()
        self.hear()
        if self.slave.rate != rate:
            self.to_rate(self.slave.rate)

    def hear(self) -> None:
        """Take the answers and the words, and compare them."""
        wanted = [one for body, codes in self.slave.answers for one in _tailed(body, codes)]
        due = ((_ANSWERED, len(wanted)), (_WRITTEN, len(self.slave.written)))
        for _ in range(_GIVES_UP):
            # A broadcast behind others waits for the memory as they do, and nobody answers it.
            if all(self.count(which) >= least for which, least in due):
                break
            self.wait(1000)
        self.wait(2 * BYTE_BITS * int(self.bit + 1))
        answered = self.take(_ANSWERED)
        self._compare(answered)
        self.slave.answers.clear()
        self.expect("what was written", self.slave.written, self.take(_WRITTEN))
        self.slave.written.clear()
        wrong = self.library.wh_link_wrong(self.model)
        for bit, what in _WRONG:
            if wrong & bit:
                raise Failure(what)

    def _compare(self, answered: list[int]) -> None:
        at = 0
        for body, codes in self.slave.answers:
            part = answered[at : at + len(body) + 2]
            at += len(part)
            wanted = [p if w is None else w for p, w in zip(part, body, strict=False)]
            self.expect("the answer", wanted, part[: len(body)])
            if codes and part[2] not in codes:
                raise Failure(f"exception {part[2]} is none of {sorted(codes)}")
            self.expect("the answer's CRC", list(crc(bytes(part[:-2]))), part[-2:])
            if len(part) != len(body) + 2:
                raise Failure("an answer is too short")
        if at != len(answered):
            raise Failure(f"{len(answered) - at} bytes more than the answers")

    def expect(self, what: str, wanted: list[int], found: list[int]) -> None:
        if wanted != found:
            raise Failure(f"{what} is {_shown(found)}, not {_shown(wanted)}")

    # ---- What isn't a burst for the model.

    def flood(self, rng: np.random.Generator) -> None:
        """More questions than can be answered: whole writes are left out, and that is counted."""
        before = self.slave.overruns
        group = WORDS["root"].at()
        sent = []
        for _ in range(_FLOOD):
            values = [int(rng.integers(1 << 16)) for _ in range(3)]
            sent.append((values, write(0x2000 + 2 * group, values, unit=0)))
            self.send(Burst(read(0x2000 + 2 * group, 6) + sent[-1][1] + read(0, 24)))
        self.wait(_REST)
        count = -1
        while count != (count := self.count(_ANSWERED)):
            self.wait(100 * BYTE_BITS * 6)
        self.wait(_REST)
        self.take(_RECEIVED)
        written, place = self.take(_WRITTEN), 0
        for values, _ in sent:
            words = [n for at, value in enumerate(values) for n in (group + at, value)]
            if written[place : place + 8] == [*words, COMMIT, 1]:
                place += 8
                for at, value in enumerate(values):
                    self.slave.memory[group + at] = value
        if place != len(written):
            raise Failure(f"a flood wrote {_shown(written[place:])}")
        self.take(_ANSWERED)
        self.send(Burst(framed(_QUESTION)))
        self.wait(_REST)
        found = bytes(self.take(_ANSWERED))
        self.take(_RECEIVED)
        if len(found) != 21 or found[-2:] != crc(found[:-2]):
            raise Failure("no answer after a flood")
        counts = [int.from_bytes(found[n : n + 4], "big") for n in range(3, 19, 4)]
        self.slave.frames, self.slave.crcs, self.slave.framings, self.slave.overruns = counts
        if counts[3] <= before:
            raise Failure("a flood was not counted")

    def all_settings(self) -> None:
        """Every setting reads as it should."""
        for address in self.slave.memory:
            self.send(Burst(read(0x2000 + 2 * address, 2)))
            self.settle(Burst())


def _tailed(body: list[int | None], codes: set[int]) -> list[int | None]:
    return [*body, None, None]


def _shown(numbers: list[int]) -> str:
    text = " ".join(f"{number:x}" for number in numbers[:40])
    return (text + (" ..." if len(numbers) > 40 else "")) or "nothing"


# ---- Frames.


def longest_run(slave: Slave) -> list[Place]:
    """Settings at addresses side by side, as many as a frame has room for."""
    best: list[Place] = []
    for first in sorted(slave.memory):
        run: list[Place] = []
        while first + len(run) in slave.memory and len(run) < 61:
            run.append(slave.places[first + len(run)])
        best = max(best, run, key=len)
    return best


def catalogue(slave: Slave) -> Iterator[bytes]:
    """One frame of each kind, that would act or be answered; the long ones last."""
    root = 0x2000 + 2 * WORDS["root"].at()
    yield read(0, 4)
    yield read(root, 5, function=4)
    yield write_one(root + 1, 3)
    yield write_one(RATE + 1, 1)
    yield write(root, [4, 5, 6])
    yield write(root, [9], unit=0)
    yield write_one(root + 1, 7, unit=0)
    yield write(0x2000 + 2 * WORDS["clear"].at(), [1])
    yield framed(bytes([UNIT, 43, 14, 1, 0]))
    yield framed(bytes([UNIT, 17]))
    yield framed(bytes([UNIT, 23, 0, 0, 0, 2, 0x20, 0, 0, 2, 4, 0, 0, 0, 1]))
    run = longest_run(slave)
    yield write(0x2000 + 2 * run[0].address, [p.word.default & 0xFFFFFFFF for p in run])


def any_frame(slave: Slave, rng: np.random.Generator, words: list[Place]) -> bytes:
    """A legal frame that acts, is answered, or is refused; none that changes the rate."""
    unit = int(rng.choice([UNIT, 0, UNIT + 1], p=[0.7, 0.2, 0.1]))
    kind = rng.integers(8)
    place = words[int(rng.integers(len(words)))]
    register = 0x2000 + 2 * place.address
    if kind == 0:
        return read(int(rng.integers(28)), int(rng.integers(1, 26)), int(rng.choice([3, 4])), unit)
    if kind == 1:
        return read(register + int(rng.integers(2)), int(rng.integers(0, 9)), unit=unit)
    if kind == 2:
        value = _drawn(place, rng) if rng.random() < 0.7 else int(rng.integers(1 << 32))
        return write_one(register + int(rng.random() < 0.95), value & 0xFFFF, unit)
    if kind == 3:
        body = bytes([unit, 43, 14, int(rng.integers(5)), int(rng.integers(5))])
        return framed(body)
    values = []
    for at in range(place.address, place.address + int(rng.integers(1, 6))):
        known = slave.places.get(at, place)
        values.append(_drawn(known, rng) if rng.random() < 0.97 else int(rng.integers(1 << 32)))
    return write(register, values, unit)


def _drawn(place: Place, rng: np.random.Generator) -> int:
    low, high = place.limits
    value = (low, high, int(rng.integers(low, high + 1)))[int(rng.integers(3))]
    return value & 0xFFFFFFFF


# ---- Bursts.


def every_beginning(slave: Slave, frames: int) -> Iterator[Burst]:
    for frame in list(catalogue(slave))[:frames]:
        for length in range(1, len(frame)):
            yield Burst(frame[:length])


def every_bit(slave: Slave, frames: int) -> Iterator[Burst]:
    for frame in list(catalogue(slave))[:frames]:
        for place in range(8 * len(frame)):
            flipped = bytearray(frame)
            flipped[place // 8] ^= 1 << place % 8
            yield Burst(bytes(flipped))


def spoilt(slave: Slave, rng: np.random.Generator, words: list[Place]) -> Burst:
    """A frame with something done to it."""
    data = bytearray(any_frame(slave, rng, words))
    for _ in range(int(rng.integers(3))):
        at = int(rng.integers(len(data)))
        what = rng.integers(4)
        if what == 0:
            del data[at]
        elif what == 1:
            data.insert(at, data[at])
        elif what == 2:
            data[at] = int(rng.integers(256))
        else:
            other = int(rng.integers(len(data)))
            data[at], data[other] = data[other], data[at]
        if not data:
            data.append(0)
    pauses = [0] * len(data)
    for _ in range(int(rng.integers(4))):
        # Clearly less than silence, or clearly more.
        long = rng.random() < 0.3
        pauses[int(rng.integers(len(data)))] = int(
            rng.integers(2 * SILENCE, 3 * SILENCE) if long else rng.integers(1, SILENCE - 100)
        )
    pauses[-1] = 0
    factor = float(rng.choice([1.0, 0.98, 1.02, 0.95, 1.05, rng.uniform(0.92, 1.08)]))
    return Burst(bytes(data), pauses, factor)


def glued(slave: Slave, rng: np.random.Generator, words: list[Place]) -> Burst:
    data = b""
    while True:
        frame = any_frame(slave, rng, words)
        if len(data) + len(frame) > 250:
            return Burst(data)
        data += frame


def rattling(rng: np.random.Generator) -> Burst:
    count = 2 * int(rng.integers(1, 100))
    most = int(rng.choice([4, 12, 60, 200]))
    return Burst(edges=[int(n) for n in rng.integers(1, most + 1, count)])


def noise(rng: np.random.Generator, heads: list[bytes]) -> Burst:
    """Random bytes with silences between, perhaps behind the beginnings of frames."""
    data, pauses = b"", []
    while len(data) < 3000 and rng.random() < 0.95:
        part = rng.bytes(int(rng.choice([3, 9, 40, 300, 1200], p=[0.1, 0.2, 0.3, 0.3, 0.1])))
        if rng.random() < 0.3:
            part = heads[int(rng.integers(len(heads)))] + part
        data += part
        pauses += [0] * (len(part) - 1) + [2 * SILENCE + 100]
    if pauses:
        pauses[-1] = 0
    return Burst(data, pauses)


# ---- The soak.


def tasks(count: int, seed: int = 0) -> list[Task]:
    """The soak of so many random bytes or some more, in tasks of TASK_BYTES."""
    number = -(-count // TASK_BYTES)
    first = [Task(soak, {"seed": seed, "count": 0, "frames": 99})]
    return first + [
        Task(soak, {"seed": seed + n, "count": TASK_BYTES, "frames": 0}) for n in range(number)
    ]


def soak(seed: int, count: int, frames: int) -> dict[str, Any]:
    """``count`` bytes of bursts of a seed, and all bursts made of so many kinds of frames.

    Counts, and ``wrong``, None or a line.
    """
    rng = np.random.default_rng([seed, 2])
    line = Line()
    slave = line.slave
    words = [slave.places[at] for at in sorted(slave.places)]
    heads = [frame[:-2] for frame in catalogue(slave)]
    wrong: str | None = None
    random = 0
    try:
        for make in (every_beginning, every_bit):
            for burst in make(slave, frames):
                line.go(burst)
        while random < count:
            kind = rng.random()
            before = line.bytes
            if kind < 0.6:
                line.go(noise(rng, heads))
            elif kind < 0.8:
                line.go(spoilt(slave, rng, words))
            elif kind < 0.9:
                line.go(glued(slave, rng, words))
            elif kind < 0.98:
                line.go(rattling(rng))
            elif kind < 0.985:
                rate = int(rng.integers(len(RATES)))
                line.go(Burst(write_one(RATE + 1, rate)))
                line.go(Burst(write_one(RATE + 1, FASTEST)))
            elif kind < 0.99:
                line.all_settings()
            elif kind < 0.992:
                line.flood(rng)
            random += line.bytes - before
        line.all_settings()
    except Failure as failure:
        wrong = f"burst {line.bursts}: {failure}"
    except Undecided:
        wrong = f"burst {line.bursts}: a pause that is neither short nor a silence"
    finally:
        clocks = line.clocks()
        line.close()
    return {
        "seed": seed, "bytes": line.bytes, "bursts": line.bursts, "clocks": clocks,
        "frames": slave.frames, "crcs": slave.crcs, "framings": slave.framings,
        "overruns": slave.overruns, "wrong": wrong,
    }  # fmt: skip


def summary(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Sums of the tasks' counts, and every line of what went wrong, with its seed."""
    counts = [key for key in results[0] if key not in ("seed", "wrong")]
    found: dict[str, Any] = {key: sum(one[key] for one in results) for key in counts}
    found["wrong"] = [f"seed {one['seed']}, {one['wrong']}" for one in results if one["wrong"]]
    return found
