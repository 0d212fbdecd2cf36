# SPDX-License-Identifier: Apache-2.0
"""The motor's integrators: the exact table beside Runge and Kutta, Euler and scipy's solvers.

The motor and its hand are driven with a voltage that is constant for a tick, as every controller
here does; a swept square wave stands for the controller, so that the same voltages go to all.
"""

from __future__ import annotations

import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from wavehaptics.motor.plant import OMEGA, SIZE, E, I, Plant, S, X, load_words
from wavehaptics.motor.plant import plant_step as exact_step
from wavehaptics.runtime.compiled import compiled_counting
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.sweeps import Task

TITLE = "How should the motor be integrated?"

SCENE = "paper_taps"
TICK_S = 1e-5
DURATION_S = 2.0
STEPS = (1, 2, 5, 10, 20, 50)
QUICK_STEPS = (1, 5, 20)
SOLVERS = ("RK45", "DOP853", "Radau", "LSODA")
QUICK_SOLVERS = ("RK45", "LSODA")
SOLVER_TICKS = 2000
"""Ticks that scipy's solvers get: they are started afresh at each, and take long."""
REPEATS = 3


def voltages(ticks: int) -> np.ndarray:
    """The voltage of each tick, V: ±2 V, whose sign changes ever faster."""
    n = np.arange(ticks)
    return 2.0 * np.sign(np.sin(2e-6 * n * n + 1e-3 * n + 0.1))


@compiled_counting()
def _exact(
    state: np.ndarray, matrix: np.ndarray, step_s: float, volts: np.ndarray, load: np.ndarray,
    parts: int, out: np.ndarray,
) -> None:  # fmt: skip
    for n in range(volts.shape[0]):
        for _ in range(parts):
            exact_step(state, matrix, step_s, volts[n], load)
        out[n, 0], out[n, 1], out[n, 2] = state[I], state[OMEGA], state[X]


@compiled_counting()
def _slope(a: np.ndarray, z: np.ndarray, out: np.ndarray) -> None:
    for row in range(z.shape[0]):
        total = 0.0
        for column in range(z.shape[0]):
            total += a[row, column] * z[column]
        out[row] = total


@compiled_counting()
def _euler(
    z: np.ndarray, a: np.ndarray, step_s: float, volts: np.ndarray, parts: int, out: np.ndarray
) -> None:
    k = np.empty_like(z)
    for n in range(volts.shape[0]):
        z[E] = volts[n]
        for _ in range(parts):
            _slope(a, z, k)
            z += step_s * k
        out[n, 0], out[n, 1], out[n, 2] = z[I], z[OMEGA], z[X]


@compiled_counting()
def _rk4(
    z: np.ndarray, a: np.ndarray, step_s: float, volts: np.ndarray, parts: int, out: np.ndarray
) -> None:
    k1, k2, k3, k4 = np.empty_like(z), np.empty_like(z), np.empty_like(z), np.empty_like(z)
    for n in range(volts.shape[0]):
        z[E] = volts[n]
        for _ in range(parts):
            _slope(a, z, k1)
            _slope(a, z + 0.5 * step_s * k1, k2)
            _slope(a, z + 0.5 * step_s * k2, k3)
            _slope(a, z + step_s * k3, k4)
            z += step_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        out[n, 0], out[n, 1], out[n, 2] = z[I], z[OMEGA], z[X]


def _start(plant: Plant) -> np.ndarray:
    """The plant's start as the augmented state of ``Plant.matrix``."""
    z = np.zeros(SIZE)
    z[: S + 1] = plant.start[: S + 1]
    return z


def _run(plant: Plant, method: str, parts: int, volts: np.ndarray) -> tuple[np.ndarray, float]:
    """(i, ω, x) at the end of each tick, and the processor's seconds for it."""
    out = np.zeros((len(volts), 3))
    step_s = TICK_S / parts
    load, a, z, state = load_words(plant), plant.matrix(), _start(plant), plant.start.copy()
    table = plant.transition(step_s)
    began = time.process_time()
    if method == "exact":
        _exact(state, table, step_s, volts, load, parts, out)
    elif method == "Euler":
        _euler(z, a, step_s, volts, parts, out)
    elif method == "RK4":
        _rk4(z, a, step_s, volts, parts, out)
    else:
        _solve(a, z, volts, out, method=method, rtol=1e-6, atol=1e-9)
    return out, time.process_time() - began


