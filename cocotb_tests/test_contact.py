# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_contact` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("walls", [1, 4])
def test_contact(simulator: str, walls: int) -> None:
    simulate(simulator, "wh_contact", "tb_contact", {"WALLS": walls})
