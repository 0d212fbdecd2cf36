# SPDX-License-Identifier: Apache-2.0
"""The port anchor as integers: bit for bit what ``rtl/wh_anchor.v`` computes.

The waves and the encoder both know where the rotor is. On an ideal motor the flux of the port,

``χ = L̂·i + k̂_T·x − ∫ (e_id − R̂·i) dt``,  ``e_id − R̂·i = s(u + v)/2``,

stays constant whatever the environment does (docs/port_anchor.md). Only the errors of the real
motor, as a voltage, move it. χ is in encoder counts, ``k̂_T·Δ`` each, so the position needs no gain.
A voltage c in series with the port, which the waves don't see, holds χ:

- **Zone.** ``z = χ + σ/4`` if the last edge had the direction σ of the one before it, else ``z =
  χ − σ/32`` (an axis: σ/16). ``q`` is the part of z beyond ± half a count: within it the inductor
  is better than the encoder.
- **The bound.** A rotor that crosses back over an edge meets no more force on its way
  out, and no less on its way in, than it met there before. ``UP`` and ``DOWN`` are χ just before
  the last edge of each direction. After an edge upwards DOWN replaces the zone's upper end, after
  one downwards UP its lower end, if they are within the zone. If they are beyond its other end,
  that end does. This lasts until the next edge; on a brushless motor's axis, which an edge hardly
  moves at some angles, until z has been there once.
- ``p`` is q, or z/128 within the zone (an axis: z/256), and ``c = θ·(y' + sgn(y')·y_b) − g_ρ·p``.
  y = L̂·i, y' is its mean of some milliseconds. It follows only while the rotor travels: while
  its last two full counts had the same direction. With each such count it takes a quarter of its
  distance, to keep up with a fast hit at any rate (not an axis).
- θ is a resistance. It is learned from p if z is out of the zone, ``θ −= g_θ·p·sgn(y')``. It starts
  at a quarter of the largest, and is kept from contact to contact.
- A turn outwards halves θ: the first full count outwards of a rotor that travelled inwards (not an
  axis). Without it a θ that has learned a brush's voltage is more than R lacks, and feeds the swing
  of a lever. While c is at its limit θ isn't halved.
- While the rotor doesn't travel, twice θ damps oscillations about y': ``c = θ·(y' + sgn(y')·y_b −
  2·(y − y')) − g_ρ·p``.
- y_b stands for the brushes' voltage. It decreases by half of what y' falls, so c falls at least as
  fast as the voltage that it compensates: a press never gets back more than it gave.
- ``g_ρ·p`` is limited to ``c_0 + |e_id|/2``, out of contact with a half of c_0, and θ by a
  largest. In contact c reduces the wave's share of the drive's limit: ``|u| ≤ u_max −
  |c|/s``. An error of the flux that c can't hold while the wave is below its limit means that
  waves and encoder don't follow the same motor.

The edge with which a contact begins gives x exactly, and sets χ without L̂·i to a quarter of a
count: at its surface a wall has no current, so any current there is pulled away. At the pins a
contact is reported up to two periods after its edge. The λ filter's content then counts as flux,
``g_w·u``, else a wall would be deeper by ω·T/2a.

The residue w that a limit cuts off from the waves in contact is added to the flux,
``χ −= g_w·w``, so the wall is in its old place after the limit has acted. So is the residue of
truncating u: half an LSB a period would move a held wall by some counts an hour. In free space the
current is zero except for the sensor's offset, which c then shows: ``offset −= g_z·c`` while the
rotor is slow.

Values computed in a period act in the next.

A brushless motor has an anchor for each axis of the stationary frame, whose flux a count changes
by a fraction of a count, along q (:mod:`wavehaptics.controller.rotor_flux`): that fraction is
``cell`` below, and the zone is ± half of it. χ begins at half of it: with a quarter a held wall was
0.7 counts off at four angles of eight.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats
from wavehaptics.words.table import ports, side_by_side

(
    ENABLE, FLUX_GAIN, OWED_GAIN, CELLS_GAIN, PULL_GAIN, LEARN_GAIN, LEARN_MAX, ZERO_GAIN,
    ROOM_GAIN, REACH, STRANGE, BRUSH, FOLLOW_TICKS, SLOW_TICKS,
) = range(14)  # fmt: skip
"""Indices of an anchor's settings, in the order of ``rtl/words.toml``, which explains them."""
SETTINGS = 14

