# SPDX-License-Identifier: Apache-2.0
"""The guard: its faults by name and its settings as a word, as ``rtl/wh_faults.vh`` has them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from enum import EnumMeta, IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

from wavehaptics.controller.ports import Ports
from wavehaptics.controller.settings import holds_position
from wavehaptics.laws import closed_forms
from wavehaptics.motor.sensor import Sensor
from wavehaptics.runtime.repository import RTL_DIR
from wavehaptics.scene import Scene
from wavehaptics.scene.tables.thermal import REFERENCE_C, Thermal
from wavehaptics.words import formats, table
from wavehaptics.words.table import WORDS

_HEADER = (RTL_DIR / "wh_faults.vh").read_text(encoding="utf-8")


def _integer(name: str) -> int:
    found = re.search(rf"^`define WH_{name}\s+(\d+'h)?([0-9a-f]+)", _HEADER, re.MULTILINE)
    assert found is not None
    return int(found[2], 16 if found[1] else 10)


class _OfHeader(EnumMeta):
    """For an enumeration whose members a type checker can't know."""

    if TYPE_CHECKING:

        def __getattr__(cls, name: str) -> Any: ...


class Fault(IntEnum, metaclass=_OfHeader):
    """Bits of the status word."""

    _ignore_ = ["_name", "_bit"]  # noqa: RUF012
    for _name, _bit in re.findall(r"WH_FAULT_(\w+)\s+(\d+)", _HEADER):
        vars()[_name] = int(_bit)


FIELDS = {word.name.removeprefix("guard_").upper(): word for word in table.ports()["guard"]}
"""The words of its settings, by the names that ``wh_faults.vh`` has for them."""

WIDTH = table.port_width(FIELDS.values(), table.Sizes())
DAMPABLE = _integer("FAULTS_DAMPABLE")
"""Faults after which damping is allowed."""

CURRENT_Q = _integer("GUARD_CURRENT_Q")
WAVE_Q = _integer("GUARD_WAVE_Q")
HEAT_Q = 2 * CURRENT_Q
HEAT_SQUARES = 1 << _integer("GUARD_HEAT_LOG2")
"""Squares of the current in the winding's time constant."""
SPAN = 1 << _integer("SPAN_LOG2")
"""Control periods of a span, in which a speed is counted."""


def mask(faults: Iterable[Fault]) -> int:
    """Word with the bits of ``faults``."""
    return sum(1 << fault for fault in set(faults))


def pack(fields: Mapping[str, int]) -> int:
    """Settings of the guard from raw fields, 0 where not named; ``ValueError`` beyond a field."""
    values = {FIELDS[name].name: value for name, value in fields.items()}
    return table.inputs(values, table.Sizes())["guard_i"]


ZERO_A = 0.02
ZERO_OF_SCALE = 0.008
"""Current with the gates off, and in parts of the ADC's scale: 20 mA of 2.5 A. The rails of
amplifier and ADC move it by the more, the wider the scale is."""


class Limits(NamedTuple):
    """What the guard allows, SI; ``watched`` are the faults that count."""

    watched: tuple[Fault, ...]
    damp: tuple[Fault, ...] = ()
    current_a: float = 5.0
    stuck_samples: int = 1000
    zero_a: float = ZERO_A
    zero_s: float = 2e-3
    """How long the bridge has to be off before the current counts as an offset."""
    lost_v: float = 0.1
    """Back-EMF that has to show as counts ..."""
    lost_s: float = 2e-3
    """... within this time."""
    host_s: float = 1e-3
    bus_min_v: float = 10.0
    bus_max_v: float = 14.0
    rms_a: float = 1.24
    """Current that the winding carries for ever."""
    energy: float = 0.0
    """Most that a contact may deliver to the shaft, A·counts; 0: no check."""
    saturated_s: float = 0.0
    """Longest time between two turns back at the voltage limit in contact; 0: no check."""
    winding_s: float = 12.0
    """Time constant of the winding."""
    stop_level: int = 0
    driver_level: int = 0
    """Levels of the pins that are a fault; 0: so is a wire that is off, with a pull-down."""


