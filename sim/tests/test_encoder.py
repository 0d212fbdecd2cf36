# SPDX-License-Identifier: Apache-2.0
"""The encoder's servo against closed forms: its spring, its amplifier, its delay, its stability."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wavehaptics.ladder.encoder import EncoderSimulation
from wavehaptics.ladder.run import CONTROLLERS, run_scene
from wavehaptics.scene import SceneError
from wavehaptics.trace.columns import Column

SLOW = (
    "hand.path='sine'",
    "hand.amplitude_rad=0.05",
    "hand.frequency_hz=2",
    "hand.stiffness=0.1",
    "hand.damping=2e-3",
    "controller.walls=[[0, 1]]",
    "controller.tick_hz=1e5",
)


def simulate(scene, duration_s: float) -> np.ndarray:
    simulation = EncoderSimulation(scene)
    rows = np.zeros((round(duration_s / simulation.tick_s), len(Column)))
    simulation.advance(rows)
    return rows


@pytest.mark.parametrize("rate_hz", [1e3, 1e4, 1e5])
def test_slow_pressing_feels_the_virtual_spring(make_scene, rate_hz, tmp_path):
    scene = make_scene(
        *SLOW, f"servo.rate_hz={rate_hz}", "servo.stiffness=0.1", "scene.duration_s=0.25"
    )
    metrics = run_scene(scene, "encoder", tmp_path)
    assert metrics["stiffness"] == pytest.approx(0.1, rel=0.01)
    assert metrics["stiffness_predicted"] == 0.1
    assert metrics["free_space_torque_rms"] < 1e-2 * metrics["peak_torque"]


def test_both_edges_of_a_wall_push_alike(make_scene):
    """A wall and its mirror image, with a coarse encoder whose cells are mirrored with it."""
    torques = []
    for wall, sign in (("[[0.01, 1]]", 1), ("[[-1, -0.01]]", -1)):
        scene = make_scene(
            *SLOW[:-2], f"controller.walls={wall}", SLOW[-1], "encoder.counts_per_rev=1000",
            "servo.stiffness=0.3", f"scene.name={'upper' if sign < 0 else 'lower'}",
        )  # fmt: skip
        rows = simulate(scene, 0.5)
        torques.append(sign * rows[:, Column.TORQUE])
    assert torques[0].min() < -3e-3
    assert torques[1].min() == pytest.approx(torques[0].min(), rel=0.01)


def test_the_amplifier_has_its_bandwidth(make_scene):
    """A locked rotor far in the wall: the current comes up as 1 − exp(−2πf·t)."""
    scene = make_scene(
        "motor.J_kgm2=1.0", "controller.walls=[[-0.01, 1]]", "servo.stiffness=1.0",
        "servo.amplifier_hz=2e3", "drive.bus_v=100",
    )  # fmt: skip
    rows = simulate(scene, 1e-3)
    final = -0.01 / scene.motor.k_t
    t = np.arange(len(rows)) * 1e-6
    expected = final * (1 - np.exp(-2 * math.pi * 2e3 * t))
    assert np.abs(rows[:, Column.I] - expected).max() < 0.02 * abs(final)


@pytest.mark.parametrize("delay_s", [0.0, 1e-3, 4e-3])
def test_the_delay_is_what_the_scene_says(make_scene, delay_s):
    scene = make_scene(
        "motor.J_kgm2=1.0", "controller.walls=[[-0.01, 1]]", "servo.stiffness=1.0",
        f"servo.delay_s={delay_s}",
    )  # fmt: skip
    rows = simulate(scene, 6e-3)
    began = np.flatnonzero(rows[:, Column.I])[0]
    assert began == round(delay_s / 1e-6) + 1


def test_the_damper_brakes_inside_the_wall(make_scene):
    free, damped = (
        simulate(
            make_scene(
                "hand.path='impact'", "hand.amplitude_rad=0.001", "hand.speed_rad_s=5",
                "controller.walls=[[0, 1]]", "servo.stiffness=0.3", "servo.rate_hz=1e5",
                "servo.amplifier_hz=2e4", f"servo.damping={damping}",
            ),
            0.02,
        )[:, Column.OMEGA]
        for damping in (0.0, 5e-4)
    )  # fmt: skip
    assert -5.2 < free[-1] < -4.8
    assert -3.5 < damped[-1] < -0.5


def test_stable_below_and_unstable_above_the_bound_of_sampling(make_scene):
    """A held spring acts T/2 late, which viscous friction has to make up for: K < 2b/T."""

    def swing(stiffness: float) -> float:
        scene = make_scene(
            "hand.path='press'", "hand.amplitude_rad=0.02", "hand.stiffness=0.1",
            "friction.viscous=1e-4", "controller.walls=[[0, 1]]", "controller.tick_hz=1e5",
            "servo.rate_hz=1e3", "servo.amplifier_hz=1e4", f"servo.stiffness={stiffness}",
        )  # fmt: skip
        rows = simulate(scene, 0.8)
        return float(np.ptp(rows[-20_000:, Column.X]))

    bound = 2 * 1e-4 / 1e-3
    assert swing(0.5 * bound) < 1e-6
    assert swing(1.5 * bound) > 1e-3


def test_voltage_limit_does_not_wind_up(make_scene):
    scene = make_scene(
        "hand.path='taps'", "hand.amplitude_rad=0.05", "hand.frequency_hz=5",
        "hand.stiffness=2", "hand.damping=2e-3", "controller.walls=[[0, 1]]",
        "servo.rate_hz=1e5", "servo.stiffness=2", "drive.limit_v=1.0",
    )  # fmt: skip
    rows = simulate(scene, 0.2)
    limited = rows[:, Column.SATURATED] != 0
    assert limited.mean() > 0.1
    assert np.abs(rows[:, Column.E_A]).max() == pytest.approx(1.0, rel=1e-6)
    left = np.flatnonzero(np.diff(rows[:, Column.CONTACT]) < 0)[-1]
    assert np.abs(rows[left + 2000 :, Column.TORQUE]).max() < 1e-4


@pytest.mark.parametrize(
    ("settings", "fragment"),
    [
        (("servo.rate_hz=3e5",), "servo.rate_hz = 300000 does not divide"),
        (("servo.rate_hz=2e6",), "servo.rate_hz = 2e+06 does not divide"),
        (("servo.amplifier_hz=2e5",), "it may be at most 100000 Hz"),
    ],
)
def test_refused(make_scene, settings, fragment):
    scene = make_scene(*settings)
    with pytest.raises(SceneError) as refusal:
        CONTROLLERS["encoder"](scene)
    assert fragment in str(refusal.value)
    assert "\n" not in str(refusal.value)
