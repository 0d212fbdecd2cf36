# SPDX-License-Identifier: Apache-2.0
"""The pictures of the study: a held wall, energy, random motors, a press beyond the limit."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from wavehaptics.ladder.run import CONTROLLERS, stiffness_predicted
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace.columns import Column

from wavetools.studies.anchored import cases
from wavetools.studies.anchored.hand import FREQUENCIES
from wavetools.studies.anchored.runs import PLAIN, cell_of, run

HELD, LOOP, ENERGY, MOTORS, OVERLOAD, MISSED = (
    "held_wall.png", "press_loop.png", "press_energy.png", "random_motors.png", "overload.png",
    "missed_holds.png",
)  # fmt: skip
PICTURES = (HELD, LOOP, ENERGY, MOTORS, OVERLOAD, MISSED)
"""Pictures that the pages show, below ``sim/docs``."""

_WRONG = cases.all_wrong(cases.SIGNS[0])
COURSES: dict[str, tuple[float, tuple[str, ...]]] = {
    "with the anchor": (100e-6, (*_WRONG, "scene.duration_s=0.2")),
    "without": (100e-6, (*_WRONG, "scene.duration_s=0.2", PLAIN)),
    "held": (10e-3, (*_WRONG, "scene.duration_s=10")),
    "press": (200e-6, ("hand.path=taps", "hand.frequency_hz=1", "hand.amplitude_rad=0.15",
                       *(s for s in cases.all_wrong(cases.SIGNS[1])
                         if not s.startswith(("drive.bus_v", "drive.step"))),
                       "scene.duration_s=2")),
    "pressed": (1e-3, ("hand.path=taps", *cases.PRESSED["2.1 V"], "scene.duration_s=2")),
}  # fmt: skip
"""Means over so long, and settings, by name."""
LEVERS = ("a lever, no error", "a lever, all errors")
COURSES |= {
    name: (500e-6, (*wrong, *cases.loaded(50.0), "hand.damping=0.1e-3", "scene.duration_s=1.5"))
    for name, wrong in zip(LEVERS, ((), _WRONG), strict=True)
}
BARS = ("a bar of −8 %", "a bar of +4 %")
"""Of the commutator, where a rotor in a hand of 0.5 mN·m·s/rad rests."""


def bar_course(name: str, part: float) -> dict[str, Any]:
    """As :func:`course`, of the bar that makes most ripple of all places."""
    damping = cases.HANDS["hand"]
    bars = [cases.bar(part, place, damping) for place in cases.STEP_PLACES]
    worst = max(bars, key=lambda bar: bar["hold_ripple_rms"])
    return _course(name, 200e-6, cases.bar_settings(part, worst["place"], damping))


def course(name: str) -> dict[str, Any]:
    """Time, torque, x, depth that the torque stands for and how far the wall has moved, cells."""
    part_s, settings = COURSES[name]
    return _course(name, part_s, [*cases.NOTHING, *settings])


def _course(name: str, part_s: float, settings: list[str]) -> dict[str, Any]:
    scene = load("held_wall", settings)
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
    return [Task(course, {"name": name}) for name in COURSES] + [
        Task(bar_course, {"name": name, "part": part})
        for name, part in zip(BARS, (-0.08, 0.04), strict=True)
    ]


def draw(found: dict[str, Any], out: Path) -> None:
    """All pictures of ``holding.json``'s numbers into the folder ``out``."""
    courses = {run["name"]: run for run in found["courses"]}
    _draw_held(courses, out / HELD)
    _draw_loop(courses["press"], out / LOOP)
    _draw_energy(found["presses"], out / ENERGY)
    _draw_motors(found["motors"], out / MOTORS)
    _draw_overload(courses["pressed"], out / OVERLOAD)
    _draw_missed(courses, out / MISSED)


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
    for edge in (-1, 1):
        right.axhline(edge, color=figures.GREY, lw=0.8, ls=":")
    right.set_ylim(-1.5, 1.5)
    figures.label(right, "Time, s", "Wall moved, counts", "Held on; one count dotted")
    figures.save(figure, path)


def _draw_loop(run: dict[str, Any], path: Path) -> None:
    """Force over depth of the first press and of the second, all of it and three counts."""
    figure, (left, right) = figures.panels(2, 4.2)
    deepest = max(run["x"])
    for ax in (left, right):
        ax.plot([0, deepest], [0, deepest], color=figures.GREY, lw=1, ls=":", label="the spring")
        for n, name in enumerate(("first press", "second press")):
            at = [k for k, t in enumerate(run["t"]) if n <= t < n + 1 and run["contact"][k] == 1]
            ax.plot([run["x"][k] for k in at], [run["force_cells"][k] for k in at], lw=1.1,
                    color=figures.COLOURS[n], label=name)  # fmt: skip
    middle = math.floor(0.6 * deepest)
    right.set_xlim(middle - 1.5, middle + 1.5)
    right.set_ylim(middle - 2.5, middle + 2.5)
    right.set_xticks([middle - 1, middle, middle + 1])
    figures.label(left, "Depth, counts", "Force over stiffness, counts", "Presses, all errors")
    figures.label(right, "Depth, counts", "", "Three counts of them; edges at whole numbers")
    figures.legend(left)
    figures.save(figure, path)


