# SPDX-License-Identifier: Apache-2.0
"""The settings memory in closed loop: words that change on a running motor, in contact and saturated."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wavehaptics.ladder.device_pins import DevicePins
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.scene import SCENES_DIR, find_scene, load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats
from wavehaptics.words.table import WORDS

BOARD = ("drive.bus_v=12", "adc.bits=12", "adc.full_scale_a=2.5", "encoder.counts_per_rev=10000")
EARLY = (
    "controller.early_duty=true", "controller.extra_ticks=0", "controller.clock_hz=80e6",
    "adc.part=AD7276", "drive.pwm_hz=500e3",
)  # fmt: skip
ANCHOR = ("controller.anchor_auto=true",)


def load(*settings: str):
    return load_scene(find_scene("press_hold"), [*BOARD, *settings])


def run(simulation, ticks: int):
    rows = np.zeros((ticks, len(Column)))
    words = np.zeros((ticks, len(Word)), dtype=np.int64)
    simulation.advance(rows, words)
    return rows, words


@pytest.mark.parametrize("more", [(), ANCHOR, (*ANCHOR, *EARLY)])
def test_a_device_that_is_left_alone_is_the_controller(more):
    """Bit for bit, with all its words from the bus."""
    found = [run(kind(load(*more)), 30_000) for kind in (PinsSimulation, DevicePins)]
    assert np.abs(found[0][1][:, Word.V]).max() > 1000
    np.testing.assert_array_equal(found[0][1], found[1][1])
    np.testing.assert_array_equal(found[0][0], found[1][0])
