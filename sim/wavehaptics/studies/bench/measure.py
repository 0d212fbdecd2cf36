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
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from rich.table import Table

from wavehaptics.ladder import verilated
from wavehaptics.runtime.files import write_json
from wavehaptics.runtime.plain_paths import workplace
from wavehaptics.runtime.repository import ROOT
from wavehaptics.studies.report.blocks import number, percent

OTHERS_PYTHON = ROOT / ".venv-bench" / "bin" / "python"
OTHERS = (("gym_electric_motor_steps.py", 20_000), ("motulator_steps.py", 4_000))
CONTROLLERS = ("analog", "golden", "core", "pins", "encoder")
ROUNDS, QUICK_ROUNDS = 7, 3
TIMEOUT_S = 900


class MeasurementError(RuntimeError):
    """A process that could not measure; the message is its last line."""


class Tried(NamedTuple):
    """Something that was tried to make the Verilated model faster."""

    name: str
    cxx: tuple[str, ...] = verilated.DEFAULT_CXX_FLAGS
    verilator: tuple[str, ...] = verilated.DEFAULT_VERILATOR_FLAGS
    seconds: str = "cpu_s"
    """Of which clock: with several threads the processor's tells nothing."""


def _without(*flags: str) -> tuple[str, ...]:
    return tuple(flag for flag in verilated.DEFAULT_CXX_FLAGS if flag not in flags)


SHIPPED = Tried("as shipped")
TRIED = (
    SHIPPED,
    Tried("compiler at -O2", ("-O2", *_without("-O3"))),
    Tried("compiler at -Os, Verilator's own default", ("-Os", *_without("-O3"))),
    Tried("without -march=native", _without("-march=native")),
    Tried("thread-local variables by a call", _without("-mtls-dialect=gnu2")),
    Tried("thread-local variables, static",
          ("-ftls-model=initial-exec", *_without("-mtls-dialect=gnu2"))),
    Tried("unknown values as Verilator has them by default", verilator=("-O3", "--noassert")),
    Tried("link-time optimisation", (*verilated.DEFAULT_CXX_FLAGS, "-flto")),
    Tried("two threads", verilator=(*verilated.DEFAULT_VERILATOR_FLAGS, "--threads", "2"),
          seconds="wall_s"),
)  # fmt: skip
HIERARCHICAL = '`verilator_config\nhier_block -module "wh_wave_core"\n'


class Runner:
    """A process that gets ready once and then measures each time that it is asked."""

    def __init__(self, what: str, tried: Tried, work: Path | None, errors: Any) -> None:
        environment = os.environ | {
            "WH_CXX_FLAGS": " ".join(tried.cxx),
            "WH_VERILATOR_FLAGS": " ".join(tried.verilator),
            "WH_BUILD_WORK": str(work or ""),
        }
        command = [sys.executable, "-m", "wavehaptics.studies.bench.once", what]
        self._errors = errors
        self.process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=errors, text=True,
        )  # fmt: skip
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
def _runner(what: str, tried: Tried = SHIPPED, work: Path | None = None) -> Iterator[Runner]:
    with tempfile.TemporaryFile("w+") as errors:
        runner = Runner(what, tried, work, errors)
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


def _alone(rounds: int) -> dict[str, Any]:
    """Clocks a second of the RTL without a motor."""
    with _runner("alone") as runner:
        (found,) = _by_turns([runner], rounds)
    each, packed = ([run[how]["cpu_s"] for run in found] for how in ("each", "packed"))
    clocks = runner.known["clocks"]
    return {
        "cycles_per_s_a_call_each": clocks / median(each),
        "cycles_per_s_many_a_call": clocks / median(packed),
        "gain_of_many_a_call": median(a / b for a, b in zip(each, packed, strict=True)),
        "clocks_that_change_a_pin": runner.known["clocks_that_change_a_pin"],
    }


def _trained(base: Runner, rounds: int, folder: Path) -> dict[str, Any]:
    """Gain of a build that follows the profile of a first run."""
    flags = verilated.DEFAULT_CXX_FLAGS
    work = folder / "work"
    first = Tried("training", (*flags, f"-fprofile-generate={folder}/profile"))
    with _runner("short", first, work):
        pass
    use = (*flags, f"-fprofile-use={folder}/profile", "-fprofile-partial-training",
           "-Wno-missing-profile")  # fmt: skip
    return _gain(base, Tried("trained", use), rounds, work)


