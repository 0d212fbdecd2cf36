# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_three_phase` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("min_pulse", [0, 1])
def test_three_phase(simulator: str, min_pulse: int) -> None:
    simulate(simulator, "wh_three_phase", "tb_three_phase", {"MIN_PULSE": min_pulse})
