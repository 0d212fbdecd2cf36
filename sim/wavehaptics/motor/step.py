# SPDX-License-Identifier: Apache-2.0
"""A step of the motor with all that its scene says of it.

What is linear is the plant's (:mod:`wavehaptics.motor.plant`), advanced exactly. What is not is a
voltage w in series with the winding and a torque on the rotor, each constant over the step: the
torque at the step's middle, and w at the step's mean current,

    w = V_b tanh(ī/knee) + ρ ī + v_eddy(ī) + (change of the missing flux)/step,   ī = ī₀ − g w

with ī₀ the mean without w and g from the same table as the exact step. One unknown, of which the
difference of both sides only ever grows: Newton's method, kept between two places of which one is
too low and one too high, finds it. It is of second order in the step, and at the mean current it
takes exactly the energy w·ī, so that brushes only ever brake. For the accuracy
:attr:`~wavehaptics.motor.plant.Plant.longest_step_s` keeps g times the brushes' slope below a
quarter.
"""

from __future__ import annotations

import numpy as np

from wavehaptics.motor.brushes import brush_drop, brush_words, contact_ohm, noise_courses
from wavehaptics.motor.cable import (
    CABLE_K,
    END_INERTIA,
    cable_torque,
    cable_words,
    massive_end_torque,
)
from wavehaptics.motor.cogging import cogging_torque, cogging_words
from wavehaptics.motor.iron import EDDY_OHM, SATURATION, eddy_share, iron_words, missing_flux
from wavehaptics.motor.plant import (
    OMEGA,
    TIME,
    I,
    P,
    Plant,
    R,
    X,
    end_ramp,
    friction_torque,
    linear_step,
    plant_step,
    settle_friction,
    square_integral,
)
from wavehaptics.runtime.compiled import compiled

BRUSHES, NOISE, FLICKER, IRON, COGGING, CABLE, MEMORY = range(7)
"""Places of the arrays in :func:`motor_parts`."""

VOLTAGE, SERIES_OHM, EDDY_CURRENT, CABLE_END, END_SPEED, ACCELERATION, RESISTANCE = range(7)
"""Places in the memory of a motor: w of the last step; Ω in series, which the supply sets; i_e; y
of the cable, and how fast a mass there is; dω/dt of the last step; R."""

NEWTON_STEPS = 40
TOLERANCE_V = 1e-7
"""Newton's last step; as its error squares itself from step to step, w is far better than this."""


def motor_parts(plant: Plant) -> tuple[np.ndarray, ...]:
    """What :func:`motor_step` takes besides the plant's words: seven float64 arrays.

    All are empty where the scene's motor is linear.
    """
    if not plant.real:
        return (np.zeros(0),) * (MEMORY + 1)
    memory = np.zeros(RESISTANCE + 1)
    memory[CABLE_END], memory[END_SPEED] = plant.start[X], plant.start[OMEGA]
    memory[RESISTANCE] = plant.resistance
    return (
        brush_words(plant.brushes, plant.resistance),
        *noise_courses(plant.brushes),
        iron_words(plant.winding, plant.inductance),
        cogging_words(plant.cogging),
        cable_words(plant),
        memory,
    )


def warm_parts(parts: tuple[np.ndarray, ...], plant: Plant) -> None:
    """Let the parts of a motor follow the plant's R."""
    if plant.real:
        parts[BRUSHES][:] = brush_words(plant.brushes, plant.resistance)
        parts[MEMORY][RESISTANCE] = plant.resistance


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def series_voltage(
    mean: float, g: float, first: float, last: float, g_last: float, step_s: float, ohm: float,
    parts: tuple[np.ndarray, ...],
) -> tuple[float, float]:  # fmt: skip
    """w of a step, the voltage in series with the linear winding, and the brushes' part of it, V.

    Without w the current would have the ``mean``, and go from ``first`` to ``last``; a volt of it
    takes ``g`` and ``g_last`` off. ``ohm`` is what lies in series besides R.
    """
    brushes, iron, memory = parts[BRUSHES], parts[IRON], parts[MEMORY]
    flux_before, eddy_ohm = 0.0, 0.0
    if iron[SATURATION] != 0.0:
        flux_before = missing_flux(first, iron)[0]
    if iron[EDDY_OHM] != 0.0:
        share, inductance = eddy_share(memory[EDDY_CURRENT], first, step_s, iron)
        eddy_ohm = share * inductance / step_s
    w, drop = memory[VOLTAGE], 0.0
    low, high = -np.inf, np.inf
    for _ in range(NEWTON_STEPS):
        current = mean - g * w
        drop, slope = brush_drop(current, brushes)
        voltage = drop + ohm * current + eddy_ohm * (current - memory[EDDY_CURRENT])
        slope = 1.0 + g * (slope + ohm + eddy_ohm)
        if iron[SATURATION] != 0.0:
            flux, inductance = missing_flux(last - g_last * w, iron)
            voltage += (flux - flux_before) / step_s
            slope += g_last * inductance / step_s
        error = w - voltage
        if error > 0.0:
            high = w
        else:
            low = w
        before = w
        w -= error / slope
        if w < low or w > high:
            w = 0.5 * (low + high)
        if abs(w - before) <= TOLERANCE_V:
            break
    return w, drop


