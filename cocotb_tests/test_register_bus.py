# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_registers` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("ports", "shaper"), [(1, 0), (3, 0), (8, 0), (3, 2)])
def test_register_bus(simulator: str, ports: int, shaper: int) -> None:
    simulate(simulator, "bench_registers", "tb_registers", {"N": ports, "SHAPER": shaper})
