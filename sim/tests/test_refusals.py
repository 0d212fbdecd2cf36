# SPDX-License-Identifier: Apache-2.0
"""What a controller can't do is refused before anything runs, in one line that says where."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner
from wavehaptics.cli.main import app
from wavehaptics.controller.ports import controller_ports
from wavehaptics.fpga.boards import load_board
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.refusals import check
from wavehaptics.scene import SceneError, find_scene, load_scene

SCENE = """\
[scene]
name = "odd"
duration_s = 0.001

[motor]
preset = "re25-118743"

[drive]
bus_v = 12.0

[controller]
tick_hz = 1e6
extra_ticks = 2
lambda = 1e4
walls = [[0.0, 1.0]]
"""
WALLS = f"[{', '.join(f'[{n}.0, {n}.5]' for n in range(17))}]"


@pytest.fixture
def odd(tmp_path: Path) -> Path:
    path = tmp_path / "odd.toml"
    path.write_text(SCENE)
    return path


def changed(path: Path, key: str, value: str) -> int:
    """Put a key into the scene's file: the line on which it stands then."""
    table, name = key.split(".")
    lines = path.read_text().splitlines()
    lines = [line for line in lines if not line.startswith(f"{name} =")]
    if f"[{table}]" not in lines:
        lines.append(f"[{table}]")
    line = lines.index(f"[{table}]") + 1
    lines.insert(line, f"{name} = {value}")
    path.write_text("\n".join(lines))
    return line + 1


@pytest.mark.parametrize(
    ("controller", "key", "value"),
    [
        ("pins", "drive.pwm_hz", "700e3"),
        ("pins", "drive.pwm_hz", "1e7"),
        ("pins", "drive.dead_time_s", "1e-5"),
        ("pins", "drive.dead_time_s", "1e-9"),
        ("pins", "drive.min_pulse_s", "1e-6"),
        ("pins", "controller.extra_ticks", "0"),
        ("pins", "controller.clock_hz", "20e6"),
        ("pins", "controller.walls", WALLS),
        ("golden", "controller.walls", "[[0.0, 1e-12]]"),
        ("golden", "controller.lambda", "1e-3"),
        ("golden", "scene.duration_s", "1e7"),
        ("analog", "shaper.sos", "[[0.5, 0.0, 0.0, 1.0, 0.0, 0.0]]"),
        ("golden", "shaper.sos", "[[0.5, 0.0, 0.0, 1.0, 0.0, 2.0]]"),
        ("encoder", "servo.rate_hz", "700"),
        ("encoder", "servo.amplifier_hz", "3e5"),
    ],
)
def test_a_refusal_names_the_line_of_its_cause(odd, controller, key, value):
    """In the file, or on the command line where it came from there."""
    override = f"{key}={value}"
    with pytest.raises(SceneError, match=rf"^--set {re.escape(override)}: ") as on_the_line:
        check(load_scene(odd, (override,)), controller)
    line = changed(odd, key, value)
    if key.startswith("shaper."):
        line -= 1  # the whole table
    with pytest.raises(SceneError) as in_the_file:
        check(load_scene(odd), controller)
    assert str(in_the_file.value) == str(on_the_line.value).replace(
        f"--set {override}", f"{odd}:{line}", 1
    )
    assert "\n" not in str(in_the_file.value)


def test_a_wall_that_no_count_is_in_is_refused(odd):
    changed(odd, "encoder.counts_per_rev", "400")
    between = ("controller.walls=[[0.0, 1.0], [2.001, 2.002]]",)
    with pytest.raises(
        SceneError, match=r"walls: \[2\.001, 2\.002\] lies between two counts of 0\.0157"
    ):
        check(load_scene(odd, between), "golden")
    check(load_scene(odd, ("controller.walls=[[0.0, 1.0], [2.001, 2.02]]",)), "golden")


def test_a_board_is_named_where_it_can_do_less_than_its_controller():
    scene = load_scene(find_scene("brushless_soft"))
    refuse(scene, "pins")
    with pytest.raises(SceneError, match=r"\[shaper\] is not for a board; with a brushless motor"):
        refuse(scene, "pins", device=True)


