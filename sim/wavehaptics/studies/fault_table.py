# SPDX-License-Identifier: Apache-2.0
"""Every fault of the guard, caused in the running closed loop.

A bare rotor is on a wall of the stiffest setting (or turns freely, where the fault needs it), the
whole RTL at its pins holds it, and then something breaks. Measured is the time from there to the
gates' being off. ``python -m wavetools.cli.fault_table`` measures them and keeps the numbers
with which ``rtl/faults.md`` is filled; a test measures them again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from wavehaptics.controller.guard import SPAN, Fault, Limits
from wavehaptics.ladder.guarded_pins import GuardedPins, Injection
from wavehaptics.motor.plant import OMEGA, I
from wavehaptics.motor.sensor import OFFSET
from wavehaptics.scene import Scene

KEPT = Path("sim", "docs", "faults.json")
"""Where the rows are kept, from the root."""

BUS_V = 12.0
WARM_TICKS = 700
"""Ticks before the cause: the rotor is deep in the wall."""
SLACK_TICKS = 60


class Case(NamedTuple):
    """A fault, what causes it, and the clocks within which the gates must be off."""

    fault: Fault
    cause: str
    break_it: Callable[[GuardedPins], None]
    most_clocks: int
    limits: dict[str, Any] = {}  # noqa: RUF012
    free: bool = False
    limit_v: float = BUS_V
    motion: dict[str, Any] = {}  # noqa: RUF012
    """Limits of speed and position, as keys of ``[guard]``."""


def scene(free: bool = False, limit_v: float = BUS_V, **motion: Any) -> Scene:
    """The scene of every case: an impact at 10 rad/s on the stiffest wall, or none at all."""
    return Scene.model_validate(
        {
            "scene": {"name": "faults", "duration_s": 1.0},
            "motor": {"preset": "re25-118743"},
            "hand": {"path": "impact", "amplitude_rad": 1e-3, "speed_rad_s": 10.0},
            "encoder": {"counts_per_rev": 10_000},
            "adc": {"bits": 12, "full_scale_a": 4.0, "noise_a": 2e-3},
            "drive": {"bus_v": BUS_V, "limit_v": limit_v, "pwm_hz": 500e3},
            **({"guard": {"trip_a": 4.0, **motion}} if motion else {}),
            "controller": {
                "tick_hz": 1e6, "extra_ticks": 1, "lambda": 1e6,
                "walls": [] if free else [[0.0, 1.0]],
            },
        }
    )  # fmt: skip


def _inject(kind: Injection, value: int = 1) -> Callable[[GuardedPins], None]:
    return lambda pins: pins.inject(kind, value)


def _short(pins: GuardedPins) -> None:
    pins.motor[I] = 3.0
    pins.inject(Injection.OUTSIDE)


def _fast_trip(pins: GuardedPins) -> None:
    pins.inject(Injection.TRIP, 5 << 12)  # 2.5 of 4 A, of 2^15
    _short(pins)


def _offset(pins: GuardedPins) -> None:
    pins.inject(Injection.ENABLE, 0)
    pins.elapse(SLACK_TICKS)
    pins.sensor_words[OFFSET] = 0.05
    pins.inject(Injection.OUTSIDE)


def _too_large_r_hat(pins: GuardedPins) -> None:
    pins.inject(Injection.ROOT_WORD, round(math.sqrt(2.0) * pins.settings.root))


def _swung_at_the_limit(pins: GuardedPins) -> None:
    pins.sensor_words[OFFSET] = 0.5
    pins.inject(Injection.OUTSIDE)
    for swing in range(20):
        pins.motor[OMEGA] = -20.0 if swing % 2 else 25.0
        pins.elapse(300)


def _pushed(pins: GuardedPins) -> None:
    pins.motor[OMEGA] = 60.0
    pins.inject(Injection.OUTSIDE)


# A tick is 48 clocks, and a sample is taken in each: a conversion is over 29 clocks after it.
TICK_CLOCKS = 48
_PINS = 4  # two of the synchroniser, the latch, the gates
_SAMPLE = TICK_CLOCKS + 2 * 14 + 6

CASES = (
    Case(Fault.CURRENT, "3 A in the winding, limit 2.5 A", _short, _SAMPLE, {"current_a": 2.5}),
    Case(Fault.TRIP, "3 A in the winding, trip at 2.5 A", _fast_trip, _SAMPLE),
    Case(Fault.ADC_STUCK, "the ADC repeats its last frame, limit 50 samples",
         _inject(Injection.ADC_REPEATS), 50 * TICK_CLOCKS + _SAMPLE, {"stuck_samples": 50}),
    Case(Fault.ADC_RANGE, "the ADC's data line stays high", _inject(Injection.ADC_LEVEL), _SAMPLE),
    Case(Fault.ZERO, "50 mA of offset with the bridge off for 0.3 ms, limit 20 mA", _offset,
         400 * TICK_CLOCKS, {"zero_s": 300e-6}),
    Case(Fault.ENCODER, "A and B change at once", _inject(Injection.ENCODER_FLIPS), 8),
    Case(Fault.LOST, "the encoder's lines stand still at 10 rad/s, limit 2 ms",
         _inject(Injection.ENCODER_HOLDS), 2600 * TICK_CLOCKS, free=True),
    Case(Fault.HOST, "no sign of the host, limit 1 ms", _inject(Injection.HOST_SILENT),
         1001 * TICK_CLOCKS),
    Case(Fault.DRIVER, "the driver's fault pin", _inject(Injection.DRIVER, 0), _PINS),
    Case(Fault.STOP, "the emergency stop's pin", _inject(Injection.STOP, 0), _PINS),
    Case(Fault.BUS_LOW, "9 V of bus, limit 10 V", _inject(Injection.BUS, 9 << 9), 2),
    Case(Fault.BUS_HIGH, "15 V of bus, limit 14 V", _inject(Injection.BUS, 15 << 9), 2),
    Case(Fault.HEAT, "0.3 A where the winding carries 30 mA, time constant 65 ms",
         _inject(Injection.OUTSIDE), 1000 * TICK_CLOCKS,
         {"rms_a": 0.03, "winding_s": 65.536e-3}),
    Case(Fault.SETTING, "R̂ = 0", _inject(Injection.ROOT_WORD, 0), 3),
    Case(Fault.OVERRUN, "an ADC frame longer than a tick", _inject(Injection.SCLK_HALF, 3),
         4 * TICK_CLOCKS),
    Case(Fault.ANCHOR, "the anchor's fault input", _inject(Injection.ANCHOR), 2),
    Case(Fault.ENERGY, "R̂ is doubled in a contact, limit 5 A·counts", _too_large_r_hat,
         500 * TICK_CLOCKS, {"energy": 5.0}),
    Case(Fault.SATURATED,
         "0.5 A of offset at 1 V, a rotor that turns back each 0.3 ms, limit 1 ms",
         _swung_at_the_limit, 6000 * TICK_CLOCKS, {"saturated_s": 1e-3}, limit_v=1.0),
    Case(Fault.OVERSPEED, "60 rad/s, limit 40 rad/s", _pushed, 2 * SPAN * TICK_CLOCKS, free=True,
         motion={"overspeed_rad_s": 40.0}),
    Case(Fault.WINDOW, "10 rad/s, 2 mrad before the end of the window",
         _inject(Injection.OUTSIDE), 250 * TICK_CLOCKS, free=True,
         motion={"window_rad": (-0.5, 8e-3)}),
)  # fmt: skip
"""One for each fault, by its bit."""


def guarded(case: Case) -> GuardedPins:
    """The case's simulation, run up to where things break."""
    watched = (case.fault,)
    pins = GuardedPins(
        scene(case.free, case.limit_v, **case.motion),
        Limits(watched=watched)._replace(**case.limits),
    )
    if case.fault != Fault.HEAT and not pins.run(WARM_TICKS):
        raise RuntimeError(f"{case.fault.name} before its cause: {pins.report()}")
    return pins


def measure(case: Case) -> dict[str, Any]:
    """A row: the fault, its cause, and the clocks and seconds until the gates were off."""
    pins = guarded(case)
    before = pins.report()
    if before.faults or not before.running:
        raise RuntimeError(f"{case.fault.name} before its cause: {before}")
    case.break_it(pins)
    pins.elapse(case.most_clocks // TICK_CLOCKS + SLACK_TICKS)
    report = pins.report()
    clocks = report.off - report.cause if report.off >= 0 else None
    return {
        "fault": case.fault.name,
        "bit": int(case.fault),
        "cause": case.cause,
        "faults": report.faults,
        "clocks": clocks,
        "time_s": None if clocks is None else clocks * pins.tick_s / TICK_CLOCKS,
        "limit_clocks": case.most_clocks,
    }
