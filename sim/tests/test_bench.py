# SPDX-License-Identifier: Apache-2.0
"""The bench: what it measures is what runs, flags reach the compiler, failures are told."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from rich.console import Console
from wavehaptics import verilated
from wavehaptics.bench import measure, once


@pytest.mark.parametrize("controller", ["golden", "encoder"])
def test_speed_of_a_controller(controller):
    found = once.whole(controller, 2, 0.2)
    assert found["ticks_per_s"] == pytest.approx(1e6 * found["simulated_s_per_s"])
    assert found["simulated_s_per_s"] > 0.1
    assert found["cycles_per_s"] is None


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


def test_flags_come_from_the_environment():
    environment = os.environ | {"WH_CXX_FLAGS": "-O1 -fPIC", "WH_VERILATOR_FLAGS": "-O0"}
    show = "from wavehaptics import verilated as v; print(v.CXX_FLAGS, v.VERILATOR_FLAGS)"
    done = subprocess.run(
        [sys.executable, "-c", show], env=environment, capture_output=True, text=True,
        timeout=60, check=True,
    )  # fmt: skip
    assert done.stdout.strip() == "('-O1', '-fPIC') ('-O0',)"
    assert verilated.CXX_FLAGS == verilated.DEFAULT_CXX_FLAGS


def test_what_fails_is_told_and_does_not_end_the_bench():
    found = measure._once("pins", 1, measure.Tried("nonsense", ("--no-such-flag",)))
    assert "failed" in found
    assert "status" in found["failed"]


def test_tables_of_a_summary():
    speed = {"simulated_s_per_s": 0.15, "ticks_per_s": 1.5e5, "cycles_per_s": None,
             "torque_error": 1e-3}  # fmt: skip
    summary = {
        "controllers": {"golden": speed},
        "tried": [
            {"what": "as shipped", "cycles_per_s": 7e6, "gain": 1.0, "failed": None},
            {"what": "worse", "cycles_per_s": None, "gain": None, "failed": "it broke"},
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
    for part in ("golden", "0.15", "it broke", "7.0·10⁶", "1.0·10⁻⁹"):
        assert part in text
