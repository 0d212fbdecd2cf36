# SPDX-License-Identifier: Apache-2.0
"""The controllers ``analog``, ``golden`` and ``core`` of a brushless motor: two ports, α and β.

Each axis of the stationary frame has a port of its own, of the same words, and none knows the
rotor's angle: the encoder's count only says which η both have. A port anchor is one for each axis;
it alone is told the electrical angle. A row's ``i`` is the current that
the torque is k_T times of, its ``e_a``, ``u`` and ``v`` are the parts of both axes along q at the
tick's middle, and the raw words are those of port α. One loop serves ``golden`` and ``core``: its
steps are those of the integer model, or of the Verilated core with two ports. W is the same on
both axes, each with states of its own.

The voltage limit is each axis' own. The converter measures the phases a and b. What a scene
can't have here yet is refused (:mod:`wavehaptics.ladder.abilities`).
"""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np

from wavehaptics.controller import anchor, clarke, magnet_angle, rotor_flux, wave_core
from wavehaptics.controller.settings import Settings, settings
from wavehaptics.ladder import verilated
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.analog import CONTACT, FREE, HALVINGS, LIMITED, MODE_CHANGES, inside
from wavehaptics.ladder.sampled import core_design
from wavehaptics.laws import closed_forms
from wavehaptics.motor.absolute import PERIOD_S, absolute_count, new_readings, reading_words
from wavehaptics.motor.brushless import (
    ENERGY,
    F_A,
    F_B,
    I_A,
    I_B,
    IMPULSE,
    Q_A,
    Q_B,
    QF_A,
    QF_B,
    BrushlessPlant,
    along_q,
    brushless_step,
    electrical_angle,
)
from wavehaptics.motor.plant import K_T, TIME, C, I, P, X
from wavehaptics.motor.sensor import (
    NOISE_SEED,
    Sensor,
    current_word,
    draw_noise,
    noise_at,
    range_ends,
)
from wavehaptics.runtime.compiled import compiled
from wavehaptics.runtime.native_call import call2
from wavehaptics.scene import Scene, drive_gain, without_anchor
from wavehaptics.trace.columns import Word, put_anchor, put_estimate, put_motion, put_port
from wavehaptics.words import formats

_VOLT = formats.VOLTAGE.step
_ROOT_WATT = formats.WAVE.step
_ETA = formats.ETA.step
_ROOT3 = math.sqrt(3.0)

# Places in the sampled loop's integer parameters, in its float parameters and in what it keeps.
(
    _A, _EXTRA, _ETA_CONTACT, _ETA_FREE, _SUBSTEPS, _HYSTERESIS, _ROOT, _U_MAX, _MODEL, _STEP,
) = range(10)  # fmt: skip
_CELL, _GAIN = range(2)
_VOLTAGE_A, _VOLTAGE_B, _CLOCKS, _WAVE_A, _WAVE_B, _C_A, _C_B = range(7)

# Places in the analog circuits' parameters and in what they keep: whether the rotor is in a wall,
# and the sign of the limit that holds each axis' f.
_TICK, _S, _DRIVE, _LIMIT, _CONTACT_ETA, _FREE_ETA = range(6)
_TOUCHING, _SIDE_A, _SIDE_B = range(3)


@compiled(inline="always")
def clear_sums(z: np.ndarray) -> None:
    """Begin a tick's sums."""
    z[Q_A] = z[Q_B] = z[QF_A] = z[QF_B] = z[IMPULSE] = z[ENERGY] = 0.0


@compiled(inline="always")
def put_axes(
    row: np.ndarray, z: np.ndarray, load: np.ndarray, begin: float, tick: float, before: float,
    hand: float, e_a: float, e_b: float, ripple: float,
) -> float:  # fmt: skip
    """The motor's part of a tick's row, of the sums since its beginning and the mean voltages.

    Returns the electrical angle at its middle, along whose q a row has the axes' waves.
    """
    theta = electrical_angle(0.5 * (before + z[X]), load)
    torque = z[IMPULSE] / tick
    put_motion(
        row, begin, tick, before, z[X], torque / load[K_T], along_q(e_a, e_b, theta),
        torque, 0.5 * (hand + z[P] + z[C]), z[ENERGY], ripple,
    )  # fmt: skip
    return theta


