# SPDX-License-Identifier: Apache-2.0
"""Pictures of runs, from the arrays of ``trace.npz`` and the numbers of ``metrics.json``.

Every function draws from dictionaries of arrays (:func:`wavehaptics.trace.columns.load_trace`) and
writes one PNG 1600 pixels wide. Arrays may be of any length: a strip over time is drawn
as its lowest and highest value in each of 1600 columns, so that no peak is lost.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter1d

from wavehaptics.runtime.files import replacing

Trace = Mapping[str, np.ndarray]
Walls = Sequence[tuple[float, float]]

PAPER_K_L = 2.2815
"""K_L of the paper's motor, N·m/rad."""
PAPER_MEASURED = 1.9
"""Stiffness that the paper measured on its prototype, N·m/rad."""

# Okabe and Ito's colours, told apart by colour-blind readers too.
_BLACK, _ORANGE, _GREEN = "#000000", "#E69F00", "#009E73"
_BLUE, _RED, _PINK, _GREY = "#0072B2", "#D55E00", "#CC79A7", "#7F7F7F"
_PALE_BLUE = "#BFDDF0"
_SMOOTHING_S = 5e-3

_WIDTH_IN, _DPI, _COLUMNS = 10.0, 160, 1600
_PATH_POINTS = 20_000


def envelope(t: np.ndarray, y: np.ndarray, columns: int = _COLUMNS) -> tuple[np.ndarray, ...]:
    """``y`` over ``t`` with at most 4 · ``columns`` points that look the same.

    Each column of the picture keeps its lowest and its highest value, in the order in which they
    came, between its first and its last. Both arrays have shape (n,); short ones come back as they
    are.
    """
    if len(t) <= 4 * columns:
        return t, y
    edges = np.linspace(0, len(t), columns + 1).astype(np.int64)
    kept = np.empty((columns, 4), dtype=np.int64)
    for n, (start, end) in enumerate(pairwise(edges)):
        part = y[start:end]
        kept[n] = start, start + int(part.argmin()), start + int(part.argmax()), end - 1
    order = np.sort(kept, axis=1).ravel()
    return t[order], y[order]


def _figure(height_in: float, rows: int = 1, ratios: Sequence[float] | None = None) -> Any:
    """A figure and its strips from top to bottom, which share the axis of time."""
    figure = Figure(figsize=(_WIDTH_IN, height_in), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False, height_ratios=ratios)[:, 0]
    for ax in axes:
        ax.grid(True, color="#E3E3E3", linewidth=0.6)
        ax.set_axisbelow(True)
        ax.spines[["top", "right"]].set_visible(False)
    return figure, axes


def save_figure(figure: Figure, path: Path | str) -> Path:
    """Write a figure as PNG, whole or not at all; returns its path. The directory is made."""
    path = Path(path)
    with replacing(path) as part:
        figure.savefig(part, dpi=figure.dpi, format="png")
    return path


def _legend(ax: Axes, columns: int = 4) -> None:
    """A legend above the axes, at their right end, where no data are."""
    ax.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=columns,
        frameon=False,
        fontsize=9,
        borderaxespad=0.2,
        handlelength=1.8,
        columnspacing=1.4,
    )


def _title(figure: Figure, metrics: Mapping[str, Any], text: str) -> None:
    motor = f", {metrics['motor']}" if "motor" in metrics else ""
    figure.suptitle(
        f"{metrics['scene']}{motor} · controller {metrics['controller']} · {text}",
        x=0.01,
        ha="left",
        fontsize=11,
    )


def _spans(trace: Trace, key: str, scale: float) -> list[tuple[float, float]]:
    """(start, length) of the times in which ``key`` is set; less than a pixel apart they join."""
    t, flag = trace["t"], trace[key].astype(bool)
    change = np.flatnonzero(np.diff(np.concatenate(([False], flag, [False])).astype(np.int8)))
    if not change.size:
        return []
    starts, ends = t[change[::2]], t[np.minimum(change[1::2], len(t) - 1)]
    pixel = (t[-1] - t[0]) / _COLUMNS
    apart = np.flatnonzero(starts[1:] - ends[:-1] > pixel) + 1
    starts, ends = starts[np.r_[0, apart]], ends[np.r_[apart - 1, len(ends) - 1]]
    return [(scale * start, scale * (end - start)) for start, end in zip(starts, ends, strict=True)]


