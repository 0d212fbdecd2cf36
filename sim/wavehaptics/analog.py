# SPDX-License-Identifier: Apache-2.0
"""The controller ``analog``: the paper's circuit in continuous time, the reference of all others.

``v = u − s·i``, ``df/dt = λ(η v − f)``, ``u`` is f within the voltage limit, ``e_a = s·u``. With
the motor this is linear as long as neither η nor the limit changes, so a step is one product with a
matrix exponential; the instant at which one of them does change is found by bisection.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from wavehaptics import formats, physics
from wavehaptics.compiled import compiled
from wavehaptics.plant import (
    OMEGA,
    TAU,
    C,
    E,
    I,
    P,
    Plant,
    Q,
    X,
    end_ramp,
    friction_torque,
    load_words,
    settle_friction,
    square_integral,
)
from wavehaptics.plant import SIZE as PLANT_SIZE
from wavehaptics.scene import Scene, drive_gain
from wavehaptics.settings import settings
from wavehaptics.shaper import refuse_shaper
from wavehaptics.thermal import Winding
from wavehaptics.trace import Column

F = E
"""The filter's f stands where the plant has its voltage: e_a = s·f."""
QF = PLANT_SIZE
"""∫f dt, for the mean voltage."""
SIZE = PLANT_SIZE + 1

FREE, CONTACT, LIMITED = range(3)
"""Matrices of the three linear circuits: free space, contact, f held at the limit."""

HALVINGS = 24
"""The steps at hand are the regular one and its halves, quarters, ... down to 2⁻²⁴ of it."""
_MODE_CHANGES = 8

# Places in the loop's float parameters.
_DT, _CELL, _S, _GAIN, _K_T, _RESISTANCE, _U_MAX, _ETA_CONTACT, _ETA_FREE = range(9)
# Places in what the loop keeps: wall side of the rotor, sign of the limit that holds f, time.
_TOUCHING, _SIDE, _TIME = range(3)


def circuit_matrices(plant: Plant, lambda_: float, s: float, gain: float, etas) -> np.ndarray:
    """A of ``z' = A z`` for the circuits FREE, CONTACT and LIMITED: (3, SIZE, SIZE).

    ``etas`` holds η of free space and of contact, ``gain`` is what the drive gives for 1 V.
    """
    matrices = np.zeros((3, SIZE, SIZE))
    matrices[:, :PLANT_SIZE, :PLANT_SIZE] = plant.matrix()
    matrices[:, I, F] *= gain * s
    matrices[:, QF, F] = 1.0
    for n, eta in enumerate(etas):
        matrices[n, F, F] = lambda_ * (eta - 1.0)
        matrices[n, F, I] = -lambda_ * eta * s
    return matrices


@compiled()
def _inside(x, wall_min, wall_max):
    for n in range(wall_min.shape[0]):
        if wall_min[n] <= x < wall_max[n]:
            return True
    return False


@compiled()
def _outward(z, kept, floats):
    """How far the filter's goal η·v lies beyond the limit that holds f, √W."""
    eta = floats[_ETA_CONTACT] if kept[_TOUCHING] else floats[_ETA_FREE]
    return kept[_SIDE] * (eta * (z[F] - floats[_S] * z[I]) - z[F])


@compiled()
def _consistent(z, kept, floats, wall_min, wall_max):
    """Whether the state still belongs to the circuit that it is advanced with."""
    if _inside(z[X], wall_min, wall_max) != (kept[_TOUCHING] != 0.0):
        return False
    if kept[_SIDE] == 0.0:
        return abs(z[F]) <= floats[_U_MAX]
    return _outward(z, kept, floats) >= 0.0


@compiled()
def _switch(z, kept, floats, wall_min, wall_max):
    """Choose the circuit that the state belongs to."""
    kept[_TOUCHING] = 1.0 if _inside(z[X], wall_min, wall_max) else 0.0
    if kept[_SIDE] == 0.0 and abs(z[F]) > floats[_U_MAX]:
        kept[_SIDE] = 1.0 if z[F] > 0.0 else -1.0
        z[F] = kept[_SIDE] * floats[_U_MAX]
    if kept[_SIDE] != 0.0 and _outward(z, kept, floats) < 0.0:
        kept[_SIDE] = 0.0


@compiled()
def _circuit(kept):
    if kept[_SIDE] != 0.0:
        return LIMITED
    return CONTACT if kept[_TOUCHING] else FREE


@compiled()
def _product(matrix, z, out):
    for row in range(z.shape[0]):
        total = 0.0
        for column in range(z.shape[0]):
            total += matrix[row, column] * z[column]
        out[row] = total


@compiled()
def _part(z, trial, kept, floats, wall_min, wall_max, steps):
    """Advance z by one regular step, through every change of circuit in it.

    Time is counted in the finest of the tabulated steps. Ever smaller ones are taken while the next
    would leave the circuit that holds, until the finest does: there the circuit changes. ``trial``
    is room for a state.
    """
    left = 1 << HALVINGS
    order = HALVINGS
    changes = 0
    _switch(z, kept, floats, wall_min, wall_max)
    while left > 0:
        while 1 << order > left:
            order -= 1
        _product(steps[_circuit(kept), order], z, trial)
        free = changes < _MODE_CHANGES
        stays = not free or _consistent(trial, kept, floats, wall_min, wall_max)
        if not stays and order > 0:
            order -= 1
            continue
        for n in range(z.shape[0]):  # `z[:] =` would compile messages about shapes, for seconds
            z[n] = trial[n]
        left -= 1 << order
        if not stays:
            _switch(z, kept, floats, wall_min, wall_max)
            changes += 1
            order = HALVINGS