_WORDS = ports()["anchor_words"]
assert len(_WORDS) == SETTINGS

(
    FLUX,  # s48q33 counts: χ without L̂·i
    THETA,  # s48q37 V a count: θ
    MEAN,  # s48q33 counts: y'
    ZERO,  # s48q33 A: the offset
    FOLLOWER,  # s48q33 counts: a slow copy of x̂, modulo 2^15
    POSITION,  # counts, of the period before
    TOUCHING,  # contact of the period before
    NEGATIVE,  # direction of the last edge
    SAME,  # it was that of the edge before it
    COUNTED,  # direction of the last edge of which that was so
    TRAVELS,  # and the one before it had the same direction
    QUIET,  # periods left until a rotor without such an edge is slow
    PHASE,  # periods left until y' moves
    COEFFICIENT,  # s27q20 V a count: θ, 0 to LEARN_MAX
    FULL,  # it is the largest
    BRUSH_LEFT,  # s31q16 counts, 0...: y_b
    UP,  # s48q33 counts: χ of the period before the last edge upwards
    DOWN,  # s48q33 counts: the same downwards
    KNOWS_UP,  # UP is of this contact, the rotor went by single counts since, and it isn't below
    # the zone: there the zone alone asks for more
    KNOWS_DOWN,  # the same of DOWN, which isn't above the zone
    UP_ALL,  # UP is above the zone: nothing of the zone is left
    DOWN_ALL,  # DOWN is below the zone
    ABOVE,  # χ is above the zone
    BELOW,  # χ is below the zone
    SINKS,  # the last edge lessened the flux
    BOUND,  # the last edge's bound is in force
    CLIPPED,  # c was at its limit
    FAULT,  # 1: waves and encoder don't follow the same motor; latched
    CHI,  # s48q33 counts: χ
    CORRECTION,  # s31q23 V: c, for the voltage that the next period computes
    OFFSET,  # s31q24 A: to be taken off the next period's current
    LAG,  # s48q33 counts: x̂ less its slow copy, ω̂ over 2^8 periods
    STARTED,  # 0 until the first period, which has none before
    ROOM,  # s31q23 √W, 0...: what c takes of the limit of the next period's wave
    PLACE,  # s48q33 counts, of an axis: its flux by the encoder in the period before
    FRESH,  # periods for which the last edge is still one that a contact can begin with
    LOADED,  # θ is there: at first a quarter of the largest
    EXCUSES,  # steps of y' in which c may yet be far beyond its limit
    TOLD,  # s31q16 counts: what θ acts on, of the last period in contact
    COPIES,  # periods left until x̂'s slow copy moves
) = range(40)
"""Indices of an anchor's state."""
STATES = 40

FRESH_TICKS = 3
"""An edge begins a contact that is reported in its own period or in the next two."""

