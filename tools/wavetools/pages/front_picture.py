# SPDX-License-Identifier: Apache-2.0
"""The README's first pictures: what ``make demo`` made, beside the usual way's stiffest wall."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from wavehaptics.trace.columns import load_trace
from wavehaptics.trace.pictures import save_figure

TAP_S = 0.5
"""One tap of the demo's scenes."""

MOTOR = "re25-118743"
"""The demo's."""

PICTURES = ("tap.png", "walls.png")
"""A tap on the wall, and how stiff walls are."""

_BLUE, _ORANGE, _RED = "#0072B2", "#E69F00", "#D55E00"


def usual(ratios: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The report's row of the demo's motor, with an encoder's servo at 1 kHz beside the waves."""
    return next(row for row in ratios if row["motor"] == MOTOR)


def way_in(trace: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Depth in mrad and push in mN·m from the first contact to the first tap's deepest point."""
    tap = trace["t"] < TAP_S
    part = slice(int(np.argmax(trace["contact"][tap])), int(np.argmax(trace["x"][tap])) + 1)
    return 1e3 * trace["x"][part], -1e3 * trace["torque"][part]


def _axes() -> tuple[Figure, Any]:
    """A picture that can be read on a telephone: half a page wide on a screen, all of it there."""
    figure = Figure(figsize=(5.0, 4.0), dpi=160, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.grid(True, color="#E3E3E3", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_ylim(-2, 30)
    return figure, axes


def draw(demo: Path, usual: Mapping[str, Any], k_l: float, folder: Path) -> tuple[Path, Path]:
    """Draw the traces of the folder ``demo`` as PICTURES into ``folder``.

    ``usual`` is the report's row of the motor: the stiffest stable walls, N·m/rad. ``k_l`` is the
    motor's own spring.
    """
    taps, analog = load_trace(demo), load_trace(demo / "analog")
    figure, axes = _axes()
    once = taps["t"] < TAP_S
    for trace, label, style in (
        (analog, "the paper's analog circuit", {"color": _ORANGE, "lw": 4.0}),
        (taps, "this Verilog, ADC bits to gates", {"color": _BLUE, "lw": 1.3}),
    ):
        axes.plot(trace["t"][once] * 1e3, -1e3 * trace["torque"][once], label=label, **style)
    axes.set_title("A finger taps a virtual wall", fontsize=12, loc="left")
    axes.set_xlabel("Time, ms", fontsize=11)
    axes.set_ylabel("Force of the wall, mN·m", fontsize=11)
    axes.legend(loc="upper left", frameon=False, fontsize=10)
    tap = save_figure(figure, folder / PICTURES[0])

    depth, push = way_in(load_trace(demo / "stiffest"))
    figure, axes = _axes()
    end = 11.0
    axes.plot([0, end], [0, end * k_l], color="#000000", lw=1.2, ls="--",
              label=f"the motor's own spring, {k_l:.2f} N·m/rad")  # fmt: skip
    axes.plot(
        np.r_[-3.0, 0.0, depth],
        np.r_[0.0, 0.0, push],
        color=_BLUE,
        lw=2.2,
        label="wave wall, this Verilog",
    )
    label = f"encoder, servo at 1 kHz, light hand:\nstiffest stable {usual['encoder']:.2g}"
    axes.plot([-3, 0, end], [0, 0, end * usual["encoder"]], color=_RED, lw=2.2, label=label)
    axes.set_title("Stiffest walls, the servo at 1 kHz", fontsize=12, loc="left")
    axes.set_xlabel("Depth, mrad", fontsize=11)
    axes.set_ylabel("Force of the wall, mN·m", fontsize=11)
    axes.set_xlim(-3, end)
    axes.legend(loc="upper left", frameon=False, fontsize=10)
    return tap, save_figure(figure, folder / PICTURES[1])
