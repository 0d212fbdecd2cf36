# SPDX-License-Identifier: Apache-2.0
"""The integer model of the wave core: against floating point, and what must hold for every word."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wavehaptics.controller import wave_core
from wavehaptics.words import formats

pytestmark = pytest.mark.model

GUARD = formats.STATE_GUARD
ETA_ONE = 1 << formats.ETA.fraction
A_ONE = 1 << formats.A.fraction
WAVE = formats.WAVE
ROOT_PAPER = formats.ROOT.to_raw(math.sqrt(2 * 2.18))
U_MAX = WAVE.raw_max
SEED = 20


def integers_of(format_: formats.Fixed) -> st.SearchStrategy[int]:
    """Words of a format, the corners often."""
    corners = [format_.raw_min, format_.raw_min + 1, -1, 0, 1, format_.raw_max - 1, format_.raw_max]
    return st.sampled_from(corners) | st.integers(format_.raw_min, format_.raw_max)


unhurried = settings(deadline=None)  # the first call compiles

currents = integers_of(formats.CURRENT)
waves = integers_of(WAVE)
roots = st.integers(0, formats.ROOT.raw_max) | st.just(ROOT_PAPER)
etas = st.sampled_from([-ETA_ONE, 0, ETA_ONE]) | st.integers(-ETA_ONE, ETA_ONE)
coefficients = st.sampled_from([1, A_ONE >> 20, A_ONE]) | st.integers(1, A_ONE)
limits = st.sampled_from([0, 1, U_MAX]) | st.integers(0, U_MAX)
ages = st.integers(0, 3)


def state_with(f: int, newest: int) -> tuple[np.ndarray, np.ndarray]:
    """State with f, and a full line whose places all hold ``newest``."""
    state, line = wave_core.new_state(), wave_core.new_line(3)
    state[wave_core.STATE_F] = f
    state[wave_core.STATE_FILLED] = line.size
    line[:] = newest
    return state, line


def s_times(root: int, current: int) -> int:
    """s·i as the core cuts it; Python's integers, as a current may be of any size."""
    shift = formats.ROOT.fraction + formats.CURRENT.fraction - WAVE.fraction
    return wave_core.truncate.py_func(root * current, shift)


def goal_of(eta: int, v: int) -> int:
    return int(wave_core.saturate(wave_core.truncate(eta * v, formats.ETA.fraction)))


@given(st.integers(-(1 << 58), 1 << 58), st.integers(1, 40))
@unhurried
def test_truncation_is_toward_zero_and_only_loses(value: int, bits: int) -> None:
    result = wave_core.truncate(value, bits)
    assert result == abs(value) // 2**bits * (1 if value >= 0 else -1)
    assert 0 <= abs(value) - abs(result) * 2**bits < 2**bits


@given(st.integers(-(1 << 60), 1 << 60))
@unhurried
def test_saturation_limits_and_never_wraps(value: int) -> None:
    assert wave_core.saturate(value) == sorted((WAVE.raw_min, value, WAVE.raw_max))[1]


@given(currents, etas, roots, coefficients, limits, ages, ages, waves, st.data())
@settings(deadline=None, max_examples=1000)
def test_every_word_stays_in_its_format_with_the_right_sign(
    current, eta, root, a, u_max, extra, hold, newest, data
) -> None:
    f = data.draw(st.integers(-u_max << GUARD, u_max << GUARD), label="f")
    state, line = state_with(f, newest)
    e, u_n, v_n = wave_core.wave_core_step(
        state, line, current, eta, 0, root, a, u_max, extra, hold
    )
    for word in (e, u_n, v_n, *line.tolist()):
        assert WAVE.raw_min <= word <= WAVE.raw_max
    assert u_n == newest
    assert abs(state[wave_core.STATE_F]) <= u_max << GUARD
    # Exact in rational numbers, then limited: a wrap would change the sign.
    exact = u_n - root * current / 2 ** (
        formats.ROOT.fraction + formats.CURRENT.fraction - WAVE.fraction
    )
    # Of the largest and the least current only one bound of v is known.
    if current == formats.CURRENT.raw_max:
        exact = min(exact, 0.0)
    if current == formats.CURRENT.raw_min:
        exact = max(exact, 0.0)
    assert abs(v_n - min(max(exact, WAVE.raw_min), WAVE.raw_max)) <= 1
    applied = wave_core.truncate(int(state[wave_core.STATE_F]), GUARD) if hold == 0 else newest
    assert e * applied >= 0


