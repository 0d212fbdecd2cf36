# SPDX-License-Identifier: Apache-2.0
"""The paper's experiment, figure by figure, and its equations, each with the test that shows it."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.ladder.run import CONTROLLERS, run_scene
from wavehaptics.laws import closed_forms
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number, percent
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.stability import simulate
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace import pictures
from wavehaptics.trace.columns import Column, load_trace

TITLE = "The paper's experiment"

KEPT_HZ = 4000.0
"""Rows a second of the traces that the report keeps."""
LIMITS_V = (2.1, 12.0)
PUSHES_RAD = (0.018, 0.024, 0.030, 0.036)

EQUATIONS = (
    ("e·i = ½u² − ½v², with e_a = s·u, v = u − s·i, s = √(2R̂)",
     "test_laws.py", "test_power_is_the_difference_of_the_waves"),
    ("u = D·v is passive if and only if |D| ≤ 1: the port gives out no energy",
     "test_laws.py", "test_port_never_gives_energy_with_the_mean_current"),
    ("K_L = k_T²/L in series with B_R = k_T²/R", "test_physics.py", "test_numbers_of_the_paper"),
    ("η = −1 takes R away and leaves K_L: rigid contact",
     "test_laws.py", "test_rigid_contact_renders_the_predicted_stiffness"),
    ("|η| < 1 adds the damper R(1 − g)/(1 + g), η = −g",
     "test_laws.py", "test_partial_contact_is_a_resistor_and_a_spring"),
    ("η = +1 is free space: what remains is an inertia k_T²τ/(2R)",
     "test_laws.py", "test_free_space_adds_the_predicted_inertia"),
    ("(14): the λ filter is a spring in series with K_L. Its stiffness is 2·k_T²·λ/R, twice what "
     "(14) prints", "test_laws.py", "test_analog_circuit_has_twice_the_stiffness_of_equation_14"),
)  # fmt: skip
"""Statement, file in ``sim/tests``, and the test there that shows it."""


def experiment(controller: str, duration_s: float) -> dict[str, Any]:
    """Metrics and thinned trace of the paper's taps."""
    settings = [f"scene.duration_s={duration_s}", f"scene.trace_hz={KEPT_HZ}"]
    with tempfile.TemporaryDirectory() as folder:
        metrics = run_scene(load("paper_taps", settings), controller, Path(folder))
        trace = load_trace(Path(folder))
    kept = ("t", "x", "torque", "e_a", "x_hand", "contact", "saturated")
    return {"metrics": metrics, "trace": {k: trace[k].tolist() for k in kept}}


