# SPDX-License-Identifier: Apache-2.0
"""The scope with a planar arm: what its feed tells, and its page on a virtual board."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import wavehaptics as wh
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from test_client import TIMEOUT_S
from test_host_planes import Device as PlanesDevice
from test_scope_browser import BROWSER, DRIVER, Page, opened
from wavehaptics.controller.planes import PLANE_ROW
from wavehaptics.host.client import Client
from wavehaptics.host.names import HostError
from wavehaptics.host.scope.arm import ArmBench
from wavehaptics.motor.tip_hand import LED, hand_words, lead, put_hand
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import find_scene, load_device
from wavehaptics.words import formats, modbus
from wavehaptics.words.table import WORDS

SCENE = "live_arm"
PICTURE = ROOT / "build" / "tests" / "scope_arm.png"
START_S, END_S = 600, 120
K_T, CELL_RAD, LINK_M, RATIO = 60.3e-3, 2 * math.pi / 40_000, 0.14, 8


class Device(PlanesDevice):
    """That of two motors, whose positions and currents a test writes."""

    def __init__(self) -> None:
        super().__init__()
        self.put(2 * modbus.IDENTIFICATION.index("motors"), [2])
        self.place([0, 0], [0.0, 0.0])

    def place(self, counts: list[int], currents: list[float]) -> None:
        for motor, (count, current) in enumerate(zip(counts, currents, strict=True)):
            raw = WORDS["current"].fixed.to_raw(current) & 0xFFFFFFFF
            self.put(modbus.word_register(WORDS["position"].at(motor)), [count & 0xFFFFFFFF])
            self.put(modbus.word_register(WORDS["current"].at(motor)), [raw])


@pytest.fixture
def device() -> Iterator[Device]:
    found = Device()
    found.start()
    yield found
    found.close()


def joints(counts: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Elbow and tip of the scene's arm, m."""
    first, second = (np.array(counts) + 0.5) * CELL_RAD / RATIO
    both = first + second + math.pi / 2
    elbow = LINK_M * np.array([math.cos(first), math.sin(first)])
    return elbow, elbow + LINK_M * np.array([math.cos(both), math.sin(both)])


def test_a_row_has_the_tip_and_a_frame_the_plane_below_it(device: Device) -> None:
    scene = load_device(find_scene(SCENE))
    bench = ArmBench(Client(device.path, timeout_s=TIMEOUT_S), scene)
    counts, currents = [-4900, 4700], [0.3, -0.2]
    device.place(counts, currents)
    row = bench.renew()
    elbow, tip = joints(counts)
    assert (row["elbow_x"], row["elbow_y"]) == pytest.approx(elbow.tolist(), abs=1e-7)
    assert (row["tip_x"], row["tip_y"]) == pytest.approx(tip.tolist(), abs=1e-7)
    step = np.eye(2) * 10
    jacobian = np.array([
        (joints(list(counts + d))[1] - joints(list(counts - d))[1]) / (20 * CELL_RAD) for d in step
    ]).T  # fmt: skip
    force = np.linalg.solve(jacobian.T, K_T * np.array(currents))
    assert (row["force_x"], row["force_y"]) == pytest.approx(force.tolist(), rel=1e-3)
    # The disc is near, the edge is not: the frame has one plane, whose G is Jᵀn per count.
    ((words, _),) = device.frames
    inward = np.array([0.14, 0.09]) - tip
    along = jacobian.T @ inward
    raws = [words[8 * PLANE_ROW + 2 + n] for n in range(2)]
    found = [formats.SURFACE.to_value(raw - (raw >> 31 << 32)) for raw in raws]
    assert found == pytest.approx((along / np.linalg.norm(along)).tolist(), abs=1e-3)
    assert 8 * (PLANE_ROW + 2) not in words
    shown = json.loads(json.dumps(bench.shown(), allow_nan=False))
    assert [shape["kind"] for shape in shown["shapes"]] == ["sphere", "plane", "plane"]
    left, low, right, high = shown["view"]
    assert left < 0 < 0.14 < right
    assert low < 0 < 0.19 < high


def test_a_stretched_arm_keeps_what_it_has(device: Device) -> None:
    """Straight along x, nothing moves the tip along the disc's normal there."""
    scene = load_device(find_scene(SCENE), ["surface.0.point_m=[0.31, 0.0, 0]"])
    bench = ArmBench(Client(device.path, timeout_s=TIMEOUT_S), scene)
    device.place([0, round(-math.pi / 2 * RATIO / CELL_RAD)], [0.0, 0.0])
    row = bench.renew()
    assert row["tip_x"] == pytest.approx(0.28, abs=1e-6)
    assert not device.frames


def test_an_arm_needs_surfaces_on_the_device(device: Device) -> None:
    device.put(modbus.word_register(WORDS["surfaces"].at()), [0])
    with pytest.raises(HostError, match="has no surfaces"):
        ArmBench(Client(device.path, timeout_s=TIMEOUT_S), load_device(find_scene(SCENE)))


