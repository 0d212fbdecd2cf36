# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_capture.v`` in ``bench_listeners.v``: rows and triggers against a model.

The model is made of their pages. With a credit that lasts, a stream chooses its four words as well.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass, field

import cocotb
from bench import CLOCK_NS, Bench, pack, random_source
from cocotb.triggers import Timer
from simulators import parameters
from wavehaptics.words import formats
from wavehaptics.words.table import WORDS

LONG_CREDIT = 1 << 20
_P = {"N": 1, "DEPTH_LOG2": 6, "CREDIT": 4000, **parameters()}
N, DEPTH = _P["N"], 1 << _P["DEPTH_LOG2"]
BESIDE = _P["CREDIT"] > LONG_CREDIT
DATA_W, COUNT_W = formats.DATA_W, formats.COUNT_W
MEANS = ("voltage", "u", "v", "current", "correction", "offset", "flux", "lag")
WIDTHS = {**dict.fromkeys(MEANS, DATA_W), "position": COUNT_W, "flags": 8}
"""Words of a motor, and their bits."""
CODES = {WORDS[name].at(motor): (name, motor) for name in WIDTHS for motor in range(N)}
CODES |= {WORDS[name].at(): (name, 0) for name in ("bus", "faults")}
NONE = (0, WORDS["wall_min"].at(), WORDS["current"].at(N), 0xFFF)
"""Addresses of no word that is captured."""
REST, FILLS, WAITS, TRIGGERED, DONE = range(5)
START, TRIGGER, STOP = 1, 2, 0
PASS_CLOCKS = 12
"""In which a tick is worked off, after that of its strobe."""
CHOOSES = (8, 4)
"""Clocks in which a reader chooses its words: the capture, and the one beside it."""
BESIDE_CLOCKS = 8
"""In which a stream works a tick off."""


def word32(raw: int) -> int:
    """The 32 bits of a word as a number with a sign."""
    return (raw + (1 << 31)) % (1 << 32) - (1 << 31)


NO_STREAM = {
    "stream_channel_i": 0, "stream_last_i": 3, "stream_shift_i": 0, "stream_decimation_i": 0,
    "stream_hold_i": 0, "stream_write_i": 0, "stream_data_i": 0, "stream_room_i": 1,
}  # fmt: skip


class Turns:
    """Who is given a tick's words (``bench_listeners.v``), the capture at first."""

    def __init__(self) -> None:
        self.chooses = [0, 0]  # clocks left
        self.waits = False  # the other one
        self.busy = 0  # the other one, clocks

    def clock(self, strobe: bool, wanted: bool) -> bool:
        """Whether the capture is given a tick's in this clock."""
        free = strobe and not self.waits and not any(self.chooses)
        other = BESIDE and not self.busy
        first = free and wanted
        second = (free and other and not wanted) or (self.waits and not self.chooses[0])
        self.waits = (first and other) or (self.waits and not second)
        given = zip((first, second), CHOOSES, self.chooses, strict=True)
        self.chooses = [clocks if takes else max(0, left - 1) for takes, clocks, left in given]
        self.busy = BESIDE_CLOCKS if second else max(0, self.busy - 1)
        return first


@dataclass
class Tick:
    """What stood at the block in the clock of a strobe."""

    words: dict[tuple[str, int], int]
    contact: int  # a bit of each motor
    fault: bool


@dataclass
class Settings:
    """Of one capture."""

    codes: list[int] = field(default_factory=lambda: [0] * 8)
    channels: int = 1
    rows: int = 1
    pre: int = 0
    decimation: int = 0
    trigger: int = 0
    level: int = 0

    @property
    def fits(self) -> bool:
        return 1 <= self.channels <= 8 and self.rows * self.channels <= DEPTH and (
            self.pre < self.rows)  # fmt: skip


