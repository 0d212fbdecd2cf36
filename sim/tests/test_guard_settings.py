# SPDX-License-Identifier: Apache-2.0
"""What a board's guard allows, and its word, against numbers made by hand from the scene."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest
from wavehaptics.controller.guard import Fault, Limits, board_limits, mask, settings
from wavehaptics.fpga.boards import Board, load_board
from wavehaptics.motor.sensor import Sensor
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import SceneError, load_scene

FIELDS = {
    name: (int(low), int(high) - int(low) + 1)
    for name, high, low in re.findall(
        r"WH_GUARD_(\w+)\s+(\d+):(\d+)", (ROOT / "rtl" / "wh_faults.vh").read_text()
    )
}
"""Lowest bit and width of each field of the guard's settings, as the RTL has them."""


def fields_of(word: int | None) -> dict[str, int]:
    assert word is not None
    return {name: (word >> low) & ((1 << width) - 1) for name, (low, width) in FIELDS.items()}


def ulx3s(*overrides: str) -> Board:
    board = load_board("ulx3s")
    scene = load_scene(ROOT / board.folder / "board.toml", overrides)
    return Board(board.name, board.root, board.fpga, board.device, scene)


def test_the_guards_limits_are_the_boards():
    """Its word has the scene's sensor, tick and motor; what the board can't know is left out."""
    found = fields_of(ulx3s().words().guard)
    left_out = (Fault.TRIP, Fault.HOST, Fault.STOP, Fault.BUS_LOW, Fault.BUS_HIGH)
    assert found["MASK"] == mask(set(Fault) - set(left_out))
    # The comparators' latch has no wire to this one.
    other = fields_of(load_board("colorlight_i5").words().guard)
    assert other["MASK"] == found["MASK"] & ~mask([Fault.DRIVER])
    assert found["DAMP"] == 0
    assert found["CURRENT"] == round(0.8 * 2**15)  # 2 A of 2.5
    assert found["STUCK"] == 2 * 833  # 1 ms at 1.2 µs, of two samples each
    assert found["ZERO_TICKS"] == 1667
    # Maxon's 100 °C for this motor: 75 K over 17.1 K/W and the hot winding's 2.82 Ω.
    assert found["HEAT"] / 2**18 == pytest.approx(75 / (17.1 * 2.18 * 1.2925), rel=1e-4)
    assert found["HEAT_TICKS"] == round(12 / 2**16 / 1.2e-6)
    # Half of what the winding's lasting current takes, as u + v = 2 (e - R̂ i)/s; with an anchor
    # the waves' R̂ is 0.7 of the motor's.
    lasting_a = math.sqrt(75 / (17.1 * 2.18 * 1.2925))
    assert lasting_a == pytest.approx(1.24, rel=0.01)  # its nominal current
    lost = 2 * 0.5 * 2.18 * lasting_a / math.sqrt(2 * 0.7 * 2.18)
    assert found["LOST"] == pytest.approx(lost * 2**8, abs=0.6)
    half = fields_of(ulx3s("motor.R_ohm=4.36").words().guard)
    assert half["HEAT"] == pytest.approx(found["HEAT"] / 2, rel=1e-4)


def test_a_winding_of_its_own():
    """Rise over resistance of heat and of the winding; the rest is the scene's as well."""
    board = ulx3s(
        "motor.R_ohm=2.0", "thermal.rth_winding=3", "thermal.rth_housing=7",
        "thermal.ambient_c=45", "thermal.alpha_per_k=0.004", "thermal.tau_winding_s=20",
    )  # fmt: skip
    limits = board_limits(board.scene, board.words().ports, 1.5)
    # 55 K over 10 K/W, in 2 Ω · (1 + 0.004 · 75).
    assert limits.rms_a == pytest.approx(math.sqrt(55 / 10 / 2.6))
    assert limits.lost_v == pytest.approx(0.5 * 2.0 * limits.rms_a)
    assert limits.winding_s == 20
    assert limits.current_a == 1.5
    unnamed = board_limits(board.scene, board.words().ports)
    assert unnamed.current_a == pytest.approx(0.9 * 2.5)


def test_the_energy_of_a_contact_has_what_its_spring_holds_as_limit():
    """½ L_eff i² at the trip's current; without a spring there is none."""
    board = ulx3s()
    ports, motor = board.words().ports, board.scene.motor
    joule = 0.5 * (motor.L_h + 0.5 * motor.R_ohm * ports.settings.tau) * 2.0**2
    count_rad = 2 * math.pi / board.scene.encoder.counts_per_rev
    limits = board_limits(board.scene, ports, 2.0)
    assert limits.energy == pytest.approx(joule / (motor.k_t * count_rad), rel=1e-6)
    found = fields_of(board.words().guard)
    assert found["ENERGY"] == math.ceil(8 * limits.energy)
    assert fields_of(ulx3s("controller.k_t_hat=0.0117").words().guard)["ENERGY"] == pytest.approx(
        2 * found["ENERGY"], abs=2
    )
    damps = ulx3s("controller.eta_contact=0")
    assert fields_of(damps.words().guard)["ENERGY"] == 0
    soft = ulx3s("shaper.feel=spring", "shaper.stiffness=0.05")
    held = 0.5 * (2.0 * motor.k_t) ** 2 / 0.05
    assert fields_of(soft.words().guard)["ENERGY"] == pytest.approx(
        8 * held / (motor.k_t * count_rad), rel=0.01
    )


