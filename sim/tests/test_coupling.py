# SPDX-License-Identifier: Apache-2.0
"""Two motors on a virtual shaft: its spring, its energy with any delay, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from test_tip import CONTROL, HEAD, MOTOR, PLANE, REAL, load, run, told
from wavehaptics.controller.coupling import cross, new_line
from wavehaptics.ladder.device_abilities import left_out_of_device
from wavehaptics.ladder.joint_run import measure_device, run_joint
from wavehaptics.scene import find_scene, load_device
from wavehaptics.trace.columns import Column

COUPLED = "[coupling]\n"
LEVERS = '[device]\nkinematics = "matrix"\njacobian = [[0.02, 0], [0, 0.02], [0, 0]]\n'
HAND = (
    '[hand]\npath = "press"\ndirection = [1, 0, 0]\namplitude_m = 0.004\n'
    "stiffness_n_per_m = 500\ndamping_n_s_per_m = 1\n"
)
HELD = "anchor_auto = true\n"
ERRORS = (
    "brushes.drop_v=0.3", "motors.0.adc.offset_a=3e-3", "motors.1.adc.offset_a=-3e-3",
    "motors.0.drive.gain_error=-0.05", "motors.1.drive.gain_error=0.05", "motors.0.R_ohm=8.3",
    "motors.1.R_ohm=6.9", "controller.r_hat=7.6",
)  # fmt: skip


def levers(*tables: str, held: str = HELD) -> str:
    return "".join((HEAD, LEVERS, *tables, HAND, MOTOR * 2, REAL, CONTROL, held))


def spring(delay_s: float, r_hat: float) -> float:
    """``k_T²/(2L + R̂ (τ + δ))`` of the RE 25 at 1 MHz, with a = 0.99 and a period of latency."""
    late = (1 / 0.99 + 1) * 1e-6 + delay_s
    return 43.8e-3**2 / (2 * 0.83e-3 + r_hat * late)


@pytest.mark.parametrize("delay_s", [0.0, 1e-3, 1e-2])
@pytest.mark.parametrize("errors", [(), ERRORS])
def test_a_shaft_is_as_stiff_as_its_delay_lets_it_be(
    tmp_path: Path, delay_s: float, errors: tuple[str, ...]
) -> None:
    """The leader's torque comes out of the follower, and both together give out nothing."""
    sets = (f"coupling.delay_s={delay_s}", "scene.duration_s=0.3", *errors)
    device = load(tmp_path, levers(COUPLED), *sets)
    found = measure_device(device, "golden")
    wanted = spring(delay_s, 0.7 * 7.6)
    assert found["shaft_stiffness_predicted"] == pytest.approx(wanted, rel=1e-3)
    # Half a count of each motor, and what gains of ±5 % make of R̂ δ.
    count = 2 * math.pi / 10_000
    unsure = count / found["shaft_twist_rad"] + (0.03 if errors else 0.005)
    assert found["shaft_stiffness"] == pytest.approx(wanted, rel=unsure)
    # Three springs in a row: the hand's, the shaft's and the one behind the follower.
    hand = 500 * 0.02**2
    torque = 0.2 / (2 / hand + 1 / wanted)
    assert found["shaft_torque"] == pytest.approx(torque, rel=0.03)
    assert found["shaft_ripple"] < 0.1 * torque
    assert found["shaft_energy_ratio"] < 0.01
    assert all(one["anchor_fault_s"] is None for one in found["motors"].values())


def test_the_law_alone_has_the_spring(tmp_path: Path) -> None:
    """Without anchors and errors R̂ is R, and the formula holds to 0.2 %."""
    for delay_s in (0.0, 5e-3):
        sets = (f"coupling.delay_s={delay_s}", "scene.duration_s=0.3")
        found = measure_device(load(tmp_path, levers(COUPLED, held=""), *sets), "golden")
        assert found["shaft_stiffness"] == pytest.approx(spring(delay_s, 7.6), rel=2e-3)
        assert found["shaft_energy_ratio"] < 1e-6


