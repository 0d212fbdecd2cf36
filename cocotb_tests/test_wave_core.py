# SPDX-License-Identifier: Apache-2.0
"""wh_wave_core on each simulator, at several numbers of ports, delay lines and word lengths."""

from __future__ import annotations

import pytest
from simulators import simulate


@pytest.mark.parametrize(
    ("ports", "delay_log2", "ticks"), [(1, 2, 40_000), (3, 1, 8_000), (1, 10, 8_000), (2, 3, 8_000)]
)
def test_wave_core(simulator: str, ports: int, delay_log2: int, ticks: int) -> None:
    parameters = {"N": ports, "DELAY_LOG2": delay_log2, "TICKS": ticks}
    simulate(simulator, "bench_wave_core", "tb_wave_core", parameters)


@pytest.mark.parametrize(("data_w", "coef_w", "guard"), [(18, 18, 9), (24, 18, 9), (16, 12, 4)])
def test_wave_core_widths(simulator: str, data_w: int, coef_w: int, guard: int) -> None:
    parameters = {"N": 1, "DELAY_LOG2": 2, "TICKS": 8_000}
    defines = {"WH_DATA_W": data_w, "WH_COEF_W": coef_w, "WH_STATE_GUARD": guard}
    simulate(simulator, "bench_wave_core", "tb_wave_core", parameters, defines)
