# SPDX-License-Identifier: Apache-2.0
"""The measured bus as integers: what ``rtl/wh_bus_scale.v`` computes, and its settings."""

from __future__ import annotations

import math

from wavehaptics.words import formats

SHARE_Q = formats.BUS_SHARE.fraction + formats.BUS_Q - formats.BUS_W
"""Fraction bits of the share of u_max that a bus leaves."""


def bus_word(bus_v: float) -> int:
    """Word of a measured bus in V, the nearest."""
    return min(max(0, round(bus_v * 2.0**formats.BUS_Q)), (1 << formats.BUS_W) - 1)


def bus_share_word(limit_v: float, reach: float) -> int:
    """``bus_share_i`` for a limit that takes a bus of ``limit_v / reach`` in V.

    Rounded down, so that the bus never leaves too much. A limit of less than a quarter of a volt
    counts as one of a quarter.
    """
    return min(formats.BUS_SHARE.raw_max, math.floor(reach / limit_v / formats.BUS_SHARE.step))


def clocks_per_volt(half_clocks: int, bus: int, half_bridge: bool = False) -> int:
    """Clocks of half pulse width per volt on the measured ``bus``, as a word."""
    dividend = half_clocks << (formats.DUTY.fraction + formats.BUS_Q - (0 if half_bridge else 1))
    return min(formats.DUTY.raw_max, dividend // bus) if bus else formats.DUTY.raw_max


def share(bus: int, bus_share: int) -> int:
    """Part of u_max that the bus can make, with SHARE_Q fraction bits; 1 at most."""
    return min(1 << SHARE_Q, bus * bus_share >> formats.BUS_W)


def limited(u_max: int, part: int) -> int:
    """The word u_max times a :func:`share`."""
    return u_max * part >> SHARE_Q
