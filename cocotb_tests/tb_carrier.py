# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_carrier.v``: every output in every clock against its definition."""

from __future__ import annotations

from dataclasses import dataclass

import cocotb
from bench import Bench, random_source


@dataclass(frozen=True)
class Setting:
    """A carrier; the samples fill the tick evenly, but for ``spare`` clocks at its end."""

    half_clocks: int
    tick_halves: int
    samples: int
    lead: int
    spare: int = 0
    late: int = 0

    @property
    def tick_clocks(self) -> int:
        return self.half_clocks * self.tick_halves

    @property
    def sample_clocks(self) -> int:
        return (self.tick_clocks - self.spare) // self.samples

    def expected(self, clock: int) -> dict[str, int]:
        """Outputs in the given clock after reset."""
        half, phase = divmod(clock, self.half_clocks)
        in_tick = clock % self.tick_clocks
        late = self.late * (clock // self.tick_clocks % 2)
        after = in_tick - (self.sample_clocks // 2 - self.lead + late)
        sample = 0 <= after < self.samples * self.sample_clocks and after % self.sample_clocks == 0
        return {
            "phase_o": phase,
            "remaining_o": self.half_clocks - 1 - phase,
            "half_o": half % 2,
            "update_o": int(phase == self.half_clocks - 1),
            "take_o": int(in_tick == self.tick_clocks - 5),
            "tick_o": int(in_tick == self.tick_clocks - 1),
            "sample_o": int(sample),
        } | ({"sample_first_o": int(after == 0)} if sample else {})


class CarrierBench(Bench):
    """Runs a setting and checks every clock."""

    async def run(self, setting: Setting, clocks: int) -> int:
        """Number of samples seen in ``clocks`` clocks after a reset."""
        await self.start(
            half_clocks_i=setting.half_clocks,
            tick_halves_i=setting.tick_halves,
            sample_clocks_i=setting.sample_clocks,
            samples_i=setting.samples,
            sample_lead_i=setting.lead,
            sample_late_i=setting.late,
        )
        for strobe in ("update_o", "take_o", "tick_o", "sample_o"):
            assert self.word(strobe) == 0
        seen = 0
        for clock in range(clocks):
            await self.step()
            expected = setting.expected(clock)
            shown = {name: self.word(name) for name in expected}
            assert shown == expected, (setting, clock)
            seen += shown["sample_o"]
        return seen


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def settings(dut: object) -> None:
    """Ticks of one and of many halves, odd ones, several samples, leads of both signs."""
    bench = CarrierBench(dut)
    for setting in (
        Setting(48, 1, 1, 0),
        Setting(48, 1, 1, -1),
        Setting(48, 1, 1, 24),
        Setting(6, 1, 1, 1),
        Setting(7, 3, 1, -7),
        Setting(24, 3, 3, -2),
        Setting(60, 2, 4, 10),
        Setting(7, 8, 2, 2),
        Setting(50, 2, 3, 4, spare=40),
        Setting(48, 1, 1, -3, late=1),
        Setting(24, 3, 3, -2, late=1),
        Setting(1500, 2, 1, -90),
        Setting(700, 4, 2, 60, spare=80),
    ):
        seen = await bench.run(setting, 4 * setting.tick_clocks)
        assert seen == 4 * setting.samples


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def random_settings(dut: object) -> None:
    bench = CarrierBench(dut)
    rng = random_source("settings")
    for _ in range(20):
        half_clocks, tick_halves = rng.randint(6, 70), rng.randint(1, 6)
        clocks = half_clocks * tick_halves
        samples = rng.choice([n for n in range(1, clocks // 2 + 1) if clocks % n == 0])
        sample_clocks = clocks // samples
        lead = rng.randint(sample_clocks // 2 - sample_clocks + 1, sample_clocks // 2)
        late = int(lead > sample_clocks // 2 - sample_clocks + 1 and rng.random() < 0.5)
        lead = max(-128, min(lead, 127))
        setting = Setting(half_clocks, tick_halves, samples, lead, late=late)
        await bench.run(setting, 2 * clocks + rng.randint(0, clocks))


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def longest_tick(dut: object) -> None:
    """256 samples in a tick, and a tick of many halves."""
    bench = CarrierBench(dut)
    assert await bench.run(Setting(8, 96, 256, 0), 2 * 768) == 512


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def reset_of_one_clock(dut: object) -> None:
    """Wherever it comes, nothing of the halves before it is to be seen after it."""
    bench = CarrierBench(dut)
    setting = Setting(7, 2, 1, 0)
    await bench.run(setting, 1)
    for clocks in range(3 * setting.tick_clocks):
        await bench.step(clocks + 1)
        await bench.step(rst=1)
        waiting = setting.expected(0) | {"take_o": 0, "sample_o": 0}
        shown = {name: bench.word(name) for name in waiting}
        assert shown == waiting, clocks
        await bench.step(rst=0)
        for clock in range(setting.tick_clocks):
            expected = setting.expected(clock)
            assert {name: bench.word(name) for name in expected} == expected, (clocks, clock)
            await bench.step()
