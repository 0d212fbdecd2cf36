# SPDX-License-Identifier: Apache-2.0
"""A surface with a damper, beside a simulation of its own in floats, and a shape of two planes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from test_tip import CONTROL, HEAD, MOTOR, PLANE, PRESS, REAL, elbow, load, run, text
from test_tip_pins import kept_rows, latency, pressed
from wavehaptics.ladder.joint_run import measure_device
from wavehaptics.trace.tip import Tip, deepest

NORMAL = [0.3, 0.5, 1.0]
STEP_S = 1e-5


def reach(q: np.ndarray) -> np.ndarray:
    """The tip of a PHANTOM of 0.14 m links behind gears of 8:1."""
    first, second, third = q / 8
    out = 0.14 * (math.cos(second) + math.sin(third))
    return np.array([
        out * math.sin(first), 0.14 * (1 - math.cos(third) + math.sin(second)),
        out * math.cos(first) - 0.14,
    ])  # fmt: skip


def levers(q: np.ndarray) -> np.ndarray:
    step = 1e-6
    return np.array([
        (reach(q + step * one) - reach(q - step * one)) / (2 * step) for one in np.eye(3)
    ]).T  # fmt: skip


def simulated(
    stiffness: float, damping: float, spring: float, inertia: float, hand: float, steps: int
) -> np.ndarray:
    """Push of a hand on a surface, N: rotors, a Kelvin-Voigt element and the motors' springs.

    No word, no wave, no controller: ``spring`` in N·m/rad is each motor's, before the element. The
    hand of 500 N/m and ``hand`` N·s/m goes 4 mm in within 50 ms, from where the surface begins.
    """
    normal = np.array(NORMAL) / np.linalg.norm(NORMAL)
    q, omega, given = np.zeros(3), np.zeros(3), 0.0
    push = np.zeros(steps)
    for n in range(steps):
        time = (n + 0.5) * STEP_S
        place, jacobian = reach(q), levers(q)
        across = -normal @ jacobian
        front = float(across @ across) / spring
        depth = float(-normal @ place)
        if depth > 0:
            behind = 1 / (1 / stiffness - front)
            rest = depth / (1 + front * behind)
            given = rest + (given - rest) * math.exp(-STEP_S * (behind + 1 / front) / damping)
            push[n] = (depth - given) / front
        else:
            given = 0.0
        part = min(time / 0.05, 1.0)
        pull = 500 * (-0.004 * part * normal - place)
        pull += hand * (-0.004 / 0.05 * (part < 1) * normal - jacobian @ omega)
        omega += STEP_S / inertia * (jacobian.T @ pull - push[n] * across)
        q = q + STEP_S * omega
    return push


def difference(
    folder: Path, controller: str, more: str, stiffness: float, damping: float, *,
    hand: float = 5.0, own: float | None = None,
) -> float:  # fmt: skip
    """RMS of the difference of the push from :func:`simulated`, over its peak.

    ``damping`` in N·s/m is the scene's, and ``own`` that of the simulation if it is another.
    """
    content = text(NORMAL).replace(CONTROL, more + CONTROL)
    content += "anchor_auto = true\n" if more else ""
    device = load(
        folder, content, f"hand.damping_n_s_per_m={hand}", f"surface.0.stiffness={stiffness}",
        f"surface.0.damping={damping}",
    )  # fmt: skip
    assert device.space is not None
    _, tips, simulation = run(device, controller, 0.1)
    _, normal, _ = deepest(device.space, tips[:, Tip.X : Tip.Z + 1])
    push = -np.einsum("ij,ij->i", tips[:, Tip.FORCE_X : Tip.FORCE_Z + 1], normal)
    every = round(STEP_S / simulation.tick_s)
    wanted = simulated(
        stiffness, own or damping, float(simulation.joint_stiffness[0]),
        device.scenes[0].motor.J_kgm2, hand, len(push) // every,
    )  # fmt: skip
    error = push.reshape(-1, every).mean(axis=1) - wanted
    return float(np.sqrt(np.mean(error**2)) / wanted.max())


@pytest.mark.parametrize(("controller", "stiffness", "damping"), [
    ("golden", 1500, 5.0), ("golden", 1500, 0.1), ("golden", 1500, 50.0), ("golden", 6000, 1.0),
    ("golden", 400, 20.0), ("analog", 1500, 5.0), ("analog", 1500, 0.1),
])  # fmt: skip
def test_a_surface_is_the_damper_and_the_spring_as_wished(
    tmp_path: Path, controller: str, stiffness: float, damping: float
) -> None:
    assert difference(tmp_path, controller, "", stiffness, damping) < 2e-3


def test_without_damping_the_motors_resistance_is_the_damper(tmp_path: Path) -> None:
    """B = 1/Σ G_n² R_n/k_T,n² is what the filter makes, and nothing else."""
    across = np.array(NORMAL) / np.linalg.norm(NORMAL) @ levers(np.zeros(3))
    own = 43.8e-3**2 / 7.6 / float(across @ across)
    assert difference(tmp_path, "golden", "", 1500, 0.0, own=own) < 2e-3
    assert difference(tmp_path, "golden", "", 1500, 0.0, own=3 * own) > 5e-3


@pytest.mark.parametrize(("stiffness", "damping", "hand"), [
    (1500, 5.0, 1.0), (5000, 1.0, 1.0), (1500, 0.1, 0.5),
])  # fmt: skip
def test_counts_and_anchors_take_little_of_it(
    tmp_path: Path, stiffness: float, damping: float, hand: float
) -> None:
    """An encoder of 10,000 counts, 11 µm at the tip, tells how deep the spring is."""
    assert difference(tmp_path, "golden", REAL, stiffness, damping, hand=hand) < 0.02


def test_a_damped_surface_on_pins_is_that_of_golden(tmp_path: Path) -> None:
    sets = ("scene.duration_s=0.06", "surface.0.stiffness=1500", "surface.0.damping=5")
    device = pressed(tmp_path, *sets)
    _, pins = kept_rows(device, "pins")
    _, golden = kept_rows(pressed(tmp_path, *sets, latency(device)), "golden")
    force = slice(Tip.FORCE_X, Tip.FORCE_Z + 1)
    largest = np.abs(golden[:, force]).max()
    assert largest > 1.0
    assert np.sqrt(np.mean((pins[:, force] - golden[:, force]) ** 2)) < 0.01 * largest
    soft = pressed(tmp_path, *sets, latency(device), "surface.0.damping=0")
    _, soft_rows = kept_rows(soft, "golden")
    assert np.abs(soft_rows[:, force] - golden[:, force]).max() > 0.05 * largest


def test_the_servo_has_the_damper_too(tmp_path: Path) -> None:
    """A tap on a soft surface gives less back with a damper, as on the wave's surface."""
    content = text(NORMAL).replace('path = "press"', 'path = "taps"\nfrequency_hz = 5')
    sets = ("scene.duration_s=0.2", "surface.0.stiffness=800", "surface.0.point_m=[0, 0, -1e-4]")
    content = content.replace(CONTROL, REAL + CONTROL)
    for controller in ("encoder", "golden"):
        bare, damped = (
            measure_device(load(tmp_path, content, *sets, *more), controller)
            for more in ((), ("surface.0.damping=4",))
        )
        assert damped["contact_energy_ratio"] < bare["contact_energy_ratio"] - 0.15
        assert damped["tip_stiffness_predicted"] == 800


