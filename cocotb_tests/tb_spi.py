# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_spi.v``: bytes both ways at any rate, glitches, transfers that break off."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source
from cocotb.triggers import RisingEdge
from spi_master import SpiMaster

FASTEST = 6
"""Clocks of a bit, the fewest."""


class SpiBench(Bench):
    async def begin(self, clocks: float = 8, mode: int = 0) -> None:
        self.got: list[tuple[int, int]] = []
        self.transfers = [0, 0]
        if not hasattr(self, "master"):
            dut = self.dut
            self.master = SpiMaster(dut.cs_n_i, dut.sclk_i, dut.mosi_i, dut.miso_o)
        self.master.clocks, self.master.mode = clocks, mode
        await self.start(takes_i=1, tx_valid_i=0, tx_data_i=0, cs_n_i=1, sclk_i=mode & 1)
        await self.step(20)
        if not hasattr(self, "_listeners"):
            self._listeners = [cocotb.start_soon(self._listen()), cocotb.start_soon(self._count())]

    async def _listen(self) -> None:
        while True:
            await RisingEdge(self.dut.rx_valid_o)
            await self._falling
            self.got.append((self.word("rx_data_o"), self.word("rx_error_o")))

    async def _count(self) -> None:
        while True:
            await self._falling
            self.transfers[0] += self.word("begins_o")
            self.transfers[1] += self.word("ends_o")
            if self.word("ends_o"):
                assert not self.word("rx_valid_o")

    async def give(self, data: bytes) -> None:
        """Bytes to be sent, from the clock on that follows the master's own time."""
        await self._falling
        for byte in data:
            assert self.word("tx_ready_o")
            await self.step(tx_valid_i=1, tx_data_i=byte)
        await self.step(4, tx_valid_i=0)

    async def drained(self) -> bytes:
        """What waits, read with zeros."""
        found = bytearray()
        while (byte := (await self.master.transfer(b"\0"))[0]) != 0:
            found.append(byte)
        return bytes(found)


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def every_byte_both_ways(dut: object) -> None:
    """All bytes in one transfer, at the fastest rate and at others, in modes 0 and 3."""
    bench = SpiBench(dut)
    for clocks, mode in ((FASTEST, 0), (6.13, 0), (FASTEST, 3), (7.77, 0), (16.4, 3)):
        await bench.begin(clocks, mode)
        out, back = bytes(range(256)), bytes(reversed(range(256)))
        await bench.give(back)
        assert await bench.master.transfer(out + b"\xff") == back + b"\0", clocks
        assert bench.got == [(data, 0) for data in out + b"\xff"], clocks
        assert bench.transfers == [1, 1]
        assert not bench.word("drives_o")


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def slow_and_in_pieces(dut: object) -> None:
    """A thousand clocks a bit; a transfer for each byte; a pause within one."""
    bench, rng = SpiBench(dut), random_source("slow")
    await bench.begin(1000)
    await bench.give(b"\xa5\x3c")
    assert await bench.master.transfer(b"\x96\x01\x80") == b"\xa5\x3c\0"
    assert bench.got == [(0x96, 0), (1, 0), (0x80, 0)]
    await bench.begin(FASTEST)
    out, back = rng.randbytes(40), bytes(rng.choices(range(1, 256), k=40))
    await bench.give(back)
    found = bytearray()
    for byte in out:
        found += await bench.master.transfer(bytes([byte]))
        await bench.step(rng.randint(1, 30))
    assert bytes(found) == back
    assert bench.got == [(byte, 0) for byte in out]
    assert bench.transfers == [40, 40]
    await bench.begin()
    await bench.give(b"\x42")
    await bench.master.begin()
    bits = [await bench.master.bit(bit) for bit in (1, 1, 0, 0, 1)]
    await bench.step(70_000)
    bits += [await bench.master.bit(bit) for bit in (0, 1, 0)]
    dut.sclk_i.value = 0
    await bench.master.end()
    assert bits == [0, 1, 0, 0, 0, 0, 1, 0]
    assert bench.got == [(0b11001010, 0)]


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def a_byte_that_comes_meanwhile(dut: object) -> None:
    """It is sent from the next byte of the transfer on."""
    bench = SpiBench(dut)
    await bench.begin()
    await bench.master.begin()
    assert await bench.master.byte(0) == 0
    await bench.give(b"\x81\x7e")
    assert [await bench.master.byte(0) for _ in range(4)] == [0, 0x81, 0x7E, 0]
    dut.sclk_i.value = 0
    await bench.master.end()


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def glitches(dut: object) -> None:
    """Pulses shorter than a clock on CS and SCLK, at any time: nothing changes."""
    bench, rng = SpiBench(dut), random_source("glitches")
    await bench.begin(40)

    async def glitch(pin: object, high: int, clocks: float) -> None:
        await bench.master.wait(rng.uniform(5, 10))
        pin.value = 1 - high
        await bench.master.wait(clocks)
        pin.value = high
        await bench.master.wait(rng.uniform(5, 10) - 4.9)

    for _ in range(6):
        bench.got.clear()
        out, back = rng.randbytes(3), bytes(rng.choices(range(1, 256), k=3))
        await bench.give(back)
        await bench.master.begin()
        found = bytearray()
        for byte in out:
            value = 0
            for place in reversed(range(8)):
                dut.mosi_i.value = byte >> place & 1
                dut.sclk_i.value = 0
                await glitch(rng.choice((dut.sclk_i, dut.cs_n_i)), 0, rng.uniform(0.05, 0.95))
                await bench.master.wait(5)
                value = value << 1 | int(dut.miso_o.value)
                dut.sclk_i.value = 1
                pin = rng.choice((dut.sclk_i, dut.cs_n_i))
                await glitch(pin, int(pin is dut.sclk_i), rng.uniform(0.05, 0.95))
                await bench.master.wait(5)
            found.append(value)
        dut.sclk_i.value = 0
        await bench.master.end()
        assert bytes(found) == back
        assert bench.got == [(byte, 0) for byte in out]
        # CS that falls for less than a clock begins nothing; nor does SCLK with CS high.
        before = list(bench.transfers)
        await glitch(dut.cs_n_i, 1, rng.uniform(0.05, 0.95))
        for level in (1, 0, 1, 0):
            dut.sclk_i.value = level
            await bench.step(9)
        assert bench.transfers == before
    assert bench.transfers == [6, 6]


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def transfers_that_break_off(dut: object) -> None:
    """Within a byte: it is none, and the byte that was being read comes again."""
    bench = SpiBench(dut)
    for bits in range(1, 8):
        await bench.begin(FASTEST)
        await bench.give(b"\xb7\x5a")
        await bench.master.begin()
        assert await bench.master.byte(0x12) == 0xB7
        for _ in range(bits):
            await bench.master.bit(1)
        dut.sclk_i.value = 0
        await bench.master.end()
        assert [error for _, error in bench.got] == [0, 1], bits
        assert await bench.master.transfer(b"\x34\xff") == b"\x5a\0"
        assert bench.got[2:] == [(0x34, 0), (0xFF, 0)]
        assert bench.transfers == [2, 2]


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def no_more_than_can_wait(dut: object) -> None:
    """511 bytes, then tx_ready_o is low; each that is read makes room for one."""
    bench, rng = SpiBench(dut), random_source("room")
    await bench.begin(FASTEST)
    data = bytes(rng.choices(range(1, 256), k=511))
    await bench.give(data)
    assert not bench.word("tx_ready_o")
    await bench.step(10, tx_valid_i=1, tx_data_i=0xEE)
    bench.drive(tx_valid_i=0)
    assert await bench.master.transfer(bytes(3)) == data[:3]
    assert bench.word("tx_ready_o")
    await bench.give(b"\x11\x22\x33")
    assert not bench.word("tx_ready_o")
    assert await bench.drained() == data[3:] + b"\x11\x22\x33"
    # What is given and read at once keeps its order.
    expected = bytes(rng.choices(range(1, 256), k=700))
    reading = cocotb.start_soon(bench.master.transfer(bytes(760)))
    await bench.step(60)
    for byte in expected:
        await bench.give(bytes([byte]))
        await bench.step(rng.randint(1, 80))
    assert bytes(byte for byte in await reading if byte) == expected


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def whoever_is_not_taken(dut: object) -> None:
    """Nothing waits, and a transfer is heard from its first byte on or not at all."""
    bench = SpiBench(dut)
    await bench.begin()
    await bench.give(b"\x42\x43")
    bench.drive(takes_i=0)
    await bench.master.begin()
    assert await bench.master.byte(0x77) == 0
    bench.drive(takes_i=1)
    assert await bench.master.byte(0x78) == 0
    dut.sclk_i.value = 0
    await bench.master.end()
    assert bench.got == []
    await bench.give(b"\x44")
    assert await bench.master.transfer(b"\x79\0") == b"\x44\0"
    assert bench.got == [(0x79, 0), (0, 0)]


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def a_reset_in_a_transfer(dut: object) -> None:
    """Nothing of its rest is heard or sent."""
    bench = SpiBench(dut)
    await bench.begin()
    await bench.give(b"\x42\x43")
    await bench.master.begin()
    await bench.master.bit(1)
    await bench.step(3, rst=1)
    bench.drive(rst=0)
    assert [await bench.master.byte(0xFF) for _ in range(3)] == [0, 0, 0]
    dut.sclk_i.value = 0
    await bench.master.end()
    assert bench.got == []
    assert bench.transfers[1] == 0
    assert await bench.master.transfer(b"\x31") == b"\0"
    assert bench.got == [(0x31, 0)]
