# SPDX-License-Identifier: Apache-2.0
"""Rows that the scope has seen, kept whatever becomes of the device, and their files."""

from __future__ import annotations

import csv
import io
import math
from array import array
from collections.abc import Mapping

import numpy as np

from wavehaptics.trace.columns import ANCHOR_COLUMNS, FLOAT_COLUMNS

FLAGS = ("contact", "saturated")
LOST = "lost"
"""Of a stream: 1 where a row didn't arrive, 0 where it did."""
NAMES = (
    *(column.name.lower() for column in FLOAT_COLUMNS),
    *FLAGS,
    LOST,
    *(column.name.lower() for column in ANCHOR_COLUMNS),
    "i_alpha", "i_beta",
    "tip_x", "tip_y", "hand_x", "hand_y", "force_x", "force_y",
)  # fmt: skip
"""Arrays of a trace that a device could tell, both currents of a brushless motor, and of an arm
its tip, the hand there and the motors' force, m and N."""

MOST_ROWS = 2_000_000
"""Some ten hours; then the oldest half is forgotten."""


class Kept:
    """Rows of the run, and which of them are recorded."""

    def __init__(self) -> None:
        self._columns = {name: array("d") for name in NAMES}
        self._forgotten = 0
        self._first: int | None = None
        self._last: int | None = None

    def __len__(self) -> int:
        return self._forgotten + len(self._columns["t"])

    def add(self, row: Mapping[str, float]) -> None:
        """Keep a row; what it doesn't have isn't known."""
        for name, column in self._columns.items():
            column.append(row.get(name, math.nan))
        if len(self._columns["t"]) > MOST_ROWS:
            for column in self._columns.values():
                del column[: MOST_ROWS // 2]
            self._forgotten += MOST_ROWS // 2

    @property
    def recording(self) -> bool:
        """Whether rows are being recorded."""
        return self._first is not None and self._last is None

    @property
    def recorded(self) -> int:
        """Rows of the recording that there is, or is being made."""
        if self._first is None:
            return 0
        return (len(self) if self._last is None else self._last) - self._first

    def record(self, on: bool) -> None:
        """Begin a recording, which takes the place of the last, or end it."""
        if on:
            self._first, self._last = len(self), None
        elif self.recording:
            self._last = len(self)

    def arrays(self) -> dict[str, np.ndarray]:
        """The recording, or all that is kept where there is none: arrays as of a trace.

        What the device never told is left out. Rows of a stream that were lost have no numbers.
        """
        first, last = self._first or 0, len(self) if self._last is None else self._last
        part = slice(max(0, first - self._forgotten), max(0, last - self._forgotten))
        found = {name: np.array(column[part]) for name, column in self._columns.items()}
        for name in FLAGS:
            found[name] = found[name] == 1.0
        told = {name: values for name, values in found.items() if not np.isnan(values).all()}
        return told | {LOST: told[LOST] == 1.0} if LOST in told else told

    def npz(self) -> bytes:
        """The arrays as the file of a trace, ``trace.npz``."""
        file = io.BytesIO()
        np.savez(file, **self.arrays())  # type: ignore[arg-type]
        return file.getvalue()

    def csv(self) -> str:
        """The arrays as lines, the first of which has their names."""
        arrays = self.arrays()
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(arrays)
        columns = [
            [int(v) if name in (*FLAGS, LOST) else f"{v:.9g}" for v in values]
            for name, values in arrays.items()
        ]
        writer.writerows(zip(*columns, strict=True))
        return text.getvalue()
