# SPDX-License-Identifier: Apache-2.0
"""What the RTL of a run reported besides its rows."""

from __future__ import annotations

from typing import Any

from wavehaptics.words.faults import FAULTS, bits_of

_FAULTS = ("a tick too short for its work", "more than one encoder edge in a clock")
"""First bits of :attr:`wavehaptics.ladder.pins.PinsSimulation.faults`; behind them the guard's."""


def seen(simulation: object) -> dict[str, Any]:
    """The highest voltage of a bus that isn't drained, and faults that the RTL reported.

    With a fault the run is not a valid run of the scene.
    """
    highest_v = getattr(simulation, "bus_highest_v", None)
    bus = {} if highest_v is None else {"bus_highest_v": highest_v}
    faults = getattr(simulation, "faults", 0)
    found = [text for bit, text in enumerate(_FAULTS) if faults >> bit & 1]
    if guard := faults >> len(_FAULTS):
        names = ", ".join(FAULTS[bit][0] for bit in bits_of(guard))
        found.append(f"switched off at {getattr(simulation, 'off_s', 0.0):.6g} s: {names}")
    return bus | ({"faults": "; ".join(found)} if found else {})
