# SPDX-License-Identifier: Apache-2.0
"""wh_board_controller: start, stop, faults, and the pin that says that all is well.

Both phases of a brushless motor measure the same here.
"""

from __future__ import annotations

import os
from math import ceil
from pathlib import Path

import cocotb
import pytest
from adc_part import AdcPart
from bench import Bench, unpack
from simulators import parameters
from wavehaptics.controller.guard import STUCK_S, Fault
from wavehaptics.fpga.board_words import OPTIONAL_PINS
from wavehaptics.fpga.boards import load_board
from wavehaptics.parts.adcs import PARTS
from wavehaptics.words import formats

SETTLE = 1 << parameters()["SETTLE_LOG2"]
ZERO_TICKS = 1 << parameters()["ZERO_LOG2"]
SCENE = os.environ.get("WH_BOARD_SCENE")
BOARD = load_board(os.environ["WH_BOARD"], scene_path=Path(SCENE) if SCENE else None)
GUARDED = BOARD.fpga.guard
BRUSHLESS = BOARD.brushless
# Anchors have no say before the magnets are found.
ANCHORED = BOARD.words().ports.settings.anchored and not BOARD.scene.controller.find_magnet
TICK = BOARD.words().ports.timing.tick_clocks
OFTEN = 2 if BOARD.words().alive_again else 1
PART = PARTS[BOARD.fpga.adc]
PERIOD_NS = 1e9 / BOARD.clock_hz
PINS_NS = 2.0
MIDDLE = 1 << (PART.bits - 1)
BELOW = ceil(BOARD.fpga.sense.trip_a / BOARD.scene.adc.full_scale_a * MIDDLE) - 1
"""The largest code from the middle that is less than the limit."""
PAD_CLOCKS = BOARD.words().ports.timing.frame.pad_clocks
"""Registers at the pads, which are the top's: the bench has them in their place."""
TOP = 2 * MIDDLE - 1
ZERO_CODES = BOARD.fpga.sense.zero_a / BOARD.scene.adc.full_scale_a * MIDDLE
_SET = BOARD.words().ports.settings
_KEPT_V = 4 * 2 * _SET.r_hat * _SET.a * formats.A.step * BOARD.fpga.sense.zero_a
LEFT_V = _KEPT_V if BRUSHLESS else 0.01
"""What free space keeps of an offset: some ticks' currents of before the zero are waves as well."""
ZERO_CLOCKS = (ZERO_TICKS + 6) * TICK
"""More than a zero takes, and what was before it to pass."""
GATES = ("gate_ah_o", "gate_al_o", "gate_bh_o", "gate_bl_o")
HIGH_GATES = GATES[::2]
ADCS = (1 << len(BOARD.adc_lines)) - 1
LINKED = BOARD.fpga.link
PARTS = len(BOARD.adc_lines)
SET_CLOCKS = 96 + 128 * PARTS + 70 if LINKED else 0
"""After reset, until all settings are copied, and SCLK knows where it rests."""
OPTIONAL = {
    name: int(level.endswith("1"))
    for key, pins in OPTIONAL_PINS.items() if getattr(BOARD.fpga, key)
    for name, level in pins.items() if level
}  # fmt: skip
"""Inputs that only some boards have, at rest."""
SYNCHRONISER = 3  # clocks until an input is seen, and one to act on it


