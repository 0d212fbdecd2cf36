# SPDX-License-Identifier: Apache-2.0
"""Millions of ticks of the core's RTL beside the integer model, everything switched at random.

A motor, its drive and sensor, R̂, λ, W, walls and latency are drawn for an episode. Within it η,
contact and W change after 1 to 4,000 ticks, a reset of one clock falls anywhere into a step, the
sensor and the encoder tell nonsense for a while, and a fault of the anchor is left standing until
the next reset. In every tick is watched that

- every word of the RTL equals the integer model's;
- the waves have given out no more than they took in since the reset, ``Σ(v² − u²) ≥ 0`` without
  any rounding, as ``|η| ≤ 1`` and W is passive;
- ``|u|`` is within its limit;
- c is within its own, ``c_0 + |e_id|/2``, c_0/2 out of contact, and 0 after a
  fault;
- the RTL answers within the stated clocks;

and at the end of an episode without nonsense, in which waves and encoder belong to the same motor,
that the work of c has stayed below its bound (:mod:`wavehaptics.trace.metrics`).
"""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np
from wavehaptics.controller import anchor, wave_core
from wavehaptics.controller.pins_timing import (
    ANCHOR_CLOCKS,
    CORE_CLOCKS,
    SECTION_CLOCKS,
    WAVES_CLOCKS,
)
from wavehaptics.controller.settings import Settings, settings
from wavehaptics.ladder.sampled import core_words, load_core
from wavehaptics.motor.plant import Plant, X, load_words
from wavehaptics.motor.sensor import Sensor, current_word, draw_noise, noise_at, range_ends
from wavehaptics.motor.step import motor_parts, motor_step
from wavehaptics.runtime.compiled import compiled
from wavehaptics.runtime.native_call import call2
from wavehaptics.scene import SceneError, drive_gain
from wavehaptics.studies.report.runs import STORE, load
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace.columns import Column
from wavehaptics.trace.metrics import Metrics
from wavehaptics.words import formats

from wavetools.studies.anchored.motors import draw

TASK_TICKS, EPISODE_TICKS, LONGEST_SPELL = 500_000, 50_000, 4000
WHOLE_TICKS = 100_000_000
"""What `make soak` asks for, and the pages quote no shorter one."""

__all__ = ["STORE", "Task", "soak", "summary", "tasks"]

NOTHING_WRONG, WORDS, PORT_ENERGY, LIMIT, CORRECTION, CLOCKS = range(6)
WHAT = ("", "the RTL's words are not the integer model's", "the waves gave out energy",
        "u is beyond its limit", "c is beyond its limit",
        "the RTL took longer than is stated")  # fmt: skip
"""What a tick may do wrong."""
WORK = "the correction's work is beyond its bound"

# Places in what a loop keeps.
_VOLTAGE, _WAVE_VOLTAGE, _LOW, _HIGH, _CORRECTION, _TOUCHED, _FAULTS = range(7)
# Places in a spell: how contact and W are chosen, η in and out of contact, and what is nonsense.
_CONTACT, _MODE, _ETA_IN, _ETA_OUT, _WILD_CURRENT, _WILD_POSITION = range(6)
_BY_WALLS, _ALWAYS, _NEVER = range(3)

_VOLT, _ROOT_WATT, _ETA = formats.VOLTAGE.step, formats.WAVE.step, formats.ETA.step
_ONE = 1 << formats.ETA.fraction
_DATA_TOP = 1 << (formats.DATA_W - 1)
_LONG_GUARD = formats.LONG_GUARD
_HELD_SHIFT = formats.PULL.fraction + formats.LONG.fraction - _LONG_GUARD - formats.VOLTAGE.fraction
_LIMB = 40  # bits of the lower part of Σ(v² − u²)

ANCHORED_CLOCKS = WAVES_CLOCKS + ANCHOR_CLOCKS + 2
"""From a step's start until ``wh_core_port`` shows its end and the anchor's next voltage."""


