# SPDX-License-Identifier: Apache-2.0
"""A brushless motor: three phases in star, in the stationary frame αβ, and a rotor with magnets.

The frame is amplitude-invariant, a vector is as long as the phases' amplitude, so that torque and
power are 3/2 of the products. With the electrical angle ``θ = p (x − magnet_rad)``, d = (cos θ,
sin θ) along the magnets and q a quarter turn ahead,

    e = R i + L_q di/dt + d/dt ((L_d − L_q) d (d·i)) + pψ g(θ) ω
    J dω/dt = 3/2 pψ g·i + 3/2 p (L_d − L_q) i_d i_q − b ω − τ_c − cogging − F_H

``g = q`` for a sinusoidal back-EMF; the harmonics of a phase turn backwards (5th) and forwards
(7th) as vectors.

A step holds the rotor's angle at its middle and takes what the rotor induces as a constant voltage
E. Each axis is then linear by itself, whatever circuit drives it, and exact by a tabulated matrix
exponential, in which E's part is linear. The mean speed follows by the trapezoidal rule from the
mean currents, and E from the mean speed: one equation, or two with L_d ≠ L_q. As E times the mean
current is the torque times the mean speed, a step neither makes nor loses energy; it is of second
order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from wavehaptics.motor.cogging import PER_REV, TORQUE, cogging_torque, cogging_words
from wavehaptics.motor.plant import (
    FRICTION_STEP_S,
    HAND_B,
    HAND_K,
    K_T,
    OMEGA,
    PART_OF_CABLE,
    STATE_SIZE,
    TIME,
    C,
    I,
    P,
    Plant,
    R,
    S,
    X,
    end_ramp,
    friction_torque,
    load_words,
    settle_friction,
)
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene

I_A, I_B, F_A, F_B, Q_A, Q_B, QF_A, QF_B, IMPULSE, ENERGY = range(STATE_SIZE, STATE_SIZE + 10)
"""Places of the state behind those of a plant, whose I is what the torque is k_T times of: currents
of both axes in A; what drives each, V or a circuit's f; sums since the caller set them to 0: of the
currents, A·s, and of what drives, of the torque, N·m·s, and of (e − R i)·i in both axes, J."""
SIZE = ENERGY + 1

MOTION_STEP_S = 20e-6
"""Longest step: the angle is held over it."""
PART_OF_WINDING = 0.1
"""Longest step in parts of L/R."""
ROUNDS = 2
"""Times that a step with L_d ≠ L_q is solved; the first takes the current at its beginning."""

NEXT_I, NEXT_F, CHARGE, DRIVEN = range(4)
"""Rows of an axis' table: i and f after the step, ∫i dt and ∫f dt."""
OF_I, OF_F, OF_E = range(3)
"""Its columns: of i and f before the step, and of E."""
DURATION, COS, SIN = range(3)
"""Places in what a step is besides, :meth:`BrushlessPlant.step_words`."""

(
    INERTIA, VISCOUS, K_E, PAIRS, MAGNET, HARMONIC_5, HARMONIC_7, L_Q, DELTA_L, COGGING,
    COGGING_PER_REV,
) = range(6, 17)  # fmt: skip
"""Places in :meth:`BrushlessPlant.words` behind those of a plant's ``load_words``."""


