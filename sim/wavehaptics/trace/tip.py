# SPDX-License-Identifier: Apache-2.0
"""What the motors of a device do at its tip: a row a tick, and the numbers of a run.

A run's metrics are those of one motor (:mod:`wavehaptics.trace.metrics`), of a motion along the
normal of the surface that the tip is deepest in: the depth in m takes the place of x and the force
along the inward normal that of the torque. ``tip_stiffness`` is the slope of the line through the
surface itself. A port anchor may move the force by half a count along the press, and a line that
need not begin at the surface leans by up to twice as much of that. What only a device has is added:

- ``tangential_force``: RMS of the force across the normal in contact, N, and
  ``tangential_part`` that over the RMS along it,
- ``surface_error_mean_m``, ``surface_error_max_m``: of ``ε = depth − push·Σ G_n²/K_n`` in contact
  from SETTLED_S after the run's first contact on: how far the surface is from where it should be;
  the mean and the largest magnitude. Above zero it has given way.
"""

from __future__ import annotations

import math
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.laws.kinematics import put_compliance
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene, Space
from wavehaptics.trace.columns import Column, thinning, write_npz
from wavehaptics.trace.metrics import Metrics

SETTLED_S = 0.1
"""Time that a surface has after the first contact before its place is judged, s."""
WALL_M = 1e3
"""Thickness of the wall that stands for a surface in the metrics of a motor, m."""


NAMES = {
    "t": ("time", "s"), "tip": ("position", "m"), "hand": ("hand_position", "m"),
    "force": ("force", "N"), "active": ("active", "–"),
}  # fmt: skip
"""A spelt-out name and the unit of each array of ``tip.npz``; – stands for none."""


class Tip(IntEnum):
    """Columns of a chunk of a device's rows, float64 of shape (ticks, ``len(Tip)``), SI units."""

    T = 0  # s, middle of the tick
    X = 1  # m, the tip's place, mean of the tick's ends
    Y = 2
    Z = 3
    HAND_X = 4  # m, middle of the tick
    HAND_Y = 5
    HAND_Z = 6
    FORCE_X = 7  # N, of the motors' mean torques at the tip
    FORCE_Y = 8
    FORCE_Z = 9
    ACTIVE = 10  # surfaces that act


@compiled(inline="always")
def put_tip_row(
    row: np.ndarray, begin: float, tick: float, before: np.ndarray, after: np.ndarray,
    hand: np.ndarray, force: np.ndarray, active: int,
) -> None:  # fmt: skip
    """A device's row; places in m and ``force`` in N are float64 (3,)."""
    row[Tip.T] = begin + 0.5 * tick
    for axis in range(3):
        row[Tip.X + axis] = 0.5 * (before[axis] + after[axis])
        row[Tip.HAND_X + axis] = hand[axis]
        row[Tip.FORCE_X + axis] = force[axis]
    row[Tip.ACTIVE] = active


