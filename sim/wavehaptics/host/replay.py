# SPDX-License-Identifier: Apache-2.0
"""A capture through the integer model of the controller, compared word by word.

The model takes what a capture has of the sensors, ``position``, ``current`` and ``flags``, and the
settings of its file. It computes all other words again:

- **From the start.** Where the bridges go on within the capture, all state is 0 before. The model
  runs by itself from there on, and every word is compared.
- **With the bridges on from the first row on**, the state is not in the capture. Contact, v and
  voltage are compared as of the row's own u. The λ filter is followed by all the fractions of an
  LSB that its state may have: u differs where none of them leads to the next row's. Of the anchor
  only c is used, where it was captured, for its share of the limit; nothing of it is compared.

``current`` is that of the step, without the offset that the anchor has learned. A control period in
which the ADC was at its end counts as clipped at that end, by ``flags``, which has the last sample.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wavehaptics.controller import anchor, wave_core
from wavehaptics.host.names import HostError
from wavehaptics.host.recording import Recording
from wavehaptics.words import formats
from wavehaptics.words.faults import FLAGS
from wavehaptics.words.table import ports

INPUTS = ("position", "current", "flags")
"""Words that a replay needs."""

WAVES = ("contact", "saturated", "u", "v", "voltage")
OF_ANCHOR = ("correction", "offset", "flux", "lag")

_ENDS = ("encoder_fault", "anchor_fault", "host_active")
"""Flags from which on a port does what isn't in a capture: it damps, or a computer has it."""

_GUARD = formats.STATE_GUARD
_LSB = 1 << _GUARD


@dataclass(frozen=True)
class Difference:
    """A word of a row that isn't the model's; raw."""

    row: int
    recorded: int
    model: int

    @property
    def size(self) -> int:
        """Its magnitude."""
        return abs(self.recorded - self.model)


@dataclass(frozen=True)
class Compared:
    """Of one word: how many rows were compared, and what differed."""

    compared: int
    differ: int
    first: Difference | None
    largest: Difference | None


@dataclass(frozen=True)
class Outcome:
    """Of one motor: its control periods with the bridges on that were replayed, and its words."""

    motor: int
    periods: int
    words: dict[str, Compared]
    unchecked: dict[str, str]
    """Words that couldn't be compared, and why, in words for the user."""

    @property
    def differs(self) -> bool:
        """Whether anything did."""
        return any(found.differ for found in self.words.values())


def replay(recording: Recording) -> list[Outcome]:
    """What the model makes of every motor's rows. :class:`HostError` where it can't be asked."""
    if recording.shape.brushless:
        raise HostError(
            "a capture of a brushless motor can't be replayed: it has the current of one axis, and "
            "not the electrical angle"
        )
    return [_Motor(recording, motor).outcome() for motor in recording.motors]


@dataclass
class _Stretch:
    """Rows with the bridges on: from ``first`` up to, not including, ``end``."""

    first: int
    end: int
    known: bool
    """Whether the bridges went on in the capture."""


