# SPDX-License-Identifier: Apache-2.0
"""What a motor, encoder, ADC and bridge can render: carrier, stiffest λ, limits of force, hold.

Every number is a closed form of the project at the settings that the whole RTL has for the scene,
or of a short run on ``golden``. The settings it recommends are overrides of the scene, so that
``wavehaptics run`` with them is the same scene.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from wavehaptics.controller.ports import Ports, controller_ports
from wavehaptics.controller.settings import settings
from wavehaptics.ladder.design_spring import rendered_stiffness
from wavehaptics.ladder.ranges import range_a
from wavehaptics.ladder.run import measure
from wavehaptics.laws.closed_forms import MOST_A, b_r, k_l, matched_a
from wavehaptics.parts.sensing import SensingPart, sensing_parts
from wavehaptics.scene import Scene, SceneError, device_of
from wavehaptics.scene.keys import unknown_choice
from wavehaptics.scene.tables.hand import Hand
from wavehaptics.studies.stability import largest_stiffness, with_stiffness
from wavehaptics.trace.metrics import LEAST_COUNTS
from wavehaptics.words import formats

CARRIERS_HZ = (1e6, 500e3, 400e3, 250e3, 100e3)
"""Carriers that are compared."""

HAND_STIFFNESS, HAND_DAMPING = 0.1, 0.5e-3
"""A light finger's, where the scene has no hand with a spring, N·m/rad and N·m·s/rad."""

PRESS_PART = 0.5
"""Part of the first limit's torque with which the wall is pressed."""

PRESS_S = 0.6
"""Simulated press, s; the last tenth is the hold."""

Progress = Callable[[str, float], None]


def tune(
    path: Path, content: bytes, overrides: Sequence[str] = (), motor: str | None = None,
    sensor: str | None = None, progress: Progress = lambda stage, part: None,
) -> dict[str, Any]:  # fmt: skip
    """What the scene's motor can render, as plain values; its keys say what they are, in SI units.

    ``sensor`` is a part of ``boards/sensing.toml`` in place of what ``[adc]`` says of edges.
    :class:`SceneError` where the whole RTL can't do the scene at any carrier.
    """

    def made(settings_: Sequence[str]) -> Scene:
        device = device_of(content, path, [*overrides, *settings_])
        return (device if motor is None else device.only(motor)).one("choose it with --motor NAME")

    scene = made(())
    part = _part(scene, sensor)
    carriers = [_at_carrier(made, part, hertz) for hertz in _carriers(scene)]
    usable = [row for row in carriers if row["refusal"] is None]
    if not usable:
        raise SceneError(f"{path}: no carrier can be had: {carriers[0]['refusal']}")
    best = max(usable, key=lambda row: row["stiffness"])
    chosen = list(best["settings"])

    progress("the stiffest stable wall", 0.0)
    asked = made(chosen)
    tried = pressed(
        for_golden(asked), PRESS_PART * _forces(asked, controller_ports(asked))[0]["torque"]
    )
    stable, stiffest = largest_stiffness(tried, "golden")
    if stable is not None and not stiffest:
        lambda_ = with_stiffness(tried, "golden", stable).controller.lambda_
        chosen[-1] = f"controller.lambda={lambda_:.6g}"
    recommended = made(chosen)
    ports = controller_ports(recommended)
    predicted = spring(recommended)
    forces = _forces(recommended, ports)
    first = forces[0]
    counts = recommended.encoder.counts_per_rev if recommended.encoder else None

    progress("press and hold", 0.5)
    torque = PRESS_PART * first["torque"]
    run = measure(pressed(for_golden(recommended), torque), "golden", compare=False)
    motor_ = recommended.motor
    count_rad = ports.settings.cell_rad
    return {
        "scene": recommended.scene.name,
        "motor": {
            "k_l": k_l(motor_.felt_k_t, motor_.L_h),
            "b_r": b_r(motor_.felt_k_t, motor_.R_ohm),
            "anchored": recommended.controller.anchored,
        },
        "carriers": [{k: v for k, v in row.items() if k != "settings"} for row in carriers],
        "best": {
            "carrier_hz": best["carrier_hz"],
            "tick_hz": 1.0 / ports.timing.tick_s,
            "clock_hz": ports.timing.clock_hz,
            "extra_ticks": ports.timing.extra_ticks,
            "lambda": recommended.controller.lambda_,
            "a": _a(recommended),
            "settings": [*overrides, *chosen],
        },
        "wall": {
            "stable": stable is not None,
            "stiffness_predicted": predicted,
            "stiffness": run["stiffness"],
            "of_k_l": predicted / k_l(motor_.felt_k_t, motor_.L_h),
            "limit": _stiffness_limit(stable, stiffest),
        },
        "forces": forces,
        "first_limit": first["name"],
        "encoder": {
            "counts_per_rev": counts,
            "counts_needed": math.ceil(
                LEAST_COUNTS * 2.0 * math.pi * predicted / first["torque"]
            ),
            "count_torque": predicted * count_rad if counts else None,
        },
        "hold": {
            "pressed_with": torque,
            "torque": run["hold_torque"],
            "offset_rad": run["hold_offset_rad"],
            "offset_counts": _over(run["hold_offset_rad"], count_rad) if counts else None,
            "ripple_rms": run["hold_ripple_rms"],
            "saturated_fraction": run["saturated_fraction"],
            "reason": run["reasons"].get("hold_error"),
        },
    }  # fmt: skip