@dataclass(frozen=True)
class BrushlessPlant:
    """Constants of one scene's brushless motor; its load and hand are those of ``plant``."""

    plant: Plant
    k_e: float
    pole_pairs: int
    magnet_rad: float
    harmonics: tuple[float, float]
    l_d_part: float

    @classmethod
    def of_scene(cls, scene: Scene) -> BrushlessPlant:
        """Plant of a scene whose motor is a ``pmsm``."""
        motor = scene.motor
        assert motor.pole_pairs is not None
        return cls(
            Plant.of_scene(scene),
            motor.k_e,
            motor.pole_pairs,
            motor.magnet_rad,
            (motor.harmonic_5, motor.harmonic_7),
            motor.l_d_part,
        )

    @property
    def start(self) -> np.ndarray:
        """State at t = 0, shape (SIZE,)."""
        state = np.zeros(SIZE)
        state[:STATE_SIZE] = self.plant.start
        return state

    @property
    def longest_step_s(self) -> float:
        """Longest step that is exact enough, s."""
        plant = self.plant
        inductance = plant.inductance * min(1.0, self.l_d_part)
        spring = plant.hand_stiffness + 1.5 * self.k_e**2 / inductance
        if plant.cogging is not None:
            spring += plant.cogging.torque_nm * plant.cogging.per_rev
        longest = min(
            MOTION_STEP_S,
            PART_OF_WINDING * inductance / plant.resistance,
            PART_OF_CABLE * math.sqrt(plant.inertia / spring),
        )
        if plant.coulomb > 0.0:
            longest = min(longest, FRICTION_STEP_S)
        damper = plant.hand_damping + plant.viscous
        return min(longest, PART_OF_CABLE * plant.inertia / damper) if damper else longest

    def substeps(self, step_s: float) -> int:
        """Into how many equal parts a step of ``step_s`` is cut for :attr:`longest_step_s`."""
        return max(1, math.ceil(step_s / self.longest_step_s))

    def axis_table(
        self, step_s: float, gain: float = 1.0, lambda_: float = 0.0, eta: float = 0.0,
        s: float = 0.0,
    ) -> np.ndarray:  # fmt: skip
        """Table of an axis for a step of ``step_s``, float64 (4, 3).

        It is driven by ``gain`` times f, of which ``df/dt = λ((η − 1) f − η s i)``, the analog
        circuit's; with ``lambda_`` 0 f stays as it is: a voltage.
        """
        i, f, e, q, qf = range(5)
        a = np.zeros((5, 5))
        a[i, i] = -self.plant.resistance / self.plant.inductance
        a[i, f] = gain / self.plant.inductance
        a[i, e] = -1.0 / self.plant.inductance
        a[f, f] = lambda_ * (eta - 1.0)
        a[f, i] = -lambda_ * eta * s
        a[q, i] = a[qf, f] = 1.0
        return np.ascontiguousarray(expm(a * step_s)[[i, f, q, qf], :3])

    def step_words(self, step_s: float) -> np.ndarray:
        """Length of a step in s, and by what the hand's oscillation turns in it."""
        turn = self.plant.hand_omega * step_s
        return np.array([step_s, math.cos(turn), math.sin(turn)])

    def words(self) -> np.ndarray:
        """Constants that a step needs besides its tables, SI units."""
        plant = self.plant
        cogging = cogging_words(plant.cogging)
        delta = (self.l_d_part - 1.0) * plant.inductance
        own = [
            plant.inertia, plant.viscous, self.k_e, self.pole_pairs, self.magnet_rad,
            *self.harmonics, plant.inductance, delta, cogging[TORQUE], cogging[PER_REV],
        ]  # fmt: skip
        return np.concatenate([load_words(plant), own])


@compiled(inline="always")
def electrical_angle(x: float, load: np.ndarray) -> float:
    """θ of a rotor at ``x``, rad."""
    theta: float = load[PAIRS] * (x - load[MAGNET])
    return theta


@compiled(inline="always")
def along_q(alpha: float, beta: float, theta: float) -> float:
    """Part of a vector along q."""
    return math.cos(theta) * beta - math.sin(theta) * alpha


@compiled(inline="always")
def _shape(theta: float, load: np.ndarray) -> tuple[float, float]:
    """g, the back-EMF of both axes over that of a sinusoidal phase's amplitude."""
    alpha, beta = -math.sin(theta), math.cos(theta)
    if load[HARMONIC_5] != 0.0:
        alpha -= load[HARMONIC_5] * math.sin(5.0 * theta)
        beta -= load[HARMONIC_5] * math.cos(5.0 * theta)
    if load[HARMONIC_7] != 0.0:
        alpha -= load[HARMONIC_7] * math.sin(7.0 * theta)
        beta += load[HARMONIC_7] * math.cos(7.0 * theta)
    return alpha, beta


