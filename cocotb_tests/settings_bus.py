# SPDX-License-Identifier: Apache-2.0
"""A master on the bus of the settings memory."""

from __future__ import annotations

from bench import Bench
from wavehaptics.words.table import WORDS

DONE, UNKNOWN, RANGE, NOT_NOW = range(4)
"""Errors of the bus."""

COMMIT, DISCARD, BUSY, STAGED = (
    WORDS[name].at() for name in ("commit", "discard", "settings_busy", "settings_staged")
)
REQUEST_CLOCKS = 8
"""No request lasts longer, once the defaults have been given."""


class BusBench(Bench):
    """A design with the bus."""

    async def begin(self, **inputs: int) -> None:
        await self.start(
            bus_valid_i=0, bus_write_i=0, bus_check_i=0, bus_address_i=0, bus_data_i=0, **inputs
        )  # fmt: skip

    async def request(self, write: int, address: int, data: int, most: int) -> tuple[int, int]:
        """(data, error) of a request; the bus ends it in ``most`` clocks."""
        self.drive(bus_valid_i=1, bus_write_i=write, bus_address_i=address, bus_data_i=data)
        for _ in range(most):
            await self.step()
            if self.word("bus_ready_o"):
                break
        else:
            raise AssertionError(f"no answer from 0x{address:03x} in {most} clocks")
        error = self.word("bus_error_o")
        read = self.word("bus_data_o") if not (error or write) else 0
        self.drive(bus_valid_i=0)
        await self.step()
        assert not self.word("bus_ready_o")
        return read, error

    async def write(self, address: int, raw: int, most: int = REQUEST_CLOCKS) -> int:
        return (await self.request(1, address, raw, most))[1]

    async def read(self, address: int, most: int = REQUEST_CLOCKS) -> tuple[int, int]:
        return await self.request(0, address, 0, most)

    async def value(self, address: int) -> int:
        """A word that can be read."""
        raw, error = await self.read(address)
        assert error == DONE, hex(address)
        return raw

    async def rests(self, most: int = 20_000) -> None:
        """Wait until nothing is under way."""
        for _ in range(most):
            if not await self.value(BUSY):
                return
        raise AssertionError("the settings are busy")
