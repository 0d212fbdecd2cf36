# SPDX-License-Identifier: Apache-2.0
"""What contact is rendered as with a controller's settings, and how far that is from a wish."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wavehaptics.controller.normalised import noise_gain, response
from wavehaptics.controller.settings import Settings
from wavehaptics.scene import Scene
from wavehaptics.words import formats

HIGHEST_HZ = 500.0
"""Up to here what is felt must be what was wished."""


def environment(set_: Settings, hertz: np.ndarray) -> np.ndarray:
    """D(jω) of contact as the controller renders it, with every delay, at ``hertz``."""
    turn = 2.0 * math.pi * np.asarray(hertz, dtype=float) * set_.tick_s
    a = formats.A.to_value(set_.a)
    d = formats.ETA.to_value(set_.eta_contact) * np.ones_like(turn, dtype=complex)
    for words in set_.shaper.words:
        d = d * response(words, turn)
    z = np.exp(1j * turn)
    found: np.ndarray = d * a / (z - (1.0 - a)) / z**set_.extra_ticks
    return found


def rendered(set_: Settings, k_t: float, inductance: float, hertz: np.ndarray) -> np.ndarray:
    """Mechanical impedance at the shaft, torque over speed, N·m·s/rad, of contact at ``hertz``.

    The port renders ``R̂ (1 + D)/(1 − D)`` behind the inductance, for a winding of R̂.
    """
    d = environment(set_, hertz)
    s = 2j * math.pi * np.asarray(hertz, dtype=float)
    return k_t**2 / (s * inductance + set_.r_hat * (1.0 + d) / (1.0 - d))


@dataclass(frozen=True)
class Report:
    """What a design comes to."""

    worst_gain: float
    """Largest ``|D|`` on a fine grid of frequencies."""
    worst_hz: float
    noise_gains: list[float]
    """Power gain from each state's rounding error to y."""
    static_stiffness: float | None
    felt_error: float | None
    """Largest relative error of the impedance against the wish, 1 Hz to HIGHEST_HZ."""


def report(set_: Settings, k_t: float, inductance: float) -> Report:
    """Figures of the shaper in ``set_``, for a motor of ``k_t`` and ``inductance``."""
    grid = np.geomspace(1e-3, 0.5 / set_.tick_s, 20_000)
    gain = np.abs(environment(set_, grid))
    wish = set_.shaper.wish
    static, error = None, None
    if wish is not None:
        static = wish.spring * wish.front / (wish.spring + wish.front)
        hertz = np.geomspace(1.0, min(HIGHEST_HZ, 0.05 / set_.tick_s), 400)
        want = wish.felt(2j * math.pi * hertz)
        got = rendered(set_, k_t, inductance, hertz)
        error = float(np.max(np.abs(got / want - 1.0)))
    return Report(
        worst_gain=float(gain.max()),
        worst_hz=float(grid[gain.argmax()]),
        noise_gains=[gain for words in set_.shaper.words for gain in noise_gain(words)],
        static_stiffness=static,
        felt_error=error,
    )


def fragment(scene: Scene, set_: Settings, k_t: float, inductance: float) -> str:
    """The scene's ``[shaper]`` as TOML, with its words and what was found of it as comments.

    What is felt is that of a motor of ``k_t`` and ``inductance``.
    """
    table = scene.shaper
    assert table is not None
    lines = ["[shaper]"]
    for key, value in table.model_dump(exclude_unset=True).items():
        if value is not None:
            lines.append(f"{key} = {_toml(value)}")
    found = report(set_, k_t, inductance)
    lines += [
        f"# a tick of {set_.tick_s:g} s, R̂ = {set_.r_hat:g} Ω, a delay of {set_.tau:g} s",
        f"# contractive, so passive in every tick; largest |D| {found.worst_gain:.9f} at "
        f"{found.worst_hz:.6g} Hz",
        f"# noise gain of the states' rounding: "
        f"{', '.join(f'{gain:.3f}' for gain in found.noise_gains)}",
    ]
    if found.static_stiffness is not None:
        front = set_.shaper.wish.front if set_.shaper.wish else 0.0
        lines.append(
            f"# felt at rest {found.static_stiffness:.6g} N·m/rad, behind K_L,eff = {front:.6g}"
        )
    if found.felt_error is not None:
        lines.append(
            f"# off the wish by {100.0 * found.felt_error:.2g} % at most, 1 to {HIGHEST_HZ:g} Hz"
        )
    for n, words in enumerate(set_.shaper.words):
        lines.append(f"# words of section {n}: {' '.join(str(int(word)) for word in words)}")
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"[{', '.join(_toml(part) for part in value)}]"
    return f"{value:.12g}" if isinstance(value, float) else str(value)
