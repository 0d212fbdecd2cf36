# SPDX-License-Identifier: Apache-2.0
"""Random settings of a port anchor, which the benches of whole controllers share."""

from __future__ import annotations

import math
import random

import numpy as np
from wavehaptics.controller import anchor
from wavehaptics.words import formats


def random_anchor(rng: random.Random, ohm: float, strange: tuple[float, ...]) -> np.ndarray:
    """Words with which some dozen ticks show an anchor's every side; ``strange`` in V."""
    words = np.zeros(anchor.SETTINGS, dtype=np.int64)
    words[anchor.ENABLE] = rng.random() < 0.9
    words[anchor.FLUX_GAIN] = formats.FLUX.to_raw(10.0 ** rng.uniform(-4.0, -1.0))
    words[anchor.OWED_GAIN] = rng.choice((0, words[anchor.FLUX_GAIN]))
    words[anchor.CELLS_GAIN] = formats.CELLS.to_raw(rng.uniform(0.02, 2.0))
    words[anchor.PULL_GAIN] = formats.PULL.to_raw(rng.uniform(0.1, 3.0))
    words[anchor.LEARN_GAIN] = formats.LEARN.to_raw(10.0 ** rng.uniform(-5.0, -2.2))
    words[anchor.LEARN_MAX] = formats.PULL.to_raw(rng.uniform(0.0, 1.0))
    words[anchor.BRUSH] = round(rng.uniform(0.0, 1.0) / anchor.SEEN_CELLS)
    words[anchor.ZERO_GAIN] = formats.FLUX.to_raw(10.0 ** rng.uniform(-3.0, -1.0) / ohm)
    words[anchor.ROOM_GAIN] = formats.FLUX.to_raw(1.0 / math.sqrt(2 * ohm))
    words[anchor.REACH] = formats.VOLTAGE.to_raw(rng.uniform(0.1, 2.0))
    words[anchor.STRANGE] = formats.VOLTAGE.to_raw(rng.choice(strange))
    words[anchor.FOLLOW_TICKS] = rng.randint(1, 4)
    words[anchor.SLOW_TICKS] = rng.randint(0, 9)
    return words
