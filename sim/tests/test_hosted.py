# SPDX-License-Identifier: Apache-2.0
"""An environment on a computer: stable and passive over any line, where plain feedback is not."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.controller import host_link
from wavehaptics.ladder.encoder import EncoderSimulation
from wavehaptics.ladder.hosted import (
    HostedSimulation,
    Line,
    PinsHostedSimulation,
    PowerEnvironment,
    WaveEnvironment,
)
from wavehaptics.laws import closed_forms
from wavehaptics.laws.reflection import Wish
from wavehaptics.trace.columns import Column

TICK_HZ = 128e3
PRESS = (
    f"controller.tick_hz={TICK_HZ}", "controller.lambda=1e9", "hand.path=press",
    "hand.amplitude_rad=0.15", "hand.stiffness=0.1", "hand.damping=0.5e-3",
)  # fmt: skip
STIFFNESS, DAMPING = 0.1, 1e-3
RATES_LOG2 = {500: 8, 1000: 7, 4000: 5}
DELAYS_S = (0.0, 2e-3, 20e-3)
BAD = Line(jitter_s=2e-3, loss=0.3, repeats=0.3)


def environment_of(kind: str, scene, period_s: float):
    motor = scene.motor
    if kind == "wave":
        wish = Wish(0.0, DAMPING, STIFFNESS, 1e9)
        return WaveEnvironment(wish, closed_forms.b_r(motor.k_t, motor.R_ohm), period_s)
    return PowerEnvironment(STIFFNESS, DAMPING, motor.k_t, motor.R_ohm, period_s)


def restless(rows: np.ndarray) -> float:
    """RMS of the rotor's speed in the last quarter of a hold, rad/s."""
    return float(np.sqrt(np.mean(rows[-len(rows) // 4 :, Column.OMEGA] ** 2)))


@pytest.mark.parametrize("kind", ["wave", "power"])
@pytest.mark.parametrize("delay_s", DELAYS_S)
@pytest.mark.parametrize("rate_hz", RATES_LOG2)
@pytest.mark.parametrize("bad", [False, True])
def test_stable_and_passive_over_any_line(make_scene, kind, delay_s, rate_hz, bad):
    """0.5 to 4 kHz, 0 to 20 ms, with 30 % lost each way, 30 % repeated, and late ones."""
    scene = make_scene(*PRESS)
    line = Line(delay_s, BAD.jitter_s, BAD.loss, BAD.repeats) if bad else Line(delay_s)
    environment = environment_of(kind, scene, 1 / rate_hz)
    simulation = HostedSimulation(scene, environment, RATES_LOG2[rate_hz], line)
    rows = simulation.advance(rate_hz)
    assert np.cumsum(rows[:, Column.ENERGY_OUT]).max() <= 0.0
    assert rows[:, Column.CONTACT].mean() > 0.9
    assert restless(rows) < (5e-2 if bad else 2e-2)
    # The wall is there: it pushes, and softer the later the answers come.
    assert rows[-1, Column.TORQUE] < -5e-4


@pytest.mark.parametrize("rate_hz", RATES_LOG2)
@pytest.mark.parametrize("delay_s", DELAYS_S)
def test_a_plain_force_feedback_loop_is_neither(make_scene, delay_s, rate_hz):
    """The same spring and damper, encoder in and torque out: it gives energy, and 2 ms break it."""
    scene = make_scene(
        *PRESS, "controller.walls=[[0, 100]]", f"servo.rate_hz={rate_hz}",
        f"servo.stiffness={STIFFNESS}", f"servo.damping={DAMPING}", f"servo.delay_s={delay_s}",
    )  # fmt: skip
    rows = np.zeros((round(TICK_HZ), len(Column)))
    EncoderSimulation(scene).advance(rows)
    assert np.cumsum(rows[:, Column.ENERGY_OUT]).max() > 1e-7
    if delay_s > 0.0:
        assert np.cumsum(rows[:, Column.ENERGY_OUT]).max() > 0.1
        assert restless(rows) > 10.0


@pytest.mark.parametrize("kind", ["wave", "power"])
def test_the_host_renders_its_spring(make_scene, kind):
    """At 4 kHz and without delay: what stands still is the host's spring behind all delays."""
    scene = make_scene(*PRESS)
    motor = scene.motor
    simulation = HostedSimulation(scene, environment_of(kind, scene, 1 / 4000), 5, Line())
    rows = simulation.advance(4000)
    set_ = simulation.settings
    # From the middle of the period of v to that of u two periods pass, and the core's own latency.
    late = 2 * simulation.period_ticks * set_.tick_s + set_.tau - set_.tick_s
    front = closed_forms.stiffness(motor.k_t, motor.L_h, motor.R_ohm, late)
    felt = 1 / (1 / STIFFNESS + 1 / front)
    begun = np.flatnonzero(rows[:, Column.CONTACT])[0]
    moved = rows[-1, Column.X] - rows[begun, Column.X]
    assert -rows[-1, Column.TORQUE] / moved == pytest.approx(felt, rel=0.02)


def test_a_host_that_falls_silent_leaves_a_passive_port(make_scene):
    """Silence for `timeout` periods, and the port's own η is in force again, then the host."""
    scene = make_scene(*PRESS, "controller.eta_free=0.0")
    environment = environment_of("power", scene, 1 / 1000)
    simulation = HostedSimulation(scene, environment, 7, Line(), timeout=10)
    before = simulation.advance(200)
    simulation.environment = None
    silent = simulation.advance(100)
    simulation.environment = environment
    after = simulation.advance(100)
    assert before[-1, Column.CONTACT] == 1.0
    active = silent[:: simulation.period_ticks, Column.CONTACT]
    assert 9 <= active.sum() <= 12
    assert not active[13:].any()
    assert after[-1, Column.CONTACT] == 1.0
    energy = np.concatenate([before, silent, after])[:, Column.ENERGY_OUT]
    assert np.cumsum(energy).max() <= 0.0


@pytest.mark.parametrize("bad", [False, True])
def test_the_whole_rtl_with_a_host(make_scene, bad):
    """Through the ports of the board's link: the same wall as the integer model's, and passive."""
    scene = make_scene(*PRESS, "controller.tick_hz=1e6", "controller.eta_free=0.0")
    line = Line(2e-3, *((BAD.jitter_s, BAD.loss, BAD.repeats) if bad else ()))
    torques = {}
    for make in (HostedSimulation, PinsHostedSimulation):
        simulation = make(scene, environment_of("power", scene, 256e-6), 8, line)
        rows = simulation.advance(500)
        torques[make] = rows[-10_000:, Column.TORQUE].mean()
        assert rows[-1, Column.CONTACT] == 1.0
        # A converter's sample is not quite the mean, hence the allowance on the pins.
        allowed = 0.0 if make is HostedSimulation else 1e-8
        assert np.cumsum(rows[:, Column.ENERGY_OUT]).max() <= allowed
    golden, pins = torques.values()
    assert golden < -5e-4
    assert pins == pytest.approx(golden, rel=0.05)


class Thief:
    """A host that always sends the largest wave, with the sign that helps the motion."""

    def step(self, v: float) -> float:
        return 127.0 if v >= 0.0 else -127.0


def test_no_host_can_take_energy_out(make_scene):
    scene = make_scene(*PRESS, "hand.path=sine", "hand.frequency_hz=5")
    simulation = HostedSimulation(scene, Thief(), 7, Line())
    rows = simulation.advance(1000)
    energy = np.cumsum(rows[:, Column.ENERGY_OUT])
    assert energy.max() <= 0.0
    # It got what the hand put in, nearly all of it: the budget is no mere brake.
    sent = np.sum(rows[:, Column.U] ** 2)
    assert sent > 0.5 * np.sum(rows[:, Column.V] ** 2)


def test_the_budget_is_needed(make_scene, monkeypatch):
    """The check can fail: with a budget that never ends the thief drives the motor."""
    scene = make_scene(*PRESS)
    simulation = HostedSimulation(scene, Thief(), 7, Line())
    energy = 0.0
    most = 0.0
    for _ in range(200):
        simulation.link[host_link.TANK] = host_link.TANK_MAX
        given = energy + np.cumsum(simulation.advance(1)[:, Column.ENERGY_OUT])
        energy, most = given[-1], max(most, given.max())
    assert most > 1e-3
