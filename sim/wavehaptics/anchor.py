# SPDX-License-Identifier: Apache-2.0
"""The anchor as integers: bit for bit what ``rtl/wh_anchor.v`` computes.

In contact the encoder says what the current of the design spring is,
``i* = −(k_T/L_eff)(x − x_w)`` with x in the middle of its cell. Whatever the current is off by more
than a dead zone, and a small part of what it is off by within, goes back into the wave core's goal
as a wave, a series voltage ``ρ·dz(i* − i_n)``, and into the estimate of the resistance,
``dR̂/dt = γ·dz(i* − i_n)·sign(i*)`` (design §1.2). What is tracked is ``s = √(2R̂)`` itself:
``dR̂ = s ds``, so ``ds/dt = (γ/s)·dz(…)·sign(i*)`` needs no square root. The words found in a tick
act in the next.

A rotor that moves at ω while its encoder stands looks like a winding of another resistance,
``R̂ i = R i + k_T ω``, and the tracking would follow. A winding can't change as fast: once s has
settled, a change beyond LOST_ROOT without an edge, over what WARM_ROOT lets pass as warming, means
that the encoder is lost; so does an s that never settles. What was known before the change stays.
"""

from __future__ import annotations

import numpy as np

from wavehaptics import formats
from wavehaptics.compiled import compiled
from wavehaptics.golden import saturate, truncate

_ISTAR_SHIFT = formats.CELL_CURRENT.fraction - formats.CURRENT.fraction
_PULL_SHIFT = formats.PULL.fraction + formats.CURRENT.fraction - formats.WAVE.fraction
_TRACK_SHIFT = formats.TRACK.fraction + formats.CURRENT.fraction - formats.ROOT_SUM_Q
_ROOT_SHIFT = formats.ROOT_SUM_Q - formats.ROOT.fraction
_SLOPE_SHIFT = formats.ROOT.fraction
_WARM_SHIFT = formats.ROOT_SUM_Q - formats.WARM.fraction
_HALF_TURN = 1 << (formats.COUNT_W - 1)
_COUNT_MASK = (1 << formats.COUNT_W) - 1

(
    ENABLE,  # 0: the plain wave wall
    HALF_CELL,  # s27q25 A: half a cell of the encoder times k_T/L_eff
    DEAD_ZONE,  # s31q24 A: the error that is left alone, usually half a cell's
    ANCHOR_GAIN,  # s27q20 √Ω: 2ρ/s
    RELEASE_GAIN,  # s27q20 √Ω: 2ρ/s while the force errs to the side of the motion; 0: no such rule
    SURFACE_GAIN,  # s27q20 √Ω: 2ρ/s in series with a moving rotor, and at the surface
    TRACK_GAIN,  # s27q32 √Ω/A: γT/s; 0 turns the tracking off
    ROOT_FREE,  # s27q22 √Ω: s out of contact
    LIMIT_FREE,  # s31q23 √W: u_max out of contact
    ROOT_START,  # s27q22 √Ω
    ROOT_MIN,  # s27q22 √Ω
    ROOT_MAX,  # s27q22 √Ω
    LIMIT_BASE,  # s31q23 √W: u_max = base − slope·s
    LIMIT_SLOPE,  # s31q23 √W/√Ω
    RELEASE_TICKS,  # ticks after an edge in which the rotor counts as moving
    PUSH_ONLY,  # 1: the contact ends where the torque would pull
    LOST_CURRENT,  # s31q24 A: error beyond the dead zone that no true encoder leaves for long
    LOST_TICKS,  # ticks that R̂ may be at its limit until the encoder counts as lost
    LOST_ROOT,  # s27q22 √Ω: change of s in a hold that no winding makes; 0: any may be
    WARM_ROOT,  # s27q38 √Ω: largest change of s in a tick that is a winding's warming
) = range(20)
"""Places in an anchor's settings."""
SETTINGS = 20

_COEF = formats.COEF_W
_DATA = formats.DATA_W
_TICKS = formats.ANCHOR_TICK_W
WIDTHS = (
    1, _COEF, _DATA, _COEF, _COEF, _COEF, _COEF, _COEF, _DATA, _COEF, _COEF, _COEF, _DATA, _DATA,
    _TICKS, 1, _DATA, _TICKS, _COEF, _COEF,
)  # fmt: skip
"""Bits of each setting in the RTL's word of all, the first one lowest."""
assert len(WIDTHS) == SETTINGS
assert sum(WIDTHS) == formats.ANCHOR_W

