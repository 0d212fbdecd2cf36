# SPDX-License-Identifier: Apache-2.0
"""``[motor]``: the motor's constants."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from wavehaptics.parts.motors import PRESETS
from wavehaptics.scene.keys import R_HAT_MAX_OHM, Table, broken_rule, scene_key, unknown_choice


class Motor(Table):
    """The motor's constants: a preset, four numbers, or numbers that replace some of a preset."""

    preset: str | None = scene_key(
        "–",
        "Motor by name; keys beside it replace its values",
        None,
        default_text="none",
        range_text=", ".join(f"`{name}`" for name in PRESETS),
    )
    R_ohm: float = scene_key(
        "Ω", "Winding resistance R", default_text="of the preset", ge=0.01, le=R_HAT_MAX_OHM
    )
    L_h: float = scene_key("H", "Winding inductance L", default_text="of the preset", ge=1e-6, le=1)
    k_t: float = scene_key(
        "N·m/A", "Torque constant k_T", default_text="of the preset", ge=1e-4, le=10
    )
    J_kgm2: float = scene_key(
        "kg·m²", "Rotor inertia J", default_text="of the preset", ge=1e-9, le=1
    )

    @model_validator(mode="before")
    @classmethod
    def _resolve_preset(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("preset"), str):
            return data
        name = data["preset"]
        if name not in PRESETS:
            broken_rule(f"motor.preset {unknown_choice(name, PRESETS)}", "preset")
        return {**PRESETS[name]._asdict(), **data}
