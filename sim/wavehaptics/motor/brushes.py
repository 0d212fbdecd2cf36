# SPDX-License-Identifier: Apache-2.0
"""The brushes: a voltage of their own, and a resistance that changes with the rotor's angle.

``V_b tanh(i/knee)`` lies in series with the winding, and ``R`` becomes
``R (1 + ripple cos(segments θ) + step·[even bar] + noise(θ) + flicker(t))``. Bars are
``2π/segments`` wide; bar 0 begins at ``step_at_rad`` and every other bar has the ``step``, so R
changes by that part where the rotor passes ``step_at_rad`` upwards and back again a bar later.
Angles are counted on, not modulo a revolution, so that bars alternate for an odd number of segments
too.

What a sliding contact adds at random changes as the rotor turns: other spots of the surfaces touch.
At rest the spots stay, and what is left is the flicker of the current in them, far smaller in a
brush that is sound. Both are a course that is drawn once and begins again at its end.
"""

from __future__ import annotations

import math

import numpy as np

from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene.tables.brushes import Brushes

(
    DROP, TWICE_PER_KNEE, RIPPLE, STEP, SEGMENTS, PER_BAR, STEP_AT, NOISE, PER_RAD, FLICKER, PER_S,
) = range(11)  # fmt: skip
"""Places in :func:`brush_words`: V, 2/A, Ω, Ω, 1/rad, 1/rad, rad; of each noise its RMS in Ω and
the points of its course in a radian or second."""

POINTS_CORRELATED = 32
"""Points of a noise's course within its correlation; it is straight between two."""
NOISE_POINTS = 1 << 17
"""Points after which a noise begins again: 4096 correlations."""
NOISE_SEED, FLICKER_SEED = 20_260_103, 20_260_102


def brush_words(brushes: Brushes | None, resistance: float) -> np.ndarray:
    """Constants of :func:`brush_drop` and :func:`contact_ohm` for a winding of ``resistance``."""
    words = np.zeros(PER_S + 1)
    if brushes is not None:
        words[DROP], words[TWICE_PER_KNEE] = brushes.drop_v, 2 / brushes.knee_a
        words[RIPPLE] = brushes.ripple * resistance
        words[STEP] = brushes.step * resistance
        words[SEGMENTS] = brushes.segments
        words[PER_BAR] = brushes.segments / (2 * math.pi)
        words[STEP_AT] = brushes.step_at_rad
        words[NOISE] = brushes.contact_noise * resistance
        words[PER_RAD] = POINTS_CORRELATED / brushes.noise_rad
        words[FLICKER] = brushes.flicker_noise * resistance
        words[PER_S] = POINTS_CORRELATED / brushes.flicker_s
    return words


def noise_courses(brushes: Brushes | None) -> tuple[np.ndarray, np.ndarray]:
    """The courses of the noise over the angle and of that over time; (0,) where there is none.

    They are functions of the angle or of time alone, so that every controller, whatever its steps,
    meets the same.
    """
    nothing = np.zeros(0)
    if brushes is None:
        return nothing, nothing
    return (
        noise_course(NOISE_SEED) if brushes.contact_noise else nothing,
        noise_course(FLICKER_SEED) if brushes.flicker_noise else nothing,
    )


def noise_course(seed: int) -> np.ndarray:
    """One round of an Ornstein-Uhlenbeck process of RMS 1, (NOISE_POINTS,)."""
    keep = math.exp(-1 / POINTS_CORRELATED)
    kicks = np.random.default_rng(seed).standard_normal(NOISE_POINTS)
    # A straight line between two points has less power than they.
    kicks *= math.sqrt((1 - keep**2) / ((2 + keep) / 3))
    from scipy.signal import lfilter  # a second to import, and few scenes have contact noise

    course: np.ndarray = lfilter([1.0], [1.0, -keep], kicks)
    # What the end leaves for the beginning: the round closes.
    course += course[-1] * keep ** np.arange(1, NOISE_POINTS + 1)
    return course


@compiled(inline="always")
def brush_drop(current: float, words: np.ndarray) -> tuple[float, float]:
    """Voltage of the brushes at a current in A, and its slope: V, Ω."""
    # The hyperbolic tangent by the exponential, which is twice as fast and overflows rightly.
    part = 1.0 - 2.0 / (np.exp(words[TWICE_PER_KNEE] * current) + 1.0)
    return words[DROP] * part, 0.5 * words[DROP] * words[TWICE_PER_KNEE] * (1.0 - part * part)


@compiled(inline="always")
def noise_at_place(at: float, rate: float, course: np.ndarray) -> float:
    """A noise at a time or an angle, in units of its RMS."""
    place = at * rate
    whole = np.floor(place)
    first = int(whole) & (course.shape[0] - 1)
    second = (first + 1) & (course.shape[0] - 1)
    noise: float = course[first] + (place - whole) * (course[second] - course[first])
    return noise


@compiled(inline="always")
def contact_ohm(
    x: float, time: float, words: np.ndarray, noise: np.ndarray, flicker: np.ndarray
) -> float:
    """What the brushes add to R at the angle ``x`` in rad and the ``time`` in s, Ω."""
    ohm = 0.0
    if words[RIPPLE] != 0.0:
        ohm += words[RIPPLE] * np.cos(words[SEGMENTS] * x)
    if words[STEP] != 0.0 and int(np.floor((x - words[STEP_AT]) * words[PER_BAR])) & 1 == 0:
        ohm += words[STEP]
    if noise.shape[0]:
        ohm += words[NOISE] * noise_at_place(x, words[PER_RAD], noise)
    if flicker.shape[0]:
        ohm += words[FLICKER] * noise_at_place(time, words[PER_S], flicker)
    return ohm
