# SPDX-License-Identifier: Apache-2.0
"""From the motors of a device to its tip: position and Jacobian of three kinds of arm.

A motor's angle q_n is 0 where the run begins. Behind its gear stands the arm's angle
``θ_n = home_n + q_n/ratio_n``. Lengths are in m and angles in rad; x, y and z are the tip's.

``planar``: two links in the plane z = 0, the second angle counted from the first link,

    x = l₁ cos θ₁ + l₂ cos(θ₁ + θ₂),   y = l₁ sin θ₁ + l₂ sin(θ₁ + θ₂).

``phantom``: three axes of a PHANTOM. Both links are driven from the base by a parallelogram, so
that θ₃ is counted from the vertical whatever θ₂ is,

    x = (l₁ cos θ₂ + l₂ sin θ₃) sin θ₁,   y = l₂ − l₂ cos θ₃ + l₁ sin θ₂,
    z = (l₁ cos θ₂ + l₂ sin θ₃) cos θ₁ − l₁,

as in Çavuşoğlu, Feygin and Tendick, *A Critical Study of the Mechanical and Electrical Properties
of the PHANToM Haptic Interface and Improvements for High-Performance Control*, Presence 11(6),
2002. The PHANTOM 1.0 has two links of 0.14 m and ratios of about 8:1 (Niemeyer, Diolaiti and
Tanner, *Wave Haptics*, section II: 8:1 and 14 cm). A course's figures for a Premium 1.0 are 140 mm
each, and drums of 115, 70 and 70 mm on capstans of 15, 10 and 10 mm, which is 7.67:1, 7:1 and 7:1
(K. J. Kuchenbecker, MEAM 520, University of Pennsylvania, homework 8).

``matrix``: a constant Jacobian, ``tip = J q``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wavehaptics.runtime.compiled import compiled

PLANAR, PHANTOM, MATRIX = range(3)
"""Kinds of arm, the first place of a geometry."""

_KIND, _L1, _L2, _RATIO, _HOME = 0, 1, 2, 3, 6
_MATRIX = 1
_SIZE = 10


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm of ``motors`` motors; ``geometry`` float64 (10,) is what the functions below take."""

    motors: int
    geometry: np.ndarray

    def tip(self, q: Sequence[float] | np.ndarray) -> np.ndarray:
        """Place of the tip at the motors' angles ``q`` (motors,) in rad: float64 (3,), m."""
        out = np.zeros(3)
        put_tip(self.geometry, np.asarray(q, dtype=float), out)
        return out

    def elbow(self, q: Sequence[float] | np.ndarray) -> np.ndarray:
        """End of the first link of a PLANAR arm at ``q``: float64 (2,), m."""
        angle = self.geometry[_HOME] + q[0] / self.geometry[_RATIO]
        place: np.ndarray = self.geometry[_L1] * np.array([math.cos(angle), math.sin(angle)])
        return place

    def jacobian(self, q: Sequence[float] | np.ndarray) -> np.ndarray:
        """J of ``dp = J dq`` at ``q`` (motors,): float64 (3, motors), m/rad of the motors."""
        out = np.zeros((3, self.motors))
        put_jacobian(self.geometry, np.asarray(q, dtype=float), out)
        return out


def linked_arm(
    kind: int, links_m: Sequence[float], ratio: Sequence[float], home_rad: Sequence[float]
) -> Arm:
    """A PLANAR arm of two motors or a PHANTOM of three: links (2,), ratios and home (motors,)."""
    geometry = np.zeros(_SIZE)
    geometry[_KIND] = kind
    geometry[_L1], geometry[_L2] = links_m
    geometry[_RATIO : _RATIO + len(ratio)] = ratio
    geometry[_HOME : _HOME + len(home_rad)] = home_rad
    return Arm(2 if kind == PLANAR else 3, geometry)


def matrix_arm(jacobian: Sequence[Sequence[float]]) -> Arm:
    """An arm whose Jacobian is the constant ``jacobian`` (3, motors), m/rad."""
    rows = np.asarray(jacobian, dtype=float)
    geometry = np.zeros(_SIZE)
    geometry[_KIND] = MATRIX
    geometry[_MATRIX : _MATRIX + rows.size] = rows.ravel()
    return Arm(rows.shape[1], geometry)


@compiled(inline="always")
def _angle(geometry: np.ndarray, q: np.ndarray, n: int) -> float:
    angle: float = geometry[_HOME + n] + q[n] / geometry[_RATIO + n]
    return angle


@compiled()
def put_tip(geometry: np.ndarray, q: np.ndarray, out: np.ndarray) -> None:
    """Place of the tip into ``out`` float64 (3,), m; ``q`` float64 (motors,), rad."""
    if geometry[_KIND] == MATRIX:
        for row in range(3):
            out[row] = 0.0
            for n in range(q.shape[0]):
                out[row] += geometry[_MATRIX + row * q.shape[0] + n] * q[n]
        return
    l1, l2 = geometry[_L1], geometry[_L2]
    first, second = _angle(geometry, q, 0), _angle(geometry, q, 1)
    if geometry[_KIND] == PLANAR:
        out[0] = l1 * math.cos(first) + l2 * math.cos(first + second)
        out[1] = l1 * math.sin(first) + l2 * math.sin(first + second)
        out[2] = 0.0
        return
    third = _angle(geometry, q, 2)
    out_of_base = l1 * math.cos(second) + l2 * math.sin(third)
    out[0] = out_of_base * math.sin(first)
    out[1] = l2 - l2 * math.cos(third) + l1 * math.sin(second)
    out[2] = out_of_base * math.cos(first) - l1


