# SPDX-License-Identifier: Apache-2.0
"""The whole RTL in closed loop with the Python motor."""

from simulators import simulate


def test_closed_loop(simulator):
    simulate(simulator, "bench_closed_loop", "tb_closed_loop")
