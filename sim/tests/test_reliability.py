# SPDX-License-Identifier: Apache-2.0
"""What the pages say of proofs, soak, coverage and tests is of their last whole run."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from wavetools.checks import proofs, soak
from wavetools.checks.proofs import Outcome
from wavetools.pages import filler, reliability

TESTS = (
    '<testsuites><testsuite tests="{}" failures="{}" errors="0" skipped="1" '
    'timestamp="2026-11-28T01:02:03+00:00"/></testsuites>'
)
NONE = {"sections": {"old_way": {"ratios": []}, "parts": {"scenes": {}}}, "seconds": 1.0}
NONE["sections"]["hard_cases"] = {"cases": []}
NONE["sections"]["field_oriented"] = {"curves": {"wall": []}}
HOLDING = {
    **{
        name: []
        for name in (
            "holds",
            "plain",
            "bars",
            "feels",
            "overloads",
            "hits",
            "rates",
            "free",
            "bounces",
            "lost",
        )
    },
}
BENCH = dict.fromkeys(("machine", "compiler", "verilator", "controllers"))
LINK_SOAK = {
    "bytes": 100_000_000, "bursts": 200_000, "frames": 250_000, "clocks": 9_900_000_000,
    "wrong": [],
}  # fmt: skip
SOAK = {"ticks": soak.WHOLE_TICKS, "episodes": 2000, "resets": 4000, "wrong": []}
COVERAGE = {
    "python": {"total": {"lines": 200, "lines_covered": 150, "branches": 40, "compiled": 30,
                         "branches_covered": 10}},
    "rtl": {"total": {"lines": 1000, "lines_covered": 990, "toggles": 4, "toggles_covered": 3}},
}  # fmt: skip
MUTATION = {"mutants": 1500, "killed": 1490, "equivalent": 8, "survived": 2}


def run(name: str, kind: str, mode: str = "prove", met: bool = True) -> Outcome:
    return Outcome(
        name=name, property="", module="wh_a", kind=kind, mode=mode, engine="smtbmc z3", depth=2,
        width="", result="", fault="", met=met, seconds=1.0, digest="",
    )  # fmt: skip


def write(root: Path, name: str, found: object) -> None:
    path = root / "build" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(found if isinstance(found, str) else json.dumps(found))


def kept(root: Path) -> dict:
    return json.loads((root / filler.MEASURED).read_bytes())


def rows(root: Path) -> dict[str, str]:
    """The table's rows by their first cell."""
    table = filler.TABLES["reliability"](kept(root))
    return {line.split("|")[1].strip(): line for line in table.splitlines()[2:]}


def test_a_command_that_was_not_run_has_no_row(tmp_path):
    assert filler.TABLES["reliability"]({}).splitlines()[2:] == []
    write(tmp_path, "soak/summary.json", SOAK)
    filler.keep(tmp_path)
    assert list(rows(tmp_path)) == ["soak"]


def test_rows_say_what_the_commands_found(tmp_path):
    outcomes = [run("a", "proof"), run("b", "proof", "bmc"), run("a.twin", "twin", "bmc"),
                run("a.cover", "cover", "cover"), run("c", "proof", met=False)]  # fmt: skip
    proofs.write_summary(outcomes, "tools", tmp_path)
    write(tmp_path, "soak/summary.json", SOAK | {"wrong": ["seed 3, tick 4: u"]})
    write(tmp_path, "soak-link/summary.json", LINK_SOAK)
    write(tmp_path, "mutate/summary.json", MUTATION)
    write(tmp_path, "coverage/summary.json", COVERAGE)
    write(tmp_path, "tests/quick.xml", TESTS.format(100, 0))
    write(tmp_path, "tests/rest.xml", TESTS.format(2000, 3))
    assert filler.keep(tmp_path) == []
    found = rows(tmp_path)
    proven = "2 properties proven with z3, 1 by induction, 1 over a bounded number of clocks; "
    assert f"{proven}1 planted faults found, 1 covers reached | c |" in found["proofs"]
    assert "100,000,000 ticks, 2,000 episodes, 4,000 resets | seed 3, tick 4: u |" in found["soak"]
    line = "100,000,000 bytes in 200,000 bursts, 250,000 frames that were right, 9.9e+09 clocks |"
    assert f"{line} nothing |" in found["soak of the link"]
    planted = found["planted changes of RTL and models"]
    assert "1,500 planted changes: 1,490 killed, 8 equivalent | 2 survived |" in planted
    python = found["coverage of the Python"]
    assert "75.0 % of 200 lines, 25.0 % of 40 branches; 30 of the others" in python
    assert "99.0 % of 1,000 lines, 75.0 % of 4 toggles | nothing |" in found["coverage of the RTL"]
    assert "2,095 passed, 2 skipped, 2026-11-28 | 3 failed |" in found["tests"]


