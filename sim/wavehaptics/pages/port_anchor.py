# SPDX-License-Identifier: Apache-2.0
"""What the pages keep and show of the study: a few numbers and tables."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from wavehaptics.studies.report.blocks import number, percent

BOUNCES = tuple(f"bounce_{speed:g}" for speed in (1.0, 3.0, 10.0, 30.0))
TARGETS = {"hold": 0.01, "swing": 0.01, "soft": 0.02}
"""Part of the depth that a wall may move besides half a cell."""


def of_holding(found: dict[str, Any]) -> dict[str, Any]:
    """The numbers that the pages quote, of ``holding.json``."""
    kept = {name: found[name] for name in ("holds", "plain", "bars", "feels", "overloads", "free")}
    for name in ("holds", "plain", "bars", "feels", "overloads"):
        kept[name] = [
            {key: row[key] for key in row if key in _WANTED or isinstance(row[key], str)}
            for row in found[name]
        ]
    kept["bounces"] = [
        {
            "preset": run["preset"],
            "wrong": run["wrong"],
            "restitution": [point["restitution"] for point in run["points"]],
            "fault": [point["anchor_fault_s"] is not None for point in run["points"]],
        }
        for run in found["bounces"]
    ]
    kept["lost"] = found["lost"]
    kept["motors"] = _motors(found["motors"])
    return kept


_WANTED = {
    *("duration_s", "cell_rad", "moved_cells", "depth_cells", "rms_cells", "hold_ripple_rms"),
    *("force", "correction_out_max_j", "correction_bound_j", "anchor_fault_s", "part", "place"),
    *("damping", "limited_s", "most_cells", "judged_s", "saturated_fraction"),
}


def _spread(values: list[float], seeds: list[int]) -> dict[str, Any] | None:
    if not values:
        return None
    worst = int(np.argmax(values))
    return {
        "median": float(np.median(values)),
        "p90": float(np.percentile(values, 90)),
        "worst": values[worst],
        "seed": seeds[worst],
        "n": len(values),
    }


def _motors(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Median, 90 %, worst and its seed of each part, and who raised a fault or was lost."""
    spreads: dict[str, Any] = {}

    def gather(name: str, part: str, value: Callable[[dict[str, Any]], float | None]) -> None:
        found = [(value(row[part]), row["seed"]) for row in rows if not _refused(row[part])]
        pairs = [(float(v), seed) for v, seed in found if v is not None]
        spreads[name] = _spread([v for v, _ in pairs], [seed for _, seed in pairs])

    for part in TARGETS:
        gather(f"{part}_cells", part, lambda row: _absolute(row.get("moved_cells")))
        gather(f"{part}_over", part, partial(_over, part=TARGETS[part]))
    gather("ripple_part", "hold", _ripple)
    for part in BOUNCES:
        gather(part, part, lambda row: row.get("restitution"))
    parts = (*TARGETS, *BOUNCES)
    return {
        "seeds": [rows[0]["seed"], rows[-1]["seed"]],
        "spreads": spreads,
        "faults": {
            part: [row["seed"] for row in rows if row[part].get("anchor_fault_s") is not None]
            for part in parts
        },
        "lost": {
            part: [row["seed"] for row in rows if _is_lost(part, row[part])] for part in TARGETS
        },
        "over": {
            part: [row["seed"] for row in rows if (_over(row[part], TARGETS[part]) or 0.0) > 0.0]
            for part in TARGETS
        },
        "thrown": {
            part: [row["seed"] for row in rows if (row[part].get("restitution") or 0.0) > 1.0]
            for part in BOUNCES
        },
        "refused": [row["seed"] for row in rows if any("refused" in row[p] for p in parts)],
    }


def _refused(row: dict[str, Any]) -> bool:
    return "refused" in row or "lost" in row


def _is_lost(part: str, row: dict[str, Any]) -> bool:
    return "lost" in row or ("refused" not in row and row.get("moved_cells") is None)


def _absolute(value: float | None) -> float | None:
    return None if value is None else abs(value)


def _over(row: dict[str, Any], part: float) -> float | None:
    """What a wall has moved beyond half a cell and its part of the depth, cells."""
    if row.get("moved_cells") is None:
        return None
    return abs(row["moved_cells"]) - 0.5 - part * row["depth_cells"]


