# SPDX-License-Identifier: Apache-2.0
"""What the ports of the whole RTL are given for a scene, as raw words."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wavehaptics.controller import bus_scale
from wavehaptics.controller.modulator import width_bounds
from wavehaptics.controller.settings import Settings, settings
from wavehaptics.controller.tick_layout import (
    MOST_SAMPLES,
    FrameAt,
    Timing,
    bridge_mode,
    dead_clocks,
    pulse_delay,
    sample_lead,
    scene_frame,
    timing,
)
from wavehaptics.motor.hand import hand_path
from wavehaptics.motor.sensor import Sensor
from wavehaptics.scene import Scene
from wavehaptics.scene.tables.drive import THREE_PHASE_REACH
from wavehaptics.words import formats, table
from wavehaptics.words.bridge_modes import MODE_WORDS, UNIPOLAR
from wavehaptics.words.table import WORDS

BRUSHLESS_KIND = "serial"
"""Kind of the converters of a brushless motor's phases."""

DEFAULT_BUS_V = 12.0
"""Bus of a scene whose drive has no limit; a switching bridge has to have one."""

FINE_COUNTS_PER_REV = 65_536
"""Encoder where the scene has none: A and B must come from somewhere."""

HOST_CLOCKS = 150
"""Least clocks of a period of ``rtl/wh_host_link.v``, which works so long at its end."""

MOST_WALLS = 7
"""Of a motor in ``rtl/wh_ports.v``."""

SIDE_NOISE = 4.0
"""Standard deviations of a sample that a leg's side must not hang on."""

SETTLE_TICKS = 5
"""Ticks between two changes of side of the dead-time compensation, besides the scene's latency."""


@dataclass(frozen=True)
class Ports:
    """What the ports of ``rtl/wh_controller.v``, or of ``rtl/wh_ports.v``, are given for a scene.

    ``words`` are settings by their names in ``rtl/words.toml``, those that aren't its defaults;
    ``walls`` are (min, max) in counts from where the rotor starts. All are raw words.
    """

    timing: Timing
    settings: Settings
    sensor: Sensor
    start_count: int
    words: dict[str, int]
    walls: list[tuple[int, int]]

    def wall_words(self, places: int, motors: int = 1) -> dict[str, list[int]]:
        """The walls' words, the same for each motor; the ``places`` beyond them are empty."""
        walls = [*self.walls, *[(0, 0)] * (places - len(self.walls))] * motors
        shaped = self.settings.shaped.tolist()
        return {
            "wall_min": [low for low, _ in walls],
            "wall_max": [high for _, high in walls],
            "wall_enable": [int(low < high) for low, high in walls],
            "wall_shaped": [*shaped, *[0] * (places - len(shaped))] * motors,
        }


