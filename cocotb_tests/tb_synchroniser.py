# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_synchroniser.v``."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source
from cocotb.clock import Clock
from simulators import parameters


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def two_clocks_later(dut: object) -> None:
    """Every bit comes out as it went in, two clock edges later."""
    bench = Bench(dut)
    rng = random_source("levels")
    cocotb.start_soon(Clock(dut.clk, 10, unit="ns").start())
    await bench.step(2, level_i=0)
    words = [rng.getrandbits(parameters()["WIDTH"]) for _ in range(200)]
    seen = []
    for word in words:
        await bench.step(level_i=word)
        seen.append(bench.word("level_o"))
    assert seen[1:] == words[:-1]
    assert len(set(seen)) > 20
