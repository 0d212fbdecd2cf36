# SPDX-License-Identifier: Apache-2.0
"""What is written of the table of words: its page, and headers of the RTL; and its sine."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from wavehaptics.controller import rotor_flux
from wavehaptics.words.generated import PAGE_HEAD, guard_fields, page_rows, settings_rom
from wavehaptics.words.table import crc

from wavetools.pages.c_header import c_words


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
