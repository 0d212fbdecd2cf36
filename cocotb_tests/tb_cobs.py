# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_cobs.v``: a slave's answers and packets on one transmitter."""

from __future__ import annotations

import random
from collections import deque

import cocotb
from bench import Bench, random_source
from cobs_frames import frames, unstuffed

PACKET = 125


class CobsBench(Bench):
    """A slave, a stream and a transmitter, each of which does what its header says.

    ``byte_clocks`` is the time of a byte on the line.
    """

    async def begin(self, rng: random.Random, byte_clocks: int = 6) -> None:
        self.rng, self.byte_clocks = rng, byte_clocks
        self.line = bytearray()
        self.left = 0  # clocks of the byte on the line
        self.answer: deque[int] | None = None
        self.pause = 0
        self.resting = False
        self.packet: deque[int] = deque()
        self.packet_ends = False
        self.committed: list[bytes] = []
        self.whole: bytes = b""
        self.credit = 0
        self.marks: list[int] = []  # clock of each byte
        self.shown: dict[str, int] = {}
        await self.start(
            credit_i=0, answers_i=0, rests_i=0, answer_valid_i=0, answer_i=0, byte_valid_i=0,
            byte_first_i=0, byte_i=0, packet_i=0, tx_ready_i=1,
        )  # fmt: skip

    def say(self, data: bytes) -> None:
        """An answer; an empty one is a broadcast's."""
        assert not self.speaks
        self.answer = deque(data)
        self.resting, self.pause = not data, 2

    @property
    def speaks(self) -> bool:
        return self.answer is not None

    def pack(self, data: bytes) -> None:
        """A packet, once there is room."""
        assert not self.packet
        assert not self.packet_ends
        self.packet, self.whole = deque(data), data

    @property
    def packs(self) -> bool:
        return bool(self.packet) or self.packet_ends

    async def clock(self) -> None:
        rng = self.rng
        offers = self.speaks and bool(self.answer) and self.pause == 0
        writes = bool(self.packet) and rng.random() < 0.3
        first = writes and len(self.packet) == len(self.whole)
        ends = self.packet_ends
        ready = self.left == 0
        await self.settle_and_see(
            credit_i=self.credit, answers_i=int(self.speaks and not self.resting),
            rests_i=int(self.speaks and self.resting), answer_valid_i=int(offers),
            answer_i=self.answer[0] if offers else 0xA5, byte_valid_i=int(writes),
            byte_first_i=int(first), byte_i=self.packet[0] if writes else 0x5A,
            packet_i=int(ends), tx_ready_i=int(ready),
        )  # fmt: skip
        taken = self.taken
        self.left = max(0, self.left - 1)
        if ready and self.valid:
            self.line.append(self.data)
            self.marks.append(self.clocks)
            self.left = self.byte_clocks
        if self.speaks:
            if self.resting and taken:
                self.answer = None
                assert ready, "the line doesn't rest"
            elif offers and taken:
                self.answer.popleft()
                self.pause = rng.randint(3, 9)
                self.resting = not self.answer
            else:
                self.pause = max(0, self.pause - 1)
        if writes:
            self.packet.popleft()
            self.packet_ends = not self.packet
        if ends:
            self.packet_ends = False
            self.committed.append(self.whole)

    async def settle_and_see(self, **inputs: int) -> None:
        """Drive inputs, look at what follows from them, and let a clock pass."""
        changed = {name: value for name, value in inputs.items() if self.shown.get(name) != value}
        self.shown |= inputs
        await self.settle(**changed)
        self.valid = bool(self.word("tx_valid_o"))
        self.data = self.word("tx_data_o") if self.valid and inputs["tx_ready_i"] else 0
        self.taken = bool(self.word("answer_ready_o"))
        self.room = bool(self.word("room_o"))
        await self.step()

    async def until_quiet(self) -> None:
        still = 0
        while still < 1200:
            await self.clock()
            still = 0 if self.left or self.speaks or self.packs else still + 1


def some_bytes(rng: random.Random, count: int) -> bytes:
    zeros = rng.choice((0.0, 0.005, 0.1, 0.9, 1.0))
    return bytes(0 if rng.random() < zeros else rng.randint(1, 255) for _ in range(count))


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def without_credit(dut: object) -> None:
    """The slave's bytes and no others, each as soon as the line has room."""
    bench, rng = CobsBench(dut), random_source("plain")
    await bench.begin(rng)
    said = b""
    for _ in range(40):
        answer = some_bytes(rng, rng.choice((0, 1, 4, 8, 40)))
        said += answer
        bench.say(answer)
        while bench.speaks:
            await bench.clock()
        for _ in range(rng.randint(0, 20)):
            await bench.clock()
    await bench.until_quiet()
    assert bytes(bench.line) == said


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def answers_as_frames(dut: object) -> None:
    """Of every length, with zeros everywhere and nowhere."""
    bench, rng = CobsBench(dut), random_source("frames")
    await bench.begin(rng)
    bench.credit = 1
    await bench.clock()
    lengths = [1, 2, 3, 8, 64, 252, 253, 254, 255, 255, 254, *rng.sample(range(256), 3)]
    given = []
    for length in lengths:
        answer = bytes(rng.randint(1, 255) for _ in range(length)) if length > 251 and (
            rng.random() < 0.7) else some_bytes(rng, length)  # fmt: skip
        given += [answer] if answer else []
        bench.say(answer)
        while bench.speaks:
            await bench.clock()
    await bench.until_quiet()
    found, rest = frames(bytes(bench.line))
    assert rest == b""
    assert [unstuffed(frame) for frame in found] == given


