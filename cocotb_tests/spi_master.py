# SPDX-License-Identifier: Apache-2.0
"""A master on SPI: transfers at any rate, in mode 0 or 3, with any fault."""

from __future__ import annotations

from bench import CLOCK_NS
from cocotb.triggers import Timer

HOLD_NS = 1.5 * CLOCK_NS
"""How long MISO has to stay after the edge that samples it."""


class SpiMaster:
    """Drives CS, SCLK and MOSI of a design and samples MISO, ``clocks`` of the design a bit."""

    def __init__(self, cs_n: object, sclk: object, mosi: object, miso: object) -> None:
        self.cs_n, self.sclk, self.mosi, self.miso = cs_n, sclk, mosi, miso
        self.clocks, self.mode = 8.0, 0
        cs_n.value, sclk.value, mosi.value = 1, 0, 0

    async def wait(self, clocks: float) -> None:
        await Timer(round(1000 * clocks * CLOCK_NS), unit="ps")

    async def begin(self) -> None:
        self.sclk.value = self.mode & 1
        await self.wait(max(self.clocks, 8))
        self.cs_n.value = 0
        await self.wait(max(self.clocks / 2, 6))

    async def end(self) -> None:
        await self.wait(max(self.clocks / 2, 3))
        self.cs_n.value = 1
        await self.wait(max(self.clocks, 8))

    async def bit(self, out: int) -> int:
        """One bit each way; SCLK is low in its first half, in either mode."""
        self.sclk.value = 0
        self.mosi.value = out
        await self.wait(self.clocks / 2)
        got = int(self.miso.value)
        self.sclk.value = 1
        await self.wait(HOLD_NS / CLOCK_NS)
        assert int(self.miso.value) == got, "MISO has changed where the master samples it"
        await self.wait(self.clocks / 2 - HOLD_NS / CLOCK_NS)
        return got

    async def byte(self, out: int) -> int:
        got = 0
        for place in reversed(range(8)):
            got = got << 1 | await self.bit(out >> place & 1)
        return got

    async def transfer(self, out: bytes) -> bytes:
        await self.begin()
        got = bytes([await self.byte(data) for data in out])
        if not self.mode:
            self.sclk.value = 0
        await self.end()
        return got
