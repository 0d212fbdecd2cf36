# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_modulator` on each simulator."""

from simulators import simulate


def test_modulator(simulator: str) -> None:
    simulate(simulator, "wh_modulator", "tb_modulator")
