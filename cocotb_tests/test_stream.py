# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_stream` on each simulator, with one motor and several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("motors", [1, 3])
def test_stream(simulator: str, motors: int) -> None:
    simulate(simulator, "wh_stream", "tb_stream", {"N": motors, "CREDIT": 4000})