def test_a_default_is_to_blame_only_where_nothing_else_is(odd):
    """`extra_ticks` isn't written, so it is the table's line."""
    odd.write_text(SCENE.replace("extra_ticks = 2\n", ""))
    check(load_scene(odd), "pins")
    line = odd.read_text().splitlines().index("[controller]") + 1
    scene = load_scene(odd)
    error = scene.refusal("no", "controller.extra_ticks")
    assert str(error) == f"{odd}:{line}: no"
    assert str(scene.refusal("no", "servo.rate_hz")) == f"{odd}:1: no"
    assert str(scene.refusal("no", "servo.rate_hz", "controller.lambda")).startswith(
        f"{odd}:{line + 2}: "
    )


def test_the_same_scene_elsewhere_is_the_same(odd, tmp_path):
    other = tmp_path / "other.toml"
    other.write_text("\n" + SCENE)
    assert load_scene(odd) == load_scene(other)
    assert load_scene(odd) != load_scene(other, ("controller.lambda=2e4",))


def test_a_boards_scene_is_refused_with_its_line():
    board = load_board("ulx3s")
    path = board.root / board.folder / "board.toml"
    asking = replace(board, scene=load_scene(path, ("drive.bus_measured=true",)))
    with pytest.raises(SceneError, match=r"^--set drive\.bus_measured=true: drive\.bus_measured"):
        asking.words()
    walls = replace(board, scene=load_scene(path, (f"controller.walls={WALLS}",)))
    with pytest.raises(SceneError, match=r"controller\.walls has 17 walls"):
        walls.words()


def run(*arguments: str) -> tuple[int, str, str]:
    found = CliRunner().invoke(app, [*arguments])
    return found.exit_code, found.stdout, str(found.exception or "")


def test_check_is_the_check_of_run(odd):
    """Without a controller what each can't do is told, and it is refused where none can."""
    assert run("check", str(odd))[:2] == (0, f"{odd}: ok\n")
    changed(odd, "drive.pwm_hz", "700e3")
    status, told, _ = run("check", str(odd))
    assert status == 0
    assert told.startswith(f"{odd}: ok\nnot on `pins`: {odd}:")
    status, _, problem = run("check", str(odd), "--controller", "pins")
    assert status
    assert "drive.pwm_hz" in problem
    status, _, problem = run("check", str(odd), "--set", "controller.lambda=1e-9")
    assert status
    assert "lambda" in problem


def test_nothing_is_left_of_a_refused_run(odd, tmp_path):
    out = tmp_path / "out"
    status, _, problem = run(
        "run", str(odd), "--controller", "analog", "--out", str(out),
        "--set", "shaper.sos=[[0.5, 0.0, 0.0, 1.0, 0.0, 0.0]]",
    )  # fmt: skip
    assert status
    assert "[shaper]" in problem
    assert not out.exists()


def test_a_carrier_that_sets_the_tick_is_told(odd):
    status, told, _ = run(
        "check", str(odd), "--controller", "pins", "--set", "drive.pwm_hz=100e3",
        "--set", "controller.extra_ticks=1",
    )  # fmt: skip
    assert status == 0
    assert "`pins` ticks at 200000 Hz, with its carrier" in told
    assert "ticks at" not in run("check", str(odd), "--controller", "pins")[1]


@pytest.mark.parametrize(("pwm_hz", "ticks"), [(500e3, 256), (100e3, 64)])
def test_a_hosts_period_is_of_the_ticks_that_there_are(odd, pwm_hz, ticks):
    """4 kHz to the nearest power of two, also where the carrier sets the tick."""
    scene = load_scene(odd, ("host.rate_hz=4e3", f"drive.pwm_hz={pwm_hz}"))
    ports = controller_ports(scene)
    rate_hz = 1.0 / (ports.timing.tick_s * 2.0 ** ports.words["host_period_log2"])
    assert 2.0 ** ports.words["host_period_log2"] == ticks
    assert 4e3 / 2**0.5 <= rate_hz <= 4e3 * 2**0.5


def test_no_cells_no_lingering(odd):
    with pytest.raises(SceneError, match=r"edge_hysteresis is of an encoder's cells; give"):
        load_scene(odd, ("controller.edge_hysteresis=true",))
