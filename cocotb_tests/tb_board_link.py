# SPDX-License-Identifier: Apache-2.0
"""A board with a link: its scene's words at first; some can be changed, and the line arms it."""

from __future__ import annotations

import cocotb
from line_bench import LineBench
from modbus_frames import ADDRESS, TABLE, decode, read, whole, words, write_one
from spi_master import SpiMaster
from tb_board_controller import BOARD, OPTIONAL, SETTLE, TICK, TOP, ZERO_CLOCKS, Board
from uart_line import Line
from wavehaptics.controller.guard import Fault
from wavehaptics.fpga.board_words import CHANGEABLE, first_values
from wavehaptics.words import table
from wavehaptics.words.memory import settings_requests
from wavehaptics.words.modbus import MOST_READ, runs
from wavehaptics.words.table import WORDS

HZ = BOARD.clock_hz
GATES = ("gate_ah_o", "gate_al_o", "gate_bh_o", "gate_bl_o")


class Linked(LineBench):
    """The board's controller at rest, without an ADC."""

    HZ = HZ

    async def begin(self) -> None:
        self.line = Line(self.dut.uart_rx_i, self.dut.uart_tx_o, self.bit_ns(0))
        await self.start(
            start_i=0, stop_i=0, clock_lost_i=0, enc_a_i=0, enc_b_i=0, adc_sdata_i=0, uart_rx_i=1,
            **OPTIONAL,
        )  # fmt: skip
        await self.step(3_000)
        assert not (await self.ask(write_one(11, 3))).isError()
        self.line.bit_ns = self.bit_ns(3)

    async def value(self, address: int) -> int:
        return whole((await self.ask(read(TABLE + 2 * address, 2))).registers)[0]


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def it_begins_with_the_scenes_words(dut: object) -> None:
    bench = Linked(dut)
    await bench.begin()
    found = whole((await bench.ask(read(0, 16))).registers)
    assert (found[0], found[3], found[4]) == (table.crc(), round(HZ), BOARD.fpga.motors)
    assert found[2] >> 27 & 1 == 1, "it is armed over the line"
    settings = settings_requests(first_values(BOARD.words(), 1), BOARD.fpga.legs)
    for first, raws in runs(settings, MOST_READ):
        answer = await bench.ask(read(TABLE + 2 * first, 2 * len(raws)))
        assert whole(answer.registers) == raws, f"{first:#05x}"


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def a_wall_can_be_moved_and_a_limit_not(dut: object) -> None:
    bench = Linked(dut)
    await bench.begin()
    for name in ("wall_min", "eta_contact", "a", "gain", "anchor_reach"):
        word = WORDS[name]
        assert f"{word.block}.{word.group}" in CHANGEABLE
        assert not (await bench.ask(words(word.at(), [100]))).isError(), name
        await bench.step(3_000)
        assert await bench.value(word.at()) == 100
    for name in ("trip", "zero_limit", "dead_clocks", "half_clocks", "min_pulse", "guard_mask"):
        at = WORDS[name].at()
        before = await bench.value(at)
        assert (await bench.ask(words(at, [before]))).exception_code == ADDRESS, name
        assert await bench.value(at) == before
    for name in ("clear", "host_alive", "restart", "zero_start", "arm"):
        await bench.ask(words(WORDS[name].at(), [1]))
        await bench.step(3_000)
        assert not bench.word("running_o")
        assert not any(bench.word(gate) for gate in GATES)


class Armed(LineBench, Board):
    """The board's controller with its ADC, which needs each clock, also while the line is used."""

    HZ = HZ

    async def begin(self, **inputs: int) -> None:
        self.line = Line(self.dut.uart_rx_i, self.dut.uart_tx_o, self.bit_ns(0))
        await super().begin(**inputs)
        await self.step(SETTLE + ZERO_CLOCKS)
        assert not (await self.ask(write_one(11, 3))).isError()
        self.line.bit_ns = self.bit_ns(3)

    async def ask(self, frame: bytes):
        sending = cocotb.start_soon(self.line.send(frame))
        while not sending.done():
            await self.step(16)
        return decode(await self.answer())

    async def give(self, name: str, value: int) -> None:
        assert not (await self.ask(words(WORDS[name].at(), [value]))).isError()
        await self.step(ZERO_CLOCKS)

    async def arm(self) -> None:
        await self.give("arm", 1)
        assert await self.told("armed") == 1
        await self.expect_running()

    async def told(self, name: str) -> int:
        at = TABLE + 2 * WORDS[name].at()
        return whole((await self.ask(read(at, 2))).registers)[0]


