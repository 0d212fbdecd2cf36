# SPDX-License-Identifier: Apache-2.0
"""Live words of a device as it sends them, row after row, by its ``rtl/wh_stream.v``.

One call begins it and gives arrays in SI units, of rows that were lost as well::

    with Stream(client, plan(client, ["current:4", "position"])) as stream:
        time.sleep(2.0)
    found = stream.found()
    plot(found.t, found["current"]), found.lost.sum()
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from wavehaptics.host.capture import MOST_DECIMATION, NOW, Captured, Plan, channel, tick_s
from wavehaptics.host.client import Client
from wavehaptics.host.framed_line import FIRST_PACKET, FramedLine
from wavehaptics.host.names import HostError, Place, listed, places
from wavehaptics.runtime.ends import ending

MOST_CHANNELS = 4
MOST_SHIFT = 15
PACKET_WORDS = 60
PACKET_BYTES = 127
"""On the line, with the frame."""
SEARCH_CLOCKS = 380
"""Of the device between two packets, for the zeros of one."""

LINE_PART = 0.97
"""Of the line that rows may take; the rest is for answers."""

REST, RUNS = 1, 2
"""The word ``stream_state``; 0 where there is no stream."""

_BITS = ("flags", "faults")


@dataclass(frozen=True)
class Wanted:
    """What is sent: the channels of ``rows``, and the bits of each that are cut off below."""

    rows: Plan
    shifts: tuple[int, ...]
    baud: int

    @property
    def packet_rows(self) -> int:
        """Rows of a packet."""
        return PACKET_WORDS // len(self.shifts)


@dataclass(frozen=True)
class Streamed(Captured):
    """Rows of a stream from its beginning on, as :class:`Captured` has them.

    Where a packet didn't arrive ``lost`` is true: numbers are NaN there, and no bits are set.
    """

    lost: np.ndarray
    """bool, of shape (rows,)."""
    lost_packets: int
    left_out: int
    """Of these, packets that the device had no room for; of the rest the way here has lost some."""
    broken: int
    """Frames that came and couldn't be read."""
    at_end: dict[str, int]
    """Rows in which a channel's word was larger than its 16 bits, where there were any."""


def is_there(client: Client) -> bool:
    """Whether the device has a stream."""
    return client.read(places("stream_state", client.shape)[:1])[0] != 0


def row_hz(client: Client, channels: int, baud: int) -> float:
    """Rows a second of so many channels that the line carries beside answers."""
    packet_s = 10 * PACKET_BYTES / baud + SEARCH_CLOCKS / client.identification.words["clock_hz"]
    return LINE_PART * PACKET_WORDS // channels / packet_s


def plan(
    client: Client, channels: Sequence[str], *, decimation: int | None = None, motor: int = 0,
    most_hz: float | None = None,
) -> Wanted:  # fmt: skip
    """What a stream of ``channels`` is to be; :class:`HostError` for what the device can't do.

    A channel is a name of :data:`~wavehaptics.host.capture.WORDS`, of ``motor``, or ``NAME@MOTOR``;
    with ``:RANGE`` behind it the largest magnitude that its 16 bits have to hold, in its unit, by
    default that of the word. A row is of ``decimation`` ticks, a power of two, by default the
    fewest that the line carries, at the rate that it has, and that make no more than ``most_hz``
    rows a second.
    """
    if not is_there(client):
        raise HostError("the device has no stream; its bitstream was made without")
    texts = [*dict.fromkeys(listed(channels))]
    if not 1 <= len(texts) <= MOST_CHANNELS:
        raise HostError(f"{len(texts)} words: a stream takes 1 to {MOST_CHANNELS}")
    found = [_channel(client, text, motor) for text in texts]
    names = tuple(name for name, _, _ in found)
    if len({*names}) < len(names):
        raise HostError(f"{', '.join(texts)}: a word is there twice; leave one out")
    baud, tick = client.baud, tick_s(client)
    carried_hz = row_hz(client, len(found), baud)
    least = _ticks(tick, carried_hz)
    if decimation is None:
        decimation = least if most_hz is None else max(least, _ticks(tick, most_hz))
    if not 1 <= decimation <= MOST_DECIMATION or decimation & (decimation - 1):
        raise HostError(f"decimation {decimation}: take 1, 2, 4 ... {MOST_DECIMATION} ticks a row")
    if decimation < least:
        raise HostError(
            f"decimation {decimation}: {1 / (decimation * tick):.0f} rows of {len(found)} words a "
            f"second, and {baud} bits a second carry {carried_hz:.0f}; take {least} or more"
        )
    rows = Plan(tuple(place for _, place, _ in found), names, 0, 0, decimation, NOW, tick)
    return Wanted(rows, tuple(shift for _, _, shift in found), baud)


