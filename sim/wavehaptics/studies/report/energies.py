# SPDX-License-Identifier: Apache-2.0
"""Mean of a tick against one sample of it: which of them keeps the port passive?"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number
from wavehaptics.studies.report.hard_cases import STRIPES
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.stability import simulate
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace.columns import Column

TITLE = "Why the mean of the current?"

RATES_HZ = (500.0, 1e3, 2e3, 5e3, 1e4, 2e4, 1e5, 1e6)
QUICK_RATES_HZ = (500.0, 1e3, 2e3, 1e4, 1e5)


def at_rate(tick_hz: float, point: bool) -> dict[str, Any]:
    """Most net energy that the port gave out, J, with η changing sign all along."""
    settings = [*STRIPES, f"controller.tick_hz={tick_hz}", "controller.lambda=1e9"]
    scene = load("stiffest", settings).model_copy(update={"encoder": None})
    rows = simulate(SampledSimulation(scene, rtl=False, point_sampling=point), 0.5)
    energy = np.cumsum(rows[:, Column.ENERGY_OUT])
    return {
        "tick_hz": tick_hz,
        "point": point,
        "energy_out_max_j": max(0.0, float(energy.max())),
        "taken_in_j": max(0.0, -float(energy[-1])),
    }


def tasks(quick: bool) -> list[Task]:
    rates = QUICK_RATES_HZ if quick else RATES_HZ
    return [Task(at_rate, {"tick_hz": hz, "point": p}) for hz in rates for p in (False, True)]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    del tasks
    return {"points": results}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    figure, (ax,) = figures.panels(1, 3.4)
    for n, (point, name) in enumerate(((True, "a sample at the tick's end"), (False, "the mean"))):
        points = [p for p in data["points"] if p["point"] == point]
        periods = [1e6 / p["tick_hz"] for p in points]
        figures.curve(ax, periods, [1e6 * p["energy_out_max_j"] for p in points], n, name)
    ax.set_xscale("log")
    ax.set_yscale("symlog", linthresh=0.01)
    ax.set_ylim(-0.005, 3e6 * max(1e-8, *(p["energy_out_max_j"] for p in data["points"])))
    figures.label(ax, "tick, µs", "energy given out, µJ")
    figures.legend(ax)
    path = figures.save(figure, folder / "energies.png")
    rows = [
        (f"{1e6 / p['tick_hz']:g}", "end" if p["point"] else "mean",
         number(1e6 * p["energy_out_max_j"]), number(1e6 * p["taken_in_j"]))
        for p in data["points"]
    ]  # fmt: skip
    return [
        Text(
            "With the mean of the current over a tick the port can take out no more energy than "
            "the discrete waves carry, whatever the tick (Jensen's inequality); with one sample a "
            "tick it can. A hand drags the rotor through forty thin walls, so that η changes sign "
            "about a thousand times a second."
        ),
        Picture(path, "Most net energy that the port had given out at any time, in 0.5 s."),
        Table("Energies", ("tick, µs", "current", "given out at most, µJ", "taken in, µJ"), rows),
    ]  # fmt: skip
