# SPDX-License-Identifier: Apache-2.0
"""How long a wall holds, and what it throws: the numbers and pictures of the README's section.

A minute's hold under every sign of the disturbances, the winding that warms, and the bare rotor's
bounces, each with the anchor and without.
"""

from __future__ import annotations

import itertools
import json
import math
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.metrics import write_metrics
from wavehaptics.motors import PRESETS
from wavehaptics.report import figures
from wavehaptics.report.anchoring import R_OHM, bounce_map
from wavehaptics.report.readme import HOLDING_PICTURES
from wavehaptics.report.runs import STORE, load
from wavehaptics.run import CONTROLLERS, measure, stiffness_predicted
from wavehaptics.sweeps import Task, sweep
from wavehaptics.trace import TraceWriter, load_trace

SIGNS = tuple(itertools.product((1, -1), repeat=3))
"""Signs of the errors of R̂ (10 %), gain (5 %) and zero (2 mA); the shipped scene has the first."""
BOTH = ("core", "golden")
PINS_S = 2.0

PARTS = (0.9, 0.95, 1.0, 1.05, 1.1)
GAINS = (-0.05, 0.0, 0.05)
SPEEDS = (1.0, 3.0, 10.0, 30.0)
OFF = "controller.anchor_auto=false"
CURES = {
    "with the anchor": (),
    "without the release rule": ("controller.release_ohm=0",),
    "without the anchor": (OFF,),
}


def hold(controller: str, signs: list[int], settings: list[str]) -> dict[str, Any]:
    """Metrics of ``held_wall`` with errors of these signs."""
    r_hat, gain, zero = signs
    scene = load("held_wall", [
        f"controller.r_hat={R_OHM * (1 + 0.1 * r_hat)}", f"drive.gain_error={0.05 * gain}",
        f"adc.offset_a={2e-3 * zero}", *settings,
    ])  # fmt: skip
    metrics = measure(scene, controller, compare=False)
    kept = ("duration_s", "hold_error", "hold_offset_rad", "hold_ripple_rms", "r_hat_error",
            "encoder_lost", "energy_out_max_j")  # fmt: skip
    found = {"controller": controller, "signs": signs, "cured": OFF not in settings}
    cell = 2 * math.pi / scene.encoder.counts_per_rev
    return found | {"cell_rad": cell} | {key: metrics[key] for key in kept}


def warm(controller: str) -> dict[str, Any]:
    """Metrics of ``warm_winding``."""
    metrics = measure(load("warm_winding", []), controller, compare=False)
    kept = ("duration_s", "winding_c", "r", "r_hat_error", "hold_error", "encoder_lost")
    return {"controller": controller} | {key: metrics[key] for key in kept}


def bounces(preset: str, cure: str) -> list[dict[str, Any]]:
    """Speed out over speed in of a preset's bare rotor, at every speed, R̂ and gain."""
    found = []
    for speed, part, gain in itertools.product(SPEEDS, PARTS, GAINS):
        scene = load("bounce", [
            f"motor.preset={preset}", f"controller.r_hat={PRESETS[preset].R_ohm * part}",
            f"drive.gain_error={gain}", f"hand.speed_rad_s={speed}",
            f"scene.duration_s={0.05 / speed + 0.05}", *CURES[cure],
        ])  # fmt: skip
        back = measure(scene, "golden", compare=False)["restitution"]
        found.append({"speed": speed, "part": part, "gain": gain, "restitution": back})
    return found


def course(duration_s: float, rows: int, settings: list[str]) -> dict[str, Any]:
    """Time, torque and x of ``held_wall`` on the integer model, as means of ``rows`` parts.

    Beside them the stiffness of the design spring, N·m/rad.
    """
    scene = load("held_wall", [f"scene.duration_s={duration_s}", "scene.trace_hz=20e3", *settings])
    simulation = CONTROLLERS["golden"](scene)
    ticks = round(duration_s / simulation.tick_s)
    with tempfile.TemporaryDirectory() as folder:
        trace = TraceWriter(Path(folder), simulation.tick_s, scene.scene.trace_hz, ticks=ticks)
        measure(scene, "golden", trace=trace, simulation=simulation, compare=False)
        trace.save()
        arrays = load_trace(Path(folder))
    means = {
        key: [float(part.mean()) for part in np.array_split(arrays[key], rows)]
        for key in ("t", "torque", "x")
    }
    return means | {"stiffness": stiffness_predicted(scene, simulation)}


