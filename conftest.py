# SPDX-License-Identifier: Apache-2.0
"""Which tests are quick, and which are long.

`make check` runs the quick ones: one of each block of the RTL, and the model's own that take no
time. `make test` leaves out the long ones, and `make test-all` runs every test. A test is long by
its mark, or because it is a bench at a further size (:func:`_is_further`).
"""

from __future__ import annotations

import os
import signal
from collections import Counter
from collections.abc import Generator
from pathlib import Path

import pytest

# Tests send these to commands, which inherit it where they are ignored, as under nohup.
signal.signal(signal.SIGHUP, signal.SIG_DFL)
signal.signal(signal.SIGINT, signal.default_int_handler)

BLOCKS = {
    "wh_adc": "test_closed_loop.py::test_closed_loop[icarus]",
    "wh_adc_max11125": "icarus-adc_max11125-LINES=1-FIRST_CHANNEL=3",
    "wh_adc_serial": "icarus-adc_serial-LINES=1",
    "wh_anchor": "icarus-anchor-briefly",
    "wh_anchor_ports": "icarus-anchor_ports-N=2",
    "wh_arm": "icarus-arm-SENSE=0",
    "wh_axes": "test_axes.py::test_axes[icarus-1]",
    "wh_bus_scale": "icarus-bus_scale-N=1",
    "wh_capture": "icarus-capture-N=1-DEPTH_LOG2=6-briefly",
    "wh_carrier": "icarus-carrier",
    "wh_cobs": "icarus-cobs-briefly",
    "wh_clarke": "icarus-clarke",
    "wh_contact": "icarus-contact-WALLS=1",
    "wh_contact_ports": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_controller": "test_closed_loop.py::test_closed_loop[icarus]",
    "wh_core": "icarus-core-N=2",
    "wh_current": "icarus-current",
    "wh_dead_time": "icarus-dead_time",
    "wh_device": "test_ports_device.py::test_ports_device_briefly",
    "wh_drive": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_energy": "icarus-energy",
    "wh_energy_ports": "icarus-energy_ports-N=3",
    "wh_environment": "icarus-environment-HOST=0",
    "wh_environment_ports": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_guard": "icarus-guard-N=1-briefly",
    "wh_guard_ports": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_half_bridge": "icarus-half_bridge",
    "wh_host_link": "icarus-host_link-briefly",
    "wh_inverse_clarke": "icarus-inverse_clarke",
    "wh_link": "test_link.py::test_link_briefly",
    "wh_linked_device": "test_link.py::test_link_briefly",
    "wh_magnet_angle": "icarus-magnet_angle",
    "wh_modbus": "icarus-modbus-briefly",
    "wh_modulator": "icarus-modulator-MIN_PULSE=0-briefly",
    "wh_motion": "icarus-motion-N=3",
    "wh_motor": "test_closed_loop.py::test_closed_loop[icarus]",
    "wh_multiply": "icarus-arithmetic-W=7-LIMB_W=3",
    "wh_multiply_shared": "icarus-multiply_shared",
    "wh_pins": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_port": "test_closed_loop.py::test_closed_loop[icarus]",
    "wh_port_check": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_port_settings": "icarus-core-N=2",
    "wh_port_state": "icarus-core-N=2",
    "wh_ports": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_pwm": "icarus-pwm-MODES=0",
    "wh_quadrature": "icarus-quadrature",
    "wh_register_ram": "icarus-registers-N=1-SHAPER=0-briefly",
    "wh_registers": "icarus-registers-N=1-SHAPER=0-briefly",
    "wh_rotor_flux": "icarus-rotor_flux",
    "wh_round": "icarus-round-IN_W=3-SHIFT=2",
    "wh_round_words": "icarus-round_words-N=2",
    "wh_rows": "icarus-capture-N=1-DEPTH_LOG2=6-briefly",
    "wh_saturate": "icarus-arithmetic-W=7-LIMB_W=3",
    "wh_sense": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_sense_check": "icarus-sense_check",
    "wh_setting_check": "icarus-setting_check",
    "wh_setting_group": "icarus-setting_group-STAGED=1",
    "wh_settings_rom": "icarus-registers-N=1-SHAPER=0-briefly",
    "wh_shaper": "icarus-wave_core-SHAPER=2-WITHHELD=1-TICKS=2000-briefly",
    "wh_shaper_ports": "icarus-core-N=1-SHAPER=1",
    "wh_sinc3": "icarus-sinc3-OSR=4-CAPTURE_RISE=0-TRIP_OSR=2-LINES=1",
    "wh_slots": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_spi": "icarus-spi-briefly",
    "wh_step_watch": "icarus-step_watch",
    "wh_stream": "icarus-stream-N=1-briefly",
    "wh_surface_frame": "test_device_surfaces.py::test_surfaces_briefly",
    "wh_surface_words": "test_surface_station.py::test_surface_station[icarus-2-3]",
    "wh_surfaces": "test_surface_station.py::test_surface_station[icarus-2-3]",
    "wh_synchroniser": "icarus-synchroniser",
    "wh_trip": "icarus-trip",
    "wh_truncate": "icarus-arithmetic-W=7-LIMB_W=3",
    "wh_uart": "icarus-uart-briefly",
    "wh_wave_core": "icarus-wave_core-OUTSIDE=0-TICKS=2000-briefly",
    "wh_wishbone": "icarus-wishbone-briefly",
    "wh_zero": "icarus-zero",
    "wh_legs": "icarus-ports_axes-briefly",
    "wh_phase_pins": "icarus-ports_axes-briefly",
    "wh_rotor": "icarus-ports_axes-briefly",
}
"""A quick test of each block in ``cocotb_tests``: a run of ``benches.toml``, or of another file."""

