# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_synchroniser` on each simulator."""

from simulators import simulate


def test_synchroniser(simulator: str) -> None:
    simulate(simulator, "wh_synchroniser", "tb_synchroniser", {"WIDTH": 5})
