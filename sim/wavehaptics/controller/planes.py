# SPDX-License-Identifier: Apache-2.0
"""The host of a device: planes of its surfaces about the place where the encoders are.

At the tip a surface is ``φ(p) ≥ 0`` with the inward normal n. About the counts X of its look the
host makes of it ``G·x ≥ d`` with ``G = S⁻¹ Jᵀn`` per count and S such that ``|G| = 1``; in the
waves ``g_n ∝ (Jᵀn)_n/√B_n``, ``B_n = k̂_T²/R̂``. A softer surface has a filter along g of the delay

    τ_s = 2 (1/K − Σ G_n² L_eff,n/k̂_T²) / Σ G_n² R̂_n/k̂_T².

That spring has the damper ``B = 1/Σ G_n² R̂_n/k̂_T²`` beside it. With another damper b the surface
has no filter, but an η of its own, and its wall velocity is its spring. By the waves along g a
surface that gives way by ε under the push F has

    F = ((1 − η) dε/dt + 2 ε/τ_w) B/(1 + η),

so that ``η = (B − b)/(B + b)`` and ``τ_w = (1 + b/B) B/K'``, with K' beside b and the motors'
springs before both.

It knows a motor by its estimates alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from wavehaptics.controller import surfaces
from wavehaptics.laws.kinematics import Arm
from wavehaptics.laws.shapes import Shape
from wavehaptics.words import formats
from wavehaptics.words.table import WORDS

WALL_S = 2e-3
"""Time constant with which a surface that isn't where it should be goes there, s."""

LEAST_LEVER = 0.05
"""A normal along which the tip's lever is less than this part of the arm's is one in which no motor
moves it: there is no surface then."""

LEAST_ANGLE = 0.1
"""Sine of the angle, in wave space, below which two surfaces are one."""

_SHORT = 1.0 - 2.0**-24
"""Length of a vector that is written, so that no rounding makes it longer than 1."""


class PortEstimate(NamedTuple):
    """What the host knows of a motor and its port, SI units."""

    k_t_hat: float
    r_hat: float
    l_eff: float
    """L̂ with what the port's delay adds, H."""
    cell_rad: float
    delay_s: float = 0.0
    """The port's delay τ, s."""


class Planes(NamedTuple):
    """What one update has, real numbers in the places of :mod:`~wavehaptics.controller.surfaces`;
    ``d`` in counts and waves in √W."""

    planes: np.ndarray
    vectors: np.ndarray
    velocity_max: float
    singular: list[int]
    """Surfaces that no motor moves the tip into."""


