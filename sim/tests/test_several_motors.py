# SPDX-License-Identifier: Apache-2.0
"""A virtual board with several motors, and what the commands say of each of them."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator

import numpy as np
import pytest
from test_virtual_board import BOARD, TOP, command, refused, run, start, stop, told, value
from wavehaptics.host.names import Shape, settings
from wavehaptics.host.scope.bench import Known
from wavehaptics.host.scope.feed import Feed
from wavehaptics.host.scope.plug import Plug
from wavehaptics.ladder import pins_loop
from wavehaptics.ladder.linked_motors import LinkedMotors
from wavehaptics.ladder.linked_pins import LinkedPins
from wavehaptics.ladder.pins import pass_clocks
from wavehaptics.scene import SceneError, find_scene, load_scene
from wavehaptics.trace.columns import load_trace
from wavehaptics.words.memory import settings_requests
from wavehaptics.words.table import WORDS

MOTORS = 3
SLOW = ("controller.tick_hz=400e3", "controller.extra_ticks=2")
"""Ticks that are long enough for three motors."""
MEASURED = ("drive.bus_measured=true", "drive.bus_actual_v=11")
SHAPE = Shape(MOTORS, 4, 0, 10)


# ---- The simulation.


@pytest.mark.parametrize(
    "more", [(), ("friction.coulomb_nm=1e-4", "adc.noise_a=1e-3", "adc.bandwidth_hz=800e3")]
)
def test_one_of_them_is_the_board_of_one_motor(more):
    """Clock by clock the same motor, ideal and real, with the bridges on."""
    scene = load_scene(find_scene("press_hold"), (*BOARD, *more))
    one, many = LinkedPins(scene, arm=False), LinkedMotors(scene, 1, arm=False)
    one.elapse(5_000)
    clocks = one.clock_cycles
    pass_clocks(clocks, many._all, many._each)
    state, kept, *_ = many._each[0].parts
    assert kept[pins_loop.NOW] == clocks
    for place in (pins_loop.COUNT, pins_loop.SHIFT, pins_loop.HELD, pins_loop.ADVANCED):
        assert kept[place] == one._kept[place]
    np.testing.assert_array_equal(state, one._state)
    assert np.abs(state).max() > 1e-3


def test_each_motor_has_its_own_settings_and_hand():
    """All begin as the scene has them; the hand that is led is the one that was asked for."""
    scene = load_scene(find_scene("press_hold"), (*BOARD, *SLOW))
    pins = LinkedMotors(scene, MOTORS, led=2)
    where = [pins.place_rad(motor) for motor in range(MOTORS)]
    assert where == [where[0]] * MOTORS
    pins.elapse(100)
    pins.lead_hand(3.0)
    pins.elapse(5_000)
    moved = [pins.place_rad(motor) - where[0] for motor in range(MOTORS)]
    assert moved[0] == moved[1]
    assert abs(moved[2] - moved[0]) > 1e-3


def test_requests_of_a_further_motor():
    """They are its own words, as many as the first one's, and none of the board's."""
    values = {"root": 5, "wall_min": [1, 2], "half_clocks": 24}
    first, second = (dict(settings_requests(values, motor=motor)) for motor in (0, 1))
    assert second == {WORDS["root"].at(1): 5, WORDS["wall_min"].at(1): 1,
                      WORDS["wall_min"].at(1, 1): 2}  # fmt: skip
    assert first == {WORDS["root"].at(): 5, WORDS["wall_min"].at(): 1,
                     WORDS["wall_min"].at(0, 1): 2, WORDS["half_clocks"].at(): 24}  # fmt: skip


@pytest.mark.parametrize(
    ("sets", "message"),
    [
        (
            (*BOARD, "controller.extra_ticks=4", "controller.clock_hz=48e6"),
            r"a tick of 48 clocks is shorter than the 102 that `pins` needs for 3 motors",
        ),
        ((*BOARD, *SLOW, "thermal.ambient_c=25"), r"thermal is simulated for one motor, and"),
        ((*BOARD, *SLOW, *MEASURED), r"drive.bus_measured is for a single motor on `pins`; set"),
    ],
)
def test_scenes_that_several_motors_refuse(sets, message):
    with pytest.raises(SceneError, match=message):
        LinkedMotors(load_scene(find_scene("press_hold"), sets), MOTORS)


# ---- The commands.


@pytest.fixture(scope="module")
def port() -> Iterator[str]:
    sets = [word for text in SLOW for word in ("--set", text)]
    process, path = start("--motors", str(MOTORS), *sets)
    yield path
    assert stop(process) == 0


def test_words_of_each_motor(port):
    """Written for one motor they are that one's, and a session has them all."""
    assert "motors          3\n" in told(port, "info")
    before = [value_of(port, "root", motor) for motor in range(MOTORS)]
    assert told(port, "set", "root=1.9375", "--motor", "2") == ""
    assert [value_of(port, "root", motor) for motor in range(MOTORS)] == [*before[:2], 1.9375]
    lines = told(port, "watch", "--csv", "-n", "1", "root", "position", "--motor", "2").splitlines()
    assert lines[0] == "t_s,root,position"
    assert lines[1].split(",")[1] == "1.9375"
    told(port, "set", f"root={before[2]!r}", "--motor", "2")
    assert re.match(
        r"root: the device has no motor 3; take --motor 0...2",
        refused(port, "get", "root", "--motor", "3", "--timeout", "60"),
    )


