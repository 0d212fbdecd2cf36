# SPDX-License-Identifier: Apache-2.0
"""The port anchor as integers: bit for bit what ``rtl/wh_anchor.v`` computes.

The waves and the encoder both know where the rotor is. On an ideal motor the flux of the port,

``χ = L̂·i + k̂_T·x − ∫ (e_id − R̂·i) dt``,  ``e_id − R̂·i = s(u + v)/2``,

stays what it is whatever the environment does (docs/port_anchor.md); what moves it is all that is
wrong with the real one, as a voltage. It is counted here in cells of the encoder, ``k̂_T·Δ`` each,
so that the position needs no gain, and held at zero by a voltage c in series with the port, which
the waves don't see:

- ``p = dz(χ, ½) + χ/256``: within half a cell the inductor knows better than the encoder;
- ``c = c_I − g_ρ·p``, ``c_I −= g_γ·p``, the latter in full only while the rotor rests;
- ``c −= g_d·(y − ȳ)``, ``y = L̂·i`` and ȳ its slow mean, in contact while the rotor rests, up to
  four cells: a resistance for swings alone, which no edge of the encoder tells of;
- what c_I has learned of a contact's current is wrong without one: it is 0 when a contact ends;
- ``|c|`` is limited by ``c_0 + |e_id|/2``, out of contact with a half of c_0. In contact what it
  takes of the drive's limit is the wave's no more: ``|u| ≤ u_max − |c|/s``, so that at the limit it
  is the wave that stops, whose share is counted. An error of the flux that c can't hold while the
  wave is below its limit means that waves and encoder don't follow the same motor.

The edge with which a contact begins tells x exactly, and sets χ without L̂·i to a quarter of a
cell: at the surface a wall has no current, so what flows there is pulled away. At the pins walls
are looked at in turn, so that a contact is told up to two ticks after its edge. Nor is its surface
where the λ filter, which still tells of the free rotor's speed, would have it: what it holds counts
as flux, ``g_w·u``, else a wall stands deeper by ω·T/2a.

A rotor that hit a wall and goes back out gets less of its wave returned, by an η of its own, so
that a hit comes back with no more than it had. What the wall lets go by it is given back with the
edge with which the rotor turns in again: χ is set as at the first, with the way since.

What a limit withholds from the waves in contact, w, is added to the flux, ``χ −= g_w·w``: so the
wall stands where it was when the limit has done its work. So is what truncation takes from u: half
a place a tick would move a held wall by some cells an hour. In free space the current is zero but
for the sensor's offset, which c then shows: ``offset −= g_z·c`` while the rotor rests.

A tick whose current or v is at the end of its range (``blind``) teaches nothing: c_I, the offset
and ȳ stay, and the next c is 0, as it would push against what isn't known. χ counts on: the flux
that the environment was given and the way of the rotor are known all the same, so that a wall which
gave way is where it stood once it can. As long as c is at its limit since, that is no lost rotor.
But a χ in the outer half of its range is, before it wraps.

Words found in a tick act in the next.

A brushless motor has an anchor for each axis of the stationary frame, whose flux a count changes by
a part of a cell, along q (:mod:`wavehaptics.controller.rotor_flux`): that part is what ``cell``
says below, and within half of it the inductor knows better. There χ begins at half of it, as with
a quarter a held wall stood 0.7 cells off at four angles of eight.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats
from wavehaptics.words.table import ports, side_by_side

(
    ENABLE, FLUX_GAIN, OWED_GAIN, CELLS_GAIN, PULL_GAIN, DAMP_GAIN, LEARN_GAIN, ZERO_GAIN,
    ROOM_GAIN, REACH, STRANGE, REST_TICKS, SLOW_UNITS, REBOUND_ETA,
) = range(14)  # fmt: skip
"""Places in an anchor's settings, in the order of ``rtl/words.toml``, which says what they are."""
SETTINGS = 14

_WORDS = ports()["anchor_words"]
assert len(_WORDS) == SETTINGS