def _bars(ax: Axes, spans: list[tuple[float, float]], height: float, **style: Any) -> None:
    """Bars over ``spans`` of the time axis, from the foot of the strip to a part of its height."""
    if spans:
        ax.broken_barh(spans, (0.0, height), transform=ax.get_xaxis_transform(), lw=0, **style)


def _shade_contact(axes: Sequence[Axes], scale: float, trace: Trace) -> None:
    """Grey where the run is in contact."""
    spans = _spans(trace, "contact", scale)
    for ax in axes:
        label = {"label": "in contact"} if ax is axes[0] else {}
        _bars(ax, spans, 1.0, color="#EFEFEF", zorder=0, **label)


def _end_time_axis(figure: Figure, axes: Sequence[Axes], trace: Trace, scale: float) -> None:
    first, last = trace["t"][0], trace["t"][-1]
    first = 0.0 if 0.0 < first < 0.01 * last else first  # the first row is half a tick late
    if first < last:  # a trace may have one row
        axes[-1].set_xlim(first * scale, last * scale)
    figure.align_ylabels(axes)


def _wall_lines(ax: Axes, metrics: Mapping[str, Any], walls: Walls, x: np.ndarray) -> None:
    """The walls' edges within reach of ``x``, drawn over milliradians."""
    edges = {edge for wall in walls for edge in wall}
    if metrics.get("contact_edge_rad") is not None:
        edges.add(metrics["contact_edge_rad"])
    low, high = float(x.min()), float(x.max())
    margin = 0.05 * (high - low)
    near = [edge for edge in sorted(edges) if low - margin <= edge <= high + margin]
    for n, edge in enumerate(near):
        label = "wall's edge" if n == 0 else None
        ax.axhline(edge * 1e3, color=_BLACK, lw=1.0, ls=(0, (1, 1.5)), label=label)


def _time_scale(trace: Trace) -> tuple[float, str]:
    return (1e3, "Time, ms") if trace["t"][-1] - trace["t"][0] < 1.0 else (1.0, "Time, s")


def _strip(ax: Axes, scale: float, trace: Trace, y: np.ndarray, **style: Any) -> None:
    t, y = envelope(trace["t"], y)
    look: dict[str, Any] = {"lw": 1.3, "color": _BLUE, "solid_joinstyle": "round"} | style
    ax.plot(t * scale, y, **look)


_REFERENCE_STYLE = {"color": _ORANGE, "lw": 3.2}
_HAND_STYLE = {"color": _GREEN, "lw": 1.1, "ls": "--"}


def _draw_hand(ax: Axes, scale: float, trace: Trace, metrics: Mapping[str, Any]) -> None:
    """The hand over the positions in ``ax``; on the path ``impact`` the rotor is bare.

    A soft hand goes much farther than the rotor, so it may take no more than the rotor's own height
    above and below it.
    """
    if metrics.get("hand") in (None, "impact"):
        return
    low, high = ax.get_ylim()
    _strip(ax, scale, trace, 1e3 * trace["x_hand"], label="hand", **_HAND_STYLE)
    lowest, highest = ax.get_ylim()
    ax.set_ylim(max(lowest, 2.0 * low - high), min(highest, 2.0 * high - low))


def _number(value: float | None, unit: str, factor: float = 1.0, digits: int = 4) -> str:
    return "–" if value is None else f"{value * factor:.{digits}g} {unit}".rstrip()


def _prefix(largest: float) -> tuple[float, str]:
    """Factor and SI prefix that bring ``largest`` to 1 or above, of milli, micro and nano."""
    for factor, prefix in ((1e3, "m"), (1e6, "µ")):
        if largest * factor >= 1.0:
            return factor, prefix
    return 1e9, "n"


def _power(value: float) -> str:
    """``value`` as a number times a power of ten."""
    mantissa, exponent = f"{value:.1e}".split("e")
    return rf"${mantissa} \cdot 10^{{{int(exponent)}}}$"


