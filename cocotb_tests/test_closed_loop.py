# SPDX-License-Identifier: Apache-2.0
"""The whole RTL in closed loop with the Python motor."""

from simulators import BUILD_DIR, simulate
from wavehaptics.words.generated import connections
from wavehaptics.words.table import Sizes


def test_closed_loop(simulator):
    folder = BUILD_DIR / f"bench_words-{simulator}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "wh_bench_words.vh").write_text(connections("WH_BENCH", Sizes(), None))
    simulate(simulator, "bench_closed_loop", "tb_closed_loop", includes=[folder])
