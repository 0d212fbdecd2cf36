# SPDX-License-Identifier: Apache-2.0
"""What a block can't be built for stops its build, and the message says which parameter it is."""

import pytest
from simulators import SimulationError, simulate


@pytest.mark.parametrize(
    ("toplevel", "parameters", "defines", "message"),
    [
        ("wh_controller", {"N": 9}, {}, "controller_n_must_be_1_to_8"),
        ("wh_controller", {"BUS": 2}, {}, "controller_bus_must_be_0_or_1"),
        ("wh_controller", {"SHARED": 2}, {}, "controller_shared_must_be_0_or_1"),
        ("wh_controller", {"SHARED": 1, "SHAPER": 1}, {}, "shared_must_be_0_or_1_and_0_with"),
        ("wh_device", {"LEGS": 4}, {}, "device_legs_must_be_2_or_3"),
        ("wh_device", {"LEGS": 3, "HOST": 1}, {}, "device_with_three_legs_has_one_motor_and"),
        ("wh_device", {"LEGS": 3, "SHAPER": 1}, {}, "device_with_three_legs_has_one_motor_and"),
        ("wh_axes", {"SHAPER": 3}, {}, "wave_core_n_delay_log2_outside_shaper"),
        ("wh_settings", {"LEGS": 3, "N": 3}, {}, "settings_n_must_be_2_with_three_legs"),
        ("wh_brushless", {"GUARD": 2}, {}, "brushless_guard_must_be_0_or_1"),
        ("wh_brushless", {"SENSE": 2}, {}, "brushless_sense_must_be_0_or_1"),
        ("wh_three_phase", {"DEAD_TIME": 2}, {}, "three_phase_dead_time_must_be_0_or_1"),
        ("wh_bus_scale", {"N": 0}, {}, "bus_scale_n_must_be_1_to_8"),
        ("wh_bus_scale", {}, {"WH_COEF_W": 18}, "WH_COEF_W_too_small_for_a_bus"),
        ("wh_modulator", {"MIN_PULSE": 2}, {}, "modulator_min_pulse_must_be_0_or_1"),
        ("wh_pwm", {"MODES": 2}, {}, "pwm_modes_must_be_0_or_1"),
        ("wh_contact", {"WALLS": 17}, {}, "contact_walls_must_be_1_to_16"),
        ("wh_adc_serial", {"LINES": 0}, {}, "adc_serial_lines_must_be_1_or_more"),
        ("wh_adc_max11125", {"LINES": 9}, {}, "adc_max11125_lines_must_be_1_to_8"),
        ("wh_adc_max11125", {"FIRST_CHANNEL": 16}, {}, "adc_max11125_channels_must_be_0_to_15"),
        ("wh_controller", {"ADC": 3}, {}, "adc_adc_must_be"),
        ("wh_sinc3", {"OSR": 3}, {}, "sinc3_osr_must_be_4_to_256"),
        ("wh_sinc3", {"TRIP_OSR": 3}, {}, "sinc3_trip_osr_must_be"),
        ("wh_zero", {"LOG2_TICKS": 17}, {}, "zero_log2_ticks_must_be_2_to_16"),
        ("wh_capture", {"DEPTH_LOG2": 16}, {}, "capture_depth_log2_must_be_4_to_15"),
        ("wh_arm", {"CREDIT": 1}, {}, "arm_credit_must_be_2_to_2_30"),
        ("wh_synchroniser", {"WIDTH": 0}, {}, "synchroniser_width"),
        ("wh_board_clock_watch", {"GATES": 0}, {}, "clock_watch_gates_must_be_1_or_more"),
        ("wh_board_clock_watch", {"BEAT_LOG2": 1}, {}, "clock_watch_beat_log2_must_be_2_to_16"),
        ("wh_board_clock_watch", {"PATIENCE_LOG2": 17}, {}, "patience_log2_must_be_2_to_16"),
        ("wh_round", {"IN_W": 8, "SHIFT": 1}, {}, "round_shift"),
        ("wh_multiply_shared", {"USERS": 0}, {}, "users_must_be_1_or_more"),
        ("wh_current", {}, {"WH_DATA_W": 24}, "WH_DATA_W_must_hold_a_tick_sum"),
        ("wh_anchor", {}, {"WH_COEF_W": 24}, "anchor_formats"),
        ("wh_modulator", {}, {"WH_COEF_W": 20}, "too_small_for_a_pulse_width"),
    ],
)
def test_build_stops(
    simulator: str,
    toplevel: str,
    parameters: dict[str, int],
    defines: dict[str, int],
    message: str,
) -> None:
    with pytest.raises(SimulationError, match=f"wh_illegal_[^ ]*{message}"):
        simulate(simulator, toplevel, "tb_none", parameters, defines)
