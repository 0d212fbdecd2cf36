# SPDX-License-Identifier: Apache-2.0
"""Fidelity against speed: one scene on every rung of the ladder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number, percent
from wavehaptics.studies.report.runs import FIRST_CONTACT_S, off, run_task
from wavehaptics.studies.sweeps import Task

TITLE = "What does each rung of the fidelity ladder cost?"

WAVE_RUNGS = ("analog", "golden", "core", "pins")
SCENES = ("paper_taps", "press_hold", "impact")


def tasks(quick: bool) -> list[Task]:
    scenes = SCENES[:1] if quick else SCENES
    found = []
    for scene in scenes:
        length = 0.05 if scene == "impact" else FIRST_CONTACT_S if quick else 0.5
        for controller in WAVE_RUNGS:
            found.append(run_task(scene, controller, f"scene.duration_s={length}"))
    return found


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    del tasks
    points = []
    for m in results:
        cycles = m["clock_cycles"]
        points.append(
            {
                "scene": m["scene"],
                "controller": m["controller"],
                "simulated_s_per_s": m["duration_s"] / m["wall_clock_s"],
                "ticks_per_s": m["ticks"] / m["wall_clock_s"],
                "cycles_per_s": None if cycles is None else cycles / m["wall_clock_s"],
                "torque_error": m["torque_nrmse_vs_analog"],
                "stiffness_error": off(m["stiffness"], m["stiffness_predicted"]),
            }
        )
    return {"points": points}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    figure, (ax,) = figures.panels(1, 3.6)
    scenes = list(dict.fromkeys(p["scene"] for p in data["points"]))
    for n, scene in enumerate(scenes):
        points = [p for p in data["points"] if p["scene"] == scene and p["torque_error"]]
        speed = [p["simulated_s_per_s"] for p in points]
        figures.curve(ax, speed, [p["torque_error"] for p in points], n, scene, ls="")
    for controller in dict.fromkeys(p["controller"] for p in data["points"]):
        # One note over each controller's points, which lie close to each other.
        points = [p for p in data["points"] if p["controller"] == controller]
        top = max(points, key=lambda p: p["torque_error"] or 0.0)
        if top["torque_error"]:
            figures.note(ax, controller, (top["simulated_s_per_s"], top["torque_error"]))
    ax.set_xscale("log")
    ax.set_yscale("log")
    figures.label(ax, "simulated seconds per second", "torque error against analog")
    if len(scenes) > 1:
        figures.legend(ax)
    path = figures.save(figure, folder / "ladder.png")
    return [
        Text(
            "The same scene on each rung, one after the other with nothing beside it. The error is "
            "that of the torque against the analog circuit; “core” has the very words of "
            "“golden”, at the price of simulating its Verilog. A scene with a noisy ADC shows that "
            "noise as error on every rung that models it."
        ),
        Picture(path, "Error over simulation speed."),
        Table(
            "The fidelity ladder",
            ("scene", "controller", "simulated s per s", "ticks per s", "clocks per s",
             "torque error", "stiffness against prediction"),
            [
                (p["scene"], p["controller"], number(p["simulated_s_per_s"]),
                 number(p["ticks_per_s"]), number(p["cycles_per_s"]), percent(p["torque_error"]),
                 percent(p["stiffness_error"]))
                for p in data["points"]
            ],
        ),
    ]  # fmt: skip