LOOPS = (
    "cocotb_tests/test_closed_loop.py::test_closed_loop[icarus]",
    "cocotb_tests/test_closed_loop.py::test_closed_loop[verilator]",
)
"""The whole at its pins, with the motor, on each simulator."""

FILES = (
    "sim/tests/test_adcs.py",
    "sim/tests/test_physics.py",
    "sim/tests/test_scene.py",
    "sim/tests/test_shaper.py",
    "sim/tests/test_trace.py",
    "sim/tests/test_words.py",
)
"""Files of which every test is quick."""

QUICK = {
    *(
        f"cocotb_tests/{run if '::' in run else f'test_benches.py::test_bench[{run}]'}"
        for run in BLOCKS.values()
    ),
    *LOOPS,
}

SLOWEST = (
    "sim/tests/test_board_netlist.py",
    "cocotb_tests/test_netlist.py",
    "cocotb_tests/test_link.py",
    "cocotb_tests/test_benches.py",
    "sim/tests/test_boards.py",
    "sim/tests/test_docs.py",
)
"""Begun first, so that none of them ends alone."""


LONG = (
    "cocotb_tests/test_axes.py::test_axes_and_their_anchors",
    "cocotb_tests/test_benches.py::test_bench[verilator-anchor-AXIS=1]",
    "cocotb_tests/test_benches.py::test_bench[verilator-controller-SENSE=1-ANCHOR=1-SHARED=1]",
    "cocotb_tests/test_benches.py::test_bench[verilator-link_spi]",
    "cocotb_tests/test_benches.py::test_bench[verilator-stream_over_the_line]",
    "cocotb_tests/test_board_link.py::test_board_link[icesugar_pro_brushless]",
    "cocotb_tests/test_board_link.py::test_board_link[icesugar_pro_eight]",
    "cocotb_tests/test_board_link.py::test_board_patterns",
    "cocotb_tests/test_device_surfaces.py::test_surfaces_over_the_line",
    "cocotb_tests/test_device_zero.py::test_device_zero",
    "cocotb_tests/test_link.py::test_link",
    "cocotb_tests/test_link.py::test_link_of_three",
    "cocotb_tests/test_netlist.py::test_wave_core[25k]",
    "cocotb_tests/test_ports.py::test_ports",
    "cocotb_tests/test_ports_axes.py::test_ports_axes",
    "cocotb_tests/test_ports_device.py::test_a_brushless_motor",
    "cocotb_tests/test_ports_device.py::test_a_brushless_motor_alone",
    "cocotb_tests/test_ports_device.py::test_ports_device",
    "cocotb_tests/test_ports_surfaces.py::test_ports_surfaces",
    "cocotb_tests/test_surface_station.py::test_surface_station",
    "sim/tests/test_board_netlist.py::test_a_brushless_motor_is_held_whatever_its_angle_is[1]",
    "sim/tests/test_boards.py::test_missed_timing",
    "sim/tests/test_boards.py::test_the_amplifier_follows_in_every_pattern",
    "sim/tests/test_boards.py::test_the_guard_lets_the_boards_own_scene_be[ecp5_evn]",
    "sim/tests/test_brushless_anchor.py::test_pins_find_the_magnets",
    "sim/tests/test_brushless_anchor.py::test_pins_hold_what_golden_holds",
    "sim/tests/test_brushless_pins.py::test_both_axes_reach_their_limit_at_once",
    "sim/tests/test_brushless_soft.py::test_core_is_golden[layer-with-anchors]",
    "sim/tests/test_brushless_soft.py::test_core_is_golden[two-sections-with-anchors]",
    "sim/tests/test_brushless_soft.py::test_core_is_golden[two-sections]",
    "sim/tests/test_brushless_soft.py::test_pins_feel_as_golden[two-sections]",
    "sim/tests/test_brushless_soft.py::test_pins_have_goldens_stiffness[0]",
    "sim/tests/test_brushless_soft.py::test_pins_have_goldens_stiffness[45]",
    "sim/tests/test_brushless_soft.py::test_pins_render_the_spring",
    "sim/tests/test_bus.py::test_every_mode_is_scaled",
    "sim/tests/test_c_library.py::test_random_bytes_never_crash_it_and_are_never_believed",
    "sim/tests/test_c_library.py::test_the_same_in_python",
    "sim/tests/test_c_spi.py::test_a_loop_of_a_host_mcu",
    "sim/tests/test_c_spi.py::test_the_ball_over_a_serial_line",
    "sim/tests/test_captured.py::test_a_capture_is_what_the_simulation_had[0]",
    "sim/tests/test_captured.py::test_a_capture_is_what_the_simulation_had[3]",
    "sim/tests/test_clipped.py::test_an_overloaded_wall_holds_with_what_it_has[servo_motor-pins]",
    "sim/tests/test_compiled.py::test_only_what_is_changed_is_compiled_anew",
    "sim/tests/test_covered.py::test_a_bench_counts_the_block_that_it_runs",
    "sim/tests/test_device_words.py::test_a_brushless_device_that_is_left_alone_is_its_controller",
    "sim/tests/test_device_words.py::test_a_brushless_motors_wall_is_moved_with_the_gates_on",
    "sim/tests/test_device_words.py::test_a_step_is_made_with_old_settings_or_with_new_ones[feels1]",
    "sim/tests/test_device_words.py::test_a_step_of_both_axes_has_old_settings_or_new_ones",
    "sim/tests/test_drive.py::test_compensated_dead_time_leaves_the_wall_as_it_is[settings1",
    "sim/tests/test_edge_hold.py::test_a_brushless_motor_holds_both_phases",
    "sim/tests/test_edge_hold.py::test_a_hold_of_half_a_carrier_period_is_felt_by_nobody[hx8k",
    "sim/tests/test_edge_hold.py::test_a_hold_of_half_a_carrier_period_is_felt_by_nobody[icebreaker",
    "sim/tests/test_edge_hold.py::test_an_edge_that_is_ignored_in_a_hold_leaves_the_wall",
    "sim/tests/test_host_over_the_line.py::test_a_packets_number_and_its_mean_are_of_one_packet",
    "sim/tests/test_host_over_the_line.py::test_each_of_several_motors_has_a_host",
    "sim/tests/test_host_planes.py::test_a_virtual_board_meets_planes",
    "sim/tests/test_host_planes.py::test_planes_about_the_tip_of_a_virtual_board",
    "sim/tests/test_identify.py::test_jammed_over_the_line",
    "sim/tests/test_identify.py::test_spreads_over_the_line",
    "sim/tests/test_link_soak.py::test_a_word_that_is_not_written_is_found",
    "sim/tests/test_link_soak.py::test_nothing_is_found",
    "sim/tests/test_live_settings.py::test_a_limit_below_what_the_anchor_takes_leaves_no_wave",
    "sim/tests/test_live_settings.py::test_a_limit_that_is_raised_while_it_is_at_work[1.25]",
    "sim/tests/test_live_settings.py::test_a_tick_is_made_with_old_words_or_with_new_ones[w]",
    "sim/tests/test_live_settings.py::test_no_energy_is_made_of_a_change[free-some]",
    "sim/tests/test_live_settings.py::test_no_energy_is_made_of_a_change[limited-some]",
    "sim/tests/test_live_settings.py::test_no_energy_is_made_of_a_change[soft-some]",
    "sim/tests/test_live_settings.py::test_no_energy_is_made_of_a_change[worked-some]",
    "sim/tests/test_live_settings.py::test_no_words_of_w_make_the_port_a_source[1.999]",
    "sim/tests/test_paper.py::test_the_encoder_does_not_make_the_force[500]",
    "sim/tests/test_pins_anchor.py::test_a_contact_begins_with_its_edge_whenever_that_comes",
    "sim/tests/test_pins_anchor.py::test_a_host_feels_the_motor_that_the_anchor_makes",
    "sim/tests/test_pulled.py::test_a_killed_board",
    "sim/tests/test_python_api.py::test_an_example_runs_to_its_plot[board",
    "sim/tests/test_python_api.py::test_motors_of_a_tip",
    "sim/tests/test_real_motor.py::test_a_load_and_a_hand_add_to_the_rotors_inertia[brushless-analog]",
    "sim/tests/test_real_scenes.py::test_a_hosted_port_has_the_same_motor",
    "sim/tests/test_report.py::test_a_disc_is_stiff_and_quiet_under_a_light_hand",
    "sim/tests/test_report.py::test_a_servo_needs_the_hand_and_its_bound_is_that_of_sampling",
    "sim/tests/test_report.py::test_field_oriented_control_beside_the_wave_wall",
    "sim/tests/test_report.py::test_parts_that_a_scene_needs_and_parts_that_it_does_not",
    "sim/tests/test_report.py::test_the_shortest_words_run[COEF_W]",
    "sim/tests/test_report.py::test_the_shortest_words_run[STATE_GUARD]",
    "sim/tests/test_run.py::test_pins_with_each_kind_of_adc[MAX11125]",
    "sim/tests/test_sampled_current.py::test_one_sample_a_pulse_and_several[brushes]",
    "sim/tests/test_scene_motors.py::test_motors_of_one_controller_on_pins",
    "sim/tests/test_scene_motors.py::test_with_brushes_and_without[core]",
    "sim/tests/test_scope_browser.py::test_as_a_newcomer_has_it",
    "sim/tests/test_scope_stream.py::test_others_get_the_port",
    "sim/tests/test_scope_stream.py::test_the_page_gets_many_rows_at_even_steps",
    "sim/tests/test_several_motors.py::test_each_motor_has_its_own_settings_and_hand",
    "sim/tests/test_several_motors.py::test_one_of_them_is_the_board_of_one_motor",
    "sim/tests/test_several_motors.py::test_the_scope_shows_the_motor_that_was_asked_for",
    "sim/tests/test_several_motors.py::test_words_of_each_motor",
    "sim/tests/test_surface_damping.py::test_a_damped_surface_on_pins_is_that_of_golden",
    "sim/tests/test_surface_damping.py::test_the_servo_has_the_damper_too",
    "sim/tests/test_sweep_command.py::test_on_processes_and_on_a_cluster_as_alone",
    "sim/tests/test_switch_on.py::test_a_run_ends_its_bridge_where_the_board_trips[ulx3s_brushless",
    "sim/tests/test_switch_on.py::test_what_a_brisk_hand_does[ulx3s_brushless",
    "sim/tests/test_tip_pins.py::test_a_hand_at_the_tip_presses_walls_of_the_motors_own[1]",
    "sim/tests/test_turns.py::test_each_port_is_a_controller_of_one_motor[mode]",
    "sim/tests/test_turns.py::test_each_port_is_a_controller_of_one_motor[real]",
    "sim/tests/test_turns.py::test_each_port_is_a_controller_of_one_motor[shaped]",
    "sim/tests/test_turns.py::test_eight_motors",
    "sim/tests/test_turns.py::test_walls_are_those_of_golden_with_the_same_latency[1e6]",
    "sim/tests/test_virtual_board.py::test_a_brushless_board_over_the_line",
    "sim/tests/test_virtual_board.py::test_a_capture_lets_the_arming_be_renewed",
    "sim/tests/test_virtual_board.py::test_a_capture_of_the_swing",
    "sim/tests/test_virtual_board.py::test_a_wall_that_is_moved",
    "sim/tests/test_virtual_board.py::test_left_alone_it_is_the_device",
    "sim/tests/test_virtual_board.py::test_rows_of_a_brushless_board",
    "sim/tests/test_virtual_board.py::test_tests_without_pseudo_terminals",
    "sim/tests/test_virtual_board.py::test_the_scope_shows_a_brushless_motors_wall",
    "sim/tests/test_virtual_board.py::test_what_a_brushless_board_refuses",
    "sim/tests/test_wheel.py::test_a_shipped_scene_runs_as_here[core]",
    "sim/tests/test_wheel.py::test_a_shipped_scene_runs_as_here[pins]",
)
"""Of 15 s or more each, while a shorter test of the same subject stays in `make test`.

A file's test, or the one of its parameters that begins so.
"""


