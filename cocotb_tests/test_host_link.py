# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_host_link` on each simulator."""

from simulators import simulate


def test_host_link(simulator: str) -> None:
    simulate(simulator, "wh_host_link", "tb_host_link")
