# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_sense_check` on each simulator."""

from simulators import simulate


def test_sense_check(simulator: str) -> None:
    simulate(simulator, "wh_sense_check", "tb_sense_check")
