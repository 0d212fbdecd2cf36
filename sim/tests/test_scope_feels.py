# SPDX-License-Identifier: Apache-2.0
"""The scope's feels: which registers each writes, on which boards, and what the page asks for."""

from __future__ import annotations

import asyncio
import json
import math
from itertools import pairwise

import pytest
from aiohttp.test_utils import TestClient, TestServer
from test_scope import END_S, SCENE, BrushlessDevice, Device, Watched, scene_words, wait
from wavehaptics.host.names import HostError, Shape, places
from wavehaptics.host.scope import feed as feed_module
from wavehaptics.host.scope.bench import Bench, Known
from wavehaptics.host.scope.feels import FEELS
from wavehaptics.host.scope.plug import Plug
from wavehaptics.host.scope.server import Scope
from wavehaptics.scene import find_scene

SOFT = {"soft", "layer", "joystick"}


def board(*overrides: str, walls: int = 4) -> tuple[Device, Bench]:
    device = Device(*overrides)
    device.shape = Shape(1, walls, 1, 10)
    bench = Bench(device, Known.of_scene(find_scene(SCENE), overrides, starts=True))
    turn(device, bench, -1e-3)  # beside the wall, in a joystick's play
    return device, bench


def turn(device: Device, bench: Bench, angle: float) -> None:
    """The rotor to an angle, rad, where the scene begins at -0.12 rad."""
    place = places("position", device.shape)[0]
    device.words[place.address] = round((angle + 0.12) / bench.known.cell_rad) % 2**32


def value(device: Device, name: str, index: int = 0) -> float:
    place = places(name, device.shape)[index]
    return place.value(device.words.get(place.address, 0))


def walls_of(device: Device) -> list[tuple[float, float, float]]:
    """Both edges and whether it is soft, of each wall that exists."""
    return [
        tuple(value(device, name, n) for name in ("wall_min", "wall_max", "wall_shaped"))
        for n in range(device.shape.walls)
        if value(device, "wall_enable", n)
    ]


def refused(bench: Bench, name: str, message: str) -> None:
    """In one line, and nothing is written."""
    before = dict(bench.client.words)
    with pytest.raises(HostError, match=message) as error:
        bench.feel(name)
    assert "\n" not in str(error.value)
    assert bench.client.words == before
    assert bench.shown()["feel"] == ""


@pytest.mark.parametrize(("walls", "counts"), [(4, 40_000), (7, 2_000)])
@pytest.mark.parametrize("name", FEELS)
def test_walls_of_each_feel(name, walls, counts):
    """They exist, don't overlap, and are where the angle says; the page is told so."""
    device, bench = board(f"encoder.counts_per_rev={counts}", walls=walls)
    bench.feel(name)
    feel, found, shown = FEELS[name], walls_of(device), bench.shown()
    assert all(high - low >= 2 for low, high, _ in found)
    assert all(high <= low for (_, high, _), (low, _, _) in pairwise(sorted(found)))
    assert len(found) == (walls if feel.ridges else len(feel.walls))
    assert [soft for *_, soft in found] == [n < feel.soft for n in range(len(found))]
    assert [wall["soft"] for wall in shown["walls"]] == [bool(soft) for *_, soft in found]
    cell = 2 * math.pi / counts
    for wall, edges in zip(shown["walls"], feel.walls, strict=feel.ridges is None):
        assert wall["from"] == pytest.approx(0.2 * edges[0], abs=1.01 * cell)
        assert wall["to"] == pytest.approx(0.2 * edges[1], abs=2.01 * cell)
    assert (shown["feel"], shown["feels"]) == (name, list(FEELS))
    assert shown["sliders"]["eta"]["value"] == value(device, "eta_contact")
    assert shown["sliders"]["wall"]["value"] == pytest.approx(shown["walls"][0]["from"])


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("stops", ["controller.walls=[[0.14, 1.0], [-1.0, -0.14]]"]),
        ("button", ["controller.walls=[[0.02, 0.024], [0.06, 1.0]]", "controller.eta_free=0.95"]),
        ("honey", ["controller.walls=[[-0.2, 0.2]]", "controller.eta_contact=-0.75"]),
        ("joystick", ["shaper.walls=[0, 1]", "controller.walls=[[0.006, 0.14], "
                      "[-0.14, -0.006], [0.14, 1.0], [-1.0, -0.14]]"]),
    ],
)  # fmt: skip
def test_a_feel_is_what_a_scene_would_be(name, overrides):
    device, bench = board()
    bench.feel("rough")  # it leaves no trace
    bench.feel(name)
    if name in SOFT:
        wish = {key: bench.shown()["sliders"][key]["value"] for key in ("stiffness", "damping")}
        overrides = [*overrides, *(f"shaper.{key}={number!r}" for key, number in wish.items())]
    made = ("wall_min", "wall_max", "anchor_owed_gain", "shape_coefficient")
    rounded = {p.address for one in made for p in places(one, device.shape)}
    unused = {places(f"wall_{end}", device.shape)[n].address
              for end in ("min", "max") for n in range(len(walls_of(device)), 4)}  # fmt: skip
    for address, raw in scene_words(*overrides).items():
        off = abs((device.words[address] - raw + 2**31) % 2**32 - 2**31)
        assert off <= (address in rounded) or address in unused, hex(address)


