# SPDX-License-Identifier: Apache-2.0
"""Devices of several motors: what a hand feels at the tip, and what is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from wavehaptics.controller.planes import LEAST_ANGLE, Host, PortEstimate, as_words, beside
from wavehaptics.controller.surfaces import (
    MIX,
    MOST_SURFACES,
    PORTS,
    VECTOR_WORDS,
    accepts,
    pair_row,
    triple_row,
)
from wavehaptics.ladder.device_abilities import left_out_of_device, refuse_device
from wavehaptics.ladder.joint import JointSimulation
from wavehaptics.ladder.joint_run import TIP_PICTURE, TIP_TRACE, measure_device
from wavehaptics.ladder.run import CONTROLLERS, analog, measure, run_device
from wavehaptics.laws.kinematics import PHANTOM, linked_arm
from wavehaptics.laws.shapes import Shape
from wavehaptics.scene import (
    SPACE_TABLES,
    Device,
    SceneError,
    find_scene,
    load_device,
    load_scene,
    shipped_scenes,
)
from wavehaptics.trace.columns import Column, Word, load_trace
from wavehaptics.trace.tip import Tip

HEAD = '[scene]\nname = "arm"\nduration_s = 0.15\ntrace_hz = 20e3\n'
MOTOR = '[[motors]]\npreset = "re25-phantom"\n'
CONTROL = "[controller]\ntick_hz = 1e6\nlambda = 5e5\n"
REAL = (
    "[encoder]\ncounts_per_rev = 10_000\n[adc]\nbits = 12\nfull_scale_a = 2.5\nnoise_a = 1e-3\n"
    "[drive]\nbus_v = 24\n"
)
PUSH = "stiffness_n_per_m = 500\ndamping_n_s_per_m = 5\n"
PLANE = '[[surface]]\nshape = "plane"\nnormal = {normal}\n'
PRESS = '[hand]\npath = "press"\namplitude_m = 0.004\ndirection = {direction}\n' + PUSH


def text(normal: list[float], *more: str, kinematics: str = "phantom", motors: int = 3) -> str:
    """A device whose hand presses against a plane."""
    return "".join((
        HEAD, f'[device]\nkinematics = "{kinematics}"\n', PLANE.format(normal=normal),
        PRESS.format(direction=[-part for part in normal]), *more, MOTOR * motors, CONTROL,
    ))  # fmt: skip


def load(folder: Path, content: str, *sets: str) -> Device:
    path = folder / "arm.toml"
    path.write_text(content)
    return load_device(path, sets)


def run(
    device: Device, controller: str, duration_s: float
) -> tuple[np.ndarray, np.ndarray, JointSimulation]:
    """Rows of motors and tip."""
    simulation = JointSimulation(device, controller)
    ticks = round(duration_s / simulation.tick_s)
    rows = np.zeros((len(device.scenes), ticks, len(Column)))
    words = np.zeros((len(device.scenes), ticks, len(Word)), dtype=np.int64)
    tips = np.zeros((ticks, len(Tip)))
    simulation.advance(rows, words, tips)
    return rows, tips, simulation


@pytest.mark.parametrize("controller", ["analog", "golden"])
@pytest.mark.parametrize("normal", [[0, 0, 1], [0.3, 0.5, 1.0], [1, -1, 0.2], [0, -1, 0.02]])
def test_a_plane_at_any_angle_is_the_papers_7500(tmp_path: Path, normal, controller: str) -> None:
    """7500 N/m ± 1 %, and a resting hand feels its spring and the wall's in series, no more."""
    device = load(tmp_path, text(normal))
    found = measure_device(device, controller)
    assert found["tip_stiffness"] == pytest.approx(7500.0, rel=0.01)
    assert found["tip_stiffness"] == pytest.approx(found["tip_stiffness_predicted"], rel=0.002)
    assert found["tip_force_n"] == pytest.approx(-0.004 / (1 / 500 + 1 / 7500), rel=0.003)
    assert found["tangential_part"] < 1e-3
    assert found["contact_energy_ratio"] < 0.01
    assert found["energy_out_max_j"] < 1e-6


