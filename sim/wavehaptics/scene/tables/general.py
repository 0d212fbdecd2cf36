# SPDX-License-Identifier: Apache-2.0
"""``[scene]``: what the run is called, how long it is and how much of it is kept."""

from __future__ import annotations

import re

from pydantic import model_validator

from wavehaptics.scene.keys import Table, as_written, broken_rule, field_texts, scene_key


class SceneTable(Table):
    """What the run is called, how long it is and how much of it is kept."""

    name: str = scene_key(
        "–", "Name of the scene, also of the folder for its results",
        range_text="1 to 60 printable characters without / and \\",
    )  # fmt: skip
    duration_s: float = scene_key("s", "Simulated time, at least one tick", ge=1e-6, le=1e6)
    trace_hz: float | None = scene_key(
        "Hz", "Most rows of the trace a second; metrics use every control period all the same",
        None, default_text="every tick", ge=1e-3, le=4e6,
    )  # fmt: skip

    @model_validator(mode="after")
    def _check(self) -> SceneTable:
        printable = self.name.isprintable() and self.name.strip() != ""
        if len(self.name) > 60 or not printable or re.search(r"[/\\]", self.name):
            wanted = field_texts(type(self), "name").range
            broken_rule(
                f"scene.name = {as_written(self.name)} can't name a folder; use {wanted}", "name"
            )
        return self
