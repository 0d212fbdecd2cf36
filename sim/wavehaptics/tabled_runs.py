# SPDX-License-Identifier: Apache-2.0
"""Runs whose numbers the pages of the drive and of the environments show, a row each.

``make tables`` runs them all and keeps the metrics that are shown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from wavehaptics import impedance, physics, pictures
from wavehaptics.metrics import write_metrics
from wavehaptics.report.blocks import number, percent
from wavehaptics.run import measure
from wavehaptics.scene import find_scene, first_comment, load_scene

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


def collect(out: Path, progress: Callable[[str, float], None]) -> Path:
    """Run them all and write ``tables.json`` into ``out``; its path."""
    rows = []
    for table, runs in PINS_RUNS.items():
        for label, ((scene, settings), further) in runs.items():
            told = f"{table}: {label}"
            loaded = load_scene(find_scene(scene), (*settings, *further))
            found = measure(loaded, "pins", progress=lambda part, told=told: progress(told, part))
            rows.append(
                {"table": table, "row": label, "tick_s": found["duration_s"] / found["ticks"]}
                | {key: found[key] for key in KEPT_METRICS}
            )
    taps = load_scene(find_scene("paper_taps"))
    off = []
    for part in R_HAT_PARTS:
        setting = f"controller.r_hat={taps.motor.R_ohm * (1.0 + part):.9g}"
        loaded = load_scene(find_scene("paper_taps"), ("scene.duration_s=0.5", setting))
        progress("the paper's taps, R̂ off", len(off) / len(R_HAT_PARTS))
        found = measure(loaded, "analog", compare=False)
        off.append({"part": part} | {key: found[key] for key in ("stiffness", "peak_torque")})
    swept = []
    for name in IMPEDANCE_SCENES:
        told = f"impedance: {name}"
        found = impedance.measure(
            load_scene(find_scene(name)), progress=lambda part, told=told: progress(told, part)
        )
        swept.append({"scene": name, "error_max": float(found.errors.max())})
    return write_metrics({"runs": rows, "r_hat": off, "impedance": swept}, out / "tables.json")


def of_tables(found: dict[str, Any]) -> dict[str, Any]:
    """What is kept of ``tables.json``: all of it."""
    return found


# ---- The tables.

Table = Callable[[Iterable[str], Iterable[Iterable[object]]], str]
_NO_WALL = 0.1
"""A stiffness below this part of the predicted one is no wall."""


def _rows(numbers: dict[str, Any], table: str) -> list[dict[str, Any]]:
    return [row for row in numbers.get("tables", {}).get("runs", ()) if row["table"] == table]


def _stiffness(row: dict[str, Any]) -> str:
    if row["stiffness"] is None:
        return "–"
    return f"{row['stiffness'] / row['stiffness_predicted']:.3f}"


def _error(row: dict[str, Any]) -> str:
    part = (row["stiffness"] or 0.0) / row["stiffness_predicted"]
    return "no wall" if part < _NO_WALL else number(row["torque_nrmse_vs_analog"], 2)


def _held(error: float | None) -> str:
    return "no wall" if error is None or abs(error) > 1.0 - _NO_WALL else percent(error)


def _dead_time(numbers: dict[str, Any], table: Table) -> str:
    held = {row["row"]: _held(row["hold_error"]) for row in _rows(numbers, "dead-time-held")}
    head = ("", "torque error against `analog`", "stiffness over predicted",
            "torque in free space, RMS, µN·m", "held torque off")  # fmt: skip
    rows = [
        (row["row"], _error(row), _stiffness(row),
         number(1e6 * row["free_space_torque_rms"], 2), held.get(row["row"], "–"))
        for row in _rows(numbers, "dead-time")
    ]  # fmt: skip
    return table(head, rows)


_SWITCHING = {
    "unipolar": "both, in turn",
    "locked-anti-phase": "both, opposite",
    "sign-magnitude": "one",
    "half-bridge": "the only one",
}


def _modes(numbers: dict[str, Any], table: Table) -> str:
    head = ("", "legs that switch", "torque error against `analog`",
            "torque in free space, RMS, µN·m")  # fmt: skip
    return table(
        head,
        (
            (f"`{row['row']}`", _SWITCHING[row["row"]], _error(row),
             number(1e6 * row["free_space_torque_rms"], 2))
            for row in _rows(numbers, "modes")
        ),
    )  # fmt: skip


def _bus(numbers: dict[str, Any], table: Table) -> str:
    head = ("bus", "torque error against `analog`", "stiffness over predicted",
            "peak torque, mN·m", "energy out, J")  # fmt: skip
    return table(
        head,
        (
            (row["row"], _error(row), _stiffness(row), number(1e3 * row["peak_torque"], 3),
             number(row["energy_out_max_j"], 1))
            for row in _rows(numbers, "bus")
        ),
    )  # fmt: skip


def _carriers(numbers: dict[str, Any], table: Table) -> str:
    head = ("carrier, kHz", "tick, µs", "torque error against `analog`",
            "stiffness over predicted", "ripple of the current, mA")  # fmt: skip
    return table(
        head,
        (
            (row["row"], number(1e6 * row["tick_s"], 3), _error(row), _stiffness(row),
             number(1e3 * row["current_ripple_a"], 2))
            for row in _rows(numbers, "carriers")
        ),
    )  # fmt: skip


def _prototype(numbers: dict[str, Any], table: Table) -> str:
    """The stiffness of the paper's wall: its parts, the whole, and what R̂ makes of it."""
    scene = load_scene(find_scene("paper_taps"))
    motor, lambda_ = scene.motor, scene.controller.lambda_
    k_l = physics.k_l(motor.k_t, motor.L_h)
    twice = physics.filter_stiffness(motor.k_t, motor.R_ohm, lambda_)
    rows = [
        ("K_L, the inductor's", k_l),
        ("the filter's as (14) prints it", twice / 2),
        ("the filter's with the factor 2", twice),
        ("both in series, as printed", 1 / (1 / k_l + 2 / twice)),
        ("both in series, with the factor 2", 1 / (1 / k_l + 1 / twice)),
    ]
    rows += [
        (f"taps on `analog`, R̂ {percent(row['part'], 1)} off" if row["part"] else
         "taps on `analog`, R̂ = R", row["stiffness"])
        for row in numbers.get("tables", {}).get("r_hat", ())
    ]  # fmt: skip
    rows.append(("what the prototype measured", pictures.PAPER_MEASURED))
    head = ("stiffness", "N·m/rad", "over K_L")
    return table(head, ((what, number(k, 3), number(k / k_l, 2)) for what, k in rows))


def _impedance(numbers: dict[str, Any], table: Table) -> str:
    head = ("scene", "what it is", "largest error")
    return table(
        head,
        (
            (f"`{row['scene']}`", first_comment(find_scene(row["scene"])),
             percent(row["error_max"]))
            for row in numbers.get("tables", {}).get("impedance", ())
        ),
    )  # fmt: skip


TABLES = {
    "dead-time": _dead_time,
    "modes": _modes,
    "bus": _bus,
    "carriers": _carriers,
    "impedances": _impedance,
    "prototype": _prototype,
}
"""Tables of Markdown by marker, made with the given function of head and rows."""
