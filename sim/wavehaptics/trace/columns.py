# SPDX-License-Identifier: Apache-2.0
"""What a simulation hands on: one row a tick, and the file that keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from wavehaptics.runtime.compiled import compiled, compiled_counting
from wavehaptics.runtime.files import replacing
from wavehaptics.words import formats

TRACE_FILE = "trace.npz"


class Column(IntEnum):
    """Columns of a chunk of rows, float64 of shape (ticks, ``len(Column)``), SI units."""

    T = 0  # s, middle of the tick
    X = 1  # rad, mean of the tick's ends
    OMEGA = 2  # rad/s, mean over the tick
    I = 3  # noqa: E741  A, mean over the tick
    E_A = 4  # V, mean over the tick
    TORQUE = 5  # N·m, k_T times the mean current
    ETA = 6  # η of the tick's step
    U = 7  # √W, u_n
    V = 8  # √W, v_n
    X_HAND = 9  # rad, middle of the tick
    CONTACT = 10  # 1 in contact, else 0
    SATURATED = 11  # 1 where the limit acted: on u_n, or in the tick's step where it varies
    ENERGY_OUT = 12  # J, ∫(e_a − R i − drop) i dt over the tick, R as it is: given out by the port
    RIPPLE = 13  # A, peak to peak within the tick
    CORRECTION = 14  # V, c of the port anchor in the tick's voltage; 0 without one
    X_HAT = 15  # rad, where the port anchor takes the rotor to be at the tick's end
    OMEGA_HAT = 16  # rad/s, how fast, as a mean of some 256 ticks
    FLUX = 17  # cells, χ of the port anchor
    FAULT = 18  # 1 once the port anchor has found that waves and encoder don't agree
    CLIPPED = 19  # 1 where a sample, the current's word or v was at the end of its range


@compiled(inline="always")
def put_motion(
    row: np.ndarray, begin: float, tick: float, x_before: float, x: float, mean: float, e_a: float,
    torque: float, x_hand: float, energy_out: float, ripple: float,
) -> None:  # fmt: skip
    """The motor's part of a tick's row: it begins at ``begin`` s, with the rotor at ``x_before``.

    ``mean`` is the current's, A, and ``x`` where the rotor is at the end.
    """
    row[Column.T] = begin + 0.5 * tick
    row[Column.X] = 0.5 * (x_before + x)
    row[Column.OMEGA] = (x - x_before) / tick
    row[Column.I] = mean
    row[Column.E_A] = e_a
    row[Column.TORQUE] = torque
    row[Column.X_HAND] = x_hand
    row[Column.ENERGY_OUT] = energy_out
    row[Column.RIPPLE] = ripple


@compiled(inline="always")
def put_port(
    row: np.ndarray, eta: float, u: float, v: float, contact: bool, saturated: bool,
    clipped: bool = False,
) -> None:  # fmt: skip
    """The port's part of a tick's row: waves in √W, and three flags."""
    row[Column.ETA] = eta
    row[Column.U] = u
    row[Column.V] = v
    row[Column.CONTACT] = 1.0 if contact else 0.0
    row[Column.SATURATED] = 1.0 if saturated else 0.0
    row[Column.CLIPPED] = 1.0 if clipped else 0.0


@compiled(inline="always")
def put_anchor(row: np.ndarray, correction: float, fault: float) -> None:
    """What a port anchor added to the tick's voltage, and whether it has found a fault."""
    row[Column.CORRECTION] = correction
    row[Column.FAULT] = fault


@compiled(inline="always")
def put_estimate(row: np.ndarray, flux: float, x_hat: float, omega_hat: float) -> None:
    """Where a port anchor takes the rotor to be, and how fast."""
    row[Column.FLUX] = flux
    row[Column.X_HAT] = x_hat
    row[Column.OMEGA_HAT] = omega_hat


class Word(IntEnum):
    """Columns of a chunk of raw words, int64 of shape (ticks, ``len(Word)``)."""

    I = 0  # noqa: E741
    U = 1
    V = 2
    E = 3


FLOAT_COLUMNS = (
    Column.T,
    Column.X,
    Column.OMEGA,
    Column.I,
    Column.E_A,
    Column.TORQUE,
    Column.ETA,
    Column.U,
    Column.V,
    Column.X_HAND,
)
"""Columns kept as float64, each under its own name in small letters."""

ANCHOR_COLUMNS = (Column.X_HAT, Column.OMEGA_HAT, Column.CORRECTION, Column.FLUX)
"""Columns kept besides where there is a port anchor."""

