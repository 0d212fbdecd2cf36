# SPDX-License-Identifier: Apache-2.0
"""A brushless motor on two ports: its plant, the transforms, the wall and what is refused."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from wavehaptics.controller import clarke
from wavehaptics.controller.pins_timing import CORE_CLOCKS
from wavehaptics.fpga.boards import load_board
from wavehaptics.ladder.abilities import ABILITIES, BRUSHLESS, BRUSHLESS_RUNGS, asked, refuse
from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.laws import closed_forms
from wavehaptics.motor.brushless import (
    ENERGY,
    F_A,
    F_B,
    I_A,
    I_B,
    IMPULSE,
    Q_A,
    Q_B,
    BrushlessPlant,
    brushless_step,
)
from wavehaptics.motor.plant import OMEGA, X, square_integral
from wavehaptics.parts.motors import BRUSHLESS_PRESETS, PRESETS
from wavehaptics.scene import SCENES_DIR, Scene, SceneError, load_scene
from wavehaptics.scene.tables.drive import THREE_PHASE_REACH
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats

BASE = """
[scene]
name = "brushless"
duration_s = 0.05
[motor]
preset = "gbm2804-100t"
[controller]
tick_hz = 1e6
lambda = 1e4
"""
GIMBAL = BRUSHLESS_PRESETS["gbm2804-100t"]
PSI = GIMBAL.pole_pairs * GIMBAL.psi_vs
TAP = (
    "hand.path='taps'", "hand.amplitude_rad=0.008", "hand.frequency_hz=10", "hand.stiffness=2",
    "hand.damping=2e-3", "controller.walls=[[0.0, 1.0]]",
)  # fmt: skip
SWUNG = (
    "hand.path='sine'", "hand.amplitude_rad=0.5", "hand.frequency_hz=30", "hand.stiffness=0.3",
    "hand.damping=1e-3",
)  # fmt: skip
EVERYWHERE = "controller.walls=[[-1000.0, 1000.0]]"
ANGLES = [n * math.pi / 4 for n in range(8)]
MODELS = ("analog", "golden")
"""Of `core` every bit is golden's: test_core_is_golden."""


@pytest.fixture
def make_scene(tmp_path: Path) -> Callable[..., Scene]:
    """A function that makes a scene of settings on a gimbal's motor."""
    path = tmp_path / "scene.toml"
    path.write_text(BASE)
    return lambda *sets: load_scene(path, sets)


def magnets_at(theta: float) -> str:
    """The setting with which x = 0 is the electrical angle ``theta``."""
    return f"motor.magnet_rad={-theta / GIMBAL.pole_pairs:.12g}"


def turning(speed: float) -> tuple[str, ...]:
    """A rotor so heavy that nothing changes its speed."""
    return ("hand.path='impact'", "hand.amplitude_rad=0.1", f"hand.speed_rad_s={speed}",
            "motor.J_kgm2=1.0")  # fmt: skip


