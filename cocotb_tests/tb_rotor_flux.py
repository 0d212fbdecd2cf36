# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_rotor_flux.v``: every count's words are the model's.

The model is :func:`wavehaptics.controller.rotor_flux.rotor_flux_step`, a count at a time.
"""

from __future__ import annotations

import os

import cocotb
import numpy as np
from bench import Bench, random_source, unpack

os.environ["NUMBA_DISABLE_JIT"] = "1"  # compiling would take longer than it saves

from wavehaptics.controller import rotor_flux
from wavehaptics.words import formats

PLACE_W = formats.LONG.width - formats.LONG.fraction + rotor_flux.SINE_Q
CELL_W = rotor_flux.SINE_Q + 2
TABLE = rotor_flux.sine_table()
LATENCY = 6
"""Clocks from a count to its words."""


class FluxBench(Bench):
    """Gives positions, and compares what is passed with the model in every clock."""

    async def begin(self, turn: int, zero: int, position: int, clocks: int = 1) -> None:
        self.turn, self.position = turn, position
        self.state = rotor_flux.new_state(position, zero)
        self.drive(
            rst=1, position_i=position, count_angle_i=turn, zero_angle_i=zero, turn_i=0, by_i=0
        )  # fmt: skip
        await self.step(clocks)
        self.drive(rst=0)
        self.still = 0
        self.check()
        assert self.word("angle_o") == zero

    def check(self) -> None:
        """What is shown is the model's, at a position between the last one shown and the pins'."""
        shown = self.signed("position_o")
        before = int(self.state[rotor_flux.POSITION])
        assert abs(shown - before) <= 1
        rotor_flux.rotor_flux_step(self.state, self.turn, TABLE, shown)
        places = unpack(self.word("place_o"), PLACE_W, 2)
        cells = unpack(self.word("cell_o"), CELL_W, 2)
        want = (self.state[rotor_flux.PLACE_A :] >> rotor_flux.SHIFT).tolist()
        assert [*places, *cells] == want
        if shown == self.position and self.still > LATENCY:
            assert self.word("angle_o") == int(self.state[rotor_flux.ANGLE])

    async def turn_by(self, by: int) -> None:
        """At rest: the angle of all that comes is another one."""
        self.drive(turn_i=1, by_i=by)
        await self.step()
        self.drive(turn_i=0)
        rotor_flux.turn_by(self.state, by)
        self.check()

    async def clock(self, position: int) -> None:
        self.still = self.still + 1 if position == self.position else 0
        self.position = position
        self.drive(position_i=position)
        await self.step()
        self.check()


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def any_walk(dut: object) -> None:
    """Any angles of a count, walks with counts at any distances, leaps, resets of any length."""
    rng = random_source("walks")
    bench = FluxBench(dut)
    await bench.start(position_i=0, count_angle_i=0, zero_angle_i=0, turn_i=0, by_i=0)
    seen = np.zeros(4, dtype=bool)
    for run in range(8 if "Icarus" in cocotb.SIM_NAME else 60):
        turn = rng.choice((0, 1, (1 << 32) - 1, 3007477, rng.getrandbits(32), rng.getrandbits(26)))
        position = rng.randint(-(1 << 20), 1 << 20)
        await bench.begin(turn, rng.getrandbits(32), position, rng.choice((1, 2, 5)))
        often = rng.choice((0.05, 0.5, 1.0))
        for _ in range(400):
            if rng.random() < 0.01:
                position += rng.randint(-40, 40)
            elif rng.random() < often:
                position += rng.choice((1, -1) if run % 2 else (1, 1, 1, -1))
            await bench.clock(position)
            seen[bench.state[rotor_flux.ANGLE] >> 30] = True
        # Those under way, up and down, are not seen in this.
        left = abs(position - bench.signed("position_o"))
        for _ in range(2 * (left + LATENCY)):
            await bench.clock(position)
        assert bench.signed("position_o") == position
        await bench.turn_by(rng.getrandbits(32))
        for _ in range(50):
            position += rng.choice((0, 0, 1, -1))
            await bench.clock(position)
    assert seen.all()


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def edges_between_two_entries(dut: object) -> None:
    """An edge at the first angle of an entry of the sine or the last one of the entry before it.

    So each bit of the angle decides: of what a count turns, and of what it is turned by.
    """
    rng = random_source("edges")
    bench = FluxBench(dut)
    await bench.start(position_i=0, count_angle_i=0, zero_angle_i=0, turn_i=0, by_i=0)
    for _ in range(4 if "Icarus" in cocotb.SIM_NAME else 40):
        turn = rng.choice((rng.getrandbits(32), rng.getrandbits(28), (1 << 22) + 1))
        await bench.begin(turn, rng.getrandbits(32), 0)
        for _ in range(20):
            counts = rng.choice((1, -1, 1, -1, 2, 5))
            way = 1 if counts > 0 else -1
            half = turn // 2 + turn % 2 if way > 0 else turn // 2
            edge = (rng.getrandbits(10) << 22) - rng.choice((0, 1))
            ahead = way * ((abs(counts) - 1) * turn + half)
            await bench.turn_by(edge - ahead - int(bench.state[rotor_flux.ANGLE]))
            position = bench.position + counts
            for _ in range(2 * abs(counts) + LATENCY):
                await bench.clock(position)
            assert bench.signed("position_o") == position


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_leap_of_any_size(dut: object) -> None:
    """However far the position is, it is followed, and by the shorter way."""
    bench = FluxBench(dut)
    await bench.start(position_i=0, count_angle_i=0, zero_angle_i=0, turn_i=0, by_i=0)
    for bit in range(formats.COUNT_W - 1):
        for way in (1, -1):
            await bench.begin(3007477, 1 << 29, 0)
            for _ in range(LATENCY):
                await bench.clock(way << bit)
            assert bench.signed("position_o") == way


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_count_takes_six_clocks(dut: object) -> None:
    """From rest: its words are there so many clocks later, and not before."""
    bench = FluxBench(dut)
    await bench.start(position_i=0, count_angle_i=0, zero_angle_i=0, turn_i=0, by_i=0)
    await bench.begin(1 << 22, 1 << 29, 100)
    for way in (1, -1, -1, 1):
        await bench.step(10)
        position = bench.position + way
        for clock in range(1, LATENCY + 1):
            await bench.clock(position)
            assert (bench.signed("position_o") == position) == (clock == LATENCY)
