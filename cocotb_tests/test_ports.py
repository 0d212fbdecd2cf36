# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_ports` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("ports", "shaper"), [(1, 0), (2, 0), (3, 0), (8, 0), (2, 1), (3, 2)])
def test_ports(simulator: str, ports: int, shaper: int) -> None:
    simulate(simulator, "bench_ports", "tb_ports", {"N": ports, "SHAPER": shaper})
