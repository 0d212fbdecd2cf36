# SPDX-License-Identifier: Apache-2.0
"""The command ``wavehaptics``.

What is wrong with the input is told in one line on stderr, ``wavehaptics: ...``, with exit status
2; an interrupted run ends with 130. What takes seconds to import is imported only once the scene is
known to be right.
"""

from __future__ import annotations

import difflib
import io
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from wavehaptics.scene import SceneError, find_scene, load_scene, shipped_scenes

CONTROLLERS = {
    "analog": "the paper's circuit in continuous time: the reference",
    "golden": "the wave core as integers in Python, bit for bit the RTL",
    "core": "the wave core's RTL, numbers in and numbers out, averaged drive",
    "pins": "the whole RTL at its pins: ADC bits, encoder edges, gate signals",
    "encoder": "the usual way beside it: sampled encoder, virtual spring, current amplifier",
}
"""Controllers that a scene can run on, and what each is."""

DEFAULT_CONTROLLER = "golden"

RUNS_DIR = Path("build/runs")
"""Where results go without ``--out``, below the current directory."""

METRIC_UNITS = {
    "duration_s": "s",
    "wall_clock_s": "s",
    "k_l": "N·m/rad",
    "stiffness": "N·m/rad",
    "stiffness_predicted": "N·m/rad",
    "stiffness_zero_rad": "rad",
    "contact_edge_rad": "rad",
    "tip_stiffness": "N/m",
    "peak_torque": "N·m",
    "peak_current_a": "A",
    "current_ripple_a": "A",
    "free_space_torque_rms": "N·m",
    "energy_out_max_j": "J",
    "hold_offset_rad": "rad",
    "hold_ripple_rms": "N·m",
}
"""Units of the metrics that have one."""

USAGE_STATUS = 2
INTERRUPTED_STATUS = 130

# Base of all errors in the use of the command; typer gives it no public name.
_UsageError: Any = typer.BadParameter.__base__


class CommandError(ValueError):
    """An option that is refused. The message is one line."""


app = typer.Typer(
    help="Run wave haptics scenes: a motor, a hand, a wall and a controller of your choice.",
    add_completion=False,
    pretty_exceptions_enable=False,
)

SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="Path of a scene, or the name of a shipped one.")
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="TABLE.KEY=VALUE", help="Replace or add a key; repeatable."),
]


@app.command()
def run(
    scene: SceneArgument,
    controller: Annotated[
        str, typer.Option(metavar="NAME", help=f"One of {', '.join(CONTROLLERS)}.")
    ] = DEFAULT_CONTROLLER,
    overrides: SetOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help=f"Folder for the results; {RUNS_DIR}/<scene name>-<controller> by default.",
        ),
    ] = None,
) -> None:
    """Simulate SCENE and write trace.npz, metrics.json and pictures."""
    if controller not in CONTROLLERS:
        near = difflib.get_close_matches(controller, CONTROLLERS, n=1)
        meant = f"did you mean {near[0]}? " if near else ""
        known = ", ".join(CONTROLLERS)
        raise CommandError(
            f"--controller {controller}: unknown; {meant}the controllers are {known}"
        )
    loaded = load_scene(find_scene(scene), overrides or ())
    folder = RUNS_DIR / f"{loaded.scene.name}-{controller}" if out is None else out
    _make_folder(folder)

    from wavehaptics.ladder.run import run_scene

    with _progress(f"{loaded.scene.name} on {controller}") as progress:
        metrics = run_scene(loaded, controller, folder, progress)
    print(_table(metrics))
    print(f"results in {folder}")


@app.command()
def demo(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")] = Path(
        "build/demo"
    ),
) -> None:
    """Run the paper's experiment with the whole RTL, and draw its figures."""
    _make_folder(out)

    from rich.console import Console

    from wavehaptics.studies.demo import demo_table, run_demo

    with _stages() as progress:
        results = run_demo(out, progress)
    Console().print(demo_table(results))
    print(f"pictures: {out / 'fig10.png'} and {out / 'fig11.png'}")
    print(f"metrics:  {out / 'metrics.json'}")


@app.command()
def speed(scene: SceneArgument = "paper_taps", overrides: SetOption = None) -> None:
    """Run SCENE on every controller, and tell how fast and how exact each is."""
    loaded = load_scene(find_scene(scene), overrides or ())

    from rich.console import Console

    from wavehaptics.studies.speed import measure_speed, speed_table

    with _stages() as progress:
        results = measure_speed(loaded, progress)
    Console().print(speed_table(results))