def test_the_stiffness_of_unequal_motors_and_levers(tmp_path: Path) -> None:
    """1/Σ G_n²/K_n of three different motors behind different gears, from their data alone."""
    content = text([0.4, 0.5, 0.9], "").replace(
        MOTOR * 3,
        '[[motors]]\npreset = "re25-phantom"\n[[motors]]\npreset = "re40-148877"\n'
        '[[motors]]\npreset = "re30-48v"\n',
    )
    device = load(
        tmp_path, content, "device.ratio=[8.0, 5.0, 6.0]", "device.home_rad=[0.2, 0.3, -0.2]"
    )
    found = measure_device(device, "golden")
    q, ratio, step = np.array([0.2, 0.3, -0.2]), np.array([8.0, 5.0, 6.0]), 1e-6

    def tip(angles: np.ndarray) -> np.ndarray:
        """The PHANTOM's tip, written once more."""
        first, second, third = angles
        out = 0.14 * (math.cos(second) + math.sin(third))
        return np.array([
            out * math.sin(first), 0.14 * (1 - math.cos(third) + math.sin(second)),
            out * math.cos(first) - 0.14,
        ])  # fmt: skip

    normal = np.array([0.4, 0.5, 0.9]) / np.linalg.norm([0.4, 0.5, 0.9])
    lever = np.array([
        (tip(q + step * unit) - tip(q - step * unit)) @ normal / (2 * step) for unit in np.eye(3)
    ]) / ratio  # fmt: skip
    k_t, inductance, resistance = (
        np.array([[one.motor.k_t, one.motor.L_h, one.motor.R_ohm] for one in device.scenes]).T
    )  # fmt: skip
    tau_s = 1e-6 / 0.99 + 1e-6
    springs = k_t**2 / (inductance + resistance * tau_s / 2)
    wanted = 1.0 / float(lever**2 @ (1.0 / springs))
    assert found["tip_stiffness_predicted"] == pytest.approx(wanted, rel=1e-3)
    assert found["tip_stiffness"] == pytest.approx(wanted, rel=0.01)


@pytest.mark.parametrize("stiffness", [5000.0, 1500.0])
@pytest.mark.parametrize("controller", ["analog", "golden"])
def test_a_softer_surface_is_as_soft_as_wished(
    tmp_path: Path, controller: str, stiffness: float
) -> None:
    device = load(tmp_path, text([0.3, 0.5, 1.0]), f"surface.0.stiffness={stiffness}")
    found = measure_device(device, controller)
    assert found["tip_stiffness_predicted"] == stiffness
    assert found["tip_force_n"] == pytest.approx(-0.004 / (1 / 500 + 1 / stiffness), rel=0.005)
    assert abs(found["tip_offset_m"]) < 0.01 * 0.004


def test_nothing_of_a_push_along_the_plane_is_felt(tmp_path: Path) -> None:
    """The hand slides by 20 mm: no force across the normal, but with a loss there is one."""
    across = '[hand]\npath = "slide"\namplitude_m = 0.004\nacross = [1, 0, -0.3]\nslide_m = 0.02\n'
    content = text([0.3, 0.5, 1.0]).replace(
        '[hand]\npath = "press"\namplitude_m = 0.004\n', f"{across}frequency_hz = 4\n"
    )
    device = load(tmp_path, content, "scene.duration_s=0.25")
    free = measure_device(device, "golden")
    assert free["tangential_part"] < 2e-3
    assert free["surface_error_max_m"] < 2e-5
    lossy = load(tmp_path, content, "scene.duration_s=0.25", "surface.0.friction_loss=0.5")
    # A damper of B_R (1 − η)/(1 + η) at each motor, through 8:1 and 0.14 m. The tip slides by
    # sin² of 4 Hz from 0.1 s on, six tenths of the time.
    drag = 43.8e-3**2 / 7.6 * 0.5 / 1.5 * (8 / 0.14) ** 2
    rms = 0.5 * 0.02 * 2 * math.pi * 4 * math.sqrt(0.5 * 0.6)
    assert measure_device(lossy, "golden")["tangential_force"] == pytest.approx(drag * rms, rel=0.1)


