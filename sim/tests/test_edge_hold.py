# SPDX-License-Identifier: Apache-2.0
"""An amplifier that holds its output after each edge of its lead: alone, at the pins, in a loop."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from test_abilities import SERVO
from test_real_scenes import PRESS, rows_of
from wavehaptics.fpga.boards import load_board
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.brushless_pins import BrushlessPinsSimulation, leads_move
from wavehaptics.ladder.run import measure
from wavehaptics.motor.sensor import (
    HELD_A,
    HOLD_S,
    LEVEL,
    UNTIL,
    Sensor,
    held_output,
    hold_at_edge,
    new_holds,
)
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import SceneError, load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats

# --- The amplifier alone --------------------------------------------------------------------------


def seen(edges, clocks, hold_clocks, restarts):
    """What an amplifier shows of an output that is the clock, with edges at known clocks."""
    holds, level, shown = new_holds(1), 0.5, []
    hold_at_edge.py_func(holds, 0, level, 0, 0.0, hold_clocks, restarts)
    for clock in clocks:
        # What is sampled with an edge is what is held from it on.
        shown.append(held_output.py_func(holds, 0, clock, float(clock)))
        if clock in edges:
            level = -level
            hold_at_edge.py_func(holds, 0, level, clock, float(clock), hold_clocks, restarts)
    return shown


@pytest.mark.parametrize("restarts", [True, False])
def test_samples_after_lone_edges_are_those_at_the_edge(restarts):
    shown = seen({10, 30}, range(41), 8, restarts)
    expected = [*range(11), *[10] * 7, *range(18, 31), *[30] * 7, 38, 39, 40]
    assert shown == expected


def test_an_edge_in_a_hold_restarts_it_or_is_ignored():
    """Edges at 10, 14 and 20 with a hold of 8 clocks: it ends at 28, or first at 18."""
    clocks = range(8, 32)
    restarted = [8, 9, *[10] * 18, 28, 29, 30, 31]
    ignored = [8, 9, *[10] * 8, 18, 19, *[20] * 8, 28, 29, 30, 31]
    assert seen({10, 14, 20}, clocks, 8, True) == restarted
    assert seen({10, 14, 20}, clocks, 8, False) == ignored


def test_a_hold_longer_than_the_edges_are_apart_never_moves_or_samples():
    """With edges every 10 clocks a hold of 15 that restarts shows what was there at the first.

    One that doesn't ends at 25, 45 …, half way to the edge that begins the next.
    """
    edges, clocks = set(range(10, 2000, 10)), range(2000)
    assert seen(edges, clocks, 15, True)[10:] == [10.0] * 1990
    shown = seen(edges, clocks, 15, False)
    assert shown == [
        clock if clock <= 10 or (clock - 10) % 20 >= 15 else 10 + (clock - 10) // 20 * 20
        for clock in clocks
    ]


@pytest.mark.parametrize("restarts", [True, False])
def test_a_hold_as_long_as_the_edges_are_apart_takes_one_output_an_edge(restarts):
    """It is over as the next begins, whichever way its length is rounded to clocks."""
    for hold_clocks in (10, 1e-6 / 1e-7, 10 * (1 + 1e-9)):
        shown = seen(set(range(10, 200, 10)), range(200), hold_clocks, restarts)
        assert shown[11:] == [clock // 10 * 10 for clock in range(11, 200)]


def test_random_edges_against_the_words_of_the_page():
    """Held exactly while a hold lasts, of which each edge outside of one is the begin."""
    seed = 20_261_127
    print("seed", seed)
    rng = np.random.default_rng(seed)
    for restarts in (True, False):
        for hold_clocks in (0.5, 3.0, 7.5, 20.0):
            edges = set(rng.choice(np.arange(1, 3000), 300, replace=False).tolist())
            shown = seen(edges, range(3000), hold_clocks, restarts)
            ends, value, expected = 0.0, 0, []
            for clock in range(3000):
                expected.append(value if clock < ends else clock)
                if clock in edges and (restarts or clock >= ends):
                    value = expected[-1]
                    ends = clock + hold_clocks
            assert shown == expected


def test_each_phase_holds_at_the_edges_of_its_own_lead():
    """Of the three legs' gates only the own one's count, and of its diodes; a floating one is none.

    Gates: high sides of a, b, c in bits 0 to 2, low sides in bits 3 to 5.
    """
    sensor = Sensor(False, edge_hold_s=1e-6).constants()
    assert sensor[HOLD_S] == 1e-6
    dt, holds, currents = 1e-7, new_holds(2), np.array([0.3, -0.1, -0.2])
    low_all, a_high, a_off = 0b111000, 0b110001, 0b110000

    def clocked(pins, clock):
        leads_move.py_func(pins, currents, clock, dt, sensor, holds)
        return holds[:, LEVEL].tolist(), holds[:, UNTIL].tolist()

    assert clocked(low_all, 0) == ([-1.0, -1.0], [0.0, 0.0])
    # Dead time: 0.3 A out of the leg come from ground, where the lead is already.
    assert clocked(a_off, 5) == ([-1.0, -1.0], [0.0, 0.0])
    assert clocked(a_high, 7) == ([1.0, -1.0], [17.0, 0.0])
    assert holds[:, HELD_A].tolist() == [0.3, 0.0]
    # Leg c switches, which no amplifier sees; then leg a's current runs out with its gates off.
    assert clocked(a_high ^ 0b100100, 30) == ([1.0, -1.0], [17.0, 0.0])
    currents[0] = 0.0
    assert clocked(a_off, 31) == ([1.0, -1.0], [17.0, 0.0])
    # Leg b opens, and its current of -0.1 A takes the lead to the bus.
    assert clocked(a_high ^ 0b010000, 40) == ([1.0, 1.0], [17.0, 50.0])
    assert holds[:, HELD_A].tolist() == [0.3, -0.1]


# --- At the pins ----------------------------------------------------------------------------------


def holding(hold_s: float, restarts: bool = True) -> tuple[str, ...]:
    return f"adc.edge_hold_s={hold_s}", f"adc.edge_hold_restarts={str(restarts).lower()}"


MODES = {
    "unipolar": ("drive.pwm_hz=500e3",),
    "locked-anti-phase": ("drive.pwm_hz=1e6",),
    "sign-magnitude": ("drive.pwm_hz=1e6",),
    "half-bridge": ("drive.pwm_hz=1e6",),
}
SENSED = ("adc.bits=16", "adc.full_scale_a=2.5", "drive.bus_v=24", "drive.limit_v=6",
          "controller.clock_hz=80e6")  # fmt: skip


@pytest.mark.parametrize("mode", MODES)
def test_a_long_hold_stops_the_current_in_every_mode(make_scene, mode):
    """Each mode moves lead A: a hold of 1 ms keeps the ADC where it was, and the motor goes on."""
    scene = make_scene(*PRESS, *SENSED, *MODES[mode], f"drive.mode={mode}", "adc.edge_hold_s=1e-3")
    rows, _, words = rows_of(scene, "pins", 3e-3, words=True)
    assert np.unique(words[100:, Word.I]).size == 1
    assert np.ptp(rows[100:, Column.I]) > 1e-3  # 13 steps of the ADC


@pytest.mark.parametrize("mode", MODES)
def test_a_hold_shorter_than_a_clock_changes_nothing(make_scene, mode):
    """What is sampled with an edge is what is held, and a clock of 12.5 ns later 10 ns are over."""
    others = (*PRESS, *SENSED, *MODES[mode], f"drive.mode={mode}", "drive.limit_v=2")
    without, _, words = rows_of(make_scene(*others), "pins", 3e-3, words=True)
    rows, _, held = rows_of(make_scene(*others, *holding(1e-8)), "pins", 3e-3, words=True)
    np.testing.assert_array_equal(held, words)
    np.testing.assert_array_equal(rows, without)
    assert np.ptp(words[:, Word.I]) > 100


def test_a_held_sample_is_the_current_at_the_edge(make_scene):
    """At 0 V and 500 kHz lead A has an edge half way between two samples, each 1 µs.

    The current of a rotor that is pushed grows by some rate; held for 0.6 µs, a sample is that of
    0.5 µs before.
    """
    others = (
        *PRESS, "hand.amplitude_rad=0.2", "hand.stiffness=0.1", "controller.walls=[]",
        "adc.bits=16", "adc.full_scale_a=1", "drive.bus_v=12", "controller.eta_free=0",
        "drive.pwm_hz=500e3", "controller.tick_hz=1e6", "controller.clock_hz=48e6",
    )  # fmt: skip

    def lateness_s(*hold):
        rows, _, words = rows_of(make_scene(*others, *hold), "pins", 2e-3, words=True)
        true_a, told_a = rows[500:, Column.I], words[500:, Word.I] * formats.CURRENT.step
        rate = np.diff(true_a).mean() / 1e-6
        assert abs(rate) > 5.0
        return (true_a - told_a).mean() / rate

    assert lateness_s() == pytest.approx(0.0, abs=0.05e-6)
    assert lateness_s(*holding(0.6e-6)) == pytest.approx(0.5e-6, abs=0.05e-6)


@pytest.mark.parametrize("restarts", [True, False])
def test_a_brushless_motor_holds_both_phases(make_scene, restarts):
    """A hold of 1 ms that restarts keeps both; one that doesn't takes a new current each 1 ms."""
    scene = make_scene(
        "motor.preset=gbm2804-100t", "encoder.counts_per_rev=10000", "adc.bits=12",
        "adc.full_scale_a=1", "drive.bus_v=12", "hand.path='press'", "hand.amplitude_rad=0.2",
        "hand.stiffness=0.4", "hand.damping=1e-4", "controller.walls=[[0.0, 1.0]]",
        *holding(1e-3, restarts),
    )  # fmt: skip
    simulation = BrushlessPinsSimulation(scene)
    seen_words, currents = [], []
    for _ in range(400):
        rows = np.zeros((10, len(Column)))
        simulation.advance(rows, np.zeros((10, len(Word)), dtype=np.int64))
        seen_words.append(simulation.step_words[::4][:2])
        currents.append(rows[-1, Column.I])
    assert np.ptp(currents[20:]) > 5e-3
    changes = np.abs(np.diff(np.array(seen_words[20:]), axis=0)).max(axis=1) > 0
    if restarts:
        assert not changes.any()
    else:
        # The two leads' edges lie apart, so that their holds don't end together.
        assert 3 <= changes.sum() <= 10


