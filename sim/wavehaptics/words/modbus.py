# SPDX-License-Identifier: Apache-2.0
"""Where ``rtl/wh_modbus.v`` has the words, and how they are put into registers of 16 bits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

TABLE = 0x2000
"""Register of the table's first word."""

MOST_READ, MOST_WRITTEN = 62, 61
"""Words of one frame."""

MAP_VERSION = 1
"""Of the registers, that this package knows."""

BAUDS = (115_200, 1_000_000, 1_500_000, 3_000_000)
"""Bits a second of the device's rates; it begins with the first one."""

OPTIONS = {
    "motors": (0, 4), "walls": (4, 5), "shaper": (9, 2), "delay_log2": (11, 4), "adc": (15, 2),
    "anchor": (18, 1), "guard": (19, 1), "sense": (20, 1), "host": (21, 1),
    "bus": (22, 1), "modes": (23, 1), "min_pulse": (24, 1), "dead_time": (25, 1),
    "arm": (27, 1), "capture": (28, 4),
}  # fmt: skip
"""Lowest bit and number of bits of each option."""

BRUSHLESS_SHAPER = 3
"""As ``shaper``: the motor is a brushless one, and there is no W."""

IDENTIFICATION = (
    "table", "build", "options", "clock_hz", "motors", "rate", "version", "rates", "frames",
    "crc_errors", "framing_errors", "overruns",
)  # fmt: skip
"""The words from register 0 on."""

EXCEPTIONS = {
    1: "the device doesn't have this function",
    2: "no such register, or it can't be read or written",
    3: "a value is out of its register's range",
    4: "the device's registers don't answer",
    6: "not now: it needs the bridges off, or a commit is under way",
}
"""Meaning of the device's exceptions."""


def word_register(address: int) -> int:
    """Register of the high half of the word at an address of the table."""
    return TABLE + 2 * address


def halves(raws: Iterable[int]) -> list[int]:
    """Registers of raw words, the high halves first."""
    return [half for raw in raws for half in (raw >> 16 & 0xFFFF, raw & 0xFFFF)]


def whole(registers: Sequence[int]) -> list[int]:
    """Words without signs of pairs of registers."""
    return [high << 16 | low for high, low in zip(registers[::2], registers[1::2], strict=True)]


def runs(pairs: Iterable[tuple[int, int]], most: int) -> Iterator[tuple[int, list[int]]]:
    """(address, raw words) of runs of successive addresses, of ``most`` words each or fewer."""
    first = 0
    raws: list[int] = []
    for address, raw in sorted(pairs):
        if raws and (address != first + len(raws) or len(raws) == most):
            yield first, raws
            raws = []
        if not raws:
            first = address
        raws = [*raws, raw]
    if raws:
        yield first, raws
