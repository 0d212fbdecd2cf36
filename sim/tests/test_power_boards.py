# SPDX-License-Identifier: Apache-2.0
"""Boards whose power stage is bought: a tap and a hold on the scale of ± 16.5 A at 25 kHz."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from wavehaptics.fpga.boards import Board, load_board
from wavehaptics.ladder.run import measure
from wavehaptics.scene import Scene, load_scene
from wavehaptics.trace.columns import Column
from wavetools.fpga import board_runs

BRUSHLESS, BRUSHED = "ulx3s_gan", "ulx3s_gan_brushed"
PRESS_TIMES = {BRUSHLESS: 6.0, BRUSHED: 1.0}
"""Of the boards' common press: 43 mN·m in place of 7 for a motor of 128 mN·m."""

RIPPLE = 0.025
"""Of the press, RMS; a hand feels 7 %. At 25 kHz half of the rests are at an edge, which the rotor
crosses to and fro with 2 %."""
OFF = 1.1
"""Times a count and 1 % of the depth that such a rest may be off."""


def held(board: Board, scene: Scene, controller: str) -> dict[str, Any]:
    found = measure(scene, controller, compare=False)
    return found | board_runs.moved(board, found, np.zeros(len(Column)))


def hold(board: Board, sign: int, eighth: int, monkeypatch: pytest.MonkeyPatch) -> Scene:
    """The press with all that may be wrong; of a brushless motor the magnets are known."""
    times, press = PRESS_TIMES[board.name], board_runs.PRESS[board.brushless]
    # The damping that a hand needs grows with the rotor's inertia.
    monkeypatch.setitem(board_runs.PRESS, board.brushless, {
        **press, "stiffness": press["stiffness"] * times,
        "damping": press["damping"] * (2 * times if board.brushless else 1),
    })  # fmt: skip
    if not board.brushless:
        return board_runs.hold(board, sign)
    magnet = 2 * math.pi * eighth / 8 / board.scene.motor.pole_pairs
    monkeypatch.setattr(board_runs, "MAGNET_RAD", magnet)
    scene = board_runs.hold(board, sign)
    known = {"find_magnet": False, "magnet_hat_rad": magnet}
    return scene.model_copy(
        update={
            "controller": scene.controller.model_copy(update=known),
            "adc": scene.adc.model_copy(update={"offset_a": 0.0}),
        }
    )


def at_rest(board: Board, found: dict[str, Any]) -> None:
    """Where its spring says, and quiet."""
    pressed = PRESS_TIMES[board.name] * board_runs.PRESS_NM[board.brushless]
    assert "faults" not in found
    assert found["held_nm"] == pytest.approx(pressed, rel=0.03)
    assert found["moved_cells"] <= OFF * found["moved_limit_cells"]
    assert found["hold_ripple_rms"] <= RIPPLE * pressed


@pytest.mark.parametrize("name", [BRUSHLESS, BRUSHED])
def test_it_taps(name):
    """The board's scene: on its way to the wall a brushless rotor shows where its magnets are.

    The force is 3 counts too large at 25 kHz, of 55 deep, in each of five taps.
    """
    board = load_board(name)
    found = measure(board_runs.without_edges(board.scene), "golden", compare=False)
    assert 0.9 < found["stiffness"] / found["stiffness_predicted"] < 1.05
    assert abs(found["stiffness_zero_rad"]) < 4 * 2 * math.pi / board.scene.encoder.counts_per_rev
    assert abs(found["contact_energy_ratio"]) < 0.15
    assert "faults" not in found


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("eighth", range(8))
def test_a_brushless_motor_is_held(sign, eighth, monkeypatch):
    board = load_board(BRUSHLESS)
    scene = hold(board, sign, eighth, monkeypatch)
    at_rest(board, held(board, board_runs.without_edges(scene), "golden"))


@pytest.mark.parametrize("sign", [1, -1])
def test_a_motor_with_brushes_is_held(sign, monkeypatch):
    board = load_board(BRUSHED)
    scene = hold(board, sign, 0, monkeypatch)
    at_rest(board, held(board, board_runs.without_edges(scene), "golden"))


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "sign", "eighth"),
    [(BRUSHED, 1, 0), (BRUSHED, -1, 0), (BRUSHLESS, 1, 0), (BRUSHLESS, 1, 3)],
)
def test_pins_hold_as_well(name, sign, eighth, monkeypatch):
    """With brushes each edge of 12 V adds 2.4 A at first, and is gone 9.6 µs later."""
    board = load_board(name)
    at_rest(board, held(board, hold(board, sign, eighth, monkeypatch), "pins"))


def test_a_gimbals_motor_is_too_small_for_its_scale():
    """8 mA hide where its magnets are; the page says so. On ± 2.5 A they are found."""
    path = load_board(BRUSHLESS).root / "boards" / BRUSHLESS / "board.toml"
    gimbal = ["motor.preset=gbm2804-100t", "hand.stiffness=0.02", "hand.damping=0.5e-3",
              "controller.tick_hz=100e3", "drive.pwm_hz=100e3"]  # fmt: skip
    fine = ["adc.full_scale_a=2.5", "adc.noise_a=0.6e-3"]
    parts = []
    for sets in (gimbal, [*gimbal, *fine]):
        found = measure(load_scene(path, sets), "golden", compare=False)
        parts.append(found["stiffness"] / found["stiffness_predicted"])
    assert parts[0] < 0.6
    assert parts[1] > 0.9
