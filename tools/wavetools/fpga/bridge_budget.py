# SPDX-License-Identifier: Apache-2.0
"""What a board's bridge and sensor ask of its scene: dead time, pulse, carrier, scale, bus, tick.

The figures are those of ``fpga.toml`` and ``boards/sensing.toml``, where their sources stand.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from wavehaptics.fpga.board_words import first_values
from wavehaptics.fpga.boards import Board, BoardError, Sense
from wavehaptics.parts.sensing import TABLE, sensing_parts
from wavehaptics.runtime.toml_source import parse
from wavehaptics.scene.keys import unknown_choice
from wavehaptics.words.memory import apart

from wavetools.fpga import clamps

LEAST_DEAD_S = 20e-9
"""Shortest dead time at HI and LI: what the maker's forum advises to begin with for an LMG5200."""

_ROUNDING_S = 1e-12


@dataclass(frozen=True)
class DeadTime:
    """A board's dead time as it is in clocks, and what it has to cover, s."""

    made_s: float
    mismatch_s: float
    gate_skew_s: float
    fpga_skew_s: float

    @property
    def needed_s(self) -> float:
        """At the FPGA's flip-flops: AND gates and FPGA may take of it on the way to HI and LI."""
        return max(LEAST_DEAD_S, self.mismatch_s) + self.gate_skew_s + self.fpga_skew_s


def dead_time(board: Board) -> DeadTime:
    """The dead time that a board's bitstream makes, and its budget."""
    bridge, words = board.fpga.bridge, board.words()
    made_s = words.words["dead_clocks"] / words.ports.timing.clock_hz
    return DeadTime(made_s, bridge.mismatch_s, bridge.gate_skew_s, bridge.fpga_skew_s)


def carrier_hz(board: Board) -> float:
    """A board's carrier, Hz."""
    timing = board.words().ports.timing
    return timing.clock_hz / (2 * timing.half_clocks)


def _check_sensing(board: Board) -> None:
    """:class:`BoardError` where the amplifier isn't known, or doesn't follow the carrier."""
    file, parts, name = f"{board.folder}/fpga.toml", sensing_parts(), board.sense.amplifier
    table, key = ("sense", "amplifier") if isinstance(board.sense, Sense) else ("modulator", "part")
    if name not in parts:
        raise BoardError(
            f"{file}: {table}.{key} {unknown_choice(name, parts)}, or enter it "
            f"in boards/{TABLE.name} with its figures"
        )
    part, made_hz = parts[name], carrier_hz(board)
    why = part.refusal(made_hz, board.words().ports.timing.tick_s)
    if why is not None:
        slower = made_hz > part.carrier_hz
        lower = f"lower drive.pwm_hz to {1e-3 * part.carrier_hz:.4g} kHz or less, or "
        raise BoardError(
            f"{board.scene_file}: the {name} may not follow the carrier of "
            f"{1e-3 * made_hz:.4g} kHz: {why}; {lower if slower else ''}"
            f"name another {key} in [{table}] of {file}"
        )


def _check_clamp(board: Board) -> None:
    """:class:`BoardError` where D2 isn't for the bus of the scene."""
    file, bridge = f"{board.folder}/fpga.toml", board.fpga.bridge
    known = clamps.clamps()
    if bridge.clamp not in known:
        raise BoardError(
            f"{file}: bridge.clamp {unknown_choice(bridge.clamp, known)}, or enter it "
            f"in boards/{clamps.TABLE.name} with its figures"
        )
    drive = board.scene.drive
    assert drive is not None
    assert drive.bus_v is not None
    why = known[bridge.clamp].refusal(drive.bus_v, bridge.bus_max_v)
    if why is not None:
        fits = [
            name for name, one in known.items()
            if one.refusal(drive.bus_v, bridge.bus_max_v) is None
        ]  # fmt: skip
        cure = f"solder and name {' or '.join(fits)}" if fits else "lower drive.bus_v"
        raise BoardError(f"{file}: D2, {bridge.clamp}, {why}; {cure}")


def _soldered(board: Board, *key: str) -> tuple[Any, str]:
    """A value of the tables of what is soldered, and where it stands."""
    for path in board.wiring:
        data, lines = parse((board.root / path).read_bytes())
        if key in lines:
            for step in key:
                data = data[step]
            return data, f"{path}:{lines[key]}"
    raise BoardError(f"{board.wiring[-1]}: {'.'.join(key)} is missing; add it")