def test_a_hand_that_is_led_goes_on_from_where_it_is() -> None:
    space = load_device(find_scene(SCENE)).space
    assert space is not None
    words, place, speed = hand_words(space), np.zeros(3), np.zeros(3)
    lead(words, 2.0, np.array([0.1, 0.0, 0.0]))
    lead(words, 3.0, np.array([0.0, -0.2, 0.0]))
    assert words[0] == LED
    put_hand(words, 3.5, place, speed)
    assert place == pytest.approx(np.add(space.home_m, [0.1, -0.1, 0.0]))
    assert speed.tolist() == [0.0, -0.2, 0.0]


@pytest.mark.parametrize(("options", "told"), [
    (["planar_disc", "--motors", "3"], "--motors: the scene's [device] says that; leave it out"),
    (["phantom_plane"], 'has kinematics = "planar" alone'),
    (["teleoperation"], "[coupling] is not for `pins`"),
    (["live_arm", "--set", "motors.elbow.encoder.counts_per_rev=400"], "are alike; leave what"),
])  # fmt: skip
def test_what_a_virtual_board_of_an_arm_refuses(options: list[str], told: str) -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "wavehaptics", "board", "--virtual", *options],
        text=True, capture_output=True, timeout=END_S, check=False,
    )  # fmt: skip
    assert ended.returncode == 2
    (line,) = ended.stderr.splitlines()
    assert told in line


@pytest.mark.long
def test_python_has_the_arm_too() -> None:
    """A hand that nobody leads stays, and so does the tip; the arm is the scene's."""
    with wh.Board.virtual(SCENE) as board:
        planes = board.planes(SCENE)
        home = np.array([0.14, 0.14, 0.0])
        until = time.monotonic() + END_S
        while np.abs(planes.tip() - home).max() > 1e-5:  # it was led away in its first tick
            assert time.monotonic() < until
        up = np.array([0.0, 1.0, 0.0])
        stamp = planes.set_shapes([wh.Shape("plane", home - 1e-3 * up, up)])
        state = planes.state
        assert (state.stamp, state.refused, state.acting) == (stamp, "", 0)


@pytest.mark.long
@pytest.mark.skipif(not (BROWSER and DRIVER), reason="Chromium and its driver are not installed")
def test_the_tip_is_dragged_onto_the_disc(tmp_path: Path) -> None:
    """With the mouse into the disc and along it: the tip stays on its edge, and the page tells it.

    Where the virtual board has them, real forces: the hand's spring, along the disc's normal.
    """
    with opened(tmp_path, "--virtual", SCENE) as page:
        _drag_along(page)


def _drag_along(page: Page) -> None:
    browser = page.browser
    browser.get(page.address)
    page.until(lambda: page["link"] == "off", START_S)
    page.until(lambda: "arm it" in page["hint"], START_S)
    assert not browser.find_element(By.ID, "stage").is_displayed()
    canvas = browser.find_element(By.ID, "arm-stage")
    assert canvas.is_displayed()
    script = """const state = document.body.dataset.view.split(" ").map(Number),
        {clientWidth: w, clientHeight: h} = document.getElementById("arm-stage");
        const scale = Math.min(w / (state[2] - state[0]), h / (state[3] - state[1]));
        return [scale, (state[0] + state[2]) / 2, (state[1] + state[3]) / 2]"""
    scale, middle_x, middle_y = browser.execute_script(script)
    page.arm()
    browser.execute_script("window.scrollTo(0, 0)")
    move = ActionChains(browser, duration=0)
    middle, radius = np.array([0.14, 0.09]), 0.03
    held = False
    seen = []
    for angle in [90, 90, 90, 84, 78, 72, 66, 60, 60]:
        way = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
        depth = 0.05 if not held else 0.022
        place = middle + depth * way
        move.move_to_element_with_offset(
            canvas, round(scale * (place[0] - middle_x)), round(scale * (middle_y - place[1]))
        )
        if not held:
            move.click_and_hold()
            held = True
        move.perform()
        page.elapse(0.3)
        assert page["link"] == "on", page["line"]
        row = json.loads(browser.execute_script("return document.body.dataset.tip"))
        seen.append((way, row))
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    browser.save_screenshot(str(PICTURE))
    for way, row in (seen[2], seen[-1]):
        tip = np.array([row["tip_x"], row["tip_y"]]) - middle
        force = np.array([row["force_x"], row["force_y"]])
        hand = np.array([row["hand_x"], row["hand_y"]]) - middle - tip
        assert row["acting"] == 1
        assert radius - 1e-3 < np.linalg.norm(tip) < radius + 5e-4
        assert force == pytest.approx(-300 * hand, abs=0.15 * 300 * np.linalg.norm(hand))
        assert force @ way > 1.0
    browser.find_element(By.ID, "stop").click()
    page.until(lambda: page["link"] == "off", 5)
    logged = [one for one in browser.get_log("browser") if one["level"] == "SEVERE"]
    assert not logged
    assert re.search(r"\d N$", page["force"])
