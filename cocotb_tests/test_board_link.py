# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_board_link` with the settings of a board that has a link."""

import pytest
from simulators import BUILD_DIR, simulate
from wavehaptics.fpga.boards import board_names, load_board, write_headers

LINKED = [name for name in board_names() if load_board(name).fpga.link]


@pytest.mark.parametrize("name", LINKED)
def test_board_link(name, monkeypatch):
    board = load_board(name)
    folder = BUILD_DIR / f"board_settings-{name}-link"
    folder.mkdir(parents=True, exist_ok=True)
    write_headers(board, folder)
    monkeypatch.setenv("WH_BOARD", name)
    simulate(
        "verilator", "wh_board_controller", "tb_board_link", {"SETTLE_LOG2": 8, "ZERO_LOG2": 2},
        name=f"tb_board_link-{name}", includes=[folder], defines=board.defines,
    )  # fmt: skip
