# SPDX-License-Identifier: Apache-2.0
"""The table of mutants fits the RTL, mutants are what they say, and a survivor shows."""

from __future__ import annotations

import json
import shutil
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from typer.testing import CliRunner
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain
from wavetools.checks.mutation import processes, results, rtl, run
from wavetools.checks.mutation.results import EQUIVALENT, KILLED, SURVIVED, Mutant, Store, summary
from wavetools.checks.mutation.table import Block, MutationError, load_table
from wavetools.cli.main import app

TABLE = load_table()
SMALL = Block("wh_half_bridge", 6, "tb_half_bridge", "wh_half_bridge", "test_mutation")


def mutant(number: int, state: str, place: str = "rtl/wh_x.v:1") -> Mutant:
    return Mutant("x", number, place, f"inv Y[{number}] of mux", state, "tb_x.walks", 1.0)


def test_every_module_has_its_mutants():
    modules = {path.stem for path in (ROOT / "rtl").glob("wh_*.v")}
    assert {block.module for block in TABLE.blocks} == modules
    assert min(block.mutants for block in TABLE.blocks) >= 4
    assert sum(block.mutants for block in TABLE.blocks) >= 300


@pytest.mark.parametrize("block", TABLE.blocks, ids=[block.name for block in TABLE.blocks])
def test_every_bench_is_there(block):
    assert (ROOT / "cocotb_tests" / f"{block.test}.py").is_file()
    if block.top == block.module:
        assert block.own == block.parameters
    else:
        assert block.module in _modules_below(block.top)


def _modules_below(top: str) -> set[str]:
    folders = (ROOT / "cocotb_tests", ROOT / "rtl")
    text = next(path.read_text() for folder in folders if (path := folder / f"{top}.v").is_file())
    return {path.stem for m in set(text.split()) for path in rtl.rtl_files(m.strip("(;#"))}


def test_a_choice_is_of_known_blocks():
    assert [block.name for block in run.chosen(TABLE, ["wh_trip"], False)] == ["trip"]
    assert run.chosen(TABLE, [], False) == [*TABLE.blocks, *TABLE.models]
    assert [model.module for model in run.chosen(TABLE, ["wave_core.py"], False)] == [
        "controller/wave_core"
    ]
    quick = run.chosen(TABLE, [], True)
    assert quick
    assert len(quick) < 5
    with pytest.raises(MutationError, match="no block tripp"):
        run.chosen(TABLE, ["tripp"], False)


def test_the_same_mutants_every_time_one_awake_by_its_number():
    tools = Toolchain.of_environment()
    folder = ROOT / "build" / "test_mutation"
    shutil.rmtree(folder, ignore_errors=True)
    commands, files = rtl.mutated(SMALL, 20, tools, folder)
    assert len(commands) == len(set(commands)) == SMALL.mutants
    assert rtl.mutated(SMALL, 20, tools, folder)[0] == commands
    assert rtl.mutated(SMALL, 21, tools, folder)[0] != commands
    text = files[0].read_text()
    assert "input [15:0] mutant_i" not in text
    assert text.count("wh_mutant mutant_select") == 1
    assert all(rtl.place_of(command).startswith("rtl/wh_half_bridge.v:") for command in commands)


def test_a_block_with_parameters_stands_behind_the_original_head():
    block = next(block for block in TABLE.blocks if block.name == "saturate")
    folder = ROOT / "build" / "test_mutation_between"
    _, files = rtl.mutated(block, 20, Toolchain.of_environment(), folder)
    text = files[1].read_text()
    assert "if (IN_W == 7 && OUT_W == 4) begin : mutants" in text
    assert "module wh_saturate_original" in text


def test_a_word_put_among_others_takes_its_sign_to_none_of_them():
    """`words[port*W +: W] <= word`: as Verilog a $shift of Yosys' has the sign of its wire."""
    block = next(block for block in TABLE.blocks if block.name == "axes")
    folder = ROOT / "build" / "test_mutation_shift"
    commands, files = rtl.mutated(block, 20, Toolchain.of_environment(), folder)
    assert len(commands) == block.mutants
    assert "cell $shift " in (folder / "prepared.il").read_text()
    assert " << - " not in files[0].read_text()


def test_a_part_without_parameters_is_no_part_of_rtl():
    text = "module wh_x(a);\n  wh_part one (a);\n  \\$p\\wh_part two (a);\nmodule wh_part(a);\n"
    assert rtl.with_parts(text, "wh_x") == (
        "module wh_x(a);\n  wh_part_of_wh_x one (a);\n  \\$p\\wh_part two (a);\n"
        "module wh_part_of_wh_x(a);\n"
    )


def test_a_place_and_a_change_hold_no_counter_of_the_tool():
    command = (
        "mutate -ctrl mutant_i 16 3 -mode cnot0 -module wh_x -cell $procdff$116 -port Q -portbit 18"
        " -ctrlbit 26 -wire place_q -wirebit 18 -src rtl/wh_x.v:64.2-64.3 -src rtl/wh_x.v:66.5-8.8"
    )
    assert rtl.place_of(command) == "rtl/wh_x.v:66"
    assert rtl.what_of(command) == "cnot0 Q[18] by bit 26 of procdff, place_q[18]"


def test_the_summary_counts_what_is_not_equivalent():
    mutants = [mutant(n, KILLED) for n in range(19)] + [
        mutant(19, SURVIVED),
        mutant(20, EQUIVALENT),
    ]
    found = summary({"x": mutants}, {})
    assert (found["mutants"], found["killed"], found["equivalent"]) == (21, 19, 1)
    assert found["score"] == 0.95
    assert found["enough"]
    assert [told["number"] for told in found["survivors"]] == [19]
    assert not summary({"x": [*mutants, mutant(21, SURVIVED)]}, {})["enough"]
    assert not summary({"x": mutants}, {"y": "can't be built"})["enough"]
    assert not summary({}, {})["enough"]


