# SPDX-License-Identifier: Apache-2.0
"""A winding that warms: its two bodies against the step response, and what a run tells of it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.motor.thermal import Winding
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.trace.columns import Column, Word

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


def test_magnets_warm_with_the_housing(make_scene):
    """k_T follows the second of the two bodies, whose course is scipy's."""
    scene = make_scene("thermal.magnet_per_k=-0.002", "thermal.tau_housing_s=5",
                       "thermal.tau_winding_s=2", "thermal.alpha_per_k=0")  # fmt: skip
    winding = Winding(scene, 1e-6)
    assert winding.plant.k_t == scene.motor.k_t
    rows = np.zeros((50_000, len(Column)))
    rows[:, Column.I] = 3.0
    for _ in range(200):
        winding.heat(rows)
    thermal = scene.thermal

    def flow(_, theta):
        inward = (theta[0] - theta[1]) / thermal.rth_winding
        outward = (theta[1] - thermal.ambient_c) / thermal.rth_housing
        return [(R_OHM * 9.0 - inward) / (2.0 / thermal.rth_winding),
                (inward - outward) / (5.0 / thermal.rth_housing)]  # fmt: skip

    housing = solve_ivp(flow, (0, 10), [25.0, 25.0], rtol=1e-9, atol=1e-9).y[1, -1]
    assert housing > 100
    expected = scene.motor.k_t * (1.0 - 0.002 * (housing - 25.0))
    assert winding.plant.k_t == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("controller", ["analog", "golden", "encoder"])
@pytest.mark.parametrize("celsius", [-20.0, 125.0])
def test_a_motor_with_warm_magnets_is_one_of_less_k_t(make_scene, controller, celsius):
    """Torque, back-EMF and what friction holds; k_T is the motor's, not the controller's."""
    common = (
        "hand.path='taps'", "hand.amplitude_rad=0.1", "hand.frequency_hz=20", "hand.stiffness=0.5",
        "hand.damping=1e-3", "friction.coulomb_nm=1e-3", "controller.tick_hz=100e3",
        "controller.walls=[[0.0, 1.0]]", "controller.k_t_hat=0.0234", "scene.duration_s=0.05",
        "thermal.alpha_per_k=0", f"thermal.start_c={celsius}", f"thermal.ambient_c={celsius}",
    )  # fmt: skip
    k_t = 0.0234 * (1.0 - 0.002 * (celsius - 25.0))
    warm = rows_of(make_scene(*common, "thermal.magnet_per_k=-0.002"), controller)
    plain = rows_of(make_scene(*common, f"motor.k_t={k_t!r}"), controller)
    assert np.abs(warm[:, Column.TORQUE]).max() > 0.01
    np.testing.assert_allclose(warm, plain, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("anchor", ["true", "false"])
def test_a_wall_of_warm_magnets_has_not_moved(make_scene, anchor):
    """Its spring is softer by k_T, or by its square; where it stands is where it stood."""
    common = (
        "hand.path='press'", "hand.amplitude_rad=0.1", "hand.stiffness=0.1", "hand.damping=1e-3",
        "controller.tick_hz=500e3", "controller.lambda=1e9", "controller.walls=[[0.0, 1.0]]",
        f"controller.anchor_auto={anchor}", "encoder.counts_per_rev=100000",
        "scene.duration_s=0.3", "drive.limit_v=12",
    )  # fmt: skip
    hot = ("thermal.alpha_per_k=0", "thermal.ambient_c=125", "thermal.magnet_per_k=-0.002")
    cold = measure(make_scene(*common), "golden", compare=False)
    warm = measure(make_scene(*common, *hot), "golden", compare=False)
    assert warm["hold_torque"] == pytest.approx(cold["hold_torque"], rel=0.05)
    assert warm["stiffness"] < 0.85 * cold["stiffness"]
    depth = warm["hold_offset_rad"] / warm["hold_error"]
    assert abs(warm["hold_offset_rad"] - cold["hold_offset_rad"]) < 0.02 * depth
    assert warm["correction_bound_j"] is None


def rows_of(scene, controller):
    """Rows of a scene on a controller."""
    ticks = round(scene.scene.duration_s * scene.controller.tick_hz)
    rows = np.zeros((ticks, len(Column)))
    CONTROLLERS[controller](scene).advance(rows, np.zeros((ticks, len(Word)), dtype=np.int64))
    return rows