def _solve(
    a: np.ndarray, z: np.ndarray, volts: np.ndarray, out: np.ndarray, **options: Any
) -> None:
    for n, e in enumerate(volts):
        z[E] = e
        z = solve_ivp(lambda t, y: a @ y, (0.0, TICK_S), z, **options).y[:, -1]
        out[n] = z[[I, OMEGA, X]]


@cache
def reference() -> np.ndarray:
    """(i, ω, x) at the end of each tick by a solver that shares nothing with the table."""
    plant = Plant.of_scene(load(SCENE, []))
    volts = voltages(SOLVER_TICKS)
    out = np.zeros((len(volts), 3))
    _solve(plant.matrix(), _start(plant), volts, out, method="DOP853", rtol=1e-13, atol=1e-16)
    return out


def at_step(method: str, parts: int) -> dict[str, Any]:
    """Error of the current against the reference, and seconds per simulated second."""
    plant = Plant.of_scene(load(SCENE, []))
    solver = method in SOLVERS
    volts = voltages(SOLVER_TICKS if solver else round(DURATION_S / TICK_S))
    if not solver:
        _run(plant, method, parts, volts[:1])  # compiles
    seconds = np.inf
    for _ in range(1 if solver else REPEATS):
        found, took = _run(plant, method, parts, volts)
        seconds = min(seconds, took)
    true = reference()
    error = found[:SOLVER_TICKS, 0] - true[:, 0]
    peak = np.abs(true[:, 0]).max()
    relative = float(np.sqrt(np.mean(error**2)) / peak)
    return {
        "method": method,
        "step_s": TICK_S / parts,
        "error": relative if np.isfinite(relative) else None,
        "cost_s_per_s": float(seconds / (len(volts) * TICK_S)),
    }


def tasks(quick: bool) -> list[Task]:
    steps = QUICK_STEPS if quick else STEPS
    found = [Task(at_step, {"method": "exact", "parts": 1})]
    found += [Task(at_step, {"method": m, "parts": n}) for m in ("RK4", "Euler") for n in steps]
    solvers = QUICK_SOLVERS if quick else SOLVERS
    return found + [Task(at_step, {"method": m, "parts": 1}) for m in solvers]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    del tasks
    return {"tick_s": TICK_S, "points": results}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    figure, (ax,) = figures.panels(1, 3.8)
    names = list(dict.fromkeys(p["method"] for p in data["points"]))
    for n, method in enumerate(names):
        points = [p for p in data["points"] if p["method"] == method]
        figures.curve(ax, [p["cost_s_per_s"] for p in points], [p["error"] for p in points], n,
                      method)  # fmt: skip
    ax.set_xscale("log")
    ax.set_yscale("log")
    figures.label(ax, "seconds per simulated second", "error of the current, RMS over peak")
    figures.legend(ax, ncols=2)
    path = figures.save(figure, folder / "integrators.png")
    return [
        Text(
            f"The motor with its hand at a voltage that changes every {1e6 * TICK_S:g} µs. Between "
            "two changes the motion is linear, so that one product with a tabulated matrix "
            "exponential is exact, at about the price of one step of Runge and Kutta's. Their and "
            "Euler's steps are compiled like it. scipy's solvers (relative tolerance 10⁻⁶) are "
            "called from Python at every tick. The reference is DOP853 at 10⁻¹³."
        ),
        Picture(path, "Error over cost; from left to right with ever smaller steps."),
        Table(
            "Integrators",
            ("method", "step, µs", "error", "s per simulated s"),
            [
                (p["method"],
                 "its own" if p["method"] in SOLVERS else number(1e6 * p["step_s"]),
                 number(p["error"]), number(p["cost_s_per_s"]))
                for p in data["points"]
            ],
        ),
    ]  # fmt: skip
