# SPDX-License-Identifier: Apache-2.0
"""The controllers ``golden`` and ``core``: the wave core with the motor, one step in each tick.

The drive is averaged: it holds e_n for a tick. One loop serves both. Only the step differs: the
integer model, or the Verilated RTL behind its C interface.
"""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np

from wavehaptics.controller import anchor, host_link, wave_core
from wavehaptics.controller.settings import Settings, settings
from wavehaptics.ladder import verilated
from wavehaptics.motor.imperfections import (
    AMPLIFIED,
    LAG,
    LAG_TABLE,
    MOTOR,
    Real,
    amplified,
    counted,
    real_parts,
    supplied,
    warm_real,
)
from wavehaptics.motor.plant import TIME, C, I, P, Plant, X, load_words, plant_step
from wavehaptics.motor.sensor import (
    LAG_RATE,
    NOISE_SEED,
    Sensor,
    current_word,
    draw_noise,
    lagged,
    noise_at,
    range_ends,
)
from wavehaptics.motor.step import motor_step
from wavehaptics.motor.thermal import Winding
from wavehaptics.runtime.compiled import compiled
from wavehaptics.runtime.native_call import call2
from wavehaptics.scene import Scene, drive_gain, encoder_end
from wavehaptics.trace.columns import Word, put_anchor, put_estimate, put_motion, put_port
from wavehaptics.words import formats

CORE_DELAY_LOG2 = 10
"""Delay line of the simulated core: up to 2**10 - 1 ticks of extra latency."""

_VOLT = formats.VOLTAGE.step
_ROOT_WATT = formats.WAVE.step
_ETA = formats.ETA.step
_LONG_GUARD = formats.LONG_GUARD

