# SPDX-License-Identifier: Apache-2.0
"""The motor with its load, advanced exactly between two switching instants.

``e_a = R i + L di/dt + k_T ω`` and ``J dω/dt = k_T i − b ω − τ_c − F_H``, with the hand's torque
``F_H = K_h (x − x_h) + B_h (ω − dx_h/dt)``; J is the rotor's with what is fixed to it, the mass of
a hand that holds it as well. For a constant voltage and a constant Coulomb torque
τ_c this is linear, the hand's path included, so a step of any length is one product with a
tabulated matrix exponential. Only Coulomb friction has to be looked at between steps.
What else a scene says of a real motor is in :mod:`wavehaptics.motor.step`, which steps it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from wavehaptics.motor.hand import hand_path
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene
from wavehaptics.scene.tables.brushes import Brushes
from wavehaptics.scene.tables.cogging import Cogging
from wavehaptics.scene.tables.transmission import Transmission
from wavehaptics.scene.tables.winding import Winding

I, OMEGA, X, P, R, C, S, E, TAU = range(9)  # noqa: E741
"""Places of the augmented state: motor, hand (:mod:`wavehaptics.motor.hand`), voltage, friction."""
Q = 9
"""Place of the charge ∫i dt, which drives nothing."""
SIZE = 10

STATE_SIZE = 8
"""Length of a plant's state vector: i, ω, x, p, r, c, s and the time t."""
TIME = 7

FRICTION_STEP_S = 20e-6
"""Longest step with Coulomb friction: its sign is held over a step."""

PART_OF_SLOPE = 0.5
"""Longest step with brushes or eddy currents, in parts of L over their steepest resistance."""
PART_OF_SATURATION = 0.25
"""Longest step where L falls, in parts of that of the full L."""
PARTS_OF_NOISE = 8
"""Steps within the correlation time of the brushes' noise over time, at least."""
PART_OF_CABLE = 0.05
"""Longest step in parts of the time constants of the rotor on its cable and of its cogging."""


