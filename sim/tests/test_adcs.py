# SPDX-License-Identifier: Apache-2.0
"""Converters: their frames on a clock, what the pages say of them, and how that is measured."""

from __future__ import annotations

import json

import pytest
from wavehaptics.controller import tick_layout
from wavehaptics.motor import sigma_delta
from wavehaptics.parts.adcs import ALL_BITS, MODULATORS, PARTS, PartError, frame, modulator_frame
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import find_scene, load_scene
from wavetools.pages import filler
from wavetools.studies import adcs


def test_fastest_frames():
    """The rates that the makers promise, on the clocks where the reader can have them."""
    for name, clock_hz, rate_hz in (
        ("AD7476A", 80e6, 1e6), ("AD7276", 96e6, 3e6), ("ADS7042", 64e6, 1e6),
        ("ADS7046", 120e6, 3e6), ("ADS7052", 96e6, 1e6), ("ADS7056", 120e6, 2.5e6),
        ("MAX11125", 96e6, 1e6),
    ):  # fmt: skip
        made = frame(PARTS[name], clock_hz)
        assert clock_hz / made.cycle_clocks == pytest.approx(rate_hz, rel=1e-9), name
        assert clock_hz / made.bit_clocks <= PARTS[name].sclk_hz
    assert frame(PARTS["AD7276"], 96e6).cycle_clocks == 32


@pytest.mark.parametrize("name", sorted(PARTS))
@pytest.mark.parametrize("clock_hz", [12e6, 30e6, 48e6, 80e6, 100e6, 200e6])
def test_no_frame_is_faster_than_its_part(name, clock_hz):
    part, made = PARTS[name], frame(PARTS[name], clock_hz)
    assert clock_hz / made.bit_clocks <= part.sclk_hz * (1 + 1e-9)
    assert clock_hz / made.cycle_clocks <= part.rate_hz * (1 + 1e-9)
    assert made.setup_clocks / clock_hz >= part.setup_s - 1e-12
    tracking = made.setup_clocks + (part.track_edge - 1) * made.sclk_half_clocks
    assert (made.cycle_clocks - tracking) / clock_hz >= part.acquire_s - 1e-12


def test_clocks_that_no_port_can_count():
    with pytest.raises(PartError, match="AD7476A at a clock of 2e\\+10 Hz: "):
        frame(PARTS["AD7476A"], 20e9)


def test_modulator_frames():
    made = modulator_frame(MODULATORS["AD7403"], 80e6, 80)
    assert (made.bit_clocks, made.osr, made.cycle_clocks) == (4, 20, 80)
    assert made.unity == pytest.approx(8000 / 8192)
    made = modulator_frame(MODULATORS["AMC1306M25"], 84e6, 336)
    assert (made.osr, made.cycle_clocks) == (21, 84)
    assert modulator_frame(MODULATORS["AD7403"], 40e6, 4000 * 256).osr <= 256
    for clock_hz, clocks in ((80e6, 81), (80e6, 12), (3e6, 300)):
        with pytest.raises(PartError, match="AD7403"):
            modulator_frame(MODULATORS["AD7403"], clock_hz, clocks)


@pytest.mark.parametrize(
    ("level", "ones"), [(0.0, 0.5), (250 / 320, 0.8906), (-250 / 320, 0.1094), (0.3, 0.65)]
)
def test_density_of_ones(level, ones):
    state = sigma_delta.new_state()
    bits = [sigma_delta.next_bit(state, level) for _ in range(20_000)]
    assert sum(bits) / len(bits) == pytest.approx(ones, abs=3e-4)


@pytest.mark.parametrize("level", [1.0, 1.5, -1.0, -40.0])
def test_overdriven_modulator(level):
    """One other bit in 128, and a level in range is right again at once."""
    state = sigma_delta.new_state()
    bits = [sigma_delta.next_bit(state, level) for _ in range(1280)]
    assert sum(bits) == (1270 if level > 0 else 10)
    bits = [sigma_delta.next_bit(state, 0.0) for _ in range(400)]
    assert sum(bits[40:]) / 360 == pytest.approx(0.5, abs=0.02)


def test_delays_of_a_scene():
    """1 MHz, 48 MHz: held in the tick's middle, driven one and a half ticks later."""
    scene = load_scene(find_scene("paper_taps"), ["adc.part=AD7276"])
    found = adcs.delays(tick_layout.timing(scene, tick_layout.scene_frame(scene)))
    assert found["conversion_ns"] == pytest.approx(27e3 / 48)
    assert found["digital_ns"] == pytest.approx(38e3 / 48)
    assert found["gate_ns"] == pytest.approx(1500)
    scene = load_scene(find_scene("paper_taps"), ["adc.part=MAX11125"])
    found = adcs.delays(tick_layout.timing(scene, tick_layout.scene_frame(scene)))
    assert found["conversion_ns"] == pytest.approx(1000 + 76e3 / 96)
    assert found["gate_ns"] == pytest.approx(2500)


def test_tau_of_a_stiffness():
    scene = load_scene(find_scene("paper_taps"))
    motor = scene.motor
    k = motor.k_t**2 / (motor.L_h + motor.R_ohm * 100e-6 / 2)
    assert adcs.tau(k, scene) == pytest.approx(100e-6)
    assert adcs.tau(None, scene) is None


@pytest.mark.parametrize("what", [{"scene": "stiffest"}, {"settings": ["drive.limit_v=3"]}])
def test_numbers_of_another_run_stay_out_of_the_pages(tmp_path, what):
    found = {"scene": "paper_taps", "settings": [], "parts": []} | what
    (tmp_path / "build" / "adcs").mkdir(parents=True)
    (tmp_path / "build" / "adcs" / "adcs.json").write_text(json.dumps(found))
    with pytest.raises(filler.NumbersError, match="run `make adcs`"):
        filler.keep(tmp_path)
    assert not (tmp_path / filler.KEPT).exists()


def test_kept_numbers_keep_the_promises():
    """What the pages show of each converter is within the design's targets."""
    kept = json.loads((ROOT / filler.KEPT).read_bytes())["adcs"]
    assert [row["part"] for row in kept["parts"]] == list(ALL_BITS)
    for row in kept["parts"]:
        scene = load_scene(find_scene("paper_taps"), [f"adc.part={row['part']}"])
        timing = tick_layout.timing(scene, tick_layout.scene_frame(scene))
        for name, value in adcs.delays(timing).items():
            assert row[name] == pytest.approx(value), (row["part"], name)
        assert row["rate_hz"] >= 1e6 * (1 - 1e-9), row["part"]
        if row["bits"] >= 10:  # eight are too few for the target, as the page says
            assert row["torque_error"] <= 5e-3, row["part"]
            assert row["tau_us"] == pytest.approx(row["tau_set_us"], rel=0.02), row["part"]
    slowest = kept["energies"][-1]
    assert slowest["mean_j"] <= 0 < slowest["point_j"]
    assert slowest["several_j"] < 0.01 * slowest["one_j"]


def test_a_tick_whose_bits_no_word_divides_is_refused():
    """A prime number of them, beyond what a word of the filter has."""
    part = MODULATORS["AD7403"]
    period = 2 * modulator_frame(part, 60e6, 1200).sclk_half_clocks
    with pytest.raises(PartError, match=r"has 257 bits, which no word of 4 to 256 bits divides"):
        modulator_frame(part, 60e6, 257 * period)
    assert 258 % modulator_frame(part, 60e6, 258 * period).osr == 0
