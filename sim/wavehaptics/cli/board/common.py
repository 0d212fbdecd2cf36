# SPDX-License-Identifier: Apache-2.0
"""What the commands for a board have in common: their options, and how a board is reached."""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.shared import CommandError
from wavehaptics.runtime.ends import end_signals

if TYPE_CHECKING:
    from wavehaptics.host.client import Client

board = typer.Typer(
    help="Talk to a board over its serial line, or be one without hardware (--virtual).",
    invoke_without_command=True,
)


def finite(value: float | None) -> float | None:
    """A number of an option: a range alone lets nan through, and one without an end inf."""
    if value is not None and not math.isfinite(value):
        raise typer.BadParameter(f"{value} is not a finite number.")
    return value


PortOption = Annotated[
    str, typer.Option("--port", metavar="PATH", envvar="WH_PORT", help="The serial port.")
]
UnitOption = Annotated[int, typer.Option(min=1, max=247, help="Unit of the device.")]
TimeoutOption = Annotated[
    float, typer.Option(min=0.01, max=3600, callback=finite, help="Seconds to wait for an answer.")
]
MotorOption = Annotated[int, typer.Option(min=0, max=7, help="The motor whose words are meant.")]
RawOption = Annotated[bool, typer.Option("--raw", help="Raw words in place of values in SI units.")]
DEFAULT_TIMEOUT = 5.0


@contextmanager
def refusals() -> Iterator[None]:
    """What the host can't do, as refusals of the command."""
    from wavehaptics.host.names import HostError

    try:
        yield
    except HostError as error:
        raise CommandError(str(error)) from None


def connected(port: str, unit: int, timeout: float) -> Client:
    """The device at a port; ``timeout`` in seconds."""
    from wavehaptics.host.client import Client

    if not port:
        raise CommandError("no port: name one with --port PATH, or in WH_PORT")
    return Client(port, unit, timeout)


@contextmanager
def asked_to_end() -> Iterator[Callable[[], bool]]:
    """Whether a signal has asked for the end since."""
    asked: list[bool] = []
    kept = {n: signal.signal(n, lambda *_: asked.append(True)) for n in end_signals()}
    try:
        yield lambda: bool(asked)
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)
