# SPDX-License-Identifier: Apache-2.0
"""What is flashed is what is simulated: whole boards as they were placed, with the motor."""

from __future__ import annotations

import json
import math
import re
import subprocess
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from wavehaptics.fpga.boards import Board, BoardError, board_names, load_board
from wavehaptics.ladder import sampled
from wavehaptics.ladder.linked_pins import ANSWER_BYTES
from wavehaptics.ladder.run import measure
from wavehaptics.laws import closed_forms
from wavehaptics.runtime.repository import CELLS, ROOT
from wavehaptics.runtime.toolchain import Toolchain
from wavehaptics.scene import Scene, load_device
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats
from wavehaptics.words.table import WORDS
from wavetools.fpga import board_runs, placed, synthesis
from wavetools.fpga.board_arm import ArmOnBoard, MotorsOnBoard
from wavetools.fpga.board_simulation import (
    BoardSimulation,
    Build,
    Report,
    bench,
    board_scene,
    build,
    on_board,
)
from wavetools.fpga.synthesis import SynthesisError

PRESS_S = 0.012
HARD = ("hand.path=taps", "hand.frequency_hz=40", "hand.amplitude_rad=0.05", "hand.stiffness=0.4",
        "adc.noise_a=1e-3")  # fmt: skip
"""A wall that is reached within PRESS_S."""


@pytest.fixture(scope="module")
def tools() -> Toolchain:
    return Toolchain.of_environment()


def advanced(simulation: BoardSimulation, seconds: float) -> np.ndarray:
    ticks = round(seconds / simulation.tick_s)
    rows = np.zeros((ticks, len(Column)))
    simulation.advance(rows, np.zeros((ticks, len(Word)), dtype=np.int64))
    return rows


def shown(built: Build) -> list[Report]:
    """What the pins show from power-up, over the button's bounces, into the wall, and after stop.

    The encoder's cells in the wall and the running light are looked at on the way.
    """
    simulation = on_board(built, board_scene(built.board, HARD))
    reports, deepest = [simulation.report()], 0.0
    for _ in range(12):
        deepest = max(deepest, advanced(simulation, PRESS_S / 12)[:, Column.X].max())
        reports.append(simulation.report())
    assert deepest > 4 * simulation.settings.cell_rad
    assert reports[-1].running
    simulation.stop()
    advanced(simulation, 1e-4)
    reports.append(simulation.report())
    assert not reports[-1].running
    return reports


def refuses_other_settings(built: Build) -> None:
    for setting in ("controller.lambda=2e4", "controller.walls=[[0.1, 100.0]]"):
        with pytest.raises(BoardError, match="other settings than the bitstream"):
            on_board(built, board_scene(built.board, (setting,)))


def taps(built: Build) -> None:
    """The stiffness of the first contact, as `golden` renders it.

    Whether a tap's deepest point is one cell of the encoder deeper is the ADC's noise's to say, and
    by the time that its gates go on a board has had other noise: it's one draw more of it.
    """
    scene = board_runs.tap(built.board)
    ideal, drawn = board_runs.without_edges(scene), []
    with pytest.MonkeyPatch.context() as patch:
        for seed in range(24):
            patch.setattr(sampled, "NOISE_SEED", seed)
            drawn.append(measure(ideal, "golden", compare=False)["stiffness"])
    assert max(drawn) < 1.03 * min(drawn)
    found = board_runs.run(built, scene)
    assert 0.995 * min(drawn) < found["stiffness"] < 1.005 * max(drawn)
    assert found["stiffness"] > 0.9 * found["stiffness_predicted"]
    assert_quiet(found["pins"])


def obeys_the_line(built: Build) -> None:
    """Armed over it; walls that it moves are felt there; a 0 ends it, and so does silence."""
    motors = built.board.fpga.motors
    board = MotorsOnBoard(built, board_scene(built.board, HARD), motors)
    assert board.received()[:2] == b"\x01\x10"
    board.advance(1e-4)
    assert board.report().running
    (face, _), *_ = built.board.words().ports.walls
    cells = 40
    for motor in range(motors):
        assert len(board.write(WORDS["wall_min"].at(motor), [face + cells])) == ANSWER_BYTES
    rows = board.advance(PRESS_S)
    for found in rows:
        pushed = found[np.abs(found[:, Column.TORQUE]) > 2e-3, Column.X]
        assert pushed.min() > (cells - 1) * board.settings.cell_rad
    assert board.report().running
    assert len(board.write(WORDS["arm"].at(), [0])) == ANSWER_BYTES
    assert not board.report().running
    assert len(board.write(WORDS["arm"].at(), [1])) == ANSWER_BYTES
    board.advance(2e-3)
    assert board.report().running
    board.advance(0.2)
    assert not board.report().running
    assert_quiet(asdict(board.report()) | {"running": True, "apart": 0})