def test_half_the_tests_are_not_taken_for_all(tmp_path):
    write(tmp_path, "tests/quick.xml", TESTS.format(100, 0))
    write(tmp_path, "soak/summary.json", SOAK)
    filler.keep(tmp_path)
    assert "tests" not in rows(tmp_path)
    assert "nothing" in rows(tmp_path)["soak"]


@pytest.mark.parametrize(
    ("name", "whole", "quick"),
    [
        ("report/report.json", NONE | {"quick": False}, NONE | {"quick": True, "seconds": 2.0}),
        ("bench/summary.json", BENCH | {"quick": False}, BENCH | {"quick": True}),
        ("soak-link/summary.json", LINK_SOAK, LINK_SOAK | {"bytes": 1_000_000}),
        ("soak/summary.json", SOAK, SOAK | {"ticks": 1_000_000, "episodes": 20}),
        ("mutate/summary.json", MUTATION,
         MUTATION | {"quick": True, "mutants": 3}),
        ("coverage/summary.json", COVERAGE,
         {"quick": True} | COVERAGE | {"rtl": COVERAGE["python"]}),
    ],
)  # fmt: skip
def test_a_quick_run_does_not_replace_a_whole_one(tmp_path, name, whole, quick):
    write(tmp_path, name, whole)
    for picture in ("old_way_limits.png", "held_wall.png"):
        write(tmp_path, f"report/{picture}", "whole")
    assert filler.keep(tmp_path) == []
    before = kept(tmp_path)
    write(tmp_path, name, quick)
    for picture in ("old_way_limits.png", "held_wall.png"):
        write(tmp_path, f"report/{picture}", "quick")
    assert filler.keep(tmp_path) == [Path("build", name)]
    assert kept(tmp_path) == before
    if name.startswith("report"):
        assert (tmp_path / "sim" / "docs" / "old_way_limits.png").read_text() == "whole"


def test_a_quick_study_of_holding_is_left_out(tmp_path, monkeypatch):
    monkeypatch.setitem(filler._STUDIES, filler._HOLDING, ("holding", dict))
    write(tmp_path, "holding/holding.json", HOLDING | {"quick": False})
    filler.keep(tmp_path)
    before = kept(tmp_path)
    write(tmp_path, "holding/holding.json", HOLDING | {"quick": True, "lost": [1]})
    assert filler.keep(tmp_path) == [filler._HOLDING]
    assert kept(tmp_path) == before


def test_a_part_of_the_proofs_leaves_the_summary_of_all(tmp_path):
    everything = proofs.write_summary([run("a", "proof"), run("b", "proof")], "tools", tmp_path)
    before = everything.read_bytes()
    part = proofs.write_summary([run("a", "proof")], "tools", tmp_path, part=True)
    assert part != everything
    assert everything.read_bytes() == before
    filler.keep(tmp_path)
    assert "2 properties proven" in rows(tmp_path)["proofs"]


def test_a_summary_that_does_not_say_whether_it_is_whole_is_not_taken_for_it(tmp_path):
    """The proofs' once held whichever runs came last."""
    write(tmp_path, "formal/summary.json", {"tools": "tools", "runs": []})
    write(tmp_path, "soak/summary.json", SOAK)
    assert filler.keep(tmp_path) == [filler._FORMAL]
    assert "proofs" not in rows(tmp_path)


def test_the_table_has_its_marker_on_its_page():
    for name in reliability.TABLES:
        assert filler.marked_pages(name) == [Path("docs", "reliability.md")]