class _Motor:
    """The rows and settings of one motor."""

    def __init__(self, recording: Recording, motor: int) -> None:
        self.recording, self.motor = recording, motor
        missing = [name for name in INPUTS if (name, motor) not in recording.words]
        if missing:
            raise HostError(
                f"{', '.join(missing)} of motor {motor} wasn't captured; a replay needs "
                f"{', '.join(INPUTS)}, and compares whatever else there is"
            )
        self.rows = {name: rows for (name, of), rows in recording.words.items() if of == motor}
        self.flags = {name: self.rows["flags"] >> bit & 1 != 0 for bit, name in enumerate(FLAGS)}
        self.rows["contact"] = self.flags["contact"].astype(np.int64)
        self.rows["saturated"] = self.flags["saturated"].astype(np.int64)
        enabled = recording.copies("wall_enable", motor) != 0
        self.wall_min = recording.copies("wall_min", motor)[enabled]
        self.wall_max = recording.copies("wall_max", motor)[enabled]
        sections = recording.shape.sections
        self.shaped = np.zeros(len(self.wall_min), dtype=np.bool_)
        self.shaper = wave_core.NO_SHAPER
        if sections:
            self.shaped = recording.copies("wall_shaped", motor)[enabled] != 0
            self.shaper = np.hstack([
                recording.copies("shape_coefficient", motor).reshape(sections, -1),
                recording.copies("shape_loss", motor).reshape(sections, -1),
            ])  # fmt: skip
        self.anchor_words = np.array(
            [self.setting(word.name) for word in ports()["anchor_words"]], dtype=np.int64
        )

    def setting(self, name: str) -> int:
        """A setting of this motor, or of the board."""
        found = self.recording.settings.get((name, self.motor))
        return self.recording.setting(name, 0) if found is None else found

    def outcome(self) -> Outcome:
        """The rows, stretch by stretch."""
        stretches = list(self._stretches())
        if not stretches:
            raise HostError(
                f"motor {self.motor} has no control period with the bridges on, so there is "
                "nothing to replay; arm while it is captured"
            )
        found: dict[str, list[tuple[int, int, int]]] = {}
        unchecked: dict[str, str] = {}
        counts: dict[str, int] = {}
        for stretch in stretches:
            words = self._from_start(stretch) if stretch.known else self._midway(stretch, unchecked)
            for name, (rows, model) in words.items():
                recorded = self.rows[name][rows]
                counts[name] = counts.get(name, 0) + len(rows)
                differ = np.flatnonzero(recorded != model)
                found.setdefault(name, []).extend(
                    (int(rows[n]), int(recorded[n]), int(model[n])) for n in differ
                )
        compared = {}
        for name, differences in found.items():
            each = [Difference(*one) for one in differences]
            compared[name] = Compared(
                counts[name], len(each), each[0] if each else None,
                max(each, key=lambda one: one.size) if each else None,
            )  # fmt: skip
        for name in (*WAVES, *OF_ANCHOR):
            if name not in self.rows:
                unchecked[name] = "it wasn't captured"
        periods = sum(stretch.end - stretch.first for stretch in stretches)
        return Outcome(self.motor, periods, compared, unchecked)

    def _stretches(self) -> Iterator[_Stretch]:
        """Rows with steps. In the row in which the bridges go off, its words may be 0 already."""
        on = self.flags["running"]
        edges = np.flatnonzero(np.diff(np.concatenate(([False], on, [False])).astype(np.int8)))
        for first, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            last = end if end == len(on) else end - 1
            ended = np.zeros(last - first, dtype=np.bool_)
            for name in _ENDS:
                ended |= self.flags[name][first:last]
            if ended.any():
                last = first + int(np.argmax(ended))
            if last > first:
                yield _Stretch(first, last, first > 0)

    # ---- All state known.

    def _from_start(self, stretch: _Stretch) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """The model by itself. The first step is of the first row or, mostly, of the second."""
        tries = []
        for first in (stretch.first, stretch.first + 1):
            if first < stretch.end:
                model = self._run(first, stretch.end)
                rows = np.arange(first, stretch.end)
                there = {name: (rows, model[name]) for name in model if name in self.rows}
                bad = [np.flatnonzero(self.rows[name][rows] != column)
                       for name, (_, column) in there.items()]  # fmt: skip
                agrees = min((first + int(n[0]) for n in bad if len(n)), default=stretch.end)
                tries.append((agrees, there))
        return max(tries, key=lambda one: one[0])[1]

    def _run(self, first: int, end: int) -> dict[str, np.ndarray]:
        """Rows of the model whose first step is that of row ``first``."""
        rows, length = self.rows, end - first
        core = wave_core.new_state()
        line = wave_core.new_line((1 << self.recording.shape.delay_log2) - 1)
        held = anchor.new_state()
        states = wave_core.new_shaper_state(len(self.shaper))
        contact = np.array([-1, 0], dtype=np.int64)
        root, a, u_max = (self.setting(name) for name in ("root", "a", "u_max"))
        etas = self.setting("eta_free"), self.setting("eta_contact")
        extra, hold = self.setting("extra_ticks"), self.setting("hold_ticks")
        hysteresis = self.setting("edge_hysteresis") != 0
        model = {name: np.zeros(length, dtype=np.int64) for name in (*WAVES, *OF_ANCHOR)}
        wave_voltage = 0
        for place in range(length):
            n = first + place
            position, current = int(rows["position"][n]), int(rows["current"][n])
            touches, _ = wave_core.contact_step(
                contact, position, self.wall_min, self.wall_max, hysteresis
            )
            withheld = int(core[wave_core.STATE_WITHHELD])
            saturated = bool(core[wave_core.STATE_SATURATED])
            eta = 0 if held[anchor.FAULT] else etas[touches]
            e, u, v = wave_core.shaped_core_step(
                core, line, self.shaper, states, wave_core.shaper_mode(contact[0], self.shaped),
                current, eta, 0, root, a, anchor.left(u_max, held), extra, hold, self._end(n),
            )  # fmt: skip
            correction = int(held[anchor.CORRECTION])
            anchor.anchor_step(
                held, self.anchor_words, position, touches, current, u, v, withheld, wave_voltage,
                saturated, bool(core[wave_core.STATE_CLIPPED]),
            )  # fmt: skip
            wave_voltage = e
            found = {
                "contact": touches, "saturated": saturated, "u": u, "v": v,
                "voltage": wave_core.saturate(e + correction), "correction": correction,
                "offset": held[anchor.OFFSET],
                "flux": held[anchor.CHI] >> formats.LONG_GUARD,
                "lag": held[anchor.LAG] >> formats.LONG_GUARD,
            }  # fmt: skip
            for name, value in found.items():
                model[name][place] = value
        return model

    def _end(self, n: int) -> int:
        """At which end of its range the current of a row is."""
        if not self.flags["adc_range"][n]:
            return 0
        return formats.AT_HIGH if self.rows["current"][n] > 0 else formats.AT_LOW

    # ---- The bridges were on before the first row.

    def _midway(
        self, stretch: _Stretch, unchecked: dict[str, str]
    ) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        rows = self.rows
        anchored = bool(self.anchor_words[anchor.ENABLE])
        begun = "the bridges were on before the first row; capture with --trigger 'flags rises 4'"
        unchecked |= {name: begun for name in OF_ANCHOR if name in rows}
        here = np.arange(stretch.first, stretch.end)
        walls = self._walls(stretch)
        found = {"contact": (here, (walls >= 0).astype(np.int64))}
        if "u" not in rows:
            unchecked |= {
                name: f"{begun}, or capture u" for name in ("v", "voltage") if name in rows
            }
            return found
        u = rows["u"]
        v = np.array([self._v(int(n)) for n in here], dtype=np.int64)
        if "v" in rows:
            found["v"] = here, v
        extra, hold = self.setting("extra_ticks"), self.setting("hold_ticks")
        if "voltage" in rows and ("correction" in rows or not anchored):
            # The u that is applied is seen when its voltage has been.
            later = 1 + extra - hold
            late = here[: max(0, len(here) - later)]
            root, zero = self.setting("root"), np.zeros(len(u), dtype=np.int64)
            shift = formats.ROOT.fraction + formats.WAVE.fraction - formats.VOLTAGE.fraction
            c = rows.get("correction", zero)
            e = [
                wave_core.saturate(
                    wave_core.saturate(wave_core.truncate(root * int(u[n + later]), shift))
                    + int(c[n])
                )
                for n in late
            ]
            if later >= 0:
                found["voltage"] = late, np.array(e, dtype=np.int64)
        if anchored and "correction" not in rows:
            unchecked |= {"u": f"{begun}, or capture correction, its share of the limit"}
            return found
        found["u"] = self._followed(stretch, walls, v)
        return found

    def _v(self, n: int) -> int:
        """v of a row, of its own u and i."""
        state, line = wave_core.new_state(), np.array([0, self.rows["u"][n]], dtype=np.int64)
        state[wave_core.STATE_HEAD], state[wave_core.STATE_FILLED] = 1, 2
        return wave_core.incoming(
            state, line, int(self.rows["current"][n]), self.setting("root"), 0, self._end(n)
        )[1]

    def _walls(self, stretch: _Stretch) -> np.ndarray:
        """The wall that each row is in, -1 for none; with a hysteresis one may be kept at first."""
        hysteresis = self.setting("edge_hysteresis") != 0
        position = self.rows["position"]
        state = np.array([-1, 0], dtype=np.int64)
        first = int(position[stretch.first])
        touches, _ = wave_core.contact_step(state, first, self.wall_min, self.wall_max, False)
        if hysteresis and not touches and self.flags["contact"][stretch.first]:
            near = (self.wall_min - 1 == first) | (self.wall_max == first)
            if near.any():
                state[0] = int(np.argmax(near))
        found = np.empty(stretch.end - stretch.first, dtype=np.int64)
        for place, n in enumerate(range(stretch.first, stretch.end)):
            wave_core.contact_step(
                state, int(position[n]), self.wall_min, self.wall_max, hysteresis
            )
            found[place] = state[0]
        return found

    def _followed(
        self, stretch: _Stretch, walls: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """(rows, u) of the λ filter from row to row, by every state that the u before allows."""
        u = self.rows["u"]
        late = 1 + self.setting("extra_ticks")  # a step's u is that of so many rows later
        a, u_max = self.setting("a"), self.setting("u_max")
        states = wave_core.new_shaper_state(len(self.shaper))
        settled = not self.shaped.any()
        f: np.ndarray | None = None
        at: list[int] = []
        model: list[int] = []
        for n in range(stretch.first, stretch.end - late):
            place = n - stretch.first
            mode = wave_core.shaper_mode(int(walls[place]), self.shaped)
            settled |= mode == wave_core.CLEAR
            wave = int(v[place])
            if settled:
                wave = wave_core.shaper_step(self.shaper, states, mode, wave)
            next_u = int(u[n + late])
            if f is not None and (settled or mode != wave_core.SHAPE):
                eta = self.setting("eta_contact" if walls[place] >= 0 else "eta_free")
                goal = wave_core.saturate(wave_core.truncate(eta * wave, formats.ETA.fraction))
                limit = max(u_max - self._room(n), 0) << _GUARD
                f = self._filtered(f, goal, a, limit)
                reached = np.where(f < 0, -(-f >> _GUARD), f >> _GUARD)
                at.append(n + late)
                near = int(np.argmin(np.abs(reached - next_u)))
                model.append(int(reached[near]))
                f = f[reached == next_u]
            else:
                f = None
            if f is None or not len(f):
                f = _states_of(next_u)
        return np.array(at, dtype=np.int64), np.array(model, dtype=np.int64)

    def _room(self, n: int) -> int:
        """What the anchor takes of the limit of u in the step of row ``n``, raw √W."""
        if not self.anchor_words[anchor.ENABLE] or n == 0 or not self.flags["contact"][n - 1]:
            return 0
        gain = int(self.anchor_words[anchor.ROOM_GAIN])
        return int(anchor.share(gain, int(self.rows["correction"][n - 1])))

    @staticmethod
    def _filtered(f: np.ndarray, goal: int, a: int, limit: int) -> np.ndarray:
        """The next states of the λ filter, int64 of the same shape."""
        error = (goal << _GUARD) - f
        error = np.where(error < 0, -(-error >> _GUARD), error >> _GUARD)
        error = np.clip(error, formats.WAVE.raw_min, formats.WAVE.raw_max)
        step, shift = a * error, formats.A.fraction - _GUARD
        step = np.where(step < 0, -(-step >> shift), step >> shift)
        found: np.ndarray = np.clip(f + step, -limit, limit)
        return found


def _states_of(u: int) -> np.ndarray:
    """Every f that is truncated to u, int64."""
    part = np.arange(_LSB, dtype=np.int64)
    if u > 0:
        return (u << _GUARD) + part
    if u < 0:
        return (u << _GUARD) - part
    return np.concatenate((-part[:0:-1], part))
