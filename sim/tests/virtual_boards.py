# SPDX-License-Identifier: Apache-2.0
"""Virtual boards of a scene, and what the command line says to them."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from wavehaptics.runtime.terminals import check_terminals


def _board(*words: str, port: str = "") -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-m", "wavehaptics", "board", *words], text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, "WH_PORT": port},
    )  # fmt: skip


@contextmanager
def virtual_board(scene: Path, sets: tuple[str, ...] = ()) -> Iterator[str]:
    """The port of one, which is gone at the end."""
    check_terminals()
    there = _board("--virtual", str(scene), *(w for text in sets for w in ("--set", text)))
    try:
        yield there.stdout.readline().strip()
    finally:
        there.terminate()
        there.communicate()


def told(port: str, *words: str) -> tuple[int, str, str]:
    """Status, stdout and stderr of ``board WORDS`` at a port."""
    asking = _board(*words, port=port)
    out, err = asking.communicate(timeout=900)
    return asking.returncode, out, err
