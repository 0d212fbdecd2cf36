# SPDX-License-Identifier: Apache-2.0
"""The live scope without a browser: who may ask, what sliders write, and who switches off."""

from __future__ import annotations

import asyncio
import csv
import io
import json
import math
import socket
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from types import SimpleNamespace

import aiohttp
import numpy as np
import pytest
from aiohttp.test_utils import TestClient, TestServer
from wavehaptics.controller.ports import controller_ports
from wavehaptics.host.led_hand import MOST_RAD_S, SETTLE_S, Follower, LedHand
from wavehaptics.host.names import HostError, Place, Shape, places
from wavehaptics.host.scope import command
from wavehaptics.host.scope import feed as feed_module
from wavehaptics.host.scope.bench import Bench, Known
from wavehaptics.host.scope.feed import PATIENCE_S, Feed
from wavehaptics.host.scope.kept import Kept
from wavehaptics.host.scope.plug import HandLine, Plug
from wavehaptics.host.scope.server import Scope, serve
from wavehaptics.ladder.brushless import magnet_words
from wavehaptics.ladder.run import stiffness_predicted
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.words import formats, modbus
from wavehaptics.words.memory import settings_requests
from wavehaptics.words.table import THREE_PHASE_LEGS

SCENE = "live_wall"
SHAPE = Shape(1, 4, 1, 10)
END_S = 10.0


def wait(done: Callable[[], bool], end_s: float = END_S) -> None:
    end = time.monotonic() + end_s
    while not done():
        assert time.monotonic() < end
        time.sleep(0.005)


def scene_words(*overrides: str) -> dict[int, int]:
    """Settings of the scene by their addresses, as the virtual board begins with them."""
    ports = controller_ports(load_scene(find_scene(SCENE), overrides))
    shaped = [int(on) for on in ports.settings.shaped]
    values = {**ports.words, **ports.settings.words(), **ports.wall_words(4),
              "wall_shaped": [*shaped, *[0] * (4 - len(shaped))]}  # fmt: skip
    return dict(settings_requests(values))


class Device:
    """What a client is to the scope, with the words of a scene; it notes what is written."""

    def __init__(self, *overrides: str, port: str = "") -> None:
        scene = load_scene(find_scene(SCENE), overrides)
        clock_hz = round(controller_ports(scene).timing.clock_hz)
        options = {"anchor": 1, "arm": 1, "shaper": 1}
        self.identification = SimpleNamespace(options=options, words={"clock_hz": clock_hz})
        self.shape = SHAPE
        self.words = scene_words(*overrides)
        self.written: list[dict[str, int]] = []
        self.silent = False
        self.delay_s = 0.001
        self.before_each: Callable[[], None] = lambda: None

    def read(self, wanted: list[Place]) -> list[int]:
        for _ in modbus.runs({(place.address, 0) for place in wanted}, modbus.MOST_READ):
            self.before_each()
            time.sleep(self.delay_s)
            if self.silent:
                raise HostError("no answer")
        return [self.words.get(place.address, 0) for place in wanted]

    def write(self, words: object) -> int:
        self.before_each()
        time.sleep(self.delay_s)
        if self.silent:
            raise HostError("no answer")
        given = dict(words)
        self.written.append({place.text: raw for place, raw in given.items()})
        for place, raw in given.items():
            self.words[place.address] = raw & 0xFFFFFFFF
            if place.text == "arm" and raw != 2:
                for name in ("armed", "running"):
                    self.words[places(name, SHAPE)[0].address] = raw
        return 1

    @property
    def armings(self) -> list[int]:
        return [words["arm"] for words in self.written if "arm" in words]


# ---- Who may ask.


def asked(what: Callable[[TestClient, Scope], Awaitable[None]]) -> None:
    """Run ``what`` at a scope whose board nobody has."""

    async def run() -> None:
        plug = Plug("/nowhere")
        scope = Scope(Feed(plug, Known(), unit=1, motor=0, timeout_s=1.0), plug)
        async with TestClient(TestServer(scope.app, host="127.0.0.1")) as client:
            await what(client, scope)

    asyncio.run(run())


