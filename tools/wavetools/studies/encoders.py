# SPDX-License-Identifier: Apache-2.0
"""What an absolute encoder, read over a serial line, costs a held wall and a hit, with all errors.

Each row is an encoder; each hold and each bounce runs with four signs of all errors, and the worst
counts. A gimbal motor holds once, with the errors of its scene. Rows of one error alone say which
of an encoder's errors it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table
from wavehaptics.parts.encoders import ABSOLUTE_PARTS
from wavehaptics.runtime.files import write_json
from wavehaptics.studies.report.runs import load
from wavehaptics.trace.columns import Column

from wavetools.studies.anchored import cases, runs

SIGNS = cases.SIGNS[:4]
HOLD_S = 1.0
SPEEDS = (3.0, 10.0, 30.0)
"""Of the hits, rad/s: slower ones are over within the counts that the anchor needs."""

Progress = Callable[[str, float], None]


def _part(name: str, counts: int) -> tuple[str, ...]:
    """A part with a hysteresis of one of its own counts."""
    return (
        "encoder.kind=absolute", f"encoder.part={name}", f"encoder.counts_per_rev={counts}",
        "encoder.hysteresis_counts=1",
    )  # fmt: skip


def _alone(*settings: str, counts: int = 4096, read_hz: float = 980e3) -> tuple[str, ...]:
    return (
        "encoder.kind=absolute", "encoder.bits=14", f"encoder.counts_per_rev={counts}",
        f"encoder.read_hz={read_hz}", *settings,
    )  # fmt: skip


def encoders() -> dict[str, tuple[str, ...]]:
    """Settings by the name of their row; 14 bits have four counts in one of 4096."""
    found: dict[str, tuple[str, ...]] = {
        f"A and B, {counts}": (f"encoder.counts_per_rev={counts}",) for counts in (16384, 4096)
    }
    for name, part in ABSOLUTE_PARTS.items():
        for counts in dict.fromkeys((2**part.bits, 4096)):
            found[f"{name}, {counts}"] = _part(name, counts)
    alone = {
        "read at 11 kHz": _alone(read_hz=11.25e3),
        **{f"{us} µs late": _alone(f"encoder.latency_s={us}e-6") for us in (30, 100, 200)},
        **{
            f"noise of {noise} count": _alone(f"encoder.noise_counts={4 * noise}", read_hz=222e3)
            for noise in (0.1, 0.3, 0.6)
        },
        **{f"filter of {hz} Hz": _alone(f"encoder.bandwidth_hz={hz}") for hz in (6000, 1500, 390)},
        "hysteresis of ¼ count": _alone("encoder.hysteresis_counts=1"),
        "MT6701 without hysteresis": _part("MT6701", 4096)[:3],
        "MT6701 as A and B are delivered": (
            *_part("MT6701", 4096)[:3],
            "encoder.hysteresis_counts=4",
        ),
    }
    return found | {f"{name}, 4096": settings for name, settings in alone.items()}


def speed_back(speed: float, signs: tuple[int, ...], settings: Sequence[str]) -> float:
    """Speed of the bare rotor after a hit over its speed before, and 0 where it stays in the wall.

    It is that of the run's end: an encoder with noise ends a contact more than once.
    """
    chosen = [*cases.bounce_settings("re25-118743", speed, signs), *settings]
    _, rows = runs.run(load("bounce", chosen), part_s=50e-6)
    return max(0.0, -float(rows[-1, Column.OMEGA]) / speed)


def _held(hold: dict[str, Any]) -> bool:
    return hold["anchor_fault_s"] is None and hold["hold_error"] is not None


def row_of(
    name: str,
    settings: Sequence[str],
    signs: Sequence[tuple[int, ...]] = SIGNS,
    others: Sequence[str] = (),
) -> dict[str, Any]:
    """The worst of an encoder's holds and bounces, and a hold of a gimbal motor, SI units.

    ``others`` are further settings.

    ``lost`` are the holds whose anchor raised its fault or whose wall was gone at the end; what is
    measured is of the others, and None without any.
    """
    duration = f"scene.duration_s={HOLD_S}"
    holds = [
        runs.hold("held_wall", "golden", [*cases.all_wrong(sign), *settings, duration, *others])
        for sign in signs
    ]
    kept = [hold for hold in holds if _held(hold)]
    gimbal = runs.hold("brushless_hold", "golden", [*settings, duration, *others])
    bounced = [speed_back(speed, sign, settings) for sign in signs for speed in SPEEDS]
    sums = {
        "moved_cells": [abs(hold["moved_cells"]) for hold in kept],
        "hold_error": [abs(hold["hold_error"]) for hold in kept],
        "ripple_nm": [hold["hold_ripple_rms"] for hold in kept],
        "contact_energy_ratio": [
            ratio for hold in holds if (ratio := hold["contact_energy_ratio"]) is not None
        ],
        "speed_back": bounced,
    }
    return {
        "encoder": name,
        "holds": len(holds),
        "lost": len(holds) - len(kept),
        **{key: max(values, default=None) for key, values in sums.items()},
        "gimbal_ripple_nm": gimbal["hold_ripple_rms"] if _held(gimbal) else None,
        "gimbal_energy_ratio": gimbal["contact_energy_ratio"],
    }


def compare(out: Path, settings: Sequence[str], progress: Progress) -> dict[str, Any]:
    """Run every encoder, and write what came of it into ``out`` as JSON."""
    every, rows = encoders(), []
    for name, own in every.items():
        rows.append(row_of(name, own, others=settings))
        progress("encoders", len(rows) / len(every))
    found = {"settings": list(settings), "rows": rows}
    write_json(out, found, indent=1)
    return found


HEAD = ("Encoder, counts", "lost", "moved, counts", "of the depth", "ripple, µN·m", "energy",
        "speed back", "gimbal: ripple, µN·m", "energy")  # fmt: skip


def _ripple(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{1e6 * value:.2g}" if value < 1e-4 else f"{1e6 * value:.0f}"


def _part_of(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}".replace("-", "−")


def cells(row: dict[str, Any]) -> list[str]:
    """A row of the table."""
    moved, error = row["moved_cells"], row["hold_error"]
    return [
        row["encoder"],
        f"{row['lost']} of {row['holds']}" if row["lost"] else "–",
        "–" if moved is None else f"{moved:.2g}",
        "–" if error is None else f"{100 * error:.0f} %",
        _ripple(row["ripple_nm"]),
        _part_of(row["contact_energy_ratio"]),
        _part_of(row["speed_back"]),
        _ripple(row["gimbal_ripple_nm"]),
        _part_of(row["gimbal_energy_ratio"]),
    ]


def part_cells(name: str) -> list[str]:
    """What a part's maker says; a star stands for memory."""
    part = ABSOLUTE_PARTS[name]

    def cell(key: str, text: str) -> str:
        return text + "*" * (key in part.remembered)

    degrees = 360 * part.noise_counts / 2**part.bits
    cut_off = "–" if part.bandwidth_hz is None else f"{part.bandwidth_hz:g} Hz"
    return [
        name,
        str(part.bits),
        cell("frame", part.frame),
        cell("sclk_hz", f"{1e-6 * part.sclk_hz:g} MHz"),
        cell("read_hz", f"{1e-3 * part.read_hz:g} kHz"),
        cell("latency_s", f"{1e6 * part.latency_s:.3g} µs"),
        cell("noise_counts", f"{degrees:.2g}°"),
        cell("bandwidth_hz", cut_off),
    ]


PART_HEAD = ("Part", "bits", "frame", "SCLK", "new angles", "delay with frames", "noise, RMS",
             "filter")  # fmt: skip


def lines(found: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table."""
    return list(HEAD), [cells(row) for row in found["rows"]]


def encoder_table(found: dict[str, Any]) -> Table:
    """The same for a terminal."""
    table = Table(title="held walls and hits with all errors, the worst of four signs")
    table.add_column(HEAD[0])
    for heading in HEAD[1:]:
        table.add_column(heading, justify="right")
    for row in found["rows"]:
        table.add_row(*cells(row))
    return table
