# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_modulator` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("min_pulse", [0, 1])
def test_modulator(simulator: str, min_pulse: int) -> None:
    simulate(simulator, "wh_modulator", "tb_modulator", {"MIN_PULSE": min_pulse})
