# SPDX-License-Identifier: Apache-2.0
"""Scenes of several motors: how they are read, what is refused, and that each runs as if alone."""

from __future__ import annotations

import json
import math
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_abilities import BASE, DRIVEN, ENCODER, KEYS, SENSED
from test_cli import call
from wavehaptics.fpga.scene_registers import scene_registers
from wavehaptics.ladder.run import run_device, run_scene
from wavehaptics.scene import (
    SCENES_DIR,
    Device,
    Scene,
    SceneError,
    find_scene,
    load_device,
    load_scene,
    shipped_scenes,
)
from wavehaptics.scene.device import SHARED, shared
from wavehaptics.trace.columns import load_trace

COMMON = """\
[encoder]
counts_per_rev = 10_000
[adc]
bits = 12
full_scale_a = 2.5
noise_a = 1e-3
[drive]
bus_v = 12
[hand]
path = "press"
amplitude_rad = 0.05
stiffness = 0.5
damping = 1e-3
[controller]
tick_hz = 250e3
lambda = 1e4
walls = [[0.0, 1.0], [2.0, 3.0]]
anchor_auto = true
"""
HEAD = '[scene]\nname = "arm"\nduration_s = 0.05\n'
SHOULDER = 'preset = "re40-148877"\nR_ohm = 1.3\n'
ELBOW = 'preset = "re25-118743"\n'
TEXT = (
    f"{HEAD}[[motors]]\nname = \"shoulder\"\n{SHOULDER}"
    "[motors.load]\ninertia_kgm2 = 2e-5\n[motors.encoder]\ncounts_per_rev = 4096\n"
    f"[[motors]]\n{ELBOW}controller.walls = [[0.001, 1.0]]\nfriction.coulomb_nm = 1e-4\n{COMMON}"
)  # fmt: skip
NAMES = ["shoulder", "motor_1"]
ALONE = {
    "shoulder": f"{HEAD}[motor]\n{SHOULDER}[load]\ninertia_kgm2 = 2e-5\n"
    + COMMON.replace("10_000", "4096"),
    "motor_1": f"{HEAD}[motor]\n{ELBOW}[friction]\ncoulomb_nm = 1e-4\n"
    + COMMON.replace("[[0.0, 1.0], [2.0, 3.0]]", "[[0.001, 1.0]]"),
}
"""Each of the two motors as a scene with this motor only."""
SECOND = TEXT.count("\n", 0, TEXT.index("[[motors]]", TEXT.index("[[motors]]") + 1)) + 1
"""Line of the second motor."""
BRUSHLESS = TEXT.replace("re25-118743", "gbm2804-100t")