BOARD_FAULTS = (
    Fault.CURRENT, Fault.ADC_STUCK, Fault.ADC_RANGE, Fault.ZERO, Fault.ENCODER, Fault.LOST,
    Fault.HEAT, Fault.SETTING, Fault.OVERRUN, Fault.ANCHOR, Fault.ENERGY,
    Fault.SATURATED, Fault.OVERSPEED, Fault.WINDOW,
)  # fmt: skip
"""What any board watches: it has no host and no measured bus, and its own stop."""

SWITCH_FAULTS = (Fault.TRIP, Fault.ENCODER, Fault.ANCHOR, Fault.OVERRUN)
"""What ``boards/wh_board_switch.v`` takes the gates off for without a guard."""

CURRENT_OF_SCALE = 0.9
"""Current limit of a board that names none, in parts of its ADC's scale."""

STUCK_S = 1e-3
"""Time in which a board's ADC says something else."""

SATURATED_S = 20e-3
"""A hand turns back at most some ten times a second."""

LOST_OF_R = 0.5
"""A winding that is so much warmer, or R̂ so much off, isn't taken for a rotor that turns."""

WINDING_MOST_C = 100.0
"""Temperature that a winding bears for ever: Maxon's data sheet of the RE 25 118743."""


def _energy_limit(scene: Scene, ports: Ports, most_a: float) -> float:
    """What the spring of a wall holds at the largest current, ½F²/K, in A·counts.

    0, no check, where contact doesn't push back for good: a damper that is moved for ever makes
    energy of any offset. And for a brushless motor, whose energy is not observed.
    """
    control, set_ = scene.controller, ports.settings
    if scene.motor.brushless or not holds_position(control, set_.shaper):
        return 0.0
    henry = closed_forms.l_eff(control.l_hat, control.r_hat, set_.tau)
    if set_.shaper.wish is not None:
        henry += control.k_t_hat**2 / set_.shaper.wish.spring
    return 0.5 * henry * most_a**2 / (control.k_t_hat * set_.cell_rad)


def board_limits(
    scene: Scene, ports: Ports, trip_a: float | None = None, *, driver: bool = False
) -> Limits:
    """What the guard of a board allows, from its scene and the controller's settings for it.

    The current is ``trip_a``, or a part of the ADC's scale; ``driver`` is a pin that is low at a
    fault. The winding is one of R̂ that bears what
    ``[thermal]`` says, or its defaults: of a motor's data sheet, which protection has to know.
    """
    thermal = scene.thermal or Thermal()
    rise_c = WINDING_MOST_C - thermal.ambient_c
    hot_ohm = scene.controller.r_hat * (1.0 + thermal.alpha_per_k * (WINDING_MOST_C - REFERENCE_C))
    rms_a = math.sqrt(rise_c / (hot_ohm * (thermal.rth_winding + thermal.rth_housing)))
    current_a = trip_a or CURRENT_OF_SCALE * ports.sensor.full_scale_a
    saturated_s = scene.guard.saturated_s if scene.guard else SATURATED_S
    return Limits(
        watched=(*BOARD_FAULTS, Fault.DRIVER) if driver else BOARD_FAULTS,
        current_a=current_a,
        zero_a=max(ZERO_A, ZERO_OF_SCALE * ports.sensor.full_scale_a),
        energy=_energy_limit(scene, ports, current_a),
        saturated_s=saturated_s,
        stuck_samples=round(STUCK_S / ports.timing.tick_s) * ports.timing.samples,
        lost_v=LOST_OF_R * scene.controller.r_hat * rms_a,
        rms_a=rms_a,
        winding_s=thermal.tau_winding_s,
    )


def settings(limits: Limits, tick_s: float, sensor: Sensor, s: float, unity: float) -> int:
    """The guard's word for a controller's tick, ADC and s = √(2R̂).

    ``unity`` is the sample of full scale, in parts of 2¹⁵.
    """
    return pack(raw_fields(limits, tick_s, sensor, s, unity))


