# SPDX-License-Identifier: Apache-2.0
"""What the fault SATURATED lets be: hands at the voltage limit.

The integer model has no guard, so its law is applied to what the model shows.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from wavehaptics.controller.guard import SATURATED_S, Fault, board_limits
from wavehaptics.controller.ports import controller_ports
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.scene import Scene
from wavehaptics.scene.tables.guard import Guard
from wavehaptics.trace.columns import Column, Word

COUNTS = 10_000
ROW = 16
"""Turns back in a row that are the fault."""


def scene(**hand: Any) -> Scene:
    return Scene.model_validate(
        {
            "scene": {"name": "saturated", "duration_s": 0.5},
            "motor": {"preset": "re25-118743"},
            "hand": {"stiffness": 1.0, "damping": 0.5e-3, **hand},
            "encoder": {"counts_per_rev": COUNTS},
            "adc": {"bits": 12, "full_scale_a": 2.5, "noise_a": 0.6e-3},
            "drive": {"bus_v": 4.0, "limit_v": 3.0},
            "controller": {"tick_hz": 200e3, "extra_ticks": 1, "lambda": 1e4, "anchor_auto": True,
                           "walls": [[0.0, 100.0]]},
        }
    )  # fmt: skip


PRESS = {"path": "press", "amplitude_rad": 0.3}


def longest_row(scene: Scene) -> tuple[float, int]:
    """Share of the time at the limit in contact, and turns back there that follow each other."""
    simulation = SampledSimulation(scene, rtl=False)
    ticks = round(0.5 / simulation.tick_s)
    rows, words = np.zeros((ticks, len(Column))), np.zeros((ticks, len(Word)), dtype=np.int64)
    simulation.advance(rows, words)
    acts = (rows[:, Column.SATURATED] != 0) & (rows[:, Column.CONTACT] != 0)
    moves = np.sign(np.diff(np.floor(rows[:, Column.X] * COUNTS / math.tau), prepend=0.0))
    newest = way = row = longest = at = 0
    for tick in np.flatnonzero(moves):
        direction = int(moves[tick])
        if direction == newest and direction != way:
            near = (tick - at) * simulation.tick_s <= SATURATED_S
            row = (row * near + 1) if acts[tick] else 0
            longest, way, at = max(longest, row), direction, tick
        newest = direction
    return float(acts.mean()), longest


@pytest.mark.parametrize(
    ("hand", "at_the_limit", "most"),
    [
        (PRESS, 0.9, 4),
        ({**PRESS, "damping": 0.0}, 0.9, ROW // 2),
        ({"path": "sine", "amplitude_rad": 0.1, "frequency_hz": 0.5}, 0.5, 4),
        ({"path": "sine", "amplitude_rad": 0.1, "frequency_hz": 12.0}, 0.1, 2),
    ],
)
def test_hands_at_the_limit_turn_back_seldom(hand, at_the_limit, most):
    """A hand beyond the wall: still, without a damper, slowly on, and to and fro."""
    share, longest = longest_row(scene(**hand))
    assert share > at_the_limit
    assert longest <= most


@pytest.mark.parametrize("told", [{}, {"saturated_s": 0.01}, {"saturated_s": 0.0}])
def test_the_limit_is_the_scenes(told):
    values = scene(**PRESS)
    guarded = values.model_copy(update={"guard": Guard(trip_a=2.0, **told)})
    limits = board_limits(guarded, controller_ports(values))
    assert Fault.SATURATED in limits.watched
    assert limits.saturated_s == told.get("saturated_s", SATURATED_S)