def pytest_configure(config: pytest.Config) -> None:
    blocks = {path.stem for path in (config.rootpath / "rtl").glob("wh_*.v")}
    if blocks != set(BLOCKS):
        wrong = ", ".join(sorted(blocks ^ set(BLOCKS)))
        raise pytest.UsageError(f"conftest.py: a quick test for each block of rtl/, but: {wrong}")
    if problem := _without_terminals():
        os.openpty = lambda: pytest.skip(problem)


def _without_terminals() -> str:
    """Why the machine has no pseudo-terminals; "" if it has."""
    from wavehaptics.runtime.terminals import check_terminals
    from wavehaptics.runtime.toolchain import ToolError

    try:
        check_terminals()
    except ToolError as error:
        return str(error)
    except pytest.skip.Exception as error:  # after this file's own function
        return str(error)
    return ""


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Count the skipped tests in one line at the end, as if all were skipped here."""
    report = yield
    if report.skipped and isinstance(report.longrepr, tuple) and (why := _without_terminals()):
        reason = report.longrepr[2]
        if why in reason:
            report.longrepr = __file__, 1, reason
    return report


def pytest_report_header() -> str | None:
    """Say at the beginning that tests will be skipped for want of them."""
    problem = _without_terminals()
    return f"tests that need a pseudo-terminal are skipped: {problem}" if problem else None


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """With `-m quick`, files without a quick test aren't even imported."""
    if config.option.markexpr != "quick" or collection_path.suffix != ".py":
        return None
    files = {nodeid.partition("::")[0] for nodeid in QUICK} | set(FILES)
    name = collection_path.relative_to(config.rootpath).as_posix()
    return None if name in files or collection_path.name == "conftest.py" else True


