# SPDX-License-Identifier: Apache-2.0
"""A brushless motor on `pins`: ADC bits of two phases, encoder edges and six gates."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_brushless import (
    ANGLES,
    EVERYWHERE,
    GIMBAL,
    PSI,
    TAP,
    magnets_at,
    make_scene,
    rows_of,
    turning,
)
from wavehaptics.controller.pins_timing import turns_latency_clocks
from wavehaptics.ladder.brushless_pins import BrushlessPinsSimulation
from wavehaptics.ladder.run import measure
from wavehaptics.laws import closed_forms
from wavehaptics.scene import SceneError
from wavehaptics.scene.tables.drive import THREE_PHASE_REACH
from wavehaptics.trace.columns import Column, Word

__all__ = ["make_scene"]

SENSED = ("encoder.counts_per_rev=10000", "adc.bits=12", "adc.full_scale_a=1", "adc.noise_a=0.5e-3",
          "drive.bus_v=12")  # fmt: skip


@pytest.mark.kept("0-degrees", "135-degrees")
@pytest.mark.parametrize("theta", ANGLES, ids=[f"{45 * n}-degrees" for n in range(8)])
def test_stiffness_at_eight_angles(make_scene, theta):
    """K = 1.5 (pψ)²/(L + Rτ/2) within 1 %, wherever the magnets stand, with 12 bits and noise."""
    result = measure(make_scene(*TAP, *SENSED, magnets_at(theta)), "pins")
    k = 1.5 * PSI**2 / (GIMBAL.L_h + GIMBAL.R_ohm * 1e-4 / 2)
    assert result["stiffness_predicted"] == pytest.approx(k, rel=1e-4)
    assert result["stiffness"] == pytest.approx(k, rel=0.01)
    assert result["torque_nrmse_vs_analog"] < 5e-3
    # The hand's spring of 2 N·m/rad against the wall's, 8 mrad apart.
    assert result["peak_torque"] == pytest.approx(8e-3 * k * 2.0 / (k + 2.0), rel=0.02)
    assert result["clock_cycles"] == pytest.approx(76 * result["ticks"], rel=1e-3)
    assert "faults" not in result


def test_free_space_is_free(make_scene):
    """A hand waves the rotor over an electrical turn: 0.05 mN·m at most, as on `golden`."""
    scene = make_scene(
        "hand.path='free'", "hand.amplitude_rad=0.5", "hand.frequency_hz=10", "hand.stiffness=0.1",
        "hand.damping=0.5e-3", "controller.walls=[[0.0, 1.0]]", "scene.duration_s=0.1", *SENSED,
        "adc.noise_a=0",
    )  # fmt: skip
    felt = []
    for controller in ("pins", "golden"):
        rows = rows_of(scene, controller)
        assert np.ptp(rows[:, Column.X]) * GIMBAL.pole_pairs > 2 * math.pi
        begun = rows[:, Column.T] > 2e-3  # the rotor moves in the first tick, and no wave knows it
        torque = rows[begun, Column.TORQUE]
        assert np.abs(torque).max() < 0.05e-3
        felt.append(np.sqrt(np.mean(torque**2)))
    assert felt[0] == pytest.approx(felt[1], rel=0.1)


def test_the_motor_gets_what_the_waves_asked_for(make_scene):
    """e = s·u of the same tick, but for whole clocks, which are owed: the sum stays bounded.

    That holds latency, inverse transform, modulators and gates to each other, by the plant's volts.
    """
    scene = make_scene(*TAP, *SENSED, magnets_at(0.5))
    simulation = BrushlessPinsSimulation(scene)
    rows = np.zeros((50_000, len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    asked = closed_forms.root(GIMBAL.R_ohm) * rows[:, Column.U]
    clock_v = 12.0 / simulation.timing.half_clocks
    assert np.abs(asked).max() > clock_v
    owed = np.cumsum(rows[:, Column.E_A] - asked)
    assert np.abs(owed).max() < 1.5 * clock_v
    assert simulation.faults == 0


def test_dead_time_takes_what_it_must(make_scene):
    """bus·dead/period of each leg, against its current, where it is not made good.

    Of three currents that are sines along q that is (2/3)·Σ|cos| of it in the mean: 4/π.
    """
    scene = make_scene(
        *turning(60.0), EVERYWHERE, "controller.eta_contact=-0.5", "drive.bus_v=12",
        "scene.duration_s=0.06", f"drive.dead_time_s={1 / 76e6}", "drive.compensate=false",
    )  # fmt: skip
    rows = rows_of(scene, "pins")
    turn = round(2 * math.pi / GIMBAL.pole_pairs / 60.0 / 1e-6)
    rows = rows[-3 * turn :]
    lost = rows[:, Column.E_A] - closed_forms.root(GIMBAL.R_ohm) * rows[:, Column.U]
    against = -np.sign(rows[:, Column.I].mean())
    assert np.all(rows[:, Column.I] * against < -0.01)
    assert lost.mean() == pytest.approx(against * 4 / math.pi * 12.0 / 76, rel=0.03)


@pytest.mark.parametrize(
    ("dead_clocks", "theta", "adc"),
    [
        (3, 5.5, ("adc.bits=16", "adc.noise_a=0.02e-3")),
        (7, 0.8, ("adc.noise_a=0",)),
        (15, 2.1, ("adc.noise_a=0.15e-3",)),
    ],
)
def test_dead_time_is_made_good(make_scene, dead_clocks, theta, adc):
    """By the legs' currents, where the ADC just tells their sides.

    Of 12 V it takes 0.6 to 2.9 V, and the tap needs 0.6.
    """
    dead = f"drive.dead_time_s={dead_clocks / 76e6}"
    sets = (*TAP, *SENSED, *adc, dead, magnets_at(theta), "scene.duration_s=0.045")
    result = measure(make_scene(*sets), "pins")
    assert result["stiffness"] == pytest.approx(result["stiffness_predicted"], rel=0.01)
    assert result["torque_nrmse_vs_analog"] < 0.03


@pytest.mark.parametrize("theta", [0.0, math.pi / 4])
def test_both_axes_reach_their_limit_at_once(make_scene, theta):
    """0.4226 of the bus on each: at the hexagon's corner the legs still have room for it."""
    scene = make_scene(
        "hand.path='press'", "hand.amplitude_rad=0.06", "hand.stiffness=2", "hand.damping=3e-3",
        "controller.walls=[[0.0, 1.0]]", "scene.duration_s=0.15", "controller.r_hat=4.8",
        "drive.bus_v=12", magnets_at(theta - 0.2),
    )  # fmt: skip
    rows = rows_of(scene, "pins")[-2000:]
    assert np.all(rows[:, Column.SATURATED] == 1.0)
    at = GIMBAL.pole_pairs * rows[:, Column.X] + theta - 0.2
    limit = 12.0 * THREE_PHASE_REACH
    # Both axes are at it, or the one that q lies along.
    both = limit * (np.abs(np.sin(at)) + np.abs(np.cos(at)))
    found = np.abs(rows[:, Column.E_A])
    if theta:
        assert found.mean() == pytest.approx(both.mean(), rel=0.005)
    assert np.all(found < 1.1 * both)
    torque = np.abs(rows[:, Column.TORQUE]).mean()
    assert torque == pytest.approx(1.5 * PSI * found.mean() / GIMBAL.R_ohm, rel=0.01)


