# SPDX-License-Identifier: Apache-2.0
"""``[[motors]]``: a scene of several motors, each of which is a scene of its own.

With ``[device]`` they move one tip together, and ``[hand]`` holds that
(:mod:`wavehaptics.scene.space`).

A motor's scene has the tables of the file, and over them, key by key, those that stand inside its
``[[motors]]``. What the motors of one controller share stands outside only.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

from wavehaptics.runtime.toml_source import KeyPath, dotted
from wavehaptics.scene.keys import as_written, nearest
from wavehaptics.scene.places import SceneError
from wavehaptics.scene.schema import TABLES, Scene
from wavehaptics.scene.space import SPACE_TABLES, Space

MOTORS = "motors"
NAME_RANGE = "1 to 30 letters, digits, _ and -, the first a letter"

_CARRIER = "one carrier times all motors"
_BRIDGE = "all bridges switch alike"
_FRAME = "one frame reads all converters"
SHARED: dict[KeyPath, str] = {
    ("scene",): "all motors run together",
    ("host",): "one line leads to the host",
    ("guard",): "one guard watches all motors",
    ("controller", "tick_hz"): _CARRIER,
    ("controller", "clock_hz"): _CARRIER,
    ("controller", "extra_ticks"): _CARRIER,
    ("drive", "pwm_hz"): _CARRIER,
    ("drive", "mode"): _BRIDGE,
    ("drive", "dead_time_s"): _BRIDGE,
    ("drive", "compensate"): _BRIDGE,
    ("drive", "min_pulse_s"): _BRIDGE,
    ("drive", "bus_measured"): "one converter measures the bus",
    ("adc", "part"): _FRAME,
    ("adc", "bits"): _FRAME,
}
"""What the motors of a controller have in common, and why: it is soldered, or in registers that
``rtl/words.toml`` has once per board."""


@dataclass(frozen=True)
class Device:
    """The motors of a scene, in the order of the file: their names, and the scene of each."""

    motors: dict[str, Scene]
    place: str
    """Where the scene says how many they are, for messages."""
    space: Space | None = None
    """What they move together; without it nothing connects them."""

    @property
    def scenes(self) -> tuple[Scene, ...]:
        return tuple(self.motors.values())

    @property
    def name(self) -> str:
        """Name of the scene, which all motors share."""
        return self.scenes[0].scene.name

    def only(self, motor: str) -> Device:
        """The device of the motor of that name or number alone; :class:`SceneError` without it."""
        self._apart("leave --motor out")
        for number, (name, scene) in enumerate(self.motors.items()):
            if motor in (name, str(number)):
                return Device({name: scene}, self.place)
        near = nearest(motor, self.motors)
        meant = f"did you mean {near}? " if near else ""
        cure = f"{meant}known: {', '.join(self.motors)}"
        if len(self.motors) == 1:
            cure = "the scene has one, so leave --motor out"
        raise SceneError(f"--motor {motor}: {self.place}: there is no such motor; {cure}")

    def one(self, cure: str) -> Scene:
        """The scene of the only motor; :class:`SceneError` ending in ``cure`` where it isn't."""
        self._apart("take `run`, or a scene without [device]")
        if len(self.motors) > 1:
            known = ", ".join(self.motors)
            raise SceneError(
                f"{self.place}: the scene has {len(self.motors)} motors, {known}; {cure}"
            )
        return self.scenes[0]

    def _apart(self, cure: str) -> None:
        """:class:`SceneError` ending in ``cure`` where the motors move one tip."""
        if self.space is not None:
            raise self.space.refusal(f"[device] moves all motors together; {cure}", "device")


@dataclass
class MotorData:
    """What a motor's scene is made of, before it is checked."""

    name: str
    data: dict[str, Any]
    lines: dict[KeyPath, int]
    several: bool = True
    """Whether it stands in a ``[[motors]]``, even if that is the only one."""
    overridden: dict[KeyPath, str] = field(default_factory=dict)


@dataclass
class SpaceData:
    """What a scene says of the device that its motors move, before it is checked."""

    data: dict[str, Any]
    lines: dict[KeyPath, int]
    overridden: dict[KeyPath, str] = field(default_factory=dict)


