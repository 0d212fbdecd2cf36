# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_motion.v``: N ports in turn equal N of the model in integers."""

from __future__ import annotations

import random

import cocotb
from bench import Bench, random_source
from simulators import parameters
from wavehaptics.controller.guard import SPAN
from wavehaptics.controller.motion import Motion
from wavehaptics.words.table import WORDS

N = parameters()["N"]
SHORT = 1 << parameters().get("SPAN_LOG2", 8)
TOP = WORDS["overspeed"].fixed.raw_max
LOW, HIGH = WORDS["window_low"].default, WORDS["window_high"].default
TURN = 3
"""Clocks from a turn's begin to the next one's, or more."""


class MotionBench(Bench):
    """Gives rounds, and compares after each turn."""

    async def begin(self, limits: list[tuple[int, int, int]]) -> None:
        self.limits = limits
        self.models = [Motion(*own, span=SHORT) for own in limits]
        await self.start(
            restart_i=0, valid_i=0, port_i=0, position_i=0, overspeed_i=0, low_i=0, high_i=0
        )

    async def turn(self, port: int, position: int, spare: int = 0) -> None:
        """Position and limits are there when they are taken, and others in other clocks."""
        overspeed, low, high = self.limits[port]
        await self.step(valid_i=1, port_i=port, position_i=~position)
        await self.step(valid_i=0, port_i=N - 1 - port, overspeed_i=1)
        await self.step(position_i=position, overspeed_i=overspeed, low_i=low, high_i=high)
        self.models[port].period(position)
        # It is judged in the next clock, which may be the next turn's first, by overspeed_i.
        self.drive(valid_i=0, position_i=~position, low_i=HIGH, high_i=LOW)
        if spare:
            await self.step(1 + spare)
            self.compare()

    def compare(self) -> None:
        found = self.word("overspeed_o"), self.word("outside_o")
        wanted = any(m.fast for m in self.models), any(m.outside for m in self.models)
        assert found == wanted, (self.limits, wanted)

    async def round(self, positions: list[int], spare: int = 1) -> tuple[int, int]:
        for port, position in enumerate(positions):
            await self.turn(port, position, spare if port == N - 1 else 0)
        return self.word("overspeed_o"), self.word("outside_o")


def random_limits(rng: random.Random) -> tuple[int, int, int]:
    """A rotor that leaps from edge to edge has no speed that a span can tell."""
    overspeed = rng.choice((0, rng.getrandbits(rng.randint(1, 16))))
    bits = 14 if overspeed else 31
    low, high = -rng.getrandbits(rng.randint(1, bits)), rng.getrandbits(rng.randint(1, bits))
    return overspeed, rng.choice((LOW, low)), rng.choice((HIGH, high))


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def equals_the_model(dut: object) -> None:
    """Any speeds at and around the limits, turns back, restarts and resets at any round."""
    bench, rng = MotionBench(dut), random_source("motion")
    seen = {(fast, out): 0 for fast in (0, 1) for out in (0, 1)}
    for _ in range(60):
        await bench.begin([random_limits(rng) for _ in range(N)])
        positions, ways = [0] * N, [0] * N
        for _ in range(6 * SHORT):
            for port, (overspeed, low, high) in enumerate(bench.limits):
                chance = rng.random()
                if chance < 1.5 / SHORT:  # a speed about the limit, or none
                    fast = max(1, overspeed // SHORT)
                    ways[port] = rng.choice((0, 0, 1, -1)) * rng.choice((fast, fast + 1, 1))
                elif chance < 2 / SHORT and not (overspeed and (low == LOW or high == HIGH)):
                    positions[port] = rng.choice((low, high, 0))
                ways[port] *= -1 if rng.random() < 0.3 / SHORT else 1
                moved = positions[port] + ways[port]
                positions[port] = min(HIGH, max(LOW, moved))
            seen[await bench.round(positions, rng.choice((1, 1, 4)))] += 1
            if rng.random() < 0.2 / SHORT:
                await bench.step(rng.choice((1, 5)), restart_i=1)
                bench.drive(restart_i=0)
                for model in bench.models:
                    model.restart()
                positions = [place + rng.choice((0, 0, 999)) for place in positions]
                positions = [min(HIGH, place) for place in positions]
    assert min(seen.values()) > 20, seen


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_steady_speed_at_the_limit(dut: object) -> None:
    """Counts of a limit in a span are none too many, one more raises it, in two spans at most."""
    bench = MotionBench(dut)
    for limit in (1, 2, 3, SHORT, 3 * SHORT + 1, TOP - 1):
        for counts in (limit, limit + 1, -limit, -limit - 1):
            await bench.begin([(0, LOW, HIGH)] * (N - 1) + [(limit, LOW, HIGH)])
            for n in range(SHORT // 2):
                assert await bench.round([0] * N) == (0, 0), n
            late = 0
            for n in range(1, 2 * SHORT + 1):
                place = counts * n // SHORT if counts > 0 else -(-counts * n // SHORT)
                fast, _ = await bench.round([place] * N)
                if fast:
                    late = late or n
            assert bool(late) == (abs(counts) > limit), (limit, counts, late)
            # A rotor that stands is slow again, two spans later at most.
            for _ in range(2 * SHORT):
                fast, _ = await bench.round([place] * N)
            assert not fast


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def every_bit_of_the_limits(dut: object) -> None:
    """A position on an edge is inside, one count further outside; a leap is over its limit."""
    bench = MotionBench(dut)
    for bit in range(31):
        edge = 1 << bit
        for place, outside in ((edge, 0), (edge + 1, 1), (-edge, 0), (-edge - 1, 1)):
            await bench.begin([(0, LOW, HIGH)] * (N - 1) + [(0, -edge, edge)])
            assert await bench.round([place] * N) == (0, outside), place
            assert await bench.round([0] * N) == (0, 0)
    for bit in range(16):
        limit = 1 << bit
        for sign in (1, -1):
            await bench.begin([(0, LOW, HIGH)] * (N - 1) + [(limit, LOW, HIGH)])
            assert await bench.round([7] * N) == (0, 0), "nothing to compare with"
            assert await bench.round([7 + sign * limit] * N) == (0, 0)
            assert await bench.round([7 + sign * (limit + 1)] * N) == (1, 0)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def resets(dut: object) -> None:
    """A reset forgets both; the position before it is no begin of a way."""
    bench = MotionBench(dut)
    await bench.begin([(5, -100, 100)] * N)
    await bench.round([0] * N)
    assert await bench.round([101] * N) == (1, 1)
    await bench.step(restart_i=1)
    bench.drive(restart_i=0)
    for model in bench.models:
        model.restart()
    assert await bench.round([50] * N) == (1, 0), "a restart keeps what was too fast"
    await bench.begin([(5, -100, 100)] * N)
    bench.compare()
    assert await bench.round([90] * N) == (0, 0)
    assert SPAN == 256
