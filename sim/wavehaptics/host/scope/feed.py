# SPDX-License-Identifier: Apache-2.0
"""The thread that has the line: it polls, writes what is asked for, and renews the arming.

Where the device has a stream the rows come by that, and nobody else has the port, until somebody
waits for it: then it is shared again for a while, and rows are polled. One exchange at a time. The
arming is renewed only while the page that asked for it gives signs of life; without them it is
ended here, and without this thread the device ends it by itself.
"""

from __future__ import annotations

import contextlib
import math
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any

from wavehaptics.host.client import RENEWAL_S, ZERO_S, Client
from wavehaptics.host.names import HostError
from wavehaptics.host.scope import fast
from wavehaptics.host.scope.bench import Bench, Known
from wavehaptics.host.scope.fast import Fast
from wavehaptics.host.scope.kept import Kept
from wavehaptics.host.scope.plug import Plug
from wavehaptics.runtime.ends import ending
from wavehaptics.words.faults import FAULTS, arm_refusal, bits_of

PATIENCE_S = 1.0
"""How long the page that armed may be silent."""

NO_ARMING = "this board runs and stops by its own switch; its line does neither"

STOPPED = "stopped while it was being armed; arm it again if that is still wanted"

_STATUS_S = 0.1
_SEEN_EVERY = 2
_PLANES_EVERY = 4
"""Turns of an arm's planes for one of the motor's own row."""
_SEEN_S = 0.04
"""From one poll of the anchor to the next beside a stream."""
_TURN_S = 0.01
"""From one look at what a stream has brought to the next."""
SHARED_S = 1.0
"""How long the port is shared after somebody was seen to want it, or a stream has lapsed: who
renews an arming does it some twenty times meanwhile."""
_AGAIN_S = 0.5
"""From one try to reach the device to the next."""
_MOST_FRESH = 4096
"""Rows that wait for the pages."""


