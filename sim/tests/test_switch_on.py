# SPDX-License-Identifier: Apache-2.0
"""What a build refuses before a bus is switched on: each check on a planted fault."""

from __future__ import annotations

import math
import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner
from wavehaptics.controller import guard
from wavehaptics.controller.guard import Fault
from wavehaptics.fpga.boards import Board, BoardError, board_names, load_board
from wavehaptics.ladder.brushless_pins import BrushlessPinsSimulation
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.parts.adcs import MODULATORS, PARTS, PartError, frame, modulator_frame
from wavehaptics.parts.sensing import sensing_parts
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words.table import Sizes, inputs
from wavetools.cli import board_commands
from wavetools.fpga import board_pins, bridge_budget, clamps, pad_timing, synthesis
from wavetools.fpga.pad_timing import Delays, PadTimingError, adc_budget, gate_skew_ns
from wavetools.fpga.synthesis import SynthesisError
from wavetools.wiring.parts import load_table


def with_scene(name: str, *overrides: str) -> Board:
    """A board whose scene is another."""
    board = load_board(name)
    scene = load_scene(ROOT / board.folder / "board.toml", list(overrides))
    return Board(board.name, board.root, board.fpga, board.device, scene)


def with_fpga(name: str, table: str, **changes: Any) -> Board:
    """A board with another ``[bridge]`` or ``[sense]``."""
    board = load_board(name)
    changed = getattr(board.fpga, table).model_copy(update=changes)
    fpga = board.fpga.model_copy(update={table: changed})
    return Board(board.name, board.root, fpga, board.device, board.scene)


def refusal(check: Any, *arguments: Any) -> str:
    with pytest.raises(BoardError) as failure:
        check(*arguments)
    assert "\n" not in str(failure.value)
    return str(failure.value)


# ---- Parts on the bus, in the motor's lead and at `alive`.

CLAMP_OF_12_V = with_fpga("ulx3s_brushless", "bridge", clamp="SMCJ15A")
NOT_SOLDERED = (
    # What the 6 V board had: D2 conducted at 16.7 V.
    (CLAMP_OF_12_V,
     r"boards/ulx3s_brushless/fpga\.toml: D2, SMCJ15A, conducts from 16\.7 V on, and the bus is "
     r"6 V: below that a bus that rises drives the motor with up to 2\.8 times .*; solder and name "
     r"SMCJ6\.5A$"),
    # The brushless board's image for another bus.
    (with_scene("ulx3s_brushless", "drive.bus_v=12"),
     r"D2, SMCJ6\.5A, stands off 6\.5 V, and the bus is 12 V: it would burn; solder and name "
     r"SMCJ13A or SMCJ15A$"),
    (with_fpga("ulx3s", "bridge", bus_max_v=20.0),
     r"D2, SMCJ15A, lets the bus rise to 24\.4 V, and its parts bear 20 V; lower drive\.bus_v$"),
    (with_fpga("ulx3s", "bridge", clamp="SMCJ51A"),
     r'fpga\.toml: bridge\.clamp "SMCJ51A" is unknown; .* or enter it in boards/clamps\.toml'),
    (with_fpga("ulx3s", "sense", shunt_ohm=0.066, gain=10.0),
     r"boards/ulx3s/fpga\.toml: sense\.shunt_ohm is 66 mΩ, but R6 of boards/wiring\.toml:\d+ has "
     r"33 mΩ; make both what is soldered$"),
    (with_scene("ulx3s", "controller.tick_hz=208333.33333333334"),
     r"boards/ulx3s/board\.toml: alive changes once a tick, 4\.8 µs, and the pump behind it lets "
     r"go of the gates with more than 4 µs \(boards/wiring\.toml:\d+\); raise controller\.tick_h"),
    # A power board has its own shunt and its own pump.
    (with_fpga("ulx3s_gan", "sense", shunt_ohm=0.01, gain=10.0),
     r"sense\.shunt_ohm is 10 mΩ, but R6 of boards/wiring_boostxl\.toml:\d+ has 5 mΩ; make both"),
    (with_scene("ulx3s_gan", "controller.tick_hz=20e3", "drive.pwm_hz=20e3"),
     r"once a tick, 50 µs, .* more than 40 µs \(boards/wiring_boostxl\.toml:\d+\); raise "),
)  # fmt: skip


@pytest.mark.parametrize(("board", "message"), NOT_SOLDERED)
def test_what_is_not_soldered_so_ends_the_build_with_one_line_and_2(monkeypatch, board, message):
    assert re.search(message, refusal(bridge_budget.check, board))
    monkeypatch.setattr(board_commands, "load_board", lambda *_: board)
    ended = CliRunner().invoke(board_commands.app, ["bitstream", board.name])
    assert ended.exit_code == 2
    assert ended.output.count("\n") == 1


