# SPDX-License-Identifier: Apache-2.0
"""The scope in a real browser without a screen, against the virtual board: as a newcomer has it."""

from __future__ import annotations

import csv
import io
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.chrome.webdriver import WebDriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from wavehaptics.cli.board.scope import SCOPE_SCENE
from wavehaptics.host.scope.feels import FEELS, PLAY
from wavehaptics.laws import closed_forms
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.terminals import check_terminals
from wavehaptics.scene import find_scene, load_scene

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-dev-shm-usage", "--window-size=1360,1220",
)  # fmt: skip
START_S = 600
"""The RTL is built first, where that hasn't been done."""
END_S = 120
PICTURE = ROOT / "build" / "tests" / "scope.png"
TRIES = 5
VIEW_RAD, MARGIN = 0.7, 34
"""How much of the rotor's way the stage shows, and what it leaves beside it, px."""
LEAST, MOST = 0.1, 0.25
"""Places of the hand between which it presses, rad."""

pytestmark = pytest.mark.skipif(
    not (BROWSER and DRIVER), reason="Chromium and its driver are not installed: make setup"
)


class Page:
    """The page in the browser, and the command that serves it."""

    def __init__(self, command: subprocess.Popen, address: str, browser: WebDriver) -> None:
        self.command, self.address, self.browser = command, address, browser
        self._at = None

    def __getitem__(self, name: str) -> str:
        """Text of an element, with a minus that Python reads."""
        script = "return document.getElementById(arguments[0]).innerText"
        return self.browser.execute_script(script, name).replace("−", "-").strip()

    def click(self, name: str) -> None:
        self.browser.find_element(By.ID, name).click()

    def until(self, done: Callable[[], bool], end_s: float = END_S) -> None:
        end = time.monotonic() + end_s
        while not done():
            assert time.monotonic() < end, f"{self['link']}: {self['line']}"
            time.sleep(0.02)

    @property
    def time_s(self) -> float:
        """Device's time of the newest row, s."""
        return float(self.browser.execute_script("return document.body.dataset.time") or 0)

    def elapse(self, device_s: float) -> None:
        end = self.time_s + device_s
        self.until(lambda: self.time_s >= end)

    def drag(self, places: list[float], device_s: float) -> None:
        """Lead the hand with the mouse from place to place, rad; so long at each."""
        stage = self.browser.find_element(By.ID, "stage")
        self.browser.execute_script("window.scrollTo(0, 0)")
        scale = (stage.size["width"] - 2 * MARGIN) / VIEW_RAD
        for place in places:
            move = ActionChains(self.browser, duration=0)
            move.move_to_element_with_offset(stage, round(place * scale), 0)
            if self._at is None:
                move.click_and_hold()
            move.perform()
            self._at = place
            self.elapse(device_s)

    def release(self) -> None:
        ActionChains(self.browser, duration=0).release().perform()
        self._at = None

    def arm(self) -> None:
        """Arm, where it isn't; the mouse that drags lets go for that.

        Once more where a busy machine kept the board from answering in time, which the page says.
        """
        for _ in range(TRIES):
            self.until(lambda: self["link"] in ("on", "off"))
            if self["link"] == "on":
                return
            if self._at is not None:
                self.release()
            before = self["line"]
            self.click("arm")
            self.until(lambda told=("", before): self["link"] == "on" or self["line"] not in told)
        raise AssertionError(self["line"])

    def press(self) -> None:
        """Into the wall, deeper and less deep, slowly: a pressing finger takes a second.

        Once more where a busy machine made the page so slow that it was taken for hung.
        """
        steps = [LEAST + (MOST - LEAST) * n / 8 for n in range(9)]
        for _ in range(TRIES):
            self.drag([-0.1], 0.05)
            self.arm()
            self.drag([0.0, LEAST, *steps, *reversed(steps)], 0.04)
            if self["link"] == "on":
                return
        raise AssertionError(self["line"])

    def plotted(self) -> dict[str, list[float]]:
        """What stands beside each plot: newest values, in its unit."""
        script = """return [...document.querySelectorAll("#plots .name")].map(
            (head) => [head.querySelector("b").innerText, head.querySelector("output").value])"""
        return {
            name: [float(v) for v in re.findall(r"-?[\d.]+(?:e-?\d+)?", text.replace("−", "-"))]
            for name, text in self.browser.execute_script(script)
        }

    def slide(self, name: str, part: float) -> None:
        """Move a slider to a part of its way."""
        script = """const slider = document.getElementById(arguments[0]);
            slider.value = 1000 * arguments[1]; slider.dispatchEvent(new Event("input"))"""
        self.browser.execute_script(script, f"slider-{name}", part)

    def fetched(self, path: str) -> str:
        script = "fetch(arguments[0]).then((a) => a.text()).then(arguments[1])"
        return self.browser.execute_async_script(script, path)


