# SPDX-License-Identifier: Apache-2.0
"""Tables of the pages that are made from the table of parts, the headers and the simulation.

A table stands between ``<!-- begin NAME -->`` and ``<!-- end NAME -->``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from wavehaptics.fpga.boards import board_names, load_board
from wavehaptics.runtime.files import write_text
from wavehaptics.runtime.repository import ROOT
from wavehaptics.words.table import LEGS

from wavetools import markers
from wavetools.fpga import bridge_budget
from wavetools.wiring import pins, spice
from wavetools.wiring.parts import Part, Table, WiringError, load_table

WIRING = Path("docs", "wiring", "README.md")
"""The page of the circuits, from the root."""

BUS_V = 12.0
INDUCTANCE_H = 0.24e-3
RESISTANCE_OHM = 2.18
"""Of the scenes' motor, an RE 25, at the boards' bus."""


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |\n"


def count(part: Part, motors: int, sclk_pins: int = 1) -> int:
    """How many a board has; ``sclk_pins`` are its pins of CS and SCLK each."""
    return part.number * {"board": 1, "motor": motors, "sclk_pin": sclk_pins}[part.each]


def sizes() -> list[tuple[int, int]]:
    """Motors and ``sclk_pins`` of the boards for motors with brushes, each pair once."""
    boards = (load_board(name).fpga for name in board_names())
    return sorted({(fpga.motors, fpga.sclk_pins) for fpga in boards if fpga.legs == LEGS})


def bill(table: Table, *, options: bool) -> str:
    """The parts for the boards of each size; of a power board's table, for one motor."""
    counted = sizes() if table.name is None else [(1, 1)]
    columns = [f"{motors} motor{'s' if motors > 1 else ''}" for motors, _ in counted]
    head = ["", "part", "role", *columns, "has to keep", "instead"]
    lines = [_row([*head, "option"] if options else head)]
    lines += [f"|---|---|---|{'--:|' * len(columns)}---|---|" + ("---|" if options else "") + "\n"]
    for reference, part in table.parts.items():
        if (part.option is not None) != options:
            continue
        tolerance = f", {part.tolerance * 100:g} %" if part.tolerance else ""
        counts = [str(count(part, *size)) for size in counted]
        cells = [reference, part.text() + tolerance, part.role, *counts, part.rating,
                 part.substitute]  # fmt: skip
        lines.append(_row([*cells, part.option] if part.option else cells))
    return "".join(lines)


def current_a(time_s: float, limit_a: float = BUS_V / RESISTANCE_OHM) -> float:
    """What the bus drives through the motor that stands, when it is left on for a time."""
    return min(limit_a, BUS_V * time_s / INDUCTANCE_H)


def pump(table: Table) -> str:
    """What the simulation makes of the charge pump: nominal, and the worst of all corners."""
    ticks_s = sorted(set(spice.board_ticks(table).values()))
    nominal = spice.stops(table, ticks_s, [spice.nominal(table)])
    everywhere = spice.stops(table, ticks_s, spice.corners(table))
    head = ["tick", "stops", "`pass` before, nominal", "in all corners", "shut after, nominal",
            "at worst"]  # fmt: skip
    # The current is that of the motor which all boards of our own bridge have.
    head += ["12 V on 0.24 mH make by then"] * (table.name is None)
    lines = [_row(head), "|--:|---" + "|--:" * (len(head) - 2) + "|\n"]
    for stop in nominal:
        same = [s for s in everywhere if (s.tick_s, s.level) == (stop.tick_s, stop.level)]
        times_s = [s.shut_s for s in same]
        if stop.shut_s is None or None in times_s:
            raise WiringError("the charge pump never shuts the gates")
        worst_s = max(time_s for time_s in times_s if time_s is not None)
        lines.append(
            _row(
                [
                    f"{stop.tick_s * 1e6:.4g} µs",
                    stop.level,
                    f"{stop.least_v:.2f} to {stop.most_v:.2f} V",
                    f"{min(s.least_v for s in same):.2f} to {max(s.most_v for s in same):.2f} V",
                    f"{stop.shut_s * 1e6:.0f} µs",
                    f"{worst_s * 1e6:.0f} µs",
                    f"{current_a(worst_s):.1f} A",
                ][: len(head)]
            )
        )
    return "".join(lines)


