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
    "root_i": (formats.COEF_W, lambda word: word > 0),
    "gain_i": (formats.COEF_W, lambda word: word > 0),
    "clocks_per_volt_i": (formats.COEF_W, lambda word: word > 0),
    "u_max_i": (formats.DATA_W, lambda word: word >= 0),
}
"""Width of a port's word, and what it may be."""

LEADS = [
    (2, -1, 0),
    (2, 1, 0),
    (7, 3, 0),
    (7, 4, 0),
    (7, -3, 0),
    (7, -3, 1),
    (7, -4, 0),
    (300, -128, 0),
]
LEADS += [
    (250, -124, 0),
    (250, -124, 1),
    (250, -125, 0),
    (250, 125, 1),
    (250, 126, 0),
    (TICK_MAX, 127, 1),
]
"""Clocks from sample to sample, by how many they come early, and whether later in odd ticks."""

PULSES = [(half, spare, least) for half in (6, 7, 48, 49) for spare in (0, 2, 3, 4, 23, 24, 128)
          for least in (0, 1, 2, 12, 22, 24, 25, 255)]  # fmt: skip
"""Clocks of a half, and what the shortest pulses take."""

DEAD = [(half, dead, compensate, spare) for half in (6, 7, 48, 49, 200, TICK_MAX)
        for dead in (0, 1, 4, 5, 6, 7, 37, 38, 39, 47, 48, 49, 199, 200, 255)
        for compensate in (0, 1) for spare in (0, 2, 128)]  # fmt: skip


def pulse_fits(half: int, spare: int, least: int) -> bool:
    """A voltage of either sign has a pulse, and none has to be shorter than the shortest."""
    most = half // 2 - spare
    return most >= 1 and most >= least


def dead_fits(half: int, dead: int, compensate: int, spare: int) -> bool:
    """A gate goes on, and what is compensated at most is less than the longest pulse."""
    longer = dead * (1 << formats.EXTRA.fraction) // 2 * 5 // 4
    return dead < half and (
        not compensate or longer < (half // 2 - spare) * (1 << formats.EXTRA.fraction)
    )


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
                            "samples_i": 1, "whole_i": 0, "sample_lead_i": 0, "sample_late_i": 0,
                            "least_i": 0, "spare_i": 0, "dead_clocks_i": 0,
                            "compensate_i": 0, "compensable_i": 1}  # fmt: skip
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
    usual = dict(good)
    for clocks, lead, late in LEADS:
        good |= {"sample_clocks_i": clocks, "sample_lead_i": lead, "sample_late_i": late}
        first = clocks // 2 - lead
        await tells(not (first >= 0 and first + late < clocks))
    good |= usual
    for half, spare, least in PULSES:
        good |= {"half_clocks_i": half, "spare_i": spare, "least_i": least}
        await tells(not pulse_fits(half, spare, least))
    good |= usual
    for half, dead, compensate, spare in DEAD:
        good |= {"half_clocks_i": half, "dead_clocks_i": dead, "compensate_i": compensate,
                 "spare_i": spare}  # fmt: skip
        await tells(not (pulse_fits(half, spare, 0) and dead_fits(half, dead, compensate, spare)))
    good |= usual
    for compensate, compensable in ((0, 0), (1, 0), (1, 1)):
        good |= {"half_clocks_i": 48, "compensate_i": compensate, "compensable_i": compensable}
        await tells(bool(compensate and not compensable))
    good |= usual
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
