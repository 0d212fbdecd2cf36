# SPDX-License-Identifier: Apache-2.0
"""Which tests are quick: one of each block of the RTL, and the model's own that take no time.

And which ones are long: further sizes and devices of what others of their file show as well, some
half an hour of two cores. `make test` runs them, unless in CI, which names them at its end.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Generator
from pathlib import Path

import pytest

# Tests send these to commands, which inherit it where they are ignored, as under nohup.
signal.signal(signal.SIGHUP, signal.SIG_DFL)
signal.signal(signal.SIGINT, signal.default_int_handler)

BLOCKS = {
    "wh_adc": "test_closed_loop.py::test_closed_loop[icarus]",
    "wh_adc_max11125": "test_adc_max11125.py::test_adc_max11125[icarus-1-3]",
    "wh_adc_serial": "test_adc_serial.py::test_adc_serial[icarus-1]",
    "wh_anchor": "test_briefly.py::test_briefly[anchor]",
    "wh_anchor_ports": "test_anchor_ports.py::test_anchor_ports[icarus-2]",
    "wh_arm": "test_arm.py::test_arm[icarus-0]",
    "wh_axes": "test_axes.py::test_axes[icarus-1]",
    "wh_brushless": "test_brushless_controller.py::test_brushless_controller[icarus-0]",
    "wh_bus_scale": "test_bus_scale.py::test_bus_scale[icarus-1]",
    "wh_capture": "test_briefly.py::test_briefly[capture]",
    "wh_carrier": "test_carrier.py::test_carrier[icarus]",
    "wh_cobs": "test_briefly.py::test_briefly[cobs]",
    "wh_clarke": "test_clarke.py::test_clarke[icarus-full]",
    "wh_contact": "test_contact.py::test_contact[icarus-1]",
    "wh_contact_ports": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_controller": "test_closed_loop.py::test_closed_loop[icarus]",
    "wh_core": "test_core.py::test_core[icarus-2-0-0]",
    "wh_current": "test_current.py::test_current[icarus]",
    "wh_dead_time": "test_dead_time.py::test_dead_time[icarus]",
    "wh_device": "test_wishbone.py::test_wishbone[icarus]",
    "wh_drive": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_energy": "test_energy.py::test_energy[icarus]",
    "wh_energy_ports": "test_energy_ports.py::test_energy_ports[icarus-3]",
    "wh_environment": "test_environment.py::test_environment[icarus-0]",
    "wh_environment_ports": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_guard": "test_briefly.py::test_briefly[guard]",
    "wh_guard_ports": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_half_bridge": "test_half_bridge.py::test_half_bridge[icarus]",
    "wh_host_link": "test_briefly.py::test_briefly[host_link]",
    "wh_inverse_clarke": "test_inverse_clarke.py::test_inverse_clarke[icarus-full]",
    "wh_link": "test_link.py::test_link_briefly",
    "wh_linked_device": "test_link.py::test_link_briefly",
    "wh_magnet_angle": "test_magnet_angle.py::test_magnet_angle[icarus]",
    "wh_modbus": "test_modbus.py::test_modbus_briefly",
    "wh_modulator": "test_briefly.py::test_briefly[modulator]",
    "wh_motor_device": "test_briefly.py::test_briefly[device]",
    "wh_motor": "test_closed_loop.py::test_closed_loop[icarus]",
    "wh_multiply": "test_arithmetic.py::test_every_small_word[icarus]",
    "wh_multiply_shared": "test_multiply_shared.py::test_multiply_shared[icarus]",
    "wh_pins": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_port": "test_closed_loop.py::test_closed_loop[icarus]",
    "wh_port_check": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_port_settings": "test_core.py::test_core[icarus-2-0-0]",
    "wh_port_state": "test_core.py::test_core[icarus-2-0-0]",
    "wh_ports": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_ports_device": "test_ports_device.py::test_ports_device_briefly",
    "wh_pwm": "test_pwm.py::test_pwm[icarus-0]",
    "wh_quadrature": "test_quadrature.py::test_quadrature[icarus]",
    "wh_register_ram": "test_register_bus.py::test_register_bus[icarus-1-0]",
    "wh_registers": "test_register_bus.py::test_register_bus[icarus-1-0]",
    "wh_rotor_flux": "test_rotor_flux.py::test_rotor_flux[icarus]",
    "wh_round": "test_round.py::test_round[icarus-3-2]",
    "wh_round_words": "test_round_words.py::test_round_words[icarus-2]",
    "wh_rows": "test_briefly.py::test_briefly[capture]",
    "wh_saturate": "test_arithmetic.py::test_every_small_word[icarus]",
    "wh_sense": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_sense_check": "test_sense_check.py::test_sense_check[icarus]",
    "wh_setting_check": "test_setting_check.py::test_setting_check[icarus]",
    "wh_setting_group": "test_setting_group.py::test_setting_group[icarus-1]",
    "wh_settings": "test_briefly.py::test_briefly[settings]",
    "wh_settings_ram": "test_briefly.py::test_briefly[settings]",
    "wh_settings_rom": "test_briefly.py::test_briefly[settings]",
    "wh_shaper": "test_briefly.py::test_briefly[shaper]",
    "wh_shaper_ports": "test_core.py::test_core[icarus-1-0-1]",
    "wh_sinc3": "test_sinc3.py::test_sinc3[icarus-4-0-2-1]",
    "wh_slots": "test_ports.py::test_ports[icarus-2-0-0-0]",
    "wh_step_watch": "test_step_watch.py::test_step_watch[icarus]",
    "wh_tick_words": "test_tick_words.py::test_tick_words[icarus-1]",
    "wh_stream": "test_briefly.py::test_briefly[stream]",
    "wh_synchroniser": "test_synchroniser.py::test_synchroniser[icarus]",
    "wh_three_phase": "test_briefly.py::test_briefly[three_phase]",
    "wh_trip": "test_trip.py::test_trip[icarus]",
    "wh_truncate": "test_arithmetic.py::test_every_small_word[icarus]",
    "wh_uart": "test_briefly.py::test_briefly[uart]",
    "wh_wave_core": "test_briefly.py::test_briefly[wave_core]",
    "wh_wishbone": "test_briefly.py::test_briefly[wishbone]",
    "wh_zero": "test_zero.py::test_zero[icarus]",
    "wh_legs": "test_ports_axes.py::test_ports_axes[icarus-2-1-0-0]",
    "wh_phase_pins": "test_ports_axes.py::test_ports_axes[icarus-2-1-0-0]",
    "wh_rotor": "test_ports_axes.py::test_ports_axes[icarus-2-1-0-0]",
}
"""A quick test of each block, in ``cocotb_tests``."""

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

QUICK = {*(f"cocotb_tests/{test}" for test in BLOCKS.values()), *LOOPS}

LONG = (
    "cocotb_tests/test_board_clock_watch.py::test_board_clock_watch[verilator-3-5]",
    "cocotb_tests/test_board_clock_watch.py::test_board_clock_watch[verilator-4-4]",
    "cocotb_tests/test_board_controller.py::test_board_controller[verilator-ulx3s]",
    "cocotb_tests/test_board_controller.py::test_board_controller[verilator-hx8k]",
    "cocotb_tests/test_bus_scale.py::test_bus_scale[verilator-3]",
    "cocotb_tests/test_capture.py::test_capture[verilator-3-7-4000]",
    "cocotb_tests/test_clarke.py::test_clarke[verilator-short]",
    "cocotb_tests/test_commit.py::test_commit[1-0]",
    "cocotb_tests/test_commit.py::test_commit[2-0]",
    "cocotb_tests/test_commit.py::test_commit[3-0]",
    "cocotb_tests/test_commit.py::test_commit[3-1]",
    "cocotb_tests/test_commit.py::test_commit[4-0]",
    "cocotb_tests/test_commit.py::test_commit[4-1]",
    "cocotb_tests/test_commit.py::test_commit[5-0]",
    "cocotb_tests/test_commit.py::test_commit[5-1]",
    "cocotb_tests/test_commit.py::test_commit[6-0]",
    "cocotb_tests/test_commit.py::test_commit[6-1]",
    "cocotb_tests/test_commit.py::test_commit[7-0]",
    "cocotb_tests/test_commit.py::test_commit[7-1]",
    "cocotb_tests/test_commit.py::test_commit[8-0]",
    "cocotb_tests/test_commit.py::test_commit[8-1]",
    "cocotb_tests/test_commit.py::test_commit_of[shared]",
    "cocotb_tests/test_commit.py::test_commit_of[shaper]",
    "cocotb_tests/test_commit.py::test_commit_of[brushless_alone]",
    "cocotb_tests/test_commit.py::test_commit_on_icarus",
    "cocotb_tests/test_controller.py::test_controller[verilator-1-4-2-1-0-1-0-0-0-0]",
    "cocotb_tests/test_controller.py::test_controller[verilator-1-4-2-0-2-0-0-0-0-0]",
    "cocotb_tests/test_controller.py::test_controller[verilator-3-1-1-0-0-0-0-1-0-0]",
    "cocotb_tests/test_controller.py::test_controller[verilator-1-4-2-0-0-0-0-1-1-0]",
    "cocotb_tests/test_controller.py::test_controller[verilator-3-1-1-0-0-0-0-0-1-0]",
    "cocotb_tests/test_controller.py::test_controller[verilator-1-4-2-0-0-0-1-1-0-0]",
    "cocotb_tests/test_controller.py::test_controller[verilator-3-1-1-0-0-1-0-0-0-0]",
    "cocotb_tests/test_controller.py::test_controller[verilator-3-1-1-0-0-0-0-0-1-1]",
    "cocotb_tests/test_controller_sigma_delta.py::test_controller_sigma_delta[verilator-2-16]",
    "cocotb_tests/test_controller_ticks.py::test_controller_ticks[3-16-0]",
    "cocotb_tests/test_controller_ticks.py::test_controller_ticks[1-10-0]",
    "cocotb_tests/test_link.py::test_link_of_three[verilator]",
    "cocotb_tests/test_netlist.py::test_closed_loop[up5k]",
    "cocotb_tests/test_netlist.py::test_wave_core[hx8k]",
    "cocotb_tests/test_netlist.py::test_closed_loop[hx8k]",
    "cocotb_tests/test_netlist.py::test_wave_core[up5k]",
    "cocotb_tests/test_netlist.py::test_closed_loop[25k]",
    "cocotb_tests/test_device.py::test_device[verilator-three]",
    "cocotb_tests/test_ports.py::test_ports[verilator-3-2-0-0]",
    "cocotb_tests/test_ports.py::test_ports[verilator-8-0-0-0]",
    "cocotb_tests/test_ports_axes.py::test_ports_axes[verilator-2-1-0-0]",
    "cocotb_tests/test_ports_axes.py::test_ports_axes[verilator-2-1-2-0]",
    "cocotb_tests/test_ports_axes.py::test_ports_axes[verilator-3-2-0-0]",
    "cocotb_tests/test_ports_axes.py::test_ports_axes[verilator-5-5-0-0]",
    "cocotb_tests/test_ports_device.py::test_a_brushless_motor[verilator-3-2]",
    "cocotb_tests/test_settings.py::test_settings[verilator-large]",
    "cocotb_tests/test_sinc3.py::test_sinc3[verilator-256-1-32-1]",
    "cocotb_tests/test_sinc3.py::test_sinc3[verilator-20-0-8-2]",
    "cocotb_tests/test_sinc3.py::test_sinc3[verilator-40-1-16-1]",
    "cocotb_tests/test_wave_core.py::test_wave_core_ports[verilator-1-10]",
    "cocotb_tests/test_wave_core.py::test_wave_core_with_a_shaper[verilator-2-1]",
    "cocotb_tests/test_wave_core.py::test_wave_core_ports[verilator-3-1]",
    "cocotb_tests/test_wave_core.py::test_wave_core_with_a_shaper[verilator-2-3]",
    "sim/tests/test_wheel.py::test_the_demo_without_the_repository",
    "sim/tests/test_several_motors.py::test_a_session_of_three",
    "sim/tests/test_several_motors.py::test_a_stream_of_two_motors",
    "sim/tests/test_several_motors.py::test_a_wall_of_one_motor_alone",
    "sim/tests/test_abilities.py::test_a_key_has_an_effect_or_is_said_to_have_none[pins]",
    "sim/tests/test_board_netlist.py::test_what_is_flashed_for_a_brushless_motor",
    "sim/tests/test_board_netlist.py::test_what_is_flashed[ulx3s]",
    "sim/tests/test_board_netlist.py::test_what_is_flashed[ulx3s_three]",
    "sim/tests/test_board_netlist.py::test_what_is_flashed[icebreaker]",
    "sim/tests/test_board_netlist.py::test_what_is_flashed[hx8k]",
    "sim/tests/test_boards.py::test_the_guard_lets_the_boards_own_scene_be[ulx3s]",
    "sim/tests/test_boards.py::test_fresh_synthesis_is_what_the_pages_say[ulx3s]",
    "sim/tests/test_boards.py::test_fresh_synthesis_is_what_the_pages_say[icebreaker]",
    "sim/tests/test_boards.py::test_the_guard_lets_the_boards_own_scene_be[orangecrab]",
    "sim/tests/test_boards.py::test_the_guard_lets_the_boards_own_scene_be[ulx3s_three]",
    "sim/tests/test_brushless_pins.py::test_stiffness_at_eight_angles[180-degrees]",
    "sim/tests/test_brushless_pins.py::test_stiffness_at_eight_angles[315-degrees]",
    "sim/tests/test_brushless_pins.py::test_stiffness_at_eight_angles[270-degrees]",
    "sim/tests/test_brushless_pins.py::test_stiffness_at_eight_angles[225-degrees]",
    "sim/tests/test_brushless_pins.py::test_stiffness_at_eight_angles[90-degrees]",
    "sim/tests/test_brushless_pins.py::test_stiffness_at_eight_angles[45-degrees]",
    "sim/tests/test_bus.py::test_every_mode_is_scaled[locked-anti-phase]",
    "sim/tests/test_c_library.py::test_a_host_that_steals_gets_what_went_in",
    "sim/tests/test_c_library.py::test_a_bad_line_and_a_killed_host[1]",
    "sim/tests/test_c_library.py::test_a_bad_line_and_a_killed_host[2]",
    "sim/tests/test_c_library.py::test_the_wall_of_a_computer",
    "sim/tests/test_device_words.py::test_a_device_that_is_left_alone_is_the_controller[more1]",
    "sim/tests/test_identify.py::test_identified_over_the_line",
    "sim/tests/test_identify_brushless.py::test_identified_over_the_line",
    "sim/tests/test_several_motors.py::test_a_board_that_is_a_board_has_its_motors",
    "cocotb_tests/test_board_link.py::test_board_link[ulx3s_three]",
    "cocotb_tests/test_board_link.py::test_board_link[icesugar_pro_eight]",
    "sim/tests/test_live_settings.py::test_no_energy_is_made_of_a_change[held-every]",
    "sim/tests/test_live_settings.py::test_no_energy_is_made_of_a_change[free-every]",
    "sim/tests/test_live_settings.py::test_no_energy_is_made_of_a_change[limited-every]",
    "sim/tests/test_live_settings.py::test_no_energy_is_made_of_a_change[worked-every]",
    "sim/tests/test_live_settings.py::test_no_energy_is_made_of_a_change[soft-every]",
    "sim/tests/test_pins_anchor.py::test_pins_hold_what_golden_holds[settings0-0.014]",
    "sim/tests/test_pins_anchor.py::test_pins_hold_what_golden_holds[settings1-0.014]",
    "sim/tests/test_pins_anchor.py::test_pins_hold_what_golden_holds[settings2-0.012]",
    "sim/tests/test_run.py::test_core_and_golden_are_the_same_integers[warm_winding]",
    "sim/tests/test_run.py::test_pins_with_each_kind_of_adc[AD7403]",
    "sim/tests/test_run.py::test_core_and_golden_are_the_same_integers[mass]",
    "sim/tests/test_run.py::test_core_and_golden_are_the_same_integers[bounce]",
    "sim/tests/test_run.py::test_pins_with_each_kind_of_adc[AD7276]",
    "sim/tests/test_run.py::test_pins_with_each_kind_of_adc[ADS7042]",
    "sim/tests/test_run.py::test_core_and_golden_are_the_same_integers[live_wall]",
    "sim/tests/test_run.py::test_pins_with_each_kind_of_adc[MAX11125]",
)
"""Tests that CI leaves out, beside those of :func:`_again`."""

ELABORATED = (
    "cocotb_tests/test_arithmetic.py",
    "cocotb_tests/test_illegal_parameters.py",
    "cocotb_tests/test_simulators.py",
)
"""Files whose tests are of the simulators themselves, and short."""

SLOWEST = (
    "sim/tests/test_board_netlist.py",
    "cocotb_tests/test_netlist.py",
    "cocotb_tests/test_modbus.py",
    "cocotb_tests/test_link.py",
    "cocotb_tests/test_controller.py",
    "cocotb_tests/test_board_clock_watch.py",
    "cocotb_tests/test_anchor.py",
    "cocotb_tests/test_wave_core.py",
    "cocotb_tests/test_sinc3.py",
    "cocotb_tests/test_board_controller.py",
    "sim/tests/test_boards.py",
    "sim/tests/test_docs.py",
)
"""Begun first, so that none of them ends alone."""


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


def _again(nodeid: str, all_of_them: set[str]) -> bool:
    """Whether it is a bench once more on Icarus, several times as slow as on Verilator.

    Of each block one is quick, and so is in CI on both simulators.
    """
    return (
        nodeid.startswith("cocotb_tests/")
        and not nodeid.startswith(ELABORATED)
        and nodeid not in QUICK
        and "[icarus" in nodeid
        and nodeid.replace("[icarus", "[verilator") in all_of_them
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark them. A quick test that isn't there any more is an error of the list."""
    all_of_them = {item.nodeid for item in items}
    for item in items:
        if item.nodeid in QUICK or item.nodeid.startswith(tuple(f"{file}::" for file in FILES)):
            item.add_marker("quick")
        if item.nodeid in LONG or _again(item.nodeid, all_of_them):
            item.add_marker("long")
    if config.option.markexpr == "quick" and config.args == config.getini("testpaths"):
        found = {item.nodeid for item in items}
        files = {nodeid.partition("::")[0] for nodeid in found}
        if missing := sorted(QUICK - found) + sorted(set(FILES) - files):
            raise pytest.UsageError(f"conftest.py calls tests quick that aren't there: {missing}")
    if "not quick" in config.option.markexpr and config.args == config.getini("testpaths"):
        found = {item.nodeid for item in items}
        if missing := sorted(set(LONG) - found):
            raise pytest.UsageError(f"conftest.py calls tests long that aren't there: {missing}")
    items.sort(key=lambda item: not item.nodeid.startswith(SLOWEST))


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    """Say what was left out."""
    if "not long" in config.option.markexpr:
        terminalreporter.section("left to `make test` outside of CI")
        for test in LONG:
            terminalreporter.write_line(test)
        terminalreporter.write_line(
            "cocotb_tests: [icarus...] where it isn't the quick one of its block"
        )