class Board(Bench):
    """The board's controller, out of reset with nothing pressed and the stop switch closed."""

    def __init__(self, dut: object) -> None:
        super().__init__(dut)
        self.code, self.noise = MIDDLE, 1
        """What the ADC says, and how much it changes from one frame to the next."""
        self.sdata: int | None = None
        """The level of SDATA where its wire is off: that of its pull."""
        self._frames = 0
        self._unset = SET_CLOCKS
        self._adc = AdcPart(PART, self._convert)
        self._out = [(1, PART.idle)] * PAD_CLOCKS
        self._in = [1] * PAD_CLOCKS

    def _convert(self) -> int:
        self._frames += 1
        return min(TOP, self.code + self.noise * (self._frames % 2))

    async def step(self, clocks: int = 1, **inputs: int) -> None:
        """As of any bench, with the ADC at its pins."""
        self.drive(**inputs)
        for _ in range(clocks):
            edge = (self.clocks + 1) * PERIOD_NS
            self._in.append(self._adc.sdata(edge - PINS_NS))
            level = self._in.pop(0)
            self.drive(adc_sdata_i=ADCS * (level if self.sdata is None else self.sdata))
            await super().step()
            self._unset = SET_CLOCKS if self.word("rst") else max(0, self._unset - 1)
            if self.word("rst") or self._unset:
                self._adc.cut_off()
                self._out = [(1, PART.idle)] * PAD_CLOCKS
            shown = (1, PART.idle)
            if not self._unset:
                shown = (self.word("adc_cs_n_o"), self.word("adc_sclk_o"))
            self._out.append(shown)
            self._adc.pins(edge + PINS_NS, *self._out.pop(0))

    def inner(self, name: str) -> list[int]:
        """Signed words that the controller tells, and the board doesn't."""
        if not LINKED:
            inside = self.dut.alone
        else:
            inside = self.dut.linked.device.device.ports
            name = {"voltage": "voltage_q"}.get(name, name)  # which holds it
        return unpack(int(getattr(inside, name).value), formats.DATA_W, PARTS)

    def overcurrent(self) -> bool:
        """Whether a current is too large: with a line, of the guard's faults only that one."""
        if not LINKED:
            return bool(self.word("overcurrent_seen"))
        faults = int(self.dut.linked.device.device.faults.value)
        return bool(faults >> Fault.CURRENT & 1)

    async def begin(self, **inputs: int) -> None:
        quiet = {"start_i": 0, "stop_i": 0, "clock_lost_i": 0, "enc_a_i": 0, "enc_b_i": 0,
                 "uart_rx_i": 1, **OPTIONAL}  # fmt: skip
        await self.start(**{**quiet, **inputs})
        await self.settings_come()

    async def leave_reset(self) -> None:
        await self.step(1, rst=0)
        await self.settings_come()

    async def settings_come(self) -> None:
        await self.step(SET_CLOCKS)

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
        await self.step(SETTLE + ZERO_CLOCKS, start_i=0)
        await self.step(SETTLE + ZERO_CLOCKS, start_i=1)
        await self.step(SETTLE + 8, start_i=0)

    async def expect_running(self) -> None:
        await self.step(2 * TICK)
        changes, gates, running = await self.watch(20 * TICK)
        assert running == {1}
        assert changes == 20 * OFTEN, "alive changes once or twice a tick"
        assert gates > 10 * TICK

    async def expect_off(self) -> None:
        await self.step(SYNCHRONISER + 2)
        assert not self.word("alive_o")
        assert await self.watch(5 * TICK) == (0, 0, {0})


async def running(dut: object) -> Board:
    """A board that has been started."""
    board = Board(dut)
    await board.begin()
    await board.press()
    await board.expect_running()
    return board


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
    await board.step(SETTLE + ZERO_CLOCKS)
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
    board = await running(dut)
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
    board = await running(dut)
    await board.step(40, enc_a_i=1, enc_b_i=1)  # both at once
    assert board.word("fault_o")
    await board.expect_off()
    await expect_off_until_reset(board)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_lost_clock_is_a_fault_until_reset(dut):
    """Told as wh_board_clock_watch does, for as long as it likes."""
    board = Board(dut)
    for clocks in (1, TICK):
        await board.begin()
        await board.press()
        await board.expect_running()
        await board.step(clocks, clock_lost_i=1)
        await board.step(SYNCHRONISER, clock_lost_i=0)
        assert board.word("fault_o")
        await board.expect_off()
        await board.press()
        await board.expect_off()


