# SPDX-License-Identifier: Apache-2.0
"""The usual way beside the wave wall of a brushless motor: field-oriented control."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from wavehaptics.controller.pins_timing import turns_latency_clocks
from wavehaptics.ladder.run import measure
from wavehaptics.laws import closed_forms
from wavehaptics.parts.foc_designs import DESIGNS
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene.tables.servo import Servo
from wavehaptics.studies import stability
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.sweeps import Task

TITLE = "The usual way with a brushless motor: field-oriented control"

SCENE = "brushless_wall"
PICTURE = "brushless_walls.png"

PAIRS_HZ = ((20e3, 1e3), (20e3, 20e3), (1e6, 1e6))
"""Rates of current control and servo that are put beside the wave wall."""
RATES_HZ = (20e3, 50e3, 100e3, 200e3, 500e3, 1e6)
QUICK_RATES_HZ = RATES_HZ[::5]
HAND_DAMPING = tuple(1.53e-6 * 10 ** (n / 2) for n in range(7))
QUICK_HAND_DAMPING = HAND_DAMPING[::2]
VISCOUS = 1e-5
WAVE_TICK_HZ = 1e6

SUMMARY = Path("boards", "summary.json")
"""Where the counts of ``make synth`` are kept, from the root."""
OWN_SCENE = "brushless_hold"
"""At its tick and clock the latency of ``wh_ports`` with a brushless motor is told."""

LATENCY_CLOCKS = turns_latency_clocks(0, 1, brushless=True)
"""Of ``wh_ports`` with one brushless motor, from the last ADC bit on."""
PRESSED_AT = 0.9
"""Part of the stiffest wall that is pressed for its ripple."""

Rows = list[tuple[str, ...]]


def limit(controller: str, settings: list[str], halvings: int = 10) -> dict[str, Any]:
    """Largest stiffness of the scene with ``settings``, N·m/rad, and whether that is all it can."""
    scene = load(SCENE, settings)
    stiffness, capped = stability.largest_stiffness(scene, controller, halvings=halvings)
    return {"stiffness": stiffness, "capped": capped}


def wall(controller: str, settings: list[str]) -> dict[str, Any]:
    """The same, and how quiet such a wall is: RMS of a pressed one's torque less its mean, N·m.

    Pressed is a wall of PRESSED_AT of that stiffness, but none stiffer than the stiffest wave wall,
    which is pressed as it is.
    """
    found = limit(controller, settings)
    scene = load(SCENE, settings)
    k = found["stiffness"]
    if not found["capped"]:
        k = min(PRESSED_AT * k, stability.stiffest_wave_wall(scene))
    pressed = measure(stability.with_stiffness(scene, controller, k), controller, compare=False)
    return found | {"pressed_at": k, "ripple": pressed["hold_ripple_rms"]}


def _usual(foc_hz: float, servo_hz: float, tick_hz: float | None = None) -> list[str]:
    settings = [f"servo.foc_hz={foc_hz}", f"servo.rate_hz={servo_hz}"]
    return settings + ([] if tick_hz is None else [f"controller.tick_hz={tick_hz}"])


def _wave(tick_hz: float) -> list[str]:
    return [f"controller.tick_hz={tick_hz}", "controller.lambda=1e9", "controller.extra_ticks=1"]


def _grid(quick: bool) -> list[tuple[str, dict[str, Any], Task]]:
    """Curve, what the point is, and its task."""
    found = []

    def add(curve: str, point: dict[str, Any], controller: str, settings: list[str]) -> None:
        function = wall if curve == "wall" else limit
        task = Task(function, {"controller": controller, "settings": settings})
        found.append((curve, point, task))

    for foc, servo in PAIRS_HZ:
        add("wall", {"foc_hz": foc, "servo_hz": servo}, "encoder", _usual(foc, servo))
    add("wall", {"tick_hz": WAVE_TICK_HZ}, "golden", _wave(WAVE_TICK_HZ))
    for hz in QUICK_RATES_HZ if quick else RATES_HZ:
        tick = max(1e5, hz)  # what nothing needs faster is not stepped faster
        add("rate slow", {"at": hz}, "encoder", _usual(hz, 1e3, tick))
        add("rate", {"at": hz}, "encoder", _usual(hz, hz, tick))
        add("rate wave", {"at": hz}, "golden", _wave(hz))
    for b in QUICK_HAND_DAMPING if quick else HAND_DAMPING:
        hand = [f"hand.damping={b}", f"friction.viscous={VISCOUS}"]
        for foc, servo in PAIRS_HZ:
            tick = max(1e5, foc)
            add(f"hand {foc:g} {servo:g}", {"at": b}, "encoder", _usual(foc, servo, tick) + hand)
        add("hand wave", {"at": b}, "golden", _wave(WAVE_TICK_HZ) + hand)
    return found


def tasks(quick: bool) -> list[Task]:
    return [task for _, _, task in _grid(quick)]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    grid = next(g for g in (_grid(True), _grid(False)) if [task for _, _, task in g] == tasks)
    curves: dict[str, list[dict[str, Any]]] = {}
    for (curve, point, _), result in zip(grid, results, strict=True):
        curves.setdefault(curve, []).append(point | result)
    return {"curves": curves, "resources": _counted()}


def _counted() -> list[dict[str, Any]]:
    """Counts of ``wh_ports`` with one brushless motor, of the last synthesis."""
    path = ROOT / SUMMARY
    kept = json.loads(path.read_bytes()) if path.exists() else {}
    return [row for row in kept.get("resources", ()) if row["table"] == "brushless"]


def _hz(value: float) -> str:
    return f"{value / 1e6:g} MHz" if value >= 1e6 else f"{value / 1e3:g} kHz"


def walls(points: list[dict[str, Any]]) -> tuple[tuple[str, ...], Rows]:
    """Head and rows of the stiffest wall of each way, of the curve ``wall``."""
    wave = next(p for p in points if "tick_hz" in p)
    rows: Rows = []
    for p in points:
        if p is wave:
            name, band = f"wave wall at {_hz(p['tick_hz'])}", "–"
        else:
            name = f"field-oriented control at {_hz(p['foc_hz'])}, servo at {_hz(p['servo_hz'])}"
            band = _hz(float(f"{Servo(foc_hz=p['foc_hz']).field_oriented_hz:.3g}"))
        rows.append(
            (name, band, number(p["stiffness"]), number(wave["stiffness"] / p["stiffness"]),
             number(p["pressed_at"]), number(1e6 * p["ripple"]))
        )  # fmt: skip
    head = (
        "",
        "bandwidth of the current",
        "stiffest stable wall, N·m/rad",
        "wave over it",
        "pressed at, N·m/rad",
        "ripple of its torque, µN·m RMS",
    )
    return head, rows


def beside(resources: list[dict[str, Any]]) -> tuple[tuple[str, ...], Rows]:
    """Head and rows: the controller of this project and what others publish of theirs.

    ``resources`` are the counts of the last synthesis; a dash is what isn't told.
    """
    head = ("", "rate", "from the last ADC bit, or a sample, to the gates", "LUT", "DSP", "of what")
    rows: Rows = []
    control = load(OWN_SCENE, []).controller
    assert control.clock_hz is not None
    us = 1e6 * LATENCY_CLOCKS / control.clock_hz
    latency = f"{LATENCY_CLOCKS} clocks, {us:.2f} µs at {_hz(control.clock_hz)}"
    for row in (row for row in resources if row["table"] == "brushless"):
        name = "wh_ports: one brushless motor, with guard and anchors"
        counts = (f"{row['lut']:,}", str(row["dsp"]))
        rows.append((name, _hz(control.tick_hz), latency, *counts, "ECP5, LUTs of four inputs"))
    for design in DESIGNS:
        published = ["–" if n is None else f"{n:,}" for n in (design.lut, design.dsp)]
        rows.append(
            (design.name, _hz(design.rate_hz), design.latency or "–", *published, design.where)
        )
    return head, rows


def _draw(curves: dict[str, Any], path: Path) -> Path:
    motor = load(SCENE, []).motor
    k_l = closed_forms.k_l(motor.felt_k_t, motor.L_h)

    def xy(curve: str) -> tuple[list[float], list[float | None]]:
        return [p["at"] for p in curves[curve]], [p["stiffness"] for p in curves[curve]]

    figure, (left, right) = figures.panels(2)
    figures.curve(left, *xy("rate slow"), 0, "FOC, servo at 1 kHz")
    figures.curve(left, *xy("rate"), 1, "FOC, servo as fast")
    figures.curve(left, *xy("rate wave"), 2, "wave wall")
    figures.label(left, "rate of current control or waves, Hz", "largest stable K, N·m/rad",
                  "over the rate")  # fmt: skip
    for n, (foc, servo) in enumerate(PAIRS_HZ):
        damping, k = xy(f"hand {foc:g} {servo:g}")
        name = f"FOC {_hz(foc)}, servo {_hz(servo)}"
        figures.curve(right, [1e3 * b for b in damping], k, (0, 1, 3)[n], name)
    damping, k = xy("hand wave")
    figures.curve(right, [1e3 * b for b in damping], k, 2, f"wave wall, {_hz(WAVE_TICK_HZ)}")
    figures.label(right, "damping of the hand, mN·m·s/rad", "largest stable K, N·m/rad",
                  "over the hand")  # fmt: skip
    for ax in (left, right):
        ax.axhline(k_l, color=figures.GREEN, lw=1, ls=":", label="K_L")
        ax.set_xscale("log")
        ax.set_yscale("log")
        figures.legend(ax)
    return figures.save(figure, path)


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    points = data["curves"]["wall"]
    slow, fast, wave = points[0], points[-2], points[-1]
    return [
        Text(
            "A brushless motor's walls are made by the same servo on field-oriented control of the "
            "currents: sampled, turned into the rotor's frame by the encoder's angle, two PI "
            "controllers without decoupling, and a voltage that reaches the bridge one period "
            "after its sample. The bandwidth is the magnitude optimum for what is late, 1/ω three "
            "periods. The hand, the encoder and what is called stable are those of the "
            "motor with brushes above; the currents have 12 bits and noise."
        ),
        Table("Stiffest stable wall under a light hand", *walls(points)),
        Picture(
            _draw(data["curves"], folder / PICTURE),
            "Left: over the rate, under the light hand. Right: over the hand's damping, with "
            f"{1e6 * VISCOUS:g} µN·m·s/rad of the rotor's own.",
        ),
        Text(
            f"Beside a servo at 1 kHz the wave wall is {wave['stiffness'] / slow['stiffness']:.1f} "
            "times as stiff. At equal rates it is not the stiffer one: what a servo can hold grows "
            "with its rate and with what the hand damps, and at 1 MHz that is "
            f"{fast['stiffness'] / wave['stiffness']:.1f} times the wave wall, whose most is K_L. "
            "What the wave wall has instead is that it is the same for every hand, and that "
            "between two counts it is still a spring: a servo's force is the count's, and a "
            "pressed rotor swings on its edge, with "
            f"{fast['ripple'] / wave['ripple']:.0f} times the ripple at the same stiffness. Its "
            "force needs no angle either."
        ),
        Table(
            "Beside what others publish; a dash is what was not found", *beside(data["resources"])
        ),
    ]
