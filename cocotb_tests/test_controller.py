# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_controller` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("ports", "walls", "delay_log2"), [(1, 4, 2), (3, 1, 1)])
def test_controller(simulator: str, ports: int, walls: int, delay_log2: int) -> None:
    parameters = {"N": ports, "WALLS": walls, "DELAY_LOG2": delay_log2}
    simulate(simulator, "wh_controller", "tb_controller", parameters)
