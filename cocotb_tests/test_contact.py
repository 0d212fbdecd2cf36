# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_contact` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("walls", [1, 2, 3, 4, 5, 7, 8, 11, 16])
def test_contact(simulator: str, walls: int) -> None:
    if walls not in (1, 4, 16) and simulator == "icarus":
        pytest.skip("a round's clocks are the same everywhere")
    simulate(simulator, "wh_contact", "tb_contact", {"WALLS": walls})
