# SPDX-License-Identifier: Apache-2.0
"""A scene at every point of a grid of its keys."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from wavehaptics.api.runs import known_controller
from wavehaptics.api.scenes import Scene, as_toml, load_scene
from wavehaptics.scene import SceneError
from wavehaptics.studies import grid


def sweep(
    scene: Scene | str | Path, axes: Mapping[str, Sequence[Any]], controller: str = "golden", *,
    workers: int | None = None, cluster: str | None = None, out: str | Path | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[dict[str, Any]]:  # fmt: skip
    """Run a scene at every combination of values, and return a row for each, the last key fastest.

    ``axes`` has the values by ``table.key``, in the key's SI unit. A row has the keys, the scalar
    metrics by the names of ``metrics.json``, and ``error``: why the point is refused, or None.
    ``workers`` processes do the work, one a core by default, or a dask ``cluster`` at that address.
    With ``out``, a CSV file, a sweep that was interrupted goes on where it stopped. ``progress``
    takes the points done and all points. In a script call it below ``if __name__ == "__main__":``,
    as the processes import the script.
    """
    if not isinstance(scene, Scene):
        scene = load_scene(scene)
    values = {key: [_value(key, each) for each in several] for key, several in axes.items()}
    if not values or not all(values.values()):
        raise SceneError("sweep: nothing to sweep; give each key one value or more")
    of = grid.Grid(scene.path, scene.content, scene.changes, known_controller(controller), values)
    return grid.sweep(
        of, None if out is None else Path(out), workers=workers or os.cpu_count() or 1,
        cluster=cluster, progress=progress,
    )  # fmt: skip


def _value(key: str, value: Any) -> grid.Value:
    """A number, bool or bare string; of anything else its TOML."""
    if hasattr(value, "item") and getattr(value, "ndim", 1) == 0:
        value = value.item()
    return value if isinstance(value, int | float | str) else as_toml(key, value)
