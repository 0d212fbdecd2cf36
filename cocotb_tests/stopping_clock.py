# SPDX-License-Identifier: Apache-2.0
"""A clock that stops and goes on when it is told to."""

from __future__ import annotations

import cocotb
from cocotb.handle import LogicObject
from cocotb.triggers import Event, Timer
from cocotb.utils import get_sim_time


class StoppingClock:
    """A clock at ``signal``, at rest until :meth:`go`."""

    def __init__(self, signal: LogicObject, period_ps: int) -> None:
        self.signal = signal
        self.period_ps = period_ps
        """May be changed at any time."""
        self.last_edge_ps = 0
        """When it rose last."""
        self._going = Event()
        self.signal.value = 0
        cocotb.start_soon(self._run())

    def go(self) -> None:
        self._going.set()

    def stop(self) -> None:
        """No rising edge from now on."""
        self._going.clear()

    async def _run(self) -> None:
        while True:
            await self._going.wait()
            self.signal.value = 1
            self.last_edge_ps = get_sim_time("ps")
            high_ps = self.period_ps // 2
            await Timer(high_ps, unit="ps")
            self.signal.value = 0
            await Timer(self.period_ps - high_ps, unit="ps")