def _over(value: float | None, unit: float) -> float | None:
    return None if value is None else value / unit


def _stiffness_limit(stable: float | None, stiffest: bool) -> str:
    if stable is None:
        return "no wall is stable in this hand"
    return "the delay of the control loop" if stiffest else "stability in this hand"


def _part(scene: Scene, name: str | None) -> SensingPart:
    """The part that senses the current, or one with the edges of the scene's ``[adc]``."""
    parts = sensing_parts()
    if name is not None:
        if name not in parts:
            raise SceneError(f"--sensor {unknown_choice(name, parts)}")
        return parts[name]
    adc = scene.adc
    edges = {
        "hold_s": adc.edge_hold_s, "hold_restarts": adc.edge_hold_restarts,
        "settle_s": adc.edge_settle_s or 0.0,
    } if adc else {}  # fmt: skip
    return SensingPart.model_validate({"what": "[adc]", "sources": ["the scene"], **edges})


def _carriers(scene: Scene) -> list[float]:
    """The scene's own carrier, by default half its rate, and the usual ones."""
    drive = scene.drive
    own = 0.5 * scene.controller.tick_hz if drive is None or not drive.pwm_hz else drive.pwm_hz
    others = [hertz for hertz in CARRIERS_HZ if not math.isclose(hertz, own)]
    return sorted([own, *others], reverse=True)


def _at_carrier(
    made: Callable[[Sequence[str]], Scene], part: SensingPart, hertz: float
) -> dict[str, Any]:
    """The stiffest wall at a carrier, with two periods a carrier's, or one without brushes."""
    row: dict[str, Any] = {"carrier_hz": hertz, "stiffness": None, "refusal": None, "settings": []}
    per_carrier = 1.0 if made(()).motor.brushless else 2.0
    keys = [f"drive.pwm_hz={hertz!r}", f"controller.tick_hz={per_carrier * hertz!r}"]
    try:
        timing = controller_ports(made(keys)).timing
        # λ of a = MOST_A: a larger one has the same wall.
        lambda_ = 1.0 / (timing.tick_s / MOST_A + timing.extra_ticks * timing.tick_s)
        keys = [*keys, f"controller.extra_ticks={timing.extra_ticks}"]
        row["settings"] = [*keys, f"controller.lambda={lambda_:.6g}"]
        scene = made(row["settings"])
        row["refusal"] = part.refusal(hertz, timing.tick_s)
        if controller_ports(scene).timing != timing:
            row["refusal"] = "its carrier doesn't fit into the clock"
        row["stiffness"] = spring(scene)
    except SceneError as error:
        row["refusal"] = str(error)
    return row


def spring(scene: Scene) -> float:
    """K of the rigid wall that the scene's settings render, N·m/rad."""
    set_ = settings(scene)
    return rendered_stiffness(scene, set_.r_hat, set_.tau, -1.0, set_.anchored, None)


def _a(scene: Scene) -> float:
    control = scene.controller
    return matched_a(1.0 / control.tick_hz, control.lambda_, control.extra_ticks)


def _forces(scene: Scene, ports: Ports) -> list[dict[str, Any]]:
    """What ends a wall's torque, the smallest first: name, current in A and torque in N·m."""
    set_, motor = ports.settings, scene.motor
    currents = {
        "the drive's voltage through R": set_.limit_v / motor.R_ohm,
        "the range of the current's ADC": range_a(ports.sensor),
        "the register of the wave v": formats.WAVE.largest / set_.s,
    }
    if scene.guard is not None and scene.guard.trip_a is not None:
        currents["the guard's trip"] = scene.guard.trip_a
    found = [
        {"name": name, "current_a": current, "torque": motor.k_t * current}
        for name, current in currents.items()
    ]
    if motor.brushless and motor.pole_pairs:
        torque = spring(scene) / motor.pole_pairs
        found.append(
            {"name": "the magnets' pull-out", "current_a": torque / motor.k_t, "torque": torque}
        )
    return sorted(found, key=lambda limit: limit["torque"])


def for_golden(scene: Scene) -> Scene:
    """The scene without edges of the bridge, which ``golden`` doesn't have, and without W."""
    adc = scene.adc
    if adc is not None:
        adc = adc.model_copy(update={"edge_hold_s": 0.0, "edge_settle_s": None})
    return scene.model_copy(update={"adc": adc, "shaper": None})


def pressed(scene: Scene, torque: float) -> Scene:
    """The scene with one rigid wall at 0 that its hand presses, in the end with ``torque`` N·m.

    The hand's spring and damper are the scene's, or a light finger's.
    """
    hand, k = scene.hand, spring(scene)
    stiffness = hand.stiffness if hand is not None and hand.stiffness else HAND_STIFFNESS
    finger = Hand(
        path="press",
        amplitude_rad=torque * (1.0 / k + 1.0 / stiffness),
        stiffness=stiffness,
        damping=hand.damping if hand is not None and hand.stiffness else HAND_DAMPING,
    )
    control = scene.controller.model_copy(
        update={"walls": ((0.0, 100.0),), "eta_contact": -1.0, "edge_hysteresis": False}
    )
    general = scene.scene.model_copy(update={"duration_s": PRESS_S})
    return scene.model_copy(update={"hand": finger, "controller": control, "scene": general})
