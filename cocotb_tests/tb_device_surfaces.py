# SPDX-License-Identifier: Apache-2.0
"""Bench of surfaces on ``rtl/wh_device.v``, over its bus, and on ``wh_linked_device.v``.

A frame is written as a host writes it. What it is made of stands in the memory afterwards, and a
surface that the rotors are beyond acts.
"""

from __future__ import annotations

import random

import cocotb
import numpy as np
from bench import random_source
from line_bench import LineBench
from modbus_frames import VALUE, decode, read, whole, write_one
from modbus_frames import words as write_frame
from settings_bus import COMMIT, DONE, BusBench
from simulators import parameters
from uart_line import Line
from wavehaptics.controller import surfaces
from wavehaptics.controller.guard import Fault
from wavehaptics.controller.pins_timing import turns_clocks
from wavehaptics.controller.planes import PLANE_ROW, as_registers, as_writes
from wavehaptics.words import formats, modbus
from wavehaptics.words.table import WORDS

_P = parameters()
N, SURFACES = _P["N"], _P["SURFACES"]
LINKED = "CLOCK_HZ" in _P
ONE = 1 << formats.SURFACE.fraction
PERIOD = turns_clocks(N, surfaces=SURFACES)
ZERO_CLOCKS = ((1 << _P["ZERO_LOG2"]) + 6) * PERIOD
MASK = 0xFFFFFFFF
HOST_TICKS = 40
MOST_CLOCKS = 1_000
"""Of a request that waits for a word's square, and for a copy of the settings."""
SAFE = {"half_clocks": PERIOD, "tick_halves": 1, "sample_clocks": PERIOD, "samples": 1,
        "guard_mask": 0, "guard_damp": 1 << Fault.HOST, "guard_levels": 0,
        "zero_limit": (1 << 23) - 1, "guard_host": HOST_TICKS}  # fmt: skip
STATE = ("surfaces", "surfaces_acting", "surfaces_pending", "surfaces_refused", "surfaces_stamp")
ROW_OF_NONE = 128 + 127

Frame = list[tuple[int, int]]


def frame_of(places: dict[int, int], longer: int = 0) -> Frame:
    """Surfaces ``n`` across motor n, from count ``places[n]`` on, with g as long as a vector may.

    ``longer`` LSBs are added to the last one's.
    """
    planes, vectors = surfaces.new_planes(), surfaces.new_vectors()
    for n, place in places.items():
        planes[n, [surfaces.PRESENT, surfaces.A, surfaces.ACROSS]] = 1, ONE, ONE
        planes[n, surfaces.ETA], planes[n, surfaces.G + n] = -ONE, ONE - 1
        planes[n, surfaces.D] = place << formats.DISTANCE.fraction
        vectors[n, n] = ONE
    if longer:
        vectors[max(places), max(places)] += longer
    return as_registers(planes, vectors, 1 << 20, SURFACES)


