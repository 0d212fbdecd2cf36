# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_capture` on each simulator: one motor and several, alone and beside a stream."""

import pytest
from simulators import simulate

LASTING = 1 << 24


@pytest.mark.parametrize(
    ("motors", "depth_log2", "credit"), [(1, 6, 4000), (3, 7, 4000), (3, 7, LASTING)]
)
def test_capture(simulator: str, motors: int, depth_log2: int, credit: int) -> None:
    size = {"N": motors, "DEPTH_LOG2": depth_log2, "CREDIT": credit}
    simulate(simulator, "bench_listeners", "tb_capture", size)