@pytest.mark.parametrize("name", board_names())
def test_a_boards_clamp_is_for_its_bus(name):
    """It stands off the bus, conducts within half above it, and every part bears what is left."""
    board = load_board(name)
    clamp = clamps.clamps()[board.fpga.bridge.clamp]
    bus_v = board.scene.drive.bus_v
    assert bus_v < clamp.standoff_v < clamp.conducts_v[0] < clamp.conducts_v[1] < clamp.clamp_v
    assert clamp.conducts_v[0] < 1.5 * bus_v
    assert clamp.clamp_v < board.fpga.bridge.bus_max_v
    # 1.5 kW, as the series is called.
    assert clamp.clamp_v * clamp.clamp_a == pytest.approx(1500, rel=0.01)
    parts = load_table(name=board.fpga.wiring).parts
    assert board.fpga.bridge.clamp in f"{parts['D2'].type} {parts['D2'].rating}"
    assert re.search(r"(\d+) V$", parts["C8"].rating)[1] == f"{board.fpga.bridge.bus_max_v:g}"


# ---- Dead time, shortest pulse, sensor.


@pytest.mark.parametrize("name", board_names())
def test_the_boards_keep_to_their_budgets(name):
    board = load_board(name)
    bridge_budget.check(board)
    board_pins.check(board)
    time = bridge_budget.dead_time(board)
    assert time.made_s >= time.needed_s
    # What is measured at HI and LI is what the AND gates and the FPGA leave of it.
    assert time.made_s - time.gate_skew_s - time.fpga_skew_s >= 20e-9
    # A pulse that the gates show is a whole clock at least, or kept so long.
    words, shortest_s = board.words().words, 1 / board.words().ports.timing.clock_hz
    if words["min_pulse"]:
        shortest_s *= words["min_pulse"] - words["dead_clocks"]
    assert shortest_s >= board.fpga.bridge.min_pulse_s
    assert words["min_pulse"] or shortest_s >= 2 * board.fpga.bridge.min_pulse_s
    sense = board.fpga.sense
    assert board.words().words["trip"] == round(sense.trip_a / board.scene.adc.full_scale_a * 2**15)


@pytest.mark.parametrize(
    ("board", "message"),
    [
        # What the Colorlight had: one clock.
        (with_scene("colorlight_i5", "drive.dead_time_s=14.3e-9"),
         r"boards/colorlight_i5/board\.toml: the dead time is 14\.3 ns in whole clocks, and 26 ns "
         r"are needed .* 20 ns at least at HI and LI\); raise drive\.dead_time_s"),
        # What the HX8K had: one clock, of which HI and LI get 12.8 ns.
        (with_scene("hx8k", "drive.dead_time_s=21e-9"),
         r"the dead time is 20\.8 ns in whole clocks, and 28 ns are needed"),
        # It is the whole clocks that count: 20 ns round to one of 70 MHz.
        (with_scene("ulx3s", "drive.dead_time_s=20e-9"), r"the dead time is 14\.3 ns"),
        (with_fpga("ulx3s", "bridge", mismatch_s=30e-9), r"36 ns are needed \(driver 30"),
        (with_scene("hx8k", "drive.min_pulse_s=5e-9"),
         r"drive\.min_pulse_s is 5 ns, and the LMG5200 needs 10 ns"),
        (with_scene("hx8k", "adc.full_scale_a=5"),
         r"adc\.full_scale_a is 5 A, but 33 mΩ and a gain of 20 at 3\.3 V make 2\.5 A"),
        (with_fpga("icebreaker", "sense", trip_a=2.25),
         r"boards/icebreaker/fpga\.toml: sense\.trip_a is 2\.25 A, but the INA241 clips at 2\.2 A"),
    ],
)  # fmt: skip
def test_budgets_that_are_not_kept(board, message):
    assert re.search(message, refusal(bridge_budget.check, board))


def test_a_build_checks_before_it_begins(tmp_path):
    """Nothing of an earlier build is touched, and no tool is called."""
    with pytest.raises(BoardError, match="dead time"):
        synthesis.build_board(with_scene("ulx3s", "drive.dead_time_s=0"), None)


# ---- A wall at the 5 V of the first stages, from an image for 12 V.


def wall(*overrides: str) -> dict[str, Any]:
    overrides = ("scene.duration_s=0.25", "adc.edge_hold_s=0", *overrides)
    return measure(with_scene("icebreaker", *overrides).scene, "golden", compare=False)


def test_an_image_for_12_volts_never_pushes_at_5():
    """What the page of switching on says of its stage 6, and why no image for 5 V is asked for."""
    page = (ROOT / "docs" / "wiring" / "switching_on.md").read_text()
    light = "hand.stiffness=0.05"
    held = wall("drive.bus_actual_v=5", light)
    assert held["anchor_fault_s"] is None
    # A count of the eleven is 9 %.
    assert held["stiffness"] == pytest.approx(wall(light)["stiffness"], rel=0.09)
    assert f"presses of {1e3 * held['peak_torque']:.0f} mN·m" in page
    pressed = wall("drive.bus_actual_v=5")
    assert pressed["anchor_fault_s"] is None
    assert f"with {1e3 * pressed['peak_torque']:.0f} mN·m at most" in page
    assert max(pressed["energy_out_max_j"], pressed["contact_energy_j"]) < 1e-6
    # The port has yet to learn 58 % of a supply: presses from 7 to 13 mN·m gave -0.16 to -0.004.
    assert held["energy_out_max_j"] < 1e-6
    assert held["contact_energy_ratio"] < 0.0
    bare = wall("drive.bus_actual_v=5", "controller.anchor_auto=false")
    whole = wall("controller.anchor_auto=false")
    assert bare["energy_out_max_j"] < 1e-6
    said = f"is {bare['stiffness']:.1f} N·m/rad in place of {whole['stiffness']:.1f}"
    assert said in " ".join(page.split())
    # The other way about: an image for 5 V in a board at 12 V.
    left = wall(
        "drive.bus_v=5", "drive.limit_v=5", "drive.bus_actual_v=12", "controller.anchor_auto=false"
    )
    assert left["energy_out_max_j"] > 0.01
    assert left["peak_torque"] > 0.06  # 2.4 times the limit of the current


