# SPDX-License-Identifier: Apache-2.0
"""A wall in a hand: slow presses, loads that the controller doesn't know, and heat."""

from __future__ import annotations

import itertools
from typing import Any

from wavehaptics.studies.sweeps import Task

from wavetools.studies.anchored import cases, runs
from wavetools.studies.anchored.cases import NOTHING

# ---- Slow presses: what energy the wall gives to the hand.

FREQUENCIES = (0.3, 0.5, 1.0, 1.5, 2.0, 4.0)
QUICK_FREQUENCIES = (0.5, 1.5, 4.0)
PRESSES = 3
"""In a run; of the slowest ones a press less."""
SOFT = (*cases.SOFT, "shaper.feel=spring", "shaper.stiffness=0.45", "shaper.damping=0.05e-3")
WALLS: dict[str, tuple[str, ...]] = {"rigid": (), "soft": SOFT}
EVERYTHING = {f"everything, {sign}": wrong for sign, wrong in (
    (cases.sign_text(signs), cases.all_wrong(signs)) for signs in cases.SIGNS[:4])}  # fmt: skip
ALONE = {
    name: settings
    for name, settings in cases.ALONE.items()
    if name != "nothing" and not name.startswith(("supply", "contact noise 3 %, flicker"))
}
WRONG: dict[str, tuple[str, ...]] = {"nothing": ()} | ALONE | EVERYTHING


def press(wall: str, frequency: float, wrong: str) -> dict[str, Any]:
    """Press a wall and let go, some times; ``wrong`` is of WRONG."""
    periods = PRESSES if frequency >= 1.0 else PRESSES - 1
    # With both supplies of all_wrong in one step: it would come in another press at each frequency.
    settings = [s for s in WRONG[wrong] if not s.startswith(("drive.bus_v", "drive.step"))]
    found = runs.swing(
        "held_wall",
        [*NOTHING, *WALLS[wall], "hand.path=taps", f"hand.frequency_hz={frequency}",
         "hand.amplitude_rad=0.15", f"scene.duration_s={periods / frequency:.6g}", *settings],
    )  # fmt: skip
    return {"wall": wall, "frequency": frequency, "wrong": wrong} | found


# ---- Loads.

LOADS = (1.0, 10.0, 50.0)
"""Inertia on the shaft over the rotor's own, which is all that the controller knows of."""
DAMPINGS = (0.1e-3, 0.5e-3, 2e-3)
"""Of the hand, N·m·s/rad."""
HELD_S = 2.5


def held_load(load: float, damping: float, wrong: str) -> dict[str, Any]:
    """A hold with a load on the shaft."""
    found = runs.hold(
        "held_wall", "golden",
        [*NOTHING, *WRONG[wrong], *cases.loaded(load), f"hand.damping={damping:g}",
         f"scene.duration_s={HELD_S:g}"],
    )  # fmt: skip
    return {"load": load, "damping": damping, "wrong": wrong} | found


def thrown_load(load: float, wrong: str) -> dict[str, Any]:
    """Bounces of a rotor with a load; ``wrong`` is of :data:`cases.BOUNCED`."""
    points = cases.bounces("re25-118743", wrong, load)
    return {
        "load": load,
        "wrong": wrong,
        "restitution": [point["restitution"] for point in points],
        "fault": [point["anchor_fault_s"] is not None for point in points],
    }


RATES = (25e3, 50e3, 100e3, 250e3, 1e6)
"""Of control, Hz; the two lowest are those of boards with a slow current amplifier."""


def held_rate(rate_hz: float, load: float, wrong: str) -> dict[str, Any]:
    """A hold with a load on the shaft, at the boards' λ and a control rate."""
    found = runs.hold(
        "held_wall", "golden",
        [*NOTHING, *WRONG[wrong], *cases.loaded(load), f"controller.tick_hz={rate_hz:g}",
         "controller.lambda=1e4", f"scene.duration_s={HELD_S:g}"],
    )  # fmt: skip
    return {"rate_hz": rate_hz, "load": load, "wrong": wrong} | found


# ---- Heat.

TEMPERATURES = (-20.0, 25.0, 60.0, 80.0, 100.0, 125.0)
"""Of winding and magnets, °C."""
MAGNET_PER_K = -0.0011
RATED = "hand.amplitude_rad=0.3"
"""Twice the half of the rated torque of ``held_wall``: 29 mN·m."""


def heat(celsius: float, wrong: str) -> dict[str, Any]:
    """A hold with the rated torque, and presses as strong, with a winding of that temperature."""
    settings = [
        *NOTHING, *WRONG[wrong], f"thermal.start_c={celsius:g}", f"thermal.ambient_c={celsius:g}",
        f"thermal.magnet_per_k={MAGNET_PER_K}", RATED, "scene.duration_s=2",
    ]  # fmt: skip
    pressed = runs.swing("held_wall", [*settings, "hand.path=taps", "hand.frequency_hz=1"])
    return {
        "celsius": celsius,
        "wrong": wrong,
        "hold": runs.hold("held_wall", "golden", settings),
        "press": pressed,
    }


def tasks(quick: bool = False) -> dict[str, list[Task]]:
    """Tasks by the name of their group; ``quick`` presses less often and with fewer errors."""
    grid = itertools.product
    many = ("nothing", *EVERYTHING)
    frequencies = QUICK_FREQUENCIES if quick else FREQUENCIES
    return {
        "presses": [
            Task(press, {"wall": wall, "frequency": frequency, "wrong": wrong})
            for frequency, wall, wrong in grid(frequencies, WALLS, many if quick else WRONG)
        ],
        "loads": [
            Task(held_load, {"load": load, "damping": damping, "wrong": wrong})
            for load, damping, wrong in grid(LOADS, DAMPINGS, many)
        ],
        "throws": [
            Task(thrown_load, {"load": load, "wrong": wrong})
            for load, wrong in grid(LOADS[1:], cases.BOUNCED)
        ],
        "rates": [
            Task(held_rate, {"rate_hz": rate_hz, "load": load, "wrong": wrong})
            for rate_hz, load, wrong in grid(RATES, LOADS, many)
        ],
        "heat": [
            Task(heat, {"celsius": celsius, "wrong": wrong})
            for celsius, wrong in grid(TEMPERATURES, many)
        ],
    }
