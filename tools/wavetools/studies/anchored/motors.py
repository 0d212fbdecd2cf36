# SPDX-License-Identifier: Apache-2.0
"""Random motors in random hands, all wrong: does one choice of the anchor's values serve?"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from wavehaptics.scene import SceneError
from wavehaptics.trace.columns import Column

from wavetools.studies.anchored import runs

SPEEDS = (0.3, 1.0, 3.0, 10.0, 30.0)
PARTS = ("hold", "press", "soft", *(f"bounce_{speed:g}" for speed in SPEEDS))
"""What each motor does; ``part`` of :func:`random_motor`."""


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def draw(seed: int) -> tuple[dict[str, float], list[str]]:
    """A motor's numbers, SI, and the settings of all but what it is to do.

    Of load and temperature the controller knows nothing. Half of the hands have a mass, which
    sits between two springs, the fingers' and the arm's.
    """
    rng = np.random.default_rng(seed)
    r = _log(rng, 0.5, 12.0)
    inductance = r * _log(rng, 60e-6, 900e-6)
    k_t = _log(rng, 12e-3, 90e-3)
    inertia = k_t**2 / r * _log(rng, 2e-3, 20e-3)
    counts = 4 * round(_log(rng, 2000, 40_000) / 4)
    tick_hz = float(rng.choice([0.5e6, 1e6, 2e6]))
    rated_a = math.sqrt(rng.uniform(1.0, 3.0) / r)
    force = 0.5 * k_t * rated_a
    stiffness = k_t**2 / inductance
    hand_k = stiffness * _log(rng, 0.03, 0.3)
    hand_b = _log(rng, 0.1e-3, 2e-3)
    limit_v = min(127.0, max(12.0, 4.0 * r * rated_a))
    signs = rng.choice([-1.0, 1.0], 6)
    load = _log(rng, 1.0, 50.0)
    mass = _log(rng, 2e-6, 2e-5) if rng.integers(2) else 0.0
    celsius = rng.uniform(-20.0, 125.0)
    frequency = _log(rng, 0.5, 4.0)
    settings = {
        "load.inertia_kgm2": (load - 1.0) * inertia, "thermal.start_c": celsius,
        "thermal.ambient_c": celsius, "thermal.magnet_per_k": -0.0011,
        "motor.R_ohm": r, "motor.L_h": inductance, "motor.k_t": k_t, "motor.J_kgm2": inertia,
        "friction.coulomb_nm": rng.uniform(0.0, 0.03) * force,
        "brushes.drop_v": rng.uniform(0.0, 0.3), "brushes.knee_a": _log(rng, 5e-3, 50e-3),
        "brushes.segments": int(rng.integers(7, 30)), "brushes.ripple": 0.03 * signs[0],
        "encoder.counts_per_rev": counts, "encoder.uneven": 0.12,
        "adc.bits": 12, "adc.full_scale_a": 3.0 * rated_a, "adc.noise_a": 1.2e-3 * rated_a,
        "adc.offset_a": 3e-3 * rated_a * signs[1], "adc.bandwidth_hz": 1 / (2 * math.pi * 0.2e-6),
        "drive.limit_v": limit_v, "drive.gain_error": 0.05 * signs[2],
        "controller.tick_hz": tick_hz, "controller.lambda": 1e9, "controller.extra_ticks": 1,
        "controller.r_hat": r * (1 + 0.1 * signs[3]),
        "controller.l_hat": inductance * (1 + 0.1 * signs[4]),
        "controller.k_t_hat": k_t * (1 + 0.05 * signs[5]), "controller.anchor_auto": "true",
    }  # fmt: skip
    numbers = {
        "r": r, "l": inductance, "k_t": k_t, "j": inertia, "counts": counts, "tick_hz": tick_hz,
        "rated_a": rated_a, "force": force, "stiffness": stiffness, "hand_k": hand_k,
        "hand_b": hand_b, "load": load, "mass": mass, "celsius": celsius, "frequency": frequency,
    }  # fmt: skip
    return numbers, [f"{key}={value}" for key, value in settings.items()]


def random_motor(seed: int) -> dict[str, Any]:
    """What the motor of a seed does in each of PARTS."""
    motor, settings = draw(seed)
    found: dict[str, Any] = {"seed": seed, "motor": motor}
    press = [*settings, *_hand(motor), "scene.duration_s=0.6"]
    held = _tried(runs.hold, "held_wall", "golden", press)
    found["hold"] = held
    pressed = [
        *settings, *_hand(motor), "hand.path=taps", f"hand.frequency_hz={motor['frequency']}",
        f"scene.duration_s={2.0 / motor['frequency']}",
    ]  # fmt: skip
    found["press"] = _tried(runs.swing, "held_wall", pressed)
    found["soft"] = soft_wall(seed)
    inertia = motor["j"] * motor["load"]
    contact_s = math.pi * math.sqrt(inertia * motor["l"]) / motor["k_t"]
    for speed in SPEEDS:
        peak_a = speed * math.sqrt(inertia / motor["l"])
        limit_v = min(127.0, max(12.0, 2.0 * motor["r"] * peak_a))
        way = min(0.05, 0.01 * speed)
        if limit_v < 1.3 * motor["r"] * peak_a:
            found[f"bounce_{speed:g}"] = {"restitution": None, "refused": "too much for any drive"}
            continue
        hit = [
            f"hand.speed_rad_s={speed}", f"hand.amplitude_rad={way}",
            f"scene.duration_s={2 * way / speed + 4 * contact_s}",
            f"adc.full_scale_a={max(3.0 * motor['rated_a'], 1.5 * peak_a)}",
            f"drive.bus_v={limit_v}", f"drive.limit_v={limit_v}",
        ]  # fmt: skip
        found[f"bounce_{speed:g}"] = _tried(runs.bounce, "bounce", [*settings, *hit])
    return found


def soft_wall(seed: int) -> dict[str, Any]:
    """How far a spring of a fifth of the motor's own moves under taps."""
    motor, settings = draw(seed)
    deep = motor["force"] / motor["stiffness"]
    soft = [
        "controller.extra_ticks=2", "shaper.feel=spring",
        f"shaper.stiffness={0.2 * motor['stiffness']}",
        # A soft wall without a damper rings with the winding at some 10 kHz, and the anchor beside
        # it at a slow tick; a quarter of B_R takes that.
        f"shaper.damping={0.25 * motor['k_t'] ** 2 / motor['r']}",
        f"hand.amplitude_rad={_amplitude(motor) + 4 * deep}",
    ]  # fmt: skip
    return _tried(runs.swing, "held_wall", [*_taps(motor, settings), *soft])