@pytest.mark.parametrize("damping", [1.0, 0.5])
def test_a_servo_shakes_where_the_wave_holds(tmp_path: Path, damping: float) -> None:
    """A Cartesian spring at 1 kHz holds 500 N/m, and swings with the 7500 that the wave has."""
    content = text([0.3, 0.5, 1.0], "").replace(CONTROL, REAL + CONTROL)
    sets = (f"hand.damping_n_s_per_m={damping}", "surface.0.point_m=[-0.3e-3, -0.4e-3, -0.9e-3]",
            "scene.duration_s=0.25")  # fmt: skip
    soft = measure_device(load(tmp_path, content, *sets, "surface.0.stiffness=500"), "encoder")
    assert soft["tip_stiffness"] == pytest.approx(500, rel=0.03)
    assert soft["swing_m"] < 2 * 11e-6
    stiff = measure_device(load(tmp_path, content, *sets), "encoder")
    assert stiff["tip_stiffness_predicted"] == pytest.approx(7500, rel=0.01)
    assert stiff["tip_offset_m"] is None  # it jumps off
    assert stiff["contact_energy_ratio"] > 0.5
    wave = measure_device(load(tmp_path, content, *sets), "golden")
    assert wave["contact_fraction"] > 0.8
    assert wave["contact_energy_ratio"] < 0.05


def test_one_motor_of_a_device_is_the_motor_alone(tmp_path: Path) -> None:
    """A lever of 20 mm, pressed on a wall at its tip: the circuit of one motor feels alike."""
    lever = 0.02
    joint = (
        f'{HEAD}[device]\nkinematics = "matrix"\njacobian = [[{lever}], [0], [0]]\n'
        '[[surface]]\nshape = "plane"\nnormal = [-1, 0, 0]\npoint_m = [0.4e-3, 0, 0]\n'
        '[hand]\npath = "press"\namplitude_m = 4e-3\ndirection = [1, 0, 0]\n'
        f"stiffness_n_per_m = {0.5 / lever**2}\ndamping_n_s_per_m = {1e-3 / lever**2}\n"
        f"{MOTOR}{CONTROL}"
    )
    sets = ("controller.lambda=1e5", "device.wall_speed_m_per_s=0")
    rows, _, _ = run(load(tmp_path, joint, *sets), "analog", 0.15)
    path = tmp_path / "alone.toml"
    path.write_text(
        f'{HEAD}[motor]\npreset = "re25-phantom"\n[hand]\npath = "press"\namplitude_rad = 0.2\n'
        f"stiffness = 0.5\ndamping = 1e-3\n{CONTROL}walls = [[0.02, 2.0]]\n"
    )
    alone = analog(load_scene(path, sets[:1]))
    other = np.zeros((150_000, len(Column)))
    alone.advance(other)
    rest = slice(120_000, None)  # the two begin their presses at other places
    assert rows[0, rest, Column.TORQUE] == pytest.approx(other[rest, Column.TORQUE], rel=1e-3)
    assert rows[0, rest, Column.X] == pytest.approx(other[rest, Column.X], rel=1e-3)


