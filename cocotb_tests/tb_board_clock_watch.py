# SPDX-License-Identifier: Apache-2.0
"""wh_board_clock_watch: gates off when the clock stops, at the corners of both clocks' rates.

The gates before it are all on, all the time, as flip-flops without a clock are: what comes behind
it is what it makes of them.
"""

from __future__ import annotations

import cocotb
from bench import random_source
from cocotb.triggers import First, RisingEdge, Timer, ValueChange
from cocotb.utils import get_sim_time
from simulators import parameters
from stopping_clock import StoppingClock

GATES = parameters()["GATES"]
BEAT = 1 << parameters()["BEAT_LOG2"]
PATIENCE = 1 << parameters()["PATIENCE_LOG2"]
AT_MOST = PATIENCE + 3
"""Clocks of the watch from the last clock to gates that are off."""

ALL_ON = (1 << GATES) - 1
CLOCK_PS = 11_112
"""90 MHz; no board is faster."""

WATCH_PS = 16 * 1_000_000 // 310
TOLERANCE = 0.3
RATES = {
    "nominal": (CLOCK_PS, WATCH_PS),
    "80 MHz": (12_500, WATCH_PS),
    "slow watch": (CLOCK_PS, round(WATCH_PS / (1 - TOLERANCE))),
    "fast watch": (12_500, round(WATCH_PS / (1 + TOLERANCE))),
    "beat nearly as short as a clock of the watch": (CLOCK_PS, round(0.97 * BEAT * CLOCK_PS)),
    "beat nearly as long as the patience": (
        CLOCK_PS, round(1.03 * BEAT * CLOCK_PS / (PATIENCE - 2)),
    ),
}  # fmt: skip
"""Periods of both clocks, ps: the boards' corners, and just within the bounds of the header."""


