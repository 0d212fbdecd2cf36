# SPDX-License-Identifier: Apache-2.0
"""wh_board_controller: start, stop, faults, and the pin that says that all is well."""

from __future__ import annotations

import cocotb
from bench import Bench
from simulators import parameters
from wavehaptics.boards import load_board

SETTLE = 1 << parameters()["SETTLE_LOG2"]
TICK = load_board("ulx3s").words().ports.timing.tick_clocks
GATES = ("gate_ah_o", "gate_al_o", "gate_bh_o", "gate_bl_o")
SYNCHRONISER = 3  # clocks until an input is seen, and one to act on it


class Board(Bench):
    """The board's controller, out of reset with nothing pressed and the stop switch closed."""

    async def begin(self, **inputs: int) -> None:
        quiet = {"start_i": 0, "stop_i": 0, "adc_sdata_i": 0, "enc_a_i": 0, "enc_b_i": 0}
        await self.start(**{**quiet, **inputs})

    async def watch(self, clocks: int) -> tuple[int, int, set[int]]:
        """(changes of alive, clocks with a gate on, values of running) in some clocks."""
        changes = gates = 0
        running = set()
        before = self.word("alive_o")
        for _ in range(clocks):
            await self.step()
            changes += before != self.word("alive_o")
            before = self.word("alive_o")
            gates += any(self.word(gate) for gate in GATES)
            running.add(self.word("running_o"))
        return changes, gates, running

    async def press(self) -> None:
        """Press and let go of the button, which must have been let go before."""
        await self.step(SETTLE + 8, start_i=0)
        await self.step(SETTLE + 8, start_i=1)
        await self.step(SETTLE + 8, start_i=0)

    async def expect_running(self) -> None:
        await self.step(2 * TICK)
        changes, gates, running = await self.watch(20 * TICK)
        assert running == {1}
        assert changes == 20, "alive changes once a tick"
        assert gates > 10 * TICK

    async def expect_off(self) -> None:
        await self.step(SYNCHRONISER + 2)
        assert not self.word("alive_o")
        assert await self.watch(5 * TICK) == (0, 0, {0})


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def off_until_start_is_pressed(dut):
    board = Board(dut)
    await board.begin()
    await board.expect_off()
    await board.press()
    await board.expect_running()
    assert not board.word("fault_o")


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_short_press_is_none(dut):
    board = Board(dut)
    await board.begin()
    await board.step(SETTLE + 8)
    await board.step(SETTLE - 4, start_i=1)
    await board.step(SETTLE + 8, start_i=0)
    await board.expect_off()


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_press_that_goes_on_through_reset_is_none(dut):
    board = Board(dut)
    await board.begin(start_i=1)
    await board.step(4 * SETTLE)
    await board.expect_off()
    await board.press()
    await board.expect_running()


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def stop_is_at_once_and_lasts(dut):
    board = Board(dut)
    await board.begin()
    await board.press()
    await board.expect_running()
    await board.step(1, stop_i=1)
    await board.expect_off()
    board.drive(stop_i=0)
    await board.expect_off()
    await board.step(2 * SETTLE, stop_i=1)
    await board.press()
    await board.expect_off()
    await board.step(8, stop_i=0)
    await board.expect_off()
    await board.press()
    await board.expect_running()


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_fault_lasts_until_reset(dut):
    board = Board(dut)
    await board.begin()
    await board.press()
    await board.expect_running()
    await board.step(40, enc_a_i=1, enc_b_i=1)  # both at once
    assert board.word("fault_o")
    await board.expect_off()
    await board.press()
    await board.expect_off()
    await board.step(3, rst=1)
    await board.step(1, rst=0)
    assert not board.word("fault_o")
    await board.press()
    await board.expect_running()


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_is_at_once(dut):
    board = Board(dut)
    await board.begin()
    await board.press()
    await board.expect_running()
    await board.step(2, rst=1)
    assert not board.word("alive_o")
    assert await board.watch(3 * TICK) == (0, 0, {0})
    await board.step(1, rst=0)
    await board.expect_off()
