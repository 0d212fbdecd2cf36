# SPDX-License-Identifier: Apache-2.0
"""Runs the benches of ``benches.toml``, each at its sizes and on its simulators."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import pytest
from simulators import SIMULATORS, TESTS_DIR, simulate

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

WORDS = {"on", "only", "inner", "sources", "model", "kept"}
"""What a row says beside its parameters."""


def _upper(row: dict[str, Any]) -> dict[str, int]:
    return {key: value for key, value in row.items() if key.isupper()}


def _runs() -> Iterator[Any]:
    """Simulator, bench and arguments of each run, with its name and marks."""
    benches = tomllib.loads((TESTS_DIR / "benches.toml").read_text(encoding="utf-8"))
    for bench, table in benches.items():
        for size in table.get("sizes", [{}]):
            row = {**table, **size}
            lower = {key for key in row if not key.isupper()}
            if unknown := lower - WORDS - {"top", "test", "parameters", "sizes"}:
                raise ValueError(f"benches.toml: [{bench}] has no {sorted(unknown)}")
            words = [f"{key}={value}" for key, value in _upper(size).items()]
            name = "-".join([bench, *words, *(["briefly"] if "only" in row else [])])
            given = {**table.get("parameters", {}), **_upper(size)}
            run = {
                "toplevel": row.get("top", f"wh_{bench}"),
                "test_module": row.get("test", f"tb_{bench}"),
                "parameters": {key: n for key, n in given.items() if not key.startswith("WH_")},
                "defines": {key: n for key, n in given.items() if key.startswith("WH_")},
                "name": name.replace("=", "") if "only" in row else None,
                "sources": [TESTS_DIR / source for source in row.get("sources", ())],
                "inner": bool(row.get("inner")),
            }
            for simulator in [row["on"]] if "on" in row else SIMULATORS:
                marks = [pytest.mark.model] if row.get("model") else []
                if row.get("kept") and simulator == "verilator":
                    marks.append(pytest.mark.kept)
                yield pytest.param(
                    simulator,
                    bench,
                    row.get("only", ""),
                    run,
                    id=f"{simulator}-{name}",
                    marks=marks,
                )


@pytest.mark.parametrize(("simulator", "bench", "only", "run"), list(_runs()))
def test_bench(
    simulator: str, bench: str, only: str, run: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    if only:
        monkeypatch.setenv("COCOTB_TEST_FILTER", only)
    simulate(simulator, **run)
