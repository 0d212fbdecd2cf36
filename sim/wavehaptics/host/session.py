# SPDX-License-Identifier: Apache-2.0
"""All settings of a device in a TOML file, and back."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from wavehaptics.host.client import Client
from wavehaptics.host.names import HostError, Place, Shape, places, settings
from wavehaptics.runtime.files import replaced, try_file, write_text
from wavehaptics.runtime.toml_source import TomlError, parse
from wavehaptics.scene.keys import as_written
from wavehaptics.words import table
from wavehaptics.words.table import MOST, WORDS

BOARD = "board"
MOTOR = "motor"
"""Table of a motor's words: ``[motor.0]``."""


def save(client: Client, path: Path) -> int:
    """Write all settings of the device to ``path``, in their units; their number."""
    check_writable(path)
    found = settings(client.shape)
    write_file(path, to_text(zip(found, client.read(found), strict=True)))
    return len(found)


def check_writable(path: Path) -> None:
    """:class:`HostError` with the cure where no file can be written; before what takes long.

    Its folder is made.
    """
    try:
        if path.is_dir():
            raise HostError(f"{path}: is a folder; name a file in it, as in {path}/settings.toml")
        if path.exists() and not path.is_file():
            raise HostError(f"{path}: is no file that can be replaced; name another one")
        target = replaced(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        try_file(target)
    except OSError as error:
        raise _unwritable(path, error) from None


def write_file(path: Path, text: str) -> None:
    """Write a file whole or not at all; :class:`HostError` where that can't be."""
    try:
        write_text(path, text)
    except OSError as error:
        raise _unwritable(path, error) from None


def _unwritable(path: Path, error: OSError) -> HostError:
    reason = error.strerror or str(error)
    if isinstance(error, (FileExistsError, NotADirectoryError)):
        files = (part for part in path.parents if os.path.lexists(part) and not part.is_dir())
        reason = f"{next(files, path.parent)} is a file and no folder"
    return HostError(f"{path}: can't be written: {reason}; name another file")


def to_text(words: Iterable[tuple[Place, int]]) -> str:
    """The file of (place, raw word)."""
    tables: dict[str, dict[str, list[float | int]]] = {}
    for place, raw in words:
        board = place.word.row.per == "board"
        rows = tables.setdefault(BOARD if board else f"{MOTOR}.{place.motor}", {})
        rows.setdefault(place.word.name, []).append(place.value(raw))
    lines = ["# Settings of a wave haptics controller, in the units of docs/words.md."]
    count = sum(len(values) for rows in tables.values() for values in rows.values())
    lines += [f'table = "{table.crc():08x}"', f"words = {count}"]
    for name, rows in tables.items():
        lines += ["", f"[{name}]"]
        for key, values in rows.items():
            word = WORDS[key]
            several = MOST[word.row.per] * word.row.count > 1
            shown = f"[{', '.join(map(repr, values))}]" if several else repr(values[0])
            lines.append(f"{key} = {shown}" + (f"  # {word.row.unit}" if word.row.unit else ""))
    return "\n".join(lines) + "\n"


def read(path: Path, shape: Shape) -> list[tuple[Place, int]]:
    """(place, raw word) of a file. :class:`HostError` with a line for each word that is wrong."""
    try:
        content = path.read_bytes()
        document, lines = parse(content)
    except TomlError as error:
        raise HostError(f"{path}:{error.line}: {error.problem}") from None
    except OSError as error:
        raise HostError(f"{path}: can't be read: {error.strerror}") from None
    found: list[tuple[Place, int]] = []
    given: set[int] = set()
    problems: list[str] = []

    def note(key: tuple[str, ...], problem: str) -> None:
        problems.append(f"{path}:{lines.get(key, 1)}: {problem}")

    told, crc = document.pop("table", None), f"{table.crc():08x}"
    if told is None and document:
        note((), f'no table = "{crc}" tells of which table of words its words are; save the '
             "settings anew, or write that as its first line if they are of this one")  # fmt: skip
    elif told not in (None, crc):
        note(("table",), f"table = {as_written(told)} is another table of words than {crc}; "
             "save the settings anew, with the package of their bitstream")  # fmt: skip
    count = document.pop("words", None)
    for name, motor, rows, key in _tables(document, shape, note):
        for row, value in rows.items():
            try:
                words = _words(row, value, motor, shape, name)
            except HostError as error:
                note((*key, row), str(error))
                continue
            addresses = {place.address for place, _ in words}
            if given & addresses:
                note((*key, row), f"{row} is given twice; take one of them out")
            given |= addresses
            found += words
    if count is not None and not problems:
        _check_whole(count, len(found), content, note)
    if problems:
        raise HostError("\n".join(problems))
    if not found:
        raise HostError(f"{path}: there is no word in it; take a file that `board save` wrote")
    return found


def _check_whole(count: Any, there: int, content: bytes, note: Any) -> None:
    """Note it where a file isn't whole any more, by the number of words that it had."""
    key = ("words",)
    if isinstance(count, bool) or not isinstance(count, int):
        note(key, f"words = {as_written(count)} is no number of words; take the line out")
    elif there < count:
        note(key, f"it has {there} of its {count} words; was it cut? Save it anew, or correct "
             f"words = {count}")  # fmt: skip
    elif there > count:
        note(key, f"words = {count}, but it has {there}; correct that number")
    elif not content.endswith(b"\n"):
        note(key, "its last line has no end; was it cut? Save it anew")


def _tables(document: dict[str, Any], shape: Shape, note: Any) -> Iterable[tuple[Any, ...]]:
    """(name, motor, rows, key) of the file's tables that the device has."""
    for name, rows in document.items():
        if name == BOARD and isinstance(rows, dict):
            yield name, 0, rows, (name,)
        elif name == MOTOR and isinstance(rows, dict):
            motors = [str(motor) for motor in range(shape.parts)]
            for number, inner in rows.items():
                known = number in motors and isinstance(inner, dict)
                if known:
                    yield f"{name}.{number}", int(number), inner, (name, number)
                else:
                    last = shape.parts - 1
                    note((name, number), f"[motor.{number}]: the device has motors 0...{last}")
        else:
            note((name,), f"{name}: there are [board] and [motor.0], [motor.1] ... only")


def _words(row: str, value: Any, motor: int, shape: Shape, name: str) -> list[tuple[Place, int]]:
    there = places(row, shape, motor)
    word = there[0].word
    if word.row.kind != "setting":
        raise HostError(f"{row} is no setting")
    if (word.row.per == "board") != (name == BOARD):
        raise HostError(f"{row} stands in [{BOARD if word.row.per == 'board' else 'motor.0'}]")
    several = MOST[word.row.per] * word.row.count > 1
    values = value if several else [value]
    if not isinstance(values, list) or len(values) != len(there):
        raise HostError(f"{row} takes a list of {len(there)} numbers on this device")
    return [(place, place.raw(each)) for place, each in zip(there, values, strict=True)]


def load(client: Client, path: Path) -> tuple[int, int]:
    """Give the device the settings of ``path``: (words that were changed, words of the file).

    :class:`HostError` for a file that is wrong, and where the device refuses a word: what was
    written before is then as it was.
    """
    wanted = read(path, client.shape)
    before = client.read(place for place, _ in wanted)
    differs = [
        (place, raw, old)
        for (place, raw), old in zip(wanted, before, strict=True)
        if raw & 0xFFFFFFFF != old
    ]
    off = [place.text for place, _, _ in differs if place.word.change == "off"]
    if off and client.read(places("running", client.shape))[0]:
        raise HostError(
            "\n".join(
                f"{path}: {name} changes with the bridges off only; disarm first" for name in off
            )
        )
    try:
        client.write((place, raw) for place, raw, _ in differs)
    except HostError as error:
        try:
            client.write((place, old) for place, _, old in differs)
        except HostError:
            raise HostError(
                f"{error} (the device may have some of the file's words; load it again)"
            ) from None
        raise
    return len(differs), len(wanted)
