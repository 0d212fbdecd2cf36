# SPDX-License-Identifier: Apache-2.0
"""``make holding``: what the pages show of it is what it should come to."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from wavehaptics.runtime.repository import ROOT
from wavetools.pages import filler, port_anchor
from wavetools.studies import anchored
from wavetools.studies.anchored import cases


@pytest.fixture(scope="module")
def kept():
    return json.loads((ROOT / filler.MEASURED).read_bytes())["holding"]


BARS_MISSED = {(-0.08, 0.5e-3): 0.85e-3}
"""Bars (their part of R, the hand's damping) that miss 0.7 mN·m; the page names them."""


def test_kept_holds_are_held_and_lost_without_the_anchor(kept):
    """No fault, no lost wall, `core` as `golden`; but for a loose contact's noise a hop."""
    twins: dict[tuple[str, float], list[dict]] = {}
    for row in kept["holds"]:
        assert row["anchor_fault_s"] is None
        assert row["moved_cells"] is not None
        if "flicker" not in row["name"]:
            assert row["hold_ripple_rms"] <= 100e-6
        assert row["correction_out_max_j"] <= row["correction_bound_j"]
        twins.setdefault((row["name"], row["duration_s"]), []).append(row)
    for name in cases.LONG:
        pairs = [rows for (of, _), rows in twins.items() if of == name and len(rows) == 2]
        assert pairs
        for core, golden in pairs:
            assert core | {"controller": "golden"} == golden
    lost = [
        row for row in kept["plain"]
        if row["moved_cells"] is None or abs(row["moved_cells"]) > 0.2 * row["depth_cells"]
    ]  # fmt: skip
    assert len(lost) > len(kept["plain"]) / 2


def test_kept_bars_swing_by_less_than_half_a_count(kept):
    assert {row["part"] for row in kept["bars"]} == set(cases.STEP_PARTS)
    for row in kept["bars"]:
        most = BARS_MISSED.get((row["part"], row["damping"]), 0.7e-3)
        assert row["hold_ripple_rms"] <= most, row


def test_kept_motors_are_all_there(kept):
    assert kept["in_hands"]["seeds"] in ([0, anchored.MOTORS - 1], [0, anchored.QUICK_MOTORS - 1])
    assert set(kept["in_hands"]["faults"]) == {*port_anchor.WALLS, *port_anchor.BOUNCES}


def test_every_table_has_its_marker_on_its_page():
    for name in port_anchor.TABLES:
        assert filler.marked_pages(name) == [Path("docs", "holding.md")]
