# SPDX-License-Identifier: Apache-2.0
"""``board stream``: live words row after row, as fast as the line is."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.board import common
from wavehaptics.cli.board.arming import stay_armed, write_arm
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
    from wavehaptics.host.client import Client
    from wavehaptics.host.stream import Stream, Streamed

STREAMED = ("position", "current", "voltage", "flags")
"""What a stream has by default."""
STILL_S = 30.0
"""Wall-clock time without a packet after which none comes, on a slow simulated board as well."""


@common.board.command()
def stream(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[WORD]...",
            help="Up to four live words: NAME or NAME@MOTOR, and :RANGE that it needs; by default "
            "position, current, voltage and flags.",
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            min=0, callback=common.finite, help="Of the device's time; else until Ctrl-C."
        ),
    ] = None,
    decimate: Annotated[
        int | None,
        typer.Option(min=1, help="Ticks of a row, 1, 2, 4 ...; else the fewest the line carries."),
    ] = None,
    arms: Annotated[
        bool, typer.Option("--arm", help="Arm meanwhile, as `board arm` does: the line is taken.")
    ] = False,
    counts_per_rev: CountsOption = None,
    preset: PresetOption = None,
    k_t: TorqueOption = None,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for trace.npz and stream.png.")
    ] = RUNS_DIR / "stream",
    port: common.PortOption = "",
    motor: common.MotorOption = 0,
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Receive live words row after row, as fast as the line is, until Ctrl-C."""
    from wavehaptics.host.captured_trace import device_of
    from wavehaptics.host.stream import Stream

    constant = torque_constant(preset, k_t)
    make_folder(out)
    with common.refusals():
        client = common.connected(port, unit, timeout)
        device = device_of(client, motor, counts_per_rev, constant)
        live = Stream(client, names or STREAMED, decimation=decimate, motor=motor)

        def written() -> None:
            if not live.came:
                raise CommandError("stopped before the first packet: nothing was received")
            found = live.found()
            keep(found.plan, found, device, out, "stream.png")
            print(*_stream_lines(found), sep="\n")

        with ending(written), shown_stages() as show, common.asked_to_end() as asked, live:
            _receive(client, live, show, asked, seconds, arms=arms)


def _receive(
    client: Client,
    live: Stream,
    show: Callable[[str, float], None],
    asked: Callable[[], bool],
    seconds: float | None,
    *,
    arms: bool,
) -> None:
    """Wait until a stream is as long as it has to be, or somebody asks to end."""
    from concurrent.futures import ThreadPoolExecutor

    over: list[bool] = []

    def disarmed() -> None:
        over.append(True)
        pool.shutdown()
        if arms:
            write_arm(client, 0)

    with ThreadPoolExecutor(1) as pool, ending(disarmed):
        arming = pool.submit(stay_armed, client, lambda: bool(over), None) if arms else None
        came, since = 0.0, time.monotonic()
        while not asked() and (seconds is None or live.seconds < seconds):
            live.check()
            if arming is not None and arming.done():
                arming.result()
            if live.seconds > came:
                came, since = live.seconds, time.monotonic()
            elif time.monotonic() - since > STILL_S:
                raise CommandError("no packet comes; are there ticks, and is the ADC there?")
            stage = f"receives, {live.lost} packets lost" if live.lost else "receives"
            show(stage, live.seconds / seconds if seconds else 0.0)
            time.sleep(0.02)


def _stream_lines(found: Streamed) -> Iterator[str]:
    """What was received, and what wasn't."""
    plan = found.plan
    yield f"{len(found.t)} rows of {plan.row_s * 1e6:.6g} µs, {1 / plan.row_s:.6g} a second"
    yield from channel_lines(plan, found)
    if found.lost_packets:
        yield (
            f"{found.lost_packets} packets were lost, {int(found.lost.sum())} rows: the device had "
            f"no room for {found.left_out}, {found.broken} frames came broken"
        )
    for name, rows in found.at_end.items():
        yield f"{name}: {rows} rows at the end of its 16 bits; take {name}:RANGE, a larger one"
