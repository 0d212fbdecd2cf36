# SPDX-License-Identifier: Apache-2.0
"""A brushless motor the usual way: its current control, its servo, and a scene's faults."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter
from wavehaptics.ladder.abilities import left_out
from wavehaptics.ladder.encoder import EncoderSimulation
from wavehaptics.ladder.field_oriented import FieldOrientedSimulation
from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.parts.motors import BRUSHLESS_PRESETS
from wavehaptics.scene import Scene, SceneError, load_scene
from wavehaptics.trace.columns import Column

BASE = """
[scene]
name = "field_oriented"
duration_s = 0.1
[motor]
preset = "gbm2804-100t"
[controller]
tick_hz = 1e6
lambda = 1e4
"""
GIMBAL = BRUSHLESS_PRESETS["gbm2804-100t"]
K_T = 1.5 * GIMBAL.pole_pairs * GIMBAL.psi_vs
DEPTH, STIFFNESS = 0.01, 0.5
LOCKED = ("motor.J_kgm2=1.0", f"controller.walls=[[-{DEPTH}, 1]]", f"servo.stiffness={STIFFNESS}")
"""A rotor so heavy that it stands still, deep in a wall: the servo asks for a step."""
FINAL_A = -STIFFNESS * DEPTH / K_T
SLOW = (
    "hand.path='sine'", "hand.amplitude_rad=0.05", "hand.frequency_hz=2", "hand.stiffness=0.1",
    "hand.damping=2e-3", "controller.walls=[[0, 1]]", "controller.tick_hz=1e5",
    "scene.duration_s=0.25",
)  # fmt: skip
ANGLES = [n * math.pi / 4 for n in range(8)]


@pytest.fixture
def make_scene(tmp_path: Path) -> Callable[..., Scene]:
    """A function that makes a scene of settings on a gimbal's motor."""
    path = tmp_path / "scene.toml"
    path.write_text(BASE)
    return lambda *sets: load_scene(path, sets)


def magnets_at(theta: float) -> str:
    """The setting with which x = 0 is the electrical angle ``theta``."""
    return f"motor.magnet_rad={-theta / GIMBAL.pole_pairs:.12g}"


def rows_of(scene: Scene, duration_s: float) -> np.ndarray:
    simulation = CONTROLLERS["encoder"](scene)
    rows = np.zeros((round(duration_s / simulation.tick_s), len(Column)))
    simulation.advance(rows, None)
    return rows


def sampled_step(foc_hz: float, bandwidth_hz: float, periods: int) -> np.ndarray:
    """i_q at the sampling instants after a step of 1 A: z-transforms of PI, late hold, winding."""
    a = math.exp(-GIMBAL.R_ohm / GIMBAL.L_h / foc_hz)
    omega = 2 * math.pi * bandwidth_hz
    k_p, k_i = omega * GIMBAL.L_h, omega * GIMBAL.R_ohm / foc_hz
    through = (1.0 - a) / GIMBAL.R_ohm
    # Open loop (k_p (z − 1) + k_i) through / (z (z − 1) (z − a)), in powers of 1/z.
    forward = through * np.array([0.0, 0.0, k_p, k_i - k_p])
    back = np.array([1.0, -1.0 - a, a, 0.0])
    return lfilter(forward, back + forward, np.ones(periods))


@pytest.mark.parametrize("foc_hz", [20e3, 100e3])
@pytest.mark.parametrize("part", [1 / 40, 1 / (6 * math.pi), 0.1])
@pytest.mark.parametrize("theta", [0.0, 2.0])
def test_current_step_is_that_of_the_sampled_loop(make_scene, foc_hz, part, theta):
    """Period for period, in the frame of the rotor, wherever that stands."""
    scene = make_scene(*LOCKED, magnets_at(theta), f"servo.foc_hz={foc_hz}",
                       f"servo.amplifier_hz={part * foc_hz}", "drive.bus_v=48",
                       "servo.rate_hz=20e3")  # fmt: skip
    periods, ticks = 60, round(1e6 / foc_hz)
    rows = rows_of(scene, (periods * ticks + 1) * 1e-6)
    # A sample ends its tick; rows have means, and the voltage is the same in both of these.
    current = rows[:, Column.I]
    at = ticks * np.arange(1, periods)
    found = 1.5 * current[at] - 0.5 * current[at - 1]
    expected = FINAL_A * sampled_step(foc_hz, part * foc_hz, periods)[1:]
    assert np.abs(found - expected).max() < 1e-4 * abs(FINAL_A)


def test_default_bandwidth_hardly_overshoots(make_scene):
    """4 %, as twice the sum of the small times always gives."""
    rows = rows_of(make_scene(*LOCKED, "drive.bus_v=48"), 4e-3)
    over = (rows[:, Column.I] / FINAL_A).max() - 1.0
    assert 0.02 < over < 0.08
    assert rows[-1, Column.I] == pytest.approx(FINAL_A, rel=1e-3)


