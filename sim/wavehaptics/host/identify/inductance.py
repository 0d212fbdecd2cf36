# SPDX-License-Identifier: Apache-2.0
"""L by steps of the voltage, in records of single ticks.

    ∫(v − V_b sgn i) dt − k_T²/J ∬i dt dt = L i + R ∫i dt + const.

V_b, k_T and J are those of the pulses; R is free, as it is that of the angle where the rotor
stands. Within RISES time constants the rotor moves by less than the encoder tells, so that it is
taken from the current; what comes later in a record would tell of friction and R(θ). A lag of the
amplifier is in the constant.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wavehaptics.host.identify.resistance import Resistance
from wavehaptics.host.identify.segments import Estimate, Segment, fit

LEAST_H, MOST_H = 2e-6, 0.1
"""L of a motor."""

BEGUN = 0.1
"""Part of the largest current from which on a step's record is looked at."""

RISES = 3.0
"""Time constants of a step's record that are looked at: R and L are told apart by then."""

FEWEST_ROWS = 6
"""And so many rows at least."""


def inductance(segments: Sequence[Segment], known: Resistance, inertia: float) -> Estimate:
    """L in H of records that begin with the step; ``known`` is what the pulses gave."""
    spring = known.k_t.value**2 / inertia
    wanted, columns = [], []
    for s in rises(segments):
        goal = s.sum(s.voltage - np.sign(s.wanted) * known.drop_v.value)
        goal -= spring * s.sum(s.step_s * np.cumsum(s.current))
        first = begins(s)
        wanted.append(goal[first:])
        columns.append([row_ends(s)[first:], s.sum(s.current)[first:]])
    return fit(wanted, columns).estimate(0)


def row_ends(s: Segment) -> np.ndarray:
    """The current at the rows' ends, A, by the four means around: of few rows a rise is no line."""
    ends = s.ends
    ends[1:-1] = (7.0 * (s.current[1:-2] + s.current[2:-1]) - s.current[:-3] - s.current[3:]) / 12.0
    return ends


def rises(segments: Sequence[Segment]) -> list[Segment]:
    """The records of steps up to RISES time constants, as the largest step has them."""
    largest = max(segments, key=lambda s: float(np.max(np.abs(s.current))))
    size = np.abs(largest.current)
    first = begins(largest)
    risen = int(np.argmax(size >= (1.0 - np.exp(-1.0)) * np.max(size)))
    rows = max(FEWEST_ROWS, round(RISES * (risen - first + 2)))
    return [s.part(0, first + rows) for s in segments]


def begins(s: Segment) -> int:
    """The first row that is all in the rise, behind the amplifier's lag and the brushes' knee."""
    return 1 + int(np.argmax(np.abs(s.current) >= BEGUN * np.max(np.abs(s.current))))
