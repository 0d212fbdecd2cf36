# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_board_link` with the settings of a board that has a link."""

import re
from pathlib import Path

import pytest
from simulators import BUILD_DIR, simulate
from wavehaptics.fpga.boards import board_names, load_board, write_headers
from wavehaptics.runtime.repository import ROOT


def hardware(name: str) -> str:
    """The macros of what is built in, without the clock's rate."""
    text = load_board(name).headers()["wh_board_settings.vh"]
    return " ".join(re.findall(r"`define WH_BOARD_(?!CLOCK_HZ)(\w+ \d+)$", text, re.MULTILINE))


LINKED = sorted(
    {hardware(name): name for name in board_names() if load_board(name).fpga.link}.values()
)
"""One board of each kind of hardware; what differs in words, test_boards.py compares for all."""


def of_board(name: str, scene: Path | None, bench: str, monkeypatch: pytest.MonkeyPatch) -> None:
    board = load_board(name, scene_path=scene)
    folder = BUILD_DIR / f"board_settings-{board.made}-link"
    folder.mkdir(parents=True, exist_ok=True)
    write_headers(board, folder)
    monkeypatch.setenv("WH_BOARD", name)
    monkeypatch.setenv("WH_BOARD_SCENE", str(scene or ""))
    simulate(
        "verilator", "wh_board_controller", bench, {"SETTLE_LOG2": 8, "ZERO_LOG2": 2},
        name=f"{bench}-{board.made}", includes=[folder], defines=board.defines,
    )  # fmt: skip


@pytest.mark.kept(1)
@pytest.mark.parametrize("name", LINKED)
def test_board_link(name, monkeypatch):
    of_board(name, None, "tb_board_link", monkeypatch)


def test_board_patterns(monkeypatch):
    """The line chooses the bridge's pattern, in the bitstream of a scene that has others."""
    scene = ROOT / "boards" / "ulx3s" / "patterns.toml"
    of_board("ulx3s", scene, "tb_board_patterns", monkeypatch)
