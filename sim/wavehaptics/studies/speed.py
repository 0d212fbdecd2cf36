# SPDX-License-Identifier: Apache-2.0
"""How fast each rung of the fidelity ladder simulates, and with what error."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rich.table import Table

from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.scene import Scene


def measure_speed(scene: Scene, progress: Callable[[str, float], None]) -> list[dict[str, Any]]:
    """Metrics of one run of the scene on each controller."""
    return [measure(scene, name, progress=partial(progress, name)) for name in CONTROLLERS]


def speed_table(results: list[dict[str, Any]]) -> Table:
    """Speed against error, a row a controller."""
    table = Table(title=f"{results[0]['scene']}, {results[0]['duration_s']:g} s simulated")
    table.add_column("controller")
    for heading in ("simulated s per s", "ticks per s", "clock cycles per s", "torque error"):
        table.add_column(heading, justify="right")
    for metrics in results:
        wall_s, cycles = metrics["wall_clock_s"], metrics["clock_cycles"]
        error = metrics["torque_nrmse_vs_analog"]
        table.add_row(
            metrics["controller"],
            f"{metrics['duration_s'] / wall_s:.3g}",
            f"{metrics['ticks'] / wall_s:.2e}",
            "–" if cycles is None else f"{cycles / wall_s:.2e}",
            "–" if error is None else f"{error:.1e}",
        )
    return table
