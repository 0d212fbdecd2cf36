# SPDX-License-Identifier: Apache-2.0
"""The boards: their words, each fault that must fail a build, and the numbers that are shown."""

from __future__ import annotations

import json
import os
import re
import shutil
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner
from wavehaptics.controller.pins_timing import (
    CORE_CLOCKS,
    latency_clocks,
    turns_clocks,
    turns_latency_clocks,
)
from wavehaptics.fpga.board_words import board_words, hardware, verilog_header
from wavehaptics.fpga.boards import Board, BoardError, board_names, load_board
from wavehaptics.ladder.brushless import magnet_words
from wavehaptics.ladder.run import measure
from wavehaptics.parts.adcs import MODULATORS, PARTS, frame, modulator_frame
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain, ToolError
from wavehaptics.scene import SceneError, load_scene
from wavehaptics.words.bridge_modes import LOCKED, MODE_WORDS, SIGN_MAGNITUDE, UNIPOLAR
from wavetools.cli import board_commands
from wavetools.fpga import bridge_budget, multipliers, pll, synthesis
from wavetools.fpga.board_pins import read_pins
from wavetools.fpga.synthesis import Design, SynthesisError, build
from wavetools.pages import filler

LUT_TOLERANCE = 0.03

GOOD = """\
module top (input wire clk, input wire a, input wire b, output reg q);
    reg x;
    always @(posedge clk) x <= a ^ b;
    always @(posedge clk) q <= !x;
endmodule
"""
PINS = {"clk": "35", "a": "4", "b": "2", "q": "47"}


@pytest.fixture(scope="module")
def tools() -> Toolchain:
    return Toolchain.of_environment()


def make(
    tmp_path: Path, tools: Toolchain, verilog: str = GOOD, pins: dict[str, str] | None = None,
    extra_pins: str = "", clock_hz: float = 12e6, say: Callable[[str], None] = print,
) -> synthesis.Result:  # fmt: skip
    """Build a small design for the UP5K in ``tmp_path``."""
    (tmp_path / "top.v").write_text(verilog)
    lines = [f"set_io {name} {pin}" for name, pin in (PINS if pins is None else pins).items()]
    (tmp_path / "top.pcf").write_text("\n".join(lines) + "\n" + extra_pins)
    (tmp_path / "out").mkdir(exist_ok=True)
    design = Design(
        name="small", top="top", root=tmp_path, sources=(Path("top.v"),), includes=(),
        constraints=Path("top.pcf"), family="ice40", device="up5k", package="sg48", speed=None,
        input_hz=clock_hz, clock_hz=clock_hz, seeds=(1, 2),
    )  # fmt: skip
    return build(design, Path("out"), tools, say)


def refusal(tmp_path: Path, tools: Toolchain, *arguments: object, **options: object) -> str:
    """The one line with which a build fails, having left nothing but logs."""
    with pytest.raises(SynthesisError) as failure:
        make(tmp_path, tools, *arguments, **options)
    assert {path.suffix for path in (tmp_path / "out").iterdir()} <= {".log"}
    message = str(failure.value)
    assert "\n" not in message
    return message


def test_a_good_design_is_built(tmp_path, tools):
    result = make(tmp_path, tools)
    assert (tmp_path / "out" / "small.bin").stat().st_size == result.bitstream_bytes > 0
    assert result.reached_mhz > 13.2
    assert result.slack_ns > 0


def test_lost_multiplier(tmp_path, tools):
    verilog = """\
module top (input wire clk, input wire a, input wire b, output wire q);
    reg signed [15:0] x, y;
    reg signed [31:0] p, p2;
    reg signed [39:0] s;
    always @(posedge clk) begin
        x <= {x[14:0], a}; y <= {y[14:0], b}; p <= x * y; p2 <= p; s <= s + p2;
    end
    assign q = ^s;
endmodule
"""
    message = refusal(tmp_path, tools, verilog)
    assert re.fullmatch(
        r"small: Yosys lost a multiplier \(Driver-driver conflict at p2\); .*", message
    )


def test_latch(tmp_path, tools):
    verilog = GOOD.replace("always @(posedge clk) q <=", "always @* if (a) q =")
    assert re.match(r"small: top\.q is a latch; ", refusal(tmp_path, tools, verilog))


def test_multiply_driven_net(tmp_path, tools):
    verilog = GOOD.replace("endmodule", "    always @(posedge clk) if (b) q <= 1'b0;\nendmodule")
    assert re.match(r"small: top\.q is driven more than once", refusal(tmp_path, tools, verilog))


def test_undriven_net(tmp_path, tools):
    verilog = GOOD.replace("a ^ b", "a ^ b ^ nobody").replace("    reg", "    wire nobody; reg")
    assert "top.nobody is used, but nothing drives it" in refusal(tmp_path, tools, verilog)


def test_any_warning(tmp_path, tools):
    verilog = GOOD.replace("    reg x", "    reg x = undeclared")
    assert re.match(r"small: yosys", refusal(tmp_path, tools, verilog))


def test_unconstrained_pin(tmp_path, tools):
    pins = {name: pin for name, pin in PINS.items() if name != "b"}
    assert "pin b is unconstrained; give it a line in top.pcf" in refusal(
        tmp_path, tools, pins=pins
    )


def test_pin_that_is_none(tmp_path, tools):
    message = refusal(tmp_path, tools, pins={**PINS, "c": "45"})
    assert message == "top.pcf: c is no pin of the top top; delete the line"


def test_clock_among_the_pins(tmp_path, tools):
    message = refusal(tmp_path, tools, extra_pins="set_frequency clk 1\n")
    assert message.startswith("top.pcf:5: sets a clock")


def test_missed_timing(tmp_path, tools):
    verilog = """\
module top (input wire clk, input wire a, input wire b, output reg q);
    reg [63:0] x, y;
    always @(posedge clk) begin
        x <= {x[62:0], a}; y <= {y[62:0], b}; q <= (x + y) >> 63;
    end
endmodule
"""
    message = refusal(tmp_path, tools, verilog, clock_hz=40e6)
    assert re.fullmatch(
        r"small: timing missed: the clock reaches \d+\.\d\d MHz, and 44\.00 MHz are needed "
        r"\(40 MHz and 10% to spare\); that is seed [12], the best of 2",
        message,
    )


