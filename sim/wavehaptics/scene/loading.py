# SPDX-License-Identifier: Apache-2.0
"""Scenes from files, and the shipped ones."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from wavehaptics.runtime.repository import SCENES_DIR
from wavehaptics.runtime.toml_source import KeyPath, TomlError, parse, parse_value
from wavehaptics.scene.device import (
    MOTORS,
    Device,
    MotorData,
    MotorsError,
    SpaceData,
    shared,
    split,
    split_space,
)
from wavehaptics.scene.keys import as_written, nearest
from wavehaptics.scene.messages import Refusal, keys_of, refused, refused_space
from wavehaptics.scene.places import Places, SceneError
from wavehaptics.scene.schema import TABLES, Scene
from wavehaptics.scene.space import SPACE_TABLES, Space

LARGEST_FILE = 1 << 20
"""Bytes in a scene; whatever is larger is no scene."""


def first_comment(path: Path) -> str:
    """What a scene says of itself: its first line of comment below the license."""
    comments = (line for line in path.read_text(encoding="utf-8").splitlines() if line[:1] == "#")
    return next((line.lstrip("# ") for line in comments if "SPDX" not in line), "")


def _apply(motors: list[MotorData], space: SpaceData | None, override: str, said: str) -> None:
    """Put one ``table.key=value`` into the scenes of ``motors``, or ``motors.NAME.key=value`` and
    ``motors.NAME.table.key=value`` into that of one; ``SceneError`` if it has another form.

    A device's ``space`` takes those of its tables, ``surface.NUMBER.key=value`` among them.
    Messages have ``said`` before it.
    """
    where = said + override
    key, equals, text = override.partition("=")
    path = tuple(part.strip() for part in key.split("."))
    text = text.strip()
    if re.search("[\ud800-\udfff]", override):  # what the shell passed on as raw bytes
        raise SceneError(f"{where}: is not UTF-8; it must be table.key=value")
    if not equals:
        raise SceneError(f"{where}: no value; it must be table.key=value")
    of_space = space if path[0] in SPACE_TABLES else None
    surface = None
    if of_space is not None and path[0] == "surface":
        surface, path = _surface(of_space, path, where), (path[0], *path[2:])
    elif path[0] == MOTORS:
        motors, path = _of_one(motors, path, where)
    elif len(path) == 1:
        homes = [f"{name}.{key.strip()}" for name, t in TABLES.items() if path[0] in keys_of(t)]
        meant = f"did you mean {' or '.join(homes)}?" if homes else "it must be table.key=value"
        raise SceneError(f"{where}: {as_written(key)} names no table; {meant}")
    if len(path) > 2 or not all(path):
        raise SceneError(f"{where}: {as_written(key)} is not table.key; it must be table.key=value")
    try:
        value = parse_value(text)
    except ValueError:
        if not text or re.search(r"""[\[\]{}"'#=,\n]""", text):
            raise SceneError(
                f"{where}: {as_written(text)} is not a TOML value; "
                'write a number, "a string", or [[x_min, x_max]]'
            ) from None
        value = text
    if surface is not None and of_space is not None:
        number, surface_table = surface
        surface_table[path[1]] = value
        _mark(of_space, (path[0], number, path[1]), where)
        return
    written: list[MotorData | SpaceData] = [*motors] if of_space is None else [of_space]
    for home in written:
        table = home.data.setdefault(path[0], {})
        if isinstance(table, dict):
            table[path[1]] = value
        _mark(home, path, where)


def _mark(data: MotorData | SpaceData, path: KeyPath, where: str) -> None:
    """Remember that a key's value is from an override."""
    data.overridden[path] = where
    data.lines = {at: line for at, line in data.lines.items() if at[: len(path)] != path}


def _surface(space: SpaceData, path: tuple[str, ...], where: str) -> tuple[int, dict[str, Any]]:
    """Number and table of the surface that ``surface.NUMBER.key`` is of."""
    found = space.data.get("surface")
    tables: list[Any] = found if isinstance(found, list) else []
    number = int(path[1]) if len(path) == 3 and path[1].isdecimal() else len(tables)
    if number >= len(tables) or not isinstance(tables[number], dict):
        raise SceneError(
            f"{where}: it must be surface.NUMBER.key=value; the scene has {len(tables)} "
            "[[surface]], which count from 0"
        )
    return number, tables[number]


def _of_one(
    motors: list[MotorData], path: tuple[str, ...], where: str
) -> tuple[list[MotorData], tuple[str, ...]]:
    """The motor that ``motors.NAME.key`` is of, by its name or number, and the key in its scene."""
    found = [
        motor for number, motor in enumerate(motors)
        if motor.several and path[1:2] in ((motor.name,), (str(number),))
    ]  # fmt: skip
    if not found or len(path) not in (3, 4):
        known = ", ".join(motor.name for motor in motors if motor.several)
        cure = f"NAME one of {known}" if known else "where the scene has [[motors]]; it has [motor]"
        raise SceneError(
            f"{where}: it must be motors.NAME.key=value or motors.NAME.table.key=value, {cure}"
        )
    at = path[2:] if len(path) == 4 else ("motor", path[2])
    if why := shared(at):
        raise SceneError(f"{where}: {why}; write {'.'.join(at)}=value")
    return found, at