def test_at_a_fast_rate_it_is_the_analog_amplifier(make_scene):
    """First-order response at 1 MHz, and the run of a motor with brushes that feels the same."""
    rate = ("servo.amplifier_hz=2e3", "servo.rate_hz=1e5")
    scene = make_scene(*LOCKED, "servo.foc_hz=1e6", *rate, "drive.bus_v=48")
    t = 1e-6 * (np.arange(1000) - 1.5)  # late by a tick and a half
    first_order = FINAL_A * (1 - np.exp(-2 * math.pi * 2e3 * np.maximum(t, 0.0)))
    found = rows_of(scene, 1e-3)[:, Column.I]
    assert np.abs(found - first_order).max() < 0.02 * abs(FINAL_A)

    hand = ("hand.path='taps'", "hand.amplitude_rad=0.02", "hand.frequency_hz=10",
            "hand.stiffness=0.3", "hand.damping=1e-3", "controller.walls=[[0, 1]]",
            "servo.stiffness=0.5", *rate)  # fmt: skip
    scene = make_scene(*hand, "servo.foc_hz=1e6", "drive.bus_v=48")
    motor = scene.motor
    brushes = make_scene(*hand[:-2], *rate, "motor.preset=re25-118743",
                         f"motor.R_ohm={motor.R_ohm}", f"motor.L_h={motor.L_h}",
                         f"motor.k_t={motor.felt_k_t:.12g}",
                         f"motor.J_kgm2={motor.J_kgm2}")  # fmt: skip
    ours = rows_of(scene, 0.1)[:, Column.TORQUE]
    theirs = rows_of(brushes, 0.1)[:, Column.TORQUE]
    assert np.abs(theirs).max() > 1e-3
    assert np.sqrt(np.mean((ours - theirs) ** 2)) < 0.01 * np.abs(theirs).max()


def test_a_sample_reaches_the_bridge_a_period_later(make_scene):
    for foc_hz, ticks in ((20e3, 50), (1e6, 1)):
        rows = rows_of(make_scene(*LOCKED, f"servo.foc_hz={foc_hz}"), 1e-3)
        assert np.flatnonzero(rows[:, Column.I])[0] == ticks + 1


@pytest.mark.parametrize("theta", ANGLES)
def test_slow_pressing_feels_the_virtual_spring(make_scene, theta):
    scene = make_scene(*SLOW, "servo.stiffness=0.1", magnets_at(theta))
    metrics = measure(scene, "encoder")
    assert metrics["stiffness"] == pytest.approx(0.1, rel=0.01)
    assert metrics["stiffness_predicted"] == pytest.approx(0.1)
    assert metrics["free_space_torque_rms"] < 1e-2 * metrics["peak_torque"]


def test_a_wrong_torque_constant_is_a_wrong_spring(make_scene):
    k_t_hat = 1.1 * make_scene().motor.felt_k_t
    scene = make_scene(*SLOW, "servo.stiffness=0.1", f"controller.k_t_hat={k_t_hat:.12g}")
    metrics = measure(scene, "encoder", compare=False)
    assert metrics["stiffness_predicted"] == pytest.approx(0.1 / 1.1)
    assert metrics["stiffness"] == pytest.approx(0.1 / 1.1, rel=0.01)


@pytest.mark.parametrize("degrees", [20, 60])
def test_wrong_magnets_cost_torque(make_scene, degrees):
    """What is taken for q is q turned by the error: its cosine is left."""
    wrong = math.radians(degrees) / GIMBAL.pole_pairs
    rows = rows_of(make_scene(*LOCKED, "drive.bus_v=48", f"controller.magnet_hat_rad={wrong}"),
                   5e-3)  # fmt: skip
    expected = FINAL_A * math.cos(math.radians(degrees))
    assert rows[-1, Column.I] == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("theta", ANGLES[:4])
def test_an_offset_is_a_torque_by_the_angle(make_scene, theta):
    """Both phases read 20 mA too much: α too, β by √3 of it."""
    rows = rows_of(
        make_scene(*LOCKED, magnets_at(theta), "drive.bus_v=48", "adc.bits=16",
                   "adc.full_scale_a=2", "adc.offset_a=20e-3"),
        5e-3,
    )  # fmt: skip
    wrong = 20e-3 * (math.sqrt(3.0) * math.cos(theta) - math.sin(theta))
    assert rows[-1, Column.I] == pytest.approx(FINAL_A - wrong, abs=0.5e-3)


