# SPDX-License-Identifier: Apache-2.0
"""The steps of an identification on a device, each with what is plausible and what to check if not.

docs/identify.md says what each measures, and how.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from wavehaptics.host.identify import encoder, zero
from wavehaptics.host.identify import inductance as inductances
from wavehaptics.host.identify import resistance as resistances
from wavehaptics.host.identify.back_emf import LEAST, MOST, SAME, BackEmf, back_emf
from wavehaptics.host.identify.driver import Driver, OffError
from wavehaptics.host.identify.inductance import inductance
from wavehaptics.host.identify.mechanics import LEAST_J, MOST_J, Mechanics, mechanics
from wavehaptics.host.identify.resistance import Resistance, resistance, rough
from wavehaptics.host.identify.sampling import Sampling
from wavehaptics.host.identify.segments import Estimate, Segment
from wavehaptics.host.names import HostError
from wavehaptics.parts.motors import BrushlessConstants, MotorConstants

READINGS = 16
"""Of the current with the bridges off."""

FIRST_OHM = 0.1
"""The first voltage is what drives the test current through this."""

STEP_ROWS = 256
PULSE_ROWS = 128
COAST_ROWS = 256
"""Rows of the records: of steps of the voltage, pulses of the current, and coasting."""

PULSES = 24
COASTS = 4
STEP_PAIRS = 3
"""Pulses in all, coasting either way, steps of the voltage either way."""

LEVELS = (1.0, 0.35)
"""Currents of the pulses, of the test current."""

LEAST_PULSE_S, MOST_PULSE_S = 2e-3, 30e-3
MOST_COAST_S = 80e-3

PART_OF_LIMIT = 0.4
"""Of the voltage's limit, for R i, and as much for the back-EMF."""

R_HAT_PART = 0.25
"""R̂ of the waves while identifying, of R: low is well damped."""

LEAST_OF_NOISE = 10.0
"""Least test current, of a reading's noise."""

NOTHING = 0.02
"""Part of the test current that is none."""

SMOOTH = 16
"""Rows that a step's current is smoothed over."""

TRIALS = ((0.1, 2e-3), (0.2, 2e-3), (0.4, 2e-3), (1.0, 2e-3), (1.0, 8e-3), (1.0, 30e-3))
"""Parts of the test current, and times in s, of the first pulses."""
CAREFUL = 3
"""Of these, those for a rotor with little room."""
MANY_CELLS = 40
"""Cells of the encoder that tell how fast the rotor speeds up."""
ROOM = 0.25
"""Part of --travel that a pulse may turn the rotor by."""
EXCHANGES_LATE = 4
"""Exchanges from the end of a record to the end of its pulse."""

SIGMA = 4.0
"""Spreads that two values may be apart."""

R_PART, L_PART, K_PART, J_PART = 0.35, 0.5, 0.15, 0.6
"""By how much a motor may differ from what was expected: R of a warm one with its wires, the
inductance at another frequency, k_T of a lot, J with what is fixed to the shaft."""


class NotPlausible(HostError):
    """A step that found what can't be: its name, what was found and what to check."""

    def __init__(self, fault: str, found: str, check: str) -> None:
        self.fault = fault
        super().__init__(f"{fault}: {found}; check {check}")


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


@dataclass(frozen=True)
class Wishes:
    """What a user says: counts a revolution, test current, room to turn, the motor to expect."""

    counts: int
    current_a: float | None = None
    travel_rad: float | None = None
    expected: MotorConstants | BrushlessConstants | None = None


Constants = TypeVar("Constants", MotorConstants, BrushlessConstants)


def expected_of(wishes: Wishes, kind: type[Constants]) -> Constants | None:
    """The motor that is expected; :class:`HostError` where it is none of the device's kind."""
    expected = wishes.expected
    if expected is None or isinstance(expected, kind):
        return expected
    drives = "a brushless motor" if kind is BrushlessConstants else "a motor with brushes"
    raise HostError(f"--expect: the device drives {drives}; name one, or leave it out")


Told = Callable[[str], None]
Shown = Callable[[str, float], None]