BEYOND_CELLS = 0.25
"""By which `golden` misses the promised count with all errors negative.

There the rotor rests at 1.22 to 1.24 counts: at the end of the anchor's zone, which leads by a
quarter of a count.
"""


def at_rest(board: Board, held: dict[str, Any], beyond: float = 0.0) -> None:
    """A press of the whole torque, within a count and 1 % of the depth, and quiet."""
    assert held["held_nm"] == pytest.approx(board_runs.PRESS_NM[board.brushless], rel=0.03)
    assert held["moved_cells"] <= held["moved_limit_cells"] + beyond
    assert held["hold_ripple_rms"] <= board_runs.QUIET_NM


def golden_hold(board: Board, scene: Scene) -> dict[str, Any]:
    held = measure(board_runs.without_edges(scene), "golden", compare=False)
    return held | board_runs.moved(board, held, np.zeros(len(Column)))


HOP_PART = 0.012
"""Ripple of a hold with a hop, of the press at most; a hand feels 7 %."""

FAST_HZ = 100e3
"""Least control rate at which a hop is as small as that; test_power_boards.py has slower boards."""


def with_other_noise(scene: Scene) -> Scene:
    """The same but for each sample's noise: a 500th more of it."""
    assert scene.adc is not None
    noise_a = 1.002 * scene.adc.noise_a
    return scene.model_copy(update={"adc": scene.adc.model_copy(update={"noise_a": noise_a})})


def holds(built: Build, sign: int) -> None:
    """14 mN·m with all that may be wrong with a motor: at rest where the spring says, as `golden`.

    Where in the zone depends on the tick in which the hand arrives.
    """
    scene = board_runs.hold(built.board, sign)
    at_rest(built.board, golden_hold(built.board, scene), BEYOND_CELLS * (sign < 0))
    found = board_runs.run(built, scene)
    at_rest(built.board, found)
    assert_quiet(found["pins"])


APART = 0.05
"""Part of the clocks in which several motors' gates may differ.

They all see the same motor, but each port looks at the encoder in its own turn: where an edge comes
between two turns, one port has it a period later.
"""


def assert_quiet(pins: dict[str, int]) -> None:
    assert pins["running"]
    assert not pins["fault"]
    assert pins["both_on"] == pins["idle_on"] == pins["irregular"] == 0
    assert pins["apart"] <= APART * pins["clocks"]


def as_its_sources(board: Board, tools: Toolchain) -> Build:
    """A board's placed netlist, which is its sources at each clock of all pins."""
    # In a folder of its own: other tests make the board's bitstream anew.
    out = synthesis.OUT / f"{board.made}-simulated"
    synthesis.build_board(board, tools, out=out)
    netlist = build(board, tools, synth=out)
    reports = shown(netlist)
    assert reports == shown(build(board, tools, netlist=False, synth=out))
    assert len({report.seen for report in reports}) == len(reports)
    last = reports[-1]
    assert last.both_on == last.idle_on == last.irregular == 0
    assert last.apart <= APART * last.clocks
    refuses_other_settings(netlist)
    return netlist


@pytest.mark.long
def test_what_is_flashed_for_a_brushless_motor(tools):
    """Once its magnets are found: the wall's stiffness, and the wall held where it is.

    R̂ and the drive's gain are off, and the sensors' zero, which is measured before the gates go on.
    In a tap, before c has learned what R̂ lacks of R, the spring is between those of the two.
    """
    netlist = as_its_sources(load_board("ulx3s_brushless"), tools)
    board = netlist.board
    motor, ports = board.scene.motor, board.words().ports
    timing, words = ports.timing, ports.settings
    tau = timing.tick_s / (words.a * formats.A.step) + timing.extra_ticks * timing.tick_s
    soft, hard = (
        closed_forms.brushless_k_l(
            motor.pole_pairs, motor.psi_vs, closed_forms.l_eff(motor.L_h, ohm, tau)
        )
        for ohm in (motor.R_ohm, words.r_hat)
    )
    assert 0.96 < soft / hard < 1.0
    found = board_runs.run(netlist, board_runs.tap(board))
    assert 0.99 * soft < found["stiffness"] < 1.01 * hard
    assert_quiet(found["pins"])
    held = board_runs.run(netlist, board_runs.hold(board))
    at_rest(board, held)
    assert_quiet(held["pins"])


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["icebreaker", "ulx3s", "ulx3s_three", "hx8k", "ulx3s/sigma_delta.toml"]
)
def test_what_is_flashed(name, tools):
    """The placed netlist is its sources at each clock of all pins, and does what they promise."""
    name, _, scene = name.partition("/")
    path = ROOT / "boards" / name / scene if scene else None
    netlist = as_its_sources(load_board(name, scene_path=path), tools)
    board = netlist.board
    assert board.scene.controller.anchored, "a bridge's dead time alone takes a plain wall away"
    taps(netlist)
    if board.fpga.link:
        obeys_the_line(netlist)
    holds(netlist, 1)
    holds(netlist, -1)