def raw_fields(
    limits: Limits, tick_s: float, sensor: Sensor, s: float, unity: float
) -> dict[str, int]:
    """The raw fields of :func:`settings`."""
    full = 1 << (formats.SAMPLE_W - 1)

    def ticks(seconds: float) -> int:
        return max(1, round(seconds / tick_s))

    return {
        "MASK": mask(limits.watched),
        "DAMP": mask(limits.damp),
        "LEVELS": limits.stop_level | limits.driver_level << 1,
        "CURRENT": min(full, _below(limits.current_a / sensor.full_scale_a * unity * full)),
        "RANGE": sensor.range_word(unity) - 1,
        "STUCK": limits.stuck_samples,
        "ZERO": round(limits.zero_a * 2**CURRENT_Q),
        "ZERO_TICKS": ticks(limits.zero_s),
        "LOST": round(2 * limits.lost_v / s * 2**WAVE_Q),
        "LOST_TICKS": ticks(limits.lost_s),
        "HOST": ticks(limits.host_s),
        "BUS_MIN": round(limits.bus_min_v * 2**formats.BUS_Q),
        "BUS_MAX": round(limits.bus_max_v * 2**formats.BUS_Q),
        "HEAT_TICKS": ticks(limits.winding_s / HEAT_SQUARES),
        "HEAT": round(limits.rms_a**2 * 2**HEAT_Q),
        "ENERGY": min(
            math.ceil(limits.energy / formats.ENERGY_LIMIT.step), formats.ENERGY_LIMIT.raw_max
        ),
        "SATURATED": min(
            ticks(limits.saturated_s) if limits.saturated_s else 0,
            FIELDS["SATURATED"].fixed.raw_max,
        ),
    }


def _below(sample: float) -> int:
    """Largest sample below this one, so that a sample of a limit's magnitude is beyond it."""
    return math.ceil(round(sample, 6)) - 1


def trip_word(trip_a: float, sensor: Sensor) -> int:
    """The word ``trip`` for a current: of 2¹⁵, whatever the sample of full scale is."""
    return round(trip_a / sensor.full_scale_a * (1 << (formats.SAMPLE_W - 1)))


def motion_words(scene: Scene, ports: Ports) -> dict[str, int]:
    """Words of the scene's limits of speed and position; those without a limit are left out.

    :class:`SceneError` where counts can't tell the speed, or the rotor starts outside.
    """
    words: dict[str, int] = {}
    if scene.guard is None:
        return words
    cell_rad, start = ports.settings.cell_rad, ports.start_count
    if scene.guard.overspeed_rad_s:
        step_rad_s = cell_rad / (SPAN * ports.timing.tick_s)
        limit = scene.guard.overspeed_rad_s / step_rad_s
        most = WORDS["overspeed"].fixed.raw_max
        if not 1.0 <= limit <= most:
            raise scene.refusal(
                f"guard.overspeed_rad_s = {scene.guard.overspeed_rad_s:g}: a speed is counted in "
                f"{SPAN} control periods, of which a count is {step_rad_s:.4g} rad/s; give "
                f"{step_rad_s:.4g} to {most * step_rad_s:.4g}, or 0 for no check",
                "guard.overspeed_rad_s",
            )
        # The next count above, so that no lower speed is a fault; a part in 1e9 is the floats'.
        words["overspeed"] = math.ceil(limit - 1e-9)
    if scene.guard.window_rad is not None:
        low, high = (round(edge / cell_rad) for edge in scene.guard.window_rad)
        if not low <= start < high:
            raise scene.refusal(
                f"guard.window_rad: the rotor starts at {start * cell_rad:.4g} rad, outside of it; "
                "make it wider",
                "guard.window_rad",
            )
        words |= {"window_low": low - start, "window_high": high - 1 - start}
        for name, word in words.items():
            if not WORDS[name].fixed.holds(word):
                raise scene.refusal(
                    f"guard.window_rad is more than {name} has counts for; make it narrower",
                    "guard.window_rad",
                )
    return words


def scene_words(scene: Scene, ports: Ports) -> dict[str, int]:
    """Words of the scene's ``[guard]``, with which ``wh_guard`` does what a board does.

    On a board that has none, the switch takes the gates off for :data:`SWITCH_FAULTS`.
    """
    assert scene.guard is not None
    limits = board_limits(scene, ports, scene.guard.trip_a)
    watched = SWITCH_FAULTS + (limits.watched if scene.guard.watch else ())
    time = ports.timing
    fields = raw_fields(
        limits._replace(watched=watched), time.tick_s, ports.sensor, ports.settings.s,
        time.frame.unity,
    )  # fmt: skip
    words = {FIELDS[name].name: raw for name, raw in fields.items()}
    words |= motion_words(scene, ports)
    return words | {"trip": trip_word(scene.guard.trip_a, ports.sensor)}
