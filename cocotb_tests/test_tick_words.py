# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_tick_words` on each simulator, with one motor and several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("motors", [1, 2])
def test_tick_words(simulator: str, motors: int) -> None:
    simulate(simulator, "wh_tick_words", "tb_tick_words", {"N": motors})
