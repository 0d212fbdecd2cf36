# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_multiply_shared` on each simulator."""

from simulators import simulate


def test_multiply_shared(simulator: str) -> None:
    simulate(simulator, "wh_multiply_shared", "tb_multiply_shared", {"USERS": 6})
