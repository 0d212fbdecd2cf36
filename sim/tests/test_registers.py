# SPDX-License-Identifier: Apache-2.0
"""`wavehaptics registers`: each format, read by its own language, holds the scene's settings."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from test_cli import call
from wavehaptics.controller.ports import Ports, controller_ports
from wavehaptics.fpga.board_words import LINKED_WALLS, turns_of
from wavehaptics.fpga.boards import load_board
from wavehaptics.fpga.scene_registers import COMMANDS, scene_registers
from wavehaptics.ladder.brushless import magnet_words
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import Scene, SceneError, find_scene, load_scene
from wavehaptics.words import table
from wavehaptics.words.memory import apart
from wavehaptics.words.table import WORDS

CC = shutil.which("cc") or shutil.which("gcc")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")

SLOW = ("controller.tick_hz=400e3", "controller.extra_ticks=2")
"""Ticks that are long enough for three motors."""

FOUR = ("controller.clock_hz=76.8e6", "controller.tick_hz=150e3", "drive.pwm_hz=150e3")
"""Ticks that are long enough for four brushless motors."""

SHAPED = ("shaper.feel=spring", "shaper.stiffness=0.45", "shaper.damping=0.2e-3",
          "shaper.walls=[0]")  # fmt: skip

CASES: dict[str, tuple[str, tuple[str, ...], int]] = {
    "plain": ("press_hold", (), 1),
    "anchored": ("held_wall", (), 1),
    "host": ("hosted_wall", (), 1),
    "walls": ("press_hold", ("controller.walls=[[0.0,0.5],[0.7,0.9]]",), 1),
    "shaped": ("press_hold", (*SHAPED, "controller.extra_ticks=2"), 1),
    "three": ("press_hold", SLOW, 3),
    "brushless": ("brushless_hold", (), 1),
    "four brushless": ("brushless_hold", FOUR, 4),
    "sigma-delta": (
        "press_hold",
        ("adc.part=AD7403", "adc.bits=16", "controller.extra_ticks=4"),
        1,
    ),
}

C_PROGRAM = """\
#include <stdio.h>
#include "wavehaptics.h"
#include "scene.h"
int main(void) {
#define ROW(NAME, motor, index, address, raw, value, unit) \\
    printf("%u %u %u %u %u %.17g %s\\n", (unsigned)WH_WORD_##NAME, motor, index, address, raw, \\
           value, unit);
    WH_SCENE_REGISTERS(ROW)
#define PARAMETER(NAME) printf(#NAME " %d\\n", WH_SCENE_##NAME);
    @
    return 0;
}
"""

BENCH = """\
`include "scene.vh"
module bench;
    reg [43:0] rows [0:`WH_SCENE_COUNT-1];
    integer n;
    initial begin
