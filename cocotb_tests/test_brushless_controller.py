# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_brushless` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("guard", [0, 1])
def test_brushless_controller(simulator: str, guard: int) -> None:
    parameters = {"WALLS": 4, "DELAY_LOG2": 2, "GUARD": guard}
    simulate(simulator, "wh_brushless", "tb_brushless", parameters)


@pytest.mark.parametrize("guard", [0, 1])
def test_its_sense(simulator: str, guard: int) -> None:
    """With all that it does without; a zero is of so few ticks that it doesn't take long."""
    parameters = {"WALLS": 4, "DELAY_LOG2": 2, "GUARD": guard, "SENSE": 1, "ZERO_LOG2": 4}
    simulate(simulator, "wh_brushless", "tb_brushless", parameters)


@pytest.mark.parametrize("sections", [1, 2])
def test_its_w(simulator: str, sections: int) -> None:
    parameters = {"WALLS": 4, "DELAY_LOG2": 2, "SHAPER": sections}
    simulate(simulator, "wh_brushless", "tb_brushless", parameters)