def _is_further(item: pytest.Item, seen: Counter[tuple[str, str]]) -> bool:
    """Whether it is a ``LONG`` one, a bench at a further size, on Icarus, or isn't ``kept``.

    `make test` runs each bench at its first size on Verilator. On Icarus, several times as slow, it
    runs the quick one of each block. ``kept`` makes an exception of a test, or says which of a
    test's parameters stay: by their names, or the first so many.
    """
    test = item.nodeid.partition("[")[0]
    if test in LONG or item.nodeid.startswith(tuple(name for name in LONG if "[" in name)):
        return True
    parameters = item.callspec.params if hasattr(item, "callspec") else {}
    simulator = parameters.get("simulator")
    bench = test, parameters.get("bench", "")
    if kept := item.get_closest_marker("kept"):
        seen[bench] += 1
        first = sum(n for n in kept.args if isinstance(n, int))
        return bool(kept.args) and seen[bench] > first and item.callspec.id not in kept.args
    if simulator is None:
        return False
    seen[bench] += simulator != "icarus"
    return simulator == "icarus" or seen[bench] > 1


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark them. A name of the lists that isn't there any more is an error."""
    seen: Counter[tuple[str, str]] = Counter()
    for item in items:
        if item.nodeid in QUICK or item.nodeid.startswith(tuple(f"{file}::" for file in FILES)):
            item.add_marker("quick")
        elif _is_further(item, seen):
            item.add_marker("long")
    if config.args == config.getini("testpaths"):
        _check_names(items, config.option.markexpr == "quick")
    items.sort(key=lambda item: not item.nodeid.startswith(SLOWEST))


def _check_names(items: list[pytest.Item], quick: bool) -> None:
    """Refuse names that aren't there, of all tests or, with ``quick``, of the quick ones."""
    found = {item.nodeid for item in items}
    if quick:
        files = {nodeid.partition("::")[0] for nodeid in found}
        missing = [*QUICK - found, *set(FILES) - files]
    else:
        missing = [*QUICK - found]
        for item in items:
            if kept := item.get_closest_marker("kept"):
                test = item.nodeid.partition("[")[0]
                names = {f"{test}[{name}]" for name in kept.args if isinstance(name, str)}
                missing += names - found
        missing += [name for name in LONG if not any(there.startswith(name) for there in found)]
    if missing:
        raise pytest.UsageError(f"named, but not there: {sorted(set(missing))}")


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    """Say what was left out."""
    if "not long" in config.option.markexpr:
        terminalreporter.section("left to `make test-all`: tests marked long")
