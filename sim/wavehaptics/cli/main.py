# SPDX-License-Identifier: Apache-2.0
"""The command ``wavehaptics``.

What is wrong with the input is told in one line on stderr, ``wavehaptics: ...``, with exit status
2; an interrupted run ends with 130. What takes seconds to import is imported only once the scene is
known to be right.
"""

from __future__ import annotations

import io
import os
import signal
import sys
from importlib.metadata import version
from threading import Timer
from typing import Annotated, Any

import typer

from wavehaptics.cli import board, checks, patching, replaying, scenes, studies, sweeping, tuning
from wavehaptics.cli.options import home
from wavehaptics.cli.shared import CommandError
from wavehaptics.runtime.toolchain import ToolError
from wavehaptics.scene import SceneError

USAGE_STATUS = 2
INTERRUPTED_STATUS = 130

# Base of all errors in the use of the command; typer gives it no public name.
_UsageError: Any = typer.BadParameter.__base__

app = typer.Typer(
    help="Run wave haptics scenes: a motor, a hand, a wall and a controller of your choice.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
for group in (scenes, sweeping, tuning, studies, checks, board, replaying, patching):
    app.add_typer(group.app)


def _tell_version(asked: bool) -> None:
    if asked:
        print(f"wavehaptics {version('wavehaptics')}")
        raise typer.Exit


@app.callback()
def _options(
    told: Annotated[
        bool,
        typer.Option(
            "--version", callback=_tell_version, is_eager=True, help="Tell the version and exit."
        ),
    ] = False,
) -> None:
    """Options of the command itself; its help is the app's."""


AGAIN_S = 0.01
"""How long after an interruption that was swallowed it is asked for once more."""


def _interrupt_again(unraisable: Any) -> None:
    """Ctrl-C within a destructor or a callback, where Python only reports it: ask once more."""
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        # What is raised in here is swallowed as well.
        Timer(AGAIN_S, os.kill, (os.getpid(), signal.SIGINT)).start()
    else:
        sys.__unraisablehook__(unraisable)


def main() -> None:
    """Run the command line and exit with its status."""
    sys.unraisablehook = _interrupt_again
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        status = app(prog_name="wavehaptics", standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED_STATUS
    except BrokenPipeError:  # the reader of our output has left
        sys.stdout = None
        status = 1
    except (SceneError, CommandError, ToolError) as error:
        status = _refuse(str(error))
    except _UsageError as error:
        problem = " ".join(error.format_message().split()).rstrip(".")
        status = _refuse(f"{problem}; {home(error) or 'wavehaptics --help shows the use'}")
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package in ("", "wavehaptics"):
            raise
        status = _refuse(f"this needs the Python package {package}; run `pip install {package}`")
    except (OSError, MemoryError) as error:
        status = _refuse(str(error) or "out of memory")
    if status == INTERRUPTED_STATUS:
        print("wavehaptics: interrupted", file=sys.stderr)
    sys.exit(status or 0)


def _refuse(problem: str) -> int:
    print(f"wavehaptics: {problem}", file=sys.stderr)
    return USAGE_STATUS
