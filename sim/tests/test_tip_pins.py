# SPDX-License-Identifier: Apache-2.0
"""Devices of several motors on `pins`: the RTL's surfaces in one loop with the arm and its hand."""

from __future__ import annotations

from functools import partial
from math import floor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_tip import CONTROL, HEAD, MOTOR, PLANE, PRESS, REAL, load, told
from wavehaptics.controller.pins_timing import look_clocks, turns_clocks
from wavehaptics.controller.tick_layout import scene_frame, timing
from wavehaptics.controller.turns import turns_ports
from wavehaptics.ladder import pins_loop
from wavehaptics.ladder.joint_pins import JointPins
from wavehaptics.ladder.joint_run import TIP_PICTURE, TIP_TRACE, measure_device
from wavehaptics.ladder.refusals import check_device
from wavehaptics.ladder.run import run_device
from wavehaptics.motor.plant import X
from wavehaptics.scene import Device, SceneError, find_scene, load_device
from wavehaptics.trace.columns import Column, Word, load_trace
from wavehaptics.trace.tip import Tip

NORMAL = [0.6, -0.8, 0.0]
HELD = "anchor_auto = true\n"
SLOW = ("controller.tick_hz=100e3", "controller.clock_hz=24e6")
"""One tick more or less of latency is 4 % of the stiffness then."""


def pressed(folder: Path, *sets: str, normal: tuple[float, ...] = tuple(NORMAL)) -> Device:
    """Two motors of a planar arm, of which both carry the plane, with the errors of real ones."""
    content = "".join((
        HEAD, '[device]\nkinematics = "planar"\nhome_rad = [0.0, 1.570796]\n',
        PLANE.format(normal=list(normal)), PRESS.format(direction=[-part for part in normal]),
        MOTOR * 2, REAL, CONTROL, HELD,
    ))  # fmt: skip
    return load(folder, content, *SLOW, *sets)


def measured(device: Device) -> dict[str, Any]:
    """Metrics of a run on `pins` without a fault."""
    found = measure_device(device, "pins")
    for name, one in found["motors"].items():
        assert "faults" not in one, f"{name}: {one['faults']}"
        assert one["clock_cycles"] > found["ticks"] * 100
    return found


def latency(device: Device) -> str:
    """What gives `golden` the latency that the device has on `pins`."""
    assert device.space is not None
    ports = turns_ports(device.scenes, len(device.space.surface))
    return f"controller.extra_ticks={ports[0].settings.extra_ticks}"


def kept_rows(device: Device, controller: str) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the motors and of the tip."""
    rows, tips = [], []

    def keep(of_motors: np.ndarray, words: np.ndarray, of_tip: np.ndarray) -> None:
        del words
        rows.append(of_motors.copy())
        tips.append(of_tip.copy())

    measure_device(device, controller, keep=keep)
    return np.concatenate(rows, axis=1), np.concatenate(tips)


def test_a_plane_is_as_stiff_as_on_golden(tmp_path: Path) -> None:
    """The same delay, and so the same spring: from the law, from golden, and in a hand's rest."""
    device = pressed(tmp_path, "scene.duration_s=0.11")
    found = measured(device)
    golden = measure_device(pressed(tmp_path, "scene.duration_s=0.11", latency(device)), "golden")
    spring = found["tip_stiffness_predicted"]
    assert spring == pytest.approx(golden["tip_stiffness_predicted"], rel=1e-3)
    assert found["tip_stiffness"] == pytest.approx(golden["tip_stiffness"], rel=0.005)
    # The tip's levers change by as much along the way.
    assert found["tip_stiffness"] == pytest.approx(spring, rel=0.03)
    assert found["tip_force_n"] == pytest.approx(-0.004 / (1 / 500 + 1 / spring), rel=0.01)
    assert found["tangential_part"] < 0.02
    assert abs(found["surface_error_mean_m"] or 0.0) < 1.1e-5  # a count
    stored = 0.5 * found["tip_force_n"] ** 2 / spring
    assert found["energy_out_max_j"] == pytest.approx(golden["energy_out_max_j"], abs=0.01 * stored)
    assert found["contact_fraction"] > 0.999


