# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_modbus.v`` with ``wh_registers``: pymodbus asks, and only it may act."""

from __future__ import annotations

import random
from collections.abc import Iterator
from importlib.metadata import version

import cocotb
from bench import Bench, random_source
from cocotb.triggers import RisingEdge
from modbus_frames import (
    ADDRESS,
    FAILURE,
    FUNCTION,
    NOT_NOW,
    TABLE,
    UNIT,
    VALUE,
    decode,
    halves,
    identify,
    raw,
    read,
    whole,
    words,
    write,
    write_one,
)  # fmt: skip
from settings_bus import COMMIT, DISCARD
from tb_registers import FLAGS, LIVE_WORDS
from wavehaptics.words import table
from wavehaptics.words.places import Place, places
from wavehaptics.words.table import WORDS, Sizes

SILENCE = 2000
RESYNC = 2 * SILENCE + 60
"""Clocks of silence after which a frame begins in any case."""

SIZES = Sizes()
SETTINGS = list(places(SIZES, "setting"))
COMMANDS = [place for place in places(SIZES, "command") if place.address not in (COMMIT, DISCARD)]
LIVE = list(places(SIZES, "live"))
MASK = 0xFFFFFFFF
KEPT = {*LIVE_WORDS, *FLAGS, "flags", "faults", "running", "ticks", "adc_ready", "overrun",
        "settings_busy", "settings_staged"}  # fmt: skip
"""Live words that ``wh_registers`` has itself, all 0 here."""
OTHER = 0x1234ABCD
"""What the bench gives for all others."""
COUNTERS = 16
"""Register of the first of them: frames, wrong CRCs, framing errors, overruns."""

SIGNED, NARROW, ROOT, U_MAX = (WORDS[n].at() for n in ("zero", "trip", "root", "u_max"))
ZERO_START = WORDS["zero_start"].at()
RANDOM_BYTES = 3000
"""Here, where a simulated clock takes long; :mod:`wavetools.checks.link_soak` sends millions."""


