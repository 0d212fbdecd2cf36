# SPDX-License-Identifier: Apache-2.0
"""What the identifications of both kinds of motors share: their order, limits, and first checks.

docs/identify.md says what each step measures, and how.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from wavehaptics.host.identify import inductance as inductances
from wavehaptics.host.identify import resistance as resistances
from wavehaptics.host.identify import zero
from wavehaptics.host.identify.driver import Driver, OffError
from wavehaptics.host.identify.mechanics import LEAST_J, MOST_J, Mechanics
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

STOPS = 8
"""Waits for a rotor that a sign needs at rest."""

SIGMA = 4.0
"""Spreads that two values may be apart."""

MOST_SPREAD = 0.3
"""Spread of J that is none, of J."""

R_PART, L_PART, K_PART, J_PART = 0.35, 0.5, 0.15, 0.6
"""By how much a motor may differ from what was expected: R of a warm one with its wires, the
inductance at another frequency, k_T of a lot, J with what is fixed to the shaft."""


class NotPlausible(HostError):
    """A step that found what can't be: its name, what was found and what to check."""

    def __init__(self, fault: str, found: str, check: str) -> None:
        self.fault = fault
        super().__init__(f"{fault}: {found}; check {check}")


@dataclass(frozen=True)
class Wishes:
    """What a user says: counts a revolution, test current, room to turn, the motor to expect.

    ``signs``: only whether current and encoder have the right sign.
    """

    counts: int
    current_a: float | None = None
    travel_rad: float | None = None
    expected: MotorConstants | BrushlessConstants | None = None
    signs: bool = False


Constants = TypeVar("Constants", MotorConstants, BrushlessConstants)


def _expected(wishes: Wishes, kind: type[Constants]) -> Constants | None:
    """The motor that is expected; :class:`HostError` where it is none of the device's kind."""
    expected = wishes.expected
    if expected is None or isinstance(expected, kind):
        return expected
    drives = "a brushless motor" if kind is BrushlessConstants else "a motor with brushes"
    raise HostError(f"--expect: the device drives {drives}; name one, or leave it out")


Told = Callable[[str], None]
Shown = Callable[[str, float], None]


