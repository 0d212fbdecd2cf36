# SPDX-License-Identifier: Apache-2.0
"""The real motor's step against closed forms and scipy, on equations written out anew here."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from wavehaptics.ladder.hosted import HostedSimulation, Line
from wavehaptics.ladder.run import CONTROLLERS
from wavehaptics.motor.brushes import (
    FLICKER_SEED,
    NOISE_POINTS,
    NOISE_SEED,
    POINTS_CORRELATED,
    noise_course,
)
from wavehaptics.motor.plant import OMEGA, I, Plant, X, load_words
from wavehaptics.motor.step import MEMORY, SERIES_OHM, motor_parts, motor_step, warm_parts
from wavehaptics.trace.columns import Column, Word

TICK_S = 1e-6
R, L, K_T, J = 2.18, 0.24e-3, 23.4e-3, 10.3e-7
"""The paper's motor, which `make_scene` has."""

BRUSHES = ("brushes.drop_v=0.5", "brushes.knee_a=5e-3")
HAND = (
    "hand.path='taps'",
    "hand.amplitude_rad=0.03",
    "hand.frequency_hz=20",
    "hand.stiffness=2.0",
    "hand.damping=2e-3",
)
SWUNG = tuple(1.5 * math.sin(1.7 * n) for n in range(20))
"""Voltages of a millisecond each, V; the current goes through zero again and again."""


def run(plant: Plant, volts, tick_s: float = TICK_S, series_ohm: float = 0.0) -> np.ndarray:
    """(i, ω, x, ∫i dt, ∫i² dt as it warms) at the end of each tick at ``volts``, in SI units."""
    substeps = plant.substeps(tick_s)
    step_s = tick_s / substeps
    state, matrix = plant.start.copy(), plant.transition(step_s)
    load, parts = load_words(plant), motor_parts(plant)
    if series_ohm:
        parts[MEMORY][SERIES_OHM] = series_ohm
    rows = np.zeros((len(volts), 5))
    charge = square = 0.0
    for n, e in enumerate(volts):
        for _ in range(substeps):
            part = motor_step(state, matrix, step_s, e, load, parts)
            charge += part[0]
            square += part[1]
        rows[n] = state[I], state[OMEGA], state[X], charge, square
    return rows


def swung(slope, start, part_s: float = 1e-3) -> np.ndarray:
    """States at the end of each of SWUNG, by scipy, of ``slope(t, y, e)``."""
    ends, t = [np.asarray(start, dtype=float)], 0.0
    for e in SWUNG:
        done = solve_ivp(
            slope, (t, t + part_s), ends[-1], args=(e,), method="LSODA", rtol=1e-10, atol=1e-13
        )
        assert done.success
        ends.append(done.y[:, -1])
        t += part_s
    return np.array(ends[1:])


def off(got: np.ndarray, expected: np.ndarray) -> float:
    """Largest error, in parts of the largest value."""
    return float(np.max(np.abs(got - expected)) / np.max(np.abs(expected)))


def compare(plant: Plant, slope, extra=(), part_s: float = 1e-3) -> tuple[float, float, float]:
    """Errors of i, ω and x at the ends of SWUNG, in parts of their largest."""
    per_part = round(part_s / TICK_S)
    volts = np.repeat(SWUNG, per_part)
    got = run(plant, volts)[per_part - 1 :: per_part]
    start = [plant.start[I], plant.start[OMEGA], plant.start[X], *extra]
    expected = swung(slope, start, part_s)
    return tuple(off(got[:, n], expected[:, n]) for n in range(3))


def hand_pull(plant: Plant, t: float, x: float, omega: float) -> float:
    x_h = -0.03 * math.cos(40 * math.pi * t)
    v_h = 0.03 * 40 * math.pi * math.sin(40 * math.pi * t)
    return 2.0 * (x - x_h) + 2e-3 * (omega - v_h)


def test_a_motor_without_these_tables_is_linear(make_scene):
    plant = Plant.of_scene(make_scene())
    assert not plant.real
    assert all(part.shape == (0,) for part in motor_parts(plant))


