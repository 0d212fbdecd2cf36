# SPDX-License-Identifier: Apache-2.0
"""How something ends: by which signals, and that the end can fail as well."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager


def end_signals() -> list[signal.Signals]:
    """Signals that ask for an end: of Ctrl-C, of `kill`, and of a terminal that is closed."""
    asks = [signal.SIGINT, signal.SIGTERM]
    nohup = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    return asks if nohup else [*asks, signal.SIGHUP]


@contextmanager
def ending(*steps: Callable[[], object]) -> Iterator[None]:
    """Do the ``steps`` after the block, however it ends, and each whatever the others raise.

    The first error is raised: the block's, or else that of the first step that failed. So no
    clean-up hides why it had to be done.
    """
    first: BaseException | None = None
    try:
        yield
    except BaseException as error:
        first = error
    for step in steps:
        try:
            step()
        except Exception as error:
            first = first or error
    if first is not None:
        raise first
