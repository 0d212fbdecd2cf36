# SPDX-License-Identifier: Apache-2.0
"""Tests as processes in groups of their own, which end with all that they have started."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path

_lock = threading.Lock()
_running: set[subprocess.Popen] = set()
_stopped = threading.Event()


class StoppedError(RuntimeError):
    """The run was interrupted; what a test said since doesn't count."""


def run_tests(
    command: Sequence[str], cwd: Path, environment: Mapping[str, str], log: Path, timeout_s: float
) -> int | None:
    """Exit status of ``command``, None if it had to be killed after ``timeout_s``."""
    with log.open("wb") as output:
        with _lock:
            if _stopped.is_set():
                raise StoppedError("interrupted")
            process = subprocess.Popen(
                command, cwd=cwd, env={**os.environ, **environment}, stdin=subprocess.DEVNULL,
                stdout=output, stderr=subprocess.STDOUT, start_new_session=True,
            )  # fmt: skip
            _running.add(process)
        try:
            status = process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            status = None
        finally:
            with _lock:
                _running.discard(process)
            if process.returncode is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
    if _stopped.is_set():
        raise StoppedError("interrupted")
    return status


def stop() -> None:
    """Kill what runs; what would be run from now on isn't."""
    with _lock:
        _stopped.set()
        for process in _running:
            os.killpg(process.pid, signal.SIGKILL)


def start() -> None:
    """Let runs happen again after a :func:`stop`."""
    _stopped.clear()
