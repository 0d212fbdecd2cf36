# SPDX-License-Identifier: Apache-2.0
"""A scene's run on a controller: its metrics and its trace."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from wavehaptics.api.scenes import Scene, load_scene
from wavehaptics.ladder.joint_run import TIP_TRACE
from wavehaptics.ladder.refusals import check_device
from wavehaptics.ladder.run import CONTROLLERS, run_device, trace_scene
from wavehaptics.scene import SceneError
from wavehaptics.scene.keys import nearest, unknown_choice
from wavehaptics.trace import columns, tip
from wavehaptics.trace.columns import load_trace

if TYPE_CHECKING:
    import pandas


class Trace(Mapping[str, np.ndarray]):
    """Arrays of a run by their names, each of shape (rows,); a tip's places and forces (rows, 3).

    A row is a kept period. The names of the arrays in ``trace.npz`` work as well: ``x`` is
    ``position``.
    """

    def __init__(
        self, arrays: Mapping[str, np.ndarray], names: Mapping[str, tuple[str, str]]
    ) -> None:
        """``names`` has the spelt-out name and the unit of each array."""
        self._arrays = {names[short][0]: array for short, array in arrays.items()}
        self._long = {short: names[short][0] for short in arrays}
        self.units = {names[short][0]: names[short][1] for short in arrays}
        """Unit of each array by its name; – stands for none."""

    def __getitem__(self, name: str) -> np.ndarray:
        try:
            return self._arrays[self._long.get(name, name)]
        except KeyError:
            near = nearest(name, self._arrays)
            meant = f"did you mean {near}? " if near else ""
            known = ", ".join(self._arrays) or "nothing; run.motors has a trace of each motor"
            raise KeyError(f"{name}: no such array; {meant}the trace has {known}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def to_pandas(self) -> pandas.DataFrame:
        """A table with a column of each array, ``position_0`` to ``position_2`` of a tip's.

        ``attrs["units"]`` has the units. :class:`ImportError` with the cure without pandas.
        """
        try:
            import pandas
        except ImportError:
            raise ImportError("to_pandas needs pandas; run `pip install pandas`") from None
        columns: dict[str, np.ndarray] = {}
        for name, array in self.items():
            if array.ndim == 1:
                columns[name] = array
            else:
                columns |= {f"{name}_{n}": array[:, n] for n in range(array.shape[1])}
        table = pandas.DataFrame(columns)
        table.attrs["units"] = dict(self.units)
        return table


@dataclass(frozen=True, eq=False)
class Run:
    """What came of a scene on a controller."""

    scene: Scene
    controller: str
    metrics: dict[str, Any]
    """By the names of ``metrics.json``, SI units; None where the run has no value for it."""
    trace: Trace
    """The motor's, or the tip's where the motors of a ``[device]`` move one; else empty."""
    notes: tuple[str, ...]
    """What the controller leaves out of the scene, a line each."""
    motors: dict[str, Run]
    """The run of each of several motors, by its name."""


def known_controller(name: str) -> str:
    """``name``, if it is a controller's; :class:`SceneError` with the cure if not."""
    if name not in CONTROLLERS:
        raise SceneError(f"controller {unknown_choice(name, CONTROLLERS)}")
    return name


def run(
    scene: Scene | str | Path, controller: str = "golden",
    progress: Callable[[float], None] | None = None,
) -> Run:  # fmt: skip
    """Simulate a scene on one of the controllers, as ``wavehaptics run`` does; no file is written.

    ``scene`` may be a path or the name of a shipped one. ``progress`` is called with the part that
    is done, 0 to 1. :class:`SceneError`, one line, where the controller can't do what the scene
    asks for.
    """
    if not isinstance(scene, Scene):
        scene = load_scene(scene)
    known_controller(controller)
    device = scene.device
    notes = tuple(check_device(device, controller))
    if len(device.motors) == 1 and device.space is None:
        metrics, arrays = trace_scene(device.scenes[0], controller, progress)
        return Run(scene, controller, metrics, Trace(arrays, columns.NAMES), notes, {})

    def show(motor: str, part: float) -> None:
        if progress is not None:
            progress(part)

    with TemporaryDirectory(prefix="wavehaptics-") as folder:
        out = Path(folder)
        metrics = run_device(device, controller, out, show)
        together = load_trace(out / TIP_TRACE) if device.space is not None else {}
        traces = {name: load_trace(out / name) for name in device.motors}
    motors = {
        name: Run(scene, controller, metrics["motors"][name], Trace(arrays, columns.NAMES), (), {})
        for name, arrays in traces.items()
    }
    return Run(scene, controller, metrics, Trace(together, tip.NAMES), notes, motors)
