# SPDX-License-Identifier: Apache-2.0
"""Messages for refused scenes: the problem, and the cure."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, Literal, NamedTuple, TypeVar, get_args, get_origin

from pydantic import ValidationError

from wavehaptics.runtime.toml_source import KeyPath, dotted
from wavehaptics.scene.device import MOTORS
from wavehaptics.scene.keys import (
    FieldTexts,
    Table,
    as_written,
    field_texts,
    nearest,
    unknown_choice,
)
from wavehaptics.scene.placed import Placed
from wavehaptics.scene.schema import TABLES, Scene
from wavehaptics.scene.space import SPACE_TABLES, Space
from wavehaptics.scene.tables.motor import DC_KEYS

# Spellings of units; all become one form before units are compared.
_UNIT_SPELLINGS = ((r"[·*.\s_^]", ""), ("²", "2"), (r"[Oo]hms?", "Ω"), ("\u2126", "Ω"))
_PREFIXES = {"p": -12, "n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3, "k": 3, "M": 6, "G": 9}
_OTHER_UNITS = {("gcm2", "kgm2"): -7, ("%", "–"): -2}
_QUANTITY = re.compile(r"\s*([-+]?)(\d+\.?\d*|\.\d+)(?:[eE]([-+]?\d{1,3}))?\s*(.*?)\s*")


def _plain_number(text: str, unit: str) -> str | None:
    """The number in ``unit`` that the string ``text`` means, as TOML; ``None`` if unclear."""
    quantity = _QUANTITY.fullmatch(text)
    if quantity is None:
        return None
    sign, digits, exponent, given = quantity.groups()
    wanted = unit
    for form, plain in _UNIT_SPELLINGS:
        given, wanted = re.sub(form, plain, given), re.sub(form, plain, wanted)
    if given in ("", wanted):
        shift = 0
    elif (given, wanted) in _OTHER_UNITS:
        shift = _OTHER_UNITS[given, wanted]
    elif given[0] in _PREFIXES and given[1:] == wanted:
        shift = _PREFIXES[given[0]]
    else:
        return None
    digits = f"0{digits}" if digits.startswith(".") else digits.removesuffix(".")
    power = int(exponent or 0) + shift
    return f"{sign}{digits}e{power}" if power else f"{sign}{digits}"


Tables = Mapping[str, type[Table]]
"""Model of each table of a file, by its name."""


def _below(path: KeyPath) -> KeyPath:
    """A path without the index into an array of tables."""
    return (path[0], *path[2:]) if len(path) > 1 and isinstance(path[1], int) else path


def _field(path: KeyPath, tables: Tables) -> FieldTexts | None:
    """Description of the key at or above ``path``; ``None`` if the schema has none."""
    path = _below(path)
    if len(path) < 2 or path[0] not in tables:
        return None
    table = tables[str(path[0])]
    for name, info in table.model_fields.items():
        if (info.alias or name) == path[1]:
            return field_texts(table, name)
    return None


def _choices(path: KeyPath, tables: Tables) -> tuple[str, ...]:
    """Values of a key that takes one of a few."""
    path = _below(path)
    kind = tables[str(path[0])].model_fields[str(path[1])].annotation
    return next(get_args(part) for part in (kind, *get_args(kind)) if get_origin(part) is Literal)


def keys_of(table: type[Table]) -> list[str]:
    return [info.alias or name for name, info in table.model_fields.items()]


def _unknown(path: KeyPath, value: Any, tables: Tables) -> str:
    """Message for a table or key that doesn't exist."""
    name = str(path[-1])
    homes = [f"[{table}]" for table, model in tables.items() if name in keys_of(model)]
    if len(path) == 1:
        names = ", ".join(f"[{table}]" for table in TABLES)
        if homes and not isinstance(value, dict):
            return f"key {dotted(path)} is outside the tables; it belongs in {' or '.join(homes)}"
        near = nearest(name, (*TABLES, MOTORS, *SPACE_TABLES))
        shown = f"[[{near}]]" if near in (MOTORS, "surface") else f"[{near}]"
        meant = f"did you mean {shown}? " if near else ""
        kind = "table [{}]" if isinstance(value, dict | list) else "key {} outside the tables"
        return (
            f"unknown {kind.format(dotted(path))}; {meant}the tables are {names}, [[motors]], "
            "[device], [[surface]], [coupling]"
        )
    table = str(path[0])
    known = keys_of(tables[table])
    near = nearest(name, known)
    if near:
        meant = f"did you mean {near}? "
    elif homes:
        meant = f"it belongs in {' or '.join(homes)}; "
    else:
        meant = ""
    return f"unknown key {dotted(path)}; {meant}[{table}] takes {', '.join(known)}"


