# SPDX-License-Identifier: Apache-2.0
"""The switch that all boards share, with a board's settings: one with a guard and one without."""

import pytest
from simulators import BUILD_DIR, simulate
from wavehaptics.fpga.boards import load_board, write_headers


@pytest.mark.parametrize("name", ["ulx3s", "hx8k"])
def test_board_controller(simulator, name, monkeypatch):
    folder = BUILD_DIR / f"board_settings-{name}-{simulator}"
    folder.mkdir(parents=True, exist_ok=True)
    board = load_board(name)
    write_headers(board, folder)
    monkeypatch.setenv("WH_BOARD", name)
    simulate(
        simulator, "wh_board_controller", "tb_board_controller", {"SETTLE_LOG2": 8, "ZERO_LOG2": 2},
        name=f"tb_board_controller-{name}", includes=[folder], defines=board.defines,
    )  # fmt: skip
