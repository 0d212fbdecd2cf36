# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_inverse_clarke.v``: its words are :mod:`wavehaptics.controller.clarke`'s."""

from __future__ import annotations

import math
import os

from simulators import defines

os.environ.update({name: str(value) for name, value in defines().items()})

import cocotb
from bench import Bench, random_source, unpack
from wavehaptics.controller import clarke
from wavehaptics.words import formats

LATENCY = 8
MULTIPLY_CLOCKS = 3
LEAST, MOST = formats.VOLTAGE.raw_min, formats.VOLTAGE.raw_max
CORNERS = (LEAST, LEAST + 1, LEAST // 2, -3, -2, -1, 0, 1, 2, 3, MOST // 2, MOST - 1, MOST)


class InverseBench(Bench):
    """Gives the voltages of both axes and plays the shared multiplier."""

    async def begin(self) -> None:
        await self.start(valid_i=0, alpha_i=0, beta_i=0, grant_i=0, done_i=0, product_i=0)

    def legs(self) -> tuple[int, ...]:
        return tuple(unpack(self.word("legs_o"), formats.DATA_W, 3))

    async def legs_of(self, alpha: int, beta: int, grant_after: int = 0) -> tuple[int, ...]:
        """Words of the legs; the multiplier is granted ``grant_after`` clocks late."""
        began = self.clocks
        before = self.legs()
        self.drive(valid_i=1, alpha_i=alpha, beta_i=beta)
        for _ in range(grant_after):
            await self.step()
            self.drive(valid_i=0)
            assert self.word("request_o") == 1
        await self.settle(grant_i=1)
        assert self.word("request_o") == 1
        assert self.signed("coefficient_o") == clarke.HALF_ROOT3
        assert self.signed("factor_o") == beta
        await self.step()
        self.drive(valid_i=0, grant_i=0, product_i=0x155555555555555)
        await self.step(MULTIPLY_CLOCKS - 1)
        assert self.word("request_o") == 0
        await self.step(done_i=1, product_i=beta * clarke.HALF_ROOT3)
        # Products that belong to other users follow.
        self.drive(done_i=0, product_i=0x2AAAAAAAAAAAAAA)
        while not self.word("valid_o"):
            assert self.legs() == before
            assert self.clocks - began < LATENCY + grant_after
            await self.step()
        assert self.clocks - began == LATENCY + grant_after
        found = self.legs()
        phases = clarke.phases.py_func(alpha, beta)
        assert found == clarke.centred.py_func(*phases)
        for n in range(3):
            assert found[n] - found[n - 1] == phases[n] - phases[n - 1]
        assert abs(max(found) + min(found)) <= 1
        await self.step()
        assert self.word("valid_o") == 0
        assert self.legs() == found
        return found


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def corners(dut: object) -> None:
    """Every corner of one axis with every corner of the other; a leg reaches either end."""
    bench = InverseBench(dut)
    await bench.begin()
    found = [await bench.legs_of(alpha, beta) for alpha in CORNERS for beta in CORNERS]
    assert {max(legs) for legs in found} >= {MOST, 0}
    assert min(min(legs) for legs in found) <= -MOST


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def random_voltages(dut: object) -> None:
    """Random voltages and late grants equal the model, and the vector, in V; all six orders."""
    bench = InverseBench(dut)
    rng = random_source("voltages")
    await bench.begin()
    orders = set()
    for _ in range(300):
        size, angle = rng.uniform(0.0, 0.99) * MOST, rng.uniform(0.0, 2.0 * math.pi)
        alpha, beta = round(size * math.cos(angle)), round(size * math.sin(angle))
        a, b, c = await bench.legs_of(alpha, beta, rng.choice((0, 0, 1, 2, 5)))
        slack = 4.0 + 2.0 * size * clarke.COEFFICIENT.step
        assert abs((2 * a - b - c) / 3.0 - alpha) <= slack
        assert abs((b - c) / math.sqrt(3.0) - beta) <= slack
        # √3/2 of the vector at most, which is what the bridge's hexagon has room for.
        assert max(abs(a), abs(b), abs(c)) <= math.sqrt(0.75) * size + slack
        orders.add(tuple(sorted(range(3), key=(a, b, c).__getitem__)))
    assert len(orders) == 6


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def reset_drops_what_is_under_way(dut: object) -> None:
    """In any clock of a transform; nothing comes of it, and the next one is whole."""
    bench = InverseBench(dut)
    for clocks in range(LATENCY):
        await bench.begin()
        await bench.step(valid_i=1, alpha_i=MOST, beta_i=MOST, grant_i=int(clocks > 0))
        bench.drive(valid_i=0, grant_i=0)
        for clock in range(1, clocks + 1):
            await bench.step(done_i=int(clock == MULTIPLY_CLOCKS))
        await bench.step(rst=1, done_i=0)
        bench.drive(rst=0)
        for _ in range(LATENCY + 1):
            assert bench.word("valid_o") == 0
            assert bench.word("request_o") == 0
            await bench.step()
        assert bench.legs() == (0, 0, 0)
        await bench.legs_of(12345, -6789)
