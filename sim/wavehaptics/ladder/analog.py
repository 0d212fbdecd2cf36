# SPDX-License-Identifier: Apache-2.0
"""The controller ``analog``: the paper's circuit in continuous time, the reference of all others.

``v = u − s·i``, ``df/dt = λ(η v − f)``, ``u`` is f within the voltage limit, ``e_a = s·u``. With
the motor this is linear as long as neither η nor the limit changes, so a step is one product with a
matrix exponential; the instant at which one of them does change is found by bisection.

The motor is the scene's, so that a wall is lost here too where a real motor loses it; encoder and
current sensor are ideal. What isn't linear is a constant voltage w over each step, as in
:mod:`wavehaptics.motor.step`: the circuit goes through the step once with the last w
and, with what that tells, again with the right one.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm

from wavehaptics.controller.settings import settings
from wavehaptics.ladder.abilities import refuse
from wavehaptics.laws import closed_forms
from wavehaptics.motor.imperfections import MOTOR, SUPPLY, Real, real_parts, warm_real
from wavehaptics.motor.plant import (
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
from wavehaptics.motor.plant import SIZE as PLANT_SIZE
from wavehaptics.motor.step import (
    MEMORY,
    SERIES_OHM,
    VOLTAGE,
    keep_step,
    load_torque,
    series_ohm,
    series_voltage,
    warming_square,
)
from wavehaptics.motor.supply import SAG_OHM, STEP_PART, STEP_S, sag_in_series, supply_part
from wavehaptics.motor.thermal import Winding
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene, drive_gain, without_anchor
from wavehaptics.trace.columns import put_motion, put_port

F = E
"""The filter's f stands where the plant has its voltage: e_a = s·f."""
QF = PLANT_SIZE
"""∫f dt, for the mean voltage."""
SIZE = PLANT_SIZE + 1
W = SIZE
"""The voltage in series with a winding that isn't linear; a linear one does without that place."""

FREE, CONTACT, LIMITED = range(3)
"""Matrices of the three linear circuits: free space, contact, f held at the limit."""

HALVINGS = 24
"""The steps at hand are the regular one and its halves, quarters, ... down to 2⁻²⁴ of it."""
MODE_CHANGES = 8
"""Changes of circuit that are looked for in a step."""

ROUNDS = 6
"""Times that a step is tried at most; without a change of circuit in it, the second is right."""
TOLERANCE_V = 1e-9

# Places in the loop's float parameters.
_DT, _CELL, _S, _GAIN, _K_T, _RESISTANCE, _U_MAX, _ETA_CONTACT, _ETA_FREE = range(9)
# Places in what the loop keeps: wall side of the rotor, sign of the limit that holds f, time.
_TOUCHING, _SIDE, _TIME = range(3)


def circuit_matrices(
    plant: Plant, lambda_: float, s: float, gain: float, etas: tuple[float, float]
) -> np.ndarray:
    """A of ``z' = A z`` for the circuits FREE, CONTACT and LIMITED: (3, SIZE, SIZE).

    ``etas`` holds η of free space and of contact, ``gain`` is what the drive gives for 1 V. The
    place W is there only where the plant's motor isn't linear.
    """
    size = SIZE + 1 if plant.real else SIZE
    matrices = np.zeros((3, size, size))
    if plant.real:
        matrices[:, I, W] = -1.0 / plant.inductance
    matrices[:, :PLANT_SIZE, :PLANT_SIZE] = plant.matrix()
    matrices[:, I, F] *= gain * s
    matrices[:, QF, F] = 1.0
    for n, eta in enumerate(etas):
        matrices[n, F, F] = lambda_ * (eta - 1.0)
        matrices[n, F, I] = -lambda_ * eta * s
    return matrices


@compiled()
def inside(x: float, wall_min: np.ndarray, wall_max: np.ndarray) -> bool:
    """Whether a rotor at ``x`` is in a wall; all in rad."""
    for n in range(wall_min.shape[0]):
        if wall_min[n] <= x < wall_max[n]:
            return True
    return False


@compiled()
def _outward(z: np.ndarray, kept: np.ndarray, floats: np.ndarray) -> float:
    """How far the filter's goal η·v lies beyond the limit that holds f, √W."""
    eta = floats[_ETA_CONTACT] if kept[_TOUCHING] else floats[_ETA_FREE]
    beyond: float = kept[_SIDE] * (eta * (z[F] - floats[_S] * z[I]) - z[F])
    return beyond


@compiled()
def _consistent(
    z: np.ndarray, kept: np.ndarray, floats: np.ndarray, wall_min: np.ndarray, wall_max: np.ndarray
) -> bool:
    """Whether the state still belongs to the circuit that it is advanced with."""
    if inside(z[X], wall_min, wall_max) != (kept[_TOUCHING] != 0.0):
        return False
    if kept[_SIDE] == 0.0:
        inner: bool = abs(z[F]) <= floats[_U_MAX]
        return inner
    return _outward(z, kept, floats) >= 0.0