class Model:
    """Rows by the page of the block: kept as a list, the ring's places by their numbers."""

    def __init__(self) -> None:
        self.state = REST
        self.given = Settings()
        self.all_rows: list[list[int]] = []
        self.ticks: list[Tick] = []
        self.trigger_row: int | None = None
        self.told = False
        self.contact = 0
        self.begun: list[bool] = []

    def obey(self, order: int, given: Settings) -> None:
        if order == START:
            self.state = (FILLS if given.pre else WAITS) if given.fits else REST
            self.given, self.told, self.trigger_row = given, False, None
            self.all_rows, self.ticks, self.begun = [], [], []
        elif order == TRIGGER:
            self.told = True
        elif self.active:
            self.state = DONE

    @property
    def active(self) -> bool:
        return self.state in (FILLS, WAITS, TRIGGERED)

    def tick(self, tick: Tick, taken: bool) -> None:
        """A strobe; ``taken`` if it is worked off."""
        begins, self.contact = bool(tick.contact & ~self.contact), tick.contact
        if not taken:
            return
        self.ticks.append(tick)
        self.begun.append(begins)
        if len(self.ticks) == 1 << self.given.decimation:
            self._row()
            self.ticks, self.begun = [], []

    def _row(self) -> None:
        row = [self._value(code) for code in self.given.codes[: self.given.channels]]
        hit = self.told or self._hit(row[0])
        self.all_rows.append(row)
        if self.state == WAITS and hit:
            self.state, self.trigger_row = TRIGGERED, len(self.all_rows) - 1
        if self.state == FILLS and len(self.all_rows) == self.given.pre:
            self.state = WAITS
        if self.state == TRIGGERED and self.left == 0:
            self.state = DONE

    def _value(self, code: int) -> int:
        if code not in CODES:
            return 0
        name, motor = CODES[code]
        values = [tick.words[name, motor] for tick in self.ticks]
        if name in MEANS or name == "bus":
            return sum(values) >> self.given.decimation
        if name == "position":
            return values[-1]
        found = 0
        for value in values:
            found |= value
        return found

    def _hit(self, value: int) -> bool:
        level, before = self.given.level, self.all_rows[-1][0] if self.all_rows else None
        return {
            0: False, 1: value >= level, 2: value < level,
            3: before is not None and before < level <= value,
            4: before is not None and value < level <= before,
            5: before is not None and value != before,
            6: any(self.begun), 7: any(tick.fault for tick in self.ticks),
        }[self.given.trigger]  # fmt: skip

    @property
    def left(self) -> int:
        after = self.given.rows - self.given.pre
        return after if self.trigger_row is None else (
            after - (len(self.all_rows) - self.trigger_row))  # fmt: skip

    @property
    def told_state(self) -> dict[str, int]:
        """What the block says of itself."""
        if self.state == REST:
            return {"state_o": REST, "count_o": 0, "first_o": 0}
        count = min(len(self.all_rows), self.given.rows)
        full = self.given.rows == count
        first = len(self.all_rows) % self.given.rows if full and count else 0
        return {"state_o": self.state, "count_o": count, "first_o": first, "left_o": self.left}

    def memory(self) -> dict[int, int]:
        """What stands at each place that a row has been written to."""
        found = {}
        for number, row in enumerate(self.all_rows):
            for channel, value in enumerate(row):
                place = number % self.given.rows * self.given.channels + channel
                found[place] = value
        return found


