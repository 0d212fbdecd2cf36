# SPDX-License-Identifier: Apache-2.0
"""Yosys' mutants of a module, each run on the module's own bench.

All mutants of a module are in one netlist, and ``+mutant=<number>`` chooses which one is awake; 0
is none. So a bench is built once. The netlist has the module's name and takes its place; where the
bench gives the module parameters, a module with the original's ports stands between, which takes
the original for other parameters. What the tests let pass, Yosys compares with the original: an
induction over all that is equal in both shows that some can't be seen from outside at all.
"""

from __future__ import annotations

import json
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

from wavehaptics.runtime.files import digest_of
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain, ToolError

from wavetools.checks.mutation.models import python_files
from wavetools.checks.mutation.processes import run_tests
from wavetools.checks.mutation.results import (
    EQUIVALENT,
    KILLED,
    OUT,
    SURVIVED,
    Mutant,
    Store,
    with_reasons,
)
from wavetools.checks.mutation.table import Block, MutationError

BENCHES = Path("cocotb_tests")
EQUAL_S = 120
"""Longest comparison of a survivor with the original, s."""

PATIENCE = 5.0
"""A mutant that runs longer than this many clean runs and SLACK_S hangs."""
SLACK_S = 60.0

BUILD_S = 3600.0
"""Longest build and run without a mutant, s."""

_SELECT = """
// Which mutant is awake.
module wh_mutant (output reg [15:0] mutant_o);
    initial begin
        if (!$value$plusargs("mutant=%d", mutant_o)) mutant_o = 16'd0;
        $display("mutant %0d is in this run", mutant_o);
    end
endmodule
"""


# ---- Mutants.


def rtl_files(module: str, root: Path = ROOT) -> list[Path]:
    """The module's file and those of all that it uses, from the root."""
    found: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        path = Path("rtl", f"{name}.v")
        if name in found or not (root / path).exists():
            continue
        found[name] = path
        waiting += re.findall(r"\bwh_\w+\b", (root / path).read_text(encoding="utf-8"))
    return [found[name] for name in sorted(found)]


def mutated(
    block: Block, seed: int, tools: Toolchain, folder: Path
) -> tuple[list[str], list[Path]]:
    """(Yosys' commands, one a mutant, and the files of the netlist that holds all of them)."""
    folder.mkdir(parents=True, exist_ok=True)
    where = folder.relative_to(ROOT)
    inner = inner_name(block)
    parameters = "".join(f" -chparam {name} {value}" for name, value in block.own.items())
    choice = (
        f"mutate -list {block.mutants} -seed {seed} -ctrl mutant_i 16 1 -module {inner}"
        f" -o {where}/mutants.ys"
    )
    # A word that is put into one of several by a variable is a $shift without a sign, which
    # write_verilog would give that of its wire: behind the word would be a negative one's sign.
    script = f"""
        read_verilog -defer -Irtl {" ".join(map(str, rtl_files(block.module)))}
        hierarchy -top {block.module}{parameters}
        prep -top {block.module}
        rename {block.module} {inner}
        write_rtlil {where}/prepared.il
        {choice}
        script {where}/mutants.ys
        techmap t:$shift
        write_json {where}/ports.json
        write_verilog -noattr {where}/{inner}.v
    """
    (folder / "make.ys").write_text(re.sub(r"^ +", "", script.lstrip("\n"), flags=re.M))
    log = folder / "make.log"
    if tools.run("yosys", ["-q", "-s", f"{where}/make.ys"], ROOT, log):
        raise MutationError(f"{block.name}: Yosys makes no mutants, see {log}")
    commands = (folder / "mutants.ys").read_text(encoding="utf-8").splitlines()
    commands = [line for line in commands if line.startswith("mutate ")]
    if len(commands) != block.mutants:
        raise MutationError(f"{block.name}: {block.mutants} mutants wanted, {len(commands)} found")
    netlist = folder / f"{inner}.v"
    text = with_parts(with_select(netlist.read_text(encoding="utf-8"), inner), inner)
    netlist.write_text("`timescale 1ns / 1ps\n" + text + _SELECT, encoding="utf-8")
    files = [netlist]
    if inner != block.module:
        ports = json.loads((folder / "ports.json").read_bytes())["modules"][inner]["ports"]
        source = (ROOT / "rtl" / f"{block.module}.v").read_text(encoding="utf-8")
        between = folder / f"{block.module}.v"
        between.write_text(_between(block, inner, source, sorted(set(ports) - {"mutant_i"})))
        files.append(between)
    return commands, files


def inner_name(block: Block) -> str:
    """Name of the module that has the mutants: its own if no parameters have to be looked at."""
    return f"{block.module}_mutants" if block.own else block.module