def currents(table: Table) -> str:
    """What the ADC sees, from shunt and gain."""
    half_v = table.supply.logic_v / 2
    per_a = table.part("R6").of("ice40") * table.current.gain
    ends, middle = table.part("R14").of("ice40"), table.part("R15").of("ice40")
    trips_a = (half_v - table.supply.logic_v * ends / (2 * ends + middle)) / per_a
    stall_a = BUS_V / RESISTANCE_OHM
    rows = [
        ("shunt R6 × gain of U7", f"{table.text('R6')} × {table.current.gain:g} = {per_a:.2f} V/A"),
        ("0 A", f"{half_v:.2f} V, mid-scale"),
        ("end of the ADC's scale, `full_scale_a`", f"± {half_v / per_a:.2f} A"),
        ("end of what U7 gives truly", f"± {(half_v - table.current.swing_v) / per_a:.2f} A"),
        ("a sample takes the gates off, `[sense] trip_a`", _trips(table)),
        ("option overcurrent, by R14 and R15", f"± {trips_a:.2f} A"),
        ("stall of the RE 25 at 12 V", f"{stall_a:.1f} A, off the scale"),
        ("heat in R6 at stall", f"{stall_a**2 * table.part('R6').of('ice40'):.1f} W"),
    ]
    return _row(["what", "value"]) + "|---|--:|\n" + "".join(_row(list(row)) for row in rows)


def _trips(table: Table) -> str:
    """The current at which the boards' own trip takes the gates off."""
    found = sorted({board.fpga.sense.trip_a for board in spice.wired_so(table)})
    return "± " + ", ".join(f"{trip_a:.2f}" for trip_a in found) + " A"


def runs(board: str) -> str:
    """How a board runs, by its scene."""
    loaded = load_board(board)
    scene = loaded.scene
    drive = scene.drive
    assert drive is not None
    assert drive.pwm_hz is not None
    motors = f" for each of {loaded.fpga.motors} motors" if loaded.fpga.motors > 1 else ""
    return (
        f"{loaded.clock_hz / 1e6:g} MHz by its PLL, "
        f"a tick of {1e6 / scene.controller.tick_hz:.4g} µs{motors}, "
        f"a carrier of {drive.pwm_hz / 1e3:.4g} kHz, "
        f"a dead time of {bridge_budget.dead_time(loaded).made_s * 1e9:.1f} ns.\n"
    )


def full_scale_a(table: Table) -> float:
    """Current at the end of the ADC's scale."""
    return table.supply.logic_v / 2 / (table.part("R6").of("ice40") * table.current.gain)


def makers(table: Table) -> dict[Path, dict[str, Callable[[], str]]]:
    """What fills each marker of each page."""
    found: dict[Path, dict[str, Callable[[], str]]] = {
        WIRING: {
            "parts": partial(bill, table, options=False),
            "options": partial(bill, table, options=True),
            "pump": partial(pump, table),
            "currents": partial(currents, table),
        }
    }
    for board in board_names():
        made = found[Path("boards", board, "README.md")] = {
            "runs": partial(runs, board),
            "pins": partial(pins.table, board),
        }
        wiring = load_board(board).fpga.wiring
        if wiring is not None:
            own = load_table(name=wiring)
            made |= {"parts": partial(bill, own, options=False), "pump": partial(pump, own)}
    return found


def filled(text: str, page: Path, made: dict[str, Callable[[], str]]) -> str:
    """The page with its tables made anew; :class:`WiringError` for one that lacks a marker."""
    for name in sorted(set(made) - set(markers.tables_of(text))):
        raise WiringError(f"{page}: there is no <!-- begin {name} --> with its end; add both")
    return markers.filled(text, made, str(page))


def write(table: Table, root: Path = ROOT) -> list[Path]:
    """Fill the markers of every page."""
    written = []
    for page, made in makers(table).items():
        old = (root / page).read_text(encoding="utf-8")
        new = filled(old, page, made)
        if new != old:
            write_text(root / page, new)
        written.append(page)
    return written