@pytest.mark.parametrize("name", sorted(SOFT))
@pytest.mark.parametrize("lambda_", [1e6, 3e3])
def test_stiffness_is_a_fraction_of_the_boards_own_wall(name, lambda_):
    _, bench = board(f"controller.lambda={lambda_}")
    rigid = bench.shown()["stiffness"]
    bench.feel(name)
    assert bench.shown()["stiffness"] == pytest.approx(FEELS[name].stiffness * rigid, rel=1e-6)


def test_old_walls_end_before_new_ones_begin_together():
    """Each frame is a commit: between the first and the last the rotor is in free space."""
    device, bench = board()
    bench.feel("stops")
    enables = [f"wall_enable[{n}]" for n in range(4)]
    first, middle, last = device.written
    assert first == dict.fromkeys(enables, 0)
    assert not set(middle) & set(enables)
    assert last == dict(zip(enables, (1, 1, 0, 0), strict=True))


def test_free_space_stays_quiet_behind_thin_walls():
    """Also with another λ, until another feel is set. Another setting ends the feel."""
    device, bench = board()
    own = value(device, "eta_free")
    bench.feel("detents")
    bench.slide("lambda", 1e4)
    assert value(device, "eta_free") == pytest.approx(0.95, abs=1e-6)
    assert bench.shown()["feel"] == ""
    bench.slide("lambda", 1e6)
    bench.feel("wall")
    assert value(device, "eta_free") == own
    bench.set_word("eta_contact=-0.9")
    assert bench.shown()["feel"] == ""


@pytest.mark.parametrize("name", FEELS)
def test_a_feel_survives_a_line_that_was_lost(name):
    """The page shows what it showed, and the next feel is what it would have been."""
    device, bench = board()
    bench.feel(name)
    again = Bench(device, bench.known, before=bench)
    assert again.shown() == bench.shown()
    for one in (bench, again):
        turn(device, one, -1e-3)
        one.feel("wall")
    assert device.written[-3:] == device.written[-6:-3]


def test_what_others_set_while_the_line_was_lost_is_no_feel():
    """η of another program ends the feel; its W is there still, until the device is reset."""
    device, bench = board()
    own = bench.shown()
    bench.feel("soft")
    soft = bench.shown()
    assert soft["stiffness"] < 0.5 * own["stiffness"]
    device.words[places("eta_contact", device.shape)[0].address] = -3 << 23 & 0xFFFFFFFF
    found = Bench(device, bench.known, before=bench).shown()
    assert (found["feel"], found["sliders"]["stiffness"]) == ("", soft["sliders"]["stiffness"])
    device.words |= scene_words()
    assert Bench(device, bench.known, before=bench).shown() == own


def test_without_a_scene():
    """Counts in place of angles, no W, and the board's own η in free space."""
    device = Device()
    bench = Bench(device, Known())
    face, own = value(device, "wall_min"), value(device, "eta_free")
    assert bench.shown()["feels"] == [name for name in FEELS if name not in SOFT]
    bench.feel("button")
    found = [(low - face, high - face) for low, high, _ in walls_of(device)]
    assert found == [(100, 120), (300, 5000)]
    assert value(device, "eta_free") == pytest.approx(min(own, 0.95), abs=1e-6)
    bench.feel("honey")
    assert value(device, "eta_free") == own