def with_select(text: str, module: str) -> str:
    """The netlist with its port ``mutant_i`` driven from within."""
    start = re.search(rf"^module {module}\(", text, re.M)
    if start is None:
        raise MutationError(f"{module} isn't in its netlist")
    head, body = text[: start.start()], text[start.start() :]
    end = body.index(");")
    ports = [name.strip() for name in body[body.index("(") + 1 : end].split(",")]
    ports.remove("mutant_i")
    body = f"module {module}({', '.join(ports)}{body[end:]}"
    body, changed = re.subn(
        r"^  input \[15:0\] mutant_i;\n",
        "  wh_mutant mutant_select (.mutant_o(mutant_i));\n", body, count=1, flags=re.M,
    )  # fmt: skip
    declared = "  wire [15:0] mutant_i;\n"
    if not changed or declared not in body:
        raise MutationError(f"{module}: the netlist has no port mutant_i")
    # Before it is used, as Verilog wants it.
    body = body.replace(declared, "", 1).replace(");\n", f");\n{declared}", 1)
    return head + body


def with_parts(text: str, module: str) -> str:
    """The netlist with names of its own for the module's parts: those of rtl have parameters."""
    for part in set(re.findall(r"^module (wh_\w+)\(", text, re.M)) - {module}:
        text = re.sub(rf"^(module |  ){part}(?=[ (])", rf"\1{part}_of_{module}", text, flags=re.M)
    return text


def _between(block: Block, inner: str, source: str, ports: list[str]) -> str:
    """A module with the original's head that takes the mutants, or the original."""
    begin = re.search(rf"^module {block.module}\b", source, re.M)
    end = re.search(r"^\);", source, re.M)
    if begin is None or end is None:
        raise MutationError(f"{block.name}: no head of a module in rtl/{block.module}.v")
    head = re.sub(r"\boutput reg\b", "output wire", source[: end.end()])
    original = f"{block.module}_original"
    names = re.findall(r"\bparameter\b[^=]*?(\w+)\s*=", head)
    passed = ", ".join(f".{name}({name})" for name in names)
    pins = ", ".join(f".{port}({port})" for port in ports)
    same = " && ".join(f"{name} == {value}" for name, value in block.own.items())
    return (
        f"`timescale 1ns / 1ps\n{head}\n    generate\n        if ({same}) begin : mutants\n"
        f"            {inner} inner ({pins});\n        end else begin : other_parameters\n"
        f"            {original} #({passed}) inner ({pins});\n        end\n    endgenerate\n"
        "endmodule\n\n"
        + re.sub(rf"^module {block.module}\b", f"module {original}", source, flags=re.M)
    )


def place_of(command: str) -> str:
    """``rtl/file.v:line`` of one of Yosys' commands."""
    found = re.findall(r"-src (?:\S*/)?(rtl/\w+\.v:\d+)", command)
    return found[-1] if found else "?"  # the last one is the cell's, before it is the wire's


def what_of(command: str) -> str:
    """What one of Yosys' commands changes, in words that no counter of Yosys' is in."""
    told = dict(re.findall(r"-(mode|cell|port|portbit|ctrlbit|wire|wirebit) (\S+)", command))
    cell = re.match(r"[\\$]*(\w+)", told.get("cell", "?"))
    text = f"{told['mode']} {told.get('port', '?').lstrip(chr(92))}[{told.get('portbit', 0)}]"
    if "ctrlbit" in told:
        text += f" by bit {told['ctrlbit']}"
    text += f" of {cell[1] if cell else '?'}"
    if "wire" in told:
        text += f", {told['wire'].lstrip(chr(92))}[{told.get('wirebit', 0)}]"
    return text


# ---- Runs.


def _test_sources(block: Block) -> list[Path]:
    """Files that the bench's verdict depends on, besides the netlist."""
    found: dict[Path, None] = {}
    tests = [ROOT / BENCHES / f"{block.test}.py", ROOT / BENCHES / "simulators.py"]
    top = ROOT / BENCHES / f"{block.top}.v"
    modules = [block.module]
    if top.exists():
        found[top] = None
        modules += re.findall(r"\bwh_\w+\b", top.read_text(encoding="utf-8"))
    elif block.top != block.module:
        modules.append(block.top)
    for module in modules:
        found.update(dict.fromkeys(ROOT / path for path in rtl_files(module)))
    found.update(dict.fromkeys(_headers(list(found))))
    found.update(dict.fromkeys(python_files(tests)))
    return sorted(found)


def _headers(files: list[Path]) -> list[Path]:
    """Headers of rtl/ that the files include, and those that these include."""
    found: list[Path] = []
    waiting = list(files)
    while waiting:
        text = waiting.pop().read_text(encoding="utf-8")
        for name in re.findall(r'^\s*`include "(\w+\.vh)"', text, re.M):
            path = ROOT / "rtl" / name
            if path.exists() and path not in found:
                found.append(path)
                waiting.append(path)
    return found


