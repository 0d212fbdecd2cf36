# SPDX-License-Identifier: Apache-2.0
"""``board identify``: what motor hangs on a board."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.board import common
from wavehaptics.cli.shared import CommandError, shown_stages
from wavehaptics.runtime.ends import ending

if TYPE_CHECKING:
    from wavehaptics.host.identify.result import AnyFound, Row

BEFORE_SUFFIX = ".before.toml"
"""Of the file of a device's settings that couldn't be given back."""

TOLD_S = 10.0
"""From one line about the progress to the next, where there is no terminal."""


@common.board.command()
def identify(
    counts: Annotated[
        int,
        typer.Option(min=4, max=4_000_000, help="Counts a turn of the encoder, all four edges."),
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="A scene of it, and words for `load` beside."),
    ] = None,
    port: common.PortOption = "",
    motor: common.MotorOption = 0,
    current: Annotated[
        float | None,
        typer.Option(min=0.001, max=60, callback=common.finite, help="Test current, A."),
    ] = None,
    travel: Annotated[
        float | None,
        typer.Option(
            min=0.01, callback=common.finite, help="Room that the rotor has, rad; else it may turn."
        ),
    ] = None,
    expect: Annotated[
        str | None, typer.Option(metavar="PRESET", help="The motor that it should be.")
    ] = None,
    signs: Annotated[
        bool,
        typer.Option("--signs", help="Only whether current and encoder have the right sign."),
    ] = False,
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Identify the motor: it turns, for some seconds; simulated, for minutes.

    Faults of the wiring are told by name.
    """
    from wavehaptics.host import session
    from wavehaptics.host.identify.driver import Driver, EndedError
    from wavehaptics.host.identify.identification import identify as identified
    from wavehaptics.host.identify.identification import try_signs
    from wavehaptics.host.identify.result import beside, rows, write
    from wavehaptics.host.identify.steps import Wishes
    from wavehaptics.host.names import HostError
    from wavehaptics.parts.motors import (
        BRUSHLESS_PRESETS,
        PRESETS,
        BrushlessConstants,
        MotorConstants,
    )

    presets: dict[str, MotorConstants | BrushlessConstants] = {**PRESETS, **BRUSHLESS_PRESETS}
    if expect is not None and expect not in presets:
        raise CommandError(f"--expect {expect}: take {', '.join(presets)}")
    for option, given in (("--out", out), ("--travel", travel), ("--expect", expect)):
        if signs and given is not None:
            raise CommandError(f"--signs takes no {option}; leave one of them out")
    wishes = Wishes(counts, current, travel, presets[expect] if expect else None)
    with common.refusals():
        if out is not None:
            for path in (out, beside(out)):
                session.check_writable(path)
        client = common.connected(port, unit, timeout)
        results: list[AnyFound] = []
        tell = partial(print, flush=True)

        def written() -> None:
            for found in results:
                _identified_table(rows(found))
                if out is not None:
                    print(*write(found, driver, out, motor), sep="\n")

        with ending(written), common.asked_to_end() as asked, _shown() as show:
            driver = Driver(client, motor, ended=asked)
            print("the rotor turns: seconds on a board, minutes on a simulated one", flush=True)
            try:
                if signs:
                    try_signs(driver, counts, tell, show, current)
                else:
                    identified(driver, wishes, tell, show, results.append)
            except EndedError:
                raise KeyboardInterrupt from None
            except HostError as error:
                if driver.restored:
                    raise
                kept = beside(out or Path("motor.toml"), BEFORE_SUFFIX)
                gives_back = f"`board load {kept}` gives it those that it had"
                try:
                    session.write_file(kept, session.to_text(driver.before))
                except HostError as more:
                    gives_back = str(more)
                raise HostError(
                    f"{error} (the device may still have the test's settings: {gives_back})"
                ) from None


@contextmanager
def _shown() -> Iterator[Callable[[str, float], None]]:
    """A function that takes a stage and its part done, 0 to 1, and shows them.

    As bars on a terminal; elsewhere a line now and then, which a board is too fast to see.
    """
    with shown_stages() as bars:
        last = time.monotonic()

        def show(stage: str, part: float) -> None:
            nonlocal last
            bars(stage, part)
            if not sys.stderr.isatty() and time.monotonic() - last >= TOLD_S:
                last = time.monotonic()
                print(f"{stage}: {100 * part:.0f} %", flush=True)

        yield show


def _identified_table(rows: Iterable[Row]) -> None:
    from rich.console import Console
    from rich.table import Table

    shown = Table("", "value", "±", "unit")
    for row in rows:
        shown.add_row(row.name, row.value, row.spread, row.unit)
    Console().print(shown)