class Procedure:
    """Of a motor with brushes: :meth:`record` with the bridges on, then :meth:`estimate`."""

    def __init__(self, driver: Driver, wishes: Wishes, tell: Told, show: Shown) -> None:
        self._driver, self._wishes, self._tell, self._show = driver, wishes, tell, show
        self._expected = expected_of(wishes, MotorConstants)
        self._cell = 2 * math.pi / wishes.counts
        self._steps: list[Segment] = []
        self._pulses: list[Segment] = []
        self._coasts: list[Segment] = []
        self._start: float | None = None
        self._place = 0.0

    def record(self) -> None:
        """All that needs the bridges."""
        driver = self._driver
        self._show("zero", 0.0)
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
                f"--current {self._amps:g} A is too little beside the sensor's noise of "
                f"{self._offset.sd:.2g} A; take {least:.2g} A or more"
            )
        driver.arm()
        self._show("zero", 1.0)
        try:
            self._rough()
            self._pulse_all()
            self._coast_all()
            volts = self._ohm * self._amps
            seconds = inductances.RISES * self._henry / self._ohm
            self._tell(f"steps: {2 * STEP_PAIRS} of {volts:.2g} V")
            self._rises = [
                self._step(self._sign(n) * volts, self._r_hat, seconds)
                for n in self._staged("steps", 2 * STEP_PAIRS)
            ]
        except OffError as error:
            raise self._switched_off(error) from None

    def _staged(self, stage: str, count: int) -> Iterator[int]:
        """Numbers of a stage's records, shown as they are done."""
        for n in range(count):
            self._show(stage, n / count)
            yield n
        self._show(stage, 1.0)

    def estimate(self) -> Found:
        """What the records tell; the bridges are off."""
        winding, turn = self._electrical()
        motion = self._mechanics(turn)
        found = self._inductance(winding, motion)
        return Found(
            self._offset, winding, found, turn, motion, self._wishes.counts, self._amps
        )  # fmt: skip

    # ---- Zero.

    def _zero(self) -> Estimate:
        driver = self._driver
        if not driver.arms:  # whose bridges are on, and which has measured its zero itself
            driver.release()
            return Estimate(0.0, 0.0)
        found = zero.offset(driver.currents(READINGS))
        if abs(found.value) > zero.MOST * driver.full_scale_a:
            raise NotPlausible(
                "zero", f"the sensor shows {found.value:.3g} A with the bridges off",
                "the shunt's amplifier and its reference",
            )  # fmt: skip
        self._tell(f"zero: {1e3 * found.value:.2f} mA, noise {1e3 * found.sd:.2f} mA")
        return found

    # ---- Sign, and the first R and L, by small voltages.

    def _step(self, volts: float, r_hat: float, seconds: float = 0.0) -> Segment:
        driver = self._driver
        driver.still()
        driver.loop(r_hat, 0.5, abs(volts))
        driver.release()
        driver.record(
            math.copysign(driver.beyond_a, volts), max(seconds, STEP_ROWS * driver.tick_s),
            STEP_ROWS, volts,
        )  # fmt: skip
        driver.brake(0.0)
        return self._fetched()

    def _rough(self) -> None:
        driver, amps = self._driver, self._amps
        sign, volts = 1.0, FIRST_OHM * amps
        # Doubled up to the limit at most, and once more the other way.
        most = 2 + max(0, math.ceil(math.log2(max(driver.limit_v, volts) / volts)))
        nothing = max(NOTHING * amps, SIGMA * self._offset.sd / math.sqrt(SMOOTH))
        while True:
            volts = min(volts, driver.limit_v)
            self._show("sign", len(self._steps) / most)
            step = self._step(sign * volts, resistances.LEAST_OHM)
            self._steps.append(step)
            smooth = np.convolve(step.current, np.full(SMOOTH, 1.0 / SMOOTH), "valid")
            peak = float(smooth[np.argmax(np.abs(smooth))])
            if abs(peak) > nothing and peak * sign < 0:
                raise NotPlausible(
                    "current reversed", f"{sign * volts:.2g} V drive {peak:.2g} A",
                    "the two wires of the shunt, or of the bridge's outputs",
                )  # fmt: skip
            if len(self._steps) == 1 and abs(peak) > amps:
                raise self._shorted(f"{volts:.2g} V drive {abs(peak):.2g} A")
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
        first = rough(inductances.rises(self._steps))
        self._check_ohm(first.ohm.value)
        self._ohm = first.ohm.value
        self._henry = min(max(first.inductance.value, inductances.LEAST_H), inductances.MOST_H)
        usual = PART_OF_LIMIT * driver.limit_v / self._ohm
        if self._wishes.current_a is None:
            self._amps = min(self._amps, usual)
        self._tell(f"sign: right; R about {self._ohm:.2g} Ω, test current {self._amps:.2g} A")

    def _check_ohm(self, ohm: float) -> None:
        if ohm < resistances.LEAST_OHM:
            raise self._shorted(f"R is {ohm:.2g} Ω")
        if ohm > resistances.MOST_OHM:
            raise NotPlausible(
                "no motor", f"R is {ohm:.3g} Ω", "the motor's leads, brushes and commutator"
            )

    def _shorted(self, found: str) -> NotPlausible:
        return NotPlausible(
            "shorted", found, "the motor's leads against each other and against the case"
        )

    def _switched_off(self, error: OffError) -> HostError:
        if len(self._steps) < 2 and error.faults:
            return self._shorted(str(error))
        return error

    # ---- Pulses, for R, the encoder, k_T and J.

    def _pulse_all(self) -> None:
        driver = self._driver
        ohm, henry = self._ohm, self._henry
        a = min(ohm / henry * driver.tick_s, 0.1 / (driver.extra_ticks + 1))
        self._a = a
        self._r_hat = R_HAT_PART * ohm
        driver.loop(self._r_hat, a)
        most_v = PART_OF_LIMIT * driver.limit_v
        self._brake_for(most_v)
        # With little room, from small ones on until the rotor moves.
        for part, seconds in TRIALS[0 if self._wishes.travel_rad is not None else CAREFUL :]:
            for n in range(2):
                self._pulse(self._sign(n) * part * self._amps, seconds)
            if encoder.cells(self._pulses[-2:], self._cell) >= MANY_CELLS:
                break
        self._check_turns()
        seconds = self._pulse_time(most_v)
        self._tell(f"pulses: {PULSES} of {1e3 * seconds:.0f} ms")
        for n in self._staged("pulses", PULSES):
            self._pulse(self._sign(n) * self._amps * LEVELS[n // 2 % len(LEVELS)], seconds)

    def _brake_for(self, emf_v: float) -> None:
        """A brake in which a back-EMF drives no more than the test current."""
        ohm = max(0.0, emf_v / self._amps - self._ohm)
        self._eta = min(ohm / (ohm + 2.0 * self._r_hat), 0.98)

    def _pulse(self, amps: float, seconds: float) -> None:
        driver = self._driver
        if self._wishes.travel_rad is not None:
            driver.still()
        driver.release()
        driver.record(amps, seconds, PULSE_ROWS)
        driver.brake(self._eta)
        self._pulses.append(self._fetched())

    def _fetched(self) -> Segment:
        """The newest record; :class:`HostError` if the rotor has left the room that it has."""
        record = self._driver.fetch()
        if self._start is None:
            self._start = float(record.position[0])
        self._place = float(record.position[-1]) - self._start
        travel = self._wishes.travel_rad
        if travel is not None and abs(self._place) > 0.5 * travel:
            raise HostError(
                f"the rotor turned by {self._place:.2g} rad, out of --travel {travel:g}; "
                f"take less than --current {self._amps:.2g}, and begin in the middle"
            )
        return record

    def _sign(self, n: int) -> float:
        """Of the next pulse: in turn, or with little room back to where it began."""
        if self._wishes.travel_rad is None or self._place == 0.0:
            return 1.0 if n % 2 == 0 else -1.0
        return -math.copysign(1.0, self._place)

    def _check_turns(self) -> None:
        newest = self._pulses[-2:]
        cells = encoder.cells(newest, self._cell)
        if cells >= encoder.CELLS:
            return
        if encoder.turns_unseen(newest[-1], encoder.emf_rate(newest), self._ohm):
            raise NotPlausible(
                "encoder silent", f"the motor turns, and the encoder tells {cells:.0f} counts",
                "the encoder's plug, its supply, and A and B each, or allow more by --current",
            )  # fmt: skip
        raise NotPlausible(
            "jammed", f"the rotor moves by {cells:.0f} counts at {self._amps:.2g} A",
            "what holds the shaft, or allow more by --current",
        )  # fmt: skip

    def _pulse_time(self, most_v: float) -> float:
        rate = encoder.emf_rate(self._pulses[-2:])
        seconds = min(max(most_v / (rate * self._amps), LEAST_PULSE_S), MOST_PULSE_S)
        # A pulse's end is some exchanges late; then the brake takes its own time.
        late = EXCHANGES_LATE * self._driver.exchange_s
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

        while seconds > LEAST_PULSE_S and reach(seconds) > ROOM * travel:
            seconds *= 0.9
        if reach(seconds) > ROOM * travel:
            amps = self._amps * ROOM * travel / reach(LEAST_PULSE_S)
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
        least = LEVELS[-1] * self._amps
        self._sampling = sampling = Sampling(self._driver.pulse_s, winding, self._henry, least)
        winding, turn = sampling.winding(), sampling.back_emf(turn)
        k_t, spread = turn.k_t.value, turn.k_t.sd
        if encoder.is_reversed(turn.k_t):
            raise NotPlausible(
                "encoder reversed", f"the back-EMF is {1e3 * k_t:.3g} mV·s/rad, below zero",
                "A and B, which may be swapped, or the motor's two leads",
            )  # fmt: skip
        if not LEAST < k_t < MOST or spread > 0.2 * k_t:
            raise NotPlausible(
                "back-EMF", f"{1e3 * k_t:.3g} ± {1e3 * spread:.2g} mV·s/rad are no motor's",
                "--counts, and that the encoder sits firmly on the shaft",
            )  # fmt: skip
        apart = abs(turn.forward.value - turn.backward.value)
        if apart > SAME * k_t + SIGMA * math.hypot(turn.forward.sd, turn.backward.sd):
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
        by_r = winding.ohm.value / expected.R_ohm
        by_k = turn.k_t.value / expected.k_t
        if abs(by_r - 1.0) > R_PART:
            raise NotPlausible(
                "wrong motor", f"R is {by_r:.2f} times what was expected",
                "the motor's type and wires, the shunt and the bus",
            )  # fmt: skip
        if abs(by_k - 1.0) > K_PART:
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
        if not inductances.LEAST_H < found.value < inductances.MOST_H:
            raise NotPlausible(
                "inductance", f"L is {found.value:.3g} H", "the current's amplifier and its filter"
            )
        expected = self._expected
        if expected is not None and abs(found.value / expected.L_h - 1.0) > L_PART:
            raise NotPlausible(
                "wrong motor", f"L is {found.value / expected.L_h:.2f} times what was expected",
                "the motor's type, and filters in its leads",
            )  # fmt: skip
        self._tell(f"L: {1e3 * found.value:.4g} ± {1e3 * found.sd:.2g} mH")
        return found

    # ---- Coasting.

    def _coast_all(self) -> None:
        driver = self._driver
        pulse = self._pulses[-1]
        spin_s = pulse.step_s * len(pulse.position)
        driver.loop(self._r_hat, self._a)
        self._tell(f"coasting: {2 * COASTS} times")
        for n in self._staged("coasting", 2 * COASTS):
            # From two speeds, or viscous friction couldn't be told from the other.
            amps = self._sign(n) * self._amps * LEVELS[n // 2 % len(LEVELS)]
            driver.release()
            driver.record(amps, spin_s, PULSE_ROWS)
            seconds = MOST_COAST_S
            travel = self._wishes.travel_rad
            if travel is not None:
                fast = self._slow * (spin_s + EXCHANGES_LATE * driver.exchange_s)
                seconds = min(seconds, ROOM * travel / fast)
            driver.record_free(seconds, COAST_ROWS, amps)
            driver.brake(self._eta)
            self._coasts.append(self._fetched())

    def _mechanics(self, turn: BackEmf) -> Mechanics:
        found = mechanics([*self._pulses, *self._coasts], turn.k_t, self._cell)
        if found is None or not LEAST_J < found.inertia.value < MOST_J:
            raise NotPlausible(
                "inertia", "the rotor's motion doesn't follow the current",
                "what the shaft is coupled to; it has to turn freely",
            )  # fmt: skip
        expected = self._expected
        if expected is not None and found.inertia.value < (1.0 - J_PART) * expected.J_kgm2:
            raise NotPlausible(
                "inertia",
                f"J is {found.inertia.value / expected.J_kgm2:.2f} times the rotor's own",
                "--counts and the motor's type",
            )  # fmt: skip
        found = self._sampling.mechanics(found)
        friction = found.coulomb
        self._tell(f"J: {found.inertia.value:.3g} ± {found.inertia.sd:.1g} kg·m², friction "
                   f"{1e3 * friction.value:.2g} ± {1e3 * friction.sd:.1g} mN·m")  # fmt: skip
        return found
