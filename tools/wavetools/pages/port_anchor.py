# SPDX-License-Identifier: Apache-2.0
"""What the pages keep and show of the study: a few numbers and tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from wavehaptics.studies.report.blocks import number, percent

from wavetools.studies.anchored.cases import HIT_SPEEDS
from wavetools.studies.anchored.motors import SPEEDS
from wavetools.studies.anchored.pictures import (
    ENERGY_TARGETS,
    KINDS,
    SWING_TARGET,
    error_of_press,
    kind_of,
)

BOUNCES = tuple(f"bounce_{speed:g}" for speed in SPEEDS)
WALLS = ("hold", "press", "soft")
"""What a random motor does with a wall."""
ALLOWED = {"hold": 0.01, "soft": 0.02}
"""Part of the depth that a wall may move besides a count."""
RIPPLE_TARGET = 0.01
"""Of a hold's force."""


def of_holding(found: dict[str, Any]) -> dict[str, Any]:
    """The numbers that the pages quote, of ``holding.json``."""
    kept = {name: found[name] for name in ("free", "throws", "hits", "lost")}
    for name in ("holds", "plain", "bars", "feels", "overloads", "presses", "loads", "rates"):
        kept[name] = [_wanted(row) for row in found[name]]
    kept["heat"] = [
        _wanted(row) | {"hold": _wanted(row["hold"]), "press": _wanted(row["press"])}
        for row in found["heat"]
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
    kept["in_hands"] = _motors(found["motors"])
    return kept


_WANTED = {
    *("duration_s", "cell_rad", "moved_cells", "depth_cells", "rms_cells", "hold_ripple_rms"),
    *("force", "correction_out_max_j", "correction_bound_j", "anchor_fault_s", "part", "place"),
    *("damping", "limited_s", "most_cells", "judged_s", "saturated_fraction", "frequency"),
    *("first", "later", "contact_energy_ratio", "load", "celsius", "swing_hz", "swing_rad"),
    "rate_hz",
}


def _wanted(row: dict[str, Any]) -> dict[str, Any]:
    return {key: row[key] for key in row if key in _WANTED or isinstance(row[key], str)}


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

    for part in WALLS:
        gather(f"{part}_cells", part, lambda row: _absolute(row.get("moved_cells")))
    gather("hold_ripple", "hold", _ripple)
    gather("press_error", "press", error_of_press)
    for which in ("first", "later"):
        gather(f"press_{which}", "press", _of(which))
    for part in BOUNCES:
        gather(part, part, lambda row: row.get("restitution"))
    parts = (*WALLS, *BOUNCES)

    def missed(
        part: str, value: Callable[[dict[str, Any]], float | None], most: float
    ) -> list[int]:
        over = [(value(row[part]), row["seed"]) for row in rows]
        return [seed for at, seed in over if at is not None and at > most]

    return {
        "seeds": [rows[0]["seed"], rows[-1]["seed"]],
        "spreads": spreads,
        "faults": {
            part: [row["seed"] for row in rows if row[part].get("anchor_fault_s") is not None]
            for part in parts
        },
        "lost": {part: [row["seed"] for row in rows if _is_lost(row[part])] for part in WALLS},
        "missed": {
            f"{part}_cells": missed(part, partial(_over, part=ALLOWED[part]), 0.0)
            for part in ALLOWED
        }
        | {
            "hold_ripple": missed("hold", _ripple, RIPPLE_TARGET),
            "press_error": missed("press", error_of_press, SWING_TARGET),
        }
        | {
            f"press_{which}": missed("press", _of(which), ENERGY_TARGETS["all"])
            for which in ("first", "later")
        }
        | {part: missed(part, lambda row: row.get("restitution"), 1.0) for part in BOUNCES},
        "refused": [row["seed"] for row in rows if any("refused" in row[p] for p in parts)],
    }


def _refused(row: dict[str, Any]) -> bool:
    return "refused" in row or "lost" in row


def _is_lost(row: dict[str, Any]) -> bool:
    return "lost" in row or ("refused" not in row and row.get("moved_cells") is None)


def _of(key: str) -> Callable[[dict[str, Any]], float | None]:
    """What takes ``key`` of a row, or None where there is none."""
    return lambda row: row.get(key)


def _absolute(value: float | None) -> float | None:
    return None if value is None else abs(value)


def _over(row: dict[str, Any], part: float) -> float | None:
    """What a wall has moved beyond a count and its part of the depth, counts."""
    if row.get("moved_cells") is None:
        return None
    return abs(row["moved_cells"]) - 1.0 - part * row["depth_cells"]


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
    head = ("wrong", "controller", "s", "moved, counts", "of the depth", "ripple, µN·m",
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
    return f"{number(moved, 2)} counts"


def _bars(numbers: dict[str, Any], table: Table) -> str:
    head = ("R changes by", "hand's damping, mN·m·s/rad", "largest ripple, µN·m", "moved, counts")
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
    head = ("moved at most, counts", "depth, counts", "target", *wrongs)
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
                number(1.0 + first["part"] * depth, 2),
                *(
                    _cells(found[wrong]["moved_cells"])
                    + (" (fault)" if found[wrong]["anchor_fault_s"] is not None else "")
                    for wrong in wrongs
                ),
            )
        )
    return table(head, rows)


