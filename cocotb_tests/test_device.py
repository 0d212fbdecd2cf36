# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_device` on each simulator."""

import pytest
from simulators import simulate

SIZES = {
    "one": {"WALLS": 1, "HOST": 1, "CAPTURE": 5, "MODES": 1, "MIN_PULSE": 1},
    "three": {"N": 3, "WALLS": 2, "SHAPER": 2, "DELAY_LOG2": 3, "HOST": 1, "CAPTURE": 5},
    "brushless": {"N": 2, "AXES": 1, "CAPTURE": 5, "MIN_PULSE": 1},
}


@pytest.mark.parametrize("size", SIZES)
def test_device(simulator: str, size: str) -> None:
    simulate(simulator, "wh_device", "tb_device", SIZES[size])
