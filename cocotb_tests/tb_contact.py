# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_contact.v``: equal to :func:`wavehaptics.controller.wave_core.contact_step`."""

from __future__ import annotations

import random
from itertools import product

import cocotb
import numpy as np
from bench import Bench, pack, random_source
from simulators import parameters
from wavehaptics.controller.wave_core import contact_step
from wavehaptics.words import formats

WALLS = parameters().get("WALLS", 4)
SETTLED = 2 * WALLS + 2
"""Clocks after which a position has been looked at, whenever in a round it came."""

LOWEST, HIGHEST = -(1 << (formats.COUNT_W - 1)), (1 << (formats.COUNT_W - 1)) - 1
ETA_CONTACT, ETA_FREE = -formats.ETA.to_raw(1.0), formats.ETA.to_raw(0.5)

Wall = tuple[int, int, bool]

SHAPED = 0xA6C5 & ((1 << WALLS) - 1)
"""Walls that are told apart by what is handed on with them."""


class ContactBench(Bench):
    """Moves the rotor and compares with the model once the walls have been looked at."""

    def __init__(self, dut: object) -> None:
        super().__init__(dut)
        self.walls: list[Wall] = []
        self.hysteresis = False
        self.lingered = 0
        self.state = np.array([-1, 0])
        self.contacts = 0
        self.entries = 0

    def drive_walls(self, walls: list[Wall]) -> None:
        """The first WALLS of ``walls``: lower edge, upper edge, enabled."""
        self.walls = walls[:WALLS]
        self.drive(
            wall_min_i=pack((wall[0] for wall in self.walls), formats.COUNT_W),
            wall_max_i=pack((wall[1] for wall in self.walls), formats.COUNT_W),
            wall_enable_i=sum(int(wall[2]) << n for n, wall in enumerate(self.walls)),
            wall_shaped_i=SHAPED,
        )

    async def begin(self, walls: list[Wall], position: int = 0) -> None:
        self.drive_walls(walls)
        await self.start(
            position_i=position, hold_i=0, eta_contact_i=ETA_CONTACT, eta_free_i=ETA_FREE,
            hysteresis_i=self.hysteresis,
        )  # fmt: skip
        self.state[:] = (-1, 0)
        assert (self.word("contact_o"), self.signed("eta_o")) == (0, ETA_FREE)

    def expected(self, position: int) -> tuple[bool, int]:
        """The model's answer; a disabled wall is one that holds no position."""
        low = np.array([wall[0] for wall in self.walls])
        high = np.array([wall[1] if wall[2] else wall[0] for wall in self.walls])
        before = self.state[0]
        contact, depth = contact_step.py_func(self.state, position, low, high, self.hysteresis)
        inside = [a <= position < b for a, b in zip(low, high, strict=True)]
        self.lingered += contact and not any(inside)
        self.contacts += contact
        self.entries += bool(contact and self.state[0] != before)
        return bool(contact), int(np.clip(depth, LOWEST, HIGHEST))

    def shown(self) -> tuple[bool, int]:
        return bool(self.word("contact_o")), self.signed("depth_o")

    def check(self, position: int) -> None:
        contact, depth = self.expected(position)
        assert self.shown() == (contact, depth), (position, self.walls)
        assert self.signed("eta_o") == (ETA_CONTACT if contact else ETA_FREE)
        if contact:
            assert self.word("wall_o") == self.state[0]
            assert self.word("shaped_o") == SHAPED >> self.state[0] & 1

    async def move(self, position: int, clocks: int = SETTLED) -> None:
        await self.step(clocks, position_i=position)
        self.check(position)


