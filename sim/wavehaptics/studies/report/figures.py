# SPDX-License-Identifier: Apache-2.0
"""How the report's pictures look."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from wavehaptics.trace.pictures import save_figure

# Okabe and Ito's colours, told apart by colour-blind readers too.
BLACK, ORANGE, GREEN, BLUE, RED, PINK, SKY, GREY = (
    "#000000", "#E69F00", "#009E73", "#0072B2", "#D55E00", "#CC79A7", "#56B4E9", "#7F7F7F",
)  # fmt: skip
COLOURS = (BLUE, ORANGE, GREEN, RED, PINK, SKY, GREY, BLACK)
MARKERS = "osD^vPX*"

_WIDTH_IN, _DPI = 10.0, 120


def panels(columns: int = 1, height_in: float = 4.2) -> tuple[Figure, list[Axes]]:
    """A figure of the page's width with panels side by side."""
    figure = Figure(figsize=(_WIDTH_IN, height_in), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = list(figure.subplots(1, columns, squeeze=False)[0])
    for ax in axes:
        ax.grid(True, which="major", color="#E3E3E3", linewidth=0.6)
        ax.set_axisbelow(True)
        ax.spines[["top", "right"]].set_visible(False)
    return figure, axes


def label(ax: Axes, x: str, y: str, title: str = "") -> None:
    """Axis labels and a title at the left."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    if title:
        ax.set_title(title, loc="left", fontsize=10.5)


def curve(ax: Axes, x: list[float], y: list[float | None], n: int, name: str, **style: Any) -> None:
    """A curve in the look of its number ``n``; points without a value are left out."""
    points = np.array([(a, b) for a, b in zip(x, y, strict=True) if b is not None], float)
    if not len(points):
        return
    look: dict[str, Any] = {
        "color": COLOURS[n % 8],
        "marker": MARKERS[n % 8],
        "ms": 5,
        "lw": 1.6,
    } | style
    ax.plot(points[:, 0], points[:, 1], label=name, **look)


def note(ax: Axes, text: str, at: tuple[float, float]) -> None:
    """A few words beside a point."""
    ax.annotate(text, at, xytext=(6, 4), textcoords="offset points", fontsize=8)


def legend(ax: Axes, **options: Any) -> None:
    """A legend inside the axes, where there is most room."""
    if ax.get_legend_handles_labels()[0]:
        ax.legend(frameon=False, fontsize=9, **options)


save = save_figure