@compiled()
def _advance(rows, z, trial, kept, wall_min, wall_max, floats, substeps, load, steps):
    dt = floats[_DT]
    tick = dt * substeps
    for n in range(rows.shape[0]):
        x_before, hand_before, t_before = z[X], z[P] + z[C], kept[_TIME]
        charge, wave, square, work = 0.0, 0.0, 0.0, 0.0
        low, high = z[I], z[I]
        for _ in range(substeps):
            i, omega, x, f = z[I], z[OMEGA], z[X], z[F]
            tau = friction_torque(z, load)
            z[TAU] = tau
            z[Q] = 0.0
            z[QF] = 0.0
            _part(z, trial, kept, floats, wall_min, wall_max, steps)
            settle_friction(z, omega, x, tau, load)
            kept[_TIME] += dt
            end_ramp(z, kept[_TIME], load)
            charge += z[Q]
            wave += z[QF]
            square += square_integral(i, z[I], z[Q], dt)
            # ∫f i dt of two straight lines with the given means and ends.
            work += z[QF] * z[Q] / dt + dt * (z[F] - f) * (z[I] - i) / 12.0
            low, high = min(low, z[I]), max(high, z[I])
        mean = charge / tick
        u = wave / tick
        row = rows[n]
        row[Column.T] = t_before + 0.5 * tick
        row[Column.X] = 0.5 * (x_before + z[X])
        row[Column.OMEGA] = (z[X] - x_before) / tick
        row[Column.I] = mean
        row[Column.E_A] = floats[_GAIN] * floats[_S] * u
        row[Column.TORQUE] = floats[_K_T] * mean
        row[Column.ETA] = floats[_ETA_CONTACT] if kept[_TOUCHING] else floats[_ETA_FREE]
        row[Column.U] = u
        row[Column.V] = u - floats[_S] * mean
        row[Column.X_HAND] = 0.5 * (hand_before + z[P] + z[C])
        row[Column.CONTACT] = kept[_TOUCHING]
        row[Column.SATURATED] = abs(kept[_SIDE])
        row[Column.ENERGY_OUT] = floats[_GAIN] * floats[_S] * work - floats[_RESISTANCE] * square
        row[Column.RIPPLE] = high - low


class AnalogSimulation:
    """A scene on the paper's analog circuit; its rows stand on the tick grid of ``tick_s``.

    It has the scene's R̂, walls (as the encoder's cells have them) and drive, an ideal sensor, no
    latency, and the scene's λ whatever the tick.
    """

    clock_cycles: int | None = None

    def __init__(
        self, scene: Scene, tick_s: float | None = None, cell_rad: float | None = None
    ) -> None:
        control = scene.controller
        refuse_shaper(scene, "analog")
        set_ = settings(scene, tick_s, cell_rad)
        self.settings = set_
        self.tick_s = set_.tick_s
        self.winding = Winding(scene, self.tick_s)
        plant = self.winding.plant
        s = physics.root(set_.r_hat)
        gain = drive_gain(scene)
        self._substeps = plant.substeps(self.tick_s)
        dt = self._dt = self.tick_s / self._substeps
        self._circuit = (control.lambda_, s, gain, (control.eta_free, control.eta_contact))
        self._steps = self._transitions(plant)
        self._z = np.zeros(SIZE)
        self._z[: C + 2] = plant.start[: C + 2]
        self._kept = np.zeros(3)
        self._floats = np.array(
            [dt, set_.cell_rad, s, gain, plant.k_t, plant.resistance,
             min(set_.limit_v / s, formats.WAVE.largest), control.eta_contact, control.eta_free]
        )  # fmt: skip
        self._load = load_words(plant)
        self._wall_min = set_.wall_min * set_.cell_rad
        self._wall_max = set_.wall_max * set_.cell_rad

    def _transitions(self, plant: Plant) -> np.ndarray:
        circuits = circuit_matrices(plant, *self._circuit)
        parts = [self._dt * 2.0 ** (n - HALVINGS) for n in range(HALVINGS + 1)]
        return np.array([[expm(a * part) for part in parts] for a in circuits])

    def advance(self, rows: np.ndarray, words: np.ndarray | None = None) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column); it has no words."""
        del words
        self.winding.advance(rows, lambda part: self._advance(rows[part]), self._warm)

    def _warm(self, plant: Plant) -> None:
        self._steps = self._transitions(plant)
        self._floats[_RESISTANCE] = plant.resistance

    def _advance(self, rows: np.ndarray) -> None:
        _advance(
            rows, self._z, np.empty_like(self._z), self._kept, self._wall_min, self._wall_max,
            self._floats, self._substeps, self._load, self._steps,
        )  # fmt: skip