@compiled(error_model="numpy")
def _soak(
    rows, spell, state, kept, core, line, shaper, contact, walls, words, held, ints, load_, matrix,
    parts, dt, substeps, cell, gain, ohm, sensor, noise, wild, buffer,
):  # fmt: skip
    """Fill ``rows``; what went wrong and in which row, as two numbers."""
    root, a, u_max, extra, model, step, most_clocks = ints
    anchored = words[anchor.ENABLE] != 0
    for n in range(rows.shape[0]):
        e_a = kept[_VOLTAGE] * _VOLT * gain
        x, charge, square = state[X], 0.0, 0.0
        for _ in range(substeps):
            part, part_square = motor_step(state, matrix, dt, e_a, load_, parts)
            charge += part
            square += part_square
        tick = dt * substeps
        raw = current_word(charge / tick, sensor, noise_at(noise, n))
        position = int(np.floor(state[X] / cell))
        if spell[_WILD_CURRENT] != 0:
            raw = wild[n]
        ends = range_ends(raw, sensor)
        if spell[_WILD_POSITION] != 0:
            position += wild[n] & 0xFFFF
        touching, _ = wave_core.contact_step(contact, position, walls[0], walls[1])
        if spell[_CONTACT] != _BY_WALLS:
            touching = spell[_CONTACT] == _ALWAYS
        mode = spell[_MODE] if touching else wave_core.CLEAR
        lost = held[anchor.FAULT] != 0
        eta = 0 if lost else spell[_ETA_IN] if touching else spell[_ETA_OUT]
        current = wave_core.saturate(raw - held[anchor.OFFSET]) if anchored else raw
        coefficient = held[anchor.COEFFICIENT]
        withheld, saturated = core[wave_core.STATE_WITHHELD], core[wave_core.STATE_SATURATED] != 0
        left = anchor.left(u_max, held)
        e_id, u, v = wave_core.shaped_core_step(
            core, line, shaper[0], shaper[1], mode, current, eta, 0, root, a, left, extra, extra,
            ends,
        )  # fmt: skip
        e = e_id
        if anchored:
            e = wave_core.saturate(e_id + held[anchor.CORRECTION])
            volts = kept[_WAVE_VOLTAGE]
            anchor.anchor_step(
                held, words, position, touching, current, u, v, withheld, volts, saturated,
                core[wave_core.STATE_CLIPPED] != 0,
            )  # fmt: skip
            kept[_WAVE_VOLTAGE] = e_id
            size = abs(volts)
            reach = words[anchor.REACH] >> (0 if touching else anchor.FREE_SHIFT)
            share = (coefficient * abs(held[anchor.TOLD])) >> _HELD_SHIFT if touching else 0
            # A word for each floor: of the half, of what θ holds and of c.
            if abs(held[anchor.CORRECTION]) > reach + (size >> 1) + share + 3:
                return CORRECTION, n
            if held[anchor.FAULT] != 0:
                kept[_FAULTS] += 0 if lost else 1
                if held[anchor.CORRECTION] != 0:
                    return CORRECTION, n

        buffer[0], buffer[1], buffer[2], buffer[3] = raw, touching, mode, position
        buffer[4] = ends
        clocks = call2(step, model, buffer.ctypes.data)
        if clocks < 0 or clocks > most_clocks:
            return CLOCKS, n
        if buffer[0] != e or buffer[1] != u or buffer[2] != v:
            return WORDS, n
        if buffer[9] != core[wave_core.STATE_CLIPPED]:
            return WORDS, n
        if anchored and (
            buffer[3] != held[anchor.CORRECTION] or buffer[4] != held[anchor.OFFSET]
            or buffer[5] != held[anchor.CHI] >> _LONG_GUARD
            or buffer[6] != held[anchor.LAG] >> _LONG_GUARD or buffer[7] != held[anchor.FAULT]
            or buffer[8] != core[wave_core.STATE_SATURATED]
        ):  # fmt: skip
            return WORDS, n

        if abs(u) > u_max:
            return LIMIT, n
        taken = (v - u) * (v + u)
        low = kept[_LOW] + (taken & ((1 << _LIMB) - 1))
        kept[_LOW] = low & ((1 << _LIMB) - 1)
        kept[_HIGH] += (taken >> _LIMB) + (low >> _LIMB)
        if kept[_HIGH] < 0:
            return PORT_ENERGY, n

        kept[_TOUCHED] += touching
        kept[_VOLTAGE] = e
        row = rows[n]
        row[Column.X] = 0.5 * (x + state[X])
        row[Column.OMEGA] = (state[X] - x) / tick
        row[Column.I] = charge / tick
        row[Column.E_A] = e_a
        row[Column.ETA] = eta * _ETA
        row[Column.U], row[Column.V] = u * _ROOT_WATT, v * _ROOT_WATT
        row[Column.CONTACT] = 1.0 if touching else 0.0
        row[Column.ENERGY_OUT] = e_a * charge - ohm * square
        row[Column.CORRECTION] = kept[_CORRECTION] * _VOLT
        kept[_CORRECTION] = held[anchor.CORRECTION]
    return NOTHING_WRONG, 0


