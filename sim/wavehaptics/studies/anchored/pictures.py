# SPDX-License-Identifier: Apache-2.0
"""The pictures of the study: a held wall, bounces and random motors, a press beyond the limit."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.ladder.run import CONTROLLERS, stiffness_predicted
from wavehaptics.studies.anchored import cases
from wavehaptics.studies.anchored.runs import PLAIN, cell_of, run
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace.columns import Column

HELD, MOTORS, OVERLOAD = "held_wall.png", "random_motors.png", "overload.png"
PICTURES = (HELD, MOTORS, OVERLOAD)
"""Pictures that the pages show, below ``sim/docs``."""

_WRONG = cases.all_wrong(cases.SIGNS[0])
COURSES: dict[str, tuple[float, tuple[str, ...]]] = {
    "with the anchor": (100e-6, (*_WRONG, "scene.duration_s=0.2")),
    "without": (100e-6, (*_WRONG, "scene.duration_s=0.2", PLAIN)),
    "held": (10e-3, (*_WRONG, "scene.duration_s=10")),
    "pressed": (1e-3, ("hand.path=taps", *cases.PRESSED["2.1 V"], "scene.duration_s=2")),
}
"""Means over so long, and settings, by name."""


def course(name: str) -> dict[str, Any]:
    """Time, torque, x, depth that the torque stands for and how far the wall has moved, cells."""
    part_s, settings = COURSES[name]
    scene = load("held_wall", [*cases.NOTHING, *settings])
    _, rows = run(scene, part_s=part_s)
    k, cell = stiffness_predicted(scene, CONTROLLERS["golden"](scene)), cell_of(scene)
    moved = (rows[:, Column.TORQUE] / k + rows[:, Column.X]) / cell
    return {
        "name": name,
        "t": rows[:, Column.T].tolist(),
        "torque": rows[:, Column.TORQUE].tolist(),
        "x": (rows[:, Column.X] / cell).tolist(),
        "moved": moved.tolist(),
        "contact": rows[:, Column.CONTACT].tolist(),
        "force_cells": (-rows[:, Column.TORQUE] / k / cell).tolist(),
    }


def tasks() -> list[Task]:
    """Tasks of the courses."""
    return [Task(course, {"name": name}) for name in COURSES]


def draw(found: dict[str, Any], out: Path) -> None:
    """All pictures of ``holding.json``'s numbers into the folder ``out``."""
    courses = {run["name"]: run for run in found["courses"]}
    _draw_held(courses, out / HELD)
    _draw_motors(found["motors"], out / MOTORS)
    _draw_overload(courses["pressed"], out / OVERLOAD)


def _draw_held(courses: dict[str, Any], path: Path) -> None:
    figure, (left, right) = figures.panels(2, 3.6)
    for n, name in enumerate(("with the anchor", "without")):
        run = courses[name]
        left.plot([1e3 * t for t in run["t"]], [-1e3 * f for f in run["torque"]], lw=1.4,
                  color=figures.COLOURS[n], label=name, zorder=3 - n)  # fmt: skip
    left.set_ylim(-20, 60)
    figures.label(left, "Time, ms", "Torque of the wall −F, mN·m", "A press, everything wrong")
    figures.legend(left)
    held = courses["held"]
    late = [n for n, t in enumerate(held["t"]) if t > 0.1]
    right.plot([held["t"][n] for n in late], [held["moved"][n] for n in late], lw=1.2,
               color=figures.BLUE)  # fmt: skip
    for edge in (-0.5, 0.5):
        right.axhline(edge, color=figures.GREY, lw=0.8, ls=":")
    right.set_ylim(-1, 1)
    figures.label(right, "Time, s", "Wall moved, encoder cells", "Held on; half a cell dotted")
    figures.save(figure, path)


def _draw_motors(rows: list[dict[str, Any]], path: Path) -> None:
    figure, (left, right) = figures.panels(2, 3.8)
    for n, (part, name) in enumerate((("hold", "hold"), ("swing", "swing"), ("soft", "soft wall"))):
        points = [
            (row[part]["depth_cells"], abs(row[part]["moved_cells"]))
            for row in rows
            if row[part].get("moved_cells") is not None
        ]
        if points:
            left.loglog(*np.array(points).T, "o", ms=3, color=figures.COLOURS[n], label=name)
    depth = np.geomspace(0.5, 1000, 50)
    left.loglog(depth, 0.5 + 0.02 * depth, color=figures.GREY, lw=0.9, ls=":")
    figures.label(left, "Depth, cells", "Moved at most, cells", "Half a cell and 2 % dotted")
    figures.legend(left)
    speeds = [float(key.split("_")[1]) for key in rows[0] if key.startswith("bounce_")]
    for speed in speeds:
        backs = [row[f"bounce_{speed:g}"].get("restitution") for row in rows]
        backs = [back for back in backs if back is not None]
        spread = speed * np.exp(np.random.default_rng(1).uniform(-0.2, 0.2, len(backs)))
        right.semilogx(spread, backs, "o", ms=3, color=figures.BLUE)
    right.axhline(1.0, color=figures.GREY, lw=0.9, ls=":")
    figures.label(right, "Speed of the hit, rad/s", "Speed out over speed in", "Bounces")
    figures.save(figure, path)


def _draw_overload(run: dict[str, Any], path: Path) -> None:
    figure, (ax,) = figures.panels(1, 3.4)
    times = [1e3 * t for t in run["t"]]
    ax.plot(times, run["x"], color=figures.BLUE, lw=1.3, label="depth of the rotor")
    ax.plot(times, run["force_cells"], color=figures.ORANGE, lw=1.3,
            label="depth that the force stands for")  # fmt: skip
    top = max(4.0, 2.0 * max(run["force_cells"]))
    ax.set_ylim(-5, top if math.isfinite(top) else 100)
    figures.label(ax, "Time, ms", "Encoder cells", "Pressed beyond a limit of 2.1 V and let go")
    figures.legend(ax)
    figures.save(figure, path)
