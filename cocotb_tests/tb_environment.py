# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_environment.v``: its three words in each case, without a host and with one."""

from __future__ import annotations

import itertools

import cocotb
from bench import Bench, random_source
from simulators import parameters
from wavehaptics.controller import wave_core
from wavehaptics.words import formats

HOST = parameters().get("HOST", 0)
PERIOD_LOG2 = 3
PERIOD_CLOCKS = 160
GOAL = -(1 << 12)
NUMBERS = 8
"""Random η of each case, beside its corners."""


async def begin(bench: Bench) -> None:
    await bench.start(
        damps_i=0, contact_i=0, shaped_i=0, eta_i=0,
        host_period_log2_i=PERIOD_LOG2, host_timeout_i=100, valid_i=0, v_i=0, host_strobe_i=0,
        host_sequence_i=0, host_u_i=0,
    )  # fmt: skip


async def every_case(bench: Bench) -> None:
    """Contact, kind of wall, damping and any η."""
    rng = random_source("eta")
    active = bench.word("host_active_o")
    for contact, shaped, damps in itertools.product((0, 1), repeat=3):
        mode = (wave_core.SHAPE if shaped else wave_core.HOLD) if contact else wave_core.CLEAR
        word = formats.ETA
        random = [rng.randint(word.raw_min, word.raw_max) for _ in range(NUMBERS)]
        for eta in (word.raw_min, -1, 0, 1, word.raw_max, *random):
            await bench.step(contact_i=contact, shaped_i=shaped, damps_i=damps, eta_i=eta)
            assert bench.word("mode_o") == (wave_core.CLEAR if active else mode)
            assert bench.signed("eta_o") == (0 if active or damps else eta)
            assert bench.signed("wave_o") == (GOAL if active and not damps else 0)
    await bench.step(damps_i=0)


async def periods(bench: Bench, number: int, v: int) -> None:
    """So many periods of one wave, each with an answer to it."""
    for _ in range(number):
        await bench.step(host_strobe_i=1, host_sequence_i=bench.word("host_sequence_o"), v_i=v)
        bench.drive(host_strobe_i=0)
        for _ in range(1 << PERIOD_LOG2):
            await bench.step(PERIOD_CLOCKS // (1 << PERIOD_LOG2))
            await bench.step(valid_i=1)
            bench.drive(valid_i=0)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_wall_free_space_and_damping(dut: object) -> None:
    """What the encoder says, as long as no host has the port."""
    bench = Bench(dut)
    await begin(bench)
    await every_case(bench)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_host_that_answers(dut: object) -> None:
    """It has the port, with its goal as the wave; without HOST nothing of it is there."""
    bench = Bench(dut)
    await begin(bench)
    bench.drive(host_u_i=GOAL)
    await periods(bench, 5, -4 * GOAL)
    assert bench.word("host_active_o") == HOST
    assert bench.word("host_sequence_o") == (5 if HOST else 0)
    assert bench.signed("host_v_o") == (-4 * GOAL if HOST else 0)
    await every_case(bench)
