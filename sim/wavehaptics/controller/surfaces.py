# SPDX-License-Identifier: Apache-2.0
"""Surfaces across the motors of a group, as integers: the reference model of the RTL.

A surface is a plane ``G·x ≥ d`` in the counts x of a group's ports, and a unit vector g in their
waves. While the rotors are beyond the plane, waves along g are reflected and all others pass::

    p = g·v,   y = η·H{p} + ξ,   u = v + g·(y − p).

H is the surface's own λ filter; that of each port follows. Up to three surfaces of a group act at a
time, the first three in contact, one after another. The vectors of the second and the third are
orthogonal to those before (:func:`pair_row`, :func:`triple_row`).

**Passive with any settings.** A vector is accepted only with ``|g|² ≤ 1``, exactly, in integers
(:func:`accepts`). Then u has at most the energy of v and y. With p rounded toward zero::

    |u|² ≤ |v|² + y² − p².

Each surface has an account: p² is added, y² is subtracted, and a y that it doesn't cover becomes 0.
So neither a filter whose coefficient changes nor a wrong η gives out energy. The further energy of
a moving wall comes from the group's budget, and what a surface still has when it is left pays that
back. Without budget the wall doesn't move. Over any time ``Σ|u|² ≤ Σ|v|² + budget``, the largest
that was set, which ``sim/tests/test_surfaces.py`` checks.

**The wall velocity ξ.** With a constant g the sum of ``u_g + v_g`` keeps the wall where the contact
began. When g turns, only the force is kept. The error of the wall's position is

    ε = G·x − d + Σ c_n i_n,   c_n = G_n·L_eff,n/k_T,n in counts/A,

where the second term is the springs' deflection. The part of ε beyond half a count gives
``ξ = −gain·beyond``, within a limit. When a surface is touched while another is in contact, the
present currents aren't its own deflection. So while several are in contact, ε excludes the currents
with which this contact began. The directions of a set are combinations of its surfaces' vectors,
and so are their velocities.

**Loss across.** The part of the waves across all surfaces in contact is multiplied by η_a: the
surface's own if it is alone, or the η of free space if that is less. With three surfaces nothing
is across.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from wavehaptics.controller.wave_core import saturate, toward_zero, truncate
from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats

MOST_SURFACES = 8
MOST_ACTIVE = 3
PORTS = 3
"""Ports of a group; unused ones have zeros in every vector."""

PRESENT, G, D, C, GAIN, A, ETA, ACROSS = 0, 1, 4, 5, 8, 9, 10, 11
PLANE_WORDS = 12
"""Indices of a surface's settings, int64 (MOST_SURFACES, PLANE_WORDS): whether it exists; G of each
port (``formats.SURFACE``), d less half a count of each port (``formats.DISTANCE``), c of each port
(``formats.CELLS``), the gain of ξ (√W per count, ``formats.SURFACE``), the filter's a
(``formats.A``), η in contact and η_a across (``formats.ETA``)."""

VECTOR, MIX = 0, 3
VECTOR_WORDS = 6
"""Indices of a row of vectors, int64 (VECTORS, VECTOR_WORDS): g of each port (``formats.SURFACE``)
and the shares of the set's wall velocities (``formats.MIX``)."""

VELOCITY_MAX, BUDGET = range(2)
LIMITS = 2
"""Indices of a group's limits: the largest ξ (``formats.WAVE``), and the largest budget in squares
of a wave's LSB."""

TOUCHING, FILTER, ACCOUNT, REST = range(4)
SURFACE_STATES = 4
"""Indices of a surface's state, int64 (MOST_SURFACES, SURFACE_STATES): in contact; f of its filter,
with ``STATE_GUARD`` bits below a wave's; its account, in squares of a wave's LSB; the currents'
part of ε when its contact began, of ``formats.SEEN``."""

_PAIRS = sorted(combinations(range(MOST_SURFACES), 2), key=lambda pair: pair[::-1])
_TRIPLES = sorted(combinations(range(MOST_SURFACES), 3), key=lambda triple: triple[::-1])
VECTORS = MOST_SURFACES + len(_PAIRS) + len(_TRIPLES)

