# SPDX-License-Identifier: Apache-2.0
"""What ``check`` and ``run`` say of scenes that ask for more than a word or the ADC has."""

from __future__ import annotations

import math
import re

import pytest
from test_cli import call
from test_clipped import SERVO_MOTOR, STRONG_MOTOR
from wavehaptics.controller import anchor
from wavehaptics.controller.settings import settings
from wavehaptics.ladder.ranges import exceeded
from wavehaptics.ladder.run import measure
from wavehaptics.scene import Scene, find_scene, load_device, load_scene, shipped_scenes

FREE_ROTOR = """
[scene]
name = "free_rotor"
duration_s = 0.3
[motor]
R_ohm = 16e-3
L_h = 190e-6
k_t = 0.165
J_kgm2 = 0.025
[hand]
path = "sine"
amplitude_rad = 10.0
frequency_hz = 4.0
stiffness = 1000.0
damping = 2.0
[drive]
bus_v = 60
[controller]
tick_hz = 100e3
lambda = 1e5
walls = []
"""


@pytest.fixture
def scene_of(tmp_path):
    """A scene of a text, with settings on top."""

    def make(text: str, *sets: str) -> Scene:
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return load_scene(path, sets)

    return make


def told(scene: Scene, controller: str = "golden") -> dict[str, float]:
    """Quantities that may leave their range, and how far."""
    return {one.quantity: one.reaches / one.limit for one in exceeded(scene, controller)}


@pytest.mark.parametrize("name", shipped_scenes())
def test_no_shipped_scene_is_beyond_a_range(name):
    """As it is; a tenth of the range of its current is beyond."""
    for scene in load_device(find_scene(name)).scenes:
        assert told(scene) == {}


@pytest.mark.parametrize("controller", ["golden", "core", "pins"])
def test_a_current_beyond_the_adc_is_known_before_the_run(scene_of, controller):
    beyond = exceeded(scene_of(SERVO_MOTOR), controller)
    assert [one.quantity for one in beyond] == ["the current"]
    assert beyond[0].limit == pytest.approx(63.0)
    # The force of hand and wall in series, by the motor's constant.
    assert beyond[0].reaches == pytest.approx(0.9 / (1 / 81.7 + 1 / 5.0) / 0.0546, rel=0.01)
    assert told(scene_of(SERVO_MOTOR, "hand.amplitude_rad=0.6"), controller) == {}


@pytest.mark.parametrize("controller", ["golden", "pins"])
def test_a_current_beyond_its_word_is_known_before_the_run(scene_of, controller):
    beyond = told(scene_of(STRONG_MOTOR), controller)
    assert beyond["the current"] == pytest.approx(85.0 / 64.0, rel=0.02)
    assert told(scene_of(STRONG_MOTOR, "hand.amplitude_rad=0.02", "drive.limit_v=19")) == {}


def test_an_impact_beyond_the_adc_is_known_before_the_run():
    scene = load_scene(find_scene("impact"), ["adc.bits=12", "adc.full_scale_a=0.5"])
    assert told(scene)["the current"] > 1.0
    assert measure(scene, "golden", compare=False)["clipped_fraction"] > 0.0


def test_a_voltage_limit_that_u_can_t_hold_is_told(scene_of):
    beyond = {one.quantity: one for one in exceeded(scene_of(FREE_ROTOR), "golden")}
    assert beyond["the voltage"].reaches == pytest.approx(60.0)
    assert beyond["the voltage"].limit == pytest.approx(128.0 * math.sqrt(2 * 16e-3), rel=1e-6)
    assert "128 √W" in str(beyond["the voltage"])
    # Without a drive it is what the hand asks for.
    text = FREE_ROTOR.replace("[drive]\nbus_v = 60\n", "")
    assert told(scene_of(text))["the voltage"] == pytest.approx(41.5 / 22.9, rel=0.01)
    assert told(scene_of(text, "hand.frequency_hz=1")) == {}
    assert told(scene_of(FREE_ROTOR, "drive.bus_v=22")) == {}


def test_analog_and_encoder_have_no_words(scene_of):
    for controller in ("analog", "encoder"):
        assert exceeded(scene_of(STRONG_MOTOR), controller) == []


def test_a_wave_beyond_its_word_is_told(scene_of):
    sets = ("motor.R_ohm=120", "motor.L_h=1e-3", "motor.k_t=0.1", "drive.bus_v=120")
    assert told(scene_of(STRONG_MOTOR, *sets, "hand.amplitude_rad=0.3"))["the wave v"] > 1.0
    assert told(scene_of(STRONG_MOTOR, *sets, "hand.amplitude_rad=0.05")) == {}


def test_a_rotor_too_fast_for_the_anchor_s_count_is_told(scene_of):
    sets = ("encoder.counts_per_rev=4000000", "hand.path=sine", "hand.frequency_hz=100",
            "controller.tick_hz=20e3", "controller.lambda=2e4", "drive.limit_v=10")  # fmt: skip
    found = [told(scene_of(STRONG_MOTOR, *sets, f"hand.amplitude_rad={a}")) for a in (1, 0.01)]
    assert found[0]["the movement in a tick"] > 1.0
    assert "the movement in a tick" not in found[1]