def test_the_page_and_its_headers():
    async def check(client: TestClient, scope: Scope) -> None:
        answer = await client.get("/", params={"token": scope.token})
        assert answer.status == 200
        assert "default-src 'self'" in answer.headers["Content-Security-Policy"]
        assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
        assert answer.headers["Referrer-Policy"] == "no-referrer"
        text = await answer.text()
        assert "http" not in text.replace("viewport", "")
        for name in ("scope.js", "uPlot.iife.min.js", "scope.css", "icon.svg"):
            found = await client.get(f"/page/{name}")
            assert found.status == 200
            assert found.headers["X-Content-Type-Options"] == "nosniff"

    asked(check)


@pytest.mark.parametrize("path", ["/", "/live", "/trace.npz", "/trace.csv"])
@pytest.mark.parametrize("token", [None, "", "guessed"])
def test_without_the_token(path, token):
    async def check(client: TestClient, scope: Scope) -> None:
        origin = {"Origin": str(client.make_url("")).rstrip("/")}
        answer = await client.get(path, params={"token": token} if token else {}, headers=origin)
        assert answer.status == 403

    asked(check)


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1"]
)
def test_another_hosts_name(host):
    """What a page gets whose name has been pointed at this machine."""

    async def check(client: TestClient, scope: Scope) -> None:
        named = {"Host": host.format(port=client.port)}
        for path in ("/", "/page/scope.js", "/trace.npz"):
            answer = await client.get(path, params={"token": scope.token}, headers=named)
            assert answer.status == 403, path

    asked(check)


@pytest.mark.parametrize(
    "origin", [None, "null", "http://evil.example", "https://127.0.0.1:{port}", "http://127.0.0.1"]
)
def test_another_origin(origin):
    async def check(client: TestClient, scope: Scope) -> None:
        token = {"token": scope.token}
        headers = {"Origin": origin.format(port=client.port)} if origin else {}
        with pytest.raises(aiohttp.WSServerHandshakeError) as refusal:
            await client.ws_connect("/live", params=token, headers=headers)
        assert refusal.value.status == 403
        answer = await client.post("/", params=token, headers=headers)
        assert answer.status == 403

    asked(check)


def test_who_may():
    """The page itself; what it asks wrongly is told in one line, and closes nothing."""

    async def check(client: TestClient, scope: Scope) -> None:
        origin = f"http://127.0.0.1:{client.port}"
        page = await client.ws_connect("/live", params={"token": scope.token}, origin=origin)
        assert (await page.receive_json())["type"] == "hello"
        for text in ("{", "[]", "{}", '{"type":"reboot"}', '{"type":"hand"}', '{"type":"slide"}'):
            await page.send_str(text)
        await page.send_json({"type": "arm"})
        told = []
        while len(told) < 7:
            message = await page.receive_json(timeout=END_S)
            if message["type"] == "told":
                told.append(message["problem"])
            else:
                assert (message["type"], message["live"]) == ("state", False)
        assert sorted(told)[-1].startswith("there is no board")
        assert sorted(told)[:-1] == ["the page asks for something unknown; load it anew"] * 6

    asked(check)


def test_it_is_on_loopback_alone():
    async def run() -> None:
        plug = Plug("/nowhere")
        scope = Scope(Feed(plug, Known(), unit=1, motor=0, timeout_s=1.0), plug)
        ended, told = asyncio.Event(), []
        task = asyncio.create_task(serve(scope, 0, ended, told.append))
        while not told:
            await asyncio.sleep(0.01)
        assert told[0].startswith("http://127.0.0.1:")
        port = int(told[0].split(":")[2].split("/")[0])
        with socket.socket() as other:
            other.settimeout(1.0)
            assert other.connect_ex(("127.0.0.2", port)) != 0
        with pytest.raises(OSError, match="in use"):
            await serve(scope, port, ended, told.append)
        ended.set()
        await task

    asyncio.run(run())


