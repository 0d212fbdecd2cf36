# SPDX-License-Identifier: Apache-2.0
"""What the port anchor's voltage can give, with everything switched at random for 10⁷ ticks."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.controller import anchor, wave_core
from wavehaptics.controller.normalised import quantise, realise
from wavehaptics.controller.settings import settings
from wavehaptics.laws.reflection import Wish, reflection
from wavehaptics.motor.plant import OMEGA, I, Plant, X, load_words
from wavehaptics.motor.sensor import Sensor, current_word
from wavehaptics.motor.step import motor_parts, motor_step
from wavehaptics.runtime.compiled import compiled_counting
from wavehaptics.trace.columns import Column
from wavehaptics.trace.metrics import Metrics
from wavehaptics.words import formats

SEED = 21
TICKS = 2_500_000
CHUNK = 1 << 16
VOLT, ROOT_WATT = formats.VOLTAGE.step, formats.WAVE.step
ONE = 1 << formats.ETA.fraction
HAND = ("hand.path=sine", "hand.amplitude_rad=0.2", "hand.frequency_hz=9", "hand.stiffness=2",
        "hand.damping=1e-3", "encoder.counts_per_rev=10000", "drive.limit_v=12", "adc.bits=12",
        "adc.full_scale_a=5", "adc.noise_a=1e-3", "controller.lambda=1e9",
        "controller.anchor_auto=true", "controller.walls=[[0.0, 1.0]]")  # fmt: skip
BRUSHES = ("brushes.drop_v=0.3", "brushes.knee_a=50e-3", "brushes.segments=22",
           "brushes.ripple=0.04")  # fmt: skip
R_OHM = 2.18


@compiled_counting()
def seed_generator(seed):
    np.random.seed(seed)


@compiled_counting(error_model="numpy")
def switched(
    rows, kept, words, states, ints, state, core, line, held, held_words, load, matrix, parts, dt,
    cell, gain, sensor, noise,
):  # fmt: skip
    """Fill rows; every 1 to 4000 ticks other settings: contact, η, W, whose state is emptied.

    A contact that begins and ends anywhere looks like a lost encoder: the fault is taken back, so
    that the correction goes on.
    """
    root, a, u_max, extra = ints
    for n in range(rows.shape[0]):
        if kept[0] == 0:
            kept[0] = np.random.randint(1, 4000)
            kept[1] = np.random.randint(0, 2)
            kept[2] = -ONE if kept[1] else ONE
            if np.random.random() < 0.3:
                kept[2] = np.random.randint(-ONE, ONE + 1)
            kept[3] = wave_core.SHAPE if kept[1] and np.random.random() < 0.3 else wave_core.CLEAR
        kept[0] -= 1
        e_a = kept[4] * VOLT * gain
        x = state[X]
        charge, square = motor_step(state, matrix, dt, e_a, load, parts)
        current = current_word(charge / dt, sensor, noise[n])
        current = wave_core.saturate(current - held[anchor.OFFSET])
        position = int(np.floor(state[X] / cell))
        withheld, saturated = core[wave_core.STATE_WITHHELD], core[wave_core.STATE_SATURATED] != 0
        e_next, u, v = wave_core.shaped_core_step(
            core, line, words, states, kept[3], current, kept[2], 0,
            root, a, u_max, extra, extra,
        )  # fmt: skip
        c = held[anchor.CORRECTION]
        anchor.anchor_step(
            held, held_words, position, kept[1] == 1, current, u, v, withheld, kept[5], saturated
        )
        kept[5] = e_next
        kept[4] = wave_core.saturate(e_next + c)
        row = rows[n]
        row[Column.X] = 0.5 * (x + state[X])
        row[Column.OMEGA] = (state[X] - x) / dt
        row[Column.I] = charge / dt
        row[Column.U], row[Column.V] = u * ROOT_WATT, v * ROOT_WATT
        row[Column.CONTACT] = kept[1]
        row[Column.ENERGY_OUT] = e_a * charge - R_OHM * square
        row[Column.CORRECTION] = held[anchor.CORRECTION] * VOLT
        held[anchor.FAULT] = 0


def run(make_scene, *sets: str, ticks: int = TICKS):
    """(metrics, most of ω and i, ticks with a correction above 10 mV) of a random run."""
    scene = make_scene(*HAND, *sets)
    set_, plant = settings(scene), Plant.of_scene(scene)
    dt = set_.tick_s
    assert plant.substeps(dt) == 1
    wish = Wish(0.0, 0.1e-3, 0.45, 2.26)
    words = np.array([quantise(realise(*reflection(wish, 0.25e-3), dt))])
    metrics = Metrics(scene, dt, controller="golden", walls=[(0.0, 1.0)], root=set_.s)
    rng = np.random.default_rng(SEED)
    seed_generator(SEED)
    rows, kept = np.zeros((CHUNK, len(Column))), np.zeros(6, dtype=np.int64)
    state, core = plant.start.copy(), wave_core.new_state()
    line, held = wave_core.new_line(set_.extra_ticks), anchor.new_state()
    ints = (set_.root, set_.a, set_.u_max, set_.extra_ticks)
    gain = 1.0 + (scene.drive.gain_error if scene.drive else 0.0)
    fastest, most, corrected = 0.0, 0.0, 0
    for _ in range(ticks // CHUNK):
        switched(
            rows, kept, words, wave_core.new_shaper_state(len(words)), ints, state, core, line,
            held, set_.anchor, load_words(plant), plant.transition(dt), motor_parts(plant), dt,
            set_.cell_rad, gain, Sensor.of_scene(scene).constants(), rng.standard_normal(CHUNK),
        )  # fmt: skip
        metrics.update(rows)
        fastest = max(fastest, abs(state[OMEGA]))
        most = max(most, abs(state[I]))
        corrected += np.count_nonzero(np.abs(rows[:, Column.CORRECTION]) > 0.01)
    return metrics.result(), fastest, most, corrected


@pytest.mark.parametrize(
    "wrong",
    [
        (),
        (*BRUSHES, "controller.r_hat=2.4", "drive.gain_error=0.05", "adc.offset_a=4e-3"),
        (*BRUSHES, "controller.r_hat=1.96", "drive.gain_error=-0.05", "adc.offset_a=-4e-3"),
        ("controller.r_hat=2.4", "controller.l_hat=0.264e-3", "controller.k_t_hat=25.7e-3"),
    ],
    ids=["nothing", "high", "low", "hats"],
)
def test_what_the_correction_gives_is_bounded(make_scene, wrong):
    result, fastest, most, corrected = run(make_scene, *wrong)
    print(SEED, {key: result[key] for key in ("correction_out_max_j", "correction_bound_j",
          "energy_out_max_j")}, fastest, most, corrected)  # fmt: skip
    assert result["correction_out_max_j"] <= result["correction_bound_j"]
    assert fastest > 1.0
    assert most > 0.1
    assert corrected > TICKS / 20