# ---- Pins.


def planted(tmp_path: Path, name: str, old: str, new: str) -> str:
    """The refusal of a board's constraints with ``old`` replaced."""
    board = load_board(name)
    text = (board.root / board.constraints).read_text()
    assert old in text
    path = tmp_path / board.constraints.name
    path.write_text(text.replace(old, new))
    return refusal(board_pins.check, board, path)


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        # What motor 2 had.
        ("ulx3s_three", '"gate_ah[2]" SITE "H18"', '"gate_ah[2]" SITE "F4"',
         r"gate_ah\[2\] is at F4, which is taken: ESP32 GPIO 26 \(gp11\) "
         r"\(boards/ulx3s/fpga\.toml\); take a free pin"),
        ("ulx3s", '"enc_a" SITE "A9"', '"enc_a" SITE "U18"', "taken: input 1 of the board's ADC"),
        ("ulx3s", '"gate_bl" SITE "A5"', '"gate_bl" SITE "A4"', "at A4, where gate_bh is already"),
        ("hx8k", "gate_al     J14", "gate_al B12", "taken: USB serial, FPGA sends"),
        ("icebreaker", "alive          46", "alive          14", "taken: flash, SO"),
        ("colorlight_i5", '"alive" SITE "B19"', '"alive" SITE "P17"', "unknown to boards/color"),
        ("orangecrab", '"gate_al" SITE "H2"', '"gate_al" SITE "R17"', "R17, which is taken: start"),
        ("icesugar_pro", '"alive" SITE "R5"', '"alive" SITE "T6"', "taken: configuration, D7"),
        ("icesugar_pro_eight", '"gate_bl[3]" SITE "R4"', '"gate_bl[3]" SITE "R6"',
         r"taken: configuration, D6 \(boards/icesugar_pro/fpga\.toml\)"),
        ("icesugar_pro_eight", '"enc_b[7]" SITE "L14"', '"enc_b[7]" SITE "E14"',
         "taken: programmer of the extension board"),
        ("ecp5_evn", '"stop" SITE "U17"', '"stop" SITE "P2"', "taken: USB serial, sends where R34"),
        ("hx8k", "-pullup yes enc_b  ", "enc_b", "floats where its wire is off; give it set_io"),
        ("icebreaker", "-pullup yes adc_sdata", "-pullup no adc_sdata", "adc_sdata is at 2 and fl"),
        ("ulx3s", '"adc_sdata" IO_TYPE=LVCMOS33 PULLMODE=UP', '"adc_sdata" IO_TYPE=LVCMOS33',
         "adc_sdata is at A10 and floats where its wire is off; give it PULLMODE=UP"),
        # 3.3 V in a bank on 2.5 V, and the contrary.
        ("ecp5_evn", '"led_fault_n" IO_TYPE=LVCMOS25', '"led_fault_n" IO_TYPE=LVCMOS33',
         r"led_fault_n is at B17, of a bank on 2\.5 V \(boards/ecp5_evn/fpga\.toml\), and LVCMOS33 "
         r"is of 3\.3 V; give it an IO_TYPE of 2\.5 V, or take another pin$"),
        ("ulx3s_three", '"alive" IO_TYPE=LVCMOS33', '"alive" IO_TYPE=LVCMOS25',
         r"of a bank on 3\.3 V \(boards/ulx3s/fpga\.toml\), and LVCMOS25 is of 2\.5 V"),
        # With its wire off a stop that reads closed, a start pressed, a line that may arm.
        ("ulx3s", '"stop" IO_TYPE=LVCMOS33 PULLMODE=UP', '"stop" IO_TYPE=LVCMOS33 PULLMODE=DOWN',
         "stop is at B9 and is pulled DOWN where its wire is off; give it PULLMODE=UP"),
        ("colorlight_i5", '"start_n" IO_TYPE=LVCMOS33 PULLMODE=UP',
         '"start_n" IO_TYPE=LVCMOS33 PULLMODE=DOWN', "start_n is at E2 and is pulled DOWN"),
        ("ulx3s", '"uart_rx" IO_TYPE=LVCMOS33 PULLMODE=UP',
         '"uart_rx" IO_TYPE=LVCMOS33 PULLMODE=NONE', "uart_rx is at M1 and floats"),
        ("ulx3s", '"button_start" IO_TYPE=LVCMOS33 PULLMODE=DOWN',
         '"button_start" IO_TYPE=LVCMOS33 PULLMODE=UP',
         "button_start is at R1 and is pulled UP where its wire is off; give it PULLMODE=DOWN"),
    ],
)  # fmt: skip
def test_pins_that_are_not_the_boards(tmp_path, name, old, new, message):
    found = planted(tmp_path, name, old, new)
    assert re.search(message, found)
    assert re.search(r"\.(lpf|pcf):\d+: ", found)


