# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_device` on each simulator."""

import pytest
from simulators import simulate

# fmt: off
SIZES = {
    "one": {
        "WALLS": 1, "GUARD": 1, "HOST": 1, "SENSE": 1, "CAPTURE": 5, "MODES": 1, "MIN_PULSE": 1,
    },
    "three": {
        "N": 3,
        "WALLS": 2,
        "SHAPER": 2,
        "ANCHOR": 1,
        "DELAY_LOG2": 3,
        "HOST": 1,
        "CAPTURE": 5,
    },
    "bus": {"BUS": 1, "ANCHOR": 1, "GUARD": 1},
    "brushless": {
        "LEGS": 3, "ANCHOR": 1, "GUARD": 1, "SENSE": 1, "CAPTURE": 5, "MIN_PULSE": 1,
    },
}
# fmt: on


@pytest.mark.parametrize("size", SIZES)
def test_device(simulator: str, size: str) -> None:
    simulate(simulator, "wh_motor_device", "tb_device", SIZES[size])