def _missing(path: KeyPath, tables: Tables) -> str:
    if path == ("device",):
        return (
            "[device] is missing, [[surface]] and [coupling] need it; give it with its kinematics"
        )
    if len(path) == 1:
        needed = "[scene], [motor] or [[motors]], and [controller]"
        return f"table [{path[0]}] is missing; a scene needs {needed}"
    if path[0] == "motor":
        return f"{dotted(path)} is missing; give preset, or all of {', '.join(DC_KEYS)}"
    texts = _field(path, tables)
    assert texts is not None
    return f"{dotted(path)} is missing; give {_wanted(texts)}"


def _wanted(texts: FieldTexts) -> str:
    """The range of a key with its unit, for the end of a message."""
    plain = re.fullmatch(r"\S+ to \S+", texts.range) and texts.unit != "–"
    return f"{texts.range} {texts.unit}" if plain else texts.range


def _wrong_value(kind: str, path: KeyPath, value: Any, tables: Tables) -> str:
    """Message for one invalid value; ``kind`` is pydantic's type of the error."""
    name, texts = dotted(path), _field(path, tables)
    assert texts is not None
    shown, wanted = as_written(value), _wanted(texts)
    unit = "" if texts.unit == "–" else f" in {texts.unit}"
    if path[:2] == ("controller", "walls") and len(path) <= 3:
        return f"{name} must hold pairs of numbers{unit}; write walls = [[x_min, x_max]]"
    if kind == "literal_error" and isinstance(value, str):
        return f"{name} {unknown_choice(value, _choices(path, tables))}"
    if kind in ("string_type", "literal_error"):
        return f"{name} must be a string in quotes, not {shown}; use {texts.range}"
    if kind == "finite_number":
        return f"{name} must be a finite number{unit}, not {shown}; use {wanted}"
    if kind in ("float_type", "int_type"):
        what = "a whole number" if kind == "int_type" else f"a number{unit}"
        if isinstance(value, str):
            plain = _plain_number(value, texts.unit)
            right = f"write {plain}" if plain else f"write the number alone, {wanted}"
            return f"{name} must be {what}, not the string {shown}; {right}"
        whole = isinstance(value, float) and value.is_integer() and abs(value) < 2**53
        right = f"write {int(value)}" if whole else f"use {wanted}"
        return f"{name} must be {what}, not {shown}; {right}"
    return f"{name} = {shown} is out of range; it must be {wanted}"


class Refusal(NamedTuple):
    """One problem, and the keys that it concerns, the most likely cause first."""

    problem: str
    paths: list[KeyPath]
    missing: bool = False


def refused(data: dict[str, Any]) -> tuple[Scene | None, list[Refusal]]:
    """The scene, or all its problems."""
    return _validated(Scene, data, TABLES)


def refused_space(data: dict[str, Any]) -> tuple[Space | None, list[Refusal]]:
    """The device with its surfaces and hand, or all their problems."""
    return _validated(Space, data, SPACE_TABLES)


_Model = TypeVar("_Model", bound=Placed)


def _validated(
    model: type[_Model], data: dict[str, Any], tables: Tables
) -> tuple[_Model | None, list[Refusal]]:
    try:
        return model.model_validate(data), []
    except ValidationError as error:
        return None, list(_explain(error, tables))


def _explain(error: ValidationError, tables: Tables) -> Iterator[Refusal]:
    for detail in error.errors(include_url=False):
        path, kind, value = detail["loc"], detail["type"], detail["input"]
        if kind == "rule":
            rule = detail["ctx"]
            of_which = f"{dotted(path)}." if _below(path) != path else ""
            yield Refusal(of_which + rule["problem"], [(*path, *below) for below in rule["paths"]])
        elif kind == "extra_forbidden":
            yield Refusal(_unknown(_below(path), value, tables), [path])
        elif kind == "missing" and len(_below(path)) <= 2:
            blamed = path if path != ("device",) else ("surface",)
            yield Refusal(_missing(path, tables), [blamed], missing=True)
        elif kind == "missing":  # one edge of a wall, one of three numbers
            yield Refusal(_wrong_value(kind, path[:-1], value, tables), [path[:-1]])
        elif kind == "tuple_type" and path == ("surface",):
            yield Refusal(
                f"surface must be tables, not {as_written(value)}; write [[surface]] above the "
                "keys of each", [path],
            )  # fmt: skip
        elif kind == "model_type":
            name = dotted(path)
            wanted = f"write [[{path[0]}]] above its keys"
            if len(path) == 1:
                wanted = f"write [{name}] above its keys"
            if path == ("motor",) and isinstance(value, list):
                wanted = "write [[motors]] above the keys of each of several"
            yield Refusal(f"{name} must be a table, not {as_written(value)}; {wanted}", [path])
        else:
            yield Refusal(_wrong_value(kind, path, value, tables), [path])
