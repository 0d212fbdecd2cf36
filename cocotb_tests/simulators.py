# SPDX-License-Identifier: Apache-2.0
"""One call that builds a top level for a simulator, runs a cocotb test module on it, and judges.

A test file of pytest stays this short, and runs on each simulator (fixture ``simulator``)::

    from simulators import simulate

    def test_quadrature(simulator):
        simulate(simulator, "wh_quadrature", "tb_quadrature")

The top level is ``rtl/<toplevel>.v``, ``boards/<toplevel>.v``, or ``cocotb_tests/<toplevel>.v`` for
a bench around it that holds the clock; the modules below it are found in ``rtl`` and ``boards`` by
their names. In the test module, ``parameters`` and ``defines`` are the environment's
``WH_PARAMETERS`` and ``WH_DEFINES`` (JSON), read by :func:`parameters` and :func:`defines`.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

import cocotb
from cocotb_tools import config
from cocotb_tools.check_results import get_results
from cocotb_tools.runner import Runner, get_runner
from wavehaptics.runtime.files import digest_of
from wavehaptics.runtime.plain_paths import plain, workplace
from wavehaptics.runtime.repository import BUILD, ROOT, RTL_DIR

TESTS_DIR = ROOT / "cocotb_tests"
BOARDS_DIR = ROOT / "boards"
# Builds that count what they come through write coverage.dat beside their logs.
COVERAGE_DIR = os.environ.get("WH_COVERAGE", "")
BUILD_DIR = workplace(Path(COVERAGE_DIR or BUILD) / "cocotb")

SIMULATORS = ("icarus", "verilator")

_BUILD_ARGS = {
    "icarus": ["-y", str(RTL_DIR), "-y", str(BOARDS_DIR), "-Wall", "-Wno-timescale"],
    "verilator": ["-y", str(RTL_DIR), "-y", str(BOARDS_DIR), "--timing", "-O3"],
}

# For files that a tool made: not written for lint.
_MADE_ARGS = {
    "icarus": [],
    "verilator": ["-Wno-lint", "-Wno-style", "-Wno-SPECIFYIGN", "-Wno-fatal"],
}
# A test that can see each wire of a design is compiled for twice as long, and runs more slowly.
_TOP_ONLY = "--no-public-flat-rw"
_SHOW_TOP = '`verilator_config\npublic_flat_rw -module "{toplevel}" -var "*"\n'


# OPT_GLOBAL is of Verilator's own runtime, where benches spend their time; ccache compiles it once.
_MAKE_FLAGS = "OPT_FAST=-O1 OPT_SLOW=-O0 OPT_GLOBAL=-O2"


class SimulationError(AssertionError):
    """A build failed, a test failed, or no test ran; the message says where to look."""


# The linker and make are given these, and a folder with a space is two words to them.
config.libs_dir, config.share_dir = plain(config.libs_dir), plain(config.share_dir)


@contextlib.contextmanager
def _toolchain() -> Iterator[str]:
    """Environment in which the Verilator in use works, and builds fast; its program."""
    # Not at the top: a bench that reads other word lengths has to import its own model first.
    from wavehaptics.ladder.verilated import verilator_environment

    before = dict(os.environ)
    program, environment = verilator_environment()
    os.environ.update(environment)
    os.environ["MAKEFLAGS"] = f"{_MAKE_FLAGS} {environment.get('MAKEFLAGS', '')}".strip()
    try:
        yield program
    finally:
        os.environ.clear()
        os.environ.update(before)


def _source(toplevel: str) -> Path:
    for directory in (RTL_DIR, TESTS_DIR, BOARDS_DIR):
        if (directory / f"{toplevel}.v").exists():
            return directory / f"{toplevel}.v"
    raise SimulationError(f"no {toplevel}.v in {RTL_DIR}, {TESTS_DIR} or {BOARDS_DIR}")


_WORD = re.compile(r"\bwh_\w+(?:\.vh)?")


def _used_files(files: Sequence[Path], includes: Sequence[Path]) -> list[Path]:
    """The files and, by their names, those of the modules and headers that they use."""
    found: dict[Path, None] = {}
    waiting = list(files)
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found[path] = None
        words = sorted(set(_WORD.findall(path.read_text(encoding="utf-8"))))
        names = [word if word.endswith(".vh") else f"{word}.v" for word in words]
        for directory in (RTL_DIR, BOARDS_DIR, *includes):
            waiting += [directory / name for name in names if (directory / name).is_file()]
    return sorted(found)


def _runner(simulator: str, verilator: str) -> Runner:
    """cocotb's runner, whose Verilator is the program ``verilator``, given plain paths."""
    from wavehaptics.ladder.verilated import WITH_STACK

    runner = get_runner(simulator)
    if simulator == "verilator":
        build_command = runner._build_command

        def in_plain_paths() -> list[list[str]]:
            first, *more = build_command()
            told = [word.replace(str(ROOT.resolve()), str(ROOT)) for word in first]
            return [[*WITH_STACK, *told], *more]

        runner.executable = verilator
        runner._simulator_in_path_build_only = lambda: None
        runner._build_command = in_plain_paths
    return runner


def _build_digest(program: str | None, arguments: object, files: Sequence[Path]) -> str:
    """Of all that a build is made of: the simulator, what it is told, and the files."""
    program = Path(program or "").resolve()
    age = program.stat().st_mtime_ns if program.is_file() else 0
    flags = [os.environ.get(name) for name in ("MAKEFLAGS", "CXX", "WAVES")]
    return digest_of((program, age, flags, cocotb.__version__, arguments), files)


def _build_name(toplevel: str, test_module: str, *options: Mapping[str, object] | None) -> str:
    words = [f"{key}{value}" for option in options for key, value in (option or {}).items()]
    return re.sub(r"[^\w.-]+", "_", "-".join([test_module, toplevel, *words]))


