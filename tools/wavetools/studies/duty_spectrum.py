# SPDX-License-Identifier: Apache-2.0
"""The voltage's error below 5 kHz that whole clocks of pulse width leave, by the feedback's order.

A carrier of few clocks a half is given a slow voltage, and the integer model of ``wh_modulator``
makes widths of it. Their error's spectrum is summed up to 5 kHz, against the power of the largest
sine that the bridge can make: that is how many bits a converter without any feedback would need.
No page shows it: tests hold the carriers of the boards to twelve bits by it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid
from scipy.signal import welch
from wavehaptics.controller.modulator import half_width, new_modulator
from wavehaptics.runtime.compiled import compiled_counting
from wavehaptics.words import formats

HALF_HZ = 1e6
"""Halves a second: a carrier of 500 kHz."""
BAND_HZ = 5e3
BIT_DB = 20 * math.log10(2)
SINE_DB = 20 * math.log10(math.sqrt(1.5))
"""A converter of n bits is 6.02 n + 1.76 dB below the largest sine."""

_ONE = 1 << formats.DUTY.fraction


@dataclass(frozen=True)
class Noise:
    """Error of the width with ``steps`` clocks in a carrier period and a feedback of ``order``."""

    steps: int
    order: int
    frequency_hz: np.ndarray
    density_db: np.ndarray
    """Error's power in 1 Hz over that of the largest sine, dB."""
    snr_db: float
    """Largest sine over the error below 5 kHz."""

    @property
    def bits(self) -> float:
        """Bits of a converter with the same error below 5 kHz, spread over half its rate."""
        return (self.snr_db - SINE_DB) / BIT_DB


@compiled_counting()
def _plain(duties: np.ndarray) -> np.ndarray:
    """Widths without feedback: each rounded by itself."""
    widths = np.empty(duties.shape[0], dtype=np.int64)
    for n in range(duties.shape[0]):
        widths[n] = (duties[n] + _ONE // 2) // _ONE
    return widths


@compiled_counting()
def _modulated(duties: np.ndarray, half_clocks: int, second_order: bool, state) -> np.ndarray:
    widths = np.empty(duties.shape[0], dtype=np.int64)
    for n in range(duties.shape[0]):
        widths[n] = half_width(state, duties[n], 0, half_clocks, second_order)
    return widths


def duty_noise(
    steps: int, order: int, *, part: float = 0.1, signal_hz: float = 37.0, seconds: float = 1.0
) -> Noise:
    """Noise for a sine of ``part`` of the bus with a direct part, as a wall's voltage has them.

    ``steps`` are clocks in a carrier period of two halves, and so the widths that the pulse can
    have; ``order`` 0 rounds each half by itself. ``ValueError`` for other orders than 0, 1, 2.
    """
    if order not in (0, 1, 2):
        raise ValueError(f"the modulator has feedback of order 1 and 2, not {order}")
    half_clocks = steps // 2
    count = round(seconds * HALF_HZ)
    time = np.arange(count) / HALF_HZ
    largest = half_clocks / 2
    asked = largest * part * (0.31 + np.sin(2 * np.pi * signal_hz * time))
    duties = np.round(asked * _ONE).astype(np.int64)
    if order == 0:
        widths = _plain(duties)
    else:
        widths = _modulated(duties, half_clocks, order == 2, new_modulator())
    error = (widths - duties / _ONE) / largest
    frequency, density = welch(error, HALF_HZ, nperseg=1 << 15, detrend=False)
    in_band = frequency <= BAND_HZ
    power = trapezoid(density[in_band], frequency[in_band])
    sine_power = 0.5
    with np.errstate(divide="ignore"):
        density_db = 10 * np.log10(density / sine_power)
    return Noise(steps, order, frequency, density_db, 10 * math.log10(sine_power / power))
