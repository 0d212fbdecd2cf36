# SPDX-License-Identifier: Apache-2.0
"""The steps of a brushless motor's identification, as docs/identify.md has them.

Currents and voltages are complex numbers, α + jβ.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from wavehaptics.host.identify import encoder, steps
from wavehaptics.host.identify import inductance as inductances
from wavehaptics.host.identify import magnets as magnet
from wavehaptics.host.identify import resistance as resistances
from wavehaptics.host.identify.driver import Driver
from wavehaptics.host.identify.magnets import Magnets, magnets
from wavehaptics.host.identify.mechanics import Mechanics, mechanics
from wavehaptics.host.identify.resistance import rough
from wavehaptics.host.identify.sampling import unseen_part
from wavehaptics.host.identify.segments import Estimate, Segment
from wavehaptics.host.identify.steps import NotPlausible
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

ASIDE_RAD = 0.6
"""By which a current may stand beside the voltage that drives it.

L_d of 0.5 L_q makes up to 20°, two wires that are swapped, or one that is open, 60° or more.
"""

LEAST_PSI, MOST_PSI = 1e-5, 0.5
"""ψ of a motor, V·s."""

CLEARLY = 2.0
"""By how many times every other p has to leave more."""


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


class BrushlessProcedure(steps.Steps[BrushlessConstants]):
    """The steps of a brushless motor."""

    def __init__(
        self, driver: Driver, wishes: steps.Wishes, tell: steps.Told, show: steps.Shown
    ) -> None:
        super().__init__(driver, wishes, tell, show, BrushlessConstants)
        self._ways: list[complex] = []

    def _try_signs(self) -> None:
        self._rough()
        self._pulse_all()
        # Which may take longer than an arming lasts.
        self._driver.disarm()
        self._magnets = magnets(self._pulses)
        if self._wishes.signs:
            self._check_pole_pairs(self._magnets)

    def _excite(self) -> None:
        self._driver.arm()
        self._coast_all()
        self._step_all()

    def estimate(self) -> FoundBrushless:
        """What the records tell; the bridges are off."""
        found = magnets([*self._pulses, *self._coasts])
        self._check_ohm(found.ohm.value)
        q, d = self._inductances(found)
        part = unseen_part(self._driver.pulse_s, found.ohm.value, q.value)
        found, q, d = found.widened(part), q.widened(part * q.value), d.widened(part * d.value)
        self._check_pole_pairs(found)
        self._check_magnets(found)
        told = f"L: {1e3 * q.value:.4g} ± {1e3 * q.sd:.2g} mH"
        along_d = f" along q, {1e3 * d.value:.4g} ± {1e3 * d.sd:.2g} along d"
        self._tell(told + (along_d if q != d else ""))
        motion = self._mechanics(found)
        return FoundBrushless(self._offset, found, q, d, motion, self._wishes.counts, self._amps)

    # ---- Signs of the currents, and the first R and L, by small voltages.

    def _rough(self) -> None:
        driver, amps = self._driver, self._amps
        # A voltage's limit is that of each axis: both may come to a third more.
        volts = resistances.LEAST_OHM * amps
        nothing = self._nothing
        most = 4 + max(0, math.ceil(math.log2(max(driver.limit_v, volts) / volts)))
        left = [DIRECTIONS[n] for n in (0, 2, 1, 3)]
        while left:
            self._show("sign", len(self._steps) / most)
            volts = min(volts, driver.limit_v)
            direction = left[0]
            step = self._step(volts * direction, resistances.LEAST_OHM)
            peak = abs(steps.smooth_peak(step))
            if not self._steps and peak > amps:
                raise steps.shorted(f"{volts:.2g} V drive {peak:.2g} A")
            self._steps.append(step)
            self._ways.append(direction)
            if peak >= CLEAR * amps or (volts >= driver.limit_v and peak > nothing):
                self._check_direction(step, volts)
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
        seen = [magnet.seen(s, way) for s, way in zip(self._steps, self._ways, strict=True)]
        self._know_roughly(rough(inductances.rises(seen)))

    def _check_direction(self, step: Segment, volts: float) -> None:
        """The current begins along the voltage, or two of the six wires are swapped."""
        size = np.abs(step.current)
        first = slice(begins := int(np.argmax(size > CLEAR * np.max(size))), begins + 2)
        aside = cmath.phase(np.mean(step.current[first]) / np.mean(step.voltage[: begins + 2]))
        if abs(aside) < ASIDE_RAD:
            return
        found = f"{volts:.2g} V drive a current {math.degrees(aside):.0f}° beside them"
        if abs(aside) > math.pi - ASIDE_RAD:
            raise NotPlausible("current reversed", found, "both wires of each shunt")
        raise NotPlausible(
            "phases", found, "which shunt is whose phase's, and that all three leads are plugged in"
        )

    # ---- Pulses, for R, the magnets and J.

    def _pulse_all(self) -> None:
        self._regulate()
        for part, seconds in steps.TRIALS[steps.CAREFUL :]:
            for n in range(3):
                self._pulse(part * self._amps * DIRECTIONS[n], seconds)
            if self._cells(self._pulses[-3:]) >= steps.MANY_CELLS:
                break
        self._check_turns()
        self._tell(f"pulses: {steps.PULSES} of {1e3 * steps.MOST_PULSE_S:.0f} ms")
        for n in self._staged("pulses", steps.PULSES):
            amps = self._amps * steps.LEVELS[n // len(DIRECTIONS) % len(steps.LEVELS)]
            self._pulse(amps * DIRECTIONS[n % len(DIRECTIONS)], steps.MOST_PULSE_S)

    def _pulse(self, amps: complex, seconds: float) -> None:
        driver = self._driver
        driver.still()
        driver.release()
        driver.record(amps, seconds, steps.PULSE_ROWS)
        driver.brake(BRAKE)
        self._pulses.append(self._fetched())

    def _check_turns(self) -> None:
        newest = self._pulses[-3:]
        cells = self._cells(newest)
        if cells >= steps.MANY_CELLS:
            return
        left = [np.abs(s.voltage - self._ohm * s.current)[len(s.voltage) // 4 :] for s in newest]
        most = max(float(np.ptp(volts)) for volts in left)
        raise self._at_rest(cells, most > encoder.TURNS * self._ohm * self._amps)

    def _check_pole_pairs(self, found: Magnets) -> None:
        if found.clear < CLEARLY:
            raise NotPlausible(
                "pole pairs", f"{abs(found.pole_pairs)} and others do as well, the rotor turns too "
                "little", "what is fixed to the shaft, or allow more by --current",
            )  # fmt: skip
        if found.pole_pairs < 0:
            raise NotPlausible(
                "encoder reversed", "the magnets turn against the counts",
                "A and B, which may be swapped, or two of the motor's leads with their shunts",
            )  # fmt: skip
        self._tell("encoder's sign: right")

    def _check_magnets(self, found: Magnets) -> None:
        psi = found.flux.value
        if not LEAST_PSI < psi < MOST_PSI or found.flux.sd > 0.1 * psi:
            raise NotPlausible(
                "back-EMF", f"ψ is {1e3 * psi:.3g} ± {1e3 * found.flux.sd:.2g} mV·s, no motor's",
                "--counts, and that the encoder sits firmly on the shaft",
            )  # fmt: skip
        degrees = math.degrees(found.pole_pairs * found.place.sd)
        self._tell(
            f"R: {found.ohm.value:.4g} ± {found.ohm.sd:.2g} Ω; {found.pole_pairs} pole pairs"
        )
        self._tell(f"ψ: {1e3 * psi:.4g} ± {1e3 * found.flux.sd:.2g} mV·s; "
                   f"magnets to {degrees:.1g}°")  # fmt: skip
        self._expect(found)

    def _expect(self, found: Magnets) -> None:
        expected = self._expected
        if expected is None:
            return
        self._check_expected_ohm(found.ohm.value)
        by_psi = found.flux.value / expected.psi_vs
        if found.pole_pairs != expected.pole_pairs:
            raise NotPlausible(
                "wrong counts", f"{found.pole_pairs} pole pairs in place of {expected.pole_pairs}",
                f"--counts {self._wishes.counts}, all four edges counted, or the motor's type",
            )  # fmt: skip
        if abs(by_psi - 1.0) > steps.K_PART:
            raise NotPlausible(
                "wrong motor", f"ψ is {by_psi:.2f} times what was expected", "the motor's type"
            )

    # ---- Coasting.

    def _coast_all(self) -> None:
        driver = self._driver
        self._regulate()
        self._tell(f"coasting: {2 * steps.COASTS} times")
        for n in self._staged("coasting", 2 * steps.COASTS):
            driver.still()
            driver.release()
            theta = self._magnets.pole_pairs * (driver.place() - self._magnets.place.value)
            way = 1.0 if n % 2 == 0 else -1.0
            amps = self._amps * steps.LEVELS[n // 2 % len(steps.LEVELS)]
            wanted = cmath.rect(1.0, theta + way * 0.5 * math.pi)
            driver.push(amps * max(DIRECTIONS, key=lambda d: (d * wanted.conjugate()).real))
            driver.linger(SPIN_S)
            driver.record_free(steps.MOST_COAST_S, steps.COAST_ROWS, way)
            driver.brake(BRAKE)
            self._coasts.append(self._fetched())

    def _mechanics(self, found: Magnets) -> Mechanics:
        records = [magnet.across(s, found) for s in [*self._pulses, *self._coasts]]
        return self._checked_motion(mechanics(records, found.k_t, self._cell))

    # ---- L.

    def _step_all(self) -> None:
        volts = self._ohm * self._amps
        seconds = inductances.RISES * self._henry / self._ohm
        ways = [*DIRECTIONS] * STEP_ROUNDS
        self._tell(f"steps: {len(ways)} of {volts:.2g} V")
        self._rises = [
            self._step(volts * ways[n], self._r_hat, seconds)
            for n in self._staged("steps", len(ways))
        ]

    def _inductances(self, found: Magnets) -> tuple[Estimate, Estimate]:
        directions = [magnet.direction(s) for s in self._rises]
        pairs = zip(self._rises, directions, strict=True)
        seen = inductances.rises([magnet.along(s, d, found) for s, d in pairs])
        firsts = [inductances.begins(s) for s in seen]
        q, d = magnet.inductances(seen, found, directions, firsts)
        self._check_henry(q.value)
        return q, d
