# SPDX-License-Identifier: Apache-2.0
"""A brushless motor behind what an identification's driver does, without words, line or RTL.

The bridge's port is a proportional current source in the stationary frame, with the voltage's
limit that of each axis. Complex numbers are α + jβ. L_d that isn't L_q is so for a rotor that
stands.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
from wavehaptics.host.identify.segments import Segment

_TURN = cmath.rect(1.0, 2.0 * math.pi / 3.0)
_STEP_S = 20e-6


@dataclass
class Wiring:
    """How it is wired: sensors that are swapped or reversed, a lead that is open, and so on."""

    swapped: bool = False
    reversed: bool = False
    open_lead: int | None = None
    encoder: int = 1
    counts: int = 40_000


class QuickBrushless:
    """A driver of a motor of R, L, ψ, p and J, with magnets at ``place``; friction is Coulomb's."""

    brushless = arms = anchored = True
    running = False
    full_scale_a, limit_v, tick_s, extra_ticks, exchange_s = 2.0, 6.0, 40e-6, 1, 1e-3
    pulse_s, beyond_a = 1e-6, 3.0

    def __init__(
        self, ohm: float = 4.7, henry: float = 0.96e-3, pairs: int = 7, flux: float = 3.82e-3,
        inertia: float = 2.3e-6, place: float = 0.3, friction: float = 0.5e-3,
        d_part: float = 1.0, offset_a: float = 4e-3, noise_a: float = 0.5e-3,
        wiring: Wiring | None = None,
    ) -> None:  # fmt: skip
        self._ohm, self._henry, self._pairs, self._flux = ohm, henry, pairs, flux
        self._d_part = d_part
        self._inertia, self._place, self._friction = inertia, place, friction
        self._offset_a, self._noise_a = offset_a, noise_a
        self._wiring = wiring or Wiring()
        self._rng = np.random.default_rng(1)
        self._i, self._x, self._omega = 0j, 0.0, 0.0
        self._target: complex | None = None
        self._gain, self._most_v = 1.0, self.limit_v
        self.armed = False
        self.given: tuple[int, int, float] | None = None

    def __enter__(self) -> QuickBrushless:
        return self

    def __exit__(self, *_: object) -> None:
        self.armed = False

    # ---- The motor.

    def _leads(self, vector: complex) -> complex:
        """A voltage as the winding gets it where a lead is open: across the other two."""
        lead = self._wiring.open_lead
        if lead is None:
            return vector
        axis = 1j * _TURN**lead
        return axis * (vector * axis.conjugate()).real

    def _sensed(self, current: complex) -> complex:
        """What the sensors of a and b make of it."""
        parts = [(current * _TURN**-n).real for n in range(2)]
        a, b = parts[::-1] if self._wiring.swapped else parts
        seen = complex(a, (a + 2.0 * b) / math.sqrt(3.0))
        return -seen if self._wiring.reversed else seen

    def _move(self) -> complex:
        """A step; the voltage."""
        theta = self._pairs * (self._x - self._place)
        volts = 0j
        if self._target is not None:
            volts = self._gain * (self._target - self._sensed(self._i)) + self._ohm * self._target
        most = self._most_v
        volts = complex(min(max(volts.real, -most), most), min(max(volts.imag, -most), most))
        emf = 1j * self._flux * self._pairs * self._omega * cmath.exp(1j * theta)
        drives = self._leads(volts - emf)
        self._i = self._leads(self._i)
        left = (drives / self._ohm - self._i) * cmath.exp(-1j * theta)
        to_q = -math.expm1(-self._ohm / self._henry * _STEP_S)
        to_d = -math.expm1(-self._ohm / (self._d_part * self._henry) * _STEP_S)
        self._i += complex(to_d * left.real, to_q * left.imag) * cmath.exp(1j * theta)
        torque = 1.5 * self._pairs * self._flux * (self._i * cmath.exp(-1j * theta)).imag
        before = self._omega
        if before == 0.0 and abs(torque) < self._friction:
            return volts
        way = math.copysign(1.0, before or torque)
        self._omega += (torque - way * self._friction) / self._inertia * _STEP_S
        if before * self._omega < 0.0:
            self._omega = 0.0
        self._x += 0.5 * (before + self._omega) * _STEP_S
        return volts

    def _run(self, seconds: float) -> None:
        for _ in range(max(1, round(seconds / _STEP_S))):
            self._move()

    def _noise(self) -> complex:
        parts = self._rng.standard_normal(2) @ (1.0, 1j)
        return complex(self._noise_a * parts + self._offset_a * (1 + 1j * math.sqrt(3.0)))

    # ---- What an identification does with it.

    def measure_cells(self, cell_rad: float) -> None:
        self._cell = cell_rad

    def measure_exchange(self) -> None:
        pass

    def most_current(self) -> float:
        return 0.4 * self.full_scale_a

    def prepare(self) -> None:
        self._target = None

    def currents(self, count: int) -> np.ndarray:
        return np.array([self._noise() for _ in range(count)])

    def arm(self) -> None:
        self.armed = True
        self._zero = self._offset_a * (1 + 1j * math.sqrt(3.0))

    def disarm(self) -> None:
        self.armed, self._i = False, 0j

    def loop(self, r_hat: float, a: float, limit_v: float | None = None) -> None:
        del a
        self._gain, self._most_v = 20.0 * r_hat, limit_v or self.limit_v

    def release(self) -> None:
        self._target = 0j

    def brake(self, eta: float) -> None:
        del eta
        self._target = 0j
        self._gain, gain = 0.0, self._gain
        self._run(self.exchange_s)
        self._gain = gain

    def push(self, amps: complex) -> None:
        self._target = amps

    def linger(self, seconds: float) -> None:
        self._run(seconds)

    def still(self) -> bool:
        for _ in range(200):
            self._omega *= 0.5
            self._run(1e-3)
            if abs(self._omega) < 1e-2:
                return True
        return False

    def place(self) -> float:
        return self._cell * self._count()

    def _count(self) -> int:
        return math.floor(self._wiring.encoder * self._x / (2.0 * math.pi / self._wiring.counts))

    def record(
        self, amps: complex, seconds: float, rows: int, wanted: float | None = None
    ) -> None:  # fmt: skip
        self._target = amps
        self._rows(seconds, rows, abs(amps) if wanted is None else wanted)

    def record_free(self, seconds: float, rows: int, wanted: float) -> None:
        self._target = 0j
        self._rows(seconds, rows, wanted)

    def _rows(self, seconds: float, rows: int, wanted: float) -> None:
        each = max(2, round(seconds / rows / _STEP_S))
        voltage, current, position = [], [], []
        for _ in range(rows):
            volts, amps = 0j, 0j
            for _ in range(each):
                before = self._i
                volts += self._move()
                amps += self._sensed(0.5 * (before + self._i))
            voltage.append(volts / each)
            current.append(amps / each + self._noise() - self._zero)
            position.append(self._cell * self._count())
        self._record = Segment(
            each * _STEP_S, np.array(voltage), np.array(current), np.array(position), wanted
        )  # fmt: skip

    def fetch(self) -> Segment:
        return self._record

    def give_magnets(self, pole_pairs: int, counts: int, magnet_rad: float) -> bool:
        assert not self.armed
        self.given = pole_pairs, counts, magnet_rad
        return True