(
    ROOT_SUM,  # s47q42 √Ω: s, with bits to spare for the smallest step of the tracking
    POSITION,  # counts, of the tick before
    DIRECTION,  # +1 or −1: of the last edge
    MOTION,  # ticks since the last edge, up to RELEASE_TICKS
    REVERSALS,  # turns of the rotor in this contact: 0, 1, 2 for more
    TOUCHING,  # contact of the tick before
    PULLED,  # 1: the contact has ended because it pulled
    LOST,  # ticks that the error has been too large
    FAULT,  # 1: the encoder does not follow the motor; latched
    WAVE,  # s31q23 √W: what the wave core's goal gets in the next tick
    ROOT,  # s27q22 √Ω: s of the next tick
    LIMIT,  # s31q23 √W: u_max of the next tick
    KNOWN,  # s47q42 √Ω: s as the winding alone can have made it since the last edge
    QUIET,  # ticks in which s has stayed near KNOWN, until it counts as settled
    STIRRED,  # ticks without an edge in which s has not settled
) = range(15)
"""Places in an anchor's state."""

SURFACE_CELLS = 2
"""Cells at the wall's edge: half a cell is so much of their depth that the tracking may only lower
R̂ there, which can't give energy."""

MOVING_SHIFT = 3
"""In motion the anchor is 2^-3 of the release, where the force errs to the other side."""

OUTWARD_SHIFT = 4
"""On the way out 2^-4 of the current counts as well: where the force has just come down to i*, an R̂
that is too high must not hold it there."""

SETTLED_SHIFT = 2
CHANGED_SHIFT = 2
"""s has settled when it has moved by less than 2^-2 of LOST_ROOT in 2^-2 of LOST_TICKS."""

UNSETTLED_SHIFT = 3
"""The longest that s may take to settle without an edge is 2^3 LOST_TICKS."""

FAR_TICKS = 8
"""A tick with an error beyond LOST_CURRENT counts as so many towards LOST_TICKS."""

INNER_SHIFT = 8
"""2^-8 of the error counts inside the dead zone too: it makes the drift within a cell die out."""


def packed(settings: np.ndarray) -> int:
    """The settings as the RTL's port ``words_i`` takes them: WIDTHS side by side."""
    word = 0
    for value, width in zip(reversed(settings.tolist()), reversed(WIDTHS), strict=True):
        word = word << width | value & ((1 << width) - 1)
    return word


def new_state(settings: np.ndarray) -> np.ndarray:
    """State of one port after reset: int64, shape (15,)."""
    state = np.zeros(15, dtype=np.int64)
    state[ROOT_SUM] = settings[ROOT_START] << _ROOT_SHIFT
    state[KNOWN] = state[ROOT_SUM]
    state[DIRECTION] = 1
    state[MOTION] = settings[RELEASE_TICKS]
    state[ROOT] = settings[ROOT_FREE]
    state[LIMIT] = settings[LIMIT_FREE]
    return state


@compiled(inline="always")
def dead_zone(error: int, half: int) -> int:
    """``error`` less the dead zone ``±half``."""
    return error - half if error > half else error + half if error < -half else 0


