# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_brushless` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("guard", [0, 1])
def test_brushless_controller(simulator: str, guard: int) -> None:
    parameters = {"WALLS": 4, "DELAY_LOG2": 2, "GUARD": guard}
    simulate(simulator, "wh_brushless", "tb_brushless", parameters)