def test_a_face_of_a_box_is_a_plane(tmp_path: Path) -> None:
    """0.1 mm below the tip; a box that is as much smaller lies deeper, and is left alone beside."""
    box = '[[surface]]\nshape = "box"\npoint_m = [0.14, 0.12, 0]\nsize_m = [0.02, 0.0398, 0.1]\n'
    plane = PLANE.format(normal=[0, 1, 0]) + "point_m = [0.14, 0.1399, 0]\n"
    sets = ("scene.duration_s=0.1", "hand.direction=[0, -1, 0]")
    boxed, flat = (run(corner(tmp_path, one, *sets), "golden", 0.1)[0] for one in (box, plane))
    np.testing.assert_array_equal(boxed, flat)
    narrow = corner(tmp_path, box, *sets, "surface.0.size_m=[0.02, 0.03, 0.1]")
    assert not run(narrow, "golden", 0.1)[1][:, Tip.ACTIVE].any()


SIDES = ([0.8, 0.6, 0.0], [-0.6, 0.8, 0.0])


def corner(folder: Path, surfaces: str, *sets: str):
    content = (
        f'{HEAD}[device]\nkinematics = "planar"\nhome_rad = [0.0, 1.5708]\n{surfaces}'
        f"{PRESS.format(direction=[0.1, -1.0, 0.0])}{MOTOR * 2}{REAL}{CONTROL}anchor_auto = true\n"
    )
    return load(folder, content, *sets)


