# SPDX-License-Identifier: Apache-2.0
"""The scope's rows by the device's stream: what is in them, and who else gets the port."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace

import numpy as np
import pytest
from test_streamed import Streams, packet
from wavehaptics.host.client import Client
from wavehaptics.host.names import places
from wavehaptics.host.scope import fast
from wavehaptics.host.scope import feed as feed_module
from wavehaptics.host.scope.bench import Known
from wavehaptics.host.scope.fast import Fast, channels, is_worth
from wavehaptics.host.scope.feed import Feed
from wavehaptics.host.scope.plug import VirtualPlug
from wavehaptics.scene import find_scene
from wavehaptics.words import modbus
from wavehaptics.words.table import WORDS

SCENE = "live_wall"
START_S = 600
"""The RTL is built first, where that hasn't been done."""
END_S = 120
ROW_S = 32 / 25e3
"""Of 32 ticks: 781 rows a second is what 115,200 bits a second carry of a tick of 40 µs."""


def wait(done: Callable[[], bool], end_s: float = END_S) -> None:
    end = time.monotonic() + end_s
    while not done():
        assert time.monotonic() < end
        time.sleep(0.01)


# ---- What is in a row.


class Bench:
    """What the stream's rows need of a bench."""

    motor = 0
    root = 2.0
    u_max = 4.0
    full_scale_a: float | None = 2.5

    def __init__(self, client: Streams) -> None:
        self.client = client

    def row(self, step: dict[str, float], seen: dict[str, float]) -> dict[str, float]:
        return {**step, **seen}


def test_rows_of_a_stream():
    """Place in the middle of the row, v and the voltage from the same step, the anchor's added."""
    bench = Bench(Streams([], position=100))
    live = Fast(bench)
    with live:
        live._stream._take(packet(0, [[100 + 2 * n, 256 * n, 512 * n, 1] for n in range(15)]))
        rows = list(live.rows({"correction": 0.25}))
        assert len(rows) == 15
        since, row = rows[3]
        assert since == pytest.approx(3 * live._stream.wanted.rows.row_s)
        assert row["position"] == 105.0
        current = live._stream.wanted.shifts[1]
        assert row["current"] == pytest.approx(
            (768 * 2**current + 0.5 * (2**current - 1)) * WORDS["current"].fixed.step
        )
        assert row["v"] == pytest.approx(row["u"] - 2.0 * row["current"])
        assert row["voltage"] == pytest.approx(2.0 * row["u"] + 0.25)
        assert (row["contact"], row["saturated"], row["lost"]) == (1.0, 0.0, 0.0)
        # Two packets are lost: counted, their rows without numbers, and the place goes on behind.
        live._stream._take(packet(3, [[200, 0, 0, 2]] * 15))
        rows = list(live.rows({}))
        assert [row for _, row in rows[:30]] == [{"lost": 1.0}] * 30
        assert live.lost == 2
        assert rows[31][1]["position"] == 200.0
        assert (rows[31][1]["contact"], rows[31][1]["saturated"]) == (0.0, 1.0)
        steps = np.diff([since for since, _ in rows])
        assert steps == pytest.approx(live._stream.wanted.rows.row_s)


def test_ranges_are_those_of_the_settings():
    """And a stream is over once a setting changes them."""
    bench = Bench(Streams([], position=0))
    assert channels(bench) == ("position", "current:2.65625", "u:4.0", "flags")
    live = Fast(bench)
    with live:
        assert not live.is_over
        bench.u_max = 9.0
        assert live.is_over
    bench.u_max, bench.full_scale_a = 0.0, None
    assert channels(bench) == ("position", "current", "u", "flags")


def test_where_polls_are_better():
    """Without a stream, and on a line that is too slow for one."""
    assert is_worth(Streams([]))
    slow = Streams([])
    slow._baud = modbus.BAUDS[0]
    assert is_worth(slow)
    slow._baud = 9600
    assert not is_worth(slow)
    silent = Streams([])
    silent.read = lambda wanted: [0 for _ in wanted]
    assert not is_worth(silent)