@compiled(inline="always")
def brushless_step(
    z: np.ndarray, table_a: np.ndarray, table_b: np.ndarray, step: np.ndarray, load: np.ndarray
) -> None:
    """Advance the state by ``step``, each axis by its own table; all are those of a plant."""
    dt = step[DURATION]
    i_a, i_b, f_a, f_b = z[I_A], z[I_B], z[F_A], z[F_B]
    omega, x, p, r, c, s = z[OMEGA], z[X], z[P], z[R], z[C], z[S]
    middle = x + 0.5 * dt * omega
    theta = electrical_angle(middle, load)
    shape_a, shape_b = _shape(theta, load)
    emf_a, emf_b = load[K_E] * shape_a, load[K_E] * shape_b
    pull_a, pull_b = emf_a, emf_b  # 2/3 of the torque for an ampere
    cogging = cogging_torque(middle, load[COGGING:])
    tau = friction_torque(z, load, cogging)

    last_a = table_a[NEXT_I, OF_I] * i_a + table_a[NEXT_I, OF_F] * f_a
    last_b = table_b[NEXT_I, OF_I] * i_b + table_b[NEXT_I, OF_F] * f_b
    charge_a = table_a[CHARGE, OF_I] * i_a + table_a[CHARGE, OF_F] * f_a
    charge_b = table_b[CHARGE, OF_I] * i_b + table_b[CHARGE, OF_F] * f_b
    less_a, less_b = table_a[CHARGE, OF_E], table_b[CHARGE, OF_E]
    drop_a, drop_b = table_a[NEXT_I, OF_E], table_b[NEXT_I, OF_E]

    p_next = p + r * dt
    c_next = step[COS] * c - step[SIN] * s
    s_next = step[SIN] * c + step[COS] * s
    hand = 0.5 * (p + c + p_next + c_next)
    hand_speed = (p_next + c_next - p - c) / dt
    push = (
        2.0 * load[INERTIA] * omega / dt - tau - cogging
        - load[HAND_K] * (x - hand) + load[HAND_B] * hand_speed
    )  # fmt: skip
    against = 2.0 * load[INERTIA] / dt + load[VISCOUS] + load[HAND_B] + 0.5 * dt * load[HAND_K]
    part = 1.5 / dt
    if load[DELTA_L] == 0.0:
        mean = push + part * (pull_a * charge_a + pull_b * charge_b)
        mean /= against - part * (pull_a * less_a * emf_a + pull_b * less_b * emf_b)
        e_a, e_b = mean * emf_a, mean * emf_b
    else:
        d_a, d_b = math.cos(theta), math.sin(theta)
        delta = load[DELTA_L] / dt
        mean_a, mean_b = i_a, i_b
        mean = e_a = e_b = 0.0
        for _ in range(ROUNDS):
            i_d = load[PAIRS] * load[DELTA_L] * (d_a * mean_a + d_b * mean_b)
            i_q = load[PAIRS] * load[DELTA_L] * (d_a * mean_b - d_b * mean_a)
            turn_a, turn_b = d_a * i_q - d_b * i_d, d_b * i_q + d_a * i_d
            emf_a, emf_b = load[K_E] * shape_a + turn_a, load[K_E] * shape_b + turn_b
            pull_a, pull_b = emf_a - 0.5 * turn_a, emf_b - 0.5 * turn_b
            # Of ω̄ and of w, the voltage along d: w = ΔL d·(change of i)/dt.
            speed_speed = against - part * (pull_a * less_a * emf_a + pull_b * less_b * emf_b)
            speed_w = -part * (pull_a * less_a * d_a + pull_b * less_b * d_b)
            w_speed = -delta * (d_a * drop_a * emf_a + d_b * drop_b * emf_b)
            w_w = 1.0 - delta * (d_a * drop_a * d_a + d_b * drop_b * d_b)
            torque = push + part * (pull_a * charge_a + pull_b * charge_b)
            change = delta * (d_a * (last_a - i_a) + d_b * (last_b - i_b))
            scale = 1.0 / (speed_speed * w_w - speed_w * w_speed)
            mean = (torque * w_w - speed_w * change) * scale
            w = (speed_speed * change - w_speed * torque) * scale
            e_a, e_b = mean * emf_a + w * d_a, mean * emf_b + w * d_b
            mean_a, mean_b = (charge_a + less_a * e_a) / dt, (charge_b + less_b * e_b) / dt
    last_a += drop_a * e_a
    last_b += drop_b * e_b
    charge_a += less_a * e_a
    charge_b += less_b * e_b

    stored = last_a * last_a + last_b * last_b - i_a * i_a - i_b * i_b
    z[ENERGY] += 1.5 * (0.5 * load[L_Q] * stored + e_a * charge_a + e_b * charge_b)
    z[IMPULSE] += 1.5 * (pull_a * charge_a + pull_b * charge_b)
    z[Q_A] += charge_a
    z[Q_B] += charge_b
    z[QF_A] += (
        table_a[DRIVEN, OF_I] * i_a + table_a[DRIVEN, OF_F] * f_a + table_a[DRIVEN, OF_E] * e_a
    )
    z[QF_B] += (
        table_b[DRIVEN, OF_I] * i_b + table_b[DRIVEN, OF_F] * f_b + table_b[DRIVEN, OF_E] * e_b
    )
    z[F_A] = table_a[NEXT_F, OF_I] * i_a + table_a[NEXT_F, OF_F] * f_a + table_a[NEXT_F, OF_E] * e_a
    z[F_B] = table_b[NEXT_F, OF_I] * i_b + table_b[NEXT_F, OF_F] * f_b + table_b[NEXT_F, OF_E] * e_b
    z[I_A], z[I_B] = last_a, last_b
    z[I] = 1.5 * (pull_a * last_a + pull_b * last_b) / load[K_T]
    z[OMEGA] = 2.0 * mean - omega
    z[X] = x + dt * mean
    settle_friction(z, omega, x, tau, load)
    z[P], z[C], z[S] = p_next, c_next, s_next
    z[TIME] += dt
    end_ramp(z, z[TIME], load)
