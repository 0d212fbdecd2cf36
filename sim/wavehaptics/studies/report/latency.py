# SPDX-License-Identifier: Apache-2.0
"""Latency of the wave loop against stiffness and stability."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from wavehaptics.ladder.run import measure
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number, percent
from wavehaptics.studies.report.runs import load, off
from wavehaptics.studies.stability import stable
from wavehaptics.studies.sweeps import Task

TITLE = "What does latency cost?"

EXTRA_TICKS = (0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
QUICK_EXTRA_TICKS = (0, 1, 10, 100, 1000)
LIMIT = "drive.limit_v=12.0"  # the paper's 2.1 V would be reached
DURATION = "scene.duration_s=0.5"


def at_latency(extra_ticks: int) -> dict[str, Any]:
    """The stiffest wall (a = 0.99) with k ticks of latency: its stiffness, energy and stability."""
    settings = [f"controller.extra_ticks={extra_ticks}", "controller.lambda=1e9", LIMIT, DURATION]
    scene = load("stiffest", settings)
    metrics = measure(scene, "golden")
    return {
        "extra_ticks": extra_ticks,
        "stiffness": metrics["stiffness"],
        "predicted": metrics["stiffness_predicted"],
        "k_l": metrics["k_l"],
        "energy_out_max_j": metrics["energy_out_max_j"],
        "stable": stable(scene, "golden", metrics["stiffness_predicted"]),
    }


def tasks(quick: bool) -> list[Task]:
    ticks = QUICK_EXTRA_TICKS if quick else EXTRA_TICKS
    return [Task(at_latency, {"extra_ticks": n}) for n in ticks]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    del tasks
    for point in results:
        point["error"] = off(point["stiffness"], point["predicted"])
    return {"points": results}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    points = data["points"]
    figure, (ax,) = figures.panels(1, 3.6)
    k = [p["extra_ticks"] for p in points]
    figures.curve(ax, k, [p["predicted"] / p["k_l"] for p in points], 1, "closed form", marker="")
    figures.curve(ax, k, [p["stiffness"] / p["k_l"] for p in points], 0, "measured", ls="")
    ax.set_xscale("symlog", linthresh=1)
    ax.set_yscale("log")
    for formatter in (ax.yaxis.set_major_formatter, ax.yaxis.set_minor_formatter):
        formatter("{x:g}")
    figures.label(ax, "extra latency k, ticks of 1 µs", "stiffness over $K_L$")
    figures.legend(ax)
    path = figures.save(figure, folder / "latency.png")
    return [
        Text(
            "Latency makes a wave wall softer, not unstable: K = k_T²/(L + R·τ/2) with "
            "τ = T/a + k·T. The port of the controller never gave out energy, at any of them."
        ),
        Picture(path, "Stiffness of the stiffest wall (a = 0.99, T = 1 µs) over its latency."),
        Table(
            "Latency against stiffness and stability",
            ("k", "K over K_L", "error against the closed form", "energy given out, J", "stable"),
            [
                (p["extra_ticks"], number(p["stiffness"] / p["k_l"]), percent(p["error"]),
                 number(p["energy_out_max_j"]), "yes" if p["stable"] else "no")
                for p in points
            ],
        ),
    ]  # fmt: skip