def rows_of(scene: Scene, controller: str) -> np.ndarray:
    simulation = CONTROLLERS[controller](scene)
    rows = np.zeros((round(scene.scene.duration_s / simulation.tick_s), len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    return rows


def advance(plant: BrushlessPlant, volts: tuple[float, float], duration_s: float, dt: float):
    """The plant's state after a time at a constant voltage; and ∫i² dt of both axes."""
    z, table, step, load = plant.start, plant.axis_table(dt), plant.step_words(dt), plant.words()
    z[F_A], z[F_B] = volts
    square = 0.0
    for _ in range(round(duration_s / dt)):
        before = z.copy()
        brushless_step(z, table, table, step, load)
        for i, q in ((I_A, Q_A), (I_B, Q_B)):
            square += square_integral(before[i], z[i], z[q] - before[q], dt)
    return z, square


def in_three_phases(plant: BrushlessPlant, volts: tuple[float, float], duration_s: float):
    """The same motor written in its phases, by scipy: (i_α, i_β, ω, x)."""
    load, (h5, h7) = plant.plant, plant.harmonics
    shifts = 2.0 * math.pi / 3.0 * np.arange(3)
    legs = np.array([volts[0], *(-volts[0] / 2 + side * math.sqrt(0.75) * volts[1]
                                 for side in (1, -1))])  # fmt: skip
    omega_h, (p0, r0, c0, s0) = load.hand_omega, load.start[3:7]

    def slope(t, y):
        i, omega, x = y[:3], y[3], y[4]
        theta = plant.pole_pairs * (x - plant.magnet_rad) - shifts
        shape = -np.sin(theta) - h5 * np.sin(5 * theta) - h7 * np.sin(7 * theta)
        emf = plant.k_e * omega * shape
        star = np.mean(legs - load.resistance * i - emf)
        current = (legs - star - load.resistance * i - emf) / load.inductance
        hand = p0 + r0 * t + c0 * math.cos(omega_h * t) - s0 * math.sin(omega_h * t)
        speed = r0 - omega_h * (c0 * math.sin(omega_h * t) + s0 * math.cos(omega_h * t))
        torque = plant.k_e * np.dot(shape, i) - load.viscous * omega
        torque -= load.hand_stiffness * (x - hand) + load.hand_damping * (omega - speed)
        if load.cogging is not None:
            torque -= load.cogging.torque_nm * math.sin(load.cogging.per_rev * x)
        return [*current, torque / load.inertia, omega]

    start = [0.0, 0.0, 0.0, load.start[OMEGA], load.start[X]]
    done = solve_ivp(slope, (0, duration_s), start, method="DOP853", rtol=1e-11, atol=1e-13)
    a, b, c, omega, x = done.y[:, -1]
    return np.array([(2 * a - b - c) / 3, (b - c) / math.sqrt(3), omega, x])


def in_dq(plant: BrushlessPlant, volts: tuple[float, float], duration_s: float):
    """A salient motor as textbooks have it, in the rotor's frame, by scipy."""
    load, p = plant.plant, plant.pole_pairs
    l_q, psi = load.inductance, plant.k_e / plant.pole_pairs
    l_d = plant.l_d_part * l_q

    def slope(_, y):
        i_d, i_q, omega, x = y
        theta = p * (x - plant.magnet_rad)
        e_d = math.cos(theta) * volts[0] + math.sin(theta) * volts[1]
        e_q = math.cos(theta) * volts[1] - math.sin(theta) * volts[0]
        torque = 1.5 * p * (psi * i_q + (l_d - l_q) * i_d * i_q) - load.viscous * omega
        return [
            (e_d - load.resistance * i_d + p * omega * l_q * i_q) / l_d,
            (e_q - load.resistance * i_q - p * omega * (l_d * i_d + psi)) / l_q,
            torque / load.inertia,
            omega,
        ]

    start = [0.0, 0.0, load.start[OMEGA], load.start[X]]
    done = solve_ivp(slope, (0, duration_s), start, method="DOP853", rtol=1e-11, atol=1e-13)
    i_d, i_q, omega, x = done.y[:, -1]
    theta = p * (x - plant.magnet_rad)
    turn = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
    return np.array([*(turn @ [i_d, i_q]), omega, x])


def got(z: np.ndarray) -> np.ndarray:
    return np.array([z[I_A], z[I_B], z[OMEGA], z[X]])


def test_plant_is_three_phases_in_star(make_scene):
    """Harmonics, hand, cogging and friction, over two electrical turns, against scipy."""
    scene = make_scene(
        *SWUNG, "motor.harmonic_5=0.08", "motor.harmonic_7=-0.05", "motor.magnet_rad=0.2",
        "friction.viscous=1e-5", "cogging.torque_nm=1e-3", "cogging.per_rev=84",
    )  # fmt: skip
    plant = BrushlessPlant.of_scene(scene)
    expected = in_three_phases(plant, (0.9, -0.4), 0.02)
    errors = []
    for dt in (4e-6, 2e-6):
        z, _ = advance(plant, (0.9, -0.4), 0.02, dt)
        errors.append(np.abs(got(z) - expected))
    assert np.all(errors[1] < 1e-4 * np.abs(expected))
    ratio = np.linalg.norm(errors[0] / expected) / np.linalg.norm(errors[1] / expected)
    assert ratio == pytest.approx(4.0, rel=0.1)  # of second order


@pytest.mark.parametrize("part", [0.6, 1.7])
def test_salient_plant_is_the_textbooks(make_scene, part):
    scene = make_scene(
        f"motor.l_d_part={part}", "motor.magnet_rad=0.1", "friction.viscous=1e-4",
        "hand.path='impact'", "hand.amplitude_rad=0.1", "hand.speed_rad_s=40",
    )  # fmt: skip
    plant = BrushlessPlant.of_scene(scene)
    expected = in_dq(plant, (6.0, -2.0), 0.01)
    errors = []
    for dt in (4e-6, 2e-6):
        z, _ = advance(plant, (6.0, -2.0), 0.01, dt)
        errors.append(np.abs(got(z) - expected))
    assert np.all(errors[1] < 3e-4 * np.abs(expected).max(initial=0.1))
    ratio = np.linalg.norm(errors[0] / expected) / np.linalg.norm(errors[1] / expected)
    assert ratio == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize("part", [1.0, 0.6])
def test_energy_balance(make_scene, part):
    """What the voltages give is in the copper, in the inductances and in the rotor."""
    scene = make_scene(f"motor.l_d_part={part}", "motor.harmonic_5=0.05", "motor.magnet_rad=0.3")
    plant, volts = BrushlessPlant.of_scene(scene), (2.0, 1.0)
    z, square = advance(plant, volts, 0.01, 2e-6)
    load = plant.plant
    theta = plant.pole_pairs * (z[X] - plant.magnet_rad)
    i_d = math.cos(theta) * z[I_A] + math.sin(theta) * z[I_B]
    stored = 0.75 * load.inductance * (z[I_A] ** 2 + z[I_B] ** 2 + (part - 1.0) * i_d**2)
    stored += 0.5 * load.inertia * z[OMEGA] ** 2
    given_j = 1.5 * (volts[0] * z[Q_A] + volts[1] * z[Q_B])
    copper = 1.5 * load.resistance * square
    assert copper > 0.01 * given_j
    assert given_j == pytest.approx(stored + copper, rel=1e-7 if part == 1.0 else 1e-4)
    assert z[ENERGY] == pytest.approx(given_j - copper, rel=1e-6)
    assert z[IMPULSE] == pytest.approx(load.inertia * z[OMEGA], rel=1e-9)


words = st.integers(formats.CURRENT.raw_min, formats.CURRENT.raw_max)


@given(words, words)
@settings(deadline=None)
def test_clarke_is_the_transform_cut_toward_zero(a, b):
    alpha, beta = clarke.currents(a, b)
    assert alpha == a
    exact = (a + 2 * b) / math.sqrt(3)
    if abs(exact) < formats.CURRENT.raw_max:
        assert abs(beta) <= abs(exact)
        assert abs(beta - exact) <= 2 + abs(exact) * clarke.COEFFICIENT.step
    else:
        assert formats.CURRENT.holds(beta)
        assert beta * exact > 0


@given(words, words)
@settings(deadline=None)
def test_inverse_clarke_gives_back_what_it_got(alpha, beta):
    a, b, c = clarke.phases(alpha, beta)
    assert all(formats.VOLTAGE.holds(leg) for leg in (a, b, c))
    if max(abs(alpha), abs(beta)) < 0.7 * formats.VOLTAGE.raw_max:
        assert abs((2 * a - b - c) / 3 - alpha) <= 1
        off = 2 + abs(beta) * 2 * clarke.COEFFICIENT.step
        assert abs((b - c) / math.sqrt(3) - beta) <= off
        assert abs(clarke.currents(a, b)[1] - beta) <= 3 + off
        assert clarke.phases(-alpha, -beta) == (-a, -b, -c)


def test_closed_forms_agree_with_each_other():
    for motor in BRUSHLESS_PRESETS.values():
        k_l = closed_forms.brushless_k_l(motor.pole_pairs, motor.psi_vs, motor.L_h)
        assert k_l == pytest.approx(1.5 * (motor.pole_pairs * motor.psi_vs) ** 2 / motor.L_h)
        form = (motor.pole_pairs, motor.psi_vs, motor.L_h, motor.R_ohm, 0.0)
        assert closed_forms.brushless_wall_torque(*form, 1e-6) == pytest.approx(-k_l * 1e-6)
        # Slow, it is the damper k_T²/r; fast, the inductance keeps the current out.
        slow = closed_forms.brushless_drag(*form, 1e-3, 0.5)
        k_t = closed_forms.brushless_k_t(motor.pole_pairs, motor.psi_vs)
        series = closed_forms.series_resistance(motor.R_ohm, 0.5)
        assert slow == pytest.approx(-(k_t**2) / series * 1e-3)
        assert closed_forms.brushless_drag(*form, 10.0, 1.0) == 0.0


@pytest.mark.parametrize("controller", MODELS)
def test_stiffness_at_eight_angles(make_scene, controller):
    """K = 1.5 (pψ)²/(L + Rτ/2) within 1 %, wherever the magnets stand, and as good as the same."""
    measured = []
    for theta in ANGLES:
        scene = make_scene(*TAP, magnets_at(theta), "encoder.counts_per_rev=10000")
        result = measure(scene, controller, compare=False)
        l_eff = GIMBAL.L_h + GIMBAL.R_ohm * 1e-4 / 2
        assert result["k_l"] == pytest.approx(1.5 * PSI**2 / GIMBAL.L_h)
        assert result["stiffness_predicted"] == pytest.approx(1.5 * PSI**2 / l_eff, rel=1e-4)
        assert result["stiffness"] == pytest.approx(1.5 * PSI**2 / l_eff, rel=0.01)
        measured.append(result["stiffness"])
    assert np.ptp(measured) < 1e-3 * np.mean(measured)


@pytest.mark.parametrize("preset", BRUSHLESS_PRESETS)
def test_stiffness_of_each_preset(make_scene, preset):
    """With a hand as stiff as the wall, a twentieth of an electrical radian deep."""
    motor = BRUSHLESS_PRESETS[preset]
    k_t = closed_forms.brushless_k_t(motor.pole_pairs, motor.psi_vs)
    k = closed_forms.stiffness(k_t, motor.L_h, motor.R_ohm, 1e-4)
    scene = make_scene(
        *TAP, f"motor.preset={preset}", f"hand.amplitude_rad={0.1 / motor.pole_pairs:.6g}",
        f"hand.stiffness={k:.6g}", f"hand.damping={math.sqrt(k * motor.J_kgm2):.6g}",
        "motor.magnet_rad=0.01",
    )  # fmt: skip
    result = measure(scene, "golden", compare=False)
    assert result["stiffness_predicted"] == pytest.approx(k, rel=1e-4)
    assert result["stiffness"] == pytest.approx(k, rel=0.01)


@pytest.mark.parametrize("controller", MODELS)
@pytest.mark.parametrize("speed", [20.0, -20.0])
def test_the_wall_of_a_turning_rotor_is_a_sine_of_its_angle(make_scene, controller, speed):
    """Forced through it, the torque is that of a flux held still, over three electrical turns."""
    scene = make_scene(*turning(speed), EVERYWHERE, "scene.duration_s=0.14", magnets_at(1.0))
    rows = rows_of(scene, controller)
    x = rows[:, Column.X] + 0.1
    assert abs(x[-1]) * GIMBAL.pole_pairs > 6.0 * math.pi
    expected = [
        closed_forms.brushless_wall_torque(
            GIMBAL.pole_pairs, GIMBAL.psi_vs, GIMBAL.L_h, GIMBAL.R_ohm, 1e-4, depth
        )
        for depth in x
    ]
    peak = np.abs(expected).max()
    assert peak > 0.12
    assert np.abs(rows[:, Column.TORQUE] - expected).max() < 0.01 * peak


@pytest.mark.parametrize("controller", MODELS)
def test_drag_of_a_turning_rotor(make_scene, controller):
    """η = −½ at 60 rad/s: a torque that does not know the angle, as the closed form has it."""
    scene = make_scene(*turning(60.0), EVERYWHERE, "controller.eta_contact=-0.5")
    torque = rows_of(scene, controller)[10_000:, Column.TORQUE]
    expected = closed_forms.brushless_drag(
        GIMBAL.pole_pairs, GIMBAL.psi_vs, GIMBAL.L_h, GIMBAL.R_ohm, 1e-4, 60.0, 0.5
    )
    assert torque.mean() == pytest.approx(expected, rel=0.01)
    assert np.ptp(torque) < 1e-3 * abs(expected)


@pytest.mark.parametrize("theta", [0.0, math.pi / 6])
def test_harmonics_are_felt_in_the_stiffness(make_scene, theta):
    """K goes by the square of the back-EMF's vector, which swings six times a turn."""
    fifth, seventh = 0.1, 0.06
    vector = 1.0 - fifth * np.exp(-6j * theta) + seventh * np.exp(6j * theta)
    scene = make_scene(
        *TAP, magnets_at(theta), f"motor.harmonic_5={fifth}", f"motor.harmonic_7={seventh}",
        "hand.amplitude_rad=0.004",
    )  # fmt: skip
    result = measure(scene, "golden", compare=False)
    expected = abs(vector) ** 2 * result["stiffness_predicted"]
    assert abs(abs(vector) ** 2 - 1.0) > 0.05
    assert result["stiffness"] == pytest.approx(expected, rel=0.01)


def test_harmonics_are_felt_in_the_torque_for_an_ampere():
    """Of three phases' back-EMFs, each a sine with its harmonics, by Clarke and along q."""
    fifth, seventh = 0.1, -0.04
    for theta in np.linspace(0.0, 2.0 * math.pi, 37):
        a, b, c = (
            -math.sin(phi) - fifth * math.sin(5.0 * phi) - seventh * math.sin(7.0 * phi)
            for phi in (theta, theta - 2.0 * math.pi / 3.0, theta + 2.0 * math.pi / 3.0)
        )
        alpha, beta = (2.0 * a - b - c) / 3.0, (b - c) / math.sqrt(3.0)
        along = math.cos(theta) * beta - math.sin(theta) * alpha
        own = closed_forms.brushless_own_k_t(theta, fifth, seventh)
        assert own == pytest.approx(along, abs=1e-12)


def test_a_wall_is_of_the_axis_q(make_scene):
    """With L_d ≠ L_q a shallow contact feels L_q, on both controllers."""
    scene = make_scene(*TAP, "motor.l_d_part=0.6", magnets_at(0.7))
    for controller in MODELS:
        result = measure(scene, controller, compare=False)
        assert result["stiffness"] == pytest.approx(result["stiffness_predicted"], rel=0.01)


def test_free_space_is_free(make_scene):
    """A hand waves the rotor over an electrical turn: 0.05 mN·m at most."""
    scene = make_scene(
        "hand.path='free'", "hand.amplitude_rad=0.5", "hand.frequency_hz=5", "hand.stiffness=0.1",
        "hand.damping=0.5e-3", "controller.walls=[[0.0, 1.0]]", "scene.duration_s=0.2",
        "encoder.counts_per_rev=10000", "adc.bits=12", "adc.full_scale_a=1",
    )  # fmt: skip
    for controller in MODELS:
        rows = rows_of(scene, controller)
        assert np.ptp(rows[:, Column.X]) * GIMBAL.pole_pairs > 2 * math.pi
        begun = rows[:, Column.T] > 2e-3  # the rotor moves in the first tick, and no wave knows it
        assert np.abs(rows[begun, Column.TORQUE]).max() < 0.05e-3


def test_torque_of_golden_is_analogs():
    scene = load_scene(SCENES_DIR / "brushless_taps.toml", ("scene.duration_s=0.5",))
    result = measure(scene, "golden")
    assert result["torque_nrmse_vs_analog"] < 2e-3
    assert result["stiffness"] == pytest.approx(result["stiffness_predicted"], rel=0.01)
    assert result["peak_torque"] > 5e-3
    ideal = scene.model_copy(update={"adc": None})
    assert measure(ideal, "golden")["torque_nrmse_vs_analog"] < 2e-4


@pytest.mark.parametrize("part", [0.9, 1.0, 1.1])
def test_it_feels_as_the_motor_with_brushes_of_its_k_t(make_scene, part):
    """R̂ off by a tenth does to two ports what it does to one: the wall leaks, or grows."""
    sets = (*TAP, f"controller.r_hat={part * GIMBAL.R_ohm}", "encoder.counts_per_rev=20000",
            "scene.duration_s=0.035")  # fmt: skip
    brushless = make_scene(*sets, magnets_at(2.0))
    k_t = closed_forms.brushless_k_t(GIMBAL.pole_pairs, GIMBAL.psi_vs)
    one = brushless.motor.model_copy(
        update={"kind": "dc", "k_t": k_t, "pole_pairs": None, "psi_vs": None, "magnet_rad": 0.0}
    )
    brushed = SampledSimulation(brushless.model_copy(update={"motor": one}), rtl=False)
    rows = rows_of(brushless, "golden")
    like = np.zeros_like(rows)
    brushed.advance(like, np.zeros((len(like), len(Word)), dtype=np.int64))
    torque = like[:, Column.TORQUE]
    error = np.sqrt(np.mean((rows[:, Column.TORQUE] - torque) ** 2)) / np.abs(torque).max()
    assert np.abs(torque).max() > 5e-4
    assert error < 2e-4


@pytest.mark.parametrize("controller", MODELS)
def test_the_voltage_limit_is_each_axis_own(make_scene, controller):
    """A wall at the limit has 1.5 pψ·limit/R where q lies along an axis, and √2 of it between.

    With R̂ above R it stays there: it grows.
    """
    held = []
    for theta in (0.0, math.pi / 4):
        scene = make_scene(
            "hand.path='press'", "hand.amplitude_rad=0.012", "hand.stiffness=2",
            "hand.damping=3e-3", "controller.walls=[[0.0, 1.0]]", "drive.limit_v=0.5",
            "scene.duration_s=0.15", magnets_at(theta - 0.05), "controller.r_hat=4.8",
        )  # fmt: skip
        rows = rows_of(scene, controller)
        assert rows[-1, Column.SATURATED] == 1.0
        held.append(-rows[-1000:, Column.TORQUE].mean())
    assert held[0] == pytest.approx(1.5 * PSI * 0.5 / GIMBAL.R_ohm, rel=0.02)
    assert held[1] == pytest.approx(math.sqrt(2.0) * held[0], rel=0.02)


def test_ports_give_no_energy(make_scene):
    """Walls that switch η all along, a rotor that turns, a = 0.99: both ports only take."""
    stripes = [[0.02 * n, 0.02 * n + 0.01] for n in range(-20, 20)]
    scene = make_scene(*SWUNG, f"controller.walls={stripes}", "controller.lambda=1e9",
                       "scene.duration_s=0.1", "hand.amplitude_rad=0.4")  # fmt: skip
    rows = rows_of(scene, "golden")
    energy = np.cumsum(rows[:, Column.ENERGY_OUT])
    assert np.count_nonzero(np.diff(rows[:, Column.ETA])) > 50
    assert energy.max() <= 0.0
    assert energy.min() < -1e-5


@pytest.mark.parametrize(
    "sets",
    [
        (*TAP, "adc.bits=12", "adc.full_scale_a=1", "adc.noise_a=1e-3", magnets_at(0.8),
         "encoder.counts_per_rev=10000", "controller.extra_ticks=3"),
        (*SWUNG, "controller.walls=[[0.0, 0.1], [0.2, 0.3]]", "controller.eta_contact=-0.7",
         "drive.limit_v=0.4", "controller.lambda=1e9", "controller.edge_hysteresis=true",
         "encoder.counts_per_rev=2000"),
    ],
    ids=["sensed", "limited"],
)  # fmt: skip
def test_core_is_golden(make_scene, sets):
    """The RTL with two ports, in the loop: every bit of every word and row, in 24 clocks a port."""
    scene = make_scene(*sets, "scene.duration_s=0.03")
    ticks = 30_000
    found = []
    for name in ("golden", "core"):
        simulation = CONTROLLERS[name](scene)
        rows, words = np.zeros((ticks, len(Column))), np.zeros((ticks, len(Word)), dtype=np.int64)
        simulation.advance(rows, words)
        found.append((rows, words, simulation.clock_cycles))
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])
    assert np.count_nonzero(np.diff(found[0][0][:, Column.ETA])) >= 1
    assert found[0][2] is None
    assert found[1][2] == 2 * CORE_CLOCKS * ticks


