# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_zero` on each simulator."""

from simulators import simulate


def test_zero(simulator: str) -> None:
    simulate(simulator, "wh_zero", "tb_zero", {"LOG2_TICKS": 4})