def test_limits_of_a_modulators_words():
    """Of 21³ bits, of 2¹⁴: 3.2 A are 18522. Trip at 2 A, end of the linear range at 2.5 A."""
    scene = ROOT / "boards" / "ulx3s" / "sigma_delta.toml"
    found = fields_of(load_board("ulx3s", scene_path=scene).words().guard)
    assert found["CURRENT"] == math.floor(2.0 / 3.2 * 2 * 21**3)
    assert found["RANGE"] + 1 == math.floor(2.5 / 3.2 * 2 * 21**3)


def test_no_limit_is_more_than_its_word():
    limits = Limits((), energy=1e6, saturated_s=1.0)
    found = fields_of(settings(limits, 1e-6, Sensor(ideal=False), s=2.0, unity=1.0))
    assert (found["ENERGY"], found["SATURATED"]) == (0xFFFF, 0xFFFF)


def test_surroundings_as_hot_as_the_winding_may_be_are_refused():
    with pytest.raises(SceneError, match=r"ambient_c = 100 °C .* bears 100 °C; lower it"):
        ulx3s("thermal.ambient_c=100").words()


@pytest.mark.parametrize("samples", [1, 3])
def test_a_stuck_adc_is_counted_in_samples(samples):
    board = ulx3s()
    ports = board.words().ports
    ports = replace(ports, timing=replace(ports.timing, samples=samples))
    assert board_limits(board.scene, ports).stuck_samples == 833 * samples


def test_each_field_has_its_own_number():
    limits = Limits(
        (Fault.CURRENT, Fault.BUS_LOW), damp=(Fault.BUS_LOW,), current_a=3.0, stuck_samples=123,
        zero_a=0.25, zero_s=3e-3, lost_v=0.75, lost_s=4e-3, host_s=5e-3, bus_min_v=9.5,
        bus_max_v=15.25, rms_a=1.5, winding_s=65.536, stop_level=0, driver_level=1, energy=70.01,
        saturated_s=7e-3,
    )  # fmt: skip
    word = settings(limits, 1e-6, Sensor(ideal=False, bits=12, full_scale_a=4.0), 2.0, 1.0)
    assert fields_of(word) == {
        "MASK": 1 << Fault.CURRENT | 1 << Fault.BUS_LOW,
        "DAMP": 1 << Fault.BUS_LOW,
        "LEVELS": 0b10,
        "CURRENT": 0x5FFF,  # below 3/4 of 2^15
        "RANGE": 0x8000 - 16 - 1,  # below the highest of 4,096 codes
        "STUCK": 123,
        "ZERO": 128,  # of 512 an ampere
        "ZERO_TICKS": 3000,
        "LOST": 192,  # 2 · 0.75 V / 2 √Ω, of 256
        "LOST_TICKS": 4000,
        "HOST": 5000,
        "BUS_MIN": 19 << 8,
        "BUS_MAX": 61 << 7,
        "HEAT_TICKS": 1000,
        "HEAT": 9 << 16,  # 2.25 A² of 2^18
        "ENERGY": 561,  # eighths, the next above
        "SATURATED": 7000,
    }


@pytest.mark.parametrize(("full_scale_a", "trip_a"), [(2.5, 1.25), (1.2, 0.3), (2.5, 2.0), (5, 3)])
def test_a_sample_of_the_limits_magnitude_is_beyond_it(full_scale_a, trip_a):
    """wh_guard finds samples above CURRENT, none of which is below the limit."""
    sensor = Sensor(ideal=False, bits=12, full_scale_a=full_scale_a)
    word = settings(Limits((), current_a=trip_a), 1e-6, sensor, s=2.0, unity=1.0)
    code_a = full_scale_a / 2**11
    code = math.ceil(round(trip_a / code_a, 6))  # the first that is no less
    assert (code - 1) << 4 <= fields_of(word)["CURRENT"] < code << 4


def test_the_ends_of_the_words():
    """A limit beyond the scale is the scale, a time below a tick is a tick."""
    limits = Limits((), current_a=9.0, stop_level=1, zero_s=0.0, lost_s=0.4e-3, winding_s=1.0)
    sensor = Sensor(ideal=False, bits=16, full_scale_a=4.0)
    found = fields_of(settings(limits, 1e-3, sensor, 2.0, 1.0))
    assert found["CURRENT"] == 1 << 15
    assert found["RANGE"] == 0x8000 - 2
    assert found["LEVELS"] == 1
    assert (found["ZERO_TICKS"], found["LOST_TICKS"], found["HEAT_TICKS"]) == (1, 1, 1)
