# SPDX-License-Identifier: Apache-2.0
"""Bits of the ADC and steps of the PWM against error."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number, percent
from wavehaptics.studies.report.runs import FIRST_CONTACT_S, cost, off, run_task
from wavehaptics.studies.sweeps import Task

TITLE = "How fine must ADC and PWM be?"

BITS = (8, 9, 10, 11, 12, 13, 14, 15, 16)
QUICK_BITS = (8, 10, 12, 14, 16)
FULL_SCALE_A = 2.5
STEPS = ((48e6, 2e6), (48e6, 1e6), (48e6, 5e5), (96e6, 5e5), (192e6, 5e5))
"""Clock and carrier, Hz: their quotient is twice the number of steps from no to full voltage."""
QUICK_STEPS = STEPS[:3]


def tasks(quick: bool) -> list[Task]:
    duration = f"scene.duration_s={FIRST_CONTACT_S}"
    adc = f"adc.full_scale_a={FULL_SCALE_A}"
    bits = QUICK_BITS if quick else BITS
    steps = QUICK_STEPS if quick else STEPS
    return [
        *(run_task("paper_taps", "golden", duration, adc, f"adc.bits={n}") for n in bits),
        *(
            run_task(
                "paper_taps", "pins", duration, f"controller.clock_hz={clock}",
                f"drive.pwm_hz={carrier}",
            )
            for clock, carrier in steps
        ),
    ]  # fmt: skip


def _setting(task: Task, key: str) -> float:
    return next(float(s.split("=")[1]) for s in task.arguments["settings"] if s.startswith(key))


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    adc, pwm = [], []
    for task, metrics in zip(tasks, results, strict=True):
        point = {
            "torque_error": metrics["torque_nrmse_vs_analog"],
            "stiffness_error": off(metrics["stiffness"], metrics["stiffness_predicted"]),
            "free_space_torque_rms": metrics["free_space_torque_rms"],
            "ripple_a": metrics["current_ripple_a"],
            "cost_s_per_s": cost(metrics),
        }
        if task.arguments["controller"] == "golden":
            bits = int(_setting(task, "adc.bits"))
            adc.append({"bits": bits, "step_a": 2 * FULL_SCALE_A / 2**bits, **point})
        else:
            clock, carrier = (
                _setting(task, key) for key in ("controller.clock_hz", "drive.pwm_hz")
            )
            pwm.append({"steps": clock / (2 * carrier), "carrier_hz": carrier, **point})
    return {"adc": adc, "pwm": pwm}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    figure, (left, right) = figures.panels(2, 3.8)
    for n, (key, name) in enumerate((("torque_error", "torque"), ("stiffness_error", "stiffness"))):
        figures.curve(
            left, [p["bits"] for p in data["adc"]], [p[key] for p in data["adc"]], n, name
        )
        figures.curve(
            right, [p["steps"] for p in data["pwm"]], [p[key] for p in data["pwm"]], n, name
        )
    right.set_xscale("log", base=2)
    steps = sorted({p["steps"] for p in data["pwm"]})
    right.set_xticks(steps, [f"{n:g}" for n in steps])
    for ax in (left, right):
        ax.set_yscale("log")
        ax.axhline(0.01, color=figures.GREY, lw=0.8, ls=":")
        figures.legend(ax)
    figures.label(left, f"bits of an ADC of ±{FULL_SCALE_A:g} A", "error", "golden")
    figures.label(right, "clocks from no to full voltage", "", "pins")
    path = figures.save(figure, folder / "converters.png")
    return [
        Text(
            "The ADC of the averaged model samples once a tick; noise is off, so that its steps "
            "alone count. The PWM is the whole RTL's: its pulses end on whole clocks, and what a "
            "tick can't give is carried to the next (error feedback), so few steps cost little."
        ),
        Picture(path, "Error over the bits of the ADC and over the steps of the PWM; 1 % dotted."),
        Table(
            "ADC",
            ("bits", "step, mA", "torque error", "stiffness error", "s per simulated s"),
            [
                (p["bits"], number(1e3 * p["step_a"]), percent(p["torque_error"]),
                 percent(p["stiffness_error"]), number(p["cost_s_per_s"]))
                for p in data["adc"]
            ],
        ),
        Table(
            "PWM, with the carrier that makes it",
            ("steps", "carrier, kHz", "torque error", "stiffness error", "current ripple, mA",
             "s per simulated s"),
            [
                (f"{p['steps']:g}", f"{p['carrier_hz'] / 1e3:g}", percent(p["torque_error"]),
                 percent(p["stiffness_error"]), number(1e3 * p["ripple_a"]),
                 number(p["cost_s_per_s"]))
                for p in data["pwm"]
            ],
        ),
    ]  # fmt: skip
