# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_anchor_ports` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("ports", [1, 2, 3, 8])
def test_anchor_ports(simulator: str, ports: int) -> None:
    simulate(simulator, "bench_anchor_ports", "tb_anchor_ports", {"N": ports})


@pytest.mark.parametrize(("ports", "axes"), [(2, 1), (3, 2)])
def test_anchors_of_axes(simulator: str, ports: int, axes: int) -> None:
    simulate(simulator, "bench_anchor_ports", "tb_anchor_ports", {"N": ports, "AXES": axes})