@pytest.mark.parametrize("more", [
    (),
    ("brushes.drop_v=0.2", "brushes.segments=11", "brushes.step=0.04"),
    ("brushes.flicker_noise=0.02", "brushes.contact_noise=0.02"),
    ("adc.bandwidth_hz=200e3", "adc.common_mode_a=5e-3", "adc.drift_a_per_s=0.02"),
    ("drive.bus_actual_v=20", "drive.sag_ohm=1", "drive.gain_error=0.03", "drive.limit_v=18"),
    ("drive.step_v=-6", "drive.step_s=0.02", "drive.bus_measured=true"),
    ("encoder.uneven=0.2", "encoder.skips_per_rev=10"),
    ("encoder.stops_at_s=0.03", "controller.edge_hysteresis=true", "controller.extra_ticks=2"),
    ("winding.saturation_a=1", "winding.eddy_ohm=5", "winding.eddy_part=0.3"),
    ("cogging.torque_nm=1e-4", "cogging.per_rev=11", "load.inertia_kgm2=1e-6"),
    ("friction.coulomb_nm=1e-5", "controller.eta_contact=-0.9", "controller.eta_free=0.95"),
])  # fmt: skip
def test_a_joint_wall_of_a_device_is_bit_for_bit_that_of_the_motor(
    tmp_path: Path, more: tuple[str, ...]
) -> None:
    """No surface, no hand: each port of the joint loop is the port of a scene of one motor."""
    walls = "walls = [[0.01, 1.0]]\nanchor_auto = true\n"
    friction = "[friction]\nviscous = 1e-6\n"
    device = load(tmp_path, (
        f'{HEAD}[device]\nkinematics = "matrix"\njacobian = [[0.02, 0], [0, 0.02], [0, 0]]\n'
        f"{MOTOR}{MOTOR}{REAL}{friction}{CONTROL}{walls}"
    ), "adc.offset_a=-0.02", "scene.duration_s=0.05", *more)  # fmt: skip
    simulation = JointSimulation(device, "golden")
    rows = np.zeros((2, 50_000, len(Column)))
    words = np.zeros((2, 50_000, len(Word)), dtype=np.int64)
    simulation.advance(rows, words, np.zeros((50_000, len(Tip))))
    path = tmp_path / "alone.toml"
    path.write_text(f'{HEAD}[motor]\npreset = "re25-phantom"\n{REAL}{friction}{CONTROL}{walls}')
    scene = load_scene(path, ["adc.offset_a=-0.02", *more])
    alone = CONTROLLERS["golden"](scene)
    other, its_words = np.zeros((50_000, len(Column))), np.zeros((50_000, len(Word)), np.int64)
    alone.advance(other, its_words)
    assert other[:, Column.CONTACT].any()
    np.testing.assert_array_equal(words[0], its_words)
    assert rows[0, :, Column.X] == pytest.approx(other[:, Column.X], rel=1e-12)


def elbow(q: np.ndarray) -> np.ndarray:
    """The tip of a planar arm of 0.14 m links, 8:1, that begins at (0.14, 0.14) m."""
    first = q[0] / 8
    both = first + math.pi / 2 + q[1] / 8
    return 0.14 * np.array([math.cos(first) + math.cos(both), math.sin(first) + math.sin(both)])


def judge_a_corner(
    normals: list[list[float]], moved: np.ndarray, goal: np.ndarray, spring: float, count: float
) -> None:
    """Springs of the motors alone, from 0 where all planes are: no word of the law is in it.

    ``moved`` (2,) is where the tip of :func:`elbow` rests and ``goal`` where the hand of 500 N/m
    pulls it, in m from the corner; ``spring`` in N·m/rad and ``count`` in rad are each motor's.
    """
    start, step, out = elbow(np.zeros(2)), 1e-6, np.array(normals)[:, :2]

    def levers(q: np.ndarray) -> np.ndarray:
        return np.array([(elbow(q + d) - elbow(q - d)) / (2 * step) for d in step * np.eye(2)]).T

    # Where springs hold the tip if both planes hold them, by Newton's steps.
    held, q = np.zeros(2), np.zeros(2)
    for _ in range(20):
        left = levers(held).T @ (500 * (goal - elbow(held) + start)) - spring * held
        held += np.linalg.solve(500 * levers(held).T @ levers(held) + spring * np.eye(2), left)
        q += np.linalg.solve(levers(q), moved + start - elbow(q))
    hand = 500 * (goal - moved)
    # Where the springs of the tip that rests begin, in counts beyond each plane.
    begin = q - levers(q).T @ hand / spring
    across = out @ levers(np.zeros(2))
    beyond = -across @ begin / (np.linalg.norm(across, axis=1) * count)
    depth = -out @ moved
    assert (np.linalg.solve(out.T, -hand) > 0).all()  # each plane pushes
    if (-out @ (elbow(held) - start) > 0).all():
        # Half a count of each plane, and half a count of each encoder across both.
        assert np.abs(beyond).max() < 0.5 + 0.5 * math.sqrt(2)
        assert np.linalg.norm(moved - elbow(held) + start) < 1.2 * count * 0.14 / 8
        return
    # The springs would hold the tip out of one plane. It lets go, and is touched again further in.
    loose = int(np.argmin(-out @ (elbow(held) - start)))
    assert abs(beyond[1 - loose]) < 0.5 + 0.5 * math.sqrt(2)
    assert beyond[loose] > 1
    assert depth[loose] > -0.5 * count * 0.14 / 8
    assert depth[1 - loose] > 0