PAIR_ROW = np.zeros((MOST_SURFACES, MOST_SURFACES), dtype=np.int64)
"""Row of the vector of the second of two surfaces, in ascending order."""
for _row, (_i, _j) in enumerate(_PAIRS, MOST_SURFACES):
    PAIR_ROW[_i, _j] = _row
TRIPLE_ROW = np.zeros((MOST_SURFACES, MOST_SURFACES, MOST_SURFACES), dtype=np.int64)
"""Row of the vector of the third of three."""
for _row, (_i, _j, _k) in enumerate(_TRIPLES, MOST_SURFACES + len(_PAIRS)):
    TRIPLE_ROW[_i, _j, _k] = _row

ACCOUNT_MAX = 1 << 61
"""Largest account and budget; anything beyond is dropped."""

_Q = formats.SURFACE.fraction
_ONE = 1 << _Q
_MIX_Q = formats.MIX.fraction
_ETA_Q = formats.ETA.fraction
_ETA_ONE = 1 << _ETA_Q
_GUARD = formats.STATE_GUARD
_A_Q = formats.A.fraction
_A_ONE = 1 << _A_Q
_A_SHIFT = _A_Q - _GUARD
_D_SHIFT = _Q - formats.DISTANCE.fraction
_SEEN = formats.SEEN.fraction
_PLACE_SHIFT = _Q - _SEEN
_BEND_SHIFT = formats.CELLS.fraction + formats.CURRENT.fraction - _SEEN
_HALF_COUNT = (1 << max(_SEEN, 0)) >> 1  # 0 where short words don't show it
_XI_SHIFT = _Q + _SEEN - formats.WAVE.fraction


def new_planes() -> np.ndarray:
    """Settings of a group without surfaces: int64 (MOST_SURFACES, PLANE_WORDS)."""
    return np.zeros((MOST_SURFACES, PLANE_WORDS), dtype=np.int64)


def new_vectors() -> np.ndarray:
    """Vectors of a group without surfaces: int64 (VECTORS, VECTOR_WORDS)."""
    return np.zeros((VECTORS, VECTOR_WORDS), dtype=np.int64)


def new_state() -> np.ndarray:
    """States of a group's surfaces after reset: int64 (MOST_SURFACES, SURFACE_STATES)."""
    return np.zeros((MOST_SURFACES, SURFACE_STATES), dtype=np.int64)


def pair_row(first: int, second: int) -> int:
    """Row of the vector of ``second`` beside ``first``, two surfaces in ascending order."""
    return int(PAIR_ROW[first, second])


def triple_row(first: int, second: int, third: int) -> int:
    """Row of the vector of ``third`` beside two others, three surfaces in ascending order."""
    return int(TRIPLE_ROW[first, second, third])


@compiled()
def accepts(planes: np.ndarray, vectors: np.ndarray) -> bool:
    """Whether settings may be committed: every ``|g|² ≤ 1``, every η in [−1, 1] and a in [0, 1]."""
    for row in range(vectors.shape[0]):
        left = 1 << (2 * _Q)
        for port in range(PORTS):
            g = vectors[row, VECTOR + port]
            if g > _ONE or g < -_ONE:
                return False
            left -= g * g
        if left < 0:
            return False
    for row in range(planes.shape[0]):
        eta, across, a = planes[row, ETA], planes[row, ACROSS], planes[row, A]
        if eta > _ETA_ONE or eta < -_ETA_ONE or across > _ETA_ONE or across < 0:
            return False
        if a > _A_ONE or a < 0:
            return False
    return True


@compiled(inline="always")
def along(vector: np.ndarray, waves: np.ndarray, q: int) -> tuple[int, int]:
    """``g·v`` of a vector with ``q`` fraction bits: rounded toward zero, and the sign of the rest
    that rounding cut off: −1, 0 or 1. A value beyond a data word saturates; the sign is then ±2.
    """
    exact = 0
    for port in range(PORTS):
        exact += vector[port] * waves[port]
    wide = truncate(exact, q)
    p = saturate(wide)
    beyond = exact - (p << q)
    side = 1 if beyond > 0 else -1 if beyond < 0 else 0
    return p, side if wide == p else 2 * side