def test_locked_rotor_with_brushes_is_the_closed_form(make_scene):
    """At rest ``e = R i + V_b tanh(i/knee)``, on either side and within the knee."""
    plant = Plant.of_scene(make_scene(*BRUSHES, "motor.J_kgm2=1.0"))
    for e in (1.0, -1.0, 0.52, 0.3, -0.05):
        i, omega = run(plant, [e] * 3000)[-1, :2]
        assert R * i + 0.5 * math.tanh(i / 5e-3) + K_T * omega == pytest.approx(e, rel=1e-7)


@pytest.mark.parametrize("knee", [1e-3, 5e-3, 50e-3])
def test_brushes_against_scipy(make_scene, knee):
    plant = Plant.of_scene(make_scene("brushes.drop_v=0.5", f"brushes.knee_a={knee}", *HAND))

    def slope(t, y, e):
        i, omega, x = y
        di = (e - R * i - K_T * omega - 0.5 * math.tanh(i / knee)) / L
        return [di, (K_T * i - hand_pull(plant, t, x, omega)) / J, omega]

    errors = compare(plant, slope)
    print(f"brushes, knee {knee:g}: {errors}")
    assert max(errors) < 1e-5


def test_brushes_err_with_the_square_of_the_step(make_scene):
    """Halving the step takes three quarters of the error of i away, through the knee."""
    plant = Plant.of_scene(make_scene("brushes.drop_v=0.5", "brushes.knee_a=20e-3"))
    assert plant.substeps(2e-6) == 1

    def slope(t, y, e):
        i, omega, _ = y
        di = (e - R * i - K_T * omega - 0.5 * math.tanh(i / 20e-3)) / L
        return [di, K_T * i / J, omega]

    expected = solve_ivp(
        slope, (0, 16e-6), [0, 0, 0], args=(1.0,), method="LSODA", rtol=1e-11, atol=1e-14
    ).y[0, -1]
    errors = [
        abs(run(plant, [1.0] * round(16e-6 / h), h)[-1, 0] - expected) for h in (2e-6, 1e-6, 0.5e-6)
    ]
    print(f"error of i at 2, 1, 0.5 µs: {errors}")
    assert 3.3 < errors[0] / errors[1] < 4.7
    assert 3.5 < errors[1] / errors[2] < 4.5


def test_what_the_brushes_take_is_heat(make_scene):
    """``e ∫i dt − R ∫i² dt`` is what has come out behind the brushes: into field and rotor."""
    plant = Plant.of_scene(make_scene(*BRUSHES, "brushes.segments=11", "brushes.ripple=0.2"))
    volts = np.repeat(SWUNG[:6], 1000)
    rows = run(plant, volts, series_ohm=0.3)
    i, omega, _, charge, square = rows.T
    work = np.cumsum(volts * np.diff(charge, prepend=0.0))
    stored = (L * i**2 + J * omega**2) / 2
    assert np.abs(work - R * square - stored).max() < 1e-4 * work.max()


def test_ripple_and_series_resistance_against_scipy(make_scene):
    plant = Plant.of_scene(
        make_scene("brushes.segments=11", "brushes.ripple=-0.3", "drive.bus_v=12",
                   "drive.sag_ohm=0.5")
    )  # fmt: skip

    def slope(t, y, e):
        i, omega, x = y
        r = R * (1 - 0.3 * math.cos(11 * x))
        return [(e - r * i - K_T * omega) / L, K_T * i / J, omega]

    errors = compare(plant, slope)
    print(f"ripple: {errors}")
    assert max(errors) < 1e-6


def test_step_rises_at_its_edge_and_falls_a_bar_later(make_scene):
    """A rotor that can't be moved, on both sides of the edges: i = e/R (1 + step) or e/R."""
    bar = 2 * math.pi / 11
    for place, part in ((-1e-6, 0.0), (1e-6, -0.04), (bar - 1e-6, -0.04), (bar + 1e-6, 0.0),
                        (-bar - 1e-6, -0.04), (23 * bar - 1e-6, -0.04)):  # fmt: skip
        plant = Plant.of_scene(
            make_scene("brushes.segments=11", "brushes.step=-0.04", "brushes.step_at_rad=0.2",
                       "motor.J_kgm2=1.0")
        )  # fmt: skip
        plant.start[X] = 0.2 + place
        i = run(plant, [1e-3] * 2000)[-1, 0]
        assert i == pytest.approx(1e-3 / (R * (1 + part)), rel=1e-6)