def _check_wiring(board: Board) -> None:
    """:class:`BoardError` where the table of what is soldered says otherwise than the board."""
    soldered_ohm, place = _soldered(board, "parts", "R6", "value")
    shunt_ohm = board.fpga.sense.shunt_ohm
    if board.sense is board.fpga.sense and abs(soldered_ohm / shunt_ohm - 1) > 1e-6:
        raise BoardError(
            f"{board.folder}/fpga.toml: sense.shunt_ohm is {1e3 * shunt_ohm:g} mΩ, but R6 of "
            f"{place} has {1e3 * soldered_ohm:g} mΩ; make both what is soldered"
        )
    longest_s, place = _soldered(board, "stop", "longest_tick_s")
    words = board.words()
    often, part = ("twice", 0.5) if words.alive_again else ("once", 1.0)
    change_s = part * words.ports.timing.tick_s
    if change_s > longest_s * (1.0 + 1e-9):
        raise BoardError(
            f"{board.scene_file}: alive changes {often} a tick, {1e6 * change_s:.3g} µs, and the "
            f"pump behind it lets go of the gates with more than {1e6 * longest_s:g} µs "
            f"({place}); raise controller.tick_hz"
        )


def in_patterns(board: Board) -> list[Board]:
    """The board with each of the patterns that its line can choose for its bridge.

    :class:`BoardError` where any other setting would be another one in one of them: only the
    pattern's word is written.
    """
    made, drive = board.words(), board.scene.drive
    found = []
    for name in made.patterns:
        assert drive is not None
        scene = board.scene.model_copy(update={"drive": drive.model_copy(update={"mode": name})})
        other = replace(board, scene=scene)
        first, then = (apart(first_values(each, 1)) for each in (made, other.words()))
        differ = [word for word in then if then[word] != first[word] and word not in made.ranges]
        if differ:
            raise BoardError(
                f"{board.scene_file}: with drive.mode = {name}, which the line can choose, "
                f"{differ[0]} would be another one; take another drive.pwm_hz or min_pulse_s"
            )
        found.append(other)
    return found


def check(board: Board) -> None:
    """:class:`BoardError` where the scene asks of bridge or sensor what they can't do.

    It has to hold in every pattern of the bridge that can be chosen.
    """
    for each in in_patterns(board) or [board]:
        _check(each)


def _check(board: Board) -> None:
    """Of the one pattern that the scene has."""
    scene_file, file = board.scene_file, f"{board.folder}/fpga.toml"
    bridge, sense, scene = board.fpga.bridge, board.sense, board.scene
    time = dead_time(board)
    if time.made_s < time.needed_s - _ROUNDING_S:
        raise BoardError(
            f"{scene_file}: the dead time is {1e9 * time.made_s:.3g} ns in whole clocks, and "
            f"{1e9 * time.needed_s:.3g} ns are needed (driver {1e9 * bridge.mismatch_s:g}, AND "
            f"gates {1e9 * bridge.gate_skew_s:g}, FPGA {1e9 * bridge.fpga_skew_s:g} ns, and "
            f"{1e9 * LEAST_DEAD_S:g} ns at least at HI and LI); raise drive.dead_time_s"
        )
    drive, adc = scene.drive, scene.adc
    assert drive is not None
    assert adc is not None
    if drive.min_pulse_s < bridge.min_pulse_s - _ROUNDING_S:
        raise BoardError(
            f"{scene_file}: drive.min_pulse_s is {1e9 * drive.min_pulse_s:g} ns, and the "
            f"{bridge.driver} needs {1e9 * bridge.min_pulse_s:g} ns; set it so"
        )
    full_scale_a = adc.full_scale_a
    made, table, ends = (
        (f"a gain of {sense.gain:g} at {sense.supply_v:g} V make", "sense", "clips at")
        if isinstance(sense, Sense)
        else (f"the {sense.part} make", "modulator", "is linear up to")
    )
    if abs(sense.full_scale_a / full_scale_a - 1) > 0.01:
        raise BoardError(
            f"{scene_file}: adc.full_scale_a is {full_scale_a:g} A, but {1e3 * sense.shunt_ohm:g} "
            f"mΩ and {made} {sense.full_scale_a:.3g} A; set it so, or change [{table}] in {file}"
        )
    if sense.trip_a >= sense.clip_a:
        raise BoardError(
            f"{file}: {table}.trip_a is {sense.trip_a:g} A, but the {sense.amplifier} {ends} "
            f"{sense.clip_a:.3g} A, so that it would never trip; lower it"
        )
    _check_sensing(board)
    _check_clamp(board)
    _check_wiring(board)
