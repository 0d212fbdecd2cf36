# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_magnet_angle.v``: every turn, and the tick in which the magnets are found.

The model is :func:`wavehaptics.controller.magnet_angle.magnet_angle_step`.
"""

from __future__ import annotations

import os
import random

import cocotb
from bench import Bench, pack, random_source

os.environ["NUMBA_DISABLE_JIT"] = "1"  # compiling would take longer than it saves

from wavehaptics.controller import magnet_angle, rotor_flux
from wavehaptics.words import formats

CELL = 1 << rotor_flux.SINE_Q
CELL_W = rotor_flux.SINE_Q + 2
JUMP = 1 << magnet_angle.SEEN_Q
TURN_CLOCKS = 5
"""Clocks from a tick's end to the turn."""
WORD = 1 << (formats.DATA_W - 1)


class AngleBench(Bench):
    """Gives ticks and takes turns, and compares them with the model."""

    async def begin(self, *, find: bool, turn: int, rest: int, position: int) -> None:
        self.turn, self.rest = turn, rest
        self.state = magnet_angle.new_state(not find, position)
        await self.start(
            find_i=find, count_angle_i=turn, rest_ticks_i=rest, position_i=position, done_i=0,
            contact_i=0, cell_i=0, flux_i=0, turned_i=0,
        )  # fmt: skip
        assert self.word("found_o") == (not find)
        assert not self.word("turn_o")

    async def tick(
        self, position: int, contact: bool, cells: tuple[int, int], chi: tuple[int, int], wait: int
    ) -> bool:
        """A tick whose turn is taken ``wait`` clocks after it is there; whether it counted."""
        before = int(self.state[magnet_angle.KNOWN])
        moved = position - int(self.state[magnet_angle.POSITION])
        counted = (
            not before
            and moved != 0
            and (moved < 0) == bool(self.state[magnet_angle.BACK])
            and self.state[magnet_angle.TICKS] < self.rest
            and not contact
        )
        by = magnet_angle.magnet_angle_step(
            self.state, self.turn, self.rest, position, contact,
            *(cell << rotor_flux.SHIFT for cell in cells), *chi,
        )  # fmt: skip
        found = int(self.state[magnet_angle.KNOWN])
        self.drive(
            done_i=1, position_i=position, contact_i=contact, cell_i=pack(cells, CELL_W),
            flux_i=pack(chi, formats.DATA_W),
        )  # fmt: skip
        await self.step()
        self.drive(done_i=0)
        clocks, begun = 1, 0
        while self.word("busy_o"):
            begun += self.word("begin_o")
            assert clocks < 50
            turns = bool(self.word("turn_o"))
            if turns:
                assert clocks >= TURN_CLOCKS
                assert self.word("by_o") == by
                self.drive(turned_i=wait == 0)
                wait -= 1
            await self.step()
            clocks += 1
            self.drive(turned_i=0)
        if counted:
            assert clocks > TURN_CLOCKS
        else:
            assert by == 0
            assert clocks <= 2
        assert begun == found - before
        assert self.word("found_o") == found
        return counted