@pytest.mark.parametrize("seed", [NOISE_SEED, FLICKER_SEED])
def test_a_noise_has_its_rms_and_its_correlation(seed):
    course = noise_course(seed)
    assert len(course) == NOISE_POINTS
    fine = np.repeat(course, 8) + np.tile(np.arange(8) / 8, NOISE_POINTS) * np.repeat(
        np.roll(course, -1) - course, 8
    )
    # 4096 correlation times give the variance to 1/sqrt(4096/2) or so.
    assert np.sqrt(np.mean(fine**2)) == pytest.approx(1.0, abs=0.04)
    for times in (0.25, 0.5, 1.0, 2.0):
        shifted = np.roll(course, round(times * POINTS_CORRELATED))
        found = np.mean(course * shifted) / np.mean(course**2)
        assert found == pytest.approx(math.exp(-times), abs=0.06)
    # The round closes: the last kick is no larger than the others.
    kicks = np.abs(course - np.roll(course, 1))
    assert kicks[0] < 5 * kicks.std()


def test_flicker_is_of_r(make_scene):
    plant = Plant.of_scene(
        make_scene("brushes.flicker_noise=0.03", "brushes.flicker_s=1e-3", "motor.J_kgm2=1.0")
    )
    i = run(plant, [1.0] * 200_000, 1e-5)[2000:, 0]
    r = 1.0 / i
    assert r.mean() == pytest.approx(R, rel=5e-3)
    # The winding's 0.11 ms smooth it a little.
    assert r.std() == pytest.approx(0.03 * R, rel=0.12)


NOISY = ("brushes.contact_noise=0.03", "brushes.noise_rad=5e-3", "motor.J_kgm2=1.0",
         "motor.k_t=1e-4", "hand.path='impact'", "hand.amplitude_rad=1")  # fmt: skip
"""A rotor that nothing slows down."""


def test_contact_noise_is_of_the_angle_and_of_r(make_scene):
    """At 10 rad/s the RMS of R, and the same R at the same angle at any speed and either way."""
    courses = {}
    for speed in (10.0, 2.0, -10.0):
        plant = Plant.of_scene(make_scene(*NOISY, f"hand.speed_rad_s={speed}"))
        plant.start[X] = -1.0 if speed > 0.0 else 1.0
        rows = run(plant, [1.0] * round(2.0 / abs(speed) / 1e-5), 1e-5)[300:]
        r = (1.0 - L * np.gradient(rows[:, 0], 1e-5)) / rows[:, 0]
        courses[speed] = (rows[:, 2], r)
        assert r.mean() == pytest.approx(R, rel=5e-3)
        assert r.std() == pytest.approx(0.03 * R, rel=0.15)
    places = np.linspace(-0.8, 0.8, 2000)
    fast = np.interp(places, *courses[10.0])
    slow = np.interp(places, *courses[2.0])
    back = np.interp(places, *(column[::-1] for column in courses[-10.0]))
    assert np.std(slow - fast) < 0.1 * np.std(fast)
    assert np.std(back - fast) < 0.1 * np.std(fast)


def test_contact_noise_is_still_where_the_rotor_is(make_scene):
    """At rest R is some constant: other than flicker the noise of sliding doesn't move a wall."""
    found = []
    for place in (0.3, 0.4, -0.5):
        plant = Plant.of_scene(make_scene(*NOISY, "hand.speed_rad_s=1e-9"))
        plant.start[X] = place
        i = run(plant, [0.1] * 20_000, 1e-5)[2000:, 0]
        assert np.ptp(i) < 1e-3 * 0.03 * i.mean()  # it drifts by 0.1 µrad
        found.append(0.1 / i.mean())
    assert max(abs(r / R - 1.0) for r in found) < 0.12
    assert np.ptp(found) > 0.005 * R