@dataclass(frozen=True)
class Plant:
    """Constants of one scene's motor, load and hand, SI units."""

    resistance: float
    inductance: float
    k_t: float
    inertia: float
    coulomb: float
    viscous: float
    hand_stiffness: float
    hand_damping: float
    hand_omega: float
    ramp_end_s: float
    start: np.ndarray
    """State at t = 0, shape (STATE_SIZE,)."""
    brushes: Brushes | None = None
    winding: Winding | None = None
    cogging: Cogging | None = None
    cable: Transmission | None = None
    """Transmission with a cable; the hand's spring and damper are then behind it."""
    cable_hand_stiffness: float = 0.0
    cable_hand_damping: float = 0.0
    cable_end_inertia: float = 0.0
    """Mass of a hand that holds the cable's end, kg·m²; one that holds the rotor is in its J."""
    sag_ohm: float = 0.0

    @classmethod
    def of_scene(cls, scene: Scene) -> Plant:
        """Plant of a scene; what the scene doesn't mention is zero.

        ``inductance`` is what lies in series: without the part that eddy currents bypass.
        """
        path = hand_path(scene)
        friction, hand, winding = scene.friction, scene.hand, scene.winding
        bypassed = 0.0
        if winding and winding.eddy_ohm is not None and winding.eddy_part is not None:
            bypassed = winding.eddy_part
        start = np.zeros(STATE_SIZE)
        start[OMEGA], start[X] = path.v0, path.x0
        held = hand is not None and hand.path != "impact"
        stiffness, damping = 0.0, 0.0
        if hand is not None and hand.path != "impact":
            start[P : S + 1] = path.start
            stiffness, damping = hand.stiffness or 0.0, hand.damping
        cable = scene.transmission
        if cable is not None and cable.cable_stiffness is None:
            cable = None
        direct = cable is None
        mass = hand.inertia_kgm2 if hand is not None else 0.0
        load = scene.load.inertia_kgm2 if scene.load else 0.0
        return cls(
            resistance=scene.motor.R_ohm,
            inductance=scene.motor.L_h * (1.0 - bypassed),
            k_t=scene.motor.k_t,
            inertia=scene.motor.J_kgm2 + load + (mass if direct else 0.0),
            coulomb=friction.coulomb_nm if friction else 0.0,
            viscous=friction.viscous if friction else 0.0,
            hand_stiffness=stiffness if direct else 0.0,
            hand_damping=damping if direct else 0.0,
            hand_omega=path.omega,
            ramp_end_s=path.ramp_end_s if held else math.inf,
            start=start,
            brushes=scene.brushes,
            winding=winding,
            cogging=scene.cogging,
            cable=cable,
            cable_hand_stiffness=0.0 if direct else stiffness,
            cable_hand_damping=0.0 if direct else damping,
            cable_end_inertia=0.0 if direct else mass,
            sag_ohm=scene.drive.sag_ohm if scene.drive else 0.0,
        )

    @property
    def real(self) -> bool:
        """Whether there is anything that the matrix exponential alone can't step."""
        parts = (self.brushes, self.winding, self.cogging, self.cable)
        return self.sag_ohm > 0.0 or any(part is not None for part in parts)

    def matrix(self) -> np.ndarray:
        """A of ``z' = A z`` for the augmented state z, shape (SIZE, SIZE)."""
        a = np.zeros((SIZE, SIZE))
        a[I, I] = -self.resistance / self.inductance
        a[I, OMEGA] = -self.k_t / self.inductance
        a[I, E] = 1 / self.inductance
        a[OMEGA, I] = self.k_t / self.inertia
        a[OMEGA, OMEGA] = -(self.viscous + self.hand_damping) / self.inertia
        a[OMEGA, X] = -self.hand_stiffness / self.inertia
        a[OMEGA, P] = a[OMEGA, C] = self.hand_stiffness / self.inertia
        a[OMEGA, R] = self.hand_damping / self.inertia
        a[OMEGA, S] = -self.hand_omega * self.hand_damping / self.inertia
        a[OMEGA, TAU] = -1 / self.inertia
        a[X, OMEGA] = 1
        a[P, R] = 1
        a[C, S] = -self.hand_omega
        a[S, C] = self.hand_omega
        a[Q, I] = 1
        return a

    def transition(self, step_s: float) -> np.ndarray:
        """Rows i, ω, x and ∫i dt, then c and s, of ``expm(A step_s)``: shape (6, 9)."""
        full = expm(self.matrix() * step_s)
        return np.ascontiguousarray(full[[I, OMEGA, X, Q, C, S], :Q])

    @property
    def longest_step_s(self) -> float:
        """Longest step that keeps friction and ∫i² dt exact enough, s.

        ∫i² dt takes the current as a parabola within a step: a tenth of the electrical time
        constant leaves an error below 1e-7 of it.
        """
        longest = 0.1 * self.inductance / self.resistance
        if self.coulomb > 0:
            longest = min(longest, FRICTION_STEP_S)
        return min(longest, self._longest_real_step_s) if self.real else longest

    @property
    def _longest_real_step_s(self) -> float:
        """Longest step for what isn't linear, s."""
        brushes, winding, cable = self.brushes, self.winding, self.cable
        slope, longest = self.resistance + self.sag_ohm, math.inf
        if brushes is not None:
            slope += brushes.drop_v / brushes.knee_a
            if brushes.flicker_noise:
                longest = brushes.flicker_s / PARTS_OF_NOISE
        if winding is not None and winding.eddy_ohm is not None:
            slope += winding.eddy_ohm
        longest = min(longest, PART_OF_SLOPE * self.inductance / slope)
        if winding is not None and winding.saturation_a is not None:
            longest *= PART_OF_SATURATION
        spring, damper = 0.0, 0.0
        if cable is not None:
            spring, damper = cable.cable_stiffness or 0.0, cable.cable_damping
        if self.cable_end_inertia:
            held = spring + self.cable_hand_stiffness
            longest = min(longest, PART_OF_CABLE * math.sqrt(self.cable_end_inertia / held))
        if self.cogging is not None:
            spring += self.cogging.torque_nm * self.cogging.per_rev
        if spring:
            longest = min(longest, PART_OF_CABLE * math.sqrt(self.inertia / spring))
        return min(longest, PART_OF_CABLE * self.inertia / damper) if damper else longest

    def substeps(self, step_s: float) -> int:
        """Into how many equal parts a step of ``step_s`` is cut for :attr:`longest_step_s`."""
        return max(1, math.ceil(step_s / self.longest_step_s))


COULOMB, K_T, HAND_K, HAND_B, HAND_OMEGA, RAMP_END = range(6)
"""Places in the constants that a step needs besides its matrix: :func:`load_words`."""


@compiled(inline="always")
def friction_torque(state: np.ndarray, load: np.ndarray, besides: float = 0.0) -> float:
    """Coulomb torque τ_c of the coming step, N·m: against the motion, or what holds the rotor.

    ``besides`` is what else acts against the rotor, N·m.
    """
    coulomb: float = load[COULOMB]
    if coulomb == 0.0:
        return 0.0
    if state[OMEGA] > 0.0:
        return coulomb
    if state[OMEGA] < 0.0:
        return -coulomb
    drive: float = (
        load[K_T] * state[I]
        - load[HAND_K] * (state[X] - state[P] - state[C])
        + load[HAND_B] * (state[R] - load[HAND_OMEGA] * state[S])
        - besides
    )
    return min(max(drive, -coulomb), coulomb)


