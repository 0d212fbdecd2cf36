# SPDX-License-Identifier: Apache-2.0
"""Files of a measured impedance: ``impedance.json`` and ``impedance.png``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from wavehaptics.controller.rendered import rendered
from wavehaptics.controller.settings import settings
from wavehaptics.runtime.files import write_json
from wavehaptics.scene import Scene
from wavehaptics.studies.impedance import Impedance
from wavehaptics.trace.pictures import save_figure

_BLUE, _ORANGE, _GREEN, _GREY = "#0072B2", "#E69F00", "#009E73", "#7F7F7F"


def result(scene: Scene, impedance: Impedance) -> dict[str, Any]:
    """What ``impedance.json`` holds: SI units, impedances as [real, imaginary]."""

    def pairs(values: np.ndarray | None) -> list[list[float]] | None:
        return None if values is None else [[float(z.real), float(z.imag)] for z in values]

    return {
        "scene": scene.scene.name,
        "hertz": impedance.hertz.tolist(),
        "measured": pairs(impedance.measured),
        "rendered": pairs(impedance.rendered),
        "wished": pairs(impedance.wished),
        "error": impedance.errors.tolist(),
        "error_max": float(impedance.errors.max()),
        "energy_out_max_j": impedance.energy_out_j,
    }


def write(scene: Scene, impedance: Impedance, out: Path) -> dict[str, Any]:
    """Write both files into ``out`` and return what the JSON holds."""
    found = result(scene, impedance)
    write_json(out / "impedance.json", found)
    picture(scene, impedance, out / "impedance.png")
    return found


def picture(scene: Scene, impedance: Impedance, path: Path) -> Path:
    """Dynamic stiffness ``|ω Z|`` and phase of Z over frequency: design, measured, their error."""
    figure = Figure(figsize=(10.0, 7.6), dpi=160, layout="constrained")
    FigureCanvasAgg(figure)
    top, middle, bottom = figure.subplots(3, 1, sharex=True, height_ratios=[1.6, 1.0, 0.8])
    motor, set_ = scene.motor, settings(scene)
    hertz = np.geomspace(impedance.hertz[0], impedance.hertz[-1], 600)
    s = 2j * math.pi * hertz
    wish = set_.shaper.wish
    curves = [(rendered(set_, motor.k_t, motor.L_h, hertz), "rendered, every delay in it", _ORANGE)]
    if wish is not None:
        curves.append((wish.felt(s), "wished", _GREEN))
        rigid = wish.front / s
        curves.append((rigid, "rigid: the motor and the delay alone", _GREY))
    for z, label, color in curves:
        style = {"color": color, "lw": 3.0 if color == _ORANGE else 1.3}
        top.loglog(hertz, np.abs(s * z), label=label, **style)
        middle.semilogx(hertz, np.degrees(np.angle(z)), **style)
    points = 2.0 * math.pi * impedance.hertz
    mark = {"color": _BLUE, "ls": "none", "marker": "o", "ms": 6}
    top.loglog(impedance.hertz, points * np.abs(impedance.measured), label="measured", **mark)
    middle.semilogx(impedance.hertz, np.degrees(np.angle(impedance.measured)), **mark)
    bottom.loglog(impedance.hertz, np.maximum(100.0 * impedance.errors, 1e-4), **mark)
    bottom.axhline(2.0, color=_GREY, ls="--", lw=1.0)
    top.set_ylabel("|torque / angle|, N·m/rad")
    middle.set_ylabel("Phase of\ntorque / speed, °")
    middle.set_yticks([-90, -45, 0, 45, 90])
    middle.set_ylim(-100, 100)
    bottom.set_ylabel("Error against\nthe design, %")
    bottom.set_xlabel("Frequency, Hz")
    for ax in (top, middle, bottom):
        ax.grid(True, color="#E3E3E3", linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
    top.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False, fontsize=9)
    text = f"{scene.scene.name} · largest error {100.0 * impedance.errors.max():.2g} %"
    figure.suptitle(text, x=0.01, ha="left", fontsize=11)
    return save_figure(figure, path)