# Indices of the loop's integer parameters.
(
    _A, _EXTRA, _ETA_CONTACT, _ETA_FREE, _SUBSTEPS, _POINT, _MODEL, _STEP, _HYSTERESIS, _ROOT,
    _U_MAX,
) = range(11)  # fmt: skip
# Indices of the loop's float parameters.
_DT, _CELL, _DRIVE_GAIN, _K_T, _RESISTANCE, _ENCODER_END = range(6)
# Indices of the loop's integer state.
_VOLTAGE_WORD, _CLOCKS, _POSITION, _WAVE_VOLTAGE, _CORRECTION, _SEQUENCE, _MEAN_V = range(7)


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _advance(
    rows: np.ndarray, words: np.ndarray, state: np.ndarray, kept: np.ndarray, core: np.ndarray,
    line: np.ndarray, contact: np.ndarray, wall_min: np.ndarray, wall_max: np.ndarray,
    shaper: tuple[Any, ...], anchored: tuple[Any, ...] | None, host: tuple[Any, ...] | None,
    ints: np.ndarray, floats: np.ndarray, load: np.ndarray, matrix: np.ndarray, real: Real | None,
    sensor: np.ndarray, noise: np.ndarray, buffer: np.ndarray,
) -> bool:  # fmt: skip
    """Fill ``rows`` and ``words``; False if the RTL didn't answer.

    ``shaper`` holds W's coefficients, its states and which walls it shapes, ``anchored`` the
    settings and state of a port anchor or None, ``host`` a link's state, period and timeout or
    None, ``real`` the errors of :mod:`wavehaptics.motor.imperfections` or None.
    """
    shaper_words, shaper_states, shaped = shaper
    dt, cell, k_t = floats[_DT], floats[_CELL], floats[_K_T]
    substeps, root, u_max = ints[_SUBSTEPS], ints[_ROOT], ints[_U_MAX]
    tick = dt * substeps
    for n in range(rows.shape[0]):
        e_a = kept[_VOLTAGE_WORD] * _VOLT * floats[_DRIVE_GAIN]
        sag = 0.0
        if real is not None:
            e_a, sag = supplied(e_a, state[TIME], real)
        x_before, i_before = state[X], state[I]
        hand_before, t_before = state[P] + state[C], state[TIME]
        charge = 0.0
        square = 0.0
        low, high = i_before, i_before
        lag_before = 0.0 if real is None else real[LAG][AMPLIFIED]
        for _ in range(substeps):
            i_start = state[I]
            if real is None:
                part, part_square = plant_step(state, matrix, dt, e_a, load)
            else:
                part, part_square = motor_step(state, matrix, dt, e_a, load, real[MOTOR])
                if sensor[LAG_RATE] != 0.0:
                    real[LAG][AMPLIFIED] = lagged(
                        real[LAG][AMPLIFIED], i_start, state[I], part / dt, real[LAG_TABLE][0]
                    )
            charge += part
            square += part_square
            low, high = min(low, state[I]), max(high, state[I])
        mean = charge / tick
        sensed = state[I] if ints[_POINT] else mean
        if real is not None:
            sensed = amplified(
                sensed, ints[_POINT], lag_before, tick, e_a, state[TIME], sensor, real
            )
        current = current_word(sensed, sensor, noise_at(noise, n))
        ends = range_ends(current, sensor)
        if real is not None:
            kept[_POSITION] = counted(
                kept[_POSITION], state[X], state[TIME], cell, floats[_ENCODER_END], real
            )
        elif state[TIME] < floats[_ENCODER_END]:
            kept[_POSITION] = int(np.floor(state[X] / cell))
        position = kept[_POSITION]
        touching, _ = wave_core.contact_step(
            contact, position, wall_min, wall_max, ints[_HYSTERESIS] != 0
        )
        eta = ints[_ETA_CONTACT] if touching else ints[_ETA_FREE]
        raw, goal, shown = current, 0, touching
        if host is not None:
            shown = host[0][host_link.ACTIVE] != 0
            touching = touching or shown
            if shown:
                eta, goal = 0, host[0][host_link.U]
        correction = 0
        left = u_max
        if anchored is not None:
            held = anchored[1]
            current = wave_core.saturate(current - held[anchor.OFFSET])
            left = anchor.left(u_max, held)
            if held[anchor.FAULT] != 0:
                eta, goal = 0, 0
        mode = wave_core.shaper_mode(contact[0], shaped)
        if ints[_MODEL] == 0:
            withheld = core[wave_core.STATE_WITHHELD]
            saturated = core[wave_core.STATE_SATURATED] != 0
            e_next, u_n, v_n = wave_core.core_step(
                core, line, shaper_words, shaper_states, mode, current, eta, goal, root, ints[_A],
                left, ints[_EXTRA], ends,
            )  # fmt: skip
            if host is not None:
                sent, number, packet = host_link.tick(host[0], v_n, host[1], host[2])
                if sent:
                    kept[_SEQUENCE], kept[_MEAN_V] = number, packet
            if anchored is not None:
                held = anchored[1]
                correction = held[anchor.CORRECTION]
                anchor.anchor_step(
                    held, anchored[0], position, touching, current, u_n, v_n, withheld,
                    kept[_WAVE_VOLTAGE], saturated, core[wave_core.STATE_CLIPPED] != 0,
                )  # fmt: skip
                kept[_WAVE_VOLTAGE] = e_next
                e_next = wave_core.saturate(e_next + correction)
        else:
            buffer[0], buffer[1], buffer[2] = raw, touching, mode
            buffer[3], buffer[4] = position, ends
            clocks = call2(ints[_STEP], ints[_MODEL], buffer.ctypes.data)
            if clocks < 0:
                return False
            kept[_CLOCKS] += clocks
            e_next, u_n, v_n = buffer[0], buffer[1], buffer[2]
            if anchored is not None:
                held = anchored[1]
                correction = held[anchor.CORRECTION]
                held[anchor.CORRECTION], held[anchor.OFFSET] = buffer[3], buffer[4]
                held[anchor.CHI] = buffer[5] << _LONG_GUARD
                held[anchor.LAG] = buffer[6] << _LONG_GUARD
                held[anchor.FAULT] = buffer[7]
        row = rows[n]
        put_motion(
            row, t_before, tick, x_before, state[X], mean, e_a - sag * mean, k_t * mean,
            0.5 * (hand_before + state[P] + state[C]),
            e_a * charge - floats[_RESISTANCE] * square, high - low,
        )  # fmt: skip
        limited = abs(u_n) >= u_max
        if anchored is not None:  # whose limit varies from tick to tick
            limited = (core[wave_core.STATE_SATURATED] if ints[_MODEL] == 0 else buffer[8]) != 0
        clipped = (core[wave_core.STATE_CLIPPED] if ints[_MODEL] == 0 else buffer[9]) != 0
        put_port(row, eta * _ETA, u_n * _ROOT_WATT, v_n * _ROOT_WATT, shown, limited, clipped)
        if anchored is not None:
            held = anchored[1]
            put_anchor(row, kept[_CORRECTION] * _VOLT, held[anchor.FAULT])
            kept[_CORRECTION] = correction
            chi = (held[anchor.CHI] >> _LONG_GUARD) * anchor.SEEN_CELLS
            lag = (held[anchor.LAG] >> _LONG_GUARD) * anchor.SEEN_CELLS
            omega_hat = lag * cell / (anchor.FOLLOWER_TICKS * tick)
            put_estimate(row, chi, (position + 0.5 - chi) * cell, omega_hat)
        words[n, Word.I] = current
        words[n, Word.U] = u_n
        words[n, Word.V] = v_n
        words[n, Word.E] = e_next
        kept[_VOLTAGE_WORD] = e_next
    return True


