# SPDX-License-Identifier: Apache-2.0
"""Words as the settings memory takes them: each with an address of its own, as 32 bits."""

from __future__ import annotations

from collections.abc import Iterable

from wavehaptics.words import table
from wavehaptics.words.table import LEGS, WORDS, Values


def requests(values: Values, legs: int = LEGS, motor: int = 0) -> list[tuple[int, int]]:
    """(address, raw word) of each word of one motor, without those that are no settings of it.

    Both axes of a brushless one have the same words. Of a motor that isn't the first they are its
    own alone, without the board's.
    """
    found = []
    for name, value in values.items():
        word = WORDS.get(name)
        if word is None or word.row.kind != "setting" or (motor and word.row.per == "board"):
            continue
        raws = list(value) if isinstance(value, Iterable) else [value]
        found += [
            (word.at(motor + part, n), int(raw) & 0xFFFFFFFF)
            for part in range(word.parts(1, legs))
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
