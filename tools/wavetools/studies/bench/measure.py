# SPDX-License-Identifier: Apache-2.0
"""All measurements of ``make bench`` into ``summary.json``.

What is compared is measured by turns, A B A B …, each in a process of its own, so that whatever
else the machine does falls on both; what counts is the median, of the speeds and of the ratios of
neighbours. A second is one of the processor's: on an idle machine it is the clock's too.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from typing import Any

from rich.table import Table
from wavehaptics.ladder import verilated
from wavehaptics.runtime.files import write_json
from wavehaptics.studies.report.blocks import number, percent

CONTROLLERS = ("analog", "golden", "core", "pins", "encoder")
ROUNDS, QUICK_ROUNDS = 7, 3
TIMEOUT_S = 900


class MeasurementError(RuntimeError):
    """A process that could not measure; the message is its last line."""


class Runner:
    """A process that gets ready once and then measures each time that it is asked."""

    def __init__(self, what: str, errors: Any) -> None:
        command = [sys.executable, "-m", "wavetools.studies.bench.once", what]
        self._errors = errors
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True
        )
        self.known = self._answer()

    def once(self) -> dict[str, Any]:
        """One measurement."""
        print(file=self.process.stdin, flush=True)
        return self._answer()

    def _answer(self) -> dict[str, Any]:
        late = threading.Timer(TIMEOUT_S, self.process.kill)
        late.start()
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        late.cancel()
        if not line:
            self._errors.seek(0)
            last = self._errors.read().strip().splitlines() or ["no message"]
            raise MeasurementError(last[-1])
        return json.loads(line)


@contextmanager
def _runner(what: str) -> Iterator[Runner]:
    with tempfile.TemporaryFile("w+") as errors:
        runner = Runner(what, errors)
        try:
            yield runner
        finally:
            assert runner.process.stdin is not None
            runner.process.stdin.close()
            runner.process.wait(TIMEOUT_S)


def _by_turns(runners: list[Runner], rounds: int) -> list[list[dict[str, Any]]]:
    """What each runner measured in each round."""
    found: list[list[dict[str, Any]]] = [[] for _ in runners]
    for _ in range(rounds):
        for runner, kept in zip(runners, found, strict=True):
            kept.append(runner.once())
    return found


def _controllers(rounds: int, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """Speeds of the controllers, and the share of a core that they had."""
    with ExitStack() as stack:
        runners = []
        for n, name in enumerate(CONTROLLERS):
            progress("controllers", n / (len(CONTROLLERS) + 1))
            runners.append(stack.enter_context(_runner(name)))
        found = _by_turns(runners, rounds)
    progress("controllers", 1.0)
    rows = {}
    speeds = {}
    for name, runner, kept in zip(CONTROLLERS, runners, found, strict=True):
        known = runner.known
        seconds = median(run["cpu_s"] for run in kept)
        cycles = known["clock_cycles"]
        speeds[name] = [known["duration_s"] / run["cpu_s"] for run in kept]
        rows[name] = {
            "ticks_per_s": known["ticks"] / seconds,
            "cycles_per_s": None if cycles is None else cycles / seconds,
            "simulated_s_per_s": known["duration_s"] / seconds,
            "torque_error": known["torque_error"],
            "share_of_a_core": median(run["cpu_s"] / run["wall_s"] for run in kept),
        }
    for name, row in rows.items():
        ratios = zip(speeds[name], speeds["pins"], strict=True)
        row["times_pins"] = median(one / other for one, other in ratios)
    return rows


def bench(
    out: Path, quick: bool = False, progress: Callable[[str, float], None] = lambda s, p: None
) -> dict[str, Any]:
    """Measure everything and write ``summary.json`` into ``out``; ``quick``: in fewer rounds."""
    rounds = QUICK_ROUNDS if quick else ROUNDS
    controllers = _controllers(rounds, progress)
    summary = {
        "machine": {
            "system": platform.platform(),
            "processor": _processor(),
            "cores": os.cpu_count(),
            "load": os.getloadavg()[0],
        },
        "compiler": _first_line([shutil.which("c++") or "g++", "--version"]),
        "verilator": _first_line([verilated.verilator_environment()[0], "--version"]),
        "cxx_flags": list(verilated.CXX_FLAGS),
        "verilator_flags": list(verilated.VERILATOR_FLAGS),
        "threads": 1,
        "controllers": controllers,
        "quick": quick,
    }
    write_json(out / "summary.json", summary)
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


def table(summary: dict[str, Any]) -> Table:
    """The summary for people."""
    speeds = Table(title="paper_taps, its motor in the loop, one thread, seconds of the processor")
    head = ("controller", "simulated s per s", "ticks per s", "clocks per s", "times pins", "error")
    for heading in head:
        speeds.add_column(heading, justify="left" if heading == "controller" else "right")
    for name, row in summary["controllers"].items():
        speeds.add_row(name, number(row["simulated_s_per_s"]), number(row["ticks_per_s"]),
                       number(row["cycles_per_s"]), number(row["times_pins"]),
                       percent(row["torque_error"]))  # fmt: skip
    return speeds
