# SPDX-License-Identifier: Apache-2.0
"""The circuits on which safety rests, simulated by ngspice with the table's values.

Three things are asked: how fast the charge pump shuts the gates once ``alive`` stands still
(:func:`stops`), what the gates do while the FPGA is configured anew (:func:`configured_anew`), and
what they do while the 3.3 V fall (:func:`brown_out`). :func:`complaints` says in a line each what
of it is not good enough.
"""

from __future__ import annotations

import itertools
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from wavehaptics.fpga.boards import Board, board_names, load_board

from wavetools.wiring.parts import FAMILIES, FAMILY_NAMES, Family, Table, WiringError

Level = Literal["high", "low"]
Diode = Literal["typical", "most"]
LEVELS: tuple[Level, ...] = ("high", "low")
DIODES: tuple[Diode, ...] = ("typical", "most")

_EDGE_S = 10e-9
_MEASURED = re.compile(r"^(\w+)\s*=\s*([-+.\de]+)", re.MULTILINE)

_SETTLED_S = 1e-6
"""After the FPGA lets go of its pins: a pull-down of 10 kΩ has emptied a wire."""


@cache
def run(netlist: str) -> Mapping[str, float | None]:
    """What the ``.meas`` lines of a netlist came to; ``None`` for one that found nothing.

    A netlist that was simulated once isn't simulated again.
    """
    program = shutil.which("ngspice")
    if program is None:
        raise WiringError("ngspice is not installed; type `make setup`")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "circuit.cir")
        path.write_text(netlist, encoding="utf-8")
        done = subprocess.run(
            [program, "-b", str(path)], capture_output=True, text=True, timeout=300, check=False
        )
    if done.returncode:
        said = " ".join(line.strip() for line in done.stderr.splitlines() if line.strip())
        raise WiringError(f"ngspice: {said[:200]}")
    found = {name: float(value) for name, value in _MEASURED.findall(done.stdout)}
    wanted = re.findall(r"^\.meas tran (\w+)", netlist, re.MULTILINE)
    return MappingProxyType({name: found.get(name) for name in wanted})


# ---- Pieces of netlists.


def _charged_s(table: Table) -> float:
    """Of ``alive`` before anything happens; C2 begins near where it will be."""
    return 1.25 * table.stop.longest_s


def _watched_s(table: Table) -> float:
    """After ``alive`` has stopped."""
    return 3.25 * table.stop.longest_s


@dataclass(frozen=True)
class Corner:
    """How far everything is off: the supply in V, the parts in their tolerances, the diodes."""

    supply_v: float
    temperature_c: float
    spread: float
    diode: Diode


def _models(table: Table, supply_v: float) -> list[str]:
    """The diodes, and the least eager Schmitt buffer that its data sheet allows, as a switch."""
    high = table.schmitt.at("rising_max_v", supply_v)
    low = table.schmitt.at("falling_min_v", supply_v)
    return [
        f".model typical D({table.diode.typical_model})",
        f".model most D({table.diode.most_model})",
        f".model schmitt SW(VT={(high + low) / 2} VH={(high - low) / 2} RON=10 ROFF=1G)",
        ".model closed SW(VT=0.5 VH=0 RON=1 ROFF=1G)",
    ]


def _pump(
    table: Table, name: str, source: str, out: str, corner: Corner, family: Family
) -> list[str]:
    """R3, R1, C1, D1, C2, R2 from ``source`` to ``out``."""

    def value(reference: str) -> float:
        part = table.part(reference)
        return part.of(family) * (1 + corner.spread * part.tolerance)

    return [
        f"R3{name} {source} 0 {table.part('R3').of(family)}",
        f"R1{name} {source} r{name} {table.part('R1').of(family)}",
        f"C1{name} r{name} n{name} {value('C1')}",
        f"D1{name} 0 n{name} {corner.diode}",
        f"D2{name} n{name} {out} {corner.diode}",
        f"C2{name} {out} 0 {value('C2')}",
        f"R2{name} {out} 0 {value('R2')}",
        f".ic v({out})={0.7 * table.supply.logic_v}",
    ]


def _square(tick_s: float, until_s: float, last: Level) -> tuple[str, float]:
    """Points of a wave of 0 and 1 that changes each tick, and the time of its last change."""
    changes = round(until_s / tick_s)
    changes += (changes % 2 == 0) == (last == "high")
    points = ["0 0"]
    for change in range(1, changes + 1):
        at, level = change * tick_s, change % 2
        points += [f"{at - _EDGE_S:.9g} {1 - level}", f"{at:.9g} {level}"]
    return " ".join(points), changes * tick_s


