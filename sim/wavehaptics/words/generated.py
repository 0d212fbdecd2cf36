# SPDX-License-Identifier: Apache-2.0
"""What is made of the register map: Verilog connections and the C++ of the shims."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Collection, Iterable, Mapping

from wavehaptics.words import formats, table
from wavehaptics.words.table import Sizes, Values, Word

LICENCE = "// SPDX-License-Identifier: Apache-2.0\n"


def _literal(raw: int, width: int) -> str:
    return f"{width}'h{raw & ((1 << width) - 1):x}"


def _concatenation(found: list[tuple[int, int]]) -> str:
    """Words of a port in Verilog, the first lowest, which stands last."""
    return "{" + ", ".join(_literal(raw, width) for raw, width in reversed(found)) + "}"


def _range(width: int) -> str:
    return f" [{width - 1}:0]" if width > 1 else ""


def macro(name: str, lines: Iterable[str]) -> str:
    """A macro of Verilog, of no or more lines."""
    return " \\\n    ".join([f"`define {name}", *lines]) + "\n"


def connections(
    prefix: str, sizes: Sizes, values: Values | None, driven: Collection[str] = ()
) -> str:
    """Verilog macros that connect a ``wh_controller`` to every word of the table.

    ``<prefix>_WIRES`` declares a wire for each output, by its port's name without ``_o``;
    ``<prefix>_PORTS`` are the connections, each with a comma behind it. Inputs get the constants
    that ``values`` say; without them they get registers with their names, which begin with the
    defaults. ``driven`` are inputs, without ``_i``, that the module connects itself.
    """
    wires, ports = [], []
    for port, found in table.fields(values or {}, sizes).items():
        if port in driven:
            continue
        given = _concatenation(found)
        if values is None:
            width = sum(bits for _, bits in found)
            wires.append(f"reg{_range(width)} {port}_i = {given};")
            given = f"{port}_i"
        ports.append(f".{port}_i ({given}),")
    outputs = table.ports("o", legs=sizes.legs)
    for port, words in outputs.items():
        wires.append(f"wire{_range(table.port_width(words, sizes))} {port};")
        ports.append(f".{port}_o ({port}),")
    wires.append(f"wire unused_words = &{{1'b0, {', '.join(outputs)}}};")
    return macro(f"{prefix}_WIRES", wires) + "\n" + macro(f"{prefix}_PORTS", ports)


# ---- The settings memory.

_KINDS = {"setting": 1, "command": 2, "live": 3}
_OF_MOTORS = {"none": "2'b01", "one": "2'b11", "two": "2'b11", "only": "2'b10"}
"""By the row: whether motors with brushes have it (low bit), and brushless ones."""
_SIGNED_TYPES = 20
_TYPES = 32
"""As ``rtl/wh_settings_rom.v`` has them: ranges of words with a sign come last."""


def verilog_number(text: str) -> str:
    """A number of a format in Verilog, which follows a width that a tool has set."""
    if text.isdigit() or text == "DELAY_LOG2":
        return text
    fixed = not any(re.search(rf"\b{name}\b", text) for name in _free_widths())
    return str(formats.HEADER_VALUES[text]) if fixed else f"`WH_{text}"


@functools.cache
def _free_widths() -> set[str]:
    """Macros, without ``WH_``, that a tool may set, or that follow from one of these."""
    found = set(formats.SETTABLE)
    text = formats.HEADER.read_text(encoding="utf-8")
    for name, meaning in re.findall(r"^\s*`define\s+WH_(\w+)\s+(.+)$", text, re.MULTILINE):
        if any(f"`WH_{known}" in re.sub(r"//.*", "", meaning) for known in found):
            found.add(name)
    return found


def _scaled(value: float, fraction: str) -> str:
    """A value as a word of 32 bits in Verilog."""
    if fraction == "0" or value == 0:
        if value != int(value):
            raise ValueError(f"{value:g} is no whole number")
        return f"{'-' if value < 0 else ''}32'd{abs(int(value))}"
    if value != int(value):
        raise ValueError(f"{value:g} is no whole number")
    return f"({'-' if value < 0 else ''}32'd{abs(int(value))} << {fraction})"


def _bounds(word: Word, given: tuple[float, float] | None = None) -> tuple[bool, str, str]:
    """Whether a word has a sign, and its least and greatest word in Verilog, as in the ROM.

    ``given`` is a range in place of the table's.
    """
    _, width, fraction = table.format_parts(word.row.format)
    bits, places = verilog_number(width), verilog_number(fraction)
    low, high = given or word.row.range
    if not word.fixed.signed:
        least = "32'd0" if math.isinf(low) else _scaled(low, places)
        most = f"(32'hffffffff >> (32 - {bits}))" if math.isinf(high) else _scaled(high, places)
        return False, least, most
    least = f"(32'd0 - (32'd1 << ({bits} - 1)))" if math.isinf(low) else _scaled(low, places)
    most = f"((32'd1 << ({bits} - 1)) - 32'd1)" if math.isinf(high) else _scaled(high, places)
    return True, f"(32'h80000000 + {least})", f"(32'h80000000 + {most})"


def _copies(word: Word) -> str:
    """Words of a row in one part of the memory, in Verilog."""
    each = {"wall": "WALLS", "section": "SHAPER"}.get(word.row.per, "")
    if not each:
        return str(word.row.count)
    return each if word.row.count == 1 else f"{word.row.count} * {each}"


def settings_rom(
    values: Values | None = None, groups: Collection[str] | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> str:  # fmt: skip
    """``rtl/wh_settings_rom.vh``: what the settings memory knows of each word.

    ``values`` are the words that stand there at first, where those of the table don't: one number
    for all copies of a word, or one for each of the first copies of a motor. Of ``groups``, by
    default all, words can be written; those of others (``block.group``) are read only, but for
    words that have one of ``ranges``, which is theirs.
    """
    ranges = ranges or {}
    types: dict[tuple[bool, str, str], int] = {}
    rows = []
    for word in table.WORDS.values():
        bounds = _bounds(word, ranges.get(word.name))
        is_setting = word.row.kind == "setting"
        named = word.name in ranges or f"{word.block}.{word.group}" in (groups or ())
        fixed = is_setting and groups is not None and not named
        # Of a word that nobody writes only the sign counts.
        if word.row.kind != "live" and bounds not in types and (bounds[0] or not fixed):
            signed = sum(known[0] for known in types)
            kind = _SIGNED_TYPES + signed if bounds[0] else len(types) - signed
            if kind >= (_TYPES if bounds[0] else _SIGNED_TYPES):
                raise ValueError(
                    f"{word.name}: the ROM of the settings memory has no room for its range"
                )
            types[bounds] = kind
        info = _KINDS["live" if fixed else word.row.kind] << 6 | types.get(bounds, 0)
        if fixed or (is_setting and word.change == "off") or word.row.off:
            info |= 1 << 5
        text = f"8'h{info:02x}"
        place = f"'h{word.at():03x}, {_copies(word)}"
        text = f"{_OF_MOTORS[word.row.brushless]}, {text}"
        if not is_setting:
            rows.append(f"`WH_SETTINGS_TOLD({place}, {text})  // {word.name}\n")
            continue
        given = (values or {}).get(word.name)
        if given is None:
            first = _scaled(
                word.row.default, verilog_number(table.format_parts(word.row.format)[2])
            )
        elif isinstance(given, int):
            first = _word(given)
        else:
            first = "0"
        rows.append(f"`WH_SETTINGS_WORD({place}, {text}, {first})  // {word.name}\n")
        if isinstance(given, Iterable):
            rows += [
                f"`WH_SETTINGS_WORD('h{word.at(index=index):03x}, 1, {text}, {_word(raw)})\n"
                for index, raw in enumerate(given)
            ]
    for (_, least, most), kind in types.items():
        rows.append(f"`WH_SETTINGS_BOUNDS({kind}, {least}, {most})\n")
    return "".join(rows)


def _word(raw: int) -> str:
    return f"32'h{raw & 0xFFFFFFFF:08x}"


# ---- C++.


def chunks(values: Values, sizes: Sizes) -> list[int]:
    """Every input port of the table in turn, each in as many words of 32 bits as it takes."""
    return [part for found in table.fields(values, sizes).values() for part in in_chunks(found)]


def in_chunks(found: list[tuple[int, int]]) -> list[int]:
    """(word, bits) side by side, in as many words of 32 bits as they take."""
    raw, width = table.side_by_side(found), sum(bits for _, bits in found)
    return [raw >> place & 0xFFFFFFFF for place in range(0, width, 32)]


def shim_header(sizes: Sizes) -> str:
    """``words.h``, with which a shim gives a top level what :func:`chunks` has for it.

    A top level may have some of the table's ports only.
    """
    lines, place = [], 0
    for port, words in table.ports(legs=sizes.legs).items():
        lines.append(
            f"    if constexpr (requires {{ top.{port}_i; }}) give(top.{port}_i, words + {place});"
        )
        place += -(-table.port_width(words, sizes) // 32)
    return (
        LICENCE + "// Made from rtl/words.toml, to be included after give.h.\n\n#pragma once\n\n"
        f"#define WH_MOTORS {sizes.motors}\n#define WH_LEGS {sizes.legs}\n\n"
        "template <class Top>\nvoid give_words(Top &top, const uint32_t *words) {\n"
        + "\n".join(lines)
        + "\n}\n"
    )
