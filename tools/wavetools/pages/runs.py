# SPDX-License-Identifier: Apache-2.0
"""Tables of the runs of :mod:`wavetools.studies.tabled_runs`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from wavehaptics.laws import closed_forms
from wavehaptics.scene import find_scene, first_comment, load_scene
from wavehaptics.studies.report.blocks import number, percent
from wavehaptics.trace import pictures

from wavetools.studies import encoders, sensing, surfaces


def of_sensing(found: dict[str, Any]) -> dict[str, Any]:
    """What is kept of ``sensing.json``: all of it."""
    return found


def of_encoders(found: dict[str, Any]) -> dict[str, Any]:
    """What is kept of ``encoders.json``: all of it."""
    return found


def of_tables(found: dict[str, Any]) -> dict[str, Any]:
    """What is kept of ``tables.json``: all of it."""
    return found


# ---- The tables.

Table = Callable[[Iterable[str], Iterable[Iterable[object]]], str]
_NO_WALL = 0.1
"""A stiffness below this part of the predicted one is no wall."""


def _rows(numbers: dict[str, Any], table: str) -> list[dict[str, Any]]:
    return [row for row in numbers.get("tables", {}).get("runs", ()) if row["table"] == table]


def _stiffness(row: dict[str, Any]) -> str:
    if row["stiffness"] is None:
        return "–"
    return f"{row['stiffness'] / row['stiffness_predicted']:.3f}"


def _error(row: dict[str, Any]) -> str:
    part = (row["stiffness"] or 0.0) / row["stiffness_predicted"]
    return "no wall" if part < _NO_WALL else number(row["torque_nrmse_vs_analog"], 2)


def _held(error: float | None) -> str:
    return "no wall" if error is None or abs(error) > 1.0 - _NO_WALL else percent(error)


def _dead_time(numbers: dict[str, Any], table: Table) -> str:
    held = {row["row"]: _held(row["hold_error"]) for row in _rows(numbers, "dead-time-held")}
    head = ("", "torque error against `analog`", "stiffness over predicted",
            "torque in free space, RMS, µN·m", "held torque off")  # fmt: skip
    rows = [
        (row["row"], _error(row), _stiffness(row),
         number(1e6 * row["free_space_torque_rms"], 2), held.get(row["row"], "–"))
        for row in _rows(numbers, "dead-time")
    ]  # fmt: skip
    return table(head, rows)


def _sensing(numbers: dict[str, Any], table: Table) -> str:
    return table(*sensing.lines(numbers["sensing"])) if "sensing" in numbers else ""


def _encoder_parts(numbers: dict[str, Any], table: Table) -> str:
    del numbers
    return table(encoders.PART_HEAD, map(encoders.part_cells, encoders.ABSOLUTE_PARTS))


def _encoders(numbers: dict[str, Any], table: Table) -> str:
    return table(*encoders.lines(numbers["encoders"])) if "encoders" in numbers else ""


_SWITCHING = {
    "unipolar": "both, in turn",
    "locked-anti-phase": "both, opposite",
    "sign-magnitude": "one",
    "half-bridge": "the only one",
}


def _modes(numbers: dict[str, Any], table: Table) -> str:
    head = ("", "legs that switch", "torque error against `analog`",
            "torque in free space, RMS, µN·m")  # fmt: skip
    return table(
        head,
        (
            (f"`{row['row']}`", _SWITCHING[row["row"]], _error(row),
             number(1e6 * row["free_space_torque_rms"], 2))
            for row in _rows(numbers, "modes")
        ),
    )  # fmt: skip


def _bus(numbers: dict[str, Any], table: Table) -> str:
    head = ("bus", "torque error against `analog`", "stiffness over predicted",
            "peak torque, mN·m", "energy out, J")  # fmt: skip
    return table(
        head,
        (
            (row["row"], _error(row), _stiffness(row), number(1e3 * row["peak_torque"], 3),
             number(row["energy_out_max_j"], 1))
            for row in _rows(numbers, "bus")
        ),
    )  # fmt: skip


def _carriers(numbers: dict[str, Any], table: Table) -> str:
    head = ("carrier, kHz", "tick, µs", "torque error against `analog`",
            "stiffness over predicted", "ripple of the current, mA")  # fmt: skip
    return table(
        head,
        (
            (row["row"], number(1e6 * row["tick_s"], 3), _error(row), _stiffness(row),
             number(1e3 * row["current_ripple_a"], 2))
            for row in _rows(numbers, "carriers")
        ),
    )  # fmt: skip


def _prototype(numbers: dict[str, Any], table: Table) -> str:
    """The stiffness of the paper's wall: its parts, the whole, and what R̂ makes of it."""
    scene = load_scene(find_scene("paper_taps"))
    motor, lambda_ = scene.motor, scene.controller.lambda_
    k_l = closed_forms.k_l(motor.k_t, motor.L_h)
    twice = closed_forms.filter_stiffness(motor.k_t, motor.R_ohm, lambda_)
    rows = [
        ("K_L, the inductor's", k_l),
        ("the filter's as (14) prints it", twice / 2),
        ("the filter's with the factor 2", twice),
        ("both in series, as printed", 1 / (1 / k_l + 2 / twice)),
        ("both in series, with the factor 2", 1 / (1 / k_l + 1 / twice)),
    ]
    rows += [
        (f"taps on `analog`, R̂ {percent(row['part'], 1)} off" if row["part"] else
         "taps on `analog`, R̂ = R", row["stiffness"])
        for row in numbers.get("tables", {}).get("r_hat", ())
    ]  # fmt: skip
    rows.append(("what the prototype measured", pictures.PAPER_MEASURED))
    head = ("stiffness", "N·m/rad", "over K_L")
    return table(head, ((what, number(k, 3), number(k / k_l, 2)) for what, k in rows))


