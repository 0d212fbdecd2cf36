# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_bus_scale` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("motors", [1, 3])
def test_bus_scale(simulator: str, motors: int) -> None:
    simulate(simulator, "wh_bus_scale", "tb_bus_scale", {"N": motors})
