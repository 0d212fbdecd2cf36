# SPDX-License-Identifier: Apache-2.0
"""A brushless motor's winding and magnets, in the stationary frame; complex numbers are α + jβ.

    ∫v dt = R ∫i dt + V_d ∫d(i) dt + V_0 t + L i + ψ exp(jp(x − x_m)) + const

The magnets' flux is a function of the place alone, so that no speed is needed, and with p given all
is linear in R, V_d, V_0, L and ψ exp(−jp x_m). p is the one that leaves least. d is what dead time
leaves of each leg, by the sign of its current. Where L_d isn't L_q, L i is of their mean, and
(L_d − L_q)/2 times the mirror image of i at the magnets, i* exp(2jθ), comes to it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wavehaptics.host.identify.inductance import row_ends
from wavehaptics.host.identify.resistance import KNEE_A, UNSETTLED
from wavehaptics.host.identify.segments import SPREADS, Estimate, Fit, Segment, fit

MOST_PAIRS = 60
"""Pole pairs that are looked for."""

_TURN = np.exp(2j * np.pi / 3.0)


NO_SALIENCY = Estimate(0.0, 0.0)


@dataclass(frozen=True)
class Magnets:
    """R and V_d of a phase in Ω and V, ψ in V·s, and the place x_m in rad where θ is 0.

    ``pole_pairs`` is below 0 where the encoder counts against the phases. x_m is within the turn
    of the magnets around 0.
    """

    ohm: Estimate
    dead_v: Estimate
    inductance: Estimate
    flux: Estimate
    pole_pairs: int
    place: Estimate
    clear: float
    """By how many times any other p leaves more, of squares."""
    saliency: Estimate = NO_SALIENCY
    """L_d − L_q, H; 0 where it isn't SPREADS above that."""

    def angle(self, position: np.ndarray) -> np.ndarray:
        """θ at places in rad."""
        return self.pole_pairs * (position - self.place.value)

    def widened(self, part: float) -> Magnets:
        """With R and ψ known to no more than such a part."""
        ohm, flux = self.ohm, self.flux
        return replace(
            self, ohm=ohm.widened(part * ohm.value), flux=flux.widened(part * flux.value)
        )

    @property
    def k_t(self) -> Estimate:
        """Torque for an ampere across the magnets, N·m/A: 1.5 pψ."""
        factor = 1.5 * abs(self.pole_pairs)
        return Estimate(factor * self.flux.value, factor * self.flux.sd)


def magnets(segments: Sequence[Segment]) -> Magnets:
    """Of records in which the rotor turns, with currents in all directions."""
    segments = [s.part(UNSETTLED, len(s.current)) for s in segments]
    wanted = [part for s in segments for part in _both(s.sum(s.voltage))]
    plain = [columns for s in segments for columns in _still(s)]

    def found(pairs: int, mirrored: Sequence[np.ndarray] | None = None) -> Fit:
        more = [[]] * len(plain) if mirrored is None else [[column] for column in mirrored]
        turning = [c for s in segments for c in _turning(pairs * s.turned)]
        columns = [[*a, *m, *b] for a, m, b in zip(plain, more, turning, strict=True)]
        return fit(wanted, columns)

    fits = {n: found(n) for n in range(-MOST_PAIRS, MOST_PAIRS + 1) if n}
    pairs, second = sorted(fits, key=lambda n: fits[n].square)[:2]
    known = _of_fit(fits[pairs], pairs, fits[second].square / fits[pairs].square)
    for _ in range(PASSES):
        mirrored = [part for s in segments for part in _both(_mirrored(s, known))]
        salient = found(pairs, mirrored)
        half = salient.estimate(MIRRORED)
        if abs(half.value) < SPREADS * half.sd:
            break
        known = replace(
            _of_fit(salient, pairs, known.clear), saliency=Estimate(2 * half.value, 2 * half.sd)
        )
    return known


PASSES = 2
"""With the magnets' place, which the mirror takes from the pass before."""

MIRRORED = 5
"""Column of the mirror image, behind those of :func:`_still`."""


