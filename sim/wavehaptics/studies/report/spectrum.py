# SPDX-License-Identifier: Apache-2.0
"""The spectrum of what the whole clocks of the PWM leave over."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from wavehaptics.controller import modulator
from wavehaptics.runtime.compiled import compiled_counting
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number
from wavehaptics.studies.sweeps import Task
from wavehaptics.words import formats

TITLE = "What becomes of the PWM's steps?"

TICK_HZ = 1e6
HALF_CLOCKS = 48
TICKS = 1 << 18
BAND_HZ = 5e3
"""What a hand and the winding let through."""
ORDERS = {"rounded": 0, "first order": 1, "second order": 2}


@compiled_counting()
def _widths(duty: np.ndarray, order: int, out: np.ndarray) -> None:
    state = np.zeros(2, np.int64)
    for n in range(duty.shape[0]):
        if order == 0:
            state[:] = 0
        out[n] = modulator.half_width(state, duty[n], 0, HALF_CLOCKS, order == 2)


def error_spectrum(order: int) -> dict[str, Any]:
    """Spectrum of pulse width less duty, over full scale, for a slow sine of a third of it."""
    n = np.arange(TICKS)
    full = HALF_CLOCKS // 2
    wanted = full / 3 * np.sin(2 * np.pi * 37 * n / TICKS) + 0.123
    one = 1 << formats.DUTY.fraction
    duty = np.round(wanted * one).astype(np.int64)
    widths = np.zeros(TICKS, dtype=np.int64)
    _widths(duty, order, widths)
    error = (widths - duty / one) / full
    power = np.abs(np.fft.rfft(error * np.hanning(TICKS))) ** 2 / (TICKS**2 * 0.375 / 2)
    hz = np.fft.rfftfreq(TICKS, 1 / TICK_HZ)
    band = float(np.sqrt(power[(hz > 0) & (hz <= BAND_HZ)].sum()))
    edges = np.geomspace(20, TICK_HZ / 2, 161)
    density = [
        (float(np.sqrt(low * high)), float(np.sqrt(power[inside].mean())))
        for low, high in pairwise(edges)
        if (inside := (hz >= low) & (hz < high)).any()
    ]
    return {
        "order": order,
        "band_rms": band,
        # A converter of b bits has an error of 2^(1−b)/√12 of its full scale.
        "bits_in_band": float(1 - np.log2(band * np.sqrt(12))),
        "hz": [at for at, _ in density],
        "rms": [rms for _, rms in density],
    }


def tasks(quick: bool) -> list[Task]:
    del quick
    return [Task(error_spectrum, {"order": order}) for order in ORDERS.values()]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    del tasks
    return {"half_clocks": HALF_CLOCKS, "band_hz": BAND_HZ, "orders": results}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    names = {order: name for name, order in ORDERS.items()}
    figure, (ax,) = figures.panels(1, 3.6)
    for n, found in enumerate(data["orders"]):
        figures.curve(ax, found["hz"], found["rms"], n, names[found["order"]], marker="", lw=1.2)
    ax.axvline(data["band_hz"], color=figures.GREY, lw=0.8, ls=":")
    ax.set_xscale("log")
    ax.set_yscale("log")
    figures.label(ax, "frequency, Hz", "error of a line, over full scale")
    figures.legend(ax)
    path = figures.save(figure, folder / "spectrum.png")
    rows = [
        (names[f["order"]], number(f["band_rms"]), f"{f['bits_in_band']:.1f}")
        for f in data["orders"]
    ]
    return [
        Text(
            f"A pulse ends on a whole clock: {data['half_clocks'] // 2} steps from no voltage to "
            "full. What a pulse can't give is owed to the next ones, which moves the error to "
            "frequencies that neither the winding nor a hand follows. Bits are those of a plain "
            f"converter with the same error below {data['band_hz'] / 1e3:g} kHz."
        ),
        Picture(path, "Spectrum of the voltage's error for a slow sine; 5 kHz dotted."),
        Table("Error in the band", ("what is left over is", "RMS over full scale", "bits"), rows),
    ]
