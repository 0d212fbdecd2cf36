# SPDX-License-Identifier: Apache-2.0
"""A sigma-delta modulator of the second order, bit by bit."""

from __future__ import annotations

import numpy as np

from wavehaptics.runtime.compiled import compiled

CLIPPED_RUN = 128
"""Bits after which an overdriven modulator shows the other level once, to prove that it lives
(AMC1306, data sheet)."""

_LIMIT = 8.0
_SUM1, _SUM2, _BIT, _RUN = range(4)


def new_state() -> np.ndarray:
    """State before the first bit: float64 (4,)."""
    return np.array([0.0, 0.0, -1.0, 0.0])


@compiled()
def next_bit(state: np.ndarray, level: float) -> int:
    """The bit for an input of ``level`` full scales: ones by (1 + level)/2, ±1 is where it clips.

    Y = U + (1 − z⁻¹)² E: two integrators with the output fed back to both. At ±1 and beyond the
    output is constant but for one bit in :data:`CLIPPED_RUN`.
    """
    state[_SUM1] = min(max(state[_SUM1] + level - state[_BIT], -_LIMIT), _LIMIT)
    state[_SUM2] = min(max(state[_SUM2] + state[_SUM1] - state[_BIT], -_LIMIT), _LIMIT)
    state[_BIT] = 1.0 if state[_SUM2] >= 0.0 else -1.0
    if abs(level) >= 1.0:
        state[_BIT] = 1.0 if level > 0.0 else -1.0
        state[_RUN] += 1.0
        if state[_RUN] >= CLIPPED_RUN:
            state[_RUN] = 0.0
            state[_BIT] = -state[_BIT]
    else:
        state[_RUN] = 0.0
    return 1 if state[_BIT] > 0.0 else 0