def _of_fit(best: Fit, pairs: int, clear: float) -> Magnets:
    along, across = best.factors[-2:]
    flux = math.hypot(along, across)
    covariance = best.covariance[-2:, -2:]
    ray, side = np.array([along, across]) / flux, np.array([-across, along]) / flux
    # ψ exp(−jp x_m) = along + j across.
    place = -math.atan2(across, along) / pairs
    spread = math.sqrt(max(0.0, side @ covariance @ side)) / flux / abs(pairs)
    return Magnets(
        best.estimate(0),
        best.estimate(1),
        best.estimate(2),
        Estimate(flux, math.sqrt(max(0.0, ray @ covariance @ ray))),
        pairs,
        Estimate(place, spread),
        clear,
    )


def _mirrored(s: Segment, known: Magnets) -> np.ndarray:
    mirrored: np.ndarray = np.conj(s.ends) * np.exp(2j * known.angle(s.turned))
    return mirrored


def _both(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return values.real, values.imag


def legs(current: np.ndarray) -> np.ndarray:
    """d of a current: the vector of the signs of its three legs' parts."""
    parts = [np.tanh((current * _TURN**-n).real / KNEE_A) * _TURN**n for n in range(3)]
    found: np.ndarray = 2.0 / 3.0 * np.sum(parts, axis=0)
    return found


def _still(s: Segment) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Columns of R, V_d, L and both V_0, of α and of β."""
    shared = [_both(values) for values in (s.sum(s.current), s.sum(legs(s.current)), s.ends)]
    nothing = np.zeros_like(s.t)
    return ([*(a for a, _ in shared), s.t, nothing], [*(b for _, b in shared), nothing, s.t])


def _turning(angle: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Columns of the flux along and across where θ is ``angle``, of α and of β."""
    return [np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]


def direction(s: Segment) -> complex:
    """That of a step's voltage: of both axes each has its own limit."""
    mean = complex(np.mean(s.voltage))
    return mean / abs(mean)


def seen(s: Segment, way: complex) -> Segment:
    """A record as seen along a direction."""
    turn = np.conj(way)
    return replace(s, voltage=(turn * s.voltage).real, current=(turn * s.current).real)


def along(s: Segment, way: complex, known: Magnets) -> Segment:
    """As :func:`seen`, without the magnets' voltage and the dead time's."""
    flux = known.flux.value * np.exp(1j * known.angle(s.position))
    moved = np.diff(flux, prepend=flux[:1]) / s.step_s
    voltage = s.voltage - moved - known.dead_v.value * legs(s.current)
    return seen(replace(s, voltage=voltage), way)


def across(s: Segment, known: Magnets) -> Segment:
    """A record with the current that makes the torque, A, in place of both axes' ones.

    What L_d − L_q makes of both currents is torque as well.
    """
    sign = math.copysign(1.0, known.pole_pairs)
    current = s.current * np.exp(-1j * known.angle(s.angle))
    more = 1.0 + known.saliency.value * current.real / known.flux.value
    return replace(s, voltage=s.voltage.real, current=sign * more * current.imag)


def inductances(
    rises: Sequence[Segment], known: Magnets, ways: Sequence[complex], firsts: Sequence[int]
) -> tuple[Estimate, Estimate]:
    """L_q and L_d in H, of steps along directions: ``rises`` as :func:`along` has them.

    Seen at δ from the magnets L is (L_d + L_q)/2 + (L_d − L_q)/2 cos 2δ. R is free. Both are the
    same where they aren't SPREADS apart.
    """
    wanted, columns = [], []
    for s, way, first in zip(rises, ways, firsts, strict=True):
        apart = np.angle(way) - float(known.angle(s.position[:1])[0])
        ends = row_ends(s)[first:]
        wanted.append(s.sum(s.voltage)[first:])
        columns.append([ends, s.sum(s.current)[first:], ends * math.cos(2.0 * apart)])
    found, alike = fit(wanted, columns), fit(wanted, [table[:2] for table in columns]).estimate(0)
    difference = found.estimate(2)
    if abs(difference.value) < SPREADS * difference.sd:
        return alike, alike
    mean, half = found.factors[[0, 2]]
    covariance = found.covariance[np.ix_([0, 2], [0, 2])]

    def value(sign: float) -> Estimate:
        along_axis = np.array([1.0, sign])
        return Estimate(float(mean + sign * half), math.sqrt(along_axis @ covariance @ along_axis))

    return value(-1.0), value(1.0)
