# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_anchor` on each simulator."""

from simulators import simulate


def test_anchor(simulator: str) -> None:
    simulate(simulator, "bench_anchor", "tb_anchor")
