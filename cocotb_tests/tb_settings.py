# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_settings.v`` and its groups: every word, at every phase of a tick."""

from __future__ import annotations

import os

from simulators import defines, parameters

os.environ.update({name: str(value) for name, value in defines().items()})

import cocotb
from bench import random_source
from settings_bus import (
    BUSY,
    COMMIT,
    DISCARD,
    DONE,
    NOT_NOW,
    RANGE,
    STAGED,
    UNKNOWN,
    BusBench,
)  # fmt: skip
from wavehaptics.words import formats
from wavehaptics.words.places import Place, places
from wavehaptics.words.table import LEGS, WORDS, Sizes

_P = {"WALLS": 4, "SHAPER": 0, "DELAY_LOG2": 2, "LEGS": LEGS, **parameters()}
# A brushless motor is one, of two axes.
_MOTORS = _P["N"] if _P["LEGS"] == LEGS else 1
SIZES = Sizes(_MOTORS, _P["WALLS"], _P["SHAPER"], _P["DELAY_LOG2"], _P["LEGS"])
N = SIZES.motors
FIRST_CLOCKS = 20_000
MASK = 0xFFFFFFFF
COEF_W, DATA_W = formats.ROOT.width, formats.WAVE.width
WAVE_W = 2 * COEF_W + DATA_W
ROOT, A, U_MAX = (WORDS[name].at() for name in ("root", "a", "u_max"))
SETTINGS = list(places(SIZES, "setting"))


def wants_off(place: Place) -> bool:
    return place.word.change == "off"