@given(currents, etas, roots, coefficients, limits, waves, st.data())
@settings(deadline=None, max_examples=1000)
def test_f_never_exceeds_what_it_was_and_what_it_follows(
    current, eta, root, a, u_max, newest, data
) -> None:
    """|f'| <= max(|f|, |η v|) and |η v| <= |v|: no word can raise the amplitude of the waves."""
    f = data.draw(st.integers(-u_max << GUARD, u_max << GUARD), label="f")
    state, line = state_with(f, newest)
    _, _, v_n = wave_core.wave_core_step(state, line, current, eta, 0, root, a, u_max, 0, 0)
    goal = goal_of(eta, v_n)
    assert abs(goal) <= abs(v_n)
    after = int(state[wave_core.STATE_F])
    assert abs(after) <= max(abs(f), abs(goal) << GUARD)
    # f' lies between f and its goal, or at the limit.
    low, high = sorted((f, goal << GUARD))
    assert low <= after <= high or abs(after) == u_max << GUARD


@given(currents, st.integers(0, 1 << 40), st.integers(0, 3), roots, waves)
@settings(deadline=None, max_examples=2000)
def test_v_is_no_longer_than_it_is_where_the_current_is_clipped(
    current, beyond, ends, root, newest
) -> None:
    """|v| is at most that of any current that may be the true one, and on the same side of 0."""
    state, line = state_with(0, newest)
    _, u_n, v_n = wave_core.wave_core_step(
        state, line, current, -ETA_ONE, 0, root, A_ONE, U_MAX, 0, 0, ends
    )
    assert u_n == newest
    high = ends & formats.AT_HIGH or current == formats.CURRENT.raw_max
    low = ends & formats.AT_LOW or current == formats.CURRENT.raw_min
    told = u_n - s_times(root, current)
    assert state[wave_core.STATE_CLIPPED] == bool(
        high or low or not WAVE.raw_min <= told <= WAVE.raw_max
    )
    for side in [+1] * bool(high) + [-1] * bool(low) + [0]:
        if side or not (high or low):
            true = u_n - s_times(root, current + side * beyond)
            assert abs(v_n) <= abs(true)
            assert v_n * true >= 0
    if not (high or low):
        assert v_n == min(max(told, WAVE.raw_min), WAVE.raw_max)


@given(currents, etas, roots, waves, waves)
@unhurried
def test_a_of_one_is_exact(current, eta, root, before, newest) -> None:
    """With a = 1 and no bits in the guard, u is η v, if the way there fits a word."""
    state, line = state_with(before << GUARD, newest)
    _, _, v_n = wave_core.wave_core_step(state, line, current, eta, 0, root, A_ONE, U_MAX, 0, 0)
    goal = goal_of(eta, v_n)
    if WAVE.raw_min <= goal - before <= WAVE.raw_max:
        assert state[wave_core.STATE_F] == max(goal, -U_MAX) << GUARD
        assert line[state[wave_core.STATE_HEAD]] == max(goal, -U_MAX)


@given(st.integers(-U_MAX << GUARD, U_MAX << GUARD), currents, etas, roots, coefficients)
@unhurried
def test_a_limit_of_zero_is_silence(f, current, eta, root, a) -> None:
    state, line = state_with(f, 0)
    e, _, _ = wave_core.wave_core_step(state, line, current, eta, 0, root, a, 0, 0, 0)
    assert e == 0
    assert state[wave_core.STATE_F] == 0


