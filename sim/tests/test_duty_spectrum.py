# SPDX-License-Identifier: Apache-2.0
"""Few clocks a carrier period and still twelve bits below 5 kHz: error feedback in the duty.

The integer model of ``wh_modulator`` makes widths of whole clocks of a slow voltage. Their error's
spectrum is summed up to 5 kHz, against the power of the largest sine that the bridge can make.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.signal import welch
from wavehaptics.controller.modulator import half_width, new_modulator
from wavehaptics.runtime.compiled import compiled_counting
from wavehaptics.words import formats

HALF_HZ = 1e6
"""Halves a second: a carrier of 500 kHz."""
BAND_HZ = 5e3
TWELVE_BITS_DB = 74.0
_ONE = 1 << formats.DUTY.fraction


@compiled_counting()
def _modulated(duties: np.ndarray, half_clocks: int, second_order: bool, state) -> np.ndarray:
    widths = np.empty(duties.shape[0], dtype=np.int64)
    for n in range(duties.shape[0]):
        widths[n] = half_width(state, duties[n], 0, half_clocks, second_order)
    return widths


def snr_db(steps: int, order: int, part: float = 0.1) -> float:
    """Largest sine over the error below 5 kHz.

    The duty is a sine of ``part`` of the bus with a direct part, as a wall's voltage has them.
    ``steps`` are clocks in a carrier period of two halves; ``order`` 0 rounds each half by itself.
    """
    half_clocks = steps // 2
    time = np.arange(int(HALF_HZ)) / HALF_HZ
    largest = half_clocks / 2
    asked = largest * part * (0.31 + np.sin(2 * np.pi * 37.0 * time))
    duties = np.round(asked * _ONE).astype(np.int64)
    if order == 0:
        widths = (duties + _ONE // 2) // _ONE
    else:
        widths = _modulated(duties, half_clocks, order == 2, new_modulator())
    error = (widths - duties / _ONE) / largest
    frequency, density = welch(error, HALF_HZ, nperseg=1 << 15, detrend=False)
    in_band = frequency <= BAND_HZ
    power = trapezoid(density[in_band], frequency[in_band])
    return 10 * math.log10(0.5 / power)


@pytest.mark.parametrize("steps", [24, 48, 100])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("part", [0.02, 0.1, 0.6])
def test_feedback_makes_twelve_bits_of_few_steps(steps, order, part):
    assert snr_db(steps, order, part) >= TWELVE_BITS_DB


@pytest.mark.parametrize("steps", [24, 48, 100])
def test_without_feedback_there_are_no_twelve_bits(steps):
    assert snr_db(steps, 0) < 40.0


def test_order_two_gains_where_order_one_does():
    """Shaped once more, the error leaves the band below 5 kHz."""
    assert snr_db(24, 2) > snr_db(24, 1) + 20.0


def test_order_two_wants_room_at_the_limit():
    """Its widths swing by a clock and a half: of six, at 0.92 of the bus, some are clipped."""
    assert snr_db(24, 1, part=0.7) >= TWELVE_BITS_DB
    assert snr_db(24, 2, part=0.7) < TWELVE_BITS_DB
