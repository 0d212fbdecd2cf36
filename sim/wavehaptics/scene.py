# SPDX-License-Identifier: Apache-2.0
"""Scenes: what is to be simulated, read from TOML, checked, and immutable.

``sim/scenes/README.md`` describes the format; a test holds that page and this schema together.
Every angle, speed and torque is the rotor's. Units are SI and stand in each key's metadata.
"""

from __future__ import annotations

import difflib
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, NoReturn

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic.functional_validators import ModelWrapValidatorHandler
from pydantic_core import PydanticCustomError

from wavehaptics import formats
from wavehaptics.adc_parts import ALL_BITS
from wavehaptics.anchor_choice import choose_eta_free
from wavehaptics.bridge_modes import HALF_BRIDGE, MODE_WORDS, UNIPOLAR
from wavehaptics.motors import PRESETS
from wavehaptics.physics import matched_a
from wavehaptics.toml_source import KeyPath, TomlError, dotted, parse, parse_value

SCENES_DIR = Path(__file__).resolve().parents[1] / "scenes"
"""Where the shipped scenes stand."""

LARGEST_FILE = 1 << 20
"""Bytes in a scene; whatever is larger is no scene."""

USUAL_BUSES_V = (12.0, 24.0, 48.0)
"""Bus voltages, V, from which a drive's default is taken."""

# What the words of the RTL can hold, in whole units.
_R_HAT_MAX_OHM = math.floor(formats.ROOT.largest**2 / 2)
_VOLTAGE_MAX_V = math.floor(formats.VOLTAGE.largest)
_CURRENT_MAX_A = math.floor(formats.CURRENT.largest)


class SceneError(ValueError):
    """A refused scene. The message is one line: where, what is wrong, what would be right."""

    def __init__(self, message: str) -> None:
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in message))


class NotSimulated(NamedTuple):
    """A part of the format that this version refuses, because it would have no effect."""

    path: KeyPath
    what: str
    off: float | bool | None = None
    """The value that means "without it", and is taken; ``None`` where only leaving it out does."""


NOT_SIMULATED: tuple[NotSimulated, ...] = ()
"""All that the format has and this version does not simulate; take an entry out to lift it."""

GONE: dict[KeyPath, str] = {
    ("controller", "release_ohm"): (
        "the port anchor needs no rule for the way out; use anchor_auto = true"
    ),
    ("controller", "surface_ohm"): (
        "the port anchor needs no rule for a wall's first cells; use anchor_auto = true"
    ),
    ("controller", "track_gain"): "the port anchor needs no tracking; use anchor_auto = true",
    ("controller", "track_limit"): (
        "the port anchor needs no tracking, so no limit of it; use anchor_auto = true"
    ),
    ("controller", "lost_limit"): (
        "the port anchor checks the encoder by itself; use anchor_auto = true"
    ),
    ("controller", "dead_zone_cells"): (
        "the port anchor's dead zone is always half a cell; use anchor_auto = true"
    ),
    ("controller", "push_only"): "a wall of the port anchor only pushes; use anchor_auto = true",
    ("controller", "r_hat_free"): "one R̂ serves contact and free space; use r_hat",
}
"""Keys that the format had once, and what has taken their place."""


def _key(
    unit: str,
    meaning: str,
    default: Any = ...,
    *,
    default_text: str | None = None,
    range_text: str | None = None,
    **options: Any,
) -> Any:
    """A key of a table: its unit, meaning and default, and bounds as pydantic names them."""
    texts = {"unit": unit, "default": default_text, "range": range_text}
    return Field(default, description=meaning, json_schema_extra=texts, **options)


def _broken_rule(problem: str, *keys: str | KeyPath) -> NoReturn:
    """Refuse values that are right one by one but don't go together.

    ``keys`` are those involved, below the model that is validated, the one to blame first.
    """
    paths = [(key,) if isinstance(key, str) else key for key in keys]
    raise PydanticCustomError("rule", "rule", {"problem": problem, "paths": paths})


