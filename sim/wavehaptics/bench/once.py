# SPDX-License-Identifier: Apache-2.0
"""One measurement in a process of its own, as the flags of the environment say.

``python -m wavehaptics.bench.once WHAT REPEATS [WORK]`` prints one line of JSON. WHAT is a
controller, ``short`` for a short run of ``pins``, or ``alone`` for the Verilated RTL without its
motor. WORK is a folder to build in, for
a profile, whose files are named after the folder.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numba

from wavehaptics import verilated
from wavehaptics.native_call import call2
from wavehaptics.pins import PinsSimulation
from wavehaptics.run import measure
from wavehaptics.scene import find_scene, load_scene

SCENE = "paper_taps"
DURATIONS_S = {"analog": 0.3, "golden": 1.5, "core": 0.2, "pins": 0.2, "encoder": 0.5}
SHORT_S = 0.03
"""Enough for a comparison of speeds, but too short for an error."""
CLOCKS = 2_000_000


class BenchPins(PinsSimulation):
    """The whole RTL with what is only measured."""

    SHIM = "bench_shim.cpp"


@numba.njit
def _each(function, model, clocks):
    out = 0
    for _ in range(clocks):
        out ^= call2(function, model, 0)
    return out


def alone(repeats: int) -> dict[str, Any]:
    """Clocks a second of the RTL without a motor, a call for each clock and many in a call."""
    simulation = BenchPins(load_scene(find_scene(SCENE)))
    library, model = simulation._library, simulation._model
    for name in ("wh_bench_clocks", "wh_bench_quiet"):
        getattr(library, name).argtypes = [verilated.ctypes.c_int64] * 3
        getattr(library, name).restype = verilated.ctypes.c_int64
    each = verilated.address(library.wh_pins_clock)
    _each(each, model, 1)
    best = {"each": 0.0, "packed": 0.0}
    for _ in range(repeats):
        began = time.perf_counter()
        _each(each, model, CLOCKS)
        best["each"] = max(best["each"], CLOCKS / (time.perf_counter() - began))
        began = time.perf_counter()
        library.wh_bench_clocks(model, 0, CLOCKS)
        best["packed"] = max(best["packed"], CLOCKS / (time.perf_counter() - began))
    changes = library.wh_bench_quiet(model, 0, CLOCKS)
    return {
        "cycles_per_s_a_call_each": best["each"],
        "cycles_per_s_many_a_call": best["packed"],
        "clocks_that_change_a_pin": changes / CLOCKS,
    }


def whole(controller: str, repeats: int, duration_s: float) -> dict[str, Any]:
    """Speed of the paper's taps on a controller, its motor in the loop; the best of some runs."""
    scene = load_scene(find_scene(SCENE), [f"scene.duration_s={duration_s}"])
    runs = [measure(scene, controller) for _ in range(repeats)]
    best = min(runs, key=lambda m: m["wall_clock_s"])
    seconds, cycles = best["wall_clock_s"], best["clock_cycles"]
    return {
        "ticks_per_s": best["ticks"] / seconds,
        "cycles_per_s": None if cycles is None else cycles / seconds,
        "simulated_s_per_s": best["duration_s"] / seconds,
        "torque_error": best["torque_nrmse_vs_analog"],
    }


def main(what: str, repeats: str, work: str = "") -> None:
    """Measure and print."""
    if work:
        Path(work).mkdir(parents=True)
        verilated.tempfile.mkdtemp = lambda **_: work
    count = int(repeats)
    if what == "alone":
        found = alone(count)
    elif what == "short":
        found = whole("pins", count, SHORT_S)
    else:
        found = whole(what, count, DURATIONS_S[what])
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