# ---- The pump when `alive` stands still.


@dataclass(frozen=True)
class Stop:
    """``alive`` changes at each tick and then stands still at ``level``.

    ``least_v`` and ``most_v`` are those of ``pass`` before, ``shut_s`` the time from the last
    change until ``pass`` is below what shuts every Schmitt buffer, ``None`` if it never is.
    """

    corner: Corner
    tick_s: float
    level: Level
    least_v: float
    most_v: float
    shut_s: float | None


def corners(table: Table) -> list[Corner]:
    supply = table.supply
    supplies = [supply.logic_v * (1 + sign * supply.tolerance) for sign in (-1, 1)]
    return [
        Corner(supply_v, temperature_c, spread, diode)
        for supply_v, temperature_c, spread, diode in itertools.product(
            supplies, supply.temperature_c, (-1.0, 1.0), DIODES
        )
    ]


def nominal(table: Table) -> Corner:
    return Corner(table.supply.logic_v, 25.0, 0.0, "typical")


def stops(
    table: Table, ticks_s: Iterable[float], cases: Sequence[Corner], family: Family = "ice40"
) -> list[Stop]:
    """``alive`` stops, high and low, at each tick and in each corner."""
    found = []
    grouped = sorted(cases, key=lambda corner: corner.temperature_c)
    for temperature_c, group in itertools.groupby(grouped, lambda corner: corner.temperature_c):
        runs = list(itertools.product(group, ticks_s, LEVELS))
        lines = ["* the charge pump of alive", f".temp {temperature_c}"]
        lines += _models(table, table.supply.logic_v)
        last_s = 0.0
        for index, (corner, tick_s, level) in enumerate(runs):
            points, stopped_s = _square(tick_s, _charged_s(table), level)
            last_s = max(last_s, stopped_s)
            shut_v = table.schmitt.at("falling_min_v", corner.supply_v)
            out = f"v(p{index})"
            before = f"from={stopped_s - 6 * tick_s} to={stopped_s}"
            lines += [
                f"V{index} v{index} 0 PWL({points})",
                f"E{index} e{index} 0 v{index} 0 {corner.supply_v}",
                f"RP{index} e{index} a{index} {table.pad.ohm}",
                *_pump(table, f"x{index}", f"a{index}", f"p{index}", corner, family),
                f".meas tran least{index} MIN {out} {before}",
                f".meas tran most{index} MAX {out} {before}",
                f".meas tran shut{index} WHEN {out}={shut_v} FALL=LAST",
            ]
        step_s = table.stop.longest_s / 400
        lines += [f".tran {step_s} {last_s + _watched_s(table)} 0 {5 * step_s}", ".end", ""]
        measured = run("\n".join(lines))
        for index, (corner, tick_s, level) in enumerate(runs):
            _, stopped_s = _square(tick_s, _charged_s(table), level)
            shut_s = measured[f"shut{index}"]
            least_v, most_v = measured[f"least{index}"], measured[f"most{index}"]
            if least_v is None or most_v is None:
                raise WiringError("ngspice measured no voltage of pass")
            after_s = None if shut_s is None or shut_s < stopped_s else shut_s - stopped_s
            found.append(Stop(corner, tick_s, level, least_v, most_v, after_s))
    return found


# ---- The gates while the FPGA is configured anew.


@dataclass(frozen=True)
class Anew:
    """The FPGA lets go of its pins while the gates run.

    ``pin_v`` is the most that a gate's pin of the FPGA stands at once it has settled, ``gate_v``
    the same of HI and LI; ``both_v`` is the most that HI and LI of a leg ever reach together.
    """

    level: Level
    pin_v: float
    gate_v: float
    both_v: float


def _pin(
    table: Table, name: str, drive: str, pull_a: float, pull_down_ohm: float | None, supply_v: float
) -> list[str]:
    """A pin that is driven while node ``cfg`` is 1, and pulled weakly when it isn't."""
    ramp_a = f"{pull_a}*(1-v(cfg))*max(0,min(1,({supply_v}-v({name}))/0.2))"
    lines = [
        f"S{name} d{name} {name} cfg 0 closed",
        f"E{name} e{name} 0 {drive} 0 {supply_v}",
        f"R{name} e{name} d{name} {table.pad.ohm}",
        f"C{name} {name} 0 {table.pad.farad}",
        f"B{name} 0 {name} I={ramp_a}",
        f"RL{name} {name} 0 100Meg",
    ]
    return lines + ([f"RD{name} {name} 0 {pull_down_ohm}"] if pull_down_ohm else [])


