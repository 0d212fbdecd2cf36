# SPDX-License-Identifier: Apache-2.0
"""The three facts of ``docs/principle.md``, on the integer model with its motor."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.ladder.analog import AnalogSimulation
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.laws import closed_forms
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats

INSIDE = (
    "hand.path='sine'",
    "hand.amplitude_rad=0.01",
    "hand.frequency_hz=5",
    "hand.stiffness=2",
    "hand.damping=5e-3",
)
# Forty walls of 1 mrad with gaps of 1 mrad between: η changes sign about a thousand times a second.
STRIPES = f"controller.walls={[[0.002 * n, 0.002 * n + 0.001] for n in range(-20, 20)]}"
SWITCHING = (
    "hand.path='sine'",
    "hand.amplitude_rad=0.03",
    "hand.frequency_hz=7",
    "hand.stiffness=2",
    "hand.damping=2e-3",
    STRIPES,
)
SIX_RATES_HZ = (1e6, 1e5, 2e4, 5e3, 1e3, 500)


def simulate(simulation, duration_s: float) -> np.ndarray:
    """Rows of ``duration_s`` of a simulation."""
    ticks = round(duration_s / simulation.tick_s)
    rows = np.zeros((ticks, len(Column)))
    simulation.advance(rows, np.zeros((ticks, len(Word)), dtype=np.int64))
    return rows


def slope(rows: np.ndarray) -> float:
    """Least-squares −torque over x, N·m/rad."""
    return -np.polyfit(rows[:, Column.X], rows[:, Column.TORQUE], 1)[0]


@pytest.mark.parametrize("extra_ticks", [0, 1, 3])
@pytest.mark.parametrize("tick_hz", [1e6, 1e5, 2e4, 5e3])
@pytest.mark.parametrize("lambda_", [1e9, 1e4, 300.0])
def test_rigid_contact_renders_the_predicted_stiffness(make_scene, tick_hz, extra_ticks, lambda_):
    """Fact 2: K = k_T²/(L + R τ/2) with τ = T/a + kT, to 0.1 %, for T from 1 µs to 200 µs."""
    scene = make_scene(
        *INSIDE,
        "controller.walls=[[-1, 1]]",
        f"controller.tick_hz={tick_hz}",
        f"controller.extra_ticks={extra_ticks}",
        f"controller.lambda={lambda_}",
    )
    simulation = SampledSimulation(scene, rtl=False)
    motor, tau = scene.motor, simulation.settings.tau
    expected = closed_forms.stiffness(motor.k_t, motor.L_h, motor.R_ohm, tau)
    assert slope(simulate(simulation, 0.4)) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("lambda_", [5e5, 1e4, 1e3])
def test_analog_circuit_has_twice_the_stiffness_of_equation_14(make_scene, lambda_):
    """The λ filter's own spring is 2 k_T² λ/R, twice what the paper's (14) prints."""
    scene = make_scene(*INSIDE, "controller.walls=[[-1, 1]]", f"controller.lambda={lambda_}")
    motor = scene.motor
    k = slope(simulate(AnalogSimulation(scene), 0.4))
    k_l = closed_forms.k_l(motor.k_t, motor.L_h)
    filter_spring = 1 / (1 / k - 1 / k_l)
    expected = closed_forms.filter_stiffness(motor.k_t, motor.R_ohm, lambda_)
    assert filter_spring == pytest.approx(expected, rel=5e-3)
    assert filter_spring / (motor.k_t**2 * lambda_ / motor.R_ohm) == pytest.approx(2, rel=5e-3)


def test_partial_contact_is_a_resistor_and_a_spring(make_scene):
    """η = −g: series resistance R(1−g)/(1+g), and L_extra = R τ·2g/(1+g)² (fact 2)."""
    g, hz = 0.6, 40.0
    scene = make_scene(
        *INSIDE,
        f"hand.frequency_hz={hz}",
        "hand.stiffness=2000",
        "controller.walls=[[-1, 1]]",
        f"controller.eta_contact={-g}",
        "controller.lambda=2e4",
    )
    simulation = SampledSimulation(scene, rtl=False)
    rows = simulate(simulation, 0.2)[100_000:]
    turns = np.exp(-2j * np.pi * hz * rows[:, Column.T])
    omega, current = (rows[:, c] @ turns for c in (Column.OMEGA, Column.I))
    motor, tau = scene.motor, simulation.settings.tau
    impedance = -motor.k_t * omega / current
    assert impedance.real == pytest.approx(closed_forms.series_resistance(motor.R_ohm, g), rel=1e-3)
    inductance = impedance.imag / (2 * np.pi * hz)
    assert inductance == pytest.approx(closed_forms.l_eff(motor.L_h, motor.R_ohm, tau, g), rel=2e-3)


def test_free_space_adds_the_predicted_inertia(make_scene):
    """Fact 2: free space feels like an added inertia k_T² τ/(2R)."""
    hz = 20.0
    scene = make_scene(
        *INSIDE, f"hand.frequency_hz={hz}", "hand.stiffness=2000", "controller.lambda=1000"
    )
    simulation = SampledSimulation(scene, rtl=False)
    rows = simulate(simulation, 0.3)[200_000:]
    turns = np.exp(-2j * np.pi * hz * rows[:, Column.T])
    omega, torque = (rows[:, c] @ turns for c in (Column.OMEGA, Column.TORQUE))
    inertia = -(torque / omega).imag / (2 * np.pi * hz)
    motor = scene.motor
    expected = closed_forms.free_space_inertia(motor.k_t, motor.R_ohm, simulation.settings.tau)
    assert inertia == pytest.approx(expected, rel=2e-2)


@pytest.mark.parametrize("extra_ticks", [0, 2])
@pytest.mark.parametrize("tick_hz", SIX_RATES_HZ)
def test_port_never_gives_energy_with_the_mean_current(make_scene, tick_hz, extra_ticks):
    """Fact 1, at six rates from 1 µs to 2 ms, with the stiffest filter and η always switching."""
    scene = make_scene(
        *SWITCHING,
        f"controller.tick_hz={tick_hz}",
        f"controller.extra_ticks={extra_ticks}",
        "controller.lambda=1e9",
    )
    rows = simulate(SampledSimulation(scene, rtl=False), 0.5)
    energy = np.cumsum(rows[:, Column.ENERGY_OUT])
    assert np.count_nonzero(np.diff(rows[:, Column.ETA])) > 100
    assert energy.max() <= 0.0
    assert energy.min() < -1e-5


def test_point_sampling_gives_energy(make_scene):
    """Fact 1 needs the mean: with one sample at the tick's end the port becomes a source."""
    scene = make_scene(*SWITCHING, "controller.tick_hz=500", "controller.lambda=1e9")
    point = simulate(SampledSimulation(scene, rtl=False, point_sampling=True), 0.5)
    mean = simulate(SampledSimulation(scene, rtl=False), 0.5)
    assert np.cumsum(point[:, Column.ENERGY_OUT]).max() > 1e-6
    assert np.cumsum(mean[:, Column.ENERGY_OUT]).max() <= 0.0


