# SPDX-License-Identifier: Apache-2.0
"""What a board's bridge and current sensor ask of its scene: dead time, pulse, scale and trip.

The figures are those of ``fpga.toml``, where their sources stand.
"""

from __future__ import annotations

from dataclasses import dataclass

from wavehaptics.fpga.boards import Board, BoardError

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


def check(board: Board) -> None:
    """:class:`BoardError` where the scene asks of bridge or sensor what they can't do."""
    scene_file, file = f"{board.folder}/board.toml", f"{board.folder}/fpga.toml"
    bridge, sense, scene = board.fpga.bridge, board.fpga.sense, board.scene
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
    if abs(sense.full_scale_a / full_scale_a - 1) > 0.01:
        raise BoardError(
            f"{scene_file}: adc.full_scale_a is {full_scale_a:g} A, but {1e3 * sense.shunt_ohm:g} "
            f"mΩ and a gain of {sense.gain:g} at {sense.supply_v:g} V make "
            f"{sense.full_scale_a:.3g} A; set it so, or change [sense] in {file}"
        )
    if sense.trip_a >= sense.clip_a:
        raise BoardError(
            f"{file}: sense.trip_a is {sense.trip_a:g} A, but the {sense.amplifier} clips at "
            f"{sense.clip_a:.3g} A, so that it would never trip; lower it"
        )
