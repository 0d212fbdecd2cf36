# SPDX-License-Identifier: Apache-2.0
"""What the current's sample is not the mean of, on ``pins``: docs/sensing.md."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from wavehaptics.ladder.run import run_scene
from wavehaptics.trace.columns import load_trace

TICK_S, L_H, DROP_V = 1e-5, 80e-6, 0.4
SPUN = (
    "scene.duration_s=0.1", "motor.R_ohm=0.5", f"motor.L_h={L_H}", "motor.k_t=12e-3",
    "motor.J_kgm2=1.2e-6", "hand.path=impact", "hand.speed_rad_s=50", "hand.amplitude_rad=50",
    "encoder.counts_per_rev=20000", "drive.bus_v=12", "drive.limit_v=9", "controller.lambda=1e6",
    f"controller.tick_hz={1 / TICK_S}", "controller.walls=[[100.0, 101.0]]",
)  # fmt: skip
BRUSHES = (f"brushes.drop_v={DROP_V}", "brushes.knee_a=1e-4")
ONE, SEVERAL = "controller.clock_hz=5e6", "controller.clock_hz=50e6"


def drift(scene, tmp_path: Path) -> float:
    """Mean current of a rotor that is spun in free space, A, where the controller sees none."""
    run_scene(scene, "pins", tmp_path)
    trace = load_trace(tmp_path)
    assert abs(np.mean(trace["i_word"])) * 2.0**-24 < 2e-4
    return float(np.mean(trace["i"]))


@pytest.mark.parametrize("sets", [SPUN, (*SPUN, *BRUSHES)], ids=["plain", "brushes"])
def test_one_sample_a_pulse_and_several(make_scene, tmp_path: Path, sets: tuple[str, ...]):
    """Brushes make up to V_b T/4L at the samples, and of several samples a tenth of that."""
    one = drift(make_scene(*sets, ONE), tmp_path)
    triangle = DROP_V * TICK_S / (4 * L_H) if "brushes.knee_a=1e-4" in sets else 0.0
    # Beside it what the back-EMF's pulses leave, up to v (T/L)² R/24: 0.2 mA.
    assert 0.5 * triangle < one < triangle + 5e-4
    several = drift(make_scene(*sets, SEVERAL), tmp_path)
    assert abs(several) < 0.1 * triangle + 5e-4
