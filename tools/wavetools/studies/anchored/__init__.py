# SPDX-License-Identifier: Apache-2.0
"""What the port anchor comes to: the numbers and pictures of ``docs/holding.md``.

Holds, slow presses, loads, heat, soft walls, bounces, free space, overloads and lost encoders of
one motor with one thing wrong or everything; random motors in random hands with everything wrong.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from wavehaptics.runtime.files import write_json
from wavehaptics.studies.report.runs import STORE
from wavehaptics.studies.sweeps import Task, sweep

from wavetools.studies.anchored import cases, hand, lost, motors, pictures

MOTORS, QUICK_MOTORS = 200, 24
"""Random motors; their seeds are 0 up to this."""


def tasks(quick: bool = False) -> dict[str, list[Task]]:
    """All tasks by the name of their group."""
    motors_asked = QUICK_MOTORS if quick else MOTORS
    return (
        cases.tasks(quick)
        | hand.tasks(quick)
        | lost.tasks()
        | {
            "motors": [Task(motors.random_motor, {"seed": seed}) for seed in range(motors_asked)],
            "courses": pictures.tasks(),
        }
    )


def collect(
    out: Path, workers: int | None, progress: Callable[[str, float], None], quick: bool = False
) -> dict[str, Any]:
    """Run everything; ``holding.json`` and the pictures into ``out``. Goes on where it stopped."""
    groups = tasks(quick)
    # The longest first, so that they don't end alone.
    order = sorted(groups, key=lambda name: name not in ("holds", "motors"))
    flat = [task for name in order for task in groups[name]]
    results = iter(
        sweep(
            flat, STORE, workers=workers or os.cpu_count() or 1,
            progress=lambda done, total: progress("holding", done / total),
        )
    )  # fmt: skip
    found = {name: [next(results) for _ in groups[name]] for name in order}
    found["bounces"] = [
        task.arguments | {"points": points}
        for task, points in zip(groups["bounces"], found["bounces"], strict=True)
    ]
    kept = write_json(out / "holding.json", found | {"quick": quick})
    found = json.loads(kept.read_bytes())
    pictures.draw(found, out)
    return found
