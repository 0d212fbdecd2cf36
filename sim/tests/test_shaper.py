# SPDX-License-Identifier: Apache-2.0
"""W: from a wish to words, the proof that they are passive, and what a rounding can do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from scipy import signal
from wavehaptics.controller import wave_core
from wavehaptics.controller.normalised import (
    from_sos,
    is_contractive,
    noise_gain,
    quantise,
    realise,
    response,
)
from wavehaptics.controller.rendered import fragment, report
from wavehaptics.controller.settings import settings
from wavehaptics.laws import closed_forms
from wavehaptics.laws.reflection import Wish, WishError, front_stiffness, reflection, spring_behind
from wavehaptics.scene import SceneError
from wavehaptics.words import formats

pytestmark = pytest.mark.model

SEED = 20
TICK_S = 1e-6
K_T, L, R = 23.4e-3, 0.24e-3, 2.18
B = closed_forms.b_r(K_T, R)
FRONT = front_stiffness(K_T, L, R, 2 * TICK_S)
GUARD_IN_WAVE = formats.STATE_GUARD - formats.SHAPE_HEADROOM
WAVE, STATE = formats.WAVE, formats.SHAPE_STATE
STATE_MAX, STATE_MIN = WAVE.raw_max << formats.STATE_GUARD, WAVE.raw_min << formats.STATE_GUARD

WISHES = {
    "spring": Wish(0.0, 0.0, 0.6, FRONT),
    "soft spring": Wish(0.0, 0.0, 5e-3, FRONT),
    "hard spring": Wish(0.0, 0.0, 80.0, FRONT),
    "spring-damper": Wish(0.0, 2e-4, 0.6, FRONT),
    "damper": Wish(0.0, 1e-4, 0.0, FRONT),
    "mass": Wish(5e-6, 1e-5, 0.0, FRONT),
    "flywheel": Wish(1e-4, 0.0, 0.0, FRONT),
    "resonance": Wish(2e-6, 1e-5, 0.4, FRONT),
    "low resonance": Wish(1e-4, 1e-5, 1e-2, FRONT),
    "undamped": Wish(1e-5, 0.0, 5e-2, FRONT),
}


def words_of(wish: Wish, tick_s: float = TICK_S) -> np.ndarray:
    return quantise(realise(*reflection(wish, B), tick_s))


def gain_word(value: float) -> int:
    return formats.SHAPE.to_raw(value)


def test_reflection_has_the_sign_and_the_size_of_the_physics():
    """Rigid is W = 1 (η = −1 makes it D = −1), nothing is W = −1, B_R itself reflects nothing."""
    rigid, nothing, matched = (Wish(0.0, b, 0.0, FRONT) for b in (1e6 * B, 1e-6 * B, B))
    values = []
    for wish in (rigid, nothing, matched):
        top, bottom = reflection(wish, B)
        values.append(np.polyval(top, 1j) / np.polyval(bottom, 1j))
    assert values[0] == pytest.approx(1.0, abs=1e-5)
    assert values[1] == pytest.approx(-1.0, abs=1e-5)
    assert values[2] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", WISHES)
def test_words_render_the_wish_and_are_contractive(name):
    """W of the words against the wish's own, bilinear, from 0.1 Hz to 5 kHz; exact contraction."""
    top, bottom = reflection(WISHES[name], B)
    words = words_of(WISHES[name])
    assert is_contractive(words)
    hertz = np.geomspace(0.1, 5e3, 300)
    turn = 2 * math.pi * hertz * TICK_S
    s = 2j / TICK_S * np.tan(0.5 * turn)
    want = np.polyval(top, s) / np.polyval(bottom, s)
    got = response(words, turn)
    assert np.abs(got).max() <= 1.0 + 1e-12
    # Words are some last places off, and W by that over the distance of its poles from z = 1.
    poles = [p for p in np.roots(np.trim_zeros(bottom, "f")) * TICK_S if p]
    distance = min((abs(p.real) for p in poles), default=1.0)
    assert np.abs(got - want).max() < 8 * formats.SHAPE.step / distance + 1e-6


