# SPDX-License-Identifier: Apache-2.0
"""Commands for a board on a serial port, and the virtual board that takes its place.

A module has the commands of one kind, which join the group as it is imported; their order here is
that of the command's help.
"""

import typer

# isort: off
from wavehaptics.cli.board import virtual, words, arming, identify, faults, capture, stream, scope

# isort: on
from wavehaptics.cli.board.common import board

__all__ = ["app", "arming", "capture", "faults", "identify", "scope", "stream", "virtual", "words"]

app = typer.Typer()
app.add_typer(board, name="board")