@pytest.mark.parametrize("angle", [60, 90, 120, 150, 170])
def test_a_corner_holds(tmp_path: Path, angle: float) -> None:
    """Two planes with anchors: the tip rests where the motors' springs have it, not swinging."""
    half = math.radians(angle / 2)
    normals = [[math.cos(half), math.sin(half), 0.0], [-math.cos(half), math.sin(half), 0.0]]
    planes = "".join(PLANE.format(normal=normal) for normal in normals)
    content = (
        f'{HEAD}[device]\nkinematics = "planar"\nhome_rad = [0.0, 1.5708]\n{planes}'
        f"{PRESS.format(direction=[0.1, -1.0, 0.0])}{MOTOR * 2}{REAL}{CONTROL}anchor_auto = true\n"
    )
    device = load(tmp_path, content, "scene.duration_s=0.35")
    _, tips, simulation = run(device, "golden", 0.35)
    rest = tips[-50_000:]
    moved = rest[:, Tip.X : Tip.Z + 1].mean(axis=0) - np.array(simulation.space.home_m)
    force = rest[:, Tip.FORCE_X : Tip.FORCE_Z + 1]
    goal = 0.004 * np.array([0.1, -1.0, 0.0]) / math.hypot(0.1, 1.0)
    assert np.abs(force.mean(axis=0) + 500 * (goal - moved)).max() < 0.01
    assert force.std(axis=0).max() < 0.01 * np.linalg.norm(force.mean(axis=0))
    # R̂ is 0.7 of 7.6 Ω, a 0.99 and the latency a period.
    spring = 43.8e-3**2 / (0.83e-3 + 0.7 * 7.6 * (1 / 0.99 + 1) * 1e-6 / 2)
    judge_a_corner(normals, moved[:2], goal[:2], spring, 2 * math.pi / 10_000)


def test_a_turning_surface_stays_where_it_is_by_its_wall_velocity() -> None:
    """Around a disc once: held to some counts (11 µm) with it, lost without."""
    path = find_scene("planar_disc")
    held = measure_device(load_device(path), "golden")
    assert held["contact_fraction"] > 0.95
    assert abs(held["surface_error_mean_m"]) < 2e-5
    assert held["surface_error_max_m"] < 5e-5
    assert held["tangential_part"] < 0.03
    lost = measure_device(load_device(path, ["device.wall_speed_m_per_s=0"]), "golden")
    assert lost["surface_error_max_m"] > 10 * held["surface_error_max_m"]


