# SPDX-License-Identifier: Apache-2.0
"""Arms: the tip is where trigonometry puts it, and the Jacobian is its derivative."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wavehaptics.laws.kinematics import (
    PHANTOM,
    PLANAR,
    Arm,
    linked_arm,
    matrix_arm,
    put_compliance,
    put_tip_force,
)
from wavehaptics.laws.shapes import Shape

ARMS = {
    "planar": linked_arm(PLANAR, (0.14, 0.1), (8.0, 7.0), (0.3, 1.2)),
    "phantom": linked_arm(PHANTOM, (0.14, 0.13), (8.0, 8.5, 7.5), (0.1, -0.2, 0.3)),
    "matrix": matrix_arm([[0.01, 0.0, 0.003], [0.002, 0.02, 0.0], [0.0, 0.005, 0.015]]),
}


@pytest.mark.parametrize("name", ARMS)
def test_the_jacobian_is_the_derivative_of_the_tip(name: str) -> None:
    arm = ARMS[name]
    rng = np.random.default_rng(1)
    step = 1e-5
    for q in rng.uniform(-6.0, 6.0, (50, arm.motors)):
        slopes = [
            (arm.tip(q + step * unit) - arm.tip(q - step * unit)) / (2.0 * step)
            for unit in np.eye(arm.motors)
        ]
        assert np.abs(arm.jacobian(q) - np.array(slopes).T).max() < 1e-10


def test_planar_is_two_links() -> None:
    arm = linked_arm(PLANAR, (0.14, 0.1), (1.0, 1.0), (0.0, 0.0))
    assert arm.tip([math.pi / 2, -math.pi / 2]) == pytest.approx([0.1, 0.14, 0.0])


def test_the_phantom_begins_at_0_with_equal_levers() -> None:
    """8:1 and 0.14 m in every direction, so that the paper's 7500 N/m are there at any angle."""
    arm = linked_arm(PHANTOM, (0.14, 0.14), (8.0,) * 3, (0.0,) * 3)
    assert arm.tip(np.zeros(3)) == pytest.approx(np.zeros(3), abs=1e-15)
    assert arm.jacobian(np.zeros(3)) == pytest.approx(np.eye(3) * 0.14 / 8.0, abs=1e-15)
    k_l = 43.8e-3**2 / 0.83e-3
    assert k_l / (0.14 / 8.0) ** 2 == pytest.approx(7500.0, rel=0.01)


@pytest.mark.parametrize("name", ARMS)
def test_a_force_is_found_from_its_torques(name: str) -> None:
    arm = ARMS[name]
    rng = np.random.default_rng(2)
    for q in rng.uniform(-3.0, 3.0, (20, arm.motors)):
        jacobian = arm.jacobian(q)
        force = jacobian @ rng.normal(size=arm.motors)
        found = np.zeros(3)
        put_tip_force(jacobian, jacobian.T @ force, found)
        assert found == pytest.approx(force, rel=1e-6, abs=1e-9)


def test_one_motor_and_a_singular_arm() -> None:
    found = np.zeros(3)
    put_tip_force(np.array([[0.02], [0.0], [0.0]]), np.array([0.1]), found)
    assert found == pytest.approx([5.0, 0.0, 0.0])
    straight = linked_arm(PLANAR, (0.14, 0.14), (8.0, 8.0), (0.0, 0.0))
    put_tip_force(straight.jacobian(np.zeros(2)), np.array([0.1, 0.1]), found)
    assert found == pytest.approx(np.zeros(3))


def test_compliance_along_a_normal() -> None:
    arm: Arm = ARMS["phantom"]
    rng = np.random.default_rng(3)
    angles, normals = rng.normal(size=(5, 3)), rng.normal(size=(5, 3))
    joint, out = np.array([0.4, 0.5, 0.6]), np.zeros(5)
    put_compliance(arm.geometry, angles, normals, joint, np.zeros((3, 3)), out)
    for n in range(5):
        along = arm.jacobian(angles[n]).T @ normals[n]
        assert out[n] == pytest.approx(np.sum(along**2 * joint))


SHAPES = {
    "plane": Shape("plane", np.array([0.01, 0.0, 0.0]), np.array([0.6, 0.8, 0.0])),
    "sphere": Shape("sphere", np.array([0.0, 0.01, 0.02]), np.zeros(3), radius=0.03),
    "box": Shape("box", np.zeros(3), np.zeros(3), size=np.array([0.04, 0.06, 0.08])),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_normal_is_the_gradient_of_the_depth(name: str) -> None:
    shape, step = SHAPES[name], 1e-7
    points = np.random.default_rng(4).uniform(-0.05, 0.05, (200, 3))
    depth, normal = shape.depth(points)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(len(points)))
    assert (depth > 0).any()
    assert (depth < 0).any()
    for axis in range(3):
        there = points + step * np.eye(3)[axis]
        slope = (shape.depth(there)[0] - depth) / step
        assert slope == pytest.approx(normal[:, axis], abs=1e-4)
