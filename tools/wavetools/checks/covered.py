# SPDX-License-Identifier: Apache-2.0
"""What the tests came through: lines and branches of the package, lines and toggles of the RTL.

``make coverage`` runs the tests under coverage.py, the benches on Verilator without numba's
compiler, so that the integer models are seen there, and the others with it. Verilator's models
count in files of their own. Here both are summed into ``build/coverage/summary.json``, and each
line that isn't covered is named there and in ``uncovered.txt``.

- coverage.py doesn't see into a function that numba has compiled. Lines of such functions that no
  run without the compiler came through count as not covered, and are told apart as ``compiled``.
- A line of the RTL is covered when any build came through it with any parameters. What no build
  elaborated has no points: the file or the line isn't in the sums.
- A signal toggles by each bit and edge, over all instances and sizes of its module.
"""

from __future__ import annotations

import ast
import json
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from wavehaptics.runtime.files import write_json, write_text
from wavehaptics.runtime.repository import ROOT

OUT = Path("build", "coverage")
"""Where everything stands, from the root."""

_COMPILERS = {"compiled", "compiled_counting", "compiled_drawing", "njit", "intrinsic"}
"""Decorators of functions whose lines run as machine code."""


class CoverageError(ValueError):
    """Data that is missing or of another form. The message is one line."""


# ---- Python.


def compiled_functions(source: str) -> dict[str, range]:
    """Names of the functions that numba compiles, and the lines of their bodies."""

    def name(decorator: ast.expr) -> str:
        if isinstance(decorator, ast.Call):
            decorator = decorator.func
        if isinstance(decorator, ast.Attribute):
            return decorator.attr
        return decorator.id if isinstance(decorator, ast.Name) else ""

    return {
        node.name: range(node.body[0].lineno, (node.end_lineno or 0) + 1)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.FunctionDef)
        and any(name(decorator) in _COMPILERS for decorator in node.decorator_list)
    }


def of_python(found: dict[str, Any], root: Path) -> dict[str, dict[str, Any]]:
    """Files of coverage.py's JSON: counts, what isn't covered, and what of it is compiled."""
    files = {}
    for path, file in sorted(found["files"].items()):
        functions = compiled_functions((root / path).read_text(encoding="utf-8"))
        compiled = {line for lines in functions.values() for line in lines}
        missing, totals = file["missing_lines"], file["summary"]
        files[path] = {
            "lines": totals["num_statements"],
            "lines_covered": totals["covered_lines"],
            "branches": totals["num_branches"],
            "branches_covered": totals["covered_branches"],
            "compiled": len(compiled.intersection(missing)),
            "compiled_functions": [
                function for function, lines in functions.items() if set(lines) & set(missing)
            ],
            "uncovered": sorted(set(missing) - compiled),
            "uncovered_branches": [
                branch for branch in file["missing_branches"] if branch[0] not in compiled
            ],
        }
    return files


# ---- The RTL.

Point = dict[str, str]
"""What Verilator says of a point, by its short keys."""


def merge(paths: Iterable[Path]) -> Iterator[tuple[Point, int]]:
    """Each point of Verilator's files of counts once, with the sum of its counts."""
    counts: defaultdict[str, int] = defaultdict(int)
    for path in paths:
        with path.open(encoding="utf-8") as lines:
            if not next(lines, "").startswith("# SystemC::Coverage-3"):
                raise CoverageError(f"{path}: not a file of Verilator's counts")
            for line in lines:
                if line.startswith("C '"):
                    name, _, count = line[3:].rpartition("' ")
                    counts[name] += int(count)
    for name, hits in counts.items():
        yield dict(part.split("\x02", 1) for part in name.split("\x01")[1:]), hits


def _lines(told: str) -> Iterator[int]:
    """``4,7-9`` as 4, 7, 8, 9."""
    for part in filter(None, told.split(",")):
        first, _, last = part.partition("-")
        yield from range(int(first), int(last or first) + 1)