def test_a_drive_that_gives_more_is_made_good_by_the_integral(make_scene):
    plain, more = (
        rows_of(make_scene(*LOCKED, "drive.bus_v=48", f"drive.gain_error={error}"), 10e-3)
        for error in (0.0, 0.2)
    )
    rise = slice(0, 400)
    assert np.abs(plain[rise, Column.I] - more[rise, Column.I]).max() > 0.05 * abs(FINAL_A)
    assert more[-1, Column.I] == pytest.approx(FINAL_A, rel=1e-3)


def test_noise_is_felt_and_repeats(make_scene):
    sets = (*LOCKED, "drive.bus_v=48", "adc.bits=12", "adc.full_scale_a=1", "adc.noise_a=2e-3")
    noisy, again = (rows_of(make_scene(*sets), 20e-3) for _ in range(2))
    assert np.array_equal(noisy, again)
    assert 1e-4 < np.std(noisy[5000:, Column.I]) < 4e-3
    quiet = rows_of(make_scene(*LOCKED, "drive.bus_v=48"), 20e-3)
    assert np.std(quiet[5000:, Column.I]) < 0.05 * np.std(noisy[5000:, Column.I])


@pytest.mark.parametrize("theta", [0.0, 0.4, 2.0])
def test_space_vectors_end_at_the_bus_over_root_three(make_scene, theta):
    """In any direction; and an integral does not wind up meanwhile."""
    sets = ("motor.J_kgm2=1.0", "hand.path='impact'", "hand.amplitude_rad=0.02",
            "hand.speed_rad_s=1", "controller.walls=[[-1, 0]]", "servo.stiffness=3")  # fmt: skip
    scene = make_scene(*sets, magnets_at(theta), "drive.bus_v=6")
    rows = rows_of(scene, 40e-3)
    limited = rows[:, Column.SATURATED] != 0
    assert 0.2 < limited.mean() < 0.9
    held = rows[limited][2000:, Column.I]
    # Of the longest vector the winding's drop is all that is left at rest, less a little back-EMF.
    assert np.abs(held).max() == pytest.approx(6 / math.sqrt(3) / GIMBAL.R_ohm, rel=0.02)
    left = np.flatnonzero(np.diff(rows[:, Column.CONTACT]) < 0)[-1]
    asked = 3 * 2e-3 / K_T  # 2 ms before, at 1 rad/s; a servo at 1 kHz is as much as 1 ms late
    assert asked < rows[left - 2000, Column.I] < 1.6 * asked
    assert np.abs(rows[left + 2500 :, Column.I]).max() < 1e-3


def test_chunks_do_not_matter(make_scene):
    scene = make_scene(*LOCKED, "adc.bits=12", "adc.noise_a=1e-3", "servo.delay_s=1e-3")
    whole = rows_of(scene, 5e-3)
    simulation = FieldOrientedSimulation(scene)
    rows = np.zeros_like(whole)
    for part in (slice(0, 777), slice(777, 3000), slice(3000, None)):
        simulation.advance(rows[part])
    assert np.array_equal(rows, whole)


@pytest.mark.parametrize(
    ("sets", "told"),
    [
        (("servo.foc_hz=3e5",), "servo.foc_hz = 300000 does not divide controller.tick_hz"),
        (("servo.rate_hz=3e5",), "servo.rate_hz = 300000 does not divide controller.tick_hz"),
        (("servo.amplifier_hz=5e3",), "servo.foc_hz = 20000 Hz, with which it is stepped; it may"),
        (("controller.anchor_auto=true", "controller.find_magnet=true"),
         "find_magnet is not for `encoder`; a servo has to know the angle; leave it out"),
        (("adc.bits=12", "adc.bandwidth_hz=1e5"), "adc.bandwidth_hz is not for `encoder`"),
    ],
)  # fmt: skip
def test_refused(make_scene, sets, told):
    with pytest.raises(SceneError) as refused:
        CONTROLLERS["encoder"](make_scene(*sets))
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)


def test_refused_by_the_format(make_scene):
    with pytest.raises(SceneError, match="foc_hz belongs to a brushless motor; leave it out"):
        make_scene("motor.preset=re25-118743", "servo.foc_hz=20e3")
    with pytest.raises(SceneError, match="belongs to a brushless motor's port anchor or servo"):
        make_scene("controller.magnet_hat_rad=0.1")
    with pytest.raises(SceneError, match="three phases and this amplifier one"):
        EncoderSimulation(make_scene())


def test_what_is_left_out_is_told(make_scene):
    """The currents are sampled; an angle for the servo is nobody else's."""
    sets = ("adc.bits=12", "servo.rate_hz=1e3", "controller.magnet_hat_rad=0.1")
    scene = make_scene(*sets, "controller.r_hat=5", "controller.eta_contact=-0.9")
    assert left_out(scene, "encoder") == ["controller.eta_contact"]
    assert "controller.magnet_hat_rad" in left_out(scene, "golden")
    brushes = make_scene("adc.bits=12", "motor.preset=re25-118743")
    assert left_out(brushes, "encoder") == ["[adc]"]
