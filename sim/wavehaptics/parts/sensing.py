# SPDX-License-Identifier: Apache-2.0
"""Parts that sense the current beside a switching bridge, and how fast a carrier they follow.

Their figures and where these come from stand in ``boards/sensing.toml``.
"""

from __future__ import annotations

import math
from functools import cache

from pydantic import BaseModel, ConfigDict, Field

from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import parse

TABLE = ROOT / "boards" / "sensing.toml"

HOLD_TOLERANCE = 0.2
"""By how much a hold may be longer than its data sheet's typical time, where that has no limits."""


class SensingPart(BaseModel):
    """A row of the table, in SI units; its head explains the keys."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    what: str
    bandwidth_hz: float | None = Field(None, gt=0)
    response_s: float = Field(0.0, ge=0)
    hold_s: float = Field(0.0, ge=0)
    hold_restarts: bool = True
    settle_s: float = Field(0.0, ge=0)
    edge_part: float = Field(0.0, ge=0)
    noise_a: float = Field(0.0, ge=0)
    modulator: str | None = None
    one_half: bool = False
    unverified: list[str] = Field(default_factory=list)
    sources: list[str] = Field(min_length=1)

    @property
    def lag_hz(self) -> float | None:
        """Bandwidth of the first-order lag that stands for the part; None without a lag.

        A lag reaches 90 % of a step after ln 10 of its time constants.
        """
        if self.bandwidth_hz is None or not self.response_s:
            return self.bandwidth_hz
        return min(self.bandwidth_hz, math.log(10.0) / (2 * math.pi * self.response_s))

    @property
    def carrier_hz(self) -> float:
        """The fastest carrier that it follows, at 0 V, where each half of a period is as long.

        A hold that restarts has to end before the next edge, half a period later, with
        :data:`HOLD_TOLERANCE`; what settles has to before the sample, a quarter later.
        """
        held_s = self.hold_s * (1.0 + HOLD_TOLERANCE) if self.hold_restarts else 0.0
        half_s = max(held_s, 2 * self.settle_s)
        return 0.5 / half_s if half_s else math.inf

    def refusal(self, carrier_hz: float, tick_s: float) -> str | None:
        """Why it can't follow a carrier with a tick of ``tick_s``; None if it can."""
        half_us = 0.5e6 / carrier_hz
        if self.one_half and tick_s < (1.0 - 1e-9) / carrier_hz:
            return f"it sees one half of each carrier period, and a tick is {1e6 * tick_s:.3g} µs"
        if carrier_hz <= self.carrier_hz * (1.0 + 1e-9):
            return None
        if 2 * self.settle_s > half_us * 1e-6:
            return (
                f"it settles for {1e6 * self.settle_s:.3g} µs after an edge, and the sample comes "
                f"{0.5 * half_us:.3g} µs after it"
            )
        return (
            f"it holds its output for {1e6 * self.hold_s:.3g} µs after an edge, give or take "
            f"{HOLD_TOLERANCE:.0%}, and at 0 V there is one each {half_us:.3g} µs"
        )

    def settings(self, bus_v: float, shunt_ohm: float) -> list[str]:
        """Keys of a scene, ``table.key=value``, by which ``pins`` has this part on a shunt."""
        found = {
            "adc.part": self.modulator,
            "adc.bandwidth_hz": self.lag_hz,
            "adc.edge_hold_s": self.hold_s or None,
            "adc.common_mode_a": self.edge_part * bus_v / shunt_ohm or None,
            "adc.edge_settle_s": self.settle_s or None,
            "adc.noise_a": self.noise_a or None,
        }
        chosen = [f"{key}={value}" for key, value in found.items() if value is not None]
        if self.hold_s:
            chosen.append(f"adc.edge_hold_restarts={str(self.hold_restarts).lower()}")
        return chosen


@cache
def sensing_parts() -> dict[str, SensingPart]:
    """The parts of the table, by name."""
    data, _ = parse(TABLE.read_bytes())
    return {name: SensingPart.model_validate(row) for name, row in data.items()}
