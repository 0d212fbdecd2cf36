# SPDX-License-Identifier: Apache-2.0
"""Control rate against error: how fast does the digital controller have to be?"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from wavehaptics.laws import closed_forms
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number, percent
from wavehaptics.studies.report.runs import FIRST_CONTACT_S, cost, load, off, run_task
from wavehaptics.studies.sweeps import Task

TITLE = "How fast must the controller be?"

RATES_HZ = (10e3, 20e3, 50e3, 100e3, 200e3, 500e3, 1e6, 2e6, 4e6)
PINS_RATES_HZ = (50e3, 100e3, 250e3, 500e3, 1e6, 2e6)
QUICK_PINS_RATES_HZ = (100e3, 1e6)


def tasks(quick: bool) -> list[Task]:
    rates = [("golden", hz) for hz in RATES_HZ]
    rates += [("pins", hz) for hz in (QUICK_PINS_RATES_HZ if quick else PINS_RATES_HZ)]
    return [
        run_task(
            "paper_taps", controller, f"controller.tick_hz={hz}",
            f"scene.duration_s={FIRST_CONTACT_S}",
        )
        for controller, hz in rates
    ]  # fmt: skip


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    scene = load("paper_taps", [])
    motor = scene.motor
    exact = closed_forms.stiffness(motor.k_t, motor.L_h, motor.R_ohm, 1 / scene.controller.lambda_)
    points = []
    for metrics in results:
        hz = metrics["ticks"] / metrics["duration_s"]
        points.append(
            {
                "controller": metrics["controller"],
                "tick_hz": hz,
                "torque_error": metrics["torque_nrmse_vs_analog"],
                "stiffness_error": off(metrics["stiffness"], exact),
                "prediction_error": off(metrics["stiffness"], metrics["stiffness_predicted"]),
                "cost_s_per_s": cost(metrics),
            }
        )
    return {"exact_stiffness": exact, "points": points}


def _shown(hz: float) -> str:
    return f"{hz / 1e6:g}\u00a0MHz" if hz >= 1e6 else f"{hz / 1e3:g}\u00a0kHz"


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    figure, (left, right) = figures.panels(2)
    n = 0
    for controller in ("golden", "pins"):
        points = [p for p in data["points"] if p["controller"] == controller]
        hz = [p["tick_hz"] for p in points]
        for key, name in (("torque_error", "torque"), ("stiffness_error", "stiffness")):
            style = {"ls": "-" if key == "torque_error" else "--"}
            figures.curve(left, hz, [p[key] for p in points], n, f"{controller}, {name}", **style)
            costs = [p["cost_s_per_s"] for p in points]
            figures.curve(right, costs, [p[key] for p in points], n, f"{controller}, {name}",
                          **(style | {"ls": ""}))  # fmt: skip
            n += 1
        for p in points:
            if p["tick_hz"] in (10e3, 100e3, 1e6):
                at = (p["cost_s_per_s"], p["torque_error"])
                figures.note(right, _shown(p["tick_hz"]), at)
    for ax in (left, right):
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.margins(x=0.12)
        ax.axhline(0.01, color=figures.GREY, lw=0.8, ls=":")
    figures.label(left, "control rate, Hz", "error against the analog circuit", "error over rate")
    figures.label(right, "seconds per simulated second", "", "error over cost")
    figures.legend(left)
    path = figures.save(figure, folder / "rates.png")
    rows = [
        (p["controller"], _shown(p["tick_hz"]), percent(p["torque_error"]),
         percent(p["stiffness_error"]), percent(p["prediction_error"]), number(p["cost_s_per_s"]))
        for p in data["points"]
    ]  # fmt: skip
    return [
        Text(
            "The paper's taps (λ = 10⁴ rad/s) up to the deepest point of the first contact. The "
            "exact answers are the analog circuit's torque, tick by tick, and its stiffness in "
            "closed form. While a tick and the latency of one more fit into 1/λ, the filter's "
            "coefficient makes up for both, and what is left of the error is the wall found late "
            "by up to a tick. Below 20 kHz they no longer fit: the wall is softer than the analog "
            "one, by just what the closed form says (last but one column)."
        ),
        Picture(path, "Error over control rate, and over what the simulation costs; 1 % dotted."),
        Table(
            "Control rate against error and cost",
            ("controller", "rate", "torque, RMS over peak", "stiffness, against analog",
             "stiffness, against prediction", "s per simulated s"),
            rows,
        ),
    ]  # fmt: skip
