# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_quadrature.v``: every clock against a model of all its stages."""

from __future__ import annotations

import random
from collections import deque

import cocotb
from bench import Bench, random_source
from wavehaptics.words import formats

SETTLE_CLOCKS = 24
"""Clocks after reset in which the levels are taken without counting, with some to spare."""

_PHASE = {(0, 0): 0, (1, 0): 1, (1, 1): 2, (0, 1): 3}
_LEVELS = {phase: levels for levels, phase in _PHASE.items()}


def levels(position: int) -> tuple[int, int]:
    """A and B of an encoder at ``position`` counts."""
    return _LEVELS[position % 4]


def wrap(position: int) -> int:
    half = 1 << (formats.COUNT_W - 1)
    return (position + half) % (2 * half) - half


class Model:
    """What the block should show, from the levels at the pins at each clock edge."""

    def __init__(self, filter_clocks: int, pins: tuple[int, int], position: int = 0) -> None:
        self.filter_clocks = filter_clocks
        self.synchroniser = deque([pins, pins], maxlen=2)
        self.seen = [deque(maxlen=filter_clocks) for _ in range(2)]
        self.believed = list(pins)
        self.counted = list(pins)
        self.position = position
        self.faults = 0
        self.moves = 0

    @property
    def move(self) -> int:
        """What the next clock counts: 1 forward, 3 backward, 2 an illegal move."""
        return (_PHASE[tuple(self.believed)] - _PHASE[tuple(self.counted)]) % 4

    def clock(self, pins: tuple[int, int], clear: int = 0) -> None:
        move, self.counted = self.move, list(self.believed)
        if clear:
            self.faults = 0
        if move == 2:
            self.faults = min(self.faults + 1, 255)
        elif move:
            self.position = wrap(self.position + (1 if move == 1 else -1))
            self.moves += 1
        for line, level in enumerate(self.synchroniser[0]):
            self.seen[line].append(level)
            if list(self.seen[line]) == [1 - self.believed[line]] * self.filter_clocks:
                self.believed[line] = level
        self.synchroniser.append(pins)