@pytest.mark.parametrize("name", board_names())
def test_the_tables_of_pins_contradict_nothing(name):
    """No pin is free and taken, and each port of a pin that is taken for it is the top's.

    A design without a link leaves the line's pins alone. Gates and alive are on free pins, so on
    none of the configuration's, which are taken.
    """
    board = load_board(name)
    free = board.fpga.free
    assert len(set(free)) == len(free)
    assert not set(free) & set(board.fpga.taken)
    text = (ROOT / board.constraints).read_text()
    pins = board_pins.read_pins(text, board.fpga.family)
    driving = [pin.site for pin in pins if pin.port.startswith(("gate_", "alive"))]
    assert len(driving) == 2 * board.fpga.legs * board.fpga.motors + 1
    assert set(driving) <= set(free)
    top = (ROOT / board.folder / f"{name}.v").read_text()
    ports = [owner for owner in board.fpga.taken.values() if re.fullmatch(r"\w*_\w+|clk\w*", owner)]
    assert len(ports) >= 2
    if not board.fpga.link:
        ports = [port for port in ports if not port.startswith("uart_")]
    for port in ports:
        assert re.search(rf"\b{port}\b", top), port


@pytest.mark.parametrize("name", ["ulx3s", "ulx3s_brushless", "ulx3s_three"])
def test_the_esp32_is_held_in_reset(name):
    top = (ROOT / "boards" / name / f"{name}.v").read_text()
    pins = board_pins.read_pins((ROOT / "constraints" / f"{name}.lpf").read_text(), "ecp5")
    # Of v3.1 F1 is its GPIO 0, and its reset J5, where older boards have nothing.
    for port, site in (("wifi_en", "F1"), ("wifi_en_v31", "J5")):
        assert re.search(rf"assign {port} += 1'b0;", top)
        assert [pin.site for pin in pins if pin.port == port] == [site]


# ---- Pads.

HEAD = '(CELLTYPE "top") (INSTANCE )\n'


def ice40_delays(sclk_ns: float = 3.0, sdata_ns: float = 2.0, low_ns: float = 1.5) -> Delays:
    """A flip-flop and a way to each output, a way and a flip-flop for the input; ps in the file."""
    ways = {"adc_sclk": sclk_ns, "gate_ah": 1.5, "gate_al": low_ns, "gate_bh": 1.5, "gate_bl": 1.5}
    text = HEAD + "".join(
        f"(INTERCONNECT {port}_LC/O {port}\\$sb_io/D_OUT_0 ({1000 * ns}:{1000 * ns}:{1000 * ns}))\n"
        for port, ns in ways.items()
    )
    text += f"(INTERCONNECT adc_sdata\\$sb_io/D_IN_0 in_LC/I0 ({1000 * sdata_ns}:0:0))\n"
    for port in ways:
        text += f'(CELLTYPE "ICESTORM_LC") (INSTANCE {port}_LC)\n'
        text += "(IOPATH CLK O (1390:1390:1390) (1400:1400:1400))\n"
        text += f'(CELLTYPE "SB_IO") (INSTANCE {port}\\$sb_io)\n'
    text += '(CELLTYPE "SB_IO") (INSTANCE adc_sdata\\$sb_io)\n(CELLTYPE "ICESTORM_LC") '
    text += "(INSTANCE in_LC)\n(SETUPHOLD (posedge I0) (posedge CLK) (1155:1155:1155) (0:0:0))\n"
    return Delays(text)


def ecp5_delays(registered: bool = True, through: str = "LUT") -> Delays:
    """Registers in the I/O cells, or the same with logic between flip-flop and pad."""
    lines = [HEAD]
    for port, cell, pin in (("adc_sclk", "I", "IOLDO"), ("adc_sdata", "O", "PADDI")):
        pad = f"{port}\\$tr_io"
        lines.append(f'(CELLTYPE "TRELLIS_IO") (INSTANCE {pad})')
        if registered:
            lines.append(f'(CELLTYPE "SIOLOGIC") (INSTANCE {pad}\\$IOL)')
            ends = (f"{pad}\\$IOL/IOLDO", f"{pad}/IOLDO")
            ends = ends if cell == "I" else (f"{pad}/O", f"{pad}\\$IOL/{pin}")
            lines.append(f"(INTERCONNECT {ends[0]} {ends[1]} (100:100:100) (100:100:100))")
    if not registered:
        lines += [
            "(INTERCONNECT ff/Q lut/A (500:600:700))",
            f"(INTERCONNECT {through.lower()}/F adc_sclk\\$tr_io/I (1500:1700:1900))",
            "(INTERCONNECT adc_sdata\\$tr_io/O lut2/B (800:900:1000))",
            "(INTERCONNECT lut2/F ff2/DI (100:120:130))",
            '(CELLTYPE "TRELLIS_FF") (INSTANCE ff)',
            "(IOPATH CLK Q (430:477:525) (430:477:525))",
            '(CELLTYPE "TRELLIS_COMB") (INSTANCE lut)',
            "(IOPATH A F (200:218:236) (200:218:236))",
            '(CELLTYPE "TRELLIS_COMB") (INSTANCE lut2)',
            "(IOPATH B F (200:218:236) (200:218:236))",
            '(CELLTYPE "TRELLIS_FF") (INSTANCE ff2)',
            "(SETUPHOLD (posedge DI) (posedge CLK) (50:60:70) (267:285:303))",
        ]
    return Delays("\n".join(lines))


