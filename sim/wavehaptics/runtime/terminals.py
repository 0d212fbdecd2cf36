# SPDX-License-Identifier: Apache-2.0
"""Pseudo-terminals, which stand in for serial lines."""

from __future__ import annotations

import os

from wavehaptics.runtime.toolchain import ToolError


def open_terminal() -> tuple[int, int, str]:
    """A pseudo-terminal: both ends, and the path of the second one, where a host opens it.

    :class:`ToolError` with the cure where the machine has none.
    """
    try:
        master, slave = os.openpty()
        return master, slave, os.ttyname(slave)
    except OSError as error:
        raise ToolError(
            f"there are no pseudo-terminals here ({error.strerror}); mount them: mount -t devpts "
            "-o ptmxmode=666 devpts /dev/pts && ln -sf pts/ptmx /dev/ptmx"
        ) from None


def check_terminals() -> None:
    """:class:`ToolError` where the machine has no pseudo-terminals."""
    for end in open_terminal()[:2]:
        os.close(end)
