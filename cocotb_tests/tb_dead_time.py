# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_dead_time.v``: what it adds, tick for tick, against integers."""

from __future__ import annotations

from dataclasses import dataclass

import cocotb
from bench import Bench, random_source
from wavehaptics.controller.modulator import dead_time_extra, new_dead_time
from wavehaptics.words import formats

LATENCY = 3
AMPERE = 1 << formats.CURRENT.fraction


@dataclass
class Setting:
    dead: int = 5
    threshold: int = AMPERE // 1000
    settle: int = 3


class DeadTimeBench(Bench):
    """Gives a current a tick; the model sees the same."""

    async def begin(self, setting: Setting) -> None:
        self.setting = setting
        self.model = new_dead_time()
        await self.start(
            compensate_i=1, dead_clocks_i=setting.dead, threshold_i=setting.threshold,
            settle_ticks_i=setting.settle, valid_i=0, current_i=0,
        )  # fmt: skip

    async def tick(self, current: int, idle: int = LATENCY - 1) -> int:
        """One tick, and as many clocks more; the extra, which must be the model's."""
        set_ = self.setting
        await self.step(valid_i=1, current_i=current)
        expected = dead_time_extra.py_func(
            self.model, current, set_.dead, set_.threshold, set_.settle
        )
        await self.step(idle, valid_i=0, current_i=0x2AAAAAA)
        shown = self.signed("extra_o")
        assert shown == expected, (current, shown, expected)
        return shown


def whole(dead: int) -> int:
    """Half a dead time, as a word."""
    return dead << (formats.EXTRA.fraction - 1)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def exact_where_there_is_current(dut: object) -> None:
    """Beyond the threshold: half the dead time, with the sign of the current, at any current."""
    bench = DeadTimeBench(dut)
    for dead in (0, 1, 2, 5, 255):
        await bench.begin(Setting(dead=dead, settle=0))
        for current in (AMPERE, formats.CURRENT.raw_max, bench.setting.threshold):
            for sign in (1, -1):
                for _ in range(3):
                    extra = await bench.tick(current if sign > 0 else ~current)
                assert extra == sign * whole(dead)
        for _ in range(3):
            extra = await bench.tick(formats.CURRENT.raw_min)
        assert extra == -whole(dead)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def tries_both_sides(dut: object) -> None:
    """No current: each side for as long as it takes to settle, with a quarter more."""
    bench = DeadTimeBench(dut)
    for settle in (0, 1, 4, 9, 201, 249):
        await bench.begin(Setting(dead=8, settle=settle))
        shown = [await bench.tick(0) for _ in range(6 * (settle + 1))]
        more = whole(8) * 5 // 4
        assert shown == ([-more] * (settle + 1) + [more] * (settle + 1)) * 3
    # What has just been enough, and just not: the threshold belongs to the side.
    await bench.begin(Setting(settle=2))
    edge = bench.setting.threshold
    assert await bench.tick(edge) == whole(5)
    assert await bench.tick(edge - 1) == -whole(5) * 5 // 4
    # -current is taken as one place less.
    for _ in range(2):
        assert await bench.tick(-edge) == -whole(5) * 5 // 4
    assert await bench.tick(-edge - 1) == -whole(5)
    assert await bench.tick(-edge) == whole(5) * 5 // 4


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def random_currents(dut: object) -> None:
    """Random settings and currents near the threshold and far from it; gaps of any length."""
    bench = DeadTimeBench(dut)
    rng = random_source("currents")
    seen = set()
    for _ in range(12):
        threshold = rng.choice((0, 1, AMPERE // 1000, formats.CURRENT.raw_max))
        await bench.begin(Setting(rng.randint(0, 255), threshold, rng.choice((0, 2, 7))))
        for _ in range(120):
            near = threshold + rng.randint(-2, 2)
            far = rng.randint(formats.CURRENT.raw_min, formats.CURRENT.raw_max)
            current = rng.choice((near, -near, 0, far, far >> 12, -threshold))
            current = max(formats.CURRENT.raw_min, min(formats.CURRENT.raw_max, current))
            extra = await bench.tick(current, rng.choice((2, 2, 3, 5)))
            seen.add((extra > 0, abs(extra) > whole(bench.setting.dead)))
    assert len(seen) == 4


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def off_and_reset(dut: object) -> None:
    """Without compensate_i, and in reset, nothing is added, and both begin with the side +."""
    bench = DeadTimeBench(dut)
    for off in ({"compensate_i": 0}, {"rst": 1}):
        await bench.begin(Setting())
        for _ in range(4):
            await bench.tick(-AMPERE)
        assert bench.signed("extra_o") < 0
        await bench.step(1, **off)
        assert bench.signed("extra_o") == 0
        await bench.step(3, valid_i=1, current_i=-AMPERE, **off)
        assert bench.signed("extra_o") == 0
        await bench.step(2, compensate_i=1, rst=0, valid_i=0)
        bench.model = new_dead_time()
        assert bench.signed("extra_o") == whole(5)
        await bench.tick(AMPERE)
