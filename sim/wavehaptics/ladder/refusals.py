# SPDX-License-Identifier: Apache-2.0
"""Whether a scene can run on a controller: all that a run would be refused for, in no time."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from wavehaptics.controller.pins_timing import turns_clocks
from wavehaptics.controller.ports import controller_ports
from wavehaptics.controller.settings import settings
from wavehaptics.controller.tick_layout import CLOCK_HZ, FASTEST_CLOCK_HZ
from wavehaptics.controller.turns import take_turns, turns_ports
from wavehaptics.ladder.abilities import left_out, refuse
from wavehaptics.ladder.device_abilities import left_out_of_device, refuse_device
from wavehaptics.ladder.encoder import check_rates
from wavehaptics.scene import Device, Scene, Space
from wavehaptics.trace.columns import ROW_BYTES, thinning


def check(
    scene: Scene, controller: str, others: Sequence[Scene] = (), space: Space | None = None
) -> float:
    """The tick that it would run at, s, as one of the motors ``others``, which has it in it.

    They move one tip in ``space``.

    :class:`SceneError`, one line, where ``controller`` can't do what the scene asks for, a word
    can't hold a value, or the rows of its trace can't be held.
    """
    refuse(scene, controller)
    tick_s = 1.0 / scene.controller.tick_hz
    if controller == "pins" and (space is not None or take_turns(others)):
        tick_s = turns_ports(others, len(space.solids) if space else 0)[0].timing.tick_s
    elif controller == "pins":
        tick_s = controller_ports(scene).timing.tick_s
    else:
        settings(scene)
    if controller == "encoder":
        check_rates(scene)
    _check_memory(scene, tick_s)
    return tick_s


def check_device(device: Device, controller: str) -> list[str]:
    """As :func:`check` of each motor: what a person should know of how it runs, a line each."""
    refuse_device(device, controller)
    told = []
    if missing := left_out_of_device(device, controller):
        told.append(f"`{controller}` leaves out {', '.join(missing)}")
    if controller == "pins" and device.space is not None:
        told += _of_clock(device.scenes, len(device.space.solids))
    for name, scene in device.motors.items():
        of = f"{name}: " if len(device.motors) > 1 else ""
        tick_hz = 1.0 / check(scene, controller, device.scenes, device.space)
        asked_hz = scene.controller.tick_hz
        if not math.isclose(tick_hz, asked_hz, rel_tol=1e-6):
            told.append(
                f"{of}`{controller}` ticks at {tick_hz:.6g} Hz, with its carrier, and not at "
                f"controller.tick_hz = {asked_hz:g} Hz"
            )
        if missing := left_out(scene, controller):
            told.append(f"{of}`{controller}` leaves out {', '.join(missing)}")
    return told


def _of_clock(scenes: Sequence[Scene], surfaces: int) -> list[str]:
    """A line where motors with surfaces take a clock that is faster than a board's."""
    time = turns_ports(scenes, surfaces)[0].timing
    if scenes[0].controller.clock_hz is not None or time.clock_hz <= FASTEST_CLOCK_HZ:
        return []
    least = turns_clocks(len(scenes), surfaces=surfaces)
    return [
        f"`pins` has a clock of {time.clock_hz / 1e6:.0f} MHz for this tick; a board's "
        f"{CLOCK_HZ / 1e6:.0f} MHz has time for controller.tick_hz = {CLOCK_HZ / least:.3g} Hz"
    ]


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