# --- In the loop ----------------------------------------------------------------------------------


FAST = ("controller.tick_hz=2e6", "drive.pwm_hz=1e6", "controller.extra_ticks=2")
"""A carrier of 1 MHz on a clock of 70."""


@cache
def tapped(board: str, *settings: str) -> dict[str, Any]:
    """A tap on a board's wall, or what its anchor finds before."""
    path = ROOT / load_board(board).folder / "board.toml"
    alone = ("adc.noise_a=0", "adc.bandwidth_hz=1e9", "guard.watch=false")
    scene = load_scene(path, ("scene.duration_s=0.2", *alone, *settings))
    return measure(scene, "pins", compare=False)


@pytest.mark.parametrize(
    ("board", "hold_s"), [("ulx3s", 1.3e-6), ("icebreaker", 1.35e-6), ("ulx3s_three", 1.6e-6)]
)
def test_a_hold_longer_than_half_a_carrier_period_loses_the_wall(board, hold_s):
    """The output never moves, and the anchor finds waves and encoder apart within 25 ms."""
    lost(board, *holding(hold_s))


def test_at_1_mhz_an_ina241_loses_the_wall():
    lost("ulx3s", *FAST, *holding(1e-6))
    lost("ulx3s", *FAST, *holding(0.55e-6))


