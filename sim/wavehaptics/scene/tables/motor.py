# SPDX-License-Identifier: Apache-2.0
"""``[motor]``: the motor's constants."""

from __future__ import annotations

import math
import sys
from typing import Any, Literal

from pydantic import model_validator

from wavehaptics.laws.closed_forms import brushless_torque_constant
from wavehaptics.parts.motors import BRUSHLESS_PRESETS, PRESETS
from wavehaptics.scene.keys import (
    R_HAT_MAX_OHM,
    Table,
    as_number,
    as_written,
    broken_rule,
    scene_key,
    unknown_choice,
)

MotorKind = Literal["dc", "pmsm"]
DC, PMSM = "dc", "pmsm"

ALL_PRESETS = (*PRESETS, *BRUSHLESS_PRESETS)
DC_KEYS = ("R_ohm", "L_h", "k_t", "J_kgm2")
"""What makes a motor with brushes."""
PMSM_KEYS = ("R_ohm", "L_h", "pole_pairs", "psi_vs", "J_kgm2")
"""What makes a brushless motor."""
_PMSM_ONLY = ("pole_pairs", "psi_vs", "l_d_part", "harmonic_5", "harmonic_7", "magnet_rad")
_LEAST_K_T, _MOST_K_T = 1e-4, 10.0


class Motor(Table):
    """The motor's constants: a preset, numbers, or numbers that replace some of a preset.

    ``k_t`` of a brushless motor is filled in: N·m per ampere of the torque's current.
    """

    preset: str | None = scene_key(
        "–", "Motor by name; keys beside it replace its values", None,
        range_text=", ".join(f"`{name}`" for name in ALL_PRESETS),
    )  # fmt: skip
    R_ohm: float = scene_key(
        "Ω", "Resistance R of the winding, or of a phase", default_text="of the preset", ge=0.01,
        le=R_HAT_MAX_OHM,
    )  # fmt: skip
    L_h: float = scene_key(
        "H", "Inductance L of the winding, or of a phase along the torque's axis q",
        default_text="of the preset", ge=1e-6, le=1,
    )  # fmt: skip
    k_t: float = scene_key(
        "N·m/A", "Torque constant k_T, of `dc` alone", default_text="of the preset", ge=_LEAST_K_T,
        le=_MOST_K_T,
    )  # fmt: skip
    J_kgm2: float = scene_key(
        "kg·m²", "Rotor inertia J", default_text="of the preset", ge=1e-9, le=1
    )
    kind: MotorKind = scene_key(
        "–", "With brushes, or brushless: three phases in star and a rotor with magnets", DC,
        default_text="of the preset, else `dc`", range_text="`dc`, `pmsm`",
    )  # fmt: skip
    pole_pairs: int | None = scene_key(
        "–", "Pole pairs p of a `pmsm`, which alone takes this key and those below", None,
        default_text="of the preset", ge=1, le=100,
    )  # fmt: skip
    psi_vs: float | None = scene_key(
        "V·s", "Flux ψ of the magnets through a phase, its amplitude", None,
        default_text="of the preset", ge=1e-6, le=1,
    )  # fmt: skip
    l_d_part: float = scene_key(
        "–", "L along the magnets' axis d, as a fraction of `L_h`", 1.0, ge=0.2, le=5
    )
    harmonic_5: float = scene_key(
        "–", "Fifth harmonic of a phase's back-EMF, as a fraction of the first", 0.0, ge=-0.3,
        le=0.3,
    )  # fmt: skip
    harmonic_7: float = scene_key("–", "Seventh harmonic, likewise", 0.0, ge=-0.3, le=0.3)
    magnet_rad: float = scene_key(
        "rad", "Position x at which the magnets lie along phase a; no controller reads it", 0.0,
        ge=-1000, le=1000,
    )  # fmt: skip

    @property
    def brushless(self) -> bool:
        """Whether it is a motor of three phases."""
        return self.kind == PMSM

    @property
    def k_e(self) -> float:
        """Back-EMF constant, V·s/rad: k_T, or pψ of a phase's amplitude."""
        if self.pole_pairs is None or self.psi_vs is None:
            return self.k_t
        return self.pole_pairs * self.psi_vs

    @property
    def felt_k_t(self) -> float:
        """k_T of the motor with brushes that feels the same at the same R and L, N·m/A."""
        return math.sqrt(self.k_t * self.k_e) if self.brushless else self.k_t

    @model_validator(mode="before")
    @classmethod
    def _resolve_preset(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        if isinstance(data.get("preset"), str):
            data = _with_preset(data)
        kind = data.get("kind", DC)
        if kind == PMSM:
            return _of_three_phases(data)
        return _with_brushes(data) if kind == DC else data


def _with_preset(data: dict[str, Any]) -> dict[str, Any]:
    """What the table says with what its preset says besides."""
    name = data["preset"]
    if name in PRESETS:
        preset: dict[str, Any] = {"kind": DC, **PRESETS[name]._asdict()}
    elif name in BRUSHLESS_PRESETS:
        preset = {"kind": PMSM, **BRUSHLESS_PRESETS[name]._asdict()}
    else:
        broken_rule(f"motor.preset {unknown_choice(name, ALL_PRESETS)}", "preset")
    kind = data.get("kind", preset["kind"])
    if kind in (DC, PMSM) and kind != preset["kind"]:
        broken_rule(
            f"motor.kind = {as_written(kind)} contradicts motor.preset = {as_written(name)}, which "
            f"is {as_written(preset['kind'])}; leave kind out",
            "kind",
            "preset",
        )
    return {**preset, **data}


def _with_brushes(data: dict[str, Any]) -> dict[str, Any]:
    for key in _PMSM_ONLY:
        if key in data:
            broken_rule(f'motor.{key} belongs to a brushless motor; add kind = "pmsm"', key)
    return data


def _of_three_phases(data: dict[str, Any]) -> dict[str, Any]:
    """The table with k_T, where what it takes is there; the field's own check tells the rest."""
    if "k_t" in data:
        broken_rule(
            'motor.k_t belongs to a motor of kind "dc"; give pole_pairs and psi_vs, k_t is 1.5 '
            "times their product",
            "k_t",
        )
    for key in ("pole_pairs", "psi_vs"):
        if key not in data:
            broken_rule(
                f"motor.{key} is missing; give preset, or all of {', '.join(PMSM_KEYS)}", "kind"
            )
    pairs, psi = data["pole_pairs"], data["psi_vs"]
    k_t = _LEAST_K_T
    if _is_number(pairs) and _is_number(psi) and pairs > 0 and psi > 0:
        k_t = brushless_torque_constant(pairs, psi)
        if not _LEAST_K_T <= k_t <= _MOST_K_T and pairs <= 100 and 1e-6 <= psi <= 1:
            broken_rule(
                f"motor.psi_vs = {as_number(psi)} at {pairs} pole pairs is {as_number(k_t)} N·m/A; "
                f"it must be {as_number(_LEAST_K_T)} to {as_number(_MOST_K_T)} N·m/A",
                "psi_vs",
                "pole_pairs",
            )
        k_t = min(max(k_t, _LEAST_K_T), _MOST_K_T)
    return {**data, "k_t": k_t}


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < math.inf and abs(value) <= sys.float_info.max
