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

from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats

ANGLE_W = 32
"""Bits of an angle, which make a turn."""
ENTRIES = 256
"""Entries of the table, a quarter of a turn."""
SINE_Q = 16
"""Fraction bits of its words, s18."""

(ANGLE, POSITION, STARTED, PLACE_A, PLACE_B, CELL_A, CELL_B) = range(7)
"""Places in the state: θ at the position's middle, the position in counts, whether there was one,
flux since the first tick and q at the last edge, s48q33 cells."""
STATES = 7
COUNT, ZERO = range(2)
"""Places in the settings: by what a count turns θ, and θ in the middle of count 0."""
SETTINGS = 2

_MASK = (1 << ANGLE_W) - 1
_SHIFT = formats.LONG.fraction - SINE_Q
_LONG_TOP = 1 << (formats.LONG.width - 1)
_LONG_MASK = (1 << formats.LONG.width) - 1
_MOVE = 1 << (formats.MOVE_W - 1)
_INDEX_SHIFT = ANGLE_W - 2 - (ENTRIES.bit_length() - 1)


def sine_table() -> np.ndarray:
    """Sines in the middle of each entry's part of the first quarter, int64 (ENTRIES,), s18q16."""
    middles = (np.arange(ENTRIES) + 0.5) * (0.5 * math.pi / ENTRIES)
    return np.round(np.sin(middles) * (1 << SINE_Q)).astype(np.int64)


def settings(pole_pairs: int, magnet_rad: float, cell_rad: float) -> np.ndarray:
    """Words for a motor whose magnets lie along phase a at ``magnet_rad``, int64 (SETTINGS,)."""
    count = pole_pairs * cell_rad / (2.0 * math.pi)
    zero = pole_pairs * (0.5 * cell_rad - magnet_rad) / (2.0 * math.pi)
    words = [round(math.fmod(turns, 1.0) * 2.0**ANGLE_W) & _MASK for turns in (count, zero)]
    return np.array(words, dtype=np.int64)


def new_state() -> np.ndarray:
    """State after reset: int64, shape (STATES,)."""
    return np.zeros(STATES, dtype=np.int64)


@compiled(inline="always")
def _sine(table, angle):
    """sin θ of the table, s18q16."""
    index = (angle >> _INDEX_SHIFT) & (ENTRIES - 1)
    if angle & (1 << (ANGLE_W - 2)):
        index = ENTRIES - 1 - index
    value = table[index]
    return -value if angle & (1 << (ANGLE_W - 1)) else value


@compiled(inline="always")
def _long(value):
    return ((value + _LONG_TOP) & _LONG_MASK) - _LONG_TOP


@compiled()
def rotor_flux_step(state: np.ndarray, words: np.ndarray, table: np.ndarray, position: int):
    """Pass one count after the other to ``position``; (counts moved, flux of α, of β).

    The fluxes are s48q33 cells. ``state`` int64 (STATES,) is updated; ``table`` is
    :func:`sine_table`'s.
    """
    moved = 0
    if state[STARTED] == 0:
        state[STARTED] = 1
        state[ANGLE] = (words[ZERO] + position * words[COUNT]) & _MASK
        state[CELL_A] = -_sine(table, state[ANGLE]) << _SHIFT
        state[CELL_B] = _sine(table, state[ANGLE] + (1 << (ANGLE_W - 2))) << _SHIFT
    else:
        moved = ((position - state[POSITION] + _MOVE) & (2 * _MOVE - 1)) - _MOVE
    state[POSITION] = position
    flux_a = flux_b = 0
    turn = words[COUNT]
    for _ in range(abs(moved)):
        back = moved < 0
        edge = (state[ANGLE] - (turn >> 1) if back else state[ANGLE] + ((turn + 1) >> 1)) & _MASK
        state[ANGLE] = (state[ANGLE] - turn if back else state[ANGLE] + turn) & _MASK
        state[CELL_A] = -_sine(table, edge) << _SHIFT
        state[CELL_B] = _sine(table, edge + (1 << (ANGLE_W - 2))) << _SHIFT
        flux_a += -state[CELL_A] if back else state[CELL_A]
        flux_b += -state[CELL_B] if back else state[CELL_B]
    state[PLACE_A] = _long(state[PLACE_A] + flux_a)
    state[PLACE_B] = _long(state[PLACE_B] + flux_b)
    return moved, flux_a, flux_b