def write(folder: Path, text: str, name: str = "arm.toml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def refusal(folder: Path, text: str, *sets: str) -> str:
    """The message of a refusal without the folder; it is one printable line."""
    with pytest.raises(SceneError) as refused:
        load_device(write(folder, text), sets)
    message = str(refused.value)
    assert message.isprintable()
    return message.replace(f"{folder}{os.sep}", "")


# ---- What is read.


def test_each_motor_is_the_scene_of_that_motor_alone(tmp_path):
    device = load_device(write(tmp_path, TEXT))
    assert list(device.motors) == NAMES
    assert device.name == "arm"
    for name, text in ALONE.items():
        assert device.motors[name] == load_scene(write(tmp_path, text, f"{name}.toml"))


def test_a_scene_with_motor_is_a_device_of_one():
    """Every shipped scene but those of several motors is as it was."""
    for name, path in shipped_scenes().items():
        device = load_device(path)
        if device.space is not None:
            continue
        several = ["shoulder", "elbow"] if name == "two_motors" else ["motor_0"]
        assert list(device.motors) == several
        if name != "two_motors":
            assert load_scene(path) == device.scenes[0]


def test_one_motors_is_a_motor(tmp_path):
    one = load_scene(write(tmp_path, f"{HEAD}[[motors]]\n{ELBOW}{COMMON}"))
    assert one == load_scene(write(tmp_path, f"{HEAD}[motor]\n{ELBOW}{COMMON}"))


def test_motors_as_inline_tables(tmp_path):
    text = f"motors = [{{{', '.join(SHOULDER.split(chr(10))[:2])}}},\n{{R_ohm = -1}}]\n{HEAD}"
    message = refusal(tmp_path, text + COMMON)
    assert message.startswith("arm.toml:2: motors.motor_1: motor.R_ohm = -1 is out of range")


def test_a_motor_is_chosen_by_name_or_number(tmp_path):
    path = write(tmp_path, TEXT)
    assert load_scene(path, motor="shoulder") == load_scene(path, motor="0")
    assert load_scene(path, motor="motor_1").motor.preset == "re25-118743"
    for motor, told in (("sholder", "did you mean shoulder? known: shoulder, motor_1"),
                        ("2", "there is no such motor; known: shoulder, motor_1")):  # fmt: skip
        with pytest.raises(SceneError, match=f"^--motor {motor}: .*{re.escape(told)}$"):
            load_scene(path, motor=motor)


def test_a_scene_of_one_motor_has_none_to_choose(tmp_path):
    path = write(tmp_path, ALONE["motor_1"])
    with pytest.raises(SceneError, match=r"the scene has one, so leave --motor out$"):
        load_scene(path, motor="elbow")


def test_nothing_takes_only_the_first(tmp_path):
    with pytest.raises(SceneError, match=r"arm\.toml:4: the scene has 2 motors, shoulder, motor_1"):
        load_scene(write(tmp_path, TEXT))


def r_ohms(device: Device) -> list[float]:
    return [scene.motor.R_ohm for scene in device.scenes]


@pytest.mark.parametrize(
    ("sets", "ohms"),
    [
        (("motor.R_ohm=3",), [3, 3]),
        (("motors.0.R_ohm=3",), [3, 2.18]),
        (("motors.shoulder.R_ohm=3",), [3, 2.18]),
        (("motors.motor_1.R_ohm=3",), [1.3, 3]),
        (("motor.R_ohm=3", "motors.1.R_ohm=4"), [3, 4]),
        (("motors.1.R_ohm=4", "motor.R_ohm=3"), [3, 3]),
    ],
)
def test_overrides(tmp_path, sets, ohms):
    """Of all motors or of one; a later one wins."""
    assert r_ohms(load_device(write(tmp_path, TEXT), sets)) == ohms


def test_overrides_of_tables(tmp_path):
    """For all it is above what stands inside a motor; for one it makes the table."""
    path = write(tmp_path, TEXT)

    def counts(*sets: str) -> list[int]:
        encoders = [scene.encoder for scene in load_device(path, sets).scenes]
        return [encoder.counts_per_rev for encoder in encoders if encoder is not None]

    assert counts() == [4096, 10_000]
    assert counts("encoder.counts_per_rev=400") == [400, 400]
    assert counts("motors.motor_1.encoder.counts_per_rev=400") == [4096, 400]
    device = load_device(path, ("motors.motor_1.load.inertia_kgm2=1e-6",))
    assert [scene.load.inertia_kgm2 if scene.load else None for scene in device.scenes] == [
        2e-5, 1e-6,
    ]  # fmt: skip


# ---- What is refused.


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (ELBOW, "R = 2\n", "motors.motor_1: unknown key motor.R; did you mean R_ohm?"),
        (ELBOW, f"{ELBOW}R_ohm = -1\n", "motors.motor_1: motor.R_ohm = -1 is out of range"),
        (ELBOW, 'name = "shoulder"\n', 'motors[1].name "shoulder" is also that of motors[0]; give'),
        (ELBOW, 'name = "an elbow"\n', 'motors[1].name = "an elbow" is no name; use 1 to 30'),
        (ELBOW, "name = 7\n", "motors[1].name = 7 is no name; use 1 to 30"),
        (ELBOW, "motor.R_ohm = 3\n", "motors.motor_1: unknown key motor.motor;"),
        (ELBOW, "lod.inertia_kgm2 = 3\n", "motors.motor_1: unknown table [lod]; did you mean"),
        (ELBOW, "encoder = 3\n", "motors.motor_1: encoder must be a table, not 3;"),
        (ELBOW, "encoder.counts = 3\n", "motors.motor_1: unknown key encoder.counts; did you mean"),
    ],
)  # fmt: skip
def test_refused_in_the_second_motor(tmp_path, old, new, told):
    """With the line of the key, right below that of its ``[[motors]]``."""
    where = SECOND + new.count("\n")
    assert refusal(tmp_path, TEXT.replace(old, new)).startswith(f"arm.toml:{where}: {told}")


