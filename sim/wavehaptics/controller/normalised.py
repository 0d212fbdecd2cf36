# SPDX-License-Identifier: Apache-2.0
"""Biquads as contractive matrices: the form in which a rounding can only lose energy.

A section with two states is ``[x', y] = M [x, v]``. In the coordinates in which its stored energy
is ``|x|²`` every bounded W has an M with ``|M| ≤ 1``: then ``|x'|² + y² ≤ |x|² + v²`` in every
single tick, and it stays so when x' and y are rounded toward zero, when they are limited, when x is
set to zero or held still, and when M becomes another contractive M. Nothing has to be known of the
signal.

The noise gain follows as well: what a rounding puts into a state leaves through y with
``|C (zI − A)⁻¹|₂ ≤ 1``, however low the corner frequency. A direct form has ``1/(4 ζ θ³)`` for its
square at a pole angle of θ, 10¹⁰ for 50 Hz at 1 MHz.

Method: complete W by V to a lossless pair, ``|W|² + |V|² = 1`` (spectral factor, closed form for
two poles); its observability Gramian is the energy; change to the coordinates where that is 1; the
bilinear transform keeps it so. All of it is done at a frequency scaled to the poles', as the
z-plane around 1 has no digits to spare.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from wavehaptics.controller.wave_core import B1, B2, C1, C2, E11, E12, E21, E22, LOSS1, D
from wavehaptics.laws.reflection import WishError, excess, worst_frequency
from wavehaptics.words import formats

_TOO_MUCH = 1e-12
_MOST_SHRINKS = 4096


def realise(top: np.ndarray, bottom: np.ndarray, tick_s: float) -> np.ndarray:
    """M less the identity of its states, float (3, 3), of ``W(s) = top/bottom`` at a tick.

    ``top`` and ``bottom`` are quadratics in s, the highest power first, with leading zeros where W
    has fewer poles. :class:`WishError` where W is not stable or ``|W|`` exceeds one.
    """
    top, bottom = np.asarray(top, dtype=float), np.asarray(bottom, dtype=float)
    if not np.any(bottom):
        raise WishError("shaper: a denominator is zero; give one with a pole or a constant")
    order = 2 - int(np.flatnonzero(bottom)[0])
    poles = np.roots(bottom[2 - order :])
    if any(pole.real >= 0.0 for pole in poles):
        raise WishError("shaper: W is not stable; all its poles must be inside the unit circle")
    gain, omega = worst_frequency(top, bottom)
    if gain > 1.0 + _TOO_MUCH:
        where = (
            f"{omega / (2 * math.pi):.6g} Hz" if math.isfinite(omega) else "the highest frequency"
        )
        raise WishError(
            f"shaper: |D| is {gain:.9g} at {where}, and so would give energy out; "
            "no |D| may exceed one"
        )
    scale = float(np.prod(np.abs(poles)) ** (1.0 / order)) if order else 1.0
    powers = scale ** np.array([2.0, 1.0, 0.0])
    lead = (bottom * powers)[2 - order]
    n, d = top * powers / lead, bottom * powers / lead
    a, b, c_w, c_v = _canonical(n, d, order)
    # Coordinates in which the lossless pair's observability Gramian is 1.
    c = np.vstack([c_w, c_v])
    gramian = solve_continuous_lyapunov(a.T, -c.T @ c) if order else np.zeros((0, 0))
    size, turn = np.linalg.eigh(gramian)
    kept = size > 1e-12 * size.max(initial=0.0)
    root = np.sqrt(size[kept])
    to, back = root[:, None] * turn[:, kept].T, turn[:, kept] / root
    # Bilinear transform, s = (2/T)(z − 1)/(z + 1).
    half = 0.5 * tick_s * scale
    a, b, c_w = half * (to @ a @ back), math.sqrt(half) * (to @ b), math.sqrt(half) * (c_w @ back)
    states = len(a)
    inverse = np.linalg.inv(np.eye(states) - a)
    matrix = np.zeros((3, 3))
    matrix[:states, :states] = 2.0 * a @ inverse
    matrix[:states, 2] = math.sqrt(2.0) * inverse @ b
    matrix[2, :states] = math.sqrt(2.0) * c_w @ inverse
    matrix[2, 2] = n[2 - order] + c_w @ inverse @ b
    return matrix


def _canonical(n: np.ndarray, d: np.ndarray, order: int) -> tuple[np.ndarray, ...]:
    """Controllable form (A, B, C of W, C of V) of n/d and of the V with ``|W|² + |V|² = 1``."""
    p2, p1, p0 = np.maximum(excess(n, d), [0.0, -np.inf, 0.0])
    q2, q0 = math.sqrt(p2), math.sqrt(p0)
    q = np.array([q2, math.sqrt(max(p1 + 2.0 * q0 * q2, 0.0)), q0])
    d, n, q = d[2 - order :], n[2 - order :], q[2 - order :]
    a = np.zeros((order, order))
    a[:1] = -d[1:]
    a[1:, :-1] = np.eye(max(order - 1, 0))
    b = np.zeros(order)
    b[:1] = 1.0
    return a, b, n[1:] - n[0] * d[1:], q[1:] - q[0] * d[1:]


def from_sos(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A row ``b0 b1 b2 a0 a1 a2`` as quadratics in s for a tick of 2 s, by z = (1 + s)/(1 − s)."""

    def turned(p: np.ndarray) -> np.ndarray:
        return np.array([p[0] - p[1] + p[2], 2.0 * (p[0] - p[2]), p[0] + p[1] + p[2]])

    return turned(np.asarray(row[:3], dtype=float)), turned(np.asarray(row[3:], dtype=float))