def way_in_and_out(push_rad: float, limit_v: float) -> dict[str, Any]:
    """Work and slope of a tap's way in and of its way out, on the integer model."""
    scene = load(
        "paper_taps",
        [f"hand.amplitude_rad={push_rad}", f"drive.limit_v={limit_v}", "scene.duration_s=0.4"],
    )
    rows = simulate(CONTROLLERS["golden"](scene), scene.scene.duration_s)
    touching = np.flatnonzero(rows[:, Column.CONTACT])
    first = touching[0]
    last = first + np.argmax(np.append(rows[first:, Column.CONTACT] == 0, True))
    contact = rows[first:last]
    x, push = contact[:, Column.X], -contact[:, Column.TORQUE]
    deepest = int(x.argmax())
    ways = {}
    for name, part in (("in", slice(0, deepest)), ("out", slice(deepest, None))):
        xs, fs = x[part], push[part]
        inner = (fs > 0.1 * push.max()) & (fs < 0.9 * push.max())
        ways[name] = {
            "work_j": float(abs(np.trapezoid(fs, xs))),
            "slope": float(np.polyfit(xs[inner], fs[inner], 1)[0]),
        }
    step = max(1, len(x) // 400)
    return {
        "push_rad": push_rad,
        "limit_v": limit_v,
        "saturated": float(contact[:, Column.SATURATED].mean()),
        "work_ratio": ways["out"]["work_j"] / ways["in"]["work_j"],
        "slope_in": ways["in"]["slope"],
        "slope_out": ways["out"]["slope"],
        "zero_rad": float(x[deepest + np.argmax(np.append(push[deepest:] <= 0, True)) - 1]),
        "x": x[::step].tolist(),
        "push": push[::step].tolist(),
    }


def tasks(quick: bool) -> list[Task]:
    duration = 0.5 if quick else 1.5
    return [
        Task(experiment, {"controller": "analog", "duration_s": duration}),
        Task(experiment, {"controller": "pins", "duration_s": duration}),
        *(
            Task(way_in_and_out, {"push_rad": push, "limit_v": limit})
            for limit in LIMITS_V
            for push in PUSHES_RAD
        ),
    ]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    del tasks
    return {"analog": results[0], "pins": results[1], "ways": results[2:]}


def _trace(run: dict[str, Any]) -> dict[str, np.ndarray]:
    return {key: np.array(values) for key, values in run["trace"].items()}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    run, reference = _trace(data["pins"]), _trace(data["analog"])
    metrics = data["pins"]["metrics"]
    walls = load("paper_taps", []).controller.walls
    fig10 = pictures.fig10(run, reference, metrics, folder / "fig10.png", walls)
    fig11 = pictures.fig11(run, reference, metrics, folder / "fig11.png")

    figure, axes = figures.panels(2, 3.8)
    for ax, limit in zip(axes, LIMITS_V, strict=True):
        for n, way in enumerate(w for w in data["ways"] if w["limit_v"] == limit):
            ax.plot(np.multiply(1e3, way["x"]), np.multiply(1e3, way["push"]),
                    color=figures.COLOURS[n], lw=6 - 1.6 * n,  # those below stay to be seen
                    label=f"hand {1e3 * way['push_rad']:g} mrad beyond the wall")  # fmt: skip
        figures.label(ax, "position x, mrad", "−torque, mN·m", f"limit {limit:g} V")
        figures.legend(ax)
    loops = figures.save(figure, folder / "asymmetry.png")
    motor = load("paper_taps", []).motor
    k = metrics["stiffness"]
    filter_k = closed_forms.filter_stiffness(motor.k_t, motor.R_ohm, 1e4)
    printed = 1 / (1 / metrics["k_l"] + 2 / filter_k)
    exact = data["analog"]["metrics"]["stiffness"]
    return [
        Text(
            "A finger taps a rigid wall: RE 25 motor, λ = 10⁴ rad/s, the voltage "
            f"limited to {LIMITS_V[0]:g} V. The paper states K_L = {pictures.PAPER_K_L} N·m/rad "
            f"for this motor and measured {pictures.PAPER_MEASURED} N·m/rad on its prototype, "
            f"{percent(pictures.PAPER_MEASURED / pictures.PAPER_K_L)} of it. The paper's taps were "
            "made by hand; ours are a hand's spring and damper on a given path, so curves can be "
            "compared in shape, and numbers in stiffness."
        ),
        Picture(fig10, "As the paper's Fig. 10: position, torque and voltage over time."),
        Picture(fig11, "As the paper's Fig. 11: torque over position, with springs to compare."),
        Table(
            "Figures 10 and 11 in numbers",
            ("", "the paper", "here, pins", "here, analog"),
            [
                ("K_L, N·m/rad", number(pictures.PAPER_K_L, 5), number(metrics["k_l"], 5),
                 number(metrics["k_l"], 5)),
                ("K, N·m/rad, at λ = 10⁴ rad/s", number(pictures.PAPER_MEASURED), number(k),
                 number(exact)),
                ("K by the closed form, N·m/rad", "–", number(metrics["stiffness_predicted"]),
                 number(data["analog"]["metrics"]["stiffness_predicted"])),
                ("peak torque, mN·m", "–", number(1e3 * metrics["peak_torque"]),
                 number(1e3 * data["analog"]["metrics"]["peak_torque"])),
                ("torque error against analog", "–", percent(metrics["torque_nrmse_vs_analog"]),
                 "–"),
            ],
        ),
        Text(
            f"Equation (14) of the paper gives the λ filter a stiffness of k_T²·λ/R = "
            f"{filter_k / 2:.3f} N·m/rad here. The circuit has 2·k_T²·λ/R = {filter_k:.3f}: twice "
            "what (14) prints. In series with K_L that makes the stiffness of the table; with "
            f"(14) as printed it would be {printed:.3f}. What the paper measured lies above both."
        ),
        Text(
            "The way out of a tap differs from the way in as soon as the voltage has been at its "
            "limit, and only then: with the limit out of reach the same taps give back 99.9 % of "
            "the work. At the limit the torque can't follow the depth, so the spring's zero moves "
            "into the wall. The way out has the same slope, but its torque is gone before the "
            "rotor is out; what the wall then does is pull, and work is lost."
        ),
        Picture(
            loops,
            "Way in and way out of one tap, with and without saturation; at 12 V all lie on one "
            "line.",
        ),
        Table(
            "Why the way out differs from the way in",
            ("limit, V", "hand, mrad", "part of the contact at the limit", "work out over work in",
             "slope in, N·m/rad", "slope out, N·m/rad", "torque gone at, mrad"),
            [
                (number(w["limit_v"]), number(1e3 * w["push_rad"]), percent(w["saturated"]),
                 number(w["work_ratio"]), number(w["slope_in"]), number(w["slope_out"]),
                 number(1e3 * w["zero_rad"]))
                for w in data["ways"]
            ],
        ),
        Table(
            "What the paper's equations state, and the test that shows it",
            ("statement", "test", "file in sim/tests"),
            [(statement, test, file) for statement, file, test in EQUATIONS],
        ),
    ]  # fmt: skip