def test_motors_turn_together_however_far(tmp_path: Path) -> None:
    """By a radian and back: the follower is within two counts of where the spring has it."""
    sets = (
        "hand.path=taps", "hand.frequency_hz=4", "hand.amplitude_m=0.03",
        "hand.stiffness_n_per_m=100", "scene.duration_s=0.26",
    )  # fmt: skip
    device = load(tmp_path, levers(COUPLED), *sets)
    rows, _, _ = run(device, "golden", 0.26)
    x, torque = rows[:, :, Column.X], rows[:, :, Column.TORQUE]
    assert x[0].max() > 1.0
    through = 0.5 * (torque[1] - torque[0])
    error = x[0] - x[1] - through / spring(0.0, 0.7 * 7.6)
    assert np.abs(error[2000:]).max() < 2 * 2 * math.pi / 10_000


def test_a_line_gives_out_what_came_in_and_no_more() -> None:
    rng = np.random.default_rng(17)
    for delay in (0, 1, 7):
        line, at = new_line(delay), np.zeros(1, dtype=np.int64)
        sent = rng.integers(-(1 << 17), 1 << 17, (40, 2))
        came = np.array([_crossed(line, at, waves) for waves in sent])
        np.testing.assert_array_equal(came[delay:], sent[: len(sent) - delay, ::-1])
        assert not came[:delay].any()
        energy = [np.cumsum((waves**2).sum(axis=1)) for waves in (came, sent)]
        assert (energy[0] <= energy[1]).all()


def _crossed(line: np.ndarray, at: np.ndarray, sent: np.ndarray) -> np.ndarray:
    waves = np.array([*sent, 0])
    cross(line, at, waves)
    assert waves[2] == 0
    return waves[:2]


@pytest.mark.parametrize("normal", [(1.0, -1.0, 0.0), (2.0, -1.0, 0.0)])
def test_two_opposite_planes_are_a_shaft_or_a_gear(tmp_path: Path, normal) -> None:
    """1:1 and 1:2 with a spring of the planes' own formula, both ways through zero."""
    planes = "".join(PLANE.format(normal=[sign * part for part in normal]) for sign in (1, -1))
    taps = HAND.replace('"press"', '"taps"') + "frequency_hz = 5\n"
    content = levers(planes).replace(HAND, taps)
    rows, _, simulation = run(load(tmp_path, content, "hand.amplitude_m=0.002"), "golden", 0.22)
    x, torque = rows[:, :, Column.X], rows[:, :, Column.TORQUE]
    g = np.array(normal[:2]) / np.linalg.norm(normal)
    deflected, along = g @ x, -(g @ torque)
    k_n = 2 * spring(0.0, 0.7 * 7.6)
    count = 2 * math.pi / 10_000
    assert np.abs(deflected).max() > 5 * count
    # Half a count of each of two motors and of the surface, and the anchors' lead.
    assert np.abs(deflected - along / k_n).max() < 3 * count
    # Nothing is felt of a turn that keeps the ratio.
    assert np.sqrt(np.mean((np.array([-g[1], g[0]]) @ torque) ** 2)) < 0.1 * np.abs(along).max()
    given = np.cumsum((torque * rows[:, :, Column.OMEGA]).sum(axis=0)) * simulation.tick_s
    assert given.max() < 0.05 * 0.5 * np.abs(along).max() ** 2 / k_n


def shaft_on_pins(folder: Path, hand: str, wanted: float, *settings: str) -> np.ndarray:
    """Twist and torque through two opposite planes on ``pins``, which give out nothing: (2, ticks).

    It is at a rate for which a board's clock has time.
    """
    planes = "".join(PLANE.format(normal=[sign, -sign, 0]) for sign in (1, -1))
    device = load(
        folder, levers(planes).replace(HAND, hand), "controller.tick_hz=100e3",
        "controller.clock_hz=32e6", *settings,
    )  # fmt: skip
    kept = []
    measure_device(device, "pins", keep=lambda rows, words, tips: kept.append(rows.copy()))
    rows = np.concatenate(kept, axis=1)
    x, torque = rows[:, :, Column.X], rows[:, :, Column.TORQUE]
    twist, through = x[0] - x[1], 0.5 * (torque[1] - torque[0])
    given = np.cumsum((torque * rows[:, :, Column.OMEGA]).sum(axis=0)) * 1e-5
    assert given.max() < 0.02 * 0.5 * np.abs(through).max() ** 2 / wanted
    assert not rows[:, :, Column.FAULT].any()
    return np.array([twist, through])


