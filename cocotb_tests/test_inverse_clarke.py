# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_inverse_clarke` on each simulator, at full word lengths and at short ones."""

import pytest
from simulators import simulate

SHORT = {"WH_DATA_W": 24, "WH_COEF_W": 18}


@pytest.mark.parametrize("defines", [{}, SHORT], ids=["full", "short"])
def test_inverse_clarke(simulator: str, defines: dict[str, int]) -> None:
    simulate(simulator, "wh_inverse_clarke", "tb_inverse_clarke", defines=defines)
