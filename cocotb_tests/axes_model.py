# SPDX-License-Identifier: Apache-2.0
"""A brushless motor at ``rtl/wh_ports.v`` in integers: codes and counts, values and gates."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

os.environ["NUMBA_DISABLE_JIT"] = "1"  # compiling would take longer than it saves

from wavehaptics.controller import anchor, clarke, magnet_angle, rotor_flux, wave_core
from wavehaptics.controller.modulator import (
    dead_time_extra,
    duty_of,
    half_width,
    new_dead_time,
    new_modulator,
    width_bounds,
)
from wavehaptics.controller.pins_timing import GATE_CLOCKS
from wavehaptics.motor.sensor import scale_sum
from wavehaptics.words import formats
from wavehaptics.words.bridge_modes import HALF_BRIDGE
from wavehaptics.words.table import AXES, THREE_PHASE_LEGS

PACE = 3
SETTLE_MOST = 255 - 2 * PACE
"""Ticks that each leg waits longer between two changes of side than the one before it."""
SINES = rotor_flux.sine_table()
NOWHERE = 1 << 30
"""Where a wall is that there isn't."""


@dataclass
class Drive:
    """Settings of all ports that the gates are of."""

    half_clocks: int
    dead_clocks: int = 0
    min_pulse: int = 0
    second_order: bool = False
    compensate: bool = False
    settle_ticks: int = 0

    @property
    def first_extra(self) -> int:
        """What a leg is longer by until the first current: its side is +1."""
        return self.dead_clocks << (formats.EXTRA.fraction - 1) if self.compensate else 0

    def extra(self, n: int, state: np.ndarray, current: int, side: int) -> int:
        """What leg ``n`` is longer by from a tick's current on."""
        if not self.compensate:
            return 0
        settle = min(self.settle_ticks, SETTLE_MOST) + PACE * n
        return dead_time_extra(state, current, self.dead_clocks, side, settle)

    def period(self, width: int) -> list[int]:
        """A leg's levels in a period of the carrier: high around its end."""
        half = self.half_clocks
        first = half // 2 + width
        last = half - half // 2 + width
        return [1] * first + [0] * (2 * half - first - last) + [1] * last


class Leg:
    """The gates of a leg, from its widths on: low at first, and on after the dead time."""

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._stood, self._before = -1, 0
        self._gates = self._passed([0] * GATE_CLOCKS)
        self._rest, self.dead_time = new_modulator(), new_dead_time()
        self.longer = drive.first_extra

    def _passed(self, levels: Iterable[int]) -> list[tuple[int, int]]:
        gates = []
        for level in levels:
            self._stood = self._stood + 1 if level == self._before else 0
            self._before = level
            on = self._stood >= self._drive.dead_clocks
            gates.append((level, 1 - level) if on else (0, 0))
        return gates

    def width(self, duty: int) -> int:
        """The width that a duty makes, in 1/65536 clock, with what was left of those before."""
        drive = self._drive
        return half_width(
            self._rest, duty, self.longer, drive.half_clocks, drive.second_order,
            *width_bounds(HALF_BRIDGE, drive.min_pulse),
        )  # fmt: skip

    def period(self, width: int) -> None:
        """Let a period of the carrier come."""
        self._gates += self._passed(self._drive.period(width))

    def gates(self, clocks: int) -> list[tuple[int, int]]:
        """(high, low) of the next ``clocks``, which are forgotten."""
        found, self._gates = self._gates[:clocks], self._gates[clocks:]
        return found


@dataclass
class Settings:
    """Of one port, as words, and those of all that its steps are of."""

    zeros: Sequence[int]
    """These two of each phase."""
    gains: Sequence[int]
    eta_contact: int
    eta_free: int
    root: int
    a: int
    u_max: int
    anchor: np.ndarray
    walls: Sequence[tuple[int, int, int, int]]
    """Low, high, enable, shaped."""
    hysteresis: int
    sections: np.ndarray
    """Words of W, (sections, 12)."""
    range: int
    """Of a sample."""


@dataclass
class Step:
    """What is shown of a step; lists have alpha's first."""

    phases: list[int]
    """Currents out of the legs."""
    position: int
    contact: bool
    lost: bool
    """An anchor had lost the rotor before."""
    current: list[int]
    u: list[int]
    v: list[int]
    voltage: list[int]
    correction: list[int]
    saturated: list[bool]
    clipped: list[bool]
    offset: list[int]
    flux: list[int]
    lag: list[int]
    faults: list[bool]
    found: bool
    """The anchors begin anew, as the magnets are found."""

    @property
    def legs(self) -> tuple[int, int, int]:
        """Voltages of the legs."""
        return clarke.centred(*clarke.phases(*self.voltage))


