# SPDX-License-Identifier: Apache-2.0
"""``[[surface]]``: a solid that the tip touches."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from wavehaptics.scene.keys import Table, as_tuples, broken_rule, scene_key

_Place = Annotated[float, Field(ge=-10, le=10)]
_Size = Annotated[float, Field(ge=1e-6, le=10)]
Point = Annotated[tuple[_Place, _Place, _Place], BeforeValidator(as_tuples)]
Direction = Annotated[tuple[_Place, _Place, _Place], BeforeValidator(as_tuples)]
_Sizes = Annotated[tuple[_Size, _Size, _Size], BeforeValidator(as_tuples)]

_NEEDS = {"plane": "normal", "sphere": "radius_m", "box": "size_m"}
THREE = "three, each -10 to 10"


def unit(direction: tuple[float, float, float]) -> tuple[float, float, float]:
    """A direction of length 1; one of length 0 stays as it is."""
    length = math.sqrt(sum(part * part for part in direction)) or 1.0
    x, y, z = (part / length for part in direction)
    return x, y, z


class Surface(Table):
    """A plane, a sphere or a box in the space of the tip, solid on one side."""

    shape: Literal["plane", "sphere", "box", "edge"] = scene_key(
        "–", "Kind of solid; an inner edge is two planes", range_text="`plane`, `sphere`, `box`"
    )
    point_m: Point = scene_key(
        "m", "A point of the plane, or the middle of sphere or box, as x, y, z", (0.0, 0.0, 0.0),
        default_text="the tip's place at the start", range_text=THREE,
    )  # fmt: skip
    normal: Direction | None = scene_key(
        "–", "Direction out of the solid of a `plane`, which alone takes it", None,
        default_text="none", range_text=THREE,
    )  # fmt: skip
    radius_m: float | None = scene_key(
        "m", "Radius of a `sphere`, which alone takes it", None, default_text="none",
        ge=1e-6, le=10,
    )  # fmt: skip
    size_m: _Sizes | None = scene_key(
        "m", "Lengths of a `box` along x, y and z, which alone takes them", None,
        default_text="none", range_text="three, each 1e-6 to 10",
    )  # fmt: skip
    stiffness: float | None = scene_key(
        "N/m", "Stiffness at the tip along the normal", None,
        default_text="the largest that motors and `lambda` allow there", ge=1e-3, le=1e7,
    )  # fmt: skip
    damping: float = scene_key(
        "N·s/m", "Damper in parallel with that spring; not available yet", 0.0, ge=0, le=1e4
    )
    friction_loss: float = scene_key(
        "–", "Part of the waves along the surface that is lost in contact", 0.0, ge=0, le=1
    )

    @model_validator(mode="after")
    def _check(self) -> Surface:
        if self.shape == "edge":
            broken_rule(
                'shape = "edge" is no shape of its own; write a [[surface]] of shape = "plane" for '
                "each side", "shape",
            )  # fmt: skip
        for shape, key in _NEEDS.items():
            given = getattr(self, key) is not None
            if shape == self.shape and not given:
                broken_rule(f'{key} is missing, shape = "{shape}" needs it; give it', "shape")
            if shape != self.shape and given:
                broken_rule(
                    f'{key} makes no sense: shape = "{self.shape}" takes {_NEEDS[self.shape]}; '
                    "leave it out", key, "shape",
                )  # fmt: skip
        if self.normal is not None and not any(self.normal):
            broken_rule("normal has no direction; give the way out of the solid", "normal")
        if self.damping:
            broken_rule(
                "damping is not had yet; leave it out, or take a smaller stiffness", "damping"
            )
        return self
