# SPDX-License-Identifier: Apache-2.0
"""An absolute encoder that is read now and then, and what it is worth to a wall."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.brushless import BrushlessSimulation
from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.motor import absolute
from wavehaptics.parts.encoders import ABSOLUTE_PARTS
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import SceneError, find_scene, load_scene
from wavehaptics.trace.columns import Column, Word
from wavetools.pages import filler
from wavetools.studies import encoders

COUNT = 2 * math.pi / 4096
ABSOLUTE = ("encoder.kind=absolute", "encoder.counts_per_rev=4096")


def held(*settings):
    return load_scene(find_scene("held_wall"), settings)


def reader(*settings):
    """(words, memory) of a reader that begins at 0.5 counts."""
    words = absolute.reading_words(held(*ABSOLUTE, "encoder.bits=14", *settings))
    return words, absolute.new_readings(0.5 * COUNT, COUNT, words)


def counts(path, step_s, words, memory):
    """What the reader counts along ``path``, rotor places in counts, one each ``step_s``."""
    return [
        absolute.absolute_count.py_func(x * COUNT, (n + 0.01) * step_s, COUNT, words, memory)
        for n, x in enumerate(path)
    ]


def test_a_reading_is_taken_at_its_time_and_arrives_later():
    words, memory = reader("encoder.read_hz=10e3", "encoder.latency_s=50e-6")
    found = counts(0.5 + 0.1 * np.arange(400), 10e-6, words, memory)
    for n, count in enumerate(found):
        taken = (n - 5) // 10  # readings each 10 steps, 5 steps late
        assert count == math.floor(0.5 + 0.1 * max(0, 10 * taken) + 1e-9), n


def test_a_count_follows_beyond_the_hysteresis_only_and_both_ways():
    """Four counts of the part are one of the reader's; the hysteresis is of the part's."""
    words, memory = reader("encoder.read_hz=1e6", "encoder.hysteresis_counts=2")
    path = [0.5, 1.2, 1.49, 1.51, 1.0, 0.55, 0.45, 0.2, -0.45, -0.55, 3.2, 3.6]
    assert counts(path, 1e-6, words, memory) == [0, 0, 0, 1, 1, 1, 0, 0, 0, -1, 2, 3]


def test_readings_stop_where_the_scene_says_so():
    words, memory = reader("encoder.read_hz=1e6", "encoder.stops_at_s=19.5e-6")
    found = counts(0.5 + np.arange(40), 1e-6, words, memory)
    assert found == [*range(20), *[19] * 20]


@pytest.mark.parametrize("filtered", [(), ("encoder.bandwidth_hz=2e3",)])
def test_noise_is_as_large_as_the_scene_says_behind_its_filter_too(filtered):
    words, memory = reader("encoder.read_hz=200e3", "encoder.noise_counts=20", *filtered)
    words[absolute.SPAN] = 1.0  # of each reading
    memory[absolute.ANGLE] = 0.5
    found = counts(np.full(60_000, 0.5), 5e-6, words, memory)
    assert np.std(found[5000:]) == pytest.approx(20, rel=0.1)
    assert abs(np.mean(found[5000:])) < 2.5


def test_the_filter_follows_a_constant_speed_and_ends_at_its_cut_off():
    words, memory = reader("encoder.read_hz=200e3", "encoder.bandwidth_hz=1e3")
    found = counts(0.5 + 0.01 * np.arange(4000), 5e-6, words, memory)
    assert abs(found[-1] - (0.5 + 0.01 * 3999)) <= 1.0
    words, memory = reader("encoder.read_hz=200e3", "encoder.bandwidth_hz=1e3")
    times = np.arange(8000) * 5e-6
    found = counts(0.5 + 1000 * np.sin(2 * np.pi * 1e3 * times), 5e-6, words, memory)
    assert 0.5 * np.ptp(found[4000:]) == pytest.approx(1000 / math.sqrt(2), rel=0.03)


@pytest.mark.parametrize("name", ABSOLUTE_PARTS)
def test_a_part_sets_what_the_scene_leaves_out(name):
    part = ABSOLUTE_PARTS[name]
    encoder = held("encoder.kind=absolute", f"encoder.part={name}", *ABSOLUTE[1:]).encoder
    assert {key: getattr(encoder, key) for key in part.settings()} == part.settings()
    assert encoder.counts_per_rev == 4096
    own = held(*ABSOLUTE, f"encoder.part={name}", "encoder.noise_counts=0.5").encoder
    assert own.noise_counts == 0.5
    assert own.read_hz == part.read_hz


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (("encoder.part=AS5047P",), 'set encoder.kind = "absolute", or leave it out'),
        (("encoder.kind=absolute", "encoder.part=AS5047P"), "a power of two up to its 16384"),
        ((*ABSOLUTE, "encoder.part=AS5047"), 'did you mean "AS5047P"?'),
        (ABSOLUTE, "encoder.read_hz is missing"),
        ((*ABSOLUTE, "encoder.part=MA702", "encoder.uneven=0.1"), "is of A and B; leave it out"),
        (
            (*ABSOLUTE, "encoder.read_hz=2e6", "encoder.latency_s=1e-3"),
            "more than 1000 readings; it may be at most 0.0005",
        ),
    ],
)
def test_what_can_not_be_is_refused_in_one_line(settings, message):
    with pytest.raises(SceneError) as refused:
        held(*settings)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_pins_has_its_a_and_b():
    """The RTL follows them without an illegal move, through a press and through noise."""
    scene = held(*ABSOLUTE, "encoder.part=AS5047P", "scene.duration_s=0.02", "drive.bus_v=12")
    simulation = CONTROLLERS["pins"](scene)
    rows = np.zeros((round(0.02 / simulation.tick_s), len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    assert simulation.faults == 0
    assert not np.any(rows[:, Column.FAULT])
    assert np.max(rows[:, Column.CONTACT]) == 1.0
    moved = (rows[-1, Column.X_HAT] - rows[-1, Column.X]) / COUNT
    assert abs(moved) < 3.0


@pytest.mark.parametrize("controller", ["pins", "encoder"])
def test_a_brushless_motor_has_no_reader_there(controller):
    scene = load_scene(find_scene("brushless_hold"), ("encoder.part=MT6701", *ABSOLUTE))
    with pytest.raises(SceneError, match=r"encoder\.kind is not for .*; with a brushless motor"):
        refuse(scene, controller)


def test_core_sees_the_same_counts_as_golden():
    rows = []
    for controller in ("golden", "core"):
        simulation = CONTROLLERS[controller](held(*ABSOLUTE, "encoder.part=MT6701"))
        words = np.zeros((2000, len(Word)), dtype=np.int64)
        simulation.advance(np.zeros((2000, len(Column))), words)
        rows.append(words)
    assert np.array_equal(*rows)


def test_a_brushless_motor_has_it_too():
    """A delay of zero at the tick's rate is the ideal encoder, and a long one isn't."""

    def places(*settings):
        scene = load_scene(find_scene("brushless_wall"), ("encoder.counts_per_rev=4096", *settings))
        simulation = BrushlessSimulation(scene, rtl=False)
        rows = np.zeros((round(0.05 / simulation.tick_s), len(Column)))
        simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
        return rows[:, Column.X]

    ideal = places()
    tick = ("encoder.kind=absolute", "encoder.read_hz=2e6")
    assert np.array_equal(places(*tick), ideal)
    assert not np.array_equal(places(*tick, "encoder.latency_s=200e-6"), ideal)


def test_a_good_reader_holds_and_a_late_one_lets_the_wall_swing():
    found = {
        late: measure(
            held(*ABSOLUTE, "encoder.bits=14", "encoder.read_hz=980e3", "scene.duration_s=0.5",
                 f"encoder.latency_s={late}"),
            "golden", compare=False,
        )
        for late in (5e-6, 300e-6)
    }  # fmt: skip
    assert found[5e-6]["hold_ripple_rms"] < 20e-6
    assert found[5e-6]["contact_energy_ratio"] < 0.5
    assert found[300e-6]["contact_energy_ratio"] > 3.0


def test_kept_numbers_say_what_the_page_says():
    kept = json.loads((ROOT / filler.MEASURED).read_bytes())["encoders"]["rows"]
    rows = {row["encoder"]: row for row in kept}
    assert list(rows) == list(encoders.encoders())
    for counts_per_rev in (4096, 16384):
        good = rows[f"MT6701, {counts_per_rev}"]
        assert good["lost"] == 0
        assert good["ripple_nm"] < 100e-6
        assert good["speed_back"] < 1.15
        assert good["gimbal_ripple_nm"] < 50e-6
    for name in ("AS5047P", "AS5048A"):
        poor = rows[f"{name}, 4096"]
        assert poor["ripple_nm"] > 1e-3
        assert poor["contact_energy_ratio"] > 1.0
    assert rows["MT6701 as A and B are delivered, 4096"]["ripple_nm"] > 1e-3
    for name in ("MA702", "MA730"):
        assert rows[f"{name}, 4096"]["lost"] == rows[f"{name}, 4096"]["holds"]


def test_a_row_is_told_in_a_few_characters():
    row = {
        "encoder": "some", "holds": 4, "lost": 1, "moved_cells": 0.61, "hold_error": 0.152,
        "ripple_nm": 5.38e-6, "contact_energy_ratio": 0.337, "speed_back": 1.024,
        "gimbal_ripple_nm": 470e-6, "gimbal_energy_ratio": -0.05,
    }  # fmt: skip
    assert encoders.cells(row) == [
        "some", "1 of 4", "0.61", "15 %", "5.4", "0.34", "1.02", "470", "−0.05",
    ]  # fmt: skip
    nothing = dict.fromkeys(row, None) | {"encoder": "none", "holds": 4, "lost": 4}
    assert encoders.cells(nothing) == ["none", "4 of 4", *"–––––––"]
    head, lines = encoders.lines({"rows": [row]})
    assert len(head) == len(lines[0])
    short = ("scene.duration_s=0.05",)
    found = encoders.row_of("A and B", ("encoder.counts_per_rev=4096",), encoders.SIGNS[:1], short)
    assert found["lost"] == 0
    assert 0.8 < found["speed_back"] < 1.1
