# SPDX-License-Identifier: Apache-2.0
"""``[hand]`` of a scene with a ``[device]``: the user, who holds the tip."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from wavehaptics.scene.keys import Table, broken_rule, field_texts, scene_key
from wavehaptics.scene.tables.surface import THREE, Direction, Point

TipPath = Literal["press", "taps", "slide", "circle"]
_NEEDS: dict[str, tuple[str, ...]] = {
    "press": ("direction",),
    "taps": ("direction", "frequency_hz"),
    "slide": ("direction", "frequency_hz", "across", "slide_m"),
    "circle": ("frequency_hz", "across", "center_m"),
}
_OPTIONAL = ("direction", "frequency_hz", "across", "slide_m", "center_m")


class TipHand(Table):
    """The user: a spring and damper, alike in all directions, from the tip to a moving point."""

    path: TipPath = scene_key(
        "–", "Motion of the hand, see below", range_text=", ".join(f"`{name}`" for name in _NEEDS)
    )
    amplitude_m: float = scene_key("m", "Amplitude A of the path", ge=0, le=1)
    stiffness_n_per_m: float = scene_key("N/m", "Spring of the hand", ge=1e-3, le=1e5)
    damping_n_s_per_m: float = scene_key("N·s/m", "Damper of the hand", 0.0, ge=0, le=1e4)
    direction: Direction | None = scene_key(
        "–", "Direction of the path as x, y, z; not of `circle`", None,
        range_text=THREE,
    )  # fmt: skip
    frequency_hz: float | None = scene_key(
        "Hz", "Frequency f of `taps` and `slide`, turns a second of `circle`", None,
        ge=1e-3, le=1e3,
    )  # fmt: skip
    across: Direction | None = scene_key(
        "–", "Where `slide` and `circle` go from there", None,
        range_text=THREE,
    )  # fmt: skip
    slide_m: float | None = scene_key("m", "How far `slide` goes", None, ge=0, le=1)
    center_m: Point | None = scene_key("m", "Middle of a `circle`", None, range_text=THREE)

    @model_validator(mode="after")
    def _check(self) -> TipHand:
        for key in _OPTIONAL:
            needed = key in _NEEDS[self.path]
            if needed and getattr(self, key) is None:
                unit = field_texts(type(self), key).unit
                given = "give it" if unit == "–" else f"give it in {unit}"
                broken_rule(
                    f'hand.{key} is missing, path = "{self.path}" needs it; {given}', "path"
                )
            if not needed and key in self.model_fields_set:
                takes = ", ".join(_NEEDS[self.path])
                broken_rule(
                    f'hand.{key} makes no sense: path = "{self.path}" does not use it; it takes '
                    f"{takes}", key, "path",
                )  # fmt: skip
        for key in ("direction", "across"):
            if getattr(self, key) is not None and not any(getattr(self, key)):
                broken_rule(f"hand.{key} has no direction; give one", key)
        return self
