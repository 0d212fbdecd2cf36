# SPDX-License-Identifier: Apache-2.0
"""What a board does with a motor before anyone solders: a tap on its wall, and a hold.

A brushless motor is tapped and held with half the torque; what it has no brushes for isn't wrong.

Both are the scene of the board's ``board.toml`` with another hand, on what was flashed
(:mod:`wavetools.fpga.board_simulation`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from wavehaptics.controller.ports import bus_voltage
from wavehaptics.fpga.boards import Board
from wavehaptics.ladder.run import measure
from wavehaptics.runtime.files import write_json
from wavehaptics.scene import Scene
from wavehaptics.trace.columns import Column, TraceWriter
from wavehaptics.trace.pictures import run_picture

from wavetools.fpga.board_simulation import Build, board_scene, on_board

TAP = ("hand.path=taps", "hand.amplitude_rad=0.05", "hand.frequency_hz=10", "hand.stiffness=0.4",
       "scene.duration_s=0.055", "scene.trace_hz=100e3")  # fmt: skip
"""Into the wall and to the deepest point."""

NOISE_A = 1e-3
"""Noise of the current at least; words without any are a stuck ADC to the guard."""

PRESS_NM = {False: 0.014, True: 0.007}
"""Torque of the hold, N·m, by whether the motor is brushless."""

RAMP_S, HOLD_S = 0.05, 0.95
"""The press's ramp, and how long it is held after that: until the rotor is at rest.

The supply steps in the middle. After ramp and step the anchor takes a quarter of a second, in which
the rotor may bounce from one edge of a count to the other.
"""

QUIET_NM = 60e-6
"""Ripple of the hold at most, N·m RMS: 0.4 % of the press, of which a hand feels 7 %."""

PRESS = {
    False: {"path": "press", "amplitude_rad": 0.15, "stiffness": 0.1, "damping": 0.5e-3},
    True: {"path": "press", "amplitude_rad": 0.15, "stiffness": 0.05, "damping": 0.3e-3},
}

LAG_S = 0.3e-6
BRUSH_V = 0.5

MAGNET_RAD = 0.3
"""Where the magnets of a held brushless motor are, which nobody has told."""

SHOWN = ("stiffness", "stiffness_predicted", "peak_torque", "held_nm", "moved_cells",
         "moved_limit_cells", "hold_ripple_rms", "free_space_torque_rms", "clock_cycles",
         "clocks_per_s")  # fmt: skip
"""What is told of a run; all the rest is in its file."""


def tap(board: Board) -> Scene:
    """A tap with a motor that is what the board takes it for, on the board's wall."""
    return board_scene(board, (*TAP, _noise(board)))


def _noise(board: Board) -> str:
    assert board.scene.adc is not None
    return f"adc.noise_a={max(NOISE_A, board.scene.adc.noise_a)!r}"


def hold(board: Board, sign: int = 1) -> Scene:
    """A press on the board's wall with a motor that is all that a real one is.

    Brushes whose voltage nobody told the controller, a winding that changes from bar to bar, the
    noise of a sliding contact, a slow amplifier, a supply that steps; and of R, L, k_T, gain and
    offset the board knows others by ``sign`` times what a motor may be off.
    """
    if board.brushless:
        return _brushless_hold(board, sign)
    controller, motor, bus_v = board.scene.controller, board.scene.motor, bus_voltage(board.scene)
    return board_scene(board, (
        f"scene.duration_s={RAMP_S + HOLD_S}", "scene.trace_hz=100e3",
        # The bitstream's own words, whatever the motor is.
        f"controller.r_hat={controller.r_hat!r}", f"controller.l_hat={controller.l_hat!r}",
        f"controller.k_t_hat={controller.k_t_hat!r}",
        f"motor.R_ohm={motor.R_ohm / (1 + 0.1 * sign)!r}",
        f"motor.L_h={motor.L_h / (1 + 0.1 * sign)!r}",
        f"motor.k_t={motor.k_t / (1 + 0.1 * sign)!r}",
        f"brushes.drop_v={BRUSH_V}", "brushes.knee_a=5e-3", "brushes.segments=22",
        f"brushes.ripple={0.04 * sign}", "brushes.contact_noise=0.03",
        f"drive.step_v={0.05 * sign * bus_v!r}", f"drive.step_s={RAMP_S + 0.5 * HOLD_S}",
        f"drive.gain_error={0.05 * sign}", f"adc.offset_a={4e-3 * sign}", _noise(board),
        f"adc.bandwidth_hz={1 / (2 * math.pi * LAG_S):.6g}",
    ), PRESS[False])  # fmt: skip


