# SPDX-License-Identifier: Apache-2.0
"""A device's bridge as a source of current or voltage, by its words alone.

In free space, η = 1, the waves hold the current at zero as the sensor has it. A word ``zero`` that
is shifted by I is a sensor that shows −I where nothing flows: so the waves hold the motor's
current at I, with a bandwidth that R̂ and λ set. Shifted beyond all currents it is a voltage at its
limit, which u_max sets. With η < 1 the port is a resistor, which brakes.

A brushless motor is two ports, whose currents and voltages are one complex number each here,
α + jβ; what is shifted are the zeros of the phases a and b.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from types import TracebackType
from typing import Any, Protocol, cast

import numpy as np

from wavehaptics.controller.rotor_flux import count_word, zero_word
from wavehaptics.controller.tick_layout import position_late_clocks
from wavehaptics.host import capture
from wavehaptics.host.client import Client, Identification
from wavehaptics.host.identify.segments import Segment, earlier
from wavehaptics.host.names import HostError, Place, Shape, places
from wavehaptics.laws import closed_forms
from wavehaptics.parts.adcs import FRAME_WORDS, KINDS, Frame, frame_of_words
from wavehaptics.runtime.ends import ending
from wavehaptics.words import formats
from wavehaptics.words.bridge_modes import MODE_WORDS, UNIPOLAR
from wavehaptics.words.faults import FAULTS, arm_refusal, bits_of
from wavehaptics.words.table import AXES, WORDS

RENEWAL_S = 0.04
"""Time after which the arming is renewed."""

WAIT_S = 20.0
"""Wall-clock time without a tick after which there are none."""

READINGS = 8
"""Exchanges whose time is measured."""

LOOKS_A_CHECK = 8
"""Looks at a capture from one look to the next whether the bridges are on."""

STILL_S = 20e-3
LONGEST_STOP_S = 0.5
"""Time without a count after which a rotor that is braked stands, and the longest wait for that."""

CHANNELS = ("current", "u", "position")
_LAYOUT = ("half_clocks", "tick_halves", "sample_clocks", "samples", "filter_clocks")
_BEFORE = 1
_TRIES = 10
_FULL_SCALE = 1 << (formats.SAMPLE_W - 1)
_BEYOND = 1.5
"""Shift that is beyond all currents, of full scale."""
_MOST_SHIFT_A = 30.0
_PART_OF_SCALE = 0.4
_PART_OF_TRIP = 0.6
"""Largest currents, of the converter's scale and of what switches off."""

TRIGGER_PART = 0.1
"""Of a shift, which the waves make good within a row or two."""

_WAVES = ("root", "a", "u_max")
_RESTORED = ("zero", "eta_contact", "eta_free", *_WAVES, "wall_enable", *capture.SETTINGS)


class Device(Protocol):
    """What is needed of a :class:`~wavehaptics.host.client.Client`."""

    identification: Identification

    @property
    def shape(self) -> Shape:
        """Its number of motors and of copies of words."""

    def read(self, places: Iterable[Place]) -> list[int]:
        """Raw words without signs."""

    def write(self, words: Iterable[tuple[Place, int]]) -> int:
        """Write raw words."""

    def hurry(self) -> AbstractContextManager[Any]:
        """Exchanges at the fastest rate."""


