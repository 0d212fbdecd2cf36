# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_linked_device.v`` with ``SPI``: pymodbus asks over SPI, and over the UART."""

from __future__ import annotations

import cocotb
from bench import random_source
from line_bench import LineBench
from modbus_frames import TABLE, VALUE, decode, identify, read, whole, words, write_one  # fmt: skip
from simulators import parameters
from spi_master import SpiMaster
from uart_line import Line
from wavehaptics.words import table
from wavehaptics.words.table import WORDS

_P = parameters()
HZ = _P["CLOCK_HZ"]
ROOT, POSITION, ARMED = (WORDS[name].at() for name in ("root", "position", "armed"))
GATES = ("gate_ah_o", "gate_al_o", "gate_bh_o", "gate_bl_o")
FILLER = 0xFF
LATER = 4_000
"""Clocks in which frames are executed, also settings."""
FALLBACK = (_P["FALLBACK"] + 2) * _P["SILENCE"]
COUNTERS = read(16, 8)


class SpiLinkBench(LineBench):
    """The device at its SPI, with a UART that a second master has."""

    HZ = HZ

    async def begin(self, clocks: float = 6) -> None:
        dut = self.dut
        self.line = Line(dut.uart_rx_i, dut.uart_tx_o, self.bit_ns(0))
        self.master = SpiMaster(dut.spi_cs_n_i, dut.spi_sclk_i, dut.spi_mosi_i, dut.spi_miso_o)
        self.master.clocks = clocks
        await self.start(
            enable_i=0, adc_sdata_i=0, enc_a_i=0, enc_b_i=0, bus_i=0, stop_i=1, driver_fault_i=1,
            press_i=0,
        )  # fmt: skip
        await self.step(6_000)

    async def read_out(self, count: int = 260) -> bytes:
        """What waits, without the zeros around it."""
        return (await self.master.transfer(bytes([FILLER] * count))).strip(b"\0")

    async def spi(self, *frames: bytes, after: int = LATER) -> bytes:
        """Frames in one transfer, and what the next one reads."""
        await self.master.transfer(b"".join(frames))
        await self.step(after)
        return await self.read_out()

    async def counters(self) -> list[int]:
        return whole(decode(await self.spi(COUNTERS)).registers)

    async def root(self) -> int:
        return whole(decode(await self.spi(read(TABLE + 2 * ROOT, 2))).registers)[0]

    async def lost(self, *transfers: bytes) -> None:
        """No frame in them is answered or executed."""
        before = await self.root()
        for data in transfers:
            await self.master.transfer(data)
            await self.step(LATER)
            assert await self.read_out() == b""
        assert await self.root() == before


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def the_device_answers(dut: object) -> None:
    """Identification, settings that are applied together, exceptions, at three rates."""
    bench = SpiLinkBench(dut)
    for clocks in (6, 9.37, 60):
        await bench.begin(clocks)
        found = whole(decode(await bench.spi(read(0, 16))).registers)
        assert found[0] == table.crc()
        assert found[3:] == [HZ, 1, 0, 1, 4]
        assert decode(await bench.spi(identify())).information[0] == b"wave haptics"
        value = round(100 * clocks)
        assert not decode(await bench.spi(words(ROOT, [value, 99, 7]))).isError()
        answer = decode(await bench.spi(read(TABLE + 2 * ROOT, 6)))
        assert whole(answer.registers) == [value, 99, 7]
        refused = decode(await bench.spi(words(ROOT, [1, 2, 1 << 31])))
        assert refused.exception_code == VALUE
        assert decode(await bench.spi(write_one(TABLE + 2 * WORDS["restart"].at() + 1, 1)))
        assert await bench.root() == value
        assert not any(bench.word(gate) for gate in GATES)


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def one_transfer_a_loop(dut: object) -> None:
    """Several frames a transfer, with the answers to those before, without a zero within one."""
    bench, rng = SpiLinkBench(dut), random_source("loop")
    await bench.begin()
    expected = b""
    for _ in range(12):
        value = rng.randint(1, 9999)
        frames = words(ROOT, [value]) + read(TABLE + 2 * POSITION, 8) + read(TABLE + 2 * ROOT, 2)
        got = await bench.master.transfer(frames + bytes([FILLER] * 60))
        assert got[: len(expected)] == expected
        # The answers of this transfer may begin in it: then they begin behind zeros.
        if expected:
            assert got[len(expected)] == 0
        await bench.step(LATER)
        rest = got[len(expected) :].strip(b"\0") + await bench.read_out()
        assert decode(rest[:8]).count == 2
        assert len(decode(rest[8:29]).registers) == 8
        assert whole(decode(rest[29:]).registers) == [value]
        # In the next loop they come with its transfer.
        await bench.master.transfer(read(TABLE + 2 * ROOT, 2))
        await bench.step(LATER)
        expected = rest[29:]
    assert await bench.read_out() == expected
    assert (await bench.counters())[1:] == [0, 0, 0]


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def broken_frames(dut: object) -> None:
    """Wrong bits, a transfer that ends too soon or within a byte, a frame in two: counted only."""
    bench, rng = SpiLinkBench(dut), random_source("broken")
    await bench.begin()
    frame = words(ROOT, [77, 5, 6])
    before = await bench.counters()
    asked = 2  # the reading of the counters, and of the register
    for place in range(0, 8 * len(frame), 7):
        flipped = bytearray(frame)
        flipped[place // 8] ^= 1 << place % 8
        await bench.master.transfer(bytes(flipped))
    await bench.lost(frame[:-1], frame[:1], frame[: rng.randrange(2, 14)])
    await bench.lost(frame[:9], frame[9:])  # longer than no silence, but two transfers
    after = await bench.counters()
    assert after[2] == before[2]
    assert after[3] == before[3]
    assert after[1] > before[1] + asked
    # What follows a broken frame is dropped to the transfer's end, and the next one is heard.
    await bench.lost(frame[:-2] + b"\0\0" + frame)
    # Within a byte.
    for bits in (1, 4, 7):
        await bench.master.begin()
        for byte in frame[:-1]:
            await bench.master.byte(byte)
        for place in range(bits):
            await bench.master.bit(frame[-1] >> (7 - place) & 1)
        dut.spi_sclk_i.value = 0
        await bench.master.end()
        await bench.lost()
    last = await bench.counters()
    assert last[2] == after[2] + 3
    # Bytes that no frame begins with, before and behind: to read with.
    assert await bench.root() == 0
    await bench.lost(bytes([FILLER]) + frame, bytes([0xF8]) + frame)
    assert not decode(await bench.spi(frame + bytes([FILLER, 1, 2, 3]))).isError()
    assert await bench.root() == 77
    assert (await bench.counters())[1:] == last[1:]


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def noise(dut: object) -> None:
    """Random transfers, and pins that rattle: nothing is written, and the next frame is heard."""
    bench, rng = SpiLinkBench(dut), random_source("noise")
    await bench.begin()
    frame = words(ROOT, [77])
    for _ in range(60):
        burst = bytearray(rng.randbytes(rng.choice((1, 7, 60, 200))))
        if rng.random() < 0.5:
            burst[:0] = frame[: rng.randrange(len(frame))]
        await bench.master.transfer(bytes(burst))
    for _ in range(3000):
        pin = rng.choice((dut.spi_cs_n_i, dut.spi_sclk_i, dut.spi_mosi_i))
        pin.value = rng.getrandbits(1)
        await bench.master.wait(rng.uniform(0.1, 9))
    dut.spi_sclk_i.value, dut.spi_cs_n_i.value = 0, 1
    await bench.step(LATER)
    await bench.read_out(600)
    assert await bench.root() == 0
    assert not bench.word("running_o")


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def the_uart_beside_it(dut: object) -> None:
    """It has the device until CS falls, and again after a second without a frame over SPI."""
    bench = SpiLinkBench(dut)
    await bench.begin()
    assert not (await bench.ask(words(ROOT, [1]))).isError()
    assert await bench.root() == 1
    # Not heard, however long SPI goes on.
    for value in range(2, 6):
        await bench.line.send(words(ROOT, [99]))
        assert not decode(await bench.spi(words(ROOT, [value]))).isError()
        await bench.step(_P["FALLBACK"] * _P["SILENCE"] // 4)
    assert await bench.root() == 5
    assert not bench.line.heard
    # Answers that nobody reads are dropped with it, and the UART has no part of them.
    await bench.master.transfer(read(0, 24) + read(0, 24))
    await bench.step(FALLBACK)
    assert not bench.line.heard
    assert (await bench.ask(read(TABLE + 2 * ROOT, 2))).registers == [0, 5]
    # The transfer that takes it is heard from its beginning.
    assert await bench.root() == 5
    # CS that stays low gives it back too.
    dut.spi_cs_n_i.value = 0
    await bench.step(FALLBACK)
    assert (await bench.ask(read(TABLE + 2 * ROOT, 2))).registers == [0, 5]
    dut.spi_cs_n_i.value = 1
    await bench.step(20)
    assert not decode(await bench.spi(words(ROOT, [6]))).isError()
    assert await bench.root() == 6


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def a_frame_of_the_uart_under_way(dut: object) -> None:
    """Half a request is dropped by its silence; an answer goes to its end before SPI is heard."""
    bench = SpiLinkBench(dut)
    await bench.begin()
    await bench.line.send(words(ROOT, [3])[:6])
    assert await bench.spi(read(TABLE + 2 * ROOT, 2), after=2 * _P["SILENCE"] + 100) == b""
    assert await bench.root() == 0
    await bench.step(FALLBACK)
    await bench.line.send(read(0, 24))
    for _ in range(20):
        await bench.master.transfer(read(TABLE, 2))
        await bench.step(100)
    await bench.step(2 * _P["SILENCE"])
    assert len(decode(await bench.answer()).registers) == 24
    await bench.read_out(600)
    assert await bench.root() == 0
