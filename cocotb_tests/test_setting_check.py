# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_setting_check` on each simulator."""

from simulators import simulate


def test_setting_check(simulator: str) -> None:
    simulate(simulator, "wh_setting_check", "tb_setting_check", {"N": 3})