AD7276 = PARTS["AD7276"]


def budget(delays: Delays, device: str, clock_hz: float, pads: bool = False, **changes: Any) -> Any:
    family = "ecp5" if device == "25k" else "ice40"
    made = frame(AD7276, clock_hz, pads)
    settings = {"wire_s": 0.6e-9, "lines": ["adc_sdata"], **changes}
    return adc_budget(delays, device, family, AD7276, made, clock_hz, **settings)


def test_a_round_trip_adds_up():
    """By hand: flip-flop, way and pad out, wires, access, pad and way back, set-up."""
    found = budget(ice40_delays(), "hx8k", 48e6)
    assert found.out_ns == pytest.approx(1.4 + 3.0 + 4.59, abs=0.01)
    assert found.back_ns == pytest.approx(1.21 + 2.0 + 1.155, abs=0.01)
    assert found.available_ns == pytest.approx(2e3 / 48, abs=0.01)
    assert found.margin_ns == pytest.approx(2e3 / 48 - 8.99 - 1.2 - 15 - 4.365, abs=0.02)
    assert found.hold_ns == 5


def test_registers_in_the_pads_leave_the_data_sheets_times():
    found = budget(ecp5_delays(), "25k", 70e6, pads=True)
    assert found.registered
    assert found.margin_ns == pytest.approx(2e3 / 70 - 4.1 - 1.2 - 15 - 0.85, abs=0.01)


@pytest.mark.parametrize(
    ("clock_hz", "pads", "clocks"),
    [(70e6, True, 4), (70e6, False, 2), (40e6, False, 1), (40e6, True, 1), (100e6, True, 1)],
)
def test_a_modulators_bit_is_taken_where_its_clock_falls(clock_hz, pads, clocks):
    """In whole clocks after its rise at the pad, or with registers there two sooner."""
    part = MODULATORS["AMC1306M25"]
    made = modulator_frame(part, clock_hz, 12 * 20, pads)
    delays = ecp5_delays(registered=pads)
    found = partial(adc_budget, delays, "25k", "ecp5", part, made, clock_hz, 0.6e-9, ["adc_sdata"])
    # Clock to pad and pad to flip-flop, as the two tests around this one add them up.
    pads_ns = 4.1 + 0.85 if pads else 7.461 + 2.286
    needed_ns = 1e9 * part.access_s + 1.2 + pads_ns
    assert made.taken_clocks == clocks
    if 1e9 * clocks / clock_hz < needed_ns:
        with pytest.raises(PadTimingError, match=r"the AMC1306M25's bits come .* too late"):
            found()
    else:
        assert found().available_ns == pytest.approx(1e9 * clocks / clock_hz, abs=0.01)
        assert found().hold_ns == 3.5


def test_the_slowest_of_several_pins_of_sclk_counts():
    found = budget(ice40_delays(low_ns=4.5), "hx8k", 48e6, clocks=["adc_sclk", "gate_al"])
    assert found.out_ns == pytest.approx(1.4 + 4.5 + 4.59, abs=0.01)


def test_logic_before_a_pad_is_counted():
    found = budget(ecp5_delays(registered=False), "25k", 50e6)
    assert found.out_ns == pytest.approx(0.525 + 0.7 + 0.236 + 1.9 + 4.1, abs=0.01)
    assert found.back_ns == pytest.approx(0.85 + 1.0 + 0.236 + 0.13 + 0.07, abs=0.01)


@pytest.mark.parametrize(
    ("delays", "device", "clock_hz", "pads", "message"),
    [
        (ecp5_delays(), "25k", 95e6, True, r"bits come 0\.1 ns too late: .* lower controller\.clo"),
        (ice40_delays(sclk_ns=20), "hx8k", 48e6, False, r"too late: .* or take registers at the"),
        (ecp5_delays(), "25k", 70e6, False, "are not what pad_registers in fpga.toml says"),
        (ecp5_delays(registered=False), "25k", 70e6, True, "are not what pad_registers"),
        (Delays(HEAD), "25k", 70e6, True, "have no pad for adc_sclk"),
    ],
)
def test_a_late_bit_fails(delays, device, clock_hz, pads, message):
    with pytest.raises(PadTimingError, match=message) as failure:
        budget(delays, device, clock_hz, pads)
    assert "\n" not in str(failure.value)


