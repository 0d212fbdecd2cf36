# SPDX-License-Identifier: Apache-2.0
"""What is flashed is what is simulated: whole boards as they were placed, with the motor."""

from __future__ import annotations

import json

import numpy as np
import pytest
from wavehaptics.fpga import board_runs, placed, synthesis
from wavehaptics.fpga.board_simulation import BoardSimulation, bench, board_scene, build
from wavehaptics.fpga.boards import BoardError, load_board
from wavehaptics.fpga.synthesis import SynthesisError
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain
from wavehaptics.trace.columns import Column, Word

BOARDS = ("icebreaker", "ulx3s")
WITHOUT_ANCHOR = "the bitstream has no port anchor, and a bridge's dead time takes the wall away"
EQUAL_S = 0.012
HARD = ("hand.path=taps", "hand.frequency_hz=40", "hand.amplitude_rad=0.05", "hand.stiffness=0.4")
"""A wall that is reached within EQUAL_S."""


@pytest.fixture(scope="module")
def tools() -> Toolchain:
    return Toolchain.of_environment()


@pytest.fixture(scope="module", params=BOARDS)
def boards(request, tools):
    """A board as netlist and as sources; its bitstream is made where there is none of it yet."""
    board = load_board(request.param)
    try:
        netlist = build(board, tools)
    except BoardError:
        synthesis.build_board(board, tools)
        netlist = build(board, tools)
    return netlist, build(board, tools, netlist=False)


def advanced(simulation: BoardSimulation, seconds: float) -> np.ndarray:
    ticks = round(seconds / simulation.tick_s)
    rows = np.zeros((ticks, len(Column)))
    simulation.advance(rows, np.zeros((ticks, len(Word)), dtype=np.int64))
    return rows


def test_netlist_is_the_sources_at_each_clock(boards):
    """From power-up, over the start button's bounces, into the wall, and off by the stop."""
    scene = board_scene(boards[0].board, HARD)
    pieces = []
    for built in boards:
        simulation = BoardSimulation(built, scene)
        seen = [simulation.report()]
        touched = 0.0
        for _ in range(12):
            rows = advanced(simulation, EQUAL_S / 12)
            touched = max(touched, rows[:, Column.X].max())
            seen.append(simulation.report())
        simulation.stop()
        advanced(simulation, 1e-4)
        seen.append(simulation.report())
        pieces.append(seen)
        assert touched > 2 * simulation.settings.cell_rad
        assert seen[-2].running
        assert not seen[-1].running
    netlist, sources = pieces
    assert netlist == sources
    assert netlist[-1].both_on == netlist[-1].idle_on == netlist[-2].irregular == 0
    assert len({report.seen for report in netlist}) == len(netlist)


def test_netlist_taps(boards):
    """The closed form's stiffness, with a motor that is what the board takes it for."""
    netlist, _ = boards
    if not netlist.board.scene.controller.anchored:
        pytest.skip(WITHOUT_ANCHOR)
    found = board_runs.run(netlist, board_runs.tap(netlist.board))
    assert found["stiffness"] == pytest.approx(found["stiffness_predicted"], rel=0.01)
    assert found["pins"]["both_on"] == found["pins"]["idle_on"] == found["pins"]["irregular"] == 0


@pytest.mark.parametrize("sign", [1, -1])
def test_netlist_holds_with_a_real_motor(boards, sign):
    """14 mN·m on brushes of 0.5 V, with everything that is wrong with a motor at once."""
    netlist, _ = boards
    if not netlist.board.scene.controller.anchored:
        pytest.skip(WITHOUT_ANCHOR)
    found = board_runs.run(netlist, board_runs.hold(netlist.board, sign))
    assert found["moved_cells"] <= found["moved_limit_cells"]
    force = found["held_nm"]
    assert force == pytest.approx(board_runs.PRESS_NM, rel=0.1)
    assert found["hold_ripple_rms"] <= board_runs.RIPPLE_PART * force
    assert found["pins"]["both_on"] == found["pins"]["idle_on"] == found["pins"]["irregular"] == 0


def test_a_scene_of_other_settings_is_refused(boards):
    """What the bitstream holds can't be asked for otherwise."""
    netlist, _ = boards
    for setting in ("controller.lambda=2e4", "controller.walls=[[0.1, 100.0]]"):
        with pytest.raises(BoardError, match="other settings than the bitstream"):
            BoardSimulation(netlist, board_scene(netlist.board, (setting,)))


# --- Without a bitstream.


def test_a_bitstream_of_other_settings_is_refused(tmp_path, tools):
    board = load_board("icebreaker")
    folder = tmp_path / synthesis.OUT / board.name
    folder.mkdir(parents=True)
    moved = type(board)(board.name, tmp_path, board.fpga, board.device, board.scene)
    with pytest.raises(BoardError, match="make bitstream BOARD=icebreaker"):
        build(moved, tools)
    (folder / f"{board.name}{synthesis.PLACED_NETLIST}").write_text("{}")
    (folder / "wh_board_settings.vh").write_text("`define WH_BOARD_N 1\n")
    with pytest.raises(BoardError, match="other settings than boards/icebreaker's"):
        build(moved, tools)


def test_a_board_that_cant_be_simulated_is_refused(tools):
    with pytest.raises(BoardError, match="ulx3s_three has 3 motors"):
        build(load_board("ulx3s_three"), tools)
    with pytest.raises(BoardError, match=r"icebreaker: its top has no pin for .*clk.*running"):
        bench(load_board("icebreaker"), {"enc_a": "input", "stop": "input"})


def cell(kind: str, **parameters: str) -> dict:
    return {
        "type": kind, "parameters": parameters, "attributes": {},
        "port_directions": {"B": "inout", "O": "output"}, "connections": {"B": [2], "O": [3]},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("cells", "says"),
    [
        ({"ram": cell("DP16KD")}, "no model of the placed cell DP16KD"),
        ({"pad": cell("TRELLIS_IO", DIR="BIDIR")}, "no model of the placed pad"),
        ({"pad": cell("TRELLIS_IO", DIR="OUTPUT")}, "no model of the placed pad"),
    ],
)
def test_a_cell_without_a_model_is_refused(tools, cells, says):
    """A pad's direction is the top's, and memories have no model yet."""
    folder = ROOT / "build" / "netlists" / "test"
    folder.mkdir(parents=True, exist_ok=True)
    made = folder / "made.json"
    top = {"ports": {"a": {"direction": "input", "bits": [2]}}, "cells": cells}
    made.write_text(json.dumps({"modules": {"top": top}}))
    with pytest.raises(SynthesisError, match=says):
        placed.placed_verilog(
            "test", "ecp5", made.relative_to(ROOT), folder.relative_to(ROOT), tools
        )
