# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_link` on each simulator: few clocks a bit at 3 Mbit/s, and silence cut short."""

from simulators import simulate

SIZE = {"CLOCK_HZ": 18_000_000, "SILENCE": 6_000, "FALLBACK": 12}


def test_link(simulator: str) -> None:
    simulate(simulator, "wh_linked_device", "tb_link", SIZE, inner=True)


def test_link_briefly(monkeypatch) -> None:
    """Few clocks a bit at 115,200 bit/s as well, for Icarus."""
    monkeypatch.setenv("COCOTB_TEST_FILTER", "a_setting_and_its_port")
    size = {**SIZE, "CLOCK_HZ": 3_000_000}
    simulate("icarus", "wh_linked_device", "tb_link", size, name="tb_link-briefly")


def test_link_of_three(simulator: str) -> None:
    size = {**SIZE, "N": 3, "WALLS": 2, "CLOCK_HZ": 50_000_000}
    simulate(simulator, "wh_linked_device", "tb_link", size, inner=True)
