# SPDX-License-Identifier: Apache-2.0
"""What the commands share: arguments, refusals, folders, and how progress and metrics are shown."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from wavehaptics.runtime.files import try_file
from wavehaptics.scene import Scene, find_scene, load_scene

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
    name: unit
    for unit, names in {
        "s": "duration_s wall_clock_s",
        "Hz": "tick_hz swing_hz",
        "N·m/rad": "k_l stiffness stiffness_predicted shaft_stiffness shaft_stiffness_predicted",
        "rad": "stiffness_zero_rad contact_edge_rad shaft_twist_rad hold_offset_rad swing_rad",
        "N/m": "tip_stiffness tip_stiffness_predicted",
        "m": "tip_offset_m surface_error_mean_m surface_error_max_m",
        "N·m": (
            "shaft_torque shaft_ripple peak_torque free_space_torque_rms hold_torque "
            "hold_ripple_rms"
        ),
        "J": "shaft_energy_out_j energy_out_max_j contact_energy_j",
        "N": "tip_force_n tip_ripple_n peak_force_n tangential_force",
        "A": "peak_current_a current_ripple_a",
        "V": "bus_highest_v",
    }.items()
    for name in names.split()
}
"""Units of the metrics that have one."""


class CommandError(ValueError):
    """An option that is refused. The message is one line."""


SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="Path of a scene, or the name of a shipped one.")
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="TABLE.KEY=VALUE", help="Replace or add a key; repeatable."),
]
OutOption = Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results.")]
WorkersOption = Annotated[
    int | None, typer.Option(metavar="N", min=1, help="Local processes; one a core by default.")
]
SceneMotorOption = Annotated[
    str | None,
    typer.Option(
        "--motor", metavar="NAME", help="One motor of SCENE's \\[\\[motors]], by name or number."
    ),
]


def scene_of_one(scene: str, overrides: Sequence[str] | None, motor: str | None) -> Scene:
    """The scene of its only motor, or of ``motor``, for a command that has SceneMotorOption."""
    cure = "one is taken here; choose it with --motor NAME"
    return load_scene(find_scene(scene), overrides or (), motor, cure)


def make_folder(folder: Path) -> None:
    """Make ``folder`` and try to write there, so that no long run ends in a refusal."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        try_file(folder / "metrics.json")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        if isinstance(error, FileExistsError):
            reason = "is a file"
        raise CommandError(
            f"--out {folder}: can't be written: {reason}; name a folder that can"
        ) from None


FIRST_TOLD_S, TOLD_S = 2.0, 10.0
"""Time until the first line of :func:`told_waiting`, and from one to the next."""


@contextmanager
def told_waiting(what: str) -> Iterator[None]:
    """While the block lasts: lines on stderr of ``what`` it does, and for how long."""
    over, start = threading.Event(), time.monotonic()

    def tell() -> None:
        wait_s = FIRST_TOLD_S
        while not over.wait(wait_s):
            wait_s = TOLD_S
            print(f"{what}: {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield
    finally:
        over.set()
        teller.join()


@contextmanager
def shown_progress(title: str) -> Iterator[Callable[[float], None]]:
    """A function that takes the part done, 0 to 1, and shows it if stderr is a terminal."""
    with shown_stages() as show:
        show(title, 0.0)  # before the first part is done, what is simulated may have to be built
        yield lambda part: show(title, part)


@contextmanager
def shown_stages() -> Iterator[Callable[[str, float], None]]:
    """A function that takes what is being done and its part done, 0 to 1, and shows them.

    Bars on stderr if that is a terminal, else nothing.
    """
    if not sys.stderr.isatty():
        yield lambda stage, part: None
        return
    from rich.console import Console
    from rich.progress import Progress

    tasks = {}
    # What is printed meanwhile stands above the bars; a pipe gets it all the same.
    above = sys.stdout.isatty()
    with Progress(console=Console(stderr=True), transient=True, redirect_stdout=above) as bars:

        def show(stage: str, part: float) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=1.0)
            bars.update(tasks[stage], completed=part)

        yield show


def warn(problem: str) -> None:
    """One line on stderr for what doesn't end the command."""
    print(f"wavehaptics: warning: {problem}", file=sys.stderr)


def metrics_table(metrics: Mapping[str, Any]) -> str:
    """Metrics that the scene defines, a line each: name, value, unit, and what there is to say.

    A metric that is None for a reason is a line as well.
    """
    reasons = metrics.get("reasons", {})
    rows = [
        (name, "null" if value is None else _value(value), METRIC_UNITS.get(name, ""))
        for name, value in metrics.items()
        if name != "reasons" and (value is not None or name in reasons)
    ]
    names = max((len(name) for name, _, _ in rows), default=0)
    values = max((len(value) for _, value, _ in rows), default=0)
    lines = (
        f"{name:<{names}}  {value:>{values}}  {_with_reason(unit, reasons.get(name))}".rstrip()
        for name, value, unit in rows
    )
    return "\n".join(lines)


def _with_reason(unit: str, reason: str | None) -> str:
    if reason is None:
        return unit
    return f"{unit}  ({reason})" if unit else f"({reason})"


def _value(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
