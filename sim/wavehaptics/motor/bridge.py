# SPDX-License-Identifier: Apache-2.0
"""The bridge: from gate signals to the voltage at the motor."""

from __future__ import annotations

from wavehaptics.runtime.compiled import compiled

GATE_AH, GATE_AL, GATE_BH, GATE_BL = 1, 2, 4, 8
"""Bits of the gates of legs A and B, high and low side."""
GATES = GATE_AH | GATE_AL | GATE_BH | GATE_BL


@compiled(inline="always")
def bridge_voltage(gates: int, current: float, bus_v: float) -> float:
    """Voltage of leg A over leg B, V, for the bits ``gates`` and the motor's ``current`` in A.

    A leg with both gates off follows the current through its diodes: a current out of the leg
    comes from ground, a current into it goes to the bus. Leg B's gates stay off in a half bridge:
    see :func:`half_bridge_voltage`.
    """
    high_a = gates & 1
    if gates & 3 == 0:
        high_a = 1 if current < 0.0 else 0
    high_b = (gates >> 2) & 1
    if gates & 12 == 0:
        high_b = 1 if current > 0.0 else 0
    return bus_v * (high_a - high_b)


@compiled(inline="always")
def half_bridge_voltage(gates: int, current: float, bus_v: float) -> float:
    """Voltage of leg A over the middle of the bus, V; the motor lies between the two."""
    high_a = gates & 1
    if gates & 3 == 0:
        high_a = 1 if current < 0.0 else 0
    return bus_v * (high_a - 0.5)