@compiled(inline="always")
def replace_along(vector: np.ndarray, waves: np.ndarray, p: int, side: int, y: int, q: int) -> None:
    """``v += g·(y − p)``, with p and ``side`` of :func:`along`: ``|v|²`` grows by y² − p² at most.

    If y − p has the sign of ``side``, the exact p counts, which is up to one LSB larger: the change
    is then one LSB less. If p saturated, its rest isn't known, and v stays.
    """
    change = y - p
    if side * change > 0:
        change = change - side if side * side == 1 else 0
    for port in range(PORTS):
        wave = truncate((waves[port] << q) + vector[port] * change, q)
        waves[port] = saturate(wave)


@compiled(inline="always")
def lose_across(vector: np.ndarray, waves: np.ndarray, eta: int, q: int, eta_q: int) -> None:
    """Multiply the part of the waves across g by ``eta``, which has ``eta_q`` fraction bits."""
    p, _ = along(vector, waves, q)
    kept = truncate(((1 << eta_q) - eta) * p, eta_q)
    for port in range(PORTS):
        wave = ((eta * waves[port]) << (q - eta_q)) + vector[port] * kept
        waves[port] = saturate(truncate(wave, q))


@compiled(inline="always")
def answer(
    state: np.ndarray, spent: np.ndarray, p: int, eta: int, a: int, velocity: int, budget: int
) -> int:
    """y of one surface for its wave p: ``η·H{p} + ξ``, within account and budget.

    ``state`` int64 (SURFACE_STATES,) and what is ``spent`` of the budget, int64 (1,), are updated;
    ``velocity`` is ξ. All are raw words.
    """
    state[ACCOUNT] = min(state[ACCOUNT] + p * p, ACCOUNT_MAX)
    goal = truncate(eta * p, _ETA_Q) << _GUARD
    f = state[FILTER]
    if a >= _A_ONE:
        f = goal
    else:
        step = (a * ((goal - f) >> _GUARD)) >> _A_SHIFT
        # Two floors take less than this of the exact step.
        f = toward_zero(f + step, (a >> _A_SHIFT) + 1)
    limit = ((1 << (formats.DATA_W - 1)) - 1) << _GUARD
    f = min(max(f, -limit), limit)
    state[FILTER] = f
    resting = truncate(f, _GUARD)
    y = saturate(resting + velocity)
    funds = state[ACCOUNT] + max(budget - spent[0], 0)
    if y * y > funds:
        y = resting
    if y * y > funds:
        y = 0
    given = y * y
    if given > state[ACCOUNT]:
        spent[0] += given - state[ACCOUNT]
        state[ACCOUNT] = 0
    else:
        state[ACCOUNT] -= given
    return y


@compiled(inline="always")
def depth(plane: np.ndarray, positions: np.ndarray) -> int:
    """``G·x − d`` of a surface with the fraction bits of ``formats.SURFACE``, counts."""
    place: int = -(plane[D] << _D_SHIFT)
    for port in range(PORTS):
        place += plane[G + port] * positions[port]
    return place


@compiled(inline="always")
def bend(plane: np.ndarray, currents: np.ndarray) -> int:
    """``Σ c_n i_n`` of a surface, counts of ``formats.SEEN``."""
    total = 0
    for port in range(PORTS):
        total += (plane[C + port] * currents[port]) >> _BEND_SHIFT
    return saturate(total)


@compiled(inline="always")
def wall_velocity(plane: np.ndarray, place: int, bent: int, most: int) -> int:
    """ξ of a surface, raw √W: the rotors are ``place`` beyond it, the springs ``bent``."""
    error = saturate((place >> _PLACE_SHIFT) + bent)
    beyond = 0
    if error > _HALF_COUNT:
        beyond = error - _HALF_COUNT
    elif error < -_HALF_COUNT:
        beyond = error + _HALF_COUNT
    velocity = -truncate(plane[GAIN] * beyond, _XI_SHIFT)
    return min(max(velocity, -most), most)