class Feed(threading.Thread):
    """Polls the device of a :class:`Plug` until :meth:`end`.

    ``fresh`` takes rows for the pages away, ``state`` tells everything else.
    """

    def __init__(
        self, plug: Plug, known: Known, *, unit: int, motor: int, timeout_s: float
    ) -> None:
        super().__init__(name="feed", daemon=True)
        self._plug, self._known = plug, known
        self._unit, self._motor, self._timeout_s = unit, motor, timeout_s
        self.kept = Kept()
        self._asked: queue.SimpleQueue[tuple[Callable[[Bench], None], Future[None]]] = (
            queue.SimpleQueue()
        )
        self._ended = threading.Event()
        self._lock = threading.Lock()
        self._fresh: list[dict[str, float]] = []
        self._status: dict[str, int] = {}
        self._shown: dict[str, Any] = {}
        self._problem, self._note = "", ""
        self._unheard = ""
        self._live = False
        # Counted, as a flag could be cleared by what was asked for before the stop.
        self._stops = self._stops_done = 0
        self._owner: object = None
        self._asker: object = None
        self._beat = self._armed_at = self._renewed = self._last_t = self._status_at = 0.0
        self._was_armed = self._watches = False
        self._begun = time.monotonic()
        self._offset = 0.0
        self._streams = False
        self._shared_until = 0.0
        self._bench: Bench | None = None
        self._fast: Fast | None = None
        self._lost = 0

    # ---- For other threads.

    def fresh(self) -> list[dict[str, float]]:
        """Rows since the last time."""
        with self._lock:
            rows, self._fresh = self._fresh, []
        return rows

    def state(self) -> dict[str, Any]:
        """What a page shows besides rows."""
        status, hand, live = self._status, self._plug.hand, self._fast
        told = hand.told if hand is not None else None
        return {
            "live": self._live,
            "problem": self._problem,
            "note": self._note,
            "virtual": self._plug.virtual,
            "plugged": self._plug.plugged,
            "speed": told.speed if told is not None and told.speed else None,
            "hand": told.hand_rad if told is not None else None,
            "wanted": self._owner is not None,
            "armed": bool(status.get("armed")),
            "running": bool(status.get("running")),
            "refused": arm_refusal(status.get("arm_refused", 0)),
            "faults": [FAULTS[bit][0] for bit in bits_of(status.get("faults", 0))],
            "overrun": bool(status.get("overrun")),
            "recording": self.kept.recording,
            "recorded": self.kept.recorded,
            "rows": len(self.kept),
            "row_hz": live.row_hz if live is not None else None,
            "lost": self._lost,
            **self._shown,
        }

    def ask(self, what: Callable[[Bench], None]) -> Future[None]:
        """Do something between two exchanges; :class:`HostError` by the future."""
        future: Future[None] = Future()
        if self._live:
            self._asked.put((what, future))
        else:
            future.set_exception(HostError("there is no board to tell"))
        return future

    def arm(self, owner: object) -> Future[None]:
        """Arm for a page, as long as it gives signs of life (:meth:`beat`).

        A stop after this call wins, whether it comes before the exchange that arms or during it.
        """
        stops = self._stops
        self._asker = owner

        def first(bench: Bench) -> None:
            if not bench.arms:
                raise HostError(NO_ARMING)
            if self._stops != stops:
                raise HostError(STOPPED)
            try:
                bench.arm(1)
            except HostError:
                self.stop()  # it may have been heard all the same
                raise
            if self._stops != stops:
                self.stop()  # once more, if what has been done about it was before the arming
                raise HostError(STOPPED)
            now = time.monotonic()
            self._owner, self._beat = owner, now
            self._armed_at = self._renewed = now
            self._was_armed, self._note = False, ""

        return self.ask(first)

    def beat(self, owner: object) -> None:
        """A sign of life."""
        if owner is self._owner:
            self._beat = time.monotonic()

    def stop(self) -> None:
        """Switch the bridges off, before anything else that is asked for."""
        with self._lock:
            self._stops += 1

    def leave(self, owner: object) -> None:
        """A page has gone, perhaps before what it asked for was done."""
        if owner is self._owner or owner is self._asker:
            self.stop()

    def lead(self, *place: float) -> None:
        """Lead the hand of a virtual board."""
        hand = self._plug.hand
        if hand is not None:
            hand.lead(*place)

    def end(self) -> None:
        """Switch off, and end the thread; :class:`HostError` where the board didn't hear that."""
        self._ended.set()
        self.join()
        if self._unheard:
            raise HostError(f"{self._unheard} (the bridges go off by themselves, 200 ms later)")

    # ---- The thread.

    def run(self) -> None:
        try:
            while not self._ended.is_set():
                self._connected()
                self._ended.wait(_AGAIN_S)
        finally:
            self._plug.close()

    def _connected(self) -> None:
        """One time with the board, until it doesn't answer, or something goes wrong here."""
        bench = None
        try:
            bench = self._connect()
            self._live, self._problem = True, ""
            self._serve(bench)
        except (HostError, OSError) as error:
            self._problem = str(error)
            if self._ended.is_set() and self._owner is not None:
                self._unheard = self._problem
        except Exception as error:
            # Whatever it is, the thread that switches off may not end by it.
            self._problem = _line_of(error)
            if bench is not None:
                with contextlib.suppress(Exception):
                    bench.arm(0)
        finally:
            self._live = False
            if self._owner is not None:
                # It stays when the board answers again: nothing else says why the bridges are off.
                self._note = f"switched off: {self._problem}"
            self._disarmed()
            self._status = {}
            self._refuse_all()

    def _connect(self) -> Bench:
        problem = self._plug.problem
        if problem:
            raise HostError(problem)
        client = Client(self._plug.port, self._unit, self._timeout_s)
        bench = self._bench = Bench(client, self._known, self._motor, self._bench)
        # What a page asks for may be many exchanges, of 16 ms each through some USB bridges.
        client.before_each = lambda: self._watch(bench)
        self._plug.connect_hand()
        self._shown = bench.shown()
        self._streams = not (bench.brushless or bench.arm_bench) and fast.is_worth(client)
        if self._streams:
            # Where the way there can't bear the fast rate, that takes a second: now, nothing is on.
            with client.hurry():
                pass
            self._share()
        return bench

    def _share(self) -> None:
        """Leave the port to others between exchanges, for a while."""
        self._shared_until = time.monotonic() + SHARED_S

    def _serve(self, bench: Bench) -> None:
        turn, seen, row = 0, {}, {}
        while not self._ended.is_set():
            if self._streams and time.monotonic() >= self._shared_until:
                self._stream(bench)
                continue
            self._attend(bench)
            tip = bench.arm_bench.renew() if bench.arm_bench is not None else {}
            if self._streams and bench.client.awaited:
                self._share()
            if not tip or turn % _PLANES_EVERY == 0:
                if turn % _SEEN_EVERY == 0:
                    seen = bench.seen()
                row = bench.row(bench.step(), seen)
            turn += 1
            row = {**row, **tip}
            moment = self._time_s()
            if moment is not None:
                self._keep(row, moment)
        bench.arm(0)

    def _stream(self, bench: Bench) -> None:
        """Rows by the device's stream, until somebody waits for the port, or the credit lapses."""
        with Fast(bench) as live:
            lost = self._lost
            seen_at = -math.inf
            seen: dict[str, float] = {}
            begin_s: float | None = None

            def keep() -> None:
                """Rows that have come, once it is known when they began."""
                nonlocal begin_s
                if begin_s is None and live.seconds:
                    moment = self._time_s()
                    begin_s = None if moment is None else moment - live.seconds
                for since_s, row in live.rows(seen):
                    if begin_s is not None:
                        self._keep(row, begin_s + since_s)
                self._lost = lost + live.lost

            with ending(keep, partial(self._show, None)):
                self._show(live)
                while not self._ended.wait(_TURN_S):
                    self._attend(bench)
                    if time.monotonic() - seen_at >= _SEEN_S:
                        seen_at, seen = time.monotonic(), bench.seen()
                    keep()
                    if live.is_over or bench.client.awaited:
                        self._share()
                        return
                bench.arm(0)

    def _show(self, live: Fast | None) -> None:
        self._fast = live

    def _attend(self, bench: Bench) -> None:
        """What goes before rows: a stop, what is asked for, and now and then the status."""
        if self._plug.problem:
            raise HostError(self._plug.problem)
        self._watch(bench)
        self._do_one(bench)
        if time.monotonic() - self._status_at >= _STATUS_S:
            self._status_at = time.monotonic()
            self._status = bench.status()
            self._judge()

    def _watch(self, bench: Bench) -> None:
        """Off, if somebody wants that or nobody is there; else renewed in time.

        Before each exchange, but for those that it makes itself.
        """
        if self._watches:
            return
        self._watches = True
        try:
            self._switch(bench)
        finally:
            self._watches = False

    def _switch(self, bench: Bench) -> None:
        now = time.monotonic()
        silent = self._owner is not None and now - self._beat > PATIENCE_S
        stops = self._stops
        if stops != self._stops_done or silent:
            self._disarmed()
            bench.arm(0)
            self._stops_done = stops
            self._note = ""
            if silent:
                self._note = "switched off: the page that armed was silent"
            elif not bench.arms:
                self._note = NO_ARMING
        elif self._owner is not None and now - self._renewed >= RENEWAL_S:
            self._renewed = now
            bench.arm(2)

    def _judge(self) -> None:
        """After an arming: whether it is so, and if not, why."""
        if self._owner is None:
            return
        armed, refused = self._status["armed"], arm_refusal(self._status["arm_refused"])
        if armed:
            self._was_armed = True
        elif refused or self._was_armed:
            self._note = f"switched off: {refused or 'somebody has disarmed it'}"
            self._disarmed()
        elif time.monotonic() - self._armed_at > ZERO_S:
            self._note = "not armed: the zero takes too long; are there ticks at all?"
            self._disarmed()

    def _disarmed(self) -> None:
        self._owner, self._was_armed = None, False

    def _do_one(self, bench: Bench) -> None:
        try:
            what, future = self._asked.get_nowait()
        except queue.Empty:
            return
        if not future.set_running_or_notify_cancel():
            return  # who asked has gone
        try:
            what(bench)
            self._shown = bench.shown()
        except HostError as error:
            future.set_exception(error)
        except Exception as error:
            future.set_exception(HostError(_line_of(error)))
        else:
            future.set_result(None)

    def _refuse_all(self) -> None:
        while True:
            try:
                _, future = self._asked.get_nowait()
            except queue.Empty:
                return
            if future.set_running_or_notify_cancel():
                future.set_exception(HostError("the board doesn't answer"))

    def _time_s(self) -> float | None:
        """Time of the device, s, or of this machine; None until a virtual board tells it."""
        hand = self._plug.hand
        return hand.time_s() if hand is not None else time.monotonic() - self._begun

    def _keep(self, row: dict[str, float], time_s: float) -> None:
        hand = self._plug.hand
        if hand is not None and hand.told is not None:
            names = ("x_hand",) if len(hand.told.hand) == 1 else ("hand_x", "hand_y")
            row |= dict(zip(names, hand.told.hand, strict=True))
        # A board that was plugged in anew begins at 0 again; time goes on.
        row["t"] = self._last_t = self._onward(time_s)
        self.kept.add(row)
        with self._lock:
            self._fresh.append(row)
            del self._fresh[:-_MOST_FRESH]

    def _onward(self, time_s: float) -> float:
        moment = time_s + self._offset
        if moment < self._last_t - 0.5:
            self._offset = self._last_t - time_s
        return max(self._last_t, time_s + self._offset)


def _line_of(error: Exception) -> str:
    """An error that nobody foresaw, in one line."""
    return " ".join(f"the scope has a fault: {type(error).__name__}: {error}".split())