def _impedance(numbers: dict[str, Any], table: Table) -> str:
    head = ("scene", "what it is", "largest error")
    return table(
        head,
        (
            (f"`{row['scene']}`", first_comment(find_scene(row["scene"])),
             percent(row["error_max"]))
            for row in numbers.get("tables", {}).get("impedance", ())
        ),
    )  # fmt: skip


def _brushless(numbers: dict[str, Any], table: Table) -> str:
    head = ("electrical angle at the wall, degrees", "K on `pins`, N·m/rad", "on `golden`",
            "on `analog`", "1.5 (pψ)²/(L + Rτ/2)", "torque error of `pins` against `analog`",
            "of `golden`")  # fmt: skip
    return table(
        head,
        (
            (f"{360 * row['turn']:g}", number(row["pins"], 4), number(row["golden"], 4),
             number(row["analog"], 4), number(row["predicted"], 4), percent(row["pins_error"]),
             percent(row["error"]))
            for row in numbers.get("tables", {}).get("brushless", ())
        ),
    )  # fmt: skip


def _brushless_held(numbers: dict[str, Any], table: Table) -> str:
    head = ("electrical angle at the wall, degrees", "off on `golden`, cells", "ripple, µN·m",
            "off on `pins`, cells", "ripple, µN·m")  # fmt: skip
    return table(
        head,
        (
            (f"{360 * row['turn']:g}", number(row["golden_cells"], 2),
             number(1e6 * row["golden_ripple"], 2), number(row["pins_cells"], 2),
             number(1e6 * row["pins_ripple"], 2))
            for row in numbers.get("tables", {}).get("brushless_held", ())
        ),
    )  # fmt: skip


def _surfaces(numbers: dict[str, Any], table: Table) -> str:
    head = ("", "mean error, counts", "largest, counts", "drag", "contact")
    return table(
        head,
        (
            (row["what"], number(row["mean"], 2), number(row["largest"], 2),
             percent(row["drag"], 2), percent(row["contact"], 3))
            for row in numbers.get("tables", {}).get("surfaces", ())
        ),
    )  # fmt: skip


def _largest(stiffness: float) -> str:
    """A largest stable stiffness, N/m; more where the search for it ended."""
    ends = stiffness > 0.95 * surfaces.STIFF
    return f"> {number(surfaces.STIFF, 2)}" if ends else number(stiffness, 2)


def _surfaces_beside(numbers: dict[str, Any], table: Table) -> str:
    head = ("damping of the hand, N·s/m", "servo at 1 kHz, largest stable K, N/m", "wave, K, N/m",
            "its swing, counts")  # fmt: skip
    return table(
        head,
        (
            (f"{row['damping']:g}", _largest(row["encoder"]), number(row["wave"], 3),
             number(row["wave_swing"], 2))
            for row in numbers.get("tables", {}).get("surfaces_beside", ())
        ),
    )  # fmt: skip


def _surfaces_map(numbers: dict[str, Any], table: Table) -> str:
    found = numbers.get("tables", {}).get("surfaces_map", ())
    turns = sorted({row["turn"] for row in found})
    head = ("lift, reach", *(f"turn {turn:g}: {what}" for turn in turns
                             for what in ("formula", "measured")))  # fmt: skip
    places = dict.fromkeys((row["lift"], row["reach"]) for row in found)
    of = {(row["turn"], row["lift"], row["reach"]): row for row in found}
    return table(
        head,
        (
            (f"{lift:g}, {reach:g}",
             *(f"{of[turn, lift, reach][what]:.0f}" for turn in turns
               for what in ("formula", "measured")))
            for lift, reach in places
        ),
    )  # fmt: skip


TABLES = {
    "brushless-angles": _brushless,
    "brushless-held": _brushless_held,
    "dead-time": _dead_time,
    "sensing": _sensing,
    "encoders": _encoders,
    "encoder-parts": _encoder_parts,
    "modes": _modes,
    "bus": _bus,
    "carriers": _carriers,
    "impedances": _impedance,
    "prototype": _prototype,
    "surfaces": _surfaces,
    "surfaces-beside": _surfaces_beside,
    "surfaces-map": _surfaces_map,
}
"""Tables of Markdown by marker, made with the given function of head and rows."""
