# SPDX-License-Identifier: Apache-2.0
"""The bench: what it measures is what runs, flags reach the compiler, failures are told."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from rich.console import Console
from wavehaptics.ladder import verilated
from wavehaptics.studies.bench import measure, once


@pytest.mark.parametrize("controller", ["golden", "encoder"])
def test_a_controller_is_measured_as_often_as_is_asked(controller):
    known, measure_once = once.whole(controller, 0.1)
    assert (known["ticks"], known["duration_s"]) == (100_000, 0.1)
    assert known["clock_cycles"] is None
    for seconds in (measure_once(), measure_once()):
        assert seconds["cpu_s"] > 0
        assert seconds["wall_s"] > 0


def test_every_controller_presses_into_the_wall():
    """The first tap meets it after an eighth of a second; without torque an error means nothing."""
    assert min(once.DURATIONS_S.values()) >= 0.2
    assert set(once.DURATIONS_S) == set(measure.CONTROLLERS)


class _Fake:
    """A runner whose measurements are given; it keeps in which order they were asked for."""

    order: list[str] = []  # noqa: RUF012

    def __init__(self, name: str, seconds: list[float], known: dict | None = None) -> None:
        self.name, self.seconds, self.known = name, iter(seconds), known

    def once(self):
        self.order.append(self.name)
        second = next(self.seconds)
        return {"cpu_s": second, "wall_s": 2 * second}


def test_a_gain_is_the_median_of_neighbours(monkeypatch):
    """A machine that slows down to a third while it measures doesn't change a ratio of two."""
    _Fake.order = []
    slowing = [1.0, 2.0, 3.0]
    base = _Fake("A", slowing)
    other = _Fake("B", [0.5 * s for s in slowing], {"clock_cycles": 100})

    @contextmanager
    def runner(*_):
        yield other

    monkeypatch.setattr(measure, "_runner", runner)
    found = measure._gain(base, measure.Tried("faster"), 3)
    assert _Fake.order == list("ABABAB")
    assert found == {"cycles_per_s": 100.0, "gain": 2.0, "gain_least": 2.0, "gain_most": 2.0}


def test_a_process_measures_each_time_that_it_is_asked():
    with measure._runner("encoder") as runner:
        ((first, second),) = measure._by_turns([runner], 2)
    assert runner.known["ticks"] == round(1e6 * once.DURATIONS_S["encoder"])
    assert first["cpu_s"] > 0 < second["cpu_s"]
    assert runner.process.returncode == 0


def test_many_clocks_in_a_call_are_as_many_calls():
    """Two controllers side by side: pins and words after every hundred clocks are the same."""
    scene = once.load_scene(once.find_scene(once.SCENE))
    one, many = once.BenchPins(scene), once.BenchPins(scene)
    clock, clocks = one._library.wh_pins_clock, many._library.wh_bench_clocks
    for function, integers in ((clock, 2), (clocks, 3)):
        function.argtypes = [verilated.ctypes.c_int64] * integers
        function.restype = verilated.ctypes.c_int64
    seen = set()
    for _ in range(50):
        pins = [clock(one._model, 1) for _ in range(100)][-1]
        assert clocks(many._model, 1, 100) == pins
        seen.add(pins)
    assert len(seen) > 3


@pytest.mark.parametrize(
    ("given", "flags"),
    [
        ({}, (verilated.DEFAULT_CXX_FLAGS, verilated.DEFAULT_VERILATOR_FLAGS)),
        ({"WH_CXX_FLAGS": "-O1 -fPIC", "WH_VERILATOR_FLAGS": "-O0"}, (("-O1", "-fPIC"), ("-O0",))),
    ],
    ids=["none", "some"],
)
def test_flags_come_from_the_environment(given, flags):
    # Where coverage is counted there are more of them.
    theirs = {k: v for k, v in os.environ.items() if k != "WH_COVERAGE"}
    show = "from wavehaptics.ladder import verilated as v; print(v.CXX_FLAGS, v.VERILATOR_FLAGS)"
    done = subprocess.run(
        [sys.executable, "-c", show], env=theirs | given, capture_output=True, text=True,
        timeout=60, check=True,
    )  # fmt: skip
    assert done.stdout.strip() == f"{flags[0]} {flags[1]}"


def test_what_fails_is_told_and_does_not_end_the_bench():
    nonsense = measure.Tried("nonsense", ("--no-such-flag",))
    with pytest.raises(measure.MeasurementError, match="status"), measure._runner("pins", nonsense):
        pass


def test_tables_of_a_summary():
    speed = {"simulated_s_per_s": 0.15, "ticks_per_s": 1.5e5, "cycles_per_s": None,
             "times_pins": 40.0, "torque_error": 1e-3}  # fmt: skip
    summary = {
        "controllers": {"golden": speed},
        "tried": [
            {"what": "as shipped", "cycles_per_s": 7e6, "gain": 1.0, "gain_least": 0.97,
             "gain_most": 1.02, "failed": None},
            {"what": "worse", "cycles_per_s": None, "failed": "it broke"},
        ],
        "others": [
            {"name": "x", "version": "1", "what": "y", "steps_per_s": 3e3,
             "simulated_s_per_s": 0.3, "current_error": 1e-9}
        ],
    }  # fmt: skip
    console = Console(record=True, width=160)
    for table in measure.tables(json.loads(json.dumps(summary))):
        console.print(table)
    text = console.export_text()
    for part in ("golden", "0.15", "it broke", "7.0·10⁶", "1.00 (0.97–1.02)", "1.0·10⁻⁹"):
        assert part in text


def test_a_library_is_built_in_the_folder_that_a_profile_is_named_after(tmp_path, monkeypatch):
    folders = []

    def built(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        folders.append(command[command.index("--Mdir") + 1])
        Path(command[command.index("-o") + 1]).write_bytes(b"library")
        return subprocess.CompletedProcess(command, 0)

    monkeypatch.setattr(verilated.subprocess, "run", built)
    work, target = tmp_path / "work", tmp_path / "model.so"
    assert verilated.verilate("top", [], target, work=work) == target
    assert folders == [str(work / "obj")]
    assert target.read_bytes() == b"library"
    assert {path.name for path in tmp_path.iterdir()} == {"model.so", "model.log"}