def _path(x: np.ndarray, y: np.ndarray, points: int = _PATH_POINTS) -> np.ndarray:
    """Places of at most ``points`` rows spread evenly along the drawn path, so that fast parts of
    it keep as many as slow ones."""
    if len(x) <= points:
        return np.arange(len(x))
    width, height = np.ptp(x) or 1.0, np.ptp(y) or 1.0
    way = np.cumsum(np.hypot(np.diff(x, prepend=x[0]) / width, np.diff(y, prepend=y[0]) / height))
    return np.flatnonzero(np.diff(np.floor(way * (points / (way[-1] or 1.0))), prepend=-1.0))


def _same_ticks(run: Trace, reference: Trace) -> bool:
    """Whether two traces have their rows at the same times, to a tenth of the first tick."""
    t, other = run["t"], reference["t"]
    return t.shape == other.shape and np.allclose(t, other, rtol=0.0, atol=0.2 * abs(other[0]))


def _smoothed(trace: Trace, y: np.ndarray) -> np.ndarray:
    """Moving average of ``y`` over :data:`_SMOOTHING_S`."""
    step_s = (trace["t"][-1] - trace["t"][0]) / max(1, len(y) - 1)
    rows = max(1, min(len(y), round(_SMOOTHING_S / step_s)))
    smooth: np.ndarray = uniform_filter1d(y, rows, mode="nearest")
    return smooth


def time_plot(
    run: Trace,
    reference: Trace | None,
    metrics: Mapping[str, Any],
    path: Path | str,
    walls: Walls = (),
) -> Path:
    """Position, torque and motor voltage over time, as the paper's Fig. 10.

    The analog ``reference`` lies as a broad line behind the run; below it their difference in
    torque gets a strip of its own, as it would not be seen. ``walls`` in rad. Returns ``path``.
    """
    compared = reference is not None and _same_ticks(run, reference)
    ratios = [1.2, 1.0, 1.0, 0.7] if compared else [1.2, 1.0, 1.0]
    figure, axes = _figure(8.2 if compared else 7.0, len(ratios), ratios)
    scale, time_label = _time_scale(run)
    name = str(metrics["controller"])
    _shade_contact(axes, scale, run)
    for ax, key, factor in zip(axes, ("x", "torque", "e_a"), (1e3, 1e3, 1.0), strict=False):
        if reference is not None:
            behind = {"label": "analog"} if key == "x" else {}
            _strip(ax, scale, reference, factor * reference[key], **_REFERENCE_STYLE, **behind)
        label = {"label": name} if key == "x" else {}
        if key == "e_a" and name == "pins":
            # The pulses come in whole clocks, so single ticks jump by the step of one.
            _strip(ax, scale, run, run[key], color=_PALE_BLUE, lw=0.5, label="single ticks")
            label = {"label": f"mean over {1e3 * _SMOOTHING_S:g} ms"}
            _strip(ax, scale, run, _smoothed(run, run[key]), **label)
            _legend(ax)
            continue
        _strip(ax, scale, run, factor * run[key], **label)
    _draw_hand(axes[0], scale, run, metrics)
    _wall_lines(axes[0], metrics, walls, run["x"])
    axes[0].set_ylabel("Position $x$, mrad")
    axes[1].set_ylabel("Torque $F$, mN·m")
    axes[2].set_ylabel("Voltage $e_a$, V")
    if reference is not None and compared:
        _strip(axes[3], scale, run, 1e6 * (run["torque"] - reference["torque"]), lw=0.9)
        axes[3].set_ylabel("$F - F_{analog}$,\nµN·m")
    axes[-1].set_xlabel(time_label)
    _end_time_axis(figure, axes, run, scale)
    _legend(axes[0], 5)
    error = metrics.get("torque_nrmse_vs_analog")
    text = f"peak torque {_number(metrics['peak_torque'], 'mN·m', 1e3, 3)}"
    if error is not None:
        text += f" · RMS torque error {_power(error)} of the analog peak"
    _title(figure, metrics, text)
    return save_figure(figure, path)


