# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_axes` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("sections", [0, 1, 2])
def test_axes(simulator: str, sections: int) -> None:
    simulate(simulator, "bench_axes", "tb_axes", {"DELAY_LOG2": 2, "SHAPER": sections})


@pytest.mark.parametrize("sections", [0, 1, 2])
def test_axes_and_their_anchors(simulator: str, sections: int) -> None:
    parameters = {"DELAY_LOG2": 2, "SHAPER": sections, "ANCHOR": 1}
    simulate(simulator, "bench_axes", "tb_axes", parameters)
