# SPDX-License-Identifier: Apache-2.0
"""Formal proofs of the RTL: ``formal/proofs.toml`` says what, SBY and z3 do it.

``python -m wavetools.checks.proofs --help`` tells the options; ``make formal`` calls it. An
entry of the table gives several runs: the proof, the covers of its top, which show that the proof
isn't about nothing, and its twins. A twin is the same proof of an RTL with one planted fault, and
must find it. What has run before with the same sources and tools is not run again.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import typer
from wavehaptics.runtime.files import digest_of, write_json
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import tomllib
from wavehaptics.runtime.toolchain import Toolchain, ToolError

OUT = Path("build", "formal")
TABLE = Path("formal", "proofs.toml")
KINDS = ("proof", "cover", "twin")
EXPECTED = {"proof": "PASS", "cover": "PASS", "twin": "FAIL"}
"""What SBY has to say of a run."""

TIMEOUT_S = 1800
"""Longest run, s."""

_MODES = ("prove", "bmc")
_KEYS = {
    "name", "block", "top", "property", "width", "mode", "depth", "skip", "cover", "engine",
    "quick", "parameters", "shown", "defines", "instead", "twin",
}  # fmt: skip
_TWIN_KEYS = {"file", "old", "new", "depth", "skip", "shown"}


class ProofError(RuntimeError):
    """A table that can't be used, in one line."""


@dataclass(frozen=True)
class Twin:
    """A planted fault: ``old`` stands in ``rtl/<file>`` once, and ``new`` takes its place.

    Its first ``skip`` steps aren't looked at, where it can't show yet; ``shown`` goes before the
    proof's.
    """

    file: str
    old: str
    new: str
    depth: int | None = None
    skip: int = 0
    shown: dict[str, int] = field(default_factory=dict)

    def planted(self, text: str) -> str:
        """``text`` of the file with the fault; :class:`ProofError` unless it fits once."""
        found = text.count(self.old)
        if found != 1:
            raise ProofError(f"twin of {self.file}: {self.old!r} is there {found} times, not once")
        return text.replace(self.old, self.new)


@dataclass(frozen=True)
class Proof:
    """An entry of the table. ``cover`` is the depth of its cover run, None without one.

    ``skip`` steps of a search aren't looked at, where a proof claims nothing.

    ``instead`` gives modules that stand for others, as files of ``formal/``; ``width`` says at
    what word lengths the proof is, in words.
    """

    name: str
    block: str
    top: str
    property: str
    mode: str
    depth: int
    width: str = "full"
    skip: int = 0
    cover: int | None = None
    engine: str = "smtbmc --nopresat --unroll z3"
    quick: bool = False
    parameters: dict[str, int] = field(default_factory=dict)
    shown: dict[str, int] = field(default_factory=dict)
    defines: dict[str, int] = field(default_factory=dict)
    instead: dict[str, str] = field(default_factory=dict)
    twins: tuple[Twin, ...] = ()


@dataclass(frozen=True)
class Job:
    """One run of SBY: a proof, its covers, or one of its twins."""

    name: str
    kind: str
    proof: Proof
    mode: str
    depth: int
    twin: Twin | None = None


@dataclass(frozen=True)
class Outcome:
    """What a run came to. ``fault`` is the assertion or cover that failed, ``met`` the verdict."""

    name: str
    property: str
    module: str
    kind: str
    mode: str
    engine: str
    depth: int
    width: str
    result: str
    fault: str
    met: bool
    seconds: float
    digest: str


# ---- The table.


def load_table(root: Path = ROOT) -> tuple[list[Proof], dict[str, str]]:
    """Proofs, and the reason why a module has none; :class:`ProofError` where that is malformed."""
    data = tomllib.loads((root / TABLE).read_text(encoding="utf-8"))
    proofs = [_proof(entry) for entry in data.get("proof", [])]
    names = [proof.name for proof in proofs]
    for name in names:
        if names.count(name) > 1:
            raise ProofError(f"{TABLE}: two proofs are called {name}")
    return proofs, data.get("unproven", {})


def _proof(entry: dict[str, Any]) -> Proof:
    where = f"{TABLE}: {entry.get('name', '?')}"
    if unknown := entry.keys() - _KEYS:
        raise ProofError(f"{where}: unknown {', '.join(sorted(unknown))}")
    entry = dict(entry)
    twins = entry.pop("twin", [])
    for twin in twins:
        if twin.keys() - _TWIN_KEYS or not {"file", "old", "new"} <= twin.keys():
            raise ProofError(f"{where}: a twin has file, old, new and perhaps depth, skip, shown")
    entry.setdefault("top", entry.get("block"))
    try:
        proof = Proof(**entry, twins=tuple(Twin(**twin) for twin in twins))
    except TypeError as error:
        raise ProofError(f"{where}: {error}") from None
    if proof.mode not in _MODES:
        raise ProofError(f"{where}: mode is one of {', '.join(_MODES)}, not {proof.mode}")
    return proof


