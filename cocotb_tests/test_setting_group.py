# SPDX-License-Identifier: Apache-2.0
"""A group of settings on a board that has some of them as constants."""

import pytest
from simulators import BUILD_DIR, simulate

pytestmark = pytest.mark.kept

HEADER = """
`WH_SETTINGS_WORD('h04e, 1, 2'b11, 8'h41, 32'd1)
`WH_SETTINGS_WORD('h04f, 1, 2'b11, 8'he1, 32'hffffffed)
`WH_SETTINGS_WORD('h150, 1, 2'b11, 8'he1, 32'd3)
`WH_SETTINGS_TOLD('h051, 2 * WALLS, 2'b11, 8'hc1)
`WH_SETTINGS_BOUNDS(1, 0, DELAY_LOG2)
"""
"""Of a board that has the group's second word as fixed, at what it takes of a word of 5 bits; a
port's word at the address of the third one is another."""


@pytest.mark.parametrize("staged", [1, 0])
def test_a_boards_fixed_words_are_constants(simulator: str, staged: int) -> None:
    folder = BUILD_DIR / "setting_group-fixed"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "wh_board_settings_rom.vh").write_text(HEADER, encoding="utf-8")
    simulate(
        simulator, "bench_setting_group", "tb_setting_group", {"STAGED": staged},
        includes=[folder], defines={"WH_BOARD_ROM": 1},
    )  # fmt: skip