async def expect_off_until_reset(board: Board) -> None:
    await board.press()
    await board.expect_off()
    await board.step(3, rst=1)
    await board.leave_reset()
    assert not board.word("fault_o")
    await board.press()
    await board.expect_running()


async def wait_for_fault(board: Board, clocks: int) -> None:
    waited = 0
    while not board.word("fault_o"):
        await board.step()
        waited += 1
        assert waited <= clocks


async def expect_fault_until_reset(board: Board, clocks: int) -> None:
    """What has been done to the board is seen within some clocks, and that lasts."""
    await wait_for_fault(board, clocks)
    # fault_o shows the guard's fault in the clock in which it is latched. The gates are off one
    # clock later, and by the board's own fault, of the trip, two.
    await board.step(1 if GUARDED and clocks > 2 * TICK + 8 else 2)
    assert not any(board.word(gate) for gate in GATES)
    await board.expect_off()
    board.code, board.noise = MIDDLE, 1
    await expect_off_until_reset(board)
    assert not board.word("fault_o")


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def too_large_a_current_takes_the_gates_off(dut):
    """Within the ADC's scale, and at either end of it, on every board."""
    for code in (MIDDLE + BELOW + 1, MIDDLE - BELOW - 2, 0, TOP):
        board = await running(dut)
        board.code = code
        for _ in range(2 * TICK + 8):
            await board.step()
            if board.overcurrent():
                break
        assert board.overcurrent()
        await expect_fault_until_reset(board, 2)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def a_large_current_below_the_limit_does_not(dut):
    """The largest codes below it. The anchor's fault may come: no rotor's current jumps so."""
    # A brushless motor's third phase has what flows in both others.
    most = BELOW // 2 if BRUSHLESS else BELOW
    for code in (MIDDLE + most - 1, MIDDLE - most):  # and one more of noise
        board = await running(dut)
        board.code = code
        for _ in range(4 * TICK):
            await board.step()
            assert not board.overcurrent()


