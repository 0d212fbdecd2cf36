# SPDX-License-Identifier: Apache-2.0
"""Few clocks a carrier period and still twelve bits below 5 kHz: error feedback in the duty."""

from __future__ import annotations

import pytest
from wavetools.studies.duty_spectrum import duty_noise

TWELVE_BITS_DB = 74.0


@pytest.mark.parametrize("steps", [24, 48, 100])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("part", [0.02, 0.1, 0.6])
def test_feedback_makes_twelve_bits_of_few_steps(steps, order, part):
    assert duty_noise(steps, order, part=part).snr_db >= TWELVE_BITS_DB


@pytest.mark.parametrize("steps", [24, 48, 100])
def test_without_feedback_there_are_no_twelve_bits(steps):
    assert duty_noise(steps, 0).snr_db < 40.0


def test_order_two_gains_where_order_one_does():
    """Shaped once more, the error leaves the band below 5 kHz."""
    assert duty_noise(24, 2).snr_db > duty_noise(24, 1).snr_db + 20.0


def test_order_two_wants_room_at_the_limit():
    """Its widths swing by a clock and a half: of six, at 0.92 of the bus, some are clipped."""
    assert duty_noise(24, 1, part=0.7).snr_db >= TWELVE_BITS_DB
    assert duty_noise(24, 2, part=0.7).snr_db < TWELVE_BITS_DB


def test_other_orders_are_refused():
    with pytest.raises(ValueError, match="order 1 and 2, not 3"):
        duty_noise(24, 3)
