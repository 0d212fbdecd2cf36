# SPDX-License-Identifier: Apache-2.0
"""``wavehaptics board scope``, once its options are known."""

from __future__ import annotations

import asyncio
import errno
import os
import webbrowser

from wavehaptics.host.names import HostError
from wavehaptics.host.scope.bench import Known
from wavehaptics.host.scope.feed import Feed
from wavehaptics.host.scope.plug import Plug
from wavehaptics.host.scope.server import Scope, serve
from wavehaptics.runtime.ends import end_signals, ending


def run(
    plug: Plug, known: Known, *, http_port: int, browser: bool, unit: int, motor: int,
    timeout_s: float,
) -> None:  # fmt: skip
    """Serve the page until it is asked to end; then the bridges are switched off.

    :class:`HostError` where that isn't heard.
    """
    feed = Feed(plug, known, unit=unit, motor=motor, timeout_s=timeout_s)
    scope = Scope(feed, plug)
    feed.start()
    with ending(feed.end):
        try:
            asyncio.run(_serve(scope, http_port, browser))
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
            raise HostError(
                f"port {http_port} is taken; name another one with --http-port, or 0 for any"
            ) from None


async def _serve(scope: Scope, http_port: int, browser: bool) -> None:
    ended = asyncio.Event()
    for number in end_signals():
        asyncio.get_running_loop().add_signal_handler(number, ended.set)

    def tell(address: str) -> None:
        print(address, flush=True)
        # Without a screen there are only browsers for terminals, which would take this one.
        if browser and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            webbrowser.open(address)

    await serve(scope, http_port, ended, tell)
