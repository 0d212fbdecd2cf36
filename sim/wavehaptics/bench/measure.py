# SPDX-License-Identifier: Apache-2.0
"""All measurements of ``make bench``, one after the other, into ``summary.json``.

Each is made in a process of its own with nothing beside it; of several repeats the fastest counts,
as whatever else the machine does can only slow one down.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from rich.table import Table

from wavehaptics import verilated
from wavehaptics.boards import ROOT
from wavehaptics.metrics import write_metrics
from wavehaptics.report.blocks import number, percent

OTHERS_PYTHON = ROOT / ".venv-bench" / "bin" / "python"
OTHERS = (("gym_electric_motor_steps.py", 20_000), ("motulator_steps.py", 4_000))
CONTROLLERS = ("analog", "golden", "core", "pins", "encoder")
REPEATS = 5
TIMEOUT_S = 900


class Tried(NamedTuple):
    """Something that was tried to make the Verilated model faster."""

    name: str
    cxx: tuple[str, ...] = verilated.DEFAULT_CXX_FLAGS
    verilator: tuple[str, ...] = verilated.DEFAULT_VERILATOR_FLAGS


def _without(*flags: str) -> tuple[str, ...]:
    return tuple(flag for flag in verilated.DEFAULT_CXX_FLAGS if flag not in flags)


TRIED = (
    Tried("as shipped"),
    Tried("compiler at -O2", ("-O2", *_without("-O3"))),
    Tried("compiler at -Os, Verilator's own default", ("-Os", *_without("-O3"))),
    Tried("without -march=native", _without("-march=native")),
    Tried("thread-local variables by a call", _without("-mtls-dialect=gnu2")),
    Tried("thread-local variables, static",
          ("-ftls-model=initial-exec", *_without("-mtls-dialect=gnu2"))),
    Tried("unknown values as Verilator has them by default", verilator=("-O3", "--noassert")),
    Tried("link-time optimisation", (*verilated.DEFAULT_CXX_FLAGS, "-flto")),
    Tried("two threads", verilator=(*verilated.DEFAULT_VERILATOR_FLAGS, "--threads", "2")),
)  # fmt: skip
HIERARCHICAL = '`verilator_config\nhier_block -module "wh_wave_core"\n'


def _once(
    what: str, repeats: int, tried: Tried = TRIED[0], work: Path | None = None
) -> dict[str, Any]:
    environment = os.environ | {
        "WH_CXX_FLAGS": " ".join(tried.cxx),
        "WH_VERILATOR_FLAGS": " ".join(tried.verilator),
    }
    command = [sys.executable, "-m", "wavehaptics.bench.once", what, str(repeats)]
    done = subprocess.run(
        [*command, *([str(work)] if work else [])], env=environment, capture_output=True,
        text=True, timeout=TIMEOUT_S, stdin=subprocess.DEVNULL, check=False,
    )  # fmt: skip
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        return {"failed": last}
    return json.loads(done.stdout.splitlines()[-1])


def _with_profile(repeats: int, folder: Path) -> dict[str, Any]:
    """Speed after a build that follows the profile of a first run."""
    base = verilated.DEFAULT_CXX_FLAGS
    work = folder / "work"
    first = Tried("training", (*base, f"-fprofile-generate={folder}/profile"))
    trained = _once("short", 1, first, work)
    if "failed" in trained:
        return trained
    use = (*base, f"-fprofile-use={folder}/profile", "-fprofile-partial-training",
           "-Wno-missing-profile")  # fmt: skip
    return _once("short", repeats, Tried("trained", use), work)


def _hierarchical(repeats: int, folder: Path) -> dict[str, Any]:
    """Speed with the wave core as a Verilated block of its own."""
    config = folder / "hier.vlt"
    config.write_text(HIERARCHICAL, encoding="utf-8")
    flags = (*verilated.DEFAULT_VERILATOR_FLAGS, "--hierarchical", str(config))
    return _once("short", repeats, Tried("hierarchical", verilator=flags))


def _tried(
    quick: bool, repeats: int, progress: Callable[[str, float], None]
) -> list[dict[str, Any]]:
    rows = []
    base: float | None = None
    cases = [(t.name, lambda t=t: _once("short", repeats, t)) for t in TRIED]
    with tempfile.TemporaryDirectory(dir=verilated.BUILD_DIR.parent) as name:
        folder = Path(name)
        cases.append(("build guided by a profile", lambda: _with_profile(repeats, folder)))
        cases.append(("wave core as a block of its own", lambda: _hierarchical(repeats, folder)))
        for n, (what, run) in enumerate(cases[:1] if quick else cases):
            progress("tried", n / len(cases))
            found = run()
            speed = found.get("cycles_per_s")
            base = speed if base is None else base
            gain = speed / base if speed and base else None
            rows.append(
                {"what": what, "cycles_per_s": speed, "gain": gain, "failed": found.get("failed")}
            )
    progress("tried", 1.0)
    return rows


def _others(progress: Callable[[str, float], None]) -> list[dict[str, Any]]:
    rows = []
    for n, (script, steps) in enumerate(OTHERS):
        progress("others", n / len(OTHERS))
        done = subprocess.run(
            [str(OTHERS_PYTHON), str(ROOT / "sim" / "others" / script), str(steps)],
            capture_output=True, text=True, timeout=TIMEOUT_S, stdin=subprocess.DEVNULL, check=True,
        )  # fmt: skip
        rows.append(json.loads(done.stdout.splitlines()[-1]))
    progress("others", 1.0)
    return rows


def bench(
    out: Path, quick: bool = False, progress: Callable[[str, float], None] = lambda s, p: None
) -> dict[str, Any]:
    """Measure everything and write ``summary.json`` into ``out``; ``quick`` tries nothing."""
    repeats = 2 if quick else REPEATS
    verilated.BUILD_DIR.mkdir(parents=True, exist_ok=True)
    controllers = {}
    for n, name in enumerate(CONTROLLERS):
        progress("controllers", n / len(CONTROLLERS))
        controllers[name] = _once(name, repeats)
    progress("controllers", 1.0)
    summary = {
        "machine": {
            "system": platform.platform(),
            "processor": _processor(),
            "cores": os.cpu_count(),
            "load_before": os.getloadavg()[0],
        },
        "compiler": _first_line([shutil.which("c++") or "g++", "--version"]),
        "verilator": _first_line([verilated.verilator_environment()[0], "--version"]),
        "cxx_flags": list(verilated.DEFAULT_CXX_FLAGS),
        "verilator_flags": list(verilated.DEFAULT_VERILATOR_FLAGS),
        "threads": 1,
        "controllers": controllers,
        "rtl_alone": _once("alone", repeats),
        "tried": _tried(quick, repeats, progress),
        "others": _others(progress) if OTHERS_PYTHON.exists() else [],
    }
    write_metrics(summary, out / "summary.json")
    return summary


def _first_line(command: list[str]) -> str:
    environment = verilated.verilator_environment()[1]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    return (done.stdout.splitlines() or [""])[0]


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if "model name" in line]
    return names[0] if names else platform.machine()


def tables(summary: dict[str, Any]) -> list[Table]:
    """The summary for people."""
    speeds = Table(title="paper_taps, its motor in the loop, one thread")
    for heading in ("controller", "simulated s per s", "ticks per s", "clocks per s", "error"):
        speeds.add_column(heading, justify="left" if heading == "controller" else "right")
    for name, row in summary["controllers"].items():
        speeds.add_row(name, number(row["simulated_s_per_s"]), number(row["ticks_per_s"]),
                       number(row["cycles_per_s"]), percent(row["torque_error"]))  # fmt: skip
    tried = Table(title="what was tried with pins")
    for heading in ("what", "clocks per s", "times as fast"):
        tried.add_column(heading, justify="left" if heading == "what" else "right")
    for row in summary["tried"]:
        tried.add_row(
            row["what"], number(row["cycles_per_s"]), row["failed"] or number(row["gain"])
        )
    others = Table(title="other motor simulators, at their own settings")
    for heading in ("package", "what", "steps per s", "simulated s per s", "error of the current"):
        others.add_column(heading, justify="left" if heading in ("package", "what") else "right")
    for row in summary["others"]:
        others.add_row(f"{row['name']} {row['version']}", row["what"], number(row["steps_per_s"]),
                       number(row["simulated_s_per_s"]), number(row["current_error"]))  # fmt: skip
    return [speeds, tried, others]