class Driver:
    """A motor of a device, whose settings come back at the end. A context.

    ``full_scale_a``, ``limit_v``, ``lambda_a`` (the λ filter's coefficient), ``extra_ticks``,
    ``dead_time_volt_s`` (what is made good of it, V·s) and ``pulse_s`` (the time in which the
    bridge makes one) are the device's as it was found.
    ``restored`` says whether they have come back.
    ``clock`` gives the seconds by which the arming is renewed. It stands for a client as well, and
    renews before each exchange. Once ``ended`` says so, the next exchange is :class:`EndedError`;
    those that switch off and give the settings back are made all the same.
    """

    def __init__(
        self,
        device: Device,
        motor: int = 0,
        clock: Callable[[], float] = time.monotonic,
        ended: Callable[[], bool] = lambda: False,
    ) -> None:
        self._device, self._motor, self._clock, self._ended = device, motor, clock, ended
        self._armed = False
        self.restored = True
        self._renewed = 0.0
        self._as_client = cast(Client, self)
        self.identification = device.identification
        options = device.identification.options
        self.arms, self.anchored = bool(options["arm"]), bool(options["anchor"])
        self.brushless = device.identification.brushless
        self._sensors = range(motor, motor + (AXES if self.brushless else 1))
        capture.depth(self._as_client)
        self.tick_s = capture.tick_s(self._as_client)
        restored = [*_RESTORED, *(["anchor_enable"] if self.anchored else [])]
        self._kept = [place for name in restored for place in self._all_places(name)]
        self._before = device.read(self._kept)
        self._gains_a = [self._value(place) for place in self._all_places("gain")]
        self._zeros = [round(self._value(place)) for place in self._all_places("zero")]
        layout = self._layout()
        made = self._frame(layout)
        self._unity = made.unity
        samples = self.value("samples")
        self.full_scale_a = min(self._gains_a) * samples * _FULL_SCALE * self._unity
        self.limit_v = self.value("root") * self.value("u_max")
        self.lambda_a = self.value("a")
        self.extra_ticks = round(self.value("extra_ticks"))
        self.adc_bits = round(self.value("data_bits"))
        lost_s = self.value("dead_clocks") / device.identification.words["clock_hz"]
        half = self.value("half_clocks")
        bus_v = half / (2.0 * max(self.value("clocks_per_volt"), formats.DUTY.step))
        self.dead_time_volt_s = lost_s * bus_v if self.value("compensate") else 0.0
        unipolar = not options["modes"] or self.value("mode") == MODE_WORDS[UNIPOLAR]
        self.pulse_s = (1.0 if unipolar else 2.0) * half / device.identification.words["clock_hz"]
        self._late_s = self._position_late_s(layout, made)
        self._shifts = [0 for _ in self._zeros]
        self._shift_a: complex = 0.0
        self._root = 1.0
        self._cell_rad = 1.0
        self.exchange_s = 0.0

    def _layout(self) -> dict[str, int]:
        """How ticks and frames are laid on the clock: raw words without signs."""
        names = (*_LAYOUT, *FRAME_WORDS)
        raws = self.read([self._places(name)[0] for name in names])
        return dict(zip(names, raws, strict=True))

    def _frame(self, words: Mapping[str, int]) -> Frame:
        """The converter's frame."""
        kind = KINDS[self.identification.options["adc"]]
        return frame_of_words(words, kind, words["sample_clocks"])

    def _position_late_s(self, words: Mapping[str, int], made: Frame) -> float:
        """By how much a row's position is younger than the row's end."""
        identification = self.identification
        lead = self.value("sample_lead")  # which has a sign
        late = position_late_clocks(
            words["half_clocks"] * words["tick_halves"],
            words["samples"],
            round(lead),
            made,
            words["filter_clocks"],
            self._motor,
            identification.options["shaper"],
            self.brushless,
        )
        return late / identification.words["clock_hz"]

    @property
    def shape(self) -> Shape:
        """The device's."""
        return self._device.shape

    @property
    def before(self) -> list[tuple[Place, int]]:
        """The settings that come back, as they were found: raw words without signs."""
        return list(zip(self._kept, self._before, strict=True))

    def __enter__(self) -> Driver:
        self.restored = False
        self._line = ExitStack()
        self._line.enter_context(self._device.hurry())
        # Also where the bridges stay on: to give the settings back is what ends the current then.
        self._line.enter_context(ending(self.disarm, self._restore))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """The bridges off, or without a current, and the settings as they were.

        To be asked to end is no error: what goes wrong here comes before it.
        """
        if isinstance(error, EndedError):
            self._line.close()
        else:
            self._line.__exit__(kind, error, trace)

    def _restore(self) -> None:
        self._device.write(
            (place, raw - (1 << 32) if place.word.fixed.signed and raw >> 31 else raw)
            for place, raw in self.before
        )
        self.restored = True

    # ---- Exchanges, which renew.

    def read(self, places: Iterable[Place]) -> list[int]:
        """As the client's."""
        self._renew()
        return self._device.read(places)

    def write(self, words: Iterable[tuple[Place, int]]) -> int:
        """As the client's."""
        self._renew()
        return self._device.write(words)

    def hurry(self) -> AbstractContextManager[Any]:
        """As the client's, whose port is kept all the time."""
        return nullcontext()

    def _renew(self) -> None:
        if self._ended():
            raise EndedError("stopped before the end")
        if self.arms and self._armed and self._clock() - self._renewed > RENEWAL_S:
            self._renewed = self._clock()
            self._device.write([(self._places("arm")[0], 2)])

    def _places(self, name: str) -> list[Place]:
        return places(name, self.shape, self._motor)

    def _all_places(self, name: str) -> list[Place]:
        """Those of every sensor, where a word has so many."""
        shape = self.shape
        owners = [n for n in self._sensors if n in shape.has(WORDS[name])] or [self._motor]
        return [place for n in owners for place in places(name, shape, n)]

    def value(self, name: str) -> float:
        """A word in SI units."""
        return self._value(self._places(name)[0])

    def _value(self, place: Place) -> float:
        return place.value(self.read([place])[0])

    def _set(self, **values: float) -> None:
        self.write((p, p.raw(value)) for n, value in values.items() for p in self._places(n))

    # ---- Limits.

    def most_current(self) -> float:
        """Largest test current that the board's settings permit, A."""
        least = _PART_OF_SCALE * self.full_scale_a
        for name, unity in (("trip", 1.0), ("guard_current", self._unity)):
            part = self.value(name) / (unity * _FULL_SCALE)
            if 0.0 < part <= 1.0:
                least = min(least, _PART_OF_TRIP * part * self.full_scale_a)
        heat = self.value("guard_heat")
        return min(least, math.sqrt(heat)) if heat > 0.0 else least

    # ---- The bridges.

    @property
    def running(self) -> bool:
        """Whether the bridges are on."""
        return bool(self.value("running"))

    def measure_exchange(self) -> None:
        """How long an exchange takes, on the device's clock."""
        ticks = [self.value("ticks") for _ in range(READINGS)]
        self.exchange_s = (ticks[-1] - ticks[0]) % (1 << 32) * self.tick_s / (READINGS - 1)

    def prepare(self) -> None:
        """No walls, no anchor, no current; the bridges have to be off where the line arms them."""
        running = self.running
        if self.arms and running:
            raise HostError("the bridges are on; `board disarm` first, and end who renews it")
        if not self.arms and not running:
            raise HostError(
                "the bridges are off, and the line can't arm this board; press its start button"
            )
        if self.anchored:
            self._set(anchor_enable=0)
        self._set(wall_enable=0)
        self._set(eta_contact=0.0, eta_free=0.0)

    def arm(self) -> None:
        """The bridges on; the device measures its zero before."""
        if not self.arms:
            return
        # Before, as it may be heard where its answer isn't, and is then to be taken back.
        self._armed, self._renewed = True, self._clock()
        self._device.write([(self._places("arm")[0], 1)])
        self._renewed = self._clock()
        until = time.monotonic() + WAIT_S
        while not self.running:
            refused = round(self.value("arm_refused"))
            if refused or time.monotonic() > until:
                raise HostError(
                    f"not armed: {arm_refusal(refused) or 'the zero takes too long'}; "
                    "`board faults` tells more"
                )

    def disarm(self) -> None:
        """The bridges off, where the line has armed them."""
        if self._armed:
            self._armed = False
            self._device.write([(self._places("arm")[0], 0)])

    def check(self) -> None:
        """:class:`HostError` with what switched the bridges off, if they are."""
        if self.running:
            return
        self._armed = False
        raise OffError(round(self.value("faults")), round(self.value("arm_refused")))

    # ---- Sources.

    def loop(self, r_hat: float, a: float, limit_v: float | None = None) -> None:
        """Waves of R̂ in Ω, the λ filter's coefficient, and the voltage's limit."""
        limit_v = self.limit_v if limit_v is None else min(limit_v, self.limit_v)
        self._root = formats.ROOT.to_value(formats.ROOT.to_raw(closed_forms.root(r_hat)))
        self._set(root=self._root, a=a, u_max=min(limit_v / self._root, formats.WAVE.largest))

    def release(self) -> None:
        """Free space without a current."""
        self.push(0.0)
        self._set(eta_contact=1.0, eta_free=1.0)

    def brake(self, eta: float) -> None:
        """A resistor, with no current of its own."""
        self._set(eta_contact=eta, eta_free=eta)
        self.push(0.0)

    def push(self, amps: complex) -> None:
        """A current from now on, A, of a port that :meth:`release` has made.

        That of a phase after that of another, some exchanges apart.
        """
        phases = _to_phases(amps)[: len(self._zeros)]
        shifts = [round(i / gain) for i, gain in zip(phases, self._gains_a, strict=True)]
        words = zip(self._all_places("zero"), self._zeros, shifts, self._shifts, strict=True)
        changed = [(p, p.raw(zero + new)) for p, zero, new, old in words if new != old]
        if changed:
            self.write(changed)
        self._shifts = shifts
        shifted = [shift * gain for shift, gain in zip(shifts, self._gains_a, strict=True)]
        self._shift_a = _from_phases(*shifted)

    @property
    def beyond_a(self) -> float:
        """A shift that no current reaches."""
        return min(_BEYOND * self.full_scale_a, _MOST_SHIFT_A)

    def give_magnets(self, pole_pairs: int, counts: int, magnet_rad: float) -> bool:
        """Tell the device its electrical angle, in place of a search; the bridges have to be off.

        Whether the rotor stood still meanwhile; if not, the device's own are as before, and what it
        searches it searches anew.
        """
        cell_rad = 2.0 * math.pi / counts
        found = [self._places(name)[0] for name in ("count_angle", "zero_angle", "find_magnet")]
        before = self.read(found)
        for _ in range(_TRIES):
            position = round(self.value("position"))
            zero = zero_word(pole_pairs, cell_rad, magnet_rad, position)
            self._set(count_angle=count_word(pole_pairs, cell_rad), zero_angle=zero, find_magnet=0)
            self._set(magnet_start=1)
            if round(self.value("position")) == position:
                return True
        self.write(zip(found, before, strict=True))
        self._set(magnet_start=1)
        return False

    # ---- Records.

    def measure_cells(self, cell_rad: float) -> None:
        """How large a cell of the encoder is, rad."""
        self._cell_rad = cell_rad

    def currents(self, count: int) -> np.ndarray:
        """Readings of the current, A."""
        found = self._all_places("current")
        readings = [
            [place.value(raw) for place, raw in zip(found, self.read(found), strict=True)]
            for _ in range(count)
        ]
        return _axes([*np.array(readings).T])

    def _plan_for(self, seconds: float, rows: int, before: int, trigger: str) -> capture.Plan:
        """Up to ``rows`` rows that last ``seconds``, and so many before a trigger."""
        decimation = 1
        while decimation * rows * self.tick_s < seconds:
            decimation *= 2
        kept = max(8, min(rows, math.ceil(seconds / (decimation * self.tick_s))))
        return capture.plan(
            self._as_client, self._channels, rows=kept + before, decimation=decimation,
            before=before, trigger=trigger, motor=self._motor,
        )  # fmt: skip

    def _wait(self, state: int) -> None:
        """Until a capture is so far. A pulse goes on meanwhile: there is no pause between looks."""
        state_at, ticks_at = (places(name, self.shape)[0] for name in ("capture_state", "ticks"))
        last, since = -1, time.monotonic()
        for look in itertools.count(1):
            if self.read([state_at])[0] >= state:
                return
            if look % LOOKS_A_CHECK:
                continue
            self.check()
            ticks = self.read([ticks_at])[0]
            if ticks != last:
                last, since = ticks, time.monotonic()
            elif time.monotonic() - since > WAIT_S:
                raise HostError("there are no ticks; is the ADC there? `board info` tells its kind")

    @property
    def _channels(self) -> list[str]:
        if not self.brushless:
            return [*CHANNELS]
        return [f"{name}@{axis}" for name in CHANNELS[:2] for axis in self._sensors] + ["position"]

    def record(self, amps: complex, seconds: float, rows: int, wanted: float | None = None) -> None:
        """The current's target from none to ``amps``, and a record of what follows.

        What is aimed at stays; who calls ends it, and downloads by :meth:`fetch` after that.
        ``wanted`` is what the record is said to be of, if not the current.
        """
        parts = [amps.real, amps.imag]
        axis = int(abs(amps.imag) > abs(amps.real))
        level = -TRIGGER_PART * parts[axis]
        name = f"current@{self._motor + axis}" if self.brushless else "current"
        plan = self._plan_for(
            seconds, rows, _BEFORE, f"{name}{'>' if level > 0 else '<'}{level:.6g}"
        )
        capture.start(self._as_client, plan)
        self._wait(capture.WAITS)
        self.push(amps)
        self._wait(capture.DONE)
        # A row of several ticks has the shift in it somewhere.
        self._recorded(plan, parts[axis] if wanted is None else wanted, plan.decimation > 1)

    def record_free(self, seconds: float, rows: int, wanted: float) -> None:
        """No current from now on, and a record of how the rotor coasts."""
        self.push(0.0)
        plan = self._plan_for(seconds, rows, 0, "now")
        capture.start(self._as_client, plan)
        self._wait(capture.DONE)
        self._recorded(plan, wanted, False)

    def _recorded(self, plan: capture.Plan, wanted: float, skipped: bool) -> None:
        self._plan, self._wanted, self._skipped = plan, wanted, int(skipped)
        self._recorded_a = self._shift_a

    def place(self) -> float:
        """Where the rotor is, rad."""
        return self._cell_rad * self.value("position")

    def linger(self, seconds: float) -> None:
        """Exchanges that last as long, on the device's clock, and one at least."""
        for _ in range(max(1, round(seconds / self.exchange_s))):
            self.value("running")

    def still(self) -> bool:
        """Wait until the rotor stands, or no longer than it may take; whether it does."""
        place = self._places("position")[0]
        rest, until = 0.0, LONGEST_STOP_S
        was = place.value(self.read([place])[0])
        while rest < STILL_S and until > 0.0:
            position = place.value(self.read([place])[0])
            rest += self.exchange_s
            until -= self.exchange_s
            if abs(position - was) > 1:
                rest, was = 0.0, position
        return rest >= STILL_S

    def fetch(self) -> Segment:
        """The record that was made last."""
        self.check()
        found = capture.download(self._as_client, self._plan)
        assert found.trigger_row is not None
        first = found.trigger_row + self._skipped
        position = earlier(found["position"], self._late_s / self._plan.row_s)
        current, u = (
            _axes([found[c] for c in self._channels if c.partition("@")[0] == name])
            for name in CHANNELS[:2]
        )
        return Segment(
            self._plan.row_s,
            self._root * u[first:],
            current[first:] + self._recorded_a,
            self._cell_rad * position[first:],
            self._wanted,
        )


def _to_phases(amps: complex) -> tuple[float, float]:
    """Currents of the phases a and b for those of the axes; a motor with brushes has the first."""
    return amps.real, 0.5 * (math.sqrt(3.0) * amps.imag - amps.real)


def _from_phases(a: float, b: float | None = None) -> complex:
    return a if b is None else complex(a, (a + 2.0 * b) / math.sqrt(3.0))


def _axes(values: Sequence[np.ndarray]) -> np.ndarray:
    """A port's values, or those of two as complex numbers."""
    return values[0] if len(values) == 1 else values[0] + 1j * values[1]


class EndedError(HostError):
    """Somebody asked to end it."""


class OffError(HostError):
    """The bridges went off by themselves. ``faults`` are the guard's bits."""

    def __init__(self, faults: int, refused: int) -> None:
        self.faults = faults
        names = [FAULTS[bit][0] for bit in bits_of(faults)]
        reason = ", ".join(names) or arm_refusal(refused) or "the board's switch"
        super().__init__(f"the bridges went off: {reason}; `board faults` tells more")