class Host:
    """Linearises ``shapes`` for ``ports`` of period ``tick_s``.

    ``stiffness`` in N/m, or None for the largest, ``loss`` and ``damping`` in N·s/m, 0 for that of
    the filter, are of each shape; ``speed`` in m/s is the most with which a surface moves. A
    surface with damping moves as fast as its spring has to.
    """

    def __init__(
        self, arm: Arm, shapes: Sequence[Shape], ports: Sequence[PortEstimate], tick_s: float,
        stiffness: Sequence[float | None], loss: Sequence[float], speed: float,
        damping: Sequence[float] = (),
    ) -> None:  # fmt: skip
        self._damping = damping or (0.0,) * len(shapes)
        self._arm, self._shapes, self._ports, self._tick_s = arm, shapes, ports, tick_s
        self._stiffness, self._loss, self._speed = stiffness, loss, speed
        self._cell = np.array([port.cell_rad for port in ports])
        k_t = np.array([port.k_t_hat for port in ports])
        self._damping_inverse = np.array([port.r_hat for port in ports]) / k_t**2
        self._compliance = np.array([port.l_eff for port in ports]) / k_t**2
        self._k_t = k_t

    def look(self, counts: np.ndarray, middle: float = 0.5) -> Planes:
        """Planes about ``counts`` (motors,), of which ``middle`` is added for the angle."""
        q = (np.asarray(counts) + middle) * self._cell
        place, jacobian = self._arm.tip(q)[None, :], self._arm.jacobian(q)
        lever = float(np.linalg.norm(jacobian))
        planes = np.zeros((surfaces.MOST_SURFACES, surfaces.PLANE_WORDS))
        vectors = np.zeros((surfaces.VECTORS, surfaces.VECTOR_WORDS))
        motors, velocity_max = len(self._ports), math.inf
        present: list[int] = []
        singular: list[int] = []
        for n, shape in enumerate(self._shapes):
            depth, normal = shape.depth(place)
            along = jacobian.T @ normal[0]
            if np.linalg.norm(along) < LEAST_LEVER * lever:
                singular.append(n)
                continue
            present.append(n)
            scale = float(np.linalg.norm(along * self._cell))
            drag = float(along**2 @ self._damping_inverse)
            tau, eta, wall_s = self._filter(n, along, drag)
            plane = planes[n]
            plane[surfaces.PRESENT] = 1.0
            plane[surfaces.G : surfaces.G + motors] = along * self._cell / scale
            plane[surfaces.D] = plane[surfaces.G : surfaces.G + motors] @ counts - depth[0] / scale
            bend = self._compliance + 0.5 * tau * self._damping_inverse
            plane[surfaces.C : surfaces.C + motors] = along * bend * self._k_t / scale
            plane[surfaces.GAIN] = 2.0 * scale / (wall_s * math.sqrt(2.0 * drag))
            plane[surfaces.A] = self._tick_s / (self._tick_s + tau)
            plane[surfaces.ETA] = eta
            plane[surfaces.ACROSS] = 1.0 - self._loss[n]
            waves = along * np.sqrt(self._damping_inverse)
            vectors[n, :motors] = waves / np.linalg.norm(waves)
            vectors[n, surfaces.MIX] = 1.0
            velocity_max = min(velocity_max, 2.0 * self._speed / math.sqrt(2.0 * drag))
        if any(self._damping[n] for n in present):
            velocity_max = formats.WAVE.largest
        for first, second in combinations(present, 2):
            vectors[surfaces.pair_row(first, second)] = beside(vectors[[first]], vectors[second])
        for first, second, third in combinations(present, 3):
            pair = vectors[[first, surfaces.pair_row(first, second)]]
            vectors[surfaces.triple_row(first, second, third)] = beside(pair, vectors[third])
        self._part_velocities(present, vectors)
        return Planes(planes, vectors, velocity_max if present else 0.0, singular)

    @property
    def delay_s(self) -> float:
        """The least ``b/K'`` of a surface with damping, s: the ports' delay takes K'·τ/2 of b."""
        return max(self._tick_s, *(port.delay_s for port in self._ports))

    def stiffest(self, number: int, counts: np.ndarray) -> float:
        """The largest K along a shape's normal at ``counts`` (motors,), N/m."""
        q = np.asarray(counts) * self._cell
        normal = self._shapes[number].depth(self._arm.tip(q)[None, :])[1][0]
        return 1.0 / float((self._arm.jacobian(q).T @ normal) ** 2 @ self._compliance)

    def _filter(self, number: int, along: np.ndarray, drag: float) -> tuple[float, float, float]:
        """τ_s of a surface in s, 0 where nothing stiffer can be had, its η, and τ_w in s."""
        wanted, damping = self._stiffness[number], self._damping[number]
        if wanted is None:
            return 0.0, -1.0, WALL_S
        softer = max(1.0 / wanted - float(along**2 @ self._compliance), 0.0)
        if not damping:
            return 2.0 * softer / drag, -1.0, WALL_S
        if damping * softer < self.delay_s:
            return 0.0, -1.0, WALL_S
        part = damping * drag
        return 0.0, (1.0 - part) / (1.0 + part), (1.0 + part) * softer / drag

    def _part_velocities(self, present: Sequence[int], vectors: np.ndarray) -> None:
        """One that rests deep in its own spring doesn't move a surface that has none."""
        for count in (2, 3):
            for numbers in combinations(present, count):
                for share, n in enumerate(numbers[:-1]):
                    if self._damping[n] and not self._damping[numbers[-1]]:
                        vectors[_vector_row(numbers), surfaces.MIX + share] = 0.0