@pytest.mark.parametrize("name", WISHES)
@pytest.mark.parametrize("tick_s", [0.5e-6, 1e-6, 5e-5, 1e-3])
def test_no_word_can_grow(name, tick_s):
    """The proof is sharp: every word that moves outward by a little breaks it, or the next one."""
    words = words_of(WISHES[name], tick_s)
    assert is_contractive(words)
    # 1e-4 is beyond all slack that the shrinking left; it must be seen.
    grown = words.copy()
    step = gain_word(1e-4)
    for place in (wave_core.B1, wave_core.C1, wave_core.D):
        grown[place] += step if grown[place] >= 0 else -step
    if abs(int(grown[wave_core.D])) + abs(int(grown[wave_core.B1])) > 0 and name != "damper":
        assert not is_contractive(grown)


def test_sos_is_rendered_as_given_and_refused_at_its_frequency():
    """A band stop of scipy's is taken; a resonant low pass is refused where it peaks."""
    notch = np.concatenate(signal.iirnotch(120.0, 2.0, fs=1e6))
    words = quantise(realise(*from_sos(notch), 2.0))
    turn = 2 * math.pi * np.geomspace(1.0, 4e5, 200) / 1e6
    want = signal.freqz(notch[:3], notch[3:], worN=turn)[1]
    assert np.abs(response(words, turn) - want).max() < 1e-5
    low_pass = signal.iirfilter(
        2, 1000.0, rp=3.0, btype="low", ftype="cheby1", fs=1e4, output="sos"
    )
    quantise(realise(*from_sos(low_pass[0]), 2.0))  # 0 dB at its peaks
    low_pass[0, :3] *= 1.01
    with pytest.raises(WishError, match=r"\|D\| is 1\.0\d* at 0\.\d+ Hz") as refusal:
        realise(*from_sos(low_pass[0]), 2.0)
    found = float(str(refusal.value).split(" at ")[1].split(" Hz")[0]) * 2.0 * 1e4
    hertz = np.linspace(1.0, 4999.0, 20_000)
    gain = np.abs(signal.freqz(low_pass[0, :3], low_pass[0, 3:], worN=hertz, fs=1e4)[1])
    # Bilinear's own frequency scale: tan.
    warped = math.atan(math.pi * found / 1e4) * 1e4 / math.pi
    assert warped == pytest.approx(hertz[gain.argmax()], rel=0.01)


@pytest.mark.parametrize(
    "row", [[1, 0, 0, 1, -2, 1], [1, 0, 0, 1, 0, 1.5], [0.1, 0, 0, 1, -1.9, 1.0]]
)
def test_unstable_sos_is_refused(row):
    with pytest.raises(WishError, match="not stable"):
        realise(*from_sos(row), 2.0)


def test_nothing_stiffer_than_the_motor():
    assert spring_behind(0.5, FRONT) == pytest.approx(1 / (1 / 0.5 - 1 / FRONT))
    with pytest.raises(WishError, match="K_L,eff"):
        spring_behind(FRONT, FRONT)


# ---- The energy of every tick, in integers.

corners = [STATE_MIN, STATE_MIN + 1, -513, -512, -1, 0, 1, 255, 256, 511, 512, STATE_MAX]
states = st.sampled_from(corners) | st.integers(STATE_MIN, STATE_MAX)
small_states = st.integers(-(1 << 12), 1 << 12)
waves = st.sampled_from([WAVE.raw_min, -1, 0, 1, WAVE.raw_max]) | st.integers(
    WAVE.raw_min, WAVE.raw_max
)
sections = st.sampled_from([words_of(wish) for wish in WISHES.values()]) | st.sampled_from(
    [words_of(wish, 1e-4) for wish in WISHES.values()]
)


def budget(states: np.ndarray) -> int:
    """What W was paid less what it gave, in squares of a wave's last place."""
    return (int(states[-1, 0]) << formats.DATA_W) + int(states[-1, 1])


