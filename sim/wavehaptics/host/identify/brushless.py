# SPDX-License-Identifier: Apache-2.0
"""The steps of a brushless motor's identification, as docs/identify.md has them.

Currents and voltages are complex numbers, α + jβ.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from wavehaptics.host.identify import inductance as inductances
from wavehaptics.host.identify import magnets as magnet
from wavehaptics.host.identify import resistance as resistances
from wavehaptics.host.identify import zero
from wavehaptics.host.identify.driver import Driver, OffError
from wavehaptics.host.identify.magnets import Magnets, magnets
from wavehaptics.host.identify.mechanics import LEAST_J, MOST_J, Mechanics, mechanics
from wavehaptics.host.identify.procedure import (
    CAREFUL,
    COAST_ROWS,
    COASTS,
    FIRST_OHM,
    J_PART,
    K_PART,
    L_PART,
    LEAST_OF_NOISE,
    LEVELS,
    MANY_CELLS,
    MOST_COAST_S,
    MOST_PULSE_S,
    NOTHING,
    PART_OF_LIMIT,
    PULSE_ROWS,
    PULSES,
    R_HAT_PART,
    R_PART,
    READINGS,
    SIGMA,
    STEP_ROWS,
    TRIALS,
    NotPlausible,
    Shown,
    Told,
    Wishes,
    expected_of,
)
from wavehaptics.host.identify.resistance import rough
from wavehaptics.host.identify.segments import Estimate, Segment
from wavehaptics.host.names import HostError
from wavehaptics.parts.motors import BrushlessConstants

DIRECTIONS = tuple(cmath.rect(1.0, math.radians(degrees)) for degrees in (30, 90, 210, 270))
"""Those that one zero alone makes: both phases' can't be written in the same tick.

From one to the next they turn by 60° or 120°, and so do the magnets with them.
"""

STEP_ROUNDS = 3
"""Steps of the voltage in each direction."""

BRAKE = 0.5
"""η from one pulse to the next."""

SPIN_S = 4e-3
"""For which a rotor is pushed before it coasts."""

CLEAR = 0.25
"""Part of the test current from which on a direction can be told."""

ASIDE_RAD = 0.3
"""By which a current may stand beside the voltage that drives it: L_d isn't L_q."""

LEAST_PSI, MOST_PSI = 1e-5, 0.5
"""ψ of a motor, V·s."""

TURNED = 0.15
"""Part of R i by which the voltage of a pulse changes if the rotor turns."""


@dataclass(frozen=True)
class FoundBrushless:
    """What was identified, SI units, with the spread of each. L is along q, where the torque is."""

    offset_a: Estimate
    magnets: Magnets
    inductance: Estimate
    inductance_d: Estimate
    mechanics: Mechanics
    counts: int
    current_a: float
    """The test current."""

    @property
    def magnet_place(self) -> Estimate:
        """Where x is when the magnets lie along phase a, rad: x is in the middle of its count."""
        place = self.magnets.place
        return Estimate(place.value + math.pi / self.counts, place.sd)

    @property
    def salient(self) -> bool:
        """Whether L_d is another than L_q."""
        return self.inductance_d.value != self.inductance.value


