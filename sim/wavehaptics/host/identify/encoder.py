# SPDX-License-Identifier: Apache-2.0
"""The encoder: whether it tells of motion, which way, and what its counts say.

Volts and counts know each other by k_T times the angle of a cell alone. Its sign is the encoder's
against the motor's; its size is that of the counts only where k_T is known from elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wavehaptics.host.identify.segments import Estimate, Segment

CELLS = 6
"""Cells that a rotor moves at least, if it isn't jammed."""

TURNS = 0.15
"""Part of R i by which the voltage of a pulse rises if the rotor turns."""

SIGMA = 4.0
"""Spreads from zero at which a sign is one."""


def emf_rate(segments: Sequence[Segment]) -> float:
    """How fast the voltage of pulses rises for an ampere, V/(A·s): k_T²/J, without the encoder."""
    rates = []
    for s in segments:
        first = len(s.voltage) // 4  # the current has settled
        t = s.step_s * np.arange(len(s.voltage) - first)
        rates.append(np.polyfit(t, s.voltage[first:], 1)[0] / np.mean(s.current[first:]))
    return max(float(np.mean(rates)), 1e-9)


def turns_unseen(segment: Segment, rate: float, ohm: float) -> bool:
    """Whether the voltage of a pulse tells of motion: ``rate`` is its :func:`emf_rate`."""
    return rate * segment.step_s * len(segment.voltage) > TURNS * ohm


def counts_along(segments: Sequence[Segment], cell_rad: float) -> float:
    """Counts of pulses from rest in the direction of their currents."""
    moved = sum((s.position[-1] - s.position[0]) * np.sign(np.mean(s.current)) for s in segments)
    return float(moved) / cell_rad


def is_reversed(k_t: Estimate) -> bool:
    """Whether the back-EMF is against the counts."""
    return k_t.value < -SIGMA * k_t.sd


def counts_for(k_t: float, expected: float, counts: int) -> float:
    """Counts a revolution with which k_T would be what was ``expected``."""
    return counts * expected / k_t