def any_chi(rng: random.Random, near: int) -> int:
    """A word near another one, or any."""
    far = rng.choice((0, 0, rng.randint(-JUMP // 4, JUMP // 4), rng.randint(-3 * JUMP, 3 * JUMP)))
    if rng.random() < 0.02:
        return rng.choice((-WORD, WORD - 1, rng.randint(-WORD, WORD - 1)))
    return (near + far + WORD) % (2 * WORD) - WORD


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def any_ticks(dut: object) -> None:
    """Counts at any distances and either way, any jumps and parts of q; found, or known."""
    rng = random_source("ticks")
    bench = AngleBench(dut)
    found = 0
    for run in range(6 if "Icarus" in cocotb.SIM_NAME else 40):
        # Half a turn is reached by some counts to the bit, or missed by little.
        exact = (1 << 31) // rng.randint(3, 12) + rng.choice((0, 1, -rng.getrandbits(12)))
        turn = rng.choice((1 << 28, (1 << 32) - (1 << 27), rng.getrandbits(32), 1, 1 << 31))
        turn = rng.choice((turn, exact, (1 << 32) - exact))
        find = run % 8 != 7
        position = rng.randint(-1000, 1000)
        rest = 60_000 if run % 2 else rng.choice((0, 2, 5))
        await bench.begin(find=find, turn=turn, rest=rest, position=position)
        chi = (0, 0)
        way = rng.choice((1, -1))
        calm = run % 4 < 2
        for _ in range(900 if calm else 100):
            if rng.random() < 0.5:
                position += way * rng.choice((1, 1, 1, 2))
                if rng.random() < 0.03:
                    leap = 1 << rng.randrange(31)
                    position += leap if position < 0 else -leap
            if rng.random() < 0.03:
                way = -way
            if calm:
                chi = tuple(word + rng.randint(-JUMP // 10, JUMP // 10) for word in chi)
            else:
                chi = tuple(any_chi(rng, word) for word in chi)
            cells = rng.choice((
                (CELL, 0), (0, -CELL), (CELL // 2, CELL // 2), (0, 0),
                (rng.randint(-CELL, CELL), rng.randint(-CELL, CELL)),
            ))  # fmt: skip
            await bench.tick(position, rng.random() < 0.1, cells, chi, rng.choice((0, 0, 1, 4)))
        found += bool(find and bench.state[magnet_angle.KNOWN])
    assert found


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_loop_that_went_far_and_came_back(dut: object) -> None:
    """Small jumps all one way, then all the other: not found. Then without them it is."""
    bench = AngleBench(dut)
    for axis in (0, 1):
        await bench.begin(find=True, turn=(1 << 31) // 199, rest=100, position=0)
        cells = (0, CELL) if axis == 0 else (CELL, 0)
        chi, position = [0, 0], 0
        for half in range(4):
            for n in range(200 if half < 3 else 210):
                position += 1
                jump = JUMP // 5 if half < 3 else 0
                chi[axis] += jump if n < 100 else -jump
                await bench.tick(position, False, cells, tuple(chi), 0)
            assert bool(bench.state[magnet_angle.KNOWN]) == (half == 3)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def any_distance_is_a_movement(dut: object) -> None:
    """Each power of two of counts in one tick, and one less, either way."""
    bench = AngleBench(dut)
    for way in (1, -1):
        for less in (0, 1):
            position = -way
            await bench.begin(find=True, turn=1, rest=100, position=position)
            # The first one may be a turn round.
            for n, leap in enumerate((1, *((1 << bit) - less for bit in range(less, 31 - less)))):
                position += way * leap
                chi = (n * JUMP // 9, 0)
                assert await bench.tick(position, False, (0, CELL), chi, 0) or n == 0


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_mean_at_its_limit(dut: object) -> None:
    """Jumps of equal size in sum, shared in any way by the axes: a quarter of a cell is too much.

    From above the mean comes to this size to the bit, and each count is half a turn, so that the
    one that finds it is told. The turn is taken at any time: the mean is kept till the next count.
    """
    rng = random_source("mean")
    bench = AngleBench(dut)
    for _ in range(1 if "Icarus" in cocotb.SIM_NAME else 3):
        share = rng.randrange(magnet_angle.FOUND)
        for size_b in (share, magnet_angle.FOUND - 1 - share):
            for size in (magnet_angle.FOUND - 1, magnet_angle.FOUND):
                await bench.begin(find=True, turn=1 << 31, rest=100, position=0)
                jump, chi = (size - size_b, size_b), (0, 0)
                for position in range(1, 601):
                    way = 1 if position % 2 else -1
                    chi = tuple(c + way * j for c, j in zip(chi, jump, strict=True))
                    await bench.tick(position, False, (CELL, 0), chi, rng.randrange(3))
                known = bool(bench.state[magnet_angle.KNOWN])
                assert known == (size < magnet_angle.FOUND)
