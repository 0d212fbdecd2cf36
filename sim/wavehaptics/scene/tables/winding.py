# SPDX-License-Identifier: Apache-2.0
"""``[winding]``: what its iron does."""

from __future__ import annotations

from pydantic import model_validator

from wavehaptics.scene.keys import Table, broken_rule, scene_key


class Winding(Table):
    """What the winding's iron does; without this table L is L at any frequency and current."""

    eddy_ohm: float | None = scene_key(
        "Ω", "Resistance in parallel to `eddy_part` of L: eddy currents", None, ge=0.01, le=1e5
    )
    eddy_part: float | None = scene_key(
        "–", "Fraction of L that has `eddy_ohm` in parallel, required with it", None, ge=1e-3,
        le=0.95,
    )  # fmt: skip
    saturation_a: float | None = scene_key(
        "A", "Current at which the incremental L is half: L/(1 + (i/this)²)", None,
        default_text="never", ge=1e-2, le=1000,
    )  # fmt: skip

    @model_validator(mode="after")
    def _check(self) -> Winding:
        for key, other in (("eddy_ohm", "eddy_part"), ("eddy_part", "eddy_ohm")):
            if getattr(self, key) is not None and getattr(self, other) is None:
                broken_rule(f"winding.{key} does nothing without {other}; give {other}", key)
        return self
