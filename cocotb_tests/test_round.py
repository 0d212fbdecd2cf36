# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_round` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(("width", "shift"), [(3, 2), (10, 4)])
def test_round(simulator: str, width: int, shift: int) -> None:
    simulate(simulator, "wh_round", "tb_round", {"IN_W": width, "SHIFT": shift})
