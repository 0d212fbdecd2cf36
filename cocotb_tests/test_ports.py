# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_ports` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("ports", [1, 2, 3])
def test_ports(simulator: str, ports: int) -> None:
    simulate(simulator, "bench_ports", "tb_ports", {"N": ports})