def deepest(space: Space, places: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth (n,) in m, inward normal (n, 3) and number (n,) of the surface that is deepest.

    ``places`` (n, 3) in m.
    """
    depth, normal = np.full(len(places), -np.inf), np.zeros((len(places), 3))
    number = np.zeros(len(places), dtype=np.int64)
    for n, shape in enumerate(space.shapes):
        other, other_normal = shape.depth(places)
        nearer = other > depth
        depth = np.where(nearer, other, depth)
        normal = np.where(nearer[:, None], other_normal, normal)
        number[nearer] = n
    return depth, normal, number


class TipMetrics:
    """Gathers the metrics of a device's tip, chunk by chunk.

    ``motors`` are the scenes of its motors, ``joint_stiffness`` (motors,) the K_n of each that the
    controller's settings make, N·m/rad, ``wished_compliance`` (surfaces,) what is softer by a wish,
    m/N, and ``predicted`` what the first surface has at the start, N/m, None where there is none.
    ``count_m`` is what a count is at the tip, m.
    """

    def __init__(
        self, space: Space, motors: tuple[Scene, ...], controller: str, tick_s: float,
        joint_stiffness: np.ndarray, wished_compliance: np.ndarray, predicted: float | None,
        count_m: float,
    ) -> None:  # fmt: skip
        self._space, self._tick_s = space, tick_s
        self._compliance = 1.0 / joint_stiffness
        self._wished = wished_compliance
        self._arm = space.arm
        path = None if space.hand is None else space.hand.path
        self._metrics = Metrics(
            motors[0], tick_s, controller=controller, stiffness_predicted=predicted,
            walls=[(0.0, WALL_M)] if space.surface else [], path=path, count=count_m,
            through_edge=True,
        )  # fmt: skip
        self._last = math.nan
        self._first_s = math.inf
        self._sums = np.zeros(4)  # across², along², ε, ticks of ε
        self._contact_ticks = 0
        self._error_max = 0.0

    def update(self, tips: np.ndarray, rows: np.ndarray) -> None:
        """Take the next ticks: ``tips`` (n, len(Tip)), ``rows`` (motors, n, len(Column))."""
        if not len(tips) or not self._space.surface:
            return
        places = tips[:, Tip.X : Tip.Z + 1]
        force = tips[:, Tip.FORCE_X : Tip.FORCE_Z + 1]
        depth, normal, number = deepest(self._space, places)
        hand, _, _ = deepest(self._space, tips[:, Tip.HAND_X : Tip.HAND_Z + 1])
        along = np.einsum("ij,ij->i", force, normal)
        before = depth[0] if math.isnan(self._last) else self._last
        seen = np.zeros((len(tips), len(Column)))
        seen[:, Column.T] = tips[:, Tip.T]
        seen[:, Column.X] = depth
        seen[:, Column.OMEGA] = np.diff(depth, prepend=before) / self._tick_s
        seen[:, Column.TORQUE] = along
        seen[:, Column.X_HAND] = hand
        seen[:, Column.CONTACT] = tips[:, Tip.ACTIVE] > 0
        for column in (Column.SATURATED, Column.CLIPPED):
            seen[:, column] = rows[:, :, column].any(axis=0)
        seen[:, Column.ENERGY_OUT] = rows[:, :, Column.ENERGY_OUT].sum(axis=0)
        self._last = float(depth[-1])
        self._metrics.update(seen)
        self._judge(tips, rows, normal, depth, along, force, number)

    def _judge(
        self, tips: np.ndarray, rows: np.ndarray, normal: np.ndarray, depth: np.ndarray,
        along: np.ndarray, force: np.ndarray, number: np.ndarray,
    ) -> None:  # fmt: skip
        contact = tips[:, Tip.ACTIVE] > 0
        if not contact.any():
            return
        self._first_s = min(self._first_s, float(tips[contact][0, Tip.T]))
        across = force - along[:, None] * normal
        self._contact_ticks += int(contact.sum())
        self._sums[0] += np.sum(across[contact] ** 2)
        self._sums[1] += np.sum(along[contact] ** 2)
        judged = contact & (tips[:, Tip.T] > self._first_s + SETTLED_S)
        if not judged.any():
            return
        angles = np.ascontiguousarray(rows[:, judged, Column.X].T)
        normals, compliance = np.ascontiguousarray(normal[judged]), np.zeros(len(angles))
        put_compliance(
            self._arm.geometry, angles, normals, self._compliance,
            np.zeros((3, angles.shape[1])), compliance,
        )  # fmt: skip
        compliance = np.maximum(compliance, self._wished[number[judged]])
        error = depth[judged] + along[judged] * compliance
        self._sums[2] += error.sum()
        self._sums[3] += len(error)
        self._error_max = max(self._error_max, float(np.abs(error).max()))

    def result(self, wall_clock_s: float) -> dict[str, Any]:
        """The tip's metrics by name, SI units."""
        found = self._metrics.result(wall_clock_s=wall_clock_s)
        across, along, error, ticks = self._sums.tolist()
        contact = self._contact_ticks
        return {
            "tip_stiffness": found["stiffness"],
            "tip_stiffness_predicted": found["stiffness_predicted"],
            "tip_offset_m": found["hold_offset_rad"],
            "tip_offset_part": found["hold_error"],
            "tip_force_n": found["hold_torque"],
            "tip_ripple_n": found["hold_ripple_rms"],
            "swing_m": found["swing_rad"],
            "swing_hz": found["swing_hz"],
            "peak_force_n": found["peak_torque"],
            "tangential_force": math.sqrt(across / contact) if contact else None,
            "tangential_part": math.sqrt(across / along) if along else None,
            "surface_error_mean_m": error / ticks if ticks else None,
            "surface_error_max_m": self._error_max if ticks else None,
            "contact_energy_j": found["contact_energy_j"],
            "contact_energy_ratio": found["contact_energy_ratio"],
            "energy_out_max_j": found["energy_out_max_j"],
            "contact_fraction": contact / found["ticks"] if found["ticks"] else None,
            "saturated_fraction": found["saturated_fraction"],
            "clipped_fraction": found["clipped_fraction"],
            "reasons": {
                {"stiffness": "tip_stiffness", "hold_error": "tip_offset_part"}.get(key, key): text
                for key, text in found["reasons"].items()
            },
        }


class TipTrace:
    """Keeps a device's rows, thinned as those of its motors, and writes them."""

    def __init__(self, tick_s: float, trace_hz: float | None) -> None:
        self._step = thinning(tick_s, trace_hz)
        self._ticks = 0
        self._kept: list[np.ndarray] = []

    def write(self, tips: np.ndarray) -> None:
        """Take the next ticks, (n, len(Tip))."""
        self._kept.append(tips[-self._ticks % self._step :: self._step].copy())
        self._ticks += len(tips)

    def arrays(self) -> dict[str, np.ndarray]:
        """``t active`` of shape (n,); ``tip hand force`` of shape (n, 3), SI units."""
        rows = np.concatenate(self._kept)
        return {
            "t": rows[:, Tip.T],
            "tip": rows[:, Tip.X : Tip.Z + 1],
            "hand": rows[:, Tip.HAND_X : Tip.HAND_Z + 1],
            "force": rows[:, Tip.FORCE_X : Tip.FORCE_Z + 1],
            "active": rows[:, Tip.ACTIVE],
        }

    def save(self, path: Path) -> Path:
        """Write the arrays to ``path``, whole or not at all."""
        return write_npz(path, self.arrays())