def value_of(port: str, name: str, motor: int) -> float:
    return float(told(port, "get", name, "--motor", str(motor)).split()[1])


@pytest.mark.long
def test_a_session_of_three(port, tmp_path):
    """Motor 2's word goes through the file, and only that differs."""
    file = tmp_path / "all.toml"
    count = len(settings(SHAPE))
    assert told(port, "save", str(file)) == f"{file}: {count} words\n"
    before = value_of(port, "a", 2)
    told(port, "set", "a=0.25", "--motor", "2")
    assert told(port, "load", str(file)) == f"{file}: {count} words, of which 1 were others\n"
    assert value_of(port, "a", 2) == before


@pytest.mark.long
def test_a_wall_of_one_motor_alone(port, tmp_path):
    """While all are armed, motor 2 has its wall where the others have none: capture, stream."""
    for motor in range(MOTORS):
        told(port, "set", "wall_enable[0]=0", "--motor", str(motor))
    edge = TOP // 2
    told(port, "set", f"wall_min[0]={edge}", f"wall_max[0]={edge + 3000}", "wall_enable[0]=1",
         "--motor", "2")  # fmt: skip
    arming = command("arm", "--timeout", "60", env={"WH_PORT": port})
    try:
        assert arming.stdout.readline() == "armed; Ctrl-C disarms\n"
        told(port, "capture", "position", "flags", "position@0", "flags@0", "--motor", "2",
             "--trigger", "contact", "--out", str(tmp_path))  # fmt: skip
    finally:
        arming.send_signal(2)
        arming.communicate(timeout=300)
    found = load_trace(tmp_path / "trace.npz")
    assert found["contact"].any()
    alone = found["flags@0"].astype(int) & 1
    assert not alone.any()


@pytest.mark.long
def test_a_stream_of_two_motors(port, tmp_path):
    """Words of both side by side, of a motor by --motor and of another by its name."""
    told(port, "stream", "position", "position@0", "--motor", "2", "--seconds", "0.002",
         "--counts-per-rev", "10000", "--out", str(tmp_path))  # fmt: skip
    found = load_trace(tmp_path / "trace.npz")
    assert len(found["t"]) > 100
    assert {"x", "position@0"} <= {*found}
    assert np.isfinite(found["x"]).all()