def key_of(block: Block, commands: list[str], files: list[Path], tools: str) -> str:
    """Of all that the block's results depend on."""
    told = (block.test, block.top, sorted(block.parameters.items()), commands, tools)
    return digest_of((*told, *block.without), [*files, *_test_sources(block)])


def _work(block: Block) -> Path:
    """Where the bench leaves what it says."""
    return ROOT / "build" / "cocotb" / f"mutate-{block.name}" / "verilator"


def bench_run(block: Block, job: Path, number: int, timeout_s: float) -> str:
    """What saw the mutant, or "" if all tests pass. :class:`MutationError` if nothing is built."""
    environment = {"COCOTB_MAX_FAILURES": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    if block.without:
        environment["COCOTB_TEST_FILTER"] = rf"^(?!.*\b(?:{'|'.join(block.without)})$)"
    command = [sys.executable, str(ROOT / BENCHES / "mutant.py"), str(job), str(number)]
    log = job.parent / "run.log"
    status = run_tests(command, ROOT, environment, log, timeout_s)
    if status is None:
        return "hangs"
    work = _work(block)
    if status == 0:
        said = (work / "test.log").read_text(encoding="utf-8", errors="replace")
        if f"mutant {number} is in this run" not in said:
            raise MutationError(f"{block.name}: {block.test} has no mutant in it, see {work}")
        return ""
    if status != 1:
        raise MutationError(f"{block.name}: the bench can't be built, see {log}")
    try:
        cases = ElementTree.parse(work / "results.xml").iter("testcase")
    except (OSError, ElementTree.ParseError):
        return f"{block.test}: ends early"
    failed = [case.get("name", "?") for case in cases if case.find("failure") is not None]
    return f"{block.test}.{failed[0]}" if failed else f"{block.test}: ends early"


def run_block(
    block: Block,
    seed: int,
    tools: Toolchain,
    versions: str,
    progress: Callable[[int], None] = lambda done: None,
) -> list[Mutant]:
    """All mutants of a block; those that are known from an earlier, equal run aren't run again."""
    folder = ROOT / OUT / "rtl" / block.name
    commands, files = mutated(block, seed, tools, folder)
    store = Store(folder / "results.json", key_of(block, commands, files, versions))
    job = folder / "job.json"
    told = {
        "toplevel": block.top,
        "test_module": block.test,
        "parameters": block.parameters,
        "name": f"mutate-{block.name}",
        "sources": [str(path) for path in files],
    }
    job.write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")
    if store.clean_s is None:
        if seen := bench_run(block, job, 0, BUILD_S):
            raise MutationError(f"{block.name}: fails without a mutant ({seen}), see {job.parent}")
        cases = ElementTree.parse(_work(block) / "results.xml").iter("testcase")
        store.clean_s = round(sum(float(case.get("time", 0)) for case in cases), 2)
        store.keep()
    limit_s = SLACK_S + PATIENCE * store.clean_s
    for number, command in enumerate(commands, 1):
        if number not in store.mutants:
            start = time.monotonic()
            seen = bench_run(block, job, number, limit_s)
            state = KILLED if seen else SURVIVED
            if not seen and is_equal(block, command, tools, folder, number):
                state, seen = EQUIVALENT, "Yosys proves all outputs equal by induction"
            store.keep(
                Mutant(
                    block.name, number, place_of(command), what_of(command), state, seen,
                    round(time.monotonic() - start, 1),
                )
            )  # fmt: skip
        progress(number)
    return with_reasons([store.mutants[n] for n in range(1, len(commands) + 1)], block.equivalent)


def is_equal(block: Block, command: str, tools: Toolchain, folder: Path, number: int) -> bool:
    """Whether Yosys can prove that the mutant has the original's outputs, always."""
    where, inner = folder.relative_to(ROOT), inner_name(block)
    awake = re.sub(r"-ctrl mutant_i \d+ \d+ ", "", command).replace(
        f"-module {inner} ", "-module gate "
    )
    script = "\n".join(
        [
            f"read_rtlil {where}/prepared.il", f"copy {inner} gate", awake, f"rename {inner} gold",
            "memory_map", "flatten gold gate", "delete t:$check t:$print",
            "opt_clean gold gate",
            "dffunmap gold gate", "equiv_make gold gate equal", "hierarchy -top equal",
            "clean -purge", "equiv_struct", "equiv_simple -short",
            "equiv_induct -seq 4", "equiv_status -assert",
        ]
    )  # fmt: skip
    path = folder / f"equal-{number}.ys"
    path.write_text(script + "\n", encoding="utf-8")
    log = folder / f"equal-{number}.log"
    try:
        return tools.run("yosys", ["-s", f"{where}/{path.name}"], ROOT, log, EQUAL_S) == 0
    except ToolError:
        return False
