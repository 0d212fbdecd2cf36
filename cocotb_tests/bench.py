# SPDX-License-Identifier: Apache-2.0
"""What the benches share: a clock, words in and out, and a random source that says its seed.

A bench acts at the clock's falling edge: it reads what the last rising edge has made, and drives
what the next one will see. So neither can race, and a clock costs one wait.
"""

from __future__ import annotations

import os
import random
from collections.abc import Iterable

import cocotb
from cocotb.clock import Clock
from cocotb.handle import LogicArrayObject, LogicObject
from cocotb.triggers import FallingEdge, ReadOnly, Timer

CLOCK_NS = 10
"""Period of the simulated clock, ns. Real periods matter to the models of parts only."""

WAKE_NS = 7
"""How long before an edge a bench that sleeps for clocks wakes up to wait for it, ns: less than a
period, so that it is this edge, and more than half, as the first edge comes after half a period.
"""


def random_source(name: str) -> random.Random:
    """Random numbers for the test ``name``, from WH_SEED or a fixed seed, which is logged."""
    seed = os.environ.get("WH_SEED", "20")
    cocotb.log.info("%s: WH_SEED=%s", name, seed)
    return random.Random(f"{name} {seed}")


def pack(words: Iterable[int], width: int) -> int:
    """Words of ``width`` bits side by side, the first one lowest."""
    packed = 0
    for place, word in enumerate(words):
        packed |= (word & ((1 << width) - 1)) << (place * width)
    return packed


def unpack(packed: int, width: int, count: int) -> list[int]:
    """The ``count`` signed words of ``width`` bits in ``packed``, the lowest first."""
    half = 1 << (width - 1)
    words = [(packed >> (place * width)) & (2 * half - 1) for place in range(count)]
    return [word - 2 * half if word >= half else word for word in words]


class Bench:
    """A clocked design and its pins."""

    def __init__(self, dut: object) -> None:
        self.dut = dut
        self.clocks = 0
        self._clock_runs = False
        self._falling = FallingEdge(dut.clk)
        self._handles: dict[str, LogicObject | LogicArrayObject] = {}

    def handle(self, name: str) -> LogicObject | LogicArrayObject:
        if name not in self._handles:
            self._handles[name] = getattr(self.dut, name)
        return self._handles[name]

    def drive(self, **inputs: int) -> None:
        """Set inputs (unsigned words; negative ones as two's complement) for the next edge."""
        for name, value in inputs.items():
            handle = self.handle(name)
            handle.value = value & ((1 << len(handle)) - 1)

    def word(self, name: str) -> int:
        """An output as an unsigned word; an undefined bit is an error."""
        return int(self.handle(name).value)

    def signed(self, name: str) -> int:
        """An output as a signed word."""
        return self.handle(name).value.to_signed()

    async def step(self, clocks: int = 1, **inputs: int) -> None:
        """Drive ``inputs``, then let ``clocks`` rising edges pass."""
        self.drive(**inputs)
        if clocks > 1:
            await Timer(clocks * CLOCK_NS - WAKE_NS, "ns")  # one wait for any number of clocks
        if clocks:
            await self._falling
        self.clocks += clocks

    async def settle(self, **inputs: int) -> None:
        """Drive ``inputs`` and wait until what follows from them without a clock is there.

        Nothing can be driven between this and the next :meth:`step` without inputs.
        """
        self.drive(**inputs)
        await ReadOnly()

    async def start(self, **inputs: int) -> None:
        """Start the clock with ``inputs``, reset for three clocks, and leave the reset.

        A clock that runs goes on: another one beside it would cost as much again.
        """
        if not self._clock_runs:
            cocotb.start_soon(Clock(self.dut.clk, CLOCK_NS, unit="ns").start())
            self._clock_runs = True
        await self.step(3, rst=1, **inputs)
        self.drive(rst=0)
