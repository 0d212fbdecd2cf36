# SPDX-License-Identifier: Apache-2.0
"""Two motors on a virtual shaft: their waves cross over, on a line with a delay.

Reflection along ``g = (1, −1)/√2`` (:mod:`wavehaptics.controller.surfaces`) exchanges two waves::

    u = v − 2 g (g·v) = (v_1, v_0),   with the delay δ:   u_0(t) = v_1(t − δ),  u_1(t) = v_0(t − δ)

This is bilateral teleoperation by wave variables (G. Niemeyer and J.-J. E. Slotine, *Stable
Adaptive Teleoperation*, IEEE Journal of Oceanic Engineering 16(1), 1991). The line gives out what
came in and nothing else, so it is passive with any delay, and as words are copied no rounding
moves one motor against the other. The line's delay adds to that of the ports, τ: the shaft has the
stiffness ``k_T²/(2L + R̂ (τ + δ))`` and adds the inertia ``k_T² (τ + δ)/(2R̂)`` to each motor.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.runtime.compiled import compiled


def new_line(ticks: int) -> np.ndarray:
    """An empty line of that delay: int64 (ticks, 2)."""
    return np.zeros((ticks, 2), dtype=np.int64)


@compiled(inline="always")
def cross(line: np.ndarray, at: np.ndarray, waves: np.ndarray) -> None:
    """Send the raw ``waves`` of two motors to each other; what arrives takes their place.

    ``line`` is that of :func:`new_line` and ``at`` int64 (1,) its next row; both are updated.
    """
    first, second = waves[0], waves[1]
    if line.shape[0]:
        row = at[0]
        arrived, other = line[row, 0], line[row, 1]
        line[row, 0], line[row, 1] = first, second
        at[0] = (row + 1) % line.shape[0]
        first, second = arrived, other
    waves[0], waves[1] = second, first
