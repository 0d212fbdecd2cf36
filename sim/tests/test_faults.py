# SPDX-License-Identifier: Apache-2.0
"""The guard in the running closed loop: every fault, what it does, and how it is got rid of."""

from __future__ import annotations

import json

import numpy as np
import pytest
from wavehaptics.controller.guard import DAMPABLE, Fault, Limits, mask
from wavehaptics.ladder.guarded_pins import GuardedPins, Injection
from wavehaptics.runtime.repository import ROOT
from wavehaptics.studies.fault_table import (  # fmt: skip
    CASES,
    KEPT,
    SLACK_TICKS,
    TICK_CLOCKS,
    guarded,
    measure,
    scene,
)
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats
from wavetools.pages import faults, filler

KEPT_ROWS = {row["fault"]: row for row in json.loads((ROOT / KEPT).read_text("utf-8"))}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.fault.name)
def test_fault_switches_the_gates_off(case):
    """In the time that the table says, with its own bit and no other; and the table is this."""
    row = measure(case)
    assert row["faults"] == 1 << case.fault
    assert 0 < row["clocks"] <= case.most_clocks
    assert row == KEPT_ROWS[case.fault.name]


def test_every_fault_has_its_row():
    assert [case.fault for case in CASES] == sorted(Fault)
    page = (ROOT / "rtl" / "faults.md").read_text("utf-8")
    assert faults.table(list(KEPT_ROWS.values())) in page
    assert filler.stale_pages() == []


def case_of(fault: Fault):
    return next(case for case in CASES if case.fault == fault)


def test_a_fault_stays_until_it_is_over_and_cleared():
    pins = guarded(case_of(Fault.STOP))

    def state(kind: Injection, value: int):
        pins.inject(kind, value)
        pins.elapse(20)
        report = pins.report()
        return report.faults, report.running

    stop = 1 << Fault.STOP
    assert state(Injection.STOP, 0) == (stop, False)
    assert state(Injection.CLEAR, 1) == (stop, False), "still pressed"
    assert state(Injection.STOP, 1) == (stop, False), "not yet cleared"
    assert state(Injection.CLEAR, 1) == (0, True)


PASSING = (
    Fault.CURRENT, Fault.TRIP, Fault.ENCODER, Fault.LOST, Fault.ENERGY, Fault.SATURATED,
)  # fmt: skip
"""Faults whose cause in the table doesn't last, or doesn't show with the bridge off."""


@pytest.mark.parametrize("fault", [fault for fault in Fault if fault not in PASSING])
def test_no_gate_goes_on_while_the_cause_lasts(fault):
    """Told to clear again and again, at other clocks of the tick: nothing switches."""
    case = case_of(fault)
    pins = guarded(case)
    case.break_it(pins)
    pins.elapse(case.most_clocks // TICK_CLOCKS + SLACK_TICKS)
    assert pins.report().faults == 1 << fault
    pins.inject(Injection.CLEAR, 1)  # counts from here on
    on = []
    for strobe in range(40):
        pins.elapse(1)
        pins.inject(Injection.CLEAR, 1 + strobe)
        pins.elapse(2)
        report = pins.report()
        on.append(report.on)
        assert report.faults == 1 << fault, strobe
    assert on == [0] * 40


@pytest.mark.parametrize("fault", [Fault.ENCODER, Fault.DRIVER, Fault.BUS_LOW, Fault.SETTING])
def test_one_strobe_clears_what_is_over(fault):
    case = case_of(fault)
    pins = guarded(case)
    root = pins.settings.root
    case.break_it(pins)
    pins.elapse(20)
    assert pins.report().faults == 1 << fault
    for kind, value in ((Injection.DRIVER, 1), (Injection.BUS, 12 << 9),
                        (Injection.ROOT_WORD, root)):  # fmt: skip
        pins.inject(kind, value)
    pins.elapse(20)
    assert (pins.report().faults, pins.report().on) == (1 << fault, 0)
    pins.inject(Injection.CLEAR, 1)
    pins.elapse(20)
    report = pins.report()
    assert (report.faults, report.running) == (0, True)
    assert report.on > 500


def test_watching_everything_raises_no_alarm():
    """A whole impact, with noise: contact, rebound and free flight, and nothing is the matter."""
    pins = GuardedPins(scene(), Limits(watched=tuple(Fault)))
    assert pins.run(8_000)
    report = pins.report()
    assert (report.faults, report.running) == (0, True)


def test_damping_keeps_the_gates_and_stores_nothing():
    """After the host has fallen silent η is 0: the voltage dies away, and the motor only brakes."""
    limits = Limits(watched=(Fault.HOST,), damp=(Fault.HOST,), host_s=50e-6)
    pins = GuardedPins(scene(free=True), limits)
    assert pins.run(300)
    pins.inject(Injection.HOST_SILENT)
    rows, words = np.zeros((3000, len(Column))), np.zeros((3000, len(Word)), dtype=np.int64)
    pins.advance(rows, words)
    report = pins.report()
    assert (report.faults, report.running, report.off) == (1 << Fault.HOST, True, -1)
    volts = words[200:, Word.E] * formats.VOLTAGE.step
    assert np.abs(volts).max() < 1e-6
    # e_a = 0 leaves the winding's own damper, B = k_T²/R.
    motor = scene().motor
    rate = motor.k_t**2 / (motor.R_ohm * motor.J_kgm2)
    omega = rows[500:, Column.OMEGA]
    time = rows[500:, Column.T]
    slope = np.polyfit(time, np.log(omega), 1)[0]
    assert slope == pytest.approx(-rate, rel=0.05)


@pytest.mark.parametrize("fault", [fault for fault in Fault if not DAMPABLE >> fault & 1])
def test_no_damping_where_the_current_cannot_be_trusted(fault):
    case = case_of(fault)
    measured = measure(case._replace(limits={**case.limits, "damp": tuple(Fault)}))
    assert measured["faults"] == mask([fault])
    assert measured["clocks"] is not None
