# SPDX-License-Identifier: Apache-2.0
"""Warming of winding and magnets: two heat capacities, R that follows the first, k_T the second.

    C_w dθ_w/dt = P − (θ_w − θ_h)/R_wh        winding, C_w = τ_w/R_wh
    C_h dθ_h/dt = (θ_w − θ_h)/R_wh − (θ_h − θ_a)/R_ha      housing, C_h = τ_h/R_ha
    R = R_25 (1 + α (θ_w − 25 °C))
    k_T = k_25 (1 + β (θ_h − 25 °C))      magnets in the housing, β below zero

The names are those of a motor's data sheet. Between two updates the heat P is constant and the
solution is exact; the winding is slow enough (seconds) for an update every PIECE_S.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.linalg import expm

from wavehaptics.motor.plant import Plant
from wavehaptics.scene import Scene
from wavehaptics.scene.tables.thermal import REFERENCE_C
from wavehaptics.trace.columns import Column

PIECE_S = 0.05
"""Longest time in which R and k_T are taken as constant, s."""


class Winding:
    """Temperatures of one scene's motor, and the plant as they have it.

    Without a ``[thermal]`` table R and k_T are the motor's for good. ``SceneError`` where the
    motor is brushless, of which there is no winding alone.
    """

    def __init__(self, scene: Scene, tick_s: float) -> None:
        if scene.motor.brushless:
            raise scene.refusal(
                'motor.kind = "pmsm" has two ports and this takes one; run it '
                "on `analog` or `golden`, or take a motor with brushes",
                "motor.kind",
                "motor.preset",
            )
        self._plant = Plant.of_scene(scene)
        self._tick_s = tick_s
        self._thermal = thermal = scene.thermal
        self._piece_ticks = max(1, math.floor(PIECE_S / tick_s))
        if thermal is None:
            return
        start = thermal.ambient_c if thermal.start_c is None else thermal.start_c
        self._theta = np.array([start, start, thermal.ambient_c, 0.0])
        winding = thermal.tau_winding_s / thermal.rth_winding
        housing = thermal.tau_housing_s / thermal.rth_housing
        # State: winding, housing, ambient (constant), heat in W (constant within a piece).
        self._matrix = np.zeros((4, 4))
        flow = 1.0 / thermal.rth_winding
        self._matrix[0, :] = (-flow / winding, flow / winding, 0.0, 1.0 / winding)
        out = 1.0 / thermal.rth_housing
        self._matrix[1, :] = (flow / housing, -(flow + out) / housing, out / housing, 0.0)

    @property
    def resistance(self) -> float:
        """R of the winding as it is now, Ω."""
        cold = self._plant.resistance
        if self._thermal is None:
            return cold
        return cold * (1.0 + self._thermal.alpha_per_k * (self.temperature - REFERENCE_C))

    @property
    def k_t(self) -> float:
        """k_T of the motor as it is now, N·m/A."""
        cold = self._plant.k_t
        if self._thermal is None:
            return cold
        warmer = float(self._theta[1]) - REFERENCE_C
        return cold * (1.0 + self._thermal.magnet_per_k * warmer)

    @property
    def temperature(self) -> float:
        """θ_w, °C; without a ``[thermal]`` table that at which R holds."""
        return REFERENCE_C if self._thermal is None else float(self._theta[0])

    @property
    def plant(self) -> Plant:
        """The scene's plant with winding and magnets as they are now."""
        return replace(self._plant, resistance=self.resistance, k_t=self.k_t)

    def advance(
        self, rows: np.ndarray, simulate: Callable[[slice], None], warm: Callable[[Plant], None]
    ) -> None:
        """Let the ticks of ``rows`` pass, in parts in which R and k_T are taken as constant.

        ``simulate`` fills a part of the rows, and ``warm`` takes the plant that holds from there
        on, where it has changed.
        """
        for part in self.pieces(len(rows)):
            simulate(part)
            if self.heat(rows[part]):
                warm(self.plant)

    def pieces(self, ticks: int) -> list[slice]:
        """Parts of ``ticks`` in which R and k_T are taken as constant, one at least."""
        longest = max(1, ticks) if self._thermal is None else self._piece_ticks
        firsts = range(0, max(1, ticks), longest)
        return [slice(first, min(first + longest, ticks)) for first in firsts]

    def heat(self, rows: np.ndarray) -> bool:
        """Let ticks pass: ``rows`` of :class:`~wavehaptics.trace.columns.Column`, in order.

        The heat is R i² of the ticks' mean currents; the carrier's ripple adds nothing to it.
        Returns whether R and k_T have changed.
        """
        if self._thermal is None or not len(rows):
            return False
        current = rows[:, Column.I]
        self._theta[3] = self.resistance * float(np.mean(current * current))
        self._theta = expm(self._matrix * (len(rows) * self._tick_s)) @ self._theta
        return True
