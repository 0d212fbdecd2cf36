# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_arm` on each simulator, without and with a measured zero."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("sense", [0, 1])
def test_arm(simulator: str, sense: int) -> None:
    simulate(simulator, "wh_arm", "tb_arm", {"SENSE": sense, "CREDIT": 50})
