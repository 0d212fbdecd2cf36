# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_setting_group` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("staged", [1, 0])
def test_setting_group(simulator: str, staged: int) -> None:
    simulate(simulator, "bench_setting_group", "tb_setting_group", {"STAGED": staged})
