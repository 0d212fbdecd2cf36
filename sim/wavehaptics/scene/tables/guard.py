# SPDX-License-Identifier: Apache-2.0
"""``[guard]``: what takes the bridge off."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator, model_validator

from wavehaptics.scene.keys import (
    CURRENT_MAX_A,
    Table,
    as_number,
    as_tuples,
    broken_rule,
    scene_key,
)

WINDOW_MAX_RAD = 1000


class Guard(Table):
    """What takes the bridge of `pins` off, as a board has it; without this table nothing does."""

    trip_a: float = scene_key(
        "A", "A sample of this magnitude switches the bridge off", ge=1e-3, le=CURRENT_MAX_A
    )
    watch: bool = scene_key(
        "–", "Whether `wh_guard` watches as well, with the limits of a board", True
    )
    saturated_s: float = scene_key(
        "s",
        "Longest time between two turns back of the rotor in contact at the voltage limit, of "
        "which 16 in a row raise `SATURATED`; 0: no check",
        20e-3, ge=0, le=1,
    )  # fmt: skip
    overspeed_rad_s: float = scene_key(
        "rad/s",
        "Speed of the rotor above which `OVERSPEED` is raised; 0: no check",
        0.0,
        ge=0,
        le=1e5,
    )
    window_rad: Annotated[tuple[float, float] | None, BeforeValidator(as_tuples)] = scene_key(
        "rad",
        "Interval `[low, high]` of the rotor's position; outside of it `WINDOW` is raised",
        None,
        default_text="no limit",
        range_text="a pair with low < high, each -1000 to 1000",
    )

    @model_validator(mode="after")
    def _check(self) -> Guard:
        if self.window_rad is not None:
            low, high = self.window_rad
            if not -WINDOW_MAX_RAD <= low < high <= WINDOW_MAX_RAD:
                broken_rule(
                    f"guard.window_rad = [{as_number(low)}, {as_number(high)}] must be "
                    f"[low, high] with low < high, each -{as_number(WINDOW_MAX_RAD)} to "
                    f"{as_number(WINDOW_MAX_RAD)}",
                    "window_rad",
                )
        for key in ("overspeed_rad_s", "window_rad"):
            if getattr(self, key) and not self.watch:
                broken_rule(
                    f"guard.{key} is watched by wh_guard; set guard.watch = true or leave it out",
                    key, "watch",
                )  # fmt: skip
        return self