def test_an_edge_is_two_planes(tmp_path: Path) -> None:
    edge = f'[[surface]]\nshape = "edge"\nnormal = {SIDES[0]}\nsecond_normal = {SIDES[1]}\n'
    point = "point_m = [0.14, 0.1395, 0]\n"
    planes = "".join(PLANE.format(normal=normal) + point for normal in SIDES)
    rows = [
        run(corner(tmp_path, surfaces), "golden", 0.1)[0]
        for surfaces in (edge + point, planes)
    ]  # fmt: skip
    np.testing.assert_array_equal(*rows)
    device = corner(tmp_path, edge + point, "surface.0.stiffness=2000", "surface.0.damping=2")
    assert device.space is not None
    assert [one.stiffness for one in device.space.solids] == [2000.0, 2000.0]
    assert [device.space.number(n) for n in (0, 1)] == [0, 0]


@pytest.mark.parametrize("damped", [(0,), (1,), (0, 1)])
def test_a_corner_with_damping_rests_where_its_springs_do(
    tmp_path: Path, damped: tuple[int, ...]
) -> None:
    """Equal motors: where their springs begin, X in rad, and their torques T make K' of a plane.

    A plane without damping is where X is on it, however deep the other is in its spring: within 2.5
    counts. By the hand's direction it was 1.1 to 2.4 off.
    """
    sides = np.array([[1.0, 0.0], [0.0, 1.0]])
    planes = "".join(PLANE.format(normal=[*side.tolist(), 0.0]) for side in sides)
    sets = [f"surface.{n}.{key}" for n in damped for key in ("stiffness=1500", "damping=0.3")]
    device = corner(
        tmp_path, planes, "scene.duration_s=0.3", "hand.direction=[-0.7, -0.7, 0]", *sets
    )
    _, tips, simulation = run(device, "golden", 0.3)
    rest = tips[-50_000:]
    assert (rest[:, Tip.ACTIVE] == 2).all()
    force = rest[:, Tip.FORCE_X : Tip.FORCE_Y + 1]
    assert force.std(axis=0).max() < 0.01 * np.linalg.norm(force.mean(axis=0))
    moved = rest[:, Tip.X : Tip.Y + 1].mean(axis=0)
    q = np.zeros(2)
    for _ in range(20):
        jacobian = np.array([(elbow(q + d) - elbow(q - d)) / 2e-6 for d in 1e-6 * np.eye(2)]).T
        q += np.linalg.solve(jacobian, moved - elbow(q))
    spring, count = float(simulation.joint_stiffness[0]), 2 * math.pi / 10_000
    torque = jacobian.T @ force.mean(axis=0)
    begin = q + torque / spring
    across = -sides @ jacobian
    lengths = np.linalg.norm(across, axis=1)
    first, second = across / lengths[:, None]
    ways = [first, second - first * (first @ second)]
    ways[1] /= np.linalg.norm(ways[1])
    for n, way in enumerate(ways):
        if n not in damped:
            assert abs(begin @ across[n]) < 2.5 * count * lengths[n]
        elif damped != (0, 1) or n == 0:  # two springs of unlike motions mix in the second way
            behind = lengths[n] ** 2 / (1 / 1500 - lengths[n] ** 2 / spring)
            assert begin @ way > 10 * count
            near = 1.2 * count * lengths[n] / (across[n] @ way)
            assert -torque @ way == pytest.approx(behind * (begin @ way), abs=behind * near)