@cocotb.test(timeout_time=10, timeout_unit="ms", skip=not GUARDED)
async def an_adc_that_stands_still_takes_the_gates_off(dut):
    board = await running(dut)
    board.noise = 0
    samples = round(STUCK_S * BOARD.clock_hz / TICK)
    await board.step((samples - 4) * TICK)
    assert not board.word("fault_o")
    assert board.word("running_o")
    await expect_fault_until_reset(board, 8 * TICK)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def what_an_adc_says_as_it_wakes_up_is_forgotten(dut):
    """Once a good sample has come, which is before a press can be believed."""
    assert 2 * TICK < SETTLE // 2
    board = Board(dut)
    board.code = 0
    await board.begin()
    await board.step(SETTLE // 2)
    board.code = MIDDLE
    await board.step(SETTLE + ZERO_CLOCKS)
    assert not board.word("fault_o")
    await board.press()
    await board.expect_running()


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def a_fault_at_rest_keeps_the_gates_off(dut):
    board = Board(dut)
    await board.begin()
    await board.step(SETTLE + ZERO_CLOCKS)
    board.code = 0
    await board.step(3 * TICK)
    assert board.word("fault_o")
    board.code = MIDDLE
    await board.press()
    await board.expect_off()


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def an_adc_without_its_wires_takes_the_gates_off(dut):
    """SDATA off: its pull says that the current is at the end of the scale. So does an ADC that is
    not selected or has no supply; one without SCLK holds the zero in front, the other end."""
    for level in (1, 0):
        board = await running(dut)
        board.sdata = level
        await wait_for_fault(board, 2 * TICK + 8)
        await board.expect_off()


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def a_board_without_its_wires_does_not_start(dut):
    """Nothing but the board: all inputs at their pulls, and the button pressed."""
    board = Board(dut)
    board.sdata = 1
    await board.begin(stop_i=1, enc_a_i=1, enc_b_i=1)
    await board.press()
    await board.expect_off()
    assert board.word("fault_o")
    # And with the stop's wire in place.
    await board.step(8, stop_i=0)
    await board.press()
    await board.expect_off()


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_is_at_once(dut):
    board = await running(dut)
    await board.step(2, rst=1)
    assert not board.word("alive_o")
    assert await board.watch(3 * TICK) == (0, 0, {0})
    await board.leave_reset()
    await board.expect_off()


async def high_gates_on(board: Board, ticks: int) -> list[int]:
    """Clocks that the high gate of each leg is on."""
    on = [0] * BOARD.fpga.legs
    for _ in range(ticks * TICK):
        await board.step()
        # Leg c of a brushless motor is leg a of the second port.
        first, second = board.word(HIGH_GATES[0]), board.word(HIGH_GATES[1])
        gates = first & 1 | (second & 1) << 1 | (first & 2) << 1
        for leg in range(len(on)):
            on[leg] += gates >> leg & 1
    return on


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def the_zero_is_measured_before_the_gates_go_on(dut):
    """At every press anew, so that what the ADC says then is no current; and with the gates off."""
    board = Board(dut)
    board.noise = 0
    await board.begin()
    for code in (MIDDLE + int(0.9 * ZERO_CODES), MIDDLE - int(0.9 * ZERO_CODES)):
        board.code = code
        await board.step(SETTLE + ZERO_CLOCKS, start_i=0)
        board.drive(start_i=1)
        changes, gates, _ = await board.watch(SETTLE + ZERO_TICKS * TICK)
        assert (changes, gates) == (0, 0)
        await board.step(6 * TICK)
        assert board.word("running_o")
        await board.step(10 * TICK)
        on = await high_gates_on(board, 40)
        assert max(map(abs, board.inner("current"))) < formats.CURRENT.to_raw(1e-3)
        assert max(map(abs, board.inner("voltage"))) < formats.VOLTAGE.to_raw(LEFT_V)
        assert on == pytest.approx([on[0]] * len(on), rel=0.05)
        assert on[0] > 15 * TICK
        await board.step(8, stop_i=1)
        await board.step(8, stop_i=0)
    assert not board.word("fault_o")


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def a_zero_that_is_none_is_a_fault(dut):
    """More than an offset may be, gates off: after reset, or later. A press measures anew."""
    for sign in (1, -1):
        for late in (False, True):
            board = Board(dut)
            strange = MIDDLE + sign * (int(ZERO_CODES) + 2)
            board.code = MIDDLE if late else strange
            await board.begin()
            await board.step(SETTLE + ZERO_CLOCKS)
            assert bool(board.word("fault_o")) != late
            board.code = strange
            await board.press()
            assert board.word("fault_o")
            await board.expect_off()
            board.code = MIDDLE
            await board.press()
            assert not board.word("fault_o")
            await board.expect_running()


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def stop_while_the_zero_is_measured_is_no_start(dut):
    board = Board(dut)
    await board.begin()
    await board.step(SETTLE + ZERO_CLOCKS)
    await board.step(SETTLE + 8 + 2 * TICK, start_i=1)
    assert not board.word("running_o")
    await board.step(1, stop_i=1)
    await board.step(1, stop_i=0)
    assert (await board.watch(2 * SETTLE + ZERO_CLOCKS))[1:] == (0, {0})


@cocotb.test(timeout_time=10, timeout_unit="ms", skip=not ANCHORED)
async def an_encoder_that_the_current_does_not_follow_takes_the_gates_off(dut):
    """Counts as of a rotor at 150 rad/s, and no back-EMF."""
    board = await running(dut)
    clocks = round(2e-3 / BOARD.scene.encoder.counts_per_rev * BOARD.clock_hz * 3.1416 / 150e-3)
    for count in range(200):
        a, b = ((0, 0), (1, 0), (1, 1), (0, 1))[count % 4]
        await board.step(clocks, enc_a_i=a, enc_b_i=b)
        if board.word("fault_o"):
            break
    assert board.word("fault_o")
    await board.expect_off()
