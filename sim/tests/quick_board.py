# SPDX-License-Identifier: Apache-2.0
"""A device at a serial line without RTL: the integer wave core with the motor, for many runs.

It has the words that an identification reads and writes, the arming that runs out, and a capture.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import nullcontext

import numpy as np
from wavehaptics.controller import wave_core
from wavehaptics.controller.settings import settings
from wavehaptics.host.client import Identification
from wavehaptics.host.names import Place, Shape
from wavehaptics.motor.imperfections import AMPLIFIED, LAG, LAG_TABLE, MOTOR, real_parts
from wavehaptics.motor.plant import OMEGA, I, X, load_words, plant_step
from wavehaptics.motor.sensor import (
    LAG_RATE,
    NOISE_SEED,
    Sensor,
    disturbed,
    lagged,
    sample_code,
    scale_sum,
)
from wavehaptics.motor.step import motor_step
from wavehaptics.motor.thermal import Winding
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene, drive_gain
from wavehaptics.words import formats, modbus, table

ARMED_S = 0.2
ZERO_TICKS = 1024
"""As ``rtl/wh_arm.v`` and ``rtl/wh_zero.v`` have it."""

CLOCK_HZ = 48e6
STEP_CLOCKS = 1 + 28 + 6 + 24 - 5 - 2
"""From the middle of a tick until its step ends, with the AD7276's frame, but for those that the
encoder's filter and the gates take."""

_SAMPLE_W = formats.SAMPLE_W
_VOLT = formats.VOLTAGE.step
(
    _RUNNING, _ROOT, _A, _U_MAX, _ETA, _EXTRA, _ZERO, _GAIN, _SUBSTEPS, _OPEN, _LINES,
) = range(11)  # fmt: skip
_DT, _CELL, _DRIVE_GAIN, _K_T, _LATE = range(5)


@compiled()
def _ticks(state, core, line, ints, floats, load, matrix, real, sensor, noise, log):
    """Ticks of the loop: u, current and position of each into ``log``, int64 (ticks, 3)."""
    shift = _SAMPLE_W - int(sensor[1])
    dt, substeps = floats[_DT], ints[_SUBSTEPS]
    e_word = core[-1]
    for n in range(log.shape[0]):
        e = e_word * _VOLT * floats[_DRIVE_GAIN]
        off = ints[_RUNNING] == 0 or ints[_OPEN] != 0
        charge = 0.0
        before = 0.0 if real is None else real[LAG][AMPLIFIED]
        for _ in range(substeps):
            start = state[I]
            if off:
                state[I] = 0.0
                e = floats[_K_T] * state[OMEGA]
            if real is None:
                part, _ = plant_step(state, matrix, dt, e, load)
            else:
                part, _ = motor_step(state, matrix, dt, e, load, real[MOTOR])
                if sensor[LAG_RATE] != 0.0:
                    real[LAG][AMPLIFIED] = lagged(
                        real[LAG][AMPLIFIED], start, state[I], part / dt, real[LAG_TABLE][0]
                    )
            charge += part
        tick = dt * substeps
        sensed = 0.0 if off else charge / tick
        if real is not None:
            if sensor[LAG_RATE] != 0.0:
                sensed -= (real[LAG][AMPLIFIED] - before) / (sensor[LAG_RATE] * tick)
            sensed = disturbed(sensed, e, n * tick, sensor)
        total = sample_code(sensed, sensor, noise[n]) << shift
        current = scale_sum(total - ints[_ZERO], ints[_GAIN])
        u = 0
        if ints[_RUNNING] != 0:
            e_word, u, _ = wave_core.wave_core_step(
                core, line, current, ints[_ETA], 0, ints[_ROOT], ints[_A], ints[_U_MAX],
                ints[_EXTRA], ints[_EXTRA],
            )  # fmt: skip
        else:
            e_word = 0
        seen = state[X] + floats[_LATE] * state[OMEGA]
        position = ints[_LINES] * int(np.floor(seen / floats[_CELL]))
        log[n, 0], log[n, 1], log[n, 2] = u, current, position
    core[-1] = e_word