INNER_SHIFT = 7
AXIS_INNER_SHIFT = 8
"""Inside the zone 2^-7 of z counts, an axis' 2^-8: what drifts within a count dies out. By as much
both means take of their distance."""
AHEAD_SHIFT = 2
"""The zone of a rotor that goes on is a quarter of a count ahead."""
BEHIND_SHIFT = 5
"""That of a rotor that has turned is 1/32 of a count behind: so much a bound gives way at each
edge, as a rotor that neither gained nor lost by an edge would bounce on it for ever. An axis, on
which such a bounce is stronger, is 1/16 of a count behind."""
COUNT_SHIFT = 2
"""With each full count y' takes 2^-2 of its distance,"""
FADE_SHIFT = 1
"""and a turn outwards takes 2^-1 of θ."""
EXCUSED = 31
"""Steps of y' in which c may be far beyond its limit without a fault, after the voltage or the
current was limited or a contact began: 2 ms. Without them a hit that reaches the voltage limit is
taken for a lost encoder."""
FIRST_SHIFT = 2
"""θ begins with a quarter of the largest."""
SHRINK_SHIFT = 1
"""y_b shrinks by half of what y' falls."""
DAMP_SHIFT = 1
"""A rotor that doesn't travel swings against 2^1 of θ."""
FREE_SHIFT = 1
"""Out of contact c may be 2^-1 of c_0: where only the sensor's offset flows, R has no voltage and a
brush not all of its own."""
FOLLOWER_TICKS = 1 << AXIS_INNER_SHIFT
COPY_TICKS = FOLLOWER_TICKS >> INNER_SHIFT
"""x̂'s slow copy moves in one period of as many, an axis' in each: a mean of FOLLOWER_TICKS."""
SEEN_CELLS = formats.LONG.step * 2.0**formats.LONG_GUARD
"""Cells of the last place of the RTL's ``flux_o`` and ``lag_o``, χ and x̂ less its slow copy."""

_GUARD = formats.LONG_GUARD
_CELL = 1 << formats.LONG.fraction
_TURN = (1 << (formats.LONG.width - formats.LONG.fraction)) - 1
_MOVE = 1 << (formats.MOVE_W - 1)
_NEAR_SHIFT = formats.CURRENT.fraction + formats.CELLS.fraction - formats.LONG.fraction
_FAR_SHIFT = formats.WAVE.fraction + formats.FLUX.fraction - formats.LONG.fraction
assert formats.PULL.fraction - _GUARD == _NEAR_SHIFT
_THETA_CUT = (
    formats.LEARN.fraction + formats.LONG.fraction - _GUARD - _FAR_SHIFT - formats.PULL.fraction
)
"""Bits of θ below a coefficient's."""
_VOLT_SHIFT = formats.LONG.fraction - formats.VOLTAGE.fraction
_AMPERE_SHIFT = formats.LONG.fraction - formats.CURRENT.fraction
_FAR = 1 << (formats.LONG.width - 2)
_LONG_TOP = 1 << (formats.LONG.width - 1)
_LONG_MASK = (1 << formats.LONG.width) - 1
_DATA_TOP = 1 << (formats.DATA_W - 1)
_DATA_MASK = (1 << formats.DATA_W) - 1
_BEHIND = _CELL >> BEHIND_SHIFT
_AXIS_BEHIND = _BEHIND << 1


def packed(settings: np.ndarray) -> int:
    """The settings as the RTL's port ``words_i`` takes them, side by side, the first one lowest."""
    widths = (word.fixed.width for word in _WORDS)
    return side_by_side(zip(settings.tolist(), widths, strict=True))


def new_state() -> np.ndarray:
    """State after reset: int64, shape (STATES,)."""
    state = np.zeros(STATES, dtype=np.int64)
    reset(state)
    return state


@compiled()
def reset(state: np.ndarray) -> None:
    """Make a state that after reset; int64 (STATES,)."""
    state[:] = 0
    state[SAME] = 1


@compiled(inline="always")
def long_word(value: int) -> int:
    """``value`` wrapped to a long word."""
    return ((value + _LONG_TOP) & _LONG_MASK) - _LONG_TOP


@compiled(inline="always")
def _data(value: int) -> int:
    """``value`` wrapped to a data word."""
    return ((value + _DATA_TOP) & _DATA_MASK) - _DATA_TOP


@compiled(inline="always")
def left(u_max: int, state: np.ndarray) -> int:
    """The waves' limit, raw √W: ``u_max`` less the share of c, at least 0."""
    limit: int = u_max - state[ROOM]
    return max(limit, 0)


