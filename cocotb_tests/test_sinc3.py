# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_sinc3` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(
    ("osr", "capture_rise", "trip_osr", "lines"),
    [(4, 0, 2, 1), (20, 0, 8, 2), (40, 1, 16, 1), (256, 1, 32, 1)],
)
def test_sinc3(simulator: str, osr: int, capture_rise: int, trip_osr: int, lines: int) -> None:
    parameters = {
        "OSR": osr, "CAPTURE_RISE": capture_rise, "TRIP_OSR": trip_osr, "LINES": lines,
    }  # fmt: skip
    simulate(simulator, "wh_sinc3", "tb_sinc3", parameters)
