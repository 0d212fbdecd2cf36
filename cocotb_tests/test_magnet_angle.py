# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_magnet_angle` on each simulator."""

from simulators import simulate


def test_magnet_angle(simulator: str) -> None:
    simulate(simulator, "wh_magnet_angle", "tb_magnet_angle")
