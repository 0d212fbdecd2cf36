# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_commit`: every number of motors, with and without anchors, each kind of design."""

import pytest
from simulators import TESTS_DIR, simulate

BENCH = (TESTS_DIR / "bench_commit.v",)
"""As a source: the test sees the bench's own signals only, and compiles in half the time."""

OTHERS = {
    "shared": {"N": 3, "ANCHOR": 1, "SHARED": 1},
    "bus": {"ANCHOR": 1, "BUS": 1},
    "bus_alone": {"BUS": 1},
    "shaper": {"N": 2, "ANCHOR": 1, "SHAPER": 2},
    "brushless": {"LEGS": 3, "ANCHOR": 1},
    "brushless_alone": {"LEGS": 3},
}


@pytest.mark.parametrize("anchor", [0, 1])
@pytest.mark.parametrize("motors", range(1, 9))
def test_commit(motors: int, anchor: int) -> None:
    simulate(
        "verilator", "bench_commit", "tb_commit", {"N": motors, "ANCHOR": anchor}, sources=BENCH
    )


@pytest.mark.parametrize("design", OTHERS)
def test_commit_of(design: str) -> None:
    simulate("verilator", "bench_commit", "tb_commit", OTHERS[design], sources=BENCH)


def test_commit_on_icarus() -> None:
    simulate("icarus", "bench_commit", "tb_commit", {"ANCHOR": 1}, sources=BENCH)
