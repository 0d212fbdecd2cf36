# SPDX-License-Identifier: Apache-2.0
"""What legal settings of a port anchor can push beyond a word ends with it, and never wraps."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.controller import anchor
from wavehaptics.words import formats

TOP = (1 << (formats.DATA_W - 1)) - 1
MOST_GAIN = (1 << (formats.COEF_W - 1)) - 1
COUNT = 1 << formats.LONG.fraction


def settings(**others: int) -> np.ndarray:
    """Settings that do nothing but for those that are named."""
    words = np.zeros(anchor.SETTINGS, dtype=np.int64)
    words[anchor.ENABLE], words[anchor.STRANGE] = 1, TOP
    words[anchor.REACH] = 1 << (formats.DATA_W - 2)
    words[anchor.FOLLOW_TICKS] = 1
    for name, word in others.items():
        words[getattr(anchor, name)] = word
    return words


def step(
    state: np.ndarray, words: np.ndarray, contact: bool = True, current: int = 0,
    saturated: bool = False,
) -> int:  # fmt: skip
    """c after a tick in which nothing moves."""
    anchor.anchor_step(state, words, 0, contact, current, 0, 0, 0, 0, saturated)
    return int(state[anchor.CORRECTION])


def held_state(side: int, counts: float, flux: float = 0.0) -> np.ndarray:
    """A contact with the largest θ, y' = ``side·counts`` and a flux, in counts."""
    state = anchor.new_state()
    step(state, settings(LEARN_MAX=MOST_GAIN))
    state[anchor.COEFFICIENT], state[anchor.THETA] = MOST_GAIN, MOST_GAIN << 17
    state[anchor.MEAN] = round(side * counts * COUNT)
    state[anchor.FLUX] = round(flux * COUNT)
    return state


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("counts", [2.5, 300.0, 8000.0])
def test_what_theta_asks_for_ends_with_the_word(side: int, counts: float) -> None:
    """64 V a count times so many counts; 8,000 of them are more than a long word holds."""
    state = held_state(side, counts)
    assert step(state, settings(LEARN_MAX=MOST_GAIN)) == (TOP if side > 0 else -TOP - 1)


@pytest.mark.parametrize("side", [1, -1])
def test_a_sum_with_the_pull_ends_with_the_word(side: int) -> None:
    """Each is within it: 96 V of θ, and 64 V that the pull is limited to."""
    state = held_state(side, 1.5, flux=-side * 2.5)
    c = step(state, settings(LEARN_MAX=MOST_GAIN, PULL_GAIN=MOST_GAIN))
    assert c == (TOP if side > 0 else -TOP - 1)


@pytest.mark.parametrize("side", [1, -1])
def test_a_pull_beyond_a_long_word_keeps_its_sign(side: int) -> None:
    """64 V a count times 400 counts, of which 64 V are left.

    It is a fault, but while the wave is at its limit and a while after that.
    """
    state = held_state(side, 0.0, flux=side * 400.0)
    c = step(state, settings(PULL_GAIN=MOST_GAIN), saturated=True)
    assert c == -side * (1 << (formats.DATA_W - 2))
    for _ in range(anchor.EXCUSED - 1):
        step(state, settings(PULL_GAIN=MOST_GAIN))
    assert state[anchor.FAULT] == 0
    step(state, settings(PULL_GAIN=MOST_GAIN))
    assert state[anchor.FAULT] == 1


@pytest.mark.parametrize("current", [TOP, -TOP - 1, TOP // 2 + 1])
def test_an_inductor_beyond_the_range_of_the_flux_is_a_fault(current: int) -> None:
    """64 A times 16,384 counts an A: what is left of it in a word may be near 0."""
    state = anchor.new_state()
    step(state, settings(), contact=False)
    step(state, settings(CELLS_GAIN=MOST_GAIN), contact=False, current=current)
    assert state[anchor.FAULT] == 1


@pytest.mark.parametrize("side", [1, -1])
def test_the_offset_stays_in_its_word(side: int) -> None:
    state = anchor.new_state()
    words = settings(ZERO_GAIN=MOST_GAIN, SLOW_TICKS=0)
    before = 0
    for _ in range(60):
        state[anchor.CORRECTION] = -side * (3 << (formats.VOLTAGE.fraction - 1))  # 24 A a tick
        step(state, words, contact=False)
        assert side * state[anchor.OFFSET] >= before
        before = side * int(state[anchor.OFFSET])
    assert before * formats.CURRENT.step == pytest.approx(48.0, abs=1e-5)  # 72 A are no word


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("ago", range(5))
def test_only_a_motor_whose_edge_began_the_contact_knows_where_it_is(side: int, ago: int) -> None:
    """A quarter of a count in its direction; the others of a surface begin in a count's middle."""
    state, words = anchor.new_state(), settings()
    position = 0
    for tick in range(10):
        position += side if tick == 9 - ago else 0
        contact = tick == 9
        anchor.anchor_step(state, words, position, contact, 0, 0, 0, 0, 0, False)
    known = ago < anchor.FRESH_TICKS
    assert state[anchor.FLUX] == (side * COUNT // 4 if known else 0)