def test_chunks_do_not_matter(make_scene):
    scene = make_scene(*TAP, "adc.bits=12", "adc.full_scale_a=1", "adc.noise_a=1e-3")
    whole = rows_of(scene, "golden")
    simulation = CONTROLLERS["golden"](scene)
    rows, raw = np.zeros_like(whole), np.zeros((len(whole), len(Word)), dtype=np.int64)
    for part in (slice(0, 777), slice(777, 30_000), slice(30_000, None)):
        simulation.advance(rows[part], raw[part])
    assert np.array_equal(rows, whole)


ASKING = {
    "brushes": ("brushes.drop_v=0.1",),
    "winding": ("winding.saturation_a=1",),
    "thermal": ("thermal.start_c=60",),
    "transmission.cable_stiffness": (*TAP, "transmission.cable_stiffness=1"),
    "encoder.stops_at_s": ("encoder.counts_per_rev=4000", "encoder.stops_at_s=1"),
    "encoder.reverses_at_s": ("encoder.counts_per_rev=4000", "encoder.reverses_at_s=1"),
    "encoder.uneven": ("encoder.counts_per_rev=4000", "encoder.uneven=0.1"),
    "encoder.skips_per_rev": ("encoder.counts_per_rev=4000", "encoder.skips_per_rev=10"),
    "adc.bandwidth_hz": ("adc.bits=12", "adc.bandwidth_hz=1e5"),
    "adc.common_mode_a": ("adc.bits=12", "adc.common_mode_a=1e-3"),
    "adc.drift_a_per_s": ("adc.bits=12", "adc.drift_a_per_s=1e-3"),
    "drive.mode": ("drive.bus_v=12", "drive.mode=locked-anti-phase"),
    "drive.bus_measured": ("drive.bus_v=12", "drive.bus_measured=true"),
    "drive.step_v": ("drive.bus_v=12", "drive.step_v=1", "drive.step_s=0.1"),
    "drive.sag_ohm": ("drive.bus_v=12", "drive.sag_ohm=1"),
}


