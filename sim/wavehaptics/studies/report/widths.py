# SPDX-License-Identifier: Apache-2.0
"""Word lengths against error, and what they cost on each FPGA."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.controller.settings import settings
from wavehaptics.ladder.analog import AnalogSimulation
from wavehaptics.runtime.repository import ROOT
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, percent
from wavehaptics.studies.report.runs import FIRST_CONTACT_S, load
from wavehaptics.studies.stability import simulate
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace.metrics import Metrics
from wavehaptics.words import formats

TITLE = "How long must the words be?"

WIDTHS = {
    "DATA_W": (14, 16, 18, 20, 22, 24, 27, 31),
    "COEF_W": (12, 14, 16, 18, 21, 24, 27),
    "STATE_GUARD": (1, 2, 4, 6, 9),
}
QUICK_WIDTHS = {"DATA_W": (16, 20, 24, 31), "COEF_W": (14, 18), "STATE_GUARD": (1,)}
NAMES = {
    "DATA_W": "current, voltage and waves",
    "COEF_W": "coefficients s, η and a",
    "STATE_GUARD": "guard bits of the state f",
}
SCENE = "paper_taps"
SETTINGS = (f"scene.duration_s={FIRST_CONTACT_S}",)
TIMEOUT_S = 3600


def at_width(name: str, bits: int, scene: str, overrides: list[str]) -> dict[str, Any]:
    """Errors of the wave core with one word length changed, on a scene with an ideal sensor."""
    environment = os.environ | {f"WH_{name}": str(bits)}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "rows.npy"
        subprocess.run(
            [
                sys.executable, "-m", "wavehaptics.studies.report.narrow",
                str(out), scene, *overrides,
            ],
            env=environment, check=True, timeout=TIMEOUT_S, stdin=subprocess.DEVNULL,
        )  # fmt: skip
        rows = np.load(out)
    loaded = load(scene, overrides)
    set_ = settings(loaded)
    analog = AnalogSimulation(loaded, set_.tick_s, set_.cell_rad)
    edges = zip(set_.wall_min * set_.cell_rad, set_.wall_max * set_.cell_rad, strict=True)
    metrics = Metrics(loaded, set_.tick_s, controller="golden", walls=list(edges))
    metrics.update(rows, simulate(analog, loaded.scene.duration_s))
    result = metrics.result()
    return {
        "torque_error": result["torque_nrmse_vs_analog"],
        "stiffness": result["stiffness"],
        "free_space_torque_rms": result["free_space_torque_rms"],
    }


def tasks(quick: bool) -> list[Task]:
    widths = QUICK_WIDTHS if quick else WIDTHS
    return [
        Task(at_width, {"name": name, "bits": n, "scene": SCENE, "overrides": list(SETTINGS)})
        for name, bits in widths.items()
        for n in bits
    ]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    points = [
        {"word": task.arguments["name"], "bits": task.arguments["bits"], **result}
        for task, result in zip(tasks, results, strict=True)
    ]
    points.sort(key=lambda p: (list(WIDTHS).index(p["word"]), p["bits"]))
    kept = json.loads((ROOT / "boards" / "summary.json").read_bytes())
    cells = [
        {key: row[key] for key in ("option", "device", "lut", "ff", "dsp", "reached_mhz")}
        for row in kept.get("resources", ())
        if row["table"] == "widths"
    ]
    default = {name: formats.HEADER_VALUES[name] for name in WIDTHS}
    # All words at the design's own lengths are one and the same run.
    own = [p for p in points if p["bits"] == default[p["word"]]]
    for name in WIDTHS:
        if own and not any(p["word"] == name for p in own):
            points.append({**own[0], "word": name, "bits": default[name]})
    return {"default": default, "points": points, "cells": cells}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    figure, axes = figures.panels(3, 3.8)
    for n, (ax, word) in enumerate(zip(axes, WIDTHS, strict=True)):
        points = [p for p in data["points"] if p["word"] == word]
        bits = [p["bits"] for p in points]
        figures.curve(ax, bits, [p["torque_error"] for p in points], n, NAMES[word])
        ax.set_yscale("log")
        ax.locator_params(axis="x", integer=True)
        ax.axhline(0.01, color=figures.GREY, lw=0.8, ls=":")
        ax.axvline(data["default"][word], color=figures.BLACK, lw=0.8, ls="--")
        figures.label(ax, "bits", "torque error" if n == 0 else "", NAMES[word])
    path = figures.save(figure, folder / "widths.png")
    blocks: list[Block] = [
        Text(
            "One word length at a time is shortened, the others stay as they are "
            f"({data['default']['DATA_W']} bits of data, {data['default']['COEF_W']} of "
            f"coefficients, {data['default']['STATE_GUARD']} guard bits). The full scales stay "
            "too, so every bit less doubles the last place. The sensor is ideal here: it is the "
            "arithmetic alone that is judged."
        ),
        Picture(path, "Torque error over word length; the design's own length dashed, 1 % dotted."),
        Table(
            "Word length against error",
            ("word", "bits", "torque error", "free-space torque over peak of a tap (21 mN·m)"),
            [
                (NAMES[p["word"]], p["bits"], percent(p["torque_error"]),
                 percent(p["free_space_torque_rms"] / 0.021))
                for p in data["points"]
            ],
        ),
    ]  # fmt: skip
    if data["cells"]:
        rows = [
            (c["option"], c["device"], c["lut"], c["ff"], c["dsp"],
             "–" if c["reached_mhz"] is None else f"{c['reached_mhz']:.0f}")
            for c in data["cells"]
        ]  # fmt: skip
        head = ("data × coefficient", "FPGA", "LUT", "flip-flops", "DSP", "MHz reached")
        blocks.append(Table("What the wave core costs (from boards/summary.json)", head, rows))
    return blocks