def test_next_seed_is_tried(tmp_path, tools, monkeypatch):
    """A seed that misses the clock gives way to the next, and the result names the one it has."""
    judge, said = synthesis._reached_hz, []

    def first_too_slow(design, *_):
        monkeypatch.setattr(synthesis, "_reached_hz", judge)
        raise synthesis._missed(design, 1e6)

    monkeypatch.setattr(synthesis, "_reached_hz", first_too_slow)
    result = make(tmp_path, tools, say=said.append)
    assert result.seed == 2
    assert "small: seed 1 reaches 1.00 MHz: too slow" in said


def test_multiplier_without_registers(tmp_path, tools):
    verilog = """\
module top (input wire clk, input wire a, input wire b, output wire q);
    reg signed [15:0] x, y;
    reg s;
    always @(posedge clk) begin x <= {x[14:0], a}; y <= {y[14:0], b}; s <= ^(x * y); end
    assign q = s;
endmodule
"""
    assert "the product of the multiplier" in refusal(tmp_path, tools, verilog)


def test_clock_that_is_not_the_scenes(tmp_path, tools):
    board = load_board("icebreaker")
    design = synthesis.board_design(board, synthesis.OUT / "icebreaker")
    cell = ice40_pll(divf=63, divq=4)
    assert pll.of_cell(cell, 12e6).clock_hz == 48e6
    with pytest.raises(
        SynthesisError, match=r"clock is 48 MHz, but controller\.clock_hz .* 27 MHz"
    ):
        synthesis._check_pll(design, {"cells": {"pll": cell}})


def ice40_pll(divr: int = 0, divf: int = 71, divq: int = 5, filter_range: int = 1) -> dict:
    """An iCE40's PLL as Yosys writes it; from 12 MHz the iCEBreaker's 27 MHz."""
    numbers = {"DIVR": divr, "DIVF": divf, "DIVQ": divq, "FILTER_RANGE": filter_range}
    return {
        "type": "SB_PLL40_PAD",
        "parameters": {key: f"{value:b}" for key, value in numbers.items()},
    }


def ecp5_pll(i: int = 1, fb: int = 1, op: int = 28, os: int = 10, **parameters: str) -> dict:
    """An ECP5's; from 25 MHz the ULX3S's 70 MHz."""
    numbers = {"CLKI_DIV": i, "CLKFB_DIV": fb, "CLKOP_DIV": op, "CLKOS_DIV": os}
    return {
        "type": "EHXPLLL",
        "parameters": {key: f"{value:032b}" for key, value in numbers.items()} | parameters,
        "connections": {"CLKOP": [4], "CLKOS": [5]},
    }


@pytest.mark.parametrize(
    ("board", "cell", "message"),
    [
        ("ulx3s", ecp5_pll(), None),
        ("icebreaker", ice40_pll(), None),
        ("ulx3s", ecp5_pll(5, 1, 120, 10), "phase detector runs at 5 MHz; .* lower CLKI_DIV"),
        ("ulx3s", ecp5_pll(5, 1, 140, 10), "CLKOP_DIV is 140; it must be 1 to 128"),
        ("ulx3s", ecp5_pll(os=0), "CLKOS_DIV is 0; it must be 1 to 128"),
        ("ulx3s", ecp5_pll(i=0), "CLKI_DIV is 0; it must be 1 to 128"),
        ("icebreaker", ice40_pll(divq=7), "DIVQ is 7; it must be 1 to 6"),
        ("ulx3s", ecp5_pll(op=14, os=5), r"VCO runs at 350 MHz; it must be 400 to 800 MHz"),
        ("ulx3s", ecp5_pll(fb=2, op=21, os=15), "VCO runs at 1050 MHz"),
        ("ulx3s", ecp5_pll(op=24, os=8), r"clock is 75 MHz, but controller\.clock_hz .* 70 MHz"),
        ("ulx3s", ecp5_pll(FEEDBK_PATH="INT_OP"), "FEEDBK_PATH is INT_OP; take CLKOP"),
        ("icebreaker", ice40_pll(divf=39, divq=4), "VCO runs at 480 MHz; it must be 533 to 1066"),
        ("icebreaker", ice40_pll(divr=1, divf=127), "phase detector runs at 6 MHz; .* lower DIVR"),
        ("icebreaker", ice40_pll(divf=63, divq=6), r"output runs at 12 MHz; it must be 16 to 275"),
        ("icebreaker", ice40_pll(filter_range=2), "FILTER_RANGE is 2; .* at 12 MHz set 1"),
    ],
)
def test_a_pll_outside_its_data_sheet_fails(board, cell, message):
    design = synthesis.board_design(load_board(board), synthesis.OUT / board)
    netlist = {"cells": {"pll": cell}}
    if message is None:
        synthesis._check_pll(design, netlist)
        return
    with pytest.raises(SynthesisError, match=message) as failure:
        synthesis._check_pll(design, netlist)
    assert "\n" not in str(failure.value)


TWO_CLOCKS = """\
module top (input wire clk, input wire a, input wire b, output reg q);
    wire own;
    reg w, x, y, z;
    OSCG #(.DIV (2)) oscillator (.OSC (own));
    always @(posedge clk) {x, w} <= {w, a ^ b};
    always @(posedge own) {z, y} <= {y, x};
    always @(posedge clk) q <= z;
endmodule
"""


def two_clocks(tmp_path: Path, clock_hz: float) -> Design:
    """A small design for the ECP5 with a clock and, at 155 MHz, its own oscillator."""
    (tmp_path / "top.v").write_text(TWO_CLOCKS)
    sites = {"clk": "G2", "a": "A9", "b": "B10", "q": "A6"}
    (tmp_path / "top.lpf").write_text(
        "".join(f'LOCATE COMP "{pin}" SITE "{site}";\n' for pin, site in sites.items())
    )
    (tmp_path / "out").mkdir()
    return Design(
        name="two", top="top", root=tmp_path, sources=(Path("top.v"),), includes=(),
        constraints=Path("top.lpf"), family="ecp5", device="25k", package="CABGA381", speed=6,
        input_hz=clock_hz, clock_hz=clock_hz, seeds=(1,),
    )  # fmt: skip


def test_oscillators_clock_is_timed(tmp_path, tools):
    result = build(two_clocks(tmp_path, 12e6), Path("out"), tools)
    assert result.watch_mhz == 155
    assert result.watch_reached_mhz > 1.1 * 1.3 * 155
    assert result.clock_mhz == 12
    assert result.reached_mhz > 13.2