class CaptureBench(Bench):
    """The block with ticks of any length, steps anywhere in them, and the model beside it."""

    def begin_of(self, rng: random.Random) -> None:
        self.rng = rng
        self.model = Model()
        self.given = Settings()
        self.orders: set[int] = set()
        """That wait."""
        self.busy = 0  # clocks until the tick is worked off
        self.hold = 0
        self.taken = 0
        self.seen: set[int] = set()
        self.stepped = self.missed = False
        self.turns = Turns()
        self.quiet = 0.9  # how often words and bits stay as they are
        self.spread = 1 << 20
        self.words = dict.fromkeys(CODES.values(), 0)
        self.fault, self.contact = False, 0

    async def begin(self, rng: random.Random) -> None:
        self.begin_of(rng)
        await self.start(
            tick_i=0, valid_i=0, hold_i=0, write_i=0, write_offset_i=0, data_i=0, read_i=0,
            contact_i=0, fault_i=0, **self._inputs(self._garbage()), **self._settings(Settings()),
            **NO_STREAM,
        )  # fmt: skip
        if BESIDE:
            await self.step(stream_write_i=1, stream_data_i=1)
            await self.step(8, stream_write_i=0)
            assert self.word("stream_state_o") == 2
        assert self.word("state_o") == REST

    def _settings(self, given: Settings) -> dict[str, int]:
        return {
            "channel_i": pack(given.codes, 12), "channels_i": given.channels, "rows_i": given.rows,
            "pre_i": given.pre, "decimation_i": given.decimation, "trigger_i": given.trigger,
            "level_i": given.level,
        }  # fmt: skip

    def _garbage(self) -> dict[tuple[str, int], int]:
        return {key: self.rng.getrandbits(32) for key in self.words}

    def _inputs(self, words: Mapping[tuple[str, int], int]) -> dict[str, int]:
        found = {
            f"{name}_i": pack((words[name, motor] for motor in range(N)), bits)
            for name, bits in WIDTHS.items()
        }
        return {**found, "bus_i": words["bus", 0], "faults_i": words["faults", 0]}

    def _next_words(self) -> None:
        rng = self.rng
        for name, motor in self.words:
            if rng.random() < self.quiet:
                continue
            bits = {"bus": 16, "faults": 16, **WIDTHS}[name]
            if name in ("bus", "faults", "flags"):
                self.words[name, motor] = rng.getrandbits(bits) & rng.getrandbits(bits)
            else:
                half = min(self.spread, 1 << (bits - 1))
                self.words[name, motor] = rng.randint(-half, half - 1)
        touches = (rng.random() < (0.8 if self.contact >> n & 1 else 0.1) for n in range(N))
        self.contact = sum(touch << n for n, touch in enumerate(touches))
        self.fault = rng.random() < 0.1

    def give(self, **values: object) -> Settings:
        """Drive settings."""
        self.given = Settings(**values)
        self.drive(**self._settings(self.given))
        return self.given

    async def clock(self, **inputs: int) -> None:
        """A clock, and what the model makes of it."""
        tick, valid = bool(inputs.get("tick_i")), bool(inputs.get("valid_i"))
        strobe = valid or self.missed
        self.missed = tick and not valid and not self.stepped
        self.stepped = not tick and (valid or self.stepped)
        taken = self.turns.clock(strobe, self.model.active and not self.busy)
        # A start first, which waits for settings as well; what was told before it is forgotten.
        starts = START in self.orders
        obeys = bool(self.orders) and not strobe and not self.busy and not (starts and self.hold)
        if strobe:
            self._next_words()
            # Words that come a clock earlier or later than the strobe are others.
            shown = {"contact_i": self.contact, "fault_i": int(self.fault)}
            await self.step(**self._inputs(self.words), **shown, **inputs)
            self.drive(**self._inputs(self._garbage()), contact_i=self.rng.getrandbits(N),
                       fault_i=self.rng.getrandbits(1))  # fmt: skip
            self.model.tick(Tick(dict(self.words), self.contact, self.fault), taken)
            self.taken += taken
        else:
            await self.step(**inputs)
        if obeys:
            done = {START} if starts else set(self.orders)
            for order in (START, TRIGGER, STOP):
                if order in done:
                    self.model.obey(order, self.given)
            self.orders -= done
        self.seen.add(self.model.state)
        self.busy = PASS_CLOCKS if taken else max(0, self.busy - 1)
        if not self.busy:
            told = self.model.told_state
            assert {name: self.word(name) for name in told} == told
        self.drive(tick_i=0, valid_i=0, write_i=0)
        if inputs.get("write_i"):
            order = inputs["data_i"]
            self.orders = {START} if order == START else self.orders | {order}

    async def tick(self, clocks: int, step: int | None, order: int | None = None) -> None:
        """A tick of so many clocks with its step in one of them; an order in any of them."""
        at = self.rng.randrange(clocks) if order is not None else None
        for n in range(clocks):
            inputs = {"tick_i": int(n == clocks - 1), "valid_i": int(n == step)}
            if n == at:
                inputs |= {"write_i": 1, "data_i": order}
            await self.clock(**inputs)

    async def tick_of(self, clocks: int, **inputs: int) -> None:
        """A clock of ticks of so many, each with its step in the fifth."""
        at = self.clocks % clocks
        await self.clock(tick_i=int(at == clocks - 1), valid_i=int(at == 4), **inputs)

    async def ticks(self, count: int, clocks: int, orders: float = 0.0) -> None:
        """Ticks with steps at one phase for a while, and without for another while."""
        rng, step = self.rng, self.rng.randrange(clocks)
        for _ in range(count):
            if rng.random() < 0.05:
                step = None if step is not None else rng.randrange(clocks)
            order = rng.choice((START, TRIGGER, STOP)) if rng.random() < orders else None
            await self.tick(clocks, step, order)

    async def write(self, order: int) -> None:
        await self.clock(write_i=1, data_i=order)
        while self.orders:
            await self.clock()

    async def rest(self) -> None:
        """Until nobody chooses words any more."""
        for _ in range(PASS_CLOCKS + BESIDE_CLOCKS):
            await self.clock()

    async def read(self, count: int) -> list[int | None]:
        """Words from the first place on, a page of 64 after another, a clock apart.

        None where nothing has been written since the simulation began.
        """
        found: list[int | None] = []
        for first in range(0, count, 64):
            await self.step(write_offset_i=1, data_i=first)
            self.drive(write_offset_i=0)
            here = min(64, count - first)
            for n in range(here + 3):
                if n < here:
                    self.drive(read_i=n)
                if n >= 3:
                    value = self.handle("read_data_o").value
                    found.append(value.to_signed() if value.is_resolvable else None)
                await self.step()
        return found

    async def check_memory(self) -> None:
        found = await self.read(DEPTH)
        wanted = self.model.memory()
        wrong = {n: (found[n], value) for n, value in wanted.items() if word32(value) != found[n]}
        assert not wrong