class SampledSimulation:
    """A scene on the wave core, tick by tick, with an averaged drive.

    ``rtl`` takes the Verilated core instead of the integer model. ``point_sampling`` gives the
    sensor the current at the tick's end instead of the mean: only to show what that breaks:
    such a port can give out energy. ``host`` is (state, log2 of the period in ticks, timeout) of a
    link to a host, whose answers are the integer model's goals.
    """

    def __init__(
        self, scene: Scene, *, rtl: bool, point_sampling: bool = False,
        host: tuple[np.ndarray, int, int] | None = None,
    ) -> None:  # fmt: skip
        self.settings: Settings = settings(scene) if host is None else settings(scene).for_a_host()
        self.tick_s = self.settings.tick_s
        self.winding = Winding(scene, self.tick_s)
        plant = self.winding.plant
        set_ = self.settings
        substeps = plant.substeps(self.tick_s)
        dt = self.tick_s / substeps
        gain = drive_gain(scene)
        self._library = None
        self._model = 0
        step = 0
        if rtl:
            self._library, self._model, step = load_core(set_)
        self._state = plant.start.copy()
        self._host = host
        self._kept = np.zeros(7, dtype=np.int64)
        self._kept[_POSITION] = math.floor(plant.start[X] / set_.cell_rad)
        self._core = wave_core.new_state()
        self._line = wave_core.new_line(set_.extra_ticks)
        self._shaper = (
            set_.shaper.words, wave_core.new_shaper_state(len(set_.shaper.words)), set_.shaped
        )  # fmt: skip
        self._contact = np.array([-1, 0], dtype=np.int64)
        self._ints = np.array(
            [set_.a, set_.extra_ticks, set_.eta_contact, set_.eta_free, substeps, point_sampling,
             self._model, step, set_.edge_hysteresis, set_.root, set_.u_max],
            dtype=np.int64,
        )  # fmt: skip
        self._floats = np.array(
            [dt, set_.cell_rad, gain, plant.k_t, plant.resistance, encoder_end(scene)]
        )
        self._load = load_words(plant)
        self._dt = dt
        self._matrix = plant.transition(dt)
        self._real = real_parts(scene, plant, set_.cell_rad, [dt])
        self._sensor = Sensor.of_scene(scene).constants()
        self._rng = np.random.default_rng(NOISE_SEED)
        self._buffer = np.zeros(10, dtype=np.int64)
        self._anchored = (set_.anchor, anchor.new_state()) if set_.anchored else None

    @property
    def clock_cycles(self) -> int | None:
        """Clocks of the RTL so far; None on the integer model, which has no clock."""
        return int(self._kept[_CLOCKS]) if self._model else None

    @property
    def packet(self) -> tuple[int, int]:
        """Number and mean wave v, as a word, of the newest packet to the host."""
        return int(self._kept[_SEQUENCE]), int(self._kept[_MEAN_V])

    def advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column) and ``words`` (Word)."""
        self.winding.advance(rows, lambda part: self._advance(rows[part], words[part]), self._warm)

    def _warm(self, plant: Plant) -> None:
        self._matrix = plant.transition(self._dt)
        self._load = load_words(plant)
        self._floats[_RESISTANCE], self._floats[_K_T] = plant.resistance, plant.k_t
        warm_real(self._real, plant)

    def _advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        done = _advance(
            rows, words, self._state, self._kept, self._core, self._line, self._contact,
            self.settings.wall_min, self.settings.wall_max, self._shaper, self._anchored,
            self._host, self._ints, self._floats, self._load, self._matrix, self._real,
            self._sensor, draw_noise(self._rng, self._sensor, len(rows)), self._buffer,
        )  # fmt: skip
        if not done:
            raise RuntimeError("the wave core's RTL never raised valid_o")

    def __del__(self) -> None:
        if getattr(self, "_model", 0) and self._library is not None:
            self._library.wh_core_delete(self._model)


def core_design(set_: Settings) -> verilated.Design:
    """The core's RTL for these settings."""
    sizes = {
        "DELAY_LOG2": CORE_DELAY_LOG2,
        "SHAPER": len(set_.shaper.words),
        "ANCHOR": int(set_.anchored),
    }
    return verilated.Design("wh_core_port", "core_shim.cpp", sizes)


def core_words(set_: Settings, **others: int) -> ctypes.Array[ctypes.c_uint32]:
    """The settings as the core's shim takes them, and ``others`` in place of some."""
    words = {**set_.words(), "hold_ticks": set_.extra_ticks, **others}
    return verilated.words_of(core_design(set_), words)


def load_core(set_: Settings) -> tuple[ctypes.CDLL, int, int]:
    """(library, a model, address of its step) of the core's RTL with these settings."""
    library = verilated.load(core_design(set_))
    verilated.declare_destructor(library.wh_core_delete)
    model = verilated.new_model(library.wh_core_new, core_words(set_))
    return library, model, verilated.address(library.wh_core_step)