def _ticks(tick_s_: float, most_hz: float) -> int:
    """Ticks of a row, a power of two, with which there are at most so many rows a second."""
    ticks = 1
    while 1 / (ticks * tick_s_) > most_hz:
        ticks *= 2
    return ticks


def _channel(client: Client, text: str, motor: int) -> tuple[str, Place, int]:
    """Name, place and cut of a channel."""
    name, colon, limit = text.partition(":")
    place = channel(client, name, motor, "streamed")
    if place.word.name in (*_BITS, "position"):
        if colon:
            raise HostError(f"{text}: {place.word.name} has no range; leave :{limit} out")
        return name, place, 0
    fixed = place.word.fixed
    whole = max(0, fixed.width + (not fixed.signed) - 16)
    if not colon:
        return name, place, whole
    try:
        largest = float(limit) if re.fullmatch(r"[\d.]+(e[-+]?\d+)?", limit) else math.nan
    except ValueError:
        largest = math.nan
    if not 0 < largest <= 2.0**32:
        raise HostError(f"{text}: write {name}:RANGE, a number above 0 in {place.word.row.unit}")
    need = math.ceil(math.log2(max(1.0, largest / fixed.step))) - 15
    return name, place, min(max(0, need), whole, MOST_SHIFT)


class Stream:
    """A stream, as a context: it begins and ends with it. The client can be used within.

    It keeps the port, at the fastest rate of the device; nobody else has it meanwhile. Its end
    raises :class:`HostError` where the port has gone; what had come is there all the same.
    """

    def __init__(self, client: Client, channels: Sequence[str], **options: float | None) -> None:
        self._client, self._channels, self._options = client, channels, options
        self._packets: list[bytes] = []
        self._last = -1  # number of the last one
        self._taken = self._before = 0  # packets that were taken away, and numbers before the next
        self._kept = ExitStack()
        self._positions: dict[str, int] = {}
        self._left_out = 0
        self.wanted: Wanted
        self._line: FramedLine

    def __enter__(self) -> Stream:
        client = self._client
        with ExitStack() as kept:
            kept.enter_context(client.hurry())
            self.wanted = wanted = plan(client, self._channels, **self._options)  # type: ignore[arg-type]
            places_ = wanted.rows.channels
            addresses = [place.address for place in places_]
            words = {
                **{f"stream_channel[{n}]": address for n, address in enumerate(addresses)},
                "stream_last": len(addresses) - 1,
                "stream_decimation": wanted.rows.decimation.bit_length() - 1,
                **{f"stream_shift[{n}]": shift for n, shift in enumerate(wanted.shifts)},
            }
            client.write((places(name, client.shape)[0], raw) for name, raw in words.items())
            self._line = kept.enter_context(client.streaming(self._take))
            kept.enter_context(ending(self._count_left_out))
            # A stream has the lowest 16 bits of a position.
            for name, place in zip(wanted.rows.names, places_, strict=True):
                if place.word.name == "position":
                    self._positions[name] = client.read([place])[0]
            self._kept = kept.pop_all()
        return self

    def __exit__(self, *raised: Any) -> None:
        self._kept.__exit__(*raised)

    def _count_left_out(self) -> None:
        if not self._line.lapsed and self._line.error is None:
            self._left_out = self._client.read(places("stream_lost", self._client.shape)[:1])[0]

    def _take(self, packet: bytes) -> None:
        if packet[0] == FIRST_PACKET + len(self.wanted.shifts) - 1:
            self._last = _after(self._last, packet)
            self._packets.append(packet)

    @property
    def came(self) -> bool:
        """Whether there is a row in :meth:`found`."""
        return bool(self._packets)

    @property
    def seconds(self) -> float:
        """Of the device's time, from the first row to the last one that came."""
        return (self._last + 1) * self.wanted.packet_rows * self.wanted.rows.row_s

    @property
    def lost(self) -> int:
        """Packets that didn't come."""
        return self._last + 1 - len(self._packets) - self._taken

    @property
    def lapsed(self) -> bool:
        """Whether credit ran out; :class:`HostError` if the port is gone."""
        if self._line.error is not None:
            raise self._client.gone(self._line.error)
        return self._line.lapsed

    def check(self) -> None:
        """:class:`HostError` if the stream is over: the port is gone, or credit ran out."""
        if self.lapsed:
            raise HostError(
                f"{self._client.port}: the stream has ended: 200 ms without a renewal; is this "
                "machine too busy?"
            )

    def found(self) -> Streamed:
        """What came, but for what :meth:`fresh` has taken away."""
        return self._made([*self._packets])

    def fresh(self) -> Streamed:
        """What came since the last time. It is not kept: a stream may last for hours."""
        packets = self._packets[:]
        found = self._made(packets)
        del self._packets[: len(packets)]
        self._taken += len(packets)
        self._before += len(found.t) // self.wanted.packet_rows
        for name in self._positions:
            last = found.values[name][~found.lost][-1:]
            if len(last):
                self._positions[name] = int(last[0]) & 0xFFFFFFFF
        return found

    def _made(self, packets: list[bytes]) -> Streamed:
        """Rows of successive packets, and of those between that are lost."""
        wanted, before = self.wanted, self._before
        channels, each = len(wanted.shifts), wanted.packet_rows
        count, numbers = before, []
        for packet in packets:
            numbers.append(_after(count - 1, packet))
            count = numbers[-1] + 1
        table = np.zeros((count - before, each, channels), dtype=np.int16)
        lost = np.ones((count - before, each), dtype=bool)
        for number, packet in zip(numbers, packets, strict=True):
            words = np.frombuffer(packet, dtype=">i2", offset=3, count=PACKET_WORDS)
            table[number - before] = words.reshape(each, channels)
            lost[number - before] = False
        rows, gone = table.reshape(-1, channels), lost.reshape(-1)
        values, at_end = {}, {}
        for n, (name, place) in enumerate(
            zip(wanted.rows.names, wanted.rows.channels, strict=True)
        ):
            values[name] = self._values(name, place, rows[:, n], gone, wanted.shifts[n])
            ends = np.isin(rows[:, n], (-0x8000, 0x7FFF)) & ~gone
            if place.word.name not in (*_BITS, "position") and ends.any():
                at_end[name] = int(ends.sum())
        t = (before * each + np.arange(len(rows))) * wanted.rows.row_s
        return Streamed(
            wanted.rows, t, values, None, gone, count - before - len(packets), self._left_out,
            self._line.broken, at_end,
        )  # fmt: skip

    def _values(
        self, name: str, place: Place, raws: np.ndarray, lost: np.ndarray, shift: int
    ) -> np.ndarray:
        if place.word.name in _BITS:
            return raws.view(np.uint16).astype(np.uint32)
        if place.word.name == "position":
            counts = np.full(len(raws), np.nan)
            there = raws[~lost].astype(np.int64)
            if len(there):
                told = self._positions[name]
                told = told - (1 << 32) if told >> 31 else told
                steps = np.diff(there, prepend=told)
                ways = (steps + 0x8000) % 0x10000 - 0x8000
                counts[~lost] = told + np.cumsum(ways)
            return counts
        # What was cut off is anything from 0 to 2^shift - 1: its mean.
        found: np.ndarray = (raws * 2.0**shift + 0.5 * (2**shift - 1)) * place.word.fixed.step
        found[lost] = np.nan
        return found


def _after(before: int, packet: bytes) -> int:
    """A packet's number, which it has modulo 2^16, by that of the one before it."""
    number = int.from_bytes(packet[1:3], "big")
    return before + 1 + (number - before - 1) % 0x10000