@compiled(inline="always")
def share(room_gain: int, correction: int) -> int:
    """What c, raw V, takes of the limit of u in contact, raw √W."""
    room = (room_gain * correction) >> _FAR_SHIFT
    room = long_word(-room if correction < 0 else room) >> _VOLT_SHIFT
    return min(max(room, 0), _DATA_TOP - 1)


@compiled()
def anchor_step(
    state: np.ndarray, words: np.ndarray, position: int, contact: bool, current: int, u: int,
    v: int, withheld: int, voltage: int, saturated: bool, blind: bool = False,
) -> None:  # fmt: skip
    """One tick of a port's anchor; ``state`` int64 (STATES,) is updated.

    ``words`` int64 (SETTINGS,); ``position`` in counts and ``contact`` are the tick's; ``current``,
    ``u`` and ``v`` those of its core step (i_n without the offset, u_n, v_n); ``withheld`` (√W),
    ``voltage`` (e_id) and ``saturated`` of the core's step before
    (:data:`wavehaptics.controller.wave_core.STATE_WITHHELD`). ``blind`` says that the current or v
    is at the end of its range (``STATE_CLIPPED``).
    """
    moved = _moved(state, position)
    _turn(
        state, words, moved, moved * _CELL, _CELL, _CELL >> 2, (position & _TURN) * _CELL, contact,
        current, u, v, withheld, voltage, saturated, blind, False,
    )  # fmt: skip


@compiled()
def anchor_axis_step(
    state: np.ndarray, words: np.ndarray, position: int, place: int, cell: int, contact: bool,
    current: int, u: int, v: int, withheld: int, voltage: int, saturated: bool, blind: bool = False,
) -> None:  # fmt: skip
    """One tick of the anchor of a brushless motor's axis, as :func:`anchor_step`.

    At ``position`` the axis' flux is ``place`` by the encoder, which its last count changed by
    ``cell`` for a step up, s48q33 cells (:mod:`wavehaptics.controller.rotor_flux`).
    """
    moved_flux = long_word(place - state[PLACE]) if state[STARTED] != 0 else 0
    state[PLACE] = place
    _turn(
        state, words, _moved(state, position), moved_flux, cell, cell >> 1, place, contact, current,
        u, v, withheld, voltage, saturated, blind, True,
    )  # fmt: skip


@compiled(inline="always")
def _moved(state: np.ndarray, position: int) -> int:
    """Counts since the previous tick; 0 in the first."""
    moved = 0
    if state[STARTED] != 0:
        moved = ((position - state[POSITION] + _MOVE) & (2 * _MOVE - 1)) - _MOVE
    state[STARTED] = 1
    state[POSITION] = position
    return moved