def jobs_of(proof: Proof) -> list[Job]:
    """The runs of an entry. A twin is looked for from the start on, so that it has a trace."""
    jobs = [Job(proof.name, "proof", proof, proof.mode, proof.depth)]
    if proof.cover is not None:
        jobs.append(Job(f"{proof.name}.cover", "cover", proof, "cover", proof.cover))
    for number, twin in enumerate(proof.twins, 1):
        name = f"{proof.name}.twin{number}"
        jobs.append(Job(name, "twin", proof, "bmc", twin.depth or proof.depth, twin))
    return jobs


# ---- Sources.


def sources(job: Job, root: Path = ROOT) -> dict[str, str]:
    """Text of each file that a run reads, by its name: the top, and what hangs on it."""
    proof = job.proof
    texts: dict[str, str] = {}
    todo = [f"prove_{proof.top}"]
    while todo:
        module = todo.pop()
        name = f"{module}.v"
        if name in texts:
            continue
        if module.startswith("prove_"):
            path = root / "formal" / f"{proof.top}.v"
        elif module in proof.instead:
            path = root / "formal" / proof.instead[module]
        else:
            path = root / "rtl" / name
        texts[name] = path.read_text(encoding="utf-8")
        code = re.sub(r"//.*", "", texts[name])
        for header in re.findall(r'`include "(\w+\.vh)"', code):
            if not (root / "rtl" / header).exists():
                continue  # a board's, which is read with a macro that no proof has
            texts[header] = (root / "rtl" / header).read_text(encoding="utf-8")
            code += re.sub(r"//.*", "", texts[header])
        for found in sorted(set(re.findall(r"\bwh_\w+\b", code)) - {module}):
            if found in proof.instead or (root / "rtl" / f"{found}.v").exists():
                todo.append(found)
    if job.twin:
        if job.twin.file not in texts or Path(job.twin.file).stem in proof.instead:
            raise ProofError(f"{job.name}: {job.twin.file} isn't part of that proof")
        texts[job.twin.file] = job.twin.planted(texts[job.twin.file])
    return texts


def sby_file(job: Job, files: list[str]) -> str:
    """SBY's description of a run whose files lie beside it."""
    proof = job.proof
    top = f"prove_{proof.top}"
    defines = "".join(f" -D{name}={value}" for name, value in proof.defines.items())
    values = proof.parameters
    if job.kind != "proof":
        values = {**values, **proof.shown, **(job.twin.shown if job.twin else {})}
    parameters = "".join(f" -chparam {name} {value}" for name, value in values.items())
    modules = " ".join(name for name in files if name.endswith(".v") and name != f"{top}.v")
    first = max(proof.skip, job.twin.skip if job.twin else 0)
    skip = [f"skip {first}"] if first and job.mode == "bmc" else []
    lines = [
        "[options]", f"mode {job.mode}", f"depth {job.depth}", f"timeout {TIMEOUT_S}", *skip,
        "[engines]", proof.engine,
        "[script]",
        f"read_verilog -formal -defer -I.{defines} {top}.v",
        f"read_verilog -formal -defer -I.{defines} {modules}",
        f"hierarchy -check -top {top}{parameters}",
        "proc",
        # Words of memories are registers that a top can name.
        "memory_collect",
        "memory_map",
        "flatten",
        "opt_clean",
        # A name that isn't there any more would be a free signal.
        "check -assert",
        "prep",
        "[files]", *files,
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def digest(job: Job, texts: dict[str, str], tools: str) -> str:
    """Of all that a run depends on; the time it may take isn't."""
    script = re.sub(r"^timeout .*\n", "", sby_file(job, sorted(texts)), flags=re.MULTILINE)
    return digest_of((script, sorted(texts.items()), job.kind, tools))


# ---- A run.


def tool_versions(tools: Toolchain) -> str:
    """Versions of Yosys and z3 in a line; :class:`ToolError` where one isn't there."""
    solver = tools.solver("z3")
    done = subprocess.run([solver, "--version"], capture_output=True, text=True, check=False)
    return f"Yosys {tools.check_age('yosys')}, {done.stdout.strip()}"


def run(
    job: Job, tools: Toolchain, versions: str, root: Path = ROOT, fresh: bool = False
) -> Outcome:
    """Run a job in ``build/formal/<name>``, or take what is there of an earlier, equal run."""
    texts = sources(job, root)
    key = digest(job, texts, versions)
    folder = root / OUT / job.name
    kept = folder / "outcome.json"
    if kept.exists() and not fresh:
        earlier = json.loads(kept.read_text(encoding="utf-8"))
        if earlier["digest"] == key and earlier["met"]:
            return replace(_outcome(job, "", "", 0.0, key), **earlier)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "run.sby").write_text(sby_file(job, sorted(texts)), encoding="utf-8")
    start = time.monotonic()
    arguments = ["-j", "1", "-f"]
    for tool in ("yosys", "yosys-smtbmc", "yosys-witness"):
        arguments += [f"--{tool.removeprefix('yosys-')}", tools.program(tool)]
    tools.run("sby", [*arguments, "run.sby"], folder, folder / "sby.log", TIMEOUT_S + 60)
    seconds = time.monotonic() - start
    log = (folder / "sby.log").read_text(encoding="utf-8", errors="replace")
    outcome = _outcome(job, *verdict(log), seconds, key)
    write_json(kept, asdict(outcome))
    return outcome


