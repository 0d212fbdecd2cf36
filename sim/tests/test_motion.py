# SPDX-License-Identifier: Apache-2.0
"""OVERSPEED and WINDOW in the running loop: a fault that is injected, and what is refused.

The integer model and the core have no guard: their rotors' counts go through the guard's integers.
`pins` has the RTL's.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from wavehaptics.controller.guard import SPAN, Fault, motion_words, scene_words
from wavehaptics.controller.motion import Motion
from wavehaptics.controller.ports import controller_ports
from wavehaptics.fpga.boards import Board, load_board
from wavehaptics.ladder.run import CONTROLLERS
from wavehaptics.motor.plant import OMEGA
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import Scene, SceneError, load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words.table import Sizes, inputs

COUNTS, TICK_S, BEFORE_RAD, SPEED = 10_000, 5e-6, 0.02, 10.0
CELL_RAD = math.tau / COUNTS
STEP = CELL_RAD / (SPAN * TICK_S)
"""A count a span, rad/s."""


def scene(**limits: Any) -> Scene:
    """A rotor that comes from -20 mrad at 10 rad/s, with nothing in its way."""
    return Scene.model_validate(
        {
            "scene": {"name": "motion", "duration_s": 8e-3},
            "motor": {"preset": "re25-118743"},
            "hand": {"path": "impact", "amplitude_rad": BEFORE_RAD, "speed_rad_s": SPEED},
            "encoder": {"counts_per_rev": COUNTS},
            "adc": {"bits": 12, "full_scale_a": 2.5, "noise_a": 0.6e-3},
            "drive": {"bus_v": 12.0, "pwm_hz": 100e3},
            "guard": {"trip_a": 2.4, **limits},
            "controller": {"tick_hz": 1 / TICK_S, "extra_ticks": 1, "lambda": 1e5},
        }
    )  # fmt: skip


PUSH_AT = 1000
"""Tick of the push, 30 mrad beyond where the rotor began."""


def run(scene: Scene, rung: str, push: float) -> tuple[Any, np.ndarray]:
    """The simulation and its rows; the rotor's speed is multiplied by ``push`` in the midst."""
    simulation = CONTROLLERS[rung](scene)
    ticks = round(scene.scene.duration_s / simulation.tick_s)
    rows, words = np.zeros((ticks, len(Column))), np.zeros((ticks, len(Word)), dtype=np.int64)
    simulation.advance(rows[:PUSH_AT], words[:PUSH_AT])
    simulation._state[OMEGA] *= push
    simulation.advance(rows[PUSH_AT:], words[PUSH_AT:])
    return simulation, rows


def found_in(simulation: Any, scene: Scene, rows: np.ndarray) -> dict[str, float]:
    """Faults and their times: the RTL's, or of the guard's integers and what the rotor did."""
    if hasattr(simulation, "off_s"):
        bits = simulation.faults >> 2
        return {fault.name: simulation.off_s for fault in Fault if bits >> fault & 1}
    ports, found = controller_ports(scene), {}
    model = Motion(**motion_words(scene, ports))
    for row in rows:
        model.period(math.floor(row[Column.X] / CELL_RAD) - ports.start_count)
        for fault, told in ((Fault.OVERSPEED, model.fast), (Fault.WINDOW, model.outside)):
            if told:
                found.setdefault(fault.name, row[Column.T])
    return found


@pytest.mark.parametrize("rung", ["golden", "core", "pins"])
def test_a_push_is_found(rung):
    """Six times the speed: too fast within two spans, and outside as soon as it is there."""
    for limits, allowed_s in (
        ({"overspeed_rad_s": 4 * SPEED}, 2 * SPAN * TICK_S),
        ({"window_rad": (-0.5, 0.06)}, 2 * TICK_S),
    ):
        limited = scene(**limits)
        simulation, rows = run(limited, rung, 6.0)
        begins = PUSH_AT * TICK_S
        if "window_rad" in limits:
            begins = rows[np.argmax(rows[:, Column.X] > 0.06), Column.T]
            assert begins > PUSH_AT * TICK_S
        ((fault, at),) = found_in(simulation, limited, rows).items()
        assert fault == ("WINDOW" if "window_rad" in limits else "OVERSPEED")
        assert -TICK_S <= at - begins <= allowed_s


