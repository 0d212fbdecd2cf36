# SPDX-License-Identifier: Apache-2.0
"""``replay``: a capture of a board through the integer model of the controller."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.shared import CommandError

if TYPE_CHECKING:
    from wavehaptics.host.replay import Outcome

app = typer.Typer()


@app.command()
def replay(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="trace.npz of `board capture`, or its folder.")
    ],
) -> None:
    """Compute a capture's words again from its positions, currents and settings, and compare.

    Ends with 0 if every word is the integer model's, and with 1 if one differs.
    """
    from wavehaptics.host import recording
    from wavehaptics.host.names import HostError
    from wavehaptics.host.replay import replay as replayed

    try:
        found = recording.read(file)
        outcomes = replayed(found)
    except HostError as error:
        text = str(error)
        raise CommandError(text if text.startswith(str(file)) else f"{file}: {text}") from None
    for outcome in outcomes:
        print(*_lines(outcome, found.tick_s), sep="\n")
    if any(outcome.differs for outcome in outcomes):
        raise typer.Exit(1)


def _lines(outcome: Outcome, tick_s: float) -> Iterator[str]:
    """What was compared of a motor, a line for each word."""
    yield (
        f"motor {outcome.motor}: {outcome.periods} control periods of {tick_s * 1e6:.6g} µs with "
        "the bridges on"
    )
    for name, word in outcome.words.items():
        text = f"  {name:<10}  {word.compared} rows compared"
        if word.first is None or word.largest is None:
            yield f"{text}, no difference"
            continue
        first, largest = word.first, word.largest
        yield (
            f"{text}, {word.differ} differ: first in row {first.row}, {first.recorded} and not "
            f"{first.model}; largest in row {largest.row}, by {largest.size}"
        )
    for name, reason in outcome.unchecked.items():
        yield f"  {name:<10}  not compared: {reason}"
