# SPDX-License-Identifier: Apache-2.0
"""The far end of a serial line: bytes at any rate, with any fault."""

from __future__ import annotations

import cocotb
from cocotb.triggers import FallingEdge, Timer


class Line:
    """Drives ``rx`` and listens to ``tx`` of a design, at ``bit_ns`` a bit."""

    def __init__(self, rx: object, tx: object, bit_ns: float) -> None:
        self.rx, self.tx, self.bit_ns = rx, tx, bit_ns
        self.heard = bytearray()
        self.broken = 0
        rx.value = 1
        self._listener = cocotb.start_soon(self._listen())

    async def _wait(self, bits: float, since: int = 0) -> None:
        await Timer(round(1000 * bits * self.bit_ns) - since, unit="ps")

    async def byte(self, data: int, stop: int = 1) -> None:
        for bit in (0, *(data >> place & 1 for place in range(8)), stop):
            self.rx.value = bit
            await self._wait(1)
        self.rx.value = 1

    async def send(self, frame: bytes) -> None:
        for data in frame:
            await self.byte(data)

    async def _listen(self) -> None:
        while True:
            await FallingEdge(self.tx)
            await self._wait(0.5)
            start = int(self.tx.value)
            data = 0
            for place in range(8):
                await self._wait(1)
                data |= int(self.tx.value) << place
            await self._wait(1)
            self.broken += start | (not int(self.tx.value))
            self.heard.append(data)
