# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_half_bridge.v``: every clock against what a leg may do."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source


class HalfBridgeBench(Bench):
    """Drives one leg; checks interlock, dead time and that a gate stays on, in every clock."""

    def __init__(self, dut: object) -> None:
        super().__init__(dut)
        self.dead = 0
        self.high_on = 0
        self.low_on = 0
        self._leg = 0
        self._quiet = 0  # clocks since the leg changed or the bridge came on, with that one
        # Clocks since each gate was last seen on; before the first there was no gate to wait for.
        self._off = {"high": 1 << 20, "low": 1 << 20}
        self._before = {"high": 0, "low": 0}

    async def clock(self, leg: int, enable: int = 1, rst: int = 0) -> tuple[int, int]:
        await self.step(leg_i=leg, enable_i=enable, rst=rst)
        on = {"high": self.word("high_o"), "low": self.word("low_o")}
        assert not (on["high"] and on["low"])
        if rst or not enable:
            assert on == {"high": 0, "low": 0}
            self._quiet = 0
        else:
            self._quiet = 1 if leg != self._leg else self._quiet + 1
        self._leg = leg
        driven = self._quiet > self.dead
        assert on == {"high": int(driven and leg), "low": int(driven and not leg)}
        for gate, other in (("high", "low"), ("low", "high")):
            if on[gate] and not self._before[gate]:
                assert self._off[other] >= self.dead
        for gate in on:
            self._off[gate] = 0 if on[gate] else self._off[gate] + 1
        self._before = on
        self.high_on += on["high"]
        self.low_on += on["low"]
        return on["high"], on["low"]


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def dead_time_is_exact(dut: object) -> None:
    """A gate goes off in the next clock, the other on after exactly dead_clocks more."""
    bench = HalfBridgeBench(dut)
    for dead in (0, 1, 2, 7, 255):
        await bench.start(leg_i=0, enable_i=0, dead_clocks_i=dead)
        bench.dead = dead
        await bench.clock(0, enable=0)
        for _ in range(dead):
            assert await bench.clock(0) == (0, 0)
        assert await bench.clock(0) == (0, 1)
        for leg in (1, 0, 1):
            for _ in range(dead):
                assert await bench.clock(leg) == (0, 0)
            assert await bench.clock(leg) == (leg, 1 - leg)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def pulse_shorter_than_dead_time(dut: object) -> None:
    """The other gate never goes on, and the first one comes back after a full dead time."""
    bench = HalfBridgeBench(dut)
    dead = 5
    await bench.start(leg_i=1, enable_i=1, dead_clocks_i=dead)
    bench.dead = dead
    for _ in range(10):
        await bench.clock(1)
    for pulse in range(1, dead + 1):
        for _ in range(pulse):
            assert await bench.clock(0) == (0, 0)
        for _ in range(dead):
            assert await bench.clock(1) == (0, 0)
        assert await bench.clock(1) == (1, 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def random_legs(dut: object) -> None:
    """Random legs, enables and resets: never both gates, never without dead time."""
    bench = HalfBridgeBench(dut)
    rng = random_source("legs")
    for dead in (0, 1, 3, 12):
        await bench.start(leg_i=0, enable_i=0, dead_clocks_i=dead)
        bench.dead = dead
        leg = enable = 0
        for _ in range(3000):
            if rng.random() < 0.15:
                leg = 1 - leg
            if rng.random() < (0.02 if enable else 0.5):
                enable = 1 - enable
            await bench.clock(leg, enable, int(rng.random() < 0.005))
    assert bench.high_on > 500
    assert bench.low_on > 500