def read_scene(path: Path) -> bytes:
    """Bytes of a scene; ``SceneError`` where there is no such file or it can't be read."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise SceneError(f"{path}: no such file; give the path of a scene") from None
    except IsADirectoryError:
        raise SceneError(f"{path}: is a directory; give the path of a scene in it") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise SceneError(f"{path}: can't be read: {reason}; give a readable file") from None
    if len(content) > LARGEST_FILE:
        raise SceneError(f"{path}: larger than {LARGEST_FILE} bytes; a scene is a short TOML file")
    return content


def load_device(path: str | Path, overrides: Sequence[str] = ()) -> Device:
    """Read and check the scene in the TOML file ``path``: the scene of each of its motors.

    ``overrides`` are strings ``table.key=value`` that replace or add keys, of every motor, and
    ``motors.NAME.key=value`` of one; values are TOML, and bare words are strings. ``SceneError``
    where anything is wrong: of several faults it tells the first in the order of the file,
    overrides before the file and missing keys last.
    """
    path = Path(path)
    return device_of(read_scene(path), path, overrides)


def device_of(
    content: bytes, path: Path, overrides: Sequence[str] = (), said: str = "--set "
) -> Device:
    """As :func:`load_device`, of the file's ``content``.

    A refused override is named with ``said`` before it.
    """
    try:
        data, lines = parse(content)
    except TomlError as error:
        raise SceneError(f"{path}:{error.line}: {error.problem}") from None
    space, data = split_space(data, lines)
    try:
        motors = split(data, lines)
    except MotorsError as error:
        label = Places(str(path), lines, {}).of(error.at)[1]
        raise SceneError(f"{label}: {error.problem}") from None
    for override in overrides:
        _apply(motors, space, override, said)

    scenes: dict[str, Scene] = {}
    wrong: list[list[_Told]] = []
    for motor in motors:
        of_motor = f"{MOTORS}.{motor.name}: " if len(motors) > 1 else ""
        places = Places(str(path), motor.lines, motor.overridden, of_motor)
        scene, found = refused(motor.data)
        if scene is not None:
            scenes[motor.name] = scene.placed(places)
        wrong.append([_told(refusal, places) for refusal in found])
    whole: Space | None = None
    if space is not None:
        places = Places(str(path), space.lines, space.overridden)
        made, found = refused_space(space.data)
        if made is not None:
            whole = made.placed(places)
        wrong.append([_told(refusal, places) for refusal in found])
    if any(wrong):
        first = min((told for each in wrong for told in each), key=lambda told: told[:2])
        names = [motor.name for motor, each in zip(motors, wrong, strict=False) if first in each]
        # What is wrong with every motor, at one place, is no matter of one.
        of_motor = "" if len(names) in (0, len(motors)) else f"{MOTORS}.{names[0]}: "
        raise SceneError(f"{first.label}: {of_motor}{first.problem}")
    if whole is not None and whole.device.motors != len(scenes):
        raise whole.refusal(
            f"the scene has {len(scenes)} motors, and the device takes {whole.device.motors}; "
            "write as many [[motors]]", "device.jacobian", "device.kinematics",
        )  # fmt: skip
    return Device(scenes, Places(str(path), lines, {}).of((MOTORS,))[1], whole)


class _Told(NamedTuple):
    """A refusal and its place."""

    missing: bool
    line: int
    label: str
    problem: str


def _told(refusal: Refusal, places: Places) -> _Told:
    line, label = places.blamed(refusal.paths)
    return _Told(refusal.missing, line, label, refusal.problem)


def load_scene(
    path: str | Path,
    overrides: Sequence[str] = (),
    motor: str | None = None,
    cure: str = "one is taken here; leave one of them in the file",
) -> Scene:
    """The scene of one motor of the file: the only one, or ``motor`` by its name or number.

    As :func:`load_device`, and ``SceneError`` ending in ``cure`` where there are several.
    """
    device = load_device(path, overrides)
    return (device if motor is None else device.only(motor)).one(cure)


def shipped_scenes() -> dict[str, Path]:
    """Scenes that come with the project: path by name, in alphabetical order."""
    return {path.stem: path for path in sorted(SCENES_DIR.glob("*.toml"))}


def find_scene(name: str) -> Path:
    """Path of a scene given as a path or as the bare name of a shipped one.

    A file of that name wins. ``SceneError`` for a bare name that is neither.
    """
    path = Path(name)
    if path.is_file() or not re.fullmatch(r"\w+", name):
        return path
    shipped = shipped_scenes()
    if name in shipped:
        return shipped[name]
    if path.exists():
        return path
    near = nearest(name, shipped)
    meant = f"did you mean {near}? " if near else ""
    raise SceneError(f"{name}: no such scene; {meant}give a path, or one of {', '.join(shipped)}")
