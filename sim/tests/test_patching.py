# SPDX-License-Identifier: Apache-2.0
"""A built bitstream with another scene's settings: they alone change, or one line says why not."""

from __future__ import annotations

import json
import random
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from test_own_scene import scene
from typer.testing import CliRunner
from wavehaptics.cli import main
from wavehaptics.cli.shared import CommandError
from wavehaptics.fpga.board_words import hardware, memory_words
from wavehaptics.fpga.boards import load_board, write_headers
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain
from wavehaptics.scene import SceneError
from wavetools.cli import main as tools
from wavetools.fpga import patching
from wavetools.fpga.synthesis import synthesis_command

CHANGES = (
    ("anchor_auto = true", "anchor_auto = true\neta_free = 0.95"),
    ("[[0.0, 100.0]]", "[[-0.3, 0.2], [0.5, 1.0]]"),
)  # fmt: skip
SHAPED = ("[host]", '[shaper]\nfeel = "spring"\nstiffness = 0.2\ndamping = 1e-3\n[host]')
OF_THE_BOARD = {"sample_lead", "frame_bits", "lead_bits", "guard_mask"}
"""Registers that a board's pad registers and overcurrent pin change: `wavehaptics registers` has
them without."""


def section(number: int, words: list[int]) -> str:
    """A block RAM of the configuration's text, by the format of Project Trellis."""
    cells = [word >> 9 * n & 0x1FF for word in words for n in range(4)]
    cells += [0] * (2048 - len(cells))
    lines = (" ".join(f"{c:03x}" for c in cells[n : n + 8]) for n in range(0, 2048, 8))
    return f".bram_init {number}\n" + "\n".join(lines) + "\n\n"


def held(config: str) -> dict[int, list[int]]:
    """Contents of the block RAMs of a configuration, 512 words of 36 bits each."""
    found = {}
    for number, text in re.findall(r"^\.bram_init (\d+)\n([0-9a-f \n]+)", config, re.MULTILINE):
        cells = [int(cell, 16) for cell in text.split()]
        found[int(number)] = [
            sum(cells[4 * n + part] << 9 * part for part in range(4)) for n in range(512)
        ]
    return found


def run(tool: str, arguments: list[str], folder: Path) -> None:
    assert Toolchain.of_environment().run(tool, arguments, folder, folder / f"{tool}.log") == 0


def invoke(*arguments: object):
    return CliRunner().invoke(tools.app, ["patch", *map(str, arguments)])


@pytest.mark.long
def test_the_settings_alone_change(tmp_path):
    """The result is, byte for byte, what is packed with the scene's words in the ROM's place."""
    path = scene(tmp_path, *CHANGES)
    board = load_board("ulx3s", scene_path=path)
    noise = [random.Random(1).getrandbits(36) for _ in range(512)]
    for name, words in (("old", load_board("ulx3s").words()), ("new", board.words())):
        rom = memory_words(words)
        config = ".device LFE5U-25F\n\n.comment Part: LFE5U-25F-6CABGA381\n\n"
        blocks = {0: [], 7: rom, 8: noise, 21: [*memory_words(load_board("ulx3s").words()), 1]}
        config += "".join(section(*block) for block in blocks.items())
        (tmp_path / f"{name}.config").write_text(config)
        run("ecppack", ["--compress", f"{name}.config", f"{name}.bit"], tmp_path)
    assert (tmp_path / "old.bit").read_bytes() != (tmp_path / "new.bit").read_bytes()

    result = invoke(tmp_path / "old.bit", path, "--board", "ulx3s")
    assert result.exit_code == 0, result.output
    made = tmp_path / "old-mine.bit"
    assert f"--verify {made}" in result.output
    assert made.read_bytes() == (tmp_path / "new.bit").read_bytes()


def test_the_words_are_the_scenes_registers(tmp_path):
    path = scene(tmp_path, *CHANGES)
    rom = memory_words(load_board("ulx3s", scene_path=path).words())
    told = CliRunner().invoke(main.app, ["registers", str(path), "--format", "json", "--trip", "2"])
    registers = json.loads(told.stdout)
    differ = {
        one["name"]
        for one in registers
        if rom[one["address"] + (160 if one["address"] < 256 else -256)] != one["raw"]
    }
    assert len(registers) > 80
    assert differ == OF_THE_BOARD


@pytest.mark.parametrize(
    ("name", "change", "problem"),
    [
        ("ulx3s", ("clock_hz = 70e6", "clock_hz = 60e6"), "the top's clock is 70 MHz, but"),
        ("ulx3s", ("tick_hz = 833333.3333333334", "tick_hz = 2.5e6"), "tick_hz = 2500000, and"),
        ("ulx3s", ("extra_ticks = 1", "extra_ticks = 5"),
         "controller.extra_ticks needs other hardware than the bitstream has: DELAY_LOG2 is 3"),
        ("ulx3s", SHAPED, "shaper needs other hardware .* SHAPER is 1, and 0 there"),
        ("ulx3s", ("[host]", "# [host]"), "host needs other hardware"),
        ("ulx3s", ("lambda = 1e4", "lambda = 5e4"),
         "the scene makes guard_energy = .* is a constant in the bitstream's logic"),
        ("icebreaker", ("", ""), "are constants in its logic"),
    ],
)  # fmt: skip
def test_what_needs_a_build(tmp_path, name, change, problem):
    path = scene(tmp_path, change) if change[0] else ROOT / "boards" / name / "board.toml"
    result = invoke(tmp_path / f"{name}.bit", path)
    assert isinstance(result.exception, CommandError | SceneError), result.output
    said = str(result.exception)
    assert re.search(problem, said)
    assert "\n" not in said
    if "hardware" in problem or "logic" in problem:
        assert f"run `make bitstream BOARD={name} SCENE=" in said


