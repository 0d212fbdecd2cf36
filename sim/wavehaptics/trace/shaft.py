# SPDX-License-Identifier: Apache-2.0
"""The numbers of a virtual shaft between two motors.

- ``shaft_stiffness``: torque through the shaft over its twist ``x_0 − x_1``, of the means over the
  last tenth of the run, N·m/rad; None below LEAST_COUNTS counts of twist.
  ``shaft_stiffness_predicted`` is the closed form's,
- ``shaft_twist_rad``, ``shaft_torque`` those means; ``shaft_ripple`` the torque's RMS about its
  mean there, N·m,
- ``shaft_energy_out_j``: the most that both motors together have given to their shafts since the
  run's beginning, J, and ``shaft_energy_ratio`` that over ½τ²/K of the largest torque. A shaft
  that is passive gives out nothing.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from wavehaptics.trace.columns import Column
from wavehaptics.trace.metrics import LEAST_COUNTS

LAST = 0.1
"""Part of the run that is judged as its rest."""


class ShaftMetrics:
    """Gathers them, chunk by chunk, of a run of ``ticks`` ticks of ``tick_s``.

    ``predicted`` in N·m/rad, ``cell_rad`` a count.
    """

    def __init__(self, ticks: int, tick_s: float, predicted: float, cell_rad: float) -> None:
        self._first, self._tick_s = ticks - max(round(LAST * ticks), 1), tick_s
        self._predicted, self._least = predicted, LEAST_COUNTS * cell_rad
        self._ticks, self._rest = 0, np.zeros(4)  # ticks, twist, torque, torque²
        self._energy = self._most = self._torque = 0.0

    def update(self, rows: np.ndarray) -> None:
        """Take the next ticks: ``rows`` (2, n, len(Column))."""
        torque, omega = rows[:, :, Column.TORQUE], rows[:, :, Column.OMEGA]
        given = self._energy + np.cumsum((torque * omega).sum(axis=0)) * self._tick_s
        if len(given):
            self._energy = float(given[-1])
            self._most = max(self._most, float(given.max()))
        through = 0.5 * (torque[1] - torque[0])
        self._torque = max(self._torque, float(np.abs(through).max(initial=0.0)))
        rest = slice(max(self._first - self._ticks, 0), None)
        self._ticks += len(through)
        through, x = through[rest], rows[:, rest, Column.X]
        self._rest += (len(through), np.sum(x[0] - x[1]), through.sum(), np.sum(through**2))

    def result(self) -> dict[str, Any]:
        """The shaft's metrics by name, SI units."""
        ticks, twist, torque, square = self._rest.tolist()
        twist, torque = twist / ticks, torque / ticks
        return {
            "shaft_stiffness": torque / twist if abs(twist) >= self._least else None,
            "shaft_stiffness_predicted": self._predicted,
            "shaft_twist_rad": twist,
            "shaft_torque": torque,
            "shaft_ripple": math.sqrt(max(square / ticks - torque**2, 0.0)),
            "shaft_energy_out_j": self._most,
            "shaft_energy_ratio": (
                2.0 * self._predicted * self._most / self._torque**2 if self._torque else None
            ),
        }
