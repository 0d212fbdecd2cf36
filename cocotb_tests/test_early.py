# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_early` on each simulator."""

from simulators import simulate


def test_early(simulator: str) -> None:
    simulate(simulator, "wh_early", "tb_early")