@pytest.mark.parametrize("eta", [-ETA_ONE, ETA_ONE, ETA_ONE // 3])
@pytest.mark.parametrize("a", [A_ONE, A_ONE // 100, 1])
def test_zero_stays_zero(eta: int, a: int) -> None:
    state, line = wave_core.new_state(), wave_core.new_line(2)
    for _ in range(1000):
        words = wave_core.wave_core_step(state, line, 0, eta, 0, ROOT_PAPER, a, U_MAX, 2, 1)
        assert words == (0, 0, 0)
    assert state[wave_core.STATE_F] == 0


@pytest.mark.parametrize("eta", [-ETA_ONE, ETA_ONE, -ETA_ONE // 2])
@pytest.mark.parametrize("a", [A_ONE, A_ONE // 3, A_ONE // 1000])
@pytest.mark.parametrize("extra", [0, 1, 5])
def test_without_current_the_waves_only_decay(eta: int, a: int, extra: int) -> None:
    """The largest wave in the line and in f never grows: there is no limit cycle to feed."""
    rng = np.random.default_rng(SEED)
    state, line = wave_core.new_state(), wave_core.new_line(extra)
    for _ in range(20):
        current = int(rng.integers(formats.CURRENT.raw_min, formats.CURRENT.raw_max))
        wave_core.wave_core_step(state, line, current, eta, 0, ROOT_PAPER, a, U_MAX, extra, 0)
    largest = math.inf
    for _ in range(5000):
        wave_core.wave_core_step(state, line, 0, eta, 0, ROOT_PAPER, a, U_MAX, extra, 0)
        now = max(abs(int(state[wave_core.STATE_F])), int(np.abs(line).max()) << GUARD)
        assert now <= largest
        largest = now


@given(st.lists(currents, min_size=1, max_size=40), st.integers(0, 7), st.integers(0, 7))
@unhurried
def test_delay_line(inputs: list[int], extra: int, hold: int) -> None:
    """u_n is the u of ``extra`` steps before the newest, e holds the u of ``hold`` steps ago."""
    state, line = wave_core.new_state(), wave_core.new_line(7)
    shift = formats.ROOT.fraction + WAVE.fraction - formats.VOLTAGE.fraction
    computed: list[int] = []

    def aged(age: int) -> int:
        return computed[-1 - age] if age < len(computed) else 0

    for current in inputs:
        want_u = aged(extra)
        e, u_n, _ = wave_core.wave_core_step(
            state, line, current, -ETA_ONE, 0, ROOT_PAPER, A_ONE // 3, U_MAX, extra, hold
        )
        computed.append(int(wave_core.truncate(int(state[wave_core.STATE_F]), GUARD)))
        assert u_n == want_u
        assert e == wave_core.saturate(wave_core.truncate(ROOT_PAPER * aged(hold), shift))


@pytest.mark.parametrize("extra", [0, 1, 4])
def test_new_line_holds_every_age(extra: int) -> None:
    assert wave_core.new_line(extra).size > extra


@pytest.mark.parametrize("eta", [-1.0, 1.0, -0.3])
@pytest.mark.parametrize("a", [1.0, 0.01, 1e-4])
@pytest.mark.parametrize("extra", [0, 1, 3])
def test_against_floating_point(eta: float, a: float, extra: int) -> None:
    """The tick's equations (:mod:`wavehaptics.controller.wave_core`) in floating point.

    The tolerance follows from the rounding. In the wave's last places: u, s·i, η·v and the error
    of f lose less than 1 each, a·error less than 2^-GUARD. If D bounds the difference of all u so
    far, the error of v is below D + 2, that of the goal below |η| (D + 2) + 1, and so f's grows in
    a step to less than (1 − a) D + a (|η| (D + 2) + 2) + 2^-GUARD <= D + 4 a + 2^-GUARD.
    """
    rng = np.random.default_rng(SEED)
    steps = 3000
    eta_word, a_word = formats.ETA.to_raw(eta), formats.A.to_raw(a)
    eta, a = formats.ETA.to_value(eta_word), formats.A.to_value(a_word)
    s = formats.ROOT.to_value(ROOT_PAPER)
    # With η = 1 and a = 1, f is the sum of all s i: this keeps s f below the voltage's full scale.
    current = rng.uniform(-0.4, 0.4, steps)
    state, line = wave_core.new_state(), wave_core.new_line(extra)
    f, applied = 0.0, [0.0] * (extra + 1)
    bound = 0.0
    largest = 0.0
    for i in current:
        word = formats.CURRENT.to_raw(i)
        e, u_n, v_n = wave_core.wave_core_step(
            state, line, word, eta_word, 0, ROOT_PAPER, a_word, U_MAX, extra, 0
        )
        u_float = applied[-1 - extra]
        v_float = u_float - s * formats.CURRENT.to_value(word)
        f += a * (eta * v_float - f)
        applied.append(f)
        assert abs(WAVE.to_value(u_n) - u_float) <= (bound + 1) * WAVE.step
        assert abs(WAVE.to_value(v_n) - v_float) <= (bound + 2) * WAVE.step
        bound += 4 * a + 2.0**-GUARD
        f_error = abs(int(state[wave_core.STATE_F]) * WAVE.step / (1 << GUARD) - f)
        assert f_error <= bound * WAVE.step
        voltage_error = abs(formats.VOLTAGE.to_value(e) - s * f)
        assert voltage_error <= s * (bound + 1) * WAVE.step + formats.VOLTAGE.step
        largest = max(largest, abs(f))
    assert largest > 10 * bound * WAVE.step, "the input is too small to show anything"


def test_what_rounding_takes_from_u_is_told():
    """In rigid contact Σ(u + v) is what f has changed by, over a, or a held wall would wander.

    Half a place is lost to each truncation of f, always towards zero: 10⁵ places here.
    """
    ticks, rng = 200_000, np.random.default_rng(5)
    a, root = formats.A.to_raw(0.99), formats.ROOT.to_raw(2.0)
    currents = formats.CURRENT.to_raw(0.5) + rng.integers(-20_000, 20_000, ticks)
    state, line = wave_core.new_state(), wave_core.new_line(0)
    total = told = 0
    for current in currents.tolist():
        told += state[wave_core.STATE_WITHHELD]
        _, u, v = wave_core.wave_core_step(
            state, line, current, -ETA_ONE, 0, root, a, formats.WAVE.raw_max, 0, 0
        )
        total += u + v
    lacking = total + state[wave_core.STATE_F] / (1 << formats.STATE_GUARD) / 0.99
    assert abs(lacking) > 50_000
    print(lacking, lacking + told)
    assert abs(lacking + told) < 2000