class SettingsBench(BusBench):
    """The memory with groups, bridges off at first."""

    async def begin(self, **inputs: int) -> None:
        await super().begin(
            live_i=0, enable_i=0, tick_i=0, hold_i=0, **inputs
        )  # fmt: skip
        for _ in range(FIRST_CLOCKS):
            if self.word("ready_o"):
                break
            await self.step()
        await self.rests()

    async def tick(self) -> None:
        await self.step(tick_i=1)
        self.drive(tick_i=0)

    async def give(self) -> None:
        """Commit, and wait for it."""
        assert await self.write(COMMIT, 1) == DONE
        if self.word("busy_o"):
            await self.tick()
        await self.rests()

    def wave(self, motor: int = 0) -> tuple[int, int, int]:
        words = self.word("wave_o") >> motor * WAVE_W
        coef = (1 << COEF_W) - 1
        return words & coef, words >> COEF_W & coef, words >> 2 * COEF_W & (1 << DATA_W) - 1

    async def memory(self) -> list[int]:
        return [await self.value(place.address) for place in SETTINGS]


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def defaults_after_reset(dut: object) -> None:
    """In memory and groups; also after a reset with other words in force, staged and on the way."""
    bench = SettingsBench(dut)
    bench.drive(rst=1)
    await bench.begin()
    defaults = [place.word.default & MASK for place in SETTINGS]
    for turn in range(3):
        assert await bench.memory() == defaults
        assert bench.wave(N - 1) == (0, 1 << formats.A.fraction, 0)
        assert bench.word("frame_o") & 0xFF == WORDS["sclk_half_clocks"].default
        assert not bench.word("loading_o")
        assert await bench.write(ROOT, 77) == DONE
        if turn:
            assert await bench.write(WORDS["frame_bits"].at(), 9) == DONE
            await bench.give()
            assert await bench.write(U_MAX, 5) == DONE
            assert await bench.write(COMMIT, 1) == DONE
            await bench.step(turn)
        await bench.begin()


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def every_word_is_written_and_read(dut: object) -> None:
    """Both ends of its range and one between; all at once; each is read in force only."""
    bench, rng = SettingsBench(dut), random_source("every word")
    await bench.begin()
    before = await bench.memory()
    for turn in range(3):
        values = []
        for place in SETTINGS:
            low, high = place.limits
            values.append((low, high, rng.randint(low, high))[turn] & MASK)
            assert await bench.write(place.address, values[-1]) == DONE, place.word.name
        assert await bench.memory() == before
        assert await bench.value(STAGED) == 1
        await bench.give()
        assert await bench.value(STAGED) == 0
        assert await bench.memory() == values
        before = values
        found = dict(zip((place.address for place in SETTINGS), values, strict=True))
        for motor in range(N):
            mask = (1 << COEF_W) - 1
            assert bench.wave(motor)[0] == found[WORDS["root"].at(motor)] & mask
            assert bench.wave(motor)[2] == found[WORDS["u_max"].at(motor)] & (1 << DATA_W) - 1
        if SIZES.walls > 1:
            wall = [found[WORDS[f"wall_{name}"].at(0, 1)] for name in ("min", "max", "enable")]
            assert bench.word("wall_o") & (1 << 65) - 1 == wall[0] | wall[1] << 32 | wall[2] << 64
        place_of = 0
        for place in SETTINGS:
            if place.word.group == "frame":
                part = bench.word("frame_o") >> place_of & (1 << place.bits) - 1
                assert part == found[place.address], place.word.name
                place_of += place.bits


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def what_is_out_of_range_changes_nothing(dut: object) -> None:
    """Refused with error 2, bridges on or off; what was there is given with the next commit."""
    bench = SettingsBench(dut)
    await bench.begin()
    before = await bench.memory()
    refused = 0
    for enable in (0, 1):
        bench.drive(enable_i=enable)
        for place in SETTINGS:
            for raw in place.outside:
                assert await bench.write(place.address, raw) == RANGE, (place.word.name, raw)
                assert not bench.word("write_o")
                refused += 1
    assert await bench.value(STAGED) == 0
    await bench.give()
    assert await bench.memory() == before
    assert refused > 4 * len(SETTINGS)
    for place in places(SIZES, "command"):
        for raw in place.outside:
            assert await bench.write(place.address, raw) == RANGE, (place.word.name, raw)
    assert not bench.word("busy_o")


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def what_is_no_word_is_refused(dut: object) -> None:
    """Every address of the bus: error 1 where there is no word, for writing and for reading."""
    bench = SettingsBench(dut)
    await bench.begin()
    known = {
        place.address: kind
        for kind in ("setting", "command", "live")
        for place in places(SIZES, kind)
    }
    bench.drive(live_i=0x12345678)
    for address in range(1 << 12):
        kind = known.get(address, "none")
        raw, error = await bench.read(address)
        assert error == (DONE if kind in ("setting", "live") else UNKNOWN), hex(address)
        if kind == "live" and address not in (BUSY, STAGED):
            assert raw == 0x12345678
        if kind in ("none", "live"):
            assert await bench.write(address, 1) == UNKNOWN, hex(address)
    assert await bench.value(STAGED) == 0


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def words_for_bridges_that_are_off(dut: object) -> None:
    """Refused with error 3 while they run; staged before, they are not given while they run."""
    bench = SettingsBench(dut)
    await bench.begin()
    bench.drive(enable_i=1)
    before = bench.word("frame_o")
    for place in SETTINGS:
        error = await bench.write(place.address, place.limits[1])
        assert error == (NOT_NOW if wants_off(place) else DONE), place.word.name
    assert await bench.write(DISCARD, 1) == DONE
    await bench.rests()
    frame_bits = WORDS["frame_bits"].at()
    bench.drive(enable_i=0)
    assert await bench.write(frame_bits, 33) == DONE
    bench.drive(enable_i=1)
    assert await bench.write(COMMIT, 1) == NOT_NOW
    assert await bench.write(U_MAX, 9) == DONE
    assert await bench.write(COMMIT, 1) == NOT_NOW
    await bench.tick()
    await bench.step(600)
    assert bench.word("frame_o") == before
    assert bench.wave()[2] == 0
    assert await bench.value(frame_bits) == WORDS["frame_bits"].default
    bench.drive(enable_i=0)
    assert await bench.write(COMMIT, 1) == DONE
    # From here on the bridges stay off until all is given, whatever enable does.
    bench.drive(enable_i=1)
    loading = 0
    while bench.word("loading_o"):
        loading += 1
        assert await bench.write(frame_bits, 5) == NOT_NOW
    assert loading > 10
    assert bench.word("frame_o") >> 8 & 63 == 33
    assert bench.wave()[2] == 9
    await bench.rests()
    assert await bench.value(frame_bits) == 33


