# SPDX-License-Identifier: Apache-2.0
"""Bench of a stream over the line of ``rtl/wh_linked_device.v``, at its fastest rate."""

from __future__ import annotations

import cocotb
from bench import CLOCK_NS, random_source
from cobs_frames import Packet, frames, is_right, packet, unstuffed
from cocotb.triggers import RisingEdge, Timer
from modbus_frames import TABLE, decode, halves, raw, read, whole, words, write_one
from simulators import parameters
from tb_link import HZ, LinkBench
from wavehaptics.words import table
from wavehaptics.words.table import WORDS

_P = parameters()
CREDIT = _P["CREDIT"]
RATE = 3
TICK, LOG2 = 72, 3
"""Clocks of a tick, and 2^LOG2 of them in a row: 31,250 rows a second with 18 MHz."""
PACKET_CLOCKS = 127 * (10 * HZ // 3_000_000 + 1)
ROOT = WORDS["root"].at()
BUS, POSITION, FAULTS = (WORDS[name].at() for name in ("bus", "position", "faults"))
START, RENEW, STOP = 1, 2, 0


class StreamBench(LinkBench):
    """The device on a line that carries frames; a bus that is another one in each tick."""

    async def begin(self) -> None:
        await super().begin()
        self.packets: list[Packet] = []
        self.ends: list[int] = []  # clocks of the packets' ends
        self.answers: list[bytes] = []
        self.buses: list[int] = []
        self.rng = random_source("bus")
        cocotb.start_soon(self._bus())
        timing = words(WORDS["half_clocks"].at(), [TICK, 1, TICK])
        assert not (await self.ask(timing)).isError()
        assert not (await self.ask(write_one(11, RATE))).isError()
        self.line.bit_ns = self.bit_ns(RATE)
        channels = [BUS, POSITION, BUS, FAULTS, 3, LOG2]
        assert not (await self.ask(words(WORDS["stream_channel"].at(), channels))).isError()
        assert not (await self.ask(words(WORDS["stream_shift"].at(), [2, 0, 9, 0]))).isError()

    async def _bus(self) -> None:
        while True:
            await RisingEdge(self.dut.tick_o)
            await Timer(3 * CLOCK_NS, unit="ns")
            self.buses.append(self.rng.getrandbits(16))
            self.dut.bus_i.value = self.buses[-1]

    def look(self) -> None:
        """At the frames that have come."""
        found, rest = frames(bytes(self.line.heard))
        self.line.heard[:] = rest
        for frame in found:
            data = unstuffed(frame)
            assert is_right(data), data.hex()
            told = packet(data)
            if told is None:
                self.answers.append(data)
            else:
                self.packets.append(told)
                self.ends.append(self.clocks)

    async def pass_by(self, clocks: int, every: int = 60) -> None:
        for _ in range(clocks // every):
            await self.step(every)
            self.look()

    async def framed(self, frame: bytes, most: int = 20_000):
        """The answer to a question, out of a frame."""
        self.look()
        assert not self.answers
        sender = cocotb.start_soon(self.line.send(frame))
        for _ in range(most // 60):
            await self.step(60)
            self.look()
            if self.answers:
                break
        assert sender.done()
        return decode(self.answers.pop())

    async def start_stream(self) -> None:
        answer = await self.framed(words(WORDS["stream"].at(), [START]))
        assert not answer.isError()

    async def renew(self) -> None:
        assert not (await self.framed(words(WORDS["stream"].at(), [RENEW]))).isError()

    def judge(self) -> None:
        """Packets without a gap, whose words are those of the ticks."""
        assert [each.number for each in self.packets] == [*range(len(self.packets))]
        rows = [row for each in self.packets for row in each.rows]
        length = 1 << LOG2
        for first in range(len(self.buses)):
            means = [
                sum(self.buses[first + n * length : first + (n + 1) * length]) // length
                for n in range(len(rows))
            ]
            if [(mean >> 2, 0, mean >> 9, 0) for mean in means] == rows:
                return
        raise AssertionError("the words are of no ticks")


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def thirty_thousand_rows(dut: object) -> None:
    """Four words of 16 bits at 30 kHz and more, none of them lost, word for word."""
    bench = StreamBench(dut)
    await bench.begin()
    assert await bench.values(WORDS["stream_state"].at(), 2) == [1, 0]
    await bench.start_stream()
    while len(bench.packets) < 10:
        await bench.pass_by(8_000)
        await bench.renew()
    count = len(bench.packets) - 1
    rate = 15 * count * HZ / (bench.ends[-1] - bench.ends[0])
    cocotb.log.info("%.0f rows of 4 words a second", rate)
    assert rate >= 30_000
    found = whole((await bench.framed(read(TABLE + 2 * WORDS["stream_state"].at(), 4))).registers)
    assert found == [2, 0]
    bench.judge()


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def the_line_while_it_streams(dut: object) -> None:
    """Long answers, settings, refusals and noise: each has its answer, and no packet is lost."""
    bench = StreamBench(dut)
    await bench.begin()
    await bench.start_stream()
    for _ in range(2):
        found = await bench.framed(read(TABLE + 2 * WORDS["stream_channel"].at(), 2 * 6))
        assert whole(found.registers) == [BUS, POSITION, BUS, FAULTS, 3, LOG2]
        await bench.pass_by(3 * PACKET_CLOCKS)
        await bench.renew()
    answer = await bench.framed(read(0, 24))
    assert whole(answer.registers)[0] == table.crc()
    assert not (await bench.framed(words(ROOT, [0x1234, 99]))).isError()
    await bench.pass_by(2_000)
    found = await bench.framed(read(TABLE + 2 * ROOT, 4))
    assert found.registers == halves([0x1234, 99])
    await bench.renew()
    assert (await bench.framed(words(ROOT, [1 << 31]))).exception_code == 3
    assert (await bench.framed(raw(b"\x63\x01\x02"), most=40_000)).exception_code == 1
    await bench.renew()
    # Noise: bytes, and levels.
    for _ in range(30):
        await bench.line.byte(bench.rng.getrandbits(8), stop=int(bench.rng.random() < 0.9))
        bench.look()
    for _ in range(80):
        dut.uart_rx_i.value = bench.rng.randint(0, 1)
        await bench.step(bench.rng.randint(1, 40))
        bench.look()
    dut.uart_rx_i.value = 1
    await bench.pass_by(2 * _P["SILENCE"] + 600)
    bench.answers.clear()
    await bench.renew()
    found = await bench.framed(read(TABLE + 2 * ROOT, 4))
    assert found.registers == halves([0x1234, 99])
    await bench.renew()
    await bench.pass_by(2 * PACKET_CLOCKS)
    assert len(bench.packets) > 12
    bench.judge()


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def a_host_that_is_gone(dut: object) -> None:
    """CREDIT clocks and a packet later the line is plain, and stays so; a 0 does it at once."""
    bench = StreamBench(dut)
    await bench.begin()
    await bench.start_stream()
    await bench.pass_by(CREDIT // 2)
    await bench.renew()
    last = bench.clocks
    await bench.pass_by(CREDIT + 2 * PACKET_CLOCKS)
    assert bench.line.heard == b""
    assert CREDIT - 2 * PACKET_CLOCKS < bench.ends[-1] - last < CREDIT + PACKET_CLOCKS + 2_000
    assert len(bench.packets) > 8
    bench.judge()
    # Any Modbus master reads now, and is given no frames.
    assert whole((await bench.ask(read(0, 2))).registers) == [table.crc()]
    assert await bench.values(WORDS["stream_state"].at()) == [1]
    bench.packets.clear()
    bench.buses.clear()
    await bench.start_stream()
    await bench.pass_by(3 * PACKET_CLOCKS)
    await bench.line.send(words(WORDS["stream"].at(), [STOP]))
    await bench.step(4 * PACKET_CLOCKS)
    line = bytes(bench.line.heard)
    answer = raw(words(WORDS["stream"].at(), [STOP])[1:6])
    assert line.endswith(answer)
    bench.line.heard[:] = line[: -len(answer)]
    bench.look()
    assert bench.line.heard == b""
    assert [each.number for each in bench.packets] == [*range(len(bench.packets))]
    # A renewal alone begins nothing.
    answer = await bench.ask(words(WORDS["stream"].at(), [RENEW]))
    assert not answer.isError()
    await bench.step(3 * PACKET_CLOCKS)
    assert bench.line.heard == b""


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def more_than_the_line_carries(dut: object) -> None:
    """What has no room is left out whole, and stands in the numbers and in stream_lost."""
    bench = StreamBench(dut)
    await bench.begin()
    decimation = WORDS["stream_decimation"].at()
    assert not (await bench.ask(words(decimation, [LOG2 - 1]))).isError()
    await bench.start_stream()
    while len(bench.packets) < 14:
        await bench.pass_by(8_000)
        await bench.renew()
    numbers = [each.number for each in bench.packets]
    missing = numbers[-1] + 1 - len(numbers)
    assert missing > 3
    assert numbers == sorted({*numbers})
    await bench.renew()
    lost = whole((await bench.framed(read(TABLE + 2 * WORDS["stream_lost"].at(), 2))).registers)
    assert missing <= lost[0] <= missing + 8
