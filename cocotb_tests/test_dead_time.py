# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_dead_time` on each simulator."""

from simulators import simulate


def test_dead_time(simulator: str) -> None:
    simulate(simulator, "wh_dead_time", "tb_dead_time")
