# SPDX-License-Identifier: Apache-2.0
"""What the pages show of report and bench: a few numbers, pictures and tables."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from wavehaptics.studies.report import field_oriented, in_space
from wavehaptics.studies.report.blocks import number, percent

PICTURES = ("old_way_limits.png", "old_way_hand.png", field_oriented.PICTURE, in_space.PICTURE)
"""Pictures of the report that the pages show, below ``sim/docs``."""


def of_report(report: dict[str, Any]) -> dict[str, Any]:
    """The report's numbers that the pages quote."""
    sections = report["sections"]
    return {
        "quick": report["quick"],
        "seconds": report["seconds"],
        "ratios": sections["old_way"]["ratios"],
        "brushless_walls": sections["field_oriented"]["curves"]["wall"],
        "scenes": {
            name: {
                "recommended": scene["recommended"],
                "models": [m for m in scene["models"] if m["model"] == scene["recommended"]],
                "pins_cost": scene["models"][0]["cost_s_per_s"],
            }
            for name, scene in sections["parts"]["scenes"].items()
        },
        "hard_cases": {
            "tried": len(sections["hard_cases"]["cases"]),
            "as_expected": sum(case["ok"] for case in sections["hard_cases"]["cases"]),
        },
    }


def of_bench(summary: dict[str, Any]) -> dict[str, Any]:
    """The bench's numbers that the pages quote."""
    kept = ("machine", "compiler", "verilator", "controllers")
    return {key: summary[key] for key in kept}


def _usual_way(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    head = ("", "wave, N·m/rad", "encoder, N·m/rad", "wave over encoder")
    rows = [
        (row["case"], number(row["wave"]), number(row["encoder"]), number(row["ratio"]))
        for row in numbers["report"]["ratios"]
    ]
    return table(head, rows)


def _brushless_walls(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    return table(*field_oriented.walls(numbers["report"]["brushless_walls"]))


def _foc_designs(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    return table(*field_oriented.beside(numbers.get("resources", [])))


def _needs(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    head = ("scene", "cheapest model", "its torque error", "times as fast as `pins`")
    rows = []
    for name, scene in numbers["report"]["scenes"].items():
        (best,) = scene["models"]
        times = scene["pins_cost"] / best["cost_s_per_s"]
        rows.append((f"`{name}`", best["model"], percent(best["error"]), number(times)))
    return table(head, rows)


def gain(row: dict[str, Any]) -> str:
    """How many times as fast something was, with the least and the most of the rounds."""
    if row["failed"]:
        return row["failed"]
    return f"{row['gain']:.2f} ({row['gain_least']:.2f}–{row['gain_most']:.2f})"


def _speed(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    head = ("controller", "simulated s per s", "ticks per s", "clock cycles per s", "torque error")
    rows = [
        (f"`{name}`", number(row["simulated_s_per_s"]), number(row["ticks_per_s"]),
         number(row["cycles_per_s"]), percent(row["torque_error"]))
        for name, row in numbers["bench"]["controllers"].items()
    ]  # fmt: skip
    return table(head, rows)


def _others(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    head = ("package", "steps per s", "simulated s per s", "error of the current")
    rows = [
        (f"{row['name']} {row['version']}: {row['what']}", number(row["steps_per_s"]),
         number(row["simulated_s_per_s"]), number(row["current_error"]))
        for row in numbers["measured_once"]["others"]
    ]  # fmt: skip
    return table(head, rows)


def _tried(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    head = ("tried with `pins`", "clock cycles per s", "times as fast")
    rows = [
        (row["what"], number(row["cycles_per_s"]), gain(row))
        for row in numbers["measured_once"]["tried"]
    ]
    return table(head, rows)


TABLES = {
    "usual-way": _usual_way,
    "brushless-walls": _brushless_walls,
    "foc-designs": _foc_designs,
    "needs": _needs,
    "speed": _speed,
    "others": _others,
    "tried": _tried,
}
"""Tables of Markdown by marker, made with the given function of head and rows."""
