# SPDX-License-Identifier: Apache-2.0
"""Records of a motor, and least squares over them.

A record's rows are means over equal blocks of time, so that an equation of motion is looked at as
it is integrated: ``∫v dt = R ∫i dt + L i + k_T x + ...`` up to the end of each block, with a
constant of its own for each record. So nothing is differentiated, and the steps of encoder and
converter are noise that doesn't add up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Estimate:
    """A value and its standard deviation, in one unit."""

    value: float
    sd: float

    def widened(self, error: float) -> Estimate:
        """With another error, that goes its own way."""
        return Estimate(self.value, math.hypot(self.sd, error))


@dataclass(frozen=True)
class Segment:
    """A record in which the host changed nothing: rows of ``step_s``.

    ``voltage`` in V and ``current`` in A are means over the rows, ``position`` in rad is that at
    their ends; ``wanted`` is the current or voltage, by its sign, that was asked for.
    """

    step_s: float
    voltage: np.ndarray
    current: np.ndarray
    position: np.ndarray
    wanted: float

    def __len__(self) -> int:
        return len(self.voltage) - 1

    @property
    def t(self) -> np.ndarray:
        """Ends of the rows but for the last, s."""
        return self.step_s * np.arange(1, len(self) + 1)

    def sum(self, values: np.ndarray) -> np.ndarray:
        """∫ of the rows' means up to :attr:`t`."""
        return self.step_s * np.cumsum(values[: len(self)])

    @property
    def ends(self) -> np.ndarray:
        """Current at :attr:`t`, A: between two means."""
        ends: np.ndarray = 0.5 * (self.current[:-1] + self.current[1:])
        return ends

    @property
    def turned(self) -> np.ndarray:
        """Position at :attr:`t`, rad."""
        return self.position[: len(self)]

    @property
    def angle(self) -> np.ndarray:
        """Position in the rows' middles, rad."""
        first = self.position[:1] - (self.position[1:2] - self.position[:1])
        angle: np.ndarray = 0.5 * (self.position + np.concatenate([first, self.position[:-1]]))
        return angle

    @property
    def speed(self) -> np.ndarray:
        """Speed in the rows, rad/s, over as many as have some cells between them."""
        span = max(1, min(len(self.position) // 8, 16))
        before = 2 * self.position[:1] - self.position[1:2]
        ends = np.concatenate([before, self.position])
        last = len(self.position)
        low = np.clip(np.arange(last) - span + 1, 0, last)
        high = np.clip(np.arange(last) + span, 0, last)
        speed: np.ndarray = (ends[high] - ends[low]) / ((high - low) * self.step_s)
        return speed

    def part(self, first: int, last: int) -> Segment:
        """Rows of it."""
        rows = slice(first, last)
        return Segment(
            self.step_s, self.voltage[rows], self.current[rows], self.position[rows], self.wanted
        )


def earlier(values: np.ndarray, rows: float) -> np.ndarray:
    """Rows' values as they were so much earlier, on straight lines between them and beyond."""
    beyond = math.ceil(abs(rows))
    long = np.pad(values.astype(float), beyond, "reflect", reflect_type="odd")
    at = np.arange(beyond, beyond + len(values)) - rows
    found: np.ndarray = np.interp(at, np.arange(len(long)), long)
    return found


@dataclass(frozen=True)
class Fit:
    """Least squares of several records: the columns' factors, and their covariance.

    The spread is taken from record to record: what is left within one is not independent.
    """

    factors: np.ndarray
    covariance: np.ndarray
    square: float
    """What is left of the sum of squares."""
    rows: int

    def estimate(self, column: int, scale: float = 1.0) -> Estimate:
        """Of one column, ``scale`` times."""
        value = float(self.factors[column])
        return Estimate(
            float(scale * value), float(abs(scale) * np.sqrt(self.covariance[column, column]))
        )


Columns = Sequence[np.ndarray]


def fit(wanted: Columns, columns: Sequence[Columns], free: Columns | None = None) -> Fit:
    """Factors of ``columns`` that make the ``wanted`` of each record, with a constant each.

    ``columns`` holds for each record its columns; ``free`` may hold one more for each record,
    whose factor is the record's own.
    """
    goals, tables = freed(wanted, columns, free)
    goal, matrix = np.concatenate(goals), np.concatenate(tables)
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    factors, *_ = np.linalg.lstsq(matrix / scale, goal, rcond=1e-12)
    inverse = np.linalg.pinv((matrix / scale).T @ (matrix / scale), rcond=1e-12)
    left = goal - matrix / scale @ factors
    spread = np.zeros_like(inverse)
    first = 0
    for table in tables:
        part = (table / scale).T @ left[first : first + len(table)]
        spread += np.outer(part, part)
        first += len(table)
    count = len(tables)
    spread *= count / max(1, count - 1)
    covariance = inverse @ spread @ inverse / np.outer(scale, scale)
    return Fit(factors / scale, covariance, float(left @ left), len(goal))


def freed(
    wanted: Columns, columns: Sequence[Columns], free: Columns | None
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Goals and tables of the records without what is each record's own."""
    goals, tables = [], []
    for n, (goal, table) in enumerate(zip(wanted, columns, strict=True)):
        own = [np.ones_like(goal)] + ([] if free is None else [free[n]])
        basis, _ = np.linalg.qr(np.stack(own, axis=1))
        matrix = np.stack(list(table), axis=1)
        goals.append(goal - basis @ (basis.T @ goal))
        tables.append(matrix - basis @ (basis.T @ matrix))
    return goals, tables


MOST_HARMONIC = 60
"""Largest number of periods a revolution that is looked for."""

LEAST_HARMONIC = 3
"""Fewer periods than bars or teeth have: slower than that it is something else."""

CLEARLY = 0.5
"""Part of the squares that a harmonic has to take away, to be one."""

FALSELY = 1e-3
"""How often noise alone may be taken for a harmonic, of all periods that are tried together."""

SPREADS = 4.0
"""Spreads that a harmonic's size has to be above zero."""


FEWEST_RECORDS = 4
"""Of which a spread can be told."""


@dataclass(frozen=True)
class Harmonic:
    """The best harmonic of the angle, with ``periods`` a revolution; 0 where there is none.

    ``size`` is in the unit of the columns' factors. ``fit`` is with its two columns behind the
    others, or without, where there is none.
    """

    periods: int
    size: Estimate
    fit: Fit


def best_harmonic(
    wanted: Columns,
    columns: Sequence[Columns],
    pairs: Sequence[np.ndarray],
    free: Columns | None = None,
) -> Harmonic:
    """The harmonic that explains most, if it is more than noise has at the best of all periods.

    ``pairs`` holds for each record the columns of all harmonics, (rows, MOST_HARMONIC, 2).
    """
    plain = fit(wanted, columns, free)
    none = Harmonic(0, Estimate(0.0, 0.0), plain)
    flat = [list(pair.reshape(len(pair), -1).T) for pair in pairs]
    goals, tables = freed(wanted, columns, free)
    basis, _ = np.linalg.qr(np.concatenate(tables))
    parts = freed(wanted, flat, free)[1]
    waves = np.concatenate(parts)
    waves -= basis @ (basis.T @ waves)
    goal = np.concatenate(goals)
    goal -= basis @ (basis.T @ goal)
    squares = {}
    for n in range(LEAST_HARMONIC, MOST_HARMONIC + 1):
        wave, _ = np.linalg.qr(waves[:, 2 * n - 2 : 2 * n])
        squares[n] = plain.square - float(np.sum((wave.T @ goal) ** 2))
    best = min(squares, key=squares.__getitem__)
    if len(wanted) < FEWEST_RECORDS or squares[best] >= (1.0 - CLEARLY) * plain.square:
        return none
    more = [
        [*table, pair[:, best - 1, 0], pair[:, best - 1, 1]]
        for table, pair in zip(columns, pairs, strict=True)
    ]
    found = fit(wanted, more, free)
    covariance = _jackknifed(wanted, more, free)[-2:, -2:]
    along = found.factors[-2:]
    size = float(np.hypot(*along))
    sd = float(np.sqrt(max(0.0, along @ covariance @ along))) / size
    ends = np.cumsum([len(part) for part in parts])[:-1]
    own = np.array([np.sum(part**2) for part in np.split(waves[:, 2 * best - 2 : 2 * best], ends)])
    records = float(own.sum() ** 2 / np.sum(own**2))
    square = float(along @ np.linalg.pinv(covariance, hermitian=True) @ along)
    if size < SPREADS * sd or len(squares) * _by_chance(square, records) > FALSELY:
        return none
    return Harmonic(best, Estimate(size, sd), found)


def _jackknifed(
    wanted: Columns, columns: Sequence[Columns], free: Columns | None = None
) -> np.ndarray:
    """Covariance of the factors by leaving out one record after another.

    Where a few records weigh most, :attr:`Fit.covariance` is too small: the fit follows them.
    """
    count = len(wanted)
    each = []
    for n in range(count):
        kept = [m for m in range(count) if m != n]
        others = [free[m] for m in kept] if free is not None else None
        each.append(fit([wanted[m] for m in kept], [columns[m] for m in kept], others).factors)
    apart = np.array(each) - np.mean(each, axis=0)
    found: np.ndarray = (count - 1) / count * apart.T @ apart
    return found


def _by_chance(square: float, records: float) -> float:
    """Probability that a harmonic's two factors, all noise, are as far from zero, or farther.

    ``square`` is Hotelling's T², of factors whose covariance is from ``records``. These are the
    effective ones, (Σw)²/Σw² of what each weighs (Carter, Schnepel, Steigerwald: Asymptotic
    behavior of a t-test robust to cluster heterogeneity, 2017): a few long ones may be nearly all.
    """
    left = max(0.0, records - 1.0)
    return float((1.0 + square / left) ** (-0.5 * (left - 1.0))) if left > 1.0 else 1.0


def harmonics(angle: np.ndarray) -> np.ndarray:
    """cos and sin of 1 to MOST_HARMONIC times the angle: (rows, MOST_HARMONIC, 2)."""
    phase = angle[:, None] * np.arange(1, MOST_HARMONIC + 1)
    return np.stack([np.cos(phase), np.sin(phase)], axis=2)