@compiled()
def put_jacobian(geometry: np.ndarray, q: np.ndarray, out: np.ndarray) -> None:
    """J of ``dp = J dq`` into ``out`` float64 (3, motors), m/rad of the motors."""
    if geometry[_KIND] == MATRIX:
        for row in range(3):
            for n in range(q.shape[0]):
                out[row, n] = geometry[_MATRIX + row * q.shape[0] + n]
        return
    l1, l2 = geometry[_L1], geometry[_L2]
    first, second = _angle(geometry, q, 0), _angle(geometry, q, 1)
    if geometry[_KIND] == PLANAR:
        x2, y2 = l2 * math.cos(first + second), l2 * math.sin(first + second)
        out[0, 0], out[0, 1] = -l1 * math.sin(first) - y2, -y2
        out[1, 0], out[1, 1] = l1 * math.cos(first) + x2, x2
        out[2, 0], out[2, 1] = 0.0, 0.0
    else:
        third = _angle(geometry, q, 2)
        out_of_base = l1 * math.cos(second) + l2 * math.sin(third)
        by_second, by_third = -l1 * math.sin(second), l2 * math.cos(third)
        out[0, 0] = out_of_base * math.cos(first)
        out[0, 1], out[0, 2] = by_second * math.sin(first), by_third * math.sin(first)
        out[1, 0] = 0.0
        out[1, 1], out[1, 2] = l1 * math.cos(second), l2 * math.sin(third)
        out[2, 0] = -out_of_base * math.sin(first)
        out[2, 1], out[2, 2] = by_second * math.cos(first), by_third * math.cos(first)
    for row in range(3):
        for n in range(q.shape[0]):
            out[row, n] /= geometry[_RATIO + n]


@compiled()
def put_tip_force(jacobian: np.ndarray, torque: np.ndarray, out: np.ndarray) -> None:
    """The least force at the tip that ``torque`` (motors,) in N·m is, ``F = J (JᵀJ)⁻¹ τ``, N.

    Into ``out`` float64 (3,). It is 0 at a singularity, where no force is these torques.
    """
    a00, a01, a02, a11, a12, a22 = 0.0, 0.0, 0.0, 1.0, 0.0, 1.0
    motors = torque.shape[0]
    for row in range(3):
        a00 += jacobian[row, 0] * jacobian[row, 0]
    t0, t1, t2 = torque[0], 0.0, 0.0
    if motors > 1:
        t1, a11 = torque[1], 0.0
        for row in range(3):
            a01 += jacobian[row, 0] * jacobian[row, 1]
            a11 += jacobian[row, 1] * jacobian[row, 1]
    if motors > 2:
        t2, a22 = torque[2], 0.0
        for row in range(3):
            a02 += jacobian[row, 0] * jacobian[row, 2]
            a12 += jacobian[row, 1] * jacobian[row, 2]
            a22 += jacobian[row, 2] * jacobian[row, 2]
    c00, c01, c02 = a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11
    whole = a00 * c00 + a01 * c01 + a02 * c02
    for row in range(3):
        out[row] = 0.0
    if whole <= 1e-12 * a00 * a11 * a22:
        return
    c11, c12, c22 = a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01
    by0 = (c00 * t0 + c01 * t1 + c02 * t2) / whole
    by1 = (c01 * t0 + c11 * t1 + c12 * t2) / whole
    by2 = (c02 * t0 + c12 * t1 + c22 * t2) / whole
    for row in range(3):
        out[row] = jacobian[row, 0] * by0
        if motors > 1:
            out[row] += jacobian[row, 1] * by1
        if motors > 2:
            out[row] += jacobian[row, 2] * by2


@compiled()
def put_compliance(
    geometry: np.ndarray, angles: np.ndarray, normals: np.ndarray, joint_compliance: np.ndarray,
    jacobian: np.ndarray, out: np.ndarray,
) -> None:  # fmt: skip
    """``Σ G_n²/K_n`` with ``G = Jᵀn`` at each of some places into ``out`` (places,), m/N.

    ``angles`` float64 (places, motors) in rad, ``normals`` (places, 3), ``joint_compliance``
    (motors,) 1/K_n in rad/(N·m); ``jacobian`` (3, motors) is room for one.
    """
    for place in range(angles.shape[0]):
        put_jacobian(geometry, angles[place], jacobian)
        out[place] = 0.0
        for n in range(angles.shape[1]):
            along = 0.0
            for row in range(3):
                along += jacobian[row, n] * normals[place, row]
            out[place] += along * along * joint_compliance[n]
