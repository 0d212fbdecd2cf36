# SPDX-License-Identifier: Apache-2.0
"""`golden` and `core` in the loop: the same words, and what a stopped encoder tells them."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.ladder.run import measure
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.scene import Scene, find_scene, load_scene
from wavehaptics.trace.columns import Column, Word

PLAIN = "controller.anchor_auto=false"


def scene(name: str, *sets: str) -> Scene:
    return load_scene(find_scene(name), list(sets))


def run(loaded: Scene, ticks: int, *, rtl: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Rows and words of so many ticks."""
    rows, words = np.zeros((ticks, len(Column))), np.zeros((ticks, len(Word)), dtype=np.int64)
    SampledSimulation(loaded, rtl=rtl).advance(rows, words)
    return rows, words


@pytest.mark.parametrize("name", ["held_wall", "bounce"])
def test_core_is_the_integer_model_word_for_word(name):
    loaded = scene(name)
    golden, core = (run(loaded, 100_000, rtl=rtl) for rtl in (False, True))
    assert np.array_equal(golden[1], core[1])
    assert np.array_equal(golden[0], core[0])
    assert np.count_nonzero(golden[0][:, Column.CONTACT]) > 1000


def test_the_bare_wall_is_lost_to_a_wrong_resistance():
    """What the scene is for: R̂ and gain are 15 % off, and nothing but the waves holds the wall."""
    metrics = measure(scene("held_wall", "scene.duration_s=1", PLAIN), "golden", compare=False)
    lost = metrics["hold_error"] is None or abs(metrics["hold_error"]) > 0.5
    assert lost or metrics["saturated_fraction"] > 0.1


def test_a_stopped_encoder_is_told_nothing_more():
    """From the time on the count stays, on the sampled controllers as at the pins' A and B."""
    stops = scene("held_wall", "encoder.stops_at_s=0.02", "scene.duration_s=0.03")
    whole = scene("held_wall", "scene.duration_s=0.03")
    rows = [run(loaded, 30_000)[0] for loaded in (stops, whole)]
    assert np.array_equal(rows[0][:19_990], rows[1][:19_990])
    assert not np.array_equal(rows[0][20_000:], rows[1][20_000:])
    assert np.ptp(rows[0][20_000:, Column.CONTACT]) == 0