def test_a_port_that_is_taken():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(HostError, match=f"port {port} is taken; name another one with"):
            command.run(
                Plug("/nowhere"), Known(), http_port=port, browser=False, unit=1, motor=0,
                timeout_s=1.0,
            )  # fmt: skip


# ---- What sliders write.


@pytest.fixture
def bench() -> Bench:
    path = find_scene(SCENE)
    return Bench(Device(), Known.of_scene(path, (), starts=True))


@pytest.mark.parametrize(
    ("slides", "overrides"),
    [
        ({"lambda": 1e3}, ["controller.lambda=1e3", "shaper.stiffness=2"]),
        ({"lambda": 1e9}, ["controller.lambda=1e9"]),
        ({"eta": -0.5}, ["controller.eta_contact=-0.5"]),
        ({"eta": -0.5, "lambda": 2e3}, ["controller.eta_contact=-0.5", "controller.lambda=2e3"]),
        ({"wall": 0.05}, ["controller.walls=[[0.05, 1.0]]"]),
        ({"soft": 1}, ["shaper.walls=[0]"]),
        ({"soft": 1, "stiffness": 4, "lambda": 6e3, "damping": 2e-3},
         ["shaper.walls=[0]", "shaper.stiffness=4", "controller.lambda=6e3",
          "shaper.damping=2e-3"]),
    ],
)  # fmt: skip
def test_sliders_write_what_a_scene_would(slides, overrides):
    """The words that the scene has with the slider's value, and its design spring."""
    device = Device()
    bench = Bench(device, Known.of_scene(find_scene(SCENE), (), starts=True))
    for name, value in slides.items():
        bench.slide(name, value)
    # What is made of words, and not of what they were rounded from, may be a last place off.
    made = {"anchor_owed_gain", "shape_coefficient"}
    rounded = {p.address for name in made for p in places(name, SHAPE)}
    for address, raw in scene_words(*overrides).items():
        assert abs(device.words[address] - raw) <= (address in rounded), address
    scene = load_scene(find_scene(SCENE), overrides)
    assert bench.stiffness == pytest.approx(
        stiffness_predicted(scene, SampledSimulation(scene, rtl=False)), rel=1e-6
    )


def test_back_and_forth(bench):
    """η through damping and λ through its range leave no trace."""
    before = dict(bench.client.words)
    for name, value in {"eta": 0.0, "lambda": 200.0, "wall": 0.1, "soft": 1.0}.items():
        kept = bench.shown()["sliders"][name]["value"]
        bench.slide(name, value)
        assert bench.shown()["sliders"][name]["value"] == pytest.approx(value, abs=2e-4, rel=1e-3)
        bench.slide(name, kept)
    now = bench.client.words
    assert {a for a in before if abs(before[a] - now[a]) > 1} == set()


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("lambda", -1.0, r"lambda = -1 rad/s is out of range"),
        ("lambda", 1e-4, r"lambda is too low: a would be below its last place"),
        ("lambda", 0.5, r"controller.lambda"),
        ("lambda", math.nan, r"no such slider, or the value is no number"),
        ("eta", -1.5, r"eta_contact = -1\.5 is out of range; it takes -1\.\.\.1"),
        ("wall", 1e9, r"wall_min\[0\] = \d+ is out of range"),
        ("stiffness", -1.0, r"shaper.stiffness"),
        ("_live", 1.0, r"no such slider"),
    ],
)
def test_sliders_that_are_refused(bench, name, value, message):
    before = dict(bench.client.words)
    with pytest.raises(HostError, match=message) as error:
        bench.slide(name, value)
    assert "\n" not in str(error.value)
    assert bench.client.words == before


