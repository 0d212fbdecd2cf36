# SPDX-License-Identifier: Apache-2.0
"""Between three phases in star and two ports, as integers: Clarke's transform and its inverse.

Amplitude-invariant: with the phases' currents summing up to zero, of which two are measured,

    α = a                 β = (a + 2 b)/√3
    a = α                 b = −α/2 + (√3/2) β        c = −α/2 − (√3/2) β

Each takes one product with a coefficient of the RTL's width. All that is cut off is cut toward
zero, as in the wave path, and the coefficients are rounded down: neither transform makes a vector
longer by more than the place that α/2 loses. What the legs have in common drives nothing in a
star: :func:`centred` chooses it so that the bridge reaches as far as its bus lets it.
``rtl/wh_clarke.v`` and ``rtl/wh_inverse_clarke.v`` are these functions, bit for bit.
"""

from __future__ import annotations

import math

from wavehaptics.controller.wave_core import saturate, truncate
from wavehaptics.runtime.compiled import compiled
from wavehaptics.words import formats

COEFFICIENT = formats.Fixed(formats.COEF_W, formats.COEF_W - 2)
"""Format of both coefficients, below 2."""
TWO_OVER_ROOT3 = math.floor(2.0 / math.sqrt(3.0) / COEFFICIENT.step)
HALF_ROOT3 = math.floor(0.5 * math.sqrt(3.0) / COEFFICIENT.step)

_Q = COEFFICIENT.fraction
_MOST, _LEAST = formats.CURRENT.raw_max, formats.CURRENT.raw_min


@compiled(inline="always")
def currents(a: int, b: int) -> tuple[int, int]:
    """Currents of α and β of those of the phases a and b, words of ``formats.CURRENT``.

    β's half sum ``a/2 + b`` is √3/2 β, so that a data word holds it wherever one holds β.
    """
    half_sum = saturate(truncate(a + 2 * b, 1))
    return a, saturate(truncate(TWO_OVER_ROOT3 * half_sum, _Q))


@compiled(inline="always")
def ends(beta: int) -> int:
    """Which end of its range β has reached: bits ``formats.AT_HIGH`` and ``formats.AT_LOW``.

    A half sum at its end takes β to its own.
    """
    return formats.AT_HIGH if beta == _MOST else formats.AT_LOW if beta == _LEAST else 0


@compiled(inline="always")
def phases(alpha: int, beta: int) -> tuple[int, int, int]:
    """Voltages of the phases a, b and c of those of both ports, words of ``formats.VOLTAGE``."""
    half, side = truncate(alpha, 1), truncate(HALF_ROOT3 * beta, _Q)
    return alpha, saturate(side - half), saturate(-side - half)


@compiled(inline="always")
def centred(a: int, b: int, c: int) -> tuple[int, int, int]:
    """Voltages of the legs of those of the phases: the highest as far up as the lowest is down.

    All three take off the same integer, so what lies between two legs is what lies between the
    phases; and what is left is never longer than a word.
    """
    common = truncate(max(a, b, c) + min(a, b, c), 1)
    return a - common, b - common, c - common