class Watch:
    """The watch with both clocks, its gates driven high."""

    def __init__(self, dut: object, clock_ps: int, watch_ps: int) -> None:
        self.dut = dut
        self.clock = StoppingClock(dut.clk, clock_ps)
        self.watch = StoppingClock(dut.watch_clk, watch_ps)
        self.dut.rst.value = 1
        self.dut.gates_i.value = ALL_ON

    async def clocks(self, count: int) -> None:
        for _ in range(count):
            await RisingEdge(self.dut.clk)

    async def watch_clocks(self, count: float) -> None:
        await Timer(round(count * self.watch.period_ps), unit="ps")

    def gates(self) -> int:
        """The gates behind the watch, which agree with what it says of the clock."""
        gates = int(self.dut.gates_o.value)
        assert gates == (0 if int(self.dut.lost_o.value) else ALL_ON)
        return gates

    async def begin(self) -> None:
        """Both clocks on, through reset."""
        self.clock.go()
        self.watch.go()
        await self.reset()
        assert self.gates() == ALL_ON

    async def reset(self) -> None:
        self.dut.rst.value = 1
        await self.clocks(4 * BEAT)
        await self.watch_clocks(4)
        await self.clocks(1)
        self.dut.rst.value = 0

    async def expect(self, gates: int, ps: int) -> None:
        """The gates are so for ``ps``."""
        until = get_sim_time("ps") + ps
        while (left := until - get_sim_time("ps")) > 0:
            await First(ValueChange(self.dut.gates_o), Timer(left, unit="ps"))
            assert self.gates() == gates

    async def off_after_stop(self) -> float:
        """Clocks of the watch from the clock's last edge to the gates' end."""
        await First(
            ValueChange(self.dut.gates_o), Timer(2 * AT_MOST * self.watch.period_ps, unit="ps")
        )
        assert self.gates() == 0, "the gates stayed on without a clock"
        return (get_sim_time("ps") - self.clock.last_edge_ps) / self.watch.period_ps


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(rates=list(RATES))
async def stopped_clock_takes_the_gates_off(dut: object, rates: str) -> None:
    """At any time of the beat, and of the watch's own clock."""
    rng = random_source(f"stops, {rates}")
    watch = Watch(dut, *RATES[rates])
    waits = []
    for _ in range(100):
        await watch.begin()
        await watch.expect(ALL_ON, rng.randrange(4 * BEAT * watch.clock.period_ps))
        watch.clock.stop()
        waits.append(await watch.off_after_stop())
        await watch.expect(0, 4 * AT_MOST * watch.watch.period_ps)
    cocotb.log.info("%s: off after %.2f to %.2f clocks", rates, min(waits), max(waits))
    assert max(waits) <= AT_MOST
    beats = BEAT * watch.clock.period_ps / watch.watch.period_ps
    assert max(waits) > AT_MOST - 1.5, "the worst time of the beat was tried"
    assert min(waits) > PATIENCE - beats, "patience lasts as long as it says"


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(rates=list(RATES))
async def no_false_alarm(dut: object, rates: str) -> None:
    """In as many beats the clocks meet at every thousandth of a period."""
    watch = Watch(dut, *RATES[rates])
    await watch.begin()
    await watch.expect(ALL_ON, 1000 * BEAT * watch.clock.period_ps)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def no_false_alarm_while_the_watch_drifts(dut: object) -> None:
    """Its rate anywhere within its tolerance, from one moment to the next."""
    rng = random_source("drift")
    watch = Watch(dut, *RATES["nominal"])
    await watch.begin()
    for _ in range(1000):
        watch.watch.period_ps = round(WATCH_PS / rng.uniform(1 - TOLERANCE, 1 + TOLERANCE))
        await watch.expect(ALL_ON, rng.randrange(4 * BEAT * CLOCK_PS))


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def clock_that_comes_back_leaves_the_gates_off_until_reset(dut: object) -> None:
    watch = Watch(dut, *RATES["nominal"])
    for stood_ps in (0, WATCH_PS, 1_000_000, 100_000_000):
        await watch.begin()
        watch.clock.stop()
        await watch.off_after_stop()
        await watch.expect(0, stood_ps)
        watch.clock.go()
        await watch.expect(0, 100 * BEAT * CLOCK_PS)
        await watch.reset()
        assert watch.gates() == ALL_ON


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def too_short_a_stop_is_none(dut: object) -> None:
    """Of fewer clocks of the watch than its patience, the beat's own length taken off."""
    watch = Watch(dut, *RATES["nominal"])
    await watch.begin()
    stood_ps = (PATIENCE - 2) * WATCH_PS - BEAT * CLOCK_PS
    for _ in range(50):
        watch.clock.stop()
        await watch.expect(ALL_ON, stood_ps)
        watch.clock.go()
        await watch.expect(ALL_ON, 3 * BEAT * CLOCK_PS)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def too_slow_a_clock_is_a_lost_one(dut: object) -> None:
    watch = Watch(dut, *RATES["nominal"])
    await watch.begin()
    watch.clock.period_ps = round(1.05 * (PATIENCE + 1) * WATCH_PS / BEAT)
    assert await watch.off_after_stop() <= AT_MOST
    await watch.expect(0, 20 * BEAT * watch.clock.period_ps)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def off_until_both_clocks_run_and_reset_has_seen_two_beats(dut: object) -> None:
    """From power-up; a reset that is too short for two beats opens nothing."""
    watch = Watch(dut, *RATES["nominal"])
    watch.dut.rst.value = 0
    await Timer(1, unit="ns")
    await watch.expect(0, 1_000_000)
    watch.watch.go()
    await watch.expect(0, 4 * AT_MOST * WATCH_PS)
    watch.clock.go()
    await watch.expect(0, 100 * BEAT * CLOCK_PS)
    for _ in range(20):
        watch.dut.rst.value = 1
        await watch.expect(0, round(0.9 * BEAT * CLOCK_PS))
        watch.dut.rst.value = 0
        await watch.expect(0, 5 * BEAT * CLOCK_PS)
    watch.dut.rst.value = 1
    begun = get_sim_time("ps")
    await ValueChange(dut.gates_o)
    assert BEAT * CLOCK_PS < get_sim_time("ps") - begun < 2 * BEAT * CLOCK_PS + 5 * WATCH_PS
    watch.dut.rst.value = 0
    await watch.expect(ALL_ON, 10 * BEAT * CLOCK_PS)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def gates_pass_one_by_one(dut: object) -> None:
    watch = Watch(dut, *RATES["nominal"])
    await watch.begin()
    for gates in [*(1 << gate for gate in range(GATES)), 0, ALL_ON]:
        dut.gates_i.value = gates
        await Timer(1, unit="ns")
        assert int(dut.gates_o.value) == gates