def _back(row: dict[str, Any]) -> Iterator[str]:
    """Restitution at each speed."""
    for back, fault in zip(row["restitution"], row["fault"], strict=True):
        yield ("–" if back is None else number(back, 3)) + (" (fault)" if fault else "")


def _bounces(numbers: dict[str, Any], table: Table) -> str:
    head = ("motor", "wrong", *(f"{speed:g} rad/s" for speed in SPEEDS))
    rows = [
        (f"`{row['preset']}`", row["wrong"], *_back(row)) for row in numbers["holding"]["bounces"]
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
    head = ("limit", "wall", "wrong", "moved 50 ms after and later, counts", "fault")
    rows = [
        (row["limit"], row["firmness"], row["wrong"], _cells(row["moved_cells"]), _fault(row))
        for row in numbers["holding"]["overloads"]
    ]
    return table(head, rows)


def _lost(numbers: dict[str, Any], table: Table) -> str:
    head = ("encoder", "case", "runs", "noticed", "after, counts", "largest torque after, mN·m",
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


def _presses(numbers: dict[str, Any], table: Table) -> str:
    rows_of = numbers["holding"]["presses"]
    frequencies = sorted({row["frequency"] for row in rows_of})
    head = ("wall", "wrong", *(f"{frequency:g} Hz" for frequency in frequencies))
    groups: dict[tuple[str, str], dict[float, dict[str, Any]]] = {}
    for row in rows_of:
        groups.setdefault((row["wall"], row["wrong"]), {})[row["frequency"]] = row
    order = sorted(groups, key=lambda key: (key[0], KINDS.index(kind_of(key[1]))))
    return table(
        head,
        [(*key, *(_first_and_later(groups[key].get(at)) for at in frequencies)) for key in order],
    )


def _first_and_later(row: dict[str, Any] | None) -> str:
    if row is None or row["first"] is None:
        return "–"
    later = "–" if row["later"] is None else number(row["later"], 2)
    return f"{number(row['first'], 2)} / {later}" + (" (fault)" if _has_fault(row) else "")


def _has_fault(row: dict[str, Any]) -> bool:
    return row.get("anchor_fault_s") is not None


def _of_kind(rows: list[dict[str, Any]], everything: bool) -> list[dict[str, Any]]:
    return [row for row in rows if row["wrong"].startswith("everything") == everything]


def _worst(values: list[float | None], show: Callable[[float], str]) -> str:
    if any(value is None for value in values):
        return "bounces"
    return show(max(abs(value) for value in values if value is not None))


def _held(rows: list[dict[str, Any]], everything: bool) -> tuple[str, str]:
    """Ripple over force and how far the wall moved, the worst of the rows without or with all."""
    some = _of_kind(rows, everything)
    faults = sum(map(_has_fault, some))
    told = f" ({faults} of {len(some)} faults)" if faults else ""
    ripples = [_ripple(row) for row in some]
    return (
        _worst(ripples, percent) + told,
        _worst([row["moved_cells"] for row in some], lambda value: number(value, 2)),
    )


def _loads(numbers: dict[str, Any], table: Table) -> str:
    head = ("inertia, J", "hand's damping, mN·m·s/rad", "ripple of the force, no error",
            "moved, counts", "all errors", "moved, counts")  # fmt: skip
    groups: dict[tuple[float, float], list[dict[str, Any]]] = {}
    for row in numbers["holding"]["loads"]:
        groups.setdefault((row["load"], row["damping"]), []).append(row)
    return table(
        head,
        [
            (number(load), number(1e3 * damping), *_held(rows, False), *_held(rows, True))
            for (load, damping), rows in groups.items()
        ],
    )


def _rates(numbers: dict[str, Any], table: Table) -> str:
    head = ("rate, kHz", "inertia, J", "swing, counts, no error", "all errors",
            "energy given over held, no error", "all errors")  # fmt: skip
    groups: dict[tuple[float, float], list[dict[str, Any]]] = {}
    for row in numbers["holding"]["rates"]:
        groups.setdefault((row["rate_hz"], row["load"]), []).append(row)

    def worst(rows: list[dict[str, Any]], of: Callable[[dict[str, Any]], float]) -> str:
        return number(max(map(of, rows)))

    rows = []
    for (rate_hz, load), found in groups.items():
        kinds = [_of_kind(found, everything) for everything in (False, True)]
        swings = [worst(kind, lambda row: row["swing_rad"] / row["cell_rad"]) for kind in kinds]
        energies = [worst(kind, lambda row: row["contact_energy_ratio"]) for kind in kinds]
        rows.append((f"{rate_hz / 1e3:g}", number(load), *swings, *energies))
    return table(head, rows)


def _throws(numbers: dict[str, Any], table: Table) -> str:
    head = ("inertia, J", "wrong", *(f"{speed:g} rad/s" for speed in SPEEDS))
    rows = [
        (number(row["load"]), row["wrong"], *_back(row)) for row in numbers["holding"]["throws"]
    ]
    return table(head, rows)


def _hits(numbers: dict[str, Any], table: Table) -> str:
    head = ("limit", "inertia, J", "wrong", *(f"{speed:g} rad/s" for speed in HIT_SPEEDS))
    groups: dict[tuple[str, float, bool], list[dict[str, Any]]] = {}
    for row in numbers["holding"]["hits"]:
        groups.setdefault((row["limit"], row["load"], row["wrong"] != "nothing"), []).append(row)

    def cell(backs: tuple[float | None, ...], faults: tuple[bool, ...]) -> str:
        came = [back for back in backs if back is not None]
        ends = dict.fromkeys(number(back, 3) for back in (min(came), max(came))) if came else "–"
        count = sum(faults)
        return "…".join(ends) + (f" ({count} fault{'s' * (count > 1)})" if count else "")

    rows = []
    for (limit, load, wrong), found in groups.items():
        backs = zip(*(row["restitution"] for row in found), strict=True)
        faults = zip(*(row["fault"] for row in found), strict=True)
        cells = map(cell, backs, faults)
        rows.append((limit, number(load), "all errors" if wrong else "nothing", *cells))
    return table(head, rows)


def _heat(numbers: dict[str, Any], table: Table) -> str:
    head = ("°C", "ripple of the force, no error", "moved, counts", "all errors", "moved, counts",
            "energy of presses, no error", "all errors")  # fmt: skip
    groups: dict[float, list[dict[str, Any]]] = {}
    for row in numbers["holding"]["heat"]:
        groups.setdefault(row["celsius"], []).append(row)

    def energy(rows: list[dict[str, Any]], everything: bool) -> str:
        presses = [row["press"] for row in _of_kind(rows, everything)]
        return _first_and_later(
            {
                which: max((row[which] for row in presses if row[which] is not None), default=None)
                for which in ("first", "later")
            }
        )

    def held(rows: list[dict[str, Any]], everything: bool) -> tuple[str, str]:
        return _held([row["hold"] | {"wrong": row["wrong"]} for row in rows], everything)

    return table(
        head,
        [
            (number(celsius), *held(rows, False), *held(rows, True), energy(rows, False),
             energy(rows, True))
            for celsius, rows in groups.items()
        ],
    )  # fmt: skip


_NAMES = {
    "hold_cells": "hold: moved, counts; at most 1 and 1 % of the depth",
    "hold_ripple": "hold: ripple over force; at most 1 %",
    "press_error": "press: largest error over force; at most 4 %",
    "press_first": "press: energy given over held, the first; at most 0.1",
    "press_later": "press: the same, later ones; at most 0.1",
    "soft_cells": "soft wall: moved, counts; at most 1 and 2 % of the depth",
} | {
    f"bounce_{speed:g}": f"bounce at {speed:g} rad/s: restitution; at most 1" for speed in SPEEDS
}  # fmt: skip


def _random(numbers: dict[str, Any], table: Table) -> str:
    motors = numbers["holding"]["in_hands"]
    head = ("", "runs", "median", "90 %", "worst", "its seed", "missed", "not held", "faults")
    rows = []
    for key, name in _NAMES.items():
        spread = motors["spreads"][key]
        if spread is None:
            continue
        part = key if key in BOUNCES else key.partition("_")[0]
        shown = percent if key in ("hold_ripple", "press_error") else partial(number, digits=3)
        rows.append(
            (
                name,
                spread["n"],
                *(shown(spread[which]) for which in ("median", "p90", "worst")),
                spread["seed"],
                len(motors["missed"][key]),
                len(motors["lost"].get(part, ())),
                len(motors["faults"][part]),
            )
        )
    return table(head, rows)


def _once_measured(group: str, render: Callable[..., str]) -> Callable[..., str]:
    """``render``, which makes nothing before the first study that measures ``group``."""

    def rendered(numbers: dict[str, Any], table: Table) -> str:
        return render(numbers, table) if group in numbers.get("holding", {}) else ""

    return rendered


TABLES = {
    "holds": _once_measured("holds", _holds),
    "bars": _once_measured("bars", _bars),
    "feels": _once_measured("feels", _feels),
    "bounces": _once_measured("bounces", _bounces),
    "free": _once_measured("free", _free),
    "overloads": _once_measured("overloads", _overloads),
    "hits": _once_measured("hits", _hits),
    "lost": _once_measured("lost", _lost),
    "presses": _once_measured("presses", _presses),
    "loads": _once_measured("loads", _loads),
    "throws": _once_measured("throws", _throws),
    "slow_rates": _once_measured("rates", _rates),
    "heat": _once_measured("heat", _heat),
    "motors": _once_measured("in_hands", _random),
}
"""Tables of Markdown by marker, made with the given function of head and rows."""
