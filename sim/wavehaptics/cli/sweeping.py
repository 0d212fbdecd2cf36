# SPDX-License-Identifier: Apache-2.0
"""``sweep``: a scene at every point of a grid of its keys."""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from wavehaptics.cli.scenes import ControllerOption, checked_controller
from wavehaptics.cli.shared import (
    DEFAULT_CONTROLLER,
    CommandError,
    SceneArgument,
    SetOption,
    WorkersOption,
    make_folder,
    shown_stages,
)
from wavehaptics.scene import find_scene, read_scene

app = typer.Typer()

SWEEPS_DIR = Path("build/sweeps")
"""Where sweeps go without ``--out``, below the current directory."""

MOST_POINTS = 100_000

FORMS = "write table.key=low:high:count, low:high:count:log or a,b,c"


def axis(text: str) -> tuple[str, list[int | float | bool | str]]:
    """Key and values of ``key=low:high:count``, ``key=low:high:count:log`` or ``key=a,b,c``.

    :class:`CommandError` where it has another form.
    """
    from wavehaptics.studies.grid import value_of

    key, equals, given = text.partition("=")
    if not equals or not key or not given:
        raise CommandError(f"{text}: {FORMS}")
    if ":" not in given:
        values = [value_of(each) for each in given.split(",")]
        if None in values or len(set(values)) < len(values):
            raise CommandError(f"{text}: a value is empty or there twice; {FORMS}")
        return key, values
    bounds = given.split(":")
    scale = bounds[3:] or ["linear"]
    if len(bounds) not in (3, 4) or scale not in (["linear"], ["log"]):
        raise CommandError(f"{text}: {FORMS}")
    try:
        low, high, count = float(bounds[0]), float(bounds[1]), int(bounds[2])
    except ValueError:
        raise CommandError(f"{text}: low and high are numbers, count is a whole one") from None
    if not (math.isfinite(low) and math.isfinite(high)) or not 2 <= count <= MOST_POINTS:
        raise CommandError(f"{text}: low and high must be finite, count 2 to {MOST_POINTS}")
    if scale == ["log"] and not min(low, high) > 0.0:
        raise CommandError(f"{text}: low and high must be above 0 on a logarithmic scale")
    if low == high:
        raise CommandError(f"{text}: low and high are the same; write {key}={bounds[0]}")
    return key, [_point(low, high, n / (count - 1), scale == ["log"]) for n in range(count)]


def _point(low: float, high: float, part: float, logarithmic: bool) -> int | float:
    """A value between, to 12 digits; a whole one is an integer, which a key of counts takes."""
    value = low * (high / low) ** part if logarithmic else low + (high - low) * part
    value = float(f"{value:.12g}")
    return int(value) if value.is_integer() and abs(value) < 2**53 else value


@app.command()
def sweep(
    scene: SceneArgument,
    axes: Annotated[
        list[str],
        typer.Argument(metavar="KEY=...", help="low:high:count, low:high:count:log, or a,b,c."),
    ],
    controller: ControllerOption = DEFAULT_CONTROLLER,
    overrides: SetOption = None,
    plot: Annotated[
        list[str] | None,
        typer.Option(metavar="METRIC", help="Draw this one; repeatable. By default a few."),
    ] = None,
    workers: WorkersOption = None,
    cluster: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="A dask scheduler; local processes without one."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help=f"Folder; {SWEEPS_DIR}/<scene name>-<controller> by default."
        ),
    ] = None,
) -> None:
    """Run SCENE at every combination of values: sweep.csv, a row for each, and sweep.png.

    An interrupted sweep goes on where it stopped when it is started again.
    """
    if cluster is not None and workers is not None:
        raise CommandError(f"--workers {workers}: a cluster has its own; leave one of the two out")
    values = dict(axis(text) for text in axes)
    if len(values) < len(axes):
        raise CommandError("a key is there twice; give each key once")
    count = math.prod(len(each) for each in values.values())
    if count > MOST_POINTS:
        raise CommandError(f"the sweep has {count} points, more than {MOST_POINTS}; take fewer")
    checked_controller(controller)
    path = find_scene(scene)
    content = read_scene(path)

    from wavehaptics.studies import grid, grid_picture
    from wavehaptics.studies.sweeps import SweepError

    swept = grid.Grid(path, content, tuple(overrides or ()), controller, values)
    folder = SWEEPS_DIR / f"{path.stem}-{controller}" if out is None else out
    make_folder(folder)
    with shown_stages() as stages:

        def show(done: int, total: int) -> None:
            stages(f"{path.stem} on {controller}", done / total)
            if not sys.stderr.isatty():
                print(f"{done} of {total} points", file=sys.stderr, flush=True)

        try:
            rows = grid.sweep(
                swept, folder / "sweep.csv", workers=workers or os.cpu_count() or 1,
                cluster=cluster, progress=show,
            )  # fmt: skip
            drawn = grid_picture.draw(rows, list(values), plot or (), folder / "sweep.png")
        except SweepError as error:
            raise CommandError(str(error)) from None
    refused = [row for row in rows if row[grid.ERROR]]
    print(f"{len(rows)} points, {len(refused)} refused; drawn: {', '.join(drawn) or 'nothing'}")
    if refused:
        print(f"first refusal: {refused[0][grid.ERROR]}")
    print(f"results in {folder}")
