# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_axes` on each simulator; of anchors ``core`` is held to ``golden``."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("sections", [0, 1, 2])
def test_axes(simulator: str, sections: int) -> None:
    simulate(simulator, "wh_axes", "tb_axes", {"DELAY_LOG2": 2, "SHAPER": sections})
