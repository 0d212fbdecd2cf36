# SPDX-License-Identifier: Apache-2.0
"""The sensor without a current: what it shows with the bridges off."""

from __future__ import annotations

import numpy as np

from wavehaptics.host.identify.segments import Estimate

MOST = 1 / 16
"""Largest offset, of full scale."""


def offset(currents: np.ndarray) -> Estimate:
    """Offset of readings of the current, A; the spread is a reading's. Of vectors, their size."""
    mean = np.mean(currents)
    value = abs(mean) if np.iscomplexobj(currents) else mean
    return Estimate(float(value), float(np.std(currents)))
