# SPDX-License-Identifier: Apache-2.0
"""The early duty at the pins: a tick of latency less, and the wall that this allows."""

from __future__ import annotations

import pytest
from wavehaptics.controller.early import _SCALE_Q, slope_fits
from wavehaptics.controller.tick_layout import scene_frame, timing
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.ladder.run import measure
from wavehaptics.laws.closed_forms import MOST_A
from wavehaptics.scene import Scene, SceneError, find_scene, load_scene
from wavehaptics.studies import adcs
from wavehaptics.words import formats

EARLY = ("controller.early_duty=true", "controller.clock_hz=80e6", "adc.part=AD7276")


def load(*settings: str, name: str = "paper_taps") -> Scene:
    return load_scene(find_scene(name), [*EARLY, *settings])


def test_the_stiffest_slope_is_the_words_largest():
    """A slope of the largest word fits, and one more doesn't; R̂ of 0 leaves the current's alone."""
    places = formats.GAIN.fraction + formats.DUTY.fraction - _SCALE_Q
    largest = (1 << (formats.DATA_W - 1)) - 1
    assert slope_fits(0, largest << places, 1)
    assert not slope_fits(0, largest + 1 << places, 1)


def test_stiffest_wall_is_that_of_no_latency():
    """One tap at a = 0.99: τ is T/a, K = k_T²/(L + R·τ/2), and no energy comes out."""
    scene = load("controller.lambda=1e9", "scene.duration_s=0.26")
    simulation = PinsSimulation(scene)
    assert simulation.timing.early
    assert simulation.timing.extra_ticks == 0
    metrics = measure(scene, "pins", simulation=simulation)
    motor = scene.motor
    k = motor.k_t**2 / (motor.L_h + motor.R_ohm * 1e-6 / MOST_A / 2)
    assert metrics["stiffness_predicted"] == pytest.approx(k, rel=1e-6)
    assert metrics["stiffness"] == pytest.approx(k, rel=0.01)
    assert metrics["torque_nrmse_vs_analog"] <= 5e-3
    assert metrics["energy_out_max_j"] < 1e-6


def test_digital_part_is_ten_clocks():
    scene = load()
    found = adcs.delays(timing(scene, scene_frame(scene)))
    assert found["digital_ns"] == pytest.approx(125.0)
    assert found["gate_ns"] == pytest.approx(500.0)


def test_a_voltage_that_waits_is_made_in_turn():
    scene = load("controller.extra_ticks=2")
    laid = timing(scene, scene_frame(scene))
    assert not laid.early
    assert laid.hold_ticks == 1


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (("adc.part=AMC1306M25", "adc.bits=16"), "sooner than the 18 that are needed"),
        (("controller.tick_hz=2e6",), "a tick of 40 clocks is shorter than the 47"),
        (
            ("controller.tick_hz=1.6e6", "controller.anchor_auto=true"),
            "a tick of 50 clocks is shorter than the 58 that are needed with a port anchor",
        ),
        (
            ("motor.preset=re25-phantom", "controller.tick_hz=2e3", "controller.clock_hz=40e6",
             "drive.bus_v=12", "drive.limit_v=12", "drive.pwm_hz=1e3", "adc.full_scale_a=20"),
            "worth too many clocks",
        ),
    ],
)  # fmt: skip
def test_where_there_is_no_time(settings, message):
    with pytest.raises(SceneError, match=f"controller.early_duty: .*{message}"):
        PinsSimulation(load(*settings))
