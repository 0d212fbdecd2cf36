# SPDX-License-Identifier: Apache-2.0
"""The watch over the clock, by itself and with a board's controller behind it."""

import pytest
from simulators import BUILD_DIR, simulate
from wavehaptics.fpga.boards import load_board, write_headers


@pytest.mark.long
@pytest.mark.parametrize(("beat", "patience"), [(4, 4), (3, 5)])
def test_board_clock_watch(simulator, beat, patience):
    if simulator == "icarus" and beat == 3:
        pytest.skip("one size is enough to see what a slow simulator sees otherwise")
    simulate(
        simulator, "wh_board_clock_watch", "tb_board_clock_watch",
        {"GATES": 12, "BEAT_LOG2": beat, "PATIENCE_LOG2": patience},
    )  # fmt: skip


def test_lost_clock(simulator, monkeypatch):
    folder = BUILD_DIR / f"board_settings-lost_clock-{simulator}"
    folder.mkdir(parents=True, exist_ok=True)
    board = load_board("ulx3s")
    write_headers(board, folder)
    monkeypatch.setenv("WH_BOARD", "ulx3s")
    simulate(
        simulator, "bench_lost_clock", "tb_lost_clock", {"SETTLE_LOG2": 6, "ZERO_LOG2": 2},
        name="tb_lost_clock", includes=[folder], defines=board.defines,
    )  # fmt: skip