(
    FLUX,  # s48q33 cells: χ without L̂·i
    LEARNED,  # s48q33 V: c_I
    MEAN,  # s48q33 cells: ȳ
    ZERO,  # s48q33 A: the offset
    FOLLOWER,  # s48q33 cells: a slow copy of x̂, modulo 2^15
    POSITION,  # counts, of the tick before
    TOUCHING,  # contact of the tick before
    NEGATIVE,  # direction of the last edge
    TICKS,  # ticks within a unit of rest
    UNITS,  # units of REST_TICKS since the last edge the same way as the one before it
    PHASE,  # ticks, modulo 32
    CLIPPED,  # c was at its limit
    FAULT,  # 1: waves and encoder don't follow the same motor; latched
    CHI,  # s48q33 cells: χ
    CORRECTION,  # s31q23 V: c, for the voltage that the next tick computes
    OFFSET,  # s31q24 A: to be taken off the next tick's current
    LAG,  # s48q33 cells: x̂ less its slow copy, ω̂ over 2^8 ticks
    STARTED,  # 0 until the first tick, which has no tick before
    ROOM,  # s31q23 √W, 0...: what c takes of the limit of the next tick's wave
    PLACE,  # s48q33 cells, of an axis: its flux by the encoder in the tick before
    FRESH,  # ticks for which the last edge is still one that a contact can begin with
    INTO,  # direction of the edge with which the contact began
    YOUNG,  # the contact is, for as many times 32 ticks
    REBOUNDS,  # a rotor that hit the wall is on its way out
    BOUNCED,  # it was, since the contact began or the wall was set anew
    BEGUN,  # s48q33 cells: the flux by the encoder where the contact began
    OVERLOADED,  # the current was at the end of its range, and c has been at its limit since
) = range(27)
"""Places in an anchor's state."""
STATES = 27

FRESH_TICKS = 3
"""An edge begins a contact that is told in its own tick or in the next two."""

INNER_SHIFT = 8
"""2^-8 of χ counts inside the dead zone too: what drifts within a cell dies out."""
MEAN_SHIFT = 8
MEAN_PHASE = 31
MEAN_TICKS = (MEAN_PHASE + 1) << MEAN_SHIFT
"""ȳ takes 2^-8 of its distance to y in one tick of 32: 8 ms at 1 MHz."""
MOVING_PHASE = 7
"""While the rotor moves c_I learns in one tick of 8."""
STILL_UNITS = 16
"""Units of REST_TICKS until it counts as still, and c_I learns in every tick."""
REBOUND_UNITS = 16
"""Units of REST_TICKS, in parts of PHASE, from a contact's beginning in which it may be a hit."""
FREE_SHIFT = 1
"""Out of contact c may be 2^-1 of c_0: where only the sensor's offset flows, R has no voltage and a
brush not all of its own."""
SWING_CELLS = 4 << formats.LONG.fraction
"""What moves the current by more is no swing, but a move or a bounce."""
FOLLOWER_SHIFT = 8
"""x̂'s slow copy takes 2^-8 of its distance in each tick."""
FOLLOWER_TICKS = 1 << FOLLOWER_SHIFT
SEEN_CELLS = formats.LONG.step * 2.0**formats.LONG_GUARD
"""Cells of the last place of the RTL's ``flux_o`` and ``lag_o``, χ and x̂ less its slow copy."""

_GUARD = formats.LONG_GUARD
_CELL = 1 << formats.LONG.fraction
_TURN = (1 << (formats.LONG.width - formats.LONG.fraction)) - 1
_MOVE = 1 << (formats.MOVE_W - 1)
_NEAR_SHIFT = formats.CURRENT.fraction + formats.CELLS.fraction - formats.LONG.fraction
_FAR_SHIFT = formats.WAVE.fraction + formats.FLUX.fraction - formats.LONG.fraction
assert formats.PULL.fraction - _GUARD == _NEAR_SHIFT
assert formats.LEARN.fraction - _GUARD == _FAR_SHIFT
_VOLT_SHIFT = formats.LONG.fraction - formats.VOLTAGE.fraction
_AMPERE_SHIFT = formats.LONG.fraction - formats.CURRENT.fraction
_FAR = 1 << (formats.LONG.width - 2)
_LONG_TOP = 1 << (formats.LONG.width - 1)
_LONG_MASK = (1 << formats.LONG.width) - 1
_DATA_TOP = 1 << (formats.DATA_W - 1)
_DATA_MASK = (1 << formats.DATA_W) - 1
_MOST_UNITS = (1 << formats.REST_UNIT_W) - 1


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
    state[UNITS] = _MOST_UNITS


@compiled(inline="always")
def long_word(value):
    """``value`` as a long word holds it."""
    return ((value + _LONG_TOP) & _LONG_MASK) - _LONG_TOP


@compiled(inline="always")
def _data(value):
    """``value`` as a data word holds it."""
    return ((value + _DATA_TOP) & _DATA_MASK) - _DATA_TOP


