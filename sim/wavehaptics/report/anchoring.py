# SPDX-License-Identifier: Apache-2.0
"""What a wrong R̂, a wrong drive and a wrong zero do to a wall, without the anchor and with it."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.report import figures
from wavehaptics.report.blocks import Block, Picture, Table, Text, number, percent
from wavehaptics.report.runs import load
from wavehaptics.run import measure
from wavehaptics.sweeps import Task

TITLE = "What holds a wall in place?"

CURES = ("controller.anchor_auto=true",)
"""Anchor, release and tracking as ``anchor_choice.py`` chooses them."""

R_OHM = 2.18
PARTS = (0.5, 0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2, 1.5)
QUICK_PARTS = (0.5, 0.9, 1.0, 1.1, 1.5)
SPEEDS = (1.0, 3.0, 10.0, 30.0)
QUICK_SPEEDS = (3.0, 30.0)
DISTURBED = ("drive.gain_error=0.05", "adc.offset_a=2e-3")
HELD = 0.1
"""A wall that has moved by less than this part of the depth, half an encoder cell, is held."""


def hold(part: float, cured: bool, disturbed: bool) -> dict[str, Any]:
    """Press for a second on the stiffest wall with R̂ = ``part``·R."""
    settings = [f"controller.r_hat={R_OHM * part}", *(CURES if cured else ())]
    metrics = measure(load("press_hold", [*settings, *(DISTURBED if disturbed else ())]), "golden")
    kept = ("hold_error", "hold_offset_rad", "hold_ripple_rms")
    return {"part": part, "cured": cured, "disturbed": disturbed} | {k: metrics[k] for k in kept}


def bounce(speed: float, part: float, cured: bool) -> dict[str, Any]:
    """The bare rotor hits the stiffest wall with R̂ = ``part``·R."""
    settings = [f"hand.speed_rad_s={speed}", f"controller.r_hat={R_OHM * part}"]
    metrics = measure(load("impact", [*settings, *(CURES if cured else ())]), "golden")
    found = {"speed": speed, "part": part, "cured": cured}
    return found | {"restitution": metrics["restitution"]}


CORNERS = (
    ("R̂ +20 %, gain +5 %, +4 mA", 1.2, 0.05, 4e-3),
    ("R̂ −20 %, gain −5 %, −4 mA", 0.8, -0.05, -4e-3),
)
COUNTS, BITS, HANDS = (1000, 10_000, 40_000), (10, 12, 16), (0.1, 1.0, 10.0)
CURE_SETTINGS = {
    "with": CURES,
    "no dead zone": (*CURES, "controller.dead_zone_cells=0"),
    "without": (),
}
PUSH_NM, DEPTH_RAD = 0.015, 6.6e-3
"""Torque of the press, and the depth to which it goes on the stiffest wall."""


def corner(disturbance: int, counts: int, bits: int, stiffness: float, cure: str) -> dict[str, Any]:
    """Press for two seconds under one of CORNERS; ``stiffness`` is the hand's."""
    _, part, gain, offset = CORNERS[disturbance]
    settings = [
        f"controller.r_hat={R_OHM * part}", f"drive.gain_error={gain}", f"adc.offset_a={offset}",
        f"encoder.counts_per_rev={counts}", f"adc.bits={bits}", f"hand.stiffness={stiffness}",
        f"hand.amplitude_rad={PUSH_NM / stiffness + DEPTH_RAD}", "scene.duration_s=2",
        *CURE_SETTINGS[cure],
    ]  # fmt: skip
    metrics = measure(load("press_hold", settings), "golden")
    offset_rad = metrics["hold_offset_rad"]
    return {
        "disturbance": disturbance,
        "counts": counts,
        "bits": bits,
        "stiffness": stiffness,
        "cure": cure,
        "cells": None if offset_rad is None else offset_rad * counts / (2 * np.pi),
        "ripple": metrics["hold_ripple_rms"],
        "encoder_lost": metrics["encoder_lost"],
    }


def _corners(quick: bool) -> list[Task]:
    counts, bits, hands = ((10_000,), (12,), HANDS) if quick else (COUNTS, BITS, HANDS)
    grid = itertools.product(range(len(CORNERS)), counts, bits, hands, CURE_SETTINGS)
    names = ("disturbance", "counts", "bits", "stiffness", "cure")
    return [Task(corner, dict(zip(names, point, strict=True))) for point in grid]


def tasks(quick: bool) -> list[Task]:
    parts, speeds = (QUICK_PARTS, QUICK_SPEEDS) if quick else (PARTS, SPEEDS)
    flags = (False, True)
    found = [
        Task(hold, {"part": part, "cured": cured, "disturbed": disturbed})
        for part, cured, disturbed in itertools.product(parts, flags, flags)
    ]
    return (
        found
        + [
            Task(bounce, {"speed": speed, "part": part, "cured": cured})
            for speed, part, cured in itertools.product(speeds, parts, flags)
        ]
        + _corners(quick)
    )


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    pairs = list(zip(tasks, results, strict=True))
    return {
        "holds": [result for task, result in pairs if task.function is hold],
        "bounces": [result for task, result in pairs if task.function is bounce],
        "corners": [result for task, result in pairs if task.function is corner],
    }


