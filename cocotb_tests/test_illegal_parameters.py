# SPDX-License-Identifier: Apache-2.0
"""What a block can't be built for stops its build, and the message says which parameter it is."""

import re
import shutil
import subprocess
from collections import defaultdict
from collections.abc import Iterator

import pytest
from simulators import SimulationError, simulate
from wavehaptics.ladder.verilated import verilator_environment
from wavehaptics.runtime.repository import ROOT, RTL_DIR

pytestmark = pytest.mark.kept


@pytest.mark.parametrize(
    ("toplevel", "parameters", "defines", "message"),
    [
        ("wh_truncate", {"IN_W": 8, "SHIFT": 0}, {}, "parameter_truncate"),
        ("wh_truncate", {"IN_W": 8, "SHIFT": 8}, {}, "parameter_truncate"),
        ("wh_saturate", {"IN_W": 8, "OUT_W": 8}, {}, "parameter_saturate"),
        ("wh_saturate", {"IN_W": 8, "OUT_W": 1}, {}, "parameter_saturate"),
        ("wh_multiply", {"DATA_W": 32}, {}, "parameter_multiply"),
        ("wh_multiply", {"COEF_W": 1}, {}, "parameter_multiply"),
        ("wh_wave_core", {"N": 0}, {}, "parameter_wave_core"),
        ("wh_wave_core", {"DELAY_LOG2": 0}, {}, "parameter_wave_core"),
        ("wh_wave_core", {"SHARED": 2}, {}, "parameter_wave_core"),
        ("wh_wave_core", {"SHARED": 1, "SHAPER": 1}, {}, "parameter_wave_core"),
        ("wh_controller", {"N": 9}, {}, "controller_n_must_be_1_to_8"),
        ("wh_controller", {"BUS": 2}, {}, "controller_bus_must_be_0_or_1"),
        ("wh_controller", {"SHARED": 2}, {}, "controller_shared_must_be_0_or_1"),
        ("wh_controller", {"SHARED": 1, "SHAPER": 1}, {}, "shared_must_be_0_or_1_and_0_with"),
        ("wh_device", {"N": 9}, {}, "n_must_be_1_to_8"),
        ("wh_device", {"N": 2, "AXES": 2}, {}, "slots_axes_must_be_pairs_of_ports"),
        ("wh_slots", {"N": 3, "AXES": 3}, {}, "slots_axes_must_be_pairs_of_ports"),
        ("wh_slots", {"N": 2, "AXES": 2}, {}, "slots_axes_must_be_pairs_of_ports"),
        ("wh_surfaces", {"PORTS": 4}, {}, "surfaces_ports_must_be_2_or_3"),
        ("wh_surfaces", {"SURFACES": 9}, {}, "surfaces_must_be_1_to_8"),
        ("wh_ports", {"N": 4, "SURFACES": 1}, {}, "ports_surfaces_need_2_or_3_ports"),
        ("wh_ports", {"N": 2, "SURFACES": 1, "HOST": 1}, {}, "ports_surfaces_need_2_or_3_ports"),
        ("wh_drive", {"N": 2, "LEGS": 1}, {}, "drive_legs_must_be_n_to_12"),
        ("wh_rotor_flux", {"MOTORS": 5}, {}, "rotor_flux_motors_must_be_1_to_4"),
        ("wh_device", {"CAPTURE": 3}, {}, "capture_depth_log2_must_be_4_to_15"),
        ("wh_axes", {"SHAPER": 3}, {}, "wave_core_n_delay_log2_outside_shaper"),
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
    simulator: str, toplevel: str, parameters: dict[str, int], defines: dict[str, int], message: str
) -> None:
    with pytest.raises(SimulationError, match=f"wh_illegal_[^ ]*{message}"):
        simulate(simulator, toplevel, "tb_none", parameters, defines)


PARAMETER = re.compile(r"parameter integer +(\w+) *= *([^,/]*?)[ ,]*(?://(.*))?")
SWITCH = re.compile(r"\s*[01]: ")
"""How a comment begins that says what 0 or 1 means."""
RANGE = re.compile(r"\.\.\.|derived")
NEITHER = {"ADC": "a choice of three", "WORDS": "a number of words"}
"""Parameters with 0 or 1 as default, and neither meaning nor range in a comment."""


def rtl_parameters() -> Iterator[tuple[str, str, str, str]]:
    """(Module, parameter, default, comment) of all that the RTL has."""
    for path in sorted(RTL_DIR.glob("wh_*.v")):
        for line in path.read_text(encoding="utf-8").splitlines():
            if found := PARAMETER.fullmatch(line.strip()):
                yield path.stem, found[1], found[2], found[3] or ""


def switches() -> list[tuple[str, str]]:
    """(Module, parameter) of each that is 0 or 1, as a comment of it in any module says."""
    names = {name for _, name, _, comment in rtl_parameters() if SWITCH.match(comment)}
    return [(module, name) for module, name, _, _ in rtl_parameters() if name in names]


def test_every_parameter_says_what_it_may_be() -> None:
    told = defaultdict(str)
    for _, name, default, comment in rtl_parameters():
        if default in ("0", "1"):
            told[name] += f"{comment}\n"
    unknown = {
        name
        for name, comments in told.items()
        if not RANGE.search(comments) and not any(map(SWITCH.match, comments.splitlines()))
    }
    assert unknown == set(NEITHER)


def elaborate(simulator: str, module: str, parameter: str) -> str:
    """What the simulator says of a module whose ``parameter`` is 2."""
    program, environment = verilator_environment()
    command = {
        "icarus": [shutil.which("iverilog"), "-o", "/dev/null", "-I", "rtl", "-y", "rtl",
                   "-s", module, f"-P{module}.{parameter}=2"],
        "verilator": [program, "--lint-only", "-Wno-lint", "-Wno-style", "-Irtl",
                      "--top-module", module, f"-G{parameter}=2"],
    }[simulator]  # fmt: skip
    run = subprocess.run(
        [*command, f"rtl/{module}.v"], cwd=ROOT, env=environment, capture_output=True, text=True
    )
    return run.stdout + run.stderr if run.returncode else ""


def test_no_switch_is_2(simulator: str) -> None:
    assert len(switches()) > 50
    built = [
        f"{module} {name}"
        for module, name in switches()
        if not re.search(
            f"wh_illegal_parameter_\\w*{name.lower()}", elaborate(simulator, module, name)
        )
    ]
    assert not built, "\n".join(built)