@compiled(inline="always")
def _seen(word: int) -> float:
    """Cells of a long word as the RTL shows it."""
    return (word >> formats.LONG_GUARD) * anchor.SEEN_CELLS


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _advance_sampled(
    rows: np.ndarray, words: np.ndarray, z: np.ndarray, kept: np.ndarray, ports: np.ndarray,
    lines: np.ndarray, contact: np.ndarray, wall_min: np.ndarray, wall_max: np.ndarray,
    shaper: tuple[Any, ...], anchored: tuple[Any, ...] | None, ints: np.ndarray, floats: np.ndarray,
    load: np.ndarray, table: np.ndarray, step: np.ndarray, sensor: np.ndarray, noise: np.ndarray,
    buffer: np.ndarray, reader: tuple[np.ndarray, ...] | None,
) -> bool:  # fmt: skip
    """Fill ``rows`` and ``words``; False when the RTL never answered.

    ``shaper`` holds the words of W, both axes' states and which walls it is for. ``anchored`` has
    an anchor's words, both axes' states, what a count turns, table and state of the flux that the
    encoder tells of, an anchor's words without a say, and the state of what finds the magnets; None
    without one.
    """
    shaper_words, shaper_states, shaped = shaper
    substeps, extra, root, u_max = ints[_SUBSTEPS], ints[_EXTRA], ints[_ROOT], ints[_U_MAX]
    tick = step[0] * substeps
    for n in range(rows.shape[0]):
        leg_a, leg_b, leg_c = clarke.phases(kept[_VOLTAGE_A], kept[_VOLTAGE_B])
        volt = floats[_GAIN] * _VOLT
        e_a = volt * (2 * leg_a - leg_b - leg_c) / 3.0
        e_b = volt * (leg_b - leg_c) / _ROOT3
        before, hand = z[X], z[P] + z[C]
        clear_sums(z)
        z[F_A], z[F_B] = e_a, e_b
        low, high = z[I], z[I]
        for _ in range(substeps):
            brushless_step(z, table, table, step, load)
            low, high = min(low, z[I]), max(high, z[I])
        mean_a, mean_b = z[Q_A] / tick, z[Q_B] / tick
        phase_a = current_word(mean_a, sensor, noise_at(noise, 2 * n))
        phase_b = current_word(0.5 * (_ROOT3 * mean_b - mean_a), sensor, noise_at(noise, 2 * n + 1))
        alpha, beta = clarke.currents(phase_a, phase_b)
        ends_a = range_ends(phase_a, sensor)
        ends_b = ends_a | range_ends(phase_b, sensor) | clarke.ends(beta)
        if reader is None:
            position = int(np.floor(z[X] / floats[_CELL]))
        else:
            position = absolute_count(z[X], z[TIME], floats[_CELL], reader[0], reader[1])
        touching, _ = wave_core.contact_step(
            contact, position, wall_min, wall_max, ints[_HYSTERESIS] != 0
        )
        eta = ints[_ETA_CONTACT] if touching else ints[_ETA_FREE]
        mode = wave_core.shaper_mode(contact[0], shaped)
        raw_a, raw_b = alpha, beta
        left_a = left_b = u_max
        if anchored is not None:
            held_a, held_b = anchored[1][0], anchored[1][1]
            alpha = wave_core.saturate(alpha - held_a[anchor.OFFSET])
            beta = wave_core.saturate(beta - held_b[anchor.OFFSET])
            left_a = anchor.left(u_max, held_a)
            left_b = anchor.left(u_max, held_b)
            if held_a[anchor.FAULT] != 0 or held_b[anchor.FAULT] != 0:
                eta = 0
        if ints[_MODEL] == 0:
            withheld_a = ports[0, wave_core.STATE_WITHHELD]
            withheld_b = ports[1, wave_core.STATE_WITHHELD]
            saturated_a = ports[0, wave_core.STATE_SATURATED] != 0
            saturated_b = ports[1, wave_core.STATE_SATURATED] != 0
            next_a, u_a, v_a = wave_core.core_step(
                ports[0], lines[0], shaper_words, shaper_states[0], mode, alpha, eta, 0, root,
                ints[_A], left_a, extra, ends_a,
            )  # fmt: skip
            next_b, u_b, v_b = wave_core.core_step(
                ports[1], lines[1], shaper_words, shaper_states[1], mode, beta, eta, 0, root,
                ints[_A], left_b, extra, ends_b,
            )  # fmt: skip
            if anchored is not None:
                gains, _, turn, sines, rotor, blind, magnet = anchored
                finds = magnet[magnet_angle.KNOWN] == 0
                if finds:
                    gains = blind
                c_a, c_b = held_a[anchor.CORRECTION], held_b[anchor.CORRECTION]
                rotor_flux.rotor_flux_step(rotor, turn, sines, position)
                anchor.anchor_axis_step(
                    held_a, gains, position, rotor[rotor_flux.PLACE_A], rotor[rotor_flux.CELL_A],
                    touching, alpha, u_a, v_a, withheld_a, kept[_WAVE_A], saturated_a,
                    ports[0, wave_core.STATE_CLIPPED] != 0,
                )  # fmt: skip
                anchor.anchor_axis_step(
                    held_b, gains, position, rotor[rotor_flux.PLACE_B], rotor[rotor_flux.CELL_B],
                    touching, beta, u_b, v_b, withheld_b, kept[_WAVE_B], saturated_b,
                    ports[1, wave_core.STATE_CLIPPED] != 0,
                )  # fmt: skip
                if finds:
                    by = magnet_angle.magnet_angle_step(
                        magnet, turn, gains[anchor.SLOW_TICKS], position, touching,
                        rotor[rotor_flux.CELL_A], rotor[rotor_flux.CELL_B],
                        held_a[anchor.CHI] >> formats.LONG_GUARD,
                        held_b[anchor.CHI] >> formats.LONG_GUARD,
                    )  # fmt: skip
                    rotor_flux.turn_by(rotor, by)
                    if magnet[magnet_angle.KNOWN] != 0:
                        anchor.reset(held_a)
                        anchor.reset(held_b)
                kept[_WAVE_A], kept[_WAVE_B] = next_a, next_b
                next_a = wave_core.saturate(next_a + c_a)
                next_b = wave_core.saturate(next_b + c_b)
        else:
            buffer[0], buffer[1], buffer[2], buffer[3] = raw_a, raw_b, touching, position
            buffer[4], buffer[5] = mode == wave_core.SHAPE, ends_a | ends_b << 2
            clocks = call2(ints[_STEP], ints[_MODEL], buffer.ctypes.data)
            if clocks < 0:
                return False
            kept[_CLOCKS] += clocks
            next_a, u_a, v_a = buffer[0], buffer[1], buffer[2]
            next_b, u_b, v_b = buffer[3], buffer[4], buffer[5]
            if anchored is not None:
                c_a, c_b = held_a[anchor.CORRECTION], held_b[anchor.CORRECTION]
                for axis in range(2):
                    held = anchored[1][axis]
                    held[anchor.CORRECTION] = buffer[6 + axis]
                    held[anchor.OFFSET] = buffer[8 + axis]
                    held[anchor.CHI] = buffer[10 + axis] << formats.LONG_GUARD
                    held[anchor.LAG] = buffer[12 + axis] << formats.LONG_GUARD
                    held[anchor.FAULT] = buffer[14]
        theta = put_axes(rows[n], z, load, z[TIME] - tick, tick, before, hand, e_a, e_b, high - low)
        u = along_q(u_a, u_b, theta) * _ROOT_WATT
        v = along_q(v_a, v_b, theta) * _ROOT_WATT
        bounded, clipped = buffer[15] != 0, buffer[16] != 0
        if ints[_MODEL] == 0:
            one, other = ports[0], ports[1]
            bounded = (one[wave_core.STATE_SATURATED] | other[wave_core.STATE_SATURATED]) != 0
            clipped = (one[wave_core.STATE_CLIPPED] | other[wave_core.STATE_CLIPPED]) != 0
        limited = abs(u_a) >= u_max or abs(u_b) >= u_max
        if anchored is not None:  # whose limit is not the same in every tick
            limited = bounded
        put_port(rows[n], eta * _ETA, u, v, touching, limited, clipped)
        if anchored is not None:
            fault = held_a[anchor.FAULT] != 0 or held_b[anchor.FAULT] != 0
            put_anchor(rows[n], along_q(kept[_C_A], kept[_C_B], theta) * _VOLT, fault)
            kept[_C_A], kept[_C_B] = c_a, c_b
            chi = along_q(_seen(held_a[anchor.CHI]), _seen(held_b[anchor.CHI]), theta)
            lag = along_q(_seen(held_a[anchor.LAG]), _seen(held_b[anchor.LAG]), theta)
            cell = floats[_CELL]
            omega_hat = lag * cell / (anchor.FOLLOWER_TICKS * tick)
            put_estimate(rows[n], chi, (position + 0.5 - chi) * cell, omega_hat)
        words[n, Word.I] = alpha
        words[n, Word.U] = u_a
        words[n, Word.V] = v_a
        words[n, Word.E] = next_a
        kept[_VOLTAGE_A], kept[_VOLTAGE_B] = next_a, next_b
    return True