def random_settings(rng: random.Random, most_ticks: int) -> dict[str, object]:
    """A capture that fits and is over in some ticks, if its trigger comes."""
    channels = rng.randint(1, 8)
    rows = rng.randint(1, DEPTH // channels)
    decimation = rng.randint(0, max(0, (most_ticks // rows).bit_length() - 1))
    codes = [rng.choice([*CODES, *NONE] if rng.random() < 0.2 else [*CODES]) for _ in range(8)]
    return {
        "codes": codes, "channels": channels, "rows": rows, "pre": rng.randrange(rows),
        "decimation": min(decimation, 4), "trigger": rng.randrange(8),
        "level": rng.choice((0, rng.randint(-(1 << 20), 1 << 20), -1, 1)),
    }  # fmt: skip


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def captures_of_every_kind(dut: object) -> None:
    """Random channels, decimations and triggers, at every phase; what is done stays as it is."""
    bench, rng = CaptureBench(dut), random_source("kinds")
    await bench.begin(rng)
    done, kinds = 0, set()
    for number in range(16):
        settings = random_settings(rng, 40) | {"trigger": number % 8}
        bench.quiet = rng.choice((0.0, 0.5, 0.9))
        bench.spread = rng.choice((1 << 20, 1 << 31))
        given = bench.give(**settings)
        await bench.clock()
        await bench.clock()
        await bench.write(START)
        assert bench.model.given is given
        clocks = rng.choice((14, 15, 17, 26))
        for _ in range(6):
            await bench.ticks(rng.randint(1, 40), clocks)
            if bench.model.state == DONE:
                break
        by_itself = bench.model.state == DONE
        if given.trigger == 0 or not by_itself:
            await bench.write(TRIGGER if rng.random() < 0.7 else STOP)
            await bench.ticks((given.rows + 1) << given.decimation, clocks)
        if bench.model.state == DONE:
            done += 1
            kinds.add(given.trigger if by_itself else 0)
        else:
            await bench.write(STOP)
        await bench.rest()
        await bench.check_memory()
        before = await bench.read(DEPTH)
        await bench.ticks(3, clocks)
        await bench.write(TRIGGER)
        await bench.ticks(3, clocks)
        await bench.rest()
        assert await bench.read(DEPTH) == before
    assert done > 13
    assert len(kinds) > 5
    assert bench.taken > 500


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def each_word_in_each_channel(dut: object) -> None:
    """They are looked up by turns: in none of them is one an older one's or another's."""
    bench, rng = CaptureBench(dut), random_source("channels")
    await bench.begin(rng)
    bench.quiet = 0.0
    codes, rows = list(CODES), max(2, DEPTH // 64)
    for first in range(len(codes)):
        turned = [codes[(first + n) % len(codes)] for n in range(8)]
        bench.give(codes=turned, channels=8, rows=rows)
        await bench.clock()
        await bench.clock()
        await bench.write(START)
        await bench.write(TRIGGER)
        await bench.ticks(rows + 1, 15)
        assert bench.model.state == DONE
        await bench.check_memory()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def orders_at_any_time(dut: object) -> None:
    """Start, trigger and stop in any clock, other settings meanwhile, a hold now and then."""
    bench, rng = CaptureBench(dut), random_source("orders")
    await bench.begin(rng)
    bench.quiet = 0.5
    for _ in range(40):
        # They are taken over by a start, which may come at any time from here on.
        while bench.orders or bench.busy:
            await bench.clock()
        settings = random_settings(rng, 10)
        if rng.random() < 0.2:
            settings |= {"rows": rng.randint(1, 2 * DEPTH), "pre": rng.randint(0, DEPTH)}
        if rng.random() < 0.1:
            settings |= {"channels": rng.choice((0, 9, 15))}
        bench.give(**settings)
        bench.hold = 1
        await bench.clock(hold_i=1)
        await bench.clock(hold_i=1)
        bench.hold = 0
        bench.drive(hold_i=0)
        for _ in range(rng.randint(1, 4)):
            await bench.ticks(rng.randint(1, 8), rng.choice((14, 20, 33)), orders=0.15)
    assert bench.seen == {REST, FILLS, WAITS, TRIGGERED, DONE}
    while bench.orders or bench.busy:
        await bench.clock()
    await bench.write(STOP)
    await bench.check_memory()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def orders_that_follow_at_once(dut: object) -> None:
    """A trigger or a stop some clocks behind a start, at every phase of a tick: none is lost.

    Nor is one during a commit, for which a start waits.
    """
    bench, rng = CaptureBench(dut), random_source("at once")
    await bench.begin(rng)
    rows = 3
    bench.give(codes=[WORDS["position"].at()] * 8, channels=1, rows=rows)
    await bench.rest()
    sequences = (START, TRIGGER), (START, STOP), (START, TRIGGER, STOP), (TRIGGER, START)
    for apart in (1, 2, 5, 13):
        for phase in range(14):
            for orders in sequences:
                for hold in (0, 6):
                    while bench.clocks % 14 != phase:
                        await bench.tick_of(14)
                    for order in orders:
                        bench.hold = int(hold > 0)
                        await bench.tick_of(14, write_i=1, data_i=order, hold_i=bench.hold)
                        for _ in range(apart - 1):
                            await bench.tick_of(14)
                    for _ in range(hold):
                        await bench.tick_of(14)
                    bench.hold = 0
                    bench.drive(hold_i=0)
                    for _ in range((rows + 2) * 14):
                        await bench.tick_of(14)
                    if orders[-1] == START:
                        assert bench.model.state == WAITS
                    else:
                        assert bench.model.state == DONE
                    started = orders == (START, TRIGGER)
                    assert (bench.word("count_o") == rows) or not started, (apart, phase)
                    await bench.write(STOP)
                    await bench.rest()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def what_does_not_fit(dut: object) -> None:
    """The largest captures that there are, and the next larger ones, which stay at rest."""
    bench, rng = CaptureBench(dut), random_source("fit")
    await bench.begin(rng)
    for channels in (*range(10), 15):
        most = DEPTH // max(1, channels)
        for rows, pre in ((most, 0), (most, most - 1), (most, most), (most + 1, 0), (0, 0),
                          (65535, 0), (65535, 65534)):  # fmt: skip
            given = bench.give(channels=channels, rows=rows, pre=pre)
            await bench.step(2)
            await bench.write(START)
            fits = 1 <= channels <= 8 and rows == most and pre < most
            assert given.fits == fits
            assert (bench.word("state_o") != REST) == fits
            await bench.write(STOP)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_bit_that_differs(dut: object) -> None:
    """Trigger 5 waits for as long as a word stays, and finds each bit of it."""
    bench, rng = CaptureBench(dut), random_source("differs")
    await bench.begin(rng)
    bench.quiet = 1.0
    position = WORDS["position"].at()
    for bit in range(COUNT_W):
        bench.give(codes=[position] * 8, rows=1, trigger=5)
        await bench.clock()
        await bench.clock()
        await bench.write(START)
        await bench.ticks(4, 14)
        assert bench.model.state == WAITS
        bench.words["position", 0] = word32(bench.words["position", 0] ^ 1 << bit)
        await bench.ticks(3, 14)
        assert bench.model.state == DONE


@cocotb.test(timeout_time=50, timeout_unit="ms",
             skip=BESIDE or not cocotb.SIM_NAME.startswith("Veri"))  # fmt: skip
async def longest_rows(dut: object) -> None:
    """A row of 2^15 ticks: least and greatest words don't wrap in their sums.

    A strobe in every clock is a tick for each that is worked off; beside a stream some are not.
    """
    bench, rng = CaptureBench(dut), random_source("long")
    await bench.begin(rng)
    low, high = -(1 << (DATA_W - 1)), (1 << (DATA_W - 1)) - 1
    bench.give(codes=[WORDS["current"].at(), WORDS["voltage"].at()] + [0] * 6, channels=2, rows=1,
               decimation=15)  # fmt: skip
    await bench.step(2)
    await bench.write(START)
    await bench.write(TRIGGER)
    ends = ((PASS_CLOCKS + 1) << 15) + 1
    bench.drive(current_i=pack([low] * N, DATA_W), voltage_i=pack([high] * N, DATA_W), tick_i=1)
    await Timer((ends - 1) * CLOCK_NS, unit="ns")
    await bench.step()
    assert bench.word("state_o") == TRIGGERED - 1
    await bench.step()
    assert bench.word("state_o") == DONE
    assert await bench.read(2) == [low, high]
