# SPDX-License-Identifier: Apache-2.0
"""The whole RTL in closed loop with the Python motor."""

from pathlib import Path

import pytest
from simulators import BUILD_DIR, simulate
from wavehaptics.words.generated import connections
from wavehaptics.words.table import Sizes


def bench_words(name: str) -> Path:
    """Folder with the words' wires and ports of ``bench_closed_loop.v``."""
    folder = BUILD_DIR / f"bench_words-{name}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "wh_bench_words.vh").write_text(connections("WH_BENCH", Sizes(), None))
    return folder


@pytest.mark.model
def test_closed_loop(simulator):
    simulate(
        simulator,
        "bench_closed_loop",
        "tb_closed_loop",
        includes=[bench_words(simulator)],
    )