@compiled(inline="always")
def lose_across_two(
    first: np.ndarray, second: np.ndarray, waves: np.ndarray, eta: int, q: int, eta_q: int
) -> None:
    """:func:`lose_across` of two vectors that should be orthogonal; nothing if it were a gain."""
    p, _ = along(first, waves, q)
    before, after = 0, 0
    left_0 = waves[0] - truncate(first[0] * p, q)
    left_1 = waves[1] - truncate(first[1] * p, q)
    left_2 = waves[2] - truncate(first[2] * p, q)
    p = truncate(second[0] * left_0 + second[1] * left_1 + second[2] * left_2, q)
    lost = (1 << eta_q) - eta
    left_0 = waves[0] - truncate(lost * (left_0 - truncate(second[0] * p, q)), eta_q)
    left_1 = waves[1] - truncate(lost * (left_1 - truncate(second[1] * p, q)), eta_q)
    left_2 = waves[2] - truncate(lost * (left_2 - truncate(second[2] * p, q)), eta_q)
    left_0, left_1, left_2 = saturate(left_0), saturate(left_1), saturate(left_2)
    for port in range(PORTS):
        before += waves[port] * waves[port]
    after = left_0 * left_0 + left_1 * left_1 + left_2 * left_2
    if after <= before:
        waves[0], waves[1], waves[2] = left_0, left_1, left_2


@compiled(inline="always")
def _row_of(order: int, first: int, second: int, third: int) -> int:
    """Row of the vector of the surface with index ``order`` among those in contact."""
    if order == 0:
        return first
    row: int = PAIR_ROW[first, second] if order == 1 else TRIPLE_ROW[first, second, third]
    return row


@compiled()
def surfaces_step(
    state: np.ndarray, spent: np.ndarray, active: np.ndarray, planes: np.ndarray,
    vectors: np.ndarray, limits: np.ndarray, positions: np.ndarray, currents: np.ndarray, free: int,
    waves: np.ndarray,
) -> int:  # fmt: skip
    """One period of a group. Returns how many surfaces act; ``waves`` become their goal u.

    ``planes``, ``vectors`` and ``limits`` are words that :func:`accepts` took; ``state``, what is
    ``spent`` of the budget, int64 (1,), and ``active`` int64 (MOST_ACTIVE,), the numbers of those
    in contact, are updated. ``positions`` in counts, ``currents`` and ``waves`` int64 (PORTS,) are
    the period's; ``waves`` are v, or what a wall of a port's own makes of it. ``free`` is the least
    η of the ports' free space. Where no surface acts the waves stay as they are.
    """
    touching = 0
    for surface in range(MOST_SURFACES):
        plane = planes[surface]
        place = depth(plane, positions)
        if plane[PRESENT] == 0 or place < 0 or touching == MOST_ACTIVE:
            if state[surface, TOUCHING] != 0:
                spent[0] = max(spent[0] - state[surface, ACCOUNT], 0)
                state[surface] = 0
            continue
        if state[surface, TOUCHING] == 0:
            state[surface, TOUCHING] = 1
            state[surface, REST] = bend(plane, currents)
        active[touching] = surface
        touching += 1
    if touching == 0:
        return 0
    if touching == 1:
        state[active[0], REST] = 0
    velocities_0, velocities_1, velocities_2 = 0, 0, 0
    for order in range(touching):
        plane, rest = planes[active[order]], state[active[order], REST]
        bent = bend(plane, currents) - rest
        velocity = wall_velocity(plane, depth(plane, positions), bent, limits[VELOCITY_MAX])
        if order == 0:
            velocities_0 = velocity
        elif order == 1:
            velocities_1 = velocity
        else:
            velocities_2 = velocity
    eta = min(free, planes[active[0], ACROSS]) if touching == 1 else free
    if eta < _ETA_ONE and touching < MOST_ACTIVE:
        vector = vectors[active[0]]
        if touching == 1:
            lose_across(vector, waves, max(eta, 0), _Q, _ETA_Q)
        else:
            beside = vectors[PAIR_ROW[active[0], active[1]]]
            lose_across_two(vector, beside, waves, max(eta, 0), _Q, _ETA_Q)
    for order in range(touching):
        surface = active[order]
        vector = vectors[_row_of(order, active[0], active[1], active[2])]
        velocity = vector[MIX] * velocities_0
        if order > 0:
            velocity += vector[MIX + 1] * velocities_1
        if order > 1:
            velocity += vector[MIX + 2] * velocities_2
        velocity = truncate(velocity, _MIX_Q)
        velocity = min(max(velocity, -limits[VELOCITY_MAX]), limits[VELOCITY_MAX])
        p, side = along(vector, waves, _Q)
        plane = planes[surface]
        y = answer(state[surface], spent, p, plane[ETA], plane[A], velocity, limits[BUDGET])
        replace_along(vector, waves, p, side, y, _Q)
    return touching
