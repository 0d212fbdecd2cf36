# SPDX-License-Identifier: Apache-2.0
"""The wave core as integers, bit for bit equal to ``rtl/wh_wave_core.v``.

Every function works on plain integers (64 bits hold every intermediate result) and is compiled by
numba; its ``.py_func`` runs as ordinary Python.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats

_DATA_MAX = (1 << (formats.DATA_W - 1)) - 1
_DATA_MIN = -(1 << (formats.DATA_W - 1))
_GUARD = formats.STATE_GUARD
_ETA_Q = formats.ETA.fraction
_A_SHIFT = formats.A.fraction - formats.STATE_GUARD
_SI_SHIFT = formats.ROOT.fraction + formats.CURRENT.fraction - formats.WAVE.fraction
_SHAPE_Y_SHIFT = formats.SHAPE.fraction - formats.SHAPE_HEADROOM
_SHAPE_X_SHIFT = formats.SHAPE.fraction - formats.STATE_GUARD
# The largest state without guard bits: rounded to the nearest, it still fits the multiplier.
_SHAPE_X_MAX, _SHAPE_X_MIN = _DATA_MAX << _GUARD, _DATA_MIN << _GUARD
_HALF = 1 << (_GUARD - 1)
_DATA_MASK = (1 << formats.DATA_W) - 1
_BUDGET_HIGH = 1 << (formats.DATA_W + 2 * formats.SHAPE_HEADROOM)
_SU_SHIFT = formats.ROOT.fraction + formats.WAVE.fraction - formats.VOLTAGE.fraction

(
    STATE_F, STATE_HEAD, STATE_FILLED, STATE_SATURATED, STATE_WITHHELD, STATE_LOST, STATE_CLIPPED,
) = range(7)  # fmt: skip
"""Indices of a core's state: the λ filter's f; the newest position of the delay line; its fill;
whether f was beyond ±u_max in the newest step; the residue of u, s31q23 √W: by how much f was
beyond, rounded down, or else −1, 0 or 1, which add up to what truncation of f to u has cut off;
the fraction of an LSB of that sum; whether i_n or v_n of the newest step was at the end of its
range."""

CLEAR, HOLD, SHAPE = range(3)
"""Modes of the shaper: W = 1 and its states become 0; W = 1 and they stay; W."""

E11, E12, E21, E22, B1, B2, C1, C2, D, LOSS1, LOSS2, LOSS_Y = range(12)
"""Indices of the coefficients of a shaper's section: its matrix, less 1 on the diagonal of the
states, and the losses of its three roundings (:mod:`wavehaptics.controller.normalised`)."""
SECTION_WORDS = 12

NO_SHAPER = np.zeros((0, SECTION_WORDS), dtype=np.int64)
"""Coefficients of a shaper without a section: W = 1."""


def new_state() -> np.ndarray:
    """State of one port after reset: int64, shape (7,)."""
    return np.zeros(7, dtype=np.int64)


def new_line(extra_ticks: int) -> np.ndarray:
    """Delay line of u for a latency of ``extra_ticks``: int64, shape (a power of two,)."""
    return np.zeros(1 << max(1, extra_ticks.bit_length()), dtype=np.int64)


@compiled(inline="always")
def truncate(value: int, bits: int) -> int:
    """``value / 2**bits`` rounded toward zero: a rounding step that can only lose magnitude."""
    return value >> bits if value >= 0 else -((-value) >> bits)


@compiled(inline="always")
def saturate(value: int) -> int:
    """``value`` limited to a data word."""
    return min(max(value, _DATA_MIN), _DATA_MAX)


@compiled(inline="always")
def line_read(line: np.ndarray, state: np.ndarray, age: int) -> int:
    """The u that was computed ``age`` steps before the newest; 0 before the first."""
    if age >= state[STATE_FILLED]:
        return 0
    u: int = line[(state[STATE_HEAD] - age) & (line.shape[0] - 1)]
    return u


def new_shaper_state(sections: int) -> np.ndarray:
    """States of a port's shaper after reset: int64, shape (sections + 1, 2).

    The last row is its budget in squares of a wave's LSB: the parts above and below
    2^``formats.DATA_W``.
    """
    return np.zeros((sections + 1, 2), dtype=np.int64)


@compiled(inline="always")
def toward_zero(value: int, loss: int) -> int:
    """A floor brought nearer to zero by ``loss``, the error that it may have; never past 0.

    With ``loss`` 0 it is :func:`truncate`: a floor below zero goes up by one.
    """
    return max(value - loss, 0) if value >= 0 else min(value + loss + 1, 0)


@compiled()
def shaper_section(words: np.ndarray, x: np.ndarray, v: int) -> int:
    """One tick of one section of W (:mod:`~wavehaptics.controller.normalised`).

    It is ``[x', y] = M [x, v]``.

    ``words`` int64 (SECTION_WORDS,), ``x`` int64 (2,) is updated, ``v`` a wave. Returns the wave y.
    Neither x' nor y is larger than the exact product with the words, so with a contractive M no
    tick gives out more energy than was there.
    """
    h1, h2 = (x[0] + _HALF) >> _GUARD, (x[1] + _HALF) >> _GUARD
    direct = (words[D] * v) >> formats.SHAPE_HEADROOM
    y = words[C1] * h1 + words[C2] * h2 + direct
    y = saturate(toward_zero(y >> _SHAPE_Y_SHIFT, words[LOSS_Y]))
    first = (words[B1] * v) >> formats.SHAPE_HEADROOM
    first += words[E11] * h1 + words[E12] * h2
    second = (words[B2] * v) >> formats.SHAPE_HEADROOM
    second += words[E21] * h1 + words[E22] * h2
    first = toward_zero(x[0] + (first >> _SHAPE_X_SHIFT), words[LOSS1])
    second = toward_zero(x[1] + (second >> _SHAPE_X_SHIFT), words[LOSS2])
    x[0] = min(max(first, _SHAPE_X_MIN), _SHAPE_X_MAX)
    x[1] = min(max(second, _SHAPE_X_MIN), _SHAPE_X_MAX)
    return y


@compiled(inline="always")
def _pay(budget: np.ndarray, square: int) -> None:
    """Add ``square`` to a budget in two words, int64 (2,), up to more than states can hold."""
    low = budget[1] + (square & _DATA_MASK)
    high = budget[0] + (square >> formats.DATA_W) + (low >> formats.DATA_W)
    full = high >= _BUDGET_HIGH
    budget[0] = _BUDGET_HIGH - 1 if full else high
    budget[1] = _DATA_MASK if full else low & _DATA_MASK


@compiled(inline="always")
def shaper_mode(wall: int, shaped: np.ndarray) -> int:
    """SHAPE in a wall that is ``shaped``, bool (walls,); HOLD in others; CLEAR outside (-1).

    So a soft layer keeps its compression while the rotor is in the rigid wall behind it.
    """
    if wall < 0:
        return CLEAR
    return SHAPE if shaped[wall] else HOLD


@compiled()
def shaper_step(words: np.ndarray, states: np.ndarray, mode: int, v: int) -> int:
    """W{v} through every section; ``words`` int64 (sections, SECTION_WORDS).

    ``states`` of :func:`new_shaper_state` is updated; ``mode`` is CLEAR, HOLD or SHAPE. W has a
    budget, the sum of v² − y²; while it is below zero, y is 0. So coefficients that aren't
    contractive give out at most what came in, plus one tick's y²; of those that are, the
    budget is never below ``|x|²``.
    """
    sections = words.shape[0]
    if mode == SHAPE:
        y = v
        for section in range(sections):
            y = shaper_section(words[section], states[section], y)
        if states[sections, 0] < 0:
            y = 0
        _pay(states[sections], v * v)
        _pay(states[sections], -y * y)
        return y
    if mode == CLEAR:
        states[:sections] = 0
    return v


@compiled(inline="always")
def incoming(
    state: np.ndarray, line: np.ndarray, current: int, root: int, extra_ticks: int, ends: int
) -> tuple[int, int]:
    """The waves of the measured tick: u_n, and v_n = u_n − s·i_n.

    If the current is at the high end of its range, the true one may be larger by any amount, and so
    v smaller; at the low end the other way round. v_n is then the smallest magnitude that the true
    one can have. So a port with ``|η| ≤ 1`` stays passive, whatever the true current is.
    """
    u_n = line_read(line, state, extra_ticks)
    wide = u_n - truncate(root * current, _SI_SHIFT)
    v_n = saturate(wide)
    high = ends & formats.AT_HIGH != 0 or current == _DATA_MAX
    low = ends & formats.AT_LOW != 0 or current == _DATA_MIN
    state[STATE_CLIPPED] = 1 if high or low or v_n != wide else 0
    if (high and v_n > 0) or (low and v_n < 0):
        v_n = 0
    return u_n, v_n


@compiled(inline="always")
def outgoing(
    state: np.ndarray, line: np.ndarray, shaped: int, eta: int, outside: int, root: int, a: int,
    u_max: int, hold_ticks: int,
) -> int:  # fmt: skip
    """The λ filter from W{v_n} on: e to be applied.

    With surfaces across motors ``outside`` is the goal, and η is 0.
    """
    goal = saturate(truncate(eta * shaped, _ETA_Q))
    f = state[STATE_F]
    error = saturate(truncate(((goal + outside) << _GUARD) - f, _GUARD))
    unlimited = f + truncate(a * error, _A_SHIFT)
    limit = u_max << _GUARD
    f = min(max(unlimited, -limit), limit)
    state[STATE_F] = f
    u = truncate(f, _GUARD)
    lost = state[STATE_LOST] + f - (u << _GUARD)
    state[STATE_LOST] = lost & ((1 << _GUARD) - 1)
    state[STATE_SATURATED] = 0 if -limit <= unlimited <= limit else 1
    beyond = saturate((unlimited - f) >> _GUARD)
    state[STATE_WITHHELD] = beyond if state[STATE_SATURATED] != 0 else lost >> _GUARD
    state[STATE_HEAD] = (state[STATE_HEAD] + 1) & (line.shape[0] - 1)
    line[state[STATE_HEAD]] = u
    state[STATE_FILLED] = min(state[STATE_FILLED] + 1, line.shape[0])
    return saturate(truncate(root * line_read(line, state, hold_ticks), _SU_SHIFT))


@compiled()
def shaped_core_step(
    state: np.ndarray, line: np.ndarray, shaper: np.ndarray, shaper_states: np.ndarray, mode: int,
    current: int, eta: int, outside: int, root: int, a: int, u_max: int, extra_ticks: int,
    hold_ticks: int, ends: int = 0,
) -> tuple[int, int, int]:  # fmt: skip
    """One tick of one port: the paper's wave transform and D(s), discrete.

    ``shaper``, ``shaper_states`` and ``mode`` are those of :func:`shaper_step`,
    ``current`` is the tick's mean i_n, ``outside`` a wave that is added to the goal η·v, a host's
    (0: none), ``root`` is s, ``u_max`` the voltage limit over s,
    ``extra_ticks`` the age of the u that was applied in the measured tick and ``hold_ticks`` the
    age of the u to be applied next; both are smaller than the line's length. ``ends`` has the bits
    ``formats.AT_HIGH`` and ``AT_LOW`` where the current, or a sample of it, is at that end of its
    range. All are raw words of :mod:`wavehaptics.words.formats`. Returns the words (e, u_n, v_n):
    the voltage to apply, and the waves of the measured tick.
    """
    u_n, v_n = incoming(state, line, current, root, extra_ticks, ends)
    shaped = shaper_step(shaper, shaper_states, mode, v_n)
    return outgoing(state, line, shaped, eta, outside, root, a, u_max, hold_ticks), u_n, v_n


@compiled()
def wave_core_step(
    state: np.ndarray, line: np.ndarray, current: int, eta: int, outside: int, root: int, a: int,
    u_max: int, extra_ticks: int, hold_ticks: int, ends: int = 0,
) -> tuple[int, int, int]:  # fmt: skip
    """:func:`shaped_core_step` of a core without a shaper, W = 1."""
    u_n, v_n = incoming(state, line, current, root, extra_ticks, ends)
    return outgoing(state, line, v_n, eta, outside, root, a, u_max, hold_ticks), u_n, v_n


@compiled(inline="always")
def core_step(
    state: np.ndarray, line: np.ndarray, shaper: np.ndarray, shaper_states: np.ndarray, mode: int,
    current: int, eta: int, outside: int, root: int, a: int, u_max: int, ticks: int, ends: int,
) -> tuple[int, int, int]:  # fmt: skip
    """:func:`shaped_core_step` where there are sections; what is applied is ``ticks`` old."""
    if shaper.shape[0] == 0:
        return wave_core_step(
            state, line, current, eta, outside, root, a, u_max, ticks, ticks, ends
        )
    return shaped_core_step(
        state, line, shaper, shaper_states, mode, current, eta, outside, root, a, u_max, ticks,
        ticks, ends,
    )  # fmt: skip


@compiled()
def contact_step(
    state: np.ndarray, position: int, wall_min: np.ndarray, wall_max: np.ndarray,
    hysteresis: bool = False,
) -> tuple[bool, int]:  # fmt: skip
    """Contact with solid intervals ``wall_min <= position < wall_max``, all in encoder counts.

    ``state`` is int64 (2,): number of the wall in contact or -1, and the count edge x_w through
    which the rotor came in. The first wall that holds the position wins. A rotor that starts
    inside a wall came in through the nearer edge, through the lower one if both are as near. With
    ``hysteresis`` a wall is not left before the rotor is two counts outside, unless another has it.
    Returns (in contact, position - x_w); the second is 0 in free space.
    """
    wall = -1
    for n in range(wall_min.shape[0]):
        if wall < 0 and wall_min[n] <= position < wall_max[n]:
            wall = n
    kept = state[0]
    if (
        hysteresis
        and wall < 0
        and kept >= 0
        and (position == wall_min[kept] - 1 or position == wall_max[kept])
    ):
        wall = kept
    if wall >= 0 and wall != state[0]:
        from_low = position - wall_min[wall]
        from_high = wall_max[wall] - position
        state[1] = wall_min[wall] if from_low <= from_high else wall_max[wall]
    state[0] = wall
    return wall >= 0, position - state[1] if wall >= 0 else 0
