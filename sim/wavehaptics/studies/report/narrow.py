# SPDX-License-Identifier: Apache-2.0
"""A run on the integer model at the word lengths of the environment, in a process of its own.

``python -m wavehaptics.studies.report.narrow OUT SCENE TABLE.KEY=VALUE...`` writes the rows of the
run (float64, ticks × Column) into OUT as ``.npy``. See :mod:`wavehaptics.words.formats` for the
environment.
"""

from __future__ import annotations

import sys

import numpy as np

from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.stability import simulate


def main(out: str, scene: str, *settings: str) -> None:
    """Simulate and write."""
    loaded = load(scene, list(settings))
    rows = simulate(SampledSimulation(loaded, rtl=False), loaded.scene.duration_s)
    np.save(out, rows)


if __name__ == "__main__":
    main(*sys.argv[1:])
