# SPDX-License-Identifier: Apache-2.0
"""``board capture``: live words at the tick's rate around a trigger."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.board import common
from wavehaptics.cli.board.rows import (
    CountsOption,
    PresetOption,
    TorqueOption,
    channel_lines,
    keep,
    torque_constant,
)
from wavehaptics.cli.shared import RUNS_DIR, CommandError, make_folder, shown_stages
from wavehaptics.runtime.ends import ending

if TYPE_CHECKING:
    from wavehaptics.host.capture import Captured, Plan, Progress


@common.board.command()
def capture(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...",
            help="Up to eight live words, or NAME@MOTOR; by default what a run's picture shows.",
        ),
    ] = None,
    trigger: Annotated[
        str,
        typer.Option(
            metavar="WHEN",
            help="now, contact, fault, NAME>VALUE, NAME<VALUE, 'NAME rises VALUE', "
            "'NAME falls VALUE', 'NAME changes'.",
        ),
    ] = "now",
    seconds: Annotated[
        float | None,
        typer.Option(
            min=0, callback=common.finite, help="Of the device's time; else all that fits."
        ),
    ] = None,
    pre: Annotated[
        float,
        typer.Option(min=0, callback=common.finite, help="Seconds of these before the trigger."),
    ] = 0.0,
    decimate: Annotated[
        int | None,
        typer.Option(min=1, help="Ticks of a row, 1, 2, 4 ...; else the fewest that fit."),
    ] = None,
    counts_per_rev: CountsOption = None,
    preset: PresetOption = None,
    k_t: TorqueOption = None,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for trace.npz and capture.png.")
    ] = RUNS_DIR / "capture",
    port: common.PortOption = "",
    motor: common.MotorOption = 0,
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Capture live words at the tick's rate around a trigger; Ctrl-C takes what is there."""
    from wavehaptics.host import capture as captures
    from wavehaptics.host import recording
    from wavehaptics.host.captured_trace import device_of

    constant = torque_constant(preset, k_t)
    make_folder(out)
    with common.refusals():
        client = common.connected(port, unit, timeout)
        plan = captures.plan(
            client, names or captures.PICTURED, seconds=seconds, decimation=decimate,
            trigger=trigger, before_s=pre, motor=motor,
        )  # fmt: skip
        device = device_of(client, motor, counts_per_rev, constant)
        came: list[Captured] = []
        before = recording.settings_now(client)
        after: list[int] | None = None

        def written() -> None:
            for found in came:
                if not len(found.t):
                    raise CommandError("stopped before the first row: nothing was captured")
                raw = recording.recorded(client, found, before, after)
                keep(plan, found, device, out, "capture.png", raw)
                print(*_capture_lines(plan, found), sep="\n")

        with ending(written), shown_stages() as show, common.asked_to_end() as asked:
            captures.start(client, plan)

            def shown(progress: Progress) -> None:
                waits = progress.state == captures.WAITS
                show("waits for the trigger" if waits else "captures", progress.part)

            captures.wait(client, plan, shown, asked)
            try:
                came.append(captures.download(client, plan, lambda part: show("is read", part)))
            except captures.CutOffError as error:
                came.append(error.found)
                raise
            after = recording.settings_now(client)


def _capture_lines(plan: Plan, found: Captured) -> Iterator[str]:
    """What was captured, a line for each channel."""
    at = "no trigger" if found.trigger_row is None else f"the trigger's is row {found.trigger_row}"
    count = len(found.t)
    rows = f"{count} rows" if count == plan.rows else f"{count} of {plan.rows} rows"
    yield f"{rows} of {plan.row_s * 1e6:.6g} µs; {at}"
    yield from channel_lines(plan, found)
