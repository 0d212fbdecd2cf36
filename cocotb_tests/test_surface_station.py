# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_surface_station` on each simulator, for groups of two and three ports."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("ports", "surfaces"), [(3, 8), (2, 3), (3, 1)])
def test_surface_station(simulator: str, ports: int, surfaces: int) -> None:
    sizes = {"PORTS": ports, "SURFACES": surfaces}
    simulate(simulator, "bench_surfaces", "tb_surface_station", sizes, inner=True)
