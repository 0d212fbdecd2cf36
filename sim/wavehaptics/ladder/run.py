# SPDX-License-Identifier: Apache-2.0
"""One run of a scene: simulation → trace → metrics → picture."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from wavehaptics.controller.settings import Settings
from wavehaptics.controller.turns import take_turns
from wavehaptics.ladder.abilities import WITHOUT_WORDS, refuse
from wavehaptics.ladder.analog import AnalogSimulation
from wavehaptics.ladder.brushless import BrushlessAnalogSimulation, BrushlessSimulation
from wavehaptics.ladder.brushless_pins import BrushlessPinsSimulation
from wavehaptics.ladder.design_spring import rendered_stiffness
from wavehaptics.ladder.encoder import EncoderSimulation
from wavehaptics.ladder.field_oriented import FieldOrientedSimulation
from wavehaptics.ladder.joint_run import run_joint
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.ladder.r_hat_error import Estimate
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.ladder.seen import seen
from wavehaptics.ladder.turns_pins import TurnsSimulation
from wavehaptics.runtime.files import write_json
from wavehaptics.scene import Device, Scene
from wavehaptics.trace.columns import TRACE_FILE, Column, TraceWriter, Word
from wavehaptics.trace.metrics import Metrics
from wavehaptics.trace.pictures import run_picture

CHUNK_TICKS = 1 << 15
"""Ticks simulated at a time: enough to hide Python's overhead, few enough for the caches."""


class Recorder(Protocol):
    """Receives the ticks of a run, such as a :class:`TraceWriter`."""

    def write(self, rows: np.ndarray, words: np.ndarray | None = None) -> None:
        """Take the next ticks: ``rows`` (Column) and ``words`` (Word)."""


