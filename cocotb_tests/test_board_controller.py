# SPDX-License-Identifier: Apache-2.0
"""The switch that all boards share, with the settings of the ULX3S."""

from simulators import BUILD_DIR, simulate
from wavehaptics.boards import load_board


def test_board_controller(simulator):
    folder = BUILD_DIR / f"board_settings-{simulator}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "wh_board_settings.vh").write_text(load_board("ulx3s").header())
    simulate(
        simulator, "wh_board_controller", "tb_board_controller", {"SETTLE_LOG2": 4},
        includes=[folder],
    )  # fmt: skip
