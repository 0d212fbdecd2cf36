# SPDX-License-Identifier: Apache-2.0
"""Walls that are left one cell late, with the port anchor, entered from either side."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.ladder.run import CONTROLLERS
from wavehaptics.scene import Scene
from wavehaptics.trace.columns import Column, Word
from wavetools.studies.anchored import cases, runs

SIDES = {"up": "controller.walls=[[0, 1]]", "down": "controller.walls=[[-1, 0]]"}
"""By the direction in which the rotor comes in."""
HOLD = ("hand.path=sine", "hand.frequency_hz=1")
"""The hand rests at its deepest in the one wall after 0.25 s, in the other after 0.75 s."""
HELD_S = {"up": 0.25, "down": 0.75}
TAPS = ("hand.path=sine", "hand.frequency_hz=4")
TREMOR = ("hand.path=sine", "hand.frequency_hz=10", "hand.amplitude_rad=0.005")
"""About a cell to either side of the edge."""
SEEN = 20
"""One tick in so many is looked at."""
WRONG = {
    "nothing": (),
    "brush, gain, offset": ("brushes.drop_v=0.3", "brushes.knee_a=0.02", "drive.gain_error=-0.05",
                            "adc.offset_a=3e-3"),
    "everything": cases.EVERYTHING["everything, −−−−"],
}  # fmt: skip


def ran(controller: str, hysteresis: bool, seconds: float, *settings: str) -> tuple:
    """Scene, rows and words of a run."""
    late = f"controller.edge_hysteresis={str(hysteresis).lower()}"
    scene = runs.load("held_wall", [*cases.NOTHING, *settings, late])
    ticks = round(seconds * scene.controller.tick_hz)
    rows = np.zeros((ticks, len(Column)))
    words = np.zeros((ticks, len(Word)), dtype=np.int64)
    CONTROLLERS[controller](scene).advance(rows, words)
    return scene, rows, words


def moved_cells(scene: Scene, rows: np.ndarray) -> np.ndarray:
    """How far the wall that is felt is from where it stands, cells; of the ticks in contact."""
    return runs.deviations(rows[::SEEN], scene)[1] / runs.cell_of(scene)


def leaves(rows: np.ndarray) -> int:
    return int(np.count_nonzero(np.diff(rows[:, Column.CONTACT]) < 0))


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("side", SIDES)
def test_a_held_wall_is_where_it_is_without(side, wrong):
    settings = (SIDES[side], *HOLD, *WRONG[wrong])
    end = {}
    for hysteresis in (False, True):
        scene, rows, _ = ran("golden", hysteresis, HELD_S[side], *settings)
        last = rows[-5000:]
        assert last[:, Column.CONTACT].min() == 1.0
        assert rows[:, Column.FAULT].max() == 0.0
        cell = runs.cell_of(scene)
        end[hysteresis] = np.array(
            [last[:, Column.X].mean() / cell, moved_cells(scene, last).mean()]
        )
    assert abs(end[False][0]) > 5
    assert np.abs(end[True] - end[False]).max() <= 1.0


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("hand", [TAPS, TREMOR], ids=["taps", "tremor"])
def test_taps_find_the_wall_where_they_do_without(hand, side, wrong):
    """And a finger on the edge never finds it more than its late cell away."""
    settings = (SIDES[side], *hand, *WRONG[wrong])
    most, left = {}, {}
    for hysteresis in (False, True):
        scene, rows, _ = ran("golden", hysteresis, 0.3, *settings)
        rows = rows[1000:]  # where the rotor begins tells nothing of the edge
        assert rows[:, Column.FAULT].max() == 0.0
        most[hysteresis] = np.abs(moved_cells(scene, rows)).max()
        left[hysteresis] = leaves(rows)
    assert most[True] <= most[False] + 1.0
    assert left[True] <= left[False]
    assert hand != TAPS or left[True] >= 1


@pytest.mark.parametrize("hand", [TAPS, TREMOR], ids=["taps", "tremor"])
@pytest.mark.parametrize("side", SIDES)
def test_the_core_does_the_same_to_the_last_word(hand, side):
    settings = (SIDES[side], *hand, *WRONG["brush, gain, offset"])
    _, rows, words = ran("golden", True, 0.3, *settings)
    _, core_rows, core_words = ran("core", True, 0.3, *settings)
    assert 0 < rows[:, Column.CONTACT].mean() < 1
    assert np.array_equal(words, core_words)
    assert np.array_equal(rows[:, Column.FLUX], core_rows[:, Column.FLUX])
    assert np.array_equal(rows[:, Column.CORRECTION], core_rows[:, Column.CORRECTION])
