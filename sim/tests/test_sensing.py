# SPDX-License-Identifier: Apache-2.0
"""The study of parts that sense the current, and the numbers that the page shows of it."""

from __future__ import annotations

import json
import math

import pytest
from wavehaptics.parts.sensing import SensingPart, sensing_parts
from wavehaptics.runtime.repository import ROOT
from wavetools.pages import filler
from wavetools.studies import sensing

RAN = {
    "part": "P", "carrier_hz": 5e5, "refusal": None, "clock_hz": 48e6, "stiffness": 1.7,
    "stiffness_predicted": 2.0, "ripple_nm": 12.4e-6, "hold_error": -0.01234,
    "contact_energy_ratio": 0.0, "anchor_fault_s": None,
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "shown"),
    [
        ({}, "0.85; 12; -1.2%"),
        ({"refusal": "it settles"}, "(0.85; 12; -1.2%)"),
        ({"anchor_fault_s": 1.83e-3, "stiffness": None}, "lost after 1.8 ms"),
        ({"stiffness": None}, "no wall"),
        ({"not_run": "sampled twice a period"}, "–"),
    ],
)
def test_a_run_is_told_in_a_few_characters(change, shown):
    assert sensing.cell(RAN | change) == shown


def test_a_run_at_the_pins_finds_a_part_that_never_follows():
    """A part's own figures make the scene, and the table of it says both what is and what was."""
    short = ("scene.duration_s=0.02",)
    part = SensingPart(what="a hold of 3 µs", hold_s=3e-6, sources=["made up"])
    keys = [sensing.TWELVE_BITS, *part.settings(sensing.BUS_V, sensing.SHUNT_OHM)]
    row = sensing.row_of("slow", part, keys, 250e3, short)
    assert row["refusal"] == (
        "it holds its output for 3 µs after an edge, give or take 20%, and at 0 V there is one "
        "each 2 µs"
    )
    assert row["anchor_fault_s"] < 0.02
    assert row["clock_hz"] == pytest.approx(48e6, rel=1e-3)
    half = sensing.row_of("half", sensing_parts()["low-side"], [], 250e3)
    assert half["not_run"] == "sampled twice a period"
    late = sensing.row_of("late", None, ["adc.part=AMC1306M25", "adc.bits=16"], 250e3, (
        *short, "controller.extra_ticks=0",
    ))  # fmt: skip
    assert late["not_run"].startswith("--set controller.extra_ticks=0:")
    head, rows = sensing.lines({"rows": [row, half]})
    assert head == ["Part", "Fastest", "250 kHz"]
    assert rows[0][:2] == ["slow", "–"]
    assert rows[0][2].startswith("(lost after ")
    assert rows[1] == ["half", "–", "–"]


def test_numbers_of_other_settings_stay_out_of_the_page(tmp_path):
    (tmp_path / "build" / "sensing").mkdir(parents=True)
    path = tmp_path / "build" / "sensing" / "sensing.json"
    path.write_text(json.dumps({"settings": ["drive.bus_v=24"], "rows": []}))
    (tmp_path / filler.MEASURED).parent.mkdir(parents=True)
    (tmp_path / filler.MEASURED).write_text("{}")
    (tmp_path / filler.KEPT).parent.mkdir(parents=True)
    (tmp_path / filler.KEPT).write_text('{"boards": []}')
    assert filler.keep(tmp_path) == [filler._SENSING]
    assert "sensing" not in json.loads((tmp_path / filler.MEASURED).read_bytes())


def test_kept_numbers_say_what_the_page_says():
    """An amplifier that holds is as good as an ideal one up to its limit, and none beyond it."""
    kept = json.loads((ROOT / filler.MEASURED).read_bytes())["sensing"]
    rows = {(row["part"], row["carrier_hz"]): row for row in kept["rows"]}
    names = {name for name, _ in rows}
    assert names > {sensing.PLAIN, *sensing_parts()}
    assert len(rows) == len(names) * len(sensing.CARRIERS_HZ)
    for (name, carrier_hz), row in rows.items():
        part = sensing_parts().get(name)
        if part is not None:
            assert row["refusal"] == part.refusal(carrier_hz, 0.5 / carrier_hz), name
        if name.startswith("INA241"):
            hold_s = 1.2e-6 if "hold" in name else 1e-6
            assert (row["anchor_fault_s"] is None) == (hold_s <= 0.5001 / carrier_hz)
            if row["anchor_fault_s"] is None:
                ideal = rows[sensing.PLAIN, carrier_hz]["stiffness"]
                assert math.isclose(row["stiffness"], ideal, rel_tol=0.03)
                assert row["ripple_nm"] < 20e-6