def force_plot(
    run: Trace, reference: Trace | None, metrics: Mapping[str, Any], path: Path | str
) -> Path:
    """−F over x of all contacts, as the paper's Fig. 11, with the springs that it should follow.

    Lines through the wall's edge: K_L, the predicted stiffness, and for the paper's motor what the
    paper measured; through its own zero the line that was fitted to the first contact. Returns
    ``path``.
    """
    figure, (ax,) = _figure(6.6)
    edge = metrics.get("contact_edge_rad")
    over = {"color": _BLUE, "lw": 1.1, "zorder": 3}  # the springs lie between the two
    for trace, style in ((reference, _REFERENCE_STYLE | {"zorder": 1.9}), (run, over)):
        if trace is None:
            continue
        at = _path(trace["x"], trace["torque"])
        label = "analog" if trace is reference else str(metrics["controller"])
        ax.plot(
            1e3 * trace["x"][at],
            -1e3 * trace["torque"][at],
            label=label,
            solid_joinstyle="round",
            **style,
        )
    if edge is not None:
        _spring_lines(ax, run, metrics, edge)
    ax.set_xlabel("Position $x$, mrad")
    ax.set_ylabel("Torque $-F$, mN·m")
    # Above the axes: the data may lie in any corner of them.
    ax.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0, 1.0, 0.1),
        mode="expand",
        ncols=3,
        frameon=False,
        fontsize=9,
    )
    measured, predicted = metrics.get("stiffness"), metrics.get("stiffness_predicted")
    text = f"K = {_number(measured, 'N·m/rad')}"
    if measured is not None and predicted:
        off = measured / predicted - 1.0
        if abs(off) < 1e-4:
            text += ", within 0.01 % of the prediction"
        else:
            way = "above" if off > 0.0 else "below"
            text += f", {100.0 * abs(off):.2f} % {way} the prediction"
    _title(figure, metrics, text)
    return save_figure(figure, path)


def _spring_lines(ax: Axes, run: Trace, metrics: Mapping[str, Any], edge: float) -> None:
    """Springs from the wall's edge to the run's largest push, and the axes' limits."""
    touched = run["contact"].astype(bool)
    depths = run["x"][touched] - edge
    if not depths.size:
        return
    side = 1.0 if abs(depths.max()) >= abs(depths.min()) else -1.0
    top = 1.06 * max(float((-side * run["torque"][touched]).max()), 1e-12)
    deepest = float((side * depths).max())
    zero = metrics.get("stiffness_zero_rad")
    lines: list[tuple[Any, Any, str, dict[str, Any]]] = [
        (metrics["k_l"], edge, "$K_L$", {"color": _BLACK, "ls": "--"}),
        (metrics["stiffness_predicted"], edge, "predicted", {"color": _GREEN, "ls": "-."}),
        (metrics["stiffness"], zero, "fitted", {"color": _RED, "ls": (0, (5, 1.5))}),
    ]
    if math.isclose(metrics["k_l"], PAPER_K_L, rel_tol=1e-4):
        lines.append(
            (PAPER_MEASURED, edge, "measured in the paper", {"color": _PINK, "ls": (0, (1, 1))})
        )
    for k, start, label, style in lines:
        if k is None or start is None or k <= 0.0:
            continue
        x = np.array([start, start + side * top / k])
        ax.plot(
            1e3 * x,
            1e3 * np.array([0.0, side * top]),
            lw=2.2,
            zorder=2,
            label=f"{label}: {k:.5g} N·m/rad",
            **style,
        )
    ax.axvline(1e3 * edge, color=_GREY, lw=0.8)
    ax.axhline(0.0, color=_GREY, lw=0.8)
    # From a quarter of the depth outside the wall on; the free motion beyond says nothing.
    ends = 1e3 * np.array([edge - side * 0.25 * deepest, edge + side * 1.08 * deepest])
    ax.set_xlim(ends.min(), ends.max())
    near = side * (run["x"] - edge) >= -0.25 * deepest
    pushes = -run["torque"][near]
    low, high = min(float(pushes.min()), 0.0), max(float(pushes.max()), 0.0)
    margin = 0.08 * (high - low) or 1e-6
    ax.set_ylim(1e3 * (low - margin), 1e3 * (high + margin))


def fig10(
    run: Trace,
    reference: Trace | None,
    metrics: Mapping[str, Any],
    path: Path | str,
    walls: Walls = (),
) -> Path:
    """The paper's Fig. 10: :func:`time_plot` of the wall taps."""
    return time_plot(run, reference, metrics, path, walls)


def fig11(
    run: Trace, reference: Trace | None, metrics: Mapping[str, Any], path: Path | str
) -> Path:
    """The paper's Fig. 11: :func:`force_plot` of the wall taps."""
    return force_plot(run, reference, metrics, path)