def random_frame(rng: random.Random) -> Frame:
    """Any words that are accepted, of any surfaces."""
    planes = np.array([
        [rng.random() < 0.6, *(rng.randint(-ONE, ONE) for _ in range(3)),
         rng.randint(-(1 << 38), (1 << 38) - 1), *(rng.randint(-(1 << 20), 1 << 20)
         for _ in range(3)), rng.randint(-(1 << 20), 1 << 20), rng.randint(0, ONE),
         rng.randint(-ONE, ONE), rng.randint(0, ONE)]
        for _ in range(surfaces.MOST_SURFACES)
    ])  # fmt: skip
    vectors = np.array([
        [rng.randint(-ONE // 2, ONE // 2) for _ in range(3)]
        + [rng.randint(-(1 << 20), 1 << 20) for _ in range(3)]
        for _ in range(surfaces.VECTORS)
    ])  # fmt: skip
    return as_registers(planes, vectors, rng.randint(0, (1 << 29) - 1), SURFACES)


class SurfacesDevice:
    """What both benches do; ``write``, ``value`` and ``give`` are theirs."""

    dut: object

    @property
    def memory(self) -> object:
        ports = self.dut.device if LINKED else self.dut
        return ports.ports.in_space.surface_words

    def kept(self, frame: Frame) -> bool:
        """Whether the memory in force has each word of a frame, but a plane's flag."""
        bank = int(self.memory.bank_q.value) << 10
        flags = {8 * (PLANE_ROW + 2 * n) + 1 for n in range(8)}
        return all(
            int(self.memory.words[bank | address].value)
            == (word & 0xFF if address in flags else word & MASK)
            for address, word in frame
        )

    def present(self) -> int:
        return int(self.memory.present_q.value)

    async def state(self) -> dict[str, int]:
        raise NotImplementedError

    async def expect(self, **wanted: int) -> None:
        found = await self.state()
        assert {name: found[f"surfaces_{name}"] for name in wanted} == wanted, found
        assert found["surfaces"] == SURFACES


class BusDevice(SurfacesDevice, BusBench):
    async def start_up(self, **settings: int) -> None:
        await self.begin(
            enable_i=1, adc_sdata_i=0, enc_a_i=0, enc_b_i=0, bus_i=0, stop_i=0, driver_fault_i=0,
            press_i=0, clear_i=0, zero_start_i=0, stream_room_i=1,
        )  # fmt: skip
        await self.step(3_000)
        await self.set({**SAFE, **settings})

    async def set(self, values: dict[str, int]) -> None:
        for name, raw in values.items():
            assert await self.write(WORDS[name].at(), raw) == DONE, name
        assert await self.write(COMMIT, 1) == DONE
        await self.rests()

    async def arm(self) -> None:
        assert await self.write(WORDS["clear"].at(), 1) == DONE
        await self.step(ZERO_CLOCKS)
        assert await self.write(WORDS["arm"].at(), 1) == DONE
        await self.step(ZERO_CLOCKS)
        assert self.word("running_o")

    async def renew(self) -> None:
        assert await self.write(WORDS["arm"].at(), 2) == DONE

    async def request(self, write: int, address: int, data: int, most: int) -> tuple[int, int]:
        return await super().request(write, address, data, max(most, MOST_CLOCKS))

    async def give(self, frame: Frame, stamp: int) -> None:
        for first, raws in as_writes(frame, stamp):
            await self.give_part(first, raws)

    async def give_part(self, first: int, raws: list[int]) -> None:
        for n, raw in enumerate(raws):
            assert await self.write(first + n, raw) == DONE

    async def state(self) -> dict[str, int]:
        return {name: await self.live(name) for name in STATE}

    async def live(self, name: str) -> int:
        return await self.value(WORDS[name].at())


class LineDevice(SurfacesDevice, LineBench):
    HZ = _P.get("CLOCK_HZ", 0)

    async def start_up(self, **settings: int) -> None:
        self.line = Line(self.dut.uart_rx_i, self.dut.uart_tx_o, self.bit_ns(0))
        await self.start(
            enable_i=1, adc_sdata_i=0, enc_a_i=0, enc_b_i=0, bus_i=0, stop_i=0, driver_fault_i=0,
            press_i=0, clear_i=0, zero_start_i=0,
        )  # fmt: skip
        await self.step(6_000)
        assert not (await self.ask(write_one(11, 3))).isError()
        self.line.bit_ns = self.bit_ns(3)
        wanted = {WORDS[name].at(): raw for name, raw in {**SAFE, **settings}.items()}
        for first, raws in modbus.runs(wanted.items(), modbus.MOST_WRITTEN):
            assert not (await self.ask(write_frame(first, raws))).isError()
        await self.command("clear")
        await self.step(ZERO_CLOCKS)
        await self.command("arm")
        await self.step(ZERO_CLOCKS)
        assert self.word("running_o")

    async def ask(self, frame: bytes) -> object:
        """Each word of a frame takes three passes."""
        await self.line.send(frame)
        await self.step(30 * len(frame))
        return decode(await self.answer())

    async def command(self, name: str, value: int = 1) -> None:
        assert not (await self.ask(write_frame(WORDS[name].at(), [value]))).isError()

    async def give(self, frame: Frame, stamp: int) -> None:
        for first, raws in as_writes(frame, stamp):
            assert not (await self.ask(write_frame(first, raws))).isError()
        await self.step(2 * PERIOD)

    async def state(self) -> dict[str, int]:
        first = modbus.word_register(WORDS[STATE[0]].at())
        return dict(
            zip(STATE, whole((await self.ask(read(first, 2 * len(STATE)))).registers), strict=True)
        )


@cocotb.test(timeout_time=100, timeout_unit="ms", skip=LINKED)
async def frames_over_the_bus(dut: object) -> None:
    """Random frames, as fast as the bus takes them, while settings are copied: each is kept."""
    bench, rng = BusDevice(dut), random_source("frames")
    await bench.start_up()
    await bench.expect(acting=0, pending=0, refused=0, stamp=0)
    for turn in range(8):
        if turn == 2:
            await bench.arm()
        frame, stamp = random_frame(rng), rng.getrandbits(16)
        if turn % 2:
            assert await bench.write(WORDS["eta_free"].at(), ONE - turn) == DONE
            assert await bench.write(COMMIT, 1) == DONE
        before = bench.present()
        parts = as_writes(frame, stamp)
        for first, raws in parts[:-1]:
            await bench.give_part(first, raws)
            assert bench.present() == before
        first, raws = parts[-1]
        await bench.give_part(first, raws)
        if turn > 1:
            await bench.renew()
        await bench.step(2 * PERIOD)
        written = {address for address, _ in frame}
        there = [n for n in range(8) if 8 * (PLANE_ROW + 2 * n) in written]
        assert bench.present() == sum(1 << n for n in there)
        assert bench.kept(frame), turn
        await bench.expect(pending=0, refused=0, stamp=stamp)
    assert bench.word("running_o")
    for turn in range(4):
        await bench.give(frame_of({0: 500}), turn)
        assert not await bench.live("surfaces_refused")
        await bench.step(2 * PERIOD)
        await bench.renew()


@cocotb.test(timeout_time=100, timeout_unit="ms", skip=LINKED)
async def a_frame_is_whole_or_nothing(dut: object) -> None:
    """What is refused changes nothing, and says where; what was begun and left is forgotten."""
    bench = BusDevice(dut)
    await bench.start_up()
    await bench.arm()
    good = frame_of({0: -9, 1: 7})

    async def same(refused: int) -> None:
        await bench.renew()
        await bench.step(3 * PERIOD)
        await bench.expect(acting=1, pending=0, refused=refused, stamp=11)
        assert bench.present() == 3
        assert bench.kept(good)

    await bench.give(good, 11)
    await same(0)
    # A vector that is longer than 1 by its last place, and values that give out energy.
    await bench.give(frame_of({0: 5, 1: 5}, longer=1), 12)
    await same(128 + 1)
    place = {8 * (PLANE_ROW + 2) + 9: -1, 8 * (PLANE_ROW + 3) + 2: ONE + 1}
    for address, raw in place.items():
        bad = [(at, raw if at == address else word) for at, word in frame_of({0: 5, 1: 5})]
        await bench.give(bad, 13)
        await same(128 + (address >> 3))
    # A commit alone, one in the midst of a run, words without a begin, a part that comes twice.
    commit = WORDS["surface_commit"].at()
    assert await bench.write(commit, 14) == DONE
    await same(ROW_OF_NONE)
    first, raws = as_writes(frame_of({0: 5}), 15)[0]
    await bench.give_part(first, raws[:-2])
    assert await bench.write(commit, 15) == DONE
    await same(ROW_OF_NONE)
    await bench.give_part(first, [raws[0] & ~(1 << 31), *raws[1:]])
    await same(ROW_OF_NONE)
    # One that began and was left: the next frame has none of its surfaces.
    await bench.give_part(first, raws[:-1])
    await same(ROW_OF_NONE)
    await bench.give(frame_of({1: -3}), 16)
    await bench.step(3 * PERIOD)
    await bench.expect(acting=1, pending=0, refused=0, stamp=16)
    assert bench.present() == 2
    # A frame that comes twice, as when its answer was lost; the end of a longer one twice.
    await bench.give(good, 11)
    await bench.step(3 * PERIOD)
    await bench.give(good, 11)
    await same(0)
    if SURFACES > 2:
        more = frame_of({0: 5, 1: 5, 2: 5})
        *parts, last = as_writes(more, 17)
        assert parts
        for part in (*parts, last):
            await bench.give_part(*part)
        await bench.step(3 * PERIOD)
        await bench.expect(acting=0, refused=0, stamp=17)
        await bench.give_part(*last)
        await bench.step(3 * PERIOD)
        await bench.expect(acting=0, refused=ROW_OF_NONE, stamp=17)
        assert bench.present() == 7
    # Two frames of one period: the second is refused.
    await bench.give(good, 11)
    await bench.step(3 * PERIOD)
    first, raws = as_writes(frame_of({0: 5}), 18)[0]
    await bench.give_part(first, raws[:-1])
    while not int(bench.memory.take_i.value):
        await bench.step()
    assert await bench.write(commit, 18) == DONE
    assert await bench.live("surfaces_pending")
    assert await bench.write(commit, 19) == DONE
    await bench.step(3 * PERIOD)
    await bench.expect(acting=0, pending=0, refused=ROW_OF_NONE, stamp=18)


@cocotb.test(timeout_time=100, timeout_unit="ms", skip=LINKED)
async def a_host_that_is_silent(dut: object) -> None:
    """Surfaces stay, or with the fault HOST the ports damp; an accepted frame is a sign of life."""
    bench = BusDevice(dut)
    for mask in (0, 1 << Fault.HOST):
        await bench.start_up(guard_mask=mask)
        await bench.arm()
        assert await bench.write(WORDS["clear"].at(), 1) == DONE
        for turn in range(6):
            await bench.give(frame_of({0: -9}), turn)
            assert await bench.write(WORDS["clear"].at(), 1) == DONE
            await bench.step(HOST_TICKS // 2 * PERIOD)
            await bench.renew()
            await bench.expect(acting=1, stamp=turn)
        assert not await bench.live("faults") & mask
        # A refused frame is none.
        await bench.give(frame_of({0: -9}, longer=1), 9)
        for _ in range(4):
            await bench.step(HOST_TICKS // 2 * PERIOD)
            await bench.renew()
        assert await bench.live("faults") == mask
        assert bench.word("running_o")
        await bench.expect(acting=0 if mask else 1)
    # A frame and `clear` end it; meanwhile frames are taken.
    await bench.give(frame_of({0: -7}), 10)
    await bench.expect(acting=0, pending=0, refused=0, stamp=10)
    assert await bench.write(WORDS["clear"].at(), 1) == DONE
    await bench.step(3 * PERIOD)
    await bench.expect(acting=1)


@cocotb.test(timeout_time=400, timeout_unit="ms", skip=not LINKED)
async def over_the_line(dut: object) -> None:
    """A frame in one write of Modbus makes a contact; a bad one changes nothing; silence damps."""
    bench = LineDevice(dut)
    await bench.start_up(guard_mask=1 << Fault.HOST, guard_host=3_000)
    assert len(as_writes(frame_of({0: -9, 1: 7}), 1)) == 1
    await bench.command("clear")
    await bench.give(frame_of({0: -9, 1: 7}), 0xABCD)
    await bench.expect(acting=1, pending=0, refused=0, stamp=0xABCD)
    await bench.give(frame_of({0: -9, 1: -7}), 2)
    await bench.expect(acting=2, refused=0, stamp=2)
    await bench.give(frame_of({0: 9, 1: 7}, longer=1), 3)
    await bench.expect(acting=2, refused=128 + 1, stamp=2)
    await bench.command("clear")
    await bench.give(frame_of({0: 9, 1: 7}), 4)
    await bench.expect(acting=0, refused=0, stamp=4)
    # A write that one register refuses is none: the stamp has 16 bits.
    ((first, raws),) = as_writes(frame_of({0: -9}), 1 << 16)
    answer = await bench.ask(write_frame(first, raws))
    assert answer.isError()
    assert answer.exception_code == VALUE
    await bench.expect(acting=0, refused=0, stamp=4)
    await bench.give(frame_of({0: -9}), 5)
    await bench.expect(acting=1, refused=0, stamp=5)
    await bench.command("arm", 2)
    await bench.step(3_100 * PERIOD)
    await bench.expect(acting=0, stamp=5)
    faults = await bench.ask(read(modbus.word_register(WORDS["faults"].at()), 2))
    assert whole(faults.registers) == [1 << Fault.HOST]
    assert bench.word("running_o")
    await bench.give(frame_of({0: -9}), 6)
    await bench.command("clear")
    await bench.step(3 * PERIOD)
    await bench.expect(acting=1, refused=0, stamp=6)
