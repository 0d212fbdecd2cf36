# SPDX-License-Identifier: Apache-2.0
"""What the pages say of proofs, soak, planted faults, coverage and tests: a row of each command.

A row is of the command's last whole run; a command that hasn't been run says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

TEST_RESULTS = (Path("build", "tests", "quick.xml"), Path("build", "tests", "rest.xml"))
"""Where the two halves of ``make test-all`` leave their results, from the root."""

_COVERED = ("lines", "branches", "toggles")


def of_formal(summary: dict[str, Any]) -> dict[str, Any]:
    """The proofs' numbers, of ``build/formal/summary.json``."""
    met: dict[str, list[dict[str, Any]]] = {"proof": [], "cover": [], "twin": []}
    for run in summary["runs"]:
        if run["met"]:
            met[run["kind"]].append(run)
    return {
        "tools": summary["tools"],
        "engines": sorted({run["engine"].split()[-1] for run in met["proof"]}),
        "induction": sum(run["mode"] == "prove" for run in met["proof"]),
        "bounded": sum(run["mode"] != "prove" for run in met["proof"]),
        "covers": len(met["cover"]),
        "twins": len(met["twin"]),
        "failed": [run["name"] for run in summary["runs"] if not run["met"]],
    }


def of_soak(summary: dict[str, Any]) -> dict[str, Any]:
    """The soak's numbers, of ``build/soak/summary.json``."""
    return {key: summary[key] for key in ("ticks", "episodes", "resets", "wrong")}


def of_link_soak(summary: dict[str, Any]) -> dict[str, Any]:
    """The numbers of the link's soak, of ``build/soak-link/summary.json``."""
    return {key: summary[key] for key in ("bytes", "bursts", "frames", "clocks", "wrong")}


def of_mutation(summary: dict[str, Any]) -> dict[str, int]:
    """What became of each planted change, of ``build/mutate/summary.json``."""
    return {key: summary[key] for key in ("mutants", "killed", "equivalent", "survived")}


def of_coverage(summary: dict[str, Any]) -> dict[str, Any]:
    """What is covered, of ``build/coverage/summary.json``."""
    return {part: summary[part]["total"] for part in ("python", "rtl")}


def of_tests(files: Iterable[Path]) -> dict[str, Any]:
    """Sums of pytest's files of results, and the day of the last."""
    suites = [suite for path in files for suite in ElementTree.parse(path).iter("testsuite")]
    found: dict[str, Any] = {
        key: sum(int(suite.get(key, 0)) for suite in suites)
        for key in ("tests", "failures", "errors", "skipped")
    }
    return found | {"day": max(suite.get("timestamp", "")[:10] for suite in suites)}


# ---- The table.


def _proofs(found: dict[str, Any]) -> tuple[str, str]:
    bounded = f", {found['bounded']} over a bounded number of clocks" if found["bounded"] else ""
    return (
        f"{found['induction'] + found['bounded']} properties proven with "
        f"{', '.join(found['engines'])}, {found['induction']} by induction{bounded}; "
        f"{found['twins']} planted faults found, {found['covers']} covers reached",
        ", ".join(found["failed"]),
    )


def _soak(found: dict[str, Any]) -> tuple[str, str]:
    return (
        f"{found['ticks']:,} ticks, {found['episodes']:,} episodes, {found['resets']:,} resets",
        "; ".join(found["wrong"]),
    )


def _link_soak(found: dict[str, Any]) -> tuple[str, str]:
    return (
        f"{found['bytes']:,} bytes in {found['bursts']:,} bursts, "
        f"{found['frames']:,} frames that were right, {found['clocks']:.2g} clocks",
        "; ".join(found["wrong"]),
    )


def _mutation(found: dict[str, Any]) -> tuple[str, str]:
    return (
        f"{found['mutants']:,} planted changes: {found['killed']:,} killed, "
        f"{found['equivalent']:,} equivalent",
        f"{found['survived']:,} survived" if found["survived"] else "",
    )


def _coverage(part: str, counts: tuple[str, ...]) -> Callable[[dict[str, Any]], tuple[str, str]]:
    def row(found: dict[str, Any]) -> tuple[str, str]:
        sums = found[part]
        told = [
            f"{100 * sums[f'{what}_covered'] / sums[what]:.1f} % of {sums[what]:,} {what}"
            for what in counts
            if sums.get(what)
        ]
        compiled = sums.get("compiled", 0)
        also = f"; {compiled:,} of the others are compiled, where no line is seen"
        return ", ".join(told) + (also if compiled else ""), ""

    return row


def _tests(found: dict[str, Any]) -> tuple[str, str]:
    failed = found["failures"] + found["errors"]
    passed = found["tests"] - failed - found["skipped"]
    skipped = f", {found['skipped']:,} skipped" if found["skipped"] else ""
    return f"{passed:,} passed{skipped}, {found['day']}", f"{failed:,} failed" if failed else ""


_ROWS = (
    ("tests", "tests", "make test-all", _tests),
    ("coverage of the Python", "coverage", "make coverage", _coverage("python", _COVERED)),
    ("coverage of the RTL", "coverage", "make coverage", _coverage("rtl", _COVERED)),
    ("planted changes of RTL and models", "mutation", "make mutate", _mutation),
    ("proofs", "proofs", "make formal", _proofs),
    ("soak", "soak", "make soak", _soak),
    ("soak of the link", "link soak", "make soak-link", _link_soak),
)


def _reliability(numbers: dict[str, Any], table: Callable[..., str]) -> str:
    """What was run; a command without a result has no row."""
    known = numbers.get("reliability", {})
    rows = []
    for name, key, command, row in _ROWS:
        if key in known:
            found, wrong = row(known[key])
            rows.append((name, f"`{command}`", found, wrong or "nothing"))
    return table(("", "by", "last whole run", "what went wrong"), rows)


TABLES = {"reliability": _reliability}
"""Tables of Markdown by marker, made with the given function of head and rows."""