class QuadratureBench(Bench):
    """Drives A and B and compares every clock with the model."""

    def __init__(self, dut: object) -> None:
        super().__init__(dut)
        self.model: Model

    async def begin(self, filter_clocks: int, at: int = 0) -> None:
        a, b = levels(at)
        await self.start(a_i=a, b_i=b, filter_clocks_i=filter_clocks, clear_i=0)
        await self.step(SETTLE_CLOCKS)
        self.model = Model(filter_clocks, (a, b))
        self.check()

    def check(self) -> None:
        shown = self.signed("position_o"), self.word("fault_o"), self.word("faults_o")
        assert shown == (self.model.position, int(self.model.faults > 0), self.model.faults)
        assert self.word("illegal_o") == int(self.model.move == 2)

    async def pins(self, a: int, b: int, clocks: int = 1, clear: int = 0) -> None:
        for _ in range(clocks):
            before = self.model.position
            await self.step(a_i=a, b_i=b, clear_i=clear)
            self.model.clock((a, b), clear)
            self.check()
            assert self.word("moved_o") == int(self.model.position != before)
            if self.model.position != before:
                assert self.word("direction_o") == int(wrap(self.model.position - before) > 0)

    async def turn(self, start: int, end: int, clocks_a_count: int) -> None:
        """Turn from one position to another at an even speed, and let the filter settle."""
        for position in range(start, end, 1 if end > start else -1):
            await self.pins(*levels(position + (1 if end > start else -1)), clocks_a_count)
        await self.pins(*levels(end), self.model.filter_clocks + 4)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_line_at_its_pull_counts_to_and_fro(dut: object) -> None:
    """A wire is off, its input stays high, the rotor turns: within a count, and no fault."""
    bench = QuadratureBench(dut)
    for off in (0, 1):
        await bench.begin(2, at=2)
        places = set()
        for position in range(2, 42):
            pins = list(levels(position))
            pins[off] = 1
            await bench.pins(*pins, 8)
            places.add(bench.model.position)
        assert max(places) - min(places) == 1
        assert bench.model.faults == 0
        assert bench.model.moves > 15


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def counts_at_full_speed(dut: object) -> None:
    """Every count arrives as fast as the filter lets levels through: two in filter + 1 clocks."""
    bench = QuadratureBench(dut)
    for filter_clocks in (1, 2, 3, 8, 15):
        await bench.begin(filter_clocks, at=3)
        fastest = (filter_clocks + 2) // 2
        await bench.turn(3, 203, fastest)
        assert bench.model.position == 200
        await bench.turn(203, -97, fastest)
        assert bench.model.position == -100
        assert bench.model.faults == 0
    # At 30 MHz with a filter of 3 samples: 2 M counts/s are a count in 15 clocks.
    assert (3 + 2) // 2 <= 30e6 / 2e6


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def latency(dut: object) -> None:
    """A pin's edge shows in the position 2 + filter + 1 clocks later."""
    bench = QuadratureBench(dut)
    for filter_clocks in (1, 2, 15):
        await bench.begin(filter_clocks)
        bench.drive(a_i=1)
        clocks = 0
        while bench.signed("position_o") == 0 and clocks < 40:
            await bench.step()
            clocks += 1
        assert clocks == 2 + filter_clocks + 1


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def glitches_are_not_counted(dut: object) -> None:
    """A level shorter than the filter leaves no trace, one as long as it counts."""
    bench = QuadratureBench(dut)
    for filter_clocks in (2, 3, 7):
        await bench.begin(filter_clocks)
        for a, b in ((1, 0), (0, 1), (1, 1)):
            for clocks in range(1, filter_clocks):
                await bench.pins(a, b, clocks)
                await bench.pins(0, 0, filter_clocks + 4)
        assert (bench.model.position, bench.model.faults, bench.model.moves) == (0, 0, 0)
        await bench.pins(1, 0, filter_clocks)
        await bench.pins(0, 0, filter_clocks + 4)
        assert (bench.model.position, bench.model.moves) == (0, 2)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def chatter_on_one_edge(dut: object) -> None:
    """A rotor that trembles on an edge moves by one count to and fro, and nothing adds up."""
    bench = QuadratureBench(dut)
    rng = random_source("chatter")
    await bench.begin(2, at=7)
    for _ in range(300):
        await bench.pins(*levels(8), rng.randint(1, 6))
        await bench.pins(*levels(7), rng.randint(1, 6))
        assert bench.model.position in (0, 1)
    await bench.pins(*levels(7), 6)
    assert bench.model.moves > 100
    assert (bench.model.position, bench.model.faults) == (0, 0)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def illegal_moves_are_tallied(dut: object) -> None:
    """A double change is not counted but latched, cleared on request, and the tally stops."""
    bench = QuadratureBench(dut)
    await bench.begin(2)
    await bench.pins(1, 1, 8)
    assert (bench.model.position, bench.model.faults) == (0, 1)
    await bench.turn(2, 5, 4)
    assert (bench.model.position, bench.model.faults) == (3, 1)
    await bench.pins(*levels(5), clear=1)
    assert bench.model.faults == 0
    for n in range(260):
        await bench.pins(*levels(5 + 2 * n), 3)
    await bench.pins(*levels(5 + 2 * 259), 8)
    assert (bench.model.position, bench.model.faults) == (3, 255)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def an_illegal_move_is_never_lost(dut: object) -> None:
    """A clear in any clock around it: the move has its strobe, and one in its clock stays."""
    bench = QuadratureBench(dut)
    kept = 0
    for at in range(12):
        await bench.begin(2)
        strobes = 0
        for clock in range(12):
            await bench.pins(1, 1, clear=int(clock == at))
            strobes += bench.word("illegal_o")
        assert strobes == 1
        kept += bench.word("fault_o")
    # Cleared where it has come before, and only there.
    assert kept == 2 + 2 + 1


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def wraps(dut: object) -> None:
    """The position wraps at ±2^31."""
    bench = QuadratureBench(dut)
    await bench.begin(2)
    top = (1 << (formats.COUNT_W - 1)) - 2
    await bench.step(position_q=top)
    bench.model.clock(levels(0))
    bench.model.position = top
    bench.check()
    await bench.turn(0, 4, 3)
    assert bench.model.position == top + 4 - (1 << formats.COUNT_W)
    await bench.turn(4, 0, 3)
    assert bench.model.position == top


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def starts_where_the_encoder_rests(dut: object) -> None:
    """No level at reset counts as a move; a reset in the middle of a turn zeroes the position."""
    bench = QuadratureBench(dut)
    for rest in range(4):
        await bench.begin(3, at=rest)
        await bench.turn(rest, rest + 6, 3)
        assert bench.model.position == 6
        await bench.begin(3, at=rest + 6)
        assert bench.signed("position_o") == 0
    # The levels may come as late as the end of the reset, whatever the filter.
    for filter_clocks in (1, 15):
        await bench.start(a_i=0, b_i=0, filter_clocks_i=filter_clocks, clear_i=0)
        await bench.step(40, a_i=1, b_i=1)
        assert (bench.signed("position_o"), bench.word("faults_o")) == (0, 0)
    await bench.begin(3, at=rest)
    # A reset of a single clock is enough where the levels have been still.
    await bench.pins(*levels(rest + 7), 9)
    await bench.step(rst=1)
    await bench.step(30, rst=0)
    assert (bench.signed("position_o"), bench.word("faults_o")) == (0, 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def random_streams(dut: object) -> None:
    """Turning, reversing, glitching and illegal pins: every clock equals the model."""
    bench = QuadratureBench(dut)
    rng = random_source("streams")
    moves = faults = 0
    for filter_clocks in (1, 2, 3, 5):
        await bench.begin(filter_clocks)
        position = 0
        for _ in range(400):
            position += rng.choice((-1, 1, 1))
            await bench.pins(*levels(position), rng.randint(1, 2 * filter_clocks + 2))
            if rng.random() < 0.2:
                await bench.pins(*_random_levels(rng), rng.randint(1, filter_clocks + 1))
        moves += bench.model.moves
        faults += bench.model.faults
    assert moves > 500
    assert faults > 20


def _random_levels(rng: random.Random) -> tuple[int, int]:
    return rng.randint(0, 1), rng.randint(0, 1)
