# SPDX-License-Identifier: Apache-2.0
"""Commands that measure what the pages show: converters, sensors, holding, speed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from wavehaptics.cli.shared import CommandError, SetOption, make_folder, shown_stages
from wavehaptics.scene import find_scene, load_scene

app = typer.Typer()


@app.command()
def adcs(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for adcs.json.")] = Path(
        "build/adcs"
    ),
    scene: Annotated[
        str, typer.Option(metavar="SCENE", help="What runs with each.")
    ] = "paper_taps",
    overrides: SetOption = None,
) -> None:
    """Run SCENE on pins with every ADC: times, stiffness and torque error; some ten minutes."""
    settings = tuple(overrides or ())
    path = find_scene(scene)
    load_scene(path, settings)
    make_folder(out)

    from rich.console import Console

    from wavetools.studies.adcs import adc_table, compare

    with shown_stages() as progress:
        found = compare(path, settings, out / "adcs.json", progress)
    Console().print(adc_table(found))
    print(f"numbers: {out / 'adcs.json'}")


@app.command()
def sensing(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for sensing.json.")] = Path(
        "build/sensing"
    ),
    overrides: SetOption = None,
) -> None:
    """Press a wall on pins with every part that senses the current, at every carrier; 2 minutes."""
    make_folder(out)

    from rich.console import Console

    from wavetools.studies.sensing import compare, sensing_table

    with shown_stages() as progress:
        found = compare(out / "sensing.json", tuple(overrides or ()), progress)
    Console().print(sensing_table(found))
    print(f"numbers: {out / 'sensing.json'}")


@app.command()
def holding(
    quick: Annotated[
        bool, typer.Option("--quick", help="Holds of seconds, few random motors: 5 minutes.")
    ] = False,
    workers: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Processes; one a core by default.")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")] = Path(
        "build/holding"
    ),
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
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")] = Path(
        "build/bench"
    ),
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
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for tables.json.")] = Path(
        "build/tables"
    ),
) -> None:
    """Run what the pages show of drive and environments in tables; some ten minutes."""
    make_folder(out)

    from wavetools.studies.tabled_runs import collect

    with shown_stages() as progress:
        print(f"numbers: {collect(out, progress)}")
