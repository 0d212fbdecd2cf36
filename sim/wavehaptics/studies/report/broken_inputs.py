# SPDX-License-Identifier: Apache-2.0
"""Hard cases at the pins: the whole RTL in its closed loop, with an input that goes wrong.

The scene is that of the table of faults (:mod:`wavehaptics.studies.fault_table`): a bare rotor has
hit the stiffest wall at 10 rad/s and is deep in it. The guard watches nothing here, so that what is
seen is what the controller does by itself; how soon the guard switches off is in ``rtl/faults.md``.
"""

from __future__ import annotations

import math

import numpy as np

from wavehaptics.controller.guard import Limits
from wavehaptics.ladder.guarded_pins import GuardedPins, Injection
from wavehaptics.laws import closed_forms
from wavehaptics.motor.plant import OMEGA, I
from wavehaptics.studies.fault_table import WARM_TICKS, scene
from wavehaptics.studies.report.blocks import number
from wavehaptics.studies.report.outcome import Outcome
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats

TICKS = 1500
"""Ticks after the cause: to the end of the contact."""
RESET_CLOCKS = 1000
"""20 µs: long enough for the freewheeling diodes to end the current."""
RESET_TICKS = 8000
SETTLE_TICKS = 30
GLITCH_CLOCKS = 1
"""The encoder's lines are believed after two clocks, see ``rtl/wh_quadrature.v``."""
FLIPPED_BIT = 3
"""Place below the highest: a sixteenth of the ADC's span, 0.5 A."""


def impact(warm_ticks: int = WARM_TICKS, quiet: bool = False) -> GuardedPins:
    """The whole RTL at its pins, after so many ticks: by default the rotor is deep in the wall.

    ``quiet`` is without the sensor's noise.
    """
    case = scene()
    if quiet:
        assert case.adc is not None
        case = case.model_copy(update={"adc": case.adc.model_copy(update={"noise_a": 0.0})})
    pins = GuardedPins(case, Limits(watched=()))
    if not pins.run(warm_ticks):
        raise RuntimeError(f"before the cause: {pins.report()}")
    return pins


def _ticks(pins: GuardedPins, ticks: int = TICKS) -> tuple[np.ndarray, np.ndarray]:
    """Rows (Column) and words (Word) of the next ticks."""
    rows, words = np.zeros((ticks, len(Column))), np.zeros((ticks, len(Word)), dtype=np.int64)
    pins.advance(rows, words)
    return rows, words


def _peak_nm(rows: np.ndarray) -> float:
    return float(np.abs(rows[:, Column.TORQUE]).max())


def adc_stuck() -> Outcome:
    """The drive's limit alone holds what the wave loop does with a current that never changes."""
    pins = impact()
    pins.inject(Injection.ADC_REPEATS)
    rows, words = _ticks(pins)
    case = scene()
    assert case.drive is not None
    assert case.drive.bus_v is not None
    bound = case.motor.k_t * case.drive.bus_v / case.motor.R_ohm
    peak = _peak_nm(rows)
    stuck = bool(np.ptp(words[5:, Word.I]) == 0)
    text = f"{number(1e3 * peak)} mN·m at most; the drive's limit allows {number(1e3 * bound)}"
    return Outcome({"peak_nm": peak, "bound_nm": bound}, text, stuck and peak <= bound)


