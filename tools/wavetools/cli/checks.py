# SPDX-License-Identifier: Apache-2.0
"""Commands that look for what is wrong: by soak, by planted faults."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from wavehaptics.cli.shared import CommandError, OutOption, WorkersOption, make_folder, shown_stages

if TYPE_CHECKING:
    from wavehaptics.studies.sweeps import Task

app = typer.Typer()


@app.command()
def soak(
    ticks: Annotated[
        float, typer.Option(metavar="N", min=1, help="How many ticks, or some more.")
    ] = 1e8,  # soak.WHOLE_TICKS, which would have to be imported
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="The first task's.")] = 0,
    workers: WorkersOption = None,
    out: OutOption = Path("build/soak"),
) -> None:
    """Run the core's RTL beside the integer model with everything switched at random.

    Words, energies and limits are watched in every tick. Some half an hour; an interrupted run goes
    on where it stopped when it is started again.
    """
    from wavetools.checks.soak import STORE, summary, tasks

    _sweep("soak", tasks(int(ticks), seed), STORE, workers, out, summary, "ticks")


def _sweep(
    name: str, tasks: Sequence[Task], store: Path, workers: int | None, out: Path,
    summary: Callable[[list[dict[str, Any]]], dict[str, Any]], unit: str,
) -> None:  # fmt: skip
    """Run a soak's tasks, write their summary, and end with 1 if something was wrong."""
    make_folder(out)

    from wavehaptics.runtime.files import write_json
    from wavehaptics.studies.sweeps import SweepError, sweep

    try:
        with shown_stages() as progress:
            results = sweep(
                tasks, store, workers=workers or os.cpu_count() or 1,
                progress=lambda done, total: progress(name, done / total),
            )  # fmt: skip
    except SweepError as error:
        raise CommandError(str(error)) from None
    found = summary(results)
    write_json(out / "summary.json", found)
    for line in found["wrong"]:
        print(f"wavetools: {name}: {line}", file=sys.stderr)
    print(f"{found[unit]:.3g} {unit}: {out / 'summary.json'}")
    if found["wrong"]:
        raise typer.Exit(1)


@app.command("soak-link")
def soak_link(
    count: Annotated[
        float, typer.Option("--bytes", metavar="N", min=0, help="How many bytes, or some more.")
    ] = 1e8,  # link_soak.WHOLE_BYTES, which would have to be imported
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="The first task's.")] = 0,
    workers: WorkersOption = None,
    out: OutOption = Path("build/soak-link"),
) -> None:
    """Send broken frames and noise to the link of the device's RTL, beside a model of its page.

    All that is written, answered and counted is watched. An interrupted run goes on where it
    stopped when it is started again.
    """
    from wavetools.checks.link_soak import STORE, summary, tasks

    _sweep("soak-link", tasks(int(count), seed), STORE, workers, out, summary, "bytes")


@app.command()
def mutate(
    block: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A block, with or without wh_; repeatable."),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Few blocks, few mutants.")] = False,
    jobs: Annotated[int, typer.Option(min=1, metavar="N", help="Blocks at a time.")] = 2,
) -> None:
    """Plant small faults into the RTL, one at a time, and see that the block's tests find them.

    An interrupted run goes on where it stopped. Ends with 1 if fewer than 95 % are found.
    """
    from wavetools.checks.mutation.run import mutate as run_mutants
    from wavetools.checks.mutation.table import MutationError

    try:
        with shown_stages() as progress:
            found, path = run_mutants(block or (), quick, jobs, progress)
    except MutationError as error:
        raise CommandError(str(error)) from None
    for mutant in found["survivors"]:
        print(f"survives: {mutant['block']} {mutant['number']}: {mutant['place']} {mutant['what']}")
    for reason in found["failed"].values():
        print(f"wavetools: mutate: {reason}", file=sys.stderr)
    print(
        f"{found['mutants']} mutants: {found['killed']} killed, {found['equivalent']} equivalent, "
        f"{found['survived']} survive ({100 * found['score']:.1f} % killed): {path}"
    )
    if not found["enough"]:
        raise typer.Exit(1)
