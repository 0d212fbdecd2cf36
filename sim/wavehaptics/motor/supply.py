# SPDX-License-Identifier: Apache-2.0
"""The supply of the bridge: a bus that steps, and that sags with the current drawn from it.

An averaged drive makes ``e = d·bus`` with a duty d and draws ``d·i``, so a bus that falls by
``sag_ohm`` times that acts as ``sag_ohm·d²`` in series with the winding. A step counts from the
first tick that begins after it. A controller that measures its bus makes both good, within what
the lowest bus reaches.
"""

from __future__ import annotations

import math

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene

STEP_S, STEP_PART, SAG_OHM, BUS_V = range(4)
"""Places in :func:`supply_words`: s, bus after the step over the bus before it, Ω, V."""


def supply_words(scene: Scene, made_good: bool) -> np.ndarray:
    """Constants of a scene's supply.

    ``made_good`` says that a controller which measures its bus sees nothing of them.
    """
    words = np.array([math.inf, 1.0, 0.0, 1.0])
    drive = scene.drive
    if drive is None or drive.true_bus_v is None:
        return words
    words[BUS_V] = drive.true_bus_v
    if not (drive.bus_measured and made_good):
        words[SAG_OHM] = drive.sag_ohm
        if drive.step_s is not None:
            words[STEP_S] = drive.step_s
            words[STEP_PART] = 1.0 + drive.step_v / drive.true_bus_v
    return words


def reached_v(scene: Scene) -> float:
    """Largest voltage that a controller can ask for which knows its bus, V: what it always has.

    The bus sags most where the rotor stands still; the controller takes the winding to be of R̂.
    """
    drive = scene.drive
    if drive is None:
        return math.inf
    sags = drive.sag_ohm / scene.controller.r_hat
    return drive.reached_v / (1.0 + sags * drive.reach**2)


@compiled(inline="always")
def supply_part(time: float, words: np.ndarray) -> float:
    """Bus in a tick that begins at ``time``, in parts of what it is at first."""
    return words[STEP_PART] if time >= words[STEP_S] else 1.0


@compiled(inline="always")
def sag_in_series(e: float, part: float, words: np.ndarray) -> float:
    """What the supply puts in series with a motor that gets ``e`` V of it, Ω."""
    duty = e / (part * words[BUS_V])
    sag: float = words[SAG_OHM] * duty * duty
    return sag
