# SPDX-License-Identifier: Apache-2.0
"""Keys of a scene: what each says of itself, and how names and values are written in messages."""

from __future__ import annotations

import difflib
import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, NoReturn

from pydantic import BaseModel, ConfigDict, Field
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from wavehaptics.runtime.toml_source import KeyPath
from wavehaptics.words import formats

# What the words of the RTL can hold, in whole units.
R_HAT_MAX_OHM = math.floor(formats.ROOT.largest**2 / 2)
VOLTAGE_MAX_V = math.floor(formats.VOLTAGE.largest)
CURRENT_MAX_A = math.floor(formats.CURRENT.largest)


class Table(BaseModel):
    """A table of a scene: immutable, and strict about names and types."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def scene_key(
    unit: str, meaning: str, default: Any = ..., *, default_text: str | None = None,
    range_text: str | None = None, **options: Any,
) -> Any:  # fmt: skip
    """A key of a table: its unit, meaning and default, and bounds as pydantic names them.

    The texts stand in the format's description where default and bounds don't say it.
    """
    texts: dict[str, Any] = {"unit": unit, "default": default_text, "range": range_text}
    return Field(default, description=meaning, json_schema_extra=texts, **options)


def broken_rule(problem: str, *keys: str | KeyPath) -> NoReturn:
    """Refuse values that are right one by one but don't go together.

    ``keys`` are those involved, below the model that is validated, the one to blame first.
    """
    paths = [(key,) if isinstance(key, str) else key for key in keys]
    raise PydanticCustomError("rule", "rule", {"problem": problem, "paths": paths})


def as_tuples(value: Any) -> Any:
    """Arrays of TOML, and arrays in them, as the tuples that a frozen table holds."""
    if isinstance(value, list):
        return tuple(tuple(pair) if isinstance(pair, list) else pair for pair in value)
    return value


class FieldTexts(NamedTuple):
    """What the format's description says of a key."""

    key: str
    unit: str
    default: str
    range: str
    meaning: str


def field_texts(table: type[BaseModel], name: str) -> FieldTexts:
    """Description of the field ``name`` of a table's model; the unit – stands for none."""
    info = table.model_fields[name]
    texts = info.json_schema_extra
    assert isinstance(texts, dict)
    return FieldTexts(
        key=info.alias or name,
        unit=str(texts["unit"]),
        default=str(texts["default"] or _default_text(info)),
        range=str(texts["range"] or _bounds_text(info)),
        meaning=info.description or "",
    )


def _default_text(info: FieldInfo) -> str:
    if info.is_required():
        return "required"
    if info.default is None:
        return "none"
    return as_written(info.default) if isinstance(info.default, bool) else as_number(info.default)


def _bounds_text(info: FieldInfo) -> str:
    if isinstance(info.default, bool):
        return "true, false"
    low = next(bound.ge for bound in info.metadata if hasattr(bound, "ge"))
    high = next(bound.le for bound in info.metadata if hasattr(bound, "le"))
    return f"{as_number(low)} to {as_number(high)}"


def as_number(value: float) -> str:
    """A number as a person writes it in TOML: ``1e-6``, ``4e6``, ``0.25``."""
    text = f"{value:.9g}"
    if zeros := re.fullmatch(r"(-?\d)(0{4,})", text):
        return f"{zeros[1]}e{len(zeros[2])}"
    if "e" not in text and value and value % 1e5 == 0:
        return f"{value / 1e6:.9g}e6"
    return re.sub(r"e([+-]?)0*(\d)", lambda m: f"e{m[1].strip('+')}{m[2]}", text)


def as_written(value: Any) -> str:
    """A refused value as it stands in TOML, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list | tuple):
        return "an array"
    if isinstance(value, int) and value.bit_length() > 64:
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, int | float):
        return repr(value)
    text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else f'{text[:56]}..."'


_ALSO_CALLED = {"bldc": "pmsm", "brushless": "pmsm", "ec": "pmsm", "brushed": "dc"}
"""What others call a known name."""


def nearest(name: str, known: Sequence[str] | Mapping[str, Any]) -> str | None:
    """The known name that ``name`` was most likely meant to be."""
    by_lower = {k.lower(): k for k in known}
    other = _ALSO_CALLED.get(name.lower())
    if other in known:
        return other
    near = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.6)
    if not near and name:
        near = [k for k in by_lower if k.startswith(f"{name.lower()}_")]
    return by_lower[near[0]] if near else None


def unknown_choice(name: str, known: Sequence[str] | Mapping[str, Any]) -> str:
    """End of a message about a name that none of ``known`` is."""
    near = nearest(name, known)
    meant = f'did you mean "{near}"? ' if near else ""
    return f"{as_written(name)} is unknown; {meant}known: {', '.join(known)}"