COUNT_M = 0.02 * 2 * math.pi / 10_000
"""A count at the tip of the levers below, m."""

ARM = """
[scene]
name = "oblique"
duration_s = 1.0
[device]
kinematics = "matrix"
jacobian = [[0.02, 0, 0], [0, 0.02, 0], [0, 0, 0.02]]
[[surface]]
shape = "plane"
point_m = [-0.866025e-3, -0.353553e-3, -0.353553e-3]
normal = [0.866025, 0.353553, 0.353553]
[controller]
tick_hz = 132e3
lambda = 1e4
[hand]
path = "slide"
direction = [-0.866025, -0.353553, -0.353553]
amplitude_m = 0.0029
across = [-0.5, 0.612372, 0.612372]
slide_m = 0.004
frequency_hz = 5
stiffness_n_per_m = 500
damping_n_s_per_m = 3
[[motors]]
preset = "re25-118743"
[[motors]]
preset = "re25-118743"
[[motors]]
preset = "re25-118743"
"""
"""A plane whose normal is 30° from the first axis, 1 mm from the tip, and a hand along it."""


@pytest.mark.long
def test_what_is_flashed_slides_along_an_oblique_plane(tmp_path, tools):
    """Three motors at the placed netlist: 1/Σ G_n²/K_n along the normal, and nothing across it."""
    board = load_board("ulx3s_space")
    out = synthesis.OUT / f"{board.name}-simulated"
    synthesis.build_board(board, tools, out=out)
    slides(build(board, tools, synth=out), tmp_path)


def slides(built: Build, folder: Path) -> None:
    """4 mm along the plane and back under a press of 0.8 N."""
    path = folder / "oblique.toml"
    path.write_text(ARM)
    space = load_device(path).space
    scene = board_scene(built.board, ("hand.stiffness=1e-6", "hand.damping=0", "adc.noise_a=1e-3"))
    board = ArmOnBoard(built, scene, space)
    assert all(answer[:2] == b"\x01\x10" for answer in board.write_surfaces(1))
    rows = board.advance(0.3)
    time, x = rows[0, :, Column.T], rows[:, :, Column.X]
    normal, along = (np.array(space.hand.direction), np.array(space.hand.across))
    tip, force = 0.02 * x, rows[:, :, Column.TORQUE] / 0.02
    slid = time > 0.1
    depth, push = normal @ tip - 1e-3, -(normal @ force)
    # Half a count of the press is what the anchors leave.
    wanted = board.host.stiffest(0, np.zeros(3))
    found = push[slid].mean() / depth[slid].mean()
    assert found == pytest.approx(wanted, rel=0.5 * COUNT_M / depth[slid].mean())
    assert np.abs(depth - push / wanted)[slid].max() < 2 * COUNT_M
    assert np.ptp((along @ tip)[slid]) == pytest.approx(0.004, rel=0.03)
    across = force + np.outer(normal, push)
    assert np.sqrt((across[:, slid] ** 2).sum(axis=0).mean()) < 0.06 * push[slid].mean()
    assert_quiet(asdict(board.report()) | {"apart": 0})


# --- Without a bitstream.


def fast_with_brushes(name: str) -> bool:
    board = load_board(name)
    return not board.brushless and board.scene.controller.tick_hz >= FAST_HZ


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("name", [name for name in board_names() if fast_with_brushes(name)])
def test_a_wall_is_held_with_all_that_may_be_wrong(name, sign):
    """The press of what is flashed on the integers: at rest where the spring says.

    In one hold of five the rotor still hops by a count where it is judged: in no two of a board.
    """
    board = load_board(name)
    scene = board_runs.hold(board, sign)
    held = golden_hold(board, scene)
    if held["hold_ripple_rms"] > board_runs.QUIET_NM:
        assert held["hold_ripple_rms"] <= HOP_PART * board_runs.PRESS_NM[False]
        held = golden_hold(board, with_other_noise(scene))
    at_rest(board, held, BEYOND_CELLS * (sign < 0))