@compiled(inline="always")
def settle_friction(
    state: np.ndarray, omega: float, x: float, tau: float, load: np.ndarray
) -> None:
    """Stop the rotor where friction stops it; ``omega``, ``x`` and ``tau`` are the step's first."""
    if load[COULOMB] == 0.0:
        return
    if omega == 0.0 and abs(tau) < load[COULOMB]:
        state[OMEGA] = 0.0
        state[X] = x
    elif omega * state[OMEGA] < 0.0:
        state[OMEGA] = 0.0


@compiled(inline="always")
def end_ramp(state: np.ndarray, time: float, load: np.ndarray) -> None:
    """Stop the hand at the end of its ramp."""
    if time >= load[RAMP_END] and state[R] != 0.0:
        state[P] -= state[R] * (time - load[RAMP_END])
        state[R] = 0.0


@compiled(inline="always")
def linear_step(state: np.ndarray, m: np.ndarray, e: float, tau: float) -> float:
    """Advance the state by the step that ``m`` was made for; returns ∫i dt over it, A·s."""
    i, omega, x = state[I], state[OMEGA], state[X]
    p, r, c, s = state[P], state[R], state[C], state[S]
    state[I] = (
        m[0, 0] * i + m[0, 1] * omega + m[0, 2] * x + m[0, 3] * p + m[0, 4] * r
        + m[0, 5] * c + m[0, 6] * s + m[0, 7] * e + m[0, 8] * tau
    )  # fmt: skip
    state[OMEGA] = (
        m[1, 0] * i + m[1, 1] * omega + m[1, 2] * x + m[1, 3] * p + m[1, 4] * r
        + m[1, 5] * c + m[1, 6] * s + m[1, 7] * e + m[1, 8] * tau
    )  # fmt: skip
    state[X] = (
        m[2, 0] * i + m[2, 1] * omega + m[2, 2] * x + m[2, 3] * p + m[2, 4] * r
        + m[2, 5] * c + m[2, 6] * s + m[2, 7] * e + m[2, 8] * tau
    )  # fmt: skip
    state[C] = m[4, 5] * c + m[4, 6] * s
    state[S] = m[5, 5] * c + m[5, 6] * s
    charge: float = (
        m[3, 0] * i + m[3, 1] * omega + m[3, 2] * x + m[3, 3] * p + m[3, 4] * r
        + m[3, 5] * c + m[3, 6] * s + m[3, 7] * e + m[3, 8] * tau
    )  # fmt: skip
    return charge


@compiled(inline="always")
def plant_step(
    state: np.ndarray, m: np.ndarray, step_s: float, e: float, load: np.ndarray,
    besides: float = 0.0,
) -> tuple[float, float]:  # fmt: skip
    """One step of ``step_s`` (the step of ``m``) at the voltage ``e``; updates ``state``.

    ``load`` is :func:`load_words` of the plant, and ``besides`` what else acts against the rotor,
    N·m. Returns (∫i dt in A·s, ∫i² dt in A²·s).
    """
    i, omega, x = state[I], state[OMEGA], state[X]
    tau = friction_torque(state, load, besides)
    charge = linear_step(state, m, e, tau + besides)
    settle_friction(state, omega, x, tau, load)
    state[P] += state[R] * step_s
    state[TIME] += step_s
    end_ramp(state, state[TIME], load)
    return charge, square_integral(i, state[I], charge, step_s)


@compiled(inline="always")
def square_integral(first: float, last: float, area: float, step_s: float) -> float:
    """∫y² dt of the parabola with the given ends and the given ∫y dt."""
    mean = area / step_s
    curve = 3.0 * (first + last) - 6.0 * mean
    slope = last - first - curve
    variance = slope * slope / 12.0 + slope * curve / 6.0 + curve * curve * (4.0 / 45.0)
    return step_s * (mean * mean + variance)


def load_words(plant: Plant) -> np.ndarray:
    """Constants of a step: friction, k_T, the hand's K, B and Ω, and its ramp's end, SI units."""
    return np.array(
        [
            plant.coulomb,
            plant.k_t,
            plant.hand_stiffness,
            plant.hand_damping,
            plant.hand_omega,
            plant.ramp_end_s,
        ]
    )
