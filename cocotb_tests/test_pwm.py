# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_pwm` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("modes", [0, 1])
def test_pwm(simulator: str, modes: int) -> None:
    simulate(simulator, "wh_pwm", "tb_pwm", {"MODES": modes})
