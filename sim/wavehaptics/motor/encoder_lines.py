# SPDX-License-Identifier: Apache-2.0
"""The encoder's lines as they are: uneven, some of them lost, and cables that come off or swap.

Edge n of an even encoder stands at n cells. Here it is displaced by up to ``uneven`` of a cell, the
same in each revolution. Of the edges of a revolution ``skips_per_rev`` are lost, evenly spaced and
half such a space away from zero: they are passed unseen, in both directions. The count goes
backwards from ``reverses_at_s`` on, and stands still from ``stops_at_s`` on.
"""

from __future__ import annotations

import math

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene

FAULTY, COUNTS, UNEVEN, SKIPS, REVERSES_S, STOPS_S = range(6)
"""Places in :func:`line_words`; FAULTY is 1 where a count is not just the rotor's cell."""

EDGES, SEEN = range(2)
"""Places in the memory: edges that the rotor has passed and that can be seen, and the count."""


def line_words(scene: Scene) -> np.ndarray:
    """Constants of :func:`line_count`."""
    words = np.array([0.0, 1.0, 0.0, 0.0, math.inf, math.inf])
    encoder = scene.encoder
    if encoder is not None:
        words[COUNTS] = encoder.counts_per_rev
        words[UNEVEN] = encoder.uneven
        words[SKIPS] = encoder.skips_per_rev
        if encoder.reverses_at_s is not None:
            words[REVERSES_S] = encoder.reverses_at_s
        if encoder.stops_at_s is not None:
            words[STOPS_S] = encoder.stops_at_s
        reverses = encoder.reverses_at_s is not None
        words[FAULTY] = bool(encoder.uneven or encoder.skips_per_rev or reverses)
    return words


def new_lines(x: float, cell: float, words: np.ndarray) -> np.ndarray:
    """Memory of an encoder whose count is right where the rotor starts, at ``x`` in rad."""
    return np.array([seen_edges(cell_of(x, cell, words), words), math.floor(x / cell)])


@compiled(inline="always")
def edge_place(n: int, words: np.ndarray) -> float:
    """Where edge ``n`` stands, in cells."""
    if words[UNEVEN] == 0.0:
        return float(n)
    mixed = (n % int(words[COUNTS]) + 1) * 0x9E3779B1 & 0xFFFFFFFF
    mixed = (mixed ^ (mixed >> 15)) * 0x85EBCA6B & 0xFFFFFFFF
    mixed = (mixed ^ (mixed >> 13)) * 0xC2B2AE35 & 0xFFFFFFFF
    mixed ^= mixed >> 16
    place: float = n + words[UNEVEN] * (mixed / 2147483648.0 - 1.0)
    return place


@compiled(inline="always")
def cell_of(x: float, cell: float, words: np.ndarray) -> int:
    """Number of the edge below ``x``."""
    place = x / cell
    # Displaced by less than half a cell, only the nearest edge can be on the other side.
    nearest = int(np.floor(place + 0.5))
    return nearest if place >= edge_place(nearest, words) else nearest - 1


@compiled(inline="always")
def seen_edges(n: int, words: np.ndarray) -> int:
    """Edges from zero to ``n`` without those that are lost."""
    return n - int(np.floor(n * words[SKIPS] / words[COUNTS] + 0.5))


@compiled()
def line_count(x: float, time: float, cell: float, words: np.ndarray, memory: np.ndarray) -> int:
    """The encoder's count with the rotor at ``x``; ``memory`` int64 (2,) is updated."""
    edges = seen_edges(cell_of(x, cell, words), words)
    moved = edges - memory[EDGES]
    memory[EDGES] = edges
    if time < words[STOPS_S]:
        memory[SEEN] += moved if time < words[REVERSES_S] else -moved
    count: int = memory[SEEN]
    return count
