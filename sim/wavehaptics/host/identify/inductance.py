# SPDX-License-Identifier: Apache-2.0
"""L by steps of the voltage, in records of single ticks.

    ∫(v − V_b sgn i) dt − k_T²/J ∬i dt dt = L i + R ∫i dt + const.

V_b, k_T and J are those of the pulses; R is free, as it is that of the angle where the rotor
stands. The rotor moves by less than the encoder tells, so that it is taken from the current. A lag
of the amplifier is in the constant.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wavehaptics.host.identify.resistance import Resistance
from wavehaptics.host.identify.segments import Estimate, Segment, fit

LEAST_H, MOST_H = 2e-6, 0.1
"""L of a motor."""

BEGUN = 0.1
"""Part of the last current from which on a step's record is looked at."""


def inductance(segments: Sequence[Segment], known: Resistance, inertia: float) -> Estimate:
    """L in H of records that begin with the step; ``known`` is what the pulses gave."""
    spring = known.k_t.value**2 / inertia
    wanted, columns = [], []
    for s in segments:
        goal = s.sum(s.voltage - np.sign(s.wanted) * known.drop_v.value)
        goal -= spring * s.sum(s.step_s * np.cumsum(s.current))
        first = _begins(s)
        wanted.append(goal[first:])
        columns.append([s.ends[first:], s.sum(s.current)[first:]])
    return fit(wanted, columns).estimate(0)


def _begins(s: Segment) -> int:
    """The row from which on a current flows, behind the amplifier's lag and the brushes' knee."""
    return int(np.argmax(np.abs(s.current) >= BEGUN * np.max(np.abs(s.current))))
