# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_cobs` on each simulator."""

from simulators import simulate


def test_cobs(simulator: str) -> None:
    simulate(simulator, "wh_cobs", "tb_cobs")