class MotorsError(ValueError):
    """Wrong ``[[motors]]``: where in the file, and what."""

    def __init__(self, at: KeyPath, problem: str) -> None:
        super().__init__(problem)
        self.at = at
        self.problem = problem


def shared(path: KeyPath) -> str | None:
    """Why ``path``, a key or table of one motor, belongs to all; ``None`` where it doesn't."""
    for at, why in SHARED.items():
        if path[: len(at)] == at:
            return f"{dotted(path)} is the same for every motor: {why}"
    return None


def split_space(
    data: dict[str, Any], lines: dict[KeyPath, int]
) -> tuple[SpaceData | None, dict[str, Any]]:
    """The device's tables of a document, None where it has none, and the other tables."""
    if not {"device", "surface", "coupling"} & set(data):
        return None, data
    space = {name: value for name, value in data.items() if name in SPACE_TABLES}
    others = {name: value for name, value in data.items() if name not in SPACE_TABLES}
    of_space = {at: line for at, line in lines.items() if at[0] in SPACE_TABLES}
    return SpaceData(space, of_space), others


def split(data: dict[str, Any], lines: dict[KeyPath, int]) -> list[MotorData]:
    """The motors of a document; :class:`MotorsError` where ``[[motors]]`` isn't understood."""
    if MOTORS not in data:
        return [MotorData("motor_0", data, lines, several=False)]
    tables = data[MOTORS]
    if "motor" in data:
        raise MotorsError(
            max(("motor",), (MOTORS,), key=lambda at: lines.get(at, 0)),
            "a scene has [motor] or [[motors]], not both; write each motor as [[motors]]",
        )
    if not isinstance(tables, list) or not tables:
        told = "is empty" if tables == [] else f"must be tables, not {as_written(tables)}"
        raise MotorsError((MOTORS,), f"motors {told}; write [[motors]] above each motor's keys")
    common = {name: value for name, value in data.items() if name != MOTORS}
    found: dict[str, MotorData] = {}
    for number, table in enumerate(tables):
        at = (MOTORS, number)
        if not isinstance(table, dict):
            raise MotorsError(
                at, f"{dotted(at)} must be a table, not {as_written(table)}; write [[motors]]"
            )
        name = _name(number, table)
        if name in found:
            raise MotorsError(
                (*at, "name"),
                f"{dotted(at)}.name {as_written(name)} is also that of {MOTORS}"
                f"[{list(found).index(name)}]; give each motor a name of its own",
            )
        found[name] = _motor(name, at, common, table, lines)
    return list(found.values())


def _name(number: int, table: dict[str, Any]) -> str:
    name = table.get("name", f"motor_{number}")
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,29}", name):
        at = (MOTORS, number, "name")
        raise MotorsError(at, f"{dotted(at)} = {as_written(name)} is no name; use {NAME_RANGE}")
    return name


def _motor(
    name: str, at: KeyPath, common: dict[str, Any], table: dict[str, Any],
    lines: dict[KeyPath, int],
) -> MotorData:  # fmt: skip
    """The scene of one motor: what stands in its ``table`` over what all have."""
    inside = {
        key: value for key, value in table.items()
        if key != "motor" and (key in TABLES or isinstance(value, dict))
    }  # fmt: skip
    motor = {key: value for key, value in table.items() if key != "name" and key not in inside}
    data = {key: dict(value) if isinstance(value, dict) else value for key, value in common.items()}
    data["motor"] = motor
    own: list[KeyPath] = []
    for key, value in inside.items():
        keys: list[KeyPath] = [(key, below) for below in value] if isinstance(value, dict) else []
        for path in keys or [(key,)]:
            if why := shared(path):
                raise MotorsError((*at, *path), f"{MOTORS}.{name}: {why}; move it to [{key}]")
        merged = isinstance(value, dict) and isinstance(data.get(key), dict)
        data[key] = {**data[key], **value} if merged else value
        own += keys if merged else [(key,)]
    kept = {
        to: line for to, line in lines.items()
        if to[0] != MOTORS and not any(to[: len(path)] == path for path in own)
    }  # fmt: skip
    for to, line in lines.items():
        if to[:2] == at:
            below = to[2:]
            kept[below if below and below[0] in inside else ("motor", *below)] = line
    return MotorData(name, data, kept)
