# SPDX-License-Identifier: Apache-2.0
"""What can be said of a board by its text alone is said before any tool has run."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner
from wavehaptics.fpga.boards import BoardError, board_names, load_board
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain
from wavehaptics.scene import SceneError
from wavetools.cli import board_commands
from wavetools.fpga import pll, synthesis, tops
from wavetools.fpga.board_pins import read_pins
from wavetools.fpga.synthesis import SynthesisError


def told(name: str) -> dict:
    board = load_board(name)
    design = synthesis.board_design(board, synthesis.OUT / name)
    sources = {str(path): (ROOT / path).read_text() for path in design.sources}
    return tops.netlist(design.top, sources, board.headers())


@pytest.mark.parametrize("name", board_names())
def test_every_boards_text_says_pins_and_clock(name):
    board, found = load_board(name), told(name)
    pins = {
        pin.port for pin in read_pins((ROOT / board.constraints).read_text(), board.fpga.family)
    }
    bits = {
        port if len(of["bits"]) == 1 else f"{port}[{bit}]"
        for port, of in found["ports"].items()
        for bit in range(len(of["bits"]))
    }
    assert bits == pins
    (cell,) = found["cells"].values()
    assert pll.of_cell(cell, board.fpga.input_hz).clock_hz == board.clock_hz
    synthesis.check_board(board)


class NoTools(Toolchain):
    """Tools that must not be called."""

    def program(self, tool: str) -> str:
        raise AssertionError(f"{tool} is asked for")


@pytest.fixture
def copy(tmp_path) -> Path:
    """A repository with the boards' sources."""
    for name in ("boards", "constraints", "rtl"):
        shutil.copytree(ROOT / name, tmp_path / name)
    return tmp_path


ULX3S, ECP5 = "boards/ulx3s/ulx3s.v", "boards/wh_board_ecp5.v"


@pytest.mark.parametrize(
    ("board", "file", "was", "now", "error", "message"),
    [
        ("ulx3s", "constraints/ulx3s.lpf", '"alive"', '"alife"', SynthesisError,
         "ulx3s: pin alive is unconstrained; give it a line in constraints/ulx3s.lpf"),
        ("ulx3s", ULX3S, "    output wire alive,\n", "", SynthesisError,
         "constraints/ulx3s.lpf: alive is no pin of the top ulx3s; delete the line"),
        ("ulx3s", "boards/ulx3s/fpga.toml", "spi = true", "spi = false", BoardError,
         "constraints/ulx3s.lpf: spi_cs_n has a pin, and boards/ulx3s/fpga.toml has no spi = true"),
        ("ulx3s", "constraints/ulx3s.lpf", '"overcurrent_n"', '"overcurent_n"', BoardError,
         "constraints/ulx3s.lpf: overcurrent_n is missing, and boards/ulx3s/fpga.toml has over"),
        ("colorlight_i5", "boards/colorlight_i5/fpga.toml", "stream = true",
         "stream = true\nspi = true", BoardError, "colorlight_i5.lpf: spi_cs_n is missing, and"),
        ("ulx3s_three", "boards/ulx3s_three/ulx3s_three.v", "input  wire [2:0] enc_a,",
         "input  wire [3:0] enc_a,", SynthesisError, "pin enc_a[3] is unconstrained"),
        ("ulx3s", ULX3S, ".CLKOP_DIV  (28)", ".CLKOP_DIV  (30)", SynthesisError,
         "the top's clock is 75 MHz, but controller.clock_hz of its scene is 70 MHz"),
        ("ulx3s", ULX3S, ".CLKOP_DIV  (28)", ".CLKOP_DIV  (8'h70)", SynthesisError,
         "the PLL's VCO runs at 2800 MHz; it must be 400 to 800 MHz"),
        ("ulx3s", ULX3S, ".CLKOS_DIV  (10)", ".CLKOS_DIV  (0)", SynthesisError,
         "the PLL's CLKOS_DIV is 0; it must be 1 to 128"),
        ("ulx3s", ECP5, "CLKI_DIV  = 1,", "CLKI_DIV  = 2 + 1,", SynthesisError,
         "the PLL's phase detector runs at 8.33333 MHz"),
        ("icebreaker", "boards/icebreaker/icebreaker.v", "7'd71", "7'd127", SynthesisError,
         "the PLL's VCO runs at 1536 MHz"),
        ("ulx3s", "boards/ulx3s/board.toml", "clock_hz = 70e6", "clock_hz = 70833333.33333334",
         SynthesisError,
         "the top's clock is 70 MHz, but controller.clock_hz of its scene is 70.8333 MHz"),
        ("ulx3s", ULX3S, ".WATCH_DIV ", ".WATCH_DIVIDER ", SynthesisError,
         "boards/ulx3s/ulx3s.v:55: wh_board_ecp5 has no parameter WATCH_DIVIDER; it has CLKI_DIV"),
        ("ulx3s", "boards/wh_board_controller.v", ".SETTLE_LOG2 ", ".SETTLE ", SynthesisError,
         "wh_board_switch has no parameter SETTLE; it has N, AGAIN, SETTLE_LOG2"),
        ("ulx3s", "boards/ulx3s/fpga.toml", "guard = true", "gard = true", BoardError,
         "did you mean guard?"),
        ("ulx3s", "boards/ulx3s/board.toml", "dead_time_s", "dead_times", SceneError,
         "drive.dead_times"),
    ],
)  # fmt: skip
def test_no_tool_is_needed_for_it(copy, board, file, was, now, error, message):
    text = (copy / file).read_text()
    assert text.count(was) >= 1
    (copy / file).write_text(text.replace(was, now, 1))
    with pytest.raises(error) as refused:
        synthesis.build_board(load_board(board, root=copy), NoTools("wheel"))
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_seeds_begin_with_it_too(copy):
    path = copy / ULX3S
    path.write_text(path.read_text().replace(".CLKOP_DIV  (28)", ".CLKOP_DIV  (30)"))
    with pytest.raises(SynthesisError, match="the top's clock is 75 MHz"):
        synthesis.survey_seeds(load_board("ulx3s", root=copy), NoTools("wheel"), [1])


