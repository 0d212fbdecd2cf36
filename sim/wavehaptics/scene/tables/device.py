# SPDX-License-Identifier: Apache-2.0
"""``[device]``: what the motors move together, and the host that knows its surfaces."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from wavehaptics.scene.keys import Table, as_tuples, broken_rule, scene_key

Kinematics = Literal["planar", "phantom", "matrix"]
ARM_MOTORS: dict[str, int] = {"planar": 2, "phantom": 3}
"""Motors of an arm with links."""

HOME: dict[str, tuple[float, ...]] = {"planar": (0.7853981634, 1.5707963268), "phantom": (0, 0, 0)}
MOST_MOTORS = 3
"""Motors of a device at most: as many as the tip has directions."""
LINKS_M = (0.14, 0.14)
RATIO = 8.0

_Length = Annotated[float, Field(ge=1e-3, le=10)]
_Ratio = Annotated[float, Field(ge=1e-3, le=1e4)]
_Angle = Annotated[float, Field(ge=-1000, le=1000)]
_PerRad = Annotated[float, Field(ge=-100, le=100)]


class DeviceTable(Table):
    """An arm of two or three motors with a tip, and the host that sends planes of its surfaces."""

    kinematics: Kinematics = scene_key(
        "–", "Two links, a PHANTOM's three axes, or a constant Jacobian",
        range_text=", ".join(f"`{name}`" for name in ("planar", "phantom", "matrix")),
    )  # fmt: skip
    links_m: Annotated[tuple[_Length, _Length] | None, BeforeValidator(as_tuples)] = scene_key(
        "m", "Lengths of the two links", None, default_text="[0.14, 0.14]",
        range_text="two, each 0.001 to 10",
    )  # fmt: skip
    ratio: Annotated[tuple[_Ratio, ...] | None, BeforeValidator(as_tuples)] = scene_key(
        "–", "Turns of each motor for one of its axis", None, default_text="8 each",
        range_text="one a motor, each 0.001 to 10000",
    )  # fmt: skip
    home_rad: Annotated[tuple[_Angle, ...] | None, BeforeValidator(as_tuples)] = scene_key(
        "rad", "Angle of each axis at the start, where its motor is at 0", None,
        default_text="[π/4, π/2]; of a phantom [0, 0, 0]",
        range_text="one a motor, each -1000 to 1000",
    )  # fmt: skip
    jacobian: Annotated[tuple[tuple[_PerRad, ...], ...] | None, BeforeValidator(as_tuples)] = (
        scene_key(
            "m/rad", "Rows x, y and z of a `matrix`, a column a motor", None,
            range_text="three rows, each value -100 to 100",
        )
    )  # fmt: skip
    update_hz: float = scene_key("Hz", "Rate at which the host sends planes", 1000.0, ge=1, le=1e5)
    delay_s: float = scene_key(
        "s", "Time from the host's reading of the encoders to the commit of its planes", 1e-3, ge=0,
        le=1,
    )  # fmt: skip
    jitter_s: float = scene_key("s", "Largest further delay of a commit", 0.0, ge=0, le=1)
    wall_speed_m_per_s: float = scene_key(
        "m/s", "Largest speed of a surface; 0: none moves", 0.1, ge=0, le=10
    )
    wall_energy_j: float = scene_key(
        "J", "Largest energy that moving surfaces may give out beyond what they took", 1e-3, ge=0,
        le=1,
    )  # fmt: skip

    @model_validator(mode="after")
    def _check(self) -> DeviceTable:
        if self.kinematics == "matrix":
            for key in ("links_m", "ratio", "home_rad"):
                if key in self.model_fields_set:
                    broken_rule(
                        f'device.{key} makes no sense: kinematics = "matrix" has a jacobian alone',
                        key, "kinematics",
                    )  # fmt: skip
            rows = self.jacobian
            if rows is None:
                broken_rule(
                    'device.jacobian is missing, kinematics = "matrix" needs it; give rows x, y '
                    "and z in m/rad", "kinematics",
                )  # fmt: skip
            lengths = {len(row) for row in rows}
            if len(rows) != 3 or len(lengths) != 1 or not 1 <= min(lengths) <= MOST_MOTORS:
                broken_rule(
                    f"device.jacobian must be three rows x, y and z of 1 to {MOST_MOTORS} values "
                    "each; write [[...], [...], [...]]", "jacobian",
                )  # fmt: skip
            return self
        if self.jacobian is not None:
            broken_rule(
                f'device.jacobian makes no sense: kinematics = "{self.kinematics}" has links; '
                "leave it out", "jacobian", "kinematics",
            )  # fmt: skip
        motors = ARM_MOTORS[self.kinematics]
        for key in ("ratio", "home_rad"):
            given = getattr(self, key)
            if given is not None and len(given) != motors:
                broken_rule(
                    f"device.{key} has {len(given)} values, and a {self.kinematics} arm has "
                    f"{motors} motors; give one for each", key, "kinematics",
                )  # fmt: skip
        return self

    @property
    def motors(self) -> int:
        """Motors that it takes."""
        return len(self.jacobian[0]) if self.jacobian else ARM_MOTORS[self.kinematics]
