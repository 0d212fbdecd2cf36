# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_energy` on each simulator."""

from simulators import simulate


def test_energy(simulator: str) -> None:
    simulate(simulator, "wh_energy", "tb_energy")