@pytest.mark.parametrize("rung", ["golden", "pins"])
def test_what_stays_within_is_none(rung):
    limited = scene(overspeed_rad_s=1.05 * SPEED, window_rad=(-0.021, 0.061))
    simulation, rows = run(limited, rung, 1.0)
    assert 0.058 < rows[-1, Column.X] < 0.06
    assert rows[:, Column.OMEGA].max() > 0.95 * SPEED
    assert found_in(simulation, limited, rows) == {}


def words(**limits: Any) -> dict[str, int]:
    values = scene(**limits)
    return motion_words(values, controller_ports(values))


def test_the_words_are_counts():
    start = math.floor(-BEFORE_RAD / CELL_RAD)
    assert words() == {}
    assert words(overspeed_rad_s=40.0) == {"overspeed": math.ceil(40.0 / STEP)}
    assert words(overspeed_rad_s=7 * STEP) == {"overspeed": 7}
    assert words(window_rad=(-0.1, 100 * CELL_RAD)) == {
        "window_low": round(-0.1 / CELL_RAD) - start, "window_high": 99 - start,
    }  # fmt: skip


def test_without_the_keys_the_words_are_as_before():
    """No limit is told, and the registers' defaults are none."""
    values = scene()
    told = scene_words(values, controller_ports(values))
    assert not {"overspeed", "window_low", "window_high"} & set(told)
    found = inputs({}, Sizes())
    assert found["overspeed_i"] == 0
    assert (found["window_low_i"], found["window_high_i"]) == (1 << 31, (1 << 31) - 1)


@pytest.mark.parametrize(
    ("limits", "problem"),
    [
        ({"overspeed_rad_s": 0.9 * STEP}, r"overspeed_rad_s = 0\.44.*a count is 0\.4909 rad/s"),
        ({"overspeed_rad_s": 9e4}, r"give 0\.4909 to 3\.217e\+04, or 0 for no check"),
        ({"window_rad": (0.1, 0.2)}, r"the rotor starts at -0\.02\d* rad, outside of it; make"),
    ],
)
def test_limits_that_counts_cannot_tell_are_refused(limits, problem):
    with pytest.raises(SceneError, match=problem) as refused:
        words(**limits)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("overrides", "problem"),
    [
        (("guard.window_rad=[0.2, 0.1]",), r"window_rad = \[0\.2, 0\.1\] must be \[low, high\]"),
        (("guard.window_rad=[-2000, 0.1]",), r"each -1000 to 1000"),
        (("guard.watch=false", "guard.overspeed_rad_s=9"), r"watched by wh_guard; set guard.watch"),
        (("guard.overspeed_rad_s=-1",), r"guard.overspeed_rad_s"),
    ],
)
def test_keys_that_mean_nothing_are_refused(overrides, problem):
    path = ROOT / "boards" / "ulx3s" / "board.toml"
    with pytest.raises(SceneError, match=problem):
        load_scene(path, ("guard.trip_a=2", *overrides))


def test_a_board_takes_the_words_only_with_a_guard():
    def board(name: str, *overrides: str) -> Board:
        made = load_board(name)
        scene = load_scene(ROOT / made.folder / "board.toml", overrides)
        return Board(made.name, made.root, made.fpga, made.device, scene)

    told = board("ulx3s", "guard.trip_a=2", "guard.window_rad=[-1, 1]").words()
    cell = told.ports.settings.cell_rad
    assert told.words["window_high"] == round(1 / cell) - 1 - told.ports.start_count
    with pytest.raises(SceneError, match=r"the board has no guard; leave"):
        board("icebreaker", "guard.watch=true", "guard.overspeed_rad_s=50").words()
