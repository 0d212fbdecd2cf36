# SPDX-License-Identifier: Apache-2.0
"""The hard cases: what is expected of each, and what was found.

Each case is a function that measures and returns its numbers, what was found in words, and whether
that is what was expected; those with a broken input are in
:mod:`wavehaptics.studies.report.broken_inputs`. What a test of the project shows by itself
is named beside them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from wavehaptics.controller import wave_core
from wavehaptics.controller.settings import settings
from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.laws import closed_forms
from wavehaptics.runtime.compiled import compiled_counting
from wavehaptics.scene import Scene
from wavehaptics.studies.report.blocks import Block, Table, Text, number, percent
from wavehaptics.studies.report.broken_inputs import (
    adc_bit_flipped,
    adc_stuck,
    encoder_glitches,
    reset_in_contact,
)
from wavehaptics.studies.report.outcome import Outcome
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.stability import simulate
from wavehaptics.studies.sweeps import Task
from wavehaptics.trace.columns import Column
from wavehaptics.words import formats

TITLE = "Hard cases"

INSIDE = (
    "hand.path='sine'", "hand.amplitude_rad=0.01", "hand.frequency_hz=5", "hand.stiffness=2",
    "hand.damping=5e-3", "controller.walls=[[-1, 1]]", "drive.limit_v=12.0",
    "scene.duration_s=0.4",
)  # fmt: skip
"""A hand that never leaves the wall."""
STRIPES = (
    "hand.path='sine'", "hand.amplitude_rad=0.03", "hand.frequency_hz=7", "hand.stiffness=2",
    "hand.damping=2e-3", "drive.limit_v=12.0", "scene.duration_s=0.3",
    f"controller.walls={[[0.002 * n, 0.002 * n + 0.001] for n in range(-20, 20)]}",
)  # fmt: skip
"""Forty walls of 1 mrad: η changes sign about a thousand times a second."""
LAMBDAS = (1e2, 1e3, 1e4, 1e5, 1e9)
RATES_HZ = (2e6, 1e6, 1e5, 1e4, 1e3, 500.0)
LATENCIES = (0, 1, 10, 100, 1000)
R_HAT_PARTS = (0.5, 0.8, 0.95, 1.05, 1.2, 1.5)
ZERO_TICKS = 100_000_000


def _rows(scene: Scene) -> np.ndarray:
    return simulate(CONTROLLERS["golden"](scene), scene.scene.duration_s)


def _ideal(scene: Scene) -> Scene:
    """With an ideal encoder and an ideal current sensor."""
    return scene.model_copy(update={"encoder": None, "adc": None})


def _inside(*more: str) -> tuple[float, float]:
    """Error of the stiffness against the closed form, and energy given out, J."""
    scene = _ideal(load("stiffest", [*INSIDE, *more]))
    rows = _rows(scene)
    k = -np.polyfit(rows[:, Column.X], rows[:, Column.TORQUE], 1)[0]
    motor, set_ = scene.motor, settings(scene)
    predicted = closed_forms.stiffness(motor.k_t, motor.L_h, set_.r_hat, set_.tau)
    return abs(k / predicted - 1), float(np.cumsum(rows[:, Column.ENERGY_OUT]).max())


def _striped_energy(*more: str) -> float:
    rows = _rows(_ideal(load("stiffest", [*STRIPES, *more])))
    return float(np.cumsum(rows[:, Column.ENERGY_OUT]).max())


def _joules(most: float) -> str:
    """The most that a running sum of energies reached; one that never rose gave nothing."""
    return f"{number(max(most, 0.0))} J"


def any_lambda() -> Outcome:
    found = [_inside(f"controller.lambda={value}") for value in LAMBDAS]
    error, energy = (max(column) for column in zip(*found, strict=True))
    text = f"stiffness off by {percent(error)} at most, energy given out {_joules(energy)}"
    return Outcome({"error": error, "energy_j": energy}, text, error < 0.01 and energy <= 0)


def any_rate() -> Outcome:
    at = [(f"controller.tick_hz={hz}", "controller.lambda=1e9") for hz in RATES_HZ]
    error = max(_inside(*s)[0] for s, hz in zip(at, RATES_HZ, strict=True) if hz >= 5e3)
    energy = max(_striped_energy(*s) for s in at)
    text = f"stiffness off by {percent(error)} at most, energy given out {_joules(energy)}"
    return Outcome({"error": error, "energy_j": energy}, text, error < 0.01 and energy <= 0)


def any_latency() -> Outcome:
    at = [(f"controller.extra_ticks={k}", "controller.lambda=1e9") for k in LATENCIES]
    error = max(_inside(*s)[0] for s in at)
    energy = max(_striped_energy(*s) for s in at)
    text = f"stiffness off by {percent(error)} at most, energy given out {_joules(energy)}"
    return Outcome({"error": error, "energy_j": energy}, text, error < 0.01 and energy <= 0)


def wrong_resistance() -> Outcome:
    """The hand, stiff as a vice, goes in evenly: di/dt is as exp((R̂ − R)/L_eff·t)."""
    numbers, worst, rings = {}, 0.0, {}
    vice = (
        "hand.amplitude_rad=0.001", "hand.stiffness=2000", "hand.damping=0.05",
        "drive.limit_v=100", "drive.bus_v=100", "scene.duration_s=0.02",
    )  # fmt: skip
    for part in R_HAT_PARTS:
        r_hat = f"controller.r_hat={part * 2.18}"
        scene = _ideal(load("press_hold", [*vice, r_hat, "controller.walls=[[-1, 1]]"]))
        rows = _rows(scene)
        motor, set_ = scene.motor, settings(scene)
        l_eff = closed_forms.l_eff(motor.L_h, set_.r_hat, set_.tau)
        expected = (set_.r_hat - motor.R_ohm) / l_eff
        time_constant = round(1 / abs(expected) / set_.tick_s)
        window = rows[time_constant // 2 : 2 * time_constant]
        width = max(1, time_constant // 20)
        change = np.abs(window[width:, Column.I] - window[:-width, Column.I])
        found = float(np.polyfit(window[width:, Column.T], np.log(change), 1)[0])
        numbers[f"{part:g}"] = {"rate_1_s": found, "expected_1_s": expected}
        worst = max(worst, abs(found / expected - 1))
        free = _rows(_ideal(load("press_hold", [*vice, r_hat, "controller.walls=[]"])))
        rings[f"{part:g}"] = float(np.sqrt(np.mean(free[-5000:, Column.TORQUE] ** 2)))
    ringing = [part for part, torque in rings.items() if torque > 1e-4]
    text = f"falls and rises as expected, to {percent(worst)}; 5 % of R̂ is 2.2 ms. "
    text += (
        f"Free space rings by itself (a = 0.99) at {', '.join(ringing)} R" if ringing
        else "Free space does not ring"
    )  # fmt: skip
    told = {"rates": numbers, "worst": worst, "free_space_torque_rms": rings}
    return Outcome(told, text, worst < 0.1)


def small_r_and_l() -> Outcome:
    cases = {"R = 0.05 Ω": ("motor.R_ohm=0.05",), "L = 10 µH": ("motor.L_h=1e-5",),
             "both": ("motor.R_ohm=0.05", "motor.L_h=1e-5")}  # fmt: skip
    found = {name: _inside("controller.lambda=1e9", *s) for name, s in cases.items()}
    error = max(e for e, _ in found.values())
    energy = max(j for _, j in found.values())
    text = f"stiffness off by {percent(error)} at most, energy given out {_joules(energy)}"
    return Outcome({"error": error, "energy_j": energy}, text, error < 0.01 and energy <= 0)


def light_rotor() -> Outcome:
    """The free space's own inertia, k_T²τ/(2R), comes to the rotor's where it meets the wall."""
    scene = load("impact", ["motor.J_kgm2=1.03e-7"])
    metrics = measure(scene, "golden")
    back, energy = metrics["restitution"], metrics["energy_out_max_j"]
    motor, set_ = scene.motor, settings(scene)
    added = closed_forms.free_space_inertia(motor.k_t, motor.R_ohm, set_.tau) / motor.J_kgm2
    bound = math.sqrt(1 + added)
    text = (
        f"comes back {back:.5f} times as fast (bound {bound:.5f}), energy given out "
        f"{_joules(energy)}"
    )
    numbers = {"restitution": back, "bound": bound, "energy_j": energy}
    return Outcome(numbers, text, 0.95 <= back <= bound and energy <= 0)


def chatter() -> Outcome:
    cell = 2 * math.pi / 1000
    scene = load("stiffest", [
        "encoder.counts_per_rev=1000", "hand.path='sine'", f"hand.amplitude_rad={0.2 * cell}",
        "hand.frequency_hz=100", "hand.stiffness=2", "hand.damping=2e-3",
        "drive.limit_v=12.0", "scene.duration_s=0.5",
    ])  # fmt: skip
    rows = _rows(scene)
    changes = int(np.count_nonzero(np.diff(rows[:, Column.CONTACT])))
    energy = float(np.cumsum(rows[:, Column.ENERGY_OUT]).max())
    text = f"{changes} changes of contact in 0.5 s, energy given out {_joules(energy)}"
    return Outcome({"changes": changes, "energy_j": energy}, text, changes > 50 and energy <= 0)


def full_speed() -> Outcome:
    speed = 12.0 / 23.4e-3  # what 12 V can turn the motor with
    scene = load("impact", [
        f"hand.speed_rad_s={speed}", "controller.walls=[[0, 20]]", "scene.duration_s=0.05",
    ])  # fmt: skip
    rows = _rows(_ideal(scene))
    first = int(np.argmax(rows[:, Column.CONTACT] != 0))
    late = float(rows[first, Column.X] + 0.5e-6 * speed)
    energy = float(np.cumsum(rows[:, Column.ENERGY_OUT]).max())
    back = float(np.abs(rows[-1, Column.OMEGA]) / speed)
    text = (
        f"contact found {number(1e3 * late)} mrad inside (ω·T is {number(1e3 * speed * 1e-6)}), "
        f"comes back {number(back)} times as fast, energy given out {_joules(energy)}"
    )
    ok = 0 <= late <= speed * 1e-6 * 1.01 and energy <= 0 and back <= 1
    return Outcome({"late_rad": late, "energy_j": energy, "restitution": back}, text, ok)


def saturated_throughout() -> Outcome:
    scene = load("paper_taps", [
        "drive.limit_v=0.1", "hand.amplitude_rad=0.05", "scene.duration_s=0.5",
    ])  # fmt: skip
    rows = _rows(scene)
    contact = rows[rows[:, Column.CONTACT] != 0]
    part = float(contact[:, Column.SATURATED].mean())
    energy = float(np.cumsum(rows[:, Column.ENERGY_OUT]).max())
    text = f"at the limit in {percent(part)} of the contact, energy given out {_joules(energy)}"
    return Outcome({"saturated": part, "energy_j": energy}, text, part > 0.5 and energy <= 1e-12)


def most_negative_words() -> Outcome:
    """Every input of the wave core at its most negative word, and at every mix with the others."""
    data = (formats.WAVE.raw_min, formats.WAVE.raw_max, 0)
    coefficients = (formats.ETA.raw_min, formats.ETA.raw_max, 0)
    largest = 0
    for current in data:
        for eta in coefficients:
            for root in coefficients:
                for a in coefficients:
                    state, line = wave_core.new_state(), wave_core.new_line(1)
                    for _ in range(200):
                        words = wave_core.wave_core_step(
                            state, line, current, eta, 0, root, a, formats.WAVE.raw_max, 1, 1
                        )
                        largest = max(largest, *(abs(int(word)) for word in words))
    bound = -formats.WAVE.raw_min
    text = f"largest output {number(largest / bound, 6)} of full scale: saturated, never wrapped"
    return Outcome({"largest_word": largest, "bound": bound}, text, largest <= bound)


@compiled_counting()
def _silence(
    state: np.ndarray, line: np.ndarray, ticks: int, eta: int, root: int, a: int, u_max: int
) -> int:
    """Tick after which all outputs stay zero at zero current; -1 if they never do."""
    last = -1
    for n in range(ticks):
        e, u, v = wave_core.wave_core_step(state, line, 0, eta, 0, root, a, u_max, 1, 1)
        if e != 0 or u != 0 or v != 0:
            last = n
    return last


def zero_input() -> Outcome:
    """10⁸ ticks at zero current: from reset, and from a full filter behind η = ±0.99."""
    root, a = formats.ROOT.to_raw(2.088), formats.A.to_raw(0.01)
    full = formats.WAVE.raw_max
    last = {}
    for name, eta, start in (("reset", -1.0, 0), ("η = 0.99", 0.99, 1), ("η = −0.99", -0.99, 1)):
        state, line = wave_core.new_state(), wave_core.new_line(1)
        if start:
            state[wave_core.STATE_F] = full << formats.STATE_GUARD
        ticks = ZERO_TICKS if not start else ZERO_TICKS // 20
        last[name] = int(_silence(state, line, ticks, formats.ETA.to_raw(eta), root, a, full))
    settled = max(last.values())
    text = (
        f"from reset no output in {number(ZERO_TICKS)} ticks; a full filter is exactly zero after "
        f"{number(settled + 1)} ticks and stays so"
    )
    ok = last["reset"] == -1 and settled < ZERO_TICKS // 40
    return Outcome({"last_output_tick": last}, text, ok)


class Case(NamedTuple):
    """A hard case, what is expected, and the function that measures it."""

    name: str
    expected: str
    measure: Callable[[], Outcome]


CASES = {
    case.measure.__name__: case
    for case in (
        Case("λ from 10² rad/s to a = 0.99",
             "stiffness within 1 % of the closed form, no energy out", any_lambda),
        Case("T from 0.5 µs to 2 ms", "no energy out; stiffness within 1 % up to 200 µs", any_rate),
        Case("k from 0 to 1000 ticks", "stiffness within 1 %, no energy out", any_latency),
        Case("R̂ from 0.5 R to 1.5 R",
             "the force falls (R̂ < R) or grows (R̂ > R) with L_eff/|R − R̂|, within 10 %",
             wrong_resistance),
        Case("R = 0.05 Ω and L = 10 µH", "stiffness within 1 %, no energy out", small_r_and_l),
        Case("rotor inertia ÷ 10, no friction, no hand",
             "comes back 0.95 to √(1 + J_free/J) times as fast: free space has inertia too",
             light_rotor),
        Case("chatter on one encoder edge", "no energy out", chatter),
        Case("contact at the speed limit, 513 rad/s",
             "found within ω·T, comes back no faster, no energy out", full_speed),
        Case("saturation through the contact", "no energy out", saturated_throughout),
        Case("every input at its most negative word", "saturated outputs, no wrap",
             most_negative_words),
        Case("zero input for 10⁸ ticks", "no output, no limit cycle", zero_input),
        Case("ADC stuck in mid-contact, without the guard", "torque below k_T·limit/R", adc_stuck),
        Case("ADC, one bit of one sample flipped in mid-contact",
             "the torque changes by no more than k_T·(2R̂·ΔI·T/L_eff + a step of the ADC)",
             adc_bit_flipped),
        Case("A/B glitches through a contact, a clock long, half a million a second",
             "filtered: the torque is the same to the last bit", encoder_glitches),
        Case("reset of 20 µs in mid-contact",
             "no current after 30 µs; then a new impact: torque within 1 % of ω·√(K·J) at most, "
             "comes back √(1 + J_free/J) times as fast at most", reset_in_contact),
    )
}  # fmt: skip
"""By the name of their function."""

BY_TEST = (
    ("every input at its most negative word, RTL", "the words of the integer model",
     "cocotb_tests/tb_wave_core.py", "equals_the_integer_model"),
    ("A/B illegal", "counted as a fault, position unharmed", "cocotb_tests/tb_quadrature.py",
     "illegal_moves_are_tallied"),
    ("A/B illegal in the closed loop, and every other fault of the guard",
     "gates off within the clocks of rtl/faults.md", "sim/tests/test_faults.py",
     "test_fault_switches_the_gates_off"),
    ("A/B glitches", "not counted", "cocotb_tests/tb_quadrature.py", "glitches_are_not_counted"),
    ("chatter on one encoder edge, RTL", "no drift", "cocotb_tests/tb_quadrature.py",
     "chatter_on_one_edge"),
    ("reset in mid-contact, RTL", "gates off at once, then as from the start",
     "cocotb_tests/tb_controller.py", "reset_in_contact"),
    ("gates in any state", "never both switches of a leg", "cocotb_tests/tb_controller.py",
     "gates_in_any_state"),
    ("ADC stuck, RTL", "told after as many like words as are set",
     "cocotb_tests/tb_sense_check.py", "long_runs"),
    ("clock lost with a gate on, on a board with an oscillator of its own",
     "gates off within 19 clocks of the oscillator, and until reset when the clock comes back",
     "cocotb_tests/tb_lost_clock.py", "a_stopped_clock_takes_the_gates_off_until_reset"),
    ("clock lost at any time, at any rates of clock and oscillator",
     "gates off within the same clocks, and no false alarm",
     "cocotb_tests/tb_board_clock_watch.py", "stopped_clock_takes_the_gates_off"),
    ("any words from a host", "no more energy paid out than came in",
     "cocotb_tests/tb_host_link.py", "never_pays_out_more_than_came_in"),
)  # fmt: skip
"""Cases that a test of the project shows by itself: name, expected, file and test."""


def check(case: str) -> dict[str, Any]:
    """Outcome of one case of :data:`CASES`."""
    outcome = CASES[case].measure()
    return {"case": case, "numbers": outcome.numbers, "found": outcome.found, "ok": outcome.ok}


def tasks(quick: bool) -> list[Task]:
    del quick
    return [Task(check, {"case": name}) for name in CASES]


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    del tasks
    tested = [dict(zip(("name", "expected", "file", "test"), row, strict=True)) for row in BY_TEST]
    return {"cases": results, "tested": tested}


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    del folder
    rows = [
        (CASES[c["case"]].name, CASES[c["case"]].expected, c["found"], "yes" if c["ok"] else "NO")
        for c in data["cases"]
    ]
    tested = [(t["name"], t["expected"], f"{t['test']} in {t['file']}") for t in data["tested"]]
    return [
        Text(
            "What breaks controllers elsewhere, tried on this one. “Energy given out” is the most "
            "net energy that the controller's port had given out at any time: a passive port "
            "never gives any. There is no UART in this design, so its noise can't be tried."
        ),
        Table("Expected and found", ("case", "expected", "found", "as expected"), rows),
        Table(
            "Cases that the project's tests show, each by itself",
            ("case", "expected", "shown by"),
            tested,
        ),
    ]
