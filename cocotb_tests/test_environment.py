# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_environment` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("host", [0, 1])
def test_environment(simulator: str, host: int) -> None:
    simulate(simulator, "wh_environment", "tb_environment", {"HOST": host})