@pytest.mark.parametrize("path", SHARED, ids=".".join)
def test_what_all_motors_share(tmp_path, path):
    """Inside a motor it is refused, with a reason, in the file and on the command line."""
    table, key = path if len(path) == 2 else (path[0], "name")
    same = f"{table}.{key if len(path) == 2 else 'name'} is the same for every motor: "
    told = refusal(tmp_path, TEXT.replace(ELBOW, f"{ELBOW}{table}.{key} = 1\n"))
    assert told == (
        f"arm.toml:{SECOND + 2}: motors.motor_1: {same}{SHARED[path]}; move it to [{table}]"
    )
    override = f"motors.motor_1.{table}.{key}=1"
    told = refusal(tmp_path, TEXT, override)
    assert told == f"--set {override}: {same}{SHARED[path]}; write {table}.{key}=value"


def test_the_description_has_what_is_shared():
    page = (SCENES_DIR / "README.md").read_text(encoding="utf-8")
    told = {}
    for keys, why in re.findall(r"^\| (`.*`) \| (.*) \|$", page.partition("| shared |")[2], re.M):
        told |= {tuple(key.strip("[]").split(".")): why for key in re.findall(r"`(.*?)`", keys)}
        if len(told) == len(SHARED):
            break
    assert told == SHARED


@pytest.mark.parametrize(
    ("motors", "line", "told"),
    [
        ("motors = []\n", 1, "motors is empty; write [[motors]] above each motor's keys"),
        ("motors = 3\n", 1, "motors must be tables, not 3; write [[motors]] above"),
        ("motors.R_ohm = 3\n", 1, "motors must be tables, not a table; write [[motors]] above"),
        ("motors = [3]\n", 1, "motors[0] must be a table, not 3; write [[motors]]"),
        (f"[motor]\n{ELBOW}[[motors]]\n{ELBOW}", 3, "a scene has [motor] or [[motors]], not both;"),
        (f"[[motors]]\n{ELBOW}[motor]\n{ELBOW}", 3, "a scene has [motor] or [[motors]], not both;"),
        (f"[[motor]]\n{ELBOW}", 1, "motor must be a table, not an array; write [[motors]] above"),
        (f"[motors]\n{ELBOW}", 1, "motors must be tables, not a table; write [[motors]] above"),
        ("[[motors]]\n", 1, "motor.R_ohm is missing; give preset, or all of R_ohm"),
        (f"[[motrs]]\n{ELBOW}", 1, "unknown table [motrs]; did you mean [[motors]]?"),
    ],
)
def test_refused_motors(tmp_path, motors, line, told):
    assert refusal(tmp_path, f"{motors}{HEAD}{COMMON}").startswith(f"arm.toml:{line}: {told}")


def test_what_is_wrong_for_all_is_told_of_none(tmp_path):
    text = TEXT.replace("amplitude_rad = 0.05", "amplitude_rad = 0")
    line = text.count("\n", 0, text.index("amplitude_rad")) + 1
    told = refusal(tmp_path, text)
    assert told.startswith(f"arm.toml:{line}: hand.amplitude_rad = 0 is out of range")


