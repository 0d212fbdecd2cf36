# SPDX-License-Identifier: Apache-2.0
"""``wavehaptics tune``: each number against a closed form, or a run of the scene it recommends."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from wavehaptics.ladder.refusals import check
from wavehaptics.ladder.run import measure
from wavehaptics.laws import closed_forms
from wavehaptics.scene import SceneError, find_scene, load_scene
from wavehaptics.studies import tune as module
from wavehaptics.studies.tune import PRESS_PART, PRESS_S, tune

TIMEOUT_S = 600


def tuned(name: str, *overrides: str, **more: Any) -> dict[str, Any]:
    path = find_scene(name)
    return tune(path, path.read_bytes(), overrides, **more)


@pytest.fixture(scope="module")
def held() -> dict[str, Any]:
    return tuned("press_hold")


def pressed_run(found: dict[str, Any], scene: str, torque: float) -> dict[str, Any]:
    """Metrics of the recommended scene, pressed with so much in the end."""
    k, base = found["wall"]["stiffness_predicted"], load_scene(find_scene(scene))
    amplitude = torque * (1.0 / k + 1.0 / base.hand.stiffness)
    settings = [
        *found["best"]["settings"], "hand.path=press", f"hand.amplitude_rad={amplitude!r}",
        f"scene.duration_s={PRESS_S}", "controller.walls=[[0.0, 100.0]]",
    ]  # fmt: skip
    return measure(load_scene(find_scene(scene), settings), "golden", compare=False)


def test_the_wall_is_what_closed_forms_and_a_run_say(held):
    motor = load_scene(find_scene("press_hold")).motor
    best, wall = held["best"], held["wall"]
    tau = closed_forms.tau(1.0 / best["tick_hz"], best["a"], best["extra_ticks"])
    expected = closed_forms.stiffness(motor.k_t, motor.L_h, motor.R_ohm, tau)
    assert wall["stiffness_predicted"] == pytest.approx(expected, rel=1e-6)
    assert held["motor"]["k_l"] == pytest.approx(2.2815)
    assert wall["of_k_l"] == pytest.approx(expected / 2.2815)
    assert (wall["stable"], wall["limit"]) == (True, "the delay of the control loop")
    run = pressed_run(held, "press_hold", PRESS_PART * held["forces"][0]["torque"])
    assert run["stiffness"] == pytest.approx(wall["stiffness_predicted"], rel=0.01)
    hold = held["hold"]
    assert wall["stiffness"] == run["stiffness"]
    assert hold["torque"] == run["hold_torque"]
    assert hold["offset_rad"] == run["hold_offset_rad"]
    assert hold["ripple_rms"] == run["hold_ripple_rms"]
    assert abs(run["hold_torque"]) == pytest.approx(hold["pressed_with"], rel=0.01)
    assert hold["offset_counts"] == pytest.approx(hold["offset_rad"] * 10_000 / (2 * math.pi))
    # A larger λ makes no stiffer wall.
    larger = module.spring(
        load_scene(find_scene("press_hold"), [*best["settings"], "controller.lambda=1e8"])
    )
    assert larger == pytest.approx(wall["stiffness_predicted"], rel=1e-5)


@pytest.mark.parametrize(
    ("volts", "first", "metric"),
    [
        (12.0, "the range of the current's ADC", "clipped_fraction"),
        (2.1, "the drive's voltage through R", "saturated_fraction"),
    ],
)
def test_the_first_limit_is_the_one_that_a_run_meets(volts, first, metric):
    found = tuned("press_hold", f"drive.limit_v={volts}")
    forces = found["forces"]
    assert found["first_limit"] == forces[0]["name"] == first
    assert [one["torque"] for one in forces] == sorted(one["torque"] for one in forces)
    motor = load_scene(find_scene("press_hold")).motor
    for one in forces:
        assert one["torque"] == pytest.approx(motor.k_t * one["current_a"])
    currents = {one["name"]: one["current_a"] for one in forces}
    assert currents["the range of the current's ADC"] == 2.5
    assert currents["the drive's voltage through R"] == pytest.approx(volts / 2.18, rel=1e-6)
    below = pressed_run(found, "press_hold", 0.85 * forces[0]["torque"])
    beyond = pressed_run(found, "press_hold", 1.3 * forces[0]["torque"])
    assert below["clipped_fraction"] == 0
    assert beyond[metric] > 0.05 > below[metric]


def test_counts_that_are_needed(held):
    """With so many the largest torque is four counts deep, and with one fewer it isn't."""
    needed, k = held["encoder"]["counts_needed"], held["wall"]["stiffness_predicted"]
    depth = held["forces"][0]["torque"] / k
    assert depth * needed / (2 * math.pi) >= 4.0 > depth * (needed - 1) / (2 * math.pi)
    assert held["encoder"]["count_torque"] == pytest.approx(k * 2 * math.pi / 10_000)


