# SPDX-License-Identifier: Apache-2.0
"""k_T by the back-EMF either way: ∫(v − R(θ) i − V_b sgn i − V_0) dt − L i = k_T x + const."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wavehaptics.host.identify.resistance import KNEE_A, UNSETTLED, Resistance
from wavehaptics.host.identify.segments import Estimate, Segment, fit

LEAST, MOST = 2e-4, 5.0
"""k_T of a motor, V·s/rad."""

SAME = 0.05
"""Part by which both ways may differ."""


@dataclass(frozen=True)
class BackEmf:
    """k_T in V·s/rad, which is N·m/A; of forward and backward turns each."""

    k_t: Estimate
    forward: Estimate
    backward: Estimate


def back_emf(segments: Sequence[Segment], known: Resistance) -> BackEmf:
    """Of pulses both ways; ``known`` is what they gave for R."""
    ways = [_one_way([s for s in segments if s.wanted * sign > 0], known) for sign in (1.0, -1.0)]
    return BackEmf(known.k_t, *ways)


def _one_way(segments: Sequence[Segment], known: Resistance) -> Estimate:
    parts = [s.part(UNSETTLED, len(s.current)) for s in segments]
    wanted = [
        s.sum(
            s.voltage
            - known.ohms(s.angle) * s.current
            - known.drop_v.value * np.tanh(s.current / KNEE_A)
            - known.offset_v.value
        )
        - known.inductance.value * s.ends
        for s in parts
    ]
    found = fit(wanted, [[s.turned] for s in parts]).estimate(0)
    return Estimate(found.value, math.hypot(found.sd, known.k_t.sd))
