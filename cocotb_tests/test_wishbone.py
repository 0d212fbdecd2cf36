# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_wishbone` on each simulator."""

from simulators import simulate


def test_wishbone(simulator: str) -> None:
    simulate(simulator, "bench_wishbone", "tb_wishbone")
