# SPDX-License-Identifier: Apache-2.0
"""``[controller]``: the wave controller."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated

from pydantic import BeforeValidator, Field, model_validator

from wavehaptics.scene.keys import (
    R_HAT_MAX_OHM,
    Table,
    as_number,
    as_tuples,
    broken_rule,
    scene_key,
)

_Edge = Annotated[float, Field(ge=-1000, le=1000)]


class Controller(Table):
    """The wave controller: its rate, latency, virtual environment and walls."""

    tick_hz: float = scene_key("Hz", "Control rate 1/T", ge=10, le=4e6)
    extra_ticks: int = scene_key(
        "ticks", "Whole control periods of latency beyond the first, k", 1,
        default_text="1; on `pins` as many as it needs", ge=0, le=1000,
    )  # fmt: skip
    lambda_: float = scene_key(
        "rad/s", "λ of the virtual environment; the latency is allowed for", alias="lambda", ge=1,
        le=1e9,
    )  # fmt: skip
    eta_contact: float = scene_key("–", "η in contact", -1.0, ge=-1, le=1)
    eta_free: float = scene_key(
        "–", "η in free space", None,
        default_text="1; with a port anchor about 0.99, which damps the winding's own oscillation",
        ge=-1, le=1,
    )  # fmt: skip
    walls: Annotated[tuple[tuple[_Edge, _Edge], ...], BeforeValidator(as_tuples)] = scene_key(
        "rad", "Solid intervals `[x_min, x_max]`, without overlap", (), default_text="no wall",
        range_text="pairs with x_min < x_max, each -1000 to 1000",
    )  # fmt: skip
    edge_hysteresis: bool = scene_key(
        "–", "A wall is left one count late, so that a resting finger does not chatter", False
    )
    r_hat: float = scene_key(
        "Ω", "The controller's estimate R̂ of the resistance", None, default_text="R of the motor",
        ge=1e-3, le=R_HAT_MAX_OHM,
    )  # fmt: skip
    l_hat: float = scene_key(
        "H", "The controller's estimate L̂ of the inductance", None, default_text="L of the motor",
        ge=1e-6, le=1,
    )  # fmt: skip
    k_t_hat: float = scene_key(
        "N·m/A", "The controller's estimate k̂_T of the torque constant", None,
        default_text="k_T of the motor, √1.5·p·ψ of a brushless one", ge=1e-4, le=10,
    )  # fmt: skip
    j_hat: float = scene_key(
        "kg·m²", "The controller's estimate Ĵ of the inertia on the shaft; no law needs it today",
        None, default_text="J of the motor, without load and hand", ge=1e-9, le=10,
    )  # fmt: skip
    magnet_hat_rad: float = scene_key(
        "rad",
        "The controller's estimate of `magnet_rad`, for the port anchors of a "
        "brushless motor's axes and for `encoder`",
        None, default_text="`magnet_rad` of the motor", ge=-1000, le=1000,
    )  # fmt: skip
    find_magnet: bool = scene_key(
        "–",
        "The electrical angle is unknown at first: the hand's first movement "
        "finds it, and the port anchor begins then",
        False,
    )
    clock_hz: float | None = scene_key(
        "Hz", "Clock of `pins`, a whole multiple of `tick_hz`", None,
        default_text="the multiple of `tick_hz` nearest to 48e6, of at least 48", ge=1e6, le=1e9,
    )  # fmt: skip
    anchor_auto: bool = scene_key(
        "–",
        "The port anchor, which holds walls where the encoder sees them, with "
        "values for the motor's data",
        False,
    )
    anchor_ohm: float | None = scene_key(
        "Ω", "Resistance ρ of the port anchor's pull; a value switches the anchor on", None,
        default_text="8 `r_hat`, less at a slow tick", ge=1e-3, le=1000,
    )  # fmt: skip
    anchor_ohm_per_s: float | None = scene_key(
        "Ω/s", "Rate γ at which the port anchor learns the resistance that `r_hat` lacks", None,
        default_text="16 ρ", ge=0, le=1e6,
    )  # fmt: skip
    anchor_limit_v: float | None = scene_key(
        "V",
        "Largest correction of the port anchor without its learned part, at a "
        "wave voltage of 0; half of that voltage adds to it",
        None, default_text="1.2, or a third of the drive's limit", ge=0, le=63,
    )  # fmt: skip
    r_hat_part: float = scene_key(
        "–", "Fraction of `r_hat` for which the waves of a port with an anchor are computed", 0.7,
        default_text="0.7", ge=0.1, le=1.5,
    )  # fmt: skip

    @property
    def anchored(self) -> bool:
        """Whether there is a port anchor."""
        return self.anchor_auto or self.anchor_ohm is not None

    @model_validator(mode="after")
    def _check(self) -> Controller:
        _check_walls(self.walls)
        if not self.anchored:
            for key in ("anchor_ohm_per_s", "anchor_limit_v", "r_hat_part"):
                if key in self.model_fields_set:
                    broken_rule(
                        f"controller.{key} belongs to a port anchor; add anchor_auto = true", key
                    )
        if self.clock_hz is not None:
            clocks = self.clock_hz / self.tick_hz
            whole = max(1, round(clocks))
            if not math.isclose(clocks, whole, rel_tol=1e-9):
                broken_rule(
                    f"controller.clock_hz = {as_number(self.clock_hz)} is no whole multiple of "
                    f"tick_hz = {as_number(self.tick_hz)}; the nearest is "
                    f"{as_number(whole * self.tick_hz)}",
                    "clock_hz",
                    "tick_hz",
                )
        return self


def _check_walls(walls: tuple[tuple[float, float], ...]) -> None:
    for n, (x_min, x_max) in enumerate(walls):
        if x_min >= x_max:
            broken_rule(
                f"controller.walls[{n}] = [{as_number(x_min)}, {as_number(x_max)}] is empty; "
                "it must be [x_min, x_max] with x_min < x_max",
                ("walls", n),
            )
    in_order = sorted(range(len(walls)), key=lambda n: walls[n])
    for low, high in pairwise(in_order):
        if walls[high][0] < walls[low][1]:
            first, second = sorted((low, high))
            broken_rule(
                f"controller.walls[{second}] overlaps walls[{first}]; join them or move them apart",
                ("walls", second),
            )
