# SPDX-License-Identifier: Apache-2.0
"""``patch``: a built bitstream with the settings of another scene."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer
from wavehaptics.cli.shared import CommandError
from wavehaptics.scene import find_scene

app = typer.Typer()


@app.command()
def patch(
    bitstream: Annotated[
        Path, typer.Argument(metavar="BITSTREAM", help="Of an ECP5 board with a link: a .bit file.")
    ],
    scene: Annotated[
        str, typer.Argument(metavar="SCENE", help="Whose settings it is to begin with.")
    ],
    board: Annotated[
        str | None,
        typer.Option(metavar="BOARD", help="Its folder of boards/; by default the file's name."),
    ] = None,
    built_with: Annotated[
        str | None,
        typer.Option(
            metavar="SCENE", help="What it begins with now; by default the board's own scene."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="File to write; by default beside BITSTREAM."),
    ] = None,
) -> None:
    """Put the settings of SCENE into a built bitstream, in seconds."""
    from wavehaptics.fpga.boards import BoardError, board_names, load_board
    from wavehaptics.runtime.toolchain import Toolchain

    from wavetools.fpga.patching import PatchError
    from wavetools.fpga.patching import patch as patched
    from wavetools.fpga.synthesis import SynthesisError

    name = board or bitstream.stem
    if name not in board_names():
        raise CommandError(
            f"{name} is no board; name the bitstream's with --board, one of "
            f"{', '.join(board_names())}"
        )
    try:
        built = load_board(name, scene_path=find_scene(built_with) if built_with else None)
        wanted = load_board(name, scene_path=find_scene(scene))
        out = out or bitstream.with_name(f"{bitstream.stem}-{Path(wanted.scene_file).stem}.bit")
        patched(bitstream, built, wanted, out, Toolchain.of_environment())
    except (BoardError, PatchError, SynthesisError) as error:
        raise CommandError(str(error)) from None
    except OSError as error:
        place = error.filename or bitstream
        raise CommandError(f"{place}: {error.strerror}; name a file that can be used") from None
    print(f"{out}: begins with the settings of {wanted.scene_file}")
    for words in (wanted.fpga.program, wanted.fpga.flash):
        print(shlex.join(word.replace("{bitstream}", str(out)) for word in words))
