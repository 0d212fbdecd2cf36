# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_modbus` on each simulator."""

from simulators import simulate


def test_modbus(simulator: str) -> None:
    simulate(simulator, "bench_modbus", "tb_modbus")


def test_modbus_briefly(monkeypatch) -> None:
    """What it answers and refuses."""
    monkeypatch.setenv("COCOTB_TEST_FILTER", "who_is_there|exceptions")
    simulate("verilator", "bench_modbus", "tb_modbus", name="tb_modbus-briefly")
