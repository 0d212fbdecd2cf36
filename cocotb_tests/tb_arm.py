# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_arm.v``: armed by a write while that is renewed, or by a press."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source
from simulators import parameters

_P = {"SENSE": 0, "CREDIT": 50, **parameters()}
SENSE, CREDIT = _P["SENSE"], _P["CREDIT"]
ENABLE, FAULT, LOADING, ZERO, CREDIT_OUT = (1 << bit for bit in range(5))
ZERO_CLOCKS = 7
REASONS = {ENABLE: {"enable_i": 0}, FAULT: {"fault_i": 1}, LOADING: {"loading_i": 1}}
ANEW = {"zero_i": 1}
"""A fault that measuring forgets; without a zero it is one as any other."""


class ArmBench(Bench):
    """The block, with a zero that takes ZERO_CLOCKS."""

    async def begin(self) -> None:
        self.left = 0
        self.starts = 0
        await self.start(
            enable_i=1, fault_i=0, loading_i=0, write_i=0, value_i=0, press_i=0, zero_busy_i=0,
            zero_fault_i=0, zero_i=0,
        )  # fmt: skip

    async def step(self, clocks: int = 1, **inputs: int) -> None:
        for _ in range(clocks):
            start = bool(self.clocks and self.word("zero_start_o"))
            self.left = ZERO_CLOCKS if start else max(0, self.left - 1)
            self.starts += start
            await super().step(1, **inputs)
            self.drive(zero_busy_i=int(self.left > 0))

    async def write(self, value: int) -> None:
        await self.step(write_i=1, value_i=value)
        self.drive(write_i=0)

    async def press(self) -> None:
        await self.step(press_i=1)
        self.drive(press_i=0)

    async def arm(self) -> None:
        await self.write(1)
        await self.measured()

    async def measured(self) -> None:
        if SENSE:
            assert self.word("armed_o") == 0
            await self.step(ZERO_CLOCKS + 2)
        assert self.state == (1, 0)

    @property
    def state(self) -> tuple[int, int]:
        return self.word("armed_o"), self.word("refused_o")


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_grant_and_its_renewals(dut: object) -> None:
    """CREDIT clocks from the last write on, by 1 as by 2; a 2 alone arms nothing."""
    bench = ArmBench(dut)
    await bench.begin()
    assert bench.state == (0, 0)
    await bench.write(2)
    await bench.step(ZERO_CLOCKS + 3)
    assert bench.state == (0, 0)
    await bench.arm()
    assert bench.starts == SENSE
    for value in (1, 2):
        await bench.step(CREDIT // 2)
        await bench.write(value)
        await bench.step(CREDIT - 1)
        assert bench.state == (1, 0)
        await bench.write(value)  # in the last clock of it
        await bench.step(3)
        assert bench.state == (1, 0)
    await bench.step(CREDIT - 4)
    assert bench.state == (1, 0)
    await bench.step()
    assert bench.state == (0, CREDIT_OUT)
    await bench.write(2)
    assert bench.state == (0, CREDIT_OUT)
    await bench.arm()
    await bench.write(0)
    assert bench.state == (0, 0)
    assert bench.starts == 2 * SENSE


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def what_is_against_it(dut: object) -> None:
    """Each reason ends it in a clock and refuses a 1; when it is over, nothing comes by itself."""
    bench = ArmBench(dut)
    await bench.begin()
    for reason, inputs in REASONS.items():
        over = {name: 1 - value for name, value in inputs.items()}
        await bench.arm()
        await bench.step(**inputs)
        assert bench.state == (0, reason)
        await bench.write(1)
        assert bench.state == (0, reason)
        await bench.step(3, **over)
        await bench.write(2)
        await bench.step(2 * ZERO_CLOCKS)
        assert bench.state == (0, reason)
        await bench.arm()
        await bench.write(0)
    await bench.step(enable_i=0, fault_i=1)
    await bench.write(1)
    assert bench.state == (0, ENABLE | FAULT)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_press_lasts(dut: object) -> None:
    """Longer than any credit, until 0 is written or there is a reason; also one on top of a 1."""
    bench = ArmBench(dut)
    await bench.begin()
    await bench.press()
    await bench.measured()
    assert bench.starts == SENSE
    await bench.step(3 * CREDIT)
    for value in (1, 2):
        await bench.write(value)
        await bench.step(3 * CREDIT)
        assert bench.state == (1, 0)
    await bench.write(0)
    assert bench.state == (0, 0)
    await bench.arm()
    await bench.press()
    await bench.step(3 * CREDIT)
    assert bench.state == (1, 0)
    assert bench.starts == 2 * SENSE, "no zero is measured while it is on"
    for reason, inputs in REASONS.items():
        await bench.step(**inputs)
        assert bench.state == (0, reason)
        await bench.press()
        assert bench.state == (0, reason)
        await bench.step(2 * CREDIT, **{name: 1 - value for name, value in inputs.items()})
        assert bench.state == (0, reason)
        await bench.arm()
        await bench.step(CREDIT)
        assert bench.state == (0, CREDIT_OUT), "the press of before is forgotten"
        await bench.press()
        await bench.measured()
    await bench.step(press_i=1, write_i=1, value_i=0)
    assert bench.state == (0, 0)


@cocotb.test(timeout_time=1, timeout_unit="ms", skip=not SENSE)
async def the_zero(dut: object) -> None:
    """A zero that is refused, or that ends with the credit, doesn't arm; nor one that was left."""
    bench = ArmBench(dut)
    await bench.begin()
    await bench.step(zero_fault_i=1)
    await bench.write(1)
    await bench.step(ZERO_CLOCKS + 2)
    assert bench.state == (0, ZERO)
    bench.drive(zero_fault_i=0)
    await bench.arm()
    await bench.write(0)
    await bench.write(1)
    await bench.step(3)
    await bench.write(0)
    await bench.step(2 * ZERO_CLOCKS)
    assert bench.state == (0, 0)
    await bench.write(1)
    for _ in range(CREDIT - 1):  # a zero without an end
        bench.left = 5
        await bench.step()
        assert bench.state == (0, 0)
    await bench.step()
    assert bench.state == (0, CREDIT_OUT)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_fault_of_the_zero(dut: object) -> None:
    """It ends what is armed. A 1 or a press measures anew, and arms if the fault is gone then."""
    bench = ArmBench(dut)
    await bench.begin()
    for order in (bench.press, lambda: bench.write(1)):
        await bench.arm()
        await bench.step(**ANEW)
        assert bench.state == (0, FAULT)
        starts = bench.starts
        await order()
        if not SENSE:
            assert bench.state == (0, FAULT)
            bench.drive(zero_i=0)
            continue
        await bench.step(2, zero_i=0)
        assert bench.starts == starts + 1
        await bench.measured()
        await bench.write(0)
        # It is there again before the zero is.
        await bench.step(**ANEW)
        await order()
        await bench.step(ZERO_CLOCKS + 2)
        assert bench.state == (0, FAULT)
        bench.drive(zero_i=0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def anything_at_any_time(dut: object) -> None:
    """Random writes and reasons against the rule in words."""
    bench, rng = ArmBench(dut), random_source("any")
    await bench.begin()
    since, armed, seen, stays = CREDIT, 0, 0, False
    for _ in range(8_000):
        calm = rng.random() < 0.97
        inputs = {
            "enable_i": int(calm or rng.random() < 0.5),
            "fault_i": int(not calm and rng.random() < 0.5),
            "write_i": int(rng.random() < 0.05), "value_i": rng.choice((0, 1, 1, 2, 2, 2)),
            "press_i": int(rng.random() < 0.005),
        }  # fmt: skip
        before = armed
        await bench.step(**inputs)
        armed = bench.word("armed_o")
        drops = inputs["write_i"] and not inputs["value_i"]
        refuses = not inputs["enable_i"] or inputs["fault_i"] or drops
        presses = inputs["press_i"] and not drops
        stays = (stays or presses) and not refuses
        since = 0 if presses or (inputs["write_i"] and inputs["value_i"]) else since + 1
        begins = presses or (inputs["write_i"] and inputs["value_i"] == 1)
        if refuses or (since >= CREDIT and not stays):
            assert not armed
        elif before or (not SENSE and begins):
            assert armed
        elif not SENSE:
            assert not armed
        seen += armed > before
    assert seen > 20
