# SPDX-License-Identifier: Apache-2.0
"""How a brushless motor's magnets are found by the first movement of the hand, as integers.

With an electrical angle that is off by δ, a count changes both axes' flux by another vector than
:mod:`wavehaptics.controller.rotor_flux` says: χ of the two port anchors jumps by
``way·δ·(−q_β, q_α)``, for a small δ. While the anchors have no say yet, c = 0, a loop takes a tenth
of δ off, count by count, of what the larger part of q tells. From any angle it comes to the right
one but from the opposite, which it leaves. Drift between counts looks like δ too, so only those
count that come quickly, the same way as the one before; what it puts on in half a turn of the
magnets it takes off in the other.

They are found when in half a turn of them the loop was never turned by an eighth, and the mean of
both jumps is small; else the next half turn tells. Then the anchors begin, from χ = 0. With an
encoder or phases the wrong way round the loop has to follow by twice what passes: that is never
found.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.controller.rotor_flux import ANGLE_W
from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats

(KNOWN, CHI_A, CHI_B, TICKS, BACK, PASSED, LEVEL, POSITION, NET, FAR) = range(10)
"""Places in the state: whether the angle is known; χ of both axes at the last count, s31q16 cells;
ticks since then, whether that was a count down; by what the magnets have turned in counts that
counted, of this half turn; the mean of both jumps, u17q16 cells; the position; and by what the loop
has turned in this half turn, s32, and whether that was an eighth or more at any time."""
STATES = 10

SEEN_Q = formats.LONG.fraction - formats.LONG_GUARD
LOOP_SHIFT = ANGLE_W - SEEN_Q - 6
"""E in cells, which is about δ in rad, is turned into an angle of a tenth of it: 2^-6 of a turn."""
MEAN_SHIFT = 6
LEVEL_TOP = int(2.0**SEEN_Q)
"""The mean at first: a cell. Words may be so short that χ shows no part of one; a motor with
brushes is studied with such."""
FOUND = LEVEL_TOP // 4
"""Below it the magnets are found."""
LEAST_NET = 1 << (ANGLE_W - 3)
"""If the loop has turned by less."""
MOST_TICKS = (1 << formats.REST_W) - 1
HALF_TURN = 1 << (ANGLE_W - 1)
_MASK = (1 << ANGLE_W) - 1
_TOP = 1 << (formats.DATA_W - 1)
_WORD = (1 << formats.DATA_W) - 1
_BIG = int(2.0 ** (SEEN_Q + 1))


def new_state(known: bool, position: int) -> np.ndarray:
    """State after reset: int64, shape (STATES,)."""
    state = np.zeros(STATES, dtype=np.int64)
    state[KNOWN], state[POSITION] = known, position
    state[LEVEL], state[TICKS] = LEVEL_TOP, MOST_TICKS
    return state


@compiled(inline="always")
def _jump(now: int, before: int) -> int:
    """−E of an axis, at most 2 cells either way."""
    jump = ((now - before + _TOP) & _WORD) - _TOP
    return max(-_BIG, min(_BIG - 1, jump))


@compiled()
def magnet_angle_step(
    state: np.ndarray, turn: int, rest_ticks: int, position: int, contact: bool, cell_a: int,
    cell_b: int, chi_a: int, chi_b: int,
) -> int:  # fmt: skip
    """One tick; the angle to be added to θ, modulo 2^32. ``state`` int64 (STATES,) is updated.

    ``turn`` is what a count turns, ``cell`` q of the last count, s48q33, and χ what the anchors
    show of this tick, s31q16 cells.
    """
    moved = position - state[POSITION]
    state[POSITION] = position
    if state[KNOWN] != 0:
        return 0
    if moved == 0:
        state[TICKS] = min(state[TICKS] + 1, MOST_TICKS)
        return 0
    back = 1 if moved < 0 else 0
    counts = back == state[BACK] and state[TICKS] < rest_ticks and not contact
    jump_a, jump_b = _jump(chi_a, state[CHI_A]), _jump(chi_b, state[CHI_B])
    state[CHI_A], state[CHI_B] = chi_a, chi_b
    state[BACK], state[TICKS] = back, 0
    if not counts:
        return 0
    size_a, size_b = abs(cell_a), abs(cell_b)
    if size_a >= size_b:
        error = jump_b if cell_a < 0 else -jump_b
    else:
        error = -jump_a if cell_b < 0 else jump_a
    if back:
        error = -error
    size = min(abs(jump_a) + abs(jump_b), _BIG - 1)
    state[LEVEL] += (size - state[LEVEL]) >> MEAN_SHIFT
    state[PASSED] = min(state[PASSED] + (turn if turn < HALF_TURN else _MASK + 1 - turn), _MASK)
    by = (error << LOOP_SHIFT) & _MASK
    state[NET] = ((state[NET] + by + HALF_TURN) & _MASK) - HALF_TURN
    if not -LEAST_NET <= state[NET] < LEAST_NET:
        state[FAR] = 1
    if state[PASSED] >= HALF_TURN:
        if state[LEVEL] < FOUND and state[FAR] == 0:
            state[KNOWN] = 1
        state[PASSED] = state[NET] = state[FAR] = 0
    return by