def test_eddy_currents_against_scipy(make_scene):
    plant = Plant.of_scene(make_scene("winding.eddy_ohm=30", "winding.eddy_part=0.4"))

    def slope(t, y, e):
        i, omega, _, i_e = y
        v = 30 * (i - i_e)
        di = (e - R * i - K_T * omega - v) / (0.6 * L)
        return [di, K_T * i / J, omega, v / (0.4 * L)]

    errors = compare(plant, slope, (0.0,))
    print(f"eddy: {errors}")
    assert max(errors) < 1e-6


def test_eddy_currents_leave_the_slow_inductance_whole(make_scene):
    """A slow ramp of current finds L: the lag of i behind e/R is L/R."""
    plant = Plant.of_scene(
        make_scene("winding.eddy_ohm=30", "winding.eddy_part=0.4", "motor.J_kgm2=1.0")
    )
    ramp = 100.0  # V/s
    ticks = 4000
    volts = ramp * TICK_S * (np.arange(ticks) + 0.5)
    i = run(plant, volts)[-1, 0]
    assert i == pytest.approx(ramp / R * (ticks * TICK_S - L / R), rel=1e-4)


@pytest.mark.parametrize("eddy", [(), ("winding.eddy_ohm=30", "winding.eddy_part=0.4")])
def test_saturation_against_scipy(make_scene, eddy):
    plant = Plant.of_scene(make_scene("winding.saturation_a=0.2", *eddy))
    part = 0.4 if eddy else 0.0

    def slope(t, y, e):
        i, omega, _, i_e = y
        v = 30 * (i - i_e) if eddy else 0.0
        di = (e - R * i - K_T * omega - v) * (1 + (i / 0.2) ** 2) / ((1 - part) * L)
        return [di, K_T * i / J, omega, v * (1 + (i_e / 0.2) ** 2) / (0.4 * L)]

    errors = compare(plant, slope, (0.0,))
    print(f"saturation {eddy}: {errors}")
    assert max(errors) < (1e-4 if eddy else 1e-6)


def test_saturated_flux_is_the_closed_form(make_scene):
    """Without R to speak of, ∫e dt is the flux L i_s atan(i/i_s)."""
    plant = Plant.of_scene(
        make_scene("winding.saturation_a=0.5", "motor.R_ohm=0.01", "motor.J_kgm2=1.0")
    )
    rows = run(plant, [1.0] * 300)
    flux = 1.0 * 300e-6 - 0.01 * rows[-1, 3] - K_T * rows[-1, 2]
    assert L * 0.5 * math.atan(rows[-1, 0] / 0.5) == pytest.approx(flux, rel=1e-7)


def test_cogging_against_scipy(make_scene):
    plant = Plant.of_scene(make_scene("cogging.torque_nm=2e-3", "cogging.per_rev=22"))

    def slope(t, y, e):
        i, omega, x = y
        di = (e - R * i - K_T * omega) / L
        return [di, (K_T * i - 2e-3 * math.sin(22 * x)) / J, omega]

    errors = compare(plant, slope)
    print(f"cogging: {errors}")
    assert max(errors) < 1e-6


def test_cogging_and_friction_hold_together(make_scene):
    """Friction has to hold what cogging takes: the rotor breaks away at k_T i > τ_c + cogging."""
    still = ("cogging.torque_nm=1e-3", "cogging.per_rev=10", "friction.coulomb_nm=5e-4")
    at = ("hand.path='impact'", f"hand.amplitude_rad={math.pi / 20}", "hand.speed_rad_s=1e-12")
    plant = Plant.of_scene(make_scene(*still, *at))
    # At −π/20 cogging pushes up with 1 mN·m, more than friction: it moves without a current.
    assert run(plant, [0.0] * 20_000)[-1, 1] != 0.0
    plant.start[OMEGA] = 0.0
    held = -0.8e-3 / K_T * R
    assert run(plant, [held] * 200)[0, 2] == pytest.approx(-math.pi / 20)


CABLE = ("transmission.cable_stiffness=5", "transmission.cable_damping=3e-4")