def simulate(
    simulator: str,
    toplevel: str,
    test_module: str,
    parameters: Mapping[str, int] | None = None,
    defines: Mapping[str, int] | None = None,
    name: str | None = None,
    sources: Sequence[Path] = (),
    includes: Sequence[Path] = (),
    plusargs: Sequence[str] = (),
    inner: bool = False,
) -> None:
    """Build ``toplevel`` on ``simulator`` and run every cocotb test of ``test_module`` on it.

    ``parameters`` are the top level's Verilog parameters, ``defines`` macros (for instance
    ``{"WH_DATA_W": 18}``). ``name`` is the folder in ``build/cocotb``, by default made of all the
    arguments: calls that may run at the same time must differ in it. The folder holds ``build.log``
    and ``test.log``. Modules of the files ``sources`` take the place of those of ``rtl`` with the
    same name; these files aren't linted. The test sees the top level's own signals only. With
    ``inner`` it sees those below it, too, and the build takes twice as long. ``includes`` are
    folders of headers besides ``rtl``, ``plusargs`` what the design asks for with
    ``$value$plusargs``. What was built from the same sources, by the same tools and with the same
    options is used again. Raises
    :class:`SimulationError` unless tests ran and all of them passed.
    """
    __tracebackhide__ = True  # the message says all there is to say
    name = name or _build_name(toplevel, test_module, parameters, defines)
    work = BUILD_DIR / name / simulator
    work.mkdir(parents=True, exist_ok=True)
    build_log, test_log, results = work / "build.log", work / "test.log", work / "results.xml"
    environment = {
        "WH_PARAMETERS": json.dumps(dict(parameters or {})),
        "WH_DEFINES": json.dumps(dict(defines or {})),
        "COCOTB_ANSI_OUTPUT": "0",
        # Assertions say what they compared in benches; in every imported module it takes seconds.
        "COCOTB_REWRITE_ASSERTION_FILES": "tb_*.py",
        "PYTHONPATH": str(TESTS_DIR),
    }
    results.unlink(missing_ok=True)
    arguments, files = [*_BUILD_ARGS[simulator]], [*sources]
    if toplevel not in {source.stem for source in sources}:
        files.insert(0, _source(toplevel))
    if sources:
        arguments += _MADE_ARGS[simulator]
    if simulator == "verilator" and (sources or not inner):
        arguments.append(_TOP_ONLY)
        shown = work / "show_top.vlt"
        shown.write_text(_SHOW_TOP.format(toplevel=toplevel))
        files.insert(0, shown)
    with _toolchain() as verilator:
        os.environ.update(environment)
        if simulator == "verilator" and COVERAGE_DIR:
            from wavehaptics.ladder.verilated import COVERAGE_FLAGS

            arguments += COVERAGE_FLAGS
        if str(TESTS_DIR) not in sys.path:  # the runner hands sys.path on to the simulator
            sys.path.insert(0, str(TESTS_DIR))
        runner = _runner(simulator, verilator)
        told = (toplevel, sorted((parameters or {}).items()), sorted((defines or {}).items()))
        program = verilator if simulator == "verilator" else shutil.which("iverilog")
        digest = _build_digest(program, (told, arguments), _used_files(files, includes))
        stamp = work / "built"
        is_built = stamp.exists() and stamp.read_text(encoding="utf-8") == digest
        if is_built:
            runner._build_command = list  # no commands; a test wants the rest of what build() does
        else:
            stamp.unlink(missing_ok=True)
        try:
            runner.build(
                sources=files,
                includes=[RTL_DIR, *includes],
                defines=dict(defines or {}),
                parameters=dict(parameters or {}),
                build_args=arguments,
                hdl_toplevel=toplevel,
                always=True,
                build_dir=work,
                timescale=("1ns", "1ps"),
                log_file=build_log,
            )
        except (RuntimeError, SystemExit) as error:
            raise SimulationError(f"build failed: {error}\n{_tail(build_log)}") from None
        if not is_built:
            stamp.write_text(digest, encoding="utf-8")
        try:
            runner.test(
                test_module=test_module,
                hdl_toplevel=toplevel,
                build_dir=work,
                test_dir=work,
                results_xml=str(results),
                log_file=test_log,
                plusargs=list(plusargs),
                timescale=("1ns", "1ps") if simulator == "icarus" else None,
            )
        except (RuntimeError, SystemExit) as error:
            raise SimulationError(f"tests failed: {error}\n{_tail(test_log)}") from None
    _judge(results, test_log)


def _judge(results: Path, log: Path) -> None:
    """Raise unless the results file shows that tests ran and that all of them passed."""
    try:
        tests, failed = get_results(results)
    except RuntimeError as error:
        raise SimulationError(f"{error}\n{_tail(log)}") from None
    skipped = sum(1 for _ in ElementTree.parse(results).iter("skipped"))
    if tests - skipped < 1:
        raise SimulationError(f"no test ran\n{_tail(log)}")
    if failed:
        raise SimulationError(f"{failed} of {tests} tests failed\n{_tail(log)}")


def _tail(log: Path, lines: int = 120) -> str:
    text = log.read_text(errors="replace").splitlines() if log.exists() else []
    return "\n".join([f"--- the end of {log}", *text[-lines:]])


def parameters() -> dict[str, int]:
    """``parameters`` of the call to :func:`simulate` that runs this test module."""
    return json.loads(os.environ.get("WH_PARAMETERS", "{}"))


def defines() -> dict[str, int]:
    """``defines`` of the call to :func:`simulate` that runs this test module."""
    return json.loads(os.environ.get("WH_DEFINES", "{}"))