def test_carriers_are_those_that_pins_and_sensor_follow():
    found = tuned("press_hold", sensor="INA241")
    usable = {row["carrier_hz"]: row for row in found["carriers"] if row["refusal"] is None}
    refused = {row["carrier_hz"]: row["refusal"] for row in found["carriers"] if row["refusal"]}
    assert min(refused) > 417e3 > max(usable)
    assert all("holds its output for 1 µs" in why for why in refused.values())
    best = max(usable.values(), key=lambda row: row["stiffness"])
    assert found["best"]["carrier_hz"] == best["carrier_hz"] == 400e3
    assert found["wall"]["stiffness_predicted"] == pytest.approx(best["stiffness"], rel=1e-6)
    scene = load_scene(find_scene("press_hold"), found["best"]["settings"])
    assert check(scene, "pins") == pytest.approx(1.0 / found["best"]["tick_hz"])
    with pytest.raises(SceneError, match="did you mean"):
        tuned("press_hold", sensor="INA242")


def test_a_clock_that_leaves_no_carrier_is_told():
    with pytest.raises(SceneError, match="no carrier can be had"):
        tuned("press_hold", "controller.clock_hz=1e6")


def test_a_wall_that_is_not_stable_asks_for_less(monkeypatch):
    monkeypatch.setattr(module, "largest_stiffness", lambda scene, controller: (1.0, False))
    found = tuned("press_hold")
    assert found["wall"]["stiffness_predicted"] == pytest.approx(1.0, rel=1e-4)
    assert found["wall"]["limit"] == "stability in this hand"
    assert found["wall"]["stiffness"] == pytest.approx(1.0, rel=0.01)
    monkeypatch.setattr(module, "largest_stiffness", lambda scene, controller: (None, False))
    assert tuned("press_hold")["wall"]["limit"] == "no wall is stable in this hand"


def test_a_brushless_motor_has_its_pull_out():
    found = tuned("brushless_wall")
    names = [one["name"] for one in found["forces"]]
    assert "the magnets' pull-out" in names
    pairs = load_scene(find_scene("brushless_wall")).motor.pole_pairs
    torque = found["forces"][names.index("the magnets' pull-out")]["torque"]
    assert torque == pytest.approx(found["wall"]["stiffness_predicted"] / pairs)
    assert found["best"]["tick_hz"] == pytest.approx(found["best"]["carrier_hz"])


def command(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "wavehaptics", *words], cwd=folder, capture_output=True, text=True,
        timeout=TIMEOUT_S, check=False,
    )  # fmt: skip


SHEET = ("--r-ohm", "2.45", "--l-h", "0.513e-3", "--k-t", "53.8e-3", "--j-kgm2", "34.7e-7")


def test_a_data_sheet_in_two_commands(tmp_path):
    made = command(tmp_path, "new-scene", "mine.toml", *SHEET, "--bus-v", "48")
    assert (made.returncode, made.stderr) == (0, "")
    told = command(tmp_path, "tune", "mine.toml")
    assert (told.returncode, told.stderr) == (0, "")
    page = told.stdout
    assert len(page.splitlines()) <= 40
    assert "% of K_L = 5.642" in page
    found = json.loads(command(tmp_path, "tune", "mine.toml", "--json").stdout)
    assert f"{found['wall']['stiffness_predicted']:.4g} N·m/rad" in page
    assert f"{found['forces'][0]['torque']:.4g} N·m" in page
    (last,) = [line for line in page.splitlines() if line.startswith("run it: ")]
    words = last.removeprefix("run it: wavehaptics ").split()
    ran = command(tmp_path, *words, "--out", "out")
    assert ran.returncode == 0, ran.stderr
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_bytes())
    predicted = found["wall"]["stiffness_predicted"]
    assert metrics["stiffness_predicted"] == pytest.approx(predicted, rel=1e-6)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("new-scene", "there.toml", *SHEET), "there.toml: is there already"),
        (("new-scene", "x.toml", *SHEET, "--counts", "1"), "encoder.counts_per_rev = 1 is out of"),
        (("new-scene", "x.toml", *SHEET, "--r-ohm", "0"), "--r-ohm 0"),
        (("new-scene", "x.toml"), "Missing option"),
        (("tune", "press_hol"), "did you mean press_hold?"),
        (("tune", "press_hold", "--set", "motor.L_h=0"), "motor.L_h = 0 is out of range"),
        (("tune", "phantom_plane"), "[device] moves all motors together"),
        (("tune", "two_motors"), "choose it with --motor NAME"),
    ],
)
def test_refused_in_one_line(tmp_path, words, told):
    (tmp_path / "there.toml").write_text("")
    done = command(tmp_path, *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(r"wavehaptics: [^\n]+\n", done.stderr), done.stderr
    assert told in done.stderr
    assert not (tmp_path / "x.toml").exists()
