# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_current` on each simulator."""

from simulators import simulate


def test_current(simulator: str) -> None:
    simulate(simulator, "wh_current", "tb_current")
