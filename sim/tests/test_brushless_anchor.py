# SPDX-License-Identifier: Apache-2.0
"""The port anchors of a brushless motor's two axes: what they are told, and what they hold."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from wavehaptics.controller import anchor, rotor_flux
from wavehaptics.controller.settings import settings
from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.laws import closed_forms
from wavehaptics.laws.anchor_choice import ZERO_PER_S, choose_zero_rate
from wavehaptics.parts.motors import BRUSHLESS_PRESETS
from wavehaptics.scene import SCENES_DIR, Scene, SceneError, load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats

CELL = 1 << formats.LONG.fraction
TABLE = rotor_flux.sine_table()
COUNTS, PAIRS = 10_000, 7
CELL_RAD = 2 * math.pi / COUNTS
ANGLES = [n * math.pi / 4 for n in range(8)]
AXES_CLOCKS = 61
"""Of a step of both ports and, behind it, both anchors."""
GIMBAL = BRUSHLESS_PRESETS["gbm2804-100t"]


TURN = rotor_flux.count_word(PAIRS, CELL_RAD)


def rotor(magnet_rad: float = 0.0, start: int = 0) -> np.ndarray:
    """State of a rotor at ``start``."""
    zero = rotor_flux.zero_word(PAIRS, 2 * math.pi / COUNTS, magnet_rad, start)
    return rotor_flux.new_state(start, zero)


def flux_at(count: float, magnet_rad: float) -> np.ndarray:
    """Both axes' flux in cells with the rotor at the middle of a count."""
    radius = COUNTS / (2 * math.pi * PAIRS)
    theta = PAIRS * (2 * math.pi / COUNTS * (count + 0.5) - magnet_rad)
    return radius * np.array([math.cos(theta), math.sin(theta)])


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("magnet_rad", [0.0, 0.3, -2.1])
def test_counts_add_up_to_the_magnets_flux(magnet_rad: float, way: int):
    state = rotor(magnet_rad)
    for count in range(way, 3 * COUNTS * way // PAIRS, way):
        rotor_flux.rotor_flux_step(state, TURN, TABLE, count)
        place = np.array([state[rotor_flux.PLACE_A], state[rotor_flux.PLACE_B]]) / CELL
        wanted = flux_at(count, magnet_rad) - flux_at(0, magnet_rad)
        assert np.abs(place - wanted).max() < 0.35  # half an entry of the table over the radius


def test_the_way_back_takes_off_the_very_words():
    state = rotor()
    chance = np.random.default_rng(1)
    for count in np.cumsum(chance.integers(-5, 6, 3000)).tolist():
        rotor_flux.rotor_flux_step(state, TURN, TABLE, count)
    assert state[rotor_flux.PLACE_A] != 0
    rotor_flux.rotor_flux_step(state, TURN, TABLE, 0)
    assert state[rotor_flux.PLACE_A] == state[rotor_flux.PLACE_B] == 0
    assert state[rotor_flux.ANGLE] == rotor()[rotor_flux.ANGLE]


def test_a_leap_is_its_counts_one_after_the_other():
    one, many = rotor(0.1, 5), rotor(0.1, 5)
    for count in range(6, 406):
        rotor_flux.rotor_flux_step(one, TURN, TABLE, count)
    rotor_flux.rotor_flux_step(many, TURN, TABLE, 405)
    assert (one == many).all()


OF_THE_MEANS = [
    anchor.MEAN, anchor.BRUSH_LEFT, anchor.TOLD, anchor.THETA,
    anchor.COEFFICIENT, anchor.FULL, anchor.CORRECTION, anchor.CLIPPED, anchor.EXCUSES,
    anchor.FAULT, anchor.ROOM,
    anchor.ZERO, anchor.OFFSET, anchor.FOLLOWER, anchor.LAG, anchor.COPIES, anchor.PHASE,
]  # fmt: skip
"""What follows from an axis' slower means and from what it takes of z within the zone."""


def test_an_axis_that_a_count_moves_by_a_cell_has_the_flux_of_a_motor_with_brushes():
    """Its flux, edges, zone and bounds; its means are slower."""
    chance = np.random.default_rng(2)
    words = settings(load_scene(SCENES_DIR / "held_wall.toml")).anchor
    axis, port = anchor.new_state(), anchor.new_state()
    position, way = 0, 1
    touching = False
    for _ in range(20_000):
        # Leaps turn it, single counts don't: at such a turn an axis gives more way.
        moved = way * int(chance.choice([0, 0, 0, 0, 1, 2, -2]))
        way = -1 if moved < 0 else 1 if moved > 0 else way
        position += moved
        current, u, v, withheld, voltage = chance.integers(-(1 << 24), 1 << 24, 5).tolist()
        contact, saturated = chance.random() < 0.9, chance.random() < 0.1
        tick = (contact, current, u, v, withheld // 16, voltage, saturated)
        place = (position & ((1 << (formats.LONG.width - formats.LONG.fraction)) - 1)) * CELL
        anchor.anchor_step(port, words, position, *tick)
        anchor.anchor_axis_step(axis, words, position, place, CELL, *tick)
        axis[anchor.PLACE] = 0
        assert axis[anchor.STARTED] == 1
        begins = port[anchor.TOUCHING] and not touching
        if begins and port[anchor.FRESH]:
            # Half a cell where the other has a quarter, besides what the filter holds.
            begun = (-1 if port[anchor.NEGATIVE] else 1) * CELL
            assert axis[anchor.FLUX] - port[anchor.FLUX] == (begun >> 1) - (begun >> 2)
            axis[:] = port
        touching = bool(port[anchor.TOUCHING])
        # A bound lasts until the next edge, an axis' own until it has been kept.
        assert axis[anchor.BOUND] <= port[anchor.BOUND]
        axis[anchor.BOUND] = port[anchor.BOUND]
        axis[OF_THE_MEANS] = port[OF_THE_MEANS]
        assert (axis == port).all()
        axis[anchor.PLACE] = place


def held(*sets: str) -> Scene:
    return load_scene(SCENES_DIR / "brushless_hold.toml", sets)


def cells_off(scene: Scene, controller: str = "golden") -> tuple[float, float, np.ndarray]:
    """(Cells off the spring of what the controller believes, ripple, rows of the last tenth).

    The spring is that of the closed form, its sine and all, with the motor's own k_T where it is.
    """
    simulation = CONTROLLERS[controller](scene)
    rows = np.zeros((round(scene.scene.duration_s / simulation.tick_s), len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    if controller == "pins":
        assert simulation.faults == 0
    end = rows[-len(rows) // 10 :]
    motor, control, set_ = scene.motor, scene.controller, simulation.settings
    k_t = math.sqrt(motor.felt_k_t * control.k_t_hat)
    spring = k_t**2 / closed_forms.l_eff(control.l_hat, set_.r_hat, set_.tau)
    x = end[:, Column.X].mean()
    theta = motor.pole_pairs * (x - motor.magnet_rad)
    own = closed_forms.brushless_own_k_t(theta, motor.harmonic_5, motor.harmonic_7)
    torque = -end[:, Column.TORQUE].mean() / own
    depth = math.asin(torque * motor.pole_pairs / spring) / motor.pole_pairs
    cell = set_.cell_rad
    return (x - depth) / cell, end[:, Column.TORQUE].std(), end


@pytest.mark.parametrize("theta", ANGLES, ids=lambda theta: f"{math.degrees(theta):.0f}-degrees")
def test_a_held_wall_with_everything_wrong(theta: float):
    magnet = theta / GIMBAL.pole_pairs
    wrong = magnet - math.radians(5.0) / GIMBAL.pole_pairs
    cells, ripple, end = cells_off(
        held(f"motor.magnet_rad={magnet}", f"controller.magnet_hat_rad={wrong}",
             "scene.duration_s=1.0")
    )  # fmt: skip
    assert end[:, Column.CONTACT].all()
    assert not end[:, Column.FAULT].any()
    assert abs(cells) < 1.0 + 0.01 * end[:, Column.X].mean() / CELL_RAD
    assert ripple < 0.01 * abs(end[:, Column.TORQUE].mean())


@pytest.mark.parametrize("depth", [9.7, 9.9, 10.1, 10.3])
def test_a_held_wall_rests_within_a_count(depth: float):
    """Of the design spring, wherever between two edges the hand asks it to, and still."""
    stiffness, scene = 0.05, held("scene.duration_s=1.0", "controller.magnet_hat_rad=0.3")
    set_, motor, control = settings(scene), scene.motor, scene.controller
    k_t = math.sqrt(motor.felt_k_t * control.k_t_hat)
    spring = k_t**2 / closed_forms.l_eff(control.l_hat, set_.r_hat, set_.tau)
    count = round(depth)
    own = closed_forms.brushless_own_k_t(
        motor.pole_pairs * (count * CELL_RAD - motor.magnet_rad), motor.harmonic_5, 0.0
    )
    # Where the hand has to be for that force with the rotor at the count.
    hand = count * CELL_RAD + own * spring * depth * CELL_RAD / stiffness
    pressed = held(
        "scene.duration_s=1.0", "controller.magnet_hat_rad=0.3",
        f"hand.stiffness={stiffness}", f"hand.amplitude_rad={hand}",
    )  # fmt: skip
    cells, ripple, end = cells_off(pressed)
    assert not end[:, Column.FAULT].any()
    assert abs(cells) < 1.0
    assert ripple < 0.01 * abs(end[:, Column.TORQUE].mean())


@pytest.mark.parametrize(
    "faults",
    [
        ("controller.r_hat=4.23",),
        ("controller.r_hat=5.17",),
        ("adc.offset_a=-4e-3",),
        ("drive.gain_error=-0.05",),
        ("controller.l_hat=0.864e-3",),
        ("controller.l_hat=1.056e-3",),
        ("controller.k_t_hat=0.0295",),
        ("controller.k_t_hat=0.036",),
        ("motor.l_d_part=0.9",),
        ("motor.harmonic_7=0.02", "motor.harmonic_5=-0.05"),
    ],
    ids=lambda faults: faults[0].partition(".")[2],
)
def test_a_held_wall_with_each_fault(faults: tuple[str, ...]):
    plain = (
        "controller.r_hat=4.7", "drive.gain_error=0", "adc.offset_a=0",
        "controller.magnet_hat_rad=0.3", "motor.harmonic_5=0", "scene.duration_s=0.5",
    )  # fmt: skip
    cells, ripple, end = cells_off(held(*plain, *faults))
    assert not end[:, Column.FAULT].any()
    assert abs(cells) < 0.5 + 0.02 * 10.8
    assert ripple < 0.01 * abs(end[:, Column.TORQUE].mean())


@pytest.mark.parametrize(
    ("tick_hz", "extra_ticks", "counts"), [(1e6, 1, 100_000), (1e5, 1, 100_000), (25e3, 2, 10_000)]
)
def test_a_tap_is_no_softer_than_without_learning(tick_hz: float, extra_ticks: int, counts: int):
    """K = k_T k̂_T/(L̂_eff + L̂ (R − R̂)/ρ) where p is all that c is made of; θ makes it stiffer."""
    scene = held(
        "hand.path='taps'", "hand.frequency_hz=10", "hand.amplitude_rad=0.05", "hand.stiffness=0.4",
        "controller.r_hat=4.7", "controller.magnet_hat_rad=0.3", "motor.harmonic_5=0",
        "drive.gain_error=0", "adc.offset_a=0", "scene.duration_s=0.3", "controller.lambda=1e4",
        f"controller.tick_hz={tick_hz}", f"controller.extra_ticks={extra_ticks}",
        f"encoder.counts_per_rev={counts}",
    )  # fmt: skip
    found = measure(scene, "golden", compare=False)
    motor, control, set_ = scene.motor, scene.controller, settings(scene)
    pull_v = formats.PULL.to_value(int(set_.anchor[anchor.PULL_GAIN]))
    ohm = pull_v * formats.CELLS.to_value(int(set_.anchor[anchor.CELLS_GAIN]))
    lacks = control.l_hat * (motor.R_ohm - set_.r_hat) / ohm
    inductance = closed_forms.l_eff(control.l_hat, set_.r_hat, set_.tau) + lacks
    expected = closed_forms.k_l(motor.felt_k_t, inductance)
    assert expected < 0.985 * found["stiffness_predicted"]
    assert expected < found["stiffness"] < 1.02 * found["stiffness_predicted"]


def test_without_anchors_the_wall_is_lost():
    bare = held("scene.duration_s=0.5", "drive.gain_error=0", "adc.offset_a=0",
                "controller.r_hat=4.747")  # fmt: skip
    control = bare.controller.model_copy(update={"anchor_auto": False, "r_hat_part": 1.0})
    cells, ripple, _ = cells_off(bare.model_copy(update={"controller": control}))
    assert abs(cells) > 1.0 or ripple > 1e-3


@pytest.mark.parametrize("magnet_rad", [0.0, 0.11, 0.45, 0.75])
@pytest.mark.parametrize("sign", [1, 0, -1])
@pytest.mark.parametrize("speed", [3.0, 10.0, 30.0])
def test_a_bare_rotor_comes_back_no_faster(
    speed: float, sign: int, magnet_rad: float, tmp_path: Path
):
    """With R̂, gain, offset and the back-EMF's shape wrong, or none of it."""
    scene = tmp_path / "bounce.toml"
    scene.write_text(f"""
        [scene]
        name = "brushless_bounce"
        duration_s = {0.04 / speed + 0.02}
        [motor]
        preset = "gbm2804-100t"
        magnet_rad = {magnet_rad}
        harmonic_5 = {0.03 * abs(sign)}
        [hand]
        path = "impact"
        amplitude_rad = 0.02
        speed_rad_s = {speed}
        [encoder]
        counts_per_rev = 10000
        [adc]
        bits = 12
        full_scale_a = 2.5
        noise_a = 0.5e-3
        offset_a = {2e-3 * sign}
        [drive]
        bus_v = 24
        gain_error = {0.05 * sign}
        [controller]
        tick_hz = 1e6
        lambda = 5e5
        walls = [[0.0, 1.0]]
        r_hat = {4.7 * (1 + 0.1 * sign)}
        anchor_auto = true
    """)
    metrics = measure(load_scene(scene), "golden")
    assert 0.85 < metrics["restitution"] <= 1.001
    assert metrics["correction_out_max_j"] < metrics["correction_bound_j"]


def test_a_cell_of_motion_teaches_little_of_an_offset():
    """Rate times k_T·Δ/R̂: what is learned of any motion from rest, in parts of the full scale."""
    assert choose_zero_rate(2.18, 23.4e-3 * CELL_RAD, 2.5) == ZERO_PER_S
    cell_vs = 0.098 * 2 * math.pi / 4020
    coarse = choose_zero_rate(0.57, cell_vs, 9.6)
    assert coarse * cell_vs / 0.57 == pytest.approx(8e-4 * 9.6)
    assert coarse < ZERO_PER_S / 5


def test_a_free_rotor_of_coarse_cells_keeps_its_speed(tmp_path: Path):
    """Of a strong motor, whose first cell looks like an offset: it went 1.3 to 2.5 rad/s from 2."""
    scene = tmp_path / "free.toml"
    scene.write_text("""
        [scene]
        name = "free_rotor"
        duration_s = 0.3
        [motor]
        kind = "pmsm"
        R_ohm = 0.6743
        L_h = 1.976e-4
        pole_pairs = 14
        psi_vs = 7.029e-3
        J_kgm2 = 1.399e-4
        magnet_rad = 0.003
        [hand]
        path = "impact"
        amplitude_rad = 0.01
        speed_rad_s = 2.0
        [encoder]
        counts_per_rev = 4020
        [adc]
        bits = 12
        full_scale_a = 9.627
        noise_a = 4.8e-3
        [drive]
        bus_v = 24
        [controller]
        tick_hz = 5e5
        lambda = 1e4
        walls = [[90.0, 91.0]]
        anchor_auto = true
    """)
    simulation = CONTROLLERS["golden"](load_scene(scene))
    rows = np.zeros((150_000, len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    omega = rows[1000:, Column.OMEGA]
    assert omega.min() > 0.93 * 2.0
    assert omega.max() < 1.05 * 2.0


def test_free_space_is_free_through_turns_of_the_magnets():
    scene = held("hand.path='sine'", "hand.amplitude_rad=0.6", "hand.frequency_hz=0.5",
                 "hand.damping=1e-3", "controller.walls=[[2.0, 3.0]]", "scene.duration_s=1.0",
                 "scene.trace_hz=1e3")  # fmt: skip
    simulation = CONTROLLERS["golden"](scene)
    rows = np.zeros((1_000_000, len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    assert np.ptp(rows[:, Column.X]) * GIMBAL.pole_pairs > 2 * math.pi / 2
    assert not rows[:, Column.FAULT].any()
    assert np.sqrt((rows[100_000:, Column.TORQUE] ** 2).mean()) < 100e-6


@pytest.mark.parametrize(
    "sets",
    [
        ("motor.magnet_rad=0.7", "controller.magnet_hat_rad=0.687", "encoder.counts_per_rev=4096"),
        ("hand.path='sine'", "hand.frequency_hz=5", "hand.amplitude_rad=0.6",
         "controller.tick_hz=20e3", "controller.lambda=1e4"),
        ("drive.limit_v=0.5", "controller.edge_hysteresis=true", "controller.extra_ticks=3"),
        ("drive.limit_v=0.3", "controller.anchor_limit_v=1.0"),
        ("hand.path='sine'", "hand.frequency_hz=3", "hand.amplitude_rad=0.3", "hand.damping=1e-3",
         "controller.find_magnet=true", "adc.offset_a=0.4e-3", "scene.duration_s=0.25",
         "controller.magnet_hat_rad=0", "motor.magnet_rad=0.05", "controller.walls=[[0.25, 1.0]]"),
    ],
    ids=["pressed", "counts-in-leaps", "limited", "no-room-left", "magnets-to-be-found"],
)  # fmt: skip
def test_core_is_golden(sets: tuple[str, ...]):
    scene = held("scene.duration_s=0.05", *sets)
    found = []
    for name in ("golden", "core"):
        simulation = CONTROLLERS[name](scene)
        ticks = round(scene.scene.duration_s / simulation.tick_s)
        rows, words = np.zeros((ticks, len(Column))), np.zeros((ticks, len(Word)), dtype=np.int64)
        simulation.advance(rows, words)
        found.append((rows, words))
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])
    finds = scene.controller.find_magnet
    assert np.count_nonzero(found[0][0][:, Column.CORRECTION]) > ticks / (10 if finds else 2)
    assert simulation.clock_cycles >= AXES_CLOCKS * ticks
    assert (simulation.clock_cycles > AXES_CLOCKS * ticks) == finds


FIND = (
    "hand.path='sine'", "hand.frequency_hz=3", "hand.amplitude_rad=0.3", "hand.damping=1e-3",
    "controller.find_magnet=true", "controller.magnet_hat_rad=0", "controller.walls=[[0.25, 1.0]]",
    "adc.offset_a=0.4e-3",
)  # fmt: skip


def found_at(scene: Scene, controller: str) -> tuple[int, float, np.ndarray]:
    """(First tick of a correction, χ's largest size behind it in cells, the rows)."""
    simulation = CONTROLLERS[controller](scene)
    rows = np.zeros((round(scene.scene.duration_s / simulation.tick_s), len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    begun = int(np.flatnonzero(rows[:, Column.CORRECTION])[0])
    return begun, float(np.abs(rows[begun + 1000 :, Column.FLUX]).max()), rows


@pytest.mark.parametrize("magnet_rad", [0.05, 0.2, 0.35, 0.5, 0.65, 0.8])
def test_the_first_movement_finds_the_magnets(magnet_rad: float):
    """Whatever their angle is: within an electrical turn, and the next wall is held."""
    scene = held(*FIND, f"motor.magnet_rad={magnet_rad}", "scene.duration_s=0.5")
    begun, chi, rows = found_at(scene, "golden")
    assert abs(rows[begun, Column.X] - rows[0, Column.X]) < 2 * math.pi / GIMBAL.pole_pairs
    assert rows[begun:, Column.CONTACT].any()
    assert not rows[:, Column.FAULT].any()
    assert chi < 4.0  # in a hit: a wrong angle's would go on growing with the way


@pytest.mark.parametrize("omega", [2.0, 10.0])
@pytest.mark.parametrize(("cells", "found"), [(0.2, True), (0.35, False)])
def test_a_voltage_that_drifts_a_quarter_of_a_cell_a_count_hides_the_magnets(omega, cells, found):
    """V/(pψω): what an unknown voltage, of an offset here, moves χ by from count to count."""
    volt = cells * GIMBAL.pole_pairs * GIMBAL.psi_vs * omega
    # The same offset of both phases is a vector of twice that.
    offset = 0.5 * volt / GIMBAL.R_ohm
    seconds = 12 * math.pi / GIMBAL.pole_pairs / omega
    scene = held(
        *FIND, "hand.amplitude_rad=2", f"hand.frequency_hz={omega / (4 * math.pi)}",
        "hand.stiffness=0.3", "controller.walls=[[10, 11]]", "controller.r_hat=4.7",
        "drive.gain_error=0", "motor.harmonic_5=0", "motor.magnet_rad=0.4", "adc.bits=16",
        "adc.noise_a=0", f"adc.offset_a={offset}", f"scene.duration_s={seconds}",
    )  # fmt: skip
    simulation = CONTROLLERS["golden"](scene)
    rows = np.zeros((round(seconds / simulation.tick_s), len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    assert np.ptp(rows[:, Column.X]) * GIMBAL.pole_pairs > 1.5 * 2 * math.pi
    assert rows[:, Column.CORRECTION].any() == found


def test_magnets_the_wrong_way_round_are_never_found():
    """An encoder that counts down where the phases count up: no anchor ever has a say."""
    scene = held(*FIND, "encoder.counts_per_rev=10000", "scene.duration_s=0.5")
    simulation = CONTROLLERS["golden"](scene)
    turn = 2  # its place in what the loop takes
    anchored = list(simulation._anchored)
    anchored[turn] = (1 << rotor_flux.ANGLE_W) - anchored[turn]
    simulation._anchored = tuple(anchored)
    rows = np.zeros((500_000, len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    assert not rows[:, Column.CORRECTION].any()


def test_pins_find_the_magnets():
    scene = held(*FIND, "motor.magnet_rad=0.05", "scene.duration_s=0.25", "drive.bus_v=12")
    begun, chi, rows = found_at(scene, "pins")
    assert begun < 200_000
    assert not rows[:, Column.FAULT].any()
    assert chi < 4.0


def test_pins_hold_what_golden_holds():
    """The whole RTL at its pins with everything wrong, at a phase where both axes push."""
    scene = held("scene.duration_s=0.7", "motor.magnet_rad=0.35", "controller.magnet_hat_rad=0.337")
    cells, ripple, end = cells_off(scene, "pins")
    assert end[:, Column.CONTACT].all()
    assert not end[:, Column.FAULT].any()
    assert abs(cells) < 0.75
    assert ripple < 60e-6


def test_a_tick_too_short_for_two_ports_is_refused():
    with pytest.raises(
        SceneError, match=r"shorter than the 74 that `pins` needs for two ports; ta"
    ):
        CONTROLLERS["pins"](held("controller.clock_hz=60e6"))


@pytest.mark.parametrize(
    "base", ["held_wall.toml", "brushless_taps.toml"], ids=["brushes", "no-anchor"]
)
def test_the_magnets_angle_is_of_a_brushless_anchor(base: str):
    with pytest.raises(SceneError, match=r"magnet_hat_rad belongs to a brushless motor's port"):
        load_scene(SCENES_DIR / base, ["controller.magnet_hat_rad=0.1"])
