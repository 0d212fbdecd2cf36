# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_ports_surfaces` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("ports", "surfaces"), [(3, 8), (2, 1)])
def test_ports_surfaces(simulator: str, ports: int, surfaces: int) -> None:
    sizes = {"N": ports, "SURFACES": surfaces}
    simulate(simulator, "bench_ports_surfaces", "tb_ports_surfaces", sizes)
