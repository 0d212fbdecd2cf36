# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_core` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("ports", "outside"), [(1, 0), (2, 0), (3, 1), (8, 0)])
def test_core(simulator: str, ports: int, outside: int) -> None:
    simulate(simulator, "bench_core", "tb_core", {"N": ports, "OUTSIDE": outside})