@app.command()
def impedance(
    scene: SceneArgument,
    controller: Annotated[str, typer.Option(metavar="NAME", help="golden or core.")] = "golden",
    overrides: SetOption = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help=f"Folder; {RUNS_DIR}/<scene name>-impedance by default."),
    ] = None,
) -> None:
    """Sweep a hand over contact in SCENE: what it feels like against what was designed."""
    if controller not in ("golden", "core"):
        raise CommandError(f"--controller {controller}: has no sweep; take golden or core")
    loaded = load_scene(find_scene(scene), overrides or ())
    folder = RUNS_DIR / f"{loaded.scene.name}-impedance" if out is None else out
    _make_folder(folder)

    from wavehaptics.studies.impedance import measure
    from wavehaptics.studies.impedance_picture import write

    with _progress(f"{loaded.scene.name}, impedance on {controller}") as progress:
        found = write(loaded, measure(loaded, rtl=controller == "core", progress=progress), folder)
    print(_table({key: found[key] for key in ("scene", "error_max", "energy_out_max_j")}))
    print(f"results in {folder}")


@app.command()
def shaper(scene: SceneArgument, overrides: SetOption = None) -> None:
    """Design W for what SCENE's \\[shaper] wishes, prove it passive and say what will be felt."""
    loaded = load_scene(find_scene(scene), overrides or ())
    if loaded.shaper is None:
        raise CommandError(
            f"{loaded.scene.name}: the scene wishes for nothing; give it a [shaper], or "
            "--set shaper.feel=spring --set shaper.stiffness=0.5"
        )

    from wavehaptics.controller.rendered import fragment
    from wavehaptics.controller.settings import settings

    print(fragment(loaded, settings(loaded)), end="")


@app.command()
def report(
    quick: Annotated[bool, typer.Option("--quick", help="Coarser grids: 3 minutes.")] = False,
    cluster: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="A dask scheduler; local processes without one."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Local processes; one a core by default.")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")] = Path(
        "build/report"
    ),
) -> None:
    """Measure speed against error, hard cases and the usual way, and write a page about it.

    An interrupted report goes on where it stopped when it is started again.
    """
    if cluster is not None and workers is not None:
        raise CommandError(f"--workers {workers}: a cluster has its own; leave one of the two out")
    _make_folder(out)

    from wavehaptics.studies.report.build import make_report
    from wavehaptics.studies.sweeps import SweepError

    try:
        with _stages() as progress:
            page = make_report(out, quick, cluster=cluster, workers=workers, progress=progress)
    except SweepError as error:
        raise CommandError(str(error)) from None
    print(f"report: {page}")


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
    _make_folder(out)

    from rich.console import Console

    from wavehaptics.studies.adcs import adc_table, compare

    with _stages() as progress:
        found = compare(path, settings, out / "adcs.json", progress)
    Console().print(adc_table(found))
    print(f"numbers: {out / 'adcs.json'}")


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
    _make_folder(out)

    from wavehaptics.studies.anchored import collect
    from wavehaptics.studies.sweeps import SweepError

    try:
        with _stages() as progress:
            collect(out, workers, progress, quick)
    except SweepError as error:
        raise CommandError(str(error)) from None
    print(f"numbers: {out / 'holding.json'}")


@app.command()
def soak(
    ticks: Annotated[
        float, typer.Option(metavar="N", min=1, help="How many ticks, or some more.")
    ] = 1e8,  # soak.WHOLE_TICKS, which would have to be imported
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="The first task's.")] = 0,
    workers: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Processes; one a core by default.")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")] = Path(
        "build/soak"
    ),
) -> None:
    """Run the core's RTL beside the integer model with everything switched at random.

    Words, energies and limits are watched in every tick. Some half an hour; an interrupted run goes
    on where it stopped when it is started again.
    """
    _make_folder(out)

    from wavehaptics.checks.soak import STORE, summary, tasks
    from wavehaptics.runtime.files import write_json
    from wavehaptics.studies.sweeps import SweepError, sweep

    try:
        with _stages() as progress:
            results = sweep(
                tasks(int(ticks), seed), STORE, workers=workers or os.cpu_count() or 1,
                progress=lambda done, total: progress("soak", done / total),
            )  # fmt: skip
    except SweepError as error:
        raise CommandError(str(error)) from None
    found = summary(results)
    write_json(out / "summary.json", found)
    for line in found["wrong"]:
        print(f"wavehaptics: soak: {line}", file=sys.stderr)
    print(f"{found['ticks']:.3g} ticks: {out / 'summary.json'}")
    if found["wrong"]:
        raise typer.Exit(1)


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
    from wavehaptics.checks.mutation.run import mutate as run_mutants
    from wavehaptics.checks.mutation.table import MutationError

    try:
        with _stages() as progress:
            found, path = run_mutants(block or (), quick, jobs, progress)
    except MutationError as error:
        raise CommandError(str(error)) from None
    for mutant in found["survivors"]:
        print(f"survives: {mutant['block']} {mutant['number']}: {mutant['place']} {mutant['what']}")
    for reason in found["failed"].values():
        print(f"wavehaptics: mutate: {reason}", file=sys.stderr)
    print(
        f"{found['mutants']} mutants: {found['killed']} killed, {found['equivalent']} equivalent, "
        f"{found['survived']} survive ({100 * found['score']:.1f} % killed): {path}"
    )
    if not found["enough"]:
        raise typer.Exit(1)