def test_a_softer_surface_is_as_soft_as_wished_on_pins(tmp_path: Path) -> None:
    found = measured(pressed(tmp_path, "scene.duration_s=0.11", "surface.0.stiffness=1500"))
    assert found["tip_stiffness"] == pytest.approx(1500, rel=0.02)
    assert found["tip_force_n"] == pytest.approx(-0.004 / (1 / 500 + 1 / 1500), rel=0.01)


def test_keys_of_host_and_surface_have_an_effect_on_pins(tmp_path: Path) -> None:
    sets = ("scene.duration_s=0.03", "device.update_hz=500", "hand.direction=[-0.6, 0.5, 0]")
    usual, _ = kept_rows(pressed(tmp_path, *sets), "pins")
    for key in (
        "device.update_hz=250", "device.delay_s=9e-3", "device.jitter_s=9e-3",
        "device.wall_speed_m_per_s=0", "surface.0.friction_loss=0.5",
    ):  # fmt: skip
        rows, _ = kept_rows(pressed(tmp_path, *sets, key), "pins")
        assert not np.array_equal(rows[:, :, 1:], usual[:, :, 1:]), key
    again, _ = kept_rows(pressed(tmp_path, *sets), "pins")
    np.testing.assert_array_equal(again, usual)


def test_rotors_that_start_at_the_end_of_a_count(tmp_path: Path) -> None:
    """They leave it within the first clocks, and the RTL has each where it is."""
    pins = JointPins(pressed(tmp_path, "drive.dead_time_s=8e-8", normal=(-0.6, 0.8, 0.0)))
    ticks = 3
    pins.advance(
        np.zeros((2, ticks, len(Column))), np.zeros((2, ticks, len(Word)), dtype=np.int64),
        np.zeros((ticks, len(Tip))),
    )  # fmt: skip
    counts = [floor(motor._state[X] / motor.settings.cell_rad) for motor in pins.motors]
    assert counts == [-1, -1]
    assert [motor._buffer[pins_loop.POSITION_WORD] for motor in pins.motors] == counts


@pytest.mark.parametrize("motors", [2, 1])
def test_a_hand_at_the_tip_presses_walls_of_the_motors_own(tmp_path: Path, motors: int) -> None:
    """Without surfaces: where the hand leaves the rotors, and what it feels of each."""
    rows_of = ["[0.02, 0], [0, 0.02], [0, 0]", "[0.02], [0], [0]"][motors == 1]
    direction = [1.0, 0.5 * (motors > 1), 0.0]
    content = (
        f'{HEAD}[device]\nkinematics = "matrix"\njacobian = [{rows_of}]\n'
        f"{PRESS.format(direction=direction)}{MOTOR * motors}{REAL}{CONTROL}{HELD}"
        "walls = [[0.02, 1.0]]\n"
    )
    device = load(tmp_path, content, *SLOW, "scene.duration_s=0.09")
    rest = []
    for controller, more in (("pins", ()), ("golden", (latency(device),))):
        sets = (*SLOW, "scene.duration_s=0.09", *more)
        rows, tips = kept_rows(load(tmp_path, content, *sets), controller)
        assert rows[:, -1, Column.CONTACT].all()
        assert not tips[:, Tip.ACTIVE].any()
        rest.append(rows[:, -500:, [Column.X, Column.TORQUE]].mean(axis=1))
    assert rest[0] == pytest.approx(rest[1], rel=0.01)