@compiled()
def _switch(
    z: np.ndarray, kept: np.ndarray, floats: np.ndarray, wall_min: np.ndarray, wall_max: np.ndarray
) -> None:
    """Choose the circuit that the state belongs to."""
    kept[_TOUCHING] = 1.0 if inside(z[X], wall_min, wall_max) else 0.0
    if kept[_SIDE] == 0.0 and abs(z[F]) > floats[_U_MAX]:
        kept[_SIDE] = 1.0 if z[F] > 0.0 else -1.0
        z[F] = kept[_SIDE] * floats[_U_MAX]
    if kept[_SIDE] != 0.0 and _outward(z, kept, floats) < 0.0:
        kept[_SIDE] = 0.0


@compiled()
def _circuit(kept: np.ndarray) -> int:
    if kept[_SIDE] != 0.0:
        return LIMITED
    return CONTACT if kept[_TOUCHING] else FREE


@compiled()
def _product(matrix: np.ndarray, z: np.ndarray, out: np.ndarray) -> None:
    for row in range(z.shape[0]):
        total = 0.0
        for column in range(z.shape[0]):
            total += matrix[row, column] * z[column]
        out[row] = total


@compiled()
def _part(
    z: np.ndarray, trial: np.ndarray, kept: np.ndarray, floats: np.ndarray, wall_min: np.ndarray,
    wall_max: np.ndarray, steps: np.ndarray,
) -> None:  # fmt: skip
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
        free = changes < MODE_CHANGES
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
def _real_part(
    z: np.ndarray, trial: np.ndarray, before: np.ndarray, kept: np.ndarray, floats: np.ndarray,
    wall_min: np.ndarray, wall_max: np.ndarray, ohm: float, steps: np.ndarray,
    parts: tuple[np.ndarray, ...],
) -> tuple[float, float]:  # fmt: skip
    """:func:`_part` of a motor that isn't linear; returns w and the brushes' part of it.

    ``before`` is room for a state.
    """
    dt = floats[_DT]
    touching, side = kept[_TOUCHING], kept[_SIDE]
    for n in range(z.shape[0]):
        before[n] = z[n]
    w, drop = parts[MEMORY][VOLTAGE], 0.0
    for attempt in range(ROUNDS):
        z[W] = w
        _part(z, trial, kept, floats, wall_min, wall_max, steps)
        table = steps[_circuit(kept), HALVINGS]
        g, g_last = -table[Q, W] / dt, -table[I, W]
        right, drop = series_voltage(
            z[Q] / dt + g * w, g, before[I], z[I] + g_last * w, g_last, dt, ohm, parts
        )
        if abs(right - w) <= TOLERANCE_V or attempt == ROUNDS - 1:
            break
        w = right
        for n in range(z.shape[0]):
            z[n] = before[n]
        kept[_TOUCHING], kept[_SIDE] = touching, side
    return w, drop


