# SPDX-License-Identifier: Apache-2.0
"""Several motors at one controller on `pins` against as many runs of one motor, side by side.

``python -m wavetools.studies.bench.motors [SCENE] [--motors N] [--set table.key=value ...]``
prints seconds of the processor for the same ticks on the same clock, and their ratio: of N single
runs to one of N motors. A scene of one motor has it N times.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence

import numpy as np
from wavehaptics.controller.tick_layout import Timing
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.ladder.turns_pins import TurnsSimulation
from wavehaptics.scene import Scene, find_scene, load_device
from wavehaptics.trace.columns import Column, Word

TICKS = 20_000
ROUNDS = 5
"""Of which the fastest counts."""


def seconds(scenes: Sequence[Scene]) -> tuple[float, float, Timing]:
    """(s of single runs, s of all motors at one controller, how its ticks are laid).

    Each is the least of some rounds.
    """
    rows = [np.zeros((TICKS, len(Column))) for _ in scenes]
    words = [np.zeros((TICKS, len(Word)), dtype=np.int64) for _ in scenes]
    laid = TurnsSimulation(scenes).motors[0]
    alone = [_alone(scene, laid) for scene in scenes]
    found = [np.inf, np.inf]
    for _ in range(ROUNDS):
        singles, together = [PinsSimulation(scene) for scene in alone], TurnsSimulation(scenes)
        for single in singles:
            single.advance(rows[0][:0], words[0][:0])
        together.advance([row[:0] for row in rows], [word[:0] for word in words])
        began = time.process_time()
        for single in singles:
            single.advance(rows[0], words[0])
        between = time.process_time()
        together.advance(rows, words)
        found = [min(found[0], between - began), min(found[1], time.process_time() - between)]
    return found[0], found[1], laid.timing


def _alone(scene: Scene, laid: PinsSimulation) -> Scene:
    """The scene with the clock and the latency that it has among others."""
    laid_on = laid.timing
    control = scene.controller.model_copy(
        update={"clock_hz": laid_on.clock_hz, "extra_ticks": laid_on.extra_ticks}
    )
    return scene.model_copy(update={"controller": control})


def main() -> None:
    """Print the seconds of both, and how much faster they are together."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("scene", nargs="?", default="two_motors")
    options.add_argument("--motors", type=int, default=3)
    options.add_argument("--set", action="append", default=[], dest="overrides")
    chosen = options.parse_args()
    device = load_device(find_scene(chosen.scene), chosen.overrides)
    scenes = [device.scenes[n % len(device.scenes)] for n in range(chosen.motors)]
    singles_s, together_s, timing = seconds(scenes)
    print(
        f"{device.name}, {len(scenes)} motors, {TICKS} ticks of {timing.tick_clocks} clocks: "
        f"one after another {singles_s:.3f} s, together {together_s:.3f} s, "
        f"ratio {singles_s / together_s:.2f}"
    )


if __name__ == "__main__":
    main()