def test_a_late_bit_fails_the_build(monkeypatch, tmp_path):
    (tmp_path / "delays.sdf").write_text("")
    board = load_board("icebreaker")
    monkeypatch.setattr(Delays, "of_file", classmethod(lambda *_: ice40_delays(sdata_ns=60)))
    with pytest.raises(SynthesisError, match=r"icebreaker: the AD7276's bits come .* too late"):
        synthesis.board_pads(board, tmp_path / "delays.sdf")
    monkeypatch.setattr(Delays, "of_file", classmethod(lambda *_: ice40_delays(low_ns=9)))
    with pytest.raises(
        SynthesisError, match=r"gates of a leg differ by 7\.5 ns .* grants 6 ns; raise it, and"
    ):
        synthesis.board_pads(board, tmp_path / "delays.sdf")
    monkeypatch.setattr(Delays, "of_file", classmethod(lambda *_: ice40_delays()))
    assert synthesis.board_pads(board, tmp_path / "delays.sdf")["margin_ns"] > 3


def test_skew_is_of_a_legs_two_gates():
    assert gate_skew_ns(ice40_delays(low_ns=4.25), 1) == 2.75
    assert gate_skew_ns(ice40_delays(), 1) == 0


def test_registers_at_the_pads_are_a_zero_more():
    """Two clocks are a pulse at half the clock; at any other rate they are refused."""
    plain, late = frame(AD7276, 85e6), frame(AD7276, 85e6, pad_registers=True)
    assert late.conversion_clocks == plain.conversion_clocks + 2
    assert late.cycle_clocks == plain.cycle_clocks + 2
    assert late.pad_clocks == 1
    with pytest.raises(PartError, match=r"SCLK at half the clock instead of 1/4"):
        frame(AD7276, 100e6, pad_registers=True)
    with pytest.raises(PartError, match="a part without commands"):
        frame(PARTS["MAX11125"], 30e6, pad_registers=True)
    assert pad_timing.PAD_TIMES["ecp5"].out_registered == 4.1


# ---- Carrier and amplifier.


def with_carrier(name: str, clocks: int) -> Board:
    """A board with so many clocks from edge to edge."""
    clock_hz = load_board(name).clock_hz
    return with_scene(
        name, f"drive.pwm_hz={0.5 * clock_hz / clocks!r}",
        f"controller.tick_hz={clock_hz / clocks!r}", "controller.extra_ticks=2",
    )  # fmt: skip


TOO_FAST = with_carrier("hx8k", 48)


@pytest.mark.parametrize(
    ("board", "message"),
    [
        (with_carrier("ulx3s", 38),
         r"boards/ulx3s/board\.toml: the INA241 may not follow the carrier of 921\.1 kHz: it holds "
         r"its output for 1 µs after an edge, give or take 20%, and at 0 V there is one each "
         r"0\.543 µs; lower drive\.pwm_hz to 416\.7 kHz or less, or name another amplifier in "
         r"\[sense\] of boards/ulx3s/fpga\.toml$"),
        # No tolerance is left of a hold that ends with the next edge.
        (TOO_FAST, r"of 500 kHz: .* one each 1 µs; lower drive\.pwm_hz to 416\.7 kHz"),
        (with_carrier("icebreaker", 32), r"of 421\.9 kHz: .* one each 1\.19 µs;"),
        (with_fpga("ulx3s", "sense", amplifier="INA240"),
         r"the INA240 .* it settles for 9\.6 µs after an edge, and the sample comes 0\.6 µs "
         r"after it; lower drive\.pwm_hz to 26\.04 kHz or less"),
        (with_fpga("ulx3s_three", "sense", amplifier="INA240"),
         r"the INA240 may not follow the carrier of 352\.3 kHz: it settles for 9\.6 µs"),
        (with_fpga("ulx3s_three", "sense", amplifier="low-side"),
         r"it sees one half of each carrier period, and a tick is 1\.42 µs; name another "
         r"amplifier"),
        (with_fpga("ulx3s", "sense", amplifier="INA24"),
         r'sense\.amplifier "INA24" is unknown; did you mean "INA24[01]"\? known: INA241, .* with '
         r"its figures$"),
    ],
)  # fmt: skip
def test_carriers_that_the_amplifier_may_not_follow(board, message):
    assert re.search(message, refusal(bridge_budget.check, board))


@pytest.mark.parametrize("amplifier", ["INA241", "MAX40056", "ACS70331"])
@pytest.mark.parametrize("name", board_names())
def test_carriers_that_it_follows(name, amplifier):
    bridge_budget.check(with_fpga(name, "sense", amplifier=amplifier))


@pytest.mark.parametrize(("name", "clocks"), [("icebreaker", 33), ("ulx3s", 84), ("hx8k", 58)])
def test_a_board_has_the_fastest_carrier_that_its_amplifier_follows(name, clocks):
    board = load_board(name)
    assert board.words().ports.timing.half_clocks == clocks
    refusal(bridge_budget.check, with_carrier(name, clocks - 1))


def test_a_bad_carrier_ends_the_build_with_one_line_and_2(monkeypatch):
    monkeypatch.setattr(board_commands, "load_board", lambda *_: TOO_FAST)
    ended = CliRunner().invoke(board_commands.app, ["bitstream", "hx8k"])
    assert ended.exit_code == 2
    assert ended.output.count("\n") == 1
    assert ended.output.startswith("synthesis: boards/hx8k/board.toml: the INA241 may not follow")


