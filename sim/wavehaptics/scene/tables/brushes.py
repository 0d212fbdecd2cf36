# SPDX-License-Identifier: Apache-2.0
"""``[brushes]`` and commutator."""

from __future__ import annotations

from pydantic import model_validator

from wavehaptics.scene.keys import Table, broken_rule, scene_key


class Brushes(Table):
    """The brushes; without this table they are part of R."""

    drop_v: float = scene_key(
        "V", "Voltage drop V_b: V_b·tanh(i/`knee_a`) in series with the winding", 0.0, ge=0, le=10
    )
    knee_a: float = scene_key("A", "Current at which the drop bends", 5e-3, ge=1e-4, le=100)
    contact_noise: float = scene_key(
        "–",
        "Noise of the sliding contact over the angle, none at rest: RMS, as a "
        "fraction of R",
        0.0,
        ge=0, le=0.5,
    )  # fmt: skip
    noise_rad: float = scene_key("rad", "Correlation angle of that noise", 5e-3, ge=1e-4, le=10)
    flicker_noise: float = scene_key(
        "–", "Noise of the contact over time, also at rest: RMS, as a fraction of R", 0.0, ge=0,
        le=0.5,
    )  # fmt: skip
    flicker_s: float = scene_key("s", "Correlation time of that noise", 1e-3, ge=1e-5, le=10)
    segments: int = scene_key(
        "bars", "Bars of the commutator; `ripple` and `step` need it", 0, default_text="none",
        ge=1, le=1000,
    )  # fmt: skip
    ripple: float = scene_key(
        "–", "Variation of R over the angle, as a fraction of R: ripple·cos(segments·x)", 0.0,
        ge=-0.5, le=0.5,
    )  # fmt: skip
    step: float = scene_key(
        "–", "What every other bar adds to R, as a fraction of R, with sharp edges", 0.0,
        ge=-0.5, le=0.5,
    )  # fmt: skip
    step_at_rad: float = scene_key(
        "rad", "An edge of the bars: above it, up to the next, R has the `step`", 0.0,
        ge=-1000, le=1000,
    )  # fmt: skip

    @model_validator(mode="after")
    def _check(self) -> Brushes:
        for key in ("ripple", "step"):
            if getattr(self, key) and not self.segments:
                broken_rule(
                    f"brushes.{key} needs to know the bars of the commutator; give segments", key
                )
        for key, needed in (("knee_a", "drop_v"), ("noise_rad", "contact_noise"),
                            ("flicker_s", "flicker_noise"), ("step_at_rad", "step")):  # fmt: skip
            if key in self.model_fields_set and needed not in self.model_fields_set:
                broken_rule(f"brushes.{key} does nothing without {needed}; give {needed}", key)
        return self
