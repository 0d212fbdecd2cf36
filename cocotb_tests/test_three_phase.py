# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_three_phase` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("min_pulse", "dead_time"), [(0, 1), (1, 0)])
def test_three_phase(simulator: str, min_pulse: int, dead_time: int) -> None:
    parameters = {"MIN_PULSE": min_pulse, "DEAD_TIME": dead_time}
    simulate(simulator, "wh_three_phase", "tb_three_phase", parameters)