class BrushlessMotor:
    """Both axes of one motor, with the encoder at 0 after reset."""

    def __init__(
        self, delays: tuple[int, int], sections: int, magnets: tuple[int, int, int]
    ) -> None:
        """``delays``: extra and hold ticks; ``magnets``: find, zero_angle and count_angle."""
        find, zero, self.count_angle = magnets
        self._delays, self._sections = delays, sections
        self._contact = np.array([-1, 0], dtype=np.int64)
        self.rotor = rotor_flux.new_state(0, zero)
        self.magnet = magnet_angle.new_state(not find, 0)
        self.stop()

    def stop(self) -> None:
        """The bridges are off."""
        extra, hold = self._delays
        self.ports = [wave_core.new_state() for _ in range(AXES)]
        self.lines = [wave_core.new_line(max(extra, hold)) for _ in range(AXES)]
        self.states = [wave_core.new_shaper_state(self._sections) for _ in range(AXES)]
        self.anchors = [anchor.new_state() for _ in range(AXES)]
        self.waves = [0] * AXES
        """e_id of the step before."""

    @property
    def known(self) -> bool:
        """Whether the magnets are found."""
        return bool(self.magnet[magnet_angle.KNOWN])

    def currents(
        self, set_: Settings, words: Sequence[Sequence[int]]
    ) -> tuple[list[int], list[int]]:
        """Currents of the phases a and b of a tick's samples, and at which ends they are."""
        phases, ends = [], []
        for zero, gain, own in zip(set_.zeros, set_.gains, words, strict=True):
            phases.append(scale_sum(sum(own) - zero, gain))
            high, low = max(own) >= set_.range, min(own) <= -set_.range
            ends.append(high * formats.AT_HIGH | low * formats.AT_LOW)
        return phases, ends

    def look(self, set_: Settings, position: int) -> tuple[bool, bool]:
        """A turn's look at the walls: contact, and whether that wall feels as W."""
        low, high = (
            np.array([wall[side] if wall[2] else NOWHERE for wall in set_.walls])
            for side in range(2)
        )
        touching, _ = wave_core.contact_step(
            self._contact, position, low, high, bool(set_.hysteresis)
        )
        rotor_flux.rotor_flux_step(self.rotor, self.count_angle, SINES, position)
        self.angle = int(self.rotor[rotor_flux.ANGLE])
        return touching, touching and bool(set_.walls[self._contact[0]][3])

    def step(
        self, set_: Settings, words: Sequence[Sequence[int]], position: int, *,
        damp: bool = False, still: bool = False,
    ) -> Step:  # fmt: skip
        """A turn of both axes; ``still``: nothing of the rotor's flux is seen to change."""
        contact, shaped = self.look(set_, position)
        phases, phase_ends = self.currents(set_, words)
        axes = clarke.currents(*phases)
        ends = [phase_ends[0], phase_ends[0] | phase_ends[1] | clarke.ends(axes[1])]
        if damp:
            for held in self.anchors:
                anchor.reset(held)
        lost = any(held[anchor.FAULT] for held in self.anchors)
        eta = 0 if damp or lost else set_.eta_contact if contact else set_.eta_free
        mode = wave_core.CLEAR if not contact else wave_core.SHAPE if shaped else wave_core.HOLD
        gains = set_.anchor.copy()
        gains[anchor.ENABLE] &= self.known
        extra, hold = self._delays
        found = Step([*phases, wave_core.saturate(-phases[0] - phases[1])], position, contact,
                     lost, *([] for _ in range(11)), found=False)  # fmt: skip
        for n, held in enumerate(self.anchors):
            port = self.ports[n]
            withheld, saturated = port[wave_core.STATE_WITHHELD], port[wave_core.STATE_SATURATED]
            current = wave_core.saturate(axes[n] - int(held[anchor.OFFSET]))
            correction = int(held[anchor.CORRECTION])
            e, u, v = wave_core.shaped_core_step(
                port, self.lines[n], set_.sections, self.states[n], mode, current, eta, 0,
                set_.root, set_.a, anchor.left(set_.u_max, held), extra, hold, ends[n],
            )  # fmt: skip
            if not damp:
                place, cell = rotor_flux.PLACE_A + n, rotor_flux.CELL_A + n
                anchor.anchor_axis_step(
                    held, gains, position, 0 if still else int(self.rotor[place]),
                    int(self.rotor[cell]), contact, current, u, v, withheld, self.waves[n],
                    bool(saturated), bool(port[wave_core.STATE_CLIPPED]),
                )  # fmt: skip
            self.waves[n] = e
            found.current.append(current)
            found.u.append(u)
            found.v.append(v)
            found.voltage.append(wave_core.saturate(e + correction))
            found.correction.append(correction)
            found.saturated.append(bool(port[wave_core.STATE_SATURATED]))
            found.clipped.append(bool(port[wave_core.STATE_CLIPPED]))
            found.offset.append(int(held[anchor.OFFSET]))
            found.flux.append(int(held[anchor.CHI]) >> formats.LONG_GUARD)
            found.lag.append(int(held[anchor.LAG]) >> formats.LONG_GUARD)
            found.faults.append(bool(held[anchor.FAULT]))
        before = self.known
        by = magnet_angle.magnet_angle_step(
            self.magnet, self.count_angle, int(set_.anchor[anchor.SLOW_TICKS]), position, contact,
            int(self.rotor[rotor_flux.CELL_A]), int(self.rotor[rotor_flux.CELL_B]), *found.flux,
        )  # fmt: skip
        rotor_flux.turn_by(self.rotor, by)
        if self.known and not before:
            found.found = True
            for held in self.anchors:
                anchor.reset(held)
        return found


class Legs:
    """The three legs of a motor, a carrier period of a tick after the other."""

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self.each = [Leg(drive) for _ in range(THREE_PHASE_LEGS)]
        for leg in self.each:
            leg.period(0)  # the first one is a reset's

    def drive_by(self, step: Step | None, scale: int, side: int) -> None:
        """Let the next period come, which is of a step, or of none yet."""
        for n, leg in enumerate(self.each):
            duty = 0
            if step is not None:
                duty = duty_of(step.legs[n], scale)
                leg.longer = self._drive.extra(n, leg.dead_time, step.phases[n], side)
            leg.period(leg.width(duty))
