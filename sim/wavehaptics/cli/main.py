# SPDX-License-Identifier: Apache-2.0
"""The command ``wavehaptics``.

What is wrong with the input is told in one line on stderr, ``wavehaptics: ...``, with exit status
2; an interrupted run ends with 130. What takes seconds to import is imported only once the scene is
known to be right.
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from wavehaptics.cli import board, machine, replaying, scenes, studies, sweeping, tuning
from wavehaptics.cli.ending import run_and_exit
from wavehaptics.cli.shared import CommandError

OF_A_CHECKOUT = (
    "adcs", "bench", "encoders", "holding", "mutate", "patch", "sensing", "soak", "soak-link",
    "tables",
)  # fmt: skip
"""Commands of the repository, which its tools have; most of them once were here."""


class _Commands(TyperGroup):
    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args[0] in OF_A_CHECKOUT:
            where = f"python -m wavetools {args[0]}"
            if find_spec("wavetools") is None:
                raise CommandError(f"{args[0]} is of the repository; run `{where}` in a checkout")
            print(f"wavehaptics: {args[0]} is `{where}`", file=sys.stderr, flush=True)
            there = import_module("wavetools.cli.main").app
            raise typer.Exit(there(args, prog_name="wavetools", standalone_mode=False) or 0)
        return super().resolve_command(ctx, args)


app = typer.Typer(
    cls=_Commands,
    help="Run wave haptics scenes: a motor, a hand, a wall and a controller of your choice.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
for group in (scenes, sweeping, tuning, studies, machine, board, replaying):
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


def main() -> None:
    """Run the command line and exit with its status."""
    run_and_exit(app, "wavehaptics")