def beside(before: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Row of a surface's vector, orthogonal to the rows ``before``, with its shares of velocity.

    ``before`` float64 (rows, VECTOR_WORDS), of which each is orthogonal to the others; ``row``
    (VECTOR_WORDS,). All zero where there is no further direction: the surface is one of those.
    """
    place, count = slice(surfaces.PORTS), len(before)
    result = np.zeros(surfaces.VECTOR_WORDS)
    result[place] = row[place]
    result[surfaces.MIX + count] = 1.0
    for other in before:
        common = float(row[place] @ other[place])
        result -= common * other
    length = float(np.linalg.norm(result[place]))
    return result / length if length >= LEAST_ANGLE else np.zeros_like(result)


def as_words(update: Planes) -> tuple[np.ndarray, np.ndarray, int]:
    """The words of an update: planes, vectors and the largest ξ.

    A value beyond its word is the word's end.
    """
    planes = surfaces.new_planes()
    ports = surfaces.PORTS
    for places, format_ in (
        (slice(surfaces.G, surfaces.G + ports), formats.SURFACE),
        (surfaces.D, formats.DISTANCE),
        (slice(surfaces.C, surfaces.C + ports), formats.CELLS),
        (surfaces.GAIN, formats.SURFACE),
        (surfaces.A, formats.A),
        (surfaces.ETA, formats.ETA),
        (surfaces.ACROSS, formats.ETA),
    ):
        planes[:, places] = _raw(update.planes[:, places], format_)
    planes[:, surfaces.PRESENT] = update.planes[:, surfaces.PRESENT] != 0.0
    vectors = surfaces.new_vectors()
    vectors[:, :ports] = np.trunc(update.vectors[:, :ports] * (_SHORT / formats.SURFACE.step))
    vectors[:, surfaces.MIX :] = _raw(update.vectors[:, surfaces.MIX :], formats.MIX)
    most = min(round(update.velocity_max / formats.WAVE.step), formats.WAVE.raw_max)
    return planes, vectors, most


PLANE_ROW = 96
"""First row of the surfaces in the registers of a group (``rtl/wh_surface_words.v``), two each."""

VELOCITY_MAX = (112, 0)
"""Row and word of the largest ξ."""

_BEND_UP = formats.SURFACE.fraction - (
    formats.CELLS.fraction + formats.CURRENT.fraction - formats.SEEN.fraction
)
_MIX_UP = formats.SURFACE.fraction - formats.MIX.fraction
_GAIN_UP = 5
_FRACTION = formats.DISTANCE.fraction


def as_registers(
    planes: np.ndarray, vectors: np.ndarray, most: int, count: int = surfaces.MOST_SURFACES
) -> list[tuple[int, int]]:
    """A frame of the registers: (address, word of 32 bits with a sign), in the order of writing.

    ``planes``, ``vectors`` and ``most`` are those of :func:`as_words`. A frame has the words of
    the first ``count`` surfaces that are there, and the vectors of their sets of up to three.
    """
    written: list[tuple[int, int]] = []

    def put(row: int, first: int, words: np.ndarray | list[int]) -> None:
        written.extend((8 * row + first + n, int(word)) for n, word in enumerate(words))

    def put_vector(row: int) -> None:
        put(row, 0, vectors[row, : surfaces.MIX])
        put(row, surfaces.MIX, vectors[row, surfaces.MIX :] << _MIX_UP)

    present = [n for n in range(count) if planes[n, surfaces.PRESENT]]
    put(*VELOCITY_MAX, [most])
    for n in present:
        plane, row = planes[n], PLANE_ROW + 2 * n
        whole, part = divmod(int(plane[surfaces.D]), 1 << _FRACTION)
        put(row, 0, [whole, 1 << _FRACTION | part])
        put(row, 2, plane[surfaces.G : surfaces.D])
        put(row, 5, plane[surfaces.C : surfaces.GAIN] << _BEND_UP)
        put(row + 1, 0, [plane[surfaces.GAIN] << _GAIN_UP])
        put(row + 1, 1, plane[[surfaces.A, surfaces.ETA, surfaces.ACROSS]])
        put_vector(n)
    for pair in combinations(present, 2):
        put_vector(surfaces.pair_row(*pair))
    for triple in combinations(present, 3):
        put_vector(surfaces.triple_row(*triple))
    return written


def as_writes(registers: Sequence[tuple[int, int]], stamp: int) -> list[tuple[int, list[int]]]:
    """Writes of a frame over a device's bus: (address of the first register, raw words) of each.

    ``registers`` are those of :func:`as_registers`. The words go in runs of successive addresses,
    with a head each, and the last write ends with the commit of ``stamp``
    (``rtl/wh_surface_frame.v``). A write is one frame of Modbus.
    """
    runs: list[tuple[int, list[int]]] = []
    for address, word in registers:
        if runs and address == runs[-1][0] + len(runs[-1][1]):
            runs[-1][1].append(word)
        else:
            runs.append((address, [word]))
    window, commit = WORDS["surface_word"].row.count, WORDS["surface_commit"].at()
    writes: list[list[int]] = [[]]
    begins = _BEGINS
    for first, words in runs:
        while words:
            if len(writes[-1]) + 2 > window:
                writes.append([])
            some = words[: window - 1 - len(writes[-1])]
            writes[-1] += [begins | len(some) << _RUN | first, *some]
            first, words, begins = first + len(some), words[len(some) :], 0
    made = [(commit - len(words), [raw & 0xFFFFFFFF for raw in words]) for words in writes]
    made[-1][1].append(stamp)
    return made


def refused_place(refused: int) -> str:
    """What of a frame a device has refused, by its register ``surfaces_refused``; "": nothing."""
    row = refused & 0x7F
    if not refused:
        return ""
    if row < surfaces.VECTORS:
        numbers = next(
            numbers
            for count in (1, 2, 3)
            for numbers in combinations(range(surfaces.MOST_SURFACES), count)
            if _vector_row(numbers) == row
        )
        *others, last = map(str, numbers)
        beside = f" beside {' and '.join(others)}" if others else ""
        return f"the vector of surface {last}{beside}: it is longer than 1, or not whole"
    if row < VELOCITY_MAX[0]:
        return f"the plane of surface {(row - PLANE_ROW) // 2}: a value is out of its range"
    if row == VELOCITY_MAX[0]:
        return "the largest velocity: it is below 0"
    return NOT_WHOLE


def _vector_row(numbers: Sequence[int]) -> int:
    if len(numbers) == 1:
        return numbers[0]
    return surfaces.pair_row(*numbers) if len(numbers) == 2 else surfaces.triple_row(*numbers)


NOT_WHOLE = "the frame: it did not begin, or not all of it came"

_BEGINS = 1 << 31
_RUN = 10
"""Of a run's head: that a frame begins, and the lowest bit of its length."""


def _raw(values: np.ndarray, format_: formats.Fixed) -> np.ndarray:
    return np.clip(np.round(values / format_.step), format_.raw_min, format_.raw_max)
