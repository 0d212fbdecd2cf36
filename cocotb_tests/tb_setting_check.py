# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_setting_check.v``: each word at both sides of its ends, in each port."""

from __future__ import annotations

import cocotb
from bench import Bench, pack, random_source
from wavehaptics.words import formats

ONE = 1 << formats.ETA.fraction
LARGEST = (1 << (formats.COEF_W - 1)) - 1
TICK_MAX = (1 << formats.TICK_W) - 1

PORT = {
    "a_i": (formats.COEF_W, lambda word: 0 < word <= ONE),
    "eta_contact_i": (formats.COEF_W, lambda word: -ONE <= word <= ONE),
    "eta_free_i": (formats.COEF_W, lambda word: -ONE <= word <= ONE),
    "eta_rebound_i": (formats.COEF_W, lambda word: -ONE <= word <= ONE),
    "root_i": (formats.COEF_W, lambda word: word > 0),
    "gain_i": (formats.COEF_W, lambda word: word > 0),
    "clocks_per_volt_i": (formats.COEF_W, lambda word: word > 0),
    "u_max_i": (formats.DATA_W, lambda word: word >= 0),
}
"""Width of a port's word, and what it may be."""

TIMES = {
    "half_clocks_i": ((0, 1, 5, 6, 7, TICK_MAX), lambda word: word >= 6),
    "tick_halves_i": ((0, 1, 2, 3, TICK_MAX), lambda word: word >= 1),
    "sample_clocks_i": ((0, 1, 2, 3, TICK_MAX), lambda word: word >= 2),
    "samples_i": ((0, 1, 2, 255, 256, 257, 511), lambda word: 1 <= word <= 256),
}


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def equals_the_ranges(dut: object) -> None:
    bench = Bench(dut)
    rng = random_source("setting_check")
    count = int(dut.N.value)
    good: dict[str, int] = {"half_clocks_i": 6, "tick_halves_i": 2, "sample_clocks_i": 2,
                            "samples_i": 1, "whole_i": 0}  # fmt: skip
    words = {name: [ONE if width == formats.COEF_W else 0] * count
             for name, (width, _) in PORT.items()}  # fmt: skip

    def packed() -> dict[str, int]:
        return {name: pack(words[name], PORT[name][0]) for name in PORT}

    async def tells(expected: bool) -> None:
        await bench.step(**good, **packed())
        assert bench.word("illegal_o") == expected, (good, words)

    await bench.start(**good, **packed())
    await tells(False)
    for name, (values, allows) in TIMES.items():
        kept = good[name]
        for value in values:
            good[name] = value
            await tells(not allows(value))
        good[name] = kept
    for halves, whole in ((1, 0), (2, 1), (3, 1), (3, 0)):
        good["tick_halves_i"], good["whole_i"] = halves, whole
        await tells(bool(whole and halves % 2))
    good["tick_halves_i"], good["whole_i"] = 2, 0
    for name, (width, allows) in PORT.items():
        top = (1 << (width - 1)) - 1
        ends = (-top - 1, -ONE - 1, -ONE, -1, 0, 1, ONE, ONE + 1, top)
        for port in range(count):
            kept = words[name][port]
            for value in (*ends, rng.randint(-top - 1, top)):
                words[name][port] = value
                await tells(not allows(value))
            words[name][port] = kept
    words["a_i"][count - 1] = LARGEST
    await bench.step(rst=1, **packed())
    assert bench.word("illegal_o") == 0
