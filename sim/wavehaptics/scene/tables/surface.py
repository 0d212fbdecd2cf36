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

_NEEDS: dict[str, tuple[str, ...]] = {
    "plane": ("normal",), "sphere": ("radius_m",), "box": ("size_m",),
    "edge": ("normal", "second_normal"),
}  # fmt: skip
_LEAST_BEND = 0.01
"""Sine of the angle between two normals below which there is no edge."""
THREE = "three, each -10 to 10"


def unit(direction: tuple[float, float, float]) -> tuple[float, float, float]:
    """A direction of length 1; one of length 0 stays as it is."""
    length = math.sqrt(sum(part * part for part in direction)) or 1.0
    x, y, z = (part / length for part in direction)
    return x, y, z


class Surface(Table):
    """A plane, a sphere, a box or an inner edge in the space of the tip, solid on one side."""

    shape: Literal["plane", "sphere", "box", "edge"] = scene_key(
        "–", "Kind of solid; an `edge` is an inner one, of two planes",
        range_text=", ".join(f"`{name}`" for name in _NEEDS),
    )  # fmt: skip
    point_m: Point = scene_key(
        "m", "A point of the plane or the edge, or the middle of sphere or box, as x, y, z",
        (0.0, 0.0, 0.0),
        default_text="the tip's place at the start", range_text=THREE,
    )  # fmt: skip
    normal: Direction | None = scene_key(
        "–", "Direction out of the solid of a `plane`, or of one side of an `edge`", None,
        range_text=THREE,
    )  # fmt: skip
    second_normal: Direction | None = scene_key(
        "–", "The same of the other side of an `edge`, which alone takes it", None,
        range_text=THREE,
    )  # fmt: skip
    radius_m: float | None = scene_key(
        "m", "Radius of a `sphere`, which alone takes it", None,
        ge=1e-6, le=10,
    )  # fmt: skip
    size_m: _Sizes | None = scene_key(
        "m", "Lengths of a `box` along x, y and z, which alone takes them", None,
        range_text="three, each 1e-6 to 10",
    )  # fmt: skip
    stiffness: float | None = scene_key(
        "N/m", "Stiffness at the tip along the normal", None,
        default_text="the largest that motors and `lambda` allow there", ge=1e-3, le=1e7,
    )  # fmt: skip
    damping: float = scene_key(
        "N·s/m",
        "Damper in parallel with that spring; 0: the one that the motors' resistance makes", 0.0,
        ge=0, le=1e4,
    )  # fmt: skip
    friction_loss: float = scene_key(
        "–", "Part of the waves along the surface that is lost in contact", 0.0, ge=0, le=1
    )

    @model_validator(mode="after")
    def _check(self) -> Surface:
        needs = _NEEDS[self.shape]
        for key in dict.fromkeys(key for keys in _NEEDS.values() for key in keys):
            given = getattr(self, key) is not None
            if key in needs and not given:
                broken_rule(f'{key} is missing, shape = "{self.shape}" needs it; give it', "shape")
            if key not in needs and given:
                broken_rule(
                    f'{key} makes no sense: shape = "{self.shape}" takes {" and ".join(needs)}; '
                    "leave it out", key, "shape",
                )  # fmt: skip
        for key in ("normal", "second_normal"):
            if getattr(self, key) is not None and not any(getattr(self, key)):
                broken_rule(f"{key} has no direction; give the way out of the solid", key)
        if self.normal is not None and self.second_normal is not None:
            (x, y, z), (a, b, c) = unit(self.normal), unit(self.second_normal)
            if math.hypot(y * c - z * b, z * a - x * c, x * b - y * a) < _LEAST_BEND:
                broken_rule(
                    "second_normal is along normal, so the planes don't meet; give another "
                    "direction", "second_normal", "normal",
                )  # fmt: skip
        if self.damping and self.stiffness is None:
            broken_rule(
                "damping needs a stiffness: beside the stiffest spring nobody feels a damper; give "
                "one below that", "damping", "shape",
            )  # fmt: skip
        return self

    @property
    def parts(self) -> tuple[Surface, ...]:
        """The two planes of an edge; any other is its only part."""
        if self.shape != "edge":
            return (self,)
        sides = (self.normal, self.second_normal)
        return tuple(self.model_copy(update={"shape": "plane", "normal": one}) for one in sides)
