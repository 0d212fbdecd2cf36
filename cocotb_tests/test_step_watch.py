# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_step_watch` on each simulator."""

from simulators import simulate


def test_step_watch(simulator: str) -> None:
    simulate(simulator, "wh_step_watch", "tb_step_watch")
