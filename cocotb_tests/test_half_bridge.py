# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_half_bridge` on each simulator."""

from simulators import simulate


def test_half_bridge(simulator: str) -> None:
    simulate(simulator, "wh_half_bridge", "tb_half_bridge")
