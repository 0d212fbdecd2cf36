# SPDX-License-Identifier: Apache-2.0
"""The reference beside a port anchor, and that ``analog`` and ``encoder`` really do without one."""

from __future__ import annotations

import pytest
from wavehaptics.ladder.run import CONTROLLERS, measure, stiffness_predicted
from wavehaptics.scene import Scene, find_scene, load_scene

ANCHOR = "controller.anchor_auto=true"


def load(name: str, *sets: str) -> Scene:
    return load_scene(find_scene(name), sets)


@pytest.mark.parametrize("controller", ["analog", "encoder"])
@pytest.mark.parametrize("name", ["paper_taps", "brushless_taps"])
def test_what_ignores_the_anchor_is_not_changed_by_it(name, controller):
    """Not a digit of what it does, nor the stiffness that it is said to have."""
    plain = load(name, "scene.duration_s=0.2")
    anchored = load(name, "scene.duration_s=0.2", ANCHOR)
    found = [measure(scene, controller, compare=False) for scene in (plain, anchored)]
    for metrics in found:
        del metrics["wall_clock_s"]
    assert found[0] == found[1]


def test_the_paper_s_wall_stays_the_paper_s():
    scene = load("paper_taps", ANCHOR)
    k = stiffness_predicted(scene, CONTROLLERS["analog"](scene))
    assert k == pytest.approx(1.569, rel=1e-3)


def test_an_eta_of_its_own_is_kept():
    scene = load("paper_taps", ANCHOR, "controller.eta_free=0.5", "scene.duration_s=0.2")
    plain = load("paper_taps", "controller.eta_free=0.5", "scene.duration_s=0.2")
    found = [measure(one, "analog", compare=False) for one in (scene, plain)]
    assert found[0]["free_space_torque_rms"] == found[1]["free_space_torque_rms"]
    usual = measure(load("paper_taps", ANCHOR, "scene.duration_s=0.2"), "analog", compare=False)
    assert found[0]["free_space_torque_rms"] > 2.0 * usual["free_space_torque_rms"]


@pytest.mark.parametrize("name", ["paper_taps", "press_hold"])
def test_an_anchored_wall_is_compared_with_the_wall_that_was_requested(name):
    """One that has R̂ and no other motor: within some percent, as what the anchor adds is small."""
    metrics = measure(load(name, ANCHOR, "scene.duration_s=0.5"), "golden")
    assert metrics["torque_nrmse_vs_analog"] < 0.05
    assert "torque_nrmse_vs_analog" not in metrics["reasons"]


@pytest.mark.parametrize(
    ("sets", "cause"),
    [
        (["controller.r_hat=2.0"], "R̂ with the drive's gain is -8.3 % off R"),
        (["controller.r_hat=2.4"], "R̂ with the drive's gain is +10 % off R"),
        (["drive.gain_error=0.05"], "R̂ with the drive's gain is +5 % off R"),
        (["brushes.drop_v=0.3"], ""),
    ],
)
def test_a_reference_that_lets_the_wall_go_is_none(sets, cause):
    scene = load("paper_taps", ANCHOR, "scene.duration_s=0.5", *sets)
    metrics = measure(scene, "golden")
    assert metrics["torque_nrmse_vs_analog"] is None
    reason = metrics["reasons"]["torque_nrmse_vs_analog"]
    assert reason.startswith("the analog circuit has no port anchor and loses this wall")
    assert cause in reason
    # Beside a port that loses it as well the two are compared.
    plain = measure(load("paper_taps", "scene.duration_s=0.5", *sets), "golden")
    assert plain["torque_nrmse_vs_analog"] is not None


def test_the_servo_has_no_reference_where_that_loses_the_wall():
    scene = load("paper_taps", "controller.r_hat=2.0", "scene.duration_s=0.5")
    assert measure(scene, "encoder")["torque_nrmse_vs_analog"] is None
    good = measure(load("paper_taps", "scene.duration_s=0.5"), "encoder")
    assert good["torque_nrmse_vs_analog"] < 0.05


def test_a_wall_of_w_has_no_reference():
    metrics = measure(load("soft_layer", "scene.duration_s=0.1"), "golden")
    assert metrics["torque_nrmse_vs_analog"] is None
    assert metrics["reasons"]["torque_nrmse_vs_analog"] == "the analog circuit has no W"


def test_the_reference_has_the_scene_s_voltage():
    """What ends the word of u, 22.9 V at 16 mΩ, is no limit of a circuit in real numbers."""
    sets = ("motor.preset=re40-148877", "hand.path=sine", "hand.amplitude_rad=1",
            "hand.frequency_hz=1", "hand.stiffness=1", "controller.walls=[]")  # fmt: skip
    scene = load("paper_taps", *sets, "drive.limit_v=48", "scene.duration_s=0.1")
    simulation = CONTROLLERS["analog"](scene)
    assert simulation.settings.limit_v == pytest.approx(48.0)
