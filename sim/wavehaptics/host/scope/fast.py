# SPDX-License-Identifier: Apache-2.0
"""Rows of a scope by the device's stream: what changes fast, at many times the rate of polls.

A stream has four words: place, current, u and the flags. With those of the same step v = u − s·i
and e_id = s·u; the anchor's voltage beside it, and χ, are those of the last poll.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from wavehaptics.host.client import Client
from wavehaptics.host.scope.bench import Bench
from wavehaptics.host.stream import Stream, is_there, row_hz

CHANNELS = 4

ZEROED = 1.0 + 1.0 / 16.0
"""Largest current over the ADC's scale: its zero may be off by so much."""

MOST_HZ = 1000.0
"""Rows a second at most: a page shows no more. Each is the device's mean over its ticks."""

LEAST_HZ = 200.0
"""With fewer it isn't worth that others have to ask for the port: polls make up to 100."""


def is_worth(client: Client) -> bool:
    """Whether the device has a stream, and its line is fast enough for it at its first rate."""
    return is_there(client) and row_hz(client, CHANNELS, client.baud) >= LEAST_HZ


def channels(bench: Bench) -> tuple[str, ...]:
    """What is streamed, with no larger ranges than the words can have by the settings."""
    scale_a, u_max = bench.full_scale_a, bench.u_max
    return (
        "position", f"current:{ZEROED * scale_a!r}" if scale_a else "current",
        f"u:{u_max!r}" if u_max else "u", "flags",
    )  # fmt: skip


class Fast:
    """The stream of a bench's motor, as a context that has the port."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._channels = channels(bench)
        self._stream = Stream(bench.client, self._channels, motor=bench.motor, most_hz=MOST_HZ)
        self._end = math.nan  # the count where the last row ended
        self.lost = 0
        """Packets that didn't come."""

    def __enter__(self) -> Fast:
        self._stream.__enter__()
        return self

    def __exit__(self, *raised: Any) -> None:
        self._stream.__exit__(*raised)

    @property
    def row_hz(self) -> float:
        """Rows a second."""
        return 1.0 / self._stream.wanted.rows.row_s

    @property
    def seconds(self) -> float:
        """Of the device, from the beginning to the last row that came."""
        return self._stream.seconds

    @property
    def is_over(self) -> bool:
        """Whether the device has ended it, or settings have changed that it was chosen by.

        :class:`HostError` where the port is gone.
        """
        return self._stream.lapsed or channels(self._bench) != self._channels

    def rows(self, seen: Mapping[str, float]) -> Iterator[tuple[float, dict[str, float]]]:
        """(s of the device since the stream began, row) of what came since the last time.

        A row of a lost packet knows nothing but that. ``seen`` is the last poll of the anchor.
        """
        found = self._stream.fresh()
        self.lost += found.lost_packets
        contact, saturated = found.flag("contact"), found.flag("saturated")
        ends, current, u, _ = (found[name] for name in found.plan.names)
        for n, lost in enumerate(found.lost.tolist()):
            if lost:
                yield float(found.t[n]), {"lost": 1.0}
                continue
            begin = ends[n] if math.isnan(self._end) else self._end
            self._end = float(ends[n])
            step = {
                "position": 0.5 * (begin + self._end), "current": float(current[n]),
                "u": float(u[n]), "v": float(u[n] - self._bench.root * current[n]),
                "voltage": float(self._bench.root * u[n]) + seen.get("correction", 0.0),
                "contact": float(contact[n]), "saturated": float(saturated[n]),
            }  # fmt: skip
            yield float(found.t[n]), {**self._bench.row(step, seen), "lost": 0.0}
