# SPDX-License-Identifier: Apache-2.0
"""What does a scene need? Each part on and off, and the cheapest model that will do."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.ladder.run import CONTROLLERS
from wavehaptics.scene import Scene
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number, percent
from wavehaptics.studies.report.runs import FIRST_CONTACT_S, load
from wavehaptics.studies.stability import simulate
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace.columns import Column

TITLE = "What does a scene need?"

WHOLE = (
    "adc.bits=12",
    "adc.full_scale_a=2.5",
    "adc.noise_a=1e-3",
    "adc.offset_a=0.5e-3",
    "drive.limit_v=2.1",
    "encoder.counts_per_rev=10000",
    "friction.coulomb_nm=2e-4",
    "friction.viscous=1e-6",
)
"""A scene with every part."""
PARTS = ("friction", "adc", "encoder", "drive", "hand")
NEEDED = 0.01
"""Error of the torque that is good enough, RMS over peak."""
SCENES = {
    "paper_taps": (f"scene.duration_s={FIRST_CONTACT_S}",),
    "stiffest": (f"scene.duration_s={FIRST_CONTACT_S}", "drive.limit_v=12.0"),
    "press_hold": ("scene.duration_s=0.2",),
    "impact": ("scene.duration_s=0.02",),
    "free_space": ("scene.duration_s=0.25",),
}
QUICK_SCENES = ("paper_taps", "impact")


def _timed(scene: Scene, controller: str) -> tuple[np.ndarray, float]:
    """Torque of each tick, and seconds that it took."""
    simulation = CONTROLLERS[controller](scene)
    simulate(simulation, 0.0)  # compiles, and takes one tick
    began = time.perf_counter()
    rows = simulate(simulation, scene.scene.duration_s)
    return rows[:, Column.TORQUE], time.perf_counter() - began


def _error(torque: np.ndarray, whole: np.ndarray) -> float:
    # What rises and falls within 50 µs is a matter of the carrier, and can't be felt.
    width = 50
    kernel = np.ones(width) / width
    a, b = (np.convolve(y, kernel, mode="valid") for y in (torque, whole))
    return float(np.sqrt(np.mean((a - b) ** 2)) / np.abs(b).max())


def on_and_off(scene: str, settings: list[str]) -> list[dict[str, Any]]:
    """The scene with every part on `pins`, and what changes without each part or on other rungs."""
    whole = load(scene, settings)
    torque, seconds = _timed(whole, "pins")
    duration = whole.scene.duration_s
    found = [{"model": "pins, every part", "error": 0.0, "cost_s_per_s": seconds / duration}]
    variants = [(f"pins without {part}", "pins", {part}) for part in PARTS if part != "hand"]
    variants += [("golden, every part", "golden", set())]
    variants += [(f"golden without {part}", "golden", {part}) for part in PARTS]
    bare = {"friction", "adc", "encoder"}
    variants += [(f"golden without {', '.join(sorted(bare))}", "golden", bare)]
    variants += [("analog", "analog", set())]
    for name, controller, without in variants:
        part = whole.model_copy(update=dict.fromkeys(without))
        other, seconds = _timed(part, controller)
        found.append(
            {"model": name, "error": _error(other, torque), "cost_s_per_s": seconds / duration}
        )
    return found


def cheapest(scene: str, settings: list[str]) -> list[dict[str, Any]]:
    """A scene as it is on `pins`, and its error and cost on cheaper models."""
    whole = load(scene, settings)
    torque, seconds = _timed(whole, "pins")
    duration = whole.scene.duration_s
    found = [{"model": "pins", "error": 0.0, "cost_s_per_s": seconds / duration}]
    present = [part for part in ("adc", "encoder") if getattr(whole, part) is not None]
    variants: list[tuple[str, str, list[str]]] = [("core", "core", []), ("golden", "golden", [])]
    variants += [
        (f"golden without {', '.join(present[:n])}", "golden", present[:n])
        for n in range(1, len(present) + 1)
    ]
    variants += [("analog", "analog", ["encoder"])]
    for name, controller, without in variants:
        other, seconds = _timed(whole.model_copy(update=dict.fromkeys(without)), controller)
        found.append(
            {"model": name, "error": _error(other, torque), "cost_s_per_s": seconds / duration}
        )
    return found


def tasks(quick: bool) -> list[Task]:
    length = f"scene.duration_s={FIRST_CONTACT_S}"
    found = [Task(on_and_off, {"scene": "paper_taps", "settings": [*WHOLE, length]})]
    return found + [
        Task(cheapest, {"scene": name, "settings": list(settings)})
        for name, settings in SCENES.items()
        if not quick or name in QUICK_SCENES
    ]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    scenes = {}
    for task, models in zip(tasks[1:], results[1:], strict=True):
        good = [m for m in models if m["error"] <= NEEDED]
        best = min(good, key=lambda m: m["cost_s_per_s"])
        scenes[task.arguments["scene"]] = {"models": models, "recommended": best["model"]}
    return {"whole": results[0], "scenes": scenes}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    figure, (ax,) = figures.panels(1, 4.2)
    models = [m for m in data["whole"] if m["error"] > 0]
    names = [m["model"] for m in models]
    colours = [figures.ORANGE if n.startswith("pins") else figures.BLUE for n in names]
    ax.barh(range(len(names)), [m["error"] for m in models], color=colours)
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.set_xscale("log")
    ax.axvline(NEEDED, color=figures.GREY, ls=":")
    figures.label(ax, "torque error against pins with every part, RMS over peak", "")
    path = figures.save(figure, folder / "parts.png")
    rows = []
    for name, scene in data["scenes"].items():
        whole = scene["models"][0]
        best = next(m for m in scene["models"] if m["model"] == scene["recommended"])
        rows.append(
            (name, best["model"], percent(best["error"]),
             number(whole["cost_s_per_s"] / best["cost_s_per_s"]),
             "; ".join(f"{m['model']} {percent(m['error'])}" for m in scene["models"][1:]))
        )  # fmt: skip
    return [
        Text(
            "What a scene does not mention is not modelled and costs nothing. Here is the paper's "
            "taps with everything in it (12-bit ADC with noise and offset, 10⁴ counts, voltage "
            "limit, friction), and what changes when a part is left out. Errors are of the torque "
            "as means over 50 µs, against the whole RTL at its pins with every part."
        ),
        Picture(path, "What each part changes; without the hand there is no contact at all."),
        Table(
            "Parts on and off, paper_taps with everything",
            ("model", "torque error", "s per simulated s"),
            [(m["model"], percent(m["error"]), number(m["cost_s_per_s"])) for m in data["whole"]],
        ),
        Table(
            f"The cheapest model whose torque error is below {percent(NEEDED)}",
            ("scene", "cheapest model", "its error", "times as fast as pins", "all errors"),
            rows,
        ),
    ]