ENERGY_TARGETS = {"nothing": 0.02, "all": 0.10}
"""What a press may give of the energy that the wall held at most: without errors, with all."""
KINDS = ("nothing", "one error, the worst", "all errors, the worst")


def kind_of(wrong: str) -> str:
    """Of KINDS."""
    return {"nothing": KINDS[0]}.get(
        wrong, KINDS[2] if wrong.startswith("everything") else KINDS[1]
    )


def worst_energies(
    presses: list[dict[str, Any]], wall: str, which: str
) -> dict[str, dict[float, float]]:
    """By kind of error and frequency the largest energy of the ``first`` or ``later`` presses."""
    found: dict[str, dict[float, float]] = {}
    for row in presses:
        if row["wall"] == wall and row[which] is not None:
            of = found.setdefault(kind_of(row["wrong"]), {})
            of[row["frequency"]] = max(of.get(row["frequency"], -math.inf), row[which])
    return found


def _draw_energy(presses: list[dict[str, Any]], path: Path) -> None:
    walls = ("rigid", "soft")
    figure, axes = figures.panels(2, 3.8)
    for ax, wall in zip(axes, walls, strict=True):
        for which, style in (("first", "--"), ("later", "-")):
            worst = worst_energies(presses, wall, which)
            for n, kind in enumerate(KINDS):
                points = sorted(worst.get(kind, {}).items())
                if points:
                    ax.semilogx(*zip(*points, strict=True), style, marker="o", ms=3, lw=1.3,
                                color=figures.COLOURS[n],
                                label=kind if which == "later" else None)  # fmt: skip
        for target in ENERGY_TARGETS.values():
            ax.axhline(target, color=figures.GREY, lw=0.8, ls=":")
        ax.set_xticks(FREQUENCIES, [f"{at:g}" for at in FREQUENCIES])
        ax.minorticks_off()
        figures.label(ax, "Presses a second, Hz", "Energy given over the most held",
                      f"A {wall} wall; first press dashed, targets dotted")  # fmt: skip
        figures.legend(ax)
    figures.save(figure, path)


def _draw_motors(rows: list[dict[str, Any]], path: Path) -> None:
    """What each random motor makes of three targets, over its load."""
    figure, (left, middle, right) = figures.panels(3, 3.8)

    def draw(ax, part: str, value, colour: str, name: str) -> None:
        points = [(row["motor"]["load"], value(row[part])) for row in rows]
        points = [(load, at) for load, at in points if at is not None]
        if points:
            ax.semilogx(*zip(*points, strict=True), "o", ms=3, color=colour, label=name)

    for n, which in enumerate(("first", "later")):
        draw(left, "press", lambda row, which=which: row.get(which), figures.COLOURS[n],
             f"{which} press")  # fmt: skip
    left.axhline(ENERGY_TARGETS["all"], color=figures.GREY, lw=0.9, ls=":")
    figures.label(left, "Inertia on the shaft, J", "Energy given over held", "Presses")
    figures.legend(left, **ABOVE)
    draw(middle, "press", error_of_press, figures.BLUE, "press")
    middle.axhline(SWING_TARGET, color=figures.GREY, lw=0.9, ls=":")
    figures.label(middle, "Inertia on the shaft, J", "Largest error over the force", "Presses")
    for n, key in enumerate(key for key in rows[0] if key.startswith("bounce_")):
        draw(right, key, lambda row: row.get("restitution"),
             figures.COLOURS[n % len(figures.COLOURS)],
             key.removeprefix("bounce_"))  # fmt: skip
    right.axhline(1.0, color=figures.GREY, lw=0.9, ls=":")
    figures.label(right, "Inertia on the shaft, J", "Speed out over speed in", "Bounces, rad/s")
    figures.legend(right, **ABOVE, ncols=5)
    figures.save(figure, path)


SWING_TARGET = 0.04
"""Largest error of a press over its force."""
ABOVE = {
    "loc": "lower right", "bbox_to_anchor": (1.02, 0.99), "borderaxespad": 0.0,
    "handlelength": 0.8, "handletextpad": 0.1, "columnspacing": 0.3, "labelspacing": 0.1,
}  # fmt: skip
"""A legend's place where points are all over the axes."""


def error_of_press(row: dict[str, Any]) -> float | None:
    """How far force and depth of a press are off the design spring at most, over the depth."""
    if row.get("moved_cells") is None or not row["depth_cells"]:
        return None
    return row["moved_cells"] / row["depth_cells"]


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


def _draw_missed(courses: dict[str, Any], path: Path) -> None:
    """The holds that miss their target furthest, each beside one that meets it."""
    figure, (left, right) = figures.panels(2, 3.6)
    for ax, names, from_s, to_s in ((left, BARS, 0.9, 0.93), (right, LEVERS, 0.0, 1.5)):
        for n, name in enumerate(names):
            run = courses[name]
            at = [k for k, t in enumerate(run["t"]) if from_s <= t <= to_s]
            ax.plot([1e3 * run["t"][k] for k in at], [-1e3 * run["torque"][k] for k in at], lw=1.2,
                    color=figures.COLOURS[1 - n], label=name, zorder=3 - n)  # fmt: skip
        figures.legend(ax)
    left.set_ylim(0, 20)
    figures.label(left, "Time, ms", "Torque of the wall −F, mN·m", "R steps where the rotor rests")
    figures.label(right, "Time, ms", "", "Fifty times the rotor's inertia")
    figures.save(figure, path)