def test_words_by_name(bench):
    bench.set_word("a = 0.5")
    assert bench.shown()["a"] == 0.5
    before = dict(bench.client.words)
    for text, message in (
        ("a", r"^a: write NAME=NUMBER"), ("a=2", "out of range"), ("wall_min=1", "which one"),
        ("position=1", "can't be set"), ("b=1", "no such word"),
        ("", r"^write NAME=NUMBER, as in root=2.0"), ("  ", r"^write NAME=NUMBER"),
        ("=1", r"^=1: write NAME=NUMBER"),
        ("arm=1", r"^arm is a command and no setting; Arm and Stop on this page do that$"),
        ("clear=1", r"^clear is a command and no setting; Forget what is over on this page does"),
        ("capture=1", r"^capture is a command and no setting; `board set` writes it$"),
    ):  # fmt: skip
        with pytest.raises(HostError, match=message):
            bench.set_word(text)
    assert bench.client.words == before


@pytest.mark.parametrize("text", ["a=0", "root=0"])
@pytest.mark.parametrize("soft", [False, True])
def test_words_with_which_nothing_is_rendered(bench, text, soft):
    """The page is told no K, has numbers that JSON knows, and can go back."""
    if soft:
        bench.slide("soft", 1)
    bench.set_word(text)
    shown = bench.shown()
    json.dumps(shown, allow_nan=False)
    assert (shown["stiffness"], shown["tau_s"]) == (None, None)
    assert "stiffness" not in shown["sliders"]
    with pytest.raises(HostError):
        bench.slide("eta", -0.5)
    again = Bench(bench.client, bench.known)
    json.dumps(again.shown(), allow_nan=False)
    bench.set_word("root=2")
    bench.slide("lambda", 1e3)
    assert bench.shown()["stiffness"] > 0


def test_without_a_scene():
    """Amperes and counts; λ, η and the wall go all the same, and W doesn't."""
    bench = Bench(Device(), Known())
    shown = bench.shown()
    assert not shown["torque"]
    assert not shown["rad"]
    assert shown["stiffness"] is None
    assert set(shown["sliders"]) == {"lambda", "eta", "wall"}
    bench.slide("wall", 250)
    assert bench.shown()["wall"][0] == 250
    bench.slide("lambda", 1e3)
    assert bench.shown()["tau_s"] == pytest.approx(1e-3, rel=1e-4)
    with pytest.raises(HostError, match="W of this device isn't known"):
        bench.slide("soft", 1)
    row = bench.row({**dict.fromkeys(("voltage", "u", "v", "contact", "saturated"), 0.0),
                     "current": 2.0, "position": 7}, {})  # fmt: skip
    assert (row["x"], row["i"]) == (7, 2.0)
    assert math.isnan(row["torque"])
    known = Known().but(0.05, 1000)
    row = Bench(Device(), known).row({**dict.fromkeys(("voltage", "u", "v", "contact", "saturated"),
                                     0.0), "current": 2.0, "position": 7}, {})  # fmt: skip
    assert row["torque"] == pytest.approx(0.1)
    assert row["x"] == pytest.approx(7.5 * 2 * math.pi / 1000)


# ---- Who switches off.


class Watched(Feed):
    """A feed of a :class:`Device`, which stays the same when the line comes back."""

    def __init__(self, device: Device) -> None:
        self.device = device
        known = Known.of_scene(find_scene(SCENE), (), starts=True)
        super().__init__(Plug("/nowhere"), known, unit=1, motor=0, timeout_s=1.0)


@pytest.fixture
def running(monkeypatch) -> Iterator[Watched]:
    device = Device()

    def connect(*_: object) -> Device:
        if device.silent:
            raise HostError("no answer")
        return device

    monkeypatch.setattr(feed_module, "Client", connect)
    monkeypatch.setattr(feed_module, "_AGAIN_S", 0.02)
    found = Watched(device)
    found.start()
    wait(lambda: found.state()["live"])
    yield found
    found.end()


def armed_by(feed: Watched, owner: object) -> None:
    feed.arm(owner).result(END_S)
    wait(lambda: feed.state()["armed"])


