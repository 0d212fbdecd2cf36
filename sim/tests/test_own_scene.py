# SPDX-License-Identifier: Apache-2.0
"""A bitstream of a user's scene: its settings are the defaults, or one line says why not."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner
from wavehaptics.fpga.boards import load_board
from wavehaptics.runtime.repository import ROOT
from wavehaptics.words import formats
from wavehaptics.words.table import WORDS
from wavetools.cli import board_commands
from wavetools.fpga import synthesis


def scene(folder: Path, *changes: tuple[str, str]) -> Path:
    """The ULX3S's scene with other text."""
    text = (ROOT / "boards" / "ulx3s" / "board.toml").read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


def defaults(header: str, name: str) -> list[int]:
    """Defaults of a word in ``wh_board_settings_rom.vh``, as they are on the bus."""
    found = re.findall(
        rf"WH_SETTINGS_WORD\('h{WORDS[name].at():03x}, .*?, 32'h([0-9a-f]+)\)", header
    )
    return [int(text, 16) for text in found]


def test_its_settings_are_the_defaults(tmp_path):
    path = scene(tmp_path, ("lambda = 1e4", "lambda = 5e4"), ("[[0.0, 100.0]]", "[[0.1, 0.2]]"))
    board, own = load_board("ulx3s", scene_path=path), load_board("ulx3s")
    synthesis.check_board(board)
    words = board.words().ports
    header, others = (b.headers()["wh_board_settings_rom.vh"] for b in (board, own))
    assert str(path) in header
    assert defaults(header, "a") == [words.settings.a]
    assert defaults(header, "a") != defaults(others, "a")
    assert defaults(header, "wall_min") == [words.wall_words(4, 1)["wall_min"][0] & 0xFFFFFFFF]
    assert formats.A.to_value(words.settings.a) > 4 * formats.A.to_value(
        own.words().ports.settings.a
    )


def test_the_boards_own_bitstream_stays(tmp_path):
    path = scene(tmp_path)
    board, own = load_board("ulx3s", scene_path=path), load_board("ulx3s")
    assert synthesis.bitstream_path(board) == Path("build/synth/ulx3s-mine/ulx3s.bit")
    assert synthesis.bitstream_path(own) == Path("build/synth/ulx3s/ulx3s.bit")
    assert path in synthesis.board_sources(board)
    assert Path("boards/ulx3s/board.toml") not in synthesis.board_sources(board)


EIGHT = "[" + ", ".join(f"[{n}.0, {n}.5]" for n in range(8)) + "]"


@pytest.mark.parametrize(
    ("change", "status", "problem"),
    [
        (("clock_hz = 70e6", "clock_hz = 60e6"), 1, "the top's clock is 70 MHz, but .* 60 MHz"),
        (("[[0.0, 100.0]]", EIGHT), 2, "has 8 walls, and a motor of this board at most 7"),
        (("tick_hz = 833333.3333333334", "tick_hz = 2.5e6"), 2,
         r"tick_hz = 2500000, and this board's clock .* make 833333.3 of it; set it so"),
        (("full_scale_a = 2.5", "full_scale_a = 5.0"), 2, "adc.full_scale_a is 5 A, but 33 mΩ"),
        (("counts_per_rev = 10_000", "counts_per_rev = 10"), 2, "counts_per_rev = 10 is out of"),
        (('"re25-118743"', '"re25-118743"\nR_ohm = 500.0'), 2, "R_ohm = 500.0 is out of range"),
        (('"re25-118743"', '"re25-118743"\nL_h = 5.0'), 2, "L_h = 5.0 is out of range"),
        (("[encoder]\ncounts_per_rev = 10_000", ""), 2, r"the scene has no \[encoder\]"),
        (("AD7276", "AD7091R"), 2, "adc.part"),
    ],
)  # fmt: skip
def test_what_the_board_cant_do(tmp_path, change, status, problem):
    path = scene(tmp_path, change)
    result = CliRunner().invoke(board_commands.app, ["bitstream", "ulx3s", "--scene", str(path)])
    assert result.exit_code == status
    assert result.stderr.count("\n") == 1
    assert re.search(problem, result.stderr)


def test_scenes_that_arent_there_or_have_several_motors():
    for name, problem in (
        ("no_such_scene", "no such scene"), ("two_motors", "the scene has 2 motors"),
        ("brushless_hold", "needs 3 half bridges, and the board has 2"),
    ):  # fmt: skip
        result = CliRunner().invoke(board_commands.app, ["bitstream", "ulx3s", "--scene", name])
        assert result.exit_code == 2
        assert result.stderr.count("\n") == 1
        assert problem in result.stderr


@pytest.mark.parametrize("command", ["prog", "flash"])
def test_the_programmer_says_how_to_make_it(tmp_path, command):
    path = scene(tmp_path)
    result = CliRunner().invoke(board_commands.app, [command, "ulx3s", "--scene", str(path)])
    assert result.exit_code == 2
    assert f"run `make bitstream BOARD=ulx3s SCENE={path}`" in result.stderr
