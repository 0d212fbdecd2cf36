# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_ports_axes` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(
    ("ports", "axes", "shaper", "min_pulse"),
    [
        (2, 1, 0, 0),
        (2, 1, 1, 1),
        (2, 1, 2, 0),
        (3, 1, 0, 1),
        (3, 2, 0, 0),
        (5, 5, 0, 0),
        (8, 85, 0, 0),
    ],
)
def test_ports_axes(simulator: str, ports: int, axes: int, shaper: int, min_pulse: int) -> None:
    """One brushless motor, and beside it a brushed one, or more."""
    sizes = {"N": ports, "AXES": axes, "SHAPER": shaper, "MIN_PULSE": min_pulse}
    simulate(simulator, "bench_ports_axes", "tb_ports_axes", sizes, inner=True)
