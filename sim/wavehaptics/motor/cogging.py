# SPDX-License-Identifier: Apache-2.0
"""Cogging: the torque with which the iron holds the rotor, ``−torque_nm · sin(per_rev · x)``."""

from __future__ import annotations

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene.tables.cogging import Cogging

TORQUE, PER_REV = range(2)


def cogging_words(cogging: Cogging | None) -> np.ndarray:
    """Constants of :func:`cogging_torque`."""
    if cogging is None:
        return np.zeros(2)
    return np.array([cogging.torque_nm, float(cogging.per_rev)])


@compiled(inline="always")
def cogging_torque(x: float, words: np.ndarray) -> float:
    """Torque against a rotor at ``x``, N·m."""
    if words[TORQUE] == 0.0:
        return 0.0
    torque: float = words[TORQUE] * np.sin(words[PER_REV] * x)
    return torque