def test_what_is_not_there_yet_is_refused_in_one_line(make_scene):
    assert set(ASKING) == set(BRUSHLESS)
    for what, sets in ASKING.items():
        scene = make_scene(*sets)
        assert what in asked(scene)
        for controller in BRUSHLESS_RUNGS:
            with pytest.raises(SceneError) as refused:
                CONTROLLERS[controller](scene)
            message = str(refused.value)
            assert what in message
            assert re.search(r"; .*(leave it out|take `golden`)", message)
            assert "\n" not in message
        with pytest.raises(SceneError, match=re.escape(what)):
            refuse(scene, "a board")


def test_controllers_of_one_port_refuse_two(make_scene):
    scene = make_scene(*TAP)
    rungs = "`analog`, `golden`, `core`, `pins` or `encoder`"
    for name in set(ABILITIES) - {*BRUSHLESS_RUNGS, "a board"}:
        with pytest.raises(SceneError, match=rf"yet; take {rungs}$"):
            refuse(scene, name)
    with pytest.raises(SceneError, match="two ports and this takes one"):
        SampledSimulation(scene, rtl=False)
    board = load_board("ulx3s")
    adc = board.scene.adc.model_copy(update={"bandwidth_hz": None})
    asking = board.scene.model_copy(update={"motor": scene.motor, "adc": adc})
    with pytest.raises(SceneError, match=r'kind = "pmsm" needs 3 half bridges, and .* has 2 \('):
        replace(board, scene=asking).words()
    brushless = load_board("ulx3s_brushless")
    with pytest.raises(SceneError, match=r'kind = "dc" needs 2 half bridges, and .* has 3 \('):
        replace(brushless, scene=board.scene.model_copy(update={"host": None})).words()