def test_each_clock_is_judged_by_its_own_rate(tmp_path):
    design = two_clocks(tmp_path, 80e6)
    own = {"type": "OSCG", "parameters": {"DIV": "10000"}, "connections": {"OSC": [7]}}
    netlist = {
        "cells": {"oscillator": own},
        "netnames": {"clk": {"bits": [2]}, "watch": {"bits": [7]}, "top.watch": {"bits": [7]}},
    }

    def reached(**mhz: float) -> tuple[float, float | None]:
        fmax = {f"$glbnet${name}": {"achieved": rate} for name, rate in mhz.items()}
        return synthesis._reached_hz(design, netlist, {"fmax": fmax})

    assert reached(clk=90, watch=30) == (90e6, 30e6)
    with pytest.raises(SynthesisError, match=r"the clock reaches 80\.00 MHz, and 88\.00 MHz"):
        reached(clk=80, watch=300)
    # 310 MHz / 16, 30 % faster, and 10 % to spare.
    with pytest.raises(SynthesisError, match=r"oscillator's clock reaches 27\.00 MHz, and 27\.71"):
        reached(clk=90, watch=27)
    with pytest.raises(SynthesisError, match="nextpnr didn't time the oscillator's clock"):
        reached(clk=90)
    with pytest.raises(SynthesisError, match="nextpnr timed no clock"):
        reached(watch=30)


def test_tool_that_is_missing(monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setenv("TOOLCHAIN", "native")
    with pytest.raises(ToolError, match="yosys is not there; install it"):
        Toolchain.of_environment().program("yosys")
    monkeypatch.setenv("TOOLCHAIN", "other")
    with pytest.raises(ToolError, match="`wheel` or `native`, not `other`"):
        Toolchain.of_environment()


@pytest.mark.parametrize(
    ("tool", "says", "version", "refused"),
    [
        ("yosys", "Yosys 0.23 (git sha1 7ce5011c24b)", "0.23", "0.70 or newer"),
        ("yosys", "Yosys 0.70+12 (git sha1 28ba3cb92, g++ 13.2)", "0.70+12", None),
        ("nextpnr-ice40", "nextpnr-ice40 -- Next (Version 0.4-1+b1)", "0.4-1+b1", "0.11 or newer"),
        ("nextpnr-ecp5", '"nextpnr-ecp5" -- Next (Version nextpnr-0.11.1)', "0.11.1", None),
        ("nextpnr-ecp5", "nextpnr-ecp5 -- Next (Version 5d1f3e2a)", "unknown", None),
    ],
)
def test_native_tools_have_an_age(tmp_path, monkeypatch, tool, says, version, refused):
    """The version that the programs themselves print, Debian's among them."""
    stand_in = tmp_path / tool
    stand_in.write_text(f"#!/bin/sh\necho '{says}'\n")
    stand_in.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    native = Toolchain("native")
    assert native.version(tool) == version
    if refused is None:
        assert native.check_age(tool) == version
    else:
        with pytest.raises(ToolError) as failure:
            native.check_age(tool)
        assert str(failure.value).startswith(f"{tool} is version {version}, too old: {refused}")
        assert "\n" not in str(failure.value)


def test_multiplier_paths_count_the_block(tmp_path):
    """One path each way, by hand: clock to operand, and product to register."""
    cell = {"type": "SB_MAC16", "parameters": {"PIPELINE_16x16_MULT_REG1": "1", "A_REG": "0"}}
    sdf = tmp_path / "delays.sdf"
    sdf.write_text(
        '(CELLTYPE "top") (INSTANCE )\n'
        "(INTERCONNECT before/O mul_DSP/A_3 (2000:2000:2000) (2000:2000:2000))\n"
        "(INTERCONNECT mul_DSP/O_5 after/I0 (4000:4000:4000) (4000:4000:4000))\n"
        '(CELLTYPE "ICESTORM_LC") (INSTANCE before)\n'
        "(IOPATH (posedge CLK) O (1000:1000:1000) (1000:1000:1000))\n"
        '(CELLTYPE "ICESTORM_DSP") (INSTANCE mul_DSP)\n'
        "(IOPATH CLK O_5 (100:100:100) (100:100:100))\n"
        "(SETUPHOLD (posedge A_3) (posedge CLK) (100:100:100) (0:0:0))\n"
        '(CELLTYPE "ICESTORM_LC") (INSTANCE after)\n'
        "(SETUPHOLD (posedge I0) (posedge CLK) (500:500:500) (0:0:0))\n"
    )
    reached_hz = multipliers.reached_hz({"cells": {"mul": cell}}, sdf)
    assert reached_hz == pytest.approx(1e9 / max(1.0 + 2.0 + 5.96, 5.46 + 4.0 + 0.5))


# ---- The words in a bitstream.


@pytest.mark.parametrize("name", board_names())
def test_words(name):
    """What the bitstream holds is what the controller `pins` runs on, but for the ADC's frame."""
    board = load_board(name)
    words, part = board.words(), PARTS[board.fpga.adc]
    time, ports = words.ports.timing, words.ports
    own = {"trip": 0, "zero_limit": 0}
    one_motors = ports.words | ports.settings.words()
    if board.brushless:
        one_motors |= magnet_words(board.scene, ports.settings, ports.start_count)
    assert words.words | own == one_motors | own
    assert time.frame == frame(part, time.clock_hz, board.fpga.pad_registers)
    assert time.frame.cycle_clocks <= time.sample_clocks
    assert time.clock_hz / time.tick_clocks == board.scene.controller.tick_hz
    brushless = board.brushless
    turns = board.fpga.link
    least = turns_clocks(words.motors, brushless=brushless) if turns else CORE_CLOCKS
    assert least <= time.tick_clocks
    # The voltage takes the scene's latency, in whole ticks.
    ready = (
        (time.samples - 1) * time.sample_clocks
        + time.sample_clocks // 2
        - words.words["sample_lead"]
        + (
            turns_latency_clocks(time.frame.conversion_clocks, words.motors, brushless=brushless)
            if turns
            else latency_clocks(
                time.frame.conversion_clocks, anchored=words.ports.settings.anchored
            )
        )
    )
    ticks = ready // time.tick_clocks + words.words["hold_ticks"]
    assert ticks == board.scene.controller.extra_ticks < 1 << words.delay_log2


GUARDED = [name for name in board_names() if load_board(name).fpga.guard]


def test_the_guard_is_on_where_there_is_room():
    assert [n for n in board_names() if load_board(n).fpga.family == "ecp5"] == GUARDED
    for name in board_names():
        assert (load_board(name).words().guard is None) == (name not in GUARDED)


def scene_of(name: str) -> str:
    """A board's scene without its name and its comments."""
    text = (ROOT / "boards" / name / "board.toml").read_text()
    return re.sub(r"#.*|^name = .*", "", text, flags=re.MULTILINE)


@pytest.mark.kept(2)
@pytest.mark.parametrize("name", sorted({scene_of(name): name for name in board_names()}.values()))
def test_the_guard_lets_the_boards_own_scene_be(name):
    """Free space and the way into the wall: no trip, and no fault that the board's guard finds."""
    scene = load_scene(ROOT / "boards" / name / "board.toml", ["scene.duration_s=0.25"])
    found = measure(scene, "pins", compare=False)
    assert "faults" not in found
    assert found["anchor_fault_s"] is None
    assert found["stiffness"] > 0.9 * found["stiffness_predicted"]


@pytest.mark.parametrize("name", board_names())
def test_header_has_every_setting(name):
    text = load_board(name).headers()["wh_board_settings.vh"]
    tops = ("wh_board_controller.v", "wh_board_ecp5.v")
    top = "".join((ROOT / "boards" / file).read_text() for file in tops)
    defined = set(re.findall(r"`define (WH_BOARD_\w+)", text))
    assert set(re.findall(r"`(WH_BOARD_\w+)", top)) == defined


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("link = true\ncapture = 12\nstream = true\n", "", "its settings over a link; .* = true"),
        ("legs = 3\n", "legs = 3\nmotors = 5\n", "at most 4 motors, which have two .*; take fewer"),
        ("legs = 3\n", "legs = 3\nshared_multiplier = true\n", "a multiplier for its core; .*"),
    ],
)  # fmt: skip
def test_what_a_brushless_board_has(tmp_path, old, new, told):
    """In one line; the tables of its pins are another board's."""
    for name in ("ulx3s", "ulx3s_brushless"):
        (tmp_path / "boards" / name).mkdir(parents=True)
        for file in ("fpga.toml", "board.toml"):
            text = (ROOT / "boards" / name / file).read_text()
            if (name, file) == ("ulx3s_brushless", "fpga.toml"):
                assert old in text
                text = text.replace(old, new)
            (tmp_path / "boards" / name / file).write_text(text)
    with pytest.raises(BoardError, match=rf"fpga\.toml:\d+: a board with legs = 3 has {told}$"):
        load_board("ulx3s_brushless", root=tmp_path)