def is_contractive(words: np.ndarray) -> bool:
    """Whether ``|M| ≤ 1`` for the words of a section, exactly: 1 − MᵀM has no negative minor."""
    one = 1 << formats.SHAPE.fraction
    w = [int(word) for word in words]
    rows = [[one + w[E11], w[E12], w[B1]], [w[E21], one + w[E22], w[B2]], [w[C1], w[C2], w[D]]]
    rest = [
        [(one * one if i == j else 0) - sum(row[i] * row[j] for row in rows) for j in range(3)]
        for i in range(3)
    ]

    def minor(places: tuple[int, ...]) -> int:
        if len(places) == 1:
            return rest[places[0]][places[0]]
        if len(places) == 2:
            i, j = places
            return rest[i][i] * rest[j][j] - rest[i][j] ** 2
        (a, b, c), (_, e, f), (_, _, i) = rest
        return a * (e * i - f * f) - b * (b * i - f * c) + c * (b * f - e * c)

    return all(minor(p) >= 0 for p in ((0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)))


def losses(words: np.ndarray) -> tuple[int, int, int]:
    """Last places to bring x₁', x₂' and y nearer to zero by, to be no larger than exact.

    The multiplier sees a state rounded to the nearest without its guard bits; what they could have
    added is bounded by ``Σ|E| 2^(guard − 1)`` of a state's last places, and likewise for y.
    """
    w = [abs(int(word)) for word in words]
    hidden = 1 << (formats.STATE_GUARD - 1)
    one = 1 << formats.SHAPE.fraction

    def whole(sum_: int, shift: int) -> int:
        return math.ceil(Fraction(sum_ * hidden, one << shift))

    guard_in_wave = formats.STATE_GUARD - formats.SHAPE_HEADROOM
    return (
        whole(w[E11] + w[E12], 0), whole(w[E21] + w[E22], 0), whole(w[C1] + w[C2], guard_in_wave),
    )  # fmt: skip


def quantise(matrix: np.ndarray) -> np.ndarray:
    """Words of a section, int64 (SECTION_WORDS,), for the matrix of :func:`realise`.

    Rounding to the nearest may leave ``|M|`` above one by some last places; M is made smaller by as
    few of them as do.
    """
    identity = np.diag([1.0, 1.0, 0.0])
    one = float(1 << formats.SHAPE.fraction)
    whole = matrix + identity
    for shrink in range(_MOST_SHRINKS):
        shrunk = whole * (1.0 - 0.25 * shrink / one) - identity
        raw = np.rint(shrunk * one)
        places = [(0, 0), (0, 1), (1, 0), (1, 1), (0, 2), (1, 2), (2, 0), (2, 1), (2, 2)]
        words = np.array([*(int(raw[p]) for p in places), 0, 0, 0], dtype=np.int64)
        if is_contractive(words):
            words[LOSS1:] = losses(words)
            return words
    raise WishError(
        "shaper: no contractive matrix was found near the wish; |D| must not exceed one"
    )


def response(words: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """W of one section's words at ``turn`` = ωT, complex, of the same shape."""
    x1, x2 = _states(words, turn)
    w = np.asarray(words[:LOSS1], dtype=float) / float(1 << formats.SHAPE.fraction)
    found: np.ndarray = w[C1] * x1 + w[C2] * x2 + w[D]
    return found


def state_gain(words: np.ndarray) -> float:
    """Largest magnitude of a section's state over that of its wave, at whatever frequency."""
    # From below the lowest corner that words can have to half a turn a tick.
    return float(np.max(np.abs(_states(words, np.geomspace(1e-9, math.pi, 4000)))))


def _states(words: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both states of a section for a wave of 1 at ``turn`` = ωT, complex, of the same shape."""
    one = float(1 << formats.SHAPE.fraction)
    w = np.asarray(words[:LOSS1], dtype=float) / one
    # z − 1 without losing its digits near zero
    z1 = np.expm1(1j * np.asarray(turn, dtype=float))
    p, q, r, t = z1 - w[E11], -w[E12], -w[E21], z1 - w[E22]
    determinant = p * t - q * r
    x1 = (t * w[B1] - q * w[B2]) / determinant
    x2 = (p * w[B2] - r * w[B1]) / determinant
    return x1, x2


def noise_gain(words: np.ndarray) -> tuple[float, float]:
    """Power gain from a white rounding error of each state to y: at most 1 by construction."""
    one = float(1 << formats.SHAPE.fraction)
    w = np.asarray(words[:LOSS1], dtype=float) / one
    e, c = np.array([[w[E11], w[E12]], [w[E21], w[E22]]]), np.array([w[C1], w[C2]])
    # Q = AᵀQA + CᵀC with A = 1 + E: EᵀQ + QE + EᵀQE = −CᵀC, four numbers of a linear system.
    eye = np.eye(2)
    system = np.kron(e.T, eye) + np.kron(eye, e.T) + np.kron(e.T, e.T)
    used = [k for k in range(2) if e[k].any() or c[k]]
    at = [2 * i + j for i in used for j in used]
    if not at:
        return 0.0, 0.0
    solved = np.linalg.solve(system[np.ix_(at, at)], -np.outer(c, c).reshape(-1)[at])
    q = np.zeros(4)
    q[at] = solved
    return float(q[0]), float(q[3])