def verdict(log: str) -> tuple[str, str]:
    """(SBY's last word, what failed and where) of its log."""
    done = re.search(r"DONE \((\w+), rc=\d+\)", log)
    faults = re.findall(
        r"summary:\s+(?:failed assertion \S+ at|unreached cover statement \S+ at) (.*)", log
    )
    if not faults:
        faults = re.findall(r"ERROR: (.*)", log)[:1]
    return (done[1] if done else "ERROR"), "; ".join(line.strip() for line in faults)


def _outcome(job: Job, result: str, fault: str, seconds: float, key: str) -> Outcome:
    proof = job.proof
    return Outcome(
        name=job.name,
        property=proof.property,
        module=proof.block,
        kind=job.kind,
        mode=job.mode,
        engine=proof.engine,
        depth=job.depth,
        width=proof.width,
        result=result,
        fault=fault,
        met=result == EXPECTED[job.kind],
        seconds=round(seconds, 1),
        digest=key,
    )


# ---- All of them.

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, help=__doc__)


def chosen(proofs: list[Proof], block: str | None, quick: bool) -> list[Job]:
    """Runs of one block or of all; ``quick`` takes the marked proofs and leaves the rest out."""
    if block and block not in {proof.block for proof in proofs}:
        blocks = ", ".join(sorted({proof.block for proof in proofs}))
        raise ProofError(f"no proof is about {block}; there are {blocks}")
    picked = [proof for proof in proofs if not block or proof.block == block]
    if quick:
        return [jobs_of(proof)[0] for proof in picked if proof.quick]
    return [job for proof in picked for job in jobs_of(proof)]


def write_summary(
    outcomes: list[Outcome], versions: str, root: Path = ROOT, part: bool = False
) -> Path:
    """Write ``build/formal/summary.json``, or ``part.json`` of a part of the runs."""
    path = root / OUT / ("part.json" if part else "summary.json")
    data = {"tools": versions, "quick": part, "runs": [asdict(outcome) for outcome in outcomes]}
    return write_json(path, data)


def line(outcome: Outcome) -> str:
    """An outcome for a terminal."""
    verb = {"proof": "proven", "cover": "reached", "twin": "found"}[outcome.kind]
    if outcome.met:
        where = f" ({outcome.fault})" if outcome.kind == "twin" else ""
        return f"{outcome.name}: {verb} in {outcome.seconds:g} s, depth {outcome.depth}{where}"
    told = f" ({outcome.fault})" if outcome.fault else ""
    return f"{outcome.name}: NOT {verb}: {outcome.result}{told}, see {OUT / outcome.name}/sby.log"


@app.command()
def formal(
    block: Annotated[str, typer.Option(help="One module, with or without wh_.")] = "",
    quick: Annotated[
        bool, typer.Option(help="One proof of each block, no covers, no twins.")
    ] = False,
    only: Annotated[str, typer.Option(help="One run, or the runs of one entry.")] = "",
    fresh: Annotated[bool, typer.Option(help="Run what has been run before, too.")] = False,
    jobs: Annotated[int, typer.Option(min=1, help="Runs at a time.")] = 2,
) -> None:
    """Prove the RTL; 1 if anything isn't as it must be."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    try:
        proofs, _ = load_table()
        if block and not block.startswith("wh_"):
            block = f"wh_{block}"
        todo = chosen(proofs, block or None, quick)
        if only:
            todo = [job for job in todo if only in (job.name, job.proof.name)]
        tools = Toolchain.of_environment()
        versions = tool_versions(tools)
        outcomes: list[Outcome] = []
        console = Console(highlight=False)
        columns = (
            BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
            TextColumn("{task.description}"),
        )  # fmt: skip
        with (
            Progress(*columns, console=console, transient=True) as progress,
            ThreadPoolExecutor(jobs) as pool,
        ):
            bar = progress.add_task("proofs", total=len(todo))
            futures = [pool.submit(run, job, tools, versions, ROOT, fresh) for job in todo]
            for future in as_completed(futures):
                outcome = future.result()
                outcomes.append(outcome)
                progress.console.print(
                    line(outcome),
                    style=None if outcome.met else "bold red",
                    markup=False,
                    soft_wrap=True,
                )
                progress.update(bar, advance=1, description=outcome.name)
    except (ProofError, ToolError) as error:
        typer.echo(f"formal: {error}", err=True)
        raise typer.Exit(2) from None
    order = [job.name for job in todo]
    outcomes.sort(key=lambda outcome: order.index(outcome.name))
    path = write_summary(outcomes, versions, part=bool(block or quick or only))
    failed = sum(not outcome.met for outcome in outcomes)
    typer.echo(
        f"formal: {len(outcomes) - failed} of {len(outcomes)} runs are as they must be "
        f"({versions}); {path.relative_to(ROOT)}"
    )
    if failed or not outcomes:
        raise typer.Exit(1)


if __name__ == "__main__":
    app()
