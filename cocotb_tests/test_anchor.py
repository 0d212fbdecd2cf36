# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_anchor` on each simulator, of a motor with brushes and of an axis without."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("axis", [0, 1])
def test_anchor(simulator: str, axis: int) -> None:
    simulate(simulator, "bench_anchor", "tb_anchor", {"AXIS": axis})
