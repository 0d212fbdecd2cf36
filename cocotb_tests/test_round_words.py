# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_round_words` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize("ports", [1, 2, 3, 8])
def test_round_words(simulator: str, ports: int) -> None:
    simulate(simulator, "wh_round_words", "tb_round_words", {"N": ports})
