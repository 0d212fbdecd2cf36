# SPDX-License-Identifier: Apache-2.0
"""Netlists of the iCE40, with and without multiplier blocks, and of the ECP5, in the RTL's place.

They pass the very tests that the RTL passes, on Verilator. What the ECP5's agreement rests on is
said in ``sim/cells/mult18x18d.v``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
from simulators import simulate
from test_closed_loop import bench_words
from wavehaptics.runtime.toolchain import Toolchain
from wavetools.fpga.netlists import DEVICES, netlist

TICKS = 3_000


def simulate_netlist(
    block: str,
    block_parameters: dict[str, int],
    device: str,
    bench: str,
    test_module: str,
    parameters: Mapping[str, int] | None = None,
    includes: Sequence[Path] = (),
) -> None:
    """Run ``test_module`` on ``bench`` with the netlist of ``block`` in the place of its RTL."""
    made = netlist(block, device, block_parameters, Toolchain.of_environment())
    simulate(
        "verilator", bench, test_module, parameters,
        name=f"netlist-{block}-{device}", sources=made, includes=includes,
    )  # fmt: skip


@pytest.mark.kept("25k")
@pytest.mark.parametrize("device", DEVICES)
def test_wave_core(device: str) -> None:
    """Word for word the integer model, over corners, resets and overruns."""
    parameters = {"N": 1, "DELAY_LOG2": 2, "OUTSIDE": 1, "SHAPER": 0, "WITHHELD": 1, "SHARED": 0}
    bench = {**parameters, "TICKS": TICKS}
    simulate_netlist("wh_wave_core", parameters, device, "bench_wave_core", "tb_wave_core", bench)


@pytest.mark.long
@pytest.mark.parametrize("device", DEVICES)
def test_closed_loop(device: str) -> None:
    """The whole design taps the stiffest wall once, at its pins."""
    parameters = {"N": 1, "WALLS": 4, "DELAY_LOG2": 2}
    simulate_netlist(
        "wh_controller", parameters, device, "bench_closed_loop", "tb_closed_loop",
        includes=[bench_words(f"netlist-{device}")],
    )  # fmt: skip
