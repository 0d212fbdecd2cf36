# SPDX-License-Identifier: Apache-2.0
"""What is written of the register map: its page, and headers of the RTL; and its sine."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from wavehaptics.controller import rotor_flux
from wavehaptics.words import table as words
from wavehaptics.words.generated import settings_rom
from wavehaptics.words.table import ACCESS, MOST, Word, crc

from wavetools.pages.c_header import c_words

PAGE_HEAD = (
    "Address", "Register", "Block", "Group", "Per", "Access", "Change", "Format", "Unit", "Range",
    "Default", "Brushless", "Meaning",
)  # fmt: skip


def guard_fields() -> str:
    """Lines of ``rtl/wh_faults.vh`` that say where in its settings the guard finds a field."""
    lines, low = [], 0
    for word in words.ports()["guard"]:
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
    for word in sorted(words.WORDS.values(), key=Word.at):
        digits = 6 if word.fixed.fraction else 10
        low, high = (f"{bound:.{digits}g}" for bound in word.range)
        width = _format(word) if word.row.format != "uDELAY_LOG2" else "u`DELAY_LOG2`"
        rows.append(
            (
                _span(word), f"`{word.name}`", f"`{word.block}`", word.group, word.row.per,
                ACCESS[word.row.kind] + (", strobe" if word.row.kind == "command" else ""),
                word.change if word.row.kind == "setting" else "off" if word.row.off else "",
                width, word.row.unit, f"{low}…{high}", f"{word.row.default:g}",
                word.row.brushless, word.row.meaning,
            )
        )  # fmt: skip
    return rows


def _words(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    rows = [PAGE_HEAD, ["---"] * len(PAGE_HEAD), *page_rows()]
    lines = [f"| {' | '.join(cell.replace('|', '&#124;') for cell in row)} |" for row in rows]
    return (
        "\n".join([*lines, "", f"{len(page_rows())} registers; CRC-32 of the map: `{crc():08x}`."])
        + "\n"
    )


def _guard_fields(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    # The marker that follows stands in a comment.
    return guard_fields() + "// "


def _settings_rom(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    return settings_rom() + "// "


def _sine_table(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    words = enumerate(rotor_flux.sine_table().tolist())
    return "".join(f"`WH_SINE({index}, {word})\n" for index, word in words) + "// "


def _words_crc(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    return f"`define WH_WORDS_CRC 32'h{crc():08x}\n// "


def _c_words(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    return c_words() + "// "


TABLES = {
    "words": _words,
    "guard-fields": _guard_fields,
    "settings-rom": _settings_rom,
    "sine-table": _sine_table,
    "words-crc": _words_crc,
    "c-words": _c_words,
}
"""Texts by marker, made with the given function of head and rows, which these do without."""