@pytest.mark.parametrize(
    ("override", "told"),
    [
        ("motors.2.R_ohm=1", "it must be motors.NAME.key=value or motors.NAME.table.key=value, "
         "NAME one of shoulder, motor_1"),
        ("motors.shoulder=1", "it must be motors.NAME.key=value"),
        ("motors=[]", "it must be motors.NAME.key=value"),
        ("motors.0.a.b.c=1", "it must be motors.NAME.key=value"),
        ("motors.0.R_ohm", "no value"),
        ("motors.0.R_ohm=-1", "motors.shoulder: motor.R_ohm = -1 is out of range"),
        ("motors.0.name=x", "motors.shoulder: unknown key motor.name;"),
        ("motors.1.load.mass=1", "motors.motor_1: unknown key load.mass;"),
    ],
)  # fmt: skip
def test_refused_overrides(tmp_path, override, told):
    assert refusal(tmp_path, TEXT, override).startswith(f"--set {override}: {told}")


def test_no_motors_to_override(tmp_path):
    told = refusal(tmp_path, ALONE["motor_1"], "motors.0.R_ohm=1")
    assert told.endswith("where the scene has [[motors]]; it has [motor]")


def test_what_a_controller_refuses_names_the_motor(tmp_path, capsys, monkeypatch):
    text = TEXT.replace(ELBOW, f'{ELBOW}shaper.feel = "spring"\nshaper.stiffness = 0.1\n')
    path = write(tmp_path, text)
    status, _, err = call(capsys, monkeypatch, "check", str(path), "--controller", "analog")
    assert status == 2
    assert f"arm.toml:{SECOND + 2}: motors.motor_1: " in err


OF_NO_MOTOR = (
    # One guard watches all motors, ...
    "wh_guard", "wh_trip", "wh_sense_check", "wh_zero",
    # ... and these count only where a bus is measured, or a motor is brushless.
    "wh_bus_scale", "wh_rotor_flux",
)  # fmt: skip
"""Blocks whose registers a device has once, though they follow from a motor."""
SOLDERED = ("ADC", "OSR", "MODES", "MIN_PULSE", "HOST")
"""Parameters of ``wh_device`` that are no station which some motors use and others don't."""
NO_BOARD = (
    "servo.", "drive.bus_measured", "motor.kind", "encoder.kind", "encoder.part", "encoder.bits",
    "encoder.read_hz", "encoder.latency_s", "encoder.noise_counts", "encoder.bandwidth_hz",
    "encoder.hysteresis_counts",
)  # fmt: skip
"""Keys that no board takes; a brushless motor's registers are others."""


@pytest.mark.parametrize("key", [key for key in KEYS if not key.startswith((*NO_BOARD, "guard."))])
def test_what_a_device_has_once_is_shared(tmp_path, key):
    """A key may differ from motor to motor if and only if no register that is all motors' does."""
    path = write(tmp_path, BASE)
    common = (*ENCODER, *SENSED, *DRIVEN, "controller.extra_ticks=4")

    def once(*sets: str) -> dict[str, int]:
        made = scene_registers(load_scene(path, [s for s in sets if not s.startswith(NO_BOARD)]))
        registers = {
            one.name: one.raw for one in made.registers
            if one.word.row.per == "board" and one.word.block not in OF_NO_MOTOR
        }  # fmt: skip
        return registers | {name: made.parameters.get(name, 0) for name in SOLDERED}

    before, after = KEYS[key]
    if key == "thermal.ambient_c":
        after = ("thermal.ambient_c=40",)  # at KEYS' 100 °C a winding bears nothing more
    changed = once(*common, *before) != once(*common, *before, *after)
    assert changed == (shared(tuple(key.split("."))) is not None)


# ---- What runs.