@compiled(inline="always")
def load_torque(state: np.ndarray, step_s: float, parts: tuple[np.ndarray, ...]) -> float:
    """Torque of cogging and cable against the rotor over a step, N·m; the cable's end moves on."""
    memory = parts[MEMORY]
    omega = state[OMEGA] + 0.5 * step_s * memory[ACCELERATION]
    torque = cogging_torque(state[X] + 0.5 * step_s * omega, parts[COGGING])
    cable = parts[CABLE]
    if cable[CABLE_K] != 0.0 and cable[END_INERTIA] != 0.0:
        pull, memory[CABLE_END], memory[END_SPEED] = massive_end_torque(
            state, state[X], omega, memory[CABLE_END], memory[END_SPEED], step_s, cable
        )
        torque += pull
    elif cable[CABLE_K] != 0.0:
        pull, end = cable_torque(state, state[X], omega, memory[CABLE_END], step_s, cable)
        torque += pull
        memory[CABLE_END] = end
    return torque


@compiled(inline="always")
def series_ohm(x: float, time: float, parts: tuple[np.ndarray, ...]) -> float:
    """What lies in series besides R at an angle and a time, Ω."""
    ohm: float = parts[MEMORY][SERIES_OHM]
    return ohm + contact_ohm(x, time, parts[BRUSHES], parts[NOISE], parts[FLICKER])


@compiled(inline="always")
def keep_step(
    w: float, first: float, mean: float, omega_before: float, omega: float, step_s: float,
    parts: tuple[np.ndarray, ...],
) -> None:  # fmt: skip
    """Remember of a step what the next needs; i was ``first``, and ``mean`` all through it."""
    memory = parts[MEMORY]
    memory[VOLTAGE] = w
    memory[ACCELERATION] = (omega - omega_before) / step_s
    if parts[IRON][EDDY_OHM] != 0.0:
        share, _ = eddy_share(memory[EDDY_CURRENT], first, step_s, parts[IRON])
        memory[EDDY_CURRENT] += share * (mean - memory[EDDY_CURRENT])


@compiled(inline="always")
def warming_square(
    square: float, charge: float, drop: float, ohm: float, parts: tuple[np.ndarray, ...]
) -> float:
    """∫i² dt for which R alone would warm as much as R, ``ohm`` and the brushes do, A²·s."""
    warming: float = square + (ohm * square + drop * charge) / parts[MEMORY][RESISTANCE]
    return warming


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def real_step(
    state: np.ndarray, m: np.ndarray, step_s: float, e: float, load: np.ndarray,
    parts: tuple[np.ndarray, ...], besides: float = 0.0,
) -> tuple[float, float]:  # fmt: skip
    """:func:`motor_step` of a motor that isn't linear."""
    i, omega, x = state[I], state[OMEGA], state[X]
    torque = load_torque(state, step_s, parts) + besides
    ohm = series_ohm(x + 0.5 * step_s * omega, state[TIME] + 0.5 * step_s, parts)
    tau = friction_torque(state, load, torque)
    charge = linear_step(state, m, e, tau + torque)
    w, drop = series_voltage(
        charge / step_s, m[3, 7] / step_s, i, state[I], m[0, 7], step_s, ohm, parts
    )
    charge -= m[3, 7] * w
    state[I] -= m[0, 7] * w
    state[OMEGA] -= m[1, 7] * w
    state[X] -= m[2, 7] * w
    settle_friction(state, omega, x, tau, load)
    keep_step(w, i, charge / step_s, omega, state[OMEGA], step_s, parts)
    state[P] += state[R] * step_s
    state[TIME] += step_s
    end_ramp(state, state[TIME], load)
    square = square_integral(i, state[I], charge, step_s)
    return charge, warming_square(square, charge, drop, ohm, parts)


@compiled(inline="always")
def motor_step(
    state: np.ndarray, m: np.ndarray, step_s: float, e: float, load: np.ndarray,
    parts: tuple[np.ndarray, ...], besides: float = 0.0,
) -> tuple[float, float]:  # fmt: skip
    """One step as :func:`wavehaptics.motor.plant.plant_step`, of a motor with ``parts``.

    ``besides`` acts against the rotor, N·m, as a hand does that holds more than this motor.

    Returns (∫i dt in A·s, ∫i² dt in A²·s). The second counts what brushes and supply turn into heat
    as if R had done it, so that ``e ∫i dt − R ∫i² dt`` is what comes out behind them: into the
    winding's field and to the rotor.
    """
    if parts[MEMORY].shape[0] == 0:
        return plant_step(state, m, step_s, e, load, besides)
    return real_step(state, m, step_s, e, load, parts, besides)