def _hierarchical(base: Runner, rounds: int, folder: Path) -> dict[str, Any]:
    """Gain of the wave core as a Verilated block of its own."""
    config = folder / "hier.vlt"
    config.write_text(HIERARCHICAL, encoding="utf-8")
    flags = (*verilated.DEFAULT_VERILATOR_FLAGS, "--hierarchical", str(config))
    return _gain(base, Tried("hierarchical", verilator=flags), rounds)


def _gain(
    base: Runner, tried: Tried, rounds: int, work: Path | None = None
) -> dict[str, float | None]:
    """Clocks a second of what is tried, and how many times as fast as ``base`` it is: the median
    of the rounds, the least and the most."""
    with _runner("short", tried, work) as runner:
        pairs = zip(*_by_turns([base, runner], rounds), strict=True)
    seconds = [(one[tried.seconds], other[tried.seconds]) for one, other in pairs]
    gains = [one / other for one, other in seconds]
    return {
        "cycles_per_s": runner.known["clock_cycles"] / median(other for _, other in seconds),
        "gain": median(gains),
        "gain_least": min(gains),
        "gain_most": max(gains),
    }


def _tried(
    quick: bool, rounds: int, progress: Callable[[str, float], None]
) -> list[dict[str, Any]]:
    """Everything that was tried with `pins`, against what is shipped, which is tried as well."""
    rows = []
    with (
        tempfile.TemporaryDirectory(dir=workplace(verilated.BUILD_DIR)) as name,
        _runner("short") as base,
    ):
        folder = Path(name)
        cases: list[tuple[str, Callable[[], dict[str, float | None]]]] = [
            (t.name, partial(_gain, base, t, rounds)) for t in TRIED
        ]
        cases.append(("build guided by a profile", lambda: _trained(base, rounds, folder)))
        cases.append(
            ("wave core as a block of its own", lambda: _hierarchical(base, rounds, folder))
        )
        for n, (what, run) in enumerate(cases[:1] if quick else cases):
            progress("tried", n / len(cases))
            row = dict.fromkeys(("cycles_per_s", "gain", "gain_least", "gain_most", "failed"))
            try:
                row |= run()
            except MeasurementError as error:
                row["failed"] = str(error)
            rows.append({"what": what, **row})
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
    """Measure everything and write ``summary.json`` into ``out``; ``quick`` tries nothing new."""
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
        "cxx_flags": list(verilated.DEFAULT_CXX_FLAGS),
        "verilator_flags": list(verilated.DEFAULT_VERILATOR_FLAGS),
        "threads": 1,
        "controllers": controllers,
        "rtl_alone": _alone(rounds),
        "tried": _tried(quick, rounds, progress),
        "quick": quick,
        "others": _others(progress) if OTHERS_PYTHON.exists() else [],
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


def gain(row: dict[str, Any]) -> str:
    """How many times as fast something was, with the least and the most of the rounds."""
    if row["failed"]:
        return row["failed"]
    return f"{row['gain']:.2f} ({row['gain_least']:.2f}–{row['gain_most']:.2f})"


def tables(summary: dict[str, Any]) -> list[Table]:
    """The summary for people."""
    speeds = Table(title="paper_taps, its motor in the loop, one thread, seconds of the processor")
    head = ("controller", "simulated s per s", "ticks per s", "clocks per s", "times pins", "error")
    for heading in head:
        speeds.add_column(heading, justify="left" if heading == "controller" else "right")
    for name, row in summary["controllers"].items():
        speeds.add_row(name, number(row["simulated_s_per_s"]), number(row["ticks_per_s"]),
                       number(row["cycles_per_s"]), number(row["times_pins"]),
                       percent(row["torque_error"]))  # fmt: skip
    tried = Table(title="what was tried with pins")
    for heading in ("what", "clocks per s", "times as fast"):
        tried.add_column(heading, justify="left" if heading == "what" else "right")
    for row in summary["tried"]:
        tried.add_row(row["what"], number(row["cycles_per_s"]), gain(row))
    others = Table(title="other motor simulators, at their own settings")
    for heading in ("package", "what", "steps per s", "simulated s per s", "error of the current"):
        others.add_column(heading, justify="left" if heading in ("package", "what") else "right")
    for row in summary["others"]:
        others.add_row(f"{row['name']} {row['version']}", row["what"], number(row["steps_per_s"]),
                       number(row["simulated_s_per_s"]), number(row["current_error"]))  # fmt: skip
    return [speeds, tried, others]
