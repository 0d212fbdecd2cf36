# SPDX-License-Identifier: Apache-2.0
"""A wall across motors: a tip goes around a disc, beside the baseline's servo."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.ladder.joint_run import measure_device
from wavehaptics.scene import find_scene, load_device
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number, percent
from wavehaptics.studies.report.runs import off
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace.tip import Tip, deepest

TITLE = "A wall across motors"

DISC = "planar_disc"
PICTURE = "in_space.png"
WALLS: tuple[tuple[str, str, float | None], ...] = (
    ("wave, 1 MHz", "golden", None),
    ("baseline, 1 kHz", "encoder", 500.0),
    ("baseline, 1 kHz", "encoder", 4000.0),
)
"""What is run: a name, the controller, and the stiffness that a surface asks for in N/m."""
HAND = ("hand.damping_n_s_per_m=0.5",)
"""A light hand, as :mod:`~wavehaptics.studies.report.old_way` has it."""
SHOWN_HZ = 1000.0
"""Rows of the tip that are kept."""
AROUND_S = 0.15
"""When the tip is on its way around: what is before is the way to the disc."""


def around(name: str, controller: str, stiffness: float | None) -> dict[str, Any]:
    """Metrics of a way around the disc, and the tip's place (mm), depth (mm) and push (N) over t.

    ``stiffness`` in N/m is the surface's; None is the stiffest wall, rigid.
    """
    asked = () if stiffness is None else (f"surface.0.stiffness={stiffness:g}",)
    device = load_device(find_scene(DISC), (*HAND, *asked))
    space = device.space
    assert space is not None
    kept: list[np.ndarray] = []

    def keep(rows: np.ndarray, words: np.ndarray, tips: np.ndarray) -> None:
        del rows, words
        kept.append(tips.copy())

    metrics = measure_device(device, controller, keep=keep)
    tips = np.concatenate(kept)
    depth, normal, _ = deepest(space, tips[:, Tip.X : Tip.Z + 1])
    push = -np.einsum("ij,ij->i", tips[:, Tip.FORCE_X : Tip.FORCE_Z + 1], normal)
    step = max(round(1.0 / (SHOWN_HZ * (tips[1, Tip.T] - tips[0, Tip.T]))), 1)
    rest = tips[:, Tip.T] >= AROUND_S
    return {
        "name": name,
        "asked": stiffness,
        "stiffness": metrics["tip_stiffness"],
        "predicted": metrics["tip_stiffness_predicted"],
        "depth_m": float(np.mean(depth[rest])),
        "deepest_m": float(np.max(depth[rest])),
        "lost_s": float(np.mean(depth[rest] <= 0.0) * (tips[-1, Tip.T] - AROUND_S)),
        "tangential_part": metrics["tangential_part"],
        "energy_ratio": metrics["contact_energy_ratio"],
        "t": tips[::step, Tip.T].tolist(),
        "x_mm": (1e3 * tips[::step, Tip.X]).tolist(),
        "y_mm": (1e3 * tips[::step, Tip.Y]).tolist(),
        "depth_mm": (1e3 * depth[::step]).tolist(),
        "push_n": push[::step].tolist(),
    }


def tasks(quick: bool) -> list[Task]:
    del quick
    return [
        Task(around, {"name": name, "controller": controller, "stiffness": stiffness})
        for name, controller, stiffness in WALLS
    ]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    del tasks
    for wall in results:
        wall["error"] = off(wall["stiffness"], wall["predicted"])
    disc = load_device(find_scene(DISC)).space
    assert disc is not None
    (surface,) = disc.surface
    return {
        "walls": results,
        "middle_mm": [1e3 * float(x) for x in surface.point_m[:2]],
        "radius_mm": 1e3 * float(surface.radius_m or 0.0),
    }


def _called(wall: dict[str, Any]) -> str:
    name: str = wall["name"]
    return name + ("" if wall["asked"] is None else f", {wall['asked']:g} N/m")


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    walls = data["walls"]
    figure, (path, depth) = figures.panels(2, 4.4)
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    x, y = data["middle_mm"]
    radius = data["radius_mm"]
    path.fill(x + radius * np.cos(angle), y + radius * np.sin(angle), color="#E3E3E3")
    for n, wall in reversed(list(enumerate(walls))):  # the wave is on top
        look = {"marker": "", "lw": 1.0 if n == len(walls) - 1 else 2.0}
        figures.curve(path, wall["x_mm"], wall["y_mm"], n, _called(wall), **look)
        figures.curve(depth, wall["t"], wall["depth_mm"], n, _called(wall), **look)
    path.set_aspect("equal")
    figures.label(path, "x of the tip, mm", "y, mm")
    figures.label(depth, "time, s", "depth of the tip in the disc, mm")
    depth.set_ylim(-2.0, 1.35 * max(max(w["depth_mm"]) for w in walls))
    figures.legend(depth, loc="upper right", reverse=True)
    picture = figures.save(figure, folder / PICTURE)
    return [
        Text(
            "Two motors of a planar arm hold a disc that a hand presses on with 2 N and goes "
            "around once a second. A host sends its tangent at 1 kHz, and each control period "
            "tests and reflects the waves along it. The baseline computes a Cartesian spring at "
            "1 kHz from the same encoders."
        ),
        Picture(picture, "The tip's path on the disc (grey), and how deep it is in it."),
        Table(
            "Around a disc",
            ("wall", "stiffness, N/m", "off its prediction", "mean depth, mm", "deepest, mm",
             "out of it, s", "push along the surface"),
            [
                (_called(w), number(w["stiffness"]), percent(w["error"]),
                 number(1e3 * w["depth_m"]), number(1e3 * w["deepest_m"]), number(w["lost_s"]),
                 percent(w["tangential_part"]))
                for w in walls
            ],
        ),
    ]  # fmt: skip
