# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_modbus` on each simulator."""

from simulators import simulate


def test_modbus(simulator: str) -> None:
    simulate(simulator, "bench_modbus", "tb_modbus")