def test_a_flux_beyond_its_half_is_told(scene_of):
    """An overload by 0.97 rad, 10,100 counts: the port anchor gives up, and says so."""
    scene = scene_of(
        STRONG_MOTOR, "hand.amplitude_rad=1.5", "hand.stiffness=20", "controller.walls=[[0, 10]]"
    )
    assert told(scene)["the flux χ"] > 1.0
    metrics = measure(scene, "golden", compare=False)
    assert metrics["anchor_fault_s"] is not None
    assert metrics["energy_out_max_j"] < 1e-3


def test_a_gain_that_is_limited_to_its_word_is_told(scene_of):
    sets = ("controller.lambda=30", "encoder.counts_per_rev=1000000", "drive.limit_v=10")
    scene = scene_of(STRONG_MOTOR, *sets, "hand.amplitude_rad=0.01")
    assert settings(scene).anchor[anchor.OWED_GAIN] == (1 << 26) - 1
    assert told(scene)["the gain of what the voltage limit withholds"] > 1.0


def test_edges_that_are_too_far_apart_are_told(scene_of):
    sets = ("controller.tick_hz=4e6", "motor.L_h=1e-3", "drive.limit_v=10")
    name = "the time between two edges of a slow rotor"
    assert name not in told(scene_of(STRONG_MOTOR, *sets))
    assert told(scene_of(STRONG_MOTOR, *sets, "encoder.counts_per_rev=20"))[name] > 1.0


def test_states_of_w_that_are_too_large_are_told():
    """A spring of a low corner frequency keeps more than 16 times its largest wave."""
    sets = ("controller.tick_hz=4e6", "hand.stiffness=100")
    found = [
        told(load_scene(find_scene("soft_layer"), [*sets, f"hand.amplitude_rad={a}"]))
        for a in (1.0, 0.1)
    ]
    assert found[0]["a state of section 0 of W"] > 1.0
    assert found[1] == {}


def test_check_warns(capsys, monkeypatch, tmp_path):
    path = tmp_path / "strong.toml"
    path.write_text(STRONG_MOTOR)
    for arguments in ((), ("--controller", "golden"), ("--controller", "pins")):
        status, out, err = call(capsys, monkeypatch, "check", str(path), *arguments)
        assert (status, err) == (0, "")
        assert re.search(r"^warning: the current may reach 8\d\.?\d* A, beyond ±6[34]", out, re.M)
        assert re.search(r"^warning: the voltage may reach 60 V, beyond ±19.2 V", out, re.M)
    status, out, _ = call(capsys, monkeypatch, "check", str(path), "--controller", "analog")
    assert (status, "warning" in out) == (0, False)


def test_run_warns_once_of_what_was_clipped(capsys, monkeypatch, tmp_path):
    path = tmp_path / "strong.toml"
    path.write_text(STRONG_MOTOR)
    status, out, err = call(
        capsys, monkeypatch, "run", str(path), "--out", str(tmp_path / "run"), "--set",
        "drive.limit_v=19", "--set", "scene.duration_s=0.1",
    )  # fmt: skip
    assert status == 0
    assert re.search(r"^clipped_fraction +0\.\d+$", out, re.M)
    assert re.fullmatch(
        r"wavehaptics: warning: in \d+ % of the ticks the current, [^\n]+\n", err
    ), err
    status, out, err = call(
        capsys, monkeypatch, "run", str(path), "--out", str(tmp_path / "run"), "--set",
        "hand.amplitude_rad=0.01", "--set", "scene.duration_s=0.1",
    )  # fmt: skip
    assert (status, err.count("\n")) == (0, 1)
    assert "warning: the voltage may reach 60 V, beyond ±19.2 V" in err


def scaled(n: float) -> list[str]:
    """A motor whose currents and torques are counted in units of n A and n N·m."""
    return [f"motor.R_ohm={16e-3 * n}", f"motor.L_h={190e-6 * n}", f"motor.J_kgm2={0.025 / n}",
            f"hand.stiffness={1000 / n}", f"hand.damping={2 / n}"]  # fmt: skip


def test_a_large_motor_is_had_by_counting_in_larger_units(scene_of):
    """As docs/sensing.md has it: a free rotor is free, and a wall as stiff, times n."""
    metrics = measure(scene_of(FREE_ROTOR, *scaled(8)), "golden", compare=False)
    assert metrics["clipped_fraction"] == 0.0
    assert 8 * metrics["free_space_torque_rms"] < 5.0
    assert measure(scene_of(FREE_ROTOR), "golden", compare=False)["free_space_torque_rms"] > 50.0
    wall = ("controller.walls=[[0, 100]]", "hand.amplitude_rad=0.002", "hand.frequency_hz=4")
    stiff = [
        n * measure(scene_of(FREE_ROTOR, *scaled(n), *wall), "golden", compare=False)["stiffness"]
        for n in (1, 8)
    ]
    assert stiff[1] == pytest.approx(stiff[0], rel=1e-3)
