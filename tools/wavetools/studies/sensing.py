# SPDX-License-Identifier: Apache-2.0
"""What each part that senses the current is worth at each carrier: stiffness, ripple, held wall."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table
from wavehaptics.ladder.run import measure
from wavehaptics.parts.sensing import HOLD_TOLERANCE, SensingPart, sensing_parts
from wavehaptics.runtime.files import write_json
from wavehaptics.scene import SceneError, find_scene, load_scene
from wavehaptics.studies.tune import CARRIERS_HZ

SCENE = "held_wall"
"""A hand presses a wall; R̂, the drive's gain and the sensor's zero are wrong."""

SHUNT_OHM = 0.033
BUS_V = 12.0

SETTINGS = ("scene.duration_s=0.2", f"drive.bus_v={BUS_V:g}", "controller.lambda=1e4")
"""A press of 0.2 s, and λ of the boards; the tick is half a carrier period, as on all of them."""

PLAIN = "ideal"
TWELVE_BITS = "adc.part=AD7276"

Progress = Callable[[str, float], None]


def _variants() -> dict[str, tuple[SensingPart | None, list[str]]]:
    """Parts by the name of their row, with the keys that make them; the first is an ideal one."""
    found: dict[str, tuple[SensingPart | None, list[str]]] = {PLAIN: (None, [TWELVE_BITS])}
    for name, part in sensing_parts().items():
        keys = part.settings(BUS_V, SHUNT_OHM)
        # The scene's 12 bits and its latency are another converter's.
        keys += ["adc.bits=16", "controller.extra_ticks=3"] if part.modulator else [TWELVE_BITS]
        found[name] = part, keys
        if part.hold_s:
            longer_s = part.hold_s * (1.0 + HOLD_TOLERANCE)
            found[f"{name}, hold {longer_s * 1e6:g} µs"] = (
                part, [*keys, f"adc.edge_hold_s={longer_s}"]
            )  # fmt: skip
    return found


def row_of(
    name: str, part: SensingPart | None, keys: Sequence[str], carrier_hz: float,
    settings: Sequence[str] = (),
) -> dict[str, Any]:  # fmt: skip
    """A part at a carrier: what came of the press, SI units.

    ``refusal`` is why the part isn't for this carrier; it runs all the same. What can't run, a part
    that sees one half of a period among them, has ``not_run`` in place of numbers.
    """
    tick_s = 0.5 / carrier_hz
    refusal = part.refusal(carrier_hz, tick_s) if part is not None else None
    row = {"part": name, "carrier_hz": carrier_hz, "refusal": refusal}
    if part is not None and part.one_half:
        return {**row, "not_run": "sampled twice a period"}
    chosen = [*SETTINGS, f"drive.pwm_hz={carrier_hz}", f"controller.tick_hz={1 / tick_s}"]
    path = find_scene(SCENE)
    try:
        scene = load_scene(path, [*chosen, *keys, *settings])
        found = measure(scene, "pins", compare=False)
    except SceneError as error:
        return {**row, "not_run": str(error).removeprefix(f"{path.parent}/")}
    return {
        **row,
        "clock_hz": found["clock_cycles"] / found["ticks"] / tick_s,
        "stiffness": found["stiffness"],
        "stiffness_predicted": found["stiffness_predicted"],
        "ripple_nm": found["hold_ripple_rms"],
        "hold_error": found["hold_error"],
        "contact_energy_ratio": found["contact_energy_ratio"],
        "anchor_fault_s": found["anchor_fault_s"],
    }


def compare(out: Path, settings: Sequence[str], progress: Progress) -> dict[str, Any]:
    """Run every part at every carrier, and write what came of it into ``out`` as JSON."""
    variants, rows = _variants(), []
    count = len(variants) * len(CARRIERS_HZ)
    for name, (part, keys) in variants.items():
        for carrier_hz in CARRIERS_HZ:
            rows.append(row_of(name, part, keys, carrier_hz, settings))
            progress("parts at carriers", len(rows) / count)
    found = {"settings": list(settings), "rows": rows}
    write_json(out, found, indent=1)
    return found


def cell(row: dict[str, Any]) -> str:
    """Stiffness over predicted, ripple in µN·m and hold error of a run, in a few characters.

    In parentheses where the part isn't for this carrier.
    """
    if "not_run" in row:
        return "–"
    if row["anchor_fault_s"] is not None:
        shown = f"lost after {1e3 * row['anchor_fault_s']:.2g} ms"
    elif row["stiffness"] is None or row["hold_error"] is None:
        shown = "no wall"
    else:
        part = row["stiffness"] / row["stiffness_predicted"]
        shown = f"{part:.2f}; {1e6 * row['ripple_nm']:.0f}; {row['hold_error']:+.1%}"
    return f"({shown})" if row["refusal"] else shown


def _fastest(name: str) -> str:
    part = sensing_parts().get(name.partition(",")[0])
    if part is None or math.isinf(part.carrier_hz):
        return "–"
    return f"{1e-3 * part.carrier_hz:.0f} kHz"


def lines(found: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table: a part a row, a carrier a column."""
    carriers = list(dict.fromkeys(row["carrier_hz"] for row in found["rows"]))
    names = list(dict.fromkeys(row["part"] for row in found["rows"]))
    shown = {(row["part"], row["carrier_hz"]): cell(row) for row in found["rows"]}
    head = ["Part", "Fastest", *(f"{1e-3 * carrier:g} kHz" for carrier in carriers)]
    return head, [
        [name, _fastest(name), *(shown[name, carrier] for carrier in carriers)] for name in names
    ]


def sensing_table(found: dict[str, Any]) -> Table:
    """The same for a terminal."""
    head, rows = lines(found)
    table = Table(title="stiffness over predicted; ripple held, µN·m; hold error")
    table.add_column(head[0])
    for heading in head[1:]:
        table.add_column(heading, justify="right")
    for row in rows:
        table.add_row(*row)
    return table