@compiled(inline="always")
def _turn(
    state: np.ndarray, words: np.ndarray, moved: int, moved_flux: int, cell: int, start: int,
    place: int, contact: bool, current: int, u: int, v: int, withheld: int, voltage: int,
    saturated: bool, blind: bool, axis: bool,
) -> None:  # fmt: skip
    inner = AXIS_INNER_SHIFT if axis else INNER_SHIFT
    begins = contact and state[TOUCHING] == 0
    state[TOUCHING] = 1 if contact else 0

    one = moved == 1 or moved == -1
    same_way = False
    travelled = state[TRAVELS] != 0
    if moved != 0:
        back = 1 if moved < 0 else 0
        same_way = back == state[NEGATIVE] or not one
        state[NEGATIVE] = back
        state[SAME] = 1 if same_way else 0
        state[FRESH] = FRESH_TICKS
    elif state[FRESH] > 0:
        state[FRESH] -= 1
    if same_way:
        state[TRAVELS] = 1 if state[NEGATIVE] == state[COUNTED] else 0
        state[COUNTED] = state[NEGATIVE]
        state[QUIET] = words[SLOW_TICKS]
    elif state[QUIET] > 0:
        state[QUIET] -= 1
    if begins:
        state[SAME], state[TRAVELS] = 1, 1
        state[COUNTED] = state[NEGATIVE]
    strobe = state[PHASE] == 0
    state[PHASE] = max(words[FOLLOW_TICKS] - 1, 0) if strobe else state[PHASE] - 1
    counts = same_way and not axis
    outward = (state[NEGATIVE] != 0) == (state[MEAN] < 0)
    turned = travelled and state[TRAVELS] == 0
    fades = counts and outward and turned and contact and state[CLIPPED] == 0

    e = -voltage if voltage < 0 else voltage
    reach = words[REACH] if contact else words[REACH] >> FREE_SHIFT
    limit = (reach << _VOLT_SHIFT) + (e << (_VOLT_SHIFT - 1))
    state[ROOM] = 0
    if contact:
        state[ROOM] = share(words[ROOM_GAIN], state[CORRECTION])

    flux = long_word(state[FLUX] - ((words[FLUX_GAIN] * u) >> _FAR_SHIFT))
    flux = long_word(flux - ((words[FLUX_GAIN] * v) >> _FAR_SHIFT))
    if contact:
        owed = words[OWED_GAIN] if saturated else words[FLUX_GAIN]
        flux = long_word(flux - ((owed * withheld) >> _FAR_SHIFT))
    y = (words[CELLS_GAIN] * current) >> _NEAR_SHIFT
    far = y >= _FAR or y < -_FAR
    y = long_word(y)
    zero_step = (words[ZERO_GAIN] * state[CORRECTION]) >> _FAR_SHIFT
    before = state[CHI]
    if begins:
        flux = (words[OWED_GAIN] * u) >> _FAR_SHIFT
        if state[FRESH] > 0:
            flux += -start if state[NEGATIVE] != 0 else start
        flux = long_word(flux)
    else:
        flux = long_word(flux + moved_flux)
    state[FLUX] = flux
    chi = long_word(flux + y)
    state[CHI] = chi

    # The last edge upwards or downwards, as the flux has it.
    down = moved_flux < 0
    if begins:
        state[KNOWS_UP] = state[KNOWS_DOWN] = state[BOUND] = 0
    elif moved != 0:
        state[BOUND] = 1
        if not one:
            state[KNOWS_UP] = state[KNOWS_DOWN] = 0
        elif down:
            state[DOWN] = before
            state[KNOWS_DOWN] = 1 - state[ABOVE]
            state[DOWN_ALL] = state[BELOW]
        else:
            state[UP] = before
            state[KNOWS_UP] = 1 - state[BELOW]
            state[UP_ALL] = state[ABOVE]
    if moved != 0:
        state[SINKS] = 1 if down else 0
    sinks = state[SINKS] != 0

    size = -cell if cell < 0 else cell
    half = size >> 1
    state[ABOVE] = 1 if chi - half >= 0 else 0
    state[BELOW] = 1 if chi + half < 0 else 0
    z = chi
    if contact:
        behind = _AXIS_BEHIND if axis else _BEHIND
        ahead = size >> AHEAD_SHIFT if state[SAME] != 0 else -behind
        z = long_word(chi - ahead if sinks else chi + ahead)
    over = z - half >= 0
    under = not over and z + half < 0
    beyond = z - half if over else z + half if under else z >> inner
    bound = contact and state[BOUND] != 0
    if not bound:
        past = z
    elif sinks and state[KNOWS_UP] != 0 and not over:
        past = long_word(z - state[UP])
        bound = state[UP_ALL] != 0 or past < 0
        past = z - half if state[UP_ALL] != 0 else past
    elif not sinks and state[KNOWS_DOWN] != 0 and not under:
        past = long_word(z - state[DOWN])
        bound = state[DOWN_ALL] != 0 or past >= 0
        past = z + half if state[DOWN_ALL] != 0 else past
    else:
        bound = False
    if bound:
        beyond = past
    elif contact and axis:
        state[BOUND] = 0
    p = _data(long_word(beyond) >> _GUARD)

    if not contact and state[QUIET] == 0 and not blind:
        zero = state[ZERO] - zero_step
        if _data(zero >> _AMPERE_SHIFT) == zero >> _AMPERE_SHIFT:
            state[ZERO] = zero

    if begins:
        # With what presses against the rotor's way in, so that y_b has its sign.
        state[MEAN] = 0
        if state[FRESH] > 0:
            state[MEAN] = start if state[NEGATIVE] != 0 else -start
        state[BRUSH_LEFT] = words[BRUSH]
    elif contact and (strobe or counts) and state[TRAVELS] != 0 and not blind and not far:
        swing = long_word(y - state[MEAN])
        taken = COUNT_SHIFT if counts else inner
        if (swing < 0) != (state[MEAN] < 0):
            shrinks = (~swing if swing < 0 else swing) >> (_GUARD + taken + SHRINK_SHIFT)
            state[BRUSH_LEFT] = max(state[BRUSH_LEFT] - shrinks, 0)
        state[MEAN] = long_word(state[MEAN] + (swing >> taken))
    presses_down = state[MEAN] < 0

    held = 0
    if contact:
        told = (state[MEAN] >> _GUARD) + (-state[BRUSH_LEFT] if presses_down else state[BRUSH_LEFT])
        if state[TRAVELS] == 0 and not begins and not blind and not far:
            told -= (long_word(y - state[MEAN]) >> _GUARD) << DAMP_SHIFT
        state[TOLD] = _data(told)
        held = (state[COEFFICIENT] * state[TOLD]) >> _NEAR_SHIFT
    if state[LOADED] == 0:
        state[LOADED] = 1
        state[THETA] = words[LEARN_MAX] << (_THETA_CUT - FIRST_SHIFT)
    grows = (p < 0) != presses_down
    stops = state[FULL] != 0 or state[CLIPPED] != 0 if grows else state[THETA] < 0
    learns = contact and (over or under) and not saturated and not blind
    if fades:
        state[THETA] = long_word(state[THETA] + ((-state[THETA]) >> FADE_SHIFT))
    elif learns and not stops:
        step = (words[LEARN_GAIN] * p) >> _FAR_SHIFT
        state[THETA] = long_word(state[THETA] + (step if presses_down else -step))
    theta = state[THETA] >> _THETA_CUT
    state[FULL] = 1 if theta >= words[LEARN_MAX] else 0
    state[COEFFICIENT] = max(words[LEARN_MAX] if state[FULL] != 0 else theta, 0)
    wanted = -((words[PULL_GAIN] * p) >> _NEAR_SHIFT)

    negative = wanted < 0
    past = wanted + limit if negative else wanted - limit
    clipped = (past < 0) == negative
    c = wanted
    if clipped:
        c = -limit if negative else limit
    state[CLIPPED] = 1 if clipped else 0
    if blind or begins or saturated:
        state[EXCUSES] = EXCUSED
    elif not clipped:
        state[EXCUSES] = 0
    elif strobe and state[EXCUSES] > 0:
        state[EXCUSES] -= 1
    strange = words[STRANGE] << _VOLT_SHIFT
    strange = past + strange if negative else past - strange
    lost = clipped and (strange < 0) == negative and state[EXCUSES] == 0
    lost = lost or far or chi >= _FAR or chi < -_FAR
    if words[ENABLE] == 0:
        state[FAULT] = 0
    elif lost:
        state[FAULT] = 1
    active = words[ENABLE] != 0 and state[FAULT] == 0 and not blind
    voltage = min(max((c + held) >> _VOLT_SHIFT, -_DATA_TOP), _DATA_TOP - 1)
    state[CORRECTION] = voltage if active else 0
    state[OFFSET] = state[ZERO] >> _AMPERE_SHIFT

    lag = long_word(place - chi - state[FOLLOWER])
    state[LAG] = lag
    if state[COPIES] == 0:
        state[COPIES] = 1 if axis else COPY_TICKS
        state[FOLLOWER] = long_word(state[FOLLOWER] + (lag >> inner))
    state[COPIES] -= 1
