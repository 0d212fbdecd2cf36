# SPDX-License-Identifier: Apache-2.0
"""A design with a serial line, asked by pymodbus as its master."""

from __future__ import annotations

from bench import CLOCK_NS, Bench
from modbus_frames import decode

RATES = (115_200, 1_000_000, 1_500_000, 3_000_000)


class LineBench(Bench):
    """Whoever begins sets ``line``; the simulated clock is HZ a second."""

    HZ: float

    def bit_ns(self, rate: int) -> float:
        return self.HZ / RATES[rate] * CLOCK_NS

    async def answer(self) -> bytes:
        """What comes back, until the line is still for three characters."""
        bits = round(self.line.bit_ns / CLOCK_NS)
        count, idle = 0, 0
        while idle < (30 if count else 400):
            await self.step(5 * bits)
            idle = idle + 5 if len(self.line.heard) == count else 0
            count = len(self.line.heard)
        found = bytes(self.line.heard)
        self.line.heard.clear()
        assert self.line.broken == 0
        return found

    async def ask(self, frame: bytes):
        await self.line.send(frame)
        return decode(await self.answer())