@pytest.mark.parametrize(
    ("name", "walls", "counts", "message"),
    [
        ("syrup", 4, None, "^syrup: there is no such feel; take one of wall, stops"),
        ("soft", 4, None, r"^Soft wall: W of this device isn't known; it takes a scene"),
        ("stops", 1, 10_000, "^End stops: it takes 2 walls, and the device has 1$"),
        ("detents", 1, None, "^Detents: it takes 2 walls, and the device has 1$"),
        ("rough", 4, 500, "^Rough surface: the encoder is too coarse for it$"),
        ("wall", 4, 10**11, r"^wall_max\[0\] = \d+ is out of range; it takes"),
        ("stops", 4, None, r"^End stops: .* inside its wall; move it first, to 64 to 1464 counts$"),
    ],
)  # fmt: skip
def test_feels_that_are_refused(name, walls, counts, message):
    device = Device()
    device.shape = Shape(1, walls, 1, 10)
    refused(Bench(device, Known().but(None, counts)), name, message)


@pytest.mark.parametrize(
    ("name", "angle", "wanted"),
    [
        ("wall", 0.03, "below 0 rad"), ("layer", 0.03, "below 0 rad"),
        ("stops", -0.2, "-0.14 to 0.14 rad"), ("joystick", -0.05, "-0.006 to 0.006 rad"),
        ("button", 0.021, "below 0.02 rad"), ("detents", 0.05, ""), ("honey", 0.1, ""),
    ],
)  # fmt: skip
def test_no_wall_begins_around_the_rotor(name, angle, wanted):
    """It would hold the rotor at depth 0; thin walls and honey let it go."""
    device, bench = board()
    turn(device, bench, angle)
    if wanted:
        refused(bench, name, f"the rotor would be inside its wall; move it first, to {wanted}$")
        turn(device, bench, -1e-3)
    bench.feel(name)
    assert bench.shown()["feel"] == name


def test_boards_without_feels():
    known = Known.of_scene(find_scene("live_brushless"), (), starts=True)
    several, (_, still) = Device(), board()
    several.shape = Shape(3, 4, 1, 10)
    for bench in (Bench(BrushlessDevice(), known), Bench(several, Known())):
        refused(bench, "wall", "feels are for a board with one motor with brushes")
        assert bench.shown()["feels"] == []
    still.set_word("a=0")
    refused(still, "wall", "lambda is too low")
    assert still.shown()["feels"] == []


def test_the_pages_message(monkeypatch):
    """One message sets a feel; a refusal is one line; the page has names and titles by then."""
    device = Device()
    monkeypatch.setattr(feed_module, "Client", lambda *_: device)
    feed = Watched(device)
    feed.start()
    wait(lambda: feed.state()["live"])

    async def run() -> None:
        scope = Scope(feed, Plug("/nowhere"))
        async with TestClient(TestServer(scope.app, host="127.0.0.1")) as client:
            origin = f"http://127.0.0.1:{client.port}"
            page = await client.ws_connect("/live", params={"token": scope.token}, origin=origin)
            hello = await page.receive_json(timeout=END_S)
            assert [feel["name"] for feel in hello["feels"]] == list(FEELS)
            assert all(feel["title"] and feel["meaning"] for feel in hello["feels"])

            async def told(message: dict[str, str]) -> str:
                await page.send_str(json.dumps(message))
                while (answer := await page.receive_json(timeout=END_S))["type"] != "told":
                    pass
                return answer["problem"]

            assert await told({"type": "feel", "name": "honey"}) == ""
            assert feed.state()["feel"] == "honey"
            assert value(device, "eta_contact") == -0.75
            before = dict(device.words)
            assert (await told({"type": "feel", "name": "x"})).startswith("x: there is no such")
            assert (await told({"type": "feel"})).startswith("the page asks for something unknown")
            assert device.words == before

    try:
        asyncio.run(run())
    finally:
        feed.end()