class Steps(ABC, Generic[Constants]):
    """:meth:`record` with the bridges on, then ``estimate`` what the records tell."""

    def __init__(
        self, driver: Driver, wishes: Wishes, tell: Told, show: Shown, kind: type[Constants]
    ) -> None:
        self._driver, self._wishes, self._tell, self._show = driver, wishes, tell, show
        self._expected: Constants | None = _expected(wishes, kind)
        self._cell = 2 * math.pi / wishes.counts
        self._pulses: list[Segment] = []
        self._coasts: list[Segment] = []
        self._steps: list[Segment] = []
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
        if not driver.arms:  # whose rotor has been free
            driver.brake(0.0)
        self._show("zero", 1.0)
        try:
            self._try_signs()
            if not self._wishes.signs:
                self._excite()
        except OffError as error:
            if len(self._steps) < 2 and error.faults:
                raise shorted(str(error)) from None
            raise

    @abstractmethod
    def _try_signs(self) -> None:
        """The first records, ``_steps`` before all others: they tell a wrong sign."""

    @abstractmethod
    def _excite(self) -> None:
        """The other records."""

    def _staged(self, stage: str, count: int) -> Iterator[int]:
        """Numbers of a stage's records, shown as they are done."""
        for n in range(count):
            self._show(stage, n / count)
            yield n
        self._show(stage, 1.0)

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

    def _step(self, volts: complex, r_hat: float, seconds: float = 0.0) -> Segment:
        """A voltage from rest on."""
        driver, size = self._driver, abs(volts)
        self._stand()
        driver.loop(r_hat, 0.5, size)
        driver.release()
        driver.record(
            driver.beyond_a * volts / size, max(seconds, STEP_ROWS * driver.tick_s), STEP_ROWS,
            volts.real,
        )  # fmt: skip
        driver.brake(0.0)
        return self._fetched()

    def _stand(self) -> None:
        """Wait until the rotor stands, whose own back-EMF or way would be taken for a sign."""
        still = self._driver.still()
        if self._steps and not self._wishes.signs:
            return
        if not still and not any(self._driver.still() for _ in range(STOPS - 1)):
            raise NotPlausible(
                "turning", "the rotor doesn't come to rest",
                "that nothing drives the shaft; let a large inertia stop first, or take it off",
            )  # fmt: skip

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

    @property
    def _nothing(self) -> float:
        """A step's smoothed current that is none, A."""
        return max(NOTHING * self._amps, SIGMA * self._offset.sd / math.sqrt(SMOOTH))

    def _regulate(self) -> None:
        """The port as a source of current, by R and L as they are known roughly."""
        driver = self._driver
        self._r_hat = R_HAT_PART * self._ohm
        a = min(self._ohm / self._henry * driver.tick_s, 0.1 / (driver.extra_ticks + 1))
        driver.loop(self._r_hat, a)

    def _cells(self, segments: list[Segment]) -> float:
        """By how many cells the rotor moves in a record, at most."""
        return max(float(np.ptp(s.position)) for s in segments) / self._cell

    def _at_rest(self, cells: float, turns: bool) -> NotPlausible:
        """For a rotor that moves by so few cells; ``turns`` is what the voltage tells."""
        if turns:
            return NotPlausible(
                "encoder silent", f"the motor turns, and the encoder tells {cells:.0f} counts",
                "the encoder's plug, its supply, and A and B each, or allow more by --current",
            )  # fmt: skip
        return NotPlausible(
            "jammed", f"the rotor moves by {cells:.0f} counts at {self._amps:.2g} A",
            "what holds the shaft, or allow more by --current",
        )  # fmt: skip

    def _check_ohm(self, ohm: float) -> None:
        if ohm < resistances.LEAST_OHM:
            raise shorted(f"R is {ohm:.2g} Ω")
        if ohm > resistances.MOST_OHM:
            raise NotPlausible(
                "no motor", f"R is {ohm:.3g} Ω", "the motor's leads, brushes and commutator"
            )

    def _know_roughly(self, first: resistances.Resistance) -> None:
        """The first R and L, and the test current that the voltage's limit leaves."""
        self._check_ohm(first.ohm.value)
        self._ohm = first.ohm.value
        self._henry = min(max(first.inductance.value, inductances.LEAST_H), inductances.MOST_H)
        if self._wishes.current_a is None:
            self._amps = min(self._amps, PART_OF_LIMIT * self._driver.limit_v / self._ohm)
            if self._amps < LEAST_OF_NOISE * self._offset.sd:
                raise HostError(
                    f"the voltage's limit leaves a test current of {self._amps:.2g} A, too little "
                    f"beside the sensor's noise of {self._offset.sd:.2g} A; raise u_max"
                )
        self._tell(f"sign: right; R about {self._ohm:.2g} Ω, test current {self._amps:.2g} A")

    def _check_henry(self, henry: float) -> None:
        if not inductances.LEAST_H < henry < inductances.MOST_H:
            raise NotPlausible(
                "inductance", f"L is {henry:.3g} H", "the current's amplifier and its filter"
            )
        if self._expected is not None and abs(henry / self._expected.L_h - 1.0) > L_PART:
            raise NotPlausible(
                "wrong motor", f"L is {henry / self._expected.L_h:.2f} times what was expected",
                "the motor's type, and filters in its leads",
            )  # fmt: skip

    def _check_expected_ohm(self, ohm: float) -> None:
        if self._expected is not None and abs(ohm / self._expected.R_ohm - 1.0) > R_PART:
            raise NotPlausible(
                "wrong motor", f"R is {ohm / self._expected.R_ohm:.2f} times what was expected",
                "the motor's type and wires, the shunt and the bus",
            )  # fmt: skip

    def _checked_motion(self, found: Mechanics | None) -> Mechanics:
        if found is None or not LEAST_J < found.inertia.value < MOST_J:
            raise NotPlausible(
                "inertia", "the rotor's motion doesn't follow the current",
                "what the shaft is coupled to; it has to turn freely",
            )  # fmt: skip
        if found.inertia.sd > MOST_SPREAD * found.inertia.value:
            raise NotPlausible(
                "inertia", f"J is {found.inertia.value:.2g} ± {found.inertia.sd:.1g} kg·m²",
                "what holds or moves the shaft; it has to turn freely, without a hand",
            )  # fmt: skip
        expected = self._expected
        if expected is not None and found.inertia.value < (1.0 - J_PART) * expected.J_kgm2:
            raise NotPlausible(
                "inertia",
                f"J is {found.inertia.value / expected.J_kgm2:.2f} times the rotor's own",
                "--counts and the motor's type",
            )  # fmt: skip
        friction = found.coulomb
        self._tell(f"J: {found.inertia.value:.3g} ± {found.inertia.sd:.1g} kg·m², friction "
                   f"{1e3 * friction.value:.2g} ± {1e3 * friction.sd:.1g} mN·m")  # fmt: skip
        return found


def smooth_peak(step: Segment) -> complex:
    """The largest of a step's currents, A, each a mean of SMOOTH rows; of vectors by their size."""
    smooth = np.convolve(step.current, np.full(SMOOTH, 1.0 / SMOOTH), "valid")
    return complex(smooth[np.argmax(np.abs(smooth))])


def shorted(found: str) -> NotPlausible:
    """Of too much current."""
    return NotPlausible(
        "shorted", found, "the motor's leads against each other and against the case"
    )