@pytest.mark.long
def test_a_board_that_is_a_board_has_its_motors(tmp_path):
    """The scene of a board with three motors is that board; --motors makes it another."""
    link = tmp_path / "board"
    process = command("--virtual", "boards/ulx3s_three/board.toml", "--link", str(link))
    try:
        assert process.stdout.readline().startswith("/dev/")
        assert "motors          3\n" in told(str(link), "info")
        assert value(str(link), "faults") == 0
        before = value_of(str(link), "a", 0)
        arming = command("arm", "--timeout", "60", env={"WH_PORT": str(link)})
        try:
            assert arming.stdout.readline() == "armed; Ctrl-C disarms\n"
            told(str(link), "set", "a=0.25", "--motor", "2")
            assert value(str(link), "running") == 1
            assert value_of(str(link), "a", 2) == 0.25
            assert value_of(str(link), "a", 0) == before
        finally:
            arming.send_signal(2)
            arming.communicate(timeout=300)
    finally:
        assert stop(process) == 0


def test_a_hand_of_no_motor(tmp_path):
    status, out, err = run("", "--virtual", "press_hold", "--hand", str(tmp_path / "hand"),
                           "--hand-of", "1")  # fmt: skip
    assert (status, out) == (2, "")
    assert err == "wavehaptics: --hand-of 1: there is no such motor; take 0...0\n"


def test_a_virtual_board_has_one_brushless_motor():
    status, out, err = run("", "--virtual", "live_brushless", "--motors", "2")
    assert (status, out) == (2, "")
    assert err == "wavehaptics: --motors 2: a virtual board has one brushless motor; take 1\n"


# ---- The scope.


WALL = ("controller.tick_hz=16e3", "controller.extra_ticks=2")
"""Of live_wall, whose W takes clocks as well."""


def wait(done, end_s: float = 300.0) -> None:
    end = time.monotonic() + end_s
    while not done():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_the_scope_shows_the_motor_that_was_asked_for(tmp_path):
    """Streamed: the hand that is led turns motor 2, whose wall is moved, and motor 0 stays."""
    sets = [word for text in WALL for word in ("--set", text)]
    link, hand = tmp_path / "board", tmp_path / "hand"
    process = command("--virtual", "live_wall", *sets, "--motors", "3", "--link", str(link),
                      "--hand", str(hand), "--hand-of", "2")  # fmt: skip
    feeds = []
    try:
        assert process.stdout.readline().startswith("/dev/")
        known = Known.of_scene(find_scene("live_wall"), WALL, starts=True)
        places_ = {}
        for motor in (2, 0):
            plug = Plug(str(link), hand if motor == 2 else None)
            feed = Feed(plug, known, unit=1, motor=motor, timeout_s=60.0)
            feeds.append(feed)
            feed.start()
            wait(lambda feed=feed: feed.state()["row_hz"])
            if motor == 2:
                wait(lambda feed=feed: feed.state()["hand"] is not None)
                feed.ask(lambda bench: bench.slide("wall", 0.05)).result(300.0)
                feed.lead(-0.02)
            else:
                assert feed.state()["wall"][0] == pytest.approx(0.0, abs=1e-9)
            count = len(feed.kept)
            wait(lambda feed=feed, count=count: len(feed.kept) > count + 300)
            places_[motor] = feed.fresh()[-1]["x"]
            feed.end()
        assert feeds[0].state()["wall"][0] == pytest.approx(0.05, abs=1e-3)
        assert places_[2] == pytest.approx(-0.02, abs=5e-3)
        assert abs(places_[0] - places_[2]) > 0.01
        unknown = Feed(Plug(str(link)), known, unit=1, motor=3, timeout_s=60.0)
        feeds.append(unknown)
        unknown.start()
        wait(lambda: "no motor 3; take --motor 0...2" in unknown.state()["problem"])
    finally:
        for feed in feeds:
            feed.end()
        assert stop(process) == 0
