# SPDX-License-Identifier: Apache-2.0
"""Netlists of the iCE40, with and without multiplier blocks, and of the ECP5, in the RTL's place.

They pass the very tests that the RTL passes, on Verilator. What the ECP5's agreement rests on is
said in ``tb_netlist_mult18x18d.v``.
"""

from __future__ import annotations

import pytest
import simulators
from simulators import simulate
from wavehaptics.netlists import DEVICES, netlist
from wavehaptics.toolchain import Toolchain

TICKS = 3_000

# The libraries' cells aren't written for lint.
QUIET = ("-Wno-lint", "-Wno-style", "-Wno-SPECIFYIGN", "-Wno-fatal")


@pytest.fixture
def in_place(monkeypatch: pytest.MonkeyPatch):
    """Put the netlist of a block in the place of its RTL."""

    def put(block: str, device: str, parameters: dict[str, int]) -> None:
        made = netlist(block, device, parameters, Toolchain.of_environment())
        defines = [f"-D{name}={value}" for name, value in made.defines.items()]
        usual = simulators._BUILD_ARGS["verilator"]
        arguments = [*map(str, made.sources), *defines, *QUIET, *usual]
        monkeypatch.setitem(simulators._BUILD_ARGS, "verilator", arguments)

    return put


@pytest.mark.parametrize("device", DEVICES)
def test_wave_core(in_place, device: str) -> None:
    """Word for word the integer model, over corners, resets and overruns."""
    parameters = {"N": 1, "DELAY_LOG2": 2}
    in_place("wh_wave_core", device, parameters)
    name = f"netlist-wave_core-{device}"
    simulate(
        "verilator", "bench_wave_core", "tb_wave_core", {**parameters, "TICKS": TICKS}, name=name
    )