def _and(table: Table, name: str, inputs: Sequence[str], supply: str, load_ohm: float) -> list[str]:
    """An AND gate that switches at 1.4 V, with the pull-down behind it."""
    product = "*".join(f"(1/(1+exp(-(v({node})-1.4)/0.03)))" for node in inputs)
    return [
        f"B{name} b{name} 0 V=v({supply})*{product}",
        f"RO{name} b{name} {name} 25",
        f"CO{name} {name} 0 {table.pad.farad}",
        f"RG{name} {name} 0 {load_ohm}",
    ]


def configured_anew(
    table: Table, family: Family, tick_s: float, *, fpga_side: bool = True
) -> list[Anew]:
    """Gate A is on when the FPGA lets go; ``fpga_side=False`` leaves out the pull-downs there."""
    supply_v = table.supply.logic_v * (1 + table.supply.tolerance)
    part, found = table.part("R4"), []
    ohm = part.of(family) * (1 + part.tolerance) if fpga_side else None
    bridge_ohm = table.part("R5").of(family)
    pull_a = table.fpga[family].pull_a
    for level in ("high", "low"):
        points, stopped_s = _square(tick_s, _charged_s(table), level)
        loose_s = stopped_s + 5e-9
        settled_s = loose_s + _SETTLED_S
        end_s = settled_s + 2.5 * table.stop.longest_s
        lines = [
            "* an FPGA is configured anew while its gates run",
            *_models(table, supply_v),
            f"VDD vdd 0 {supply_v}",
            "VONE one 0 1",
            f"VCFG cfg 0 PWL(0 1 {loose_s:.9g} 1 {loose_s + 2e-9:.9g} 0)",
            f"VA va 0 PWL({points})",
            *_pin(table, "alive", "va", pull_a, None, supply_v),
            *_pin(table, "ah", "one", pull_a, ohm, supply_v),
            *_pin(table, "al", "0", pull_a, ohm, supply_v),
            *_pump(table, "x", "alive", "pass", Corner(supply_v, 25.0, 1.0, "typical"), family),
            "S1 vdd enable pass 0 schmitt",
            "R9 enable 0 10k",
            *_and(table, "hi", ("ah", "enable"), "vdd", bridge_ohm),
            *_and(table, "li", ("al", "enable"), "vdd", bridge_ohm),
            "BBOTH both 0 V=min(v(hi),v(li))",
            "BPIN pin 0 V=max(v(ah),v(al))",
            "BGATE gate 0 V=max(v(hi),v(li))",
            f".meas tran before MAX v(hi) from={stopped_s - 4 * tick_s} to={stopped_s}",
            f".meas tran pin MAX v(pin) from={settled_s} to={end_s}",
            f".meas tran gate MAX v(gate) from={settled_s} to={end_s}",
            f".meas tran both MAX v(both) from={stopped_s} to={end_s}",
            f".tran 50n {end_s + 10e-6} 0 {table.stop.longest_s / 200}",
            ".end",
            "",
        ]
        volts = {name: value for name, value in run("\n".join(lines)).items() if value is not None}
        if volts.get("before", 0.0) < table.levels.v_ih:
            raise WiringError("the gate was not on before the FPGA was configured anew")
        found.append(Anew(level, volts["pin"], volts["gate"], volts["both"]))
    return found


# ---- The gates while the 3.3 V fall.


