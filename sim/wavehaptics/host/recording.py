# SPDX-License-Identifier: Apache-2.0
"""Raw words of a capture and the settings they were made with, beside the arrays of its trace.

They are arrays of ``trace.npz`` as well: ``raw_NAME`` of each channel, int64 of shape (rows,), and
``device``, one text in JSON with all settings. :mod:`wavehaptics.host.replay` reads them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.host.capture import BOARD_WORDS, Captured
from wavehaptics.host.client import Client
from wavehaptics.host.names import HostError, Place, Shape, places, settings
from wavehaptics.trace.columns import load_trace
from wavehaptics.words import table

HEADER = "device"
"""Name of the array with the settings."""

_RAW = "raw_"


def settings_now(client: Client) -> list[int]:
    """All settings of the device, raw, in the order of :func:`wavehaptics.host.names.settings`."""
    return client.read(settings(client.shape))


def recorded(
    client: Client, found: Captured, before: Sequence[int], after: Sequence[int] | None
) -> dict[str, np.ndarray]:
    """Arrays for the trace's file: raw words, and settings ``before`` and ``after`` the capture.

    ``after`` is None where the line failed before they could be read.
    """
    plan, shape = found.plan, client.shape
    header = {
        "table": f"{table.crc():08x}",
        "build": f"{client.identification.words['build']:08x}",
        "shape": [shape.motors, shape.walls, shape.sections, shape.delay_log2, shape.legs],
        "decimation": plan.decimation,
        "tick_s": plan.tick_s,
        "channels": [
            [name, place.text, place.motor]
            for name, place in zip(plan.names, plan.channels, strict=True)
        ],
        "settings": [*before],
        "after": None if after is None else [*after],
    }
    arrays = {HEADER: np.array(json.dumps(header))}
    for name, place in zip(plan.names, plan.channels, strict=True):
        # A word times its step is exact in a float.
        raws = np.rint(found.values[name] / place.word.fixed.step)
        arrays[_RAW + name] = raws.astype(np.int64)
    return arrays


@dataclass(frozen=True)
class Recording:
    """A capture as it was: raw words by (name, motor), int64 (rows,), and settings, raw."""

    words: dict[tuple[str, int], np.ndarray]
    settings: dict[tuple[str, int], int]
    shape: Shape
    tick_s: float

    @property
    def motors(self) -> list[int]:
        """Motors that it has words of."""
        return sorted({motor for name, motor in self.words if name not in BOARD_WORDS})

    def setting(self, name: str, motor: int) -> int:
        """A setting's raw word."""
        return self.settings[name, motor]

    def copies(self, name: str, motor: int) -> np.ndarray:
        """All words of a row that has several, int64."""
        return np.array(
            [self.settings[place.text, motor] for place in places(name, self.shape, motor)],
            dtype=np.int64,
        )


def read(path: Path) -> Recording:
    """The recording of a file or of its folder. :class:`HostError`, one line, where it is none."""
    try:
        arrays = load_trace(path)
    except OSError as error:
        raise HostError(f"{path}: can't be read: {error.strerror}") from None
    except ValueError as error:
        raise HostError(str(error)) from None
    if HEADER not in arrays:
        raise HostError(
            f"{path}: it has no raw words and settings: it is a stream, a scope's recording, a "
            "simulation, or of an older package; make a new one with `board capture`"
        )
    try:
        header = json.loads(str(arrays[HEADER]))
        told = header["table"]
    except (ValueError, KeyError, TypeError):
        raise HostError(f"{path}: its settings can't be read; capture it anew") from None
    if told != f"{table.crc():08x}":
        raise HostError(
            f"{path}: its register map has the CRC {told}, and this package's {table.crc():08x}; "
            "replay it with the package that captured it"
        )
    try:
        return _recording(path, header, arrays)
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, HostError):
            raise
        raise HostError(f"{path}: its settings or words aren't whole; capture it anew") from None


def _recording(path: Path, header: dict[str, Any], arrays: dict[str, np.ndarray]) -> Recording:
    shape = Shape(*header["shape"])
    wanted = settings(shape)
    before, after = header["settings"], header["after"]
    if after is not None:
        for place, old, new in zip(wanted, before, after, strict=True):
            if old != new and place.word.block not in table.BESIDE:
                raise HostError(
                    f"{path}: {place.text} was changed while it was captured; capture again, and "
                    "leave the settings as they are meanwhile"
                )
    if header["decimation"] != 1:
        raise HostError(
            f"{path}: a row is the mean of {header['decimation']} control periods, and the model "
            "needs each; capture with --decimate 1"
        )
    values = {
        (place.text, place.motor): _signed(place, raw)
        for place, raw in zip(wanted, before, strict=True)
    }
    words = {
        (text, motor): np.asarray(arrays[_RAW + name], dtype=np.int64)
        for name, text, motor in header["channels"]
    }
    if len({len(rows) for rows in words.values()}) > 1:
        raise ValueError("columns of different lengths")
    return Recording(words, values, shape, float(header["tick_s"]))


def _signed(place: Place, raw: int) -> int:
    return raw - (1 << 32) if place.word.fixed.signed and raw >> 31 else raw