NAMES = {
    "t": ("time", "s"), "x": ("position", "rad"), "omega": ("speed", "rad/s"),
    "i": ("current", "A"), "e_a": ("voltage", "V"), "torque": ("torque", "N·m"),
    "eta": ("eta", "–"), "u": ("u", "√W"), "v": ("v", "√W"), "x_hand": ("hand_position", "rad"),
    "energy_out": ("energy_out", "J"), "contact": ("contact", "–"),
    "saturated": ("saturated", "–"), "clipped": ("clipped", "–"),
    "x_hat": ("position_estimate", "rad"), "omega_hat": ("speed_estimate", "rad/s"),
    "correction": ("correction", "V"), "flux": ("flux", "counts"), "fault": ("fault", "–"),
    "i_word": ("i_word", "LSB"), "u_word": ("u_word", "LSB"), "v_word": ("v_word", "LSB"),
    "e_word": ("e_word", "LSB"),
}  # fmt: skip
"""A spelt-out name and the unit of each array of ``trace.npz``; – stands for none."""

_N_FLOAT = len(FLOAT_COLUMNS)
assert tuple(FLOAT_COLUMNS) == tuple(range(_N_FLOAT)), "_keep copies the first columns of a row"
_CONTACT = int(Column.CONTACT)
_SATURATED = int(Column.SATURATED)
_ENERGY_OUT = int(Column.ENERGY_OUT)
_FAULT = int(Column.FAULT)
_CLIPPED = int(Column.CLIPPED)
_ANCHOR = tuple(int(column) for column in ANCHOR_COLUMNS)
_WORD_TYPE = np.int32 if formats.DATA_W <= 32 else np.int64


@compiled_counting()
def _keep(
    rows: np.ndarray, first: int, step: int, energy: float, floats: np.ndarray, flags: np.ndarray,
    at: int,
) -> float:  # fmt: skip
    """Copy rows ``first::step`` to the places from ``at`` on; energy after the chunk, J."""
    due = first
    for n in range(rows.shape[0]):
        energy += rows[n, _ENERGY_OUT]
        if n == due:
            for column in range(_N_FLOAT):
                floats[column, at] = rows[n, column]
            floats[_N_FLOAT, at] = energy
            flags[0, at] = rows[n, _CONTACT] != 0.0
            flags[1, at] = rows[n, _SATURATED] != 0.0
            flags[2, at] = rows[n, _CLIPPED] != 0.0
            if floats.shape[0] > _N_FLOAT + 1:
                for place in range(len(_ANCHOR)):
                    floats[_N_FLOAT + 1 + place, at] = rows[n, _ANCHOR[place]]
                flags[3, at] = rows[n, _FAULT] != 0.0
            at += 1
            due += step
    return energy


ROW_BYTES = 140
"""Most that a row of a trace takes, in memory and in the file: with an anchor and its raw words."""


def thinning(tick_s: float, trace_hz: float | None) -> int:
    """Ticks from a row that is kept to the next, for a tick in s; without a rate each is kept."""
    return 1 if trace_hz is None else max(1, round(1.0 / (tick_s * trace_hz)))