class BrushlessProcedure:
    """:meth:`record` with the bridges on, then :meth:`estimate`; as for motors with brushes."""

    def __init__(self, driver: Driver, wishes: Wishes, tell: Told, show: Shown) -> None:
        self._driver, self._wishes, self._tell, self._show = driver, wishes, tell, show
        self._expected = expected_of(wishes, BrushlessConstants)
        self._cell = 2 * math.pi / wishes.counts
        self._steps: list[tuple[Segment, complex]] = []
        self._pulses: list[Segment] = []
        self._coasts: list[Segment] = []
        self._start: float | None = None

    def record(self) -> None:
        """All that needs the bridges."""
        driver = self._driver
        driver.measure_cells(self._cell)
        driver.measure_exchange()
        most = driver.most_current()
        self._amps = most if self._wishes.current_a is None else self._wishes.current_a
        if self._amps > most * (1 + 1e-9):
            raise HostError(
                f"--current {self._amps:g} A is more than the board's settings permit, {most:.3g} A"
            )
        driver.prepare()
        self._offset = self._zero()
        least = LEAST_OF_NOISE * self._offset.sd
        if self._amps < least:
            raise HostError(
                f"--current {self._amps:g} A is too little beside the sensors' noise of "
                f"{self._offset.sd:.2g} A; take {least:.2g} A or more"
            )
        driver.arm()
        try:
            self._rough()
            self._pulse_all()
            # Which may take longer than an arming lasts.
            driver.disarm()
            self._magnets = magnets(self._pulses)
            driver.arm()
            self._coast_all()
            self._step_all()
        except OffError as error:
            if len(self._steps) < 2 and error.faults:
                raise _shorted(str(error)) from None
            raise

    def estimate(self) -> FoundBrushless:
        """What the records tell; the bridges are off."""
        found = self._turning()
        q, d = self._inductances(found)
        motion = self._mechanics(found)
        return FoundBrushless(self._offset, found, q, d, motion, self._wishes.counts, self._amps)

    # ---- Zero.

    def _zero(self) -> Estimate:
        driver = self._driver
        self._show("zero", 0.0)
        if not driver.arms:  # whose bridges are on, and which has measured its zeros itself
            driver.release()
            return Estimate(0.0, 0.0)
        readings = driver.currents(READINGS)
        found = Estimate(float(abs(np.mean(readings))), float(np.std(readings)))
        if found.value > zero.MOST * driver.full_scale_a:
            raise NotPlausible(
                "zero", f"the sensors show {found.value:.3g} A with the bridges off",
                "the shunts' amplifiers and their reference",
            )  # fmt: skip
        self._tell(f"zero: {1e3 * found.value:.2f} mA, noise {1e3 * found.sd:.2f} mA")
        self._show("zero", 1.0)
        return found

    # ---- Signs of the currents, and the first R and L, by small voltages.

    def _step(self, volts: complex, r_hat: float, seconds: float = 0.0) -> Segment:
        driver = self._driver
        driver.still()
        driver.loop(r_hat, 0.5, abs(volts))
        driver.release()
        driver.record(
            driver.beyond_a * volts / abs(volts), max(seconds, STEP_ROWS * driver.tick_s),
            STEP_ROWS, abs(volts),
        )  # fmt: skip
        driver.brake(0.0)
        return self._fetched()

    def _rough(self) -> None:
        driver, amps = self._driver, self._amps
        volts, nothing = FIRST_OHM * amps, max(NOTHING * amps, SIGMA * self._offset.sd)
        most = 4 + max(0, math.ceil(math.log2(max(driver.limit_v, volts) / volts)))
        left = [DIRECTIONS[n] for n in (0, 2, 1, 3)]
        while left:
            self._show("sign", len(self._steps) / most)
            volts = min(volts, driver.limit_v)
            direction = left[0]
            step = self._step(volts * direction, resistances.LEAST_OHM)
            peak = float(np.max(np.abs(step.current)))
            if not self._steps and peak > amps:
                raise _shorted(f"{volts:.2g} V drive {peak:.2g} A")
            self._steps.append((step, direction))
            if peak >= CLEAR * amps or (volts >= driver.limit_v and peak > nothing):
                self._check_direction(step, direction, volts)
            elif volts >= driver.limit_v:
                raise NotPlausible(
                    "unplugged", f"no current at the limit of {volts:.3g} V",
                    "the motor's plug, its three leads, and the bus",
                )  # fmt: skip
            if peak >= 0.5 * amps or volts >= driver.limit_v:
                left.pop(0)
            else:
                volts *= 2.0
        self._show("sign", 1.0)
        first = rough(inductances.rises([_seen(s, d) for s, d in self._steps]))
        self._check_ohm(first.ohm.value)
        self._ohm = first.ohm.value
        self._henry = min(max(first.inductance.value, inductances.LEAST_H), inductances.MOST_H)
        if self._wishes.current_a is None:
            self._amps = min(self._amps, PART_OF_LIMIT * driver.limit_v / self._ohm)
        self._tell(f"sign: right; R about {self._ohm:.2g} Ω, test current {self._amps:.2g} A")

    def _check_direction(self, step: Segment, direction: complex, volts: float) -> None:
        """The current begins along the voltage, or two of the six wires are swapped."""
        size = np.abs(step.current)
        begins = int(np.argmax(size > 0.5 * np.max(size)))
        aside = cmath.phase(np.mean(step.current[begins : begins + 2]) / direction)
        if abs(aside) < ASIDE_RAD:
            return
        found = f"{volts:.2g} V drive a current {math.degrees(aside):.0f}° beside them"
        if abs(aside) > math.pi - ASIDE_RAD:
            raise NotPlausible("current reversed", found, "both wires of each shunt")
        raise NotPlausible(
            "phases", found, "which shunt is whose phase's, and that all three leads are plugged in"
        )

    def _check_ohm(self, ohm: float) -> None:
        if ohm < resistances.LEAST_OHM:
            raise _shorted(f"R is {ohm:.2g} Ω")
        if ohm > resistances.MOST_OHM:
            raise NotPlausible("no motor", f"R is {ohm:.3g} Ω", "the motor's three leads")

    # ---- Pulses, for R, the magnets and J.

    def _pulse_all(self) -> None:
        driver = self._driver
        self._a = min(self._ohm / self._henry * driver.tick_s, 0.1 / (driver.extra_ticks + 1))
        self._r_hat = R_HAT_PART * self._ohm
        driver.loop(self._r_hat, self._a)
        for part, seconds in TRIALS[CAREFUL:]:
            for n in range(3):
                self._pulse(part * self._amps * DIRECTIONS[n], seconds)
            if self._cells(self._pulses[-3:]) >= MANY_CELLS:
                break
        self._check_turns()
        self._tell(f"pulses: {PULSES} of {1e3 * MOST_PULSE_S:.0f} ms")
        for n in range(PULSES):
            self._show("pulses", n / PULSES)
            amps = self._amps * LEVELS[n // len(DIRECTIONS) % len(LEVELS)]
            self._pulse(amps * DIRECTIONS[n % len(DIRECTIONS)], MOST_PULSE_S)
        self._show("pulses", 1.0)

    def _pulse(self, amps: complex, seconds: float) -> None:
        driver = self._driver
        driver.still()
        driver.release()
        driver.record(amps, seconds, PULSE_ROWS)
        driver.brake(BRAKE)
        self._pulses.append(self._fetched())

    def _fetched(self) -> Segment:
        """The newest record; :class:`HostError` if the rotor has left the room that it has."""
        record = self._driver.fetch()
        if self._start is None:
            self._start = float(record.position[0])
        travel, place = self._wishes.travel_rad, float(record.position[-1]) - self._start
        if travel is not None and abs(place) > 0.5 * travel:
            raise HostError(
                f"the rotor turned by {place:.2g} rad, out of --travel {travel:g}; each pulse may "
                "turn it by half a turn of the magnets: give it more room"
            )
        return record

    def _cells(self, segments: list[Segment]) -> float:
        return max(float(np.ptp(s.position)) for s in segments) / self._cell

    def _check_turns(self) -> None:
        newest = self._pulses[-3:]
        cells = self._cells(newest)
        if cells >= MANY_CELLS:
            return
        left = [np.abs(s.voltage - self._ohm * s.current)[len(s.voltage) // 4 :] for s in newest]
        if max(float(np.ptp(volts)) for volts in left) > TURNED * self._ohm * self._amps:
            raise NotPlausible(
                "encoder silent", f"the motor turns, and the encoder tells {cells:.0f} counts",
                "the encoder's plug, its supply, and A and B each, or allow more by --current",
            )  # fmt: skip
        raise NotPlausible(
            "jammed", f"the rotor moves by {cells:.0f} counts at {self._amps:.2g} A",
            "what holds the shaft, or allow more by --current",
        )  # fmt: skip

    def _turning(self) -> Magnets:
        found = magnets([*self._pulses, *self._coasts])
        self._check_ohm(found.ohm.value)
        part = self._sampled
        flux = found.flux.widened(part * found.flux.value)
        found = Magnets(
            found.ohm.widened(part * found.ohm.value), found.dead_v, found.inductance, flux,
            found.pole_pairs, found.place,
        )  # fmt: skip
        psi = found.flux.value
        if not LEAST_PSI < psi < MOST_PSI or found.flux.sd > 0.1 * psi:
            raise NotPlausible(
                "back-EMF", f"ψ is {1e3 * psi:.3g} ± {1e3 * found.flux.sd:.2g} mV·s, no motor's",
                "--counts, and that the encoder sits firmly on the shaft",
            )  # fmt: skip
        if found.pole_pairs < 0:
            raise NotPlausible(
                "encoder reversed", "the magnets turn against the counts",
                "A and B, which may be swapped, or two of the motor's leads with their shunts",
            )  # fmt: skip
        degrees = math.degrees(found.pole_pairs * found.place.sd)
        self._tell(
            f"R: {found.ohm.value:.4g} ± {found.ohm.sd:.2g} Ω; {found.pole_pairs} pole pairs"
        )
        self._tell(f"ψ: {1e3 * psi:.4g} ± {1e3 * found.flux.sd:.2g} mV·s; encoder's sign: right; "
                   f"magnets to {degrees:.1g}°")  # fmt: skip
        self._expect(found)
        return found

    @property
    def _sampled(self) -> float:
        """Part by which a sampled current isn't its pulse's mean: :mod:`.sampling`."""
        return (self._driver.pulse_s * self._ohm / self._henry) ** 2 / 24.0

    def _expect(self, found: Magnets) -> None:
        expected = self._expected
        if expected is None:
            return
        by_r = found.ohm.value / expected.R_ohm
        if abs(by_r - 1.0) > R_PART:
            raise NotPlausible(
                "wrong motor", f"R is {by_r:.2f} times what was expected",
                "the motor's type and wires, the shunts and the bus",
            )  # fmt: skip
        by_psi = found.flux.value / expected.psi_vs
        if found.pole_pairs != expected.pole_pairs:
            counts = self._wishes.counts * expected.pole_pairs / found.pole_pairs
            raise NotPlausible(
                "wrong counts", f"{found.pole_pairs} pole pairs in place of {expected.pole_pairs}, "
                f"as if there were {counts:.0f} counts a revolution",
                f"--counts {self._wishes.counts}, all four edges counted, or the motor's type",
            )  # fmt: skip
        if abs(by_psi - 1.0) > K_PART:
            raise NotPlausible(
                "wrong motor", f"ψ is {by_psi:.2f} times what was expected", "the motor's type"
            )

    # ---- Coasting.

    def _coast_all(self) -> None:
        driver = self._driver
        driver.loop(self._r_hat, self._a)
        self._tell(f"coasting: {2 * COASTS} times")
        for n in range(2 * COASTS):
            self._show("coasting", n / (2 * COASTS))
            driver.still()
            driver.release()
            theta = self._magnets.pole_pairs * (driver.place() - self._magnets.place.value)
            way = 1.0 if n % 2 == 0 else -1.0
            amps = self._amps * LEVELS[n // 2 % len(LEVELS)]
            wanted = cmath.rect(1.0, theta + way * 0.5 * math.pi)
            driver.push(amps * max(DIRECTIONS, key=lambda d: (d * wanted.conjugate()).real))
            driver.linger(SPIN_S)
            driver.record_free(MOST_COAST_S, COAST_ROWS, way)
            driver.brake(BRAKE)
            self._coasts.append(self._fetched())
        self._show("coasting", 1.0)

    def _mechanics(self, found: Magnets) -> Mechanics:
        records = [magnet.across(s, found) for s in [*self._pulses, *self._coasts]]
        motion = mechanics(records, found.k_t, self._cell)
        if motion is None or not LEAST_J < motion.inertia.value < MOST_J:
            raise NotPlausible(
                "inertia", "the rotor's motion doesn't follow the current",
                "what the shaft is coupled to; it has to turn freely",
            )  # fmt: skip
        expected = self._expected
        if expected is not None and motion.inertia.value < (1.0 - J_PART) * expected.J_kgm2:
            raise NotPlausible(
                "inertia",
                f"J is {motion.inertia.value / expected.J_kgm2:.2f} times the rotor's own",
                "--counts and the motor's type",
            )  # fmt: skip
        friction = motion.coulomb
        self._tell(f"J: {motion.inertia.value:.3g} ± {motion.inertia.sd:.1g} kg·m², friction "
                   f"{1e3 * friction.value:.2g} ± {1e3 * friction.sd:.1g} mN·m")  # fmt: skip
        return motion

    # ---- L.

    def _step_all(self) -> None:
        volts = self._ohm * self._amps
        seconds = inductances.RISES * self._henry / self._ohm
        steps = [*DIRECTIONS] * STEP_ROUNDS
        self._tell(f"steps: {len(steps)} of {volts:.2g} V")
        self._rises: list[tuple[Segment, complex]] = []
        for n, direction in enumerate(steps):
            self._show("steps", n / len(steps))
            self._rises.append((self._step(volts * direction, self._r_hat, seconds), direction))
        self._show("steps", 1.0)

    def _inductances(self, found: Magnets) -> tuple[Estimate, Estimate]:
        directions = [direction for _, direction in self._rises]
        seen = inductances.rises([magnet.along(s, d, found) for s, d in self._rises])
        firsts = [inductances.begins(s) for s in seen]
        q, d = (
            value.widened(self._sampled * value.value)
            for value in magnet.inductances(seen, found, directions, firsts)
        )
        for value in (q, d):
            if not inductances.LEAST_H < value.value < inductances.MOST_H:
                raise NotPlausible(
                    "inductance", f"L is {value.value:.3g} H",
                    "the currents' amplifiers and their filters",
                )  # fmt: skip
        expected = self._expected
        if expected is not None and abs(q.value / expected.L_h - 1.0) > L_PART:
            raise NotPlausible(
                "wrong motor", f"L is {q.value / expected.L_h:.2f} times what was expected",
                "the motor's type, and filters in its leads",
            )  # fmt: skip
        self._tell(f"L: {1e3 * q.value:.4g} ± {1e3 * q.sd:.2g} mH along q, "
                   f"{1e3 * d.value:.4g} ± {1e3 * d.sd:.2g} along d")  # fmt: skip
        return q, d


def _seen(s: Segment, direction: complex) -> Segment:
    """A record along a direction."""
    turn = np.conj(direction)
    return Segment(
        s.step_s, (turn * s.voltage).real, (turn * s.current).real, s.position, s.wanted
    )  # fmt: skip


def _shorted(found: str) -> NotPlausible:
    return NotPlausible(
        "shorted", found, "the motor's leads against each other and against the case"
    )
