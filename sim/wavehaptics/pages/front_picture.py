# SPDX-License-Identifier: Apache-2.0
"""The README's first picture: what ``make demo`` made, beside the usual way's stiffest wall."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from wavehaptics.trace.columns import load_trace

TAP_S = 0.5
"""One tap of the demo's scenes."""

MOTOR = "re25-118743"
"""The demo's."""

_BLUE, _ORANGE, _RED = "#0072B2", "#E69F00", "#D55E00"


def usual(ratios: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The report's row of the demo's motor, with an encoder's servo at 1 kHz beside the waves."""
    return next(row for row in ratios if row["motor"] == MOTOR)


def way_in(trace: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Depth in mrad and push in mN·m from the first contact to the first tap's deepest point."""
    tap = trace["t"] < TAP_S
    part = slice(int(np.argmax(trace["contact"][tap])), int(np.argmax(trace["x"][tap])) + 1)
    return 1e3 * trace["x"][part], -1e3 * trace["torque"][part]


def draw(demo: Path, usual: dict[str, Any], k_l: float, path: Path) -> Path:
    """Draw the traces of the folder ``demo`` into ``path``.

    ``usual`` is the report's row of the motor: the stiffest stable walls, N·m/rad. ``k_l`` is the
    motor's own spring.
    """
    taps, analog = load_trace(demo), load_trace(demo / "analog")
    stiff = load_trace(demo / "stiffest")
    figure = Figure(figsize=(10.0, 4.0), dpi=160, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])

    once = taps["t"] < TAP_S
    for trace, label, style in (
        (analog, "the paper's analog circuit", {"color": _ORANGE, "lw": 4.0}),
        (taps, "this Verilog, ADC bits to gates", {"color": _BLUE, "lw": 1.3}),
    ):
        left.plot(trace["t"][once] * 1e3, -1e3 * trace["torque"][once], label=label, **style)
    left.set_title("A finger taps a virtual wall", fontsize=11, loc="left")
    left.set_xlabel("Time, ms")
    left.set_ylabel("Force of the wall, mN·m")
    left.set_ylim(-2, 30)
    left.legend(loc="upper left", frameon=False, fontsize=9)

    depth, push = way_in(stiff)
    end = 11.0
    right.plot([0, end], [0, end * k_l], color="#000000", lw=1.2, ls="--",
               label=f"the motor's own spring, {k_l:.2f} N·m/rad")  # fmt: skip
    right.plot(
        np.r_[-3.0, 0.0, depth],
        np.r_[0.0, 0.0, push],
        color=_BLUE,
        lw=2.2,
        label="wave wall, this Verilog",
    )
    label = f"encoder, servo at 1 kHz, light hand:\nstiffest stable {usual['encoder']:.2g}"
    right.plot([-3, 0, end], [0, 0, end * usual["encoder"]], color=_RED, lw=2.2, label=label)
    right.set_title("Stiffest walls; the encoder's servo at 1 kHz", fontsize=11, loc="left")
    right.set_xlabel("Depth, mrad")
    right.set_xlim(-3, end)
    right.set_ylim(-2, 30)
    right.legend(loc="upper left", frameon=False, fontsize=9)
    for ax in (left, right):
        ax.grid(True, color="#E3E3E3", linewidth=0.6)
        ax.set_axisbelow(True)
        ax.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=160)
    return path