def tasks(ticks: int, seed: int = 0) -> list[Task]:
    """The soak of so many ticks or some more, in tasks of TASK_TICKS."""
    count = -(-ticks // TASK_TICKS)
    return [Task(soak, {"seed": seed + n, "ticks": TASK_TICKS}) for n in range(count)]


def soak(seed: int, ticks: int) -> dict[str, Any]:
    """Episodes of a seed for ``ticks`` or some more: counts, and ``wrong``, None or a line."""
    rng = np.random.default_rng([seed, 1])
    found: dict[str, Any] = {
        "seed": seed, "ticks": 0, "episodes": 0, "refused": 0, "resets": 0, "spells": 0,
        "touched": 0, "anchored": 0, "shaped": 0, "faults": 0, "wrong": None,
    }  # fmt: skip
    while found["ticks"] < ticks and found["wrong"] is None:
        drawn = _settings(rng)
        try:
            scene = load("held_wall", drawn)
            set_ = settings(scene)
        except SceneError:
            found["refused"] += 1
            continue
        _episode(scene, set_, rng, found)
        found["episodes"] += 1
    return found


def _settings(rng: np.random.Generator) -> list[str]:
    """Settings of an episode's scene; some are refused, as a wall that the tick can't have."""
    motor, drawn = draw(int(rng.integers(1 << 31)))
    deep = motor["force"] / motor["stiffness"]
    drawn += [
        f"hand.stiffness={motor['hand_k']}", f"hand.damping={motor['hand_b']}",
        f"hand.path={rng.choice(['sine', 'taps'])}", f"hand.frequency_hz={rng.uniform(0.5, 20.0)}",
        f"hand.amplitude_rad={(motor['force'] / motor['hand_k'] + deep) * rng.uniform(0.2, 3.0)}",
        f"controller.lambda={10 ** rng.uniform(2.0, 7.0)}",
        f"controller.extra_ticks={rng.integers(0, 4)}",
        f"controller.anchor_auto={'true' if rng.random() < 0.6 else 'false'}",
        f"controller.walls=[[0.0, {20 * deep}], [{30 * deep}, {31 * deep}]]", "scene.duration_s=1",
        # Where the magnets warm the work of a correction has no bound to be held against.
        "thermal.magnet_per_k=0",
    ]  # fmt: skip
    if rng.random() < 0.4:
        drawn += [
            "shaper.feel=spring", f"shaper.stiffness={motor['stiffness'] * rng.uniform(0.05, 0.5)}",
            f"shaper.damping={motor['k_t'] ** 2 / motor['r'] * rng.uniform(0.1, 0.5)}",
        ]  # fmt: skip
    return drawn


def _spell(rng: np.random.Generator) -> np.ndarray:
    """What is in force for some ticks."""
    wild = rng.random()
    chosen = np.zeros(6, dtype=np.int64)
    chosen[_CONTACT] = rng.choice([_BY_WALLS, _ALWAYS, _NEVER], p=[0.6, 0.2, 0.2])
    chosen[_MODE] = wave_core.SHAPE if rng.random() < 0.7 else wave_core.HOLD
    chosen[_ETA_IN] = -_ONE if rng.random() < 0.6 else rng.integers(-_ONE, _ONE + 1)
    chosen[_ETA_OUT] = _ONE if rng.random() < 0.6 else rng.integers(-_ONE, _ONE + 1)
    chosen[_WILD_CURRENT] = wild < 0.03
    chosen[_WILD_POSITION] = 0.02 < wild < 0.04
    return chosen


def _episode(scene: Any, set_: Settings, rng: np.random.Generator, found: dict[str, Any]) -> None:
    plant = Plant.of_scene(scene)
    substeps = plant.substeps(set_.tick_s)
    dt = set_.tick_s / substeps
    library, model, step = load_core(set_)
    sections = len(set_.shaper.words)
    most = CORE_CLOCKS + SECTION_CLOCKS * sections
    if set_.anchored:
        most = max(most, ANCHORED_CLOCKS + SECTION_CLOCKS * sections)
    ints = (set_.root, set_.a, set_.u_max, set_.extra_ticks, model, step, most)
    sensor = Sensor.of_scene(scene).constants()
    metrics = Metrics(scene, set_.tick_s, controller="golden", walls=[(0.0, 1.0)], root=set_.s)
    state, parts = plant.start.copy(), motor_parts(plant)
    contact = np.array([-1, 0], dtype=np.int64)
    kept = np.zeros(7, dtype=np.int64)
    buffer = np.zeros(10, dtype=np.int64)
    clean, done = True, 0
    core = line = held = states = None
    try:
        while done < EPISODE_TICKS:
            if core is None or rng.random() < 0.05:
                library.wh_core_stop(
                    ctypes.c_void_p(model), ctypes.c_int64(int(rng.integers(0, most)))
                )
                core, line = wave_core.new_state(), wave_core.new_line(set_.extra_ticks)
                held, states = anchor.new_state(), wave_core.new_shaper_state(sections)
                kept[:_TOUCHED] = 0
                found["resets"] += 1
            count = int(math.exp(rng.uniform(0.0, math.log(LONGEST_SPELL))))
            spell = _spell(rng)
            clean = clean and not (spell[_WILD_CURRENT] or spell[_WILD_POSITION])
            _set_eta(library, model, set_, spell)
            rows = np.zeros((count, len(Column)))
            wild = rng.integers(-_DATA_TOP, _DATA_TOP, count)
            wrong, at = _soak(
                rows, spell, state, kept, core, line, (set_.shaper.words, states), contact,
                (set_.wall_min, set_.wall_max), set_.anchor, held, ints, load_words(plant),
                plant.transition(dt), parts, dt, substeps, set_.cell_rad, drive_gain(scene),
                plant.resistance, sensor, draw_noise(rng, sensor, count), wild, buffer,
            )  # fmt: skip
            found["spells"] += 1
            if wrong != NOTHING_WRONG:
                found["wrong"] = f"episode {found['episodes']}, tick {done + at}: {WHAT[wrong]}"
                break
            done += count
            rows[:, Column.TORQUE] = plant.k_t * rows[:, Column.I]
            metrics.update(rows)
    finally:
        library.wh_core_delete(model)
    result = metrics.result()
    out, bound = result["correction_out_max_j"], result["correction_bound_j"]
    if found["wrong"] is None and clean and out is not None and out > bound:
        found["wrong"] = f"episode {found['episodes']}: {WORK}, {out:.3g} J and {bound:.3g} J"
    found["ticks"] += done
    found["touched"] += int(kept[_TOUCHED])
    found["faults"] += int(kept[_FAULTS])
    found["anchored"] += done if set_.anchored else 0
    found["shaped"] += done if sections else 0


def _set_eta(library: Any, model: int, set_: Settings, spell: np.ndarray) -> None:
    eta_contact, eta_free = (int(spell[place]) for place in (_ETA_IN, _ETA_OUT))
    words = core_words(set_, eta_contact=eta_contact, eta_free=eta_free)
    library.wh_core_set(ctypes.c_void_p(model), words)


def summary(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Sums of the tasks' counts, and every line of what went wrong, with its seed."""
    counts = [key for key in results[0] if key not in ("seed", "wrong")]
    found: dict[str, Any] = {key: sum(one[key] for one in results) for key in counts}
    found["wrong"] = [f"seed {one['seed']}, {one['wrong']}" for one in results if one["wrong"]]
    return found
