# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_quadrature` on each simulator."""

from simulators import simulate


def test_quadrature(simulator: str) -> None:
    simulate(simulator, "wh_quadrature", "tb_quadrature")