# ---- On the virtual board.


@pytest.fixture(scope="module")
def board() -> Iterator[VirtualPlug]:
    plug = VirtualPlug(str(find_scene(SCENE)), ())
    wait(lambda: not plug.problem, START_S)
    yield plug
    plug.close()


class Borrowed:
    """The board's plug, of which a feed may not take the board with it at its end."""

    def __init__(self, plug: VirtualPlug) -> None:
        self._plug = plug

    def __getattr__(self, name: str) -> object:
        return getattr(self._plug, name)

    def close(self) -> None:
        self._plug.disconnect_hand()


@pytest.fixture
def feed(board) -> Iterator[Feed]:
    known = Known.of_scene(find_scene(SCENE), (), starts=True)
    found = Feed(Borrowed(board), known, unit=1, motor=0, timeout_s=5.0)
    found.start()
    yield found
    found.end()


def streams(feed: Feed) -> bool:
    return feed.state()["row_hz"] is not None


def test_the_page_gets_many_rows_at_even_steps(feed):
    """Armed meanwhile, and stopped: eight rows for each that polls make; the trace as theirs."""
    wait(lambda: streams(feed), START_S)
    assert feed.state()["row_hz"] == pytest.approx(1 / ROW_S)
    page = object()
    feed.arm(page).result(END_S)

    def running() -> bool:
        feed.beat(page)
        return feed.state()["running"]

    wait(running)
    feed.fresh()
    feed.kept.record(True)
    wait(lambda: running() and feed.kept.recorded > 500)
    rows = feed.fresh()
    assert np.diff([row["t"] for row in rows]) == pytest.approx(ROW_S, rel=1e-6)
    assert max(abs(row["torque"]) for row in rows) > 0.0
    feed.stop()
    wait(lambda: not feed.state()["running"])
    feed.kept.record(False)
    state = feed.state()
    assert (state["lost"], state["problem"]) == (0, "")
    arrays = feed.kept.arrays()
    assert {"t", "x", "i", "e_a", "torque", "eta", "u", "v", "x_hand", "contact", "saturated",
            "correction", "flux", "lost"} == {*arrays}  # fmt: skip
    assert arrays["lost"].dtype == bool
    assert not arrays["lost"].any()


def test_polls_have_the_same(feed, monkeypatch):
    """Without a stream rows are as they were, and there is nothing to be lost."""
    wait(lambda: feed.state()["live"])
    monkeypatch.setattr(fast, "is_worth", lambda client: False)
    known = Known.of_scene(find_scene(SCENE), (), starts=True)
    feed.end()
    polled = Feed(feed._plug, known, unit=1, motor=0, timeout_s=5.0)
    polled.start()
    try:
        wait(lambda: len(polled.kept) > 20)
        assert not streams(polled)
        assert "lost" not in polled.kept.arrays()
    finally:
        polled.end()


def test_others_get_the_port(feed, board):
    """Whoever waits has it soon; while they go on rows are polled, and then it streams again."""
    wait(lambda: streams(feed))
    other = Client(board.port, timeout_s=END_S)
    place = places("position", other.shape)[0]
    end = time.monotonic() + 2 * feed_module.SHARED_S
    while time.monotonic() < end:
        other.read([place])
        assert not streams(feed)
    count = len(feed.kept)
    wait(lambda: streams(feed))
    wait(lambda: len(feed.kept) > count + 100)
    assert feed.state()["problem"] == ""


def test_a_stream_that_lapses_begins_anew(feed, monkeypatch):
    """For a while it is polled."""
    wait(lambda: streams(feed))
    live = feed._fast
    monkeypatch.setattr(live._stream, "_line", SimpleNamespace(
        error=None, lapsed=True, broken=0))  # fmt: skip
    wait(lambda: feed._fast is not live)
    wait(lambda: streams(feed))
    assert feed.state()["problem"] == ""
