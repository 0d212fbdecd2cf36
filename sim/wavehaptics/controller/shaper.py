# SPDX-License-Identifier: Apache-2.0
"""From a scene's ``[shaper]`` to the words of W, and what a person will feel of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wavehaptics.controller import wave_core
from wavehaptics.controller.normalised import from_sos, noise_gain, quantise, realise, response
from wavehaptics.laws import closed_forms
from wavehaptics.laws.reflection import Wish, WishError, front_stiffness, reflection, spring_behind
from wavehaptics.scene import Scene, SceneError
from wavehaptics.words import formats

if TYPE_CHECKING:
    from wavehaptics.controller.settings import Settings

HIGHEST_HZ = 500.0
"""Up to here what is felt must be what was wished."""


@dataclass(frozen=True)
class Shaper:
    """W of a scene as the RTL has it. Without a section W is 1."""

    words: np.ndarray
    """int64 (sections, SECTION_WORDS)."""
    wish: Wish | None = None
    """What was wished; None for coefficients of one's own and without a shaper."""


NONE = Shaper(wave_core.NO_SHAPER)


def refuse_shaper(scene: Scene, controller: str) -> None:
    """:class:`SceneError` for a controller that has no W, where the scene wants one."""
    if scene.shaper is not None:
        raise SceneError(
            f"{scene.scene.name}: [shaper] is not for `{controller}`; leave it out or take `golden`"
        )


def design(scene: Scene, tick_s: float, tau_s: float, r_hat: float) -> Shaper:
    """W of the scene at a tick, with the delay τ and R̂ of the controller that runs it.

    It is made for the motor that the controller believes in: R̂, L̂ and k̂_T.
    :class:`wavehaptics.laws.reflection.WishError` where it can't be had or would give energy out.
    """
    table = scene.shaper
    if table is None:
        return NONE
    if table.sos is not None:
        # A row stands for itself at any tick: 2 s is the one of from_sos.
        sections = [quantise(realise(*from_sos(np.array(row)), 2.0)) for row in table.sos]
        return Shaper(np.array(sections, dtype=np.int64))
    k_t, inductance = scene.controller.k_t_hat, scene.controller.l_hat
    front = front_stiffness(k_t, inductance, r_hat, tau_s)
    mass, damping, spring = table.mass_kgm2 or 0.0, table.damping, table.stiffness or 0.0
    if table.feel in ("spring", "resonance"):
        spring = spring_behind(spring, front)
    if table.feel == "mass":
        # What the delay adds to free space is there already (:func:`physics.free_space_inertia`).
        mass -= closed_forms.free_space_inertia(k_t, r_hat, tau_s)
        if mass <= 0.0:
            raise WishError(
                f"shaper.mass_kgm2 = {table.mass_kgm2:.6g} is less than the delay adds by itself, "
                f"{table.mass_kgm2 - mass:.3g} kg·m²; wish for more"
            )
    wish = Wish(table.mass_kgm2 or 0.0, damping, spring, front)
    behind = Wish(mass, damping, spring, front)
    top, bottom = reflection(behind, closed_forms.b_r(k_t, r_hat))
    return Shaper(quantise(realise(top, bottom, tick_s))[None], wish)


def environment(set_: Settings, hertz: np.ndarray) -> np.ndarray:
    """D(jω) of contact as the controller renders it, with every delay, at ``hertz``."""
    turn = 2.0 * math.pi * np.asarray(hertz, dtype=float) * set_.tick_s
    a = formats.A.to_value(set_.a)
    d = formats.ETA.to_value(set_.eta_contact) * np.ones_like(turn, dtype=complex)
    for words in set_.shaper.words:
        d = d * response(words, turn)
    z = np.exp(1j * turn)
    return d * a / (z - (1.0 - a)) / z**set_.extra_ticks


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


def fragment(scene: Scene, set_: Settings) -> str:
    """The scene's ``[shaper]`` as TOML, with its words and what was found of it as comments."""
    table = scene.shaper
    assert table is not None
    lines = ["[shaper]"]
    for key, value in table.model_dump(exclude_unset=True).items():
        if value is not None:
            lines.append(f"{key} = {_toml(value)}")
    found = report(set_, scene.motor.k_t, scene.motor.L_h)
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
