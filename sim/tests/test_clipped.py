# SPDX-License-Identifier: Apache-2.0
"""Currents beyond the ADC's range or the current word: reported, never a source, not learned."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from wavehaptics.controller import anchor
from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.scene import Scene, find_scene, load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats

SERVO_MOTOR = """
[scene]
name = "servo_motor"
duration_s = 0.25
[motor]
kind = "pmsm"
R_ohm = 39e-3
L_h = 24e-6
pole_pairs = 7
psi_vs = 5.2e-3
J_kgm2 = 1.5e-4
[hand]
path = "press"
amplitude_rad = 0.9
stiffness = 5.0
damping = 0.05
[encoder]
counts_per_rev = 65536
[adc]
bits = 12
full_scale_a = 63
[drive]
bus_v = 24
[controller]
tick_hz = 100e3
lambda = 1e5
walls = [[0.0, 1.0]]
anchor_auto = true
"""
STRONG_MOTOR = """
[scene]
name = "strong_motor"
duration_s = 0.25
[motor]
R_ohm = 16e-3
L_h = 19e-6
k_t = 0.165
J_kgm2 = 0.025
[hand]
path = "press"
amplitude_rad = 0.15
stiffness = 100.0
damping = 2.0
[encoder]
counts_per_rev = 65536
[drive]
bus_v = 60
[controller]
tick_hz = 100e3
lambda = 1e5
walls = [[0.0, 1.0]]
anchor_auto = true
"""
SMALL_ADC = ("adc.full_scale_a=0.4", "controller.anchor_auto=true", "scene.duration_s=0.3")


@pytest.fixture
def clipped_scene(tmp_path: Path):
    """The scenes by name: a brushless motor and one with brushes whose ADC or word is too short."""
    texts = {"servo_motor": SERVO_MOTOR, "strong_motor": STRONG_MOTOR}

    def make(name: str, *sets: str) -> Scene:
        if name in texts:
            path = tmp_path / f"{name}.toml"
            path.write_text(texts[name])
            return load_scene(path, sets)
        return load_scene(find_scene(name), (*SMALL_ADC, *sets))

    return make


# Scene, the force that its largest current makes in N·m.
SCENES = {"servo_motor": 63 * 0.0546, "strong_motor": 64 * 0.165, "press_hold": 0.4 * 0.0234}
RUNGS = [
    (name, rung) for name in SCENES for rung in ("golden", "core", "pins")
    if rung == "pins" or name != "press_hold" or rung == "golden"
]  # fmt: skip


@pytest.mark.parametrize(("name", "rung"), RUNGS)
def test_an_overloaded_wall_holds_with_what_it_has(clipped_scene, name, rung):
    """It gives out nothing, neither trembles nor lets go: it yields to what is beyond its force."""
    result = measure(clipped_scene(name), rung, compare=False)
    force = SCENES[name]
    assert 0.3 < result["clipped_fraction"] < 1.0
    assert result["saturated_fraction"] == 0.0
    # Of the force times the way of the hand no more than rounding and noise.
    assert result["energy_out_max_j"] < 1.3e-3 * force * 0.3
    assert result["hold_torque"] == pytest.approx(-force, rel=0.05)
    assert result["hold_ripple_rms"] < 0.02 * force
    assert result["hold_error"] > 0.5
    assert result["anchor_fault_s"] is None


@pytest.mark.parametrize("name", SCENES)
def test_the_rtl_says_the_same(clipped_scene, name):
    """Word for word, through thousands of clipped periods."""
    scene = clipped_scene(name)
    ticks = round(0.1 * scene.controller.tick_hz)
    found = []
    for rung in ("golden", "core"):
        rows = np.zeros((ticks, len(Column)))
        words = np.zeros((ticks, len(Word)), dtype=np.int64)
        CONTROLLERS[rung](scene).advance(rows, words)
        found.append((rows[:, Column.CLIPPED].copy(), words))
    (clipped, words), (rtl_clipped, rtl_words) = found
    assert clipped.sum() > 1000
    np.testing.assert_array_equal(clipped, rtl_clipped)
    np.testing.assert_array_equal(words, rtl_words)


def works(scene: Scene) -> list[tuple[float, float]]:
    """Of each contact of more than 100 periods what was stored in it and what came back, J."""
    ticks = round(scene.scene.duration_s * scene.controller.tick_hz)
    rows = np.zeros((ticks, len(Column)))
    words = np.zeros((ticks, len(Word)), dtype=np.int64)
    CONTROLLERS["golden"](scene).advance(rows, words)
    power = rows[:, Column.TORQUE] * rows[:, Column.OMEGA] / scene.controller.tick_hz
    ends = np.flatnonzero(np.diff(rows[:, Column.CONTACT])) + 1
    found = []
    for begin, end in itertools.pairwise(ends):
        if rows[begin, Column.CONTACT] and end - begin > 100:
            given = np.cumsum(power[begin:end])
            found.append((-given.min(), given[-1] - given.min()))
    return found


@pytest.mark.parametrize("name", ["servo_motor", "strong_motor"])
def test_an_overload_gives_back_what_it_took(clipped_scene, name):
    """A wall that was pressed in far beyond its force is where it stood, and as stiff, on the way
    out."""
    scene = clipped_scene(name, "hand.path=sine", "hand.frequency_hz=2", "scene.duration_s=0.8")
    (stored, returned), *_ = works(scene)
    assert stored > 0.19 * SCENES[name] * scene.hand.amplitude_rad
    assert 0.95 < returned / stored <= 1.0


def test_it_is_counted_alike_on_every_controller(clipped_scene):
    scene = clipped_scene("strong_motor")
    parts = [measure(scene, rung, compare=False)["clipped_fraction"] for rung in ("golden", "pins")]
    assert parts[0] == pytest.approx(parts[1], rel=0.05)
    for rung in ("analog", "encoder"):
        assert measure(scene, rung, compare=False)["clipped_fraction"] == 0.0
    calm = clipped_scene("strong_motor", "hand.amplitude_rad=0.02")
    assert measure(calm, "golden", compare=False)["clipped_fraction"] == 0.0


def test_field_oriented_control_tells_of_its_samples(clipped_scene):
    scene = clipped_scene("servo_motor", "adc.full_scale_a=20")
    assert 0.0 < measure(scene, "encoder", compare=False)["clipped_fraction"] < 1.0


# ---- The anchor by itself.


def blind_words() -> np.ndarray:
    words = np.zeros(anchor.SETTINGS, dtype=np.int64)
    words[anchor.ENABLE] = 1
    words[anchor.FLUX_GAIN] = words[anchor.OWED_GAIN] = formats.FLUX.to_raw(0.5)
    words[anchor.CELLS_GAIN] = formats.CELLS.to_raw(10.0)
    words[anchor.PULL_GAIN] = formats.PULL.to_raw(0.1)
    words[anchor.LEARN_GAIN] = formats.LEARN.to_raw(0.005)
    words[anchor.ZERO_GAIN] = formats.FLUX.to_raw(0.01)
    words[anchor.REACH] = formats.VOLTAGE.to_raw(2.0)
    words[anchor.STRANGE] = formats.VOLTAGE.to_raw(1.0)
    words[anchor.LEARN_MAX] = formats.PULL.to_raw(1.0)
    words[anchor.FOLLOW_TICKS] = words[anchor.SLOW_TICKS] = 1
    return words


@pytest.mark.parametrize("contact", [False, True])
def test_the_anchor_learns_nothing_of_a_clipped_current(contact):
    """θ, the offset and the mean of the current stay, c is 0; what the waves did is counted."""
    words, state = blind_words(), anchor.new_state()
    ampere = formats.CURRENT.to_raw(0.2)
    for _ in range(200):
        anchor.anchor_step(state, words, 0, contact, ampere, 0, 0, 0, 0, False)
    kept = state[[anchor.THETA, anchor.ZERO, anchor.MEAN]].copy()
    assert kept[0]
    assert kept[2 if contact else 1]
    assert state[anchor.CORRECTION] != 0
    for _ in range(100):
        flux = int(state[anchor.FLUX])
        anchor.anchor_step(
            state, words, 0, contact, 30 * ampere, 1000, 1 << 20, 0, 0, False, True
        )  # fmt: skip
        assert state[anchor.CORRECTION] == 0
        assert state[anchor.FLUX] < flux
    np.testing.assert_array_equal(state[[anchor.THETA, anchor.ZERO, anchor.MEAN]], kept)
    assert state[anchor.FAULT] == 0
    anchor.anchor_step(state, words, 0, contact, ampere, 0, 0, 0, 0, False)
    assert state[anchor.CORRECTION] != 0


def test_an_overload_is_no_lost_rotor():
    """While c corrects what an overload has left, its limit is no fault; later on, it is."""
    words, state = blind_words(), anchor.new_state()
    words[anchor.FOLLOW_TICKS] = 4
    wave = formats.WAVE.to_raw(100.0)

    def tick(u: int, blind: bool = False) -> None:
        anchor.anchor_step(state, words, 0, True, 0, u, 0, 0, 0, False, blind)

    tick(0)
    tick(wave, blind=True)
    assert state[anchor.CHI] < -40 << formats.LONG.fraction
    left = state.copy()
    for _ in range(4 * (anchor.EXCUSED - 1)):
        tick(0)
        assert state[anchor.CLIPPED] == 1
    assert state[anchor.FAULT] == 0
    for _ in range(4):
        tick(0)
    assert state[anchor.FAULT] == 1
    state[:] = left
    tick(-wave)
    tick(0)
    assert state[anchor.CLIPPED] == 0
    tick(wave)
    assert state[anchor.FAULT] == 1


@pytest.mark.parametrize("side", [1, -1])
def test_a_flux_near_its_word_s_end_is_a_lost_rotor(side):
    """Else it would wrap, and c would pull the wrong way; also with the voltage at its limit."""
    words, state = blind_words(), anchor.new_state()
    for n in range(20_000):
        anchor.anchor_step(state, words, side * n, True, 0, 0, 0, 0, 0, True)
        if state[anchor.FAULT] != 0:
            break
        assert n == 0 or side * state[anchor.CORRECTION] <= 0  # before an edge no side is known
    assert state[anchor.FAULT] == 1
    # The whole cells that the outer half of the range begins with, at either end.
    assert state[anchor.CHI] >> formats.LONG.fraction in (1 << 13, -(1 << 13) - 1)
    assert state[anchor.CORRECTION] == 0
