# SPDX-License-Identifier: Apache-2.0
"""The circuits around a board: simulated, drawn, and told in the pages, all from one table.

The circuits shut the gates when ``alive`` stops, when the FPGA is configured anew and when its
supply falls; a wrong part must be found.
"""

from __future__ import annotations

import re

import pytest
from wavehaptics.wiring import spice
from wavehaptics.wiring.parts import FAMILIES, TABLE, Table, WiringError, load_table

FAMILY_TICK_S = 1e-6


@pytest.fixture(scope="module")
def table() -> Table:
    return load_table()


# ---- The table.


def test_values_are_printed_with_their_units(table):
    assert table.text("C1") == "2.2 nF"
    assert table.text("R6") == "33 mΩ"
    assert table.text("R4", "ice40") == "1 kΩ"
    assert table.text("R4") == "1 kΩ (iCE40), 10 kΩ (ECP5)"
    assert table.text("U8") == "AD7276"
    with pytest.raises(WiringError, match=r"boards/wiring.toml: there is no part R99; add"):
        table.text("R99")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("value = 2.2e-09", 'value = "2n2"', r"wiring.toml:\d+: parts.C1.value.float: .* number"),
        ("value = 2.2e-09\n", "", r"wiring.toml:\d+: parts.C1: .* either a type or a value"),
        ("value = 2.2e-09", "value = 2.2 nF", r"wiring.toml:\d+: .*without a unit"),
        ("ecp5 = 10e3 }", "}", r"wiring.toml:\d+: "),
        ('type = "BAT54S"', 'tipe = "BAT54S"', r"wiring.toml:\d+: parts.D1"),
    ],
)
def test_a_bad_table_is_refused_with_its_line(tmp_path, old, new, said):
    text = (spice.load_board("hx8k").root / TABLE).read_text()
    assert old in text
    (tmp_path / TABLE.parent).mkdir()
    (tmp_path / TABLE).write_text(text.replace(old, new, 1))
    with pytest.raises(WiringError, match=said) as refusal:
        load_table(tmp_path)
    assert "\n" not in str(refusal.value)


# ---- The circuits.


@pytest.mark.parametrize("which", ["typical", "most"])
def test_diodes_are_those_of_the_data_sheet(table, which):
    points_a, wanted_v = table.diode.points_a, getattr(table.diode, f"{which}_v")
    lines = ["* a diode", f".model d D({getattr(table.diode, f'{which}_model')})", ".temp 25"]
    for index, current_a in enumerate(points_a):
        lines += [f"I{index} 0 d{index} {current_a}", f"D{index} d{index} 0 d"]
        lines += [f".meas tran v{index} AVG v(d{index}) from=0 to=1u"]
    measured = spice.run("\n".join([*lines, ".tran 0.1u 1u", ".end", ""]))
    for index, wanted in enumerate(wanted_v):
        assert measured[f"v{index}"] == pytest.approx(wanted, abs=0.02)


def test_gates_are_shut_soon_after_the_last_change(table):
    """At each board's tick, stopped high and low, in every corner of parts, supply and warmth."""
    ticks_s = sorted(set(spice.board_ticks().values()))
    found = spice.stops(table, ticks_s, spice.corners(table))
    assert len(found) == len(ticks_s) * 2 * 24
    assert spice.stop_complaints(table, found) == []
    assert min(stop.least_v for stop in found) > 1.85
    assert min(stop.most_v for stop in found) > 2.10
    assert max(stop.most_v for stop in found) < 2.80
    assert 30e-6 < max(stop.shut_s for stop in found) < table.stop.longest_s
    assert max(stop.shut_s for stop in found if stop.level == "low") < 12e-6


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"C1": 10e-9}, r"alive stops high, .* the gates are shut after 1\d\d µs, allowed are 40"),
        ({"C2": 10e-9}, r"alive stops low, .* the gates are shut after"),
        ({"R2": 100e3}, r"the gates are shut not within 130 µs, allowed are 40"),
        ({"R2": 1e3}, r"pass sinks to .* V, and .* V may shut"),
        ({"C1": 100e-12}, r"pass reaches .* V, and .* V may open"),
    ],
)
def test_a_wrong_part_of_the_pump_is_found(table, values, said):
    wrong = table.changed(**values)
    found = spice.stops(wrong, [FAMILY_TICK_S], [spice.nominal(table)])
    lines = spice.stop_complaints(wrong, found)
    assert any(re.search(said, line) for line in lines), lines


@pytest.mark.parametrize("family", FAMILIES)
def test_no_gate_rises_while_the_fpga_is_configured_anew(table, family):
    found = spice.configured_anew(table, family, FAMILY_TICK_S)
    assert spice.anew_complaints(table, family, found) == []
    assert [anew.level for anew in found] == ["high", "low"]
    assert 0.1 < max(anew.pin_v for anew in found) < 0.25


def test_pull_downs_on_the_bridges_side_alone_let_both_switches_on(table):
    found = spice.configured_anew(table, "ice40", FAMILY_TICK_S, fpga_side=False)
    lines = spice.anew_complaints(table, "ice40", found)
    assert any(re.search(r"HI and LI reach 3\.\d\d V together", line) for line in lines), lines


def test_ten_kilohm_do_not_hold_an_ice40(table):
    wrong = table.changed(R4={"ice40": 10e3, "ecp5": 10e3})
    found = spice.configured_anew(wrong, "ice40", FAMILY_TICK_S)
    assert any(
        "a pin of the FPGA stands at 1." in x for x in spice.anew_complaints(wrong, "ice40", found)
    )


def test_gates_are_shut_while_the_supply_falls(table):
    assert spice.brown_out(table, FAMILY_TICK_S) < 0.1
    assert spice.brown_out(table, FAMILY_TICK_S, supervised=False) > table.levels.v_ih


def test_ngspice_that_is_missing_or_fails_is_said_in_a_line(monkeypatch):
    with pytest.raises(WiringError, match=r"^ngspice: ") as failure:
        spice.run("* nothing\nR1 a 0 {nobody}\n.tran 1n 1u\n.meas tran x MAX v(a)\n.end\n")
    assert "\n" not in str(failure.value)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(WiringError, match="ngspice is not installed; type `make setup`"):
        spice.run("* nothing\n.end\n")
