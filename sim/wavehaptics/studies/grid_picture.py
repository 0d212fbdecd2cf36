# SPDX-License-Identifier: Apache-2.0
"""The picture of a sweep: metrics over the first key, a line for each value of the others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from wavehaptics.scene.keys import as_number, nearest
from wavehaptics.studies.grid import ERROR, Row
from wavehaptics.studies.sweeps import SweepError
from wavehaptics.trace.pictures import save_figure

SHOWN = (
    "stiffness", "tip_stiffness", "torque_nrmse_vs_analog", "hold_offset_rad", "hold_ripple_rms",
    "contact_energy_ratio", "peak_torque",
)  # fmt: skip
"""Metrics that are drawn by default, as far as the rows have them."""
MOST_SHOWN = 4
MOST_LINES = 12
LOG_SPAN = 30.0
"""Largest over smallest value from which on an axis is logarithmic."""


def draw(rows: Sequence[Row], keys: Sequence[str], metrics: Sequence[str], path: Path) -> list[str]:
    """Draw ``metrics`` of a sweep's rows into ``path``, a PNG, and return their names.

    By default up to MOST_SHOWN of SHOWN. :class:`SweepError` for a metric that the rows don't have.
    """
    known = [name for name in rows[0] if name not in (*keys, ERROR)]
    for name in metrics:
        if name not in known:
            near = nearest(name, known)
            meant = f"did you mean {near}?" if near else f"the rows have {', '.join(known)}"
            raise SweepError(f"--plot {name}: no such metric; {meant}")
    shown = list(metrics) or [name for name in SHOWN if any(map(_is_number, _of(rows, name)))]
    shown = shown if metrics else shown[:MOST_SHOWN]
    figure = Figure(figsize=(8.0, 1.0 + 2.5 * max(1, len(shown))), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    strips = figure.subplots(max(1, len(shown)), 1, sharex=True, squeeze=False)[:, 0]
    lines: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        lines.setdefault(tuple(row[key] for key in keys[1:]), []).append(row)
    for strip, name in zip(strips, shown, strict=False):
        for others, of_line in list(lines.items())[:MOST_LINES]:
            label = ", ".join(
                f"{key} = {_shown(value)}" for key, value in zip(keys[1:], others, strict=True)
            )
            drawn = [row for row in of_line if _is_number(row.get(name))]
            x = [_place(row[keys[0]]) for row in drawn]
            strip.plot(x, [row[name] for row in drawn], "o-", label=label or None)
        strip.set_ylabel(name)
        strip.grid(True, color="#E3E3E3")
    places = [_place(row[keys[0]]) for row in rows]
    numbers = [place for place in places if not isinstance(place, str)]
    if len(numbers) == len(places) and min(numbers) > 0 and max(numbers) > LOG_SPAN * min(numbers):
        strips[0].set_xscale("log")
    strips[-1].set_xlabel(keys[0])
    if len(keys) > 1 and shown:
        strips[0].legend(fontsize="small")
    save_figure(figure, path)
    return shown


def _of(rows: Sequence[Row], name: str) -> list[Any]:
    return [row.get(name) for row in rows]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _place(value: Any) -> float | str:
    """Where a value is on the axis: numbers by their size, others by their names."""
    return value if _is_number(value) and not isinstance(value, bool) else str(value)


def _shown(value: Any) -> str:
    return as_number(value) if _is_number(value) else str(value)
