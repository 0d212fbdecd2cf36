# SPDX-License-Identifier: Apache-2.0
"""J and friction, by ramps and coasting, integrated twice.

    J x = k_T ∬i − c ∬sgn(ω) − b ∫x + ∬(p cos nθ + q sin nθ) + each record's J (x_0 + ω_0 t)

Divided by J everything is linear. Each record ends where its rotor stands still: there friction is
whatever it has to be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wavehaptics.host.identify.segments import (
    Columns,
    Estimate,
    Fit,
    Segment,
    best_harmonic,
    fit,
    freed,
    harmonics,
)

LEAST_J, MOST_J = 1e-9, 1e-2
"""J of a rotor with what is fixed to it, kg·m²."""

FEWEST_ROWS = 12
FEWEST_CELLS = 8
"""Of a record of which anything can be said."""


@dataclass(frozen=True)
class Mechanics:
    """J in kg·m², friction in N·m and N·m·s/rad; cogging in N·m with its periods or 0."""

    inertia: Estimate
    coulomb: Estimate
    viscous: Estimate
    cogging: Estimate
    per_rev: int


def moving(s: Segment, cell_rad: float) -> Segment | None:
    """The part of a record in which the rotor turns; None if there is too little of it."""
    speed = s.speed
    slow = np.abs(speed) < 2.0 * cell_rad / (8 * s.step_s)
    turns = np.nonzero(~slow)[0]
    if not len(turns):
        return None
    first = int(turns[0])
    stands = np.nonzero(slow[first:])[0]
    last = first + int(stands[0]) if len(stands) else len(speed)
    kept = s.part(first, last)
    if last - first < FEWEST_ROWS or np.ptp(kept.position) < FEWEST_CELLS * cell_rad:
        return None
    return kept


def mechanics(segments: Sequence[Segment], k_t: Estimate, cell_rad: float) -> Mechanics | None:
    """Of pulses and coasting both ways; None where the rotor hardly moved."""
    parts = [part for s in segments if (part := moving(s, cell_rad)) is not None]
    if len(parts) < 4:
        return None
    wanted = [s.turned for s in parts]
    free = [s.t for s in parts]
    columns = [_columns(s) for s in parts]
    pairs = [_waves(s) for s in parts]
    wave = best_harmonic(wanted, columns, pairs, free)
    per_rev, found = wave.periods, wave.fit
    goals = [
        goal - (pair[:, per_rev - 1] @ found.factors[3:] if per_rev else 0.0)
        for goal, pair in zip(wanted, pairs, strict=True)
    ]
    pull, friction = found.estimate(0), found
    coasts = [n for n, s in enumerate(parts) if _coasts(s, parts)]
    ramps = [n for n in range(len(parts)) if n not in coasts]
    if len(coasts) >= FEWEST_PARTS and len(ramps) >= FEWEST_PARTS:
        for _ in range(TURNS):
            friction = _friction(coasts, goals, columns, free, pull.value)
            pull = _pull(ramps, goals, columns, free, friction)
    if pull.value <= 0.0:
        return None
    inertia = k_t.value / pull.value
    spread = float(np.hypot(pull.sd / pull.value, k_t.sd / k_t.value))
    return Mechanics(
        Estimate(inertia, inertia * spread),
        _positive(friction, 1, inertia),
        _positive(friction, 2, inertia),
        Estimate(inertia * wave.size.value, inertia * wave.size.sd),
        per_rev,
    )


FEWEST_PARTS = 2
"""Ramps, and records of coasting, of which each tells its own."""

TURNS = 2
"""The ramps need the friction, a little, and coasting the current that there still is."""


def _friction(
    coasts: Sequence[int], goals: Columns, columns: Sequence[Columns], free: Columns, pull: float
) -> Fit:
    """c/J and b/J, columns 1 and 2: a ramp's least error would be friction's."""
    return fit(
        [goals[n] - pull * columns[n][0] for n in coasts],
        [[np.zeros_like(goals[n]), *columns[n][1:]] for n in coasts],
        [free[n] for n in coasts],
    )


def _pull(
    ramps: Sequence[int], goals: Columns, columns: Sequence[Columns], free: Columns, friction: Fit
) -> Estimate:
    """k_T/J: coasting lasts long, and what of cogging isn't found in it would be in J."""
    known = friction.factors[1:]
    own = [free[n] for n in ramps]
    found = fit(
        [goals[n] - np.stack(columns[n][1:], axis=1) @ known for n in ramps],
        [columns[n][:1] for n in ramps],
        own,
    ).estimate(0)
    # What isn't known of the friction: its columns, as far as they look like that of k_T/J.
    tables = freed([goals[n] for n in ramps], [columns[n] for n in ramps], own)[1]
    pulled, *others = np.concatenate(tables).T
    alike = np.array([pulled @ other for other in others]) / (pulled @ pulled)
    covariance = friction.covariance[1:, 1:]
    return found.widened(float(np.sqrt(max(0.0, alike @ covariance @ alike))))


COASTS = 0.05
"""Part of the largest mean current below which a record is one of coasting."""


def _coasts(s: Segment, among: Sequence[Segment]) -> bool:
    most = max(abs(float(np.mean(other.current))) for other in among)
    return abs(float(np.mean(s.current))) < COASTS * most


def _columns(s: Segment) -> list[np.ndarray]:
    """Columns of k_T/J, c/J and b/J."""
    return [_twice(s, s.current), -_twice(s, np.sign(s.speed)), -s.sum(s.angle - s.angle[0])]


def _waves(s: Segment) -> np.ndarray:
    """∬ of the angle's harmonics."""
    once = s.step_s * np.cumsum(harmonics(s.angle), axis=0)
    before = np.concatenate([np.zeros_like(once[:1]), once[:-1]])
    return (s.step_s * np.cumsum(0.5 * (once + before), axis=0))[: len(s)]


def _positive(found: Fit, column: int, inertia: float) -> Estimate:
    """A friction, which is never below zero."""
    estimate = found.estimate(column, inertia)
    return Estimate(max(0.0, estimate.value), estimate.sd)


def _twice(s: Segment, values: np.ndarray) -> np.ndarray:
    """∬ of the rows' means, at their ends."""
    once = s.step_s * np.cumsum(values)
    before = np.concatenate([[0.0], once[:-1]])
    return (s.step_s * np.cumsum(0.5 * (once + before)))[: len(s)]
