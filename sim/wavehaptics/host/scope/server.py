# SPDX-License-Identifier: Apache-2.0
"""The scope's page on loopback, and what may talk to it.

Other hosts' names (a page that has been given another address by its name server), other origins
and whoever doesn't know the run's token are refused.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import json
import math
import secrets
from collections.abc import Awaitable, Callable
from concurrent.futures import Future
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from wavehaptics.host.names import HostError
from wavehaptics.host.scope.feed import Feed
from wavehaptics.host.scope.feels import FEELS
from wavehaptics.host.scope.plug import Plug
from wavehaptics.runtime.repository import PACKAGE
from wavehaptics.words.faults import FAULTS

ADDRESS = "127.0.0.1"
PAGE = PACKAGE / "host" / "scope" / "page"
FRAME_S = 0.03
"""From one message with rows to the next."""
_STATE_FRAMES = 5
_TAKES_S = 1.0
"""In which a page has to take what it is told."""
_MOST_MESSAGE = 4096

_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}

_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Scope:
    """The page and its websocket, for a feed."""

    def __init__(self, feed: Feed, plug: Plug) -> None:
        self._feed, self._plug = feed, plug
        self.token = secrets.token_urlsafe(24)
        self._pages: set[web.WebSocketResponse] = set()
        self.app = web.Application(middlewares=[self._guard], client_max_size=_MOST_MESSAGE)
        self.app.add_routes(
            [
                web.get("/", self._index),
                web.get("/live", self._live),
                web.get("/trace.npz", self._npz),
                web.get("/trace.csv", self._csv),
                web.static("/page", PAGE),
            ]
        )
        self.app.cleanup_ctx.append(self._telling)
        self.app.on_shutdown.append(self._part)

    # ---- Who may.

    @web.middleware
    async def _guard(self, request: web.Request, handler: _Handler) -> web.StreamResponse:
        """Refuse other hosts' names and other origins."""
        found = request.transport and request.transport.get_extra_info("sockname")
        port = found[1] if found else 0
        names = {f"{name}:{port}" for name in (ADDRESS, "localhost")}
        if request.headers.getall("Host", []) not in [[name] for name in names]:
            raise web.HTTPForbidden(text="this page is served to this machine alone\n")
        origins = request.headers.getall("Origin", [])
        asks = request.method not in ("GET", "HEAD") or request.path == "/live"
        if origins != [f"http://{request.host}"] and (asks or origins):
            raise web.HTTPForbidden(text="another origin may not ask\n")
        try:
            response = await handler(request)
        except web.HTTPException as error:
            error.headers.update(_HEADERS)
            raise
        if not response.prepared:
            response.headers.update(_HEADERS)
        return response

    def _know(self, request: web.Request) -> None:
        """Refuse who doesn't know the token."""
        given = request.query.get("token", "")
        if not hmac.compare_digest(given.encode(), self.token.encode()):
            raise web.HTTPForbidden(text="open the page by the address that the command printed\n")

    # ---- What there is.

    async def _index(self, request: web.Request) -> web.StreamResponse:
        self._know(request)
        return web.FileResponse(PAGE / "index.html", headers=_HEADERS)

    async def _npz(self, request: web.Request) -> web.StreamResponse:
        self._know(request)
        body = await asyncio.to_thread(self._feed.kept.npz)
        return self._file(body, "application/octet-stream", "trace.npz")

    async def _csv(self, request: web.Request) -> web.StreamResponse:
        self._know(request)
        body = await asyncio.to_thread(self._feed.kept.csv)
        return self._file(body.encode(), "text/csv", "trace.csv")

    @staticmethod
    def _file(body: bytes, kind: str, name: str) -> web.Response:
        disposition = {"Content-Disposition": f'attachment; filename="{name}"'}
        return web.Response(body=body, content_type=kind, headers=disposition)

    async def _live(self, request: web.Request) -> web.StreamResponse:
        self._know(request)
        page = web.WebSocketResponse(max_msg_size=_MOST_MESSAGE, heartbeat=5.0)
        await page.prepare(request)
        faults = [{"name": name, "meaning": meaning} for name, meaning in FAULTS.values()]
        feels = [
            {"name": name, "title": feel.title, "meaning": feel.meaning}
            for name, feel in FEELS.items()
        ]
        hello = {
            "type": "hello", "faults": faults, "feels": feels, "virtual": self._plug.virtual
        }  # fmt: skip
        await page.send_str(_text(hello))
        self._pages.add(page)
        answers: set[asyncio.Task[None]] = set()
        try:
            async for message in page:
                if message.type is WSMsgType.TEXT:
                    # What has to wait for the line holds up nothing: a stop may come behind it.
                    task = asyncio.create_task(self._answer(message.data, page))
                    answers.add(task)
                    task.add_done_callback(answers.discard)
        finally:
            self._pages.discard(page)
            self._feed.leave(page)
        return page

    async def _answer(self, text: str, page: web.WebSocketResponse) -> None:
        """Do what a page asks, and tell it in one line what was wrong."""
        try:
            asked = json.loads(text)
            wanted = self._take(asked, page)
            if wanted is None:
                return
            await asyncio.wrap_future(wanted)
            problem = ""
        except HostError as error:
            problem = str(error)
        except (ValueError, TypeError, KeyError, OverflowError):
            problem = "the page asks for something unknown; load it anew"
        with contextlib.suppress(ConnectionError):
            await page.send_str(_text({"type": "told", "problem": problem}))

    def _take(self, asked: dict[str, Any], page: web.WebSocketResponse) -> Future[None] | None:
        """Begin what a page asks; None where there is nothing to wait for."""
        feed = self._feed
        match asked["type"]:
            case "beat":
                feed.beat(page)
            case "hand":
                place = asked["place"]
                feed.lead(*map(float, place if isinstance(place, list) else [place]))
            case "stop":
                feed.stop()
            case "record":
                feed.kept.record(bool(asked["on"]))
            case "plug":
                self._plug.set_in(bool(asked["in"]))
            case "arm":
                return feed.arm(page)
            case "clear":
                return feed.ask(lambda bench: bench.clear())
            case "slide":
                name, value = str(asked["name"]), float(asked["value"])
                return feed.ask(lambda bench: bench.slide(name, value))
            case "feel":
                feel = str(asked["name"])
                return feed.ask(lambda bench: bench.feel(feel))
            case "word":
                word = str(asked["text"])
                return feed.ask(lambda bench: bench.set_word(word))
            case _:
                raise ValueError
        return None

    # ---- What pages are told.

    async def _telling(self, _: web.Application) -> Any:
        task = asyncio.create_task(self._tell())
        yield
        task.cancel()

    async def _tell(self) -> None:
        frame = 0
        parting: set[asyncio.Task[bool]] = set()
        while True:
            await asyncio.sleep(FRAME_S)
            rows = self._feed.fresh()
            texts = []
            if rows:
                names = sorted({name for row in rows for name in row})
                columns = {name: [_short(row.get(name)) for row in rows] for name in names}
                texts.append(_text({"type": "rows", "columns": columns}))
            if frame % _STATE_FRAMES == 0:
                texts.append(_text({"type": "state", **self._feed.state()}))
            frame += 1
            for page in list(self._pages):
                for text in texts:
                    try:
                        await asyncio.wait_for(page.send_str(text), _TAKES_S)
                    except (ConnectionError, asyncio.TimeoutError):
                        # It comes back by itself, if it is still there.
                        self._pages.discard(page)
                        task = asyncio.create_task(page.close())
                        parting.add(task)
                        task.add_done_callback(parting.discard)
                        break

    async def _part(self, _: web.Application) -> None:
        for page in list(self._pages):
            await page.close(code=WSCloseCode.GOING_AWAY, message=b"the scope has ended")


def _short(value: float | None) -> float | None:
    """A number that JSON has, with as many digits as a picture needs; time has more."""
    if value is None or not math.isfinite(value):
        return None
    return float(f"{value:.9g}")


def _text(message: dict[str, Any]) -> str:
    return json.dumps(message, allow_nan=False, separators=(",", ":"))


async def serve(scope: Scope, port: int, ended: asyncio.Event, tell: Callable[[str], None]) -> None:
    """Serve until ``ended``; ``tell`` gets the page's address. ``OSError`` if the port is taken."""
    runner = web.AppRunner(scope.app, access_log=None, shutdown_timeout=1.0)
    await runner.setup()
    try:
        await web.TCPSite(runner, ADDRESS, port).start()
        (address,) = runner.addresses
        tell(f"http://{ADDRESS}:{address[1]}/?token={scope.token}")
        await ended.wait()
    finally:
        await runner.cleanup()
