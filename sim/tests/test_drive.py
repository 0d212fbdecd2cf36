# SPDX-License-Identifier: Apache-2.0
"""The drive on ``pins``: what dead time does to a wall, and what its compensation gives back."""

from __future__ import annotations

import pytest
from wavehaptics.pins import controller_ports
from wavehaptics.run import run_scene
from wavehaptics.scene import SCENES_DIR, SceneError, load_scene

# 50 ns at 500 kHz and 12 V: 0.6 V against every current, of the 2.1 V that the paper's taps have.
DEAD = (
    "drive.bus_v=12",
    "drive.pwm_hz=500e3",
    "drive.dead_time_s=50e-9",
    "scene.duration_s=0.5",
)


def load(*settings: str):
    return load_scene(SCENES_DIR / "paper_taps.toml", DEAD + settings)


@pytest.mark.parametrize(
    ("settings", "most_error"),
    [
        # Four clocks of dead time, five of which the middle falls between two clocks, and an ADC
        # with noise as large as its step.
        (("controller.clock_hz=80e6",), 5e-3),
        (("controller.clock_hz=100e6",), 5e-3),
        (
            ("controller.clock_hz=80e6", "adc.bits=12", "adc.full_scale_a=2.5", "adc.noise_a=1e-3"),
            5e-3,
        ),
    ],
)
def test_compensated_dead_time_leaves_the_wall_as_it_is(settings, most_error, tmp_path):
    """Torque, stiffness and free space are those of a bridge without dead time."""
    metrics = run_scene(load(*settings), "pins", tmp_path)
    assert metrics["torque_nrmse_vs_analog"] < most_error
    assert metrics["stiffness"] == pytest.approx(metrics["stiffness_predicted"], rel=0.01)
    assert metrics["free_space_torque_rms"] < 1e-4
    # What the core believes to have applied is what was applied, so the port stays passive, but for
    # the kicks near 0 A.
    assert metrics["energy_out_max_j"] < 1e-8


def test_dead_time_without_compensation_takes_the_wall_away(tmp_path):
    """The check above can fail: 0.6 V of friction hold the current at zero."""
    metrics = run_scene(
        load("drive.compensate=false", "controller.clock_hz=80e6"), "pins", tmp_path
    )
    assert metrics["peak_torque"] < 1e-4


def test_the_voltage_limit_leaves_room_for_the_compensation():
    """At the limit the longer pulse still fits into its half."""
    ports = controller_ports(load("drive.limit_v=12", "controller.clock_hz=80e6"))
    assert ports.words["dead_clocks"] == 4
    half = ports.timing.half_clocks
    volts_per_clock = 2 * 12.0 / half
    room = half / 2 - ports.settings.limit_v / volts_per_clock
    assert room == pytest.approx(ports.words["dead_clocks"] / 2)


def test_a_dead_time_that_the_rtl_cannot_count_is_refused():
    with pytest.raises(SceneError, match=r"drive\.dead_time_s .*clock_hz <= 2\.55e\+06"):
        controller_ports(load("drive.dead_time_s=100e-6", "drive.pwm_hz=1e3"))
