# SPDX-License-Identifier: Apache-2.0
"""Brushless motors identified: what is found, where the magnets are, and faults by name."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest
from quick_brushless import QuickBrushless, Wiring
from virtual_boards import told, virtual_board
from wavehaptics.controller import rotor_flux
from wavehaptics.host.identify import result
from wavehaptics.host.identify.brushless import FoundBrushless
from wavehaptics.host.identify.driver import Driver
from wavehaptics.host.identify.identification import identify
from wavehaptics.host.identify.steps import NotPlausible, Wishes
from wavehaptics.host.names import HostError, Shape
from wavehaptics.ladder.run import measure
from wavehaptics.parts.motors import BRUSHLESS_PRESETS, PRESETS
from wavehaptics.scene import load_scene
from wavehaptics.words.table import THREE_PHASE_LEGS

GIMBAL = BRUSHLESS_PRESETS["gbm2804-100t"]
MOTORS = {
    "gimbal": {},
    "few pairs": {"pairs": 2, "flux": 20e-3, "inertia": 1e-5, "place": -0.9},
    "many pairs": {"pairs": 21, "flux": 2.4e-3, "ohm": 0.8, "henry": 0.2e-3, "place": 2.0,
                   "inertia": 63e-6, "friction": 3e-3},
}  # fmt: skip


def identified(quick: QuickBrushless, wishes: Wishes) -> tuple[FoundBrushless, list[str]]:
    told: list[str] = []
    found = identify(quick, wishes, told.append)
    assert isinstance(found, FoundBrushless)
    return found, told


@pytest.mark.parametrize("name", MOTORS)
def test_motors(name: str):
    quick = QuickBrushless(**MOTORS[name])
    found, told = identified(quick, Wishes(40_000))
    pairs, flux = MOTORS[name].get("pairs", 7), MOTORS[name].get("flux", 3.82e-3)
    turning, motion = found.magnets, found.mechanics
    assert turning.pole_pairs == pairs
    for what, estimate, true, part in (
        ("R", turning.ohm, MOTORS[name].get("ohm", 4.7), 0.005),
        ("L_q", found.inductance, MOTORS[name].get("henry", 0.96e-3), 0.03),
        ("L_d", found.inductance_d, MOTORS[name].get("henry", 0.96e-3), 0.03),
        ("ψ", turning.flux, flux, 0.01),
        ("k_T", turning.k_t, 1.5 * pairs * flux, 0.01),
        ("J", motion.inertia, MOTORS[name].get("inertia", 2.3e-6), 0.05),
        ("friction", motion.coulomb, MOTORS[name].get("friction", 0.5e-3), 0.1),
    ):
        assert estimate.value == pytest.approx(true, rel=part), what
        assert 0 < estimate.sd < 2 * part * true, what
        if what in ("R", "L_q", "L_d", "ψ"):
            assert abs(estimate.value - true) < 5 * estimate.sd + 5e-4 * true, what
    off = (found.magnet_place.value - MOTORS[name].get("place", 0.3)) * pairs / (2 * math.pi)
    assert abs(off - round(off)) * 360 < 1.0  # a degree of a turn of the magnets
    assert not quick.armed
    assert quick.given == (pairs, 40_000, found.magnet_place.value)
    assert told[-1] == "magnets: the device knows where they are"


@pytest.mark.parametrize(
    ("fault", "wiring", "others"),
    [
        ("encoder reversed", Wiring(encoder=-1), {}),
        ("encoder silent", Wiring(encoder=0), {}),
        ("current reversed", Wiring(reversed=True), {}),
        ("phases", Wiring(swapped=True), {}),
        ("phases", Wiring(open_lead=2), {}),
        ("phases", Wiring(open_lead=0), {}),
        ("unplugged", Wiring(), {"ohm": 1e5}),
        ("no motor", Wiring(), {"ohm": 150.0}),
        ("shorted", Wiring(), {"ohm": 0.02, "flux": 1e-5, "henry": 2e-5}),
        ("jammed", Wiring(), {"friction": 1.0}),
        ("zero", Wiring(), {"offset_a": 0.1}),
        ("pole pairs", Wiring(), {"inertia": 4e-4}),
        ("wrong counts", Wiring(counts=20_000), {}),
        ("wrong motor", Wiring(), {"ohm": 9.0}),
    ],
)
def test_faults_by_name(fault: str, wiring: Wiring, others: dict):
    """One line that begins with the fault and says what to check; the device isn't told a place."""
    quick = QuickBrushless(wiring=wiring, **others)
    with pytest.raises(NotPlausible) as error:
        identified(quick, Wishes(40_000, expected=GIMBAL))
    assert error.value.fault == fault
    assert re.fullmatch(rf"{fault}: [^\n]+; check [^\n]+", str(error.value))
    assert not quick.armed
    assert quick.given is None


def test_another_kind_of_motor_is_not_expected():
    with pytest.raises(HostError, match=r"^--expect: the device drives a brushless motor; "):
        identified(QuickBrushless(), Wishes(40_000, expected=PRESETS["re25-118743"]))


def test_little_room():
    with pytest.raises(HostError, match=r"out of --travel 0\.1; take less than"):
        identified(QuickBrushless(), Wishes(40_000, travel_rad=0.1))


def test_a_salient_motor():
    """A row of each axis, and l_d_part in the scene."""
    found, told = identified(QuickBrushless(d_part=0.8), Wishes(40_000))
    assert found.salient
    assert found.inductance.value == pytest.approx(0.96e-3, rel=0.03)
    assert found.inductance_d.value == pytest.approx(0.8 * 0.96e-3, rel=0.03)
    rows = {row.name: row for row in result.rows(found)}
    assert {"L_q", "L_d"} < rows.keys()
    assert any(re.match(r"L: 0\.9\d+ ± \S+ mH along q, 0\.7\d+ ±", line) for line in told)


