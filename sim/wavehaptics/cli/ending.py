# SPDX-License-Identifier: Apache-2.0
"""How a command line ends: its exit status, and one line on stderr for what is wrong."""

from __future__ import annotations

import io
import os
import signal
import sys
from threading import Timer
from typing import Any, NoReturn

import typer

from wavehaptics.cli.options import home
from wavehaptics.cli.shared import CommandError
from wavehaptics.runtime.toolchain import ToolError
from wavehaptics.scene import SceneError

USAGE_STATUS = 2
INTERRUPTED_STATUS = 130

# Base of all errors in the use of the command; typer gives it no public name.
_UsageError: Any = typer.BadParameter.__base__

AGAIN_S = 0.01
"""How long after an interruption that was swallowed it is asked for once more."""


def _interrupt_again(unraisable: Any) -> None:
    """Ctrl-C within a destructor or a callback, where Python only reports it: ask once more."""
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        # What is raised in here is swallowed as well.
        Timer(AGAIN_S, os.kill, (os.getpid(), signal.SIGINT)).start()
    else:
        sys.__unraisablehook__(unraisable)


def run_and_exit(app: Any, program: str) -> NoReturn:
    """Run the command line of ``program``, and exit with its status."""

    def refuse(problem: str) -> int:
        print(f"{program}: {problem}", file=sys.stderr)
        return USAGE_STATUS

    sys.unraisablehook = _interrupt_again
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        status = app(prog_name=program, standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED_STATUS
    except BrokenPipeError:  # the reader of our output has left
        sys.stdout = None
        status = 1
    except (SceneError, CommandError, ToolError) as error:
        status = refuse(str(error))
    except _UsageError as error:
        problem = " ".join(error.format_message().split()).rstrip(".")
        status = refuse(f"{problem}; {home(error) or f'{program} --help shows the use'}")
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package in ("", "wavehaptics", program):
            raise
        status = refuse(f"this needs the Python package {package}; run `pip install {package}`")
    except (OSError, MemoryError) as error:
        status = refuse(str(error) or "out of memory")
    if status == INTERRUPTED_STATUS:
        print(f"{program}: interrupted", file=sys.stderr)
    sys.exit(status or 0)
