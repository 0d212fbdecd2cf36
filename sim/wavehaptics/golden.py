# SPDX-License-Identifier: Apache-2.0
"""The wave core as integers: bit for bit what ``rtl/wh_wave_core.v`` computes.

Every function works on plain integers (64 bits hold every intermediate result) and is compiled by
numba; ``.py_func`` of each runs as ordinary Python.
"""

from __future__ import annotations

import numba
import numpy as np

from wavehaptics import formats

_DATA_MAX = (1 << (formats.DATA_W - 1)) - 1
_DATA_MIN = -(1 << (formats.DATA_W - 1))
_GUARD = formats.STATE_GUARD
_ETA_Q = formats.ETA.fraction
_A_SHIFT = formats.A.fraction - formats.STATE_GUARD
_SI_SHIFT = formats.ROOT.fraction + formats.CURRENT.fraction - formats.WAVE.fraction
_SU_SHIFT = formats.ROOT.fraction + formats.WAVE.fraction - formats.VOLTAGE.fraction

STATE_F, STATE_HEAD, STATE_FILLED = 0, 1, 2
"""Places in a core's state: the λ filter's f, the newest place of the delay line, its fill."""


def new_state() -> np.ndarray:
    """State of one port after reset: int64, shape (3,)."""
    return np.zeros(3, dtype=np.int64)


def new_line(extra_ticks: int) -> np.ndarray:
    """Delay line of u for a latency of ``extra_ticks``: int64, shape (a power of two,)."""
    return np.zeros(1 << max(1, extra_ticks.bit_length()), dtype=np.int64)


@numba.njit(cache=True, inline="always")
def truncate(value: int, bits: int) -> int:
    """``value / 2**bits`` rounded toward zero: a rounding step that can only lose magnitude."""
    return value >> bits if value >= 0 else -((-value) >> bits)


@numba.njit(cache=True, inline="always")
def saturate(value: int) -> int:
    """``value`` limited to a data word."""
    return min(max(value, _DATA_MIN), _DATA_MAX)


@numba.njit(cache=True, inline="always")
def line_read(line: np.ndarray, state: np.ndarray, age: int) -> int:
    """The u that was computed ``age`` steps before the newest; 0 before the first."""
    if age >= state[STATE_FILLED]:
        return 0
    return line[(state[STATE_HEAD] - age) & (line.shape[0] - 1)]


@numba.njit(cache=True)
def wave_core_step(
    state: np.ndarray,
    line: np.ndarray,
    current: int,
    eta: int,
    root: int,
    a: int,
    u_max: int,
    extra_ticks: int,
    hold_ticks: int,
) -> tuple[int, int, int]:
    """One tick of one port (design equations of §1.1; the paper's wave transform and D(s)).

    ``current`` is the tick's mean i_n, ``root`` is s, ``u_max`` the voltage limit over s,
    ``extra_ticks`` the age of the u that was applied in the measured tick and ``hold_ticks`` the
    age of the u to be applied next; both are smaller than the line's length. All are raw words of
    :mod:`wavehaptics.formats`. Returns the words (e, u_n, v_n): the voltage to apply, and the
    waves of the measured tick.
    """
    u_n = line_read(line, state, extra_ticks)
    v_n = saturate(u_n - truncate(root * current, _SI_SHIFT))
    goal = saturate(truncate(eta * v_n, _ETA_Q))
    f = state[STATE_F]
    error = saturate(truncate((goal << _GUARD) - f, _GUARD))
    f += truncate(a * error, _A_SHIFT)
    f = min(max(f, -(u_max << _GUARD)), u_max << _GUARD)
    state[STATE_F] = f
    state[STATE_HEAD] = (state[STATE_HEAD] + 1) & (line.shape[0] - 1)
    line[state[STATE_HEAD]] = truncate(f, _GUARD)
    state[STATE_FILLED] = min(state[STATE_FILLED] + 1, line.shape[0])
    e = saturate(truncate(root * line_read(line, state, hold_ticks), _SU_SHIFT))
    return e, u_n, v_n


@numba.njit(cache=True)
def contact_step(
    state: np.ndarray, position: int, wall_min: np.ndarray, wall_max: np.ndarray
) -> tuple[bool, int]:
    """Contact with solid intervals ``wall_min <= position < wall_max``, all in encoder counts.

    ``state`` is int64 (2,): number of the wall in contact or -1, and the count edge x_w through
    which the rotor came in. The first wall that holds the position wins. A rotor that starts
    inside a wall came in through the nearer edge, through the lower one if both are as near.
    Returns (in contact, position - x_w); the second is 0 in free space.
    """
    wall = -1
    for n in range(wall_min.shape[0]):
        if wall < 0 and wall_min[n] <= position < wall_max[n]:
            wall = n
    if wall >= 0 and wall != state[0]:
        from_low = position - wall_min[wall]
        from_high = wall_max[wall] - position
        state[1] = wall_min[wall] if from_low <= from_high else wall_max[wall]
    state[0] = wall
    return wall >= 0, position - state[1] if wall >= 0 else 0