def test_an_unplugged_encoder_under_a_pressing_hand_ends_the_contact(tmp_path: Path) -> None:
    """As on golden: the plane turns away from what the encoders tell, and nothing is given out."""
    sets = ("scene.duration_s=0.08", "motors.0.encoder.stops_at_s=0.02")
    device = pressed(tmp_path, *sets)
    found = measured(device)
    golden = measure_device(pressed(tmp_path, *sets, latency(device)), "golden")
    assert found["contact_fraction"] == pytest.approx(golden["contact_fraction"], abs=2e-3)
    assert found["contact_fraction"] < 0.7
    assert found["contact_energy_ratio"] < 0.0
    assert found["energy_out_max_j"] < 1e-5


def test_an_anchor_that_gives_up_leaves_ports_that_damp(tmp_path: Path) -> None:
    """One encoder counts the wrong way; from its anchor's fault on no motor holds the surface."""
    sets = ("scene.duration_s=0.09", "motors.0.encoder.reverses_at_s=0.06")
    device = pressed(tmp_path, *sets)
    golden = measure_device(pressed(tmp_path, *sets, latency(device)), "golden")
    lost_s = golden["motors"]["motor_0"]["anchor_fault_s"]
    rows, tips = kept_rows(device, "pins")
    fault = rows[:, :, Column.FAULT] != 0.0
    assert fault[0].any()
    assert not fault[1].any()
    assert rows[0, fault[0], Column.T][0] == pytest.approx(lost_s, abs=2e-3)
    before, after = ~fault[0], np.flatnonzero(fault[0])[1:]
    assert (tips[before, Tip.ACTIVE] == 1).mean() > 0.9
    assert not tips[after, Tip.ACTIVE].any()
    assert not rows[:, after, Column.CONTACT].any()
    assert not rows[0, after, Column.ETA].any()
    # The winding alone lets go of the current, in L/R = 0.1 ms.
    torque = np.abs(rows[1, :, Column.TORQUE])
    assert torque[after[-1]] < 0.1 * torque[before].max()


@pytest.mark.long
def test_a_corner_whose_frames_come_faster_than_they_are_written(tmp_path: Path) -> None:
    """Of frames that wait the newest counts; the tip rests in both planes, as it does on golden."""
    planes = "".join(PLANE.format(normal=normal) for normal in ([0.8, 0.6, 0], [-0.6, 0.8, 0]))
    content = (
        f'{HEAD}[device]\nkinematics = "planar"\nhome_rad = [0.0, 1.570796]\n{planes}'
        f"{PRESS.format(direction=[0.1, -1.0, 0.0])}{MOTOR * 2}{REAL}{CONTROL}{HELD}"
    )
    sets = ("controller.tick_hz=100e3", "controller.clock_hz=32e6", "device.update_hz=100e3",
            "device.delay_s=0", "scene.duration_s=0.1")  # fmt: skip
    device = load(tmp_path, content, *sets)
    assert device.space is not None
    rows, tips = kept_rows(device, "pins")
    rest = tips[-2_000:]
    assert (rest[:, Tip.ACTIVE] == 2).all()
    assert not rows[:, :, Column.FAULT].any()
    moved = rest[:, Tip.X : Tip.Z + 1].mean(axis=0) - np.array(device.space.home_m)
    force = rest[:, Tip.FORCE_X : Tip.FORCE_Z + 1]
    hand = 500 * (0.004 * np.array([0.1, -1.0, 0.0]) / np.hypot(0.1, 1.0) - moved)
    assert np.abs(force.mean(axis=0) + hand).max() < 0.01
    assert np.linalg.norm(moved) < 0.55e-3
    assert force.std(axis=0).max() < 0.01 * np.linalg.norm(force.mean(axis=0))


