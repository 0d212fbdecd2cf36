# SPDX-License-Identifier: Apache-2.0
"""The switch that all boards share, with a board's settings.

One has a guard, one doesn't, and one has a brushless motor.
"""

import pytest
from simulators import BUILD_DIR, simulate
from wavehaptics.fpga.boards import load_board, write_headers


@pytest.mark.kept("verilator-ulx3s_brushless")
@pytest.mark.parametrize("name", ["ulx3s", "hx8k", "ulx3s_brushless"])
def test_board_controller(simulator, name, monkeypatch):
    folder = BUILD_DIR / f"board_settings-{name}-{simulator}"
    folder.mkdir(parents=True, exist_ok=True)
    board = load_board(name)
    write_headers(board, folder)
    monkeypatch.setenv("WH_BOARD", name)
    four_ticks = 4 * board.words().ports.timing.tick_clocks
    parameters = {"SETTLE_LOG2": four_ticks.bit_length(), "ZERO_LOG2": 2}
    simulate(
        simulator, "wh_board_controller", "tb_board_controller", parameters,
        name=f"tb_board_controller-{name}", includes=[folder], defines=board.defines, inner=True,
    )  # fmt: skip
