# SPDX-License-Identifier: Apache-2.0
"""R and the brushes' voltage, by pulses of several currents either way.

    ∫v dt = R ∫i dt + V_b ∫sgn(i) dt + V_0 t + k_T x + L i + ∫ i (c cos nθ + d sin nθ) dt + const.

x is the encoder's, so that the back-EMF of a rotor that the pulses turn is known. What dead time
leaves over goes by the sign of the current as well and is in V_b; an offset of the voltage, or of
the current times R, is V_0. R(θ) is looked for as one harmonic of the angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wavehaptics.host.identify.segments import Estimate, Segment, best_harmonic, fit, harmonics

KNEE_A = 0.005
"""Current at which the brushes' voltage bends: a scene's default. Pulses are far above it."""

UNSETTLED = 4
"""Rows in which the current still changes: between two of its means it is no straight line."""

LEAST_OHM, MOST_OHM = 0.05, 100.0
"""R of a motor."""


@dataclass(frozen=True)
class Resistance:
    """R in Ω and V_b in V; of R(θ) the ripple, a part of R, with its periods a revolution or 0."""

    ohm: Estimate
    drop_v: Estimate
    offset_v: Estimate
    segments: int
    ripple: Estimate
    k_t: Estimate
    inductance: Estimate
    waves: tuple[float, float] = (0.0, 0.0)
    """Factors of cos and sin of the ripple, Ω."""

    def ohms(self, angle: np.ndarray) -> np.ndarray:
        """R at angles in rad."""
        along, across = self.waves
        phase = self.segments * angle
        ohms: np.ndarray = self.ohm.value + along * np.cos(phase) + across * np.sin(phase)
        return ohms


def rough(segments: Sequence[Segment]) -> Resistance:
    """Of records of voltage steps as they rise, in which the rotor hardly turns."""
    found = fit([s.sum(s.voltage) for s in segments], [_still(s) for s in segments])
    none = Estimate(0.0, 0.0)
    return Resistance(
        found.estimate(0), found.estimate(1), none, 0, none, none, found.estimate(2)
    )  # fmt: skip


def resistance(segments: Sequence[Segment]) -> Resistance:
    """Of pulses of at least two currents both ways; records are SI, angles in rad."""
    segments = [s.part(UNSETTLED, len(s.current)) for s in segments]
    wanted = [s.sum(s.voltage) for s in segments]
    columns = [[*_still(s), s.t, s.turned] for s in segments]
    pairs = []
    for s in segments:
        waves = harmonics(s.angle) * s.current[:, None, None]
        pairs.append(s.step_s * np.cumsum(waves[: len(s)], axis=0))
    wave = best_harmonic(wanted, columns, pairs)
    bars, found = wave.periods, wave.fit
    ohm = found.estimate(0)
    ripple = Estimate(wave.size.value / ohm.value, wave.size.sd / ohm.value)
    along, across = map(float, found.factors[-2:]) if bars else (0.0, 0.0)
    return Resistance(
        ohm, found.estimate(1), found.estimate(3), bars, ripple, found.estimate(4),
        found.estimate(2), (along, across),
    )  # fmt: skip


def _still(s: Segment) -> list[np.ndarray]:
    """Columns of R, V_b and L."""
    return [s.sum(s.current), s.sum(np.tanh(s.current / KNEE_A)), s.ends]