`define WH_SCENE_WRITE(NUMBER, ADDRESS, RAW) rows[NUMBER] = {ADDRESS, RAW};
`include "scene.vh"
        for (n = 0; n < `WH_SCENE_COUNT; n = n + 1) begin
            $display("%0d %0d", rows[n][43:32], rows[n][31:0]);
        end
        @
    end
endmodule
"""


def _scene(case: str) -> Scene:
    name, overrides, _ = CASES[case]
    return load_scene(find_scene(name), overrides)


def _expected(scene: Scene, ports: Ports, motors: int) -> dict[tuple[str, int, int], int]:
    """What (name, motor, index) must be, from the settings of the scene."""
    set_, places = ports.settings, max(LINKED_WALLS, len(ports.walls))
    shaped = [int(one) for one in set_.shaped]
    values = apart(
        {
            **ports.words,
            **set_.words(),
            **ports.wall_words(places),
            "wall_shaped": shaped + [0] * (places - len(shaped)),
            **(magnet_words(scene, set_, ports.start_count) if scene.motor.brushless else {}),
        }
    )  # fmt: skip
    found = {}
    for name, raws in values.items():
        word, legs = WORDS[name], 3 if scene.motor.brushless else 2
        for motor in word.port_numbers(motors, legs):
            for index, raw in enumerate([raws] if isinstance(raws, int) else raws):
                found[name, motor, index] = int(raw) & 0xFFFFFFFF
    return found


def _written(capsys, monkeypatch, case: str, form: str, out: Path) -> None:
    name, overrides, motors = CASES[case]
    options = [option for one in overrides for option in ("--set", one)]
    status, told, error = call(
        capsys, monkeypatch, "registers", name, *options, "--motors", str(motors), "--format", form,
        "--out", str(out),
    )  # fmt: skip
    assert (status, error) == (0, "")
    assert re.fullmatch(rf"{re.escape(str(out))}: \d+ registers of \S+\n", told)


@pytest.fixture(params=CASES)
def case(request) -> str:
    return request.param


def _check(case: str, rows: dict[int, int]) -> None:
    """The raw values by address are those of the scene's settings, with nothing else but limits."""
    scene, motors = _scene(case), CASES[case][2]
    turns = turns_of(motors, 3 if scene.motor.brushless else 2, linked=True)
    ports = controller_ports(scene, turns=turns)
    expected = {
        WORDS[name].at(motor, index): raw
        for (name, motor, index), raw in _expected(scene, ports, motors).items()
    }
    # What needs motors, or a sense path, besides the scene.
    own = {WORDS[name].at() for name in ("hold_ticks", "zero_limit", "trip")}
    guard = {word.at() for word in table.ports()["guard"]}
    assert rows.keys() - expected.keys() - own == guard
    assert {at: raw for at, raw in expected.items() if at not in own} == {
        at: raw for at, raw in rows.items() if at in expected and at not in own
    }
    assert len(expected) > 60


def test_json_by_the_register_map(capsys, monkeypatch, tmp_path, case):
    _written(capsys, monkeypatch, case, "json", tmp_path / "scene.json")
    found = json.loads((tmp_path / "scene.json").read_text(encoding="utf-8"))
    rows = {}
    for row in found:
        word = WORDS[row["name"]]
        assert list(row) == ["name", "motor", "index", "address", "raw", "value", "unit"]
        assert row["address"] == word.at(row["motor"], row["index"])
        assert row["unit"] == word.row.unit
        assert round(row["value"] * 2**word.fixed.fraction) & 0xFFFFFFFF == row["raw"]
        rows[row["address"]] = row["raw"]
    assert len(rows) == len(found)
    _check(case, rows)


@pytest.mark.skipif(CC is None, reason="there is no C compiler")
def test_c_as_compiled(capsys, monkeypatch, tmp_path, case):
    _written(capsys, monkeypatch, case, "c", tmp_path / "scene.h")
    made = scene_registers(_scene(case), CASES[case][2])
    names = " ".join(f"PARAMETER({name})" for name in made.parameters)
    commands = " ".join(f"PARAMETER(AT_{name.upper()})" for name in COMMANDS)
    (tmp_path / "show.c").write_text(C_PROGRAM.replace("@", f"{names} {commands}"))
    command = [CC, *STRICT, f"-I{ROOT / 'sim' / 'c'}", "show.c", "-o", "show"]
    subprocess.run(command, cwd=tmp_path, check=True)
    out = subprocess.run([tmp_path / "show"], capture_output=True, text=True, check=True).stdout
    by_number = [word.name for word in sorted(WORDS.values(), key=table.Word.at)]
    rows, given = {}, {}
    for line in out.splitlines():
        parts = line.split(" ")
        if not parts[0].isdigit():
            given[parts[0]] = int(parts[1])
            continue
        number, motor, index, address, raw = map(int, parts[:5])
        word = WORDS[by_number[number]]
        assert address == word.at(motor, index)
        assert round(float(parts[5]) * 2**word.fixed.fraction) & 0xFFFFFFFF == raw
        assert " ".join(parts[6:]) == word.row.unit
        rows[address] = raw
    assert given == made.parameters | {f"AT_{one.upper()}": WORDS[one].at() for one in COMMANDS}
    _check(case, rows)


@pytest.mark.skipif(CC is None, reason="there is no C compiler")
def test_c_of_another_register_map_is_refused(capsys, monkeypatch, tmp_path):
    _written(capsys, monkeypatch, "plain", "c", tmp_path / "scene.h")
    (tmp_path / "other.c").write_text('#define WH_WORDS_CRC 1u\n#include "scene.h"\n')
    command = [CC, *STRICT, "-c", "other.c"]
    found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert found.returncode != 0
    assert "another register map" in found.stderr


def test_verilog_as_a_bench_reads_it(capsys, monkeypatch, tmp_path, case):
    _written(capsys, monkeypatch, case, "verilog", tmp_path / "scene.vh")
    made = scene_registers(_scene(case), CASES[case][2])
    names = [*made.parameters, *(f"AT_{name.upper()}" for name in COMMANDS)]
    shown = " ".join(f'$display("{name} %0d", `WH_SCENE_{name});' for name in names)
    (tmp_path / "bench.v").write_text(BENCH.replace("@", shown))
    command = ["iverilog", "-g2005", "-Wall", "-Wno-timescale", "-o", "bench", "bench.v"]
    built = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (built.returncode, built.stderr) == (0, "")
    out = subprocess.run(
        ["vvp", "-n", "bench"], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout
    lines = [line.split() for line in out.splitlines()]
    given = {first: int(second) for first, second in lines if not first.isdigit()}
    assert given == made.parameters | {f"AT_{one.upper()}": WORDS[one].at() for one in COMMANDS}
    rows = {int(first): int(second) for first, second in lines if first.isdigit()}
    assert len(rows) + len(names) == len(lines)
    _check(case, rows)


@pytest.mark.parametrize("name", ["ulx3s", "ulx3s_three", "ulx3s_brushless"])
def test_a_boards_scene_gives_the_boards_parameters(name):
    """Of what its header says; its own converter and its empty walls aside."""
    board = load_board(name)
    header = board.headers()["wh_board_settings.vh"]
    made = scene_registers(board.scene, board.fpga.motors, board.fpga.sense.trip_a)
    renamed = {"MIN_PULSE": "SHORTEST"}
    for key, value in made.parameters.items():
        if key not in ("ADC", "WALLS"):
            assert f"`define WH_BOARD_{renamed.get(key, key)} {value}\n" in header, key
    trip = round(board.fpga.sense.trip_a / board.fpga.sense.full_scale_a * 2**15)
    assert [one.raw for one in made.registers if one.name == "trip"] == [trip]


REFUSED = {
    "no ADC": ("paper_taps", (), 1, "no [adc]"),
    "no encoder": ("damped", ("adc.bits=12", "adc.full_scale_a=2"), 1, "no [encoder]"),
    "servo": ("brushless_wall", (), 1, "[servo]"),
    "W of a brushless motor": ("brushless_soft", (), 1, "[shaper]"),
    "host of a brushless motor": ("brushless_hold", ("host.rate_hz=1e3",), 1, "[host]"),
    "a tick too short for two brushless ones": ("brushless_hold", (), 2, "is shorter than the 138"),
    "a tick too short for three": ("press_hold", ("controller.clock_hz=48e6",), 3,
                                  "a tick of 48 clocks is shorter than the 102"),
    "8 walls": ("press_hold", (f"controller.walls={[[n, n + 0.5] for n in range(8)]}",), 1,
                 "controller.walls"),
    "a measured bus": ("press_hold", ("drive.bus_measured=true",), 1, "drive.bus_measured"),
}  # fmt: skip


@pytest.mark.parametrize("why", REFUSED)
def test_what_registers_cannot_express_is_refused(why):
    name, overrides, motors, told = REFUSED[why]
    with pytest.raises(SceneError, match=re.escape(told)) as error:
        scene_registers(load_scene(find_scene(name), overrides), motors)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("paper_taps", "--format", "json"), "adc.bits and adc.full_scale_a"),
        (("press_hold", "--format", "toml"), "take one of c, verilog, json"),
        (("press_hold", "--format", "c", "--trip", "-1"), "above 0"),
        (("press_hold", "--format", "c", "--trip", "nan"), "above 0"),
        (("press_hold", "--format", "c", "--out", "a_file/none.h"), "name a file that can"),
        (("press_hold",), "--format"),
        (("nowhere", "--format", "c"), "nowhere"),
    ],
)
def test_one_line_and_status_2(capsys, monkeypatch, tmp_path, arguments, told):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a_file").touch()
    status, out, error = call(capsys, monkeypatch, "registers", *arguments)
    assert (status, out, error.count("\n")) == (2, "", 1)
    assert told in error


def test_without_a_file_it_is_printed(capsys, monkeypatch):
    status, out, _ = call(capsys, monkeypatch, "registers", "press_hold", "--format", "json")
    assert status == 0
    assert json.loads(out)[0]["name"] == "half_clocks"
