# SPDX-License-Identifier: Apache-2.0
"""The table of words, ``rtl/words.toml``: what the controller is told, and what it tells.

It is the one place where a setting, a command or a live value is declared. The file says how it is
written; here it is checked, and its words are packed into the ports of ``rtl/wh_controller.v``.
"""

from __future__ import annotations

import json
import math
import re
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from wavehaptics.runtime.repository import RTL_DIR
from wavehaptics.runtime.toml_source import TomlError, parse
from wavehaptics.words import formats
from wavehaptics.words.formats import Fixed

TABLE = RTL_DIR / "words.toml"

MOST = {"board": 1, "motor": 1, "wall": 16, "section": 2}
"""Most copies of a word that one motor has."""

MOTOR_STRIDE = 0x100
"""Addresses from a motor's words to the next one's, which begin here."""

MEMORY = "wh_registers"
"""Block of the words that are the settings memory's own, and no port of the controller."""

BESIDE = ("wh_arm", "wh_capture", "wh_device", "wh_stream", "wh_surface_frame")
"""Blocks beside the controller, whose words are no ports of it either."""

CHANGES = ("off", "core", "scale", "anchor", "sum", "round", "any")
"""When a group's settings may change: with the bridges off, between two of these, or always."""

LEGS, THREE_PHASE_LEGS = 2, 3
"""Half bridges of a motor with brushes, and of a brushless one."""

AXES = 2
"""Axes of a brushless motor, and phases whose current is measured: so many ports it has."""

ACCESS = {"setting": "read, write", "command": "write", "live": "read"}

_FORMAT = re.compile(r"([us])(\d+|[A-Z][A-Z0-9_]*)(?:q(\d+|[A-Z][A-Z0-9_]*))?")


class TableError(ValueError):
    """A table that can't be read. The message is one line: file, line, what would be right."""


@dataclass(frozen=True)
class Sizes:
    """Hardware: how many copies of a word there are, and how wide the delay line counts."""

    motors: int = 1
    walls: int = 4
    sections: int = 0
    delay_log2: int = 2
    legs: int = LEGS

    def copies(self, word: Word) -> int:
        """Copies of a word in its port, which is never empty."""
        each = {"wall": self.walls, "section": max(1, self.sections)}.get(word.row.per, 1)
        return each * len(word.port_numbers(self.motors, self.legs))