def _ripple(row: dict[str, Any]) -> float | None:
    if row.get("hold_ripple_rms") is None or not row.get("force"):
        return None
    return row["hold_ripple_rms"] / row["force"]


# ---- The tables.

Table = Callable[..., str]


def _cells(value: float | None) -> str:
    return "lost" if value is None else number(value, 3 if abs(value) >= 10 else 2)


def _fault(row: dict[str, Any]) -> str:
    return "–" if row.get("anchor_fault_s") is None else f"{1e3 * row['anchor_fault_s']:.0f} ms"


def _holds(numbers: dict[str, Any], table: Table) -> str:
    head = ("wrong", "controller", "s", "moved, cells", "of the depth", "ripple, µN·m",
            "of the force", "energy of c, µJ", "fault", "without the anchor")  # fmt: skip
    plain = {row["name"]: row for row in numbers["holding"]["plain"]}
    rows = []
    for row in numbers["holding"]["holds"]:
        if row["controller"] == "golden" and row["duration_s"] > 30:
            continue  # as on `core`, to the last digit
        moved = row["moved_cells"]
        rows.append(
            (
                row["name"],
                f"`{row['controller']}`",
                number(row["duration_s"]),
                _cells(moved),
                "–" if moved is None else percent(moved / row["depth_cells"]),
                "–" if moved is None else number(1e6 * row["hold_ripple_rms"], 3),
                "–" if moved is None else percent(row["hold_ripple_rms"] / row["force"]),
                number(1e6 * row["correction_out_max_j"], 2)
                if row["correction_out_max_j"] is not None
                else "–",
                _fault(row),
                _plain(plain.get(row["name"])),
            )
        )
    return table(head, rows)


def _plain(row: dict[str, Any] | None) -> str:
    if row is None:
        return "–"
    moved = row["moved_cells"]
    if moved is None or abs(moved) > 0.2 * row["depth_cells"]:
        return "lost"
    return f"{number(moved, 2)} cells"


def _bars(numbers: dict[str, Any], table: Table) -> str:
    head = ("R changes by", "hand's damping, mN·m·s/rad", "largest ripple, µN·m", "moved, cells")
    groups: dict[tuple[float, float], list[dict[str, Any]]] = {}
    for row in numbers["holding"]["bars"]:
        groups.setdefault((row["part"], row["damping"]), []).append(row)
    rows = []
    for (part, damping), found in groups.items():
        ripples = [row["hold_ripple_rms"] for row in found]
        lost = any(ripple is None for ripple in ripples)
        rows.append(
            (
                f"{100 * part:+.0f} %".replace("-", "−"),
                number(1e3 * damping),
                "lost" if lost else number(1e6 * max(ripples), 3),
                "lost" if lost else number(max(abs(row["moved_cells"]) for row in found), 2),
            )
        )
    return table(head, rows)


def _feels(numbers: dict[str, Any], table: Table) -> str:
    wrongs = list(dict.fromkeys(row["wrong"] for row in numbers["holding"]["feels"]))
    head = ("moved at most, cells", "depth, cells", "target", *wrongs)
    groups: dict[str, dict[str, Any]] = {}
    for row in numbers["holding"]["feels"]:
        groups.setdefault(row["name"], {})[row["wrong"]] = row
    rows = []
    for name, found in groups.items():
        first = found[wrongs[0]]
        depth = first["depth_cells"]
        rows.append(
            (
                name,
                number(depth, 2),
                number(0.5 + first["part"] * depth, 2),
                *(
                    _cells(found[wrong]["moved_cells"])
                    + (" (fault)" if found[wrong]["anchor_fault_s"] is not None else "")
                    for wrong in wrongs
                ),
            )
        )
    return table(head, rows)


def _bounces(numbers: dict[str, Any], table: Table) -> str:
    head = ("motor", "wrong", "1 rad/s", "3 rad/s", "10 rad/s", "30 rad/s")
    rows = [
        (
            f"`{row['preset']}`",
            row["wrong"],
            *(
                ("–" if back is None else number(back, 3)) + (" (fault)" if fault else "")
                for back, fault in zip(row["restitution"], row["fault"], strict=True)
            ),
        )
        for row in numbers["holding"]["bounces"]
    ]
    return table(head, rows)


