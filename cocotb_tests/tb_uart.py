# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_uart.v``: bytes both ways, rates that differ, glitches, broken bytes."""

from __future__ import annotations

import cocotb
from bench import CLOCK_NS, Bench, random_source
from cocotb.triggers import RisingEdge
from uart_line import Line


class UartBench(Bench):
    async def begin(self, sixteenths: int, error: float = 0.0) -> None:
        self.got: list[tuple[int, int]] = []
        bit_ns = sixteenths / 16 * CLOCK_NS * (1 + error)
        if hasattr(self, "line"):
            self.line.bit_ns = bit_ns
            self.line.heard.clear()
        else:
            self.line = Line(self.dut.rx_i, self.dut.tx_o, bit_ns)
        await self.start(bit_clocks_i=sixteenths, tx_valid_i=0, tx_data_i=0)
        await self.step(20)
        if not hasattr(self, "_listener"):
            self._listener = cocotb.start_soon(self._listen())

    async def _listen(self) -> None:
        while True:
            await RisingEdge(self.dut.rx_valid_o)
            await self._falling
            self.got.append((self.word("rx_data_o"), self.word("rx_error_o")))

    async def bits(self, count: float) -> None:
        await self.step(round(count * self.line.bit_ns / CLOCK_NS))


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def every_byte_is_heard(dut: object) -> None:
    """All bytes back to back, from 6 clocks a bit on, at rates that are up to 3 % off."""
    bench = UartBench(dut)
    for sixteenths, errors in (
        (96, (-0.02, 0.02)),
        (128, (-0.03, 0.0, 0.03)),
        (267, (-0.03, 0.03)),
    ):
        for error in errors:
            await bench.begin(sixteenths, error)
            await bench.line.send(bytes(range(256)))
            await bench.bits(12)
            assert bench.got == [(data, 0) for data in range(256)], (sixteenths, error)


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def bits_are_read_in_their_middles(dut: object) -> None:
    """To the clock, at any rate: a byte is told so many clocks after its stop bit's middle."""
    bench = UartBench(dut)
    behind = set()
    for sixteenths in (96, 103, 205, 214, 219, 1003, 3334, 33_001, 60_013):
        await bench.begin(sixteenths)
        # Nothing but zeros and the stop bit; the line falls between two clocks.
        dut.rx_i.value = 0
        clocks = 0
        while not bench.word("rx_valid_o"):
            await bench.step()
            clocks += 1
            if clocks == round(9.2 * sixteenths / 16):
                dut.rx_i.value = 1
        assert (bench.word("rx_data_o"), bench.word("rx_error_o")) == (0, 0)
        # The level was seen a clock and a half ago.
        behind.add(clocks - (sixteenths // 2 - 24 + 9 * sixteenths) // 16)
        await bench.bits(3)
    assert len(behind) == 1


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def every_byte_is_sent(dut: object) -> None:
    """All bytes back to back; ready comes with the stop bit's end."""
    bench = UartBench(dut)
    for sixteenths in (96, 107, 112, 128, 3333):
        await bench.begin(sixteenths)
        start = bench.clocks
        for data in range(0, 256, 1 if sixteenths < 1000 else 51):
            bench.drive(tx_valid_i=1, tx_data_i=data)
            while not bench.word("tx_ready_o"):
                await bench.step()
            await bench.step()
            bench.drive(tx_valid_i=0)
        sent = bench.clocks - start
        await bench.bits(12)
        wanted = bytes(range(0, 256, 1 if sixteenths < 1000 else 51))
        assert bench.line.heard == wanted
        assert bench.line.broken == 0
        # Ten bits each, and a clock to take the next one.
        most = (len(wanted) - 1) * (10 * sixteenths / 16 + 2)
        assert most - 2 * len(wanted) < sent <= most + 2


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def what_is_no_byte(dut: object) -> None:
    """Glitches are none; without a stop bit there is an error; a broken line says so once."""
    bench, rng = UartBench(dut), random_source("glitches")
    await bench.begin(256)
    for clocks in (1, 3, 6):
        dut.rx_i.value = 0
        await bench.step(clocks)
        dut.rx_i.value = 1
        await bench.bits(12)
    assert bench.got == []
    for _ in range(20):
        data = rng.randint(0, 255)
        await bench.line.byte(data, stop=0)
        await bench.bits(3)
        await bench.line.byte(data)
        await bench.bits(3)
        assert bench.got[-2:] == [(data, 1), (data, 0)]
    count = len(bench.got)
    dut.rx_i.value = 0
    await bench.bits(100)
    assert bench.got[count:] == [(0, 1)]
    dut.rx_i.value = 1
    await bench.bits(3)
    await bench.line.byte(0x5A)
    await bench.bits(3)
    assert bench.got[-1] == (0x5A, 0)
    # A glitch of a clock within any bit is outvoted.
    for place in range(0, 150, 7):
        sender = cocotb.start_soon(bench.line.byte(0xFF))
        await bench.step(20 + place)
        dut.rx_i.value = 0
        await bench.step(1)
        dut.rx_i.value = 1
        await sender
        await bench.bits(3)
        assert bench.got[-1] == (0xFF, 0), place


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def reset_in_a_byte(dut: object) -> None:
    """What was on its way is lost, nothing else."""
    bench = UartBench(dut)
    for clocks in range(5, 150, 9):
        await bench.begin(128)
        sender = cocotb.start_soon(bench.line.byte(0x00))
        bench.drive(tx_valid_i=1, tx_data_i=0)
        await bench.step(clocks)
        await bench.step(2, rst=1, tx_valid_i=0)
        assert bench.word("tx_o") == 1
        bench.drive(rst=0)
        await sender
        await bench.bits(12)
        got = len(bench.got)
        await bench.line.byte(0xA5)
        await bench.bits(3)
        assert bench.got[got:] == [(0xA5, 0)]
