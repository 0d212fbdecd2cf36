# SPDX-License-Identifier: Apache-2.0
"""Tasks that several sections share: a scene with settings, on a controller."""

from __future__ import annotations

from typing import Any

from wavehaptics.ladder.run import measure
from wavehaptics.runtime.repository import BUILD
from wavehaptics.scene import Scene, find_scene, load_scene
from wavehaptics.studies.sweeps import Task

STORE = BUILD / "sweeps"
"""Where finished tasks are kept, so that an interrupted report goes on."""

FIRST_CONTACT_S = 0.26
"""Up to the deepest point of the first contact of the paper's taps: enough for a stiffness."""


def load(scene: str, settings: list[str]) -> Scene:
    """A shipped scene with ``table.key=value`` settings."""
    return load_scene(find_scene(scene), settings)


def run(scene: str, controller: str, settings: list[str]) -> dict[str, Any]:
    """Metrics of a run."""
    return measure(load(scene, settings), controller)


def run_task(scene: str, controller: str, *settings: str) -> Task:
    """Task of :func:`run`."""
    return Task(run, {"scene": scene, "controller": controller, "settings": list(settings)})


def cost(metrics: dict[str, Any]) -> float:
    """Seconds that a simulated second took."""
    seconds: float = metrics["wall_clock_s"] / metrics["duration_s"]
    return seconds


def off(value: float | None, exact: float | None) -> float | None:
    """How far ``value`` is off ``exact``, as a part of it; None where there is no value."""
    return None if value is None or not exact else abs(value / exact - 1)