def test_a_commit_causes_no_jump_of_the_force() -> None:
    """Within 12 µs of a commit the force along a turning disc changes as it does elsewhere."""
    _, tips, simulation = run(load_device(find_scene("planar_disc")), "golden", 0.5)
    force = tips[:, Tip.FORCE_X : Tip.FORCE_Z + 1]
    every = round(1e-3 / simulation.tick_s)
    commits = np.arange(200 * every, 490 * every, every)  # at 1 kHz, a period late
    at, between = (
        np.linalg.norm(force[first + 12] - force[first - 1], axis=1)
        for first in (commits, commits + every // 2)
    )
    assert at.max() < 0.2
    assert at.mean() < 1.5 * between.mean()


def test_the_phantoms_plane_is_held_with_the_errors_of_real_motors(tmp_path: Path) -> None:
    device = load_device(find_scene("phantom_plane"))
    found = run_device(device, "golden", tmp_path)
    assert found["tip_stiffness"] == pytest.approx(7500, rel=0.02)
    assert found["surface_error_max_m"] < 2.5e-5
    assert found["tangential_part"] < 0.02
    assert found["motors"].keys() == {"turn", "lift", "reach"}
    assert all(one["anchor_fault_s"] is None for one in found["motors"].values())
    assert json.loads((tmp_path / "metrics.json").read_text())["tip_stiffness"] == pytest.approx(
        found["tip_stiffness"]
    )
    assert (tmp_path / TIP_PICTURE).stat().st_size > 20_000
    tip = load_trace(tmp_path / TIP_TRACE)
    assert tip["tip"].shape == tip["hand"].shape == tip["force"].shape == (12_000, 3)
    for name in ("turn", "lift", "reach"):
        assert load_trace(tmp_path / name)["i_word"].shape == (12_000,)
        assert (tmp_path / name / "run.png").exists()


@pytest.mark.parametrize("tick_hz", [1e6, 160e3])
def test_with_anchors_the_rate_alone_takes_stiffness(tick_hz: float) -> None:
    """Each axis has 8:1 and 0.14 m; R̂ is 0.7 of what the scene says, and the latency a period."""
    sets = (f"controller.tick_hz={tick_hz:g}", "scene.duration_s=0.06")
    found = measure_device(load_device(find_scene("phantom_plane"), sets), "golden")
    late = (1 / 0.99 + 1) / tick_hz
    motors = [43.8e-3**2 / (0.83e-3 + 0.7 * r * late / 2) for r in (8.0, 7.2, 7.6)]
    normal = np.array([0.3, 0.5, 1.0]) / math.sqrt(1.34)
    spring = (8 / 0.14) ** 2 / float(normal**2 @ (1 / np.array(motors)))
    assert found["tip_stiffness_predicted"] == pytest.approx(spring, rel=1e-3)
    # Half a count in 25, where the force is largest.
    assert found["tip_stiffness"] == pytest.approx(spring, rel=0.02)


def test_a_budget_of_nothing_lets_no_surface_move_on_credit(tmp_path: Path) -> None:
    device = load_device(find_scene("planar_disc"), ["device.wall_energy_j=0"])
    _, _, simulation = run(device, "golden", 0.3)
    assert simulation._group[1][0] >= 0


@pytest.mark.parametrize("keys", [
    ("device.update_hz=100",), ("device.delay_s=20e-3",), ("device.jitter_s=20e-3",),
    ("device.wall_speed_m_per_s=1e-3",), ("device.wall_energy_j=0",),
    ("surface.0.friction_loss=0.2",), ("surface.0.stiffness=3000",), ("surface.0.radius_m=0.036",),
    ("surface.0.point_m=[0.14, 0.101, 0]",), ("hand.amplitude_m=0.008",),
    ("hand.frequency_hz=2",), ("hand.center_m=[0.141, 0.1, 0]",), ("hand.across=[-1, 0, 0]",),
    ("hand.stiffness_n_per_m=400",), ("hand.damping_n_s_per_m=4",),
    ("device.links_m=[0.14, 0.13]",), ("device.ratio=[8, 7]",), ("device.home_rad=[0, 1.5]",),
])  # fmt: skip
@pytest.mark.parametrize("controller", ["analog", "golden", "encoder"])
def test_every_key_of_a_device_has_an_effect_or_is_said_to_have_none(
    controller: str, keys: tuple[str, ...]
) -> None:
    path = find_scene("planar_disc")
    rows = [run(load_device(path, more), controller, 0.2)[0][:, :, 1:] for more in ((), keys)]
    said = left_out_of_device(load_device(path, keys), controller)
    changed = keys[0].partition("=")[0].replace("surface.0.", "surface.")
    assert (changed in said) == np.array_equal(*rows)


def told(folder: Path, content: str, *sets: str, controller: str = "golden") -> str:
    with pytest.raises(SceneError) as refused:
        refuse_device(load(folder, content, *sets), controller)
    message = str(refused.value)
    assert message.isprintable()
    assert ";" in message
    return message.removeprefix(f"{folder}/")


def test_a_controller_that_cannot_do_it_says_so(tmp_path: Path) -> None:
    content = text([0, 0, 1])
    line = content[: content.index("[device]")].count("\n") + 1
    assert told(tmp_path, content, controller="core") == (
        f"arm.toml:{line}: [device] is not for `core`, whose RTL is the wave core of one motor; "
        "take `pins`, `analog`, `golden` or `encoder`"
    )


@pytest.mark.parametrize(("sets", "fragments"), [
    (("surface.0.stiffness=9000",), ("surface.0.stiffness=9000", "7479", "less")),
    (("surface.0.shape=edge",), ("surface[0].second_normal is missing", "give it")),
    (("surface.0.shape=edge", "surface.0.second_normal=[0,0,-2]"),
     ("surface[0].second_normal is along normal", "another direction")),
    (("surface.0.shape=edge", "surface.0.second_normal=[0,0,0]"),
     ("surface[0].second_normal has no direction",)),
    (("surface.0.second_normal=[0,1,0]",),
     ("surface[0].second_normal makes no sense", "takes normal")),
    (("surface.0.damping=1",), ("surface[0].damping needs a stiffness", "give one")),
    (("surface.0.damping=0.01", "surface.0.stiffness=6000"),
     ("surface.0.damping=0.01", "less than the 0.0", "smaller stiffness")),
    (("surface.0.radius_m=1",), ("surface[0].radius_m makes no sense", "takes normal")),
    (("surface.0.shape=sphere",), ("surface[0].normal makes no sense", "takes radius_m")),
    (("surface.0.normal=[0,0,0]",), ("surface[0].normal has no direction",)),
    (("surface.0.normal=[0,0]",), ("surface[0].normal", "three")),
    (("surface.0.friction_loss=2",), ("surface[0].friction_loss = 2", "0 to 1")),
    (("surface.4.stiffness=1",), ("surface.NUMBER.key", "has 1 [[surface]]")),
    (("device.kinematics=delta",), ('device.kinematics "delta"', "known: planar")),
    (("device.kinematics=planar",), ("has 3 motors, and the device takes 2",)),
    (("device.kinematics=matrix",), ("device.jacobian is missing",)),
    (("device.ratio=[8]",), ("device.ratio has 1 values", "3 motors")),
    (("device.jacobian=[[1]]",), ("device.jacobian makes no sense",)),
    (("hand.amplitude_rad=1",), ("unknown key hand.amplitude_rad", "amplitude_m")),
    (("hand.slide_m=1",), ("hand.slide_m makes no sense", "direction")),
    (("hand.path=slide",), ("hand.frequency_hz is missing", "Hz")),
    (("hand.path=impact",), ('hand.path "impact"', "known: press")),
    (("shaper.feel=spring", "shaper.stiffness=0.1"), ("[shaper] of a motor", "leave it out")),
    (("thermal.start_c=80",), ("[thermal] of a motor", "leave it out")),
    (("transmission.ratio=8", "transmission.lever_m=0.1"), ("[transmission]", "device.ratio")),
    (("motor.preset=gbm2804-100t",), ("pmsm", "brushes")),
    (("motors.1.hand.path=impact", "motors.1.hand.amplitude_rad=1",
      "motors.1.hand.speed_rad_s=1"), ("motors.motor_1: [hand] of a motor", "[hand]")),
])  # fmt: skip
def test_what_is_refused_is_told_in_one_line(tmp_path: Path, sets, fragments) -> None:
    message = told(tmp_path, text([0, 0, 1]), *sets)
    for fragment in fragments:
        assert fragment in message


@pytest.mark.parametrize("key", ["encoder.stops_at_s=0.05", "servo.rate_hz=2e3",
                                 "servo.delay_s=1e-3", "servo.amplifier_hz=500"])  # fmt: skip
def test_what_a_servo_of_a_device_knows_has_an_effect(key: str) -> None:
    path = find_scene("planar_disc")
    rows = [run(load_device(path, sets), "encoder", 0.1)[0] for sets in ((), (key,))]
    assert not np.array_equal(rows[0][:, :, 1:], rows[1][:, :, 1:])


def test_what_a_servo_of_a_device_does_without(tmp_path: Path) -> None:
    content = text([0, 0, 1])
    for sets, words in (
        (("servo.stiffness=1",), "surface.stiffness"),
        (("controller.walls=[[1, 2]]",), "controller.walls"),
        (("servo.damping=1e-3",), "surface.damping"),
        (
            ("encoder.kind=absolute", "encoder.counts_per_rev=4096", "encoder.read_hz=1e5"),
            "A and B",
        ),
        (("motors.1.servo.rate_hz=500",), "[servo] is the same for all motors"),
        (("servo.rate_hz=3e3",), "does not divide"),
    ):
        assert words in told(tmp_path, content, *sets, controller="encoder")


def test_a_surface_that_no_motor_reaches_is_refused(tmp_path: Path) -> None:
    content = text([0, 0, 1], kinematics="planar", motors=2)
    assert "surface[0] can't be felt where the run begins" in told(tmp_path, content)
    content = text([1, 0, 0], kinematics="planar", motors=2)
    assert "can't be felt" in told(tmp_path, content, "device.home_rad=[0, 0]")


def test_nine_surfaces_and_one_without_a_device(tmp_path: Path) -> None:
    plane = PLANE.format(normal=[0, 0, 1])
    assert "9 surfaces" in told(tmp_path, text([0, 0, 1], plane * 8))
    assert "[device] is missing" in told(
        tmp_path, f'{HEAD}{plane}[motor]\npreset = "re25-phantom"\n{CONTROL}'
    )


def test_commands_of_one_motor_refuse_a_device(tmp_path: Path) -> None:
    load(tmp_path, text([0, 0, 1]))
    for motor in (None, "motor_0"):
        with pytest.raises(SceneError, match="moves all motors together"):
            load_scene(tmp_path / "arm.toml", motor=motor)


def test_a_run_of_a_motor_with_a_device_compares_with_nothing() -> None:
    """What `measure` takes is a scene of one motor: no shipped device can come there unseen."""
    for name, path in shipped_scenes().items():
        if load_device(path).space is not None:
            with pytest.raises(SceneError):
                measure(load_scene(path), "golden")
            assert name in ("phantom_plane", "planar_disc", "teleoperation", "live_arm")


PORT = PortEstimate(43.8e-3, 7.6, 0.84e-3, 2 * math.pi / 10_000)


def host(shapes: list[Shape]) -> Host:
    arm = linked_arm(PHANTOM, (0.14, 0.14), (8.0,) * 3, (0.0,) * 3)
    count = len(shapes)
    return Host(arm, shapes, [PORT] * 3, 1e-6, [None] * count, [0.0] * count, 0.1)


def test_every_set_of_a_host_is_orthonormal_and_accepted() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        shapes = [
            Shape("plane", np.zeros(3), normal / np.linalg.norm(normal))
            for normal in rng.normal(size=(MOST_SURFACES, 3))
        ]
        update = host(shapes).look(rng.integers(-2000, 2000, 3))
        planes, vectors, most = as_words(update)
        assert accepts(planes, vectors)
        assert most > 0
        found = update.vectors[:, :PORTS]
        for i, j, k in ((0, 1, 2), (2, 5, 7), (1, 3, 6)):
            basis = np.array([found[i], found[pair_row(i, j)], found[triple_row(i, j, k)]])
            for first in range(3):
                for second in range(first):
                    assert abs(basis[first] @ basis[second]) < 1e-12
            # A set's direction is the mixture of the surfaces' that its row says.
            shares = update.vectors[triple_row(i, j, k), MIX : MIX + 3]
            assert shares @ found[[i, j, k]] == pytest.approx(basis[2], abs=1e-9)


def test_two_surfaces_that_are_nearly_one_have_one_vector() -> None:
    row = np.zeros((2, VECTOR_WORDS))
    row[0, 0], row[0, MIX] = 1.0, 1.0
    row[1, 0], row[1, 1] = math.sqrt(1 - 0.09**2), 0.09
    assert not beside(row[:1], row[1]).any()
    row[1, 0], row[1, 1] = math.sqrt(1 - 0.11**2), 0.11
    assert LEAST_ANGLE < 0.11
    assert beside(row[:1], row[1])[:2] == pytest.approx([0.0, 1.0])


def test_the_tables_of_a_device_are_known() -> None:
    assert list(SPACE_TABLES) == ["device", "surface", "coupling", "hand"]
