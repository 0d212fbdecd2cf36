# SPDX-License-Identifier: Apache-2.0
"""``[adc]``: the converter of the current."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from wavehaptics.parts.adcs import ALL_BITS
from wavehaptics.scene.keys import (
    CURRENT_MAX_A,
    Table,
    as_number,
    as_written,
    broken_rule,
    scene_key,
    unknown_choice,
)
from wavehaptics.scene.tables.drive import USUAL_BUSES_V, Drive


class Adc(Table):
    """The converter of the current; without this table the sensor is ideal."""

    part: str | None = scene_key(
        "–", "Converter by name: its resolution everywhere, its frame at the pins", None,
        default_text="none: two zeros and the bits, at half the clock",
        range_text=", ".join(f"`{name}`" for name in ALL_BITS),
    )  # fmt: skip
    bits: int = scene_key("bits", "Resolution", default_text="of the part", ge=8, le=16)
    full_scale_a: float = scene_key(
        "A", "Largest current either way: the range is ± this", None,
        default_text="twice what the voltage limit drives through `r_hat`", ge=1e-3,
        le=CURRENT_MAX_A,
    )  # fmt: skip
    noise_a: float = scene_key("A", "Noise of a sample, RMS", 0.0, ge=0, le=CURRENT_MAX_A)
    offset_a: float = scene_key(
        "A", "Constant error of the sensor, below the full scale", 0.0, ge=-CURRENT_MAX_A,
        le=CURRENT_MAX_A,
    )  # fmt: skip
    bandwidth_hz: float | None = scene_key(
        "Hz", "Bandwidth of the sense amplifier, a first-order lag", None, default_text="no lag",
        ge=100, le=1e9,
    )  # fmt: skip
    common_mode_a: float = scene_key(
        "A", "Error of the sensor by the sign of the motor's voltage", 0.0, ge=-CURRENT_MAX_A,
        le=CURRENT_MAX_A,
    )  # fmt: skip
    edge_settle_s: float | None = scene_key(
        "s", "On `pins`: `common_mode_a` is what an edge of lead A adds; 1 % is left after this",
        None, default_text="`common_mode_a` goes by the sign of the voltage", ge=1e-9, le=1e-3,
    )  # fmt: skip
    edge_hold_s: float = scene_key(
        "s",
        "On `pins`: after an edge of its lead the amplifier holds its output for so long; 0: never",
        0.0, ge=0, le=1e-3,
    )  # fmt: skip
    edge_hold_restarts: bool = scene_key(
        "–",
        "Whether an edge in a hold begins it anew, with the same output; otherwise it is ignored",
        True,
    )
    drift_a_per_s: float = scene_key(
        "A/s", "How fast the constant error grows", 0.0, ge=-CURRENT_MAX_A, le=CURRENT_MAX_A
    )

    @model_validator(mode="before")
    @classmethod
    def _resolve_part(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("part"), str):
            return data
        name = data["part"]
        if name not in ALL_BITS:
            broken_rule(f"adc.part {unknown_choice(name, ALL_BITS)}", "part")
        bits = ALL_BITS[name]
        if data.get("bits", bits) != bits:
            broken_rule(
                f"adc.bits = {as_written(data['bits'])} contradicts adc.part = {as_written(name)}, "
                f"which has {bits}; leave bits out",
                "bits",
                "part",
            )
        return {**data, "bits": bits}

    def resolved(self, r_hat: float, drive: Drive | None, duration_s: float) -> Adc:
        """With the full scale filled in: room for twice the largest current that can last.

        ``r_hat`` is what whoever makes the amplifier takes the winding's resistance for, Ω.
        """
        limit_v = drive.limit_v if drive and drive.limit_v else USUAL_BUSES_V[0]
        full_scale_a = self.full_scale_a
        if full_scale_a is None:
            full_scale_a = min(2 * limit_v / r_hat, CURRENT_MAX_A)
        if abs(self.offset_a) >= full_scale_a:
            broken_rule(
                f"adc.offset_a = {as_number(self.offset_a)} leaves the range of "
                f"±{full_scale_a:g} A; it must be smaller than full_scale_a",
                ("adc", "offset_a"),
                ("adc", "full_scale_a"),
            )
        if self.edge_settle_s is not None and self.common_mode_a == 0.0:
            broken_rule(
                f"adc.edge_settle_s = {as_number(self.edge_settle_s)} has nothing to settle; set "
                "adc.common_mode_a, what an edge adds, or leave it out",
                ("adc", "edge_settle_s"),
            )
        if "edge_hold_restarts" in self.model_fields_set and self.edge_hold_s == 0.0:
            broken_rule(
                f"adc.edge_hold_restarts = {as_written(self.edge_hold_restarts)} has no hold to "
                "restart; set adc.edge_hold_s, or leave it out",
                ("adc", "edge_hold_restarts"),
            )
        drifted = self.offset_a + self.drift_a_per_s * duration_s
        if abs(drifted) >= full_scale_a:
            broken_rule(
                f"adc.drift_a_per_s = {as_number(self.drift_a_per_s)} leaves the range of "
                f"±{full_scale_a:g} A in {duration_s:g} s; it must be slower",
                ("adc", "drift_a_per_s"),
                ("adc", "full_scale_a"),
                ("scene", "duration_s"),
            )
        return self.model_copy(update={"full_scale_a": full_scale_a})
