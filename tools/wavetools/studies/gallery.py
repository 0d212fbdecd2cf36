# SPDX-License-Identifier: Apache-2.0
"""What environments feel like: the motor's torque over the angle, a picture of ``make tables``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from wavehaptics.ladder.run import CONTROLLERS
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.studies.stability import simulate
from wavehaptics.trace.columns import Column
from wavehaptics.trace.pictures import save_figure

PICTURE = "gallery.png"

FEELS = {
    "two_walls": "end stops",
    "spring_damper": "a soft wall",
    "soft_layer": "a soft layer on a floor",
    "centring": "a joystick's spring",
    "detents": "detents",
    "click": "a push button",
    "texture": "a rough surface",
    "damped": "honey",
}
"""Scenes of the gallery, with what they feel like."""

ROWS_HZ = 20e3
COLUMNS = 4
_BLUE, _GREY = "#0072B2", "#E3E3E3"


def stroke(name: str) -> np.ndarray:
    """Angle (mrad) and torque (mN·m) of a scene on ``golden``: float64 (2, rows)."""
    scene = load_scene(find_scene(name))
    every = round(scene.controller.tick_hz / ROWS_HZ)
    rows = simulate(CONTROLLERS["golden"](scene), scene.scene.duration_s)
    return 1e3 * rows[::every, [Column.X, Column.TORQUE]].T


def draw(out: Path, progress: Callable[[str, float], None]) -> Path:
    """Run the gallery's scenes and draw PICTURE into ``out``; its path."""
    figure = Figure(figsize=(10.0, 5.0), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(-(-len(FEELS) // COLUMNS), COLUMNS).ravel()
    for n, (ax, (name, feel)) in enumerate(zip(axes, FEELS.items(), strict=True)):
        progress("gallery", n / len(FEELS))
        ax.plot(*stroke(name), color=_BLUE, lw=1.0)
        ax.set_title(feel, loc="left", fontsize=10)
        ax.grid(True, color=_GREY, linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
        ax.tick_params(labelsize=8)
    for ax in axes[-COLUMNS:]:
        ax.set_xlabel("angle, mrad", fontsize=9)
    for ax in axes[::COLUMNS]:
        ax.set_ylabel("torque, mN·m", fontsize=9)
    return save_figure(figure, out / PICTURE)
