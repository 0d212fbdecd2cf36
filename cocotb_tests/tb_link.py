# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_linked_device.v``: the whole at its pins, asked by pymodbus over the line."""

from __future__ import annotations

import cocotb
from bench import random_source
from line_bench import LineBench
from modbus_frames import TABLE, identify, raw, read, whole, words, write_one
from simulators import parameters
from uart_line import Line
from wavehaptics.words import table
from wavehaptics.words.places import places
from wavehaptics.words.table import WORDS

_P = {"N": 1, "WALLS": 4, **parameters()}
HZ = _P["CLOCK_HZ"]
GATES = ("gate_ah_o", "gate_al_o", "gate_bh_o", "gate_bl_o")
ROOT = WORDS["root"].at()


class LinkBench(LineBench):
    """The device on its line."""

    HZ = HZ

    async def begin(self) -> None:
        self.line = Line(self.dut.uart_rx_i, self.dut.uart_tx_o, self.bit_ns(0))
        await self.start(
            enable_i=0, adc_sdata_i=0, enc_a_i=0, enc_b_i=0, bus_i=0, stop_i=1,
            driver_fault_i=(1 << _P["N"]) - 1, press_i=0,
        )  # fmt: skip
        await self.step(6_000)

    def last_root(self) -> int:
        """s of the last motor as it is in force."""
        in_force = self.dut.device.registers.in_force_ram.memory
        return int(in_force[ROOT - 0x100 + 0x100 * (_P["N"] - 1)].value)

    async def values(self, address: int, count: int = 1) -> list[int]:
        return whole((await self.ask(read(TABLE + 2 * address, 2 * count))).registers)


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def the_device_answers(dut: object) -> None:
    """Identification, a setting at its port, and bridges that the line can't switch on."""
    bench = LinkBench(dut)
    await bench.begin()
    found = whole((await bench.ask(read(0, 16))).registers)
    options = _P["N"] | _P["WALLS"] << 4 | 2 << 11 | 1 << 18
    options |= 1 << 19 | 1 << 20 | 1 << 25 | 1 << 27
    assert found == [table.crc(), 0, options, HZ, _P["N"], 0, 1, 4]
    assert (await bench.ask(identify())).information[0] == b"wave haptics"
    if _P["N"] == 1:  # whose work a tick of the table's defaults is long enough for
        assert await bench.values(WORDS["overrun"].at()) == [0]
    motor = _P["N"] - 1
    assert not (await bench.ask(words(WORDS["root"].at(motor), [0x1234, 99]))).isError()
    assert not (await bench.ask(write_one(TABLE + 2 * WORDS["u_max"].at(motor) + 1, 7))).isError()
    await bench.step(3_000)
    assert await bench.values(WORDS["root"].at(motor), 3) == [0x1234, 99, 7]
    assert bench.last_root() == 0x1234
    for name in ("clear", "host_alive", "restart", "zero_start", "arm"):
        assert not (await bench.ask(words(WORDS[name].at(), [1]))).isError()
        assert not bench.word("running_o")
        assert not any(bench.word(gate) for gate in GATES)


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def a_setting_and_its_port(dut: object) -> None:
    """One question and one answer: what is written is at its port."""
    bench = LinkBench(dut)
    await bench.begin()
    assert not (await bench.ask(words(WORDS["root"].at(_P["N"] - 1), [0x1234]))).isError()
    await bench.step(3_000)
    assert bench.last_root() == 0x1234


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def words_over_the_line(dut: object) -> None:
    """Any words are read back as they were given, with sign; one out of range changes none.

    Of the pins SCLK is counted meanwhile: frames go on.
    """
    bench, rng = LinkBench(dut), random_source("words")
    await bench.begin()
    motor = _P["N"] - 1
    root, wall = WORDS["root"].at(motor), WORDS["wall_min"].at(motor)
    sizes = table.Sizes(_P["N"], _P["WALLS"])
    most = [p.limits[1] for p in places(sizes, "setting") if root <= p.address < root + 3]
    for _ in range(4):
        three = [rng.randint(0, limit) for limit in most]
        assert not (await bench.ask(words(root, three))).isError()
        assert await bench.values(root, 3) == three
        walls = [rng.getrandbits(32) for _ in range(_P["WALLS"])]
        assert not (await bench.ask(words(wall, walls))).isError()
        assert await bench.values(wall, _P["WALLS"]) == walls
        assert (await bench.ask(words(root, [1, 2, 1 << 31]))).isError()
        assert await bench.values(root, 3) == three
    assert not (await bench.ask(write_one(TABLE + 2 * wall + 1, 0xFFF0))).isError()
    assert await bench.values(wall) == [0xFFFFFFF0]
    clocks = _P["SILENCE"]
    rises = 0
    for _ in range(clocks):
        before = bench.word("adc_sclk_o")
        await bench.step()
        rises += bench.word("adc_sclk_o") > before
    frame, tick = WORDS["frame_bits"].default, WORDS["half_clocks"].default
    assert abs(rises - clocks // tick * frame) <= frame


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def every_rate(dut: object) -> None:
    """Up, with the answer at the old rate, between any two; back without good frames."""
    bench = LinkBench(dut)
    await bench.begin()
    for rate in (1, 3, 2, 0, 3):
        assert not (await bench.ask(write_one(11, rate))).isError()
        bench.line.bit_ns = bench.bit_ns(rate)
        for _ in range(3):
            assert (await bench.ask(read(10, 2))).registers == [0, rate]
    # Nobody speaks for FALLBACK silences.
    await bench.step(_P["SILENCE"] * (_P["FALLBACK"] + 2))
    bench.line.bit_ns = bench.bit_ns(0)
    assert (await bench.ask(read(10, 2))).registers == [0, 0]


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def a_wrong_rate_and_noise(dut: object) -> None:
    """Frames at other rates and a line that rattles do nothing; errors are counted."""
    bench, rng = LinkBench(dut), random_source("noise")
    await bench.begin()
    before = await bench.values(ROOT, 3)
    counted = whole((await bench.ask(read(16, 8))).registers)
    for factor in (0.5, 0.8, 0.9, 1.12, 1.3, 2.0):
        bench.line.bit_ns = bench.bit_ns(0) * factor
        await bench.line.send(words(ROOT, [4, 5, 6]))
        await bench.step(2 * _P["SILENCE"] + 200)
    for _ in range(400):
        dut.uart_rx_i.value = rng.randint(0, 1)
        await bench.step(rng.randint(1, 900))
    dut.uart_rx_i.value = 1
    bench.line.bit_ns = bench.bit_ns(0)
    await bench.step(2 * _P["SILENCE"] + 4_000)
    bench.line.heard.clear()
    assert await bench.values(ROOT, 3) == before
    after = whole((await bench.ask(read(16, 8))).registers)
    assert after[0] == counted[0] + 2
    assert after[1] + after[2] > counted[1] + counted[2] + 4
    assert (await bench.ask(raw(b"\x63"))).exception_code == 1