class ModbusBench(Bench):
    """The slave at its bytes. Whatever it sends is collected."""

    async def begin(self, **inputs: int) -> None:
        await self.start(
            rx_valid_i=0, rx_error_i=0, rx_data_i=0, framed_i=0, ends_i=0, tx_ready_i=1, dead_i=0,
            enable_i=0, trap_i=0, commits_i=0, **inputs,
        )  # fmt: skip
        self.sent = bytearray()  # with it what was on its way as the reset came
        if not hasattr(self, "_listener"):
            self._listener = cocotb.start_soon(self._listen())
        for _ in range(20_000):
            if self.word("ready_o"):
                break
            await self.step()
        await self.step(RESYNC)

    async def _listen(self) -> None:
        while True:
            await RisingEdge(self.dut.tx_valid_o)
            await self._falling
            self.sent.append(self.word("tx_data_o"))

    async def takes_at_any_time(self, rng: random.Random) -> None:
        """The UART takes what is sent in some clocks only."""
        while True:
            self.drive(tx_ready_i=rng.getrandbits(1))
            await self._falling

    async def byte(self, data: int, error: int = 0, clocks: int = 14) -> None:
        await self.step(rx_valid_i=1, rx_data_i=data, rx_error_i=error)
        await self.step(clocks, rx_valid_i=0)

    async def send(self, frame: bytes, clocks: int = 14) -> None:
        for data in frame:
            await self.byte(data, clocks=clocks)

    async def answer(self, most: int = 8 * SILENCE) -> bytes:
        """What comes back, until nothing has come for some clocks; nothing if there is none."""
        count, idle = len(self.sent), 0
        for _ in range(most // 20):
            await self.step(20)
            idle = idle + 20 if len(self.sent) == count else 0
            count = len(self.sent)
            if idle >= (200 if count else 5 * SILENCE):
                break
        found, self.sent = bytes(self.sent), bytearray()
        return found

    async def ask(self, frame: bytes):
        await self.send(frame)
        return decode(await self.answer())

    async def refused(self, frame: bytes, code: int) -> None:
        """The frame gets this exception, and nothing was done."""
        before = self.done()
        await self.send(frame)
        answer = await self.answer()
        assert answer == raw(bytes([frame[1] | 0x80, code])), (frame.hex(), answer.hex())
        assert self.done() == before, frame.hex()

    async def silent(self, frame: bytes) -> None:
        """The frame gets no answer, and nothing was done."""
        before = self.done()
        await self.send(frame)
        await self.step(RESYNC)
        assert not self.sent, (frame.hex(), self.sent.hex())
        assert self.done() == before, frame.hex()

    def done(self) -> tuple[int, ...]:
        """Counts of what changed anything."""
        return tuple(self.word(f"{name}_o") for name in ("writes", "commands", "changes"))

    async def registers(self, address: int, count: int, function: int = 3) -> list[int]:
        pdu = await self.ask(read(address, count, function))
        assert not pdu.isError(), (hex(address), count)
        assert len(pdu.registers) == count
        return list(pdu.registers)

    async def values(self, address: int, count: int = 1) -> list[int]:
        return whole(await self.registers(TABLE + 2 * address, 2 * count))

    async def written(self, address: int, values: list[int]) -> None:
        pdu = await self.ask(words(address, values))
        assert not pdu.isError(), (hex(address), pdu)
        assert (pdu.address, pdu.count) == (TABLE + 2 * address, 2 * len(values))

    async def counters(self) -> list[int]:
        return whole(await self.registers(COUNTERS, 8))


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def who_is_there(dut: object) -> None:
    """Identification, by registers and by function 43/14."""
    bench = ModbusBench(dut)
    await bench.begin()
    found = whole(await bench.registers(0, 24))
    assert found[:8] == [table.crc(), 0x20261122, 0xFEDCBA98, 24_000_000, 1, 0, 1, 3]
    assert whole(await bench.registers(0, 16, function=4)) == found[:8]
    objects = {0: b"wave haptics", 1: b"controller", 2: f"v{version('wavehaptics')}".encode()}
    for code in (1, 2, 3):
        for number in (0, 1, 2, 3, 77, 255):
            pdu = await bench.ask(identify(code, number))
            first = number if number < 3 else 0
            assert pdu.information == {n: t for n, t in objects.items() if n >= first}
            assert (pdu.conformity, pdu.more_follows, pdu.read_code) == (1, 0, code)
    for code in (0, 4, 5, 255):
        await bench.refused(raw(bytes([43, 14, code, 0])), VALUE)


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def every_word_is_read(dut: object) -> None:
    """Settings and live words, alone and in the longest runs; every half by itself."""
    bench = ModbusBench(dut)
    await bench.begin()
    known = {place.address: place.word.default & MASK for place in SETTINGS}
    known |= {place.address: 0 if place.word.name in KEPT else OTHER for place in LIVE}
    for address, value in known.items():
        assert await bench.values(address) == [value], hex(address)
    for address in (SIGNED, NARROW, 0x000):
        high, low = halves([known[address]])
        assert await bench.registers(TABLE + 2 * address, 1, 4) == [high]
        assert await bench.registers(TABLE + 2 * address + 1, 1) == [low]
    # Rows without a gap, from each half to each half.
    for first in range(0x100, 0x110):
        for last in (first + 1, first + 7, first + 61):
            inside = list(range(first, last + 1))
            for head in (0, 1):
                for tail in (0, 1):
                    start = TABLE + 2 * first + head
                    count = 2 * len(inside) - head - tail
                    if set(inside) <= set(known):
                        all_halves = halves([known[a] for a in inside])
                        wanted = all_halves[head : len(all_halves) - tail]
                        assert await bench.registers(start, count) == wanted
                    elif last - first < 8:
                        await bench.refused(read(start, count), ADDRESS)
    # As many registers as a frame holds: of live words alone there are enough in a row.
    line = cocotb.start_soon(bench.takes_at_any_time(random_source("line")))
    first = next(a for a in known if set(range(a, a + 63)) <= set(known))
    for count in (64, 124, 125):
        for head in (0, 1):
            wanted = halves([known[first + n] for n in range(63)])[head : head + count]
            assert await bench.registers(TABLE + 2 * first + head, count) == wanted
    line.cancel()
    bench.drive(tx_ready_i=1)
    wanted = [known[WORDS["shape_coefficient"].address]] if SIZES.sections else []
    assert len(known) > 100 + len(wanted)
    assert len(await bench.registers(TABLE + 0x40 * 2, 30)) == 30
    for place in places(SIZES, "command"):
        await bench.refused(read(TABLE + 2 * place.address, 2), ADDRESS)


def sixteen(place: Place, value: int) -> int:
    """What function 6 makes of a value: the word."""
    low = value & 0xFFFF
    return low | (0xFFFF0000 if place.word.fixed.signed and low >> 15 else 0)


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def every_word_is_written(dut: object) -> None:
    """Both ends of its range by function 16, and function 6; what is outside is refused."""
    bench, rng = ModbusBench(dut), random_source("written")
    await bench.begin()
    for place in SETTINGS[:: 1 if len(SETTINGS) < 150 else 2]:
        low, high = place.limits
        for value in (low, high, rng.randint(low, high)):
            await bench.written(place.address, [value & MASK])
            assert await bench.values(place.address) == [value & MASK], place.word.name
        outside = place.outside
        for value in outside[:1] + outside[-1:]:
            await bench.refused(words(place.address, [value & MASK]), VALUE)
        for value in {low & 0xFFFF, high & 0xFFFF, 0xFFFF, 0x8000}:
            word = sixteen(place, value)
            signed = word - (1 << 32) if place.word.fixed.signed and word >> 31 else word
            frame = write_one(TABLE + 2 * place.address + 1, value)
            if low <= signed <= high:
                pdu = await bench.ask(frame)
                assert not pdu.isError(), (place.word.name, hex(value))
                assert pdu.registers == [value]
                assert await bench.values(place.address) == [word], place.word.name
            else:
                await bench.refused(frame, VALUE)


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def commands_act_once(dut: object) -> None:
    """By either function, alone or beside settings; commit and discard are the link's own."""
    bench = ModbusBench(dut)
    await bench.begin()
    for place in COMMANDS:
        before = bench.done()
        assert not (await bench.ask(words(place.address, [1]))).isError()
        assert bench.done() == (before[0], before[1] + 1, before[2]), place.word.name
        assert not (await bench.ask(write_one(TABLE + 2 * place.address + 1, 1))).isError()
        assert bench.done() == (before[0], before[1] + 2, before[2]), place.word.name
        if place.outside:  # some take any 32 bits
            await bench.refused(words(place.address, [place.outside[-1] & MASK]), VALUE)
    assert any(place.outside for place in COMMANDS)
    zero = WORDS["zero_start"].at()
    before = bench.done()
    assert not (await bench.ask(words(zero - 1, [5, 1]))).isError()
    assert bench.done() == (before[0] + 1, before[1] + 1, before[2] + 1)
    await bench.refused(words(zero - 1, [5, 2]), VALUE)
    for own in (COMMIT, DISCARD):
        await bench.refused(words(own, [1]), ADDRESS)
        await bench.refused(write_one(TABLE + 2 * own + 1, 1), ADDRESS)


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def exceptions(dut: object) -> None:
    """1, 2 and 3, in the order that the standard asks in; nothing is done."""
    bench = ModbusBench(dut)
    await bench.begin()
    for function in (0, 1, 2, 5, 7, 8, 11, 15, 17, 20, 22, 23, 24, 44, 0x7F):
        for body in (b"", b"\0\0\0\1", bytes(100)):
            await bench.refused(raw(bytes([function]) + body), FUNCTION)
    await bench.refused(raw(bytes([43, 13, 0, 0, 9])), FUNCTION)
    for function in (3, 4):
        for count in (0, 126, 127, 128, 0x102, 0xFFFF):
            await bench.refused(raw(bytes([function, 0, 0]) + count.to_bytes(2, "big")), VALUE)
        for address in (24, 31, 32, 0x42, 0x1FFF, 0x4000, 0xE000, 0xFFFF, TABLE + 2 * 0x7F):
            await bench.refused(read(address, 1, function), ADDRESS)
        await bench.refused(read(0xFFFF, 125, function), ADDRESS)
        await bench.refused(read(23, 2, function), ADDRESS)
        await bench.refused(read(0x3FFF, 2, function), ADDRESS)
    for address in (0, 1, 8, 9, 11 + 2, 16, 23, 25, TABLE + 2 * 0x7F + 1, 0x4001):
        await bench.refused(write_one(address | 1, 1), ADDRESS)
    await bench.refused(write_one(TABLE + 2 * ROOT, 1), ADDRESS)
    await bench.refused(write(TABLE + 2 * ROOT + 1, [0, 1]), ADDRESS)
    for count, size in (
        (0, 0),
        (1, 2),
        (3, 6),
        (2, 2),
        (2, 6),
        (4, 6),
        (124, 246),
        (258, 4),
        (61, 244),
    ):
        head = (TABLE + 2 * ROOT).to_bytes(2, "big") + count.to_bytes(2, "big")
        await bench.refused(raw(b"\x10" + head + bytes([size]) + bytes(size)), VALUE)
    await bench.refused(words(0x1B0, [0]), ADDRESS)  # a live word
    await bench.refused(words(ROOT, [1, 1, 1, 1, 1, 1, 1, 1, 1]), ADDRESS)


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def words_of_a_frame_belong_together(dut: object) -> None:
    """One change-over for all; with one that is refused, wherever it stands, none is written."""
    bench = ModbusBench(dut)
    await bench.begin()
    walls = WORDS["wall_min"].at()
    before = bench.done()
    await bench.written(walls, [1, 2, 3, 4])
    assert bench.done() == (before[0] + 4, before[1], before[2] + 1)
    for place in range(4):
        values = [0x8000_0000 if n == place else 50 + n for n in range(4)]
        group = WORDS["root"].at()
        await bench.refused(words(group, values[:3] if place < 3 else [1, 1 << 31, 1]), VALUE)
    assert await bench.values(walls, 4) == [1, 2, 3, 4]
    # A word that wants the bridges off, beside one that doesn't.
    bench.drive(enable_i=1)
    await bench.refused(words(WORDS["guard_heat"].at(), [9]), NOT_NOW)
    await bench.refused(write_one(TABLE + 2 * WORDS["guard_heat"].at() + 1, 9), NOT_NOW)
    bench.drive(enable_i=0)
    # The bridges come on between judging and writing: the words before are forgotten.
    heat = WORDS["guard_heat"].at()
    was = await bench.values(heat - 1, 2)
    before = bench.done()
    bench.drive(trap_i=1)
    pdu = await bench.ask(words(heat - 1, [7, 8]))
    assert pdu.isError()
    assert pdu.exception_code == NOT_NOW
    assert bench.done() == (before[0] + 1, before[1], before[2])
    assert await bench.values(heat - 1, 2) == was
    assert await bench.values(WORDS["settings_staged"].at()) == [0]
    bench.drive(trap_i=0)
    await bench.written(walls, [5])
    assert await bench.values(heat - 1, 2) == was
    # Or only as they are to be given.
    bench.drive(trap_i=1)
    pdu = await bench.ask(words(heat, [8]))
    assert pdu.exception_code == NOT_NOW
    bench.drive(trap_i=0)
    assert await bench.values(heat) == was[1:]
    assert await bench.values(WORDS["settings_staged"].at()) == [0]


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def a_memory_that_is_busy_or_gone(dut: object) -> None:
    """Busy for long: 6, to settings alone; without an answer: 4. It goes on afterwards."""
    bench = ModbusBench(dut)
    await bench.begin()
    await bench.written(ROOT, [5])
    bench.drive(enable_i=1, commits_i=1)
    await bench.refused(words(ROOT, [6]), NOT_NOW)
    await bench.refused(words(ZERO_START - 1, [5, 1]), NOT_NOW)  # a setting and a command
    assert await bench.values(ROOT) == [5]
    # Whatever else a master may want waits for nothing. What acts with the bridges off is refused.
    for place in COMMANDS:
        for frame in (words(place.address, [1]), write_one(TABLE + 2 * place.address + 1, 0)):
            if place.word.row.off:
                await bench.refused(frame, NOT_NOW)
                continue
            before, clocks = bench.done(), 0
            await bench.send(frame)
            while bench.done() == before:
                await bench.step()
                clocks += 1
                assert clocks < SILENCE // 2, place.word.name
            assert not decode(await bench.answer()).isError(), place.word.name
            assert bench.done() == (before[0], before[1] + 1, before[2]), place.word.name
    assert (await bench.registers(TABLE + 2 * WORDS["settings_busy"].at() + 1, 1)) == [1]
    assert not (await bench.ask(write_one(11, 1))).isError()
    bench.drive(commits_i=0)
    assert await bench.values(ROOT) == [5]
    bench.drive(dead_i=1)
    for frame in (words(ROOT, [6]), read(TABLE, 2), write_one(TABLE + 2 * ROOT + 1, 6)):
        await bench.refused(frame, FAILURE)
    assert whole(await bench.registers(0, 2)) == [table.crc()]
    bench.drive(dead_i=0)
    await bench.written(ROOT, [7])
    await bench.step(1_000)
    assert await bench.values(ROOT) == [7]


def legal_frames() -> Iterator[bytes]:
    """One of each kind, that would act or be answered."""
    yield read(0, 4)
    yield read(TABLE + 2 * ROOT, 5, 4)
    yield write_one(TABLE + 2 * ROOT + 1, 3)
    yield words(ROOT, [4, 5, 6])
    yield words(U_MAX, [9], unit=0)
    yield words(WORDS["clear"].at(), [1])
    yield identify()


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def truncations(dut: object) -> None:
    """Every beginning of every kind of frame does nothing, and the next frame is understood."""
    bench = ModbusBench(dut)
    await bench.begin()
    before, count = await bench.counters(), 0
    for frame in legal_frames():
        for length in range(1, len(frame)):
            await bench.silent(frame[:length])
            count += 1
    after = await bench.counters()
    assert [now - then for now, then in zip(after, before, strict=True)] == [1, count, 0, 0]


@cocotb.test(timeout_time=2000, timeout_unit="ms")
async def flipped_bits(dut: object) -> None:
    """A single bit of every kind of frame, in each of its bytes: no answer, nothing is done."""
    bench = ModbusBench(dut)
    await bench.begin()
    for frame in legal_frames():
        for place in range(0, 8 * len(frame), 5):
            flipped = bytearray(frame)
            flipped[place // 8] ^= 1 << place % 8
            await bench.silent(bytes(flipped))
        await bench.send(frame)
        assert await bench.answer() or frame[0] == 0


@cocotb.test(timeout_time=2000, timeout_unit="ms")
async def broken_bytes(dut: object) -> None:
    """A byte that is none, at every place: the frame is dropped, and counted as that."""
    bench = ModbusBench(dut)
    await bench.begin()
    before = await bench.counters()
    frame, count = words(ROOT, [4, 5]), 0
    for place in range(len(frame)):
        done = bench.done()
        for at, data in enumerate(frame):
            await bench.byte(data, error=at == place)
        await bench.step(RESYNC)
        assert not bench.sent
        assert bench.done() == done
        count += 1
    after = await bench.counters()
    assert after[2] - before[2] == count
    assert after[1] == before[1]


@cocotb.test(timeout_time=9000, timeout_unit="ms")
async def random_bytes(dut: object) -> None:
    """Noise, with and without gaps, and with beginnings of frames: no word is written."""
    bench, rng = ModbusBench(dut), random_source("noise")
    await bench.begin()
    done, left = bench.done(), RANDOM_BYTES
    heads = [frame[:-2] for frame in legal_frames()]
    while left > 0:
        burst = rng.randbytes(rng.choice((3, 9, 40, 300)))
        if rng.random() < 0.5:
            burst = rng.choice(heads) + burst
        await bench.send(burst, clocks=rng.choice((10, 12, 25)))
        left -= len(burst)
        await bench.step(rng.choice((0, 100, RESYNC)) + 1)
    await bench.step(RESYNC)
    assert bench.done()[0] == done[0]
    assert bench.done()[1:] == done[1:]
    bench.sent.clear()
    assert whole(await bench.registers(0, 2)) == [table.crc()]


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def frames_split_and_joined(dut: object) -> None:
    """Pauses shorter than silence, anywhere; frames without any pause between them."""
    bench, rng = ModbusBench(dut), random_source("split")
    await bench.begin()
    overruns = (await bench.counters())[3]
    frame = words(ROOT, [4, 5, 6])
    for place in range(1, len(frame)):
        done = bench.done()
        await bench.send(frame[:place])
        await bench.step(SILENCE - 40)
        await bench.send(frame[place:])
        assert decode(await bench.answer()).count == 6
        assert bench.done()[0] == done[0] + 3
    # A silence does end a frame, and the rest is none.
    await bench.silent(frame[:5])
    await bench.silent(frame[5:])
    # Broadcasts, other units, and one for this one, back to back and faster than they are done.
    for clocks in (1, 12):
        values = [rng.randint(0, 9999) for _ in range(6)]
        done = bench.done()
        for value in values[:3]:
            await bench.send(words(ROOT, [value], unit=0), clocks=clocks)
            await bench.send(words(ROOT, [77], unit=2), clocks=clocks)
            await bench.send(read(0, 9, unit=9), clocks=clocks)
        await bench.send(read(TABLE + 2 * ROOT, 2), clocks=clocks)
        answer = decode(await bench.answer())
        assert bench.done()[0] == done[0] + 3
        assert len(answer.registers) == 2
        await bench.step(RESYNC)
        assert await bench.values(ROOT) == [values[2]]
    # Two questions at once get two answers.
    first = await bench.ask(read(0, 3))
    await bench.send(read(0, 3) + read(TABLE, 4), clocks=1)
    both = await bench.answer()
    assert decode(both[:11]).registers == first.registers
    assert len(decode(both[11:]).registers) == 4
    assert (await bench.counters())[3] == overruns


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def too_many_bytes(dut: object) -> None:
    """Frames beyond 256 bytes, and more bytes at once than fit: counted, and nothing is done."""
    bench = ModbusBench(dut)
    await bench.begin()
    before = await bench.counters()
    for data in (bytes([100, *bytes(300)]), bytes([16, 0x22, 0x20, 0, 124, 248, *bytes(248)])):
        await bench.silent(raw(data))
    longest = raw(bytes([100, *bytes(251)]))
    assert len(longest) == 255
    await bench.refused(longest, FUNCTION)
    after = await bench.counters()
    assert after[3] - before[3] == 2
    # The slave is kept from taking bytes by an answer that nobody takes.
    bench.drive(tx_ready_i=0)
    await bench.send(read(0, 2))
    await bench.step(200)
    done = bench.done()
    for _ in range(30):
        await bench.send(words(ROOT, [4]), clocks=1)
    bench.drive(tx_ready_i=1)
    await bench.step(RESYNC)
    writes = bench.done()[0] - done[0]
    assert 0 < writes < 30
    await bench.step(60_000)
    bench.sent.clear()
    assert (await bench.counters())[3] == after[3] + 1
    await bench.step(RESYNC)
    await bench.written(ROOT, [5])


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def the_rate(dut: object) -> None:
    """Written by either function, in force after the answer, and given up without good frames."""
    bench = ModbusBench(dut)
    await bench.begin()
    for rate, frame in ((1, write(10, [0, 1])), (2, write_one(11, 2))):
        bench.drive(tx_ready_i=0)
        await bench.send(frame)
        await bench.step(400)
        assert bench.word("tx_valid_o")
        assert bench.word("rate_o") == rate - 1
        bench.drive(tx_ready_i=1)
        assert not decode(await bench.answer()).isError()
        assert bench.word("rate_o") == rate
        assert await bench.registers(10, 2) == [0, rate]
        # A reading that ends before it leaves the next one's quantity alone.
        assert len(await bench.registers(0, 10)) == 10
        assert len(await bench.registers(0, 4)) == 4
    for value in (3, 4, 0x100, 0xFFFF):
        await bench.refused(write_one(11, value), VALUE)
    await bench.refused(write(10, [1, 1]), VALUE)
    for _ in range(4):
        await bench.step(15 * SILENCE)
        assert await bench.registers(10, 2) == [0, 2]
    # Noise and wrong CRCs don't hold it.
    for _ in range(6):
        await bench.silent(read(0, 2)[:-1])
        assert bench.word("rate_o") == 2
    for _ in range(6):
        await bench.silent(read(0, 2)[:-1])
    assert bench.word("rate_o") == 0
    assert await bench.registers(10, 2) == [0, 0]
    await bench.send(write(10, [0, 1], unit=0))
    await bench.step(400)
    assert bench.word("rate_o") == 1
    await bench.begin()
    assert bench.word("rate_o") == 0


@cocotb.test(timeout_time=900, timeout_unit="ms")
async def counters_carry(dut: object) -> None:
    """256 frames and more; a reset at any time leaves a slave that answers."""
    bench, rng = ModbusBench(dut), random_source("carry")
    await bench.begin()
    before = (await bench.counters())[0]
    for _ in range(300):
        await bench.send(identify(), clocks=1)
        await bench.step(900)
    bench.sent.clear()
    assert (await bench.counters())[0] == before + 301
    for _ in range(30):
        await bench.send(words(ROOT, [4, 5, 6]), clocks=2)
        await bench.step(rng.randint(1, 900))
        await bench.begin()
        assert whole(await bench.registers(0, 2)) == [table.crc()]
        assert await bench.values(ROOT) == [0]
    assert UNIT == 1
