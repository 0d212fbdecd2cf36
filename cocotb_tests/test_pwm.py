# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_pwm` on each simulator."""

from simulators import simulate


def test_pwm(simulator: str) -> None:
    simulate(simulator, "wh_pwm", "tb_pwm")
