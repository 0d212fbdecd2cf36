# SPDX-License-Identifier: Apache-2.0
"""Scenes on ``rtl/wh_device.v`` whose words are changed while they run."""

from __future__ import annotations

import numpy as np
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.scene import Scene, find_scene, load_scene
from wavehaptics.trace.columns import Column, Word

BOARD = ("drive.bus_v=12", "adc.bits=12", "adc.full_scale_a=2.5", "encoder.counts_per_rev=10000")
ANCHOR = ("controller.anchor_auto=true",)
FEEL = (
    "controller.extra_ticks=2",
    "shaper.feel=layer",
    "shaper.stiffness=0.5",
    "shaper.damping=0.1e-3",
)
OTHER_FEEL = (
    "controller.extra_ticks=2",
    "shaper.feel=layer",
    "shaper.stiffness=0.2",
    "shaper.damping=0.4e-3",
)


def copied_clocks(sections: int = 0) -> int:
    """Clocks in which a commit copies the settings of one motor, from whose end on they count.

    A request in that time is a clock more: ``rtl/wh_registers.v``.
    """
    return 96 + (152 if sections else 128)


def load(*settings: str) -> Scene:
    """The scene that presses and holds, at a board's bus, ADC and encoder."""
    return load_scene(find_scene("press_hold"), [*BOARD, *settings])


def run(simulation: PinsSimulation, ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and words of the next ticks."""
    rows = np.zeros((ticks, len(Column)))
    words = np.zeros((ticks, len(Word)), dtype=np.int64)
    simulation.advance(rows, words)
    return rows, words