class _Table(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


class SceneTable(_Table):
    """What the run is called, how long it is and how much of it is kept."""

    name: str = _key(
        "–",
        "Name of the scene, also of the folder for its results",
        range_text="1 to 60 printable characters without / and \\",
    )
    duration_s: float = _key("s", "Simulated time, at least one tick", ge=1e-6, le=1e6)
    trace_hz: float | None = _key(
        "Hz",
        "At most so many rows of the trace a second; metrics see every tick all the same",
        None,
        default_text="every tick",
        ge=1e-3,
        le=4e6,
    )

    @model_validator(mode="after")
    def _check(self) -> SceneTable:
        printable = self.name.isprintable() and self.name.strip() != ""
        if len(self.name) > 60 or not printable or re.search(r"[/\\]", self.name):
            wanted = field_texts(type(self), "name").range
            _broken_rule(
                f"scene.name = {_shown(self.name)} can't name a folder; use {wanted}", "name"
            )
        return self


class Motor(_Table):
    """The motor's constants: a preset, four numbers, or numbers that replace some of a preset."""

    preset: str | None = _key(
        "–",
        "Motor by name; keys beside it replace its values",
        None,
        default_text="none",
        range_text=", ".join(f"`{name}`" for name in PRESETS),
    )
    R_ohm: float = _key(
        "Ω", "Winding resistance R", default_text="of the preset", ge=0.01, le=_R_HAT_MAX_OHM
    )
    L_h: float = _key("H", "Winding inductance L", default_text="of the preset", ge=1e-6, le=1)
    k_t: float = _key("N·m/A", "Torque constant k_T", default_text="of the preset", ge=1e-4, le=10)
    J_kgm2: float = _key("kg·m²", "Rotor inertia J", default_text="of the preset", ge=1e-9, le=1)

    @model_validator(mode="before")
    @classmethod
    def _resolve_preset(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("preset"), str):
            return data
        name = data["preset"]
        if name not in PRESETS:
            _broken_rule(f"motor.preset {_unknown_choice(name, PRESETS)}", "preset")
        return {**PRESETS[name]._asdict(), **data}


class Friction(_Table):
    """Friction of the rotor; without this table there is none."""

    coulomb_nm: float = _key("N·m", "Coulomb friction", 0.0, ge=0, le=100)
    viscous: float = _key("N·m·s/rad", "Viscous friction", 0.0, ge=0, le=100)


class Brushes(_Table):
    """The brushes; without this table they are part of R."""

    drop_v: float = _key(
        "V", "Voltage drop V_b: V_b·tanh(i/`knee_a`) in series with the winding", 0.0, ge=0, le=10
    )
    knee_a: float = _key("A", "Current at which the drop bends", 5e-3, ge=1e-4, le=100)
    contact_noise: float = _key("–", "Noise of the contact, RMS, part of R", 0.0, ge=0, le=0.5)
    noise_s: float = _key("s", "Correlation time of that noise", 1e-3, ge=1e-5, le=10)
    segments: int = _key(
        "bars", "Bars of the commutator; `ripple` and `step` need it", 0,
        default_text="none", ge=1, le=1000,
    )  # fmt: skip
    ripple: float = _key(
        "–", "Part of R by which it swings with the angle: ripple·cos(segments·x)", 0.0,
        ge=-0.5, le=0.5,
    )  # fmt: skip
    step: float = _key(
        "–", "Part of R by which every other bar has more, with sharp edges", 0.0,
        ge=-0.5, le=0.5,
    )  # fmt: skip
    step_at_rad: float = _key(
        "rad", "An edge of the bars: above it R has the `step`, up to the next", 0.0,
        ge=-1000, le=1000,
    )  # fmt: skip

    @model_validator(mode="after")
    def _check(self) -> Brushes:
        for key in ("ripple", "step"):
            if getattr(self, key) and not self.segments:
                _broken_rule(
                    f"brushes.{key} needs to know the bars of the commutator; give segments", key
                )
        for key, needed in (("knee_a", "drop_v"), ("noise_s", "contact_noise"),
                            ("step_at_rad", "step")):  # fmt: skip
            if key in self.model_fields_set and needed not in self.model_fields_set:
                _broken_rule(f"brushes.{key} does nothing without {needed}; give {needed}", key)
        return self


class Winding(_Table):
    """What the winding's iron does; without this table L is L at any frequency and current."""

    eddy_ohm: float | None = _key(
        "Ω",
        "Resistance in parallel to `eddy_part` of L: eddy currents",
        None,
        default_text="none",
        ge=0.01,
        le=1e5,
    )
    eddy_part: float | None = _key(
        "–", "That part of L, which `eddy_ohm` needs", None, default_text="none", ge=1e-3, le=0.95
    )
    saturation_a: float | None = _key(
        "A",
        "Current at which the incremental L is half: L/(1 + (i/this)²)",
        None,
        default_text="never",
        ge=1e-2,
        le=1000,
    )

    @model_validator(mode="after")
    def _check(self) -> Winding:
        for key, other in (("eddy_ohm", "eddy_part"), ("eddy_part", "eddy_ohm")):
            if getattr(self, key) is not None and getattr(self, other) is None:
                _broken_rule(f"winding.{key} does nothing without {other}; give {other}", key)
        return self


class Cogging(_Table):
    """Torque of the iron on the rotor; without this table there is none."""

    torque_nm: float = _key("N·m", "Amplitude: −torque_nm·sin(per_rev·x)", ge=0, le=100)
    per_rev: int = _key("–", "Periods a revolution", ge=1, le=1000)


HandPath = Literal["taps", "press", "free", "sine", "impact"]

_HAND_NEEDS: dict[str, tuple[str, ...]] = {
    "taps": ("frequency_hz", "stiffness"),
    "press": ("stiffness",),
    "free": ("frequency_hz", "stiffness"),
    "sine": ("frequency_hz", "stiffness"),
    "impact": ("speed_rad_s",),
}
_HAND_TAKES = {
    path: {*needs, *(() if path == "impact" else ("damping",))}
    for path, needs in _HAND_NEEDS.items()
}


class Hand(_Table):
    """The user: a spring and damper from the rotor to a point x_h(t); without it, a free rotor."""

    path: HandPath = _key(
        "–",
        "Motion of the hand, see below",
        range_text=", ".join(f"`{name}`" for name in _HAND_NEEDS),
    )
    amplitude_rad: float = _key("rad", "Amplitude A of the path", ge=1e-6, le=1000)
    frequency_hz: float | None = _key(
        "Hz", "Frequency f of `taps`, `free` and `sine`", None, default_text="none", ge=1e-3, le=1e4
    )
    stiffness: float | None = _key(
        "N·m/rad",
        "Spring of the hand; every path but `impact` needs it",
        None,
        default_text="none",
        ge=1e-9,
        le=1e6,
    )
    damping: float = _key("N·m·s/rad", "Damper of the hand; not with `impact`", 0.0, ge=0, le=1000)
    speed_rad_s: float | None = _key(
        "rad/s",
        "Speed of the rotor at the start of an `impact`, which alone needs it; not 0",
        None,
        default_text="none",
        ge=-1e4,
        le=1e4,
    )

    @model_validator(mode="after")
    def _check(self) -> Hand:
        shown = f'path = "{self.path}"'
        takes = _HAND_TAKES[self.path]
        for key in ("frequency_hz", "stiffness", "damping", "speed_rad_s"):
            if key in self.model_fields_set and key not in takes:
                wanted = ", ".join(["amplitude_rad", *sorted(takes)])
                why = "has no hand" if self.path == "impact" else "does not use it"
                _broken_rule(
                    f"hand.{key} makes no sense: {shown} {why}; it takes {wanted}", key, "path"
                )
        for key in _HAND_NEEDS[self.path]:
            if getattr(self, key) is None:
                unit = field_texts(type(self), key).unit
                _broken_rule(f"hand.{key} is missing, {shown} needs it; give it in {unit}", "path")
        if self.speed_rad_s == 0:
            _broken_rule("hand.speed_rad_s = 0 is no impact; give a speed in rad/s", "speed_rad_s")
        return self


class Encoder(_Table):
    """A quadrature encoder on the rotor; without this table the position is ideal."""

    counts_per_rev: int = _key(
        "counts",
        "Counts a revolution, all four edges counted",
        range_text="a multiple of 4 from 4 to 4e6",
        ge=4,
        le=4_000_000,
        multiple_of=4,
    )
    stops_at_s: float | None = _key(
        "s",
        "Time from which A and B stand still, as if the cable had come off",
        None,
        default_text="never",
        ge=0,
        le=1e6,
    )
    uneven: float = _key(
        "–",
        "Part of a cell by which an edge is displaced at most, the same in each revolution",
        0.0,
        ge=0,
        le=0.45,
    )
    reverses_at_s: float | None = _key(
        "s",
        "Time from which it counts backwards, as if A and B were swapped",
        None,
        default_text="never",
        ge=0,
        le=1e6,
    )
    skips_per_rev: int = _key(
        "edges",
        "Edges of a revolution that are lost, evenly spaced, at most a quarter of all",
        0,
        ge=0,
        le=1_000_000,
    )

    @model_validator(mode="after")
    def _check(self) -> Encoder:
        if 4 * self.skips_per_rev > self.counts_per_rev:
            _broken_rule(
                f"encoder.skips_per_rev = {self.skips_per_rev} is more than a quarter of "
                f"counts_per_rev = {self.counts_per_rev}; it may be at most "
                f"{self.counts_per_rev // 4}",
                "skips_per_rev",
                "counts_per_rev",
            )
        return self


class Adc(_Table):
    """The converter of the current; without this table the sensor is ideal."""

    part: str | None = _key(
        "–",
        "Converter by name: its resolution everywhere, its frame at the pins",
        None,
        default_text="none: two zeros and the bits, at half the clock",
        range_text=", ".join(f"`{name}`" for name in ALL_BITS),
    )
    bits: int = _key("bits", "Resolution", default_text="of the part", ge=8, le=16)
    full_scale_a: float | None = _key(
        "A",
        "Largest current either way: the range is ± this",
        None,
        default_text="twice what the voltage limit drives through R",
        ge=1e-3,
        le=_CURRENT_MAX_A,
    )
    noise_a: float = _key("A", "Noise of a sample, RMS", 0.0, ge=0, le=_CURRENT_MAX_A)
    offset_a: float = _key(
        "A",
        "Constant error of the sensor, below the full scale",
        0.0,
        ge=-_CURRENT_MAX_A,
        le=_CURRENT_MAX_A,
    )
    bandwidth_hz: float | None = _key(
        "Hz",
        "Bandwidth of the sense amplifier, a first-order lag",
        None,
        default_text="no lag",
        ge=100,
        le=1e9,
    )
    common_mode_a: float = _key(
        "A",
        "Error of the sensor by the sign of the motor's voltage",
        0.0,
        ge=-_CURRENT_MAX_A,
        le=_CURRENT_MAX_A,
    )
    edge_settle_s: float | None = _key(
        "s",
        "On `pins`: `common_mode_a` is what an edge of lead A adds; 1 % is left after this",
        None,
        default_text="`common_mode_a` goes by the sign of the voltage",
        ge=1e-9,
        le=1e-3,
    )
    drift_a_per_s: float = _key(
        "A/s", "How fast the constant error grows", 0.0, ge=-_CURRENT_MAX_A, le=_CURRENT_MAX_A
    )

    @model_validator(mode="before")
    @classmethod
    def _resolve_part(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("part"), str):
            return data
        name = data["part"]
        if name not in ALL_BITS:
            _broken_rule(f"adc.part {_unknown_choice(name, ALL_BITS)}", "part")
        bits = ALL_BITS[name]
        if data.get("bits", bits) != bits:
            _broken_rule(
                f"adc.bits = {_shown(data['bits'])} contradicts adc.part = {_shown(name)}, which "
                f"has {bits}; leave bits out",
                "bits",
                "part",
            )
        return {**data, "bits": bits}

    def resolved(self, motor: Motor, drive: Drive | None, duration_s: float) -> Adc:
        """With the full scale filled in: room for twice the largest current that can last."""
        limit_v = drive.limit_v if drive and drive.limit_v else USUAL_BUSES_V[0]
        full_scale_a = self.full_scale_a
        if full_scale_a is None:
            full_scale_a = min(2 * limit_v / motor.R_ohm, _CURRENT_MAX_A)
        if abs(self.offset_a) >= full_scale_a:
            _broken_rule(
                f"adc.offset_a = {_number(self.offset_a)} leaves the range of "
                f"±{full_scale_a:g} A; it must be smaller than full_scale_a",
                ("adc", "offset_a"),
                ("adc", "full_scale_a"),
            )
        if self.edge_settle_s is not None and self.common_mode_a == 0.0:
            _broken_rule(
                f"adc.edge_settle_s = {_number(self.edge_settle_s)} has nothing to settle; set "
                "adc.common_mode_a, what an edge adds, or leave it out",
                ("adc", "edge_settle_s"),
            )
        drifted = self.offset_a + self.drift_a_per_s * duration_s
        if abs(drifted) >= full_scale_a:
            _broken_rule(
                f"adc.drift_a_per_s = {_number(self.drift_a_per_s)} leaves the range of "
                f"±{full_scale_a:g} A in {duration_s:g} s; it must be slower",
                ("adc", "drift_a_per_s"),
                ("adc", "full_scale_a"),
                ("scene", "duration_s"),
            )
        return self.model_copy(update={"full_scale_a": full_scale_a})


Mode = Literal["unipolar", "locked-anti-phase", "sign-magnitude", "half-bridge"]


class Drive(_Table):
    """The bridge; without this table every voltage is reached, exactly."""

    mode: Mode = _key(
        "–",
        "How the bridge of `pins` switches, see below",
        UNIPOLAR,
        default_text="`unipolar`",
        range_text=", ".join(f"`{name}`" for name in MODE_WORDS),
    )
    bus_v: float | None = _key(
        "V",
        "Bus voltage of the bridge",
        None,
        default_text="smallest of 12, 24, 48 to reach `limit_v`; 12 on `pins` without `limit_v`",
        ge=0.1,
        le=_VOLTAGE_MAX_V,
    )
    limit_v: float | None = _key(
        "V",
        "Largest voltage either way, not above the bus; of a half bridge, half the bus",
        None,
        default_text="what the bus reaches where `bus_v` is given, else no limit",
        ge=1e-3,
        le=_VOLTAGE_MAX_V,
    )
    pwm_hz: float | None = _key(
        "Hz",
        "PWM carrier of `pins`",
        None,
        default_text="chosen by `pins` to fit the tick",
        ge=100,
        le=1e7,
    )
    dead_time_s: float = _key(
        "s", "Dead time of a half bridge, below half a carrier period", 0.0, ge=0, le=1e-3
    )
    compensate: bool = _key(
        "–",
        "Whether `pins` makes good what the dead time takes",
        True,
        default_text="true",
        range_text="true, false",
    )
    min_pulse_s: float = _key(
        "s", "Time that a gate of `pins` stays on at least; 0: any", 0.0, ge=0, le=1e-3
    )
    gain_error: float = _key(
        "–", "The motor gets (1 + this) times the voltage asked for", 0.0, ge=-0.9, le=1
    )
    bus_actual_v: float | None = _key(
        "V",
        "What the bus really is; the controller takes it for `bus_v` unless it measures it",
        None,
        default_text="`bus_v`",
        ge=0.1,
        le=_VOLTAGE_MAX_V,
    )
    bus_ripple_v: float = _key(
        "V", "Amplitude of a sine on the bus of `pins`", 0.0, ge=0, le=_VOLTAGE_MAX_V
    )
    bus_ripple_hz: float | None = _key(
        "Hz", "Its frequency, which it needs", None, default_text="none", ge=1e-3, le=1e5
    )
    bus_measured: bool = _key(
        "–",
        "Whether the controller measures the bus, and scales its pulses and its limit by it",
        False,
        default_text="false",
        range_text="true, false",
    )

    step_v: float = _key(
        "V",
        "What the bus changes by at `step_s`",
        0.0,
        ge=-_VOLTAGE_MAX_V,
        le=_VOLTAGE_MAX_V,
    )
    step_s: float | None = _key(
        "s", "Time of that step, which it needs", None, default_text="none", ge=0, le=1e6
    )
    sag_ohm: float = _key(
        "Ω", "What the bus falls by for an ampere that the bridge draws", 0.0, ge=0, le=100
    )

    @property
    def true_bus_v(self) -> float | None:
        """The bus as it is, without ripple, V; None where the scene has none."""
        return self.bus_v if self.bus_actual_v is None else self.bus_actual_v

    @property
    def gain(self) -> float:
        """Voltage at the motor over the voltage asked for, within the limit."""
        unmeasured = self.bus_v is not None and not self.bus_measured
        return (1.0 + self.gain_error) * (self.true_bus_v / self.bus_v if unmeasured else 1.0)

    @property
    def reached_v(self) -> float:
        """Largest voltage that a controller can ask for which knows its bus, V."""
        measured = self.bus_measured and self.bus_v is not None
        return (self.true_bus_v + min(0.0, self.step_v)) * self.reach if measured else math.inf

    @property
    def reach(self) -> float:
        """Largest voltage at the motor, in parts of the bus."""
        return 0.5 if self.mode == HALF_BRIDGE else 1.0

    @model_validator(mode="wrap")
    @classmethod
    def _resolve(cls, data: Any, handler: ModelWrapValidatorHandler[Drive]) -> Drive:
        drive = handler(data)
        bus_v, limit_v, reach = drive.bus_v, drive.limit_v, drive.reach
        if limit_v is None:
            limit_v = None if bus_v is None else bus_v * reach
        elif bus_v is None:
            bus_v = next((usual for usual in USUAL_BUSES_V if usual * reach >= limit_v), None)
            if bus_v is None:
                largest = USUAL_BUSES_V[-1] * reach
                _broken_rule(
                    f"drive.bus_v is missing and limit_v = {_number(limit_v)} is above "
                    f"{largest:g} V, the most with the largest default; give bus_v",
                    "limit_v",
                )
        elif limit_v > bus_v * reach:
            of = "" if reach == 1.0 else f"what a {drive.mode} has of "
            _broken_rule(
                f"drive.limit_v = {_number(limit_v)} is above {of}bus_v = {_number(bus_v)}; "
                f"it may be at most {bus_v * reach:g} V",
                "limit_v",
                "bus_v",
            )
        if drive.pwm_hz is not None and 2 * drive.dead_time_s * drive.pwm_hz >= 1:
            _broken_rule(
                f"drive.dead_time_s = {_number(drive.dead_time_s)} fills half a carrier period; "
                f"it must be below {_number(1 / (2 * drive.pwm_hz))} s",
                "dead_time_s",
                "pwm_hz",
            )
        drive._check_bus(bus_v)
        return drive.model_copy(update={"bus_v": bus_v, "limit_v": limit_v})

    def _check_bus(self, bus_v: float | None) -> None:
        """Refuse a true bus that can't be, for the resolved ``bus_v``."""
        if bus_v is None:
            for key in (
                "bus_actual_v", "bus_ripple_v", "bus_ripple_hz", "bus_measured", "step_v", "sag_ohm"
            ):  # fmt: skip
                if getattr(self, key):
                    _broken_rule(f"drive.{key} needs to know the bus; give bus_v", key)
            return
        if self.bus_ripple_v and self.bus_ripple_hz is None:
            _broken_rule("drive.bus_ripple_v has no frequency; give bus_ripple_hz", "bus_ripple_v")
        if self.bus_ripple_hz is not None and not self.bus_ripple_v:
            _broken_rule("drive.bus_ripple_hz has no amplitude; give bus_ripple_v", "bus_ripple_hz")
        name = "bus_v" if self.bus_actual_v is None else "bus_actual_v"
        actual_v = bus_v if self.bus_actual_v is None else self.bus_actual_v
        room_v = min(actual_v, _VOLTAGE_MAX_V - actual_v)
        if self.bus_ripple_v and self.bus_ripple_v >= room_v:
            _broken_rule(
                f"drive.bus_ripple_v = {_number(self.bus_ripple_v)} on {name} = "
                f"{_number(actual_v)} leaves 0 to {_VOLTAGE_MAX_V} V; it must be below "
                f"{_number(room_v)}",
                "bus_ripple_v",
                name,
            )
        if self.step_v and self.step_s is None:
            _broken_rule("drive.step_v has no time; give step_s", "step_v")
        if self.step_s is not None and "step_v" not in self.model_fields_set:
            _broken_rule("drive.step_s has nothing to change; give step_v", "step_s")
        after_v = actual_v + self.step_v
        if not self.bus_ripple_v < after_v <= _VOLTAGE_MAX_V - self.bus_ripple_v:
            _broken_rule(
                f"drive.step_v = {_number(self.step_v)} takes {name} = {_number(actual_v)} out of "
                f"0 to {_VOLTAGE_MAX_V} V; it must be above "
                f"{_number(self.bus_ripple_v - actual_v)} and at most "
                f"{_number(_VOLTAGE_MAX_V - self.bus_ripple_v - actual_v)}",
                "step_v",
                name,
            )


class Thermal(_Table):
    """Warming of the winding; without this table R is constant. Defaults are the RE 25's."""

    rth_winding: float = _key("K/W", "Thermal resistance, winding to housing", 3.1, ge=1e-3, le=1e4)
    rth_housing: float = _key(
        "K/W", "Thermal resistance, housing to ambient", 14.0, ge=1e-3, le=1e4
    )
    tau_winding_s: float = _key("s", "Time constant of the winding", 12.0, ge=0.5, le=1e6)
    tau_housing_s: float = _key("s", "Time constant of the housing", 612.0, ge=0.5, le=1e7)
    alpha_per_k: float = _key(
        "1/K", "Temperature coefficient of the winding, copper's", 0.0039, ge=0, le=0.01
    )
    ambient_c: float = _key("°C", "Temperature around the motor", 25.0, ge=-50, le=150)
    start_c: float | None = _key(
        "°C",
        "Temperature of winding and housing at the start; `R_ohm` holds at 25",
        None,
        default_text="`ambient_c`",
        ge=-50,
        le=200,
    )


class Transmission(_Table):
    """From the rotor to the hand and to the tip of an arm; the rotor's stiffness stays the same."""

    ratio: float | None = _key(
        "–", "Turns of the rotor for one of the arm", None, default_text="none", ge=1e-3, le=1e4
    )
    lever_m: float | None = _key(
        "m", "Length of the arm, which goes with `ratio`", None, default_text="none",
        ge=1e-4, le=100,
    )  # fmt: skip
    cable_stiffness: float | None = _key(
        "N·m/rad",
        "Spring of the cable between rotor and hand",
        None,
        default_text="a rigid cable",
        ge=1e-6,
        le=1e6,
    )
    cable_damping: float = _key("N·m·s/rad", "Damper of the cable", 0.0, ge=0, le=1000)
    backlash_rad: float = _key(
        "rad", "Play of the cable from one side to the other", 0.0, ge=0, le=1000
    )

    @model_validator(mode="after")
    def _check(self) -> Transmission:
        for key, other in (("ratio", "lever_m"), ("lever_m", "ratio")):
            if getattr(self, key) is not None and getattr(self, other) is None:
                _broken_rule(f"transmission.{key} does nothing without {other}; give {other}", key)
        for key in ("cable_damping", "backlash_rad"):
            if getattr(self, key) and self.cable_stiffness is None:
                _broken_rule(f"transmission.{key} needs a cable; give cable_stiffness", key)
        if self.ratio is None and self.cable_stiffness is None:
            _broken_rule(
                "[transmission] holds nothing; give ratio and lever_m, or cable_stiffness", ()
            )
        return self


class Servo(_Table):
    """The encoder's servo on the controller `encoder`; the wave controllers don't look at it."""

    rate_hz: float = _key(
        "Hz", "Rate of the servo; `tick_hz` is a whole multiple of it", 1e3, ge=10, le=4e6
    )
    stiffness: float | None = _key(
        "N·m/rad",
        "Virtual spring K of the walls",
        None,
        default_text="that of the analog wave wall",
        ge=1e-6,
        le=1e6,
    )
    damping: float = _key("N·m·s/rad", "Virtual damper B inside a wall", 0.0, ge=0, le=1000)
    amplifier_hz: float = _key(
        "Hz", "Bandwidth of the PI current amplifier, at most a tenth of `tick_hz`", 2e3,
        ge=1, le=4e5,
    )  # fmt: skip
    delay_s: float = _key(
        "s", "Time from sample to command, rounded to whole ticks", 0.0, ge=0, le=1
    )


def _as_tuples(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(tuple(pair) if isinstance(pair, list) else pair for pair in value)
    return value


Index = Annotated[int, Field(ge=0, le=999)]
"""Place of a wall in ``controller.walls``."""

_Edge = Annotated[float, Field(ge=-1000, le=1000)]


Feel = Literal["spring", "layer", "mass", "resonance"]

# Keys that each feel needs, and those that it may have besides.
_FEEL_NEEDS: dict[str, tuple[str, ...]] = {
    "spring": ("stiffness",),
    "layer": ("stiffness",),
    "mass": ("mass_kgm2",),
    "resonance": ("stiffness", "mass_kgm2"),
}
MOST_SECTIONS = 2
"""Biquads of a shaper."""

_Coefficient = Annotated[float, Field(ge=-1e6, le=1e6)]


class Shaper(_Table):
    """What contact feels like, as a wave-domain filter W; without this table W is 1."""

    feel: Feel | None = _key(
        "–",
        "What is wished, see below",
        None,
        default_text="none",
        range_text=", ".join(f"`{name}`" for name in _FEEL_NEEDS),
    )
    stiffness: float | None = _key(
        "N·m/rad", "Spring of the feel", None, default_text="none", ge=1e-9, le=1e6
    )
    damping: float = _key("N·m·s/rad", "Damper of the feel", 0.0, ge=0, le=1000)
    mass_kgm2: float | None = _key(
        "kg·m²", "Inertia of the feel", None, default_text="none", ge=1e-12, le=1
    )
    sos: Annotated[tuple[tuple[_Coefficient, ...], ...] | None, BeforeValidator(_as_tuples)] = _key(
        "–",
        "Biquads of your own in z, in place of a feel",
        None,
        default_text="none",
        range_text="one or two rows `[b0, b1, b2, a0, a1, a2]`",
    )
    walls: Annotated[tuple[Index, ...] | None, BeforeValidator(_as_tuples)] = _key(
        "–",
        "Walls that feel so, by their place in `controller.walls` from 0; others are rigid",
        None,
        default_text="all",
        range_text="places in `controller.walls`",
    )

    @property
    def sections(self) -> int:
        """Biquads that it takes."""
        return 1 if self.sos is None else len(self.sos)

    @model_validator(mode="after")
    def _check(self) -> Shaper:
        if self.sos is not None:
            given = self.model_fields_set & {"feel", "stiffness", "damping", "mass_kgm2"}
            if given:
                _broken_rule(
                    f"shaper.{min(given)} makes no sense beside sos; give one of the two",
                    min(given),
                    "sos",
                )
            if not 1 <= len(self.sos) <= MOST_SECTIONS or any(len(row) != 6 for row in self.sos):
                _broken_rule(
                    "shaper.sos must hold one or two rows of six numbers; "
                    "write sos = [[b0, b1, b2, a0, a1, a2]]",
                    "sos",
                )
            return self
        if self.feel is None:
            _broken_rule(
                f"[shaper] has neither feel nor sos; write feel = one of {', '.join(_FEEL_NEEDS)}",
                (),
            )
        needs = _FEEL_NEEDS[self.feel]
        shown = f'feel = "{self.feel}"'
        for key in needs:
            if getattr(self, key) is None:
                unit = field_texts(type(self), key).unit
                _broken_rule(
                    f"shaper.{key} is missing, {shown} needs it; give it in {unit}", "feel"
                )
        for key in ("stiffness", "mass_kgm2"):
            if key in self.model_fields_set and key not in needs:
                _broken_rule(
                    f"shaper.{key} makes no sense: {shown} does not use it; "
                    f"it takes {', '.join((*needs, 'damping'))}",
                    key,
                    "feel",
                )
        return self


class Controller(_Table):
    """The wave controller: its rate, latency, virtual environment and walls."""

    tick_hz: float = _key("Hz", "Control rate 1/T", ge=10, le=4e6)
    extra_ticks: int = _key(
        "ticks",
        "Whole ticks of latency k beyond the soonest possible",
        1,
        default_text="1; on `pins` as many as it needs",
        ge=0,
        le=1000,
    )
    lambda_: float = _key(
        "rad/s",
        "λ of the virtual environment, matched in spite of the latency",
        alias="lambda",
        ge=1,
        le=1e9,
    )
    eta_contact: float = _key("–", "η in contact", -1.0, ge=-1, le=1)
    eta_free: float | None = _key(
        "–",
        "η in free space",
        None,
        default_text="1; with a port anchor what the winding's own swing asks for, 0.99 or so",
        ge=-1,
        le=1,
    )
    walls: Annotated[tuple[tuple[_Edge, _Edge], ...], BeforeValidator(_as_tuples)] = _key(
        "rad",
        "Solid intervals `[x_min, x_max]`, none over another",
        (),
        default_text="no wall",
        range_text="pairs with x_min < x_max, each -1000 to 1000",
    )
    edge_hysteresis: bool = _key(
        "–",
        "A wall is left one encoder cell late, so that a resting finger does not chatter",
        False,
        default_text="false",
        range_text="`true` or `false`",
    )
    r_hat: float | None = _key(
        "Ω",
        "The controller's estimate R̂ of the resistance",
        None,
        default_text="R of the motor",
        ge=1e-3,
        le=_R_HAT_MAX_OHM,
    )
    l_hat: float | None = _key(
        "H",
        "The controller's estimate L̂ of the inductance",
        None,
        default_text="L of the motor",
        ge=1e-6,
        le=1,
    )
    k_t_hat: float | None = _key(
        "N·m/A",
        "The controller's estimate k̂_T of the torque constant",
        None,
        default_text="k_T of the motor",
        ge=1e-4,
        le=10,
    )
    clock_hz: float | None = _key(
        "Hz",
        "Clock of `pins`, a whole multiple of `tick_hz`",
        None,
        default_text="the multiple of `tick_hz` nearest to 48e6, of at least 48",
        ge=1e6,
        le=1e9,
    )
    early_duty: bool = _key(
        "–",
        "`pins` makes the duty 10 clocks after the last ADC bit, for one tick of latency less",
        False,
        default_text="false",
        range_text="`true` or `false`",
    )
    anchor_auto: bool = _key(
        "–",
        "The port anchor, which holds walls by the encoder, with what suits the motor's data",
        False,
        default_text="`false`",
        range_text="`true`, `false`",
    )
    anchor_ohm: float | None = _key(
        "Ω",
        "Resistance ρ with which the port anchor pulls waves and encoder together; given, there is "
        "an anchor",
        None,
        default_text="4 `r_hat`, less at a slow tick",
        ge=1e-3,
        le=1000,
    )
    anchor_ohm_per_s: float | None = _key(
        "Ω/s",
        "How fast the port anchor learns a voltage that stays, γ",
        None,
        default_text="22.5 ρ",
        ge=0,
        le=1e6,
    )
    swing_ohm: float | None = _key(
        "Ω",
        "Resistance that the port anchor has for swings within a cell, in contact and at rest",
        None,
        default_text="ρ/2",
        ge=0,
        le=1000,
    )
    anchor_limit_v: float | None = _key(
        "V",
        "Largest correction of the port anchor where the waves ask for no voltage; it grows by "
        "half of theirs",
        None,
        default_text="0.8, or a third of the drive's limit",
        ge=0,
        le=63,
    )
    r_hat_part: float = _key(
        "–",
        "Part of `r_hat` that the waves of a port with an anchor are made for",
        0.9,
        default_text="0.9",
        ge=0.1,
        le=1.5,
    )

    @property
    def anchored(self) -> bool:
        """Whether there is a port anchor."""
        return self.anchor_auto or self.anchor_ohm is not None

    @model_validator(mode="after")
    def _check(self) -> Controller:
        _check_walls(self.walls)
        if not self.anchored:
            for key in ("anchor_ohm_per_s", "swing_ohm", "anchor_limit_v", "r_hat_part"):
                if key in self.model_fields_set:
                    _broken_rule(
                        f"controller.{key} belongs to a port anchor; add anchor_auto = true", key
                    )
        if self.clock_hz is not None:
            clocks = self.clock_hz / self.tick_hz
            whole = max(1, round(clocks))
            if not math.isclose(clocks, whole, rel_tol=1e-9):
                _broken_rule(
                    f"controller.clock_hz = {_number(self.clock_hz)} is no whole multiple of "
                    f"tick_hz = {_number(self.tick_hz)}; the nearest is "
                    f"{_number(whole * self.tick_hz)}",
                    "clock_hz",
                    "tick_hz",
                )
        return self


def _check_walls(walls: tuple[tuple[float, float], ...]) -> None:
    for n, (x_min, x_max) in enumerate(walls):
        if x_min >= x_max:
            _broken_rule(
                f"controller.walls[{n}] = [{_number(x_min)}, {_number(x_max)}] is empty; "
                "it must be [x_min, x_max] with x_min < x_max",
                ("walls", n),
            )
    in_order = sorted(range(len(walls)), key=lambda n: walls[n])
    for low, high in pairwise(in_order):
        if walls[high][0] < walls[low][1]:
            first, second = sorted((low, high))
            _broken_rule(
                f"controller.walls[{second}] overlaps walls[{first}]; join them or move them apart",
                ("walls", second),
            )


class Scene(_Table):
    """A whole scene; a table that the file does not have is ``None`` and is not simulated.

    ``controller.r_hat``, ``l_hat``, ``k_t_hat``, ``eta_free`` and ``adc.full_scale_a`` are never
    ``None``: defaults are filled in.
    ``drive.bus_v`` is ``None`` only if ``drive.limit_v`` is, which then means no limit.
    """

    scene: SceneTable
    motor: Motor
    friction: Friction | None = None
    brushes: Brushes | None = None
    winding: Winding | None = None
    cogging: Cogging | None = None
    hand: Hand | None = None
    encoder: Encoder | None = None
    adc: Adc | None = None
    drive: Drive | None = None
    thermal: Thermal | None = None
    transmission: Transmission | None = None
    servo: Servo | None = None
    controller: Controller
    shaper: Shaper | None = None

    @model_validator(mode="wrap")
    @classmethod
    def _resolve(cls, data: Any, handler: ModelWrapValidatorHandler[Scene]) -> Scene:
        scene = handler(data)
        tick_s = 1 / scene.controller.tick_hz
        if scene.scene.duration_s < tick_s:
            _broken_rule(
                f"scene.duration_s = {_number(scene.scene.duration_s)} is shorter than a tick; "
                f"it must be at least {_number(tick_s)} s",
                ("scene", "duration_s"),
                ("controller", "tick_hz"),
            )
        if scene.shaper is not None and scene.controller.early_duty:
            _broken_rule(
                "controller.early_duty has no time for W: no [shaper]; take one of the two out",
                ("shaper",),
                ("controller", "early_duty"),
            )
        if scene.shaper is not None and scene.shaper.walls:
            walls = len(scene.controller.walls)
            for n, wall in enumerate(scene.shaper.walls):
                if wall >= walls:
                    _broken_rule(
                        f"shaper.walls[{n}] = {wall} is no wall: controller.walls has {walls}; "
                        "walls count from 0",
                        ("shaper", "walls", n),
                        ("controller", "walls"),
                    )
        if scene.adc is not None:
            adc = scene.adc.resolved(scene.motor, scene.drive, scene.scene.duration_s)
            scene = scene.model_copy(update={"adc": adc})
        cable = scene.transmission is not None and scene.transmission.cable_stiffness is not None
        if cable and (scene.hand is None or scene.hand.path == "impact"):
            _broken_rule(
                "transmission.cable_stiffness has no hand at its other end; "
                "give [hand] with a path that has a spring",
                ("transmission", "cable_stiffness"),
                ("hand",),
            )
        motor, controller = scene.motor, scene.controller
        known = {"r_hat": motor.R_ohm, "l_hat": motor.L_h, "k_t_hat": motor.k_t}
        missing = {key: value for key, value in known.items() if getattr(controller, key) is None}
        controller = controller.model_copy(update=missing)
        if controller.eta_free is None:
            controller = controller.model_copy(update={"eta_free": _eta_free(controller, scene)})
        return scene.model_copy(update={"controller": controller})


def _eta_free(controller: Controller, scene: Scene) -> float:
    """η in free space where the scene has none."""
    if not controller.anchored:
        return 1.0
    lag_s = 0.0
    if scene.adc is not None and scene.adc.bandwidth_hz is not None:
        lag_s = 1.0 / (2.0 * math.pi * scene.adc.bandwidth_hz)
    tick_s = 1.0 / controller.tick_hz
    return choose_eta_free(
        controller.r_hat, controller.l_hat, lag_s,
        matched_a(tick_s, controller.lambda_, controller.extra_ticks), controller.extra_ticks,
        tick_s, controller.anchor_ohm,
    )  # fmt: skip


TABLES: dict[str, type[_Table]] = {
    "scene": SceneTable,
    "motor": Motor,
    "friction": Friction,
    "brushes": Brushes,
    "winding": Winding,
    "cogging": Cogging,
    "hand": Hand,
    "encoder": Encoder,
    "adc": Adc,
    "drive": Drive,
    "thermal": Thermal,
    "transmission": Transmission,
    "servo": Servo,
    "controller": Controller,
    "shaper": Shaper,
}
"""Model of each table, in the order of the format's description."""


class FieldTexts(NamedTuple):
    """What the format's description says of a key."""

    key: str
    unit: str
    default: str
    range: str
    meaning: str


def field_texts(table: type[BaseModel], name: str) -> FieldTexts:
    """Description of the field ``name`` of a table's model; the unit – stands for none."""
    info = table.model_fields[name]
    texts = info.json_schema_extra
    assert isinstance(texts, dict)
    default = texts["default"]
    if default is None:
        default = "required" if info.is_required() else _number(info.default)
    return FieldTexts(
        key=info.alias or name,
        unit=str(texts["unit"]),
        default=str(default),
        range=str(texts["range"] or _bounds_text(info)),
        meaning=info.description or "",
    )


def _bounds_text(info: FieldInfo) -> str:
    low = next(bound.ge for bound in info.metadata if hasattr(bound, "ge"))
    high = next(bound.le for bound in info.metadata if hasattr(bound, "le"))
    return f"{_number(low)} to {_number(high)}"


def _number(value: float) -> str:
    """A number as a person writes it in TOML: ``1e-6``, ``4e6``, ``0.25``."""
    text = f"{value:.9g}"
    if zeros := re.fullmatch(r"(-?\d)(0{4,})", text):
        return f"{zeros[1]}e{len(zeros[2])}"
    if "e" not in text and value and value % 1e5 == 0:
        return f"{value / 1e6:.9g}e6"
    return re.sub(r"e([+-]?)0*(\d)", lambda m: f"e{m[1].strip('+')}{m[2]}", text)


def _shown(value: Any) -> str:
    """A refused value as it stands in TOML, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list | tuple):
        return "an array"
    if isinstance(value, int) and value.bit_length() > 64:
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, int | float):
        return repr(value)
    text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else f'{text[:56]}..."'


def _near(name: str, known: Sequence[str] | Mapping[str, Any]) -> str | None:
    """The known name that ``name`` was most likely meant to be."""
    by_lower = {k.lower(): k for k in known}
    near = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.6)
    if not near and name:
        near = [k for k in by_lower if k.startswith(f"{name.lower()}_")]
    return by_lower[near[0]] if near else None


def _unknown_choice(name: str, known: Sequence[str] | Mapping[str, Any]) -> str:
    near = _near(name, known)
    meant = f'did you mean "{near}"? ' if near else ""
    return f"{_shown(name)} is unknown; {meant}known: {', '.join(known)}"


# Ways to write a unit in plain letters, all brought to one form before units are compared.
_UNIT_SPELLINGS = ((r"[·*.\s_^]", ""), ("²", "2"), (r"[Oo]hms?", "Ω"), ("\u2126", "Ω"))
_PREFIXES = {"p": -12, "n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3, "k": 3, "M": 6, "G": 9}
_OTHER_UNITS = {("gcm2", "kgm2"): -7, ("%", "–"): -2}
_QUANTITY = re.compile(r"\s*([-+]?)(\d+\.?\d*|\.\d+)(?:[eE]([-+]?\d{1,3}))?\s*(.*?)\s*")


def _plain_number(text: str, unit: str) -> str | None:
    """The number in ``unit`` that the string ``text`` means, as TOML; ``None`` if unclear."""
    quantity = _QUANTITY.fullmatch(text)
    if quantity is None:
        return None
    sign, digits, exponent, given = quantity.groups()
    wanted = unit
    for form, plain in _UNIT_SPELLINGS:
        given, wanted = re.sub(form, plain, given), re.sub(form, plain, wanted)
    if given in ("", wanted):
        shift = 0
    elif (given, wanted) in _OTHER_UNITS:
        shift = _OTHER_UNITS[given, wanted]
    elif given[0] in _PREFIXES and given[1:] == wanted:
        shift = _PREFIXES[given[0]]
    else:
        return None
    digits = f"0{digits}" if digits.startswith(".") else digits.removesuffix(".")
    power = int(exponent or 0) + shift
    return f"{sign}{digits}e{power}" if power else f"{sign}{digits}"


def _field(path: KeyPath) -> FieldTexts | None:
    """Description of the key at or above ``path``; ``None`` where the schema has none."""
    if len(path) < 2 or path[0] not in TABLES:
        return None
    table = TABLES[str(path[0])]
    for name, info in table.model_fields.items():
        if (info.alias or name) == path[1]:
            return field_texts(table, name)
    return None


def _keys_of(table: type[_Table]) -> list[str]:
    return [info.alias or name for name, info in table.model_fields.items()]


def _unknown(path: KeyPath, value: Any) -> str:
    """Message for a table or key that the format does not have."""
    if path in GONE:
        return f"{dotted(path)} is gone: {GONE[path]}"
    name = str(path[-1])
    homes = [f"[{table}]" for table, model in TABLES.items() if name in _keys_of(model)]
    if len(path) == 1:
        tables = ", ".join(f"[{table}]" for table in TABLES)
        if homes and not isinstance(value, dict):
            return f"key {dotted(path)} stands in no table; it belongs in {' or '.join(homes)}"
        near = _near(name, TABLES)
        meant = f"did you mean [{near}]? " if near else ""
        kind = "table [{}]" if isinstance(value, dict | list) else "key {} outside the tables"
        return f"unknown {kind.format(dotted(path))}; {meant}the tables are {tables}"
    table = str(path[0])
    known = _keys_of(TABLES[table])
    near = _near(name, known)
    if near:
        meant = f"did you mean {near}? "
    elif homes:
        meant = f"it belongs in {' or '.join(homes)}; "
    else:
        meant = ""
    return f"unknown key {dotted(path)}; {meant}[{table}] takes {', '.join(known)}"


def _missing(path: KeyPath) -> str:
    if len(path) == 1:
        return f"table [{path[0]}] is missing; a scene needs [scene], [motor] and [controller]"
    if path[0] == "motor":
        constants = ", ".join(_keys_of(Motor)[1:])
        return f"{dotted(path)} is missing; give preset, or all of {constants}"
    texts = _field(path)
    assert texts is not None
    return f"{dotted(path)} is missing; give {_wanted(texts)}"


def _wanted(texts: FieldTexts) -> str:
    """The range of a key with its unit, for the end of a message."""
    plain = re.fullmatch(r"\S+ to \S+", texts.range) and texts.unit != "–"
    return f"{texts.range} {texts.unit}" if plain else texts.range


def _wrong_value(kind: str, path: KeyPath, value: Any) -> str:
    """Message for one value that is wrong by itself; ``kind`` is pydantic's type of the error."""
    name, texts = dotted(path), _field(path)
    assert texts is not None
    shown, wanted = _shown(value), _wanted(texts)
    unit = "" if texts.unit == "–" else f" in {texts.unit}"
    if path[:2] == ("controller", "walls") and len(path) <= 3:
        return f"{name} must hold pairs of numbers{unit}; write walls = [[x_min, x_max]]"
    if kind == "literal_error" and isinstance(value, str):
        return f"{name} {_unknown_choice(value, _HAND_NEEDS)}"
    if kind in ("string_type", "literal_error"):
        return f"{name} must be a string in quotes, not {shown}; use {texts.range}"
    if kind == "finite_number":
        return f"{name} must be a finite number{unit}, not {shown}; use {wanted}"
    if kind in ("float_type", "int_type"):
        what = "a whole number" if kind == "int_type" else f"a number{unit}"
        if isinstance(value, str):
            plain = _plain_number(value, texts.unit)
            right = f"write {plain}" if plain else f"write the number alone, {wanted}"
            return f"{name} must be {what}, not the string {shown}; {right}"
        whole = isinstance(value, float) and value.is_integer() and abs(value) < 2**53
        right = f"write {int(value)}" if whole else f"use {wanted}"
        return f"{name} must be {what}, not {shown}; {right}"
    return f"{name} = {shown} is out of range; it must be {wanted}"


class _Refusal(NamedTuple):
    """One thing wrong: what, and the keys that have to do with it, the one to blame first."""

    problem: str
    paths: list[KeyPath]
    missing: bool = False


def _refusals(data: dict[str, Any]) -> tuple[Scene | None, list[_Refusal]]:
    """The scene, or everything that is found wrong with it."""
    found = []
    for part in NOT_SIMULATED:
        value: Any = data
        for name in part.path:
            value = value.get(name) if isinstance(value, dict) else None
        if value is None or (part.off is not None and value == part.off):
            continue
        name = f"[{part.path[0]}]" if len(part.path) == 1 else dotted(part.path)
        way_out = "leave it out"
        if part.off is not None:
            way_out += f" or give {_shown(part.off)}"
        found.append(_Refusal(f"{name}: {part.what} is not simulated yet; {way_out}", [part.path]))
    scene = None
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        found.extend(_explain(error))
    return scene, found


def _explain(error: ValidationError) -> Iterator[_Refusal]:
    lifted = [part.path for part in NOT_SIMULATED]
    for detail in error.errors(include_url=False):
        path, kind, value = detail["loc"], detail["type"], detail["input"]
        if kind == "rule":
            rule = detail["ctx"]
            yield _Refusal(rule["problem"], [(*path, *below) for below in rule["paths"]])
        elif any(path[: len(part)] == part for part in lifted):
            # Already refused as a whole, unless it is what switches the part off, wrongly written.
            if kind != "extra_forbidden" and path in lifted and len(path) > 1:
                yield _Refusal(_wrong_value(kind, path, value), [path])
        elif kind == "extra_forbidden":
            yield _Refusal(_unknown(path, value), [path])
        elif kind == "missing" and len(path) <= 2:
            yield _Refusal(_missing(path), [path], missing=True)
        elif kind == "missing":  # one edge of a wall
            yield _Refusal(_wrong_value(kind, path[:-1], value), [path[:-1]])
        elif kind == "model_type":
            name = dotted(path)
            problem = f"{name} must be a table, not {_shown(value)}; write [{name}] above its keys"
            yield _Refusal(problem, [path])
        else:
            yield _Refusal(_wrong_value(kind, path, value), [path])


def _apply(data: dict[str, Any], override: str) -> KeyPath:
    """Put one ``table.key=value`` into ``data``; ``SceneError`` if it has another form."""
    where = f"--set {override}"
    key, equals, text = override.partition("=")
    path = tuple(part.strip() for part in key.split("."))
    text = text.strip()
    if re.search("[\ud800-\udfff]", override):  # what the shell passed on as raw bytes
        raise SceneError(f"{where}: is not UTF-8; it must be table.key=value")
    if not equals:
        raise SceneError(f"{where}: no value; it must be table.key=value")
    if len(path) == 1:
        homes = [f"{name}.{key.strip()}" for name, t in TABLES.items() if path[0] in _keys_of(t)]
        meant = f"did you mean {' or '.join(homes)}?" if homes else "it must be table.key=value"
        raise SceneError(f"{where}: {_shown(key)} names no table; {meant}")
    if len(path) > 2 or not all(path):
        raise SceneError(f"{where}: {_shown(key)} is not table.key; it must be table.key=value")
    try:
        value = parse_value(text)
    except ValueError:
        if not text or re.search(r"""[\[\]{}"'#=,\n]""", text):
            raise SceneError(
                f"{where}: {_shown(text)} is not a TOML value; "
                'write a number, "a string", or [[x_min, x_max]]'
            ) from None
        value = text
    table = data.setdefault(path[0], {})
    if isinstance(table, dict):
        table[path[1]] = value
    return path


def _read(path: Path) -> bytes:
    """Bytes of a scene; ``SceneError`` where there is no such file or it can't be read."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise SceneError(f"{path}: no such file; give the path of a scene") from None
    except IsADirectoryError:
        raise SceneError(f"{path}: is a directory; give the path of a scene in it") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise SceneError(f"{path}: can't be read: {reason}; give a readable file") from None
    if len(content) > LARGEST_FILE:
        raise SceneError(f"{path}: larger than {LARGEST_FILE} bytes; a scene is a short TOML file")
    return content


def load_scene(path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """Read and check the scene in the TOML file ``path``.

    ``overrides`` are strings ``table.key=value`` that replace or add keys; values are TOML, and
    bare words are strings. ``SceneError`` where anything is wrong: of several faults it tells the
    first in the order of the file, overrides before the file and missing keys last.
    """
    path = Path(path)
    try:
        data, lines = parse(_read(path))
    except TomlError as error:
        raise SceneError(f"{path}:{error.line}: {error.problem}") from None
    overridden: dict[KeyPath, str] = {}
    for override in overrides:
        key = _apply(data, override)
        overridden[key] = override
        lines = {at: line for at, line in lines.items() if at[: len(key)] != key}

    def place(at: KeyPath) -> tuple[int, str]:
        """Line (0 for an override) and its label, of ``at`` or of what holds it."""
        for length in range(len(at), 0, -1):
            if at[:length] in overridden:
                return 0, f"--set {overridden[at[:length]]}"
            if at[:length] in lines:
                return lines[at[:length]], f"{path}:{lines[at[:length]]}"
        made_by = [text for key, text in overridden.items() if key[0] == at[0]]
        return (0, f"--set {made_by[0]}") if made_by else (1, f"{path}:1")

    scene, refusals = _refusals(data)
    placed = []
    for refusal in refusals:
        places = [place(at) for at in refusal.paths]
        # What the user changed on the command line is to blame before what stood in the file.
        line, label = next((p for p in places if p[0] == 0), places[0])
        placed.append((refusal.missing, line, f"{label}: {refusal.problem}"))
    if placed:
        raise SceneError(min(placed, key=lambda p: p[:2])[2])
    assert scene is not None
    return scene


def drive_gain(scene: Scene) -> float:
    """Voltage at the motor over the voltage asked for, within the limit; 1 without a drive."""
    return scene.drive.gain if scene.drive else 1.0


def encoder_end(scene: Scene) -> float:
    """Time from which a scene's encoder stands still, s; infinite where it goes on."""
    stops = scene.encoder.stops_at_s if scene.encoder else None
    return math.inf if stops is None else stops


def shipped_scenes() -> dict[str, Path]:
    """Scenes that come with the project: path by name, in alphabetical order."""
    return {path.stem: path for path in sorted(SCENES_DIR.glob("*.toml"))}


def find_scene(name: str) -> Path:
    """Path of a scene given as a path or as the bare name of a shipped one.

    A file of that name wins. ``SceneError`` for a bare name that is neither.
    """
    path = Path(name)
    if path.is_file() or not re.fullmatch(r"\w+", name):
        return path
    shipped = shipped_scenes()
    if name in shipped:
        return shipped[name]
    if path.exists():
        return path
    near = _near(name, shipped)
    meant = f"did you mean {near}? " if near else ""
    raise SceneError(f"{name}: no such scene; {meant}give a path, or one of {', '.join(shipped)}")