ENABLE, FAULT = 1, 2
"""Bits of ``arm_refused``."""


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def the_line_arms_what_the_switch_permits(dut: object) -> None:
    """And disarms, also what the button has armed; the stop goes before all."""
    board = Armed(dut)
    await board.begin()
    await board.expect_off()
    await board.arm()
    await board.give("arm", 0)
    await board.expect_off()
    await board.press()
    await board.expect_running()
    assert await board.told("armed") == 1
    await board.give("arm", 0)
    await board.expect_off()
    await board.arm()
    await board.step(1, stop_i=1)
    await board.expect_off()
    await board.give("arm", 1)
    await board.expect_off()
    assert await board.told("arm_refused") == ENABLE
    await board.step(8, stop_i=0)
    await board.give("arm", 2)
    await board.expect_off()
    await board.arm()
    assert not board.word("fault_o")


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def the_line_forgets_a_fault_that_is_over(dut: object) -> None:
    """Not one that lasts; after it neither line nor button arm before, and nothing by itself."""
    board = Armed(dut)
    await board.begin()
    await board.arm()
    await board.step(40, enc_a_i=1, enc_b_i=1)  # both at once
    assert board.word("fault_o")
    await board.expect_off()
    await board.give("arm", 1)
    await board.press()
    await board.expect_off()
    assert await board.told("arm_refused") == ENABLE | FAULT
    await board.give("clear", 1)
    assert not board.word("fault_o")
    await board.expect_off()
    await board.arm()
    board.code = TOP
    await board.step(3 * TICK)
    assert board.word("fault_o")
    await board.give("clear", 1)
    assert board.word("fault_o"), "the current is still there"
    await board.expect_off()


@cocotb.test(timeout_time=500, timeout_unit="ms", skip=not BOARD.fpga.spi)
async def a_host_mcu_has_the_board_over_spi(dut: object) -> None:
    """It reads and moves a wall, and the serial line isn't heard meanwhile."""
    bench = Linked(dut)
    await bench.begin()
    spi = SpiMaster(dut.spi_cs_n_i, dut.spi_sclk_i, dut.spi_mosi_i, dut.spi_miso_o)
    spi.clocks = 6  # as fast as it may be

    async def ask(frame: bytes):
        await spi.transfer(frame)
        await bench.step(4_000)
        return decode((await spi.transfer(b"\xff" * 80)).strip(b"\0"))

    at = WORDS["wall_min"].at()
    found = whole((await ask(read(0, 16))).registers)
    assert (found[0], found[3]) == (table.crc(), round(HZ))
    assert not (await ask(words(at, [123]))).isError()
    assert whole((await ask(read(TABLE + 2 * at, 2))).registers) == [123]
    await bench.line.send(read(0, 16))
    await bench.step(4_000)
    assert not bench.line.heard
    assert not bench.word("spi_drives_o"), "MISO is left alone while CS is high"


@cocotb.test(timeout_time=500, timeout_unit="ms", skip=not BOARD.fpga.overcurrent)
async def comparators_that_shut_the_gates_are_a_fault(dut: object) -> None:
    """It lasts as long as they do, and is told over the line."""
    board = Armed(dut)
    await board.begin()
    await board.arm()
    assert await board.told("faults") == 0
    await board.step(8, overcurrent_n_i=0)
    assert board.word("fault_o")
    await board.expect_off()
    assert await board.told("faults") == 1 << Fault.DRIVER
    await board.give("clear", 1)
    assert board.word("fault_o"), "they still do"
    await board.step(8, overcurrent_n_i=1)
    await board.give("clear", 1)
    assert not board.word("fault_o")
    await board.arm()
