# SPDX-License-Identifier: Apache-2.0
"""Frames of a stream, read by what docs/link.md says of them and by pymodbus' CRC."""

from __future__ import annotations

from typing import NamedTuple

from pymodbus.framer import FramerRTU

WORDS = 60
"""Of a packet."""


class Packet(NamedTuple):
    """Its number, and rows of words without signs."""

    number: int
    rows: list[tuple[int, ...]]


def unstuffed(frame: bytes) -> bytes:
    """What a frame, without the zero at its end, stands for."""
    assert frame, "an empty frame"
    assert 0 not in frame
    found, place = bytearray(), 0
    while place < len(frame):
        code = frame[place]
        piece = frame[place + 1 : place + code]
        assert len(piece) == code - 1, f"a block is cut off: {frame.hex()}"
        place += code
        found += piece
        if code < 255 and place < len(frame):
            found.append(0)
    return bytes(found)


def frames(line: bytes) -> tuple[list[bytes], bytes]:
    """All whole frames of a line, as they stand between zeros, and what is left."""
    *whole, rest = line.split(b"\0")
    return whole, rest


def is_right(data: bytes) -> bool:
    """Whether the two bytes at the end are the CRC of those before."""
    return len(data) > 2 and FramerRTU.compute_CRC(data[:-2]).to_bytes(2, "big") == data[-2:]


def packet(data: bytes) -> Packet | None:
    """A packet, or None of an answer, whose first byte is a unit."""
    assert is_right(data), data.hex()
    if data[0] < 248:
        return None
    channels = data[0] - 247
    assert 1 <= channels <= 4
    assert len(data) == 5 + 2 * WORDS
    words = [int.from_bytes(data[n : n + 2], "big") for n in range(3, 3 + 2 * WORDS, 2)]
    rows = [tuple(words[n : n + channels]) for n in range(0, WORDS, channels)]
    return Packet(int.from_bytes(data[1:3], "big"), rows)
