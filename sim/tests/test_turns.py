# SPDX-License-Identifier: Apache-2.0
"""Several motors on `pins`: ports of one controller that take turns, in one loop."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from test_cli import call
from wavehaptics.controller.turns import turns_ports
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.ladder.run import measure, run_device
from wavehaptics.ladder.turns_pins import TurnsSimulation
from wavehaptics.scene import Device, Scene, SceneError, find_scene, load_device
from wavehaptics.trace.columns import Column, Word

BLIND = ("controller.tick_hz=100e3", "encoder.stops_at_s=1e-9",
         "motors.1.controller.walls=[[-1.0, 1.0]]")  # fmt: skip
"""No edge comes when one controller has looked at its position and the other has not; the second
motor is in its wall from the start. A tick is long enough for a latency of one, as one motor's."""
TICKS = 1_200
PARTS = (slice(0, 500), slice(500, TICKS))
"""As a run has them."""
SHAPED = ("shaper.feel=spring", "shaper.stiffness=0.9", "controller.tick_hz=50e3")


def two_motors(*overrides: str) -> Device:
    return load_device(find_scene("two_motors"), overrides)


def room() -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((TICKS, len(Column))), np.zeros((TICKS, len(Word)), dtype=np.int64)


def with_latency(scene: Scene, extra_ticks: int) -> Scene:
    """The scene with the latency that its motor has among others."""
    control = scene.controller.model_copy(update={"extra_ticks": extra_ticks})
    return scene.model_copy(update={"controller": control})