class BrushlessSimulation:
    """A scene's brushless motor on a wave core with two ports, with an averaged drive.

    ``rtl`` takes the Verilated core instead of the integer model.
    """

    def __init__(self, scene: Scene, *, rtl: bool) -> None:
        refuse(scene, "core" if rtl else "golden")
        self._library = None
        self._model = step = 0
        self.settings = set_ = settings(scene)
        self.tick_s = set_.tick_s
        plant = BrushlessPlant.of_scene(scene)
        substeps = plant.substeps(self.tick_s)
        dt = self.tick_s / substeps
        position = math.floor(plant.plant.start[X] / set_.cell_rad)
        turn, zero = rotor_angles(scene, set_, position)
        if rtl:
            angles = (position, zero, turn, int(scene.controller.find_magnet))
            self._library, self._model, step = _load_axes(set_, *angles)
        self._z = plant.start
        self._kept = np.zeros(7, dtype=np.int64)
        known = not scene.controller.find_magnet
        self._anchored = _anchors(set_, position, zero, turn, known) if set_.anchored else None
        self._buffer = np.zeros(17, dtype=np.int64)
        self._ports = np.stack([wave_core.new_state() for _ in range(2)])
        self._lines = np.stack([wave_core.new_line(set_.extra_ticks) for _ in range(2)])
        sections = len(set_.shaper.words)
        states = np.stack([wave_core.new_shaper_state(sections) for _ in range(2)])
        self._shaper = (set_.shaper.words, states, set_.shaped)
        self._contact = np.array([-1, 0], dtype=np.int64)
        self._ints = np.array(
            [set_.a, set_.extra_ticks, set_.eta_contact, set_.eta_free, substeps,
             set_.edge_hysteresis, set_.root, set_.u_max, self._model, step],
            dtype=np.int64,
        )  # fmt: skip
        self._floats = np.array([set_.cell_rad, drive_gain(scene)])
        self._load = plant.words()
        reading = reading_words(scene)
        readings = new_readings(plant.plant.start[X], set_.cell_rad, reading)
        self._reader = (reading, readings) if reading[PERIOD_S] else None
        self._table, self._step = plant.axis_table(dt), plant.step_words(dt)
        self._sensor = Sensor.of_scene(scene).constants()
        self._rng = np.random.default_rng(NOISE_SEED)

    @property
    def clock_cycles(self) -> int | None:
        """Clocks of the RTL so far; None on the integer model, which has no clock."""
        return int(self._kept[_CLOCKS]) if self._model else None

    def advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column) and ``words`` (Word)."""
        done = _advance_sampled(
            rows, words, self._z, self._kept, self._ports, self._lines, self._contact,
            self.settings.wall_min, self.settings.wall_max, self._shaper, self._anchored,
            self._ints, self._floats, self._load, self._table, self._step, self._sensor,
            draw_noise(self._rng, self._sensor, 2 * len(rows)), self._buffer, self._reader,
        )  # fmt: skip
        if not done:
            raise RuntimeError("the wave core's RTL never raised valid_o")

    def __del__(self) -> None:
        if getattr(self, "_model", 0) and self._library is not None:
            self._library.wh_axes_delete(self._model)


def rotor_angles(scene: Scene, set_: Settings, position: int) -> tuple[int, int]:
    """Words of the angle by which a count turns the magnets, and of θ at a position in counts."""
    pairs = scene.motor.pole_pairs
    assert pairs is not None
    magnet = scene.controller.magnet_hat_rad
    return (
        rotor_flux.count_word(pairs, set_.cell_rad),
        rotor_flux.zero_word(pairs, set_.cell_rad, magnet, position),
    )


def magnet_words(scene: Scene, set_: Settings, position: int) -> dict[str, int]:
    """The table's words of the magnets, with the rotor at a position, counts, at reset."""
    turn, zero = rotor_angles(scene, set_, position)
    return {
        "count_angle": turn,
        "zero_angle": zero,
        "find_magnet": int(scene.controller.find_magnet),
    }


