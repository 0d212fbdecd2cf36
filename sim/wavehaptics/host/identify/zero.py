# SPDX-License-Identifier: Apache-2.0
"""The sensor without a current: what it shows with the bridges off."""

from __future__ import annotations

import numpy as np

from wavehaptics.host.identify.segments import Estimate

MOST = 1 / 16
"""Largest offset, of full scale."""


def offset(currents: np.ndarray) -> Estimate:
    """Offset of readings of the current, A; the spread is a reading's."""
    return Estimate(float(np.mean(currents)), float(np.std(currents)))
