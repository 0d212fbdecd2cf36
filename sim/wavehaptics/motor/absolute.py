# SPDX-License-Identifier: Apache-2.0
"""An absolute encoder that is read now and then: what its reader takes for the count.

At a fixed rate the part takes the angle, adds noise, filters it and rounds it down to its bits. The
reading arrives later. A reader turns readings into counts of one or several of the part's: the
count follows when a reading is beyond an edge by more than the hysteresis::

    count = ⌊(reading − h) / c⌋ if that is more, ⌊(reading + h) / c⌋ if that is less

The tracking filter is that of a servo without a lag at constant speed, (1 + 2τs)/(1 + τs)².
"""

from __future__ import annotations

import math

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene

PERIOD_S, LATENCY_S, NOISE, RATE, SPAN, HYSTERESIS, STOPS_S = range(7)
"""Places in :func:`reading_words`; PERIOD_S is 0 without an absolute encoder, RATE 1/τ or 0.

SPAN is the part's counts in one of the reader's; noise and hysteresis are in the part's.
"""

TAKEN, GIVEN, COUNT, ANGLE, SPEED, RING = range(6)
"""Places in the memory: readings taken and arrived, the count, the filter, and what's under way."""

CUTOFF = math.sqrt(3.0 + math.sqrt(10.0)) / (2 * math.pi)
"""Of (1 + 2τs)/(1 + τs)², times τ: 0.395."""

NOISE_PART = 0.625
"""Noise bandwidth of the same, one-sided, times τ."""


def reading_words(scene: Scene) -> np.ndarray:
    """Constants of :func:`absolute_count`."""
    words = np.zeros(7)
    encoder = scene.encoder
    if encoder is None or not encoder.absolute:
        return words
    assert encoder.bits is not None
    assert encoder.read_hz is not None
    words[PERIOD_S] = 1.0 / encoder.read_hz
    words[LATENCY_S] = encoder.latency_s
    words[NOISE] = encoder.noise_counts
    words[SPAN] = 2**encoder.bits / encoder.counts_per_rev
    words[HYSTERESIS] = encoder.hysteresis_counts
    words[STOPS_S] = math.inf if encoder.stops_at_s is None else encoder.stops_at_s
    if encoder.bandwidth_hz is not None:
        # The noise is what is left of white noise in front of the filter.
        words[RATE] = encoder.bandwidth_hz / CUTOFF
        words[NOISE] *= math.sqrt(max(1.0, 0.5 * encoder.read_hz / (NOISE_PART * words[RATE])))
    return words


def new_readings(x: float, cell: float, words: np.ndarray) -> np.ndarray:
    """Memory of a reader whose count is right where the rotor rests, at ``x`` in rad."""
    under_way = math.ceil(words[LATENCY_S] / words[PERIOD_S]) + 2 if words[PERIOD_S] else 0
    memory = np.zeros(RING + under_way)
    memory[COUNT] = math.floor(x / cell)
    memory[ANGLE] = x / cell * words[SPAN]
    return memory


@compiled(inline="always")
def _mixed(n: int) -> int:
    """A number of 32 bits for each ``n``, as if by chance."""
    mixed = (n + 1) * 0x9E3779B1 & 0xFFFFFFFF
    mixed = (mixed ^ (mixed >> 15)) * 0x85EBCA6B & 0xFFFFFFFF
    mixed = (mixed ^ (mixed >> 13)) * 0xC2B2AE35 & 0xFFFFFFFF
    return mixed ^ (mixed >> 16)


@compiled(inline="always")
def _normal(n: int) -> float:
    """Normal noise of reading ``n``, RMS 1."""
    first, second = _mixed(2 * n) + 0.5, _mixed(2 * n + 1) + 0.5
    share = 1.0 / 4294967296.0
    return math.sqrt(-2.0 * math.log(first * share)) * math.cos(2.0 * math.pi * second * share)


@compiled(inline="always")
def _arrive(time: float, words: np.ndarray, memory: np.ndarray) -> None:
    """Let the count follow the readings that have arrived."""
    span, hysteresis = words[SPAN], words[HYSTERESIS]
    under_way = memory.shape[0] - RING
    while memory[GIVEN] < memory[TAKEN]:
        arrives = memory[GIVEN] * words[PERIOD_S] + words[LATENCY_S]
        if arrives > time:
            break
        reading = memory[RING + int(memory[GIVEN]) % under_way]
        memory[GIVEN] += 1.0
        if arrives < words[STOPS_S]:
            up = math.floor((reading - hysteresis) / span)
            down = math.floor((reading + hysteresis) / span)
            if up > memory[COUNT]:
                memory[COUNT] = up
            elif down < memory[COUNT]:
                memory[COUNT] = down


@compiled()
def absolute_count(
    x: float, time: float, cell: float, words: np.ndarray, memory: np.ndarray
) -> int:
    """The count at ``time`` with the rotor at ``x``; ``memory`` is updated."""
    period = words[PERIOD_S]
    under_way = memory.shape[0] - RING
    while memory[TAKEN] * period <= time:
        number = int(memory[TAKEN])
        angle = x / cell * words[SPAN]
        if words[NOISE] != 0.0:
            angle += words[NOISE] * _normal(number)
        if words[RATE] != 0.0:
            error = angle - memory[ANGLE]
            memory[SPEED] += words[RATE] ** 2 * period * error
            memory[ANGLE] += period * (2.0 * words[RATE] * error + memory[SPEED])
            angle = memory[ANGLE]
        memory[RING + number % under_way] = math.floor(angle)
        memory[TAKEN] += 1.0
        _arrive(time, words, memory)  # makes room for the next
    _arrive(time, words, memory)
    return int(memory[COUNT])
