# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_adc_max11125` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("lines", "first_channel"), [(1, 3), (3, 0), (8, 8)])
def test_adc_max11125(simulator: str, lines: int, first_channel: int) -> None:
    parameters = {"LINES": lines, "FIRST_CHANNEL": first_channel}
    simulate(simulator, "wh_adc_max11125", "tb_adc_max11125", parameters)
