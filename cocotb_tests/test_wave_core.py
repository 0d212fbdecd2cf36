# SPDX-License-Identifier: Apache-2.0
"""wh_wave_core on each simulator, at several numbers of ports, delay lines and word lengths."""

from __future__ import annotations

import pytest
from simulators import simulate

# Verilator runs the long stream; a word that Icarus sees otherwise (X, races) shows in a short one.
TICKS = {"icarus": 10_000, "verilator": 60_000}
TICKS_OF_A_VARIANT = 4_000


def test_wave_core(simulator: str) -> None:
    parameters = {"N": 1, "DELAY_LOG2": 2, "WITHHELD": 1, "TICKS": TICKS[simulator]}
    simulate(simulator, "bench_wave_core", "tb_wave_core", parameters)


@pytest.mark.parametrize(("sections", "ports"), [(1, 1), (2, 1), (2, 3)])
def test_wave_core_with_a_shaper(simulator: str, sections: int, ports: int) -> None:
    if simulator == "icarus" and (sections, ports) != (2, 1):
        pytest.skip("one size is enough to see what a slow simulator sees otherwise")
    ticks = {"icarus": 2_000, "verilator": 8_000 if ports == 1 else 2_500}[simulator]
    parameters = {
        "N": ports, "DELAY_LOG2": 2, "SHAPER": sections, "WITHHELD": sections - 1, "TICKS": ticks,
    }  # fmt: skip
    simulate(simulator, "bench_wave_core", "tb_wave_core", parameters)


@pytest.mark.parametrize(("ports", "delay_log2"), [(3, 1), (1, 10)])
def test_wave_core_ports(simulator: str, ports: int, delay_log2: int) -> None:
    # A long delay line is filled late: the stream is longer, so that it goes everywhere as well.
    ticks = TICKS_OF_A_VARIANT * (3 if delay_log2 > 4 else 1)
    parameters = {"N": ports, "DELAY_LOG2": delay_log2, "WITHHELD": int(ports == 3), "TICKS": ticks}
    simulate(simulator, "bench_wave_core", "tb_wave_core", parameters)


@pytest.mark.parametrize("ports", [1, 3])
def test_wave_core_with_a_shared_multiplier(simulator: str, ports: int) -> None:
    """Whose every clock somebody else asks for."""
    parameters = {
        "N": ports, "DELAY_LOG2": 2, "WITHHELD": 1, "SHARED": 1, "TICKS": TICKS_OF_A_VARIANT,
    }  # fmt: skip
    simulate(simulator, "bench_wave_core", "tb_wave_core", parameters)


def test_wave_core_without_a_wave_from_outside(simulator: str) -> None:
    parameters = {"N": 1, "DELAY_LOG2": 2, "OUTSIDE": 0, "TICKS": TICKS_OF_A_VARIANT}
    simulate(simulator, "bench_wave_core", "tb_wave_core", parameters)


@pytest.mark.parametrize(("data_w", "coef_w", "guard"), [(18, 18, 9), (16, 12, 4)])
def test_wave_core_widths(simulator: str, data_w: int, coef_w: int, guard: int) -> None:
    parameters = {"N": 1, "DELAY_LOG2": 2, "WITHHELD": 1, "TICKS": TICKS_OF_A_VARIANT}
    defines = {"WH_DATA_W": data_w, "WH_COEF_W": coef_w, "WH_STATE_GUARD": guard}
    simulate(simulator, "bench_wave_core", "tb_wave_core", parameters, defines)