def _anchors(set_: Settings, position: int, zero: int, turn: int, known: bool) -> tuple[Any, ...]:
    """What :func:`_advance_sampled` takes as ``anchored``."""
    blind = set_.anchor.copy()
    blind[anchor.ENABLE] = 0
    return (
        set_.anchor,
        np.stack([anchor.new_state() for _ in range(2)]),
        turn,
        rotor_flux.sine_table(),
        rotor_flux.new_state(position, zero),
        blind,
        magnet_angle.new_state(known, position),
    )


def _load_axes(set_: Settings, *angles: int) -> tuple[ctypes.CDLL, int, int]:
    """(library, a model, address of its step) of both axes' RTL.

    ``angles`` are position, θ there, a count's angle, and whether θ is to be found.
    """
    sizes = core_design(set_).parameters
    design = verilated.Design("wh_core_axes", "brushless_core_shim.cpp", sizes)
    library = verilated.load(design)
    verilated.declare_destructor(library.wh_axes_delete)
    words = verilated.words_of(design, {**set_.words(), "hold_ticks": set_.extra_ticks})
    model = verilated.new_model(library.wh_axes_new, words, *angles)
    return library, model, verilated.address(library.wh_axes_step)


@compiled(inline="always")
def _outward(
    z: np.ndarray, f: int, i: int, side: float, kept: np.ndarray, floats: np.ndarray
) -> float:
    """How far the goal of a filter lies beyond the limit that holds its f, √W."""
    eta = floats[_CONTACT_ETA] if kept[_TOUCHING] else floats[_FREE_ETA]
    beyond: float = side * (eta * (z[f] - floats[_S] * z[i]) - z[f])
    return beyond


