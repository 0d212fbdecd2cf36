# SPDX-License-Identifier: Apache-2.0
"""How well the controller knows the winding: R̂ against R, from chunk to chunk of a run."""

from __future__ import annotations

from typing import Any

from wavehaptics.scene import Scene, drive_gain


class Estimate:
    """Gathers the metrics of R̂ of one run of ``ticks`` ticks.

    All are None where no winding warms in the scene.
    """

    def __init__(self, scene: Scene, ticks: int) -> None:
        self._wanted = scene.thermal is not None
        self._gain = drive_gain(scene)
        self._late = ticks - ticks // 10
        self._last: tuple[float, float, float] | None = None
        self._worst = 0.0

    def update(self, simulation: Any, ticks: int) -> None:
        """Look at a simulation after so many ticks."""
        if not self._wanted:
            return
        winding = simulation.winding
        r_hat = simulation.settings.r_hat
        self._last = (r_hat, winding.resistance, winding.temperature)
        if ticks > self._late:
            error = r_hat * self._gain / winding.resistance - 1.0
            self._worst = max(self._worst, error, -error)

    def result(self) -> dict[str, Any]:
        """Metrics by name.

        ===============  ======================================================================
        ``r_hat``        the estimate, Ω
        ``r``            the winding's resistance at the end, Ω
        ``winding_c``    its temperature at the end, °C
        ``r_hat_error``  largest magnitude of gain·R̂/R − 1 in the last tenth: an error of the
                         drive's gain acts as one of R̂
        ===============  ======================================================================
        """
        if self._last is None:
            return dict.fromkeys(("r_hat", "r", "winding_c", "r_hat_error"))
        r_hat, resistance, temperature = self._last
        return {
            "r_hat": r_hat,
            "r": resistance,
            "winding_c": temperature,
            "r_hat_error": self._worst,
        }