def results(folder: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Metrics of a run, without how long it took, and its trace."""
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics.pop("wall_clock_s") >= 0.0
    return metrics, load_trace(folder)


def assert_same(found: Path, alone: Path, motor: str) -> None:
    """To the last digit, and that there is something to compare."""
    (metrics, trace), (wanted, alone_trace) = results(found), results(alone)
    assert metrics.pop("motor") == motor
    assert metrics == wanted
    assert list(trace) == list(alone_trace)
    for key, values in trace.items():
        np.testing.assert_array_equal(values, alone_trace[key], err_msg=key)
    assert np.unique(trace["x"]).size > 100


def run_both(folder: Path, text: str, alone: dict[str, str], controller: str, *sets: str) -> None:
    device = load_device(write(folder, text), sets)
    told: list[tuple[str, float]] = []
    summary = run_device(device, controller, folder / "all", lambda *part: told.append(part))
    assert [name for name, part in told if part == 1.0] == list(alone)
    assert json.loads((folder / "all" / "metrics.json").read_text()) == summary
    assert list(summary["motors"]) == list(alone)
    assert (summary["scene"], summary["controller"]) == ("arm", controller)
    for name, alone_text in alone.items():
        scene: Scene = load_scene(write(folder, alone_text, "alone.toml"), sets)
        run_scene(scene, controller, folder / name)
        assert_same(folder / "all" / name, folder / name, name)
        assert summary["motors"][name] == json.loads(
            (folder / "all" / name / "metrics.json").read_text()
        )


@pytest.mark.parametrize("controller", ["analog", "golden", "core", "encoder"])
def test_each_motor_runs_as_if_alone(tmp_path, controller):
    run_both(tmp_path, TEXT, ALONE, controller)


def test_motors_of_one_controller_on_pins(tmp_path):
    """Files, metrics and arrays are those of motors alone, and motion is, but for the latency."""
    sets = ("scene.duration_s=0.05", "controller.tick_hz=100e3")
    device = load_device(write(tmp_path, TEXT), sets)
    told: list[tuple[str, float]] = []
    summary = run_device(device, "pins", tmp_path / "all", lambda *part: told.append(part))
    assert [name for name, part in told if part == 1.0] == NAMES
    assert json.loads((tmp_path / "all" / "metrics.json").read_text()) == summary
    assert list(summary) == ["scene", "controller", "duration_s", "wall_clock_s", "motors"]
    times_s = [summary["motors"][name]["wall_clock_s"] for name in NAMES]
    assert times_s == [times_s[0]] * 2
    assert summary["wall_clock_s"] == pytest.approx(sum(times_s))
    for name, text in ALONE.items():
        wanted = run_scene(load_scene(write(tmp_path, text, "alone.toml"), sets), "pins",
                           tmp_path / name)  # fmt: skip
        assert files(tmp_path / "all" / name) == files(tmp_path / name) == RUN_FILES
        metrics, trace = results(tmp_path / "all" / name)
        assert metrics.pop("motor") == name
        assert set(metrics) == set(wanted) - {"wall_clock_s"}
        alone = load_trace(tmp_path / name)
        assert list(trace) == list(alone)
        assert np.ptp(alone["x"]) > 0.005
        np.testing.assert_allclose(trace["x"], alone["x"], atol=2 * math.pi / 10_000)
        assert metrics["peak_torque"] == pytest.approx(wanted["peak_torque"], rel=0.02)


@pytest.mark.parametrize("controller", ["golden", "core", "pins", "encoder"])
def test_with_brushes_and_without(tmp_path, controller):
    """A brushless motor beside one with brushes."""
    alone = {name: text.replace("re25-118743", "gbm2804-100t") for name, text in ALONE.items()}
    sets = ("scene.duration_s=0.01", "controller.tick_hz=200e3")
    run_both(tmp_path, BRUSHLESS, alone, controller, *sets)


# ---- The commands.


def files(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


RUN_FILES = {"trace.npz", "metrics.json", "run.png"}


def test_run_writes_a_folder_for_each_motor(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, TEXT)
    status, out, err = call(capsys, monkeypatch, "run", "arm.toml")
    assert (status, err) == (0, "")
    folder = tmp_path / "build" / "runs" / "arm-golden"
    assert files(folder) == {"metrics.json"} | {f"{n}/{f}" for n in NAMES for f in RUN_FILES}
    assert out.count("stiffness_predicted") == 2
    shown = [line.split()[1] for line in out.splitlines() if line.startswith("motor ")]
    assert shown == NAMES
    assert out.endswith("results in build/runs/arm-golden\n")


def test_run_of_one_motor_of_several(tmp_path, capsys, monkeypatch):
    """Its folder is where a run of all has it."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path, TEXT)
    status, out, _ = call(capsys, monkeypatch, "run", "arm.toml", "--motor", "shoulder")
    assert status == 0
    assert files(tmp_path / "build") == {f"runs/arm-golden/shoulder/{name}" for name in RUN_FILES}
    assert "motor_1" not in out


def test_check_looks_at_every_motor(tmp_path, capsys, monkeypatch):
    path = str(write(tmp_path, TEXT))
    assert call(capsys, monkeypatch, "check", path)[0] == 0
    shaped = ("--set", "motors.1.shaper.feel=spring", "--set", "motors.1.shaper.stiffness=0.1")
    status, out, err = call(capsys, monkeypatch, "check", path, *shaped)
    assert (status, err) == (0, "")
    assert "not on `analog`: --set motors.1.shaper.feel=spring: motors.motor_1: " in out


def test_warnings_name_the_motor(tmp_path, capsys, monkeypatch):
    path = write(
        tmp_path, TEXT.replace("[[motors]]\npreset", "[[motors]]\nadc.full_scale_a = 0.1\npreset")
    )
    status, out, _ = call(capsys, monkeypatch, "check", str(path), "--controller", "golden")
    assert status == 0
    warnings = [line for line in out.splitlines() if line.startswith("warning: ")]
    assert warnings
    assert all(line.startswith("warning: motor_1: the current may reach") for line in warnings)


@pytest.mark.parametrize(
    "arguments",
    [
        ("speed", "two_motors"), ("impedance", "two_motors"), ("shaper", "two_motors"),
        ("registers", "two_motors", "--format", "c"),
        ("board", "--virtual", "two_motors"), ("board", "scope", "--virtual", "two_motors"),
        ("board", "scope", "--port", "p", "--scene", "two_motors"),
    ],
)  # fmt: skip
def test_commands_for_one_motor(tmp_path, capsys, monkeypatch, arguments):
    """They refuse several in one line with a cure, and make no folder."""
    monkeypatch.chdir(tmp_path)
    status, out, err = call(capsys, monkeypatch, *arguments)
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert "two_motors.toml:9: the scene has 2 motors, shoulder, elbow; one is taken here; " in err
    has_option = arguments[0] in ("speed", "impedance", "shaper", "registers")
    assert ("choose it with --motor NAME" in err) == has_option
    assert list(tmp_path.iterdir()) == []


def test_registers_of_the_motor_that_is_named(capsys, monkeypatch):
    made = {}
    for motor in ("shoulder", "elbow"):
        status, out, _ = call(
            capsys, monkeypatch, "registers", "two_motors", "--format", "json", "--motor", motor
        )
        assert status == 0
        made[motor] = {row["name"]: row["value"] for row in json.loads(out)}
    ohms = {motor: 0.5 * row["root"] ** 2 for motor, row in made.items()}
    assert ohms == pytest.approx({"shoulder": 0.7 * 1.16, "elbow": 0.7 * 2.18}, rel=1e-3)


def test_the_shipped_scene_of_two_motors(tmp_path):
    """The lever is tapped on a wall of the larger motor, the smaller one's is held."""
    device = load_device(find_scene("two_motors"))
    metrics = run_device(device, "golden", tmp_path)["motors"]
    for name, stiffness in (("shoulder", 9.81), ("elbow", 1.731)):
        assert metrics[name]["stiffness_predicted"] == pytest.approx(stiffness, rel=1e-3)
        assert metrics[name]["stiffness"] == pytest.approx(stiffness, rel=0.03)
    assert metrics["shoulder"]["hold_error"] is None
    held = metrics["elbow"]
    depth = held["hold_torque"] / held["stiffness"]
    assert abs(held["hold_offset_rad"]) <= 2 * math.pi / 10_000 + 0.01 * abs(depth)
