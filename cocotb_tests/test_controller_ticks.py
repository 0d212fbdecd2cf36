# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_controller_ticks`: what is counted there is the same on every simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("ports", "walls", "shaper"), [(1, 10, 0), (3, 16, 0), (1, 16, 2)])
def test_controller_ticks(ports: int, walls: int, shaper: int) -> None:
    parameters = {"N": ports, "WALLS": walls, "SHAPER": shaper}
    simulate("verilator", "wh_controller", "tb_controller_ticks", parameters)