@cocotb.test(timeout_time=400, timeout_unit="ms")
async def packets_and_answers(dut: object) -> None:
    """Every packet that there was room for and every answer, whole, in turn; none waits for two."""
    bench, rng = CobsBench(dut), random_source("mixed")
    await bench.begin(rng)
    bench.credit = 1
    await bench.clock()
    answers, refused = [], 0
    next_packet = next_answer = 0
    for _ in range(25_000):
        if bench.clocks >= next_packet and not bench.packs:
            next_packet = bench.clocks + rng.choice((600, 900, 1500))
            if bench.room:
                bench.pack(some_bytes(rng, PACKET))
            else:
                refused += 1
        if bench.clocks >= next_answer and not bench.speaks:
            answer = some_bytes(rng, rng.choice((0, 8, 8, 30, 255)))
            bench.say(answer)
            answers += [answer] if answer else []
            next_answer = bench.clocks + rng.randint(500, 3000)
        await bench.clock()
    await bench.until_quiet()
    found, rest = frames(bytes(bench.line))
    assert rest == b""
    data = [unstuffed(frame) for frame in found]
    assert len(data) == len(answers) + len(bench.committed)
    assert [each for each in data if each in answers] == answers
    assert [each for each in data if each not in answers] == bench.committed
    assert refused > 1
    assert len(answers) > 5
    assert len(bench.committed) > 12


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def an_answer_goes_first(dut: object) -> None:
    """With packets that wait, no more than the one under way is before an answer."""
    bench, rng = CobsBench(dut), random_source("first")
    await bench.begin(rng)
    bench.credit = 1
    await bench.clock()
    for _ in range(6):
        while not (bench.room and not bench.packs):
            await bench.clock()
        for _ in range(3):
            bench.pack(some_bytes(rng, PACKET))
            while bench.packs:
                await bench.clock()
        for _ in range(rng.randint(1, 900)):
            await bench.clock()
        before = len(bench.line)
        answer = bytes([1, *some_bytes(rng, 7)])
        bench.say(answer)
        while bench.speaks:
            await bench.clock()
        behind, rest = frames(bytes(bench.line[before:]))
        assert rest == b""
        assert unstuffed(behind[-1]) == answer
        assert len(behind) <= 2
    await bench.until_quiet()


@cocotb.test(timeout_time=400, timeout_unit="ms")
async def credit_that_ends(dut: object) -> None:
    """At any time: the packet under way is the last one, and answers are plain behind it."""
    bench, rng = CobsBench(dut), random_source("ends")
    await bench.begin(rng)
    cut = 0
    for _ in range(12):
        bench.line.clear()
        bench.committed.clear()
        bench.credit = 1
        await bench.clock()
        await bench.clock()
        for _ in range(rng.randint(1, 3000)):
            if not bench.packs and bench.room and rng.random() < 0.01:
                bench.pack(some_bytes(rng, PACKET))
            await bench.clock()
        bench.credit = 0
        bench.packet.clear()
        bench.packet_ends = False
        await bench.clock()
        kept = len(bench.line)
        answer = bytes([1, *some_bytes(rng, 7)])
        bench.say(answer)
        while bench.speaks:
            await bench.clock()
        line = bytes(bench.line)
        assert line.endswith(answer)
        found, rest = frames(line[: -len(answer)])
        assert rest == b""
        assert [unstuffed(frame) for frame in found] == bench.committed[: len(found)]
        # What had begun went on, by no more than its frame.
        assert len(line) - len(answer) - kept <= PACKET + 2
        cut += len(bench.committed) > len(found)
        await bench.until_quiet()
        assert bytes(bench.line) == line
    assert cut > 3


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def one_packet_after_another(dut: object) -> None:
    """A line that is never left alone: but for the search for zeros nothing is lost."""
    bench, rng = CobsBench(dut), random_source("rate")
    await bench.begin(rng, byte_clocks=60)
    bench.credit = 1
    await bench.clock()
    while bench.line.count(0) < 4:
        if not bench.packs and bench.room:
            bench.pack(bytes(rng.randint(0, 255) for _ in range(PACKET)))
        await bench.clock()
    ends = [at for at, data in zip(bench.marks, bench.line, strict=True) if data == 0]
    each = (ends[-1] - ends[0]) / (len(ends) - 1)
    found, _ = frames(bytes(bench.line))
    assert [unstuffed(frame) for frame in found] == bench.committed[: len(found)]
    cocotb.log.info("a packet each %.1f clocks of the line's %d", each, 127 * 61)
    assert 127 * 61 <= each < 127 * 61 + 3 * PACKET + 40