PERIOD = 60
"""Clocks of a tick in which a group is watched."""
PATIENCE = 15
"""Ticks that a change-over waits for readers, at most."""


class Watch:
    """Ticks in whose clocks ``reads`` words are read: a group has its old words or new ones."""

    def __init__(self, bench: SettingsBench, reads: range) -> None:
        self.bench, self.reads = bench, reads
        self.clock = 0
        self.now = self.new = bench.wave()
        self.changes: set[int] = set()

    @property
    def phase(self) -> int:
        return self.clock % PERIOD

    async def pass_clocks(self, count: int = 1) -> None:
        for _ in range(count):
            phase = self.phase
            hold = phase in self.reads or phase + PERIOD in self.reads
            before = self.bench.wave()
            await self.bench.step(tick_i=phase == PERIOD - 1, hold_i=hold)
            after = self.bench.wave()
            assert all(self.bench.wave(motor) == after for motor in range(N))
            if after != before:
                assert (before, after) == (self.now, self.new), phase
                assert not hold
                self.changes.add(phase)
            self.clock += 1

    async def write(self, address: int, raw: int) -> None:
        self.bench.drive(bus_valid_i=1, bus_write_i=1, bus_address_i=address, bus_data_i=raw)
        for _ in range(20):
            await self.pass_clocks()
            if self.bench.word("bus_ready_o"):
                break
        assert self.bench.word("bus_error_o") == DONE
        self.bench.drive(bus_valid_i=0)
        await self.pass_clocks()


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def a_group_changes_in_one_clock(dut: object) -> None:
    """Commit at every phase of a tick: all or none, just after its end or when nobody reads."""
    bench, rng = SettingsBench(dut), random_source("phases")
    for reads, changes in ((range(10, 50), 0), (range(20, PERIOD + 10), 10)):
        await bench.begin()
        await bench.step(10, enable_i=1)
        watch = Watch(bench, reads)
        for phase in range(PERIOD):
            new = tuple(rng.randint(0, 99) for _ in range(3))
            for motor in range(N):
                for name, raw in zip(("root", "a", "u_max"), new, strict=True):
                    await watch.write(WORDS[name].at(motor), raw)
            while watch.phase != phase:
                await watch.pass_clocks()
            assert bench.wave() == watch.now
            watch.new = new
            await watch.write(COMMIT, 1)
            await watch.pass_clocks(2 * PERIOD)
            assert bench.wave() == new
            watch.now = new
            while bench.word("busy_o"):
                await watch.pass_clocks()
        assert watch.changes == {changes}


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def groups_wait_for_their_own_readers(dut: object) -> None:
    """A group that is held keeps all its words; the memory is busy until the last changed."""
    bench = SettingsBench(dut)
    await bench.begin()
    bench.drive(enable_i=1)
    wall_min = WORDS["wall_min"].at(0, min(1, SIZES.walls - 1))
    for held in range(4):
        raw = 1000 + held
        for address in (ROOT, U_MAX, wall_min):
            assert await bench.write(address, raw) == DONE
        old, old_wall = bench.wave(), bench.word("wall_o") & MASK
        assert await bench.write(COMMIT, 1) == DONE
        await bench.step(3)
        assert bench.wave() == old
        bench.drive(hold_i=held)
        await bench.tick()
        await bench.step(100)
        assert (bench.wave() == old) == bool(held & 1)
        if SIZES.walls > 1:
            assert (bench.word("wall_o") & MASK == old_wall) == bool(held & 2)
        waited_for = (
            held if SIZES.walls > 1 else held & 1
        )  # the second wall isn't there to be written
        assert bench.word("busy_o") or not waited_for
        if waited_for:
            assert await bench.write(ROOT, 1) == NOT_NOW
            assert await bench.write(COMMIT, 1) == NOT_NOW
            assert await bench.write(DISCARD, 1) == NOT_NOW
            assert await bench.value(ROOT) == old[0]
        await bench.step(hold_i=0)
        assert bench.wave()[::2] == (raw, raw)
        await bench.rests()
        assert await bench.value(ROOT) == raw


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def a_reader_that_never_ends_is_waited_for_some_ticks(dut: object) -> None:
    """After PATIENCE of them the words change all the same; an unwritten group waits for none."""
    bench = SettingsBench(dut)
    await bench.begin()
    bench.drive(enable_i=1)
    wall_min = WORDS["wall_min"].at(0, min(1, SIZES.walls - 1))
    for hold, ticks in ((0b01, PATIENCE), (0b10, 0)):
        await bench.rests()
        assert await bench.write(U_MAX, 7 + hold) == DONE
        assert await bench.write(COMMIT, 1) == DONE
        bench.drive(hold_i=hold)
        await bench.tick()
        await bench.step(3)
        for n in range(ticks):
            assert bench.word("now_o") == 0, n
            assert bench.wave()[2] == 0
            await bench.tick()
            await bench.step(20)
        assert bench.wave()[2] == 7 + hold
        assert bench.word("now_o") == 0
    # Discarded words are no reason to wait either.
    await bench.rests()
    assert await bench.write(wall_min, 3) == DONE
    assert await bench.write(DISCARD, 1) == DONE
    await bench.rests()
    assert await bench.write(U_MAX, 30) == DONE
    assert await bench.write(COMMIT, 1) == DONE
    await bench.tick()
    await bench.step(3)
    assert bench.wave()[2] == 30
    bench.drive(hold_i=0)
    await bench.rests()
    assert await bench.value(U_MAX) == 30


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def the_copy_and_discard(dut: object) -> None:
    """A word written once is in both banks; what is discarded is nowhere."""
    bench, rng = SettingsBench(dut), random_source("copies")
    await bench.begin()
    bench.drive(enable_i=1)
    wanted = dict(zip((p.address for p in SETTINGS), await bench.memory(), strict=True))
    free = [place for place in SETTINGS if not wants_off(place)]
    discards = 0
    for _ in range(30):
        chosen = {p.address: rng.randint(*p.limits) & MASK for p in rng.sample(free, 3)}
        for address, raw in chosen.items():
            assert await bench.write(address, raw) == DONE
        if rng.random() < 0.4:
            assert await bench.write(DISCARD, 1) == DONE
            discards += 1
            if rng.random() < 0.5:
                await bench.rests()
        else:
            assert await bench.write(COMMIT, 1) == DONE
            await bench.tick()
            wanted |= chosen
        for place in rng.sample(SETTINGS, 5):  # while it copies, or later
            raw, error = await bench.read(place.address)
            assert (raw, error) == (wanted[place.address], DONE)
        await bench.rests()
    assert discards > 3
    for _ in range(2):
        assert await bench.memory() == list(wanted.values())
        assert bench.wave()[0] == wanted[ROOT] & (1 << COEF_W) - 1
        await bench.give()


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def commands_are_handed_on(dut: object) -> None:
    """Each in one clock, also while words are given; those of the memory are its own."""
    bench = SettingsBench(dut)
    await bench.begin()
    bench.drive(enable_i=1)
    own = (COMMIT, DISCARD)
    for busy in (0, 1):
        if busy:
            assert await bench.write(COMMIT, 1) == DONE
            bench.drive(hold_i=3)
            await bench.tick()
        for place in places(SIZES, "command"):
            if place.address in own:
                continue
            refused = place.word.row.off  # as the bridges are on
            bench.drive(
                bus_valid_i=1, bus_write_i=1, bus_address_i=place.address,
                bus_data_i=place.limits[1],
            )  # fmt: skip
            strobes = 0
            for _ in range(8):
                await bench.step()
                strobes += bench.word("command_o")
                if bench.word("bus_ready_o"):
                    break
            assert bench.word("bus_error_o") == (NOT_NOW if refused else DONE)
            assert strobes == (not refused), place.word.name
            bench.drive(bus_valid_i=0)
            await bench.step()
        assert bench.word("busy_o") == busy
    bench.drive(enable_i=0)
    for place in places(SIZES, "command"):
        if place.word.row.off:
            assert await bench.write(place.address, 1) == DONE, place.word.name
