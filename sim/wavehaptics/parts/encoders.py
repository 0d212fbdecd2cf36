# SPDX-License-Identifier: Apache-2.0
"""Absolute magnetic encoders with a serial port: what their makers say of them.

A reading is the angle some time ago, with noise; it comes no faster than the part converts and its
frame can be read. Figures *from memory* must be looked up before a design leans on them. The
linearity, ±0.8° of the AS5047P and the AS5048A at best, is not among them: it moves a wall, and is
the same each turn.
"""

from __future__ import annotations

from typing import NamedTuple


class AbsolutePart(NamedTuple):
    """A part by its data sheet; the first five are keys of a scene's ``[encoder]``, too."""

    bits: int
    read_hz: float
    """Fastest rate of new readings: the part's own, or its frame's at the fastest clock."""
    latency_s: float
    """From the angle to the beginning of the frame that has it, and that frame."""
    noise_counts: float
    """RMS, in counts of ``bits``."""
    bandwidth_hz: float | None
    """Of its tracking filter, which follows a constant speed without a lag; None without one."""
    sclk_hz: float
    frame: str
    remembered: tuple[str, ...]
    """Fields that are from memory, or taken."""

    def settings(self) -> dict[str, float | None]:
        """Keys of a scene's ``[encoder]``."""
        return {key: getattr(self, key) for key in self._fields[:5]}


def _degrees(noise: float, bits: int) -> float:
    return noise / 360.0 * 2.0**bits


_AMS = "16 bits: even parity, error flag, angle"
_MPS = "16 bits: angle, no check"
_MPS_REMEMBERED = ("read_hz", "latency_s", "bandwidth_hz", "sclk_hz", "frame")

ABSOLUTE_PARTS: dict[str, AbsolutePart] = {
    # AS5047P, v1-00 (2014): 14 bits; 350 ns from CS's fall to SCLK and between frames; 202 to 247
    # kHz (printed as ns); 90 to 110 µs of the core. ANGLEUNC (0x3FFE), whose noise is 0.068° less
    # the 0.016° of the compensation. The frame that has an angle comes after the one that asks for
    # it: 2.3 µs each.
    "AS5047P": AbsolutePart(
        14, 222e3, 100e-6 + 4.6e-6, _degrees(0.052, 14), None, 10e6, _AMS, ()
    ),
    # AS5048A, v1-06 (2014): 10.2 to 12.4 kHz, 90.7 to 110.2 µs, 0.06°; frames as above.
    "AS5048A": AbsolutePart(
        14, 11.25e3, 100e-6 + 4.6e-6, _degrees(0.06, 14), None, 10e6, _AMS, ()
    ),
    # MA702 and MA730: cut-off of (1 + 2τs)/(1 + τs)², delay at constant speed and a frame of 0.8
    # µs. The maker's article on the filter has ± 3σ as the resolution, so that a count of it is 6σ,
    # and 11.5 bits of the MA702.
    "MA702": AbsolutePart(
        12, 980e3, 8e-6 + 0.8e-6, 2**0.5 / 6, 390.0, 25e6, _MPS, _MPS_REMEMBERED
    ),
    "MA730": AbsolutePart(
        14, 980e3, 10e-6 + 0.8e-6, 1 / 6, 23.0, 25e6, _MPS, (*_MPS_REMEMBERED, "noise_counts")
    ),
    # MT6701, rev. 1.8 (2022): 5 µs at constant speed, 0.01° of A and B at 25 °C; a clock of 64 ns,
    # 100 ns from CSN's fall to it, CRC of x⁶ + x + 1: 1.7 µs a frame. How often it converts isn't
    # said, nor of what filter its noise is.
    "MT6701": AbsolutePart(
        14, 500e3, 5e-6 + 1.7e-6, _degrees(0.01, 14), None, 15.6e6,
        "24 bits: angle, status, CRC-6", ("read_hz",),
    ),
}  # fmt: skip
"""Absolute encoders by name."""
