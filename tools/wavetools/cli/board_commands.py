# SPDX-License-Identifier: Apache-2.0
"""Commands for the boards, which the Makefile calls.

``python -m wavetools.cli.board_commands --help`` tells them.
"""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Annotated, NoReturn

import typer
from wavehaptics.fpga.boards import Board, BoardError, board_names, load_board
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain, ToolError
from wavehaptics.scene import SceneError, find_scene

from wavetools.fpga import resources, synthesis
from wavetools.fpga.synthesis import SynthesisError
from wavetools.pages import filler

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, help=__doc__)

BoardArgument = Annotated[str, typer.Argument(metavar="BOARD", help="A folder of boards/.")]
DeviceOption = Annotated[
    str | None, typer.Option(help="The FPGA that is fitted, where a board comes with several.")
]

SeedOption = Annotated[
    int | None, typer.Option(help="Seed of the placer, in place of the board's own ones.")
]

SceneOption = Annotated[
    str, typer.Option("--scene", help="A scene in place of the board's own: a path, or a name.")
]

_ERRORS = (BoardError, SceneError, SynthesisError, ToolError, filler.NumbersError)


def _fail(error: Exception) -> NoReturn:
    """One line, and 1 where a design fails, 2 where something else must be put right first."""
    typer.echo(f"synthesis: {error}", err=True)
    raise typer.Exit(1 if isinstance(error, SynthesisError) else 2)


@app.command()
def bitstream(
    board: BoardArgument, device: DeviceOption = None, seed: SeedOption = None,
    scene: SceneOption = "",
) -> None:  # fmt: skip
    """Make the bitstream of a board."""
    try:
        chosen = _chosen(board, device, scene)
        result = synthesis.build_board(chosen, Toolchain.of_environment(), seed)
    except _ERRORS as error:
        _fail(error)
    typer.echo(synthesis.summary_line(result))
    typer.echo(str(synthesis.bitstream_path(chosen)))


@app.command()
def synth(
    jobs: Annotated[int, typer.Option(min=1, help="Boards that are made at a time.")] = 1,
) -> None:
    """Make the bitstreams of all boards but those on demand, and build/synth/summary.json."""
    results = []
    try:
        boards, tools = list(map(load_board, board_names())), Toolchain.of_environment()
        for board in boards:
            synthesis.check_board(board)
        boards = [board for board in boards if not board.fpga.on_demand]
        # The work is the tools', which are processes of their own.
        with ThreadPoolExecutor(jobs) as pool:
            made = [pool.submit(synthesis.build_board, board, tools) for board in boards]
            try:
                for each in made:
                    results.append(each.result())
                    typer.echo(synthesis.summary_line(results[-1]))
            finally:
                pool.shutdown(cancel_futures=True)
        typer.echo(str(synthesis.write_summary(results).relative_to(ROOT)))
    except _ERRORS as error:
        _fail(error)


@app.command()
def seeds(
    board: BoardArgument,
    device: DeviceOption = None,
    count: Annotated[int, typer.Option(min=1, help="Seeds to try, from 1.")] = 8,
) -> None:
    """Place a board with several seeds, and say which meet its clock."""
    try:
        chosen = load_board(board, device or None)
        found = synthesis.survey_seeds(
            chosen, Toolchain.of_environment(), range(1, count + 1), typer.echo
        )
    except _ERRORS as error:
        _fail(error)
    good = [seed for spare, seed in found if spare >= synthesis.SPARE]
    typer.echo(f"for {chosen.folder}/fpga.toml, the best first: seeds = {good}")


def _chosen(board: str, device: str | None, scene: str) -> Board:
    """A board with its own scene, or with another one."""
    if not scene:
        return load_board(board, device or None)
    return load_board(board, device or None, scene_path=find_scene(scene))


def _programmer(board: str, device: str | None, flash: bool, scene: str = "") -> NoReturn:
    """Call a board's programmer with its bitstream, and hand its exit status on."""
    again = f"make bitstream BOARD={board}" + (f" SCENE={scene}" if scene else "")
    try:
        chosen = _chosen(board, device, scene)
    except _ERRORS as error:
        _fail(error)
    path = synthesis.bitstream_path(chosen)
    if not (ROOT / path).is_file():
        _fail(BoardError(f"{path} is not there; run `{again}`"))
    newest = max(synthesis.board_sources(chosen), key=lambda of: (chosen.root / of).stat().st_mtime)
    if (chosen.root / newest).stat().st_mtime > (ROOT / path).stat().st_mtime:
        _fail(BoardError(f"{path} is older than {newest}; run `{again}`"))
    words = chosen.fpga.flash if flash else chosen.fpga.program
    command = [word.replace("{bitstream}", str(path)) for word in words]
    if shutil.which(command[0]) is None:
        _fail(ToolError(f"{command[0]} is not on PATH; install it, or run another programmer"))
    typer.echo(shlex.join(command))
    sys.exit(subprocess.run(command, cwd=ROOT, check=False).returncode)


@app.command()
def prog(board: BoardArgument, device: DeviceOption = None, scene: SceneOption = "") -> None:
    """Load a board's bitstream with the board's own programmer."""
    _programmer(board, device, flash=False, scene=scene)


@app.command()
def flash(board: BoardArgument, device: DeviceOption = None, scene: SceneOption = "") -> None:
    """Write a board's bitstream into its flash and read it back: what runs at every power-up."""
    _programmer(board, device, flash=True, scene=scene)


@app.command()
def simulate(board: BoardArgument, device: DeviceOption = None) -> None:
    """Run the netlist of a board's bitstream with a motor: a tap on its wall, and a hold."""
    from wavehaptics.cli.shared import metrics_table, shown_progress

    from wavetools.fpga import board_runs, board_simulation

    try:
        chosen = load_board(board, device or None)
        typer.echo(f"{board}: building the netlist of build/synth/{board}, a few minutes")
        built = board_simulation.build(chosen, Toolchain.of_environment())
        scenes = {"tap": board_runs.tap(chosen)}
        if chosen.scene.controller.anchored:
            scenes["hold"] = board_runs.hold(chosen)
        out = chosen.root / board_simulation.OUT / board
        out.mkdir(parents=True, exist_ok=True)
        for name, scene in scenes.items():
            with shown_progress(name) as progress:
                found = board_runs.run(built, scene, out, name, progress)
            shown = {key: found[key] for key in board_runs.SHOWN if key in found}
            typer.echo(f"{name}:\n{metrics_table(shown)}")
            typer.echo(str((out / f"{name}.png").relative_to(chosen.root)))
    except _ERRORS as error:
        _fail(error)


@app.command("resources")
def count_resources() -> None:
    """Count what each block and option costs, into build/synth/resources.json."""
    try:
        path = resources.measure(Toolchain.of_environment(), typer.echo)
    except _ERRORS as error:
        _fail(error)
    typer.echo(str(path))


@app.command("numbers")
def write_numbers() -> None:
    """Keep the numbers of the last whole runs, and write them into the pages."""
    try:
        for path in filler.keep():
            typer.echo(f"{path}: not of a whole run, its numbers are left out")
        written = filler.write()
        for path in written:
            typer.echo(f"{path}: numbers written")
        if not written:
            typer.echo("the pages have these numbers already")
    except _ERRORS as error:
        _fail(error)


if __name__ == "__main__":
    app()
