# SPDX-License-Identifier: Apache-2.0
"""A capture or a stream as ``trace.npz``: arrays of a simulation, so that its plots serve all."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wavehaptics.host.capture import Captured
from wavehaptics.host.client import Client
from wavehaptics.host.names import places
from wavehaptics.host.stream import Streamed
from wavehaptics.trace.columns import FLOAT_COLUMNS, TRACE_FILE, write_npz
from wavehaptics.words.table import AXES

FOLLOWER_TICKS = 256
"""Ticks over which the word ``lag`` is the rotor's way."""


@dataclass(frozen=True)
class Device:
    """What rows of a motor's words are turned into SI by, besides the formats.

    ``cell_rad`` is a count of the encoder, rad, and ``k_t`` in N·m/A; NaN where not known.
    """

    eta_contact: float = math.nan
    eta_free: float = math.nan
    delay_ticks: int = 1
    """Ticks from that of a step's current to the one in which its voltage is applied."""
    cell_rad: float = math.nan
    k_t: float = math.nan
    brushless: bool = False
    """Currents, voltages and waves are those of an axis that stands, not what the torque is of."""


def device_of(
    client: Client, motor: int = 0, counts_per_rev: int | None = None, k_t: float | None = None
) -> Device:
    """The motor's side of a device, by its words and by what a person knows of it."""
    names = ("eta_contact", "eta_free", "extra_ticks")
    brushless = client.shape.brushless
    motor -= motor % AXES if brushless else 0
    found = [places(name, client.shape, motor)[0] for name in names]
    contact, free, extra = (
        place.value(raw) for place, raw in zip(found, client.read(found), strict=True)
    )
    return Device(
        contact, free, 1 + int(extra),
        2.0 * math.pi / counts_per_rev if counts_per_rev else math.nan,
        math.nan if k_t is None else k_t, brushless,
    )  # fmt: skip


def trace_arrays(found: Captured, device: Device) -> dict[str, np.ndarray]:
    """The arrays of :meth:`wavehaptics.trace.columns.TraceWriter.save`, of shape (rows,).

    What wasn't captured, or isn't known, is NaN, and flags are False. As in a simulation ``x`` is
    the mean of a row's ends, ``e_a`` the voltage that was applied in a row's ticks. ``energy_out``
    is that of the waves, with R̂ for the winding's resistance, where each tick has its row. Channels
    that a simulation has no array for come under their own names, and ``lost`` says which rows of a
    stream didn't arrive. So do those of a brushless motor's axes: a simulation has them along the
    torque.
    """
    rows, plan = len(found.t), found.plan
    nothing = np.full(rows, np.nan)
    arrays = {column.name.lower(): nothing.copy() for column in FLOAT_COLUMNS}
    arrays |= {"energy_out": nothing.copy()}
    arrays |= {name: np.zeros(rows, dtype=bool) for name in ("contact", "saturated")}
    arrays["t"] = found.t
    values = found.values
    cell = device.cell_rad
    if device.brushless:
        values = {name: values[name] for name in ("position", "flags") if name in values}
    if "current" in values:
        arrays["i"] = values["current"]
        arrays["torque"] = device.k_t * values["current"]
    if "voltage" in values and rows:
        late = found.t - device.delay_ticks * plan.tick_s
        arrays["e_a"] = np.interp(late, found.t, values["voltage"])
    if "position" in values:
        ends = values["position"] * cell
        begins = np.concatenate((ends[:1], ends[:-1]))
        arrays["x"], arrays["omega"] = 0.5 * (begins + ends), (ends - begins) / plan.row_s
    if "flags" in values:
        for name in ("contact", "saturated"):
            arrays[name] = found.flag(name)
        arrays["eta"] = np.where(arrays["contact"], device.eta_contact, device.eta_free)
    for name in {"u", "v"} & {*values}:
        arrays[name] = values[name]
    if plan.decimation == 1:
        power = 0.5 * (arrays["u"] ** 2 - arrays["v"] ** 2)
        arrays["energy_out"] = np.cumsum(power) * plan.tick_s
    if {"correction", "flux", "lag"} & {*values}:
        flux = arrays["flux"] = values.get("flux", nothing)
        arrays["correction"] = values.get("correction", nothing)
        arrays["x_hat"] = (values.get("position", nothing) + 0.5 - flux) * cell
        way = values.get("lag", nothing) * cell
        arrays["omega_hat"] = way / (FOLLOWER_TICKS * plan.tick_s)
        arrays["fault"] = (
            found.flag("anchor_fault") if "flags" in values else np.zeros(rows, dtype=bool)
        )
    if isinstance(found, Streamed):
        arrays["lost"] = found.lost
    used = {"current", "voltage", "position", "u", "v", "correction", "flux", "lag"}
    if device.brushless:
        used = {"position"}
    return arrays | {name: value for name, value in found.values.items() if name not in used}


def save(arrays: dict[str, np.ndarray], folder: Path) -> Path:
    """Write ``trace.npz`` into ``folder``, whole or not at all; its path."""
    return write_npz(folder / TRACE_FILE, arrays)
