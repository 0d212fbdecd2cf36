# SPDX-License-Identifier: Apache-2.0
"""``[shaper]``: what contact feels like."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from wavehaptics.scene.keys import Table, as_tuples, broken_rule, field_texts, scene_key

Index = Annotated[int, Field(ge=0, le=999)]
"""Place of a wall in ``controller.walls``."""
Feel = Literal["spring", "layer", "mass", "resonance"]
# Keys that each feel needs, and those that it may have besides.
_NEEDS: dict[str, tuple[str, ...]] = {
    "spring": ("stiffness",),
    "layer": ("stiffness",),
    "mass": ("mass_kgm2",),
    "resonance": ("stiffness", "mass_kgm2"),
}

MOST_SECTIONS = 2
"""Biquads of a shaper."""
_Coefficient = Annotated[float, Field(ge=-1e6, le=1e6)]
_Rows = tuple[tuple[_Coefficient, ...], ...]


class Shaper(Table):
    """What contact feels like, as a wave-domain filter W; without this table W is 1."""

    feel: Feel | None = scene_key(
        "–", "Impedance type, see below", None,
        range_text=", ".join(f"`{name}`" for name in _NEEDS),
    )  # fmt: skip
    stiffness: float | None = scene_key("N·m/rad", "Spring of the feel", None, ge=1e-9, le=1e6)
    damping: float = scene_key("N·m·s/rad", "Damper of the feel", 0.0, ge=0, le=1000)
    mass_kgm2: float | None = scene_key("kg·m²", "Inertia of the feel", None, ge=1e-12, le=1)
    sos: Annotated[_Rows | None, BeforeValidator(as_tuples)] = scene_key(
        "–", "Biquads of your own in z, in place of a feel", None,
        range_text="one or two rows `[b0, b1, b2, a0, a1, a2]`",
    )  # fmt: skip
    walls: Annotated[tuple[Index, ...] | None, BeforeValidator(as_tuples)] = scene_key(
        "–", "Walls with this feel, by their index in `controller.walls`, from 0; others are rigid",
        None, default_text="all", range_text="indices in `controller.walls`",
    )  # fmt: skip

    @property
    def sections(self) -> int:
        """Biquads that it takes."""
        return 1 if self.sos is None else len(self.sos)

    @model_validator(mode="after")
    def _check(self) -> Shaper:
        if self.sos is not None:
            given = self.model_fields_set & {"feel", "stiffness", "damping", "mass_kgm2"}
            if given:
                broken_rule(
                    f"shaper.{min(given)} makes no sense beside sos; give one of the two",
                    min(given),
                    "sos",
                )
            if not 1 <= len(self.sos) <= MOST_SECTIONS or any(len(row) != 6 for row in self.sos):
                broken_rule(
                    "shaper.sos must hold one or two rows of six numbers; "
                    "write sos = [[b0, b1, b2, a0, a1, a2]]",
                    "sos",
                )
            return self
        if self.feel is None:
            broken_rule(
                f"[shaper] has neither feel nor sos; write feel = one of {', '.join(_NEEDS)}", ()
            )
        needs = _NEEDS[self.feel]
        shown = f'feel = "{self.feel}"'
        for key in needs:
            if getattr(self, key) is None:
                unit = field_texts(type(self), key).unit
                broken_rule(f"shaper.{key} is missing, {shown} needs it; give it in {unit}", "feel")
        for key in ("stiffness", "mass_kgm2"):
            if key in self.model_fields_set and key not in needs:
                broken_rule(
                    f"shaper.{key} makes no sense: {shown} does not use it; "
                    f"it takes {', '.join((*needs, 'damping'))}",
                    key,
                    "feel",
                )
        return self