def lost(board, *settings):
    found = tapped(board, "scene.duration_s=0.03", *settings)
    assert found["anchor_fault_s"] is not None
    assert found["anchor_fault_s"] < 25e-3


@pytest.mark.parametrize(
    ("board", "hold_s"), [("ulx3s", 1.2e-6), ("icebreaker", 1.2e-6), ("hx8k", 1.2e-6)]
)
def test_a_hold_of_half_a_carrier_period_is_felt_by_nobody(board, hold_s):
    """As 1.2 µs at 417 kHz: at 0 V a hold ends with the edge that begins the next.

    The stiffness of taps a fraction of a count apart scatters by 0.5 to 0.8 % (RMS) by itself.
    """
    found, bare = tapped(board, *holding(hold_s)), tapped(board, "adc.edge_hold_s=0")
    assert found["anchor_fault_s"] is None
    assert found["stiffness"] == pytest.approx(bare["stiffness"], rel=0.025)
    assert found["current_ripple_a"] == pytest.approx(bare["current_ripple_a"], rel=0.05)


def test_an_edge_that_is_ignored_in_a_hold_leaves_the_wall():
    """At 1 MHz an amplifier that doesn't restart shows a current each µs, which is enough."""
    found = tapped("ulx3s", *FAST, *holding(1e-6, False))
    bare = tapped("ulx3s", *FAST, "adc.edge_hold_s=0")
    assert found["anchor_fault_s"] is None
    assert found["stiffness"] == pytest.approx(bare["stiffness"], rel=0.01)


# --- What is refused ------------------------------------------------------------------------------


@pytest.mark.parametrize("controller", ["golden", "core", "hosted"])
def test_holding_is_refused_without_a_bridge(make_scene, controller):
    scene = make_scene("adc.bits=12", *holding(1e-6))
    with pytest.raises(SceneError, match=r"adc\.edge_hold_s is not for .* take `pins`$"):
        refuse(scene, controller)
    refuse(make_scene("adc.bits=12", "adc.edge_hold_s=0"), controller)


def test_field_oriented_control_refuses_it_too(make_scene):
    brushless = ("motor.preset=gbm2804-100t", "drive.bus_v=12", "adc.bits=12", *SERVO)
    scene = make_scene(*brushless, "adc.edge_hold_s=1e-6")
    with pytest.raises(SceneError, match=r"adc\.edge_hold_s is not for `encoder`"):
        refuse(scene, "encoder")
    refuse(scene, "pins")
    # With brushes it has an ideal sensor.
    refuse(make_scene("adc.bits=12", "adc.edge_hold_s=1e-6"), "encoder")


def test_restarting_is_refused_without_a_hold(make_scene):
    with pytest.raises(SceneError, match=r"edge_hold_restarts = false has no hold to restart; set"):
        make_scene("adc.bits=12", "adc.edge_hold_restarts=false")


def test_it_stands_beside_the_analog_reference(make_scene):
    scene = make_scene("adc.bits=12", *holding(0.2e-6), "scene.duration_s=1e-3")
    assert measure(scene, "pins")["ticks"] == 1000
