# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_stream.v``: its packets against a model of its page, and its credit.

Beside a memory of 16 words a capture, which never ends, chooses eight of a tick's before it.
"""

from __future__ import annotations

import random
from collections.abc import Iterable

import cocotb
from bench import Bench, pack, random_source
from cobs_frames import WORDS, Packet, packet
from simulators import parameters
from tb_capture import CODES, MEANS, NO_STREAM, NONE, WAITS, WIDTHS

_P = {"N": 1, "DEPTH_LOG2": 6, "CREDIT": 4000, **parameters()}
N, CREDIT, BESIDE = _P["N"], _P["CREDIT"], _P["DEPTH_LOG2"] == 4
REST, RUNS = 1, 2
START, RENEW, STOP = 1, 2, 0
PASS_CLOCKS = 14 if BESIDE else 9
"""In which a tick is worked off."""
Words = dict[tuple[str, int], int]


def row(codes: list[int], shifts: list[int], ticks: Iterable[Words]) -> tuple[int, ...]:
    """The words of a row of these ticks without signs, by the page."""
    found, given = [], list(ticks)
    for code, shift in zip(codes, shifts, strict=False):
        name, motor = CODES.get(code, ("", 0))
        values = [tick[name, motor] for tick in given] if name else [0]
        if name in MEANS or name == "bus":
            cut = (sum(values) // len(values)) >> shift
            found.append(max(-32768, min(32767, cut)) & 0xFFFF)
        elif name == "position" or not name:
            found.append(values[-1] >> shift & 0xFFFF)
        else:
            bits = 0
            for value in values:
                bits |= value
            found.append(bits >> shift & 0xFFFF)
    return tuple(found)


class StreamBench(Bench):
    """The block with ticks of any length; ``ticks`` has the words of each strobe with credit."""

    async def begin(self, rng: random.Random) -> None:
        self.rng = rng
        self.words: Words = dict.fromkeys(CODES.values(), 0)
        self.ticks: list[Words] = []
        self.bytes = bytearray()
        self.packets: list[bytes] = []
        self.rooms: list[bool] = []
        self.room = 1
        self.codes, self.shifts, self.channels, self.decimation = [0] * 4, [0] * 4, 1, 0
        await self.start(
            tick_i=0, valid_i=0, **NO_STREAM, **self._inputs(self.words), contact_i=0, fault_i=0,
            channel_i=pack([*CODES][:8], 12), channels_i=8, rows_i=1, pre_i=0, decimation_i=0,
            trigger_i=0, level_i=0, hold_i=0, write_i=0, write_offset_i=0, data_i=0, read_i=0,
        )  # fmt: skip
        assert self.word("stream_state_o") == REST
        if BESIDE:
            await self.step(write_i=1, data_i=1)
            await self.step(4, write_i=0)
            assert self.word("state_o") == WAITS

    def give(self, codes: list[int], shifts: list[int], channels: int, decimation: int) -> None:
        self.codes, self.shifts, self.channels = codes, shifts, channels
        self.decimation = decimation
        self.drive(
            stream_channel_i=pack(codes, 12), stream_shift_i=pack(shifts, 4),
            stream_last_i=channels - 1, stream_decimation_i=decimation,
        )  # fmt: skip

    def _inputs(self, words: Words) -> dict[str, int]:
        found = {
            f"{name}_i": pack((words[name, motor] for motor in range(N)), bits)
            for name, bits in WIDTHS.items()
        }
        return {**found, "bus_i": words["bus", 0], "faults_i": words["faults", 0]}

    async def clock(self, **inputs: int) -> None:
        """A clock, and the bytes of it."""
        await self.step(stream_room_i=self.room, **inputs)
        self.drive(tick_i=0, valid_i=0, stream_write_i=0)
        if self.word("stream_valid_o"):
            if self.word("stream_first_o"):
                self.bytes.clear()
            self.bytes.append(self.word("stream_byte_o"))
        if self.word("stream_packet_o"):
            self.packets.append(bytes(self.bytes))
            self.bytes.clear()

    async def tick(self, clocks: int, *, steps: bool) -> None:
        """A tick of so many clocks with words of its own.

        Its step comes when the strobe of one before it without a step is worked off, and its row
        is written.
        """
        rng = self.rng
        before = max(PASS_CLOCKS, clocks - 30)
        for _ in range(before):
            await self.clock()
        for name, motor in self.words:
            bits = {"bus": 16, "faults": 16, **WIDTHS}[name]
            small = rng.random() < 0.7
            if name in ("bus", "faults", "flags"):
                self.words[name, motor] = rng.getrandbits(bits) & rng.getrandbits(bits)
            else:
                half = 1 << (14 if small else bits - 1)
                self.words[name, motor] = rng.randint(-half, half - 1)
        self.drive(**self._inputs(self.words))
        if steps:
            await self.clock(valid_i=1)
            self.drive(**self._inputs({key: rng.getrandbits(32) for key in self.words}))
        left = clocks - before - steps
        for n in range(left):
            await self.clock(tick_i=int(n == left - 1))
        self.ticks.append(dict(self.words))

    async def write(self, value: int) -> None:
        await self.clock(stream_write_i=1, stream_data_i=value)

    def rows(self) -> list[tuple[int, ...]]:
        """Of all ticks since the first credit."""
        length = 1 << self.decimation
        return [
            row(self.codes[: self.channels], self.shifts, self.ticks[n : n + length])
            for n in range(0, len(self.ticks) - length + 1, length)
        ]


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def packets_of_every_kind(dut: object) -> None:
    """Random channels, cuts and decimations; with steps and without; room now and then."""
    bench, rng = StreamBench(dut), random_source("packets")
    await bench.begin(rng)
    lost_ever = cut_ever = 0
    for number in range(6):
        channels = number % 4 + 1
        codes = [rng.choice([*CODES, *NONE] if rng.random() < 0.2 else [*CODES]) for _ in range(4)]
        bench.give(codes, [rng.choice((0, 0, 1, 8, 15)) for _ in range(4)], channels,
                   rng.choice((0, 1, 3)) if number else 0)  # fmt: skip
        bench.ticks, bench.packets = [], []
        await bench.write(START)
        await bench.step(3)
        # Settings that are written while it runs are the next one's.
        kept = (bench.codes, bench.shifts, bench.channels, bench.decimation)
        bench.give([0xFFF] * 4, [3] * 4, 2, 7)
        bench.codes, bench.shifts, bench.channels, bench.decimation = kept
        clocks = rng.choice((140, 170))
        rooms = []
        for _ in range(4):
            bench.room = int(rng.random() < 0.7)
            rooms.append(bench.room)
            for n in range(WORDS // channels << bench.decimation):
                await bench.tick(clocks, steps=rng.random() < 0.7 or n == 0)
                if n % 16 == 0:
                    await bench.write(RENEW)
        await bench.tick(clocks, steps=True)
        assert bench.word("stream_lost_o") == rooms.count(0)
        await bench.write(STOP)
        await bench.step(20)
        assert bench.word("stream_state_o") == REST
        rows, each = bench.rows(), WORDS // channels
        wanted = [
            Packet(n, rows[n * each : (n + 1) * each]) for n, room in enumerate(rooms) if room
        ]
        assert [packet(data) for data in bench.packets] == wanted
        lost_ever += rooms.count(0)
        cut_ever += sum(word in (0x7FFF, 0x8000) for row in rows for word in row)
    assert lost_ever > 2
    assert cut_ever > 10


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def lowest_bits_of_each_word(dut: object) -> None:
    """No word is cut: those that stand at the block are those of the rows."""
    bench, rng = StreamBench(dut), random_source("each")
    await bench.begin(rng)
    codes = [*CODES]
    for first in range(0, len(codes), 4):
        bench.give([codes[(first + n) % len(codes)] for n in range(4)], [0] * 4, 4, 0)
        bench.ticks, bench.packets = [], []
        await bench.write(START)
        await bench.step(3)
        for _ in range(WORDS // 4 + 1):
            await bench.tick(140, steps=True)
        await bench.write(STOP)
        await bench.step(20)
        assert [packet(data) for data in bench.packets] == [Packet(0, bench.rows()[: WORDS // 4])]


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def rows_that_come_too_fast(dut: object) -> None:
    """Packets whose rows can't be written in time are left out, numbered and counted."""
    bench, rng = StreamBench(dut), random_source("fast")
    await bench.begin(rng)
    bench.give([*CODES][:4], [0] * 4, 4, 0)
    await bench.write(START)
    await bench.step(3)
    for clocks, packets in ((120, 1), (20, 3), (120, 2)):
        for _ in range(packets * 15):
            await bench.tick(clocks, steps=True)
        await bench.write(RENEW)
    await bench.tick(120, steps=True)
    found = [packet(data) for data in bench.packets]
    rows = bench.rows()
    assert [each.number for each in found] == [0, 4, 5] or [each.number for each in found] == [0, 5]
    assert bench.word("stream_lost_o") == 6 - len(found)
    for each in found:
        assert each.rows == rows[15 * each.number : 15 * each.number + 15]


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def credit_lasts_so_long(dut: object) -> None:
    """CREDIT clocks from a 1 or 2 on; a 2 alone begins nothing, a 0 ends it, a hold waits."""
    bench, rng = StreamBench(dut), random_source("credit")
    await bench.begin(rng)
    await bench.write(RENEW)
    await bench.step(5)
    assert (bench.word("stream_credit_o"), bench.word("stream_state_o")) == (0, REST)
    for renewals in range(3):
        await bench.write(START)
        lasts = 0
        for _ in range(renewals):
            await bench.step(CREDIT - 7)
            assert bench.word("stream_credit_o")
            await bench.write(RENEW)
        while bench.word("stream_credit_o"):
            await bench.clock()
            lasts += 1
        assert lasts == CREDIT
        await bench.step(3)
        assert bench.word("stream_state_o") == REST
        assert not bench.packets
    await bench.step(stream_hold_i=1)
    await bench.write(START)
    await bench.step(30)
    assert (bench.word("stream_credit_o"), bench.word("stream_state_o")) == (1, REST)
    await bench.step(2, stream_hold_i=0)
    assert bench.word("stream_state_o") == RUNS
    await bench.write(STOP)
    await bench.step(2)
    assert (bench.word("stream_credit_o"), bench.word("stream_state_o")) == (0, REST)
