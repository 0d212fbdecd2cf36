# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_carrier` on each simulator."""

from simulators import simulate


def test_carrier(simulator: str) -> None:
    simulate(simulator, "wh_carrier", "tb_carrier")