@pytest.mark.parametrize("sign", [1, -1])
def test_a_brushless_motor_is_held_whatever_its_angle_is(sign, monkeypatch):
    """The press of what is flashed on the integers, at eight angles of the magnets.

    Of the start, the measured zero and the magnets that were found are what is left.
    """
    board = load_board("ulx3s_brushless")
    for n in range(8):
        magnet = 2 * math.pi * n / 8 / board.scene.motor.pole_pairs
        monkeypatch.setattr(board_runs, "MAGNET_RAD", magnet)
        scene = board_runs.hold(board, sign)
        control = {"find_magnet": False, "magnet_hat_rad": magnet}
        scene = scene.model_copy(
            update={
                "controller": scene.controller.model_copy(update=control),
                "adc": scene.adc.model_copy(update={"offset_a": 0.0}),
            }
        )
        at_rest(board, golden_hold(board, scene))


def test_a_bitstream_of_other_settings_is_refused(tmp_path, tools):
    board = load_board("icebreaker")
    folder = tmp_path / synthesis.OUT / board.name
    folder.mkdir(parents=True)
    moved = type(board)(board.name, tmp_path, board.fpga, board.device, board.scene)
    with pytest.raises(BoardError, match="make bitstream BOARD=icebreaker"):
        build(moved, tools)
    (folder / f"{board.name}{synthesis.PLACED_NETLIST}").write_text("{}")
    (folder / "wh_board_settings.vh").write_text("`define WH_BOARD_N 1\n")
    with pytest.raises(BoardError, match=r"settings than those of boards/icebreaker/board\.toml"):
        build(moved, tools)


def test_a_board_that_cant_be_simulated_is_refused():
    with pytest.raises(BoardError, match=r"icebreaker: its top has no pin for .*clk.*running"):
        bench(load_board("icebreaker"), {"enc_a": "input", "stop": "input"})


@pytest.mark.parametrize("name", board_names())
def test_each_board_has_the_pins_of_a_simulation(name):
    """Start is one of them wherever its button is, and a reset that nobody presses."""
    board = load_board(name)
    text = (ROOT / board.folder / f"{name}.v").read_text()
    ports = {
        port: direction
        for direction, port in re.findall(
            r"^ +(input|output) +wire +(?:\[[^\]]*\] +)?(\w+)", text, re.MULTILINE
        )
    }
    made = bench(board, ports)
    (start,) = [port for port in ports if re.fullmatch(r"(button_)?start(_n)?", port)]
    assert f".{start} ({'!' if start.endswith('_n') else ''}start)" in made
    assert (".button_reset_n (1'b1)" in made) == ("button_reset_n" in ports)
    resets = re.search(r"(locked && |\.reset_n_i +\()button_reset_n\)", text)
    assert (resets is not None) == ("button_reset_n" in ports)


MEMORY = """\
module memory (input wire clk, input wire write, input wire [{address}:0] at,
               input wire [{address}:0] from, input wire [{bit}:0] data, output reg [{bit}:0] out);
    (* ram_style = "block", no_rw_check *) reg [{bit}:0] ram [0:{last}];
    integer n;
    initial for (n = 0; n <= {last}; n = n + 1) ram[n] = {bits}'d{step} * n + {bits}'d{first};
    always @(posedge clk) begin
        if (write) ram[at] <= data;
        out <= ram[from];
    end
endmodule
"""

COMPARED = """\
`timescale 1ns / 1ps
module compared;
    reg clk = 0, write = 0;
    reg [{address}:0] at = 0, from = 0;
    reg [{bit}:0] data = 0;
    wire [{bit}:0] out, wanted;
    integer n, wrong = 0, changes = 0;
    memory placed (.clk (clk), .write (write), .at (at), .from (from), .data (data), .out (out));
    source source (.clk (clk), .write (write), .at (at), .from (from), .data (data), .out (wanted));
    initial begin
        for (n = 0; n < 6000; n = n + 1) begin
            write = $random; at = $random; data = $random;
            from = $random;
            if (from == at) from = ~at;
            #5 clk = 1;
            #5 clk = 0;
            if (out !== wanted) wrong = wrong + 1;
            if (^wanted) changes = changes + 1;
        end
        $display("%0d wrong, %0d odd", wrong, changes);
    end
endmodule
"""


