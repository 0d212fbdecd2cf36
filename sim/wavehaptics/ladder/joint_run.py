# SPDX-License-Identifier: Apache-2.0
"""One run of a device: its motors together → traces → metrics → pictures."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.ladder.abilities import WITHOUT_WORDS, refuse
from wavehaptics.ladder.device_abilities import refuse_device
from wavehaptics.ladder.joint import JointSimulation
from wavehaptics.ladder.joint_host import JointLoop
from wavehaptics.ladder.joint_pins import JointPins
from wavehaptics.ladder.seen import seen
from wavehaptics.runtime.files import write_json
from wavehaptics.scene import Device
from wavehaptics.trace.columns import TRACE_FILE, Column, TraceWriter, Word
from wavehaptics.trace.metrics import Metrics
from wavehaptics.trace.pictures import run_picture
from wavehaptics.trace.shaft import ShaftMetrics
from wavehaptics.trace.tip import Tip, TipMetrics, TipTrace
from wavehaptics.trace.tip_picture import tip_picture

CHUNK_TICKS = 1 << 14
"""Ticks at a time."""

TIP_TRACE, TIP_PICTURE = "tip.npz", "tip.png"

OF_A_MOTOR = (
    "scene", "controller", "duration_s", "wall_clock_s", "ticks", "tick_hz", "clock_cycles", "k_l",
    "peak_torque", "peak_current_a", "current_ripple_a", "energy_out_max_j", "saturated_fraction",
    "clipped_fraction", "correction_out_max_j", "correction_bound_j", "x_hat_error_rms_rad",
    "omega_hat_error_rms", "anchor_fault_s",
)  # fmt: skip
"""Metrics that a motor of a device has for itself; what a wall feels like is the tip's."""


def _simulation(device: Device, controller: str) -> JointLoop:
    return JointPins(device) if controller == "pins" else JointSimulation(device, controller)


class _Gathered:
    """Traces and metrics of a device's run."""

    def __init__(
        self, device: Device, controller: str, simulation: JointLoop, ticks: int
    ) -> None:  # fmt: skip
        self._simulation, tick_s = simulation, simulation.tick_s
        self._words = controller not in WITHOUT_WORDS
        anchored = [set_.anchored and self._words for set_ in simulation.settings]
        self.metrics = [
            Metrics(scene, tick_s, controller=controller, root=set_.s if has else None)
            for scene, set_, has in zip(device.scenes, simulation.settings, anchored, strict=True)
        ]
        self.tip = TipMetrics(
            simulation.space, device.scenes, controller, tick_s, simulation.joint_stiffness,
            simulation.wished_compliance(), simulation.predicted(), simulation.count_m,
        )  # fmt: skip
        self.shaft = None
        if simulation.line_ticks >= 0:
            self.shaft = ShaftMetrics(
                ticks, tick_s, simulation.shaft_predicted(), simulation.settings[0].cell_rad
            )

    def update(self, rows: np.ndarray, tips: np.ndarray) -> None:
        self.tip.update(tips, rows)
        if self.shaft is not None:
            self.shaft.update(rows)
        for metrics, of_motor in zip(self.metrics, rows, strict=True):
            alone = of_motor.copy()
            alone[:, Column.CONTACT] = 0.0  # the wall is no motor's
            metrics.update(alone)

    def result(self, wall_clock_s: float) -> tuple[dict[str, Any], list[dict[str, Any]]]:
        """Metrics of the tip and of each motor."""
        of_motors = []
        for n, metrics in enumerate(self.metrics):
            found = metrics.result(
                wall_clock_s=wall_clock_s, clock_cycles=self._simulation.clock_cycles
            )
            own = {key: found[key] for key in OF_A_MOTOR}
            if isinstance(self._simulation, JointPins):
                own |= seen(self._simulation.motors[n])
            of_motors.append(own)
        tip = self.tip.result(wall_clock_s)
        if self.shaft is not None:
            tip = {**tip, **self.shaft.result()}
        return {**tip, "singular_updates": self._simulation.singular_updates}, of_motors