@app.command()
def bench(
    quick: Annotated[bool, typer.Option("--quick", help="Only what is shipped.")] = False,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")] = Path(
        "build/bench"
    ),
) -> None:
    """Measure how fast the simulation is, what was tried to speed it up, and others beside it."""
    _make_folder(out)

    from rich.console import Console

    from wavehaptics.studies.bench.measure import bench as measure_all
    from wavehaptics.studies.bench.measure import tables

    with _stages() as progress:
        summary = measure_all(out, quick, progress)
    for table in tables(summary):
        Console().print(table)
    print(f"summary: {out / 'summary.json'}")


@app.command()
def check(scene: SceneArgument, overrides: SetOption = None) -> None:
    """Check SCENE without running it."""
    path = find_scene(scene)
    load_scene(path, overrides or ())
    print(f"{path}: ok")


@app.command()
def scenes() -> None:
    """List the shipped scenes."""
    shipped = shipped_scenes()
    width = max(map(len, shipped), default=0)
    for name, path in shipped.items():
        print(f"{name:<{width}}  {_first_comment(path)}")


def _first_comment(path: Path) -> str:
    """What a scene says of itself: its first line of comment below the license."""
    comments = (line for line in path.read_text(encoding="utf-8").splitlines() if line[:1] == "#")
    return next((line.lstrip("# ") for line in comments if "SPDX" not in line), "")


def _make_folder(folder: Path) -> None:
    """Make ``folder`` and try to write there, so that no long run ends in a refusal."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        if isinstance(error, FileExistsError):
            reason = "is a file"
        raise CommandError(
            f"--out {folder}: can't be written: {reason}; name a folder that can"
        ) from None


@contextmanager
def _progress(title: str) -> Iterator[Callable[[float], None]]:
    """A function that takes the part done, 0 to 1, and shows it if stderr is a terminal."""
    with _stages() as show:
        yield lambda part: show(title, part)


@contextmanager
def _stages() -> Iterator[Callable[[str, float], None]]:
    """A function that takes what is being done and its part done, 0 to 1, and shows them.

    Bars on stderr if that is a terminal, else nothing.
    """
    if not sys.stderr.isatty():
        yield lambda stage, part: None
        return
    from rich.console import Console
    from rich.progress import Progress

    tasks = {}
    with Progress(console=Console(stderr=True), transient=True) as bars:

        def show(stage: str, part: float) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=1.0)
            bars.update(tasks[stage], completed=part)

        yield show


def _table(metrics: Mapping[str, Any]) -> str:
    """Metrics that the scene defines, a line each: name, value, unit."""
    rows = [(name, _value(value)) for name, value in metrics.items() if value is not None]
    names = max((len(name) for name, _ in rows), default=0)
    values = max((len(value) for _, value in rows), default=0)
    lines = (f"{n:<{names}}  {v:>{values}}  {METRIC_UNITS.get(n, '')}".rstrip() for n, v in rows)
    return "\n".join(lines)


def _value(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def main() -> None:
    """Run the command line and exit with its status."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        status = app(prog_name="wavehaptics", standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED_STATUS
    except BrokenPipeError:  # the reader of our output has left
        sys.stdout = None
        status = 1
    except (SceneError, CommandError) as error:
        status = _refuse(str(error))
    except _UsageError as error:
        problem = " ".join(error.format_message().split()).rstrip(".")
        status = _refuse(f"{problem}; wavehaptics --help shows the use")
    except (OSError, MemoryError) as error:
        status = _refuse(str(error) or "out of memory")
    if status == INTERRUPTED_STATUS:
        print("wavehaptics: interrupted", file=sys.stderr)
    sys.exit(status or 0)


def _refuse(problem: str) -> int:
    print(f"wavehaptics: {problem}", file=sys.stderr)
    return USAGE_STATUS
