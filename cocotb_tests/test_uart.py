# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_uart` on each simulator."""

from simulators import simulate


def test_uart(simulator: str) -> None:
    simulate(simulator, "wh_uart", "tb_uart")