def alone(scene: Scene, extra_ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and words of a motor at a controller of its own."""
    simulation = PinsSimulation(with_latency(scene, extra_ticks))
    rows, words = room()
    for part in PARTS:
        simulation.advance(rows[part], words[part])
    return rows, words


def together(scenes: Sequence[Scene]) -> tuple[TurnsSimulation, list[np.ndarray], list[np.ndarray]]:
    """Rows and words of each motor."""
    made = [room() for _ in scenes]
    rows, words = [row for row, _ in made], [word for _, word in made]
    simulation = TurnsSimulation(scenes)
    for part in PARTS:
        simulation.advance([row[part] for row in rows], [word[part] for word in words])
    return simulation, rows, words


@pytest.mark.parametrize(
    "sets",
    [
        (),
        ("motors.0.controller.anchor_auto=false",),
        (*SHAPED, "shaper.walls=[0]"),
        ("drive.mode=locked-anti-phase",),
        ("drive.min_pulse_s=200e-9", "motors.1.drive.gain_error=0.05"),
        ("thermal.ambient_c=60", "adc.bandwidth_hz=800e3", "drive.sag_ohm=0.2"),
        ("drive.pwm_hz=100e3", "drive.dead_time_s=100e-9"),
    ],
    ids=["plain", "anchor-of-one", "shaped", "mode", "pulse", "real", "dead-time"],
)
def test_each_port_is_a_controller_of_one_motor(sets):
    """Every row and word, bit for bit, while no encoder has an edge."""
    scenes = two_motors(*BLIND, *sets).scenes
    simulation, rows, words = together(scenes)
    extra_ticks = simulation.motors[0].settings.extra_ticks
    assert extra_ticks == 1
    for scene, found, found_words in zip(scenes, rows, words, strict=True):
        wanted, wanted_words = alone(scene, extra_ticks)
        np.testing.assert_array_equal(found_words, wanted_words)
        for column in Column:
            np.testing.assert_array_equal(found[:, column], wanted[:, column], err_msg=column.name)
        assert np.abs(found_words[:, Word.U]).max() > 1000
    assert rows[1][:, Column.CONTACT].all()
    assert not rows[0][:, Column.CONTACT].any()
    assert [motor.faults for motor in simulation.motors] == [0, 0]


def test_an_ideal_motor_beside_a_real_one():
    """The loop has one kind of motor, and an ideal one is what it was to rounding."""
    scenes = two_motors(*BLIND, "motors.0.friction.coulomb_nm=1e-4").scenes
    _, rows, words = together(scenes)
    wanted, wanted_words = alone(scenes[1], 1)
    np.testing.assert_array_equal(words[1], wanted_words)
    np.testing.assert_allclose(rows[1], wanted, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("tick_hz", ["1e6", "250e3"])
def test_walls_are_those_of_golden_with_the_same_latency(tmp_path, tick_hz):
    """A lever that is tapped and a rotor that is held, with a tick of latency for the turns.

    The stiffness of taps scatters by 1 % with where in a count the lever turns.
    """
    device = two_motors(f"controller.tick_hz={tick_hz}", "scene.duration_s=0.25")
    found = run_device(device, "pins", tmp_path)["motors"]
    extra_ticks = turns_ports(device.scenes)[0].settings.extra_ticks
    for name, scene in device.motors.items():
        golden = measure(with_latency(scene, extra_ticks), "golden", compare=False)
        assert found[name]["stiffness"] == pytest.approx(golden["stiffness"], rel=0.025)
        if name == "elbow":
            assert found[name]["hold_torque"] == pytest.approx(golden["hold_torque"], rel=0.01)
        assert found[name]["stiffness_predicted"] == golden["stiffness_predicted"]
        assert set(found[name]) - {"motor"} == set(golden)


def test_a_guard_takes_the_gates_of_all_motors():
    """One that presses trips it, and the one that rests is off in the same tick."""
    sets = ("motors.0.adc.full_scale_a=2.5", "motors.1.adc.full_scale_a=2.5", "guard.trip_a=0.5",
            "guard.watch=false", "controller.tick_hz=250e3", "motors.1.hand.amplitude_rad=0.5",
            "motors.1.hand.stiffness=5.0")  # fmt: skip
    scene = two_motors(*sets).scenes[1]
    resting = scene.model_copy(
        update={"hand": scene.hand.model_copy(update={"amplitude_rad": 1e-6})}
    )
    simulation = TurnsSimulation([resting, scene])
    made = [np.zeros((20_000, len(Column))) for _ in range(2)]
    words = [np.zeros((20_000, len(Word)), dtype=np.int64) for _ in range(2)]
    simulation.advance(made, words)
    first, second = simulation.motors
    assert first.off_s == second.off_s > 0.0
    assert first.faults == second.faults != 0
    off = made[0][:, Column.T] > first.off_s + 1e-4
    assert off.sum() > 100
    assert not made[0][off][:, Column.U].any()
    assert not made[1][off][:, Column.U].any()
    assert np.abs(made[1][~off][:, Column.U]).max() > 0.1


@pytest.mark.parametrize(
    ("sets", "problem", "cure"),
    [
        (("drive.bus_measured=true",), "drive.bus_measured is for a single motor", "set it to"),
        (("controller.clock_hz=60e6",), "a tick of 60 clocks is shorter than the 70",
         "clock_hz >= 7e+07"),
        (("controller.extra_ticks=0",), "controller.extra_ticks = 0 is less than", "extra_ticks ="),
        (("drive.pwm_hz=4e6",), "a carrier half of 9 clocks of 7.2e+07 Hz is shorter than the 10",
         "lower drive.pwm_hz"),
        (("adc.part=MAX11125",), "adc.part = MAX11125 has a channel for each motor", "another"),
        (("guard.trip_a=0.5",), "guard_current is 6553 for this motor and 3276 for the first",
         "leave [guard] out"),
        (("controller.walls=[[0.0,0.1],[0.2,0.3],[0.4,0.5],[0.6,0.7],[0.8,0.9],[1.0,1.1],"
          "[1.2,1.3],[1.4,1.5]]",), "controller.walls has 8 walls, and each of several", "leave"),
    ],
)  # fmt: skip
def test_what_several_motors_refuse(tmp_path: Path, capsys, monkeypatch, sets, problem, cure):
    """In one line with place and cure, by `run` and by `check`, and no file is written."""
    monkeypatch.chdir(tmp_path)
    flags = [word for text in sets for word in ("--set", text)]
    for command in ("run", "check"):
        status, out, err = call(
            capsys, monkeypatch, command, "two_motors", "--controller", "pins", *flags
        )
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert f"--set {sets[0]}: motors." in err
        assert problem in err
        assert cure in err
    assert list(tmp_path.rglob("*.npz")) == []


def test_a_converter_of_one_motor_alone():
    """One frame reads all converters, so that all have one or none has."""
    device = load_device(find_scene("two_motors"), ())
    first, second = device.scenes
    with pytest.raises(SceneError, match=r"sample_clocks is .* give all motors an \[adc\]"):
        turns_ports([first, second.model_copy(update={"adc": None})])


def test_more_motors_than_a_controller_has():
    scenes = two_motors("controller.tick_hz=50e3").scenes * 5
    with pytest.raises(SceneError, match="the scene has 10 motors, and one controller has 8"):
        turns_ports(scenes)


def test_eight_motors():
    """As many as there can be, each with what it does as the only other one."""
    scenes = two_motors(*BLIND, "controller.tick_hz=50e3").scenes
    _, rows, words = together(scenes * 4)
    _, wanted, wanted_words = together(scenes)
    for n in range(8):
        np.testing.assert_array_equal(words[n], wanted_words[n % 2])
        np.testing.assert_array_equal(rows[n], wanted[n % 2])
