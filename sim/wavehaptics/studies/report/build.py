# SPDX-License-Identifier: Apache-2.0
"""From scenes to the report: sweeps → ``report.json`` → pictures → ``index.html``."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from wavehaptics.runtime.files import write_json, write_text
from wavehaptics.studies.report import (
    converters,
    energies,
    field_oriented,
    hard_cases,
    in_space,
    integrators,
    ladder,
    latency,
    old_way,
    paper,
    parts,
    rates,
    spectrum,
    widths,
)
from wavehaptics.studies.report.page import render
from wavehaptics.studies.report.runs import STORE
from wavehaptics.studies.sweeps import sweep

SECTIONS: tuple[ModuleType, ...] = (
    paper,
    old_way,
    in_space,
    field_oriented,
    hard_cases,
    rates,
    latency,
    energies,
    widths,
    converters,
    spectrum,
    ladder,
    parts,
    integrators,
)
"""In the order of the page."""

TIMED: tuple[ModuleType, ...] = (rates, converters, ladder, parts, integrators)
"""Sections that compare times: nothing else runs beside their tasks."""

TITLE = "Wave haptics on an FPGA: speed against error, hard cases, and the usual way beside it"


def name_of(section: ModuleType) -> str:
    """Name of a section, in the JSON and in the page's links."""
    return section.__name__.rpartition(".")[2]


def _show(progress: Callable[[str, float], None], stage: str, done: int, total: int) -> None:
    progress(stage, done / max(total, 1))


def collect(
    quick: bool,
    *,
    cluster: str | None = None,
    workers: int | None = None,
    store: Path = STORE,
    progress: Callable[[str, float], None] = lambda stage, part: None,
) -> dict[str, Any]:
    """All numbers of the report, by section."""
    began = time.monotonic()
    workers = workers or os.cpu_count() or 1
    together = [section for section in SECTIONS if section not in TIMED]
    results: dict[str, Any] = {}
    groups = (("sweeps", together, cluster, workers), ("times", TIMED, None, 1))
    for stage, sections, where, count in groups:
        parts = {name_of(section): section.tasks(quick) for section in sections}
        tasks = [task for part in parts.values() for task in part]
        found = sweep(
            tasks, store, cluster=where, workers=count, progress=partial(_show, progress, stage)
        )
        for section in sections:
            part = parts[name_of(section)]
            results[name_of(section)] = section.gather(part, found[: len(part)])
            found = found[len(part) :]
    return {
        "quick": quick,
        "seconds": round(time.monotonic() - began, 1),
        "machine": {"processor": _processor(), "cores": os.cpu_count()},
        "sections": {name_of(section): results[name_of(section)] for section in SECTIONS},
    }


def draw(report: dict[str, Any], out: Path) -> Path:
    """Draw the pictures of a collected report into ``out``, and write its page; the page's path."""
    sections = []
    for section in SECTIONS:
        data = report["sections"][name_of(section)]
        sections.append((name_of(section), section.TITLE, section.show(data, out)))
    machine = report["machine"]
    form = "quick form: coarser grids" if report["quick"] else "full form"
    lead = (
        "A motor's inductance is a spring. The wave controller of Niemeyer, Diolaiti and Tanner "
        "(“Wave Haptics: Encoderless Virtual Stiffnesses”) lets a user feel it: it takes the "
        "winding's resistance away by handling power as waves, and an encoder only tells on which "
        "side of a wall the rotor is. The paper's controller is an analog circuit; this project's "
        "is digital, and this page says how exact it is, what each part of the exactness costs, "
        "what happens where it is hardest, and how the usual encoder and current amplifier do "
        "on the same motors.",
        "“Analog” is always the paper's circuit simulated in continuous time, “golden” the digital "
        "controller's arithmetic bit by bit, “core” its Verilog, and “pins” the whole Verilog with "
        "ADC bits, encoder edges and gate signals on a switching bridge. Stiffnesses and torques "
        "are the rotor's unless a tip is named. T is the digital controller's tick, k its latency "
        "in whole ticks beyond the soonest possible, and a the coefficient of its λ filter: with "
        "a = 0.99 the wall is the stiffest.",
    )
    footer = (
        f"Made from scenes by `make report` ({form}) in {report['seconds']:g} s on "
        f"{machine['cores']} cores of {machine['processor']}. The numbers stand in report.json."
    )
    return write_text(out / "index.html", render(TITLE, lead, sections, footer))


def make_report(out: Path, quick: bool, **options: Any) -> Path:
    """Collect, write ``report.json`` and draw; options as of :func:`collect`. The page's path."""
    report = collect(quick, **options)
    kept = write_json(out / "report.json", report)
    return draw(json.loads(kept.read_bytes()), out)


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in text.splitlines() if "model name" in line]
    return names[0] if names else platform.machine()
