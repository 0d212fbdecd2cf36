# SPDX-License-Identifier: Apache-2.0
"""A scene at every point of a grid of its keys: a row of metrics for each point."""

from __future__ import annotations

import csv
import io
import itertools
import multiprocessing
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from wavehaptics.runtime.files import digest_of, write_text
from wavehaptics.scene import SceneError, device_of
from wavehaptics.studies.sweeps import SweepError, Task, finished, sources_digest

DIGEST, ERROR = "sweep", "error"
"""Columns of a row besides keys and metrics: of what sweep it is, and why the point is refused."""

Row = dict[str, Any]
Value = int | float | bool | str
Point = tuple[Value, ...]


@dataclass(frozen=True)
class Grid:
    """A scene's text, its overrides and a controller, and the values of each key that is varied."""

    path: Path
    content: bytes
    overrides: tuple[str, ...]
    controller: str
    axes: Mapping[str, Sequence[Value]]
    """Values by ``table.key``; a string may be any TOML."""

    def points(self) -> list[Point]:
        """Values of the keys at each point; the last key changes fastest."""
        return list(itertools.product(*self.axes.values()))

    def digest(self) -> str:
        """Digest, 16 digits, of all that a row may depend on besides its point."""
        told = (self.content, self.overrides, self.controller, list(self.axes), sources_digest())
        return digest_of(told)[:16]

    def task(self, point: Point) -> Task:
        """The run at a point, as a process or a cluster does it."""
        varied = [f"{key}={_text(value)}" for key, value in zip(self.axes, point, strict=True)]
        arguments = {
            "path": str(self.path), "text": self.content.decode("utf-8"),
            "overrides": [*self.overrides, *varied], "controller": self.controller,
        }  # fmt: skip
        return Task(run_point, arguments)


def run_point(path: str, text: str, overrides: list[str], controller: str) -> Row:
    """The scalar metrics of a scene's run; ``error`` alone where the scene is refused."""
    from wavehaptics.ladder.joint_run import measure_device
    from wavehaptics.ladder.refusals import check_device
    from wavehaptics.ladder.run import measure

    try:
        device = device_of(text.encode("utf-8"), Path(path), overrides, said="")
        check_device(device, controller)
        if device.space is not None:
            found = measure_device(device, controller)
        else:
            found = measure(device.one("sweep a scene of one motor"), controller)
    except SceneError as error:
        return {ERROR: str(error)}
    return {
        name: value for name, value in found.items()
        if name not in ("scene", "controller") and isinstance(value, int | float | str | None)
    }  # fmt: skip


def ran(
    grid: Grid, points: Sequence[Point], *, workers: int, cluster: str | None = None
) -> Iterator[tuple[Point, Row]]:
    """Each point with its metrics, as soon as it is finished.

    On this process where ``workers`` is 1, on so many processes, or on a dask ``cluster``.
    :class:`SweepError` where a process or the cluster has gone.
    """
    tasks = {point: grid.task(point) for point in points}
    if cluster is not None and tasks:
        yield from finished(tasks, cluster)
    elif workers == 1 or len(tasks) <= 1:
        for point, task in tasks.items():
            yield point, task.function(**task.arguments)
    else:
        # New processes, as a forked one would have the threads of numerical libraries half.
        spawned = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(
            min(workers, len(tasks)), spawned, signal.signal, (signal.SIGINT, signal.SIG_IGN)
        )
        try:
            running = {
                pool.submit(partial(task.function, **task.arguments)): point
                for point, task in tasks.items()
            }
            for done in as_completed(running):
                yield running[done], done.result()
        except BrokenProcessPool:
            raise SweepError(
                "a worker has ended; start the sweep again, with fewer --workers"
            ) from None
        finally:
            pool.shutdown(cancel_futures=True)


def sweep(
    grid: Grid, out: Path | None, *, workers: int, cluster: str | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Row]:  # fmt: skip
    """Rows of all the grid's points in their order: keys, metrics, and why a point is refused.

    Points that the CSV file ``out`` has aren't run, and it is written whole after each other one.
    :class:`SweepError` where it is of another sweep, :class:`SceneError` where the scene is valid
    at no point. ``progress`` takes the points done and all.
    """
    points, digest = grid.points(), grid.digest()
    _check(grid, points)
    found = {} if out is None else _read(grid, out, digest)
    if strange := [point for point in found if point not in points]:
        shown = " ".join(
            f"{key}={_text(value)}" for key, value in zip(grid.axes, strange[0], strict=True)
        )
        raise SweepError(f"{out}: has {shown}, which isn't asked for; name another --out")
    missing = [point for point in points if point not in found]
    progress(len(found), len(points))
    for point, metrics in ran(grid, missing, workers=workers, cluster=cluster):
        row = dict(zip(grid.axes, point, strict=True))
        found[point] = {**row, ERROR: None, **metrics, DIGEST: digest}
        if out is not None:
            write_text(out, to_csv([found[point] for point in points if point in found]))
        progress(len(found), len(points))
    names = [name for name in columns(list(found.values())) if name != DIGEST]
    return [{name: found[point].get(name) for name in names} for point in points]


def _check(grid: Grid, points: Sequence[Point]) -> None:
    """:class:`SceneError` of the first point where the scene is valid at none."""
    first: SceneError | None = None
    for point in points:
        arguments = grid.task(point).arguments
        try:
            device_of(grid.content, grid.path, arguments["overrides"], said="")
            return
        except SceneError as error:
            first = first or error
    if first is not None:
        raise first


def _read(grid: Grid, out: Path, digest: str) -> dict[Point, Row]:
    """Rows of an earlier start of the same sweep, by their points."""
    if not out.exists():
        return {}
    with out.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if any(row.get(DIGEST) != digest for row in rows):
        raise SweepError(
            f"{out}: is of another scene, controller, set of keys or version; remove it, or name "
            "another --out"
        )
    cells = [{name: value_of(text) for name, text in row.items()} for row in rows]
    return {tuple(row[key] for key in grid.axes): row for row in cells}


def value_of(text: str) -> Any:
    """A number, a bool, a string, or None for an empty one."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return {"true": True, "false": False, "": None}.get(text, text)


def _text(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def columns(rows: Sequence[Row]) -> list[str]:
    """Names of all columns, with those of the sweep itself last."""
    names = dict.fromkeys(name for row in rows for name in row)
    return [*(name for name in names if name not in (ERROR, DIGEST)), ERROR, DIGEST]


def to_csv(rows: Sequence[Row]) -> str:
    """Rows with a head, a line each; what a row hasn't is empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns(rows), lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({k: _text(v) if isinstance(v, bool) else v for k, v in row.items()})
    return text.getvalue()
