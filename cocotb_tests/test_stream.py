# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_stream` on each simulator: one motor and several, alone and beside a capture."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("motors", "depth_log2"), [(1, 6), (3, 6), (1, 4)])
def test_stream(simulator: str, motors: int, depth_log2: int) -> None:
    size = {"N": motors, "DEPTH_LOG2": depth_log2, "CREDIT": 4000}
    simulate(simulator, "bench_listeners", "tb_stream", size)


def test_stream_over_the_line(simulator: str) -> None:
    size = {"CLOCK_HZ": 18_000_000, "SILENCE": 6_000, "FALLBACK": 40, "CREDIT": 60_000, "STREAM": 1}
    simulate(simulator, "wh_linked_device", "tb_link_stream", size)