@pytest.mark.parametrize("backlash", [0.0, 4e-3])
def test_cable_against_scipy(make_scene, backlash):
    plant = Plant.of_scene(
        make_scene(*HAND, *CABLE, f"transmission.backlash_rad={backlash}", *BRUSHES)
    )

    def slope(t, y, e):
        i, omega, x, end = y
        x_h = -0.03 * math.cos(40 * math.pi * t)
        v_h = 0.03 * 40 * math.pi * math.sin(40 * math.pi * t)
        alone = v_h - 2.0 / 2e-3 * (end - x_h)
        gap = 0.5 * backlash
        stretched = x - end
        torque, v_end = 0.0, alone
        if backlash == 0.0 or abs(stretched) > gap:
            side = math.copysign(gap, stretched) if backlash else 0.0
            spring = 5 * (stretched - side)
            v_end = (spring + 3e-4 * omega - 2.0 * (end - x_h) + 2e-3 * v_h) / (3e-4 + 2e-3)
            torque = spring + 3e-4 * (omega - v_end)
            if backlash and torque * stretched < 0.0:
                torque, v_end = 0.0, alone
        di = (e - R * i - K_T * omega - 0.5 * math.tanh(i / 5e-3)) / L
        return [di, (K_T * i - torque) / J, omega, v_end]

    errors = compare(plant, slope, (plant.start[X],))
    print(f"cable, backlash {backlash:g}: {errors}")
    assert max(errors) < (2e-3 if backlash else 2e-4)


@pytest.mark.parametrize("backlash", [0.0, 4e-3])
@pytest.mark.parametrize("mass", [1e-7, 4e-6])
def test_a_hand_with_a_mass_at_its_cable_against_scipy(make_scene, backlash, mass):
    """Rotor, cable, mass, the hand's spring and damper, its path."""
    plant = Plant.of_scene(
        make_scene(*HAND, *CABLE, f"transmission.backlash_rad={backlash}",
                   f"hand.inertia_kgm2={mass}")
    )  # fmt: skip
    assert plant.inertia == J

    def slope(t, y, e):
        i, omega, x, end, speed = y
        gap = 0.5 * backlash
        stretched = x - end
        torque = 0.0
        if backlash == 0.0 or abs(stretched) > gap:
            side = math.copysign(gap, stretched) if backlash else 0.0
            torque = 5 * (stretched - side) + 3e-4 * (omega - speed)
            if backlash and torque * stretched < 0.0:
                torque = 0.0
        di = (e - R * i - K_T * omega) / L
        pull = hand_pull(plant, t, end, speed)
        return [di, (K_T * i - torque) / J, omega, speed, (torque - pull) / mass]

    errors = compare(plant, slope, (plant.start[X], 0.0))
    print(f"mass {mass:g}, backlash {backlash:g}: {errors}")
    assert max(errors) < (2e-3 if backlash else 2e-4)


def test_a_mass_on_a_stiff_cable_is_one_on_the_rotor(make_scene):
    mass = "hand.inertia_kgm2=2e-6"
    direct = Plant.of_scene(make_scene(*HAND, mass))
    assert direct.inertia == J + 2e-6
    assert not direct.real
    stiff = Plant.of_scene(
        make_scene(*HAND, mass, "transmission.cable_stiffness=2e3",
                   "transmission.cable_damping=5e-3")
    )  # fmt: skip
    volts = np.repeat(SWUNG, 500)
    assert off(run(stiff, volts)[:, 2], run(direct, volts)[:, 2]) < 2e-3
    # And a vanishing one is none.
    none = Plant.of_scene(make_scene(*HAND, *CABLE))
    tiny = Plant.of_scene(make_scene(*HAND, *CABLE, "hand.inertia_kgm2=1e-11"))
    assert off(run(tiny, volts)[:, 2], run(none, volts)[:, 2]) < 1e-5