@compiled()
def _advance(
    rows: np.ndarray, z: np.ndarray, trial: np.ndarray, before: np.ndarray, kept: np.ndarray,
    wall_min: np.ndarray, wall_max: np.ndarray, floats: np.ndarray, substeps: int, load: np.ndarray,
    steps: np.ndarray, real: Real | None,
) -> None:  # fmt: skip
    dt = floats[_DT]
    tick = dt * substeps
    for n in range(rows.shape[0]):
        x_before, hand_before, t_before = z[X], z[P] + z[C], kept[_TIME]
        charge, wave, square, work, lost = 0.0, 0.0, 0.0, 0.0, 0.0
        low, high = z[I], z[I]
        for _ in range(substeps):
            i, omega, x, f = z[I], z[OMEGA], z[X], z[F]
            z[Q] = 0.0
            z[QF] = 0.0
            sag, ohm, drop = 0.0, 0.0, 0.0
            if real is None:
                tau = friction_torque(z, load)
                z[TAU] = tau
                _part(z, trial, kept, floats, wall_min, wall_max, steps)
            else:
                parts = real[MOTOR]
                if real[SUPPLY][SAG_OHM] != 0.0:
                    e = floats[_GAIN] * floats[_S] * f
                    sag = sag_in_series(e, supply_part(kept[_TIME], real[SUPPLY]), real[SUPPLY])
                    parts[MEMORY][SERIES_OHM] = sag
                if parts[MEMORY].shape[0] == 0:
                    tau = friction_torque(z, load)
                    z[TAU] = tau
                    _part(z, trial, kept, floats, wall_min, wall_max, steps)
                else:
                    torque = load_torque(z, dt, parts)
                    ohm = series_ohm(x + 0.5 * dt * omega, kept[_TIME] + 0.5 * dt, parts)
                    tau = friction_torque(z, load, torque)
                    z[TAU] = tau + torque
                    w, drop = _real_part(
                        z, trial, before, kept, floats, wall_min, wall_max, ohm, steps, parts
                    )
                    keep_step(w, i, z[Q] / dt, omega, z[OMEGA], dt, parts)
            settle_friction(z, omega, x, tau, load)
            kept[_TIME] += dt
            end_ramp(z, kept[_TIME], load)
            charge += z[Q]
            wave += z[QF]
            part_square = square_integral(i, z[I], z[Q], dt)
            if real is not None and real[MOTOR][MEMORY].shape[0] != 0:
                part_square = warming_square(part_square, z[Q], drop, ohm, real[MOTOR])
                lost += sag * z[Q]
            square += part_square
            # ∫f i dt of two straight lines with the given means and ends.
            work += z[QF] * z[Q] / dt + dt * (z[F] - f) * (z[I] - i) / 12.0
            low, high = min(low, z[I]), max(high, z[I])
        mean = charge / tick
        u = wave / tick
        row = rows[n]
        put_motion(
            row, t_before, tick, x_before, z[X], mean,
            floats[_GAIN] * floats[_S] * u - lost / tick, floats[_K_T] * mean,
            0.5 * (hand_before + z[P] + z[C]),
            floats[_GAIN] * floats[_S] * work - floats[_RESISTANCE] * square, high - low,
        )  # fmt: skip
        eta = floats[_ETA_CONTACT] if kept[_TOUCHING] else floats[_ETA_FREE]
        put_port(row, eta, u, u - floats[_S] * mean, kept[_TOUCHING], kept[_SIDE] != 0)


class AnalogSimulation:
    """A scene on the paper's analog circuit; its rows stand on the tick grid of ``tick_s``.

    It has the scene's motor, R̂, walls (as the encoder's cells have them) and drive, an ideal sensor
    and encoder, no latency, and the scene's λ whatever the tick.
    """

    clock_cycles: int | None = None

    def __init__(
        self, scene: Scene, tick_s: float | None = None, cell_rad: float | None = None
    ) -> None:
        refuse(scene, "analog")
        scene = without_anchor(scene)
        control = scene.controller
        set_ = settings(scene, tick_s, cell_rad)
        self.settings = set_
        self.tick_s = set_.tick_s
        self.winding = Winding(scene, self.tick_s)
        plant = self.winding.plant
        s = closed_forms.root(set_.r_hat)
        gain = drive_gain(scene)
        self._substeps = plant.substeps(self.tick_s)
        dt = self._dt = self.tick_s / self._substeps
        self._stepped = False
        self._circuit = (control.lambda_, s, gain, (control.eta_free, control.eta_contact))
        self._plant = plant
        self._steps = self._transitions(plant)
        self._z = np.zeros(self._steps.shape[-1])
        self._real = real_parts(scene, plant, set_.cell_rad, [dt])
        self._z[: C + 2] = plant.start[: C + 2]
        self._kept = np.zeros(3)
        self._floats = np.array(
            [dt, set_.cell_rad, s, gain, plant.k_t, plant.resistance,
             set_.limit_v / s, control.eta_contact, control.eta_free]
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
        self._plant = plant
        self._steps = self._transitions(plant)
        self._load = load_words(plant)
        self._floats[_RESISTANCE], self._floats[_K_T] = plant.resistance, plant.k_t
        warm_real(self._real, plant)

    def _advance(self, rows: np.ndarray) -> None:
        before = self._ticks_to_step(len(rows))
        self._run(rows[:before])
        if before < len(rows):
            self._step_bus()
            self._run(rows[before:])

    def _ticks_to_step(self, ticks: int) -> int:
        """Ticks before the first after a step of the bus, at most ``ticks``."""
        if self._real is None or self._stepped or not np.isfinite(self._real[SUPPLY][STEP_S]):
            return ticks
        left_s: float = self._real[SUPPLY][STEP_S] - self._kept[_TIME]
        return min(ticks, max(0, math.ceil(left_s / self.tick_s - 1e-6)))

    def _step_bus(self) -> None:
        lambda_, s, gain, etas = self._circuit
        assert self._real is not None
        gain *= float(self._real[SUPPLY][STEP_PART])
        self._circuit = (lambda_, s, gain, etas)
        self._floats[_GAIN] = gain
        self._steps = self._transitions(self._plant)
        self._stepped = True

    def _run(self, rows: np.ndarray) -> None:
        _advance(
            rows, self._z, np.empty_like(self._z), np.empty_like(self._z), self._kept,
            self._wall_min, self._wall_max, self._floats, self._substeps, self._load, self._steps,
            self._real,
        )  # fmt: skip
