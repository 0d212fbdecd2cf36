# SPDX-License-Identifier: Apache-2.0
"""``[transmission]`` from the rotor to the hand."""

from __future__ import annotations

from pydantic import model_validator

from wavehaptics.scene.keys import Table, broken_rule, scene_key


class Transmission(Table):
    """From the rotor to the hand and to the tip of an arm; the rotor's stiffness stays the same."""

    ratio: float | None = scene_key(
        "–", "Turns of the rotor for one of the arm", None, ge=1e-3, le=1e4
    )
    lever_m: float | None = scene_key(
        "m", "Length of the arm, which goes with `ratio`", None,
        ge=1e-4, le=100,
    )  # fmt: skip
    cable_stiffness: float | None = scene_key(
        "N·m/rad", "Spring of the cable between rotor and hand", None, default_text="a rigid cable",
        ge=1e-6, le=1e6,
    )  # fmt: skip
    cable_damping: float = scene_key("N·m·s/rad", "Damper of the cable", 0.0, ge=0, le=1000)
    backlash_rad: float = scene_key(
        "rad", "Play of the cable from one side to the other", 0.0, ge=0, le=1000
    )

    @model_validator(mode="after")
    def _check(self) -> Transmission:
        for key, other in (("ratio", "lever_m"), ("lever_m", "ratio")):
            if getattr(self, key) is not None and getattr(self, other) is None:
                broken_rule(f"transmission.{key} does nothing without {other}; give {other}", key)
        for key in ("cable_damping", "backlash_rad"):
            if getattr(self, key) and self.cable_stiffness is None:
                broken_rule(f"transmission.{key} needs a cable; give cable_stiffness", key)
        if self.ratio is None and self.cable_stiffness is None:
            broken_rule(
                "[transmission] holds nothing; give ratio and lever_m, or cable_stiffness", ()
            )
        return self
