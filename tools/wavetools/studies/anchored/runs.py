# SPDX-License-Identifier: Apache-2.0
"""One run of a scene under a disturbance, and what the study asks of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from wavehaptics.ladder.run import CONTROLLERS, measure, stiffness_predicted
from wavehaptics.laws import closed_forms
from wavehaptics.scene import Scene
from wavehaptics.studies.report.runs import load
from wavehaptics.trace.columns import Column

PLAIN = "controller.anchor_auto=false"

KEPT = ("hold_offset_rad", "hold_error", "hold_ripple_rms", "restitution", "energy_out_max_j",
        "correction_out_max_j", "correction_bound_j", "anchor_fault_s", "saturated_fraction",
        "free_space_torque_rms", "peak_torque", "x_hat_error_rms_rad",
        "omega_hat_error_rms", "contact_energy_ratio", "swing_rad", "swing_hz")  # fmt: skip


LEAST_COUNTS = 2.0
"""An encoder can't tell what a shallower press does."""
AT_LIMIT = 0.97
"""Part of the voltage limit from which on it counts as at work."""


class Means:
    """Means over parts of a run, ``part_s`` long each, in place of a trace."""

    def __init__(self, part_s: float, tick_s: float) -> None:
        self._ticks = max(1, round(part_s / tick_s))
        self._left = np.zeros((0, len(Column)))
        self._parts: list[np.ndarray] = []

    def write(self, rows: np.ndarray, words: np.ndarray | None = None) -> None:
        """Take the next ticks, as :meth:`wavehaptics.trace.columns.TraceWriter.write` does."""
        del words
        rows = np.concatenate([self._left, rows])
        whole = len(rows) // self._ticks * self._ticks
        self._parts.append(rows[:whole].reshape(-1, self._ticks, len(Column)).mean(axis=1))
        self._left = rows[whole:].copy()

    def rows(self) -> np.ndarray:
        """The means, (parts, len(Column))."""
        return np.concatenate(self._parts)


def cell_of(scene: Scene) -> float:
    """Cell of the scene's encoder, rad."""
    assert scene.encoder is not None
    return 2 * math.pi / scene.encoder.counts_per_rev


def run(
    scene: Scene, controller: str = "golden", part_s: float | None = None
) -> tuple[dict[str, Any], np.ndarray]:
    """Metrics of a run; with ``part_s`` the means of its rows over that time, else no rows."""
    if part_s is None:
        return measure(scene, controller, compare=False), np.zeros((0, len(Column)))
    means = Means(part_s, 1.0 / scene.controller.tick_hz)
    return measure(scene, controller, trace=means, compare=False), means.rows()


def hold(scene: str, controller: str, settings: list[str]) -> dict[str, Any]:
    """Metrics of a held wall in cells, in parts of the depth and of the force."""
    loaded = load(scene, settings)
    try:
        metrics, _ = run(loaded, controller)
    except FloatingPointError:
        metrics = dict.fromkeys(KEPT)
    cell = cell_of(loaded)
    found = {"duration_s": loaded.scene.duration_s, "controller": controller, "cell_rad": cell}
    found |= {key: metrics[key] for key in KEPT}
    offset, part = metrics["hold_offset_rad"], metrics["hold_error"]
    found["force"] = found["depth_cells"] = found["moved_cells"] = None
    if offset is not None and part:
        depth = offset / part
        found["moved_cells"] = offset / cell
        found["depth_cells"] = abs(depth) / cell
        found["force"] = abs(metrics["stiffness_predicted"] * (depth - offset))
    return found


def rigid_stiffness(scene: Scene) -> float:
    """K of a rigid wall with an anchor, N·m/rad: of scenes whose soft walls lie on one."""
    set_ = CONTROLLERS["golden"](scene).settings
    k_t = math.sqrt(scene.motor.k_t * scene.controller.k_t_hat)
    return closed_forms.stiffness(k_t, scene.controller.l_hat, set_.r_hat, set_.tau)


