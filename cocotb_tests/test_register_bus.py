# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_registers` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("ports", "shaper"), [(1, 0), (3, 0), (8, 0), (3, 2)])
def test_register_bus(simulator: str, ports: int, shaper: int) -> None:
    simulate(simulator, "bench_registers", "tb_registers", {"N": ports, "SHAPER": shaper})


@pytest.mark.parametrize(("ports", "axes"), [(3, 1), (4, 5)])
def test_registers_of_brushless_motors(simulator: str, ports: int, axes: int) -> None:
    simulate(simulator, "bench_registers", "tb_registers", {"N": ports, "SHAPER": 2, "AXES": axes})
