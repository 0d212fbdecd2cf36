# SPDX-License-Identifier: Apache-2.0
"""``[encoder]`` on the rotor."""

from __future__ import annotations

import math
from typing import Any, Literal

from pydantic import model_validator

from wavehaptics.parts.encoders import ABSOLUTE_PARTS
from wavehaptics.scene.keys import Table, as_number, broken_rule, scene_key, unknown_choice

EncoderKind = Literal["quadrature", "absolute"]

QUADRATURE: EncoderKind = "quadrature"
ABSOLUTE: EncoderKind = "absolute"

_OF_READINGS = (
    "part", "bits", "read_hz", "latency_s", "noise_counts", "bandwidth_hz", "hysteresis_counts",
)  # fmt: skip
_OF_LINES = ("uneven", "reverses_at_s", "skips_per_rev")


class Encoder(Table):
    """The rotor's encoder; without this table the position is ideal."""

    counts_per_rev: int = scene_key(
        "counts", "Counts a revolution; of A and B all four edges are counted",
        default_text="required; 2^`bits` of an absolute encoder",
        range_text="a multiple of 4 from 4 to 4e6; a power of two up to 2^`bits`", ge=4,
        le=4_000_000, multiple_of=4,
    )  # fmt: skip
    kind: EncoderKind = scene_key(
        "–", "A and B, or an absolute encoder that is read over a serial line", QUADRATURE,
        default_text="`quadrature`", range_text=f"`{QUADRATURE}`, `{ABSOLUTE}`",
    )  # fmt: skip
    stops_at_s: float | None = scene_key(
        "s",
        "Time from which A and B, or the readings, stay constant, as if the cable had come off",
        None, default_text="never", ge=0, le=1e6,
    )  # fmt: skip
    uneven: float = scene_key(
        "–",
        "Largest displacement of an edge, as a fraction of a count, the same in each revolution",
        0.0, ge=0, le=0.45,
    )  # fmt: skip
    reverses_at_s: float | None = scene_key(
        "s", "Time from which it counts backwards, as if A and B were swapped", None,
        default_text="never", ge=0, le=1e6,
    )  # fmt: skip
    skips_per_rev: int = scene_key(
        "edges", "Edges of a revolution that are lost, evenly spaced, at most a quarter of all", 0,
        ge=0, le=1_000_000,
    )  # fmt: skip
    part: str | None = scene_key(
        "–", "Absolute encoder by name: the five keys below", None,
        range_text=", ".join(f"`{name}`" for name in ABSOLUTE_PARTS),
    )  # fmt: skip
    bits: int | None = scene_key(
        "bits", "Resolution of a reading", None,
        default_text="of the part, else of `counts_per_rev`", ge=8, le=20,
    )  # fmt: skip
    read_hz: float | None = scene_key(
        "Hz", "Rate at which the angle is read", None, default_text="of the part, else required",
        ge=1e3, le=2e6,
    )  # fmt: skip
    latency_s: float = scene_key(
        "s", "From an angle to the end of its frame", 0.0, default_text="of the part, else 0", ge=0,
        le=1e-3,
    )  # fmt: skip
    noise_counts: float = scene_key(
        "counts", "Noise of a reading, RMS, in counts of `bits`", 0.0,
        default_text="of the part, else 0", ge=0, le=1e3,
    )  # fmt: skip
    bandwidth_hz: float | None = scene_key(
        "Hz", "Cut-off of the tracking filter in front of the readings", None,
        default_text="of the part, else no filter", ge=1, le=1e5,
    )  # fmt: skip
    hysteresis_counts: int = scene_key(
        "counts",
        "How far beyond an edge a reading must be before the count follows, in counts of `bits`", 0,
        ge=0, le=10_000,
    )  # fmt: skip

    @property
    def absolute(self) -> bool:
        """Whether it is read, and has no edges."""
        return self.kind == ABSOLUTE

    @model_validator(mode="before")
    @classmethod
    def _resolve_part(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("kind") != ABSOLUTE:
            return data
        if isinstance(name := data.get("part"), str):
            if name not in ABSOLUTE_PARTS:
                broken_rule(f"encoder.part {unknown_choice(name, ABSOLUTE_PARTS)}", "part")
            data = {**ABSOLUTE_PARTS[name].settings(), **data}
        counts, bits = data.get("counts_per_rev"), data.get("bits")
        if counts is None and isinstance(bits, int) and 0 < bits < 22:
            data = {**data, "counts_per_rev": 2**bits}
        elif bits is None and isinstance(counts, int) and counts > 0:
            data = {**data, "bits": max(8, math.ceil(math.log2(counts)))}
        return data

    @model_validator(mode="after")
    def _check(self) -> Encoder:
        if 4 * self.skips_per_rev > self.counts_per_rev:
            broken_rule(
                f"encoder.skips_per_rev = {self.skips_per_rev} is more than a quarter of "
                f"counts_per_rev = {self.counts_per_rev}; it may be at most "
                f"{self.counts_per_rev // 4}",
                "skips_per_rev",
                "counts_per_rev",
            )
        wrong = [
            key
            for key in (_OF_LINES if self.absolute else _OF_READINGS)
            if getattr(self, key) != type(self).model_fields[key].default
        ]
        if wrong and self.absolute:
            broken_rule(f"encoder.{wrong[0]} is of A and B; leave it out", wrong[0], "kind")
        if wrong:
            broken_rule(
                f'encoder.{wrong[0]} is of an absolute encoder; set encoder.kind = "{ABSOLUTE}", '
                "or leave it out",
                wrong[0],
                "kind",
            )
        if self.absolute:
            self._check_readings()
        return self

    def _check_readings(self) -> None:
        counts, bits = self.counts_per_rev, self.bits
        assert bits is not None
        if counts & (counts - 1) or counts > 2**bits:
            broken_rule(
                f"encoder.counts_per_rev = {counts} of an absolute encoder must be a power of two "
                f"up to its {2**bits}",
                "counts_per_rev",
                "bits",
            )
        if self.read_hz is None:
            broken_rule(
                "encoder.read_hz is missing: how often the angle is read; set it, or encoder.part",
                "kind",
            )
        if self.latency_s * self.read_hz > 1000:
            broken_rule(
                f"encoder.latency_s = {as_number(self.latency_s)} is more than 1000 readings; it "
                f"may be at most {as_number(1000 / self.read_hz)}",
                "latency_s",
                "read_hz",
            )
