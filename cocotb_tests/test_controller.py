# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_controller` on each simulator."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(
    (
        "ports",
        "walls",
        "delay_log2",
        "adc",
        "shaper",
        "sense",
        "modes",
        "bus",
        "anchor",
        "shared",
    ),
    [
        (1, 4, 2, 0, 0, 0, 0, 0, 0, 0),
        (3, 1, 1, 0, 0, 1, 0, 0, 0, 0),
        (1, 4, 2, 1, 0, 1, 0, 0, 0, 0),
        (1, 4, 2, 0, 2, 0, 0, 0, 0, 0),
        (1, 4, 2, 0, 0, 0, 1, 1, 0, 0),
        (3, 1, 1, 0, 0, 0, 0, 1, 0, 0),
        (3, 1, 1, 0, 0, 0, 0, 0, 1, 0),
        (1, 4, 2, 0, 0, 0, 0, 1, 1, 0),
        (1, 4, 2, 0, 0, 1, 0, 0, 1, 1),
        (3, 1, 1, 0, 0, 1, 0, 0, 0, 1),
        (3, 1, 1, 0, 0, 0, 0, 0, 1, 1),
    ],
)
def test_controller(
    simulator: str, ports: int, walls: int, delay_log2: int, adc: int, shaper: int, sense: int,
    modes: int, bus: int, anchor: int, shared: int,
) -> None:  # fmt: skip
    if (shaper or modes or anchor) and simulator == "icarus":
        pytest.skip("these blocks' clocks are the same everywhere; each has a bench of its own")
    if simulator == "icarus" and not (sense or adc):
        pytest.skip("test_closed_loop has this very controller on Icarus")
    parameters = {
        "N": ports, "WALLS": walls, "DELAY_LOG2": delay_log2, "ADC": adc, "SHAPER": shaper,
        "SENSE": sense, "ZERO_LOG2": 3, "MODES": modes, "MIN_PULSE": modes,
        "BUS": bus, "ANCHOR": anchor, "SHARED": shared,
    }  # fmt: skip
    simulate(simulator, "wh_controller", "tb_controller", parameters)