def test_what_is_told():
    found, _ = identified(QuickBrushless(), Wishes(40_000))
    assert not found.salient
    rows = {row.name: row for row in result.rows(found)}
    assert "L" in rows
    assert rows["pole pairs"].value == "7"
    turns = float(rows["θ at x = 0"].value) / 360 + 7 * 0.3 / (2 * math.pi)
    assert abs(turns - round(turns)) < 2e-3


SCENE = """
[scene]
name = "virtual"
duration_s = 1.0
[motor]
preset = "gbm2804-100t"
magnet_rad = 0.3
harmonic_5 = 0.03
[friction]
coulomb_nm = 0.5e-3
viscous = 5e-6
[encoder]
counts_per_rev = 40_000
[adc]
bits = 12
full_scale_a = 1.0
noise_a = 0.5e-3
offset_a = 4e-3
[drive]
bus_v = 12.0
[controller]
tick_hz = 25e3
clock_hz = 2e6
extra_ticks = 2
lambda = 1e6
walls = [[0.0, 1.0]]
anchor_auto = true
"""


@pytest.mark.long
def test_identified_over_the_line(tmp_path: Path):
    """The whole RTL at its line; the device knows its angle then, and a wall made so holds."""
    scene, file = tmp_path / "scene.toml", tmp_path / "found.toml"
    scene.write_text(SCENE)
    with virtual_board(scene) as port:
        status, out, err = told(
            port, "identify", "--counts", "40000", "--timeout", "60", "--out", str(file),
            "--expect", "gbm2804-100t",
        )  # fmt: skip
        assert (status, err) == (0, "")
        assert "magnets: the device knows where they are\n" in out
        assert told(port, "load", str(tmp_path / "found.words.toml"))[0] == 0
        status, out, err = told(port, "get", "position", "magnet_angle", "magnet_found")
    assert (status, err) == (0, "")
    position, angle, known = (int(line.split()[1]) for line in out.splitlines())
    assert known == 1
    found = load_scene(file)
    motor = found.motor
    assert motor.pole_pairs == GIMBAL.pole_pairs
    assert motor.R_ohm == pytest.approx(GIMBAL.R_ohm, rel=0.005)
    assert motor.L_h == pytest.approx(GIMBAL.L_h, rel=0.03)
    assert motor.psi_vs == pytest.approx(GIMBAL.psi_vs, rel=0.01)
    assert motor.J_kgm2 == pytest.approx(GIMBAL.J_kgm2, rel=0.05)
    assert found.friction.coulomb_nm == pytest.approx(0.5e-3, rel=0.1)
    off = GIMBAL.pole_pairs * ((position + 0.5) / 40_000 - 0.3 / (2 * math.pi)) - angle / 2**32
    assert abs(off - round(off)) * 360 < 2.0
    press = load_scene(
        scene,
        (
            "scene.duration_s=1.5", "hand.path=press", "hand.amplitude_rad=0.15",
            "hand.stiffness=0.05", "hand.damping=0.3e-3", "adc.offset_a=2e-3",
            "controller.tick_hz=5e5", "controller.lambda=5e5", "controller.clock_hz=48e6",
            f"controller.r_hat={motor.R_ohm}", f"controller.l_hat={motor.L_h}",
            f"controller.k_t_hat={motor.felt_k_t}",
            f"controller.magnet_hat_rad={motor.magnet_rad}",
        ),
    )  # fmt: skip
    held = measure(press, "golden", compare=False)
    depth = held["peak_torque"] / held["stiffness_predicted"]
    assert abs(held["hold_offset_rad"]) < 0.5 * 2 * math.pi / 40_000 + 0.01 * depth


class Restless:
    """A device with the magnets' words, whose rotor has moved at every look but the last few."""

    shape = Shape(1, 4, 0, 10, THREE_PHASE_LEGS)

    def __init__(self, moves: int) -> None:
        self.words = {"count_angle": 5, "zero_angle": 6, "find_magnet": 1, "position": 0}
        self.moves, self.starts = moves, 0

    def read(self, places):
        found = [place.word.name for place in places]
        if found == ["position"] and self.moves:
            self.moves -= 1
            self.words["position"] += 1
        return [self.words[name] for name in found]

    def write(self, words) -> int:
        for place, raw in words:
            if place.word.name == "magnet_start":
                self.starts += 1
            else:
                self.words[place.word.name] = raw
        return 1


@pytest.mark.parametrize("moves", [0, 5, 1000])
def test_magnets_of_a_rotor_that_moves(moves: int):
    """The angle is that of where it stands at last, or the device has its own words again."""
    device = Restless(moves)
    driver = object.__new__(Driver)
    driver._device, driver._motor, driver._sensors = device, 0, range(2)
    driver._armed, driver.arms, driver._ended = False, True, lambda: False
    given = driver.give_magnets(7, 40_000, 0.3)
    assert given == (moves < 1000)
    found = [device.words[name] for name in ("count_angle", "zero_angle", "find_magnet")]
    if given:
        cell = 2 * math.pi / 40_000
        zero = rotor_flux.zero_word(7, cell, 0.3, device.words["position"])
        assert found == [rotor_flux.count_word(7, cell), zero, 0]
    else:
        assert found == [5, 6, 1]
    assert device.starts >= 1
