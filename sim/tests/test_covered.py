# SPDX-License-Identifier: Apache-2.0
"""`make coverage`: counts of many builds are summed, and what isn't covered is named."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner
from wavehaptics.runtime.repository import ROOT
from wavetools.checks import covered

HEADER = "# SystemC::Coverage-3\n"


def counted(root: Path, count: int, **point: object) -> str:
    """A line of Verilator's counts; ``file`` is from the root."""
    fields = {"f": root / point.pop("file"), "t": point["page"], "h": "top"} | point
    fields["page"] = f"v_{point['page']}/wh_a"
    told = "".join(f"\x01{key}\x02{value}" for key, value in fields.items())
    return f"C '{told}' {count}\n"


def test_counts_of_two_builds_are_summed_and_the_rest_is_named(tmp_path):
    a, other = "rtl/wh_a.v", "sim/verilated/wh_b.v"
    one, two = tmp_path / "one.dat", tmp_path / "two.dat"
    block = {"file": a, "l": 4, "n": 5, "page": "line", "o": "block", "S": "4,6-7"}
    taken = {"file": a, "l": 8, "n": 9, "page": "line", "o": "if", "S": "8-9"}
    never = {"file": a, "l": 8, "n": 10, "page": "line", "o": "else", "S": "11"}
    empty = {"file": a, "l": 9, "n": 9, "page": "line", "o": "else"}
    up = {"file": a, "l": 2, "n": 3, "page": "toggle", "o": "x_q[1]:0->1"}
    down = up | {"o": "x_q[1]:1->0"}
    clock = up | {"o": "clk:0->1"}
    outside = block | {"file": other}
    one.write_text(
        HEADER + counted(tmp_path, 3, **block) + counted(tmp_path, 0, **taken)
        + counted(tmp_path, 0, **never) + counted(tmp_path, 0, **up) + counted(tmp_path, 9, **clock)
        + counted(tmp_path, 0, **empty)
        + counted(tmp_path, 0, **outside)
    )  # fmt: skip
    two.write_text(
        HEADER + counted(tmp_path, 2, **taken) + counted(tmp_path, 0, **never)
        + counted(tmp_path, 1, **up) + counted(tmp_path, 0, **down)
        + counted(tmp_path, 1, **block)
    )  # fmt: skip
    points = list(covered.merge([one, two]))
    assert sum(count for _, count in points) == 3 + 9 + 2 + 1 + 1
    assert covered.of_rtl(points, tmp_path) == {
        a: {
            "lines": 6, "lines_covered": 5, "toggles": 3, "toggles_covered": 2,
            "uncovered": [11], "never": ["8: else", "9: else"],
            "signals": {"x_q": {"toggles": 2, "covered": 1}},
        }
    }  # fmt: skip
    alone = covered.of_rtl(covered.merge([one]), tmp_path)
    assert alone[a]["uncovered"] == [8, 9, 11]


def test_another_file_than_counts_is_refused(tmp_path):
    (tmp_path / "x.dat").write_text("C 'x' 1\n")
    with pytest.raises(covered.CoverageError, match=r"x\.dat: not a file of Verilator's counts"):
        list(covered.merge([tmp_path / "x.dat"]))


SOURCE = """import numba
@compiled()
def loop(n):
    return n
@numba.njit
def other(n):
    return n
def plain(n):
    if n:
        return 1
    return 2
"""


def test_lines_of_compiled_functions_are_told_apart(tmp_path):
    (tmp_path / "a.py").write_text(SOURCE)
    totals = {
        "num_statements": 10, "covered_lines": 6, "num_branches": 2, "covered_branches": 1,
    }  # fmt: skip
    file = {
        "summary": totals, "missing_lines": [4, 7, 11], "missing_branches": [[9, 11], [4, -3]],
    }  # fmt: skip
    (found,) = covered.of_python({"files": {"a.py": file}}, tmp_path).values()
    assert (found["lines"], found["lines_covered"]) == (10, 6)
    assert (found["branches"], found["branches_covered"]) == (2, 1)
    assert found["compiled"] == 2
    assert found["compiled_functions"] == ["loop", "other"]
    assert found["uncovered"] == [11]
    assert found["uncovered_branches"] == [[9, 11]]


def test_every_compiled_function_of_the_package_is_known():
    """By the decorators' names: of `golden` and `pins` as numba has them."""
    from numba.core.dispatcher import Dispatcher
    from wavehaptics.controller import wave_core
    from wavehaptics.ladder import pins_loop

    for module in (wave_core, pins_loop):
        known = covered.compiled_functions(Path(module.__file__).read_text(encoding="utf-8"))
        here = {
            name for name, value in vars(module).items()
            if isinstance(value, Dispatcher) and value.__module__ == module.__name__
        }  # fmt: skip
        assert here
        assert here <= set(known)


def test_the_command_writes_what_is_covered_and_what_is_not(tmp_path, monkeypatch):
    out = tmp_path / covered.OUT
    (out / "rtl" / "cocotb" / "bench" / "verilator").mkdir(parents=True)
    monkeypatch.setattr(covered, "ROOT", tmp_path)
    none = CliRunner().invoke(covered.app, [])
    assert none.exit_code == 2
    (tmp_path / "a.py").write_text(SOURCE)
    totals = {
        "num_statements": 10, "covered_lines": 7, "num_branches": 2, "covered_branches": 1,
    }  # fmt: skip
    file = {"summary": totals, "missing_lines": [4, 7, 11], "missing_branches": [[9, 11]]}
    (out / "python.json").write_text(json.dumps({"files": {"a.py": file}}))
    point = {"file": "rtl/wh_a.v", "l": 4, "n": 5, "page": "line", "o": "if", "S": "4-5"}
    toggle = {"file": "rtl/wh_a.v", "l": 2, "n": 3, "page": "toggle", "o": "y[0]:0->1"}
    (out / "rtl" / "cocotb" / "bench" / "verilator" / "coverage.dat").write_text(
        HEADER + counted(tmp_path, 0, **point)
    )
    (out / "rtl" / "model-x.dat").write_text(HEADER + counted(tmp_path, 0, **toggle))
    done = CliRunner().invoke(covered.app, ["--quick"])
    assert done.exit_code == 0, done.output
    summary = json.loads((out / "summary.json").read_bytes())
    assert summary["quick"] is True
    assert summary["rtl"]["total"] == {
        "lines": 2, "lines_covered": 0, "toggles": 1, "toggles_covered": 0,
    }  # fmt: skip
    assert summary["python"]["total"]["compiled"] == 2
    assert (out / "uncovered.txt").read_text().splitlines() == [
        "a.py:11", "a.py:9: never on to line 11",
        "a.py: compiled, loop()", "a.py: compiled, other()",
        "rtl/wh_a.v:4", "rtl/wh_a.v:5", "rtl/wh_a.v:4: if, never", "rtl/wh_a.v: y toggles 0 of 1",
    ]  # fmt: skip


def test_a_bench_counts_the_block_that_it_runs():
    folder = ROOT / "build" / "test-coverage"
    counts = "cocotb/tb_synchroniser-wh_synchroniser-*/verilator/coverage.dat"
    for old in folder.glob(counts):
        old.unlink()
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "COVERAGE"))}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider",
         "cocotb_tests/test_benches.py::test_bench[verilator-synchroniser]"],
        cwd=ROOT, env=environment | {"WH_COVERAGE": str(folder)}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    found = covered.of_rtl(covered.merge(folder.glob(counts)), ROOT)["rtl/wh_synchroniser.v"]
    assert found["lines"] == found["lines_covered"] > 0
    assert found["toggles"] >= found["toggles_covered"] > 0
