# SPDX-License-Identifier: Apache-2.0
"""A bus that isn't what the scene says: what it does, and what measuring it makes good."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wavehaptics.controller import bus_scale
from wavehaptics.controller.ports import controller_ports
from wavehaptics.controller.settings import settings
from wavehaptics.ladder.analog import AnalogSimulation
from wavehaptics.ladder.brushless_pins import BrushlessPinsSimulation
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.ladder.run import measure, run_scene
from wavehaptics.scene import SCENES_DIR, SceneError, find_scene, load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats
from wavehaptics.words.bridge_modes import MODE_WORDS, UNIPOLAR

PAPER_TAPS = SCENES_DIR / "paper_taps.toml"
LOW = ("drive.bus_v=12", "drive.bus_actual_v=9.5")
RIPPLE = ("drive.bus_ripple_v=0.5", "drive.bus_ripple_hz=100")
MEASURED = ("drive.bus_measured=true",)
TAP = ("scene.duration_s=0.5",)

# Both signs in one run: a wall on either side of a hand that swings.
SWING = (
    "hand.path=sine",
    "hand.frequency_hz=20",
    "controller.walls=[[-1.0, -0.002], [0.002, 1.0]]",
    "scene.duration_s=0.05",
)
# More than 12 V would be needed.
HARD = (
    *SWING,
    "hand.stiffness=20",
    "hand.amplitude_rad=0.2",
    "drive.limit_v=12",
    "adc.bits=12",
    "adc.full_scale_a=12",
    "scene.trace_hz=1e6",
)


def load(*settings: str, name: str = "paper_taps"):
    return load_scene(find_scene(name), settings)


def test_a_measured_bus_leaves_the_wall_as_it_is():
    """Torque, stiffness and energy are those on the 12 V that the scene has."""
    true = measure(load("drive.bus_v=12", *TAP), "pins")
    found = measure(load(*LOW, *RIPPLE, *MEASURED, *TAP), "pins")
    assert found["torque_nrmse_vs_analog"] <= 5e-3
    assert found["torque_nrmse_vs_analog"] <= 2 * true["torque_nrmse_vs_analog"]
    assert found["stiffness"] == pytest.approx(found["stiffness_predicted"], rel=0.01)
    assert found["energy_out_max_j"] < 1e-8


def test_without_it_the_wall_is_lost():
    """A fifth of the voltage less is a fifth of R̂ less: the force dies away within a tap."""
    found = measure(load(*LOW, *RIPPLE, *TAP), "pins")
    assert found["stiffness"] < 0.2 * found["stiffness_predicted"]
    assert found["peak_torque"] < 0.05 * 0.021


@pytest.mark.parametrize("ripple", [(), RIPPLE])
def test_what_the_bus_cannot_reach_is_not_taken_for_applied(ripple, tmp_path):
    """6 V where the limit is 12: the mean voltage of every few ticks is s u, and nothing comes out.

    A tick alone differs by what the error feedback owes, half a clock of the pulse: 0.25 V.
    """
    scene = load("drive.bus_v=12", "drive.bus_actual_v=6", *ripple, *MEASURED, *HARD)
    found = run_scene(scene, "pins", tmp_path)
    trace = np.load(tmp_path / "trace.npz")
    s = math.sqrt(2 * scene.motor.R_ohm)
    owed = np.convolve(trace["e_a"] - s * trace["u"], np.full(16, 1 / 16), "valid")
    assert np.abs(owed).max() < 0.03
    top = 6.0 + (0.5 if ripple else 0.0)
    assert top - 0.01 < s * np.abs(trace["u"]).max() <= top
    assert found["saturated_fraction"] > 0.3
    assert trace["torque"].min() < -0.05
    assert trace["torque"].max() > 0.05
    assert found["energy_out_max_j"] < 1e-8


def test_a_limit_that_is_not_shrunk_is_seen(tmp_path, monkeypatch):
    """The check above can fail."""
    monkeypatch.setattr(bus_scale, "bus_share_word", lambda *_: formats.BUS_SHARE.raw_max)
    scene = load("drive.bus_v=12", "drive.bus_actual_v=6", *MEASURED, *HARD)
    run_scene(scene, "pins", tmp_path)
    trace = np.load(tmp_path / "trace.npz")
    owed = trace["e_a"] - math.sqrt(2 * scene.motor.R_ohm) * trace["u"]
    assert np.abs(np.convolve(owed, np.full(16, 1 / 16), "valid")).max() > 0.3


@pytest.mark.kept("sign-magnitude")
@pytest.mark.parametrize("mode", [mode for mode in MODE_WORDS if mode != UNIPOLAR])
def test_every_mode_is_scaled(mode):
    scene = load(
        *LOW, *RIPPLE, *MEASURED, *SWING, f"drive.mode={mode}", "controller.clock_hz=100e6"
    )
    found = measure(scene, "pins")
    assert found["torque_nrmse_vs_analog"] < 5e-3
    assert found["stiffness"] == pytest.approx(found["stiffness_predicted"], rel=0.01)


def test_the_word_of_the_limit():
    """Half of the bus that the limit takes leaves half of u_max."""
    scene = load(*LOW, *MEASURED, "drive.limit_v=8")
    words = controller_ports(scene).words
    whole = 1 << bus_scale.SHARE_Q
    for bus_v, part in ((12.0, 1.0), (8.1, 1.0), (4.0, 0.5), (1.0, 0.125), (0.0, 0.0)):
        found = bus_scale.share(bus_scale.bus_word(bus_v), words["bus_share"])
        assert found == pytest.approx(part * whole, rel=1e-4)
    assert bus_scale.bus_word(1e6) == (1 << formats.BUS_W) - 1
    # What the compensation of the dead time takes, the bus has to have besides.
    dead = controller_ports(load(*LOW, *MEASURED, "drive.limit_v=8", "drive.dead_time_s=50e-9"))
    lost = dead.words["dead_clocks"] / dead.timing.half_clocks
    assert dead.words["bus_share"] == pytest.approx(words["bus_share"] * (1 - lost), rel=1e-6)


def test_without_a_bridge_a_bus_is_a_gain_or_a_limit():
    unmeasured, measured = load(*LOW, *TAP), load(*LOW, *MEASURED, *TAP)
    assert unmeasured.drive.gain == pytest.approx(9.5 / 12)
    assert measured.drive.gain == 1.0
    both = load(*LOW, "drive.gain_error=0.1")
    assert both.drive.gain == pytest.approx(1.1 * 9.5 / 12)
    reach = ("drive.limit_v=11",)
    assert settings(load(*LOW, *reach)).limit_v == 11.0
    assert settings(load(*LOW, *reach, *MEASURED)).limit_v == 9.5
    half = ("drive.mode=half-bridge", "drive.limit_v=5.5")
    assert settings(load(*LOW, *half, *MEASURED)).limit_v == 4.75
    assert AnalogSimulation(load(*LOW, *reach, *MEASURED)).settings.limit_v == 9.5
    # On pins the RTL does it.
    assert PinsSimulation(load(*LOW, *reach, *MEASURED)).settings.limit_v == 11.0
    plain = measure(load("drive.gain_error=0.05", *TAP), "golden")
    found = measure(load("drive.bus_v=10", "drive.bus_actual_v=10.5", *TAP), "golden")
    assert found["stiffness"] == pytest.approx(plain["stiffness"], rel=1e-6)


# ---- A supply that takes nothing back.

# A damper of η = 0.6 brakes a bare rotor by its back-EMF alone: most of its energy returns.
BRAKE = """
[scene]
name = "brake"
duration_s = 0.06
[motor]
preset = "gbm2804-100t"
[hand]
path = "impact"
amplitude_rad = 0.005
speed_rad_s = 130.0
[encoder]
counts_per_rev = 10_000
[drive]
bus_v = 6.0
supply_sinks = false
bus_farad = 100e-6
[controller]
tick_hz = 400e3
lambda = 1e4
eta_contact = 0.6
walls = [[0.0, 100.0]]
"""
RE25 = ("motor.preset=re25-118743", "drive.bus_v=12", "hand.speed_rad_s=200")


def brake(tmp_path, *settings: str):
    """(scene, simulation, rows) of a braked rotor on `pins`."""
    path = tmp_path / "brake.toml"
    path.write_text(BRAKE)
    scene = load_scene(path, settings)
    kind = BrushlessPinsSimulation if scene.motor.brushless else PinsSimulation
    pins = kind(scene)
    rows = np.zeros((round(scene.scene.duration_s / pins.tick_s), len(Column)))
    pins.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    return scene, pins, rows


@pytest.mark.parametrize("settings", [(), RE25], ids=["brushless", "brushes"])
def test_a_braked_rotor_charges_the_bus(tmp_path, settings):
    """What the rotor lost is in the copper and on the capacitors: by ω and i alone, within 2 %.

    All of the brushless rotor's 19 mJ would lift 100 µF from 6 to 20.6 V.
    """
    scene, pins, rows = brake(tmp_path, *settings)
    motor, first_v, farad = scene.motor, scene.drive.bus_v, scene.drive.bus_farad
    phases = 1.5 if motor.brushless else 1.0  # of three sines, in squares of their amplitude
    copper = np.cumsum(phases * motor.R_ohm * rows[:, Column.I] ** 2) * pins.tick_s
    lost = 0.5 * motor.J_kgm2 * (scene.hand.speed_rad_s**2 - rows[:, Column.OMEGA] ** 2)
    returned = lost - copper
    highest_v = math.sqrt(first_v**2 + 2 * returned.max() / farad)
    assert highest_v > 1.3 * first_v
    assert pins.bus_highest_v == pytest.approx(highest_v, rel=0.02)
    if not settings:
        whole = 0.5 * motor.J_kgm2 * scene.hand.speed_rad_s**2
        assert whole == pytest.approx(19e-3, rel=0.03)
        assert 15.0 < highest_v < math.sqrt(first_v**2 + 2 * whole / farad)


def test_the_drive_follows_the_bus_that_rises(tmp_path):
    """Not measured it brakes otherwise than asked for; measured as a supply that sinks does."""
    path = tmp_path / "sinks.toml"
    path.write_text(BRAKE.replace("supply_sinks = false\nbus_farad = 100e-6\n", ""))
    asked = load_scene(path, RE25)
    rows = np.zeros((24_000, len(Column)))
    pins = PinsSimulation(asked)
    pins.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    assert pins.bus_highest_v is None
    assert "bus_highest_v" not in measure(asked, "golden", compare=False)
    _, _, unmeasured = brake(tmp_path, *RE25)
    _, _, measured = brake(tmp_path, *RE25, *MEASURED)
    end = rows[-1, Column.OMEGA]
    assert measured[-1, Column.OMEGA] == pytest.approx(end, rel=0.01)
    assert unmeasured[-1, Column.OMEGA] > 1.1 * end


def test_a_clear_metric_of_the_bus(tmp_path):
    path = tmp_path / "brake.toml"
    path.write_text(BRAKE)
    found = run_scene(load_scene(path, ("scene.duration_s=0.01",)), "pins", tmp_path / "run")
    assert 6.0 < found["bus_highest_v"] < 20.0


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (("bus_actual_v=9",), "bus_actual_v needs to know the bus; give bus_v"),
        (("bus_measured=true",), "bus_measured needs to know the bus; give bus_v"),
        (("bus_v=12", "bus_ripple_v=1"), "bus_ripple_v has no frequency; give bus_ripple_hz"),
        (("bus_v=12", "bus_ripple_hz=1"), "bus_ripple_hz has no amplitude; give bus_ripple_v"),
        (
            ("bus_v=12", "bus_actual_v=2", "bus_ripple_v=2", "bus_ripple_hz=1"),
            "bus_ripple_v = 2 on bus_actual_v = 2 leaves 0 to 127 V; it must be below 2",
        ),
        (
            ("bus_v=120", "bus_ripple_v=8", "bus_ripple_hz=1"),
            "bus_ripple_v = 8 on bus_v = 120 leaves 0 to 127 V; it must be below 7",
        ),
        (("bus_farad=1e-4", "supply_sinks=false"), "bus_farad needs to know the bus; give bus_v"),
        (("bus_v=12", "supply_sinks=false"), "what the bridge returns; give bus_farad"),
        (("bus_v=12", "bus_farad=1e-4"), "where the supply sinks; add supply_sinks = false"),
        (
            ("bus_v=12", "bus_farad=1e-4", "supply_sinks=false", "sag_ohm=1"),
            "supply_sinks = false does by bus_farad; leave one out",
        ),
        (("bus_v=12", "bus_actual_v=0"), "bus_actual_v = 0 is out of range"),
    ],
)
def test_a_bus_that_cannot_be_is_refused(tmp_path, keys, message):
    scene = tmp_path / "no_drive.toml"
    scene.write_text(PAPER_TAPS.read_text().replace("limit_v = 2.1", ""))
    with pytest.raises(SceneError, match=r"^--set drive\.[^\n]*$") as refused:
        load_scene(scene, [f"drive.{key}" for key in keys])
    assert message in str(refused.value)
