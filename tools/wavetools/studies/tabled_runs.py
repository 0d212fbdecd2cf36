# SPDX-License-Identifier: Apache-2.0
"""Runs whose numbers the pages of drive, environments, brushless motors and surfaces show.

``make tables`` runs them all and keeps the metrics that are shown.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from wavehaptics.ladder.run import measure
from wavehaptics.runtime.files import write_json
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.studies import impedance

from wavetools.studies import gallery, surfaces

KEPT_METRICS = (
    "torque_nrmse_vs_analog",
    "stiffness",
    "stiffness_predicted",
    "peak_torque",
    "free_space_torque_rms",
    "energy_out_max_j",
    "current_ripple_a",
    "hold_error",
)

_TAPS = ("paper_taps", ("drive.bus_v=12", "scene.duration_s=0.5"))
_HOLD = ("press_hold", ("drive.bus_v=12", "scene.duration_s=0.5"))
_AT_80_MHZ = ("drive.pwm_hz=500e3", "controller.clock_hz=80e6")
_DEAD = ("drive.dead_time_s=50e-9",)
_BLIND = ("drive.compensate=false",)
_NOISE = ("adc.bits=12", "adc.full_scale_a=2.5", "adc.noise_a=1.2e-3")
_LOW = ("drive.bus_actual_v=9.5", "drive.bus_ripple_v=0.5", "drive.bus_ripple_hz=100")

Settings = tuple[str, ...]

PINS_RUNS: dict[str, dict[str, tuple[tuple[str, Settings], Settings]]] = {
    "dead-time": {
        "no dead time": (_TAPS, _AT_80_MHZ),
        "50 ns, compensated": (_TAPS, _AT_80_MHZ + _DEAD),
        "the same, 12-bit ADC with 1 LSB of noise": (_TAPS, _AT_80_MHZ + _DEAD + _NOISE),
        "50 ns, `drive.compensate = false`": (_TAPS, _AT_80_MHZ + _DEAD + _BLIND),
    },
    "dead-time-held": {
        "no dead time": (_HOLD, _AT_80_MHZ),
        "50 ns, compensated": (_HOLD, _AT_80_MHZ + _DEAD),
        "50 ns, `drive.compensate = false`": (_HOLD, _AT_80_MHZ + _DEAD + _BLIND),
    },
    "modes": {
        mode: (_TAPS, ("controller.clock_hz=100e6", f"drive.mode={mode}"))
        for mode in ("unipolar", "locked-anti-phase", "sign-magnitude", "half-bridge")
    },
    "bus": {
        "12 V": (_TAPS, ()),
        "9.5 ± 0.5 V, taken for 12 V": (_TAPS, _LOW),
        "9.5 ± 0.5 V, measured": (_TAPS, (*_LOW, "drive.bus_measured=true")),
    },
    "carriers": {
        f"{hertz / 1e3:g}": (_TAPS, (f"drive.pwm_hz={hertz:g}",))
        for hertz in (500e3, 100e3, 50e3, 20e3)
    },
}
"""Runs on ``pins`` by table and row: scene with settings, and further settings."""

R_HAT_PARTS = (-1e-3, 0.0, 0.5e-3, 1e-3)
"""Errors of R̂ with which the paper's taps run on ``analog``."""

IMPEDANCE_SCENES = (
    "stiffest", "damped", "spring_damper", "soft_layer", "resonance", "mass"
)  # fmt: skip
"""Scenes whose impedance is swept."""


BRUSHLESS_ANGLES = 8
"""Electrical angles, of a turn, at which the brushless taps meet their wall."""
BRUSHLESS_ON = ("analog", "golden", "pins")
"""On these controllers."""


