# SPDX-License-Identifier: Apache-2.0
"""Commits while the bridges are on, in periods of any length that a tool accepts."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import cocotb
from cocotb.triggers import Timer, ValueChange, with_timeout
from simulators import parameters
from wavehaptics.controller.pins_timing import shortest_tick_clocks
from wavehaptics.words.table import THREE_PHASE_LEGS

_P = {
    "N": 1,
    "LEGS": 2,
    "ANCHOR": 0,
    "SHAPER": 0,
    "SHARED": 0,
    "BUS": 0,
    **parameters(),
}
BRUSHLESS = _P["LEGS"] == THREE_PHASE_LEGS
ANCHORED, BUS = bool(_P["ANCHOR"]), bool(_P["BUS"])
HALVES = 2 if BRUSHLESS else 1
LEAST = (
    (72 if ANCHORED else 52)  # of wh_brushless
    if BRUSHLESS
    else shortest_tick_clocks(_P["N"], _P["SHAPER"], ANCHORED, bool(_P["SHARED"]))
)
FRAME_BITS = 6
"""Short ones fit into the shortest tick."""
CORE, SCALE, ANCHORS, OTHERS = 1, 2, 4, 8
"""What is written, as in ``kinds_i``."""
ALL = CORE | SCALE | ANCHORS | OTHERS
BUS_CLOCKS = 119
"""Of ``wh_bus_scale``, at most."""
PATIENCE = 15
"""Ticks of ``wh_settings``."""


@dataclass
class Found:
    """Outputs of the bench after some commits."""

    worst: int
    stuck: int
    errors: int
    mixed: int
    steps: int
    held: int
    overrun: int


async def commit(dut: Any, tick: int, commits: int, kinds: int = ALL) -> Found:
    """Commits of these ``kinds`` in periods of ``tick`` clocks."""
    dut.half_clocks_i.value = tick // HALVES
    dut.tick_halves_i.value = HALVES
    dut.frame_bits_i.value = FRAME_BITS
    dut.commits_i.value = commits
    dut.kinds_i.value = kinds
    await Timer(1, "ns")  # for the bench to begin
    dut.go_i.value = not int(dut.done_o.value)
    await with_timeout(ValueChange(dut.done_o), 500, "ms")
    return Found(
        **{field.name: int(getattr(dut, f"{field.name}_o").value) for field in fields(Found)}
    )


def periods() -> list[int]:
    """The shortest ones, clock by clock, and longer ones up to three times as long."""
    further = {LEAST + HALVES * n for n in range(8)} | {LEAST + _P["N"] * n for n in (4, 6)}
    return sorted(further | {HALVES * (LEAST * part // (4 * HALVES)) for part in (5, 6, 8, 12)})


@cocotb.test(timeout_time=20, timeout_unit="sec")
async def a_commit_ends_in_every_period(dut: Any) -> None:
    """Within three periods, all words of a step of one commit; nobody waits who has nothing."""
    for tick in periods():
        found = await commit(dut, tick, 4)
        cocotb.log.info("%d clocks: %s", tick, found)
        assert (found.stuck, found.errors, found.mixed, found.held, found.overrun) == (0,) * 5, tick
        assert found.steps > 8
        assert 0 < found.worst <= 3 * tick + (tick + BUS_CLOCKS if BUS else 8), tick


@cocotb.test(timeout_time=20, timeout_unit="sec")
async def a_group_that_nobody_wrote_waits_for_nothing(dut: Any) -> None:
    """One kind of words alone, while the readers of all others are at work."""
    for kinds in (CORE, SCALE, ANCHORS, OTHERS):
        if kinds & ALL:
            found = await commit(dut, LEAST + HALVES, 2, kinds)
            assert (found.stuck, found.errors, found.held, found.overrun) == (0,) * 4, kinds


@cocotb.test(timeout_time=20, timeout_unit="sec")
async def a_commit_ends_in_too_short_a_period(dut: Any) -> None:
    """Ticks that overrun, which a host can write as well: the commit ends all the same."""
    overruns = 0
    for tick in (LEAST - HALVES, LEAST * 2 // 3 // HALVES * HALVES):
        found = await commit(dut, tick, 3)
        cocotb.log.info("%d clocks: %s", tick, found)
        assert (found.stuck, found.errors) == (0, 0), tick
        assert found.worst <= (PATIENCE + 3) * tick + BUS_CLOCKS
        overruns += found.overrun
    assert overruns > 0