@pytest.mark.parametrize(
    ("key", "told"),
    [
        ("walls = 8", "7 walls for a motor; take walls = 7 or fewer"),
        ("shared_multiplier = true", "one multiplier for all products always; leave .* out"),
    ],
)
def test_what_a_linked_board_with_brushes_has(tmp_path, key, told):
    """In one line."""
    folder = tmp_path / "boards" / "ulx3s"
    folder.mkdir(parents=True)
    for file in ("fpga.toml", "board.toml"):
        text = (ROOT / "boards" / "ulx3s" / file).read_text()
        text = text.replace("link = true\n", f"link = true\n{key}\n")
        (folder / file).write_text(text)
    with pytest.raises(BoardError, match=rf"fpga\.toml:\d+: a board with link = true has {told}$"):
        load_board("ulx3s", root=tmp_path)


def test_a_brushless_boards_own_words():
    """What a count turns, and that the magnets are to be found; nothing of a full bridge."""
    board = load_board("ulx3s_brushless")
    headers = board.headers()
    cell = 2 * np.pi / board.scene.encoder.counts_per_rev
    turn = round(board.scene.motor.pole_pairs * cell / (2 * np.pi) * 2**32)
    rom = headers["wh_board_settings_rom.vh"]
    first = {name: int(raw, 16) for raw, name in re.findall(r"32'h(\w{8})\)  // (\w+)", rom)}
    assert first["count_angle"] == turn
    assert first["find_magnet"] == 1
    assert first["gain"] == board.words().words["gain"]
    text = headers["wh_board_settings.vh"]
    made = dict(re.findall(r"`define WH_BOARD_(\w+) (\d+)", text))
    told = {"AXES": "1", "N": "2", "LINKED": "1", "MODES": "0"}
    assert {name: made[name] for name in told} == told


def test_four_brushless_motors_are_eight_ports():
    """Each has two ADC lines and one of all else; ``alive`` changes twice in their long period."""
    board = load_board("icesugar_pro_brushless")
    made = hardware(board.words())
    assert (made["N"], made["AXES"], made["AGAIN"]) == (8, 0b1010101, 134)
    assert board.adc_lines == [f"adc_sdata[{n}]" for n in range(8)]
    assert board.sclk_pins == [f"adc_sclk[{n}]" for n in range(4)]
    assert turns_clocks(4, brushless=True) == 7 * 32 + 42
    alone = load_board("ulx3s_brushless").words()
    assert hardware(alone)["AGAIN"] == 0


def patterns(root: Path = ROOT) -> Board:
    scene = root / "boards" / "ulx3s" / "patterns.toml"
    return load_board("ulx3s", root=root, scene_path=scene)


def assert_refused(
    load: Callable[[Path], Board], root: Path, file: str, was: str, now: str, problem: str
) -> None:
    """The build refuses the board of a copy in which ``file`` of its folder is changed."""
    for name in ("boards", "constraints", "rtl"):
        shutil.copytree(ROOT / name, root / name)
    path = root / "boards" / "ulx3s" / file
    text = path.read_text()
    assert was in text
    path.write_text(text.replace(was, now))
    with pytest.raises((BoardError, SceneError), match=re.escape(problem)):
        synthesis.check_board(load(root))