def bounce_map(ax: Any, points: list[dict[str, Any]]) -> Any:
    """Map of the largest ``restitution`` at each ``speed`` and ``part`` of ``points``."""
    speeds = sorted({p["speed"] for p in points})
    parts = sorted({p["part"] for p in points})
    grid = np.full((len(speeds), len(parts)), np.nan)
    for p in points:
        if p["restitution"] is not None:
            place = speeds.index(p["speed"]), parts.index(p["part"])
            grid[place] = np.fmax(grid[place], p["restitution"])
    return figures.value_map(ax, grid, speeds, parts)


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    figure, axes = figures.panels(2, 3.8)
    for ax, disturbed in zip(axes, (False, True), strict=True):
        for n, cured in enumerate((False, True)):
            points = [
                p for p in data["holds"] if p["cured"] == cured and p["disturbed"] == disturbed
            ]
            errors = [None if p["hold_error"] is None else abs(p["hold_error"]) for p in points]
            figures.curve(ax, [p["part"] for p in points], errors, n,
                          "anchor, release and tracking" if cured else "without")  # fmt: skip
        ax.set_yscale("log")
        ax.axhline(HELD, color=figures.GREY, lw=0.8, ls=":")
        title = "gain error 5 %, offset 2 mA" if disturbed else "nothing else wrong"
        figures.label(ax, "R̂ over R", "wall moved, over the depth", title)
        figures.legend(ax)
    holds = figures.save(figure, folder / "holds.png")

    figure, axes = figures.panels(2, 3.4)
    for ax, cured in zip(axes, (False, True), strict=True):
        image = bounce_map(ax, [p for p in data["bounces"] if p["cured"] == cured])
        title = "with anchor, release and tracking" if cured else "without"
        figures.label(ax, "R̂ over R", "speed of the hit, rad/s", title)
    figure.colorbar(image, ax=axes, shrink=0.85, label="speed out over speed in")
    bounces = figures.save(figure, folder / "bounces.png")
    rows = [
        (f"{p['part']:g}", "yes" if p["disturbed"] else "no", "yes" if p["cured"] else "no",
         percent(p["hold_error"]), number(None if p["hold_ripple_rms"] is None
                                          else 1e6 * p["hold_ripple_rms"]))
        for p in data["holds"]
    ]  # fmt: skip
    return [
        Text(
            "The paper leaves open what happens when R̂ is not R. A held wall then gives way or "
            "throws the rotor out; so do an error of the drive's gain and an offset of the sensor. "
            "The anchor pulls the force of a held wall to where the encoder says it should be, R̂ "
            "follows the winding, and on the way out the force may differ only in the direction "
            "that takes energy. Half an encoder cell is 5 % of the depth here. A missing point is "
            "a wall that lost contact."
        ),
        Text(
            "An encoder's edge tells x exactly, which half a cell does not. Setting the current "
            "right at each edge was tried: a soft hand's wall then stood 0.2 of a cell off and not "
            "0.35, but the torque's ripple was twice to four times as large for stiffer hands, "
            "whose rotor rests on an edge and has it pass again and again. It is not in."
        ),
        Picture(holds, "How far a wall has moved after a second's press; 10 % dotted."),
        Picture(bounces, "Speed of the bare rotor after a hit: above 1 the wall has thrown it."),
        Table(
            "Holds",
            ("R̂ over R", "gain and offset wrong", "cured", "moved, over the depth", "ripple, µN·m"),
            rows,
        ),
        Table(
            "Corners of the grid: cells that the wall moved / torque ripple in µN·m, a hold of 2 s",
            ("wrong", "counts", "ADC bits", "hand, N·m/rad", *CURE_SETTINGS),
            _corner_rows(data["corners"]),
        ),
    ]


def _corner_rows(corners: list[dict[str, Any]]) -> list[tuple[str, ...]]:
    """A row a corner, a cell of the table for each cure."""
    places: dict[tuple[Any, ...], dict[str, str]] = {}
    for p in corners:
        place = (p["disturbance"], p["counts"], p["bits"], p["stiffness"])
        text = "lost"
        if p["cells"] is not None:
            text = f"{number(p['cells'], 2)} / {1e6 * p['ripple']:.0f}"
        told = ", encoder lost" if p["encoder_lost"] else ""
        places.setdefault(place, {})[p["cure"]] = text + told
    return [
        (CORNERS[place[0]][0], f"{place[1]:,}", f"{place[2]}", f"{place[3]:g}",
         *(found.get(cure, "–") for cure in CURE_SETTINGS))
        for place, found in places.items()
    ]  # fmt: skip
