# SPDX-License-Identifier: Apache-2.0
"""A winding that warms: its two bodies against the step response, and what a run tells of it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from wavehaptics.ladder.run import measure
from wavehaptics.motor.thermal import Winding
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.trace.columns import Column

R_OHM = 2.18


def test_a_winding_warms_as_its_constants_say():
    """Constant current into a constant R: the step response of the two-body network."""
    scene = load_scene(find_scene("warm_winding"), ["thermal.alpha_per_k=0", "scene.duration_s=1"])
    winding = Winding(scene, 1e-6)
    rows = np.zeros((50_000, len(Column)))
    rows[:, Column.I] = 1.24
    for _ in range(round(40 / 0.05)):
        assert winding.heat(rows)
    thermal = scene.thermal
    c_winding = thermal.tau_winding_s / thermal.rth_winding
    c_housing = thermal.tau_housing_s / thermal.rth_housing

    def flow(_, theta):
        inward = (theta[0] - theta[1]) / thermal.rth_winding
        outward = (theta[1] - thermal.ambient_c) / thermal.rth_housing
        return [(R_OHM * 1.24**2 - inward) / c_winding, (inward - outward) / c_housing]

    exact = solve_ivp(flow, (0, 40), [25.0, 25.0], rtol=1e-9, atol=1e-9).y[0, -1]
    assert exact > 35
    assert winding.temperature == pytest.approx(exact, abs=1e-4)
    assert winding.resistance == R_OHM


def test_a_run_tells_of_the_winding_and_of_what_r_hat_misses():
    """A wall pressed by a vice: the current warms the winding, and R̂ stays what it was."""
    scene = load_scene(
        find_scene("warm_winding"),
        [
            "scene.duration_s=1",
            "thermal.tau_winding_s=0.5",
            "thermal.start_c=60",
            "controller.anchor_auto=false",
        ],
    )
    metrics = measure(scene, "golden", compare=False)
    assert metrics["r_hat"] == R_OHM
    assert metrics["winding_c"] > 60
    alpha = scene.thermal.alpha_per_k
    assert metrics["r"] == pytest.approx(R_OHM * (1 + alpha * (metrics["winding_c"] - 25)))
    assert metrics["r_hat_error"] == pytest.approx(1 - R_OHM / metrics["r"], rel=0.1)
    cold = measure(load_scene(find_scene("held_wall"), ["scene.duration_s=0.01"]), "golden")
    assert [cold[key] for key in ("r_hat", "r", "winding_c", "r_hat_error")] == [None] * 4
