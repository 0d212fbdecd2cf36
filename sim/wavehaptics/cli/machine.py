# SPDX-License-Identifier: Apache-2.0
"""The command that looks at the machine it runs on."""

from __future__ import annotations

import typer

app = typer.Typer()


@app.command()
def doctor() -> None:
    """Look what this machine lacks: versions, tools, ports, each with its cure.

    Ends with 1 if something is missing that simulations need, or a port can't be opened.
    """
    from wavehaptics.runtime.doctor import main

    if status := main():
        raise typer.Exit(status)