def test_the_line_chooses_between_patterns_that_differ_in_their_word_alone():
    """Not a unipolar bridge, and not without a line; the build looks at both."""
    board = patterns()
    synthesis.check_board(board)
    first, second = bridge_budget.in_patterns(board)
    assert first.words().words == {**second.words().words, "mode": MODE_WORDS[LOCKED]}
    assert hardware(board.words())["MODES"] == 1
    rom = board.headers()["wh_board_settings_rom.vh"]
    kinds = {name: int(info, 16) for info, name in re.findall(r"8'h(\w\w),.*// (\w+)", rom)}
    assert (kinds["mode"] >> 5, kinds["dead_clocks"] >> 5) == (3, 7), "with the gates off; never"
    kind = kinds["mode"] & 31
    assert f"BOUNDS({kind}, 32'd{MODE_WORDS[LOCKED]}, 32'd{MODE_WORDS[SIGN_MAGNITUDE]})" in rom
    for other in (load_board("ulx3s").words(), replace(board.words(), linked=False)):
        assert other.patterns == ()


@pytest.mark.parametrize(
    ("file", "was", "now", "problem"),
    [
        (
            "patterns.toml",
            "dead_time_s = 28.6e-9",
            "dead_time_s = 14.3e-9",
            "the dead time is 14.3",
        ),
        ("fpga.toml", '"INA241"', '"INA240"', "the INA240 may not follow the carrier of 416.7 kHz"),
        ("patterns.toml", "compensate = false", "compensate = true", "drive.compensate: what dead"),
    ],
)
def test_what_a_pattern_cant_have_is_refused(tmp_path, file, was, now, problem):
    assert_refused(patterns, tmp_path, file, was, now, problem)


def test_patterns_with_other_settings_are_refused(monkeypatch):
    """Such as a pulse of at least so much, where a leg has to be on as long in one of them only."""
    monkeypatch.setattr("wavehaptics.fpga.board_words.PATTERNS", (LOCKED, UNIPOLAR))
    with pytest.raises(
        BoardError, match=r"drive.mode = unipolar, .* sample_clocks would be another"
    ):
        bridge_budget.check(patterns())


@pytest.mark.parametrize("mode", [LOCKED, SIGN_MAGNITUDE])
def test_the_amplifier_follows_in_every_pattern(mode):
    """It holds its output after each edge, and a wall is as stiff as it should be."""
    overrides = ["scene.duration_s=0.15", f"drive.mode={mode}"]
    scene = load_scene(ROOT / "boards" / "ulx3s" / "patterns.toml", overrides)
    found = measure(scene, "pins", compare=False)
    assert "faults" not in found
    assert found["anchor_fault_s"] is None
    assert found["stiffness"] > 0.9 * found["stiffness_predicted"]


def sigma_delta(root: Path = ROOT) -> Board:
    scene = root / "boards" / "ulx3s" / "sigma_delta.toml"
    return load_board("ulx3s", root=root, scene_path=scene)


def test_a_scene_has_the_boards_modulator_in_the_place_of_its_adc():
    """Its own full scale, trip and zero; whoever names none of them has the ADC."""
    board, plain = sigma_delta(), load_board("ulx3s")
    synthesis.check_board(board)
    made, time = board.words(), board.words().ports.timing
    assert (hardware(made)["ADC"], hardware(made)["OSR"]) == (2, 21)
    assert hardware(plain.words())["ADC"] == 0
    assert time.frame == modulator_frame(MODULATORS["AMC1306M25"], 70e6, 168, pad_registers=True)
    assert time.samples * time.frame.osr * time.frame.bit_clocks == time.tick_clocks
    assert board.sense.full_scale_a == pytest.approx(3.2)
    assert board.sense.clip_a == pytest.approx(2.5)
    assert made.words["trip"] == round(2.0 / 3.2 * 2**15)
    assert board.adc_lines == plain.adc_lines
    assert (plain.sense, plain.converter) == (plain.fpga.sense, PARTS["AD7276"])


@pytest.mark.parametrize(
    ("file", "was", "now", "problem"),
    [
        ("sigma_delta.toml", "full_scale_a = 3.2", "full_scale_a = 2.5",
         "adc.full_scale_a is 2.5 A, but 100 mΩ and the AMC1306M25 make 3.2 A; set it so, or "
         "change [modulator] in"),
        ("sigma_delta.toml", '"AMC1306M25"', '"AD7403"', "the board's ADC is an AD7276; set"),
        ("sigma_delta.toml", "tick_hz = 416666.6666666667", "tick_hz = 411764.70588235295",
         "not a whole number of bits of 4 clocks"),
        ("fpga.toml", 'part = "AMC1306M25"', 'part = "AMC"',
         "modulator.part = 'AMC' is not known; AMC1306M25, AD7403 are"),
        ("fpga.toml", "shunt_ohm = 0.1\ntrip_a = 2.0", "shunt_ohm = 0.1\ntrip_a = 2.6",
         "modulator.trip_a is 2.6 A, but the AMC1306M25 is linear up to 2.5 A"),
        ("fpga.toml", "[modulator]", "[modulator]\ngain = 2.0",
         "modulator.gain is no key of a board; it has part, shunt_ohm"),
    ],
)  # fmt: skip
def test_what_a_modulator_cant_have_is_refused(tmp_path, file, was, now, problem):
    assert_refused(sigma_delta, tmp_path, file, was, now, problem)


def test_a_wall_of_a_modulators_words():
    """On `pins`, with its bits and a switching bridge, as stiff as it should be."""
    scene = load_scene(
        ROOT / "boards" / "ulx3s" / "sigma_delta.toml",
        ["scene.duration_s=0.15", "adc.noise_a=1e-3"],
    )
    found = measure(scene, "pins", compare=False)
    assert "faults" not in found
    assert found["anchor_fault_s"] is None
    assert found["stiffness"] > 0.9 * found["stiffness_predicted"]


def test_a_board_says_how_many_walls():
    """Three motors have two each."""
    three, one = load_board("ulx3s_three"), load_board("ulx3s")
    assert (three.words().walls, one.words().walls) == (2, 4)
    assert "`define WH_BOARD_WALLS 2\n" in three.headers()["wh_board_settings.vh"]
    many = replace(three.words(), linked_walls=1)
    assert many.walls == len(three.scene.controller.walls) == 1


