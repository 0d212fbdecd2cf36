# SPDX-License-Identifier: Apache-2.0
"""Words of a board: what it is, read, written, saved, loaded, watched."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.board import common

if TYPE_CHECKING:
    from wavehaptics.host.names import Place


@common.board.command()
def info(
    port: common.PortOption = "",
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Tell what the device is, and what its line has counted."""
    with common.refusals():
        found = common.connected(port, unit, timeout).identification
    words = found.words
    shown = {
        "table of words": f"{words['table']:08x}",
        "build": f"{words['build']:08x}",
        "clock": f"{words['clock_hz'] / 1e6:g} MHz",
        "motors": f"{words['motors']}, brushless" if found.brushless else words["motors"],
        "options": ", ".join(f"{name} {value}" for name, value in found.options.items() if value),
        **{
            name.replace("_", " "): words[name]
            for name in ("frames", "crc_errors", "framing_errors", "overruns")
        },
    }
    for name, value in shown.items():
        print(f"{name:<15} {value}")


def _shown(place: Place, raw: int, as_raw: bool) -> str:
    if as_raw:
        return f"0x{raw:08x}"
    value = place.value(raw)
    return f"{value:.9g}" if isinstance(value, float) else str(value)


@common.board.command()
def get(
    names: Annotated[list[str], typer.Argument(metavar="NAME...", help="NAME or NAME[INDEX].")],
    port: common.PortOption = "",
    motor: common.MotorOption = 0,
    raw: common.RawOption = False,
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Read words."""
    from wavehaptics.host.names import places, readable

    with common.refusals():
        client = common.connected(port, unit, timeout)
        found = [readable(p) for name in names for p in places(name, client.shape, motor)]
        words = client.read(found)
    width = max(len(place.text) for place in found)
    for place, word in zip(found, words, strict=True):
        unit_text = "" if raw else place.word.row.unit
        print(f"{place.text:<{width}}  {_shown(place, word, raw)} {unit_text}".rstrip())


@common.board.command("set")
def set_words(
    values: Annotated[
        list[str], typer.Argument(metavar="NAME=VALUE...", help="In SI units, as docs/words.md.")
    ],
    port: common.PortOption = "",
    motor: common.MotorOption = 0,
    raw: common.RawOption = False,
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Write words; those of one group are given together."""
    from wavehaptics.host.names import HostError, number, places, settable

    with common.refusals():
        client = common.connected(port, unit, timeout)
        words: dict[Place, int] = {}
        for text in values:
            name, _, value = text.partition("=")
            try:
                given = number(value.strip())
            except ValueError:
                raise HostError(f"{text}: write NAME=NUMBER, as in root=2.0") from None
            found = [settable(place) for place in places(name.strip(), client.shape, motor)]
            if len(found) > 1:
                raise HostError(f"{text}: which one? Take {found[0].text}...{found[-1].text}")
            if found[0] in words:
                raise HostError(f"{text}: {found[0].text} is there twice; leave one out")
            words[found[0]] = found[0].raw(given, is_raw=raw)
        frames = client.write(words.items())
    if frames > 1:
        print(f"{frames} frames, given one after another: the words aren't of one group")


@common.board.command()
def save(
    path: Annotated[Path, typer.Argument(metavar="FILE", help="A TOML file.")],
    port: common.PortOption = "",
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Save all settings of the device."""
    from wavehaptics.host import session

    with common.refusals():
        count = session.save(common.connected(port, unit, timeout), path)
    print(f"{path}: {count} words")


@common.board.command()
def load(
    path: Annotated[Path, typer.Argument(metavar="FILE", help="A TOML file.")],
    port: common.PortOption = "",
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Give the device the settings of FILE: all of them, or none."""
    from wavehaptics.host import session

    with common.refusals():
        changed, count = session.load(common.connected(port, unit, timeout), path)
    print(f"{path}: {count} words, of which {changed} were others")


@common.board.command()
def watch(
    names: Annotated[list[str], typer.Argument(metavar="NAME...", help="NAME or NAME[INDEX].")],
    port: common.PortOption = "",
    motor: common.MotorOption = 0,
    raw: common.RawOption = False,
    csv: Annotated[bool, typer.Option("--csv", help="Lines of CSV in place of a table.")] = False,
    count: Annotated[int | None, typer.Option("-n", min=1, help="So many times.")] = None,
    every: Annotated[
        float, typer.Option(min=0, max=3600, callback=common.finite, help="Seconds between.")
    ] = 0.2,
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Read words again and again, until Ctrl-C."""
    from wavehaptics.host.names import places, readable

    with common.refusals():
        client = common.connected(port, unit, timeout)
        found = [readable(p) for name in names for p in places(name, client.shape, motor)]
        start = time.monotonic()

        def samples() -> Iterator[tuple[float, list[str]]]:
            taken = 0
            while count is None or taken < count:
                if taken:
                    time.sleep(every)
                words = client.read(found)
                texts = [_shown(p, w, raw) for p, w in zip(found, words, strict=True)]
                yield time.monotonic() - start, texts
                taken += 1

        if csv:
            print(",".join(["t_s", *(place.text for place in found)]), flush=True)
            for moment, texts in samples():
                print(",".join([f"{moment:.3f}", *texts]), flush=True)
        else:
            _watch_table(found, raw, samples())


def _watch_table(found: list[Place], raw: bool, samples: Iterator[tuple[float, list[str]]]) -> None:
    from rich.console import Console
    from rich.live import Live
    from rich.table import Table

    console, shown = Console(), None
    try:
        with Live(console=console) as live:
            for moment, texts in samples:
                shown = Table("word", f"at {moment:.1f} s", "unit")
                for place, text in zip(found, texts, strict=True):
                    shown.add_row(place.text, text, "" if raw else place.word.row.unit)
                live.update(shown, refresh=True)
    finally:
        # The last table, which is all that is not for a terminal, comes without its line's end.
        if shown is not None and not console.is_terminal:
            console.line()