@compiled(inline="always")
def left(u_max, state):
    """What c leaves the waves of their limit ``u_max``, raw √W: nothing where c takes all of it."""
    return max(u_max - state[ROOM], 0)


@compiled(inline="always")
def returned(eta, contact, words, state):
    """η of the next step, raw: less of it comes back to a rotor that rebounds."""
    return words[REBOUND_ETA] if contact and state[REBOUNDS] != 0 else eta


@compiled()
def anchor_step(
    state: np.ndarray,
    words: np.ndarray,
    position: int,
    contact: bool,
    current: int,
    u: int,
    v: int,
    withheld: int,
    voltage: int,
    saturated: bool,
    blind: bool = False,
) -> None:
    """One tick of the anchor beside one port; ``state`` int64 (STATES,) is updated.

    ``words`` int64 (SETTINGS,); ``position`` in counts and ``contact`` are the tick's; ``current``,
    ``u`` and ``v`` those of its core step (i_n without the offset, u_n, v_n); ``withheld`` (√W),
    ``voltage`` (e_id) and ``saturated`` of the core's step before
    (:data:`wavehaptics.controller.wave_core.STATE_WITHHELD`). ``blind`` says that the current or v
    is at the end of its range (``STATE_CLIPPED``).
    """
    moved = _moved(state, position)
    _turn(
        state, words, moved, moved * _CELL, _CELL, _CELL >> 2, (position & _TURN) * _CELL, contact,
        current, u, v, withheld, voltage, saturated, blind,
    )  # fmt: skip


@compiled()
def anchor_axis_step(
    state: np.ndarray,
    words: np.ndarray,
    position: int,
    place: int,
    cell: int,
    contact: bool,
    current: int,
    u: int,
    v: int,
    withheld: int,
    voltage: int,
    saturated: bool,
    blind: bool = False,
) -> None:
    """One tick of the anchor of a brushless motor's axis, as :func:`anchor_step`.

    At ``position`` the axis' flux is ``place`` by the encoder, which its last count changed by
    ``cell`` for a step up, s48q33 cells (:mod:`wavehaptics.controller.rotor_flux`).
    """
    moved_flux = long_word(place - state[PLACE]) if state[STARTED] != 0 else 0
    state[PLACE] = place
    _turn(
        state, words, _moved(state, position), moved_flux, cell, cell >> 1, place, contact, current,
        u, v, withheld, voltage, saturated, blind,
    )  # fmt: skip


@compiled(inline="always")
def _moved(state, position):
    """Counts since the tick before; none in the first."""
    moved = 0
    if state[STARTED] != 0:
        moved = ((position - state[POSITION] + _MOVE) & (2 * _MOVE - 1)) - _MOVE
    state[STARTED] = 1
    state[POSITION] = position
    return moved


