# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_trip.v``: every corner of the word against every corner of the threshold."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source

LOW, TOP = -(1 << 15), (1 << 15) - 1


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def equals_the_comparison(dut: object) -> None:
    bench = Bench(dut)
    rng = random_source("trip")
    await bench.start(valid_i=0, sample_i=0, trip_i=0)
    assert bench.word("trip_o") == 0
    seen = set()
    corners = [LOW, LOW + 1, -1, 0, 1, TOP]
    for threshold in (0, 1, TOP, 1 << 15, (1 << 15) + 1, 0xFFFF, 12345):
        for sample in corners + [rng.randint(LOW, TOP) for _ in range(20)]:
            await bench.step(valid_i=1, sample_i=sample, trip_i=threshold)
            tripped = int(abs(sample) >= threshold)
            seen.add((tripped, threshold == 0xFFFF))
            for _ in range(2):
                assert bench.word("trip_o") == tripped
                # Without valid_i nothing changes.
                await bench.step(valid_i=0, sample_i=rng.choice(corners))
    assert seen == {(0, False), (1, False), (0, True)}
    await bench.step(valid_i=1, sample_i=LOW, trip_i=5)
    assert bench.word("trip_o") == 1
    await bench.step(rst=1)
    assert bench.word("trip_o") == 0
