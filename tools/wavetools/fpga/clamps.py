# SPDX-License-Identifier: Apache-2.0
"""Clamps that end the rise of a bus, and the buses that they are for.

Their figures stand in ``boards/clamps.toml``.
"""

from __future__ import annotations

from functools import cache

from pydantic import BaseModel, ConfigDict, Field
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import parse

TABLE = ROOT / "boards" / "clamps.toml"

MOST_OF_BUS = 1.5
"""A clamp that conducts above so much of the bus is none for it: a board doesn't measure its bus,
so a motor gets as much more than the controller asked for."""


class Clamp(BaseModel):
    """A row of the table; its head explains the keys."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    standoff_v: float = Field(gt=0)
    conducts_v: list[float] = Field(min_length=2, max_length=2)
    clamp_v: float = Field(gt=0)
    clamp_a: float = Field(gt=0)

    def refusal(self, bus_v: float, bus_max_v: float) -> str | None:
        """Why it isn't for a bus whose parts bear ``bus_max_v``; None where it is."""
        if self.standoff_v < bus_v:
            return f"stands off {self.standoff_v:g} V, and the bus is {bus_v:g} V: it would burn"
        if self.clamp_v > bus_max_v:
            return f"lets the bus rise to {self.clamp_v:g} V, and its parts bear {bus_max_v:g} V"
        if self.conducts_v[0] > MOST_OF_BUS * bus_v:
            return (
                f"conducts from {self.conducts_v[0]:g} V on, and the bus is {bus_v:g} V: below "
                f"that a bus that rises drives the motor with up to "
                f"{self.conducts_v[0] / bus_v:.2g} times the voltage that is asked for"
            )
        return None


@cache
def clamps() -> dict[str, Clamp]:
    """The clamps of the table, by name."""
    data, _ = parse(TABLE.read_bytes())
    return {name: Clamp.model_validate(row) for name, row in data.items()}