def brown_out(table: Table, tick_s: float, *, supervised: bool = True) -> float:
    """The supply falls in 0.5 ms, and the FPGA, out of its mind, holds all gates on with ``alive``
    running: the most that HI and LI stand at once the supply is below the supervisor's."""
    full_v, fall_s, start_s = table.supply.logic_v, 0.5e-3, _charged_s(table)
    trip_v = table.supervisor_levels.trip_v[0]
    shut_s = start_s + (1 - trip_v / full_v) * fall_s + 3 * table.supervisor_levels.delay_s
    points, _ = _square(tick_s, start_s + fall_s, "low")
    inputs = ["gate", "enable", "good"] if supervised else ["gate", "enable"]
    delay_s = table.supervisor_levels.delay_s
    lines = [
        "* the 3.3 V fall",
        *_models(table, full_v),
        f"VDD vdd 0 PWL(0 {full_v} {start_s} {full_v} {start_s + fall_s} 0)",
        f"VA va 0 PWL({points})",
        "BA ba 0 V=v(va)*v(vdd)",
        f"RA ba alive {table.pad.ohm}",
        *_pump(table, "x", "alive", "pass", nominal(table), "ice40"),
        f"BON enable 0 V=v(vdd)/(1+exp(-(v(pass)-{table.levels.v_il})/0.03))",
        "RGATE vdd gate 40",
        "RGATE2 gate 0 100k",
        f"RSENSE vdd sense {delay_s / 1e-9}",
        "CSENSE sense 0 1n",
        f"BGOOD good 0 V=v(vdd)/(1+exp(-(v(sense)-{trip_v})/0.005))",
        *_and(table, "hi", inputs, "vdd", table.part("R5").of("ice40")),
        f".meas tran before MAX v(hi) from={start_s / 2} to={start_s}",
        f".meas tran after MAX v(hi) from={shut_s} to={start_s + fall_s}",
        f".tran 200n {start_s + fall_s} 0 1u",
        ".end",
        "",
    ]
    volts = run("\n".join(lines))
    if (volts["before"] or 0.0) < table.levels.v_ih:
        raise WiringError("the gate was not on before the supply fell")
    if volts["after"] is None:
        raise WiringError("ngspice measured nothing while the supply fell")
    return volts["after"]


# ---- What of it is not good enough.


def wired_so(table: Table) -> list[Board]:
    """The boards that have this table's circuits."""
    return [board for board in map(load_board, board_names()) if board.fpga.wiring == table.name]


def board_ticks(table: Table) -> Mapping[str, float]:
    """Time from one change of ``alive`` to the next on each such board, in s: a tick, or half."""
    return {
        board.name: (0.5 if board.words().alive_again else 1.0) / board.scene.controller.tick_hz
        for board in wired_so(table)
    }


def stop_complaints(table: Table, found: Iterable[Stop]) -> list[str]:
    lines = []
    for stop in found:
        corner = stop.corner
        where = (
            f"alive stops {stop.level}, tick {stop.tick_s * 1e6:g} µs, {corner.supply_v:.2f} V, "
            f"{corner.temperature_c:g} °C"
        )
        if stop.shut_s is None or stop.shut_s > table.stop.longest_s:
            took = (
                f"not within {_watched_s(table) * 1e6:g} µs"
                if stop.shut_s is None
                else f"after {stop.shut_s * 1e6:.0f} µs"
            )
            lines.append(
                f"{where}: the gates are shut {took}, allowed are {table.stop.longest_s * 1e6:g} µs"
            )
        opens_v = table.schmitt.at("rising_max_v", corner.supply_v)
        if stop.most_v < opens_v:
            lines.append(f"{where}: pass reaches {stop.most_v:.2f} V, and {opens_v:.2f} V may open")
        stays_v = table.schmitt.at("falling_max_v", corner.supply_v)
        if stop.least_v < stays_v:
            lines.append(
                f"{where}: pass sinks to {stop.least_v:.2f} V, and {stays_v:.2f} V may shut"
            )
    return lines


def anew_complaints(table: Table, family: Family, found: Iterable[Anew]) -> list[str]:
    lines, limit_v = [], table.levels.v_il
    for anew in found:
        where = f"{FAMILY_NAMES[family]} configured anew, alive left {anew.level}"
        for what, volts in (("a pin of the FPGA", anew.pin_v), ("HI or LI", anew.gate_v)):
            if volts > limit_v:
                lines.append(f"{where}: {what} stands at {volts:.2f} V, low is below {limit_v:g} V")
        if anew.both_v > limit_v:
            lines.append(f"{where}: HI and LI reach {anew.both_v:.2f} V together")
    return lines


def complaints(table: Table) -> list[str]:
    """A line for each thing that is not safe; the whole takes a few seconds."""
    ticks_s = sorted({*board_ticks(table).values(), table.stop.longest_tick_s})
    lines = stop_complaints(table, stops(table, ticks_s, corners(table)))
    for family in FAMILIES:
        if family not in {board.fpga.family for board in wired_so(table)}:
            continue
        lines += anew_complaints(table, family, configured_anew(table, family, ticks_s[-1]))
    left_v = brown_out(table, ticks_s[-1])
    if left_v > table.levels.v_il:
        lines.append(f"the 3.3 V fall: HI or LI stands at {left_v:.2f} V below the supervisor's")
    least_v = table.supply.logic_v * (1 - table.supply.tolerance)
    if table.supervisor_levels.trip_v[1] >= least_v:
        lines.append(
            f"the supervisor may shut at {table.supervisor_levels.trip_v[1]:g} V, and the supply "
            f"may be {least_v:.2f} V"
        )
    return lines