@pytest.mark.long
@pytest.mark.parametrize(("name", "error_m", "across"), [
    ("phantom_plane", 2.5e-5, 0.03), ("planar_disc", 6e-5, 0.04),
])  # fmt: skip
def test_whole_scenes_feel_as_on_golden(tmp_path: Path, name: str, error_m: float, across: float):
    """At a rate that a board's clock has time for."""
    sets = ("controller.tick_hz=160e3",)
    device = load_device(find_scene(name), sets)
    assert check_device(device, "pins") == []
    found = run_device(device, "pins", tmp_path)
    golden = measure_device(load_device(find_scene(name), (*sets, latency(device))), "golden")
    assert all("faults" not in one for one in found["motors"].values())
    assert found["tip_stiffness"] == pytest.approx(golden["tip_stiffness"], rel=0.01)
    assert found["tip_stiffness"] == pytest.approx(found["tip_stiffness_predicted"], rel=0.03)
    assert found["surface_error_max_m"] < error_m
    assert found["tangential_part"] < across
    assert found["contact_fraction"] == pytest.approx(golden["contact_fraction"], abs=0.01)
    assert found["contact_energy_ratio"] == pytest.approx(
        golden["contact_energy_ratio"], rel=0.1, abs=0.02
    )
    assert (tmp_path / TIP_PICTURE).stat().st_size > 20_000
    assert load_trace(tmp_path / TIP_TRACE)["active"].max() == 1


def test_the_clocks_of_a_round() -> None:
    """Those of wh_ports' header, of which a bench measures each."""
    assert turns_clocks(3, surfaces=8) == 413
    assert turns_clocks(3) == 102
    assert look_clocks(3, 8) == (64 + 18 + 52, 64 + 18 + 229)
    assert look_clocks(2, 1) == (32 + 38, 32 + 18 + 97)
    assert look_clocks(3, 0) == (0, 0)


@pytest.mark.parametrize(("sets", "fragments"), [
    (("controller.clock_hz=48e6", "controller.tick_hz=500e3"),
     ("a tick of 96 clocks is shorter than the 217", "2 motors with 1 surface", "clock_hz >=")),
    (("adc.part=MAX11125",), ("adc.part = MAX11125 has a channel for each motor", "another part")),
    (("controller.extra_ticks=0",),
     ("controller.extra_ticks = 0 is less than", "extra_ticks = 1")),
    (("surface.0.stiffness=9000",), ("surface.0.stiffness=9000", "that or less")),
    (("thermal.start_c=80",), ("[thermal] of a motor", "leave it out")),
])  # fmt: skip
def test_what_pins_refuses_of_a_device(tmp_path: Path, sets, fragments) -> None:
    with pytest.raises(SceneError) as refused:
        check_device(pressed(tmp_path, *sets), "pins")
    message = str(refused.value)
    assert message.isprintable()
    for fragment in fragments:
        assert fragment in message


def test_a_latency_that_contact_would_change_is_refused(tmp_path: Path) -> None:
    """One sample in the middle of a tick whose end comes between the two latencies."""
    for clock_hz, natural in (("44e6", None), ("34e6", 1), ("51e6", 0)):
        scene = pressed(tmp_path, f"controller.clock_hz={clock_hz}").scenes[0]
        laid = partial(timing, scene, scene_frame(scene), 1, 2, surfaces=1)
        if natural is None:
            with pytest.raises(SceneError, match=r"a tick of 440 clocks later .* take another"):
                laid()
        else:
            assert laid().extra_ticks - laid().hold_ticks == natural


def test_a_surface_of_one_motor_is_a_wall(tmp_path: Path) -> None:
    content = (
        f'{HEAD}[device]\nkinematics = "matrix"\njacobian = [[0.02], [0], [0]]\n'
        + PLANE.format(normal=[1, 0, 0]) + MOTOR + CONTROL
    )  # fmt: skip
    said = told(tmp_path, content, controller="pins")
    assert "[[surface]] of a single motor is not for `pins`" in said
    assert "controller.walls" in said


def test_a_clock_that_no_board_has_is_told(tmp_path: Path) -> None:
    device = find_scene("planar_disc")
    (line,) = check_device(load_device(device), "pins")
    assert line == (
        "`pins` has a clock of 220 MHz for this tick; a board's 48 MHz has time for "
        "controller.tick_hz = 2.21e+05 Hz"
    )
    assert check_device(load_device(device, ["controller.tick_hz=220e3"]), "pins") == []
