# SPDX-License-Identifier: Apache-2.0
"""Whether a scene can run on a controller: all that a run would be refused for, in no time."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from wavehaptics.controller.ports import controller_ports
from wavehaptics.controller.settings import settings
from wavehaptics.controller.turns import take_turns, turns_ports
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.encoder import check_rates
from wavehaptics.scene import Scene
from wavehaptics.trace.columns import ROW_BYTES, thinning


def check(scene: Scene, controller: str, others: Sequence[Scene] = ()) -> float:
    """The tick that it would run at, s, as one of the motors ``others``, which has it in it.

    :class:`SceneError`, one line, where ``controller`` can't do what the scene asks for, a word
    can't hold a value, or the rows of its trace can't be held.
    """
    refuse(scene, controller)
    tick_s = 1.0 / scene.controller.tick_hz
    if controller == "pins" and take_turns(others):
        tick_s = turns_ports(others)[0].timing.tick_s
    elif controller == "pins":
        tick_s = controller_ports(scene).timing.tick_s
    else:
        settings(scene)
    if controller == "encoder":
        check_rates(scene)
    _check_memory(scene, tick_s)
    return tick_s


def _check_memory(scene: Scene, tick_s: float) -> None:
    every_s = tick_s * thinning(tick_s, scene.scene.trace_hz)
    needed = scene.scene.duration_s / every_s * ROW_BYTES
    there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed > there:
        most_hz = there / ROW_BYTES / scene.scene.duration_s
        digits = 10.0 ** math.floor(math.log10(most_hz))
        raise scene.refusal(
            f"scene.duration_s = {scene.scene.duration_s:g} s is {needed / 1e9:.3g} GB of trace, "
            f"and this machine has {there / 1e9:.3g}; set scene.trace_hz to "
            f"{math.floor(most_hz / digits) * digits:g} or less",
            "scene.duration_s", "scene.trace_hz",
        )  # fmt: skip
