# SPDX-License-Identifier: Apache-2.0
"""The winding's iron: eddy currents beside a part of L, and an L that falls with the current.

``eddy_ohm`` lies in parallel to the part ``p`` of the inductance, in series with the rest:
``p L di_e/dt = eddy_ohm (i − i_e)`` is the voltage over both. Saturation makes the incremental
inductance ``L/(1 + (i/i_s)²)``, of a flux ``L i_s atan(i/i_s)``; each part falls with its own
current.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene.tables.winding import Winding

EDDY_OHM, EDDY_H, SATURATION, SERIES_H = range(4)
"""Places in :func:`iron_words`: Ω, H (p L), A, H ((1 − p) L)."""


def iron_words(winding: Winding | None, inductance: float) -> np.ndarray:
    """Constants of the functions below; ``inductance`` is that in series, (1 − p) L, in H."""
    words = np.zeros(SERIES_H + 1)
    words[SERIES_H] = inductance
    if winding is not None:
        words[SATURATION] = winding.saturation_a or 0.0
        part = winding.eddy_part
        if winding.eddy_ohm is not None and part is not None:
            words[EDDY_OHM] = winding.eddy_ohm
            words[EDDY_H] = inductance * part / (1 - part)
    return words


@compiled(inline="always")
def eddy_share(
    eddy_current: float, current: float, step_s: float, words: np.ndarray
) -> tuple[float, float]:
    """(part of ``i − i_e`` that i_e makes up for in a step, the eddied part's inductance in H).

    ``current`` is i at the step's beginning. The inductance is that of i_e half a step later.
    """
    inductance = words[EDDY_H]
    share = -np.expm1(-step_s * words[EDDY_OHM] / inductance)
    if words[SATURATION] != 0.0:
        for half in (0.0, 0.5):
            middle = eddy_current + half * share * (current - eddy_current)
            inductance = words[EDDY_H] / (1.0 + (middle / words[SATURATION]) ** 2)
            share = -np.expm1(-step_s * words[EDDY_OHM] / inductance)
    return share, inductance


@compiled(inline="always")
def missing_flux(current: float, words: np.ndarray) -> tuple[float, float]:
    """Flux that the series part has less than its unsaturated L, V·s, and its slope, H."""
    part = current / words[SATURATION]
    flux = words[SERIES_H] * (words[SATURATION] * np.arctan(part) - current)
    return flux, words[SERIES_H] * (1.0 / (1.0 + part * part) - 1.0)
