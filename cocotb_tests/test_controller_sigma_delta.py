# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_controller_sigma_delta` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("ports", "osr"), [(1, 12), (2, 16)])
def test_controller_sigma_delta(simulator: str, ports: int, osr: int) -> None:
    parameters = {"N": ports, "WALLS": 1, "DELAY_LOG2": 3, "ADC": 2, "OSR": osr}
    simulate(simulator, "wh_controller", "tb_controller_sigma_delta", parameters)