def energy(x: np.ndarray, wave: int) -> int:
    """|x|² + wave², in the squares of a state's last place, without rounding."""
    return sum(int(word) ** 2 for word in x) + (int(wave) << GUARD_IN_WAVE) ** 2


@given(sections, states | small_states, states | small_states, waves)
@hypothesis_settings(deadline=None, max_examples=2000)
def test_no_tick_gives_out_energy(words, x1, x2, v):
    """|x'|² + y² ≤ |x|² + v² in whole numbers, for any state and any wave."""
    x = np.array([x1, x2])
    before = energy(x, v)
    y = wave_core.shaper_section(words, x, v)
    assert energy(x, y) <= before
    assert WAVE.raw_min <= y <= WAVE.raw_max
    assert all(STATE_MIN <= word <= STATE_MAX for word in x.tolist())


@pytest.mark.parametrize("tick_s", [TICK_S, 1e-4])
@pytest.mark.parametrize("name", WISHES)
def test_words_of_a_wish_never_owe(name, tick_s):
    """The budget of a contractive W is what its states hold, or more: nobody ever meets it."""
    words = words_of(WISHES[name], tick_s)[None]
    states = wave_core.new_shaper_state(1)
    rng = np.random.default_rng(SEED)
    for size in (2, 10, 20, WAVE.width - 1):
        for _ in range(3000):
            v = int(rng.integers(-(1 << size), 1 << size))
            wave_core.shaper_step(words, states, wave_core.SHAPE, v)
            held = sum(int(word) ** 2 for word in states[0])
            assert budget(states) << (2 * GUARD_IN_WAVE) >= held


@given(
    st.lists(st.integers(formats.SHAPE.raw_min, formats.SHAPE.raw_max), min_size=9, max_size=9),
    st.lists(waves, min_size=1, max_size=60),
    st.lists(st.sampled_from([wave_core.SHAPE, wave_core.HOLD, wave_core.CLEAR]), min_size=60,
             max_size=60),
)  # fmt: skip
@hypothesis_settings(deadline=None, max_examples=500)
def test_no_words_give_out_more_than_came_in(words, taken, modes):
    """Σ y² ≤ Σ v² and one wave's square, whatever W's words are and whenever it stands still."""
    section = np.array([[*words, 0, 0, 0]])
    states = wave_core.new_shaper_state(1)
    rest = 0
    for v, mode in zip(taken, modes, strict=False):
        y = int(wave_core.shaper_step(section, states, mode, v))
        rest += v**2 - y**2
        assert rest >= -(WAVE.raw_min**2)
        assert budget(states) == rest


def test_a_section_alone_would():
    """The check can fail: W = 2 gives out four times what came in."""
    words = np.zeros((1, wave_core.SECTION_WORDS), dtype=np.int64)
    words[0, wave_core.D] = formats.SHAPE.raw_max
    y = wave_core.shaper_section(words[0], np.zeros(2, dtype=np.int64), 1 << 20)
    assert y == pytest.approx(2 << 20, rel=1e-6)
    states = wave_core.new_shaper_state(1)
    given_back = [wave_core.shaper_step(words, states, wave_core.SHAPE, 1 << 20) for _ in range(8)]
    assert given_back == [y, 0, 0, 0] * 2


def test_a_budget_ends_above_what_states_can_hold():
    words = np.zeros((1, wave_core.SECTION_WORDS), dtype=np.int64)
    states = wave_core.new_shaper_state(1)
    most = 1 << (2 * formats.DATA_W + 2 * formats.SHAPE_HEADROOM)
    for _ in range(3000):
        wave_core.shaper_step(words, states, wave_core.SHAPE, WAVE.raw_min)
    assert budget(states) == most - 1
    assert most << (2 * GUARD_IN_WAVE) > 2 * STATE_MIN**2


