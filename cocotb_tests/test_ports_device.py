# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_ports_device` on each simulator, with one motor and with several."""

import pytest
from simulators import simulate

SIZE = {"WALLS": 1, "CAPTURE": 6, "STREAM": 1, "ARM": 1, "ARM_CLOCKS": 20_000, "ZERO_LOG2": 3}


@pytest.mark.parametrize(("ports", "shaper"), [(1, 0), (2, 0), (3, 2)])
def test_ports_device(simulator: str, ports: int, shaper: int) -> None:
    size = {**SIZE, "N": ports, "SHAPER": shaper}
    simulate(simulator, "wh_device", "tb_ports_device", size, inner=True)


def test_ports_device_briefly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COCOTB_TEST_FILTER", "every_live_register")
    size = {**SIZE, "N": 2, "SHAPER": 0}
    simulate("icarus", "wh_device", "tb_ports_device", size, name="ports_device-briefly")


@pytest.mark.parametrize(("ports", "axes"), [(2, 1), (3, 2)])
def test_a_brushless_motor(simulator: str, ports: int, axes: int) -> None:
    size = {**SIZE, "N": ports, "SHAPER": 0, "AXES": axes}
    simulate(simulator, "wh_device", "tb_ports_device_axes", size, inner=True)


def test_a_brushless_motor_alone(simulator: str) -> None:
    size = {"WALLS": 1, "N": 2, "AXES": 1, "ZERO_LOG2": 3}
    simulate(simulator, "wh_device", "tb_device_turns", size)