def test_all_boards_are_checked_before_the_first_is_made(monkeypatch):
    checked, last = [], board_names()[-1]

    def check(board):
        checked.append(board.name)
        if board.name == last:
            raise SynthesisError(f"{last}: what is wrong")

    monkeypatch.setattr(synthesis, "check_board", check)
    monkeypatch.setattr(synthesis, "build_board", lambda *_: pytest.fail("a board is made"))
    ended = CliRunner().invoke(board_commands.app, ["synth"])
    assert (ended.exit_code, ended.stdout) == (1, "")
    assert ended.stderr == f"synthesis: {last}: what is wrong\n"
    assert checked == board_names()


@pytest.mark.parametrize(
    ("was", "now", "message"),
    [
        ('package = "CABGA381"', 'package = "CABGA38"', "Unsupported package 'CABGA38'"),
        ('"25k"', '"26k"', "unrecognised option '--26k'"),
        ("speed = 6", "speed = 9", "Unsupported speed grade '9'"),
    ],
)
def test_the_placer_knows_its_parts_before_synthesis(copy, monkeypatch, was, now, message):
    path = copy / "boards" / "ulx3s" / "fpga.toml"
    assert was in path.read_text()
    path.write_text(path.read_text().replace(was, now, 1))
    monkeypatch.setattr(synthesis, "synthesise", lambda *_: pytest.fail("it is synthesised"))
    with pytest.raises(SynthesisError, match=message) as refused:
        synthesis.build_board(load_board("ulx3s", root=copy), Toolchain.of_environment())
    assert str(refused.value).endswith("; fpga.toml has devices, package and speed")


# ---- What the text says, and what it doesn't.

PLL = """
    SB_PLL40_CORE #(.DIVR (4'd0), .DIVF (7'd63), .DIVQ (3'd4), .FILTER_RANGE (3'd1)) pll (
        .REFERENCECLK (clk)
    );
"""


def read(text: str, header: str = "") -> dict:
    return tops.netlist("top", {"top.v": text}, {"header.vh": header})


def widths(text: str, header: str = "") -> dict[str, int] | None:
    ports = read(text, header)["ports"]
    return None if ports is None else {name: len(port["bits"]) for name, port in ports.items()}


@pytest.mark.parametrize(
    ("head", "found"),
    [
        ("(input wire clk, output reg [3:0] q, r)", {"clk": 1, "q": 4, "r": 4}),
        ("(input [1:0] a, output q)", {"a": 2, "q": 1}),
        ("(inout wire signed [0:7] a)", {"a": 8}),
        ("#(parameter integer N = 3) (input wire [2 * N - 1:0] a)", {"a": 6}),
        ("(input wire [`WIDE-1:0] a, /* input wire b, */ input wire c) // );", {"a": 5, "c": 1}),
        ("(input wire [$clog2(9):0] a)", None),
        ("(input wire [`NARROW:0] a)", None),
        ("(\n`ifdef A\n input wire a,\n`endif\n input wire b)", None),
        ("(a, q)", {"a": 1, "q": 1}),
    ],
)
def test_ports(head, found):
    assert widths(f"module top {head};\nendmodule\n", "`define WIDE 5\n") == found


def cells(body: str, more: str = "") -> list | None:
    found = read(f"module top (input wire clk);\n{body}\nendmodule\n{more}")["cells"]
    return None if found is None else [pll.of_cell(cell, 12e6).clock_hz for cell in found.values()]


def test_plls():
    assert cells("") == []
    assert cells(PLL) == [48e6]
    assert cells("always @(*) q = 1; (* keep *) " + PLL) == [48e6]
    assert cells(f"// {PLL.strip()}".replace("\n", " ")) == []
    below = f"module below #(parameter N = 63) (input wire clk);{PLL}endmodule"
    below = below.replace("7'd63", "N")
    assert cells("below a (.clk (clk));", below) == [48e6]
    assert cells("below #(.N (39 + 40)) a (.clk (clk));", below) == [60e6]


@pytest.mark.parametrize(
    "head",
    [
        "#(parameter integer M = 1, N = 2) (input wire clk);",
        "#(parameter integer M = 1, parameter [7:0] N = (1 + 1)) (input wire clk);",
        "(input wire clk); parameter M = 1, N = 2;",
    ],
)
def test_parameters(head):
    """However they are declared: only one that isn't there is refused."""
    below = f"module below {head}\nendmodule"
    assert cells("below #(.M (3), .N (4)) a (.clk (clk));", below) == []
    with pytest.raises(tops.TopError) as refused:
        cells("\nbelow #(.M (3), .K (4)) a (.clk (clk));", below)
    assert str(refused.value) == "top.v:3: below has no parameter K; it has M, N"


@pytest.mark.parametrize(
    "body",
    [
        f"generate if (1) begin {PLL} end endgenerate",
        f"`ifdef A\n{PLL}\n`endif",
        PLL.replace("7'd63", "$clog2(64)"),
        PLL.replace(".DIVF", ".DIFV"),  # which Yosys names
    ],
)
def test_what_only_an_elaboration_knows(body):
    assert cells(body) is None


def test_another_top():
    assert read("module other (input wire clk); endmodule") == {"ports": None, "cells": None}
