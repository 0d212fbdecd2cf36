# SPDX-License-Identifier: Apache-2.0
"""What ``sim/c/wavehaptics_words.h`` has of the table of words, and of the registers it is read by.

Lists are macros that take a macro, a row each: C makes an enumeration and a table of one of them.
"""

from __future__ import annotations

from collections.abc import Iterable

from wavehaptics.words import modbus, table
from wavehaptics.words.faults import ARM_REFUSALS, FAULTS
from wavehaptics.words.table import MEMORY, Word

BY_DELAY = "WH_BY_DELAY"
"""The greatest value of a word that counts a delay line, which a device tells."""


def _list(name: str, rows: Iterable[Iterable[object]]) -> str:
    lines = [f"    X({', '.join(str(value) for value in row)})" for row in rows]
    return " \\\n".join([f"#define {name}(X)", *lines]) + "\n"


def _text(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _row(word: Word) -> tuple[object, ...]:
    low, high = word.range
    kind = "MEMORY" if word.block == MEMORY and word.row.kind != "live" else word.row.kind.upper()
    return (
        word.name.upper(), _text(word.name), f"0x{word.at():03x}", f"WH_{kind}",
        f"WH_OF_{word.row.per.upper()}", word.row.count, word.fixed.fraction,
        int(word.fixed.signed), repr(float(low)),
        BY_DELAY if "DELAY_LOG2" in word.row.format else repr(float(high)), _text(word.row.unit),
    )  # fmt: skip


def c_words() -> str:
    """The lists: words, faults, reasons, exceptions, options, and where a device has them."""
    parts = [
        f"#define WH_WORDS_CRC 0x{table.crc():08x}u\n",
        f"#define WH_MAP_VERSION {modbus.MAP_VERSION}u\n"
        f"#define WH_TABLE_REGISTER 0x{modbus.TABLE:04x}u\n"
        f"#define WH_MOTOR_STRIDE 0x{table.MOTOR_STRIDE:03x}u\n"
        f"#define WH_MOST_READ {modbus.MOST_READ}u\n"
        f"#define WH_BRUSHLESS_SHAPER {modbus.BRUSHLESS_SHAPER}u\n"
        f"#define WH_AXES {table.AXES}u\n",
        "// Words of the identification, from register 0 on.\n"
        + _list("WH_IDENTIFICATION", ((name.upper(),) for name in modbus.IDENTIFICATION)),
        "// Of its word `options`: name, lowest bit, bits.\n"
        + _list("WH_OPTIONS", ((name, *place) for name, place in modbus.OPTIONS.items())),
        "// Bits a second by the word `rate`.\n"
        + _list("WH_RATES", ((rate,) for rate in modbus.BAUDS)),
        "// NAME, name, address, kind, of what, words of one, places of the fraction, has a sign,\n"
        "// least and greatest value, unit.\n"
        + _list("WH_WORDS", map(_row, sorted(table.WORDS.values(), key=Word.at))),
        "// Bits of the word `faults`: bit, NAME, meaning.\n"
        + _list("WH_FAULTS", ((bit, name, _text(what)) for bit, (name, what) in FAULTS.items())),
        "// Bits of the word `arm_refused`.\n"
        + _list("WH_ARM_REFUSALS", ((bit, _text(what)) for bit, what in enumerate(ARM_REFUSALS))),
        "// Exceptions of Modbus.\n"
        + _list("WH_EXCEPTIONS", ((n, _text(what)) for n, what in modbus.EXCEPTIONS.items())),
    ]  # fmt: skip
    return "\n".join(parts)