@compiled(inline="always")
def _turn(
    state, words, moved, moved_flux, cell, start, place, contact, current, u, v, withheld, voltage,
    saturated, blind,
):  # fmt: skip
    begins = contact and state[TOUCHING] == 0
    ends = not contact and state[TOUCHING] != 0
    state[TOUCHING] = 1 if contact else 0

    same_way = False
    if moved != 0:
        back = 1 if moved < 0 else 0
        same_way = back == state[NEGATIVE] or (moved != 1 and moved != -1)
        state[NEGATIVE] = back
        state[FRESH] = FRESH_TICKS
    elif state[FRESH] > 0:
        state[FRESH] -= 1
    if same_way:
        state[TICKS] = 0
        state[UNITS] = 0
    elif state[TICKS] + 1 >= words[REST_TICKS]:
        state[TICKS] = 0
        state[UNITS] = min(state[UNITS] + 1, _MOST_UNITS)
    else:
        state[TICKS] += 1
    state[PHASE] = (state[PHASE] + 1) & MEAN_PHASE
    anew = begins
    if begins:
        state[INTO] = state[NEGATIVE]
        state[YOUNG] = (words[REST_TICKS] * REBOUND_UNITS) // (MEAN_PHASE + 1)
        state[BOUNCED] = 0
        state[BEGUN] = place
    else:
        if contact and moved != 0 and words[ENABLE] != 0 and words[REBOUND_ETA] != 0:
            inward = state[NEGATIVE] == state[INTO]
            anew = inward and state[BOUNCED] != 0
            state[BOUNCED] = 0 if inward else 1 if state[YOUNG] > 0 else state[BOUNCED]
        if state[PHASE] == 0 and state[YOUNG] > 0:
            state[YOUNG] -= 1

    e = -voltage if voltage < 0 else voltage
    reach = words[REACH] if contact else words[REACH] >> FREE_SHIFT
    limit = (reach << _VOLT_SHIFT) + (e << (_VOLT_SHIFT - 1))
    state[ROOM] = 0
    if contact:
        room = (words[ROOM_GAIN] * state[CORRECTION]) >> _FAR_SHIFT
        state[ROOM] = _data(long_word(-room if state[CORRECTION] < 0 else room) >> _VOLT_SHIFT)

    flux = long_word(state[FLUX] - ((words[FLUX_GAIN] * u) >> _FAR_SHIFT))
    flux = long_word(flux - ((words[FLUX_GAIN] * v) >> _FAR_SHIFT))
    if contact:
        owed = words[OWED_GAIN] if saturated else words[FLUX_GAIN]
        flux = long_word(flux - ((owed * withheld) >> _FAR_SHIFT))
    y = long_word((words[CELLS_GAIN] * current) >> _NEAR_SHIFT)
    zero_step = (words[ZERO_GAIN] * state[CORRECTION]) >> _FAR_SHIFT
    if anew:
        flux = long_word(((words[OWED_GAIN] * u) >> _FAR_SHIFT) + place - state[BEGUN])
        if state[FRESH] > 0:
            flux = long_word(flux + (-start if state[NEGATIVE] != 0 else start))
    else:
        flux = long_word(flux + moved_flux)
    state[FLUX] = flux
    chi = long_word(flux + y)
    state[CHI] = chi

    swing = long_word(y - state[MEAN])
    if state[PHASE] == 0 and not blind:
        state[MEAN] = long_word(state[MEAN] + (swing >> MEAN_SHIFT))

    half = (-cell if cell < 0 else cell) >> 1
    beyond = 0
    if chi - half >= 0:
        beyond = chi - half
    elif chi + half < 0:
        beyond = chi + half
    p = _data((beyond + (chi >> INNER_SHIFT)) >> _GUARD)

    if not contact and state[UNITS] >= words[SLOW_UNITS] and not blind:
        state[ZERO] = long_word(state[ZERO] - zero_step)

    learns = state[UNITS] >= STILL_UNITS or state[PHASE] & MOVING_PHASE == 0
    if ends:
        state[LEARNED] = 0
    if learns and state[CLIPPED] == 0 and not saturated and not blind:
        state[LEARNED] = long_word(state[LEARNED] - ((words[LEARN_GAIN] * p) >> _FAR_SHIFT))
    wanted = long_word(state[LEARNED] - ((words[PULL_GAIN] * p) >> _NEAR_SHIFT))
    if contact and state[UNITS] >= 1 and -SWING_CELLS <= swing < SWING_CELLS:
        wanted = long_word(wanted - ((words[DAMP_GAIN] * _data(swing >> _GUARD)) >> _NEAR_SHIFT))

    negative = wanted < 0
    past = long_word(wanted + limit) if negative else long_word(wanted - limit)
    clipped = (past < 0) == negative
    c = wanted
    if clipped:
        c = -limit if negative else limit
    state[CLIPPED] = 1 if clipped else 0
    state[OVERLOADED] = 1 if blind or (clipped and state[OVERLOADED] != 0) else 0
    strange = words[STRANGE] << _VOLT_SHIFT
    strange = long_word(past + strange) if negative else long_word(past - strange)
    lost = clipped and (strange < 0) == negative and not saturated and state[OVERLOADED] == 0
    lost = lost or chi >= _FAR or chi < -_FAR
    if words[ENABLE] != 0 and lost:
        state[FAULT] = 1
    out = contact and state[YOUNG] > 0 and state[NEGATIVE] != state[INTO]
    state[REBOUNDS] = 1 if words[ENABLE] != 0 and words[REBOUND_ETA] != 0 and out else 0
    active = words[ENABLE] != 0 and state[FAULT] == 0 and not blind
    state[CORRECTION] = _data(c >> _VOLT_SHIFT) if active else 0
    state[OFFSET] = _data(state[ZERO] >> _AMPERE_SHIFT)

    lag = long_word(place - chi - state[FOLLOWER])
    state[LAG] = lag
    state[FOLLOWER] = long_word(state[FOLLOWER] + (lag >> FOLLOWER_SHIFT))
