# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_clarke.v``: its words are :func:`wavehaptics.controller.clarke.currents`'."""

from __future__ import annotations

import math
import os

from simulators import defines

os.environ.update({name: str(value) for name, value in defines().items()})

import cocotb
from bench import Bench, random_source
from wavehaptics.controller import clarke
from wavehaptics.words import formats

LATENCY = 7
MULTIPLY_CLOCKS = 3
SUM_CLOCKS = 2
"""Clocks from the currents to the request."""
LEAST, MOST = formats.CURRENT.raw_min, formats.CURRENT.raw_max
CORNERS = (LEAST, LEAST + 1, LEAST // 2, -3, -2, -1, 0, 1, 2, 3, MOST // 2, MOST - 1, MOST)


class ClarkeBench(Bench):
    """Gives the currents of two phases and plays the shared multiplier."""

    async def begin(self) -> None:
        await self.start(valid_i=0, a_i=0, b_i=0, grant_i=0, done_i=0, product_i=0)

    async def axes_of(self, a: int, b: int, grant_after: int = 0) -> tuple[int, int]:
        """Words of both axes; the multiplier is granted ``grant_after`` clocks late."""
        assert self.word("request_o") == 0
        began = self.clocks
        await self.step(valid_i=1, a_i=a, b_i=b)
        await self.step(SUM_CLOCKS - 1, valid_i=0)
        for _ in range(grant_after):
            assert self.word("request_o") == 1
            await self.step()
        assert self.word("request_o") == 1
        coefficient = self.signed("coefficient_o")
        assert coefficient == clarke.TWO_OVER_ROOT3
        product = self.signed("factor_o") * coefficient
        await self.step(grant_i=1)
        self.drive(grant_i=0)
        assert self.word("request_o") == 0
        await self.step(MULTIPLY_CLOCKS - 1, product_i=0x155555555555555)
        await self.step(done_i=1, product_i=product)
        # A product that belongs to another user follows.
        self.drive(done_i=0, product_i=0x2AAAAAAAAAAAAAA)
        assert self.word("valid_o") == 0
        await self.step()
        assert self.word("valid_o") == 1
        assert self.clocks - began == LATENCY + grant_after
        found = self.signed("alpha_o"), self.signed("beta_o")
        assert found == clarke.currents.py_func(a, b)
        assert self.word("beta_ends_o") == clarke.ends.py_func(found[1])
        await self.step()
        assert self.word("valid_o") == 0
        assert (self.signed("alpha_o"), self.signed("beta_o")) == found
        return found


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def corners(dut: object) -> None:
    """Every corner of one phase with every corner of the other; both limits are reached."""
    bench = ClarkeBench(dut)
    await bench.begin()
    found = [await bench.axes_of(a, b) for a in CORNERS for b in CORNERS]
    betas = {beta for _, beta in found}
    assert {LEAST, MOST, 0, 1, -1} <= betas


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def random_currents(dut: object) -> None:
    """Random currents and late grants equal the model, and the vector of the phases, in A."""
    bench = ClarkeBench(dut)
    rng = random_source("currents")
    await bench.begin()
    # Of a star's phases: a third of the range, where nothing is limited.
    for _ in range(200):
        size, angle = rng.uniform(0.0, 0.5) * MOST, rng.uniform(0.0, 2.0 * math.pi)
        a, b = (round(size * math.cos(angle - shift)) for shift in (0.0, 2.0 * math.pi / 3.0))
        alpha, beta = await bench.axes_of(a, b, rng.choice((0, 0, 1, 2, 5)))
        assert abs(alpha - size * math.cos(angle)) <= 1.0
        slack = 4.0 + 2.0 * size * clarke.COEFFICIENT.step
        assert abs(beta - size * math.sin(angle)) <= slack
    for _ in range(200):
        await bench.axes_of(rng.randint(LEAST, MOST), rng.randint(LEAST, MOST), rng.randint(0, 3))


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def reset_drops_what_is_under_way(dut: object) -> None:
    """In any clock of a transform; nothing comes of it, and the next one is whole."""
    bench = ClarkeBench(dut)
    for clocks in range(LATENCY):
        await bench.begin()
        await bench.step(valid_i=1, a_i=MOST, b_i=MOST)
        bench.drive(valid_i=0)
        for clock in range(1, clocks + 1):
            await bench.step(grant_i=int(clock == SUM_CLOCKS), done_i=int(clock == 5))
        await bench.step(rst=1, grant_i=0, done_i=0)
        bench.drive(rst=0)
        for _ in range(LATENCY + 1):
            assert bench.word("valid_o") == 0
            assert bench.word("request_o") == 0
            await bench.step()
        assert (bench.signed("alpha_o"), bench.signed("beta_o")) == (0, 0)
        await bench.axes_of(12345, -6789)
