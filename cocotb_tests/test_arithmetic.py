# SPDX-License-Identifier: Apache-2.0
"""The arithmetic modules, exhaustively at small widths, and what they refuse."""

from __future__ import annotations

import pytest
from simulators import SimulationError, simulate


def test_every_small_word(simulator: str) -> None:
    # 7 bits are the longest word that two limbs of 3 bits hold.
    simulate(simulator, "bench_arithmetic", "tb_arithmetic", {"W": 7, "LIMB_W": 3})


@pytest.mark.parametrize(
    ("toplevel", "parameters"),
    [
        ("wh_truncate", {"IN_W": 8, "SHIFT": 0}),
        ("wh_truncate", {"IN_W": 8, "SHIFT": 8}),
        ("wh_saturate", {"IN_W": 8, "OUT_W": 8}),
        ("wh_saturate", {"IN_W": 8, "OUT_W": 1}),
        ("wh_multiply", {"DATA_W": 32}),
        ("wh_multiply", {"COEF_W": 1}),
        ("wh_wave_core", {"N": 0}),
        ("wh_wave_core", {"DELAY_LOG2": 0}),
        ("wh_wave_core", {"SHARED": 2}),
        ("wh_wave_core", {"SHARED": 1, "SHAPER": 1}),
    ],
)
def test_illegal_parameters_stop_elaboration(
    simulator: str, toplevel: str, parameters: dict[str, int]
) -> None:
    with pytest.raises(SimulationError, match=f"wh_illegal_parameter_{toplevel[3:]}"):
        simulate(simulator, toplevel, "tb_arithmetic", parameters)