def _free(numbers: dict[str, Any], table: Table) -> str:
    head = ("free space", "torque RMS, µN·m", "speed at the end, rad/s", "fastest, rad/s",
            "current at the end, mA")  # fmt: skip
    rows = []
    for row in numbers["holding"]["free"]:
        held = row["name"].startswith("hand")
        rows.append(
            (
                row["name"],
                number(1e6 * row["free_space_torque_rms"], 3),
                "–" if held else number(row["omega"], 2),
                "–" if held else number(row["omega_most"], 2),
                "–" if held else number(1e3 * row["current_a"], 2),
            )
        )
    return table(head, rows)


def _overloads(numbers: dict[str, Any], table: Table) -> str:
    head = ("limit", "wall", "wrong", "moved 50 ms after and later, cells", "fault")
    rows = [
        (row["limit"], row["firmness"], row["wrong"], _cells(row["moved_cells"]), _fault(row))
        for row in numbers["holding"]["overloads"]
    ]
    return table(head, rows)


def _lost(numbers: dict[str, Any], table: Table) -> str:
    head = ("encoder", "case", "runs", "noticed", "after, cells", "largest torque after, mN·m",
            "with a sound encoder, mN·m")  # fmt: skip
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in numbers["holding"]["lost"]:
        case, kind = row["case"], row.get("kind", "skips")
        name = {"held": "held at rest", "tap": "in a tap", "skips": "taps"}.get(case)
        if case == "free":
            name = f"free space, {row['speed']:g} rad/s"
        if case == "skips":
            name = f"taps, {row['edges']} edges a turn"
        groups.setdefault((kind, name or case), []).append(row)
    rows = []
    for (kind, name), found in groups.items():
        noticed = [row["noticed_cells"] for row in found if row["noticed_cells"] is not None]
        worst = max(found, key=lambda row: row["lost_after"])
        rows.append(
            (
                kind,
                name,
                len(found),
                len(noticed),
                f"{min(noticed):.0f} to {max(noticed):.0f}" if noticed else "–",
                number(1e3 * worst["lost_after"], 2),
                number(1e3 * worst["sound_after"], 2),
            )
        )
    return table(head, rows)


_NAMES = {
    "hold_cells": "hold: moved, cells",
    "hold_over": "hold: beyond half a cell and 1 %, cells",
    "ripple_part": "hold: ripple over force",
    "swing_cells": "swing: moved at most, cells",
    "swing_over": "swing: beyond half a cell and 1 %, cells",
    "soft_cells": "soft wall: moved at most, cells",
    "soft_over": "soft wall: beyond half a cell and 2 %, cells",
    "bounce_1": "bounce at 1 rad/s",
    "bounce_3": "bounce at 3 rad/s",
    "bounce_10": "bounce at 10 rad/s",
    "bounce_30": "bounce at 30 rad/s",
}


def _random(numbers: dict[str, Any], table: Table) -> str:
    motors = numbers["holding"]["motors"]
    head = ("", "runs", "median", "90 %", "worst", "its seed", "missed", "lost", "faults")
    rows = []
    for key, name in _NAMES.items():
        spread = motors["spreads"][key]
        if spread is None:
            continue
        part = key.removesuffix("_cells").removesuffix("_over")
        shown = percent if key == "ripple_part" else (lambda value: number(value, 3))
        missed = motors["over"] | motors["thrown"]
        of_part = part in motors["faults"] and not key.endswith("_over")
        rows.append(
            (
                name,
                spread["n"],
                *(shown(spread[which]) for which in ("median", "p90", "worst")),
                spread["seed"],
                len(missed[part]) if of_part else "",
                len(motors["lost"].get(part, ())) if of_part else "",
                len(motors["faults"][part]) if of_part else "",
            )
        )
    return table(head, rows)


def _once_measured(render: Callable[..., str]) -> Callable[..., str]:
    """``render``, which makes nothing before the first study."""

    def rendered(numbers: dict[str, Any], table: Table) -> str:
        return render(numbers, table) if "holding" in numbers else ""

    return rendered


TABLES = {
    "holds": _once_measured(_holds),
    "bars": _once_measured(_bars),
    "feels": _once_measured(_feels),
    "bounces": _once_measured(_bounces),
    "free": _once_measured(_free),
    "overloads": _once_measured(_overloads),
    "lost": _once_measured(_lost),
    "motors": _once_measured(_random),
}
"""Tables of Markdown by marker, made with the given function of head and rows."""