class TraceWriter:
    """Collects the rows of a run, thinned, and writes them as ``trace.npz``.

    ``path`` is the file, or the directory that is to hold ``trace.npz``. Every m-th tick is kept
    from the run's first on, ``m = max(1, round(1/(tick_s · trace_hz)))``, however the run is cut
    into chunks; ``trace_hz`` None keeps every tick. ``ticks`` is the number of ticks expected: the
    memory is reserved for it at once, and grows if there are more. ``anchored`` keeps what a port
    anchor adds to a row.

    A row takes 91 bytes, 33 more with an anchor and 16 more with its raw words, in memory and in
    the file: 4 million rows (4 s at 1 MHz unthinned) take 0.4 GB. ``trace_hz`` is what keeps a
    long run small.

    The file is not compressed: zlib at its fastest took ten times as long to save a third.
    """

    def __init__(
        self, path: Path | str, tick_s: float, trace_hz: float | None = None, *, ticks: int = 0,
        anchored: bool = False,
    ) -> None:  # fmt: skip
        if tick_s <= 0.0 or (trace_hz is not None and trace_hz <= 0.0):
            raise ValueError("tick_s and trace_hz must be above zero")
        path = Path(path)
        self.path = path if path.suffix == ".npz" else path / TRACE_FILE
        self.step = thinning(tick_s, trace_hz)
        self._ticks = 0
        self._kept = 0
        self._energy = 0.0
        self._has_words: bool | None = None
        room = max(1, -(-ticks // self.step))
        self._anchored = anchored
        self._floats = np.empty((_N_FLOAT + 1 + anchored * len(ANCHOR_COLUMNS), room))
        self._flags = np.empty((4, room), dtype=np.bool_)
        self._words = np.empty((len(Word), 0), dtype=_WORD_TYPE)

    @property
    def kept(self) -> int:
        """Rows kept so far."""
        return self._kept

    def _reserve(self, rows: int) -> None:
        room = self._floats.shape[1]
        if rows > room:
            more = max(rows, 2 * room) - room
            self._floats = np.pad(self._floats, ((0, 0), (0, more)))
            self._flags = np.pad(self._flags, ((0, 0), (0, more)))
        if self._has_words and self._words.shape[1] < self._floats.shape[1]:
            more = self._floats.shape[1] - self._words.shape[1]
            self._words = np.pad(self._words, ((0, 0), (0, more)))

    def write(self, rows: np.ndarray, words: np.ndarray | None = None) -> None:
        """Take the next ticks: ``rows`` float64 (n, len(Column)), ``words`` int64 (n, len(Word)).

        ``ValueError`` if the shapes don't fit, or if words come with some chunks only.
        """
        if rows.ndim != 2 or rows.shape[1] != len(Column):
            raise ValueError(f"rows must be (ticks, {len(Column)}), not {rows.shape}")
        if words is not None and words.shape != (rows.shape[0], len(Word)):
            raise ValueError(f"words must be {(rows.shape[0], len(Word))}, not {words.shape}")
        if self._has_words not in (None, words is not None):
            raise ValueError("raw words must come with every chunk or with none")
        self._has_words = words is not None
        first = -self._ticks % self.step
        end = self._kept + len(range(first, rows.shape[0], self.step))
        self._reserve(end)
        self._energy = _keep(
            rows, first, self.step, self._energy, self._floats, self._flags, self._kept
        )
        if words is not None:
            self._words[:, self._kept : end] = words[first :: self.step].T
        self._ticks += rows.shape[0]
        self._kept = end

    def arrays(self) -> dict[str, np.ndarray]:
        """The arrays as they go into the file, each of shape (kept,); views, not copies."""
        kept = slice(self._kept)
        named: dict[str, np.ndarray] = {
            column.name.lower(): self._floats[column, kept] for column in FLOAT_COLUMNS
        }
        named["energy_out"] = self._floats[_N_FLOAT, kept]
        named["contact"], named["saturated"], named["clipped"] = self._flags[:3, kept]
        if self._anchored:
            for place, column in enumerate(ANCHOR_COLUMNS, _N_FLOAT + 1):
                named[column.name.lower()] = self._floats[place, kept]
            named["fault"] = self._flags[3, kept]
        if self._has_words:
            for word in Word:
                named[f"{word.name.lower()}_word"] = self._words[word, kept]
        return named

    def save(self) -> Path:
        """Write the file, whole or not at all, and return its path; the directory is made.

        Arrays: ``t x omega i e_a torque eta u v x_hand`` (:class:`Column`), ``energy_out`` (J, what
        the port has given out up to the end of that tick, summed at full rate), ``contact``,
        ``saturated`` and ``clipped`` (bool), ``x_hat omega_hat correction flux`` and ``fault``
        (bool) where there is a port anchor, and ``i_word u_word v_word e_word`` where the
        controller has words.
        """
        return write_npz(self.path, self.arrays())


def write_npz(path: Path, arrays: Mapping[str, np.ndarray]) -> Path:
    """Write arrays by name, whole or not at all; returns ``path``. The directory is made."""
    named: dict[str, Any] = {**arrays}
    with replacing(path) as part, part.open("wb") as file:
        np.savez(file, **named)
    return path


def load_trace(path: Path | str) -> dict[str, np.ndarray]:
    """Arrays of a ``trace.npz`` by name, as :meth:`TraceWriter.save` lists them.

    ``path`` is the file or the directory that holds ``trace.npz``. ``ValueError`` for a file that
    is none, or was cut.
    """
    path = Path(path)
    if path.is_dir():
        path = path / TRACE_FILE
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (ValueError, EOFError, BadZipFile):
        raise ValueError(f"{path}: is no whole trace; was it cut? Write it anew") from None
