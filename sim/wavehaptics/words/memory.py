# SPDX-License-Identifier: Apache-2.0
"""Words as the settings memory takes them: each with an address of its own, as 32 bits."""

from __future__ import annotations

from collections.abc import Iterable

from wavehaptics.words import table
from wavehaptics.words.table import AXES, LEGS, MOST, THREE_PHASE_LEGS, WORDS, Values, Word


def requests(values: Values, legs: int = LEGS, motor: int = 0) -> list[tuple[int, int]]:
    """(address, raw word) of each word of one motor, without those that are no settings of it.

    Both axes of a brushless one, whose two ports are behind those of the motors before it, have the
    same words. Of a motor that isn't the first they are its own alone, without the board's.
    """
    found = []
    first = motor * (AXES if legs == THREE_PHASE_LEGS else 1)
    for name, value in values.items():
        word = WORDS.get(name)
        if word is None or word.row.kind != "setting" or (motor and word.row.per == "board"):
            continue
        raws = list(value) if isinstance(value, Iterable) else [value]
        found += [
            (word.at(first + port, n), int(raw) & 0xFFFFFFFF)
            for port in word.port_numbers(1, legs)
            for n, raw in enumerate(raws)
        ]
    return found


def apart(values: Values) -> dict[str, int | list[int]]:
    """``values`` by their words' names, with those of a port of several words taken apart."""
    found: dict[str, int | list[int]] = {}
    for name, value in values.items():
        mates = table.ports().get(name, [])
        if len(mates) < 2 and (not mates or mates[0].name == name):
            found[name] = value if isinstance(value, int) else [int(raw) for raw in value]
            continue
        copies = [value] if isinstance(value, int) else [int(raw) for raw in value]
        for raw in copies:
            for word in mates:
                for _ in range(word.row.count):
                    mask = (1 << word.fixed.width) - 1
                    part = raw & mask
                    raw >>= word.fixed.width
                    if word.fixed.signed and part >> word.fixed.width - 1:
                        part -= mask + 1
                    found.setdefault(word.name, []).append(part)  # type: ignore[union-attr]
    return found


def settings_requests(values: Values, legs: int = LEGS, motor: int = 0) -> list[tuple[int, int]]:
    """As :func:`requests`, of words and of ports with several of them."""
    return requests(apart(values), legs, motor)


ROM_WORDS = 256
"""Words of the ROM ``defaults`` of ``rtl/wh_registers.v``."""

_BOARDS, _MOTORS = 160, 256
"""Where that ROM has the board's first word, and the address of a motor's first, which leads it."""


def rom_slots() -> list[tuple[Word, list[int]]]:
    """Each setting, and where that ROM has its words: as many as it may have at most."""
    found = []
    for word in WORDS.values():
        if word.row.kind == "setting":
            first = word.at() - _MOTORS if word.at() >= _MOTORS else word.at() + _BOARDS
            most = MOST[word.row.per] if word.row.per in ("wall", "section") else 1
            found.append((word, [first + n for n in range(most * word.row.count)]))
    return found


def first_words(values: Values, walls: int, sections: int) -> list[int]:
    """The ROM ``defaults`` of ``rtl/wh_registers.v``: each register's first word, as 32 bits.

    ``values`` are by their words' names, as :func:`apart` returns them; what isn't among them has
    the table's default.
    """
    rom = [0] * ROM_WORDS
    for word, slots in rom_slots():
        given = values.get(word.name, word.default)
        copies = word.row.count * {"wall": walls, "section": sections}.get(word.row.per, 1)
        raws = [given] * copies if isinstance(given, int) else given
        for slot, raw in zip(slots, raws, strict=False):
            rom[slot] = int(raw) & 0xFFFFFFFF
    return rom