@compiled()
def anchor_step(
    state: np.ndarray,
    settings: np.ndarray,
    position: int,
    contact: bool,
    depth: int,
    current: int,
    saturated: int,
) -> None:
    """One tick of one port, after the wave core's step of the same tick.

    ``position`` and ``depth`` (x − x_w) are in counts, ``current`` is the word of i_n, and
    ``saturated`` says that the voltage limit acted in the core's step before. Sets WAVE, ROOT,
    LIMIT and PULLED for the next tick.
    """
    moved = ((position - state[POSITION] + _HALF_TURN) & _COUNT_MASK) - _HALF_TURN
    state[POSITION] = position
    turned = False
    if moved != 0:
        direction = 1 if moved > 0 else -1
        turned = direction != state[DIRECTION]
        state[DIRECTION] = direction
        state[MOTION] = 0
    elif state[MOTION] < settings[RELEASE_TICKS]:
        state[MOTION] += 1
    entering = contact and not state[TOUCHING]
    state[TOUCHING] = contact
    if entering:
        state[REVERSALS] = 0
    elif turned:
        state[REVERSALS] = min(2, state[REVERSALS] + 1)

    side = -1 if depth < 0 else 1
    cell = -1 - depth if depth < 0 else depth
    target = saturate(truncate(-settings[HALF_CELL] * saturate(2 * depth + 1), _ISTAR_SHIFT))
    error = saturate(target - current)
    moving = (
        settings[RELEASE_GAIN] != 0
        and state[MOTION] < settings[RELEASE_TICKS]
        and state[REVERSALS] <= 1
    )
    beyond = dead_zone(error, settings[DEAD_ZONE])
    pull = saturate(beyond + truncate(error, INNER_SHIFT))

    if not contact or (moved != 0 and state[DIRECTION] == side):
        state[PULLED] = 0
    elif settings[PUSH_ONLY] and side * current > settings[HALF_CELL] >> _ISTAR_SHIFT:
        state[PULLED] = 1

    excess = error * side > 0
    word = pull
    gain = settings[RELEASE_GAIN] >> MOVING_SHIFT if moving else settings[ANCHOR_GAIN]
    if moving and state[DIRECTION] != side and excess:
        word = saturate(error - truncate(current, OUTWARD_SHIFT))
        gain = settings[RELEASE_GAIN]
    elif moving and state[DIRECTION] == side and not excess and beyond != 0:
        gain = settings[RELEASE_GAIN]
    elif (
        beyond == 0
        and (moving or cell == 0 or (cell < SURFACE_CELLS and excess))
        and settings[RELEASE_GAIN] != 0
    ):
        word = saturate(-current)
        gain = settings[SURFACE_GAIN]

    held = contact and not state[PULLED]
    on = held and settings[ENABLE] and not state[FAULT]
    state[WAVE] = saturate(truncate(gain * word, _PULL_SHIFT)) if on else 0

    before, known = state[ROOT_SUM], state[KNOWN]
    root_sum = before
    tracks = on and not saturated and (cell >= SURFACE_CELLS or excess)
    if tracks:
        root_sum -= side * truncate(settings[TRACK_GAIN] * pull, _TRACK_SHIFT)
    low = settings[ROOT_MIN] << _ROOT_SHIFT
    high = settings[ROOT_MAX] << _ROOT_SHIFT
    pinned = root_sum < low or root_sum > high
    root_sum = min(max(root_sum, low), high)

    far = abs(beyond) > settings[LOST_CURRENT]
    suspect = on and not saturated and (pinned or far)
    state[LOST] = state[LOST] + (FAR_TICKS if far else 1) if suspect else 0

    change = before - known
    strange = settings[LOST_ROOT] << _ROOT_SHIFT
    settled = state[QUIET] >= settings[LOST_TICKS] >> SETTLED_SHIFT
    watched = tracks and moved == 0 and strange > 0
    unseen = watched and settled and abs(change) > strange
    if not held or (suspect and not settled):
        state[QUIET] = 0
    elif tracks and not settled:
        if abs(change) > strange >> CHANGED_SHIFT:
            state[QUIET] = 0
            state[KNOWN] = before
        elif state[MOTION] >= settings[RELEASE_TICKS]:
            state[QUIET] += 1
    elif tracks and moved != 0:
        state[KNOWN] = before
    elif tracks:
        warm = settings[WARM_ROOT] << _WARM_SHIFT
        state[KNOWN] += min(max(change, -warm), warm)
    if moved != 0 or settled or not held:
        state[STIRRED] = 0
    elif watched:
        state[STIRRED] += 1
    unsettled = (
        watched and not settled and state[STIRRED] >= settings[LOST_TICKS] << UNSETTLED_SHIFT
    )

    if unseen or unsettled or (suspect and state[LOST] >= settings[LOST_TICKS]):
        state[FAULT] = 1
        root_sum = known if settled else settings[ROOT_START] << _ROOT_SHIFT
    state[ROOT_SUM] = root_sum
    # u_max follows s along the tangent of limit/s at the start, which lies below it everywhere.
    root = root_sum >> _ROOT_SHIFT
    limit = max(0, settings[LIMIT_BASE] - ((settings[LIMIT_SLOPE] * root) >> _SLOPE_SHIFT))
    state[ROOT] = root if held else settings[ROOT_FREE]
    state[LIMIT] = limit if held else settings[LIMIT_FREE]