def test_it_is_renewed_while_the_page_lives(running):
    """Armed by one 1, renewed by 2s, and switched off soon after the last sign of life."""
    page = object()
    armed_by(running, page)
    until = time.monotonic() + 2 * PATIENCE_S
    while time.monotonic() < until:
        running.beat(page)
        running.beat(object())
        time.sleep(0.02)
    assert running.state()["wanted"]
    assert running.device.armings[0] == 1
    assert set(running.device.armings[1:]) == {2}
    assert len(running.device.armings) > 2 * PATIENCE_S / 0.2 * 2  # twice as often as needed
    silent = time.monotonic()
    wait(lambda: running.device.armings[-1] == 0)
    assert PATIENCE_S / 2 < time.monotonic() - silent < 2 * PATIENCE_S
    wait(lambda: "silent" in running.state()["note"])
    time.sleep(0.2)
    assert running.device.armings[-1] == 0
    assert not running.state()["wanted"]


def test_another_page_keeps_nothing_on(running):
    """Signs of life of a page that hasn't armed count for nothing, and any page may stop."""
    page, other = object(), object()
    armed_by(running, page)
    running.leave(other)
    end = time.monotonic() + 3 * PATIENCE_S
    while running.device.armings[-1] != 0:
        running.beat(other)
        assert time.monotonic() < end
        time.sleep(0.02)
    armed_by(running, page)
    running.stop()
    wait(lambda: running.device.armings[-1] == 0, 0.3)
    armed_by(running, page)
    running.leave(page)
    wait(lambda: running.device.armings[-1] == 0, 0.3)


def test_a_stop_goes_before_what_waits(running):
    """However much is to be written, the next exchange but one switches off."""
    armed_by(running, object())
    running.device.delay_s = 0.02
    asked = [running.ask(lambda bench: bench.slide("lambda", 1e3)) for _ in range(50)]
    running.stop()
    wait(lambda: running.device.armings[-1] == 0, 0.5)
    assert not asked[-1].done()
    running.device.delay_s = 0.0
    asked[-1].result(END_S)


def test_it_is_renewed_while_words_are_set(running):
    """Which takes many exchanges, slow ones through some USB bridges; a stop goes between them."""
    page = object()
    armed_by(running, page)
    running.device.delay_s = 0.016
    armed, told = [], running.device.write

    def noted(words: object) -> int:
        given = dict(words)
        if "arm" in [place.text for place in given]:
            armed.append(time.monotonic())
        return told(given)

    running.device.write = noted
    for _ in range(3):
        asked = running.ask(lambda bench: bench.set_word("a=0.5"))
        while not asked.done():
            running.beat(page)
            time.sleep(0.005)
    assert running.state()["wanted"]
    assert max(np.diff(armed)) < 0.15
    asked = running.ask(lambda bench: bench.set_word("a=0.5"))
    while not any("a" in words for words in running.device.written[-2:]):
        running.beat(page)
    running.stop()
    wait(lambda: running.device.armings[-1] == 0, 0.1)
    asked.result(END_S)


def test_a_stop_while_an_arming_waits(running):
    """A stop goes before the arming that was asked for before it, and isn't undone by it."""
    running.device.delay_s = 0.02
    for _ in range(20):
        running.ask(lambda bench: bench.clear())
    arming = running.arm(object())
    running.stop()
    running.device.delay_s = 0.001
    with pytest.raises(HostError, match="stopped while it was being armed"):
        arming.result(END_S)
    assert 1 not in running.device.armings
    assert not running.state()["wanted"]
    armed_by(running, object())


@pytest.mark.parametrize("leaves", [False, True])
def test_a_stop_during_the_exchange_that_arms(running, leaves):
    """Or the page that asked has gone meanwhile: it is switched off by the next exchange."""
    page, write = object(), running.device.write

    def slow(words: object) -> int:
        given = dict(words)
        done = write(given)
        if 1 in [raw for place, raw in given.items() if place.text == "arm"]:
            running.leave(page) if leaves else running.stop()
        return done

    running.device.write = slow
    with pytest.raises(HostError, match="stopped while it was being armed"):
        running.arm(page).result(END_S)
    wait(lambda: running.device.armings == [1, 0], 0.5)
    assert not running.state()["wanted"]
    running.device.write = write
    armed_by(running, page)