def run_picture(
    trace: Trace, metrics: Mapping[str, Any], path: Path | str, walls: Walls = ()
) -> Path:
    """What every run leaves: position, torque, waves, η and the port's energy over time.

    ``walls`` in rad. Returns ``path``.
    """
    # Waves and η can't be seen at a board's pins.
    waves = bool(np.isfinite(trace["u"]).any())
    heights = [1.3, 1.0, *([1.0, 0.45] if waves else []), 0.8]
    figure, axes = _figure(9.0 if waves else 6.5, len(heights), heights)
    scale, time_label = _time_scale(trace)
    _shade_contact(axes, scale, trace)
    _strip(axes[0], scale, trace, 1e3 * trace["x"], label="x")
    _draw_hand(axes[0], scale, trace, metrics)
    _wall_lines(axes[0], metrics, walls, trace["x"])
    axes[0].set_ylabel("Position $x$, mrad")
    _strip(axes[1], scale, trace, 1e3 * trace["torque"])
    axes[1].set_ylabel("Torque $F$, mN·m")
    if waves:
        _strip(axes[2], scale, trace, trace["v"], label="v, from the motor", color=_ORANGE, lw=2.4)
        _strip(axes[2], scale, trace, trace["u"], label="u, to the motor")
        axes[2].set_ylabel("Waves, √W")
        _legend(axes[2])
        _strip(axes[3], scale, trace, trace["eta"], drawstyle="steps-mid")
        axes[3].set_ylabel("η")
        axes[3].set_ylim(-1.2, 1.2)
        axes[3].set_yticks([-1, 0, 1])
    energy = trace["energy_out"]
    factor, prefix = _prefix(float(np.abs(energy).max()))
    _strip(axes[-1], scale, trace, factor * energy)
    axes[-1].set_ylabel(f"Energy out, {prefix}J")
    limited = _spans(trace, "saturated", scale)
    if limited:
        _bars(axes[1], limited, 0.04, color=_RED, label="voltage at its limit")
        _legend(axes[1])
    axes[-1].set_xlabel(time_label)
    _end_time_axis(figure, axes, trace, scale)
    _legend(axes[0])
    text = f"{metrics['duration_s']:.6g} s · peak torque "
    text += _number(metrics["peak_torque"], "mN·m", 1e3, 3)
    if metrics.get("stiffness") is not None:
        text += f" · K = {_number(metrics['stiffness'], 'N·m/rad')}"
    if metrics.get("restitution") is not None:
        text += f" · restitution {_number(metrics['restitution'], '')}"
    _title(figure, metrics, text)
    return save_figure(figure, path)


def strips_picture(
    trace: Trace, strips: Mapping[str, tuple[np.ndarray, str]], title: str, path: Path | str
) -> Path:
    """A strip over time for each of ``strips``: by its label the values, and their unit.

    ``trace`` has ``t``, ``contact`` and ``saturated``; where it is in contact is grey, and a dotted
    line is at t = 0 if that isn't an end. Returns ``path``.
    """
    figure, axes = _figure(1.0 + 1.5 * len(strips), len(strips))
    scale, time_label = _time_scale(trace)
    _shade_contact(axes, scale, trace)
    for ax, (label, (values, unit)) in zip(axes, strips.items(), strict=True):
        largest = float(np.abs(values).max())
        factor, prefix = _prefix(largest) if unit and 0.0 < largest < 1.0 else (1.0, "")
        _strip(ax, scale, trace, factor * values)
        ax.set_ylabel(f"{label}, {prefix}{unit}" if unit else label)
        if trace["t"][0] < 0.0 < trace["t"][-1]:
            ax.axvline(0.0, color=_BLACK, lw=1.0, ls=(0, (1, 1.5)))
    _bars(
        axes[0], _spans(trace, "saturated", scale), 0.04, color=_RED, label="voltage at its limit"
    )
    if axes[0].get_legend_handles_labels()[1]:
        _legend(axes[0])
    axes[-1].set_xlabel(time_label)
    _end_time_axis(figure, axes, trace, scale)
    figure.suptitle(title, x=0.01, ha="left", fontsize=11)
    return save_figure(figure, path)
