# SPDX-License-Identifier: Apache-2.0
"""The drive as integers: what ``rtl/wh_modulator.v`` and ``rtl/wh_dead_time.v`` compute.

Compiled by numba; ``.py_func`` of each runs as ordinary Python.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats
from wavehaptics.words.bridge_modes import SIGN_MAGNITUDE, UNIPOLAR

_FRACTION = formats.DUTY.fraction
_ONE = 1 << _FRACTION
_EXTRA_SHIFT = formats.DUTY.fraction - formats.EXTRA.fraction

REST, OLDER = 0, 1
"""Places in a modulator's state: the rest of the last half, and of the one before."""

NEGATIVE, STARTING, SETTLE = 0, 1, 2
"""Places in the state of the dead time's compensation."""


def new_modulator() -> np.ndarray:
    """State of a modulator after reset: int64, shape (2,)."""
    return np.zeros(2, dtype=np.int64)


def new_dead_time() -> np.ndarray:
    """State of a compensation after reset: int64, shape (3,)."""
    return np.zeros(3, dtype=np.int64)


@compiled(inline="always")
def duty_of(voltage: int, clocks_per_volt: int) -> int:
    """Duty of a voltage word, in 2⁻¹⁶ clocks of half width; rounded toward zero."""
    product = voltage * clocks_per_volt
    magnitude = abs(product) >> formats.VOLTAGE.fraction
    return magnitude if product >= 0 else -magnitude


@compiled()
def half_width(
    state: np.ndarray, duty: int, extra: int, half_clocks: int, second_order: bool, least: int = 0,
    spare: int = 0,
) -> int:  # fmt: skip
    """Half width in clocks of the coming half, for a ``duty`` in 2⁻¹⁶ and ``extra`` in 2⁻⁸ clocks.

    What the whole clocks leave over is owed to the next halves; what a clipped half can't give is
    not. A width below ``least`` clocks is 0 or ``least``; the largest is ``spare`` clocks less than
    half of ``half_clocks``, or 0.
    """
    owed: int = 2 * state[REST] - state[OLDER] if second_order else state[REST]
    total = duty + (extra << _EXTRA_SHIFT) + owed
    magnitude = (abs(total) + _ONE // 2) >> _FRACTION
    if magnitude < least:
        magnitude = 0 if 2 * magnitude < least else least
    width = magnitude if total >= 0 else -magnitude
    limit = max(half_clocks // 2 - spare, 0)
    state[OLDER] = state[REST]
    if abs(width) > limit:
        state[REST] = 0
        return limit if width > 0 else -limit
    state[REST] = total - width * _ONE
    return width


def width_bounds(mode: str, min_pulse: int) -> tuple[int, int]:
    """``least`` and ``spare`` of :func:`half_width` for legs that stay ``min_pulse`` clocks.

    As ``rtl/wh_controller.v`` makes them for a mode of :mod:`wavehaptics.motor.bridge`.
    """
    spare = (min_pulse + 1) // 2
    return {UNIPOLAR: min_pulse, SIGN_MAGNITUDE: spare}.get(mode, 0), spare


@compiled()
def dead_time_extra(
    state: np.ndarray, current: int, dead_clocks: int, threshold: int, settle_ticks: int
) -> int:
    """What the half pulses must be longer by, in 2⁻⁸ clocks, from a tick's ``current`` on."""
    below = (~current if state[NEGATIVE] else current) < threshold
    state[STARTING] = below
    if below and state[SETTLE] == 0:
        state[NEGATIVE] = 1 - state[NEGATIVE]
        state[SETTLE] = settle_ticks
    elif state[SETTLE] > 0:
        state[SETTLE] -= 1
    extra = dead_clocks << (formats.EXTRA.fraction - 1)
    if state[STARTING]:
        extra += extra >> 2
    return -extra if state[NEGATIVE] else extra
