# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_core` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(
    ("ports", "outside", "shaper"),
    [(1, 0, 0), (2, 0, 0), (3, 1, 0), (8, 0, 0), (1, 0, 1), (3, 1, 1), (3, 0, 2)],
)
def test_core(simulator: str, ports: int, outside: int, shaper: int) -> None:
    sizes = {"N": ports, "OUTSIDE": outside, "SHAPER": shaper}
    simulate(simulator, "bench_core", "tb_core", sizes)
