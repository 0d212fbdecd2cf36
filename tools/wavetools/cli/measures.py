# SPDX-License-Identifier: Apache-2.0
"""Commands that measure what the pages show: converters, sensors, holding, speed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from wavehaptics.cli.shared import (
    CommandError,
    OutOption,
    SetOption,
    WorkersOption,
    make_folder,
    shown_stages,
)
from wavehaptics.scene import find_scene, load_scene

if TYPE_CHECKING:
    from rich.table import Table

Progress = Callable[[str, float], None]

app = typer.Typer()


def _study(
    out: Path, file: str, compare: Callable[[Path, Progress], dict[str, Any]],
    table: Callable[[dict[str, Any]], Table],
) -> None:  # fmt: skip
    """Run a study into ``file`` of the folder ``out``, and show what it found."""
    from rich.console import Console

    make_folder(out)
    with shown_stages() as progress:
        found = compare(out / file, progress)
    Console().print(table(found))
    print(f"numbers: {out / file}")


@app.command()
def adcs(
    out: OutOption = Path("build/adcs"),
    scene: Annotated[
        str, typer.Option(metavar="SCENE", help="What runs with each.")
    ] = "paper_taps",
    overrides: SetOption = None,
) -> None:
    """Run SCENE on pins with every ADC: times, stiffness and torque error; some ten minutes."""
    settings = tuple(overrides or ())
    path = find_scene(scene)
    load_scene(path, settings)

    from wavetools.studies.adcs import adc_table, compare

    _study(out, "adcs.json", lambda *to: compare(path, settings, *to), adc_table)


@app.command()
def sensing(out: OutOption = Path("build/sensing"), overrides: SetOption = None) -> None:
    """Press a wall on pins with every part that senses the current, at every carrier; 2 minutes."""
    from wavetools.studies.sensing import compare, sensing_table

    settings = tuple(overrides or ())
    _study(out, "sensing.json", lambda to, show: compare(to, settings, show), sensing_table)


@app.command()
def encoders(out: OutOption = Path("build/encoders"), overrides: SetOption = None) -> None:
    """Hold and hit walls with absolute encoders, with all errors; 3 minutes."""
    from wavetools.studies.encoders import compare, encoder_table

    settings = tuple(overrides or ())
    _study(out, "encoders.json", lambda to, show: compare(to, settings, show), encoder_table)


@app.command()
def holding(
    quick: Annotated[
        bool, typer.Option("--quick", help="Holds of seconds, few random motors: 5 minutes.")
    ] = False,
    workers: WorkersOption = None,
    out: OutOption = Path("build/holding"),
) -> None:
    """Hold, tap, bounce and overload walls with everything wrong that a real motor has.

    Some twenty minutes; an interrupted run goes on where it stopped when it is started again.
    """
    make_folder(out)

    from wavehaptics.studies.sweeps import SweepError

    from wavetools.studies.anchored import collect

    try:
        with shown_stages() as progress:
            collect(out, workers, progress, quick)
    except SweepError as error:
        raise CommandError(str(error)) from None
    print(f"numbers: {out / 'holding.json'}")


@app.command()
def bench(
    quick: Annotated[bool, typer.Option("--quick", help="In fewer rounds.")] = False,
    out: OutOption = Path("build/bench"),
) -> None:
    """Measure how fast the simulation is, the controllers by turns."""
    make_folder(out)

    from rich.console import Console

    from wavetools.studies.bench.measure import bench as measure_all
    from wavetools.studies.bench.measure import table

    with shown_stages() as progress:
        summary = measure_all(out, quick, progress)
    Console().print(table(summary))
    print(f"summary: {out / 'summary.json'}")


@app.command()
def tables(
    out: OutOption = Path("build/tables"),
) -> None:
    """Run what the pages show of drive and environments in tables; some ten minutes."""
    make_folder(out)

    from wavetools.studies.tabled_runs import collect

    with shown_stages() as progress:
        print(f"numbers: {collect(out, progress)}")
