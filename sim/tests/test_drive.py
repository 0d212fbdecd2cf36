# SPDX-License-Identifier: Apache-2.0
"""The drive on ``pins``: dead time and its compensation, and the modes of the bridge."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.controller.ports import controller_ports
from wavehaptics.ladder.run import run_scene
from wavehaptics.scene import SCENES_DIR, SceneError, load_scene
from wavehaptics.words import formats
from wavehaptics.words.bridge_modes import MODE_WORDS, UNIPOLAR

# 50 ns at 500 kHz and 12 V: 0.6 V against every current, of the 2.1 V that the paper's taps have.
DEAD = ("drive.bus_v=12", "drive.pwm_hz=500e3", "drive.dead_time_s=50e-9", "scene.duration_s=0.5")


PAPER_TAPS = SCENES_DIR / "paper_taps.toml"


def load(*settings: str):
    return load_scene(PAPER_TAPS, DEAD + settings)


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
    with pytest.raises(
        SceneError, match=r"drive\.dead_time_s .*half a clock .*none; take 2\.\d+e-08"
    ):
        controller_ports(load("drive.dead_time_s=1e-9"))
    with pytest.raises(SceneError, match=r"drive\.dead_time_s .*clock_hz <= 2\.55e\+06"):
        controller_ports(load("drive.dead_time_s=100e-6", "drive.pwm_hz=1e3"))


# Both signs in one run: a wall on either side of a hand that swings.
BOTH_SIGNS = (
    "hand.path=sine",
    "hand.frequency_hz=20",
    "controller.walls=[[-1.0, -0.002], [0.002, 1.0]]",
    "scene.duration_s=0.05",
    "drive.bus_v=12",
    "controller.clock_hz=100e6",
)
MODES = [mode for mode in MODE_WORDS if mode != UNIPOLAR]


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (("drive.pwm_hz=6e6",), "a carrier half of 4 clocks of .* is shorter than the 6 that"),
        (("controller.clock_hz=4e6",), "is shorter than the 6 that `pins` needs; lower"),
        (
            ("controller.clock_hz=2e6", "controller.tick_hz=100e3", "drive.pwm_hz=50e3"),
            "the ADC needs 34 clocks of 2e[+]06 Hz .* leaves 20; lower it",
        ),
        (("drive.dead_time_s=1e-6",), "48 clocks of `pins`, as long as a carrier half of 48; take"),
        (("drive.dead_time_s=0.82e-6",), "dead time of 39 clocks .* 24.375 clocks longer, and the"),
        (("drive.pwm_hz=1e3", "drive.bus_v=6"), "a volt at a bus of 6 V is 2000 clocks of the"),
    ],
)
def test_what_a_carrier_has_no_clocks_for_is_refused(settings: tuple[str, ...], told: str) -> None:
    """Each of them ran, or ended in an error that named no key."""
    base = ("drive.bus_v=12", "controller.tick_hz=1e6")
    with pytest.raises(SceneError, match=told):
        controller_ports(load_scene(PAPER_TAPS, (*base, *settings)))


@pytest.mark.parametrize("mode", MODE_WORDS)
def test_every_mode_makes_the_wall(mode, tmp_path):
    """Torque against the analog circuit, either way, on half a carrier period of 50 clocks."""
    scene = load_scene(PAPER_TAPS, [*BOTH_SIGNS, f"drive.mode={mode}"])
    metrics = run_scene(scene, "pins", tmp_path)
    assert metrics["torque_nrmse_vs_analog"] < 5e-3
    assert metrics["stiffness"] == pytest.approx(metrics["stiffness_predicted"], rel=0.01)
    torque = np.load(tmp_path / "trace.npz")["torque"]
    assert torque.min() < -0.015
    assert torque.max() > 0.015


@pytest.mark.parametrize("mode", MODES)
def test_dead_time_is_compensated_in_the_unipolar_mode_only(mode):
    with pytest.raises(SceneError, match=rf"drive\.compensate: .* {mode}, .*compensate = false"):
        controller_ports(load(f"drive.mode={mode}", "controller.tick_hz=500e3"))
    ports = controller_ports(
        load(f"drive.mode={mode}", "controller.tick_hz=500e3", "drive.compensate=false")
    )
    assert (ports.words["compensate"], ports.timing.tick_halves) == (0, 2)


def test_a_half_bridge_reaches_half_the_bus():
    ports = controller_ports(load_scene(PAPER_TAPS, ["drive.mode=half-bridge", "drive.bus_v=8"]))
    half = ports.timing.half_clocks
    assert ports.words["clocks_per_volt"] == formats.DUTY.to_raw(half / 8)
    with pytest.raises(
        SceneError, match=r"limit_v = 2\.1 is above what a half-bridge has of bus_v"
    ):
        load_scene(PAPER_TAPS, ["drive.mode=half-bridge", "drive.bus_v=4"])
    # The default bus is one that reaches the limit.
    drive = load_scene(PAPER_TAPS, ["drive.mode=half-bridge", "drive.limit_v=7"]).drive
    assert drive.bus_v == 24.0
    drive = load_scene(PAPER_TAPS, ["drive.mode=half-bridge"]).drive
    assert (drive.bus_v, drive.reach) == (12.0, 0.5)


def test_ticks_of_half_a_period_are_refused_where_a_pulse_takes_a_whole_one():
    for settings, wanted in (
        (["drive.pwm_hz=1.5e6"], "with mode = half-bridge pwm_hz must be"),
        (["controller.clock_hz=49e6"], "even number of clocks in a tick, not 49"),
    ):
        with pytest.raises(SceneError, match=wanted):
            controller_ports(load_scene(PAPER_TAPS, ["drive.mode=half-bridge", *settings]))
    # A carrier slower than the tick sets the pace.
    laid = controller_ports(
        load_scene(PAPER_TAPS, ["drive.mode=half-bridge", "drive.pwm_hz=250e3"])
    ).timing
    assert (laid.tick_s, laid.tick_halves) == (pytest.approx(4e-6), 2)


def test_the_shortest_pulse_in_clocks():
    """The gate's time on comes after the dead time; what the legs keep, the limit doesn't have."""
    ports = controller_ports(
        load("drive.min_pulse_s=30e-9", "controller.clock_hz=100e6", "drive.limit_v=12")
    )
    assert (ports.words["dead_clocks"], ports.words["min_pulse"]) == (5, 8)
    half = ports.timing.half_clocks
    assert ports.settings.limit_v == pytest.approx(12.0 * (1 - (5 + 8) / half))
    with pytest.raises(SceneError, match=r"min_pulse_s = 3e-07 s .* 35 clocks .* room for 25"):
        controller_ports(load("drive.min_pulse_s=300e-9", "controller.clock_hz=100e6"))


def test_a_wall_of_pulses_that_are_not_short(tmp_path):
    """What the shortest pulse swallows comes later: the torque is that of the analog circuit."""
    scene = load_scene(PAPER_TAPS, [*BOTH_SIGNS, "drive.min_pulse_s=50e-9"])
    metrics = run_scene(scene, "pins", tmp_path)
    assert metrics["torque_nrmse_vs_analog"] < 5e-3
    assert metrics["stiffness"] == pytest.approx(metrics["stiffness_predicted"], rel=0.01)