class _Row(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    kind: Literal["setting", "command", "live"] = "setting"
    per: Literal["board", "motor", "wall", "section"] = "board"
    count: int = Field(1, ge=1)
    format: str
    unit: str = ""
    range: tuple[float, float] = Field((-math.inf, math.inf), strict=False)
    default: float = 0
    port: str = ""
    off: bool = False
    brushless: Literal["none", "one", "two", "only"] = "one"
    meaning: str = Field(min_length=1)


@dataclass(frozen=True)
class Word:
    """A row of the table, with its place. ``fixed`` is its format with a delay line of 2² steps."""

    name: str
    block: str
    group: str
    address: int
    row: _Row
    fixed: Fixed
    change: str = CHANGES[0]

    @property
    def port(self) -> str:
        """Its port of ``wh_controller``."""
        return self.row.port or f"{self.name}_{'o' if self.row.kind == 'live' else 'i'}"

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest value, in the word's unit."""
        low, high = self.row.range
        fixed = self.fixed
        return max(low, fixed.to_value(fixed.raw_min)), min(high, fixed.largest)

    @property
    def default(self) -> int:
        """The word where nothing says otherwise."""
        return self.fixed.to_raw(self.row.default)

    def port_numbers(self, motors: int, legs: int = LEGS) -> Sequence[int]:
        """Ports that have the word; one of the board, none without it.

        A brushless motor has two ports, its axes. The first one has the words of both.
        """
        each = AXES if legs == THREE_PHASE_LEGS else 1
        if self.row.brushless == ("none" if each == AXES else "only"):
            return range(0)
        if self.row.per == "board":
            return range(1)
        return range(0, each * motors, 1 if self.row.brushless == "two" else each)

    def width(self, sizes: Sizes) -> int:
        """Bits of one word."""
        return sizes.delay_log2 if "DELAY_LOG2" in self.row.format else self.fixed.width

    def at(self, motor: int = 0, index: int = 0) -> int:
        """Address of a word; ``index`` counts the motor's walls, or its sections' words."""
        if not 0 <= index < MOST[self.row.per] * self.row.count:
            raise IndexError(f"{self.name} has no word {index}")
        return self.address + index + (0 if self.row.per == "board" else motor * MOTOR_STRIDE)


def _number(text: str) -> int:
    known = {**formats.HEADER_VALUES, "DELAY_LOG2": Sizes.delay_log2}
    return int(text) if text.isdigit() else known[text]


def format_parts(text: str) -> tuple[str, str, str]:
    """``u`` or ``s``, the bits and those of the fraction of a format, as the table names them."""
    found = _FORMAT.fullmatch(text)
    if found is None:
        raise ValueError(f'format = "{text}" is not like u8, s24 or sCOEF_WqROOT_Q')
    return found[1], found[2], found[3] or "0"


def _fixed(text: str) -> Fixed:
    sign, width, fraction = format_parts(text)
    try:
        return Fixed(_number(width), _number(fraction), sign == "s")
    except KeyError as error:
        raise ValueError(f'format = "{text}": there is no WH_{error.args[0]}') from None


def _word(name: str, block: str, group: str, address: int, row: Any, change: str) -> Word:
    try:
        checked = _Row.model_validate(row)
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(": ".join([*map(str, first["loc"]), first["msg"]])) from None
    word = Word(name, block, group, address, checked, _fixed(checked.format), change)
    if word.fixed.width > 32:
        raise ValueError(f"a word has at most 32 bits, not {word.fixed.width}")
    low, high = word.range
    for bound in checked.range:
        if math.isfinite(bound) and not low <= bound <= high:
            raise ValueError(f"range {bound:g} is outside the format's {low:g}...{high:g}")
    if not low <= checked.default <= high:
        raise ValueError(f"default {checked.default:g} is outside {low:g}...{high:g}")
    if not re.fullmatch(rf"\w+_{'[io]' if checked.kind == 'live' else 'i'}", word.port):
        raise ValueError(f'port = "{word.port}" is none of a {checked.kind}')
    return word


def read(path: Path = TABLE) -> dict[str, Word]:
    """The words by their names, in the order of the file. :class:`TableError` in one line."""
    try:
        blocks, lines = parse(path.read_bytes())
    except TomlError as error:
        raise TableError(f"{path}:{error.line}: {error.problem}") from None
    words: dict[str, Word] = {}
    taken: dict[int, str] = {}
    pers: dict[str, str] = {}
    for block, groups in blocks.items():
        for group, rows in groups.items():
            place: tuple[str, ...] = (block, group)
            try:
                address = rows.pop("address")
                if not isinstance(address, int):
                    raise ValueError(f"address = {address!r} is not a number")
                change = rows.pop("change", CHANGES[0])
                if change not in CHANGES:
                    raise ValueError(f"change = {change!r} is none of {', '.join(CHANGES)}")
                for name, row in rows.items():
                    place = (block, group, name)
                    if name in words:
                        raise ValueError(f"there is a {name} in {words[name].block} already")
                    words[name] = word = _word(name, block, group, address, row, change)
                    per = pers.setdefault(word.port, word.row.per)
                    if per != word.row.per:
                        raise ValueError(f"{word.port} has words per {per} and per {word.row.per}")
                    if word.row.per != "motor" and word.row.brushless == "two":
                        raise ValueError("a brushless motor has two of what is a motor's only")
                    _take(taken, word)
                    address += MOST[word.row.per] * word.row.count
            except KeyError:
                problem = f"[{block}.{group}] has no address"
                raise TableError(f"{path}:{lines[place]}: {problem}") from None
            except ValueError as error:
                raise TableError(f"{path}:{lines[place]}: {'.'.join(place)}: {error}") from None
    return words


def _take(taken: dict[int, str], word: Word) -> None:
    """Give the word its addresses, of which nobody else has one."""
    first = 0 if word.row.per == "board" else MOTOR_STRIDE
    for index in range(MOST[word.row.per] * word.row.count):
        at = word.at(index=index)
        if not first <= at < first + MOTOR_STRIDE:
            span = f"0x{first:03x}...0x{first + MOTOR_STRIDE - 1:03x}"
            raise ValueError(f"address 0x{at:03x} is outside {span}, for words a {word.row.per}")
        if at in taken:
            raise ValueError(f"address 0x{at:03x} is that of {taken[at]}")
        taken[at] = word.name


WORDS = read()


def crc(words: Mapping[str, Word] = WORDS) -> int:
    """CRC-32 of all that two sides have to agree on: everything but default, port and meaning."""
    told = [
        [word.address, word.name, word.row.kind, word.row.per, word.row.count,
         word.fixed.width, word.fixed.fraction, word.fixed.signed, word.row.unit, word.range,
         word.row.brushless]
        for word in sorted(words.values(), key=lambda word: word.address)
    ]  # fmt: skip
    return zlib.crc32(json.dumps(told).encode())


# ---- Words side by side.

Values = Mapping[str, int | Sequence[int]]
"""Raw words by name: one for all copies, or one for each, those of the first motor first. A name of
a port of several words, without ``_i``, gives each copy's words side by side."""


def ports(
    direction: Literal["i", "o"] = "i", words: Mapping[str, Word] = WORDS, *, beside: bool = False,
    legs: int | None = LEGS,
) -> dict[str, list[Word]]:  # fmt: skip
    """The table's inputs or outputs of the controller, without ``_i`` or ``_o``: their words.

    With three ``legs`` those of a brushless motor; None: what any motor has. ``beside``:
    those of the blocks beside it instead.
    """
    found: dict[str, list[Word]] = {}
    for word in words.values():
        there = word.block != MEMORY and (word.block in BESIDE) == beside
        there = there and (legs is None or bool(word.port_numbers(1, legs)))
        if there and word.port.endswith(direction):
            found.setdefault(word.port[:-2], []).append(word)
    return found


def port_width(words: Iterable[Word], sizes: Sizes) -> int:
    """Bits of a port with these words."""
    return sum(sizes.copies(w) * w.row.count * w.width(sizes) for w in words)


def fields(values: Values, sizes: Sizes) -> dict[str, list[tuple[int, int]]]:
    """(word, bits) of everything in each input port, the lowest first; defaults where not given.

    Values of words that a motor with so many legs hasn't are left out. ``ValueError`` for one that
    its word can't hold, or that no word is for.
    """
    inputs, all_inputs = ports(legs=sizes.legs), ports(legs=None)
    known = {*all_inputs, *(word.name for words in all_inputs.values() for word in words)}
    if unknown := sorted(set(values) - known):
        raise ValueError(f"{TABLE}: there is no setting {unknown[0]}")
    result: dict[str, list[tuple[int, int]]] = {}
    for port, words in inputs.items():
        copies = sizes.copies(words[0])
        result[port] = found = []
        if port in values and (len(words) > 1 or words[0].name != port):
            width = port_width(words, sizes) // copies
            found += [(raw, width) for raw in _each(port, values[port], copies)]
            continue
        each = [
            _each(word.name, values.get(word.name, word.default), copies * word.row.count)
            for word in words
        ]
        for copy in range(copies):
            for word, raws in zip(words, each, strict=True):
                first = copy * word.row.count
                width = word.width(sizes)
                for raw in raws[first : first + word.row.count]:
                    if not Fixed(width, 0, word.fixed.signed).holds(raw):
                        raise ValueError(f"{word.name} = {raw} doesn't fit {word.row.format}")
                    found.append((raw, width))
    return result


def _each(name: str, value: int | Sequence[int], copies: int) -> list[int]:
    raws = [int(raw) for raw in value] if isinstance(value, Iterable) else [int(value)] * copies
    if len(raws) != copies:
        raise ValueError(f"{name} has {copies} words, not {len(raws)}")
    return raws


def side_by_side(found: Iterable[tuple[int, int]]) -> int:
    """(word, bits) side by side, the first lowest."""
    total = place = 0
    for raw, width in found:
        total |= (raw & ((1 << width) - 1)) << place
        place += width
    return total


def inputs(values: Values, sizes: Sizes) -> dict[str, int]:
    """Every input port of the table as one word: ``{"half_clocks_i": 48, ...}``."""
    return {f"{port}_i": side_by_side(found) for port, found in fields(values, sizes).items()}
