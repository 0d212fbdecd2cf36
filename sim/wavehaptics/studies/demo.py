# SPDX-License-Identifier: Apache-2.0
"""The paper's experiment: a finger taps a virtual wall, with the whole RTL driving the motor."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from rich.table import Table

from wavehaptics.ladder.run import run_scene
from wavehaptics.scene import Scene, find_scene, load_scene
from wavehaptics.trace import pictures
from wavehaptics.trace.columns import load_trace

RUNS = (
    ("analog", "paper_taps", "analog"),
    ("pins", "paper_taps", ""),
    ("pins", "stiffest", "stiffest"),
)
"""Controller, scene and folder (below the demo's own) of each run."""


def run_demo(out: Path, progress: Callable[[str, float], None]) -> list[dict[str, Any]]:
    """Run the experiment and draw its figures into ``out``; returns the metrics of :data:`RUNS`.

    ``metrics.json``, ``fig10.png`` and ``fig11.png`` are of the paper's taps on ``pins``.
    ``progress`` is called with what is being done and the part of it that is done.
    """
    results = []
    scenes: dict[str, Scene] = {}
    for controller, name, folder in RUNS:
        scene = scenes.setdefault(name, load_scene(find_scene(name)))
        label = f"{name} on {controller}"
        results.append(run_scene(scene, controller, out / folder, partial(progress, label)))
    run, reference = load_trace(out), load_trace(out / "analog")
    walls = scenes["paper_taps"].controller.walls
    pictures.fig10(run, reference, results[1], out / "fig10.png", walls)
    pictures.fig11(run, reference, results[1], out / "fig11.png")
    return results


def demo_table(results: list[dict[str, Any]], timed: bool = True) -> Table:
    """The demo's table: what was rendered, what was predicted, what the paper measured.

    ``timed``: with how fast the machine was.
    """
    table = Table(title="A virtual wall from the motor's own inductance")
    table.add_column("")
    _, taps, stiffest = results
    for metrics in (taps, stiffest):
        table.add_column(f"{metrics['scene']} on {metrics['controller']}", justify="right")
    rows: list[tuple[str, Callable[[dict[str, Any]], str]]] = [
        ("K measured, N·m/rad", lambda m: f"{m['stiffness']:.4f}"),
        ("K predicted, N·m/rad", lambda m: f"{m['stiffness_predicted']:.4f}"),
        ("the paper's prototype, N·m/rad", lambda m: f"{pictures.PAPER_MEASURED:.1f}"),
        ("K_L = k_T²/L, N·m/rad", lambda m: f"{m['k_l']:.4f}"),
        ("K measured over K_L", lambda m: f"{m['stiffness'] / m['k_l']:.3f}"),
        ("peak torque, N·m", lambda m: f"{m['peak_torque']:.4f}"),
        ("torque error against the analog circuit", lambda m: f"{m['torque_nrmse_vs_analog']:.1e}"),
    ]
    speeds: list[tuple[str, Callable[[dict[str, Any]], str]]] = [
        ("simulated seconds per second", lambda m: f"{m['duration_s'] / m['wall_clock_s']:.3f}"),
        ("clock cycles per second", lambda m: f"{m['clock_cycles'] / m['wall_clock_s']:.2e}"),
    ]
    for label, value in rows + (speeds if timed else []):
        table.add_row(label, value(taps), value(stiffest))
    return table