@pytest.mark.parametrize(("words", "bits"), [(512, 36), (1024, 18), (2048, 9), (4096, 4)])
def test_a_block_ram_is_what_its_source_says(tmp_path, tools, words, bits):
    """As Yosys maps it, with its contents, beside the source; not read where it is written."""
    sizes = {"address": words.bit_length() - 2, "bit": bits - 1, "bits": bits, "last": words - 1,
             "step": min(7, 2**bits - 1), "first": 2}  # fmt: skip
    source = MEMORY.format(**sizes)
    (tmp_path / "memory.v").write_text(source)
    script = "read_verilog memory.v; synth_ecp5 -top memory -json memory.json"
    assert tools.run("yosys", ["-p", script], tmp_path, tmp_path / "yosys.log") == 0
    top = json.loads((tmp_path / "memory.json").read_bytes())["modules"]["memory"]
    rams = [cell for cell in top["cells"].values() if cell["type"] == "DP16KD"]
    assert {int(ram["parameters"]["DATA_WIDTH_B"], 2) for ram in rams} == {bits}
    assert any("1" in value for key, value in rams[0]["parameters"].items() if "INITVAL" in key)
    plain = {name: placed._plain_cell(cell) for name, cell in top["cells"].items()}
    module = {"ports": top["ports"], "cells": plain, "netnames": {}}
    (tmp_path / "plain.json").write_text(json.dumps({"modules": {"memory": module}}))
    script = "read_json plain.json; write_verilog -noattr -noexpr plain.v"
    assert tools.run("yosys", ["-p", script], tmp_path, tmp_path / "write.log") == 0
    (tmp_path / "compared.v").write_text(
        COMPARED.format(**sizes) + source.replace("module memory", "module source")
    )
    assert len(rams) == len(plain) == 1
    files = ["compared.v", "plain.v", str(CELLS / "dp16kd.v")]
    subprocess.run(
        ["iverilog", "-o", "compared", "-s", "compared", *files], cwd=tmp_path, check=True
    )
    said = subprocess.run(["vvp", "-n", "compared"], cwd=tmp_path, check=True, capture_output=True)
    found = re.fullmatch(r"(\d+) wrong, (\d+) odd\s*", said.stdout.decode())
    assert found is not None, said.stdout
    assert int(found[1]) == 0
    assert 2000 < int(found[2]) < 4500


def cell(kind: str, **parameters: str) -> dict:
    return {
        "type": kind, "parameters": parameters, "attributes": {},
        "port_directions": {"B": "inout", "O": "output"}, "connections": {"B": [2], "O": [3]},
    }  # fmt: skip


def test_registers_in_a_pad_are_those_of_any_bank():
    """A bank with gears has another cell, of which a plain register uses what all have."""
    kept = {"CLK": [2], "CE": [3], "LSR": [4], "TXDATA0": [5], "IOLDO": [6]}
    extra = {"ECLK": [], "DQSW270": [], "WRPNTR0": [], "TXDATA3": [], "SLIP": [], "RXDATA6": []}
    geared = {
        "type": "IOLOGIC",
        "parameters": {"MODE": "IREG_OREG", "OUTREG.OUTREGMODE": "FF", "MODDRX.MODE": "NONE",
                       "MIDDRX_MODDRX.WRCLKMUX": "NONE", "CLKOMUX": "CLK", "IOLTOMUX": "NONE"},
        "port_directions": dict.fromkeys([*kept, *extra], "input") | {"IOLDO": "output"},
        "connections": kept | extra,
    }  # fmt: skip
    plain = placed._plain_cell(geared)
    assert (plain["type"], plain["connections"]) == ("SIOLOGIC", kept)
    assert plain["parameters"] == {"MODE": "IREG_OREG", "OUTREG_OUTREGMODE": "FF"}


@pytest.mark.parametrize(
    ("cells", "says"),
    [
        ({"alu": cell("ALU54B")}, "no model of the placed cell ALU54B"),
        ({"ff": cell("TRELLIS_FF", INIT_0="01")}, "no model of a placed TRELLIS_FF with contents"),
        ({"pad": cell("TRELLIS_IO", DIR="BIDIR")}, "no model of the placed pad"),
        ({"pad": cell("TRELLIS_IO", DIR="OUTPUT")}, "no model of the placed pad"),
    ],
)
def test_a_cell_without_a_model_is_refused(tools, cells, says):
    """A pad's direction is the top's."""
    folder = ROOT / "build" / "netlists" / "test"
    folder.mkdir(parents=True, exist_ok=True)
    made = folder / "made.json"
    top = {"ports": {"a": {"direction": "input", "bits": [2]}}, "cells": cells}
    made.write_text(json.dumps({"modules": {"top": top}}))
    with pytest.raises(SynthesisError, match=says):
        placed.placed_verilog(
            "test", "ecp5", made.relative_to(ROOT), folder.relative_to(ROOT), tools
        )