def measure_device(
    device: Device,
    controller: str,
    progress: Callable[[float], None] = lambda part: None,
    keep: Callable[[np.ndarray, np.ndarray, np.ndarray], None] = lambda rows, words, tips: None,
) -> dict[str, Any]:
    """Metrics of a device's run; nothing is written.

    ``keep`` takes each chunk: rows (motors, ticks, Column), words (motors, ticks, Word) and tips
    (ticks, Tip). ``progress`` is called with the part done. The result has ``scene``,
    ``controller``, ``duration_s``, ``wall_clock_s``, ``ticks``, the metrics of
    :mod:`wavehaptics.trace.tip`, and in ``motors`` those of each motor.
    """
    for scene in device.scenes:
        refuse(scene, controller)
    refuse_device(device, controller)
    simulation = _simulation(device, controller)
    ticks = max(1, round(device.scenes[0].scene.duration_s / simulation.tick_s))
    gathered = _Gathered(device, controller, simulation, ticks)
    motors, room = len(device.scenes), min(ticks, CHUNK_TICKS)
    rows = np.zeros((motors, room, len(Column)))
    words = np.zeros((motors, room, len(Word)), dtype=np.int64)
    tips = np.zeros((room, len(Tip)))
    simulation.advance(rows[:, :0], words[:, :0], tips[:0])  # compiles
    wall_clock_s = 0.0
    for first in range(0, ticks, CHUNK_TICKS):
        size = min(CHUNK_TICKS, ticks - first)
        chunk = rows[:, :size], words[:, :size], tips[:size]
        began = time.perf_counter()
        simulation.advance(*chunk)
        wall_clock_s += time.perf_counter() - began
        gathered.update(chunk[0], chunk[2])
        keep(*chunk)
        progress((first + size) / ticks)
    tip, of_motors = gathered.result(wall_clock_s)
    return {
        "scene": device.name,
        "controller": controller,
        "duration_s": round(ticks * simulation.tick_s, 12),
        "wall_clock_s": wall_clock_s,
        "ticks": ticks,
        **tip,
        "motors": dict(zip(device.motors, of_motors, strict=True)),
    }


def run_joint(
    device: Device,
    controller: str,
    out: Path,
    progress: Callable[[float], None] = lambda part: None,
) -> dict[str, Any]:
    """Run a device as :func:`measure_device`, and write its files into ``out``.

    ``metrics.json``, ``tip.npz`` and ``tip.png`` are the device's; a folder for each motor, of its
    name, has ``trace.npz``, ``metrics.json`` and ``run.png``. Returns the metrics.
    """
    tick_s = 1.0 / device.scenes[0].controller.tick_hz
    thin_hz = device.scenes[0].scene.trace_hz
    tip_trace = TipTrace(tick_s, thin_hz)
    has_words = controller not in WITHOUT_WORDS
    traces = [
        TraceWriter(
            out / name / TRACE_FILE, tick_s, thin_hz,
            anchored=has_words and scene.controller.anchored,
        )
        for name, scene in device.motors.items()
    ]  # fmt: skip

    def keep(rows: np.ndarray, words: np.ndarray, tips: np.ndarray) -> None:
        tip_trace.write(tips)
        for trace, of_motor, its_words in zip(traces, rows, words, strict=True):
            trace.write(of_motor, its_words if has_words else None)

    result = measure_device(device, controller, progress, keep)
    tip_trace.save(out / TIP_TRACE)
    assert device.space is not None
    tip_picture(device.space, tip_trace.arrays(), result, out / TIP_PICTURE)
    for (name, scene), trace in zip(device.motors.items(), traces, strict=True):
        trace.save()
        of_motor = {"motor": name, **result["motors"][name]}
        write_json(out / name / "metrics.json", of_motor)
        run_picture(trace.arrays(), of_motor, out / name / "run.png", scene.controller.walls)
    write_json(out / "metrics.json", result)
    return result
