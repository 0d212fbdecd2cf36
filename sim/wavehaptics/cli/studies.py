# SPDX-License-Identifier: Apache-2.0
"""Commands for many runs: the demonstration and the report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wavehaptics.cli.shared import CommandError, OutOption, WorkersOption, make_folder, shown_stages

app = typer.Typer()


@app.command()
def demo(
    out: OutOption = Path("build/demo"),
) -> None:
    """Run the paper's experiment with the whole RTL, and draw its figures."""
    make_folder(out)

    from rich.console import Console

    from wavehaptics.studies.demo import demo_table, run_demo

    with shown_stages() as progress:
        results = run_demo(out, progress)
    Console().print(demo_table(results))
    print(f"pictures: {out / 'fig10.png'} and {out / 'fig11.png'}")
    print(f"metrics:  {out / 'metrics.json'}")


@app.command()
def report(
    quick: Annotated[bool, typer.Option("--quick", help="Coarser grids: 3 minutes.")] = False,
    cluster: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="A dask scheduler; local processes without one."),
    ] = None,
    workers: WorkersOption = None,
    out: OutOption = Path("build/report"),
) -> None:
    """Measure speed against error, hard cases and the usual way, and write a page about it.

    An interrupted report goes on where it stopped when it is started again.
    """
    if cluster is not None and workers is not None:
        raise CommandError(f"--workers {workers}: a cluster has its own; leave one of the two out")
    make_folder(out)

    from wavehaptics.studies.report.build import make_report
    from wavehaptics.studies.sweeps import SweepError

    try:
        with shown_stages() as progress:
            page = make_report(out, quick, cluster=cluster, workers=workers, progress=progress)
    except SweepError as error:
        raise CommandError(str(error)) from None
    print(f"report: {page}")