def _tasks() -> dict[str, list[Task]]:
    def held(controller: str, signs: tuple[int, ...], *settings: str) -> Task:
        arguments = {"controller": controller, "signs": list(signs), "settings": list(settings)}
        return Task(hold, arguments)

    return {
        "holds": [held(controller, signs) for controller in BOTH for signs in SIGNS]
        + [held("pins", SIGNS[0], f"scene.duration_s={PINS_S}")]
        + [held("golden", SIGNS[0], OFF, "scene.duration_s=1")],
        "warm": [Task(warm, {"controller": controller}) for controller in BOTH],
        "bounces": [
            Task(bounces, {"preset": preset, "cure": cure})
            for preset in PRESETS
            for cure in (CURES if preset == "re25-118743" else list(CURES)[:1])
        ],
        "courses": [
            Task(course, {"duration_s": s, "rows": rows, "settings": settings})
            for s, rows, settings in ((0.2, 1000, []), (0.2, 1000, [OFF]), (10.0, 500, []))
        ],
    }


def collect(
    out: Path, workers: int | None, progress: Callable[[str, float], None]
) -> dict[str, Any]:
    """Run everything; ``holding.json`` and the pictures into ``out``. Goes on where it stopped."""
    groups = _tasks()
    tasks = [task for group in groups.values() for task in group]
    results = iter(
        sweep(
            tasks, STORE, workers=workers or os.cpu_count() or 1,
            progress=lambda done, total: progress("holding", done / total),
        )
    )  # fmt: skip
    found = {name: [next(results) for _ in group] for name, group in groups.items()}
    found["bounces"] = [
        task.arguments | {"points": points}
        for task, points in zip(groups["bounces"], found["bounces"], strict=True)
    ]
    kept = write_metrics(found, out / "holding.json")
    found = json.loads(kept.read_bytes())
    _draw_holds(found["courses"], found["holds"][0]["cell_rad"], out / HOLDING_PICTURES[0])
    _draw_bounces(found["bounces"], out / HOLDING_PICTURES[1])
    return found


def _draw_holds(courses: list[dict[str, Any]], cell: float, path: Path) -> None:
    cured, plain, long = courses
    figure, (left, right) = figures.panels(2, 3.6)
    for n, (run, name) in enumerate(((cured, "with the anchor"), (plain, "without"))):
        left.plot([1e3 * t for t in run["t"]], [-1e3 * f for f in run["torque"]], lw=1.4,
                  color=figures.COLOURS[n], label=name, zorder=3 - n)  # fmt: skip
    left.set_ylim(-20, 60)
    figures.label(left, "Time, ms", "Torque of the wall −F, mN·m", "The press of held_wall")
    figures.legend(left)
    moved = [
        (f / long["stiffness"] + x) / cell for f, x in zip(long["torque"], long["x"], strict=True)
    ]
    late = [n for n, t in enumerate(long["t"]) if t > 0.1]
    right.plot([long["t"][n] for n in late], [moved[n] for n in late], lw=1.2, color=figures.BLUE)
    for edge in (-0.5, 0.5):
        right.axhline(edge, color=figures.GREY, lw=0.8, ls=":")
    right.set_ylim(-1, 1)
    figures.label(right, "Time, s", "Wall moved, encoder cells", "Held on; half a cell dotted")
    figures.save(figure, path)


def _draw_bounces(runs: list[dict[str, Any]], path: Path) -> None:
    runs = [run for run in runs if run["preset"] == "re25-118743"]
    figure, axes = figures.panels(len(runs), 3.2)
    image = None
    for ax, run in zip(axes, runs, strict=True):
        image = bounce_map(ax, run["points"])
        figures.label(ax, "R̂ over R", "speed of the hit, rad/s", run["cure"])
    figure.colorbar(image, ax=axes, shrink=0.85, label="speed out over speed in")
    figures.save(figure, path)