def test_energy_is_given_when_the_resistance_is_overestimated(make_scene):
    """The check above can fail: with R̂ 5 % too high the wall is a source."""
    scene = make_scene(*SWITCHING, "controller.r_hat=2.289", "controller.walls=[[-1, 1]]",
                       "drive.limit_v=2.1")  # fmt: skip
    rows = simulate(SampledSimulation(scene, rtl=False), 0.5)
    assert np.cumsum(rows[:, Column.ENERGY_OUT]).max() > 1e-5


def test_matched_lambda_is_independent_of_the_latency(make_scene):
    """Fact 3: a = T/(1/λ − kT) keeps τ = 1/λ, and the torque that of the analog circuit."""
    taps = (
        "hand.path='taps'", "hand.amplitude_rad=0.03", "hand.frequency_hz=10",
        "hand.stiffness=1", "hand.damping=2e-3", "controller.walls=[[0, 1]]",
        "drive.limit_v=2.1", "encoder.counts_per_rev=10000",
    )  # fmt: skip
    for extra_ticks in (0, 1, 10, 40):
        scene = make_scene(*taps, f"controller.extra_ticks={extra_ticks}")
        simulation = SampledSimulation(scene, rtl=False)
        assert simulation.settings.tau == pytest.approx(1e-4, rel=formats.A.step / 1e-2)
        torque = simulate(simulation, 0.1)[:, Column.TORQUE]
        analog = simulate(AnalogSimulation(scene), 0.1)[:, Column.TORQUE]
        error = np.sqrt(np.mean((torque - analog) ** 2)) / np.abs(analog).max()
        assert np.abs(analog).max() > 0.01
        assert error < 5e-4 * max(1, extra_ticks)


def test_power_is_the_difference_of_the_waves(make_scene):
    """e·i = ½u² − ½v² with e = e_a − R i, tick by tick, as the integer model has its words."""
    scene = make_scene(*INSIDE, "controller.walls=[[-1, 0]]")
    rows = simulate(SampledSimulation(scene, rtl=False), 0.2)
    e_a, i, u, v = rows[:, (Column.E_A, Column.I, Column.U, Column.V)].T
    power = (e_a - scene.motor.R_ohm * i) * i
    assert np.abs(power).max() > 1e-4
    assert np.count_nonzero(np.diff(rows[:, Column.ETA])) > 0
    # Each wave is off by a place or two at most, and so its square by that times the wave.
    place = 2 * formats.WAVE.step * (np.abs(u).max() + np.abs(v).max())
    np.testing.assert_allclose(power, 0.5 * u**2 - 0.5 * v**2, rtol=0, atol=place)
    assert place < 0.01 * np.abs(power).max()