def shaft_with_a_lag(lag_s: float) -> float:
    """K of a shaft on ``pins``, N·m/rad, with a lag beside the loop's own delay."""
    late = (1 / 0.99 + 1) * 1e-5 + lag_s
    return 43.8e-3**2 / (2 * 0.83e-3 + 0.7 * 7.6 * late)


@pytest.mark.long
def test_two_opposite_planes_are_a_shaft_on_pins(tmp_path: Path) -> None:
    """Pushed to and fro at 10 Hz."""
    taps = HAND.replace('"press"', '"taps"') + "frequency_hz = 10\n"
    wanted = shaft_with_a_lag(0.0)
    twist, through = shaft_on_pins(
        tmp_path, taps, wanted, "hand.amplitude_m=0.002", "scene.duration_s=0.11"
    )
    assert (twist @ through) / (twist @ twist) == pytest.approx(wanted, rel=0.02)


@pytest.mark.long
@pytest.mark.parametrize("lag_s", [0.0, 1e-3, 1e-2])
def test_a_lag_softens_a_shaft_on_pins(tmp_path: Path, lag_s: float) -> None:
    """The planes' filters in the RTL as the lag of the line: pressed, at rest, and the formula."""
    wanted = shaft_with_a_lag(lag_s)
    # 1/Σ G_n²/K_n of two levers of 0.02 m, along (1, −1)/√2.
    hard = [f"surface.{n}.stiffness={2 * wanted / 0.02**2!r}" for n in (0, 1) if lag_s]
    twist, through = shaft_on_pins(
        tmp_path, HAND, wanted, "hand.amplitude_m=0.004", "scene.duration_s=0.25", *hard
    )
    rest = slice(20_000, None)
    # Half a count of each motor.
    unsure = 2 * math.pi / 10_000 / twist[rest].mean()
    assert through[rest].mean() / twist[rest].mean() == pytest.approx(wanted, rel=unsure)
    assert through[rest].std() < 0.01 * through[rest].mean()
    assert np.ptp(twist[rest]) < 2 * math.pi / 10_000


def test_the_shipped_scene_writes_its_files(tmp_path: Path) -> None:
    device = load_device(find_scene("teleoperation"), ["scene.duration_s=0.25"])
    found = run_joint(device, "golden", tmp_path)
    assert found["shaft_stiffness"] == pytest.approx(spring(1e-3, 0.7 * 7.6), rel=0.03)
    assert found["tip_stiffness"] is None
    assert (tmp_path / "tip.png").stat().st_size > 20_000
    assert (tmp_path / "follower" / "trace.npz").exists()


def test_what_a_coupling_leaves_out_and_refuses(tmp_path: Path) -> None:
    content = levers(COUPLED)
    device = load(tmp_path, content, "device.update_hz=100", "device.wall_energy_j=0")
    assert left_out_of_device(device, "golden") == ["device.update_hz", "device.wall_energy_j"]
    for controller in ("analog", "pins", "encoder"):
        said = told(tmp_path, content, controller=controller)
        assert f"[coupling] is not for `{controller}`" in said
        assert "two opposite planes" in said
    assert "[device] is not for `core`" in told(tmp_path, content, controller="core")
    plane = PLANE.format(normal=[1, -1, 0])
    assert "take the same waves" in told(tmp_path, levers(COUPLED, plane))
    three = content.replace(LEVERS, '[device]\nkinematics = "phantom"\n').replace(
        MOTOR * 2, MOTOR * 3
    )
    assert "joins two motors, and the device has 3" in told(tmp_path, three)
    for other in ("motors.1.controller.r_hat=8", "motors.0.encoder.counts_per_rev=4000"):
        assert "[coupling] needs one k_t_hat" in told(tmp_path, content, other)
    alone = content.replace(LEVERS, "")
    assert "[device] is missing, [[surface]] and [coupling] need it" in told(tmp_path, alone)
    assert "coupling.delay_s = 2.0 is out of range" in told(
        tmp_path, content, "coupling.delay_s=2.0"
    )
