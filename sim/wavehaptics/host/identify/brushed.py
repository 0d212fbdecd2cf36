# SPDX-License-Identifier: Apache-2.0
"""The steps of an identification of a motor with brushes, each with what is plausible.

docs/identify.md says what each measures, and how.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wavehaptics.host.identify import encoder, steps
from wavehaptics.host.identify import inductance as inductances
from wavehaptics.host.identify import resistance as resistances
from wavehaptics.host.identify.back_emf import LEAST, MOST, SAME, BackEmf, back_emf
from wavehaptics.host.identify.driver import Driver
from wavehaptics.host.identify.inductance import inductance
from wavehaptics.host.identify.mechanics import Mechanics, mechanics
from wavehaptics.host.identify.resistance import Resistance, resistance, rough
from wavehaptics.host.identify.sampling import Sampling
from wavehaptics.host.identify.segments import Estimate
from wavehaptics.host.identify.steps import NotPlausible
from wavehaptics.host.names import HostError
from wavehaptics.parts.motors import MotorConstants


@dataclass(frozen=True)
class Found:
    """What was identified, SI units, with the spread of each."""

    offset_a: Estimate
    resistance: Resistance
    inductance: Estimate
    back_emf: BackEmf
    mechanics: Mechanics
    counts: int
    current_a: float
    """The test current."""


class BrushedProcedure(steps.Steps[MotorConstants]):
    """The steps of a motor with brushes."""

    def __init__(
        self, driver: Driver, wishes: steps.Wishes, tell: steps.Told, show: steps.Shown
    ) -> None:
        super().__init__(driver, wishes, tell, show, MotorConstants)

    def _try_signs(self) -> None:
        self._rough()
        self._first_pulses()

    def _excite(self) -> None:
        self._pulse_all()
        self._coast_all()
        volts = self._ohm * self._amps
        seconds = inductances.RISES * self._henry / self._ohm
        self._tell(f"steps: {2 * steps.STEP_PAIRS} of {volts:.2g} V")
        self._rises = [
            self._step(self._sign(n) * volts, self._r_hat, seconds)
            for n in self._staged("steps", 2 * steps.STEP_PAIRS)
        ]

    def estimate(self) -> Found:
        """What the records tell; the bridges are off."""
        winding, turn = self._electrical()
        motion = self._mechanics(turn)
        found = self._inductance(winding, motion)
        return Found(
            self._offset, winding, found, turn, motion, self._wishes.counts, self._amps
        )  # fmt: skip

    # ---- Sign, and the first R and L, by small voltages.

    def _rough(self) -> None:
        driver, amps = self._driver, self._amps
        sign, volts = 1.0, steps.FIRST_OHM * amps
        # Doubled up to the limit at most, and once more the other way.
        most = 2 + max(0, math.ceil(math.log2(max(driver.limit_v, volts) / volts)))
        nothing = self._nothing
        while True:
            volts = min(volts, driver.limit_v)
            self._show("sign", len(self._steps) / most)
            step = self._step(sign * volts, resistances.LEAST_OHM)
            self._steps.append(step)
            peak = steps.smooth_peak(step).real
            if abs(peak) > nothing and peak * sign < 0:
                raise NotPlausible(
                    "current reversed", f"{sign * volts:.2g} V drive {peak:.2g} A",
                    "the two wires of the shunt, or of the bridge's outputs",
                )  # fmt: skip
            if len(self._steps) == 1 and abs(peak) > amps:
                raise steps.shorted(f"{volts:.2g} V drive {abs(peak):.2g} A")
            if abs(peak) >= 0.5 * amps and len(self._steps) > 1:
                break
            if volts >= driver.limit_v:
                if abs(peak) < nothing:
                    raise NotPlausible(
                        "unplugged", f"no current at the limit of {volts:.3g} V",
                        "the motor's plug, its leads and brushes, and the bus",
                    )  # fmt: skip
                break
            sign, volts = -sign, 2.0 * volts
        self._steps.append(self._step(-sign * volts, resistances.LEAST_OHM))
        self._show("sign", 1.0)
        self._know_roughly(rough(inductances.rises(self._steps)))

    # ---- Pulses, for R, the encoder, k_T and J.

    def _first_pulses(self) -> None:
        self._regulate()
        self._brake_for(self._most_v)
        # Where it has to move little, from small ones on until it moves.
        enough = 2 * encoder.CELLS if self._wishes.signs else steps.MANY_CELLS
        for part, seconds in steps.TRIALS[0 if self._careful else steps.CAREFUL :]:
            for n in range(2):
                self._pulse(self._sign(n) * part * self._amps, seconds)
            if self._cells(self._pulses[-2:]) >= enough:
                break
        self._check_turns()

    @property
    def _careful(self) -> bool:
        """Whether each pulse begins with the rotor at rest, and none is larger than it must be."""
        return self._wishes.signs or self._wishes.travel_rad is not None

    @property
    def _most_v(self) -> float:
        return steps.PART_OF_LIMIT * self._driver.limit_v

    def _pulse_all(self) -> None:
        seconds = self._pulse_time(self._most_v)
        self._tell(f"pulses: {steps.PULSES} of {1e3 * seconds:.0f} ms")
        for n in self._staged("pulses", steps.PULSES):
            self._pulse(
                self._sign(n) * self._amps * steps.LEVELS[n // 2 % len(steps.LEVELS)], seconds
            )

    def _brake_for(self, emf_v: float) -> None:
        """A brake in which a back-EMF drives no more than the test current."""
        ohm = max(0.0, emf_v / self._amps - self._ohm)
        self._eta = min(ohm / (ohm + 2.0 * self._r_hat), 0.98)

    def _pulse(self, amps: float, seconds: float) -> None:
        driver = self._driver
        if self._careful:
            self._stand()
        driver.release()
        driver.record(amps, seconds, steps.PULSE_ROWS)
        driver.brake(self._eta)
        self._pulses.append(self._fetched())

    def _sign(self, n: int) -> float:
        """Of the next pulse: in turn, or with little room back to where it began."""
        if self._wishes.travel_rad is None or self._place == 0.0:
            return 1.0 if n % 2 == 0 else -1.0
        return -math.copysign(1.0, self._place)

    def _check_turns(self) -> None:
        newest = self._pulses[-2:]
        cells = self._cells(newest)
        if cells < encoder.CELLS:
            turns = encoder.turns_unseen(newest[-1], encoder.emf_rate(newest), self._ohm)
            raise self._at_rest(cells, turns)
        if self._careful:
            counts = encoder.counts_along(newest, self._cell)
            if counts < -encoder.CELLS:
                raise encoder_reversed(
                    f"the rotor goes {-counts:.0f} counts against the current that turns it"
                )
            if self._wishes.signs and counts < encoder.CELLS:
                raise NotPlausible(
                    "encoder's sign", f"both pulses' {counts:.0f} counts are too few for one",
                    "what holds or moves the shaft, or allow more by --current",
                )  # fmt: skip
            self._tell(f"encoder's sign: right, by {counts:.0f} counts")

    def _pulse_time(self, most_v: float) -> float:
        rate = encoder.emf_rate(self._pulses[-2:])
        seconds = min(max(most_v / (rate * self._amps), steps.LEAST_PULSE_S), steps.MOST_PULSE_S)
        # A pulse's end is some exchanges late; then the brake takes its own time.
        late = steps.EXCHANGES_LATE * self._driver.exchange_s
        travel = self._wishes.travel_rad
        if travel is None:
            self._brake_for(min(rate * self._amps * (seconds + late), self._driver.limit_v))
            return seconds
        last = self._pulses[-1]
        t = last.step_s * len(last.position)
        pull = 2 * float(np.ptp(last.position)) / t**2 / abs(float(np.mean(last.current)))
        self._slow = pull * self._amps

        def reach(seconds: float) -> float:
            t = seconds + late
            return self._slow * t * (0.5 * t + max(t, self._ohm / rate))

        while seconds > steps.LEAST_PULSE_S and reach(seconds) > steps.ROOM * travel:
            seconds *= 0.9
        if reach(seconds) > steps.ROOM * travel:
            amps = self._amps * steps.ROOM * travel / reach(steps.LEAST_PULSE_S)
            raise HostError(
                f"--travel {travel:g} rad is too little for pulses of {self._amps:.2g} A; "
                f"take --current {amps:.1g}"
            )
        self._brake_for(rate * self._amps * (seconds + late))
        return seconds

    def _electrical(self) -> tuple[Resistance, BackEmf]:
        winding = resistance(self._pulses)
        self._check_ohm(winding.ohm.value)
        turn = back_emf(self._pulses, winding)
        # As if the rotor didn't turn in the rises, of which J is to come.
        henry = max(inductance(self._rises, winding, math.inf).value, inductances.LEAST_H)
        least = steps.LEVELS[-1] * self._amps
        self._sampling = sampling = Sampling(self._driver.pulse_s, winding, henry, least)
        winding, turn = sampling.winding(), sampling.back_emf(turn)
        k_t, spread = turn.k_t.value, turn.k_t.sd
        if encoder.is_reversed(turn.k_t):
            raise encoder_reversed(f"the back-EMF is {1e3 * k_t:.3g} mV·s/rad, below zero")
        if not LEAST < k_t < MOST or spread > 0.2 * k_t:
            raise NotPlausible(
                "back-EMF", f"{1e3 * k_t:.3g} ± {1e3 * spread:.2g} mV·s/rad are no motor's",
                "--counts, and that the encoder sits firmly on the shaft",
            )  # fmt: skip
        apart = abs(turn.forward.value - turn.backward.value)
        if apart > SAME * k_t + steps.SIGMA * math.hypot(turn.forward.sd, turn.backward.sd):
            raise NotPlausible(
                "back-EMF", f"{1e3 * turn.forward.value:.4g} mV·s/rad one way and "
                f"{1e3 * turn.backward.value:.4g} the other",
                "the brushes, and the encoder's edges",
            )  # fmt: skip
        self._tell(f"R: {winding.ohm.value:.4g} ± {winding.ohm.sd:.2g} Ω, with brushes of "
                   f"{winding.drop_v.value:.2g} ± {winding.drop_v.sd:.2g} V")  # fmt: skip
        self._tell(f"k_T: {1e3 * k_t:.4g} ± {1e3 * spread:.2g} mN·m/A; encoder's sign: right")
        self._expect_winding(winding, turn)
        return winding, turn

    def _expect_winding(self, winding: Resistance, turn: BackEmf) -> None:
        expected = self._expected
        if expected is None:
            return
        self._check_expected_ohm(winding.ohm.value)
        by_r = winding.ohm.value / expected.R_ohm
        by_k = turn.k_t.value / expected.k_t
        if abs(by_k - 1.0) > steps.K_PART:
            counts = encoder.counts_for(turn.k_t.value, expected.k_t, self._wishes.counts)
            raise NotPlausible(
                "wrong counts", f"k_T is {by_k:.3f} times what was expected and R {by_r:.3f} "
                f"times, as if there were {counts:.0f} counts a revolution",
                f"--counts {self._wishes.counts}, all four edges counted, or the motor's type",
            )  # fmt: skip

    # ---- L.

    def _inductance(self, winding: Resistance, motion: Mechanics) -> Estimate:
        found = inductance(self._rises, winding, motion.inertia.value)
        found = self._sampling.inductance(found)
        self._check_henry(found.value)
        self._tell(f"L: {1e3 * found.value:.4g} ± {1e3 * found.sd:.2g} mH")
        return found

    # ---- Coasting.

    def _coast_all(self) -> None:
        driver = self._driver
        pulse = self._pulses[-1]
        spin_s = pulse.step_s * len(pulse.position)
        self._regulate()
        self._tell(f"coasting: {2 * steps.COASTS} times")
        for n in self._staged("coasting", 2 * steps.COASTS):
            # From two speeds, or viscous friction couldn't be told from the other.
            amps = self._sign(n) * self._amps * steps.LEVELS[n // 2 % len(steps.LEVELS)]
            driver.release()
            driver.record(amps, spin_s, steps.PULSE_ROWS)
            seconds = steps.MOST_COAST_S
            travel = self._wishes.travel_rad
            if travel is not None:
                fast = self._slow * (spin_s + steps.EXCHANGES_LATE * driver.exchange_s)
                seconds = min(seconds, steps.ROOM * travel / fast)
            driver.record_free(seconds, steps.COAST_ROWS, amps)
            driver.brake(self._eta)
            self._coasts.append(self._fetched())

    def _mechanics(self, turn: BackEmf) -> Mechanics:
        found = mechanics([*self._pulses, *self._coasts], turn.k_t, self._cell)
        return self._checked_motion(found and self._sampling.mechanics(found))


def encoder_reversed(found: str) -> NotPlausible:
    """Of counts against the motor."""
    return NotPlausible(
        "encoder reversed", found, "A and B, which may be swapped, or the motor's two leads"
    )