def deviations(rows: np.ndarray, scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(which of ``rows`` are in contact, F/K + x − x_w of those in rad, their depths in rad).

    x_w is the edge nearest to where the contact began. Rows with contact in a part of their ticks
    are left out. The wall below a soft layer is the layer's end with the layer's force on it.
    """
    k = stiffness_predicted(scene, CONTROLLERS["golden"](scene))
    touching = rows[:, Column.CONTACT] == 1.0
    edges = np.array(scene.controller.walls).ravel()
    cell = cell_of(scene)
    edges = np.round(edges / cell) * cell
    layered = scene.shaper is not None and scene.shaper.walls is not None
    moved = np.zeros(len(rows))
    depth = np.zeros(len(rows))
    edge, inside = 0.0, False
    for n in range(len(rows)):
        if rows[n, Column.CONTACT] > 0.0 and not inside:
            edge = edges[np.argmin(np.abs(edges - rows[n, Column.X]))]
        inside = rows[n, Column.CONTACT] > 0.0
        depth[n] = rows[n, Column.X] - edge
        moved[n] = rows[n, Column.TORQUE] / k + depth[n]
    if layered:
        first, end = edges[0], edges[1]
        below = rows[:, Column.X] > end
        rigid = rigid_stiffness(scene)
        on_it = -k * (end - first)
        moved[below] = (rows[below, Column.TORQUE] - on_it) / rigid + rows[below, Column.X] - end
    return touching, moved[touching], np.abs(depth[touching])


def energies(rows: np.ndarray, scene: Scene, part_s: float) -> list[float]:
    """Of each of the hand's periods what the wall gave to the shaft, over the most that it held.

    ``∫ F dx`` of all touches of that period over its largest ``½F²/K``; below zero it took some. A
    period in which the wall is less than LEAST_COUNTS deep, or that the run ends in, is left out.
    """
    assert scene.hand is not None
    assert scene.hand.frequency_hz is not None
    k = stiffness_predicted(scene, CONTROLLERS["golden"](scene))
    touching = rows[:, Column.CONTACT] > 0.0
    torque = np.where(touching, rows[:, Column.TORQUE], 0.0)
    given = torque * rows[:, Column.OMEGA] * part_s
    # Half a step of a row early, as a row is the mean of its time.
    period = np.floor((rows[:, Column.T] - 0.5 * part_s) * scene.hand.frequency_hz).astype(int)
    found = []
    for n in range(math.floor(scene.scene.duration_s * scene.hand.frequency_hz + 1e-9)):
        force = float(np.max(np.abs(torque[period == n]), initial=0.0))
        if force > LEAST_COUNTS * k * cell_of(scene):
            found.append(float(np.sum(given[period == n])) / (0.5 * force**2 / k))
    return found


def swing(scene: str, settings: list[str]) -> dict[str, Any]:
    """How far a wall that is pressed and left moves at most, and what energy it gives.

    In cells and over its depth; ``first`` is the energy of the first press, when nothing is
    learned, ``later`` the largest of the others (:func:`energies`).
    """
    loaded = load(scene, settings)
    part_s = max(50e-6, 1.0 / loaded.controller.tick_hz)
    metrics, rows = run(loaded, part_s=part_s)
    touching, moved, depth = deviations(rows, loaded)
    cell = cell_of(loaded)
    found: dict[str, Any] = {"touched": int(np.count_nonzero(touching)), "cell_rad": cell}
    found |= {key: metrics[key] for key in KEPT}
    given = energies(rows, loaded, part_s)
    found["first"] = given[0] if given else None
    found["later"] = max(given[1:], default=None)
    if not len(moved):
        return found | dict.fromkeys(("moved_cells", "rms_cells", "depth_cells"))
    return found | {
        "moved_cells": float(np.max(np.abs(moved)) / cell),
        "rms_cells": float(np.sqrt(np.mean(moved**2)) / cell),
        "depth_cells": float(np.max(depth) / cell),
    }


def overload(settings: list[str], after_s: float = 0.05) -> dict[str, Any]:
    """Press into the voltage limit and back: how far off the wall is ``after_s`` later, in cells.

    The largest from then until 5 ms before the rotor leaves.
    """
    loaded = load("held_wall", settings)
    metrics, rows = run(loaded, part_s=100e-6)
    touching, moved, _ = deviations(rows, loaded)
    times = rows[touching, Column.T]
    # The waves may stay below their limit while c has no more room.
    assert loaded.drive is not None
    assert loaded.drive.limit_v is not None
    limit_v = loaded.drive.limit_v * (1.0 + loaded.drive.gain_error)
    limited = np.abs(rows[:, Column.E_A]) > AT_LIMIT * limit_v
    cell = cell_of(loaded)
    found = {key: metrics[key] for key in KEPT}
    found |= {"limited_s": float(np.count_nonzero(limited) * 100e-6), "moved_cells": None}
    if not limited.any() or not len(times):
        return found
    last = rows[limited, Column.T].max()
    # The contact in which the limit was last at work.
    left = rows[(rows[:, Column.T] > last) & (rows[:, Column.CONTACT] == 0.0), Column.T]
    end = left[0] if len(left) else rows[-1, Column.T] + 1.0
    late = (times > last + after_s) & (times < end - 5e-3)
    deepest = np.max(np.abs(moved)) / cell
    found |= {"most_cells": float(deepest), "judged_s": float(np.count_nonzero(late) * 100e-6)}
    if late.any():
        found["moved_cells"] = float(np.max(np.abs(moved[late])) / cell)
    return found


def bounce(scene: str, settings: list[str]) -> dict[str, Any]:
    """Speed out over speed in of the bare rotor."""
    metrics, _ = run(load(scene, settings))
    return {key: metrics[key] for key in KEPT}


def free(scene: str, settings: list[str]) -> dict[str, Any]:
    """Torque in free space, and the current and the speed of the rotor at the run's end."""
    loaded = load(scene, settings)
    metrics, rows = run(loaded, part_s=10e-3)
    found = {key: metrics[key] for key in KEPT}
    return found | {
        "current_a": float(rows[-1, Column.I]),
        "omega": float(rows[-1, Column.OMEGA]),
        "omega_most": float(np.max(np.abs(rows[:, Column.OMEGA]))),
    }
