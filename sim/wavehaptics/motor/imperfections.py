# SPDX-License-Identifier: Apache-2.0
"""What a scene says of its real motor, supply, encoder and amplifier, for the controllers' loops.

A loop takes it as one argument, which is None for an ideal scene: numba then compiles the loop
without any of it, once more, so that it costs an ideal scene nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wavehaptics.motor.absolute import PERIOD_S, absolute_count, new_readings, reading_words
from wavehaptics.motor.encoder_lines import FAULTY, line_count, line_words, new_lines
from wavehaptics.motor.plant import Plant, X
from wavehaptics.motor.sensor import (
    COMMON_MODE,
    DRIFT,
    HOLD_S,
    LAG_RATE,
    Sensor,
    disturbed,
    new_holds,
)
from wavehaptics.motor.step import MEMORY, SERIES_OHM, motor_parts, warm_parts
from wavehaptics.motor.supply import SAG_OHM, STEP_PART, sag_in_series, supply_part, supply_words
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene

MOTOR, SUPPLY, LINES, LINE_MEMORY, LAG_TABLE, LAG, HOLDS, READING, READINGS = range(9)
"""Places in :func:`real_parts`."""

Real = tuple[Any, ...]
"""Arrays, and of the motor a tuple of them."""

AMPLIFIED, VOLTS, DRAWN, LOAD, LEAD, LEAD_EDGE = range(6)
"""Places in the LAG memory: the amplifier's output in A; with a switching bridge, the voltage that
was last applied, the charge drawn from the bus in this tick, A·s, and the mean of the last, A; lead
A's level, ±½ and 0 before the first, and what is left of its edges at the amplifier, A."""


def real_parts(
    scene: Scene, plant: Plant, cell_rad: float, steps_s: Sequence[float], switching: bool = False,
    always: bool = False,
) -> Real | None:  # fmt: skip
    """What the loops take, for steps of the lengths ``steps_s``; None for an ideal scene.

    ``switching`` is whether there is a bridge that draws from the bus itself; ``always`` gives an
    ideal scene its parts as well, for a loop of several motors.
    """
    supply, lines = supply_words(scene, not switching), line_words(scene)
    reading = reading_words(scene)
    sensor = Sensor.of_scene(scene)
    words = sensor.constants()
    if not (
        always
        or plant.real
        or supply[STEP_PART] != 1.0
        or lines[FAULTY]
        or reading[PERIOD_S]
        or np.any(words[[LAG_RATE, COMMON_MODE, DRIFT]])
        or (switching and words[HOLD_S])
    ):
        return None
    memory = new_lines(plant.start[X], cell_rad, lines)
    return (
        motor_parts(plant),
        supply,
        lines,
        memory,
        sensor.lag_table(np.asarray(steps_s)),
        np.zeros(6),
        new_holds(1),
        reading,
        new_readings(plant.start[X], cell_rad, reading),
    )


def warm_real(real: Real | None, plant: Plant) -> None:
    """Let the motor follow the plant's R."""
    if real is not None:
        warm_parts(real[MOTOR], plant)


@compiled(inline="always")
def supplied(e: float, time: float, real: Real) -> tuple[float, float]:
    """(V at the motor without current, Ω in series that the supply's sag is) of a tick."""
    part = supply_part(time, real[SUPPLY])
    e *= part
    if real[SUPPLY][SAG_OHM] == 0.0:
        return e, 0.0
    sag = sag_in_series(e, part, real[SUPPLY])
    real[MOTOR][MEMORY][SERIES_OHM] = sag
    return e, sag


@compiled(inline="always")
def amplified(
    current: float, point: int, lag_before: float, tick_s: float, e: float, time: float,
    sensor: np.ndarray, real: Real,
) -> float:  # fmt: skip
    """What the amplifier makes of a tick's mean ``current`` in A: its mean, or its ``point``."""
    if sensor[LAG_RATE] != 0.0:
        if point:
            current = real[LAG][AMPLIFIED]
        else:  # from dz/dt = ω_b (i − z)
            current -= (real[LAG][AMPLIFIED] - lag_before) / (sensor[LAG_RATE] * tick_s)
    return disturbed(current, e, time, sensor)


@compiled(inline="always")
def look(x: float, time: float, cell: float, real: Real) -> None:
    """Let an absolute encoder be read at a tick's end, for who asks for the count more rarely."""
    if real[READING][PERIOD_S] != 0.0:
        absolute_count(x, time, cell, real[READING], real[READINGS])


@compiled(inline="always")
def counted(position: int, x: float, time: float, cell: float, end_s: float, real: Real) -> int:
    """The encoder's count at a tick's end; ``position`` is the one before."""
    if real[READING][PERIOD_S] != 0.0:
        return absolute_count(x, time, cell, real[READING], real[READINGS])
    if real[LINES][FAULTY] != 0.0:
        return line_count(x, time, cell, real[LINES], real[LINE_MEMORY])
    return int(np.floor(x / cell)) if time < end_s else position