def test_pins_of_sclk_are_shared_evenly(tmp_path):
    assert load_board("ulx3s_three").sclk_pins == ["adc_sclk"]
    assert load_board("icesugar_pro_eight").sclk_pins == [f"adc_sclk[{n}]" for n in range(4)]
    for name in ("icesugar_pro", "icesugar_pro_eight"):
        shutil.copytree(ROOT / "boards" / name, tmp_path / "boards" / name)
    path = tmp_path / "boards" / "icesugar_pro_eight" / "fpga.toml"
    path.write_text(path.read_text().replace("sclk_pins = 4", "sclk_pins = 3"))
    with pytest.raises(BoardError, match=r"fpga\.toml:\d+: sclk_pins = 3 .* by 8 motors; take a"):
        load_board("icesugar_pro_eight", root=tmp_path)


def test_header_keeps_signs_and_order():
    words = load_board("ulx3s_three").words()
    words.words["sample_lead"] = -2
    text = verilog_header(words, "somewhere")
    assert ".sample_lead_i ({8'hfe})," in text
    assert len(re.search(r"\.gain_i \(\{(.*)\}\)", text)[1].split(",")) == 3


TWO_MHZ = ("controller.tick_hz=2e6", "drive.pwm_hz=1e6")


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (
            ("controller.clock_hz=100e6", *TWO_MHZ),
            "needs 58 clocks of 1e\\+08 Hz from sample to sample",
        ),
        (("adc.part=ADS7042",), "the board's ADC is an AD7276"),
        (("adc.part=AD7277",), "the board's ADC is an AD7276"),
        (("controller.extra_ticks=0",), "extra_ticks"),
    ],
)
def test_refused_scenes(overrides, message):
    scene = load_scene(ROOT / "boards" / "ulx3s" / "board.toml", overrides)
    with pytest.raises(SceneError, match=message):
        board_words(scene, PARTS["AD7276"])


def test_too_many_motors_for_a_tick():
    scene = load_scene(ROOT / "boards" / "ulx3s" / "board.toml", ["controller.extra_ticks=3"])
    with pytest.raises(SceneError, match=r"shorter than the \d+ that `pins` needs for 4 motors"):
        board_words(scene, PARTS["AD7276"], motors=4)


def test_shared_multiplier_is_refused_where_it_has_no_time():
    """W needs the core's own one, and the products of a tick more clocks than a short one has."""
    board = load_board("hx8k")
    path = ROOT / board.folder / "board.toml"
    assert "`define WH_BOARD_SHARED 1\n" in board.headers()["wh_board_settings.vh"]
    assert "`define WH_BOARD_SHARED 0\n" in load_board("ulx3s").headers()["wh_board_settings.vh"]
    shaped = ("shaper.feel=spring", "shaper.stiffness=0.3", "shaper.damping=0.1e-3")
    with pytest.raises(
        SceneError, match=r"^--set shaper.*: \[shaper\] needs a multiplier that the wave core"
    ):
        replace(board, scene=load_scene(path, shaped)).words()
    short = (
        "controller.clock_hz=38e6", "controller.tick_hz=1e6", "drive.pwm_hz=500e3",
        "controller.extra_ticks=3",
    )  # fmt: skip
    with pytest.raises(
        SceneError, match="a tick of 38 clocks is shorter than the 39 that the shared multiplier"
    ):
        replace(board, scene=load_scene(path, short)).words()
    alone = replace(board, fpga=board.fpga.model_copy(update={"shared_multiplier": False}))
    assert not replace(alone, scene=load_scene(path, short)).words().shared


def test_slow_adc():
    slow = ["adc.part=AD7476A", "controller.tick_hz=1e6", "drive.pwm_hz=500e3"]
    scene = load_scene(ROOT / "boards" / "icebreaker" / "board.toml", slow)
    with pytest.raises(SceneError, match=r"needs \d+ clocks of 2.7e\+07 Hz from sample to sample"):
        board_words(scene, PARTS["AD7476A"])


def test_boards_that_are_not_there():
    with pytest.raises(BoardError, match="there is no board 'none'; take one of"):
        load_board("none")
    with pytest.raises(BoardError, match="ulx3s has no device '99k'; take one of 25k"):
        load_board("ulx3s", "99k")
    assert load_board("ulx3s", "85k").device == "85k"


LINK = "link = true\ncapture = 12\nstream = true"


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("guard = true", 'guard = "yes"', 'guard = "yes": it must be a valid boolean'),
        ("trip_a", "trip_amps", "sense.trip_a is missing; another board's"),
        ("guard = true", "gaurd = true", "gaurd is no key of a board; did you mean guard?"),
        ("capture = 12", "capture = 16", "capture = 16: it must be 0, 9, 10, "),
        ("link = true", "link = false", "capture goes with a link; set link = true or leave it"),
        (LINK, "walls = 2", "walls goes with a link; set link = true or leave it out"),
        (
            "guard = true",
            "guard = false",
            "overcurrent goes with a guard; set guard = true or l",
        ),
        ("link = true", "link = true\nwalls = 0", "walls = 0: it must be greater than or equal"),
        ("motors", "motor", "motor is no key of a board; did you mean motors?"),
    ],
)
def test_a_wrong_board_file_is_told_with_its_line(tmp_path, old, new, problem):
    shutil.copytree(ROOT / "boards" / "ulx3s", tmp_path / "boards" / "ulx3s")
    path = tmp_path / "boards" / "ulx3s" / "fpga.toml"
    text = path.read_text()
    if old == "motors":
        text = "motors = 1\n" + text
    assert text.count(old) >= 1
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(BoardError) as refused:
        load_board("ulx3s", root=tmp_path)
    where, _, told = str(refused.value).partition(": ")
    assert told.startswith(problem)
    line = int(where.removeprefix(f"{path}:"))
    key = problem.split()[0].split(".")[0]
    assert key in path.read_text().splitlines()[line - 1]


@pytest.mark.parametrize("name", board_names())
def test_page_has_every_pin(name):
    """A board's page names the place of each pin of its constraints, but for the oscillator's."""
    board = load_board(name)
    pins = read_pins((ROOT / board.constraints).read_text(), board.fpga.family)
    page = (ROOT / board.folder / "README.md").read_text()
    assert len(pins) >= 13
    for pin in pins:
        assert pin.port.startswith("clk_") or re.search(rf"\b{pin.site}\b", page), pin


# ---- The programmers.