def children(pid: int) -> list[int]:
    """Processes that a process has started."""
    return [
        int(child)
        for task in Path(f"/proc/{pid}/task").iterdir()
        for child in (task / "children").read_text().split()
    ]


@contextmanager
def opened(folder: Path, *words: str) -> Iterator[Page]:
    """The page of ``board scope`` in a browser whose profile is in ``folder``."""
    check_terminals()
    command = subprocess.Popen(
        [sys.executable, "-m", "wavehaptics", "board", "scope", *words, "--no-browser",
         "--http-port", "0"],
        text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={name: value for name, value in os.environ.items() if name != "WH_PORT"},
    )  # fmt: skip
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for flag in (*FLAGS, f"--user-data-dir={folder / 'browser'}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    try:
        address = command.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=\S{20,}", address)
        browser = webdriver.Chrome(options, Service(DRIVER))
        try:
            yield Page(command, address, browser)
        finally:
            browser.quit()
    finally:
        command.terminate()
        try:
            _, error = command.communicate(timeout=END_S)
        finally:
            command.kill()
    assert (command.returncode, error) == (0, "")


@pytest.fixture
def page(tmp_path) -> Iterator[Page]:
    with opened(tmp_path) as found:
        yield found


@pytest.mark.long
def test_a_feel_by_one_click(page):
    """A joystick: the finger's spring against the motor's, on the page and in the board."""
    scene = load_scene(find_scene(SCOPE_SCENE))
    page.browser.get(page.address)
    page.until(lambda: "arm it" in page["hint"], START_S)
    page.click("feel-joystick")
    page.until(lambda: "move it first" in page["line"])  # its spring would begin at the rotor
    pressed = "return [...document.querySelectorAll('#feels [aria-pressed=true]')].map((b) => b.id)"
    for _ in range(TRIES):  # a board that was away for a while has other settings on the page
        page.drag([0.0], 0.06)
        page.release()
        page.click("feel-joystick")
        page.elapse(0.1)
        if page.browser.execute_script(pressed) != ["feel-joystick"]:
            continue
        page.arm()
        page.drag([LEAST, 2 * LEAST], 0.06)
        page.until(lambda: page["link"] != "on" or page.plotted()["Place"][1] > 1999 * LEAST)
        page.elapse(0.1)
        if page["link"] == "on":
            break
    rotor, hand = page.plotted()["Place"]
    (torque,) = page.plotted()["Torque"]

    control, motor = scene.controller, scene.motor
    most = 1 / (control.extra_ticks + 1 / closed_forms.MOST_A) * control.tick_hz
    port_ohm = control.r_hat_part * motor.R_ohm
    rigid = closed_forms.stiffness(motor.k_t, motor.L_h, port_ohm, 1 / most)
    spring, finger = FEELS["joystick"].stiffness * rigid, scene.hand.stiffness
    assert float(page["k-design"]) == pytest.approx(spring, rel=0.005)  # its three digits
    assert hand == pytest.approx(2e3 * LEAST, abs=3)
    face = 200 * PLAY  # mrad
    place = (finger * hand + spring * face) / (finger + spring)
    assert rotor == pytest.approx(place, rel=0.03)
    assert torque == pytest.approx(-spring * (rotor - face), rel=0.03)

    # The board's own rows say the same.
    address = page.browser.find_element(By.ID, "csv").get_attribute("href")
    last = list(csv.DictReader(io.StringIO(page.fetched(address))))[-1]
    assert 1e3 * float(last["x"]) == pytest.approx(rotor, rel=0.03)
    assert 1e3 * motor.k_t * float(last["i"]) == pytest.approx(torque, rel=0.05)
    page.release()
    assert [line["message"] for line in page.browser.get_log("browser")] == []


def test_as_a_newcomer_has_it(page):
    """Arm, press, another λ, stop; a page that hangs; the plug pulled, and nothing lost."""
    scene = load_scene(find_scene(SCOPE_SCENE))
    browser = page.browser
    browser.get(page.address)
    page.until(lambda: page["link"] == "off", START_S)
    page.until(lambda: "arm it" in page["hint"], START_S)  # once it has heard of the hand
    page.click("record")

    # The wall pushes back with what the hand's spring presses.
    page.drag([-0.12], 0.0)
    page.press()
    page.drag([MOST], 0.2)
    seen = page.plotted()
    rotor, hand = seen["Place"]
    (torque,) = seen["Torque"]
    assert hand == pytest.approx(1e3 * MOST, abs=3)
    assert torque == pytest.approx(-scene.hand.stiffness * (hand - rotor), rel=0.05)

    def predicted(lambda_: float) -> float:
        control = scene.controller
        port_ohm = control.r_hat_part * scene.motor.R_ohm
        return closed_forms.stiffness(scene.motor.k_t, scene.motor.L_h, port_ohm, 1 / lambda_)

    def measured() -> tuple[float, float]:
        return float(page["k-fit"]), float(page["k-design"])

    # A count is 0.16 of 10 mrad, a row's values are read within 2 ms, and the anchor learns what is
    # wrong within some tens of ms. A turn outwards softens the next press by up to a count. 10 %
    # are above these together, and far below what λ changes.
    most = 1 / (scene.controller.extra_ticks + 1 / closed_forms.MOST_A) * scene.controller.tick_hz
    found, designed = measured()
    assert designed == pytest.approx(predicted(most), rel=0.005)  # three digits of 10.03
    assert found == pytest.approx(designed, rel=0.1)

    # Another λ: the closed form says another spring, and the wall is it.
    page.drag([LEAST, -0.05], 0.1)
    page.slide("lambda", 0.6)
    softer = most / 300**0.4
    page.until(lambda: float(page["k-design"]) < 0.6 * designed)
    page.press()
    found, designed = measured()
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    browser.save_screenshot(str(PICTURE))
    assert designed == pytest.approx(predicted(softer), rel=0.005)
    assert found == pytest.approx(designed, rel=0.1)
    page.release()

    # A value that the device doesn't have is told in one line.
    browser.find_element(By.ID, "word-text").send_keys("root=99\n")
    page.until(lambda: "out of range" in page["line"])
    assert "\n" not in page["line"]

    # A page that hangs keeps nothing on; nor does one that is told to stop.
    page.arm()
    browser.execute_script("const t = performance.now(); while (performance.now() - t < 2500);")
    page.until(lambda: page["link"] == "off" and "silent" in page["line"])
    page.arm()
    page.click("stop")
    page.until(lambda: page["link"] == "off", 5)

    # On a telephone nothing is wider than the screen, and the stop is in sight.
    size = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.execute_script("window.scrollTo(0, 1e5)")
    assert browser.execute_script("return document.documentElement.scrollWidth") <= 390
    at_the_foot = "return document.elementFromPoint(innerWidth - 60, innerHeight - 30).id"
    assert browser.execute_script(at_the_foot) == "stop"
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})

    # The plug is pulled: what was seen stays, and can be had.
    (board,) = children(page.command.pid)
    os.kill(board, signal.SIGKILL)
    page.until(lambda: page["link"] == "no answer")
    page.until(lambda: "has ended" in page["line"])
    assert page.plotted()["Place"][1] == pytest.approx(1e3 * LEAST, abs=3)
    page.click("record")
    page.until(lambda: page["record"] == "Record")
    address = browser.find_element(By.ID, "csv").get_attribute("href")
    rows = list(csv.DictReader(io.StringIO(page.fetched(address))))
    assert f"{len(rows)} rows" in page["rows"]
    pushed = -min(float(row["torque"]) for row in rows)
    assert pushed == pytest.approx(scene.hand.stiffness * MOST, rel=0.1)
    times = [float(row["t"]) for row in rows]
    assert times == sorted(times)
    browser.execute_script("""window.shown = new Set();
        const show = () => window.shown.add(document.body.textContent);
        new MutationObserver(show).observe(
            document.body, {subtree: true, childList: true, characterData: true});""")
    page.click("plug")
    page.until(lambda: page["link"] == "off")
    page.until(lambda: page.time_s > times[-1])
    page.until(lambda: re.fullmatch(r"simulated, [\d.]+ of real time", page["speed"]))
    # Nor was there anything meanwhile, in sight or not, that is no value.
    shown = browser.execute_script("return [...window.shown]")
    assert len(shown) > 1
    assert [text for text in shown if re.search(r"undefined|NaN|null", text)] == []

    # Nothing was refused that the page itself wanted.
    assert [line["message"] for line in browser.get_log("browser")] == []