def controller_ports(
    scene: Scene, frame_at: FrameAt | None = None, most_samples: int = MOST_SAMPLES,
    turns: int = 0, most_sections: int = 0, surfaces: int = 0,
) -> Ports:  # fmt: skip
    """Settings of the whole RTL for a scene; :class:`SceneError` where it can't do it.

    ``frame_at`` takes the place of the scene's ADC, for a board that has its own. The scene's is
    one of so many motors that take ``turns`` (:func:`wavehaptics.controller.tick_layout.timing`),
    whose W have ``most_sections``, and across which there are so many ``surfaces``.
    """
    walls = len(scene.controller.walls)
    most, where = table.MOST["wall"], "the whole RTL"
    if scene.motor.brushless:
        most, where = MOST_WALLS, "a brushless motor"
    elif turns:
        most, where = MOST_WALLS, "each of several motors" if turns > 1 else "a motor on a device"
    if walls > most:
        raise scene.refusal(
            f"controller.walls has {walls} walls, and {where} takes {most}; "
            "leave some out or take `golden`",
            "controller.walls",
        )
    if turns and scene.drive is not None and scene.drive.bus_measured:
        cure = "run each with --motor" if turns > 1 else "`run` the scene"
        raise scene.refusal(
            f"drive.bus_measured is for a single motor on `pins`; set it to false, or {cure}",
            "drive.bus_measured",
        )
    sensor = Sensor.of_scene(scene)
    if sensor.ideal:
        sensor = _fine_sensor(scene)
    cell_rad = None if scene.encoder else 2 * math.pi / FINE_COUNTS_PER_REV
    time = timing(
        scene, frame_at or scene_frame(scene), most_samples, turns, most_sections, surfaces
    )
    bus_v = bus_voltage(scene)
    if scene.motor.brushless and time.frame.kind != BRUSHLESS_KIND:
        raise scene.refusal(
            f"adc.part = {scene.adc and scene.adc.part}: the phases of a "
            "brushless motor have two serial converters yet; take one of those, such as AD7276",
            "adc.part",
        )
    controller = scene.controller.model_copy(update={"extra_ticks": time.extra_ticks})
    scene = scene.model_copy(update={"controller": controller})
    shortest = _min_pulse(scene, time)
    # What the pulse is longer by and what a leg's shortest pulse takes, the voltage can't have.
    _, spare = width_bounds(bridge_mode(scene), shortest)
    dead = _dead_time_words(scene, time, bus_v, sensor, time.half_clocks // 2 - spare)
    delay = pulse_delay(scene, time.clock_hz, time.half_clocks)
    # What a leg reaches makes clocks of volts; what the motor does, the limit.
    reach_v = leg_v = bus_v * (scene.drive.reach if scene.drive else 1.0)
    if scene.motor.brushless:
        reach_v, leg_v = bus_v * THREE_PHASE_REACH, 0.5 * bus_v
    lost = (dead["dead_clocks"] if dead["compensate"] else 0) + 2 * spare
    set_ = settings(scene, time.tick_s, cell_rad, reach_v * (1.0 - lost / time.half_clocks))
    start_count = math.floor(hand_path(scene).x0 / set_.cell_rad)
    per_volt = time.half_clocks / (2 * leg_v)
    if per_volt > formats.DUTY.largest:
        raise scene.refusal(
            f"a volt at a bus of {leg_v:g} V is {per_volt:g} clocks of the "
            f"pulse, and `pins` counts {formats.DUTY.largest:.0f}; take a faster drive.pwm_hz or a "
            "higher drive.bus_v",
            "drive.pwm_hz",
            "drive.bus_v",
        )
    words = {
        "half_clocks": time.half_clocks,
        "tick_halves": time.tick_halves,
        "sample_clocks": time.sample_clocks,
        "samples": time.samples,
        "sample_lead": sample_lead(time.frame, delay // 2),
        "sample_late": 0 if time.frame.osr else delay % 2,
        **time.frame.words(),
        "gain": sensor.gain_word(time.samples * time.frame.unity),
        "range": sensor.range_word(time.frame.unity),
        "eta_contact": set_.eta_contact,
        "eta_free": set_.eta_free,
        "root": set_.root,
        "a": set_.a,
        "u_max": set_.u_max,
        "extra_ticks": set_.extra_ticks,
        "hold_ticks": time.hold_ticks,
        "mode": MODE_WORDS[bridge_mode(scene)],
        "min_pulse": shortest,
        "clocks_per_volt": formats.DUTY.to_raw(per_volt),
        "bus_share": bus_scale.bus_share_word(
            set_.limit_v, reach_v / bus_v * (1.0 - lost / time.half_clocks)
        ),
        **dead,
        **_host_words(scene, time),
    }
    return Ports(time, set_, sensor, start_count, words, _port_walls(set_, start_count))


def _min_pulse(scene: Scene, time: Timing) -> int:
    """Clocks that a leg stays, so that its gate is on for the scene's time after the dead time."""
    if not scene.drive or not scene.drive.min_pulse_s:
        return 0
    # A gate is on for a whole clock or not at all: no rule is needed where that is long enough,
    # with as much again for what the way to the gate takes from it.
    if 2 * scene.drive.min_pulse_s * time.clock_hz <= 1.0:
        return 0
    # A part in 1e9 of a clock is the floats'.
    clocks = math.ceil(scene.drive.min_pulse_s * time.clock_hz - 1e-9)
    clocks += dead_clocks(scene, time.clock_hz)
    most = min(WORDS["min_pulse"].fixed.raw_max, time.half_clocks // 4)
    if clocks > most:
        raise scene.refusal(
            f"drive.min_pulse_s = {scene.drive.min_pulse_s:g} s and the dead "
            f"time are {clocks} clocks of `pins`, of which a carrier half of {time.half_clocks} "
            f"has room for {most}; take a slower drive.pwm_hz or a shorter min_pulse_s",
            "drive.min_pulse_s",
            "drive.pwm_hz",
        )
    return clocks


def _host_words(scene: Scene, time: Timing) -> dict[str, int]:
    """Words of the link to a host, ``rtl/wh_host_link.v``, where the scene has one."""
    if scene.host is None:
        return {}
    tick_hz = 1.0 / time.tick_s
    log2 = round(math.log2(tick_hz / scene.host.rate_hz))
    most = WORDS["host_period_log2"].fixed.raw_max
    clocks = time.tick_clocks * 2.0**log2
    if not 0 <= log2 <= most or clocks < HOST_CLOCKS:
        raise scene.refusal(
            f"host.rate_hz = {scene.host.rate_hz:g}: a period is 1 to "
            f"{1 << most} ticks and {HOST_CLOCKS} clocks at least, which is "
            f"{tick_hz / (1 << most):g} to "
            f"{min(tick_hz, time.clock_hz / HOST_CLOCKS):g} Hz here",
            "host.rate_hz",
            "controller.tick_hz",
        )
    return {"host_period_log2": log2, "host_timeout": scene.host.timeout}


def _dead_time_words(
    scene: Scene, time: Timing, bus_v: float, sensor: Sensor, widest: int
) -> dict[str, int]:  # fmt: skip
    """Words of the dead time and of its compensation, ``rtl/wh_dead_time.v``.

    ``widest`` is the longest half pulse in clocks, beyond which nothing is compensated.
    """
    clocks = dead_clocks(scene, time.clock_hz)
    if clocks >= time.half_clocks:
        raise scene.refusal(
            f"drive.dead_time_s is {clocks} clocks of `pins`, as long as a "
            f"carrier half of {time.half_clocks}; take a shorter one or a slower drive.pwm_hz",
            "drive.dead_time_s",
            "drive.pwm_hz",
        )
    compensate = clocks > 0 and scene.drive is not None and scene.drive.compensate
    if compensate and bridge_mode(scene) != UNIPOLAR and not scene.motor.brushless:
        raise scene.refusal(
            f"drive.compensate: what dead time takes depends on the ripple in "
            f"the mode {bridge_mode(scene)}, and can't be made good; set drive.compensate = false "
            "or take drive.mode = unipolar",
            "drive.compensate",
            "drive.mode",
            "drive.dead_time_s",
        )
    if compensate and 5 * clocks >= 8 * widest:
        raise scene.refusal(
            f"drive.compensate: a dead time of {clocks} clocks of `pins` makes a half pulse up to "
            f"{5 * clocks / 8:g} clocks longer, and the longest has {widest}; take a shorter "
            "dead_time_s, a slower drive.pwm_hz or set drive.compensate = false",
            "drive.dead_time_s",
            "drive.compensate",
            "drive.pwm_hz",
        )
    # Half the current that one dead time's voltage changes.
    side_a = 0.5 * bus_v * clocks / time.clock_hz / scene.controller.l_hat
    if compensate and scene.motor.brushless:
        _check_sides(scene, side_a, sensor)
    return {
        "dead_clocks": clocks,
        "compensate": int(compensate),
        "side_current": formats.CURRENT.to_raw(min(side_a, 0.5 * formats.CURRENT.largest)),
        "settle_ticks": min(
            WORDS["settle_ticks"].fixed.raw_max, scene.controller.extra_ticks + SETTLE_TICKS
        ),
    }


def _check_sides(scene: Scene, side_a: float, sensor: Sensor) -> None:
    """:class:`SceneError` where the ADC can't tell on which side a leg's current is.

    Three legs that are mistaken hold each other, and the wall leaks away. Two legs in series can't.
    """
    step_a = sensor.full_scale_a / (1 << (sensor.bits - 1))
    error_a = step_a + SIDE_NOISE * sensor.noise_a + abs(sensor.offset_a)
    if error_a > side_a:
        raise scene.refusal(
            f"drive.compensate: the ADC's step, noise and offset are "
            f"{error_a:.2g} A, and half of what a dead time moves a leg's current by is "
            f"{side_a:.2g} A, too little to tell its side; take a finer adc or set "
            "drive.compensate = false",
            "drive.compensate",
            "drive.dead_time_s",
            "adc",
        )


def bus_voltage(scene: Scene) -> float:
    """Bus of the scene's bridge, V."""
    drive = scene.drive
    return DEFAULT_BUS_V if drive is None or drive.bus_v is None else drive.bus_v


def _fine_sensor(scene: Scene) -> Sensor:
    """The finest ADC that the reader takes, for a scene without one: 16 bits.

    Its scale is twice what drives through R̂, or through what the waves take for it if that is less.
    """
    set_ = settings(scene)
    largest = 2 * min(set_.limit_v, bus_voltage(scene)) / min(scene.controller.r_hat, set_.r_hat)
    return Sensor(ideal=False, full_scale_a=min(largest, 0.99 * formats.CURRENT.largest))


def _port_walls(set_: Settings, start_count: int) -> list[tuple[int, int]]:
    """Walls in the RTL's own counts, which begin at 0 where the rotor starts."""
    low, high = -(1 << (formats.COUNT_W - 1)), (1 << (formats.COUNT_W - 1)) - 1
    walls = []
    for wall_min, wall_max in zip(set_.wall_min.tolist(), set_.wall_max.tolist(), strict=True):
        walls.append((max(low, wall_min - start_count), min(high, wall_max - start_count)))
    return walls
