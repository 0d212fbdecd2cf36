# SPDX-License-Identifier: Apache-2.0
"""``python -m wavetools``: commands that measure and check the repository, as its Makefile does.

Refusals and exit statuses are those of ``wavehaptics``.
"""

from __future__ import annotations

import typer
from wavehaptics.cli.ending import run_and_exit

from wavetools.cli import checks, measures, patching

app = typer.Typer(
    help="Measure and check the repository of wavehaptics, in a checkout of it.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
for group in (measures, checks, patching):
    app.add_typer(group.app)


def main() -> None:
    """Run the command line and exit with its status."""
    run_and_exit(app, "wavetools")
