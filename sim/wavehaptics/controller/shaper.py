# SPDX-License-Identifier: Apache-2.0
"""From a scene's ``[shaper]`` to the words of W."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wavehaptics.controller import wave_core
from wavehaptics.controller.normalised import from_sos, quantise, realise
from wavehaptics.laws import closed_forms
from wavehaptics.laws.reflection import Wish, WishError, front_stiffness, reflection, spring_behind
from wavehaptics.scene import Scene


@dataclass(frozen=True)
class Shaper:
    """W of a scene as the RTL has it. Without a section W is 1."""

    words: np.ndarray
    """int64 (sections, SECTION_WORDS)."""
    wish: Wish | None = None
    """What was wished; None for coefficients of one's own and without a shaper."""


NONE = Shaper(wave_core.NO_SHAPER)


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
    asked = table.mass_kgm2 or 0.0
    mass, damping, spring = asked, table.damping, table.stiffness or 0.0
    if table.feel in ("spring", "resonance"):
        spring = spring_behind(spring, front)
    if table.feel == "mass":
        # What the delay adds to free space is there already (``free_space_inertia``).
        mass -= closed_forms.free_space_inertia(k_t, r_hat, tau_s)
        if mass <= 0.0:
            raise WishError(
                f"shaper.mass_kgm2 = {asked:.6g} is less than the delay adds by itself, "
                f"{asked - mass:.3g} kg·m²; choose more"
            )
    wish = Wish(asked, damping, spring, front)
    behind = Wish(mass, damping, spring, front)
    top, bottom = reflection(behind, closed_forms.b_r(k_t, r_hat))
    return Shaper(quantise(realise(top, bottom, tick_s))[None], wish)