def test_an_arming_that_fails_is_taken_back(running):
    """What wasn't acknowledged may have been heard."""
    write = running.device.write

    def deaf(words: object) -> int:
        given = dict(words)
        write(given)
        if 1 in [raw for place, raw in given.items() if place.text == "arm"]:
            raise HostError("no answer")
        return 1

    running.device.write = deaf
    with pytest.raises(HostError, match="no answer"):
        running.arm(object()).result(END_S)
    wait(lambda: running.device.armings == [1, 0], 0.5)


def test_a_board_that_falls_silent(running):
    """It is told, nothing is lost, nothing stays armed, and it comes back by itself."""
    wait(lambda: len(running.kept) > 5)
    armed_by(running, object())
    running.device.silent = True
    wait(lambda: not running.state()["live"])
    kept = len(running.kept)
    assert kept > 5
    assert running.state()["problem"] == "no answer"
    with pytest.raises(HostError, match="no board"):
        running.ask(lambda bench: bench.clear()).result(END_S)
    running.device.silent = False
    wait(lambda: running.state()["live"])
    assert not running.state()["wanted"]
    assert running.state()["note"] == "switched off: no answer"
    wait(lambda: len(running.kept) > kept)
    times = running.kept.arrays()["t"]
    assert (np.diff(times) >= 0).all()
    told = len(running.device.armings)
    time.sleep(0.2)
    assert len(running.device.armings) == told


def test_a_feel_is_shown_when_the_line_comes_back(running):
    """K is that of the feel, as W of the device is, and not that of the scene."""
    place = places("position", SHAPE)[0]
    running.device.words[place.address] = round(0.119 / running._known.cell_rad)
    scenes = running.state()["stiffness"]
    running.ask(lambda bench: bench.feel("joystick")).result(END_S)
    feels = running.state()["stiffness"]
    assert feels == pytest.approx(0.05 * scenes, rel=1e-6)
    running.device.silent = True
    wait(lambda: not running.state()["live"])
    running.device.silent = False
    wait(lambda: running.state()["live"])
    assert (running.state()["feel"], running.state()["stiffness"]) == ("joystick", feels)


def test_a_board_with_its_own_switch(running):
    """It can't be armed, and a stop says so instead of nothing."""
    running.device.identification.options["arm"] = 0
    running.device.silent = True
    wait(lambda: not running.state()["live"])
    running.device.silent = False
    wait(lambda: running.state()["live"])
    with pytest.raises(HostError, match="by its own switch"):
        running.arm(object()).result(END_S)
    running.stop()
    wait(lambda: "by its own switch" in running.state()["note"])


def test_a_refusal_doesnt_end_it(running):
    with pytest.raises(HostError, match="out of range"):
        running.ask(lambda bench: bench.slide("eta", 3.0)).result(END_S)
    assert running.state()["live"]


def test_what_nobody_foresaw_doesnt_end_it(running):
    """It is one line for who asked, and for the page; who asked and went is passed over."""
    wait_for = threading.Event()

    def wrong(_: object) -> None:
        wait_for.wait(END_S)
        raise ZeroDivisionError("by\nzero")

    asked = running.ask(wrong)
    gone, last = running.ask(lambda _: None), running.ask(lambda _: None)
    assert gone.cancel()
    wait_for.set()
    with pytest.raises(HostError, match="ZeroDivisionError: by zero"):
        asked.result(END_S)
    last.result(END_S)
    armed_by(running, object())
    read = running.device.read

    def broken(wanted: list[Place]) -> list[int]:
        raise OverflowError("too large")

    running.device.read = broken
    wait(lambda: not running.state()["live"])
    assert running.state()["problem"] == "the scope has a fault: OverflowError: too large"
    assert running.device.armings[-1] == 0
    running.device.read = read
    wait(lambda: running.state()["live"])
    assert running.is_alive()


