# SPDX-License-Identifier: Apache-2.0
"""Scenes from files, and the shipped ones."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from wavehaptics.runtime.repository import SCENES_DIR
from wavehaptics.runtime.toml_source import KeyPath, TomlError, parse, parse_value
from wavehaptics.scene.keys import as_written, nearest
from wavehaptics.scene.messages import keys_of, refused
from wavehaptics.scene.places import Places, SceneError
from wavehaptics.scene.schema import TABLES, Scene

LARGEST_FILE = 1 << 20
"""Bytes in a scene; whatever is larger is no scene."""


def first_comment(path: Path) -> str:
    """What a scene says of itself: its first line of comment below the license."""
    comments = (line for line in path.read_text(encoding="utf-8").splitlines() if line[:1] == "#")
    return next((line.lstrip("# ") for line in comments if "SPDX" not in line), "")


def _apply(data: dict[str, Any], override: str) -> KeyPath:
    """Put one ``table.key=value`` into ``data``; ``SceneError`` if it has another form."""
    where = f"--set {override}"
    key, equals, text = override.partition("=")
    path = tuple(part.strip() for part in key.split("."))
    text = text.strip()
    if re.search("[\ud800-\udfff]", override):  # what the shell passed on as raw bytes
        raise SceneError(f"{where}: is not UTF-8; it must be table.key=value")
    if not equals:
        raise SceneError(f"{where}: no value; it must be table.key=value")
    if len(path) == 1:
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
    table = data.setdefault(path[0], {})
    if isinstance(table, dict):
        table[path[1]] = value
    return path


def _read(path: Path) -> bytes:
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


def load_scene(path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """Read and check the scene in the TOML file ``path``.

    ``overrides`` are strings ``table.key=value`` that replace or add keys; values are TOML, and
    bare words are strings. ``SceneError`` where anything is wrong: of several faults it tells the
    first in the order of the file, overrides before the file and missing keys last.
    """
    path = Path(path)
    try:
        data, lines = parse(_read(path))
    except TomlError as error:
        raise SceneError(f"{path}:{error.line}: {error.problem}") from None
    overridden: dict[KeyPath, str] = {}
    for override in overrides:
        key = _apply(data, override)
        overridden[key] = override
        lines = {at: line for at, line in lines.items() if at[: len(key)] != key}

    places = Places(str(path), lines, overridden)
    scene, found = refused(data)
    placed = []
    for refusal in found:
        line, label = places.blamed(refusal.paths)
        placed.append((refusal.missing, line, f"{label}: {refusal.problem}"))
    if placed:
        raise SceneError(min(placed, key=lambda p: p[:2])[2])
    assert scene is not None
    return scene.placed(places)


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
