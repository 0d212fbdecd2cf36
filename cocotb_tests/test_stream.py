# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_stream` on each simulator, with one motor and several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("motors", [1, 3])
def test_stream(simulator: str, motors: int) -> None:
    simulate(simulator, "wh_stream", "tb_stream", {"N": motors, "CREDIT": 4000})


def test_stream_over_the_line(simulator: str) -> None:
    size = {"CLOCK_HZ": 18_000_000, "SILENCE": 6_000, "FALLBACK": 40, "CREDIT": 60_000, "STREAM": 1}
    simulate(simulator, "wh_linked_device", "tb_link_stream", size)