def test_the_end_switches_off(running):
    armed_by(running, object())
    running.end()
    assert running.device.armings[-1] == 0


# ---- What is kept.


def test_a_recording():
    kept = Kept()
    for n in range(10):
        if n in (3, 7):
            kept.record(n == 3)
        kept.add({"t": 0.1 * n, "x": 1e-3 * n, "torque": math.nan, "contact": n % 2})
    assert (kept.recording, kept.recorded, len(kept)) == (False, 4, 10)
    arrays = kept.arrays()
    assert set(arrays) == {"t", "x", "contact", "saturated"}
    np.testing.assert_allclose(arrays["t"], [0.3, 0.4, 0.5, 0.6])
    assert arrays["contact"].tolist() == [True, False, True, False]
    with np.load(io.BytesIO(kept.npz()), allow_pickle=False) as file:
        assert {name: file[name].tolist() for name in file} == {
            name: values.tolist() for name, values in arrays.items()
        }
    lines = list(csv.DictReader(io.StringIO(kept.csv())))
    assert [float(line["x"]) for line in lines] == arrays["x"].tolist()
    assert [line["contact"] for line in lines] == ["1", "0", "1", "0"]


def test_without_a_recording_everything(monkeypatch):
    monkeypatch.setattr("wavehaptics.host.scope.kept.MOST_ROWS", 100)
    kept = Kept()
    for n in range(130):
        kept.add({"t": float(n)})
    assert len(kept) == 130
    assert kept.arrays()["t"].tolist() == [float(n) for n in range(50, 130)]
    kept.record(True)
    kept.add({"t": 130.0})
    assert kept.arrays()["t"].tolist() == [130.0]


# ---- The hand.


def test_the_hand_follows_smoothly():
    """A step is a path with a bounded speed that ends where it was led, whatever the steps."""
    for step_s in (SETTLE_S / 50, SETTLE_S / 3, 4 * SETTLE_S):
        hand = Follower(0.0)
        hand.target, places_, speeds = 0.3, [0.0], []
        for _ in range(round(0.3 / step_s)):
            speeds.append(hand.follow(step_s))
            places_.append(places_[-1] + speeds[-1] * step_s)
        assert max(map(abs, speeds)) <= MOST_RAD_S * (1 + 1e-9)
        assert places_[-1] == pytest.approx(hand.position)
        assert hand.position == pytest.approx(0.3, abs=1e-4)
        assert max(places_) < 0.3 * 1.2


def test_a_guide_of_the_hand(tmp_path):
    """Lines lead it, others are passed over, and it stays where it was when the guide goes."""
    path = tmp_path / "hand"
    with LedHand(path, 0.1) as hand:
        stopped = threading.Event()

        def simulate() -> None:
            moment = 0.0
            while not stopped.is_set():
                hand.speed(moment, 1e-3)
                moment += 1e-3
                time.sleep(1e-3)

        thread = threading.Thread(target=simulate)
        thread.start()
        for place in (0.2, -0.05):
            guide = HandLine(path)
            guide._socket.send(b"nonsense\nnan\ninf\n1e9\n")
            guide.lead(place)
            wait(lambda guide=guide, place=place: guide.told is not None
                 and abs(guide.told.hand_rad - place) < 1e-3)  # fmt: skip
            assert guide.time_s() > 0
            guide.close()
        stopped.set()
        thread.join()
        assert hand.speed(9.0, 1e-3) == pytest.approx([0.0], abs=0.1)
    assert not path.exists()
    with pytest.raises(HostError, match="no hand to lead"):
        HandLine(path)


def test_formats_of_the_sliders():
    """The least λ of the slider still has a coefficient."""
    shown = Bench(Device(), Known()).shown()["sliders"]["lambda"]
    assert formats.A.to_raw(1e-6 * shown["min"] * 40) > 0


# ---- A brushless motor.


