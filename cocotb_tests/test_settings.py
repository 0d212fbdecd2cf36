# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_settings` on each simulator."""

import pytest
from simulators import simulate

SIZES = {
    "two": {"N": 2},
    "large": {"N": 3, "WALLS": 16, "SHAPER": 2, "DELAY_LOG2": 5},
    "one": {"N": 1, "WALLS": 1},
    "brushless": {"N": 2, "LEGS": 3},
}


@pytest.mark.parametrize("size", SIZES)
def test_settings(simulator: str, size: str) -> None:
    simulate(simulator, "bench_settings", "tb_settings", SIZES[size])


def test_settings_of_short_words(simulator: str) -> None:
    """Ranges follow the widths that a tool sets."""
    defines = {"WH_DATA_W": 28, "WH_COEF_W": 24}
    simulate(simulator, "bench_settings", "tb_settings", SIZES["two"], defines)