def of_rtl(points: Iterable[tuple[Point, int]], root: Path) -> dict[str, dict[str, Any]]:
    """Files of ``rtl`` and ``boards``: lines, toggles by signal, and what isn't covered."""
    hits: defaultdict[str, defaultdict[int, int]] = defaultdict(lambda: defaultdict(int))
    blocks: defaultdict[tuple[str, int, int, str], int] = defaultdict(int)
    toggles: defaultdict[str, defaultdict[str, int]] = defaultdict(lambda: defaultdict(int))
    for point, count in points:
        try:
            path = Path(point["f"]).resolve().relative_to(root.resolve())
        except ValueError:
            continue
        if path.parts[0] not in ("rtl", "boards"):
            continue
        file, kind = path.as_posix(), point["page"].partition("/")[0]
        if kind == "v_toggle":
            toggles[file][point["o"]] += count
        else:
            blocks[file, int(point["l"]), int(point["n"]), point["o"]] += count
            for line in _lines(point.get("S", "")):  # a way without statements has no lines
                hits[file][line] += count
    files = {}
    for file in sorted({*hits, *toggles}):
        signals: defaultdict[str, list[int]] = defaultdict(lambda: [0, 0])
        for name, count in toggles[file].items():
            signal = signals[name.partition(":")[0].partition("[")[0]]
            signal[0] += 1
            signal[1] += count > 0
        of_file = {key[1:]: count for key, count in blocks.items() if key[0] == file}
        files[file] = {
            "lines": len(hits[file]),
            "lines_covered": sum(count > 0 for count in hits[file].values()),
            "toggles": len(toggles[file]),
            "toggles_covered": sum(count > 0 for count in toggles[file].values()),
            "uncovered": sorted(line for line, count in hits[file].items() if not count),
            "never": [f"{line}: {what}" for (line, _, what), n in sorted(of_file.items()) if not n],
            "signals": {
                name: {"toggles": total, "covered": covered}
                for name, (total, covered) in sorted(signals.items())
                if covered < total
            },
        }
    return files


# ---- Both.


def total(files: dict[str, dict[str, Any]]) -> dict[str, int]:
    """Sums of every count of the files."""
    sums: defaultdict[str, int] = defaultdict(int)
    for file in files.values():
        for key, value in file.items():
            if isinstance(value, int):
                sums[key] += value
    return dict(sums)


def uncovered(summary: dict[str, Any]) -> str:
    """Everything that isn't covered, a line each."""
    out = []
    for path, file in summary["python"]["files"].items():
        out += [f"{path}:{line}" for line in file["uncovered"]]
        out += [
            f"{path}:{first}: never on to {f'line {to}' if to > 0 else 'the end'}"
            for first, to in file["uncovered_branches"]
        ]
        out += [f"{path}: compiled, {name}()" for name in file["compiled_functions"]]
    for path, file in summary["rtl"]["files"].items():
        out += [f"{path}:{line}" for line in file["uncovered"]]
        out += [f"{path}:{block}, never" for block in file["never"]]
        out += [
            f"{path}: {name} toggles {signal['covered']} of {signal['toggles']}"
            for name, signal in file["signals"].items()
        ]
    return "\n".join(out) + "\n"


def tables(summary: dict[str, Any]) -> list[Table]:
    """What is covered of each file, for a terminal."""
    shown = []
    for language, second in (("python", "branches"), ("rtl", "toggles")):
        part = summary[language]
        table = Table(title=f"covered: {language}")
        extra = ("compiled",) if language == "python" else ()
        for heading in ("file", "lines", "of", "%", second, "of", "%", *extra):
            if heading == "file":
                table.add_column(heading, no_wrap=True)
            else:
                table.add_column(heading, justify="right")
        for path, file in [*part["files"].items(), ("together", part["total"])]:
            cells = [path.removeprefix("sim/wavehaptics/").removeprefix("tools/")]
            for what in ("lines", second):
                most, covered = file.get(what, 0), file.get(f"{what}_covered", 0)
                cells += [str(covered), str(most), f"{100 * covered / most:.1f}" if most else "–"]
            table.add_row(*cells, *(str(file.get("compiled", 0)) for _ in extra))
        shown.append(table)
    return shown


app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, help=__doc__)


@app.command()
def coverage(
    quick: Annotated[bool, typer.Option(help="Only a part of the tests has been run.")] = False,
) -> None:
    """Sum what the tests have left in build/coverage."""
    out = ROOT / OUT
    try:
        if not (out / "python.json").exists():
            raise CoverageError(f"{OUT / 'python.json'} is not there; run `make coverage`")
        python = of_python(json.loads((out / "python.json").read_bytes()), ROOT)
        counted = [*out.glob("rtl/*.dat"), *out.glob("rtl/cocotb/*/verilator/coverage.dat")]
        rtl = of_rtl(merge(sorted(counted)), ROOT)
    except CoverageError as error:
        typer.echo(f"coverage: {error}", err=True)
        raise typer.Exit(2) from None
    summary = {
        "quick": quick,
        "python": {"total": total(python), "files": python},
        "rtl": {"total": total(rtl), "files": rtl},
    }
    write_json(out / "summary.json", summary, indent=1)
    write_text(out / "uncovered.txt", uncovered(summary))
    for table in tables(summary):
        Console().print(table)
    typer.echo(f"coverage: {OUT / 'summary.json'}; what isn't covered: {OUT / 'uncovered.txt'}")


if __name__ == "__main__":
    app()