def adc_bit_flipped() -> Outcome:
    """One bit of one sample: a flux of 2R̂·ΔI·T, which moves the wall and no more."""
    pins = impact()
    frame, set_ = pins.timing.frame, pins.settings
    place = frame.setup_clocks + frame.bit_clocks * (frame.lead_bits + FLIPPED_BIT)
    pins.inject(Injection.ADC_FLIP, place)
    rows, words = _ticks(pins)
    whole, whole_words = _ticks(impact())
    wrong = np.flatnonzero(words[:, Word.I] != whole_words[:, Word.I])[0]
    flip_a = abs(int(words[wrong, Word.I] - whole_words[wrong, Word.I])) * formats.CURRENT.step
    adc = scene().adc
    assert adc is not None
    one_bit_a = adc.full_scale_a * 2.0**-FLIPPED_BIT
    difference = np.abs(rows[:, Column.TORQUE] - whole[:, Column.TORQUE])
    motor = scene().motor
    l_eff = closed_forms.l_eff(motor.L_h, set_.r_hat, set_.tau)
    # What a step of the ADC may make of the two currents, which are no longer the same.
    step_a = pins.sensor.full_scale_a * 2.0 ** (1 - pins.sensor.bits)
    bound = motor.k_t * (2 * set_.r_hat * flip_a * set_.tick_s / l_eff + step_a)
    peak = float(difference.max())
    text = (
        f"{number(1e6 * peak)} µN·m at most (bound {number(1e6 * bound)}), of "
        f"{number(1e3 * _peak_nm(whole))} mN·m of the impact"
    )
    ok = math.isclose(flip_a, one_bit_a, rel_tol=1e-4) and 0 < peak <= bound
    numbers = {"flip_a": flip_a, "one_bit_a": one_bit_a, "peak_nm": peak, "bound_nm": bound}
    return Outcome(numbers, text, ok)


def glitches(clocks: int) -> float:
    """Largest change of torque, N·m, by glitches of A and B by turns, from before the contact."""
    glitched = impact(1)
    glitched.inject(Injection.ENCODER_GLITCHES, clocks)
    torques = [
        _ticks(pins, WARM_TICKS + TICKS)[0][:, Column.TORQUE] for pins in (glitched, impact(1))
    ]
    return float(np.abs(torques[0] - torques[1]).max())


def encoder_glitches() -> Outcome:
    changed = glitches(GLITCH_CLOCKS)
    text = f"torque changed by {number(1e6 * changed)} µN·m at most"
    return Outcome({"changed_nm": changed}, text, changed == 0)


def reset_in_contact() -> Outcome:
    """The gates open, the diodes end the current, and the count begins anew where the rotor is.

    The wall then stands as far beyond the rotor as it was from the start, and what follows is
    another impact: its torque is at most ω·√(K·J), and the rotor comes back no faster, but for the
    inertia of free space. It is tried without noise, which alone moves that speed by 0.2 % from
    one moment to the next.
    """
    pins = impact(quiet=True)
    before = float(pins.motor[I])
    pins.inject(Injection.RESET, RESET_CLOCKS)
    pins.elapse(SETTLE_TICKS)
    speed, left = float(pins.motor[OMEGA]), abs(float(pins.motor[I]))
    motion = np.zeros((RESET_TICKS // 10, 2))
    for row in motion:
        pins.elapse(10)
        row[:] = pins.motor[I], pins.motor[OMEGA]
    motor, set_ = scene().motor, pins.settings
    k = closed_forms.stiffness(motor.k_t, motor.L_h, set_.r_hat, set_.tau)
    peak = motor.k_t * float(np.abs(motion[:, 0]).max())
    bound = speed * math.sqrt(k * motor.J_kgm2)
    back = float(np.abs(motion[-1, 1])) / speed
    added = closed_forms.free_space_inertia(motor.k_t, motor.R_ohm, set_.tau) / motor.J_kgm2
    most_back = math.sqrt(1 + added)
    text = (
        f"{number(1e3 * abs(before))} mA before, {number(1e3 * left)} mA "
        f"{SETTLE_TICKS} µs later; then {number(1e3 * peak)} mN·m at most (bound "
        f"{number(1e3 * bound)}), and the rotor leaves {back:.4f} times as fast"
    )
    numbers = {
        "before_a": abs(before), "left_a": left, "peak_nm": peak, "bound_nm": bound,
        "restitution": back, "most_restitution": most_back,
    }  # fmt: skip
    ok = left < 0.01 * abs(before) and 0.5 * bound < peak <= 1.01 * bound and back <= most_back
    return Outcome(numbers, text, ok)