PROGRAMMERS = {
    "colorlight_i5": [
        "openFPGALoader", "-b", "colorlight-i5", "build/synth/colorlight_i5/colorlight_i5.bit",
    ],
    "ecp5_evn": ["openFPGALoader", "-b", "ecp5_evn", "build/synth/ecp5_evn/ecp5_evn.bit"],
    "hx8k": ["iceprog", "build/synth/hx8k/hx8k.bin"],
    "icebreaker": ["iceprog", "build/synth/icebreaker/icebreaker.bin"],
    "icesugar_pro": [
        "openFPGALoader", "--cable", "cmsisdap", "--vid", "0x1d50", "--pid", "0x602b",
        "build/synth/icesugar_pro/icesugar_pro.bit",
    ],
    "icesugar_pro_brushless": [
        "openFPGALoader", "--cable", "cmsisdap", "--vid", "0x1d50", "--pid", "0x602b",
        "build/synth/icesugar_pro_brushless/icesugar_pro_brushless.bit",
    ],
    "icesugar_pro_eight": [
        "openFPGALoader", "--cable", "cmsisdap", "--vid", "0x1d50", "--pid", "0x602b",
        "build/synth/icesugar_pro_eight/icesugar_pro_eight.bit",
    ],
    "orangecrab": [
        "dfu-util", "--device", "1209:5af0", "--alt", "0", "--download",
        "build/synth/orangecrab/orangecrab.bit",
    ],
    "ulx3s": ["fujprog", "build/synth/ulx3s/ulx3s.bit"],
    "ulx3s_brushless": ["fujprog", "build/synth/ulx3s_brushless/ulx3s_brushless.bit"],
    "ulx3s_gan": ["fujprog", "build/synth/ulx3s_gan/ulx3s_gan.bit"],
    "ulx3s_gan_brushed": ["fujprog", "build/synth/ulx3s_gan_brushed/ulx3s_gan_brushed.bit"],
    "ulx3s_space": ["fujprog", "build/synth/ulx3s_space/ulx3s_space.bit"],
    "ulx3s_three": ["fujprog", "build/synth/ulx3s_three/ulx3s_three.bit"],
}  # fmt: skip

FLASHERS = {
    "colorlight_i5": [
        "openFPGALoader", "-b", "colorlight-i5", "--unprotect-flash", "--write-flash", "--verify",
        "build/synth/colorlight_i5/colorlight_i5.bit",
    ],
    "ecp5_evn": [
        "openFPGALoader", "-b", "ecp5_evn", "--write-flash", "--verify",
        "build/synth/ecp5_evn/ecp5_evn.bit",
    ],
    # It writes the flash and reads it back unless it is told not to.
    "hx8k": PROGRAMMERS["hx8k"],
    "icebreaker": PROGRAMMERS["icebreaker"],
    **{
        name: [*PROGRAMMERS[name][:-1], "--write-flash", "--verify", PROGRAMMERS[name][-1]]
        for name in ("icesugar_pro", "icesugar_pro_brushless", "icesugar_pro_eight")
    },
    # Its bootloader knows nothing but the flash.
    "orangecrab": PROGRAMMERS["orangecrab"],
    **{
        name: ["openFPGALoader", "-b", "ulx3s", "--write-flash", "--verify", PROGRAMMERS[name][-1]]
        for name in PROGRAMMERS
        if name.startswith("ulx3s")
    },
}  # fmt: skip
COMMANDS = {"prog": PROGRAMMERS, "flash": FLASHERS}


def prog(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, board: str, made: bool, command: str = "prog"
) -> Any:
    """``prog`` of a board, its bitstream ``made`` or not, in a repository that holds no more."""
    monkeypatch.setattr(board_commands, "ROOT", tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    if made:
        bitstream = tmp_path / PROGRAMMERS[board][-1]
        bitstream.parent.mkdir(parents=True)
        bitstream.write_bytes(b"bits")
    return CliRunner().invoke(board_commands.app, [command, board])


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("board", board_names())
def test_programmer_is_called(tmp_path, monkeypatch, board, command):
    """The board's own programmer gets the bitstream, and its exit status is handed on."""
    called, words = tmp_path / "called", COMMANDS[command][board]
    stand_in = tmp_path / "bin" / words[0]
    stand_in.parent.mkdir()
    stand_in.write_text(
        f'#!/bin/sh\necho "$0" "$@" > {called}\nfor last; do :; done\ntest -s "$last" && exit 3\n'
    )
    stand_in.chmod(0o755)
    result = prog(tmp_path, monkeypatch, board, True, command)
    assert result.exit_code == 3
    assert called.read_text().split() == [str(stand_in), *words[1:]]


@pytest.mark.parametrize("board", board_names())
def test_the_flash_is_verified(board):
    """By iceprog of itself, which -n would forbid, or by the option; else the page says so."""
    loaded = load_board(board)
    words = loaded.fpga.flash
    page = " ".join((ROOT / loaded.folder / "README.md").read_text().split())
    verified = (words[0] == "iceprog" and "-n" not in words) or "--verify" in words
    assert verified == ("What is written isn't read back" not in page)
    assert verified or words[0] == "dfu-util"


def test_programmer_that_is_missing(tmp_path, monkeypatch):
    result = prog(tmp_path, monkeypatch, "ulx3s", made=True)
    assert result.exit_code == 2
    assert result.stderr == (
        "synthesis: fujprog is not on PATH; install it, or run another programmer\n"
    )


def test_programmer_without_a_bitstream(tmp_path, monkeypatch):
    result = prog(tmp_path, monkeypatch, "ulx3s", made=False)
    assert result.exit_code == 2
    assert result.stderr == (
        "synthesis: build/synth/ulx3s/ulx3s.bit is not there; run `make bitstream BOARD=ulx3s`\n"
    )


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    "source",
    [
        "boards/ulx3s/board.toml",
        "boards/ulx3s/fpga.toml",
        "boards/ulx3s/ulx3s.v",
        "boards/wh_board_switch.v",
        "constraints/ulx3s.lpf",
        "rtl/wh_pwm.v",
        "rtl/wh_faults.vh",
        "rtl/words.toml",
    ],
)
def test_a_bitstream_older_than_its_sources_is_refused(tmp_path, monkeypatch, source, command):
    """Else it is an image of other settings that drives the gates."""
    board = load_board("ulx3s")
    for path in synthesis.board_sources(board):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_bytes((ROOT / path).read_bytes())
        os.utime(tmp_path / path, (1e9, 1e9))
    later = max(time.time(), (tmp_path / source).stat().st_mtime) + 60
    os.utime(tmp_path / source, (later, later))
    moved = Board(board.name, tmp_path, board.fpga, board.device, board.scene)
    monkeypatch.setattr(board_commands, "load_board", lambda *_: moved)
    result = prog(tmp_path, monkeypatch, "ulx3s", True, command)
    assert result.exit_code == 2
    assert result.stderr == (
        f"synthesis: build/synth/ulx3s/ulx3s.bit is older than {source}; "
        "run `make bitstream BOARD=ulx3s`\n"
    )


