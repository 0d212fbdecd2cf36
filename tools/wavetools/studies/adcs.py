# SPDX-License-Identifier: Apache-2.0
"""What each ADC is worth at the pins: how late its words are, what is felt, what is lost."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rich.table import Table
from wavehaptics.controller.pins_timing import HOLD_CLOCKS, latency_clocks
from wavehaptics.controller.tick_layout import Timing
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.ladder.run import Simulation, measure
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.parts.adcs import ALL_BITS
from wavehaptics.runtime.files import write_json
from wavehaptics.scene import Scene, load_scene

NOISE_STEPS = 0.5
"""Noise of every ADC, RMS in its own steps; but for the modulators, that have their own."""

STIFF = ("controller.lambda=1e9", "scene.duration_s=0.26")
"""The stiffest wall that the latency allows, up to the deepest point of the first contact."""

ENERGY_TICKS_HZ = (1e6, 100e3, 10e3)
ENERGY = ("controller.lambda=1e9", "scene.duration_s=0.5")

Progress = Callable[[str, float], None]


def tau(stiffness: float | None, scene: Scene) -> float | None:
    """τ of the stiffness that was rendered, s: see :func:`closed_forms.stiffness`."""
    if stiffness is None or stiffness <= 0:
        return None
    motor = scene.motor
    return 2.0 * (motor.k_t**2 / stiffness - motor.L_h) / motor.R_ohm


def delays(timing: Timing) -> dict[str, float]:
    """Times from where the last sample of a tick is held, ns.

    ``conversion_ns`` to the word, ``digital_ns`` from there to the duty, ``gate_ns`` to the edge
    of the tick in which the gates show it. A modulator's sample is the middle of its word's bits.
    """
    ns = 1e9 / timing.clock_hz
    made = timing.frame
    digital = latency_clocks(0)
    if made.osr:
        # The word stands one and a half of its intervals after the middle of its bits.
        conversion = 1.5 * made.cycle_clocks + made.conversion_clocks
    else:
        conversion = made.pipeline * timing.sample_clocks + made.conversion_clocks - HOLD_CLOCKS
    # Held in the middle of its interval, as the gates have it; the last one ends with the tick.
    to_gate = timing.sample_clocks / 2 + timing.extra_ticks * timing.tick_clocks
    return {"conversion_ns": conversion * ns, "digital_ns": digital * ns, "gate_ns": to_gate * ns}


def _part(
    path: Path, settings: Sequence[str], name: str, progress: Callable[[float], None]
) -> dict[str, Any]:
    settings = [*settings, f"adc.part={name}"]
    scene = load_scene(path, settings)
    assert scene.adc is not None
    step = 2 * scene.adc.full_scale_a / (1 << ALL_BITS[name])
    simulation = PinsSimulation(scene)
    modulator = simulation.timing.frame.osr > 0
    if not modulator:
        settings.append(f"adc.noise_a={NOISE_STEPS * step:.9f}")
    scene, stiff = load_scene(path, settings), load_scene(path, [*settings, *STIFF])
    simulation, stiffest = PinsSimulation(scene), PinsSimulation(stiff)
    timing = simulation.timing
    total = scene.scene.duration_s + stiff.scene.duration_s
    part = scene.scene.duration_s / total
    metrics = measure(
        scene, "pins", progress=lambda done: progress(done * part), simulation=simulation
    )
    hard = measure(
        stiff, "pins", progress=lambda done: progress(part + done * (1 - part)),
        simulation=stiffest,
    )  # fmt: skip

    def microseconds(seconds: float | None) -> float | None:
        return None if seconds is None else 1e6 * seconds

    return {
        "part": name,
        "bits": ALL_BITS[name],
        "clock_mhz": timing.clock_hz / 1e6,
        "sclk_mhz": timing.clock_hz / timing.frame.bit_clocks / 1e6,
        "rate_hz": timing.clock_hz / timing.frame.cycle_clocks,
        "samples": timing.samples,
        **delays(timing),
        "extra_ticks": timing.extra_ticks,
        "tau_us": microseconds(tau(metrics["stiffness"], scene)),
        "tau_set_us": 1e6 * simulation.settings.tau,
        "stiff_tau_us": microseconds(tau(hard["stiffness"], stiff)),
        "stiff_tau_set_us": 1e6 * stiffest.settings.tau,
        "torque_error": metrics["torque_nrmse_vs_analog"],
        "energy_out_max_j": metrics["energy_out_max_j"],
    }


def energies(path: Path, settings: Sequence[str], progress: Progress) -> list[dict[str, Any]]:
    """Most net energy that the port gave out, by tick, for the mean and for point samples.

    On ``golden`` the point sample is at the tick's end; on ``pins`` it is in the tick's middle.
    """
    rows = []
    for tick_hz in ENERGY_TICKS_HZ:
        scene = load_scene(path, [*settings, *ENERGY, f"controller.tick_hz={tick_hz:g}"])
        several = PinsSimulation(scene)
        runs: dict[str, tuple[str, Simulation]] = {
            "mean_j": ("golden", SampledSimulation(scene, rtl=False)),
            "point_j": ("golden", SampledSimulation(scene, rtl=False, point_sampling=True)),
            "one_j": ("pins", PinsSimulation(scene, most_samples=1)),
            "several_j": ("pins", several),
        }
        row: dict[str, Any] = {"tick_s": 1 / tick_hz, "samples": several.timing.samples}
        for name, (controller, simulation) in runs.items():
            label = f"energies, {name} at a tick of {1e6 / tick_hz:g} µs"
            metrics = measure(
                scene, controller, simulation=simulation,
                progress=partial(progress, label),
            )  # fmt: skip
            row[name] = metrics["energy_out_max_j"]
        rows.append(row)
    return rows


def compare(path: Path, settings: Sequence[str], out: Path, progress: Progress) -> dict[str, Any]:
    """Run the scene with every ADC, and write what came of it into ``out`` as JSON."""
    parts = [_part(path, settings, name, partial(progress, name)) for name in ALL_BITS]
    found = {
        "scene": path.stem,
        "settings": list(settings),
        "parts": parts,
        "energies": energies(path, settings, progress),
    }
    write_json(out, found, indent=1)
    return found


def adc_table(found: dict[str, Any]) -> Table:
    """The parts' numbers for a terminal."""
    table = Table(title=f"{found['scene']} on pins")
    table.add_column("ADC")
    for heading in ("sample to gate, ns", "τ, µs", "τ at a = 0.99, µs", "torque error"):
        table.add_column(heading, justify="right")
    for row in found["parts"]:
        table.add_row(
            row["part"],
            f"{row['gate_ns']:.0f}",
            "no wall" if row["tau_us"] is None else f"{row['tau_us']:.1f}",
            "no wall" if row["stiff_tau_us"] is None else f"{row['stiff_tau_us']:.2f}",
            f"{row['torque_error']:.1e}",
        )
    return table
