# SPDX-License-Identifier: Apache-2.0
"""``wavehaptics holding``: what the README shows of it, and how it comes by that."""

from __future__ import annotations

import json

import pytest
from wavehaptics import holding, numbers
from wavehaptics.boards import ROOT
from wavehaptics.report.readme import of_holding


@pytest.fixture(scope="module")
def kept():
    return json.loads((ROOT / numbers.MEASURED).read_bytes())["holding"]


def test_kept_holds_are_within_the_targets(kept):
    """Half a cell and 1 % of the depth, 50 µN·m, for every sign; `core` is `golden`."""
    by_name = {}
    for row in kept["holds"]:
        if not row["cured"]:
            assert abs(row["hold_error"] or 1.0) > 0.1
            continue
        depth = abs(row["hold_offset_rad"] / row["hold_error"])
        assert abs(row["hold_offset_rad"]) <= 0.5 * row["cell_rad"] + 0.01 * depth
        assert row["hold_ripple_rms"] <= 50e-6
        assert abs(row["r_hat_error"]) <= 0.02
        assert not row["encoder_lost"]
        by_name[row["controller"], tuple(row["signs"])] = row
    for signs in holding.SIGNS:
        core, golden = by_name["core", signs], by_name["golden", signs]
        assert core["duration_s"] >= 60
        assert core | {"controller": "golden"} == golden
    assert by_name["pins", holding.SIGNS[0]]["duration_s"] >= 2


def test_kept_winding_is_followed(kept):
    for row in kept["warm"]:
        assert row["duration_s"] >= 60
        assert row["r"] > 1.2 * 2.18
        assert abs(row["r_hat_error"]) <= 0.02
        assert not row["encoder_lost"]
    core, golden = kept["warm"]
    assert core | {"controller": "golden"} == golden


def test_kept_bounces_throw_nobody(kept):
    cures = list(holding.CURES)
    for row in kept["bounces"]:
        if row["cure"] == cures[0]:
            assert row["largest"] <= 1.0
            assert 0.95 <= row["exact"] <= 1.0
        else:
            assert row["largest"] > 1.2


def test_a_hold_and_its_course(tmp_path):
    """The functions behind the numbers, on short runs; the wall's course is that of its hold."""
    row = holding.hold("golden", [1, -1, 1], ["scene.duration_s=0.3"])
    assert row["cured"]
    assert abs(row["hold_offset_rad"]) <= 0.5 * row["cell_rad"]
    runs = [holding.course(0.2, 1000, settings) for settings in ([], [holding.OFF], [])]
    cured, plain, long = runs
    assert max(-f for f in cured["torque"]) < 0.05 < max(-f for f in plain["torque"])
    moved = long["torque"][-1] / long["stiffness"] + long["x"][-1]
    assert abs(moved) <= row["cell_rad"]
    holding._draw_holds(runs, row["cell_rad"], tmp_path / "holds.png")
    assert (tmp_path / "holds.png").stat().st_size > 10_000


def test_the_largest_bounce_is_kept():
    points = [
        {"speed": 10.0, "part": 1.0, "gain": 0.0, "restitution": 0.9},
        {"speed": 1.0, "part": 1.1, "gain": 0.05, "restitution": 0.99},
        {"speed": 3.0, "part": 1.1, "gain": 0.05, "restitution": None},
    ]
    run = {"preset": "re25-118743", "cure": "with the anchor", "points": points}
    found = of_holding({"holds": [], "warm": [], "bounces": [run]})
    assert found["bounces"][0]["largest"] == 0.99
    assert found["bounces"][0]["exact"] == 0.9
