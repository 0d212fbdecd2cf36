# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_energy_ports` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("ports", [1, 3])
def test_energy_ports(simulator: str, ports: int) -> None:
    simulate(simulator, "wh_energy_ports", "tb_energy_ports", {"N": ports})