class Simulation(Protocol):
    """A scene on one controller, advanced tick by tick."""

    settings: Settings
    tick_s: float

    @property
    def clock_cycles(self) -> int | None:
        """Clocks of the RTL so far; None without RTL."""

    def advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column) and ``words`` (Word)."""


def analog(
    scene: Scene, tick_s: float | None = None, cell_rad: float | None = None
) -> AnalogSimulation | BrushlessAnalogSimulation:
    """The analog circuit, or two for a brushless motor, in steps of ``tick_s``."""
    kind = BrushlessAnalogSimulation if scene.motor.brushless else AnalogSimulation
    return kind(scene, tick_s, cell_rad)


def _sampled(scene: Scene, rtl: bool) -> Simulation:
    """The wave core with one port, or two for a brushless motor, as integers or as RTL."""
    kind = BrushlessSimulation if scene.motor.brushless else SampledSimulation
    return kind(scene, rtl=rtl)


def _pins(scene: Scene) -> Simulation:
    """The whole RTL at its pins, for a motor with or without brushes."""
    kind = BrushlessPinsSimulation if scene.motor.brushless else PinsSimulation
    return kind(scene)


def _encoder(scene: Scene) -> Simulation:
    """The baseline: sampled impedance control on a current amplifier or field-oriented control."""
    kind = FieldOrientedSimulation if scene.motor.brushless else EncoderSimulation
    return kind(scene)


CONTROLLERS: dict[str, Callable[[Scene], Simulation]] = {
    "analog": analog,
    "golden": lambda scene: _sampled(scene, rtl=False),
    "core": lambda scene: _sampled(scene, rtl=True),
    "pins": _pins,
    "encoder": _encoder,
}
"""The simulation of each controller level, by its name."""


def stiffness_predicted(scene: Scene, simulation: Simulation, shaped: bool | None = None) -> float:
    """K of the design spring for contact (:func:`closed_forms.stiffness`), N·m/rad.

    ``shaped`` chooses walls with or without W; by default those with W, if there are any.

    The controller's delay acts on R̂; the analog circuit has τ = 1/λ. With a port anchor the spring
    is ``k_T k̂_T/L̂_eff``: the anchor's flux uses L̂ and k̂_T, and the current is the motor's.
    Without one, inductance and torque are the motor's own. W is designed for k̂_T, so it renders
    ``(k_T/k̂_T)²`` of its target impedance, in series with the motor's spring. The encoder's servo
    renders the spring that it computes, with a current for k̂_T. A brushless motor's two ports feel
    like one with k_T = √1.5·pψ.
    """
    if isinstance(simulation, EncoderSimulation | FieldOrientedSimulation):
        return simulation.stiffness * (scene.motor.felt_k_t / scene.controller.k_t_hat)
    set_ = simulation.settings
    continuous = isinstance(simulation, AnalogSimulation | BrushlessAnalogSimulation)
    tau = 1.0 / scene.controller.lambda_ if continuous else set_.tau
    shaped = bool(set_.shaped.any()) if shaped is None else shaped
    wish = set_.shaper.wish if shaped else None
    return rendered_stiffness(
        scene, set_.r_hat, tau, scene.controller.eta_contact, set_.anchored and not continuous,
        wish.spring if wish is not None else None,
    )  # fmt: skip


def measure(
    scene: Scene,
    controller: str,
    trace: Recorder | None = None,
    progress: Callable[[float], None] | None = None,
    simulation: Simulation | None = None,
    compare: bool = True,
) -> dict[str, Any]:
    """Metrics of a scene on a controller. It writes only into ``trace``, if that is given.

    ``simulation`` replaces the controller's simulation of the scene.

    The analog circuit runs in parallel on the same ticks as the reference, unless ``compare`` is
    false. ``progress`` is called with the fraction done, 0 to 1. ``wall_clock_s`` is the time for
    controller and motor, without compilation, reference and files.
    """
    refuse(scene, controller)
    simulation = simulation or CONTROLLERS[controller](scene)
    one = _Measurement(scene, controller, simulation, trace, compare)
    return _measured([one], _alone(simulation), progress)[0]


Advance = Callable[[Sequence[np.ndarray], Sequence[np.ndarray]], None]
"""Simulates ticks into the rows and the words of each motor."""


def _alone(simulation: Simulation) -> Advance:
    return lambda rows, words: simulation.advance(rows[0], words[0])


class _Measurement:
    """Metrics, trace and reference of one motor, from its ticks."""

    def __init__(
        self, scene: Scene, controller: str, simulation: Simulation, trace: Recorder | None,
        compare: bool = True,
    ) -> None:  # fmt: skip
        set_, tick_s = simulation.settings, simulation.tick_s
        self._scene, self._controller, self._simulation = scene, controller, simulation
        self._trace, self._compare = trace, compare
        self.ticks = ticks = _ticks(scene, tick_s)
        self._reference = None
        # The analog circuit has no W: it would be another environment.
        if compare and controller != "analog" and scene.shaper is None:
            self._reference = analog(scene, tick_s, set_.cell_rad)
        edges = zip(set_.wall_min * set_.cell_rad, set_.wall_max * set_.cell_rad, strict=True)
        self._metrics = Metrics(
            scene, tick_s, controller=controller, walls=list(edges),
            stiffness_predicted=stiffness_predicted(scene, simulation),
            springs=[
                stiffness_predicted(scene, simulation, shaped) for shaped in set_.shaped.tolist()
            ],
            root=set_.s if _anchored(controller, simulation) else None,
            shape_power=_shape_power(simulation),
            reference_spring=_reference_spring(scene, controller, simulation, self._reference),
        )  # fmt: skip
        self.rows = np.zeros((min(ticks, CHUNK_TICKS), len(Column)))
        self.words = np.zeros((len(self.rows), len(Word)), dtype=np.int64)
        self._reference_rows = np.zeros_like(self.rows)
        self._estimate = Estimate(scene, ticks)

    def take(self, part: slice, done: int) -> None:
        """Take ``part`` of the rows and words; ``done`` is the number of ticks so far."""
        rows, reference_rows = self.rows[part], self._reference_rows[part]
        if self._reference is not None:
            self._reference.advance(reference_rows)
        self._metrics.update(rows, None if self._reference is None else reference_rows)
        self._estimate.update(self._simulation, done)
        if self._trace is not None:
            without = self._controller in WITHOUT_WORDS
            self._trace.write(rows, None if without else self.words[part])

    def result(self, wall_clock_s: float) -> dict[str, Any]:
        simulation = self._simulation
        result = self._metrics.result(
            wall_clock_s=wall_clock_s, clock_cycles=simulation.clock_cycles
        )
        if self._compare and self._controller != "analog" and self._scene.shaper is not None:
            result["reasons"]["torque_nrmse_vs_analog"] = "the analog circuit has no W"
        return result | self._estimate.result() | seen(simulation)


def _measured(
    motors: Sequence[_Measurement], advance: Advance, progress: Callable[[float], None] | None
) -> list[dict[str, Any]]:
    """Metrics of each motor. Motors that ``advance`` simulates together share its time equally."""
    ticks = motors[0].ticks
    # The first call compiles, or loads what an earlier run compiled: no ticks, but all the types.
    advance([one.rows[:0] for one in motors], [one.words[:0] for one in motors])
    wall_clock_s = 0.0
    for first in range(0, ticks, CHUNK_TICKS):
        part = slice(0, min(CHUNK_TICKS, ticks - first))
        began = time.perf_counter()
        advance([one.rows[part] for one in motors], [one.words[part] for one in motors])
        wall_clock_s += time.perf_counter() - began
        for one in motors:
            one.take(part, first + part.stop)
        if progress is not None:
            progress((first + part.stop) / ticks)
    return [one.result(wall_clock_s / len(motors)) for one in motors]


def _anchored(controller: str, simulation: Simulation) -> bool:
    """Whether the rows contain a port anchor's values."""
    return simulation.settings.anchored and controller not in WITHOUT_WORDS


def _reference_spring(
    scene: Scene,
    controller: str,
    simulation: Simulation,
    reference: AnalogSimulation | BrushlessAnalogSimulation | None,
) -> float | None:
    """K of the reference's wall, if the controller holds its wall by the encoder; else None."""
    if reference is None or not (controller == "encoder" or _anchored(controller, simulation)):
        return None
    return stiffness_predicted(scene, reference)


