# SPDX-License-Identifier: Apache-2.0
"""The motor model against closed forms and against scipy's integrators."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from wavehaptics.motor.hand import PRESS_RAMP_S, hand_path
from wavehaptics.motor.plant import (
    OMEGA,
    STATE_SIZE,
    TIME,
    C,
    I,
    P,
    Plant,
    X,
    load_words,
    plant_step,
    square_integral,
)

HAND = (
    "hand.path='taps'",
    "hand.amplitude_rad=0.03",
    "hand.frequency_hz=20",
    "hand.stiffness=2.0",
    "hand.damping=2e-3",
)


def run(plant: Plant, volts, step_s: float) -> tuple[np.ndarray, float, float]:
    """Final state, ∫i dt and ∫i² dt after one step of ``step_s`` for each of ``volts``."""
    state, matrix, load = plant.start.copy(), plant.transition(step_s), load_words(plant)
    charge = square = 0.0
    for e in volts:
        part = plant_step(state, matrix, step_s, e, load)
        charge += part[0]
        square += part[1]
    return state, charge, square


def reference(plant: Plant, e, duration_s: float) -> np.ndarray:
    """(i, ω, x, ∫i dt, ∫i² dt) after ``duration_s`` at the voltage e(t), by scipy, in SI units."""

    def slope(t, y):
        i, omega, x = y[:3]
        _, _, amplitude, _ = plant.start[3:7]
        x_h = amplitude * math.cos(plant.hand_omega * t)
        v_h = -amplitude * plant.hand_omega * math.sin(plant.hand_omega * t)
        pull = plant.hand_stiffness * (x - x_h) + plant.hand_damping * (omega - v_h)
        di = (e(t) - plant.resistance * i - plant.k_t * omega) / plant.inductance
        domega = (plant.k_t * i - plant.viscous * omega - pull) / plant.inertia
        return [di, domega, omega, i, i * i]

    start = [plant.start[I], plant.start[OMEGA], plant.start[X], 0.0, 0.0]
    done = solve_ivp(slope, (0, duration_s), start, method="DOP853", rtol=1e-12, atol=1e-14)
    return done.y[:, -1]


def test_locked_rotor_current_is_the_closed_form(make_scene):
    """With a huge inertia i(t) = e/R (1 − exp(−t R/L)), and ∫i dt is its integral."""
    scene = make_scene("motor.J_kgm2=1.0")
    plant = Plant.of_scene(scene)
    time_constant = plant.inductance / plant.resistance
    for t in (1e-6, 1e-4, 2e-3):
        parts = plant.substeps(t)
        state, charge, square = run(plant, [1.0] * parts, t / parts)
        decay = math.exp(-t / time_constant)
        end = 1.0 / plant.resistance
        assert state[I] == pytest.approx(end * (1 - decay), rel=1e-6)
        assert charge == pytest.approx(end * (t - time_constant * (1 - decay)), rel=1e-6)
        expected = end**2 * (
            t - 2 * time_constant * (1 - decay) + time_constant / 2 * (1 - decay**2)
        )
        assert square == pytest.approx(expected, rel=1e-5)


def test_no_load_speed_is_the_closed_form(make_scene):
    """ω(∞) = e/k_T without friction, and with viscous b: e k_T/(k_T² + R b)."""
    for viscous in (0.0, 1e-5):
        plant = Plant.of_scene(make_scene(f"friction.viscous={viscous}"))
        state, _, _ = run(plant, [1.0] * 4000, 1e-3)
        expected = plant.k_t / (plant.k_t**2 + plant.resistance * viscous)
        assert state[OMEGA] == pytest.approx(expected, rel=1e-12)


def test_linear_plant_with_hand_against_scipy(make_scene):
    plant = Plant.of_scene(make_scene(*HAND, "friction.viscous=1e-6"))
    state, charge, square = run(plant, [0.7] * 20_000, 1e-6)
    expected = reference(plant, lambda t: 0.7, 0.02)
    got = np.array([state[I], state[OMEGA], state[X], charge, square])
    np.testing.assert_allclose(got, expected, rtol=1e-8)
    assert state[TIME] == pytest.approx(0.02)


def test_a_step_of_any_length_gives_the_same(make_scene):
    """Exactness of the tabulated exponential: many short steps or a few long ones."""
    plant = Plant.of_scene(make_scene(*HAND))
    short, _, _ = run(plant, [0.3] * 10_000, 1e-6)
    long, _, _ = run(plant, [0.3] * 10, 1e-3)
    np.testing.assert_allclose(short, long, rtol=1e-9)


def test_coulomb_friction_holds_and_stops_the_rotor(make_scene):
    scene = make_scene("friction.coulomb_nm=6.2e-4", "motor.J_kgm2=1e-6")
    plant = Plant.of_scene(scene)
    # Below the breakaway current nothing moves: k_T e/R = 3.2e-4 N·m < 6.2e-4 N·m.
    state, _, _ = run(plant, [0.03] * 5000, 1e-5)
    assert state[OMEGA] == 0.0
    assert state[X] == 0.0
    # A free rotor at speed ω0 with open-circuit-like high R comes to rest after J ω0/τ_c.
    scene = make_scene(
        "friction.coulomb_nm=6.2e-4", "motor.R_ohm=100", "motor.k_t=1e-4",
        "hand.path='impact'", "hand.amplitude_rad=1", "hand.speed_rad_s=10",
    )  # fmt: skip
    plant = Plant.of_scene(scene)
    stop_s = plant.inertia * 10 / plant.coulomb
    state, _, _ = run(plant, [0.0] * round(1.5 * stop_s / 1e-5), 1e-5)
    assert state[OMEGA] == 0.0
    expected = -1 + 0.5 * 10 * stop_s
    assert state[X] == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize(
    ("path", "x0", "v0"),
    [("taps", -0.1, 0.0), ("free", -0.2, 0.1 * 2 * math.pi * 3), ("sine", 0.0, 0.6 * math.pi)],
)
def test_hand_paths_start_as_the_format_says(make_scene, path, x0, v0):
    scene = make_scene(
        f"hand.path='{path}'", "hand.amplitude_rad=0.1", "hand.frequency_hz=3",
        "hand.stiffness=1", "hand.damping=0",
    )  # fmt: skip
    hand = hand_path(scene)
    assert hand.x0 == pytest.approx(x0)
    assert hand.v0 == pytest.approx(v0)
    plant = Plant.of_scene(scene)
    assert plant.start.shape == (STATE_SIZE,)
    assert plant.start[X] == pytest.approx(x0)
    assert plant.start[OMEGA] == pytest.approx(v0)


def test_press_ramps_and_stays(make_scene):
    scene = make_scene(
        "hand.path='press'", "hand.amplitude_rad=0.1", "hand.stiffness=1", "hand.damping=1e-3"
    )
    plant = Plant.of_scene(scene)
    state, _, _ = run(plant, [0.0] * 25_000, 1e-6)
    assert state[P] + state[C] == pytest.approx(-0.01 + 0.11 * 0.025 / PRESS_RAMP_S)
    state, _, _ = run(plant, [0.0] * 80_000, 1e-6)
    assert state[P] + state[C] == pytest.approx(0.1, rel=1e-9)


def test_impact_releases_the_rotor_without_a_hand(make_scene):
    scene = make_scene("hand.path='impact'", "hand.amplitude_rad=0.2", "hand.speed_rad_s=7")
    plant = Plant.of_scene(scene)
    assert plant.hand_stiffness == 0.0
    assert (plant.start[X], plant.start[OMEGA]) == (-0.2, 7.0)


def test_energy_balance(make_scene):
    """What the source gives is in the copper, the inductor, the rotor, the hand and friction."""
    plant = Plant.of_scene(make_scene("friction.viscous=1e-6"))
    steps, step_s, e = 20_000, 1e-6, 2.0
    state, matrix, load = plant.start.copy(), plant.transition(step_s), load_words(plant)
    charge = square = drag = 0.0
    for _ in range(steps):
        omega = state[OMEGA]
        part = plant_step(state, matrix, step_s, e, load)
        charge += part[0]
        square += part[1]
        drag += plant.viscous * step_s * (omega**2 + omega * state[OMEGA] + state[OMEGA] ** 2) / 3
    stored = (plant.inductance * state[I] ** 2 + plant.inertia * state[OMEGA] ** 2) / 2
    assert e * charge == pytest.approx(stored + plant.resistance * square + drag, rel=1e-7)


def test_square_integral_is_exact_for_parabolas():
    for a, b, c in ((1.0, 0.0, 0.0), (0.3, -2.0, 5.0), (-1.0, 1.0, 1.0)):
        step = 0.25
        first, last = a, a + b * step + c * step**2
        area = a * step + b * step**2 / 2 + c * step**3 / 3
        t = np.polynomial.Polynomial([a, b, c])
        exact = (t**2).integ()(step)
        assert square_integral(first, last, area, step) == pytest.approx(exact, rel=1e-12)
