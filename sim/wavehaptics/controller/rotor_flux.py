# SPDX-License-Identifier: Apache-2.0
"""How the magnets' flux changes from count to count of the encoder, as integers.

A brushless motor's port anchors compare each axis' flux with the encoder
(:mod:`wavehaptics.controller.anchor`), in cells of it: one count changes the flux by the vector
``q = (−sin θ, cos θ)`` of that length, where ``θ = p (x − x_0)`` is the electrical angle of the
edge between two counts, and x_0 where the magnets lie along phase a. So counts add up to what the
rotor has done to both axes, and the same way back takes off the very words that were added.

The angle is a word of 2³² to the turn; its highest places choose an entry of a quarter of a sine.
Half an entry of :data:`ENTRIES` is 3 mrad; an angle that is wrong by 5° still moves a held wall by
nothing to speak of, as an error across q pushes along the magnets.
"""

from __future__ import annotations

import math

import numpy as np

from wavehaptics.controller.anchor import long_word
from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats

ANGLE_W = 32
"""Bits of an angle, which make a turn."""
ENTRIES = 256
"""Entries of the table, a quarter of a turn."""
SINE_Q = 15
"""Fraction bits of its words."""
SHIFT = formats.LONG.fraction - SINE_Q
"""More of them has an anchor's flux."""

(ANGLE, POSITION, PLACE_A, PLACE_B, CELL_A, CELL_B) = range(6)
"""Places in the state: θ at the middle of a count, the count, all flux since the first, modulo 2^15
cells, and q of the last edge; the latter two of each axis, s48q33 cells."""
STATES = 6

_MASK = (1 << ANGLE_W) - 1
_QUARTER = 1 << (ANGLE_W - 2)
_INDEX_SHIFT = ANGLE_W - 2 - (ENTRIES.bit_length() - 1)


def sine_table() -> np.ndarray:
    """Sines in the middle of each entry's part of the first quarter, int64 (ENTRIES,), u16q15."""
    middles = (np.arange(ENTRIES) + 0.5) * (0.5 * math.pi / ENTRIES)
    sines: np.ndarray = np.round(np.sin(middles) * (1 << SINE_Q)).astype(np.int64)
    return sines


def angle_word(turns: float) -> int:
    """Word of an angle in turns."""
    return round(math.fmod(turns, 1.0) * 2.0**ANGLE_W) & _MASK


def count_word(pole_pairs: int, cell_rad: float) -> int:
    """Word of the angle by which a count turns the magnets of ``pole_pairs``."""
    return angle_word(pole_pairs * cell_rad / (2.0 * math.pi))


def zero_word(pole_pairs: int, cell_rad: float, magnet_rad: float, position: int) -> int:
    """Word of θ in the middle of the count ``position``, where all begins."""
    x = (position + 0.5) * cell_rad
    return angle_word(pole_pairs * (x - magnet_rad) / (2.0 * math.pi))


def new_state(position: int, zero: int) -> np.ndarray:
    """State after reset at a position whose angle's word is ``zero``: int64, shape (STATES,)."""
    state = np.zeros(STATES, dtype=np.int64)
    state[POSITION], state[ANGLE] = position, zero
    return state


@compiled(inline="always")
def _sine(table: np.ndarray, angle: int) -> int:
    """sin θ, s17q15."""
    index = (angle >> _INDEX_SHIFT) & (ENTRIES - 1)
    if angle & _QUARTER:
        index = ENTRIES - 1 - index
    value: int = table[index]
    return -value if angle & (2 * _QUARTER) else value


@compiled()
def turn_by(state: np.ndarray, by: int) -> None:
    """Turn θ of all that comes by a word, as what finds the magnets asks for."""
    state[ANGLE] = (state[ANGLE] + by) & _MASK


@compiled()
def rotor_flux_step(state: np.ndarray, turn: int, table: np.ndarray, position: int) -> None:
    """Pass one count after the other to ``position``; ``state`` int64 (STATES,) is updated.

    ``turn`` is :func:`count_word`'s, ``table`` :func:`sine_table`'s.
    """
    while state[POSITION] != position:
        back = position < state[POSITION]
        angle = state[ANGLE]
        edge = (angle - (turn >> 1) if back else angle + ((turn + 1) >> 1)) & _MASK
        cell_a = -_sine(table, edge) << SHIFT
        cell_b = _sine(table, edge + _QUARTER) << SHIFT
        way = -1 if back else 1
        state[POSITION] += way
        state[ANGLE] = (angle + way * turn) & _MASK
        state[PLACE_A] = long_word(state[PLACE_A] + way * cell_a)
        state[PLACE_B] = long_word(state[PLACE_B] + way * cell_b)
        state[CELL_A], state[CELL_B] = cell_a, cell_b
