# SPDX-License-Identifier: Apache-2.0
"""A scene that can be changed: each change makes another scene, checked as a whole."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wavehaptics.scene import SceneError, device_of, find_scene, read_scene
from wavehaptics.scene.device import MOTORS, Device
from wavehaptics.scene.keys import nearest
from wavehaptics.scene.messages import keys_of
from wavehaptics.scene.schema import TABLES

SEPARATOR = "__"
"""Stands for the dot of ``table.key`` in the name of an argument."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A checked scene: its file's text and what was changed since. Made by :func:`load_scene`."""

    path: Path
    """Where it was read; messages name it."""
    content: bytes
    """The file's text, UTF-8."""
    changes: tuple[str, ...]
    """``table.key=value`` of each change, in their order."""
    device: Device
    """Its motors, with every default filled in."""

    @property
    def name(self) -> str:
        """The scene's name."""
        return self.device.name

    @property
    def motors(self) -> tuple[str, ...]:
        """Names of its motors; ``motor_0`` where the file has one ``[motor]``."""
        return tuple(self.device.motors)

    def __getitem__(self, key: str) -> Any:
        """Value of ``table.key`` in SI units, or of ``motors.NAME.table.key``.

        It is the first motor's where none is named; None is a key without a value.
        :class:`SceneError` where the format has no such key.
        """
        parts, scene = key.split("."), self.device.scenes[0]
        if parts[0] == MOTORS and len(parts) == 4 and parts[1] in self.device.motors:
            scene, parts = self.device.motors[parts[1]], parts[2:]
        if len(parts) != 2 or parts[0] not in TABLES:
            near = nearest(parts[0], TABLES)
            meant = f"did you mean {near}.{parts[-1]}?" if near else "write table.key"
            raise SceneError(f"{key}: no such table; {meant}")
        model = TABLES[parts[0]]
        if parts[1] not in keys_of(model):
            near = nearest(parts[1], keys_of(model))
            meant = f"did you mean {near}?" if near else f"it has {', '.join(keys_of(model))}"
            raise SceneError(f"{key}: [{parts[0]}] has no such key; {meant}")
        table = getattr(scene, parts[0])
        fields = {info.alias or name: name for name, info in model.model_fields.items()}
        return None if table is None else getattr(table, fields[parts[1]])

    def with_(self, changes: Mapping[str, Any] | None = None, /, **keys: Any) -> Scene:
        """Another scene, with these keys replaced or added.

        ``with_(controller__lambda=2e4)`` or ``with_({"controller.lambda": 2e4})``; numbers are in
        the key's SI unit. Keys of one of several motors are ``motors.NAME.table.key``.
        :class:`SceneError`, one line with the key and the cure, where the new scene isn't valid.
        """
        named = {key.replace(SEPARATOR, "."): value for key, value in keys.items()}
        wanted = {**(changes or {}), **named}
        made = (*self.changes, *(f"{key}={as_toml(key, value)}" for key, value in wanted.items()))
        device = device_of(self.content, self.path, made, said="")
        return replace(self, changes=made, device=device)


def as_toml(key: str, value: Any) -> str:
    """A value of ``key`` as it is written in a scene; :class:`SceneError` where it has no form."""
    if hasattr(value, "tolist"):  # NumPy's numbers and arrays
        value = value.tolist()
    if isinstance(value, list | tuple):
        return f"[{', '.join(as_toml(key, each) for each in value)}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool | int | float):
        return str(value).lower() if isinstance(value, bool) else repr(value)
    raise SceneError(
        f"{key}={value!r}: a scene has no such value; give a number, a string, a bool or a list"
    )


def load_scene(path: str | Path) -> Scene:
    """The scene in the TOML file ``path``, or the shipped one of that name.

    :class:`SceneError`, one line with place and cure, where the file isn't there or isn't valid;
    :class:`TypeError` for anything but a path or a name.
    """
    if not isinstance(path, (str, Path)):
        raise TypeError(f"a scene is a path, a name or a Scene of load_scene, not {path!r:.60}")
    found = find_scene(str(path))
    content = read_scene(found)
    return Scene(found, content, (), device_of(content, found))