class QuickBoard:
    """A scene's motor behind a device's words; every exchange takes ``exchange_s``.

    ``unplugged`` has no motor at the bridge, ``encoder`` is −1 for A and B in each
    other's place and 0 for one that is silent.
    ``switched`` is a board that a switch alone lets run (ARM = 0).
    """

    def __init__(
        self, scene: Scene, *, exchange_s: float = 2e-3, unplugged: bool = False,
        encoder: int = 1, switched: bool = False,
    ) -> None:  # fmt: skip
        set_ = settings(scene)
        self._tick_s = set_.tick_s
        self._exchange_ticks = max(1, round(exchange_s / self._tick_s))
        plant = Winding(scene, self._tick_s).plant
        substeps = plant.substeps(self._tick_s)
        self._substep_s = dt = self._tick_s / substeps
        sensor = Sensor.of_scene(scene)
        self._sensor = sensor.constants()
        self._state, self._load = plant.start.copy(), load_words(plant)
        self._matrix = plant.transition(dt)
        self._real = real_parts(scene, plant, set_.cell_rad, [dt])
        late_s = STEP_CLOCKS / CLOCK_HZ - 0.5 * self._tick_s
        self._floats = np.array([dt, set_.cell_rad, drive_gain(scene), plant.k_t, late_s])
        self._extra, self._substeps = set_.extra_ticks, substeps
        self._open, self._lines = unplugged, encoder
        self._rng = np.random.default_rng(NOISE_SEED)
        self._reset()
        self.shape = Shape(1, 4, 0, 10)
        options = {"motors": 1, "walls": 4, "delay_log2": 10, "sense": 1, "dead_time": 1,
                   "guard": 1, "arm": int(not switched), "capture": 12}  # fmt: skip
        self.identification = Identification({
            "table": table.crc(), "clock_hz": round(CLOCK_HZ), "motors": 1,
            "options": sum(v << modbus.OPTIONS[k][0] for k, v in options.items()),
        })  # fmt: skip
        half_clocks = round(CLOCK_HZ * self._tick_s)
        gain = sensor.gain_word(1)
        self._words: dict[tuple[str, int], int] = {}
        values = {"half_clocks": half_clocks, "tick_halves": 1, "samples": 1,
                  "sample_clocks": half_clocks, "gain": gain,
                  "extra_ticks": set_.extra_ticks, **set_.words(), "anchor_words": 0,
                  "wall_min": [0] * 4, "wall_max": [0] * 4, "wall_enable": [0] * 4}  # fmt: skip
        for word in table.WORDS.values():
            value = values.get(word.name, word.default)
            for index, raw in enumerate(value if isinstance(value, list) else [value] * 64):
                self._words[word.name, index] = int(raw)
        self._measured_zero = 0
        self._armed_until = -1
        self._refused = 0
        self._now = 0
        self._switched = switched
        self.reach = (self.turned, self.turned)
        self._log: list[np.ndarray] | None = None
        self._data: list[int] = []
        self._last = np.zeros(3, dtype=np.int64)
        if switched:
            self._arm(1)
        self._pass(1)

    def _reset(self) -> None:
        self._core = np.append(wave_core.new_state(), 0)
        self._line = wave_core.new_line(self._extra)

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return self._now * self._tick_s

    @property
    def turned(self) -> float:
        """Where the rotor is, rad."""
        return float(self._state[X])

    def spin(self, omega: float) -> None:
        """The rotor's speed from now on, rad/s."""
        self._state[OMEGA] = omega

    @property
    def current(self) -> float:
        """What flows, A."""
        return float(self._state[I])

    @property
    def settings(self) -> dict[tuple[str, int], int]:
        """Raw words by name and index."""
        return self._words

    @property
    def running(self) -> bool:
        """Whether the bridges are on."""
        return self._switched or self._now < self._armed_until

    def _pass(self, ticks: int) -> None:
        while ticks > 0:
            part = min(ticks, 1_000)
            if not self._switched and self.running:
                part = min(part, self._armed_until - self._now)
            if not self.running:
                self._reset()
            w = self._words
            zero = w["zero", 0] + self._measured_zero
            ints = np.array(
                [self.running, w["root", 0], w["a", 0], w["u_max", 0], w["eta_free", 0],
                 self._extra, zero, w["gain", 0], self._substeps, self._open, self._lines],
                dtype=np.int64,
            )  # fmt: skip
            log = np.zeros((part, 3), dtype=np.int64)
            noise = self._rng.standard_normal(part)
            _ticks(self._state, self._core, self._line, ints, self._floats, self._load,
                   self._matrix, self._real, self._sensor, noise, log)  # fmt: skip
            if self._log is not None:
                self._log.append(log)
            self._last = log[-1]
            self.reach = min(self.reach[0], self.turned), max(self.reach[1], self.turned)
            self._now += part
            ticks -= part

    def _arm(self, value: int) -> None:
        armed = self.running
        if value == 1 and not armed:
            zero = self._words["zero", 0]
            self._words["zero", 0], kept, self._log = 0, self._log, []
            self._measured_zero = 0
            self._pass(ZERO_TICKS)
            currents = np.concatenate(self._log)[:, 1]
            self._log = kept
            gain = formats.GAIN.to_value(self._words["gain", 0])
            mean = currents.mean() * formats.CURRENT.step / gain
            self._measured_zero = round(mean)
            self._words["zero", 0] = zero
            armed = True
        if value == 0:
            self._armed_until = -1
        elif armed:
            self._armed_until = self._now + round(ARMED_S / self._tick_s)
            self._refused = 0

    # ---- What a host sees.

    def read(self, places: Iterable[Place]) -> list[int]:
        """As a client."""
        self._pass(self._exchange_ticks)
        live = {"running": int(self.running), "armed": int(self.running), "faults": 0,
                "arm_refused": 0 if self.running else 1 << 4, "ticks": self._now,
                "current": int(self._last[1]), "position": int(self._last[2])}  # fmt: skip
        wanted = list(places)
        if any(p.word.name.startswith("capture_") for p in wanted):
            self._captured()
        offset = self._words["capture_offset", 0]
        raws = []
        for p in wanted:
            name, at = p.word.name, offset + p.index
            if name == "capture_data":
                raws.append(self._data[at] if at < len(self._data) else 0)
            else:
                raws.append(live.get(name, self._words.get((name, p.index), 0)))
        return [raw & 0xFFFFFFFF for raw in raws]

    def write(self, words: Iterable[tuple[Place, int]]) -> int:
        """As a client."""
        self._pass(self._exchange_ticks)
        for place, raw in words:
            if place.word.name == "arm":
                self._arm(raw)
            elif place.word.name == "capture":
                self._capture(raw)
            else:
                self._words[place.word.name, place.index] = raw
        return 1

    def hurry(self) -> nullcontext:
        """As a client."""
        return nullcontext()

    def _capture(self, value: int) -> None:
        if value == 1:
            self._log, self._words["capture_state", 0] = [], 1

    def _captured(self) -> None:
        """The words of a capture that was started, as ``rtl/wh_capture.v`` has them."""
        if self._log is None:
            return
        w = self._words
        every, rows = 1 << w["capture_decimation", 0], w["capture_rows", 0]
        before = w["capture_pre", 0]
        log = np.concatenate([np.zeros((0, 3), dtype=np.int64), *self._log])
        self._log = [log]
        count = len(log) // every
        blocks = log[: count * every].reshape(count, every, 3)
        # The columns of the log by the addresses of their words.
        columns = {table.WORDS[name].at(): n for n, name in enumerate(("u", "current", "position"))}
        chosen = [columns[w["capture_channel", n]] for n in range(w["capture_channels", 0])]
        found = np.where(np.arange(3) == 2, blocks[:, -1], blocks.sum(axis=1) // every)[:, chosen]
        level, kind = w["capture_level", 0], w["capture_trigger", 0]
        hits = found[:, 0] >= level if kind == 1 else found[:, 0] < level
        hits[:before] = False
        hits |= kind == 0
        first = int(np.argmax(hits)) - before if hits.any() else max(0, count - before)
        kept = found[first : first + rows]
        left = rows - len(kept) if hits.any() else rows - before
        w["capture_state", 0] = 4 if left == 0 else 3 if hits.any() else 2 if count >= before else 1
        w["capture_count", 0], w["capture_left", 0] = len(kept), left
        self._data = kept.ravel().tolist()
        if left == 0:
            self._log = None