def test_one_block_alone_is_replaced():
    old, new = [5, 1 << 31, 3], [0, 7, 1 << 35]
    before, behind = "\n.tile X\n\n" + section(0, [5]), section(9, [*old, 1])
    made = patching.replaced(before + section(4, old) + behind, old, new)
    assert made == before + section(4, new) + behind


@pytest.mark.parametrize("count", [0, 2])
def test_settings_are_in_one_block_or_in_none(count):
    config = "".join(section(n, [1, 2, 3]) for n in range(count))
    assert patching.replaced(config, [1, 2, 3], [4, 5, 6]) is None


def test_a_file_that_is_no_bitstream(tmp_path):
    (tmp_path / "ulx3s.bit").write_bytes(b"no bitstream")
    result = invoke(tmp_path / "ulx3s.bit", scene(tmp_path))
    assert re.fullmatch(r".*ulx3s\.bit: ecpunpack failed: .*", str(result.exception))
    result = invoke(tmp_path / "my.bit", scene(tmp_path))
    assert re.search("my is no board; name the bitstream's with --board", str(result.exception))
    result = invoke(tmp_path / "nothing.bit", scene(tmp_path), "--board", "ulx3s")
    assert re.search("nothing.bit: No such file", str(result.exception))


TOP = """
module tb;
    wh_registers #(.WALLS({walls}), .SHAPER({sections})) dut ();
    integer n;
    initial for (n = 0; n < 256; n = n + 1) $display("%h", dut.defaults[n]);
endmodule
"""


@pytest.mark.parametrize("name", ["ulx3s", "ulx3s_brushless", "ulx3s_three"])
def test_the_rom_is_the_verilogs(tmp_path, name):
    board = load_board(name)
    write_headers(board, tmp_path)
    made = hardware(board.words())
    top = TOP.format(walls=made["WALLS"], sections=made["SHAPER"])
    (tmp_path / "tb.v").write_text(top)
    names = ("registers", "register_ram", "settings_rom", "setting_group")
    sources = [str(ROOT / "rtl" / f"wh_{source}.v") for source in names]
    subprocess.run(
        ["iverilog", "-g2005", "-DWH_BOARD_ROM", "-I", str(ROOT / "rtl"), "-I", str(tmp_path),
         "-s", "tb", "-o", str(tmp_path / "tb"), str(tmp_path / "tb.v"), *sources],
        check=True,
    )  # fmt: skip
    told = subprocess.run(
        ["vvp", "-n", tmp_path / "tb"], check=True, capture_output=True, text=True
    )
    assert [int(line, 16) for line in told.stdout.split()] == memory_words(board.words())


SMALL = """
`include "wh_formats.vh"
`include "wh_faults.vh"
module small (input wire clk, input wire rst, input wire serial, output wire out);
    reg [50:0] in_q;
    wire [31:0] data;
    wire [11:0] address;
    wire write;
    always @(posedge clk) in_q <= {in_q[49:0], serial};
    assign out = ^{data, address, write};
    wh_registers dut (
        .clk(clk), .rst(rst), .bus_valid_i(in_q[0]), .bus_write_i(in_q[1]), .bus_check_i(in_q[2]),
        .bus_address_i(in_q[14:3]), .bus_data_i(in_q[46:15]), .data_o(data), .address_o(address),
        .write_o(write), .running_i(in_q[47]), .adc_ready_i(in_q[48]), .tick_i(in_q[49]),
        .faults_i({`WH_FAULTS{in_q[50]}}), .live_valid_i(1'b0), .live_port_i(1'b0),
        .live_word_i(4'd0), .live_data_i(32'd0), .other_i(32'd0));
endmodule
"""


@pytest.mark.long
def test_what_is_placed_is_patched(tmp_path):
    """The registers alone, placed: one of their block RAMs holds the settings as expected."""
    board = load_board("ulx3s")
    write_headers(board, tmp_path)
    (tmp_path / "small.v").write_text(SMALL)
    (tmp_path / "small.lpf").write_text("")
    for path in [*(ROOT / "rtl").glob("*.v"), *(ROOT / "rtl").glob("*.vh")]:
        shutil.copy(path, tmp_path)
    sources = " ".join(path.name for path in sorted(tmp_path.glob("*.v")))
    script = (
        f"read_verilog -defer -DWH_BOARD_ROM -I. {sources}; hierarchy -check -top small; "
        f"{synthesis_command('ecp5', '25k')} -top small -json small.json"
    )
    run("yosys", ["-q", "-p", script], tmp_path)
    run(
        "nextpnr-ecp5",
        ["--25k", "--package", "CABGA381", "--json", "small.json", "--lpf", "small.lpf",
         "--lpf-allow-unconstrained", "--textcfg", "small.config"],
        tmp_path,
    )  # fmt: skip
    run("ecppack", ["--compress", "small.config", "small.bit"], tmp_path)
    result = invoke(
        tmp_path / "small.bit", scene(tmp_path, *CHANGES), "--board", "ulx3s", "--out",
        tmp_path / "new.bit",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    run("ecpunpack", ["new.bit", "new.config"], tmp_path)
    wanted = memory_words(load_board("ulx3s", scene_path=tmp_path / "mine.toml").words())
    assert wanted in [words[:256] for words in held((tmp_path / "new.config").read_text()).values()]
