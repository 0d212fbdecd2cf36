# SPDX-License-Identifier: Apache-2.0
"""Cosmic Ray's mutants of the integer models, each in a copy of the tree with the model's tests.

Its operators make the changes; which of them, where, and what they run on is chosen here, because
its own sessions mutate the files in place and know no sample. The tests of a model are those of
pytest and, above all, the benches that hold the RTL to it word for word.
"""

from __future__ import annotations

import ast
import os
import random
import re
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from wavehaptics.runtime.files import digest_of
from wavehaptics.runtime.repository import ROOT

from wavetools.checks.mutation.processes import run_tests
from wavetools.checks.mutation.results import KILLED, OUT, SURVIVED, Mutant, Store, with_reasons
from wavetools.checks.mutation.table import Model, MutationError

PACKAGE = Path("sim", "wavehaptics")
_FOLDERS = {"wavehaptics": "sim", "wavetools": "tools"}
_TREE = ("sim", "tools", "cocotb_tests", "rtl", "boards", "formal", "conftest.py", "pyproject.toml")
_CLEAN_S = 3600.0
_PATIENCE, _SLACK_S = 5.0, 60.0

# No fault in a program's text: what they make is no program, or the same one.
_LEFT_OUT = ("Variable", "RemoveDecorator", "ExceptionReplacer", "NoOp")


@dataclass(frozen=True)
class Change:
    """The file's ``line`` is changed by ``operator``; ``text`` is the whole file then."""

    line: int
    operator: str
    text: str


def changes(source: str, functions: Sequence[str], count: int, seed: int) -> list[Change]:
    """``count`` changes of the functions' code, or of all, at different places if there are."""
    places = _places(source, functions)
    chance = random.Random(seed)
    keys = sorted(places)
    chance.shuffle(keys)
    for key in keys:
        chance.shuffle(places[key])
    found: dict[str, Change] = {}
    while any(places.values()) and len(found) < count:
        for key in keys:
            if places[key] and len(found) < count:
                operator, occurrence = places[key].pop()
                text = _changed(source, operator, occurrence)
                if text is not None:
                    found.setdefault(text, Change(key[0], operator.removeprefix("core/"), text))
    return sorted(found.values(), key=lambda change: (change.line, change.operator))


def _places(source: str, functions: Sequence[str]) -> dict[tuple[int, int], list[tuple[str, int]]]:
    """(operator, its occurrence) by line and column, where code runs."""
    try:
        from cosmic_ray.ast import ast_nodes, get_ast
        from cosmic_ray.plugins import get_operator, operator_names
    except ImportError:
        raise MutationError("Cosmic Ray is not there; run `make mutate`") from None
    wanted, unwanted = _spans(source, functions)
    tree = get_ast(source)
    nodes = list(ast_nodes(tree))
    places: dict[tuple[int, int], list[tuple[str, int]]] = {}
    for name in operator_names():
        if any(word in name for word in _LEFT_OUT):
            continue
        operator = get_operator(name)()
        positions = (place for node in nodes for place in operator.mutation_positions(node))
        for occurrence, (start, _) in enumerate(positions):
            within = any(low <= start < high for low, high in wanted)
            if within and not any(low <= start < high for low, high in unwanted):
                places.setdefault(tuple(start), []).append((name, occurrence))
    return places


def _spans(source: str, functions: Sequence[str]) -> tuple[list, list]:
    """(Where the functions' code is, where in it nothing runs: annotations and decorators)."""
    tree = ast.parse(source)
    defined = [n for n in ast.walk(tree) if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef))]
    names = {node.name for node in defined}
    if missing := set(functions) - names:
        raise MutationError(f"no function {', '.join(sorted(missing))} to be mutated")
    wanted = [_span(node) for node in defined if not functions or node.name in functions]
    unwanted = []
    for node in ast.walk(tree):
        for field in ("annotation", "returns"):
            if getattr(node, field, None) is not None:
                unwanted.append(_span(getattr(node, field)))
        unwanted += [_span(decorator) for decorator in getattr(node, "decorator_list", ())]
    return wanted, unwanted


def _span(node: ast.expr | ast.stmt) -> tuple[tuple[int, int], tuple[int, int]]:
    assert node.end_lineno is not None
    assert node.end_col_offset is not None
    return (node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset)


def _changed(source: str, operator: str, occurrence: int) -> str | None:
    """The text after an operator's change, None where that is no other program."""
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator

    text = mutate_code(source, get_operator(operator)(), occurrence)
    try:
        same = text is None or ast.dump(ast.parse(text)) == ast.dump(ast.parse(source))
    except SyntaxError:
        return None
    return None if same else text


