# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_trip` on each simulator."""

from simulators import simulate


def test_trip(simulator: str) -> None:
    simulate(simulator, "wh_trip", "tb_trip")
