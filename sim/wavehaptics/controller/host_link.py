# SPDX-License-Identifier: Apache-2.0
"""The link to an environment that runs on a computer, as integers: ``rtl/wh_host_link.v``.

A period is ``2**period_log2`` ticks. At its end the mean of v goes to the host with a number, and
what the host answers is the goal of the filter for a whole period. Two things make that passive
whatever the host, the line and the clocks do:

- The **mean** v̄: ``P v̄² ≤ Σ v²``, so the host never gets more than the port took in.
- The **budget**: v̄² of each period is paid in, u² of each is paid out, and a u that is not covered
  is halved until it is. Late, lost, repeated or forged answers can't take out what was not there.

An answer counts once, and only if its number is newer than that of the last. Without a new one the
last u is held, as far as the budget goes; after ``timeout`` such periods the link falls silent, and
the port has its own environment again, which sees its own v and owes the budget nothing.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.controller.wave_core import truncate
from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats

SEQUENCES = 256
"""Numbers of the packets before they begin again."""
OLDEST = 128
"""An answer to a packet so many periods old, or older, is not believed."""
TANK_MAX = (1 << (2 * formats.DATA_W)) - 1
"""The budget's largest value, in squares of a wave's last place; what is beyond it is lost."""

(
    SUM, TICKS, SEQUENCE, AGE, SILENT, ACTIVE, U, COST, TANK, PENDING, PENDING_U,
) = range(11)  # fmt: skip
"""Places in a link's state."""


def new_state() -> np.ndarray:
    """State of a link after reset: int64, shape (11,)."""
    state = np.zeros(11, dtype=np.int64)
    state[AGE] = OLDEST
    return state


@compiled()
def answer(state: np.ndarray, sequence: int, u: int) -> bool:
    """An answer of the host arrives, to packet ``sequence``; whether it counts.

    It counts if it is newer than whatever counted before. Of several in a period the newest is
    taken at the period's end.
    """
    age = (state[SEQUENCE] - sequence) & (SEQUENCES - 1)
    if age >= state[AGE]:
        return False
    state[AGE] = age
    state[PENDING], state[PENDING_U] = 1, u
    return True


@compiled()
def tick(state: np.ndarray, v: int, period_log2: int, timeout: int) -> tuple[bool, int, int]:
    """One tick with its wave v; returns (a packet goes out, its number, its v̄)."""
    state[SUM] += v
    state[TICKS] += 1
    if state[TICKS] < 1 << period_log2:
        return False, 0, 0
    mean = truncate(state[SUM], period_log2)
    state[SUM] = state[TICKS] = 0
    state[SEQUENCE] = (state[SEQUENCE] + 1) & (SEQUENCES - 1)
    state[AGE] = min(state[AGE] + 1, OLDEST)
    was_active = state[ACTIVE]
    if state[PENDING]:
        state[SILENT], state[ACTIVE] = 0, 1
        state[U], state[COST] = state[PENDING_U], state[PENDING_U] * state[PENDING_U]
        state[PENDING] = 0
    elif state[SILENT] < timeout:
        state[SILENT] += 1
    if state[SILENT] >= timeout:
        state[ACTIVE] = 0
    if state[ACTIVE]:
        while state[COST] > state[TANK]:
            state[U], state[COST] = truncate(state[U], 1), state[COST] >> 2
        state[TANK] -= state[COST]
        if was_active:
            state[TANK] = min(state[TANK] + mean * mean, TANK_MAX)
    else:
        state[U] = state[COST] = state[TANK] = 0
    return True, state[SEQUENCE], mean