def random_walls(rng: random.Random, span: int) -> list[Wall]:
    walls = []
    for _ in range(WALLS):
        low = rng.randint(-span, span)
        walls.append((low, low + rng.randint(-2, span), rng.random() < 0.8))
    return walls


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def random_walks(dut: object) -> None:
    """Steps and jumps through overlapping, empty and disabled walls, resets in mid-contact."""
    bench = ContactBench(dut)
    rng = random_source("walks")
    resets = 0
    for span, bench.hysteresis in product((4, 12, 60), (False, True)):
        for _ in range(5):
            walls = random_walls(rng, span)
            position = rng.randint(-span, span)
            await bench.begin(walls, position)
            for _ in range(60):
                await bench.move(position, rng.randint(SETTLED, SETTLED + WALLS))
                position += rng.choice((-1, 1, -1, 1, rng.randint(-span, span)))
                if rng.random() < 0.03:
                    resets += bench.shown()[0]
                    await bench.begin(walls, position)
    assert bench.contacts > 50
    assert bench.entries > 10
    assert resets > 0
    assert bench.lingered > 10


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def enters_through_either_edge(dut: object) -> None:
    """The depth keeps the sign of the edge it came in by, right through the wall."""
    bench = ContactBench(dut)
    await bench.begin([(10, 21, True)] * WALLS, 9)
    await bench.move(9)
    for position in range(10, 21):
        await bench.move(position)
        assert bench.shown() == (True, position - 10)
    await bench.move(21)
    assert bench.shown() == (False, 0)
    for position in range(20, 9, -1):
        await bench.move(position)
        assert bench.shown() == (True, position - 21)
    await bench.move(9)
    assert bench.shown() == (False, 0)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def leaves_one_count_later_with_hysteresis(dut: object) -> None:
    """At either edge, for as long as it rests there; the way in is as without."""
    bench = ContactBench(dut)
    bench.hysteresis = True
    await bench.begin([(10, 21, True)] * WALLS, 9)
    for position, contact in ((9, False), (10, True), (9, True), (9, True), (10, True), (9, True),
                              (8, False), (9, False), (22, False), (21, False), (20, True),
                              (21, True), (22, False)):  # fmt: skip
        await bench.move(position)
        assert bench.shown()[0] == contact, position
    assert bench.lingered == 4


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def ends_of_the_count(dut: object) -> None:
    """Walls and positions at the ends of the word; a depth beyond it saturates."""
    bench = ContactBench(dut)
    await bench.begin([(LOWEST, HIGHEST, True)] * WALLS, LOWEST)
    for position in (LOWEST, -1, 0, HIGHEST - 1, HIGHEST, HIGHEST - 1, 1, LOWEST):
        await bench.move(position)
    await bench.begin([(HIGHEST - 1, HIGHEST, True)] * WALLS, HIGHEST)
    for position in (HIGHEST, HIGHEST - 1, HIGHEST, LOWEST):
        await bench.move(position)
    await bench.begin([(HIGHEST, LOWEST, True)] * WALLS, 0)
    for position in (0, LOWEST, HIGHEST):
        await bench.move(position)
        assert bench.shown() == (False, 0)
    assert bench.contacts > 5


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def latency(dut: object) -> None:
    """WALLS + 2 clocks from the position that a round is made for, WALLS - 1 more to its turn."""
    bench = ContactBench(dut)
    slowest, fastest = 0, 1000
    await bench.begin([(5, 9, True)] * WALLS, 0)
    for wait in range(20):
        await bench.move(0, SETTLED + wait)
        bench.drive(position_i=6)
        clocks = 0
        while not bench.word("contact_o") and clocks < 100:
            await bench.step()
            clocks += 1
        slowest, fastest = max(slowest, clocks), min(fastest, clocks)
        bench.check(6)
    assert (fastest, slowest) == (WALLS + 2, 2 * WALLS + 1)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def hold_freezes(dut: object) -> None:
    """While held no output changes; then the rotor's whole way counts, not its last place alone."""
    bench = ContactBench(dut)
    await bench.begin([(5, 20, True)] * WALLS, 0)
    await bench.move(0)
    await bench.step(3 * SETTLED, position_i=6, hold_i=1)
    assert bench.shown() == (False, 0)
    bench.expected(6)
    # In through the lower edge while held, then right to the upper one.
    await bench.step(3 * SETTLED, position_i=19)
    await bench.step(hold_i=0)
    bench.check(19)
    assert bench.shown() == (True, 14)
    await bench.step(3 * SETTLED, position_i=0, hold_i=1)
    assert bench.shown() == (True, 14)
    await bench.step(hold_i=0)
    bench.check(0)
    assert bench.shown() == (False, 0)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def one_clock_without_hold_is_enough(dut: object) -> None:
    """Holds that are locked to the rounds in any phase, as ticks lock them: each wall is felt.

    A clock without hold shows what the newest round found, even if that one ended long before.
    """
    bench = ContactBench(dut)
    rng = random_source("locked")
    found = set()

    def outputs() -> tuple[int, ...]:
        return tuple(bench.word(name) for name in ("contact_o", "wall_o", "depth_o", "eta_o"))

    for period in (WALLS * rng.randint(2, 3), 24, 48, rng.randint(2, 60)):
        for phase in range(min(period, 2 * WALLS)):
            low = rng.choice((1, 1, rng.randint(1, period)))
            bench.hysteresis = rng.random() < 0.5
            await bench.begin(random_walls(rng, 5), 0)
            await bench.move(0)
            await bench.step(phase)
            for _ in range(3):
                position, held = rng.randint(-6, 6), True
                bench.drive(position_i=position)
                end, before = bench.clocks + SETTLED, outputs()
                while bench.clocks < end or held:
                    held = bench.clocks % period >= low
                    await bench.step(hold_i=held)
                    after = outputs()
                    assert after == before or not held
                    before = after
                bench.check(position)
                found.add(bench.shown()[0])
            bench.drive(hold_i=0)
    assert found == {False, True}


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def wall_switched_under_the_rotor(dut: object) -> None:
    """A wall that is switched off lets go; switched on again, the nearer edge is the way in."""
    bench = ContactBench(dut)
    await bench.begin([(5, 20, True)] * WALLS, 4)
    await bench.move(4)
    for position in (5, 10, 18):
        await bench.move(position)
    assert bench.shown() == (True, 13)
    bench.drive_walls([(5, 20, False)] * WALLS)
    await bench.move(18)
    assert bench.shown() == (False, 0)
    bench.drive_walls([(5, 20, True)] * WALLS)
    await bench.move(18)
    assert bench.shown() == (True, -2)
