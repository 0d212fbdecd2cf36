# SPDX-License-Identifier: Apache-2.0
"""``[encoder]`` on the rotor."""

from __future__ import annotations

from pydantic import model_validator

from wavehaptics.scene.keys import Table, broken_rule, scene_key


class Encoder(Table):
    """A quadrature encoder on the rotor; without this table the position is ideal."""

    counts_per_rev: int = scene_key(
        "counts",
        "Counts a revolution, all four edges counted",
        range_text="a multiple of 4 from 4 to 4e6",
        ge=4,
        le=4_000_000,
        multiple_of=4,
    )
    stops_at_s: float | None = scene_key(
        "s",
        "Time from which A and B stay constant, as if the cable had come off",
        None,
        default_text="never",
        ge=0,
        le=1e6,
    )
    uneven: float = scene_key(
        "–",
        "Largest displacement of an edge, as a fraction of a count, the same in each revolution",
        0.0,
        ge=0,
        le=0.45,
    )
    reverses_at_s: float | None = scene_key(
        "s",
        "Time from which it counts backwards, as if A and B were swapped",
        None,
        default_text="never",
        ge=0,
        le=1e6,
    )
    skips_per_rev: int = scene_key(
        "edges",
        "Edges of a revolution that are lost, evenly spaced, at most a quarter of all",
        0,
        ge=0,
        le=1_000_000,
    )

    @model_validator(mode="after")
    def _check(self) -> Encoder:
        if 4 * self.skips_per_rev > self.counts_per_rev:
            broken_rule(
                f"encoder.skips_per_rev = {self.skips_per_rev} is more than a quarter of "
                f"counts_per_rev = {self.counts_per_rev}; it may be at most "
                f"{self.counts_per_rev // 4}",
                "skips_per_rev",
                "counts_per_rev",
            )
        return self