def test_a_rounding_of_less_loss_would_give_out_energy():
    """The check can fail: without the losses a state is found that gives energy out."""
    words = words_of(WISHES["hard spring"])
    words[wave_core.LOSS1 :] = 0
    rng = np.random.default_rng(SEED)
    found = 0
    for _ in range(20_000):
        x = rng.integers(-(1 << 20), 1 << 20, 2)
        v = int(rng.integers(-(1 << 12), 1 << 12))
        before = energy(x, v)
        y = int(wave_core.shaper_section(words, x, v))
        found += energy(x, y) > before
    assert found > 0


@given(sections, states, states, waves)
@hypothesis_settings(deadline=None, max_examples=300)
def test_no_sum_leaves_64_bits(words, x1, x2, v):
    """The compiled integers wrap at 64 bits; Python's own do not, and say the same."""
    x, whole = np.array([x1, x2]), [x1, x2]
    y = wave_core.shaper_section(words, x, v)
    assert y == wave_core.shaper_section.py_func(words.tolist(), whole, v)
    assert x.tolist() == whole


@pytest.mark.parametrize("name", WISHES)
def test_without_input_the_states_die_away(name):
    """No limit cycle: from anywhere, a filter without input ends at zero or goes on losing."""
    words = words_of(WISHES[name], 1e-4)
    rng = np.random.default_rng(SEED)
    x = rng.integers(STATE_MIN // 8, STATE_MAX // 8, 2)
    if not words[wave_core.B2]:
        x[1] = 0  # a section of one pole has no second state
    if not words[wave_core.B1]:
        x[0] = 0
    last = energy(x, 0)
    for _ in range(400_000):
        wave_core.shaper_section(words, x, 0)
        now = energy(x, 0)
        assert now < last or now == 0
        last = now
        if now == 0:
            break
    else:
        # Lossless ones ring for long, but each tick has lost something.
        assert last < 1e-2 * energy(np.array([STATE_MAX, STATE_MAX]), 0)


# ---- Why this form: noise of candidates at a low corner frequency.


def direct_form_noise(sos: np.ndarray, ticks: int, fraction: int, feedback: bool) -> float:
    """RMS of y's error, √W, of a direct form I with exact coefficients and y kept to ``fraction``
    bits, rounded toward zero, or with first-order error feedback."""
    b, a = sos[:3], sos[3:]
    rng = np.random.default_rng(SEED)
    v = np.round(rng.uniform(-1.0, 1.0, ticks) * 2.0**WAVE.fraction) * WAVE.step
    exact = signal.sosfilt(sos[None], v)
    scale = 2.0**fraction
    y1 = y2 = v1 = v2 = kept = 0.0
    total = 0.0
    for n in range(ticks):
        y = b[0] * v[n] + b[1] * v1 + b[2] * v2 - a[1] * y1 - a[2] * y2 + kept
        cut = math.trunc(y * scale) / scale
        kept = y - cut if feedback else 0.0
        v2, v1, y2, y1 = v1, v[n], y1, cut
        total += (cut - exact[n]) ** 2
    return math.sqrt(total / ticks)


def test_the_normalised_form_has_the_least_noise_at_a_low_corner():
    """70 Hz at 1 MHz, against direct form I, plain and with error feedback, with waves as words.

    The direct forms are given exact coefficients here: only roundings count. At the same words as
    the normalised form has, they are not even the same filter.
    """
    wish = WISHES["resonance"]
    top, bottom = reflection(wish, B)
    b, a = signal.bilinear(top, bottom, fs=1 / TICK_S)
    sos = np.concatenate([b / a[0], a / a[0]])
    ticks = 100_000
    plain = direct_form_noise(sos, ticks, WAVE.fraction, feedback=False)
    feedback = direct_form_noise(sos, ticks, WAVE.fraction, feedback=True)
    words = words_of(wish)
    rng = np.random.default_rng(SEED)
    raw = np.round(rng.uniform(-1.0, 1.0, ticks) * 2.0**WAVE.fraction).astype(np.int64)
    x = np.zeros(2, dtype=np.int64)
    got = np.array([wave_core.shaper_section(words, x, v) for v in raw.tolist()]) * WAVE.step
    w = words[: wave_core.LOSS1] / 2.0**formats.SHAPE.fraction
    matrix = np.array([[1 + w[0], w[1]], [w[2], 1 + w[3]]])
    b_, c_ = (
        np.array([w[wave_core.B1], w[wave_core.B2]]),
        np.array([w[wave_core.C1], w[wave_core.C2]]),
    )
    state, exact = np.zeros(2), np.zeros(ticks)
    for n, v in enumerate(raw * WAVE.step):
        exact[n] = c_ @ state + w[wave_core.D] * v
        state = matrix @ state + b_ * v
    normalised = float(np.sqrt(np.mean((got - exact) ** 2)))
    assert max(noise_gain(words)) <= 1.0
    assert normalised < 10 * WAVE.step
    assert feedback > 3 * normalised
    assert plain > 1000 * normalised
    rounded = np.round(sos * 2.0**formats.SHAPE.fraction)
    turn = 2 * math.pi * np.geomspace(1.0, 1e3, 500) * TICK_S
    want = signal.freqz(sos[:3], sos[3:], worN=turn)[1]
    direct = signal.freqz(rounded[:3], rounded[3:], worN=turn)[1]
    assert np.abs(direct - want).max() > 100 * np.abs(response(words, turn) - want).max()


@pytest.mark.parametrize("name", WISHES)
def test_noise_gain_is_at_most_one_however_low_the_corner(name):
    for tick_s in (0.5e-6, 1e-5, 1e-3):
        assert max(noise_gain(words_of(WISHES[name], tick_s))) <= 1.0 + 1e-9


# ---- A scene's shaper.

SPRING = ("controller.walls=[[0,1]]", "controller.lambda=1e9", "shaper.feel=spring")


def test_a_scenes_spring_is_felt_as_wished(make_scene):
    scene = make_scene(*SPRING, "shaper.stiffness=0.5", "shaper.damping=1e-4")
    found = report(settings(scene), scene.motor.k_t, scene.motor.L_h)
    assert found.static_stiffness == pytest.approx(0.5)
    assert found.felt_error < 0.005
    assert found.worst_gain <= 1.0
    text = fragment(scene, settings(scene), scene.motor.felt_k_t, scene.motor.L_h)
    assert 'feel = "spring"\nstiffness = 0.5\ndamping = 0.0001\n' in text
    assert "contractive" in text


@pytest.mark.parametrize(
    ("wishes", "fragments"),
    [
        ((*SPRING, "shaper.stiffness=2.5"), ("2.5 is stiffer", "K_L,eff = 2.26", "choose less")),
        ((*SPRING,), ("shaper.stiffness is missing",)),
        ((*SPRING, "shaper.stiffness=1", "shaper.mass_kgm2=1e-6"), ("shaper.mass_kgm2 makes no",)),
        ((*SPRING, "shaper.sos=[[1,0,0,1,0,0]]"), ("makes no sense beside sos",)),
        (("shaper.sos=[[1,0,0]]",), ("six numbers",)),
        (("shaper.sos=[[1.1,0,0,1,0,0]]",), ("|D| is 1.1",)),
        (("shaper.sos=[[1,0,0,1,0,2]]",), ("not stable",)),
        (("shaper.damping=1",), ("neither feel nor sos",)),
        (("shaper.feel=mass", "shaper.mass_kgm2=1e-10"), ("less than the delay adds",)),
        ((*SPRING, "shaper.stiffness=1", "shaper.walls=[1]"), ("shaper.walls[0] = 1 is no wall",)),
    ],
)  # fmt: skip
def test_refusals_name_the_cure(make_scene, wishes, fragments):
    with pytest.raises(SceneError) as refusal:
        settings(make_scene(*wishes))
    message = str(refusal.value)
    assert "\n" not in message
    assert ";" in message
    for text in fragments:
        assert text in message
