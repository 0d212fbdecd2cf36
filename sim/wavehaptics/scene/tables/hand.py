# SPDX-License-Identifier: Apache-2.0
"""``[hand]``: the user."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from wavehaptics.scene.keys import Table, broken_rule, field_texts, scene_key

HandPath = Literal["taps", "press", "free", "sine", "impact"]
_NEEDS: dict[str, tuple[str, ...]] = {
    "taps": ("frequency_hz", "stiffness"),
    "press": ("stiffness",),
    "free": ("frequency_hz", "stiffness"),
    "sine": ("frequency_hz", "stiffness"),
    "impact": ("speed_rad_s",),
}
_TAKES = {
    path: {*needs, *(() if path == "impact" else ("damping", "inertia_kgm2"))}
    for path, needs in _NEEDS.items()
}


class Hand(Table):
    """The user: a spring and damper from the rotor to a point x_h(t); without it, a free rotor."""

    path: HandPath = scene_key(
        "–", "Motion of the hand, see below", range_text=", ".join(f"`{name}`" for name in _NEEDS)
    )
    amplitude_rad: float = scene_key("rad", "Amplitude A of the path", ge=1e-6, le=1000)
    frequency_hz: float | None = scene_key(
        "Hz", "Frequency f of `taps`, `free` and `sine`", None, ge=1e-3, le=1e4
    )
    stiffness: float | None = scene_key(
        "N·m/rad", "Spring of the hand; every path but `impact` needs it", None, ge=1e-9, le=1e6
    )
    damping: float = scene_key(
        "N·m·s/rad", "Damper of the hand; not with `impact`", 0.0, ge=0, le=1000
    )
    inertia_kgm2: float = scene_key(
        "kg·m²", "Mass of the hand where it holds; not with `impact`", 0.0, ge=0, le=1
    )
    speed_rad_s: float | None = scene_key(
        "rad/s", "Speed of the rotor at the start of an `impact`, which alone needs it; not 0",
        None, ge=-1e4, le=1e4,
    )  # fmt: skip

    @model_validator(mode="after")
    def _check(self) -> Hand:
        shown = f'path = "{self.path}"'
        takes = _TAKES[self.path]
        for key in ("frequency_hz", "stiffness", "damping", "inertia_kgm2", "speed_rad_s"):
            if key in self.model_fields_set and key not in takes:
                wanted = ", ".join(["amplitude_rad", *sorted(takes)])
                why = "has no hand" if self.path == "impact" else "does not use it"
                broken_rule(
                    f"hand.{key} makes no sense: {shown} {why}; it takes {wanted}", key, "path"
                )
        for key in _NEEDS[self.path]:
            if getattr(self, key) is None:
                unit = field_texts(type(self), key).unit
                broken_rule(f"hand.{key} is missing, {shown} needs it; give it in {unit}", "path")
        if self.speed_rad_s == 0:
            broken_rule("hand.speed_rad_s = 0 is no impact; give a speed in rad/s", "speed_rad_s")
        return self
