# SPDX-License-Identifier: Apache-2.0
"""A device's picture: the tip's path over its surfaces with the forces, and both over time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from wavehaptics.scene import Space
from wavehaptics.trace.pictures import envelope, save_figure
from wavehaptics.trace.tip import deepest

_BLUE, _ORANGE, _GREY, _SOLID = "#0072B2", "#D55E00", "#7F7F7F", "#E3E3E3"
_ARROWS = 24
_GRID = 240
_MARGIN = 0.25
"""Part of the path's extent that is shown around it."""


def view(space: Space, tip: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Two axes of the picture (2, 3): along the surface, where the path is longest, and outwards.

    ``tip`` (n, 3) in m; without a contact x and y.
    """
    if not active.any():
        return np.eye(3)[:2]
    first = tip[np.argmax(active > 0)]
    outward = -deepest(space, first[None, :])[1][0]
    flat = tip - tip.mean(axis=0)
    flat = flat - np.outer(flat @ outward, outward)
    along = np.linalg.svd(flat, full_matrices=False)[2][0]
    along -= outward * (along @ outward)
    length = np.linalg.norm(along)
    if length < 1e-6:  # it only pressed
        along = np.cross(outward, np.eye(3)[np.argmin(np.abs(outward))])
        length = np.linalg.norm(along)
    along = along / length
    return np.array([along if along[np.argmax(np.abs(along))] > 0 else -along, outward])


def tip_picture(
    space: Space, arrays: Mapping[str, np.ndarray], metrics: Mapping[str, Any], path: Path
) -> Path:
    """Draw ``arrays`` of :class:`~wavehaptics.trace.tip.TipTrace` as PNG; returns ``path``."""
    tip, hand, force, t = (arrays[name] for name in ("tip", "hand", "force", "t"))
    figure = Figure(figsize=(10.0, 5.6), dpi=160, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplot_mosaic([["path", "force"], ["path", "place"]], width_ratios=[1.1, 1.0])
    axis = view(space, tip, arrays["active"])
    seen, led = 1e3 * tip @ axis.T, 1e3 * hand @ axis.T
    ax = axes["path"]
    both = np.concatenate((seen, led))
    low, high = both.min(axis=0), both.max(axis=0)
    middle, half = 0.5 * (low + high), (0.5 + _MARGIN) * max(*(high - low), 1e-3)
    steps = np.linspace(-half, half, _GRID)
    right, up = np.meshgrid(middle[0] + steps, middle[1] + steps)
    off = tip.mean(axis=0) - axis.T @ (axis @ tip.mean(axis=0))
    grid = off + 1e-3 * (right[..., None] * axis[0] + up[..., None] * axis[1])
    if space.surface:
        depth = deepest(space, grid.reshape(-1, 3))[0].reshape(right.shape)
        ax.contourf(right, up, depth, levels=[0.0, np.inf], colors=[_SOLID])
        ax.contour(right, up, depth, levels=[0.0], colors=[_GREY], linewidths=1.0)
    ax.plot(*led.T, color=_GREY, lw=1.0, ls=":", label="hand")
    ax.plot(*seen.T, color=_BLUE, lw=1.6, label="tip")
    shown = np.linspace(0, len(t) - 1, _ARROWS).astype(int)
    push = force @ axis.T
    largest = float(np.linalg.norm(push, axis=1).max()) or 1.0
    ax.quiver(
        *seen[shown].T, *push[shown].T, color=_ORANGE, angles="xy", scale_units="xy",
        scale=largest / (0.4 * half), width=0.005, label=f"force, at most {largest:.3g} N",
    )  # fmt: skip
    ax.set_aspect("equal")
    ax.set_xlim(middle[0] - half, middle[0] + half)
    ax.set_ylim(middle[1] - half, middle[1] + half)
    ax.set_xlabel("along the surface, mm")
    ax.set_ylabel("out of it, mm")
    ax.legend(loc="upper right", fontsize=8, frameon=False)
    depth, normal, _ = deepest(space, tip)
    along = -np.einsum("ij,ij->i", force, normal)
    across = np.linalg.norm(force + along[:, None] * normal, axis=1)
    axes["force"].plot(*envelope(t, along), color=_BLUE, lw=1.2, label="along the normal")
    axes["force"].plot(*envelope(t, across), color=_ORANGE, lw=1.0, label="across")
    axes["force"].set_ylabel("Force of the motors, N")
    axes["force"].legend(loc="upper right", fontsize=8, frameon=False)
    if np.isfinite(depth).all():
        axes["place"].plot(*envelope(t, 1e3 * depth), color=_BLUE, lw=1.2)
        deep = 1e3 * float(depth.max())
        if deep > 0.0:  # the way there is longer by far
            axes["place"].set_ylim(-0.5 * deep, 1.1 * deep)
    axes["place"].set_ylabel("Depth of the tip, mm")
    axes["place"].set_xlabel("time, s")
    for name in ("force", "place"):
        axes[name].grid(True, color=_SOLID, linewidth=0.6)
        axes[name].spines[["top", "right"]].set_visible(False)
    stiffness = metrics.get("tip_stiffness")
    told = "" if stiffness is None else f" · K = {stiffness:.4g} N/m"
    title = f"{metrics['scene']} · controller {metrics['controller']}{told}"
    figure.suptitle(title, x=0.01, ha="left", fontsize=11)
    return save_figure(figure, path)
