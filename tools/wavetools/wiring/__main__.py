# SPDX-License-Identifier: Apache-2.0
"""Draw the schematic, fill the tables of the pages, and say what of the circuits is not safe.

``make drawings`` calls it.
"""

from __future__ import annotations

import typer
from wavehaptics.fpga.boards import BoardError
from wavehaptics.scene import SceneError

from wavetools.wiring import drawings, pages, spice
from wavetools.wiring.parts import WiringError, load_table, power_boards


def main() -> None:
    """Exit status 1 for circuits that are not safe, 2 for a table that can't be read."""
    try:
        table = load_table()
        unsafe = [line for each in (table, *power_boards()) for line in spice.complaints(each)]
        for line in unsafe:
            typer.echo(f"wiring: {line}", err=True)
        if unsafe:
            raise typer.Exit(1)
        for path in (*drawings.write(table), *pages.write(table)):
            typer.echo(str(path))
    except (WiringError, BoardError, SceneError) as error:
        typer.echo(f"wiring: {error}", err=True)
        raise typer.Exit(2) from None


if __name__ == "__main__":
    typer.run(main)
