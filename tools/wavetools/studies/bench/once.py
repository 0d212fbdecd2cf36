# SPDX-License-Identifier: Apache-2.0
"""One thing to measure, in a process of its own.

``python -m wavetools.studies.bench.once WHAT`` builds and compiles what WHAT needs and
prints a line of JSON; then it measures once for each line that it reads, and prints what it found.
WHAT is a controller.

Seconds are the processor's (``cpu_s``) and the clock's (``wall_s``).
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from wavehaptics.ladder.run import CHUNK_TICKS, CONTROLLERS, measure
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.trace.columns import Column, Word

SCENE = "paper_taps"
DURATIONS_S = {"analog": 0.5, "golden": 2.0, "core": 0.2, "pins": 0.2, "encoder": 2.0}
"""Long enough to press into the wall, or the error would be that of no torque."""

Measurement = Callable[[], dict[str, Any]]


class _Watch:
    """Seconds since it was made."""

    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def seconds(self) -> dict[str, float]:
        return {
            "wall_s": time.perf_counter() - self._wall,
            "cpu_s": time.process_time() - self._cpu,
        }


def whole(controller: str, duration_s: float) -> tuple[dict[str, Any], Measurement]:
    """The paper's taps on a controller, its motor in the loop: error first, then seconds."""
    scene = load_scene(find_scene(SCENE), [f"scene.duration_s={duration_s}"])
    metrics = measure(scene, controller)
    ticks = metrics["ticks"]
    rows = np.zeros((min(ticks, CHUNK_TICKS), len(Column)))
    words = np.zeros((len(rows), len(Word)), dtype=np.int64)

    def once() -> dict[str, Any]:
        simulation = CONTROLLERS[controller](scene)
        watch = _Watch()
        for first in range(0, ticks, CHUNK_TICKS):
            part = slice(0, min(CHUNK_TICKS, ticks - first))
            simulation.advance(rows[part], words[part])
        return watch.seconds()

    known = {
        "ticks": ticks,
        "clock_cycles": metrics["clock_cycles"],
        "duration_s": metrics["duration_s"],
        "torque_error": metrics["torque_nrmse_vs_analog"],
    }
    return known, once


def main(what: str) -> None:
    """Get ready, and measure as often as is asked for."""
    known, once = whole(what, DURATIONS_S[what])
    print(json.dumps(known), flush=True)
    for _ in sys.stdin:
        print(json.dumps(once()), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
