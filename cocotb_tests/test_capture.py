# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_capture` on each simulator, with one motor and several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("motors", "depth_log2"), [(1, 6), (3, 7)])
def test_capture(simulator: str, motors: int, depth_log2: int) -> None:
    simulate(simulator, "wh_capture", "tb_capture", {"N": motors, "DEPTH_LOG2": depth_log2})