@pytest.mark.parametrize("name", board_names())
def test_a_boards_scene_simulates_the_parts_that_it_names(name):
    """Converter, scale, amplifier, trip and guard are those of ``fpga.toml``."""
    board = load_board(name)
    scene, sense = board.scene, board.fpga.sense
    part = sensing_parts()[sense.amplifier]
    assert scene.adc.part == part.modulator or scene.adc.part == board.fpga.adc
    assert scene.adc.full_scale_a == pytest.approx(sense.full_scale_a, rel=0.01)
    assert scene.adc.edge_hold_s == part.hold_s
    assert scene.adc.edge_hold_restarts == (part.hold_restarts if part.hold_s else True)
    # A brushless motor's model has no lag and no edges that settle.
    settle_s, edge_a = part.settle_s, part.edge_part * scene.drive.bus_v / sense.shunt_ohm
    assert scene.adc.edge_settle_s == (None if board.brushless else settle_s or None)
    assert scene.adc.common_mode_a == pytest.approx(0.0 if board.brushless else edge_a)
    assert scene.adc.bandwidth_hz == (None if board.brushless else part.lag_hz)
    half_step_a = scene.adc.full_scale_a / 2**scene.adc.bits
    assert scene.adc.noise_a >= max(0.98 * half_step_a, part.noise_a)
    assert scene.guard.trip_a == sense.trip_a
    assert scene.guard.watch == board.fpga.guard


def run_of(board: Board, seconds: float) -> tuple[PinsSimulation, np.ndarray]:
    """A board's scene on `pins`, and its ticks."""
    scene = board.scene
    pins = (BrushlessPinsSimulation if board.brushless else PinsSimulation)(scene)
    rows = np.zeros((round(seconds / pins.tick_s), len(Column)))
    pins.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    return pins, rows


@pytest.mark.parametrize(
    ("name", "seconds", "settings"),
    [
        ("icebreaker", 0.3, ("hand.amplitude_rad=0.9", "guard.trip_a=1")),
        ("ulx3s", 0.18, ("hand.amplitude_rad=0.9", "guard.trip_a=1")),
        ("ulx3s_brushless", 0.2, ("guard.trip_a=0.3", "hand.stiffness=0.05")),
    ],
)
def test_a_run_ends_its_bridge_where_the_board_trips(name, seconds, settings):
    """Pressed with more than the trip: from there on no current, and the hand moves the motor."""
    board = with_scene(name, *settings)
    trip_a = board.scene.guard.trip_a
    pins, rows = run_of(board, seconds)
    assert pins.faults >> 2 & (1 << Fault.TRIP | 1 << Fault.CURRENT)
    off = round(pins.off_s / pins.tick_s)
    assert 0 < off < len(rows) - 1000
    assert 0.9 * trip_a < np.abs(rows[:off, Column.I]).max() < 1.1 * trip_a
    after = rows[off + 500 :]
    assert np.abs(after[:, Column.I]).max() < 1e-3
    assert np.all(after[:, [Column.U, Column.V]] == 0)
    assert np.ptp(after[:, Column.X]) > 1e-3
    assert np.all(np.diff(rows[:, Column.T]) > 0)


def hit_of(folder: Path, name: str, speed_rad_s: float, seconds: float, *settings: str) -> Board:
    """A board whose bare rotor hits the wall 20 mrad away, by its text without [hand]."""
    board = load_board(name)
    text = (ROOT / board.folder / "board.toml").read_text()
    hand = f'[hand]\npath = "impact"\namplitude_rad = 0.02\nspeed_rad_s = {speed_rad_s}\n\n'
    before, rest = text.split("[hand]")
    path = folder / "board.toml"
    path.write_text(before + hand + rest[rest.index("[encoder]") :])
    sets = [f"scene.duration_s={seconds}", *settings]
    return Board(board.name, board.root, board.fpga, board.device, load_scene(path, sets))


@pytest.mark.parametrize(
    ("name", "load", "brisk", "back", "seconds"),
    [
        ("icebreaker", 1.0, 80.0, 56.0, 10e-3), ("ulx3s", 1.0, 80.0, 56.0, 10e-3),
        ("ulx3s", 10.0, 60.0, 45.0, 50e-3), ("ulx3s_brushless", 1.0, 40.0, 33.0, 20e-3),
    ],
)  # fmt: skip
def test_what_a_brisk_hand_does(tmp_path, name, load, brisk, back, seconds):
    """The limit acts, and the rotor comes back with less, as the board's page says."""
    known = ("controller.find_magnet=false",) if name == "ulx3s_brushless" else ()
    inertia = (load - 1.0) * load_board(name).scene.motor.J_kgm2
    board = hit_of(
        tmp_path, name, brisk, seconds, f"load.inertia_kgm2={inertia:.9g}", *known
    )  # fmt: skip
    pins, rows = run_of(board, seconds)
    assert pins.faults == 0
    assert rows[:, Column.CONTACT].any()
    assert rows[:, Column.SATURATED].any()
    assert rows[-1, Column.CONTACT] == 0.0
    assert rows[-1, Column.OMEGA] == pytest.approx(-back, rel=0.02)
    if known:  # no limit of the current: at rest the bus can't reach the trip
        return
    # A rotor at rest gets the limit, one that turns k_T·ω/R more.
    motor, least_a = board.scene.motor, board.scene.drive.current_limit_a
    most_a = least_a + motor.k_t * brisk / motor.R_ohm
    assert least_a < np.abs(rows[:, Column.I]).max() < most_a


