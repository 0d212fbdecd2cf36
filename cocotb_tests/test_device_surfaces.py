# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_device_surfaces` on each simulator: over the bus, and over the line."""

import pytest
from simulators import simulate

SIZE = {"WALLS": 1, "ARM": 1, "ZERO_LOG2": 3}
LINE = {"CLOCK_HZ": 18_000_000, "SILENCE": 6_000, "FALLBACK": 500, "CREDIT": 4_000_000}


@pytest.mark.parametrize(("ports", "surfaces"), [(2, 2), (3, 4)])
def test_surfaces_over_the_bus(simulator: str, ports: int, surfaces: int) -> None:
    size = {**SIZE, "N": ports, "SURFACES": surfaces, "ARM_CLOCKS": 200_000}
    simulate(simulator, "wh_device", "tb_device_surfaces", size, inner=True)


def test_surfaces_briefly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COCOTB_TEST_FILTER", "frames_over_the_bus")
    size = {**SIZE, "N": 2, "SURFACES": 2, "ARM_CLOCKS": 200_000}
    name = "device_surfaces-briefly"
    simulate("icarus", "wh_device", "tb_device_surfaces", size, name=name)


def test_surfaces_over_the_line(simulator: str) -> None:
    size = {**SIZE, **LINE, "N": 2, "SURFACES": 2}
    simulate(simulator, "wh_linked_device", "tb_device_surfaces", size, inner=True)
