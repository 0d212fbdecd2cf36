# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_board_link` with the settings of a board that has a link."""

import re

import pytest
from simulators import BUILD_DIR, simulate
from wavehaptics.fpga.boards import board_names, load_board, write_headers


def hardware(name: str) -> str:
    """The macros of what is built in, without the clock's rate."""
    text = load_board(name).headers()["wh_board_settings.vh"]
    return " ".join(re.findall(r"`define WH_BOARD_(?!CLOCK_HZ)(\w+ \d+)$", text, re.MULTILINE))


LINKED = sorted(
    {hardware(name): name for name in board_names() if load_board(name).fpga.link}.values()
)
"""One board of each kind of hardware; what differs in words, test_boards.py compares for all."""


@pytest.mark.kept(1)
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