def free_after_a_tap(seed: int, settings: tuple[str, ...]) -> dict[str, Any]:
    """The voltage (RMS, V) in free space of a motor that taps, with more ``settings``.

    Only a test asks: η = 1 ends in a swing there, which is why another one is chosen.
    """
    motor, drawn = draw(seed)
    loaded = runs.load("held_wall", [*_taps(motor, drawn), *settings])
    metrics, rows = runs.run(loaded, part_s=1.0 / motor["tick_hz"])
    free = rows[rows[:, Column.CONTACT] == 0.0, Column.E_A]
    return {
        "voltage_rms": float(np.sqrt(np.mean(free**2))),
        "anchor_fault_s": metrics["anchor_fault_s"],
    }


def _amplitude(motor: dict[str, float]) -> float:
    return motor["force"] / motor["hand_k"] + motor["force"] / motor["stiffness"]


def _hand(motor: dict[str, float]) -> list[str]:
    settings = [f"hand.damping={motor['hand_b']}", f"hand.amplitude_rad={_amplitude(motor)}"]
    if not motor["mass"]:
        return [*settings, f"hand.stiffness={motor['hand_k']}"]
    half = 2.0 * motor["hand_k"]
    return [
        *settings, f"hand.stiffness={half}", f"hand.inertia_kgm2={motor['mass']}",
        f"transmission.cable_stiffness={half}", f"transmission.cable_damping={motor['hand_b']}",
    ]  # fmt: skip


def _taps(motor: dict[str, float], settings: list[str]) -> list[str]:
    return [
        *settings, *_hand(motor), "hand.path=taps", "hand.frequency_hz=2", "scene.duration_s=0.5",
    ]  # fmt: skip


def _tried(function, *arguments) -> dict[str, Any]:
    try:
        return function(*arguments)
    except SceneError as problem:
        return {"refused": str(problem)}
    except FloatingPointError as problem:
        return {"lost": str(problem)}
