# SPDX-License-Identifier: Apache-2.0
"""What the motors of a scene have in common where they move one tip: device, surfaces and hand."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, model_validator

from wavehaptics.laws.shapes import Shape
from wavehaptics.scene.keys import Table, broken_rule
from wavehaptics.scene.placed import Placed
from wavehaptics.scene.tables.coupling import Coupling
from wavehaptics.scene.tables.device import HOME, LINKS_M, RATIO, DeviceTable
from wavehaptics.scene.tables.surface import Surface, unit
from wavehaptics.scene.tables.tip_hand import TipHand

if TYPE_CHECKING:
    from wavehaptics.laws.kinematics import Arm

MOST_SURFACES = 8


def _list(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


class Space(Placed):
    """The tables of a device; a hand that the file does not have is ``None``."""

    device: DeviceTable
    surface: Annotated[tuple[Surface, ...], BeforeValidator(_list)] = ()
    coupling: Coupling | None = None
    hand: TipHand | None = None

    @property
    def called(self) -> str:
        return "[device]"

    @model_validator(mode="after")
    def _check(self) -> Space:
        if len(self.solids) > MOST_SURFACES:
            broken_rule(
                f"[[surface]]: {len(self.solids)} surfaces, two for each edge, and a group of "
                f"ports has {MOST_SURFACES}; leave some out",
                ("surface", self.number(MOST_SURFACES)),
            )  # fmt: skip
        if self.coupling is not None and self.device.motors != 2:
            broken_rule(
                f"[coupling] joins two motors, and the device has {self.device.motors}; take a "
                "device of two", ("coupling",), ("device", "kinematics"),
            )  # fmt: skip
        if self.coupling is not None and self.surface:
            broken_rule(
                "[coupling] and [[surface]] take the same waves; leave one of them out",
                ("coupling",), ("surface",),
            )  # fmt: skip
        if self.hand is not None and self.hand.center_m is not None:
            away = math.dist(self.home_m, self.hand.center_m)
            if away <= self.hand.amplitude_m:
                broken_rule(
                    f"hand.center_m is {away:.3g} m from the tip, no further than amplitude_m; "
                    "take a circle that is larger", ("hand", "center_m"), ("hand", "amplitude_m"),
                )  # fmt: skip
            inward = np.array(self.hand.center_m) - np.array(self.home_m)
            across = np.array(unit(self.hand.across or (0.0, 0.0, 0.0)))
            if np.linalg.norm(np.cross(inward, across)) < 1e-3 * away:
                broken_rule(
                    "hand.across leads to center_m, so there is no circle; give a direction "
                    "beside it", ("hand", "across"), ("hand", "center_m"),
                )  # fmt: skip
        return self

    @property
    def arm(self) -> Arm:
        """The arm's kinematics, which are compiled: a scene that is refused does without."""
        from wavehaptics.laws.kinematics import PHANTOM, PLANAR, linked_arm, matrix_arm

        device = self.device
        if device.jacobian is not None:
            return matrix_arm(device.jacobian)
        kind = device.kinematics
        motors = device.motors
        return linked_arm(
            PLANAR if kind == "planar" else PHANTOM, device.links_m or LINKS_M,
            device.ratio or (RATIO,) * motors,
            HOME[kind] if device.home_rad is None else device.home_rad,
        )  # fmt: skip

    @property
    def home_m(self) -> tuple[float, float, float]:
        """The tip's place where the run begins, m."""
        arm = self.arm
        x, y, z = arm.tip(np.zeros(arm.motors)).tolist()
        return x, y, z

    @property
    def solids(self) -> tuple[Surface, ...]:
        """The surfaces, with two planes in place of an edge."""
        return tuple(part for one in self.surface for part in one.parts)

    def number(self, solid: int) -> int:
        """Which ``[[surface]]`` one of :attr:`solids` is of."""
        return [n for n, one in enumerate(self.surface) for _ in one.parts][solid]

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """:attr:`solids` as what a tip touches."""
        return tuple(
            Shape(
                one.shape,
                np.array(one.point_m if "point_m" in one.model_fields_set else self.home_m),
                np.array(unit(one.normal) if one.normal else (0.0, 0.0, 0.0)),
                one.radius_m or 0.0,
                None if one.size_m is None else np.array(one.size_m),
            )
            for one in self.solids
        )


SPACE_TABLES: dict[str, type[Table]] = {
    "device": DeviceTable, "surface": Surface, "coupling": Coupling, "hand": TipHand,
}  # fmt: skip
"""Model of each table of a device, in the order of the format's description."""
