# SPDX-License-Identifier: Apache-2.0
"""The table of proofs: it fits the RTL as it stands, and a run that isn't as it must be shows."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain
from wavetools.checks import proofs
from wavetools.checks.proofs import Proof, ProofError, Twin, jobs_of, load_table, sby_file, sources

ENTRIES, UNPROVEN = load_table()
JOBS = [job for proof in ENTRIES for job in jobs_of(proof)]

COUNTER = """\
module wh_small (input wire clk, input wire rst, output reg [3:0] count_o);
    always @(posedge clk) count_o <= (rst || count_o == 4'd9) ? 4'd0 : count_o + 4'd1;
endmodule
"""
TOP = """\
module prove_wh_small (input wire clk, input wire rst);
    wire [3:0] count;
    wh_small block (.clk(clk), .rst(rst), .count_o(count));
    reg begun = 1'b0;
    always @(posedge clk) begin
        begun <= 1'b1;
        if (!begun) assume (rst);
        if (begun) assert (count <= LIMIT);
        cover (begun && count == REACHED);
    end
endmodule
"""
TABLE = """\
[[proof]]
name = "small"
block = "wh_small"
property = "counts no further than that"
mode = "prove"
depth = 3
cover = 15
quick = true
[[proof.twin]]
file = "wh_small.v"
old = "4'd9"
new = "PLANTED"
depth = 15
"""


@pytest.mark.parametrize("job", JOBS, ids=[job.name for job in JOBS])
def test_sources_of_every_run_fit_the_rtl(job: proofs.Job) -> None:
    texts = sources(job)
    assert f"prove_{job.proof.top}.v" in texts
    assert f"{job.proof.block}.v" in texts
    module = re.search(r"\bmodule (\w+)", re.sub(r"//.*", "", texts[f"prove_{job.proof.top}.v"]))
    assert module is not None
    assert module[1] == f"prove_{job.proof.top}"
    if job.twin:
        planted = (ROOT / "rtl" / job.twin.file).read_text()
        assert texts[job.twin.file] != planted
        assert job.twin.new in texts[job.twin.file]
    for name in texts:
        assert f" {name}" in sby_file(job, sorted(texts)) or name.endswith(".vh")


def test_every_module_is_proven_or_has_a_reason() -> None:
    modules = {path.stem for path in (ROOT / "rtl").glob("*.v")}
    proven = {proof.block for proof in ENTRIES}
    assert proven <= modules
    assert UNPROVEN.keys() == modules - proven
    assert all(len(reason) > 20 for reason in UNPROVEN.values())


def test_every_block_has_a_twin_covers_and_a_quick_proof() -> None:
    for block in {proof.block for proof in ENTRIES}:
        entries = [proof for proof in ENTRIES if proof.block == block]
        assert sum(proof.quick for proof in entries) == 1, block
        for top in {proof.top for proof in entries}:
            assert any(proof.cover for proof in entries if proof.top == top), top
    for proof in ENTRIES:
        assert proof.twins, proof.name
        assert proof.skip < proof.depth, proof.name


def test_tops_assert_and_cover() -> None:
    tops = {proof.top for proof in ENTRIES}
    for path in (ROOT / "formal").glob("wh_*.v"):
        assert path.stem in tops, f"{path.name} is of no proof"
        text = path.read_text()
        assert "assert (" in text
        assert "cover (" in text


def test_a_twin_fits_once() -> None:
    assert Twin("x.v", "a", "b").planted("cat") == "cbt"
    for text in ("dog", "banana"):
        with pytest.raises(ProofError, match=r"x\.v: 'a' is there \d times, not once"):
            Twin("x.v", "a", "b").planted(text)


def test_a_twin_is_of_a_file_that_the_proof_reads() -> None:
    proof = replace(ENTRIES[0], twins=(Twin("wh_anchor.v", "a", "b"),))
    with pytest.raises(ProofError, match=r"wh_anchor\.v isn't part of that proof"):
        sources(jobs_of(proof)[-1])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('mode = "prove"', 'mode = "believe"', "mode is one of prove, bmc, not believe"),
        ("depth = 3", "deep = 3", "unknown deep"),
        ('mode = "prove"\n', "", "mode"),
        ("new = ", "now = ", "a twin has file, old, new"),
    ],
)
def test_a_table_that_is_wrong_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    (tmp_path / "formal").mkdir()
    (tmp_path / proofs.TABLE).write_text(TABLE.replace(old, new))
    with pytest.raises(ProofError, match=message):
        load_table(tmp_path)


def test_names_of_proofs_differ(tmp_path: Path) -> None:
    (tmp_path / "formal").mkdir()
    (tmp_path / proofs.TABLE).write_text(TABLE + TABLE)
    with pytest.raises(ProofError, match="two proofs are called small"):
        load_table(tmp_path)


def test_digest_follows_sources_settings_and_tools() -> None:
    job = next(job for job in JOBS if job.proof.name == "half_bridge")
    texts = sources(job)
    digest = proofs.digest(job, texts, "tools")
    assert digest == proofs.digest(job, dict(texts), "tools")
    changed = {**texts, "wh_half_bridge.v": texts["wh_half_bridge.v"] + " "}
    assert digest != proofs.digest(job, changed, "tools")
    assert digest != proofs.digest(job, texts, "newer tools")
    assert digest != proofs.digest(replace(job, depth=job.depth + 1), texts, "tools")


def test_verdict_is_the_last_word() -> None:
    log = (
        "SBY summary:   failed assertion top.x at top.v:3.4-5.6 step 7\n"
        "SBY [run] DONE (FAIL, rc=2)\n"
    )
    assert proofs.verdict(log) == ("FAIL", "top.v:3.4-5.6 step 7")
    assert proofs.verdict("ERROR: no such module\n") == ("ERROR", "no such module")


def test_quick_is_one_proof_of_each_block() -> None:
    quick = proofs.chosen(ENTRIES, None, quick=True)
    assert [job.kind for job in quick] == ["proof"] * len({proof.block for proof in ENTRIES})
    with pytest.raises(ProofError, match="no proof is about wh_nothing"):
        proofs.chosen(ENTRIES, "wh_nothing", quick=False)


def small(folder: Path, limit: int = 9, reached: int = 9, planted: str = "4'd11") -> Proof:
    """A project of one block in ``folder``, and its proof."""
    for name in ("rtl", "formal"):
        (folder / name).mkdir()
    (folder / "rtl" / "wh_small.v").write_text(COUNTER)
    top = TOP.replace("LIMIT", f"4'd{limit}").replace("REACHED", f"4'd{reached}")
    (folder / "formal" / "wh_small.v").write_text(top)
    (folder / proofs.TABLE).write_text(TABLE.replace("PLANTED", planted))
    return load_table(folder)[0][0]


@pytest.mark.parametrize(
    ("limit", "reached", "planted", "results"),
    [
        (9, 9, "4'd11", ["PASS", "PASS", "FAIL"]),
        (8, 9, "4'd11", ["UNKNOWN", "PASS", "FAIL"]),
        (9, 12, "4'd11", ["PASS", "FAIL", "FAIL"]),
        (9, 9, "4'd8", ["PASS", "PASS", "PASS"]),
    ],
    ids=["as it must be", "false", "about nothing", "blind"],
)
def test_a_run_that_is_not_as_it_must_be_shows(
    limit: int, reached: int, planted: str, results: list[str]
) -> None:
    # In the project's folder, since the packaged Yosys doesn't see the system's temporary one.
    folder = ROOT / proofs.OUT / f"test-{limit}-{reached}-{planted[-2:].strip('d')}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        tools = Toolchain.of_environment()
        jobs = jobs_of(small(folder, limit, reached, planted))
        outcomes = [proofs.run(job, tools, "tools", folder) for job in jobs]
        assert [outcome.result for outcome in outcomes] == results
        expected = ["PASS", "PASS", "FAIL"]
        assert [outcome.met for outcome in outcomes] == [
            result == good for result, good in zip(results, expected, strict=True)
        ]
        for outcome in outcomes:
            assert ("NOT" in proofs.line(outcome)) == (not outcome.met)
        data = json.loads(proofs.write_summary(outcomes, "tools", folder).read_text())
        assert [run["result"] for run in data["runs"]] == results

        # What was as it must be isn't run again, and what wasn't is.
        again = [proofs.run(job, tools, "tools", folder) for job in jobs]
        kept = [new.seconds == old.seconds for new, old in zip(again, outcomes, strict=True)]
        assert all(same for same, old in zip(kept, outcomes, strict=True) if old.met)
        assert [outcome.result for outcome in again] == results
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def test_a_name_that_is_not_there_stops_a_proof() -> None:
    folder = ROOT / proofs.OUT / "test-name"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        proof = small(folder)
        top = folder / "formal" / "wh_small.v"
        named = "(* hierconn *) wire [3:0] \\block.gone ;\n    reg begun"
        text = top.read_text().replace("reg begun", named)
        top.write_text(text.replace("count <=", "\\block.gone <="))
        outcome = proofs.run(jobs_of(proof)[0], Toolchain.of_environment(), "tools", folder)
        assert outcome.result == "ERROR"
        assert "check -assert" in outcome.fault
        assert not outcome.met
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def test_command_exits_with_what_happened(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    results = {"proof": "PASS", "cover": "PASS", "twin": "FAIL"}

    def fake(job: proofs.Job, *_: object) -> proofs.Outcome:
        return proofs._outcome(job, results[job.kind], "", 0.1, "digest")

    monkeypatch.setattr(proofs, "run", fake)
    monkeypatch.setattr(proofs, "tool_versions", lambda _: "tools")
    monkeypatch.setattr(
        proofs, "write_summary", lambda *_, **__: ROOT / proofs.OUT / "summary.json"
    )
    arguments = ["--block", "half_bridge"]
    good = CliRunner().invoke(proofs.app, arguments)
    assert good.exit_code == 0, good.output
    for kind, result in (("proof", "UNKNOWN"), ("twin", "PASS"), ("cover", "FAIL")):
        before = results[kind]
        results[kind] = result
        bad = CliRunner().invoke(proofs.app, arguments)
        assert bad.exit_code == 1, kind
        assert "NOT" in bad.output
        results[kind] = before
    assert CliRunner().invoke(proofs.app, ["--block", "nothing"]).exit_code == 2
