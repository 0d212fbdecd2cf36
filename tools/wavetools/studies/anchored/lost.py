# SPDX-License-Identifier: Apache-2.0
"""An encoder that stops, skips or counts backwards: what is noticed, and how large the force gets.

A lost encoder looks like a voltage, so what is noticed depends on how fast the rotor moves. Each
case is compared with the same motion with a sound encoder: the largest torque afterwards over the
largest that the sound one has had until then, and over what it has from then on.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace.columns import Column

from wavetools.studies.anchored.cases import BRUSHES, NOTHING
from wavetools.studies.anchored.runs import cell_of, run

SPEEDS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 50.0)
"""Speed of the hand in free space when the encoder is lost, rad/s."""
MOMENTS = (0.25, 0.5, 0.75)
"""When the encoder is lost in a contact, in parts of its length."""
KINDS = ("stops", "reverses")
SKIPS = (1, 10, 100, 1000)
PART_S = 50e-6


def _compare(settings: list[str], lose: str, lost_s: float) -> dict[str, Any]:
    """A run with a lost encoder beside that with a sound one."""
    sound_scene = load("held_wall", settings)
    cell = cell_of(sound_scene)
    _, sound = run(sound_scene, part_s=PART_S)
    metrics, rows = run(load("held_wall", [*settings, lose]), part_s=PART_S)
    late = sound[:, Column.T] > lost_s
    before = float(np.max(np.abs(sound[~late, Column.TORQUE]), initial=0.0))
    at = int(np.argmax(late))
    fault_s = metrics["anchor_fault_s"]
    noticed = None
    if fault_s is not None:
        way = rows[(rows[:, Column.T] > lost_s) & (rows[:, Column.T] <= fault_s), Column.OMEGA]
        noticed = float(np.sum(np.abs(way)) * PART_S / cell)
    return {
        "lost_s": lost_s,
        "omega": float(sound[at, Column.OMEGA]),
        "force": float(abs(sound[at, Column.TORQUE])),
        "force_before": before,
        "sound_after": float(np.max(np.abs(sound[late, Column.TORQUE]))),
        "lost_after": float(np.max(np.abs(rows[late, Column.TORQUE]))),
        "speed_after": float(np.max(np.abs(rows[late, Column.OMEGA]))),
        "sound_speed": float(np.max(np.abs(sound[late, Column.OMEGA]))),
        "noticed_cells": noticed,
        "fault_s": fault_s,
    }


def held(kind: str, stiffness: float, brush: bool) -> dict[str, Any]:
    """A press that rests when the encoder is lost."""
    settings = [
        *NOTHING, "scene.duration_s=0.6", f"hand.stiffness={stiffness}",
        f"hand.amplitude_rad={0.0144 / stiffness + 0.0063}", *(BRUSHES if brush else ()),
    ]  # fmt: skip
    found = _compare(settings, f"encoder.{kind}_at_s=0.4", 0.4)
    return {"case": "held", "kind": kind, "stiffness": stiffness, "brush": brush} | found


def in_contact(kind: str, speed: float, moment: float, brush: bool) -> dict[str, Any]:
    """A tap; ``speed`` is the hand's as it meets the wall, and the force is about that of a press.

    The encoder is lost at ``moment``, a part of the tap's time.
    """
    force, stiffness = 0.0144, 0.2
    amplitude = force / stiffness + 0.0063
    frequency = min(speed / (2 * math.pi * amplitude), 60.0)
    settings = [
        *NOTHING, "hand.path=taps", f"hand.amplitude_rad={amplitude}",
        f"hand.stiffness={stiffness}", f"hand.frequency_hz={frequency}",
        f"scene.duration_s={1.0 / frequency}",
        *(BRUSHES if brush else ()),
    ]  # fmt: skip
    lost_s = (0.25 + 0.5 * moment) / frequency
    found = _compare(settings, f"encoder.{kind}_at_s={lost_s}", lost_s)
    return {"case": "tap", "kind": kind, "speed": speed, "moment": moment, "brush": brush} | found


def in_free_space(kind: str, speed: float, brush: bool) -> dict[str, Any]:
    """A hand that swings the rotor clear of walls loses the encoder at its fastest."""
    amplitude = 0.5
    frequency = speed / (2 * math.pi * amplitude)
    duration = min(1.0 / frequency, 1.0)
    lost_s = 0.25 * duration if duration < 1.0 / frequency else 0.5 / frequency
    settings = [
        *NOTHING, "hand.path=free", f"hand.amplitude_rad={amplitude}", "hand.stiffness=2",
        "hand.damping=2e-3", f"hand.frequency_hz={frequency}", f"scene.duration_s={duration}",
        *(BRUSHES if brush else ()),
    ]  # fmt: skip
    found = _compare(settings, f"encoder.{kind}_at_s={lost_s}", lost_s)
    return {"case": "free", "kind": kind, "speed": speed, "brush": brush} | found


def skipping(edges: int, frequency: float) -> dict[str, Any]:
    """Taps with an encoder that loses ``edges`` of a revolution."""
    settings = [
        *NOTHING, "hand.path=taps", "hand.amplitude_rad=0.15", f"hand.frequency_hz={frequency}",
        f"scene.duration_s={1.0 / frequency}",
    ]  # fmt: skip
    found = _compare(settings, f"encoder.skips_per_rev={edges}", 0.0)
    return {"case": "skips", "edges": edges, "frequency": frequency} | found


def tasks() -> dict[str, list[Task]]:
    """Tasks of the group ``lost``."""
    grid = itertools.product
    return {
        "lost": [
            *(
                Task(held, {"kind": kind, "stiffness": stiffness, "brush": brush})
                for kind, stiffness, brush in grid(KINDS, (0.1, 1.0), (False, True))
            ),
            *(
                Task(in_contact, {"kind": kind, "speed": speed, "moment": moment, "brush": brush})
                for kind, speed, moment, brush in grid(
                    KINDS, (0.1, 0.3, 1.0, 3.0), MOMENTS, (False, True)
                )
            ),
            *(
                Task(in_free_space, {"kind": kind, "speed": speed, "brush": brush})
                for kind, speed, brush in grid(KINDS, SPEEDS, (False, True))
            ),
            *(
                Task(skipping, {"edges": edges, "frequency": frequency})
                for edges, frequency in grid(SKIPS, (0.5, 2.0))
            ),
        ]
    }