def brushless_angles(progress: Callable[[str, float], None]) -> list[dict[str, Any]]:
    """K of a brushless motor's first tap with its magnets at each of the angles."""
    rows = []
    pairs = load_scene(find_scene("brushless_taps")).motor.pole_pairs
    assert pairs is not None
    for n in range(BRUSHLESS_ANGLES):
        progress("a brushless motor's wall", n / BRUSHLESS_ANGLES)
        part = n / BRUSHLESS_ANGLES
        magnet_rad = -2.0 * math.pi * part / pairs
        settings = ("scene.duration_s=0.3", f"motor.magnet_rad={magnet_rad:.12g}")
        scene = load_scene(find_scene("brushless_taps"), settings)
        found = {name: measure(scene, name, compare=name != "analog") for name in BRUSHLESS_ON}
        rows.append(
            {"turn": part, "predicted": found["golden"]["stiffness_predicted"]}
            | {name: found[name]["stiffness"] for name in BRUSHLESS_ON}
            | {"error": found["golden"]["torque_nrmse_vs_analog"]}
            | {"pins_error": found["pins"]["torque_nrmse_vs_analog"]}
        )
    return rows


HELD_ON = ("golden", "pins")
"""Controllers on which a brushless motor's wall is held at each of the angles."""


def brushless_held(progress: Callable[[str, float], None]) -> list[dict[str, Any]]:
    """How far a brushless motor's held wall is off with everything wrong, at each of the angles.

    What is wrong is ``brushless_hold``'s; the magnets' angle is off by as much everywhere.
    """
    rows = []
    base = load_scene(find_scene("brushless_hold"))
    pairs, encoder = base.motor.pole_pairs, base.encoder
    assert pairs is not None
    assert encoder is not None
    cell = 2.0 * math.pi / encoder.counts_per_rev
    wrong = base.controller.magnet_hat_rad - base.motor.magnet_rad
    for n in range(BRUSHLESS_ANGLES):
        progress("a brushless motor's held wall", n / BRUSHLESS_ANGLES)
        part = n / BRUSHLESS_ANGLES
        magnet_rad = -2.0 * math.pi * part / pairs
        settings = (
            "scene.duration_s=0.5",
            f"motor.magnet_rad={magnet_rad:.12g}",
            f"controller.magnet_hat_rad={magnet_rad + wrong:.12g}",
        )
        scene = load_scene(find_scene("brushless_hold"), settings)
        row: dict[str, Any] = {"turn": part}
        for name in HELD_ON:
            found = measure(scene, name, compare=False)
            row[f"{name}_cells"] = found["hold_offset_rad"] / cell
            row[f"{name}_ripple"] = found["hold_ripple_rms"]
        rows.append(row)
    return rows


def collect(out: Path, progress: Callable[[str, float], None]) -> Path:
    """Run them all and write ``tables.json`` into ``out``; its path."""
    rows = []
    for table, runs in PINS_RUNS.items():
        for label, ((scene, settings), further) in runs.items():
            told = f"{table}: {label}"
            loaded = load_scene(find_scene(scene), (*settings, *further))
            found = measure(loaded, "pins", progress=partial(progress, told))
            rows.append(
                {"table": table, "row": label, "tick_s": found["duration_s"] / found["ticks"]}
                | {key: found[key] for key in KEPT_METRICS}
            )
    taps = load_scene(find_scene("paper_taps"))
    off: list[dict[str, Any]] = []
    for part in R_HAT_PARTS:
        setting = f"controller.r_hat={taps.motor.R_ohm * (1.0 + part):.9g}"
        loaded = load_scene(find_scene("paper_taps"), ("scene.duration_s=0.5", setting))
        progress("the paper's taps, R̂ off", len(off) / len(R_HAT_PARTS))
        found = measure(loaded, "analog", compare=False)
        off.append({"part": part} | {key: found[key] for key in ("stiffness", "peak_torque")})
    swept = []
    for name in IMPEDANCE_SCENES:
        told = f"impedance: {name}"
        heard = impedance.measure(load_scene(find_scene(name)), progress=partial(progress, told))
        swept.append({"scene": name, "error_max": float(heard.errors.max())})
    gallery.draw(out, progress)
    return write_json(
        out / "tables.json",
        {
            "runs": rows,
            "r_hat": off,
            "impedance": swept,
            "brushless": brushless_angles(progress),
            "brushless_held": brushless_held(progress),
            "surfaces": surfaces.collect(out, progress),
            "surfaces_beside": surfaces.beside(progress),
            "surfaces_map": surfaces.stiffness_map(progress),
        },
    )