@pytest.mark.parametrize("controller", ["analog", "golden", "encoder", "hosted"])
@pytest.mark.parametrize("kind", ["brushed", "brushless"])
def test_a_load_and_a_hand_add_to_the_rotors_inertia(make_scene, controller, kind):
    """Rotor, load and mass are one inertia on every controller, which knows of none of it."""
    if (controller, kind) == ("hosted", "brushless"):
        pytest.skip("a host has no brushless motor")
    motor = ("motor.preset=gbm2804-100t", "servo.foc_hz=25e3") if kind == "brushless" else ()
    common = (*HAND, *motor, "controller.tick_hz=50e3", "controller.j_hat=1e-6",
              "encoder.counts_per_rev=4000", "controller.walls=[[0.0, 1.0]]",
              "controller.anchor_auto=true", "scene.duration_s=0.02")  # fmt: skip
    split = make_scene(*common, "motor.J_kgm2=1e-6", "load.inertia_kgm2=2e-6",
                       "hand.inertia_kgm2=3e-6")  # fmt: skip
    whole = make_scene(*common, "motor.J_kgm2=6e-6")
    first, second = (rows_of(scene, controller) for scene in (split, whole))
    assert np.ptp(first[:, Column.X]) > 0.01
    np.testing.assert_allclose(first, second, rtol=1e-9, atol=1e-12)


def rows_of(scene, controller: str) -> np.ndarray:
    """Rows of a scene on a controller."""
    ticks = round(scene.scene.duration_s * scene.controller.tick_hz)
    if controller == "hosted":
        return HostedSimulation(scene, None, 4, Line()).advance(ticks >> 4)
    rows = np.zeros((ticks, len(Column)))
    CONTROLLERS[controller](scene).advance(rows, np.zeros((ticks, len(Word)), dtype=np.int64))
    return rows


def test_stiff_cable_is_the_hand_itself(make_scene):
    """Without dampers the springs stand in series, and a stiff one vanishes."""
    hand = HAND[:-1]
    direct = run(Plant.of_scene(make_scene(*hand)), np.repeat(SWUNG, 500))
    stiff = Plant.of_scene(make_scene(*hand, "transmission.cable_stiffness=2e4"))
    rows = run(stiff, np.repeat(SWUNG, 500))
    assert off(rows[:, 2], direct[:, 2]) < 1e-3
    halved = Plant.of_scene(make_scene(*hand, "transmission.cable_stiffness=2.0"))
    half = run(Plant.of_scene(make_scene(*hand, "hand.stiffness=1.0")), np.repeat(SWUNG, 500))
    assert off(run(halved, np.repeat(SWUNG, 500))[:, 2], half[:, 2]) < 1e-5


def test_steps_are_short_enough_for_what_is_there(make_scene):
    """Brushes alone are one step a µs with the usual knee, and more with a sharper one."""
    assert Plant.of_scene(make_scene(*BRUSHES)).substeps(1e-6) == 1
    assert (
        Plant.of_scene(make_scene("brushes.drop_v=0.5", "brushes.knee_a=5e-4")).substeps(1e-6) > 5
    )
    noisy = make_scene("brushes.flicker_noise=0.03", "brushes.flicker_s=1e-5")
    assert Plant.of_scene(noisy).longest_step_s <= 1.25e-6


def test_a_warm_winding_takes_its_brushes_along(make_scene):
    """Parts of R are of R as it is, and a µs more of it is what they say."""
    parts_of = ("brushes.segments=11", "brushes.ripple=0.1", "motor.J_kgm2=1.0")
    plant = Plant.of_scene(make_scene(*parts_of))
    parts = motor_parts(plant)
    warm = replace(plant, resistance=2 * R)
    warm_parts(parts, warm)
    for got, expected in zip(parts, motor_parts(warm), strict=True):
        np.testing.assert_array_equal(got, expected)
    i = run(warm, [1.0] * 3000)[-1, 0]
    assert i == pytest.approx(1.0 / (2 * R * 1.1), rel=1e-4)


def test_a_step_far_too_long_is_still_stable(make_scene):
    """20 kΩ of slope at steps of 20 µs, where plain Newton steps would go to and fro."""
    plant = Plant.of_scene(
        make_scene("brushes.drop_v=2", "brushes.knee_a=1e-4", "motor.J_kgm2=1.0")
    )
    state, matrix, step_s = plant.start.copy(), plant.transition(20e-6), 20e-6
    load, parts = load_words(plant), motor_parts(plant)
    for n, e in enumerate([5.0] * 100 + [-5.0] * 100 + [1.0] * 100):
        motor_step(state, matrix, step_s, e, load, parts)
        if n % 100 == 99:
            expected = 0.0 if e == 1.0 else math.copysign(3.0 / R, e)
            assert state[I] == pytest.approx(expected, abs=1e-3)