def _shape_power(simulation: Simulation) -> int:
    """Power of the motor's own k_T in a wall's stiffness: see :class:`Metrics`."""
    own = isinstance(simulation, AnalogSimulation | BrushlessAnalogSimulation)
    servo = isinstance(simulation, EncoderSimulation | FieldOrientedSimulation)
    return 1 if servo or (simulation.settings.anchored and not own) else 2


def _ticks(scene: Scene, tick_s: float) -> int:
    return max(1, round(scene.scene.duration_s / tick_s))


def run_scene(
    scene: Scene,
    controller: str,
    out: Path,
    progress: Callable[[float], None] | None = None,
    motor: str | None = None,
) -> dict[str, Any]:
    """Run a scene as :func:`measure`, and write ``trace.npz``, ``metrics.json`` and ``run.png``.

    The files go into ``out``. ``motor`` is the motor's name in a scene of several. Returns the
    metrics.
    """
    run, result = _ran(scene, controller, out, progress)
    return run.write(result, motor)


def trace_scene(
    scene: Scene, controller: str, progress: Callable[[float], None] | None = None
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Metrics and arrays of a run as :func:`run_scene` has them, without its files."""
    run, result = _ran(scene, controller, Path(), progress)
    return result, run.arrays()


def _ran(
    scene: Scene, controller: str, out: Path, progress: Callable[[float], None] | None
) -> tuple[_Run, dict[str, Any]]:
    """A run that is over, and its metrics."""
    refuse(scene, controller)
    simulation = CONTROLLERS[controller](scene)
    run = _Run(scene, controller, simulation, out)
    (result,) = _measured([run.measurement], _alone(simulation), progress)
    return run, result


class _Run:
    """A motor's run, and its files."""

    def __init__(self, scene: Scene, controller: str, simulation: Simulation, out: Path) -> None:
        self._scene, self._out = scene, out
        tick_s = simulation.tick_s
        self._trace = TraceWriter(
            out / TRACE_FILE, tick_s, scene.scene.trace_hz, ticks=_ticks(scene, tick_s),
            anchored=_anchored(controller, simulation),
        )  # fmt: skip
        self.measurement = _Measurement(scene, controller, simulation, self._trace)

    def arrays(self) -> dict[str, np.ndarray]:
        """What is in ``trace.npz``."""
        return self._trace.arrays()

    def write(self, result: dict[str, Any], motor: str | None) -> dict[str, Any]:
        """Write the files of a run with this result, which is returned with the motor's name."""
        if motor is not None:
            result = {"motor": motor, **result}
        self._trace.save()
        write_json(self._out / "metrics.json", result)
        walls = self._scene.controller.walls
        run_picture(self._trace.arrays(), result, self._out / "run.png", walls)
        return result


def run_device(
    device: Device,
    controller: str,
    out: Path,
    progress: Callable[[str, float], None] = lambda motor, part: None,
) -> dict[str, Any]:
    """Run each motor as :func:`run_scene`, into a folder of its name in ``out``.

    Motors of a ``[device]`` run together, :func:`wavehaptics.ladder.joint_run.run_joint`. Others
    aren't coupled. On ``pins``, motors with brushes are ports of one controller: they run together
    and share its time. All others run one after another. ``out`` gets a ``metrics.json`` with what
    the motors have in common, and the metrics of each in ``motors``.
    ``progress`` is called with the motor's name and the fraction of its run that is done.
    """
    if device.space is not None:
        return run_joint(device, controller, out, partial(progress, device.name))
    for scene in device.scenes:
        refuse(scene, controller)
    if controller == "pins" and take_turns(device.scenes):
        motors = _run_together(device, out, progress)
    else:
        motors = {
            name: run_scene(scene, controller, out / name, partial(progress, name), name)
            for name, scene in device.motors.items()
        }
    result = {
        "scene": device.name,
        "controller": controller,
        "duration_s": max(one["duration_s"] for one in motors.values()),
        "wall_clock_s": sum(one["wall_clock_s"] for one in motors.values()),
        "motors": motors,
    }
    write_json(out / "metrics.json", result)
    return result


def _run_together(
    device: Device, out: Path, progress: Callable[[str, float], None]
) -> dict[str, dict[str, Any]]:
    """Write the files of the motors of one controller, and return the metrics of each."""
    simulation = TurnsSimulation(device.scenes)
    runs = {
        name: _Run(scene, "pins", motor, out / name)
        for (name, scene), motor in zip(device.motors.items(), simulation.motors, strict=True)
    }

    def show(part: float) -> None:
        for name in runs:
            progress(name, part)

    measurements = [run.measurement for run in runs.values()]
    results = _measured(measurements, simulation.advance, show)
    return {
        name: run.write(result, name)
        for (name, run), result in zip(runs.items(), results, strict=True)
    }
