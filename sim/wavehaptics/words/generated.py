# SPDX-License-Identifier: Apache-2.0
"""What is made of the table of words: Verilog connections, the C++ of the shims, rows of a page."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from wavehaptics.words import table
from wavehaptics.words.table import ACCESS, MOST, Sizes, Values, Word

LICENCE = "// SPDX-License-Identifier: Apache-2.0\n"


def _literal(raw: int, width: int) -> str:
    return f"{width}'h{raw & ((1 << width) - 1):x}"


def _concatenation(found: list[tuple[int, int]]) -> str:
    """Words of a port in Verilog, the first lowest, which stands last."""
    return "{" + ", ".join(_literal(raw, width) for raw, width in reversed(found)) + "}"


def _range(width: int) -> str:
    return f" [{width - 1}:0]" if width > 1 else ""


def _macro(name: str, lines: Iterable[str]) -> str:
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
    outputs = table.ports("o")
    for port, words in outputs.items():
        wires.append(f"wire{_range(table.port_width(words, sizes))} {port};")
        ports.append(f".{port}_o ({port}),")
    wires.append(f"wire unused_words = &{{1'b0, {', '.join(outputs)}}};")
    return _macro(f"{prefix}_WIRES", wires) + "\n" + _macro(f"{prefix}_PORTS", ports)


# ---- C++.


def chunks(values: Values, sizes: Sizes) -> list[int]:
    """Every input port of the table in turn, each in as many words of 32 bits as it takes."""
    result = []
    for found in table.fields(values, sizes).values():
        raw, width = table.side_by_side(found), sum(bits for _, bits in found)
        result += [raw >> place & 0xFFFFFFFF for place in range(0, width, 32)]
    return result


def shim_header(sizes: Sizes) -> str:
    """``words.h``, with which a shim gives a top level what :func:`chunks` has for it.

    A top level may have some of the table's ports only.
    """
    lines, place = [], 0
    for port, words in table.ports().items():
        lines.append(
            f"    if constexpr (requires {{ top.{port}_i; }}) give(top.{port}_i, words + {place});"
        )
        place += -(-table.port_width(words, sizes) // 32)
    return (
        LICENCE + "// Made from rtl/words.toml, to be included after give.h.\n\n#pragma once\n\n"
        "template <class Top>\nvoid give_words(Top &top, const uint32_t *words) {\n"
        + "\n".join(lines)
        + "\n}\n"
    )


# ---- For people.


def guard_fields() -> str:
    """Lines of ``rtl/wh_faults.vh`` that say where in its settings the guard finds a field."""
    lines, low = [], 0
    for word in table.ports()["guard"]:
        high = low + word.fixed.width - 1
        macro = f"`define WH_{word.name.upper()}".ljust(28)
        what = f"{_format(word)} {word.row.unit}".strip()
        lines.append(f"{macro} {f'{high}:{low}':<8} // {what}, {word.row.meaning}\n")
        low = high + 1
    return "".join([f"{'`define WH_GUARD_W':<28} {low}\n", *lines])


def _format(word: Word) -> str:
    fraction = f"q{word.fixed.fraction}" if word.fixed.fraction else ""
    return f"{'s' if word.fixed.signed else 'u'}{word.fixed.width}{fraction}"


def _span(word: Word) -> str:
    """Addresses of a word's copies in one motor."""
    last = MOST[word.row.per] * word.row.count - 1
    return f"`{word.at():03x}`" + (f"…`{word.at(index=last):03x}`" if last else "")


def page_rows() -> list[tuple[str, ...]]:
    """A row of the page for each word, in the order of their addresses."""
    rows: list[tuple[str, ...]] = []
    for word in sorted(table.WORDS.values(), key=Word.at):
        digits = 6 if word.fixed.fraction else 10
        low, high = (f"{bound:.{digits}g}" for bound in word.range)
        width = _format(word) if word.row.format != "uDELAY_LOG2" else "u`DELAY_LOG2`"
        rows.append(
            (
                _span(word), f"`{word.name}`", f"`{word.block}`", word.group, word.row.per,
                ACCESS[word.row.kind] + (", strobe" if word.row.kind == "command" else ""),
                width, word.row.unit, f"{low}…{high}", f"{word.row.default:g}", word.row.meaning,
            )
        )  # fmt: skip
    return rows


PAGE_HEAD = (
    "Address", "Word", "Block", "Group", "Per", "Access", "Format", "Unit", "Range", "Default",
    "Meaning",
)  # fmt: skip