@pytest.mark.parametrize(("name", "speed"), [("icebreaker", 120.0), ("ulx3s", 120.0)])
def test_a_hit_beyond_the_trip_ends_without_a_current(tmp_path, name, speed):
    """From there on no row has waves, a limit at work or a current."""
    pins, rows = run_of(hit_of(tmp_path, name, speed, 8e-3), 8e-3)
    assert pins.faults >> 2 & 1 << Fault.TRIP
    off = round(pins.off_s / pins.tick_s)
    after = rows[off + 200 :]
    assert len(after) > 1000
    assert not after[:, [Column.U, Column.V, Column.SATURATED]].any()
    assert np.abs(after[500:, Column.I]).max() < 1e-3


@pytest.mark.parametrize("find", ["true", "false"], ids=["to-be-found", "known"])
@pytest.mark.parametrize("speed", [90.0, 100.0, 110.0])
def test_no_hit_of_the_brushless_wall_swings_for_ever(tmp_path, speed, find):
    """Without the guard: the rotor leaves the wall, or it rests within 0.35 s.

    Where a hit turns known magnets by more than half an electrical turn, the wall is lost: the
    anchor sees it, or the rotor rests between two poles.
    """
    settings = ("adc.edge_hold_s=0", f"controller.find_magnet={find}")
    scene = hit_of(tmp_path, "ulx3s_brushless", speed, 0.4, *settings).scene
    golden = CONTROLLERS["golden"](scene)
    rows = np.zeros((round(0.4 / golden.tick_s), len(Column)))
    golden.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    late = rows[:, Column.T] > 0.35
    assert rows[~late, Column.SATURATED].any()
    left, seen = not rows[late, Column.CONTACT].any(), rows[-1, Column.FAULT] != 0.0
    assert left or seen or np.abs(rows[late, Column.OMEGA]).max() < 1.0
    farthest = rows[:, Column.X].max() * scene.motor.pole_pairs
    assert seen == (find == "false" and speed > 100.0)
    assert left == (find == "false" and farthest < math.pi)
    assert left == (find == "false" and speed < 100.0)


def test_what_switched_a_run_off_is_told():
    found = measure(
        with_scene(
            "icebreaker", "hand.amplitude_rad=0.9", "scene.duration_s=0.2", "guard.trip_a=1"
        ).scene,
        "pins", compare=False,
    )  # fmt: skip
    assert re.fullmatch(r"switched off at 0\.1\d+ s: TRIP", found["faults"])


@pytest.mark.parametrize("name", board_names())
def test_a_scenes_guard_is_the_boards(name):
    """Its word is the bitstream's, and besides it does what the board's switch does."""
    board = load_board(name)
    found = guard.scene_words(board.scene, board.words().ports)
    assert found.pop("trip") == board.words().words["trip"]
    switch = guard.mask(guard.SWITCH_FAULTS)
    if board.fpga.guard:
        assert found["guard_mask"] == switch | guard.mask(guard.BOARD_FAULTS)
        # A scene has no pin of the comparators.
        latch = (guard.Fault.DRIVER,) if board.fpga.overcurrent else ()
        found["guard_mask"] = guard.mask((*guard.BOARD_FAULTS, *latch))
        assert inputs(found, Sizes())["guard_i"] == board.words().guard
    else:
        assert found["guard_mask"] == switch
    text = (ROOT / "boards" / "wh_board_switch.v").read_text()
    latched = re.search(r"fault_q +<= \(fault_q(.*?);", text, re.DOTALL)[1]
    for cause in ("overrun_i", "anchor_fault_i", "encoder_fault_i", "overcurrent_i"):
        assert cause in latched


def test_the_table_of_parts_gives_figures_and_sources():
    """Of each key that no data sheet has, the sources say so, and the scene takes the others."""
    for name, part in sensing_parts().items():
        assert part.sources, name
        assert set(part.unverified) <= set(type(part).model_fields), name
        assert part.modulator is None or part.modulator in MODULATORS
        settings = [key for key in part.settings(12.0, 0.033) if not key.startswith("adc.part")]
        load_scene(ROOT / "sim" / "scenes" / "held_wall.toml", settings)
    assert sensing_parts()["INA241"].carrier_hz == pytest.approx(0.5 / 1.2e-6)
    assert sensing_parts()["MAX40056"].carrier_hz == pytest.approx(500e3)
    edge_a = 12.0 * 10 ** (-60 / 20) / 0.033  # 60 dB
    assert f"adc.common_mode_a={edge_a}" in sensing_parts()["MAX40056"].settings(12.0, 0.033)
    # A lag that reaches 90 % of a step after 535 ns.
    lag_hz = sensing_parts()["ACS70331"].lag_hz
    assert lag_hz < 1e6
    assert 1 - math.exp(-2 * math.pi * lag_hz * 535e-9) == pytest.approx(0.9)
