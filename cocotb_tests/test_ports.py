# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_ports` on each simulator, with one port and with several."""

import pytest
from simulators import simulate


@pytest.mark.parametrize(
    ("ports", "shaper", "host", "modes"),
    [
        (1, 0, 0, 0), (2, 0, 0, 0), (3, 0, 0, 0), (8, 0, 0, 0), (2, 1, 1, 0), (3, 2, 0, 0),
        (3, 0, 1, 1), (2, 0, 0, 1),
    ],
)  # fmt: skip
def test_ports(simulator: str, ports: int, shaper: int, host: int, modes: int) -> None:
    """``modes``: patterns of the bridge, and shortest pulses."""
    sizes = {"N": ports, "SHAPER": shaper, "HOST": host, "MODES": modes, "MIN_PULSE": modes}
    simulate(simulator, "bench_ports", "tb_ports", sizes, inner=True)
