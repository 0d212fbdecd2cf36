# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_adc_serial` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("lines", [1, 2])
def test_adc_serial(simulator: str, lines: int) -> None:
    simulate(simulator, "wh_adc_serial", "tb_adc_serial", {"LINES": lines})