def _brushless_hold(board: Board, sign: int) -> Scene:
    """As :func:`hold`, of a brushless motor.

    R̂ is off by a tenth, the drive's gain, the zero of both phases, and the back-EMF's shape.
    """
    controller, motor = board.scene.controller, board.scene.motor
    return board_scene(board, (
        f"scene.duration_s={RAMP_S + HOLD_S}", "scene.trace_hz=100e3",
        f"controller.r_hat={controller.r_hat!r}", f"motor.R_ohm={motor.R_ohm / (1 + 0.1 * sign)!r}",
        f"controller.magnet_hat_rad={controller.magnet_hat_rad!r}",
        f"motor.magnet_rad={MAGNET_RAD}", "motor.harmonic_5=0.03",
        f"drive.gain_error={0.05 * sign}", f"adc.offset_a={2e-3 * sign}", _noise(board),
    ), PRESS[True])  # fmt: skip


def without_edges(scene: Scene) -> Scene:
    """The scene for `golden`, whose bridge has no edges for an amplifier."""
    assert scene.adc is not None
    none = {"edge_hold_s": 0.0, "edge_settle_s": None, "common_mode_a": 0.0}
    return scene.model_copy(update={"adc": scene.adc.model_copy(update=none)})


class _Deepest:
    """Hands ticks on to a trace, and keeps the one in which the rotor was deepest."""

    def __init__(self, trace: TraceWriter | None) -> None:
        self._trace = trace
        self.row = np.full(len(Column), -math.inf)

    def write(self, rows: np.ndarray, words: np.ndarray | None = None) -> None:
        """Take the next ticks."""
        row = rows[np.argmax(rows[:, Column.X])]
        if row[Column.X] > self.row[Column.X]:
            self.row = row.copy()
        if self._trace is not None:
            self._trace.write(rows, words)


def run(
    built: Build, scene: Scene, out: Path | None = None, name: str = "run",
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Metrics of a scene on a built board, and ``pins``, what its pins have shown.

    It is started by its button.
    With ``out``, a folder, they go into ``<name>.json`` there, and a picture into ``<name>.png``.
    """
    simulation = on_board(built, scene)
    tick_s = simulation.tick_s
    ticks = max(1, round(scene.scene.duration_s / tick_s))
    trace = None
    if out is not None:
        trace = TraceWriter(out, tick_s, scene.scene.trace_hz, ticks=ticks)
    deepest = _Deepest(trace)
    begun = simulation.report().clocks
    metrics = measure(
        scene, "a board", trace=deepest, progress=progress, simulation=simulation, compare=False
    )
    report = simulation.report()
    metrics["pins"] = asdict(report)
    metrics["clocks_per_s"] = (report.clocks - begun) / metrics["wall_clock_s"]
    metrics |= moved(built.board, metrics, deepest.row)
    if trace is not None:
        assert out is not None
        write_json(out / f"{name}.json", metrics)
        run_picture(trace.arrays(), metrics, out / f"{name}.png", scene.controller.walls)
    return metrics


def moved(board: Board, metrics: dict[str, Any], deepest: np.ndarray) -> dict[str, Any]:
    """How far the wall is from where its spring says, in cells, and how far it may be.

    That is a count and 1 % of the depth. Of a hold in the last tenth of the run, with
    the force held; else where the rotor was deepest, ``deepest`` (Column).
    """
    assert board.scene.encoder is not None
    cell = 2 * math.pi / board.scene.encoder.counts_per_rev
    spring, edge = metrics["stiffness_predicted"], metrics["contact_edge_rad"]
    offset, part = metrics["hold_offset_rad"], metrics["hold_error"]
    found = {}
    if offset is not None and part:
        depth = offset / part
        found["held_nm"] = abs(metrics["hold_torque"])
    elif edge is not None:
        depth = deepest[Column.X] - edge
        offset = deepest[Column.TORQUE] / spring + depth
    else:
        return {}
    return found | {
        "moved_cells": float(abs(offset) / cell),
        "moved_limit_cells": float(1.0 + 0.01 * abs(depth) / cell),
    }
