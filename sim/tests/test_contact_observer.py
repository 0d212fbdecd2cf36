# SPDX-License-Identifier: Apache-2.0
"""The energy that the RTL observes at its pins, against the physics; the fault that it raises."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.controller.guard import Fault, Limits, board_limits
from wavehaptics.controller.ports import controller_ports
from wavehaptics.host.names import HostError, Shape, places
from wavehaptics.ladder.guarded_pins import GuardedPins, Injection
from wavehaptics.scene import Scene
from wavehaptics.scene.tables.hand import Hand
from wavehaptics.studies.report.runs import load
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats
from wavehaptics.words.table import LEGS, THREE_PHASE_LEGS
from wavetools.studies.anchored.cases import NOTHING, all_wrong

CHUNK = 500
"""Ticks from one look at the guard to the next."""

PRESS = ("hand.path=taps", "hand.frequency_hz=40", "hand.stiffness=0.8", "hand.amplitude_rad=0.07")
"""A hand that presses as hard as the ADC can see: half a period is the press."""
PRESS_S = 0.0255


def impact(settings: tuple[str, ...], speed: float) -> Scene:
    """A bare rotor that meets the wall of ``held_wall``."""
    hand = Hand.model_validate({"path": "impact", "amplitude_rad": 2e-3, "speed_rad_s": speed})
    return load("held_wall", settings).model_copy(update={"hand": hand})


class Run:
    """A run with the energy's fault alone, and the energy of its contacts by the physics."""

    def __init__(self, scene: Scene, duration_s: float) -> None:
        limits = board_limits(scene, controller_ports(scene))
        self.limit = limits.energy
        self.pins = GuardedPins(scene, Limits(watched=(Fault.ENERGY,), energy=self.limit))
        ticks = round(duration_s / self.pins.tick_s)
        self.rows = np.zeros((ticks, len(Column)))
        words = np.zeros((ticks, len(Word)), dtype=np.int64)
        for n in range(0, ticks, CHUNK):
            try:
                self.pins.advance(self.rows[n : n + CHUNK], words[n : n + CHUNK])
            except RuntimeError:
                break
        self.report = self.pins.report()
        contact = np.flatnonzero(self.rows[:, Column.CONTACT])
        gaps = np.flatnonzero(np.diff(contact) > 1)
        self.begin = contact[gaps[-1] + 1] if len(gaps) else contact[0]
        self.end = contact[-1] + 1
        within = self.rows[self.begin : self.end + 1]
        self.count_j = scene.motor.k_t * self.pins.settings.cell_rad  # of an ampere
        way = within[:, Column.OMEGA] * self.pins.tick_s
        self.energy = float(np.sum(within[:, Column.TORQUE] * way)) / self.count_j
        self.most_a = float(np.abs(within[:, Column.I]).max())

    @property
    def observed(self) -> float:
        return formats.ENERGY.to_value(self.report.energy)


@pytest.mark.parametrize(
    ("settings", "speed"),
    [(NOTHING, None), (all_wrong((1, 1, 1, 1)), None), (all_wrong((-1, -1, -1, -1)), None),
     (NOTHING, 30.0), (all_wrong((1, 1, 1, 1)), 30.0), (all_wrong((-1, -1, -1, -1)), 30.0)],
    ids=lambda it: "-".join(map(str, it[:1])) if isinstance(it, tuple) else str(it),
)  # fmt: skip
def test_honest_contacts(settings, speed):
    """A press as hard as the ADC can see and a bounce at 30 rad/s are no fault.

    What is observed is what the torque did, within one count at the contact's largest current.
    """
    if speed is None:
        run = Run(load("held_wall", [*settings, *PRESS]), PRESS_S)
    else:
        run = Run(impact(settings, speed), 3.5e-3)
    print(run.energy, run.observed, run.most_a, run.limit, run.report)
    assert not run.rows[-1, Column.CONTACT]
    assert run.most_a > 1.0
    assert run.observed == pytest.approx(run.energy, abs=1.0 * run.most_a)  # A·counts
    assert run.report.faults == 0
    assert run.report.running
    assert formats.ENERGY.to_value(run.report.peak) < 0.1 * run.limit


@pytest.mark.parametrize("part", [1.5, 2.0])
def test_a_wall_that_runs_away_is_switched_off(part):
    """R̂ far too high without an anchor: the rotor is flung out, for some tens of counts at most."""
    wrong = ("controller.anchor_auto=false", f"controller.r_hat={2.18 * part}")
    scene = load("held_wall", [*PRESS, "hand.stiffness=0.2", *wrong])
    run = Run(scene, 0.05)
    cells = run.rows[run.begin : run.end, Column.X] / run.pins.settings.cell_rad
    print(part, np.ptp(cells), run.observed, run.limit, run.energy, run.report)
    assert run.report.faults == 1 << Fault.ENERGY
    assert not run.report.running
    assert run.limit < formats.ENERGY.to_value(run.report.peak) < 1.2 * run.limit
    assert np.ptp(cells) < 41
    # With the bridges off it is over, and what was delivered can still be read.
    before = run.report.energy
    run.pins.inject(Injection.CLEAR, 1)
    run.pins.elapse(20)
    assert run.pins.report().faults == 0
    assert run.pins.report().running
    assert before == run.report.energy > 0


def test_a_limit_for_a_brushless_motor_is_refused():
    """In one line; 0, no check, is what it has."""
    place = {legs: places("guard_energy", Shape(1, 4, 0, 2, legs))[0]
             for legs in (LEGS, THREE_PHASE_LEGS)}  # fmt: skip
    assert place[LEGS].raw(5.125) == 41
    assert place[THREE_PHASE_LEGS].raw(0) == 0
    with pytest.raises(HostError, match=r"= 5.125 can't be had: .* not observed; set it to 0$"):
        place[THREE_PHASE_LEGS].raw(5.125)
