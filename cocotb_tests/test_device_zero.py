# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_device_zero` on each simulator, of both kinds of motors."""

import pytest
from simulators import simulate

SIZES = {
    "one": {},
    "brushless": {"N": 2, "AXES": 1},
    "by_pin": {"ARM": 0},
    "ports": {"N": 2},
    "ports_by_pin": {"N": 2, "ARM": 0},
}


@pytest.mark.parametrize("size", SIZES)
def test_device_zero(simulator: str, size: str) -> None:
    simulate(simulator, "bench_zero", "tb_device_zero", SIZES[size])