@pytest.mark.parametrize(
    ("sets", "told"),
    [
        (("motor.k_t=0.1",), "motor.k_t belongs to a motor of kind \"dc\""),
        (("motor.kind=dc",), 'motor.kind = "dc" contradicts motor.preset = "gbm2804-100t"'),
        (("motor.preset=re25-118743", "motor.pole_pairs=2"), "add kind = \"pmsm\""),
        (("motor.psi_vs=1e-6",), "motor.psi_vs = 1e-6 at 7 pole pairs is 1.05e-5 N·m/A; it must"),
        (("motor.pole_pairs=0",), "motor.pole_pairs = 0 is out of range; it must be 1 to 100"),
        (("motor.psi_vs='4 mV·s'",), "motor.psi_vs must be a number in V·s"),
        (("motor.kind=synchronous",), 'motor.kind "synchronous" is unknown; known: dc, pmsm'),
        (("drive.limit_v=6", "drive.bus_v=12"), "it may be at most 5.072 V"),
    ],
)  # fmt: skip
def test_refused_by_the_format(make_scene, sets, told):
    with pytest.raises(SceneError) as refused:
        make_scene(*sets)
    assert told in str(refused.value)


def test_a_motor_of_numbers_needs_all_of_them(tmp_path):
    path = tmp_path / "scene.toml"
    keys = {"kind": '"pmsm"', "R_ohm": 1, "L_h": 1e-3, "pole_pairs": 7, "psi_vs": 0.01,
            "J_kgm2": 1e-5}  # fmt: skip
    for missing in ("pole_pairs", "psi_vs", "R_ohm", None):
        lines = "\n".join(f"{key} = {value}" for key, value in keys.items() if key != missing)
        path.write_text(BASE.replace('preset = "gbm2804-100t"', lines))
        if missing is None:
            motor = load_scene(path).motor
            assert (motor.k_t, motor.k_e) == pytest.approx((0.105, 0.07))
        else:
            with pytest.raises(SceneError, match=rf"motor.{missing} is missing; give preset, or"):
                load_scene(path)


def test_limit_and_bus_of_three_phases(make_scene):
    assert THREE_PHASE_REACH * (math.sqrt(3.0) + 1.0) / 2.0 == pytest.approx(1.0 / math.sqrt(3.0))
    drive = make_scene("drive.bus_v=24").drive
    assert drive.limit_v == pytest.approx(24 * THREE_PHASE_REACH)
    for limit, bus in ((5.0, 12.0), (5.1, 24.0), (20.0, 48.0)):
        assert make_scene(f"drive.limit_v={limit}").drive.bus_v == bus
    with pytest.raises(SceneError, match=r"at most 20\.29 V"):
        make_scene("drive.limit_v=21")


def test_presets_are_on_the_page():
    page = (SCENES_DIR / "README.md").read_text(encoding="utf-8")
    assert not set(PRESETS) & set(BRUSHLESS_PRESETS)
    for name, motor in BRUSHLESS_PRESETS.items():
        (row,) = re.findall(rf"^\| `{name}` \|(.*)\|$", page, re.MULTILINE)
        assert tuple(float(cell) for cell in row.split("|")) == pytest.approx(tuple(motor))