@compiled(inline="always")
def _axis_stays(
    z: np.ndarray, f: int, i: int, side: float, kept: np.ndarray, floats: np.ndarray
) -> bool:
    if side == 0.0:
        inner: bool = abs(z[f]) <= floats[_LIMIT]
        return inner
    return _outward(z, f, i, side, kept, floats) >= 0.0


@compiled()
def _consistent(
    z: np.ndarray, kept: np.ndarray, floats: np.ndarray, wall_min: np.ndarray, wall_max: np.ndarray
) -> bool:
    """Whether the state still belongs to the circuits that it is advanced with."""
    if inside(z[X], wall_min, wall_max) != (kept[_TOUCHING] != 0.0):
        return False
    return _axis_stays(z, F_A, I_A, kept[_SIDE_A], kept, floats) and _axis_stays(
        z, F_B, I_B, kept[_SIDE_B], kept, floats
    )


@compiled(inline="always")
def _switch_axis(
    z: np.ndarray, f: int, i: int, at: int, kept: np.ndarray, floats: np.ndarray
) -> None:
    if kept[at] == 0.0 and abs(z[f]) > floats[_LIMIT]:
        kept[at] = 1.0 if z[f] > 0.0 else -1.0
        z[f] = kept[at] * floats[_LIMIT]
    if kept[at] != 0.0 and _outward(z, f, i, kept[at], kept, floats) < 0.0:
        kept[at] = 0.0


@compiled()
def _switch(
    z: np.ndarray, kept: np.ndarray, floats: np.ndarray, wall_min: np.ndarray, wall_max: np.ndarray
) -> None:
    """Choose the circuits that the state belongs to."""
    kept[_TOUCHING] = 1.0 if inside(z[X], wall_min, wall_max) else 0.0
    _switch_axis(z, F_A, I_A, _SIDE_A, kept, floats)
    _switch_axis(z, F_B, I_B, _SIDE_B, kept, floats)


@compiled(inline="always")
def _circuit(side: float, kept: np.ndarray) -> int:
    if side != 0.0:
        return LIMITED
    return CONTACT if kept[_TOUCHING] else FREE