def python_files(starts: Iterator[Path] | Sequence[Path]) -> list[Path]:
    """Files of the project that ``starts`` import, and they themselves."""
    found: dict[Path, None] = {}
    waiting = list(starts)
    while waiting:
        path = waiting.pop()
        if path in found or not path.is_file():
            continue
        found[path] = None
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            for name in names:
                ours = _FOLDERS.get(name.partition(".")[0])
                folder = ROOT / ours if ours else path.parent
                waiting.append(folder / f"{name.replace('.', '/')}.py")
    return sorted(found)


def key_of(model: Model, changed: Sequence[Change], versions: str) -> str:
    """Of all that the model's results depend on."""
    told = (model.tests, model.compiled, [change.text for change in changed], versions)
    starts = [ROOT / test.partition("::")[0] for test in model.tests]
    for test in list(starts):  # a test of the RTL names its bench
        benches = re.findall(r'"(tb_\w+)"', test.read_text(encoding="utf-8"))
        starts += [test.parent / f"{bench}.py" for bench in benches]
    starts.append(ROOT / PACKAGE / f"{model.module}.py")
    return digest_of(told, [*python_files(starts), *sorted((ROOT / "rtl").glob("*.v*"))])


def tree_of(model: Model) -> Path:
    """A copy of the project's files for the model's mutants; what was built there stays."""
    tree = ROOT / OUT / "models" / model.module / "tree"
    for name in _TREE:
        source, target = ROOT / name, tree / name
        if source.is_dir():
            shutil.rmtree(target, ignore_errors=True)
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", ".*"))
        else:
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target)
    return tree


def tests_fail(model: Model, tree: Path, timeout_s: float) -> str:
    """What saw the mutant that is in ``tree``, or "" if all tests pass."""
    environment = {
        "PYTHONPATH": os.pathsep.join(str(tree / name) for name in _FOLDERS.values()),
        "PYTHONDONTWRITEBYTECODE": "1",
        "COCOTB_MAX_FAILURES": "1",
    }
    if not model.compiled:
        environment["NUMBA_DISABLE_JIT"] = "1"
    options = ["-x", "-q", "-p", "no:cacheprovider", "--tb=line"]
    log = tree.parent / "run.log"
    command = [sys.executable, "-m", "pytest", *options, *model.tests]
    status = run_tests(command, tree, environment, log, timeout_s)
    if status is None:
        return "hangs"
    if status == 0:
        return ""
    said = log.read_text(encoding="utf-8", errors="replace")
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", said, re.M)
    if status not in (1, 2) or failed is None:
        raise MutationError(f"{model.module}: pytest ends with {status}, see {log}")
    return failed[1]


def run_model(
    model: Model, seed: int, versions: str, progress: Callable[[int], None] = lambda done: None
) -> list[Mutant]:
    """All mutants of a model; those that are known from an earlier, equal run aren't run again."""
    file = PACKAGE / f"{model.module}.py"
    source = (ROOT / file).read_text(encoding="utf-8")
    changed = changes(source, model.functions, model.mutants, seed)
    if len(changed) < model.mutants:
        raise MutationError(f"{model.module}: has {len(changed)} mutants, not {model.mutants}")
    folder = ROOT / OUT / "models" / model.module
    store = Store(folder / "results.json", key_of(model, changed, versions))
    if len(store.mutants) < len(changed):
        tree = tree_of(model)
        clean_s = store.clean_s
        if clean_s is None:
            for _ in range(2):  # the first one builds
                start = time.monotonic()
                if seen := tests_fail(model, tree, _CLEAN_S):
                    raise MutationError(f"{model.module}: fails without a mutant ({seen})")
                clean_s = round(time.monotonic() - start, 2)
            store.clean_s = clean_s
            store.keep()
        for number, change in enumerate(changed, 1):
            if number not in store.mutants:
                start = time.monotonic()
                (tree / file).write_text(change.text, encoding="utf-8")
                seen = tests_fail(model, tree, _SLACK_S + _PATIENCE * (clean_s or 0.0))
                place, what = f"{file}:{change.line}", _difference(source, change)
                state = KILLED if seen else SURVIVED
                seconds = round(time.monotonic() - start, 1)
                store.keep(Mutant(model.module, number, place, what, state, seen, seconds))
            progress(number)
    found = [store.mutants[number] for number in range(1, len(changed) + 1)]
    return with_reasons(found, model.equivalent)


def _difference(source: str, change: Change) -> str:
    """The operator, and the line as it became."""
    before, after = source.splitlines(), change.text.splitlines()
    line = next((new for old, new in zip(before, after, strict=False) if old != new), "")
    return f"{change.operator}: {line.strip()}"
