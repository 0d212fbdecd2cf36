# SPDX-License-Identifier: Apache-2.0
"""A board's controller that runs, whose clock stops with a gate on."""

from __future__ import annotations

import cocotb
from bench import random_source
from cocotb.triggers import First, Timer, ValueChange
from cocotb.utils import get_sim_time
from stopping_clock import StoppingClock
from tb_board_controller import GATES, OPTIONAL, PERIOD_NS, SETTLE, TICK, Board

AT_MOST = 19
"""Clocks of the watch, 2^4 + 3 with its parameters as they stand."""

WATCH_PS = 16 * 1_000_000 // 310
RESET_CLOCKS = 200
STOPS = 12


class Watched(Board):
    """As the board, with clocks that can be stopped."""

    def __init__(self, dut: object) -> None:
        super().__init__(dut)
        self.clock = StoppingClock(dut.clk, round(1000 * PERIOD_NS))
        self.watch_clock = StoppingClock(dut.watch_clk, WATCH_PS)

    async def begin(self) -> None:
        self.clock.go()
        self.watch_clock.go()
        quiet = {"start_i": 0, "stop_i": 0, "enc_a_i": 0, "enc_b_i": 0, **OPTIONAL}
        await self.step(RESET_CLOCKS, rst=1, **quiet)
        self.drive(rst=0)
        await self.settings_come()

    def pads(self) -> int:
        return sum(self.word(gate) for gate in GATES)

    async def expect_pads_off(self, ps: int) -> None:
        until = get_sim_time("ps") + ps
        edges = [ValueChange(self.handle(gate)) for gate in GATES]
        while (left := until - get_sim_time("ps")) > 0:
            assert not self.pads()
            await First(*edges, Timer(left, unit="ps"))
        assert not self.pads()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_stopped_clock_takes_the_gates_off_until_reset(dut: object) -> None:
    rng = random_source("stops")
    board = Watched(dut)
    for _ in range(STOPS):
        await board.begin()
        await board.press()
        await board.expect_running()
        assert not board.word("fault_o")
        await board.step(rng.randrange(TICK))
        while not board.pads():
            await board.step()

        board.clock.stop()
        since_ps = get_sim_time("ps") - board.clock.last_edge_ps
        await Timer(AT_MOST * WATCH_PS - since_ps, unit="ps")
        assert board.word("bridge_on_o"), "the flip-flop before the pad stands still at 1"
        await board.expect_pads_off(20 * AT_MOST * WATCH_PS)

        board.clock.go()
        await board.expect_pads_off(round(4 * TICK * 1000 * PERIOD_NS))
        assert board.word("fault_o")
        await board.step(SETTLE)
        await board.press()
        await board.expect_off()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_board_whose_oscillator_is_dead_never_starts(dut: object) -> None:
    board = Watched(dut)
    board.watch_clock.stop()
    board.clock.go()
    await board.step(RESET_CLOCKS, rst=1, start_i=0, stop_i=0, enc_a_i=0, enc_b_i=0, **OPTIONAL)
    await board.leave_reset()
    await board.press()
    await board.expect_off()
    assert board.word("fault_o")