@compiled()
def _part(
    z: np.ndarray, trial: np.ndarray, kept: np.ndarray, floats: np.ndarray, wall_min: np.ndarray,
    wall_max: np.ndarray, tables: np.ndarray, steps: np.ndarray, load: np.ndarray,
) -> None:  # fmt: skip
    """Advance z by one regular step, through every change of circuit in it, as `analog` does.

    ``tables`` has the axis' tables by circuit and halving. ``trial`` is room for a state.
    """
    left = 1 << HALVINGS
    order = HALVINGS
    changes = 0
    _switch(z, kept, floats, wall_min, wall_max)
    while left > 0:
        while 1 << order > left:
            order -= 1
        for n in range(z.shape[0]):
            trial[n] = z[n]
        circuit_a, circuit_b = _circuit(kept[_SIDE_A], kept), _circuit(kept[_SIDE_B], kept)
        brushless_step(
            trial, tables[circuit_a, order], tables[circuit_b, order], steps[order], load
        )
        free = changes < MODE_CHANGES
        stays = not free or _consistent(trial, kept, floats, wall_min, wall_max)
        if not stays and order > 0:
            order -= 1
            continue
        for n in range(z.shape[0]):
            z[n] = trial[n]
        left -= 1 << order
        if not stays:
            _switch(z, kept, floats, wall_min, wall_max)
            changes += 1
            order = HALVINGS


@compiled(error_model="numpy")
def _advance_analog(
    rows: np.ndarray, z: np.ndarray, trial: np.ndarray, kept: np.ndarray, wall_min: np.ndarray,
    wall_max: np.ndarray, floats: np.ndarray, substeps: int, load: np.ndarray, tables: np.ndarray,
    steps: np.ndarray,
) -> None:  # fmt: skip
    tick, s = floats[_TICK], floats[_S]
    for n in range(rows.shape[0]):
        before, hand = z[X], z[P] + z[C]
        clear_sums(z)
        low, high = z[I], z[I]
        for _ in range(substeps):
            _part(z, trial, kept, floats, wall_min, wall_max, tables, steps, load)
            low, high = min(low, z[I]), max(high, z[I])
        u_a, u_b = z[QF_A] / tick, z[QF_B] / tick
        volt = floats[_DRIVE]
        theta = put_axes(
            rows[n], z, load, z[TIME] - tick, tick, before, hand, volt * u_a, volt * u_b,
            high - low,
        )  # fmt: skip
        u = along_q(u_a, u_b, theta)
        v = along_q(u_a - s * z[Q_A] / tick, u_b - s * z[Q_B] / tick, theta)
        eta = floats[_CONTACT_ETA] if kept[_TOUCHING] else floats[_FREE_ETA]
        limited = kept[_SIDE_A] != 0.0 or kept[_SIDE_B] != 0.0
        put_port(rows[n], eta, u, v, kept[_TOUCHING], limited)


class BrushlessAnalogSimulation:
    """A scene's brushless motor on two of the paper's analog circuits.

    Its rows stand on the tick grid of ``tick_s``. As of
    :class:`~wavehaptics.ladder.analog.AnalogSimulation` encoder and sensors are ideal.
    """

    clock_cycles: int | None = None

    def __init__(
        self, scene: Scene, tick_s: float | None = None, cell_rad: float | None = None
    ) -> None:
        refuse(scene, "analog")
        scene = without_anchor(scene)
        control = scene.controller
        self.settings = set_ = settings(scene, tick_s, cell_rad)
        self.tick_s = set_.tick_s
        plant = BrushlessPlant.of_scene(scene)
        self._substeps = plant.substeps(self.tick_s)
        dt = self.tick_s / self._substeps
        s = closed_forms.root(set_.r_hat)
        drive = drive_gain(scene) * s
        parts = [dt * 2.0 ** (n - HALVINGS) for n in range(HALVINGS + 1)]
        filters = {
            FREE: (control.lambda_, control.eta_free, s),
            CONTACT: (control.lambda_, control.eta_contact, s),
            LIMITED: (0.0, 0.0, 0.0),
        }
        self._tables = np.array(
            [[plant.axis_table(part, drive, *filters[n]) for part in parts] for n in range(3)]
        )
        self._steps = np.array([plant.step_words(part) for part in parts])
        self._z = plant.start
        self._kept = np.zeros(3)
        self._floats = np.array(
            [self.tick_s, s, drive, set_.limit_v / s, control.eta_contact, control.eta_free]
        )
        self._load = plant.words()
        self._wall_min = set_.wall_min * set_.cell_rad
        self._wall_max = set_.wall_max * set_.cell_rad

    def advance(self, rows: np.ndarray, words: np.ndarray | None = None) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column); it has no words."""
        del words
        _advance_analog(
            rows, self._z, np.empty_like(self._z), self._kept, self._wall_min, self._wall_max,
            self._floats, self._substeps, self._load, self._tables, self._steps,
        )  # fmt: skip
