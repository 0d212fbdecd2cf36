# SPDX-License-Identifier: Apache-2.0
"""The port anchor at the pins: it holds what `golden` holds, and says when the encoder is lost."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.controller.guard import Fault, Limits
from wavehaptics.ladder.guarded_pins import GuardedPins, Injection
from wavehaptics.ladder.hosted import HostedSimulation, Line, PinsHostedSimulation, PowerEnvironment
from wavehaptics.ladder.run import CONTROLLERS
from wavehaptics.motor.plant import OMEGA
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.trace.columns import Column, Word

FAULTY = (
    "controller.anchor_auto=true", "brushes.drop_v=0.3", "brushes.knee_a=0.02",
    "drive.gain_error=-0.05", "adc.offset_a=3e-3",
)  # fmt: skip
"""Each of these alone loses the wall without an anchor."""

BOARD = (
    "controller.clock_hz=80e6", "drive.bus_v=12", "drive.pwm_hz=500e3", "adc.bits=12",
    "adc.full_scale_a=2.5", "adc.part=AD7276", "encoder.counts_per_rev=10000",
)  # fmt: skip


def advanced(simulation, seconds: float) -> np.ndarray:
    ticks = round(seconds / simulation.tick_s)
    rows = np.zeros((ticks, len(Column)))
    simulation.advance(rows, np.zeros((ticks, len(Word)), dtype=np.int64))
    return rows


def held(controller: str, *settings: str) -> tuple[float, float, float, float]:
    """Of the end of a run with all of FAULTY: x in cells, torque, its ripple, and any fault."""
    scene = load_scene(find_scene("press_hold"), [*BOARD, *FAULTY, *settings])
    simulation = CONTROLLERS[controller](scene)
    rows = advanced(simulation, scene.scene.duration_s)
    end = rows[-len(rows) // 20 :]
    torque = end[:, Column.TORQUE]
    if controller == "pins":
        assert simulation.faults == 0
    return (
        float(end[:, Column.X].mean() / simulation.settings.cell_rad), float(torque.mean()),
        float(torque.std()), float(rows[:, Column.FAULT].max()),
    )  # fmt: skip


@pytest.mark.kept("brushes")
@pytest.mark.parametrize(
    ("name", "begun"), [("held_wall", 0.25), ("brushless_hold", 0.5)], ids=["brushes", "brushless"]
)
def test_a_contact_begins_with_its_edge_whenever_that_comes(name: str, begun: float):
    """Walls are looked at in turn, so that a contact may be told a tick after its edge.

    χ is then what it is on `golden`, which is told of both at once; without the edge it is less by
    all of ``begun``. Of hits at one speed no two meet the same part of a tick.
    """
    base = load_scene(find_scene(name))
    for n in range(12):
        hand = f"hand.amplitude_rad={base.hand.amplitude_rad * (1 + 0.003 * n)}"
        scene = load_scene(find_scene(name), [hand, "scene.duration_s=0.006"])
        found = {}
        for controller in ("golden", "pins"):
            rows = advanced(CONTROLLERS[controller](scene), scene.scene.duration_s)
            (first,) = np.flatnonzero(np.diff(rows[:, Column.CONTACT]) > 0)[:1]
            found[controller] = rows[first + 1, Column.FLUX]
        assert found["pins"] == pytest.approx(found["golden"], abs=0.4 * begun)


@pytest.mark.kept("settings3-0.0")
@pytest.mark.parametrize(
    ("settings", "pressed_nm"),
    [
        (("controller.extra_ticks=1",), 0.014),
        (("controller.extra_ticks=1", "drive.bus_actual_v=10", "drive.bus_measured=true"), 0.014),
        (
            ("controller.extra_ticks=2", "shaper.feel=layer", "shaper.stiffness=0.5",
             "shaper.damping=0.1e-3"),
            0.012,
        ),
        # A damper gives way until nothing presses.
        (("controller.extra_ticks=1", "controller.eta_contact=-0.6"), 0.0),
    ],
)  # fmt: skip
def test_pins_hold_what_golden_holds(settings, pressed_nm):
    """Brushes of 0.3 V, 5 % too little voltage and 3 mA: within a cell, and quiet."""
    settings = (*settings, "scene.duration_s=0.4")
    x, torque, ripple, fault = held("pins", *settings)
    expected_x, expected, _, _ = held("golden", *settings)
    assert fault == 0
    assert x == pytest.approx(expected_x, abs=1.0)
    assert torque == pytest.approx(expected, rel=0.02, abs=2e-5)
    assert ripple < 6e-5
    assert -torque == pytest.approx(pressed_nm, abs=5e-4)


def turning(damps: bool) -> GuardedPins:
    """A free rotor at 60 rad/s whose encoder stops after 20 ms."""
    settings = (
        *BOARD, "controller.anchor_auto=true", "hand.path=impact", "hand.amplitude_rad=3",
        "hand.speed_rad_s=60", "scene.duration_s=0.1",
    )  # fmt: skip
    limits = Limits(watched=(Fault.ANCHOR,), damp=(Fault.ANCHOR,) if damps else ())
    return GuardedPins(load_scene(find_scene("impact"), settings), limits)


@pytest.mark.parametrize("damps", [False, True])
def test_an_encoder_that_stops_is_told(damps):
    """Fault ANCHOR alone; the gates go off, or the port only damps from then on."""
    pins = turning(damps)
    assert pins.run(5_000)
    assert pins.report().faults == 0
    pins.inject(Injection.ENCODER_HOLDS)
    speed = pins.motor[OMEGA]
    went_on = pins.run(5_000)
    report = pins.report()
    assert report.faults == 1 << Fault.ANCHOR
    assert (report.running, went_on) == (damps, damps)
    assert damps or report.off >= report.cause
    assert abs(pins.motor[OMEGA]) <= 1.02 * abs(speed)


def hosted_scene(make_scene):
    return make_scene(
        *BOARD, *FAULTY, "controller.tick_hz=1e6", "controller.lambda=1e9", "hand.path=press",
        "hand.amplitude_rad=0.15", "hand.stiffness=0.1", "hand.damping=0.5e-3",
        "controller.eta_free=0.0",
    )  # fmt: skip


def test_a_host_feels_the_motor_that_the_anchor_makes(make_scene):
    """Behind brushes, gain error and offset a host's spring is what it is on the ideal motor."""
    found = {}
    for make in (HostedSimulation, PinsHostedSimulation):
        scene = hosted_scene(make_scene)
        motor, r_hat = scene.motor, scene.controller.r_hat * scene.controller.r_hat_part
        environment = PowerEnvironment(0.1, 1e-3, motor.k_t, r_hat, 256e-6)
        simulation = make(scene, environment, 8, Line(1e-3))
        rows = simulation.advance(1200)
        assert rows[-1, Column.CONTACT] == 1.0
        assert rows[:, Column.FAULT].max() == 0.0
        found[make] = rows[-10_000:, Column.X].mean() / simulation.settings.cell_rad
    golden, pins = found.values()
    assert pins == pytest.approx(golden, abs=2.0)