def test_a_reason_has_to_fit_a_survivor():
    reasons = {"rtl/wh_x.v:1 inv Y[2] of mux": "2 is never asked for"}
    told = results.with_reasons([mutant(1, SURVIVED), mutant(2, SURVIVED)], reasons)
    assert [(m.state, m.by) for m in told] == [
        (SURVIVED, "tb_x.walks"), (EQUIVALENT, "2 is never asked for"),
    ]  # fmt: skip
    twice = results.with_reasons([mutant(2, SURVIVED), mutant(2, SURVIVED)], reasons)
    assert [m.state for m in twice] == [EQUIVALENT, SURVIVED]
    with pytest.raises(MutationError, match="no survivor"):
        results.with_reasons([mutant(1, SURVIVED), mutant(2, KILLED)], reasons)


def test_what_is_known_is_not_run_again(monkeypatch, tmp_path):
    """Until a source changes. A run that was interrupted goes on."""
    asked = []

    def bench_run(block, job, number, timeout_s):
        if number and len(asked) == 3:
            raise KeyboardInterrupt
        asked.append(number)
        (tmp_path / "results.xml").write_text('<a><testcase time="2.5"/></a>')
        return "tb_half_bridge.seen" if number % 2 else ""

    monkeypatch.setattr(rtl, "bench_run", bench_run)
    monkeypatch.setattr(rtl, "is_equal", lambda *told: False)
    monkeypatch.setattr(rtl, "_work", lambda block: tmp_path)
    folder = ROOT / results.OUT / "rtl" / SMALL.name
    shutil.rmtree(folder, ignore_errors=True)
    tools = Toolchain.of_environment()
    with pytest.raises(KeyboardInterrupt):
        rtl.run_block(SMALL, 20, tools, "1")
    assert asked == [0, 1, 2]
    asked[:] = [-1] * 4
    found = rtl.run_block(SMALL, 20, tools, "1")
    assert asked[4:] == [3, 4, 5, 6]
    assert [m.state for m in found] == [KILLED, SURVIVED] * 3
    store = json.loads((folder / "results.json").read_text())
    assert store["clean_s"] == 2.5
    assert Store(folder / "results.json", store["digest"]).mutants.keys() == {1, 2, 3, 4, 5, 6}
    assert not Store(folder / "results.json", "another").mutants
    shutil.rmtree(folder)


def test_an_interrupted_run_leaves_no_process(tmp_path):
    sleeps = [sys.executable, "-c", "import time; print('on', flush=True); time.sleep(60)"]
    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(processes.run_tests, sleeps, tmp_path, {}, tmp_path / "log", 60)
        while not (tmp_path / "log").exists() or not (tmp_path / "log").read_text():
            time.sleep(0.05)
        processes.stop()
        with pytest.raises(processes.StoppedError):
            future.result(10)
    with pytest.raises(processes.StoppedError):
        processes.run_tests(sleeps, tmp_path, {}, tmp_path / "log", 60)
    processes.start()
    assert processes.run_tests(sleeps, tmp_path, {}, tmp_path / "log", 1.0) is None
    assert processes.run_tests([sys.executable, "-c", ""], tmp_path, {}, tmp_path / "log", 60) == 0


def test_yosys_tells_an_equal_mutant_from_another():
    """In wh_half_bridge a gate that never goes on is no equal of the original."""
    tools = Toolchain.of_environment()
    folder = ROOT / "build" / "test_mutation_equal"
    commands, _ = rtl.mutated(SMALL, 20, tools, folder)
    changed = next(command for command in commands if "-mode inv" in command)
    none = "mutate -ctrl mutant_i 16 1 -mode none -module wh_half_bridge "
    assert rtl.is_equal(SMALL, none, tools, folder, 0)
    assert not rtl.is_equal(SMALL, changed, tools, folder, 1)


def test_misuse_is_one_line(monkeypatch):
    monkeypatch.setattr(run, "load_table", lambda: TABLE)
    ended = CliRunner().invoke(app, ["mutate", "--block", "tripp"])
    assert "no block tripp" in str(ended.exception)


SOURCE = '''\
def first(x: int | None) -> int:
    """Says x + 1."""
    return x + 1 if x < 3 else -x


def second(x):
    return x * 2
'''


def test_changes_of_a_model_are_where_its_code_runs():
    pytest.importorskip("cosmic_ray", reason="comes with make mutate")
    from wavetools.checks.mutation.models import changes

    found = changes(SOURCE, ["first"], 12, 20)
    assert len(found) == len({change.text for change in found}) == 12
    assert {change.line for change in found} == {3}
    assert found == changes(SOURCE, ["first"], 12, 20)
    assert found != changes(SOURCE, ["first"], 12, 21)
    assert {change.line for change in changes(SOURCE, [], 30, 20)} == {3, 7}
    with pytest.raises(MutationError, match="no function third"):
        changes(SOURCE, ["third"], 1, 20)


@pytest.mark.parametrize("model", TABLE.models, ids=[model.name for model in TABLE.models])
def test_every_model_has_its_tests(model):
    assert model.tests
    for test in model.tests:
        path, _, name = test.partition("::")
        assert f"def {name.partition('[')[0]}" in (ROOT / path).read_text()
    source = (ROOT / "sim" / "wavehaptics" / f"{model.module}.py").read_text()
    assert all(f"def {function}(" in source for function in model.functions)