class BrushlessDevice(Device):
    """The device of ``live_brushless``, whose live words a test puts there."""

    def __init__(self) -> None:
        super().__init__()
        scene = load_scene(find_scene("live_brushless"))
        ports = controller_ports(scene)
        self.shape = Shape(1, 4, 0, 10, THREE_PHASE_LEGS)
        self.identification.options["shaper"] = 0
        self.identification.words["clock_hz"] = round(ports.timing.clock_hz)
        values = {**ports.words, **ports.settings.words(), **ports.wall_words(4),
                  **magnet_words(scene, ports.settings, ports.start_count)}  # fmt: skip
        self.words = dict(settings_requests(values, THREE_PHASE_LEGS))

    def tell(self, name: str, value: float, axis: int = 0) -> None:
        (place,) = places(name, self.shape, axis)
        self.words[place.address] = place.word.fixed.to_raw(value) & 0xFFFFFFFF


def brushless_bench() -> tuple[BrushlessDevice, Bench]:
    device = BrushlessDevice()
    return device, Bench(device, Known.of_scene(find_scene("live_brushless"), (), starts=True))


def test_a_brushless_motors_torque_is_of_both_axes_by_the_magnets_angle():
    """From the device's own angle, which nobody knows before it is found."""
    device, bench = brushless_bench()
    scene = load_scene(find_scene("live_brushless"))
    i_q, i_d = 0.2, -0.1
    count, moved = 700, 37
    turn = scene.motor.pole_pairs * 2 * math.pi / scene.encoder.counts_per_rev
    theta = 1.1 + moved * turn
    currents = (i_d * math.cos(theta) - i_q * math.sin(theta),
                i_d * math.sin(theta) + i_q * math.cos(theta))  # fmt: skip
    for axis, current in enumerate(currents):
        device.tell("current", current, axis)
    device.tell("position", count)
    device.tell("magnet_angle", round(1.1 / (2 * math.pi) * 2**32))
    bench.status()
    row = bench.row(bench.step(), bench.seen())
    assert math.isnan(row["torque"])
    assert row["i_alpha"] == pytest.approx(currents[0], abs=1e-6)
    assert row["i_beta"] == pytest.approx(currents[1], abs=1e-6)
    assert bench.shown()["magnet"] is False
    device.tell("magnet_found", 1)
    bench.status()
    device.tell("position", count + moved)
    row = bench.row(bench.step(), bench.seen())
    assert row["i"] == pytest.approx(i_q, rel=1e-5)
    psi = scene.motor.psi_vs
    assert row["torque"] == pytest.approx(1.5 * scene.motor.pole_pairs * psi * i_q, rel=1e-5)
    assert bench.shown()["magnet"] is True


def test_a_brushless_motors_spring_is_the_closed_form():
    """K = 1.5 (pψ)²/(L + R̂·τ/2), also for another λ; and K_L; no W."""
    device, bench = brushless_bench()
    scene = load_scene(find_scene("live_brushless"))
    flux = scene.motor.pole_pairs * scene.motor.psi_vs
    for lambda_ in (None, 3e3):
        if lambda_:
            bench.slide("lambda", lambda_)
        shown = bench.shown()
        (root,) = places("root", device.shape)
        r_hat = 0.5 * formats.ROOT.to_value(device.words[root.address]) ** 2
        wanted = 1.5 * flux**2 / (scene.controller.l_hat + 0.5 * r_hat * shown["tau_s"])
        assert shown["stiffness"] == pytest.approx(wanted, rel=1e-9)
    assert shown["k_l"] == pytest.approx(1.5 * flux**2 / scene.motor.L_h)
    assert (shown["brushless"], shown["pairs"]) == (True, scene.motor.pole_pairs)
    assert {*shown["sliders"]} == {"lambda", "eta", "wall"}


def test_a_brushless_device_isnt_shown_with_a_brushed_motors_scene():
    with pytest.raises(HostError, match="the device has a brushless motor, and the scene's has"):
        Bench(BrushlessDevice(), Known.of_scene(find_scene(SCENE), (), starts=True))