def test_slow_ticks_have_rows_of_their_own(make_scene):
    """Where a step is done before its tick ends: rows a tick apart from the first one on."""
    scene = make_scene(
        *TAP, *SENSED, "controller.tick_hz=50e3", "controller.lambda=5e3", magnets_at(1.0),
    )  # fmt: skip
    rows = rows_of(scene, "pins")
    steps = np.diff(rows[:, Column.T])
    assert rows[0, Column.T] == pytest.approx(10e-6)
    assert steps[1:] == pytest.approx(20e-6, rel=1e-6)
    result = measure(scene, "pins", compare=False)
    assert result["stiffness"] == pytest.approx(result["stiffness_predicted"], rel=0.01)


def test_chunks_do_not_matter(make_scene):
    scene = make_scene(*TAP, *SENSED, "scene.duration_s=0.002")
    whole = rows_of(scene, "pins")
    simulation = BrushlessPinsSimulation(scene)
    rows, raw = np.zeros_like(whole), np.zeros((len(whole), len(Word)), dtype=np.int64)
    for part in (slice(0, 1), slice(1, 777), slice(777, None)):
        simulation.advance(rows[part], raw[part])
    assert np.array_equal(rows, whole)


@pytest.mark.parametrize(
    ("sets", "told"),
    [
        (("controller.clock_hz=48e6",), r"shorter than the 74 that `pins` needs for two ports"),
        (("controller.extra_ticks=1",), "set extra_ticks = 2 or more"),
        (("drive.dead_time_s=100e-9",), r"are 0\.0025 A, and half .* is 0\.00066 A, too little"),
        (("adc.part=MAX11125",), r"MAX11125: .* two serial converters yet; take one of those"),
        (("adc.part=AMC1306M25", "adc.bits=16"), r"AMC1306M25: .* two serial converters yet"),
    ],
)  # fmt: skip
def test_refused_in_one_line(make_scene, sets, told):
    with pytest.raises(SceneError, match=told) as refused:
        BrushlessPinsSimulation(make_scene(*TAP, *SENSED, *sets))
    assert "\n" not in str(refused.value)


def test_latency_is_that_of_two_ports():
    assert turns_latency_clocks(28, 1, brushless=True) == 28 + 89