# ---- The numbers.


def test_pages_show_the_kept_numbers():
    assert filler.stale_pages() == [], "run `make numbers`"


def test_stale_page_is_noticed(tmp_path):
    (tmp_path / "boards").mkdir()
    (tmp_path / filler.KEPT).write_bytes((ROOT / filler.KEPT).read_bytes())
    page = tmp_path / "README.md"
    page.write_text("before\n<!-- begin boards -->\n<!-- end boards -->\nafter\n")
    assert filler.stale_pages(tmp_path) == [Path("README.md")]
    assert filler.write(tmp_path) == [Path("README.md")]
    assert filler.write(tmp_path) == []
    assert filler.stale_pages(tmp_path) == []
    page.write_text(page.read_text().replace("| `ulx3s` |", "| `ulx4s` |"))
    assert filler.stale_pages(tmp_path) == [Path("README.md")]
    page.write_text("<!-- begin boards -->\n")
    with pytest.raises(filler.NumbersError, match="has no <!-- end boards -->"):
        filler.write(tmp_path)


def test_numbers_of_another_version_are_refused(tmp_path):
    """They would lack what the pages show; what is kept stays as it was."""
    summary = tmp_path / synthesis.OUT / "summary.json"
    summary.parent.mkdir(parents=True)
    summary.write_text('{"boards": [{"board": "ulx3s", "spare": 0.3}]}')
    with pytest.raises(filler.NumbersError, match=r"summary\.json is that of another version"):
        filler.keep(tmp_path)
    assert not (tmp_path / filler.KEPT).exists()


def kept(name: str) -> dict[str, object]:
    boards = json.loads((ROOT / filler.KEPT).read_bytes())["boards"]
    return next(board for board in boards if board["board"] == name)


MADE = [name for name in board_names() if not load_board(name).fpga.on_demand]
"""Boards that `make synth` makes."""


def test_boards_on_demand_have_no_numbers():
    """`make synth` leaves them out, and the pages have no row of them."""
    boards = json.loads((ROOT / filler.KEPT).read_bytes())["boards"]
    assert [board["board"] for board in boards] == MADE
    assert set(board_names()) - set(MADE) == {
        "icesugar_pro_brushless", "ulx3s_gan", "ulx3s_gan_brushed", "ulx3s_space",
    }  # fmt: skip


@pytest.mark.parametrize("name", board_names())
def test_the_watch_fits_both_clocks(name):
    """ECP5 boards have one, and the beat suits it wherever its oscillator is in its tolerance."""
    board = load_board(name)
    top = (ROOT / board.folder / f"{name}.v").read_text()
    watched = board.fpga.family == "ecp5"
    assert ("wh_board_ecp5" in top) == watched
    if name in MADE:
        assert (kept(name)["watch_mhz"] is not None) == watched
    if not watched:
        return
    hz = synthesis.OSCILLATOR_HZ / int(re.search(r"\.WATCH_DIV +\((\d+)\)", top)[1])
    if name in MADE:
        assert kept(name)["watch_mhz"] == pytest.approx(hz / 1e6, abs=0.01)
    verilog = (ROOT / "boards" / "wh_board_clock_watch.v").read_text()
    beat, patience = (
        2 ** int(re.search(rf"parameter integer {parameter}_LOG2 += (\d+)", verilog)[1])
        for parameter in ("BEAT", "PATIENCE")
    )
    for off in (-synthesis.OSCILLATOR_TOLERANCE, 0, synthesis.OSCILLATOR_TOLERANCE):
        watch_clocks = beat / board.clock_hz * hz * (1 + off)
        assert 2 < watch_clocks < (patience - 2) / 2, "twice as far from an alarm as need be"


def test_kept_numbers_keep_the_promises():
    for name in MADE:
        board = kept(name)
        assert board["spare"] >= synthesis.SPARE
        if board["watch_mhz"] is not None:
            fastest = (1 + synthesis.OSCILLATOR_TOLERANCE) * board["watch_mhz"]
            assert board["watch_reached_mhz"] >= (1 + synthesis.SPARE) * fastest
        assert board["zero"]
        assert board["anchor"]
        # The brushless board: a dead time of one clock, and little of it in a tick.
        # Eight take turns of 32 clocks each.
        slower = {"ulx3s_brushless": 0.4, "ulx3s_three": 0.68, "icesugar_pro_eight": 0.25}
        assert load_board(name).scene.controller.tick_hz >= 1e6 * slower.get(name, 0.8)
    for name in MADE:
        pads = kept(name)["pads"]
        assert pads["margin_ns"] > 0
        assert pads["hold_ns"] > 3
        assert pads["dead_ns"] >= pads["dead_needed_ns"] >= 20
        assert pads["fpga_skew_ns"] <= pads["fpga_skew_granted_ns"]
        assert pads["trip_a"] < pads["clip_a"]
    for name in ("hx8k", "icebreaker"):
        assert kept(name)["logic_cells"] <= 0.9 * kept(name)["logic_cells_available"]


@pytest.mark.long
@pytest.mark.parametrize("name", ["icebreaker", "ulx3s"])
def test_fresh_synthesis_is_what_the_pages_say(name, tools):
    """Exactly in multipliers and memories, nearly in logic; the clock is met or the build fails."""
    result, shown = synthesis.build_board(load_board(name), tools, say=print), kept(name)
    assert (ROOT / synthesis.bitstream_path(load_board(name))).stat().st_size > 0
    assert (result.dsp, result.block_ram) == (shown["dsp"], shown["block_ram"])
    assert result.watch_mhz == shown["watch_mhz"]
    for key in ("logic_cells", "lut", "ff"):
        assert getattr(result, key) == pytest.approx(shown[key], rel=LUT_TOLERANCE), key
    assert result.clock_mhz == shown["clock_mhz"]
