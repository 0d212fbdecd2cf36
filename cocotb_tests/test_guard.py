# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_guard` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("motors", [1, 3])
def test_guard(simulator: str, motors: int) -> None:
    simulate(simulator, "wh_guard", "tb_guard", {"N": motors})
