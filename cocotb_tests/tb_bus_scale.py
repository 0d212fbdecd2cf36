# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_bus_scale.v``: equals the integers, on every bus, and in time."""

from __future__ import annotations

import cocotb
from bench import Bench, pack, random_source, unpack
from simulators import parameters
from wavehaptics.controller import bus_scale
from wavehaptics.words import formats

N = parameters()["N"]
WORDS_CLOCKS = 60  # a bus from its clock to the one behind which its words are there
CHANGE_CLOCKS = 2 * WORDS_CLOCKS - 1  # from another bus to its words, at most
TOP_BUS = (1 << formats.BUS_W) - 1
TOP_U = formats.WAVE.raw_max
TOP_SHARE = formats.BUS_SHARE.raw_max
FIXED = [1000 + n for n in range(N)]


class ScaleBench(Bench):
    """A bus, its settings, and what must come of them."""

    async def begin(self, half_clocks: int = 48, half_bridge: int = 0, **inputs: int) -> None:
        self.half_clocks, self.half_bridge = half_clocks, half_bridge
        self.bus, self.bus_share, self.u_max = 0, 0, [0] * N
        await self.start(
            half_clocks_i=half_clocks, half_bridge_i=half_bridge, bus_i=0,
            bus_share_i=0, u_max_i=0, hold_i=0,
            clocks_per_volt_i=pack(FIXED, formats.COEF_W), **inputs,
        )  # fmt: skip

    def set(self, bus: int, bus_share: int, u_max: list[int]) -> None:
        self.bus, self.bus_share, self.u_max = bus, bus_share, u_max
        self.drive(bus_i=bus, bus_share_i=bus_share, u_max_i=pack(u_max, formats.DATA_W))

    def clocks_per_volt(self) -> list[int]:
        return unpack(self.word("clocks_per_volt_o"), formats.COEF_W, N)

    def limits(self) -> list[int]:
        return unpack(self.word("u_max_o"), formats.DATA_W, N)

    def wanted_limits(self) -> list[int]:
        part = bus_scale.share(self.bus, self.bus_share)
        return [bus_scale.limited(u_max, part) for u_max in self.u_max]

    async def check(self) -> None:
        await self.step(CHANGE_CLOCKS)
        wanted = bus_scale.clocks_per_volt(self.half_clocks, self.bus, bool(self.half_bridge))
        assert self.clocks_per_volt() == [wanted] * N, (self.half_clocks, self.bus)
        assert self.limits() == self.wanted_limits(), (self.bus, self.bus_share, self.u_max)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def equals_the_integers(dut: object) -> None:
    """Corners and random words in both kinds of bridge; each limit of the words is met."""
    bench, rng = ScaleBench(dut), random_source("bus scale")
    whole = parts = largest = 0
    for half_clocks in (6, 48, 65535, rng.randint(6, 65535)):
        for half_bridge in (0, 1):
            await bench.begin(half_clocks, half_bridge)
            buses = [0, 1, 2, TOP_BUS, TOP_BUS - 1, 6144, *(rng.randint(0, TOP_BUS),) * 3]
            buses += [rng.randint(0, 1 << rng.randint(1, 15)) for _ in range(6)]
            for bus in buses:
                shares = (
                    0,
                    1,
                    TOP_SHARE,
                    bus_scale.bus_share_word(12.0, 1.0),
                    rng.randint(0, TOP_SHARE),
                )
                u_max = [
                    rng.choice((0, 1, TOP_U, TOP_U - 1, rng.randint(0, TOP_U))) for _ in range(N)
                ]
                bench.set(bus, rng.choice(shares), u_max)
                await bench.check()
                one = bus_scale.share(bus, bench.bus_share) == 1 << bus_scale.SHARE_Q
                whole, parts = whole + one, parts + (not one and any(bench.limits()))
                largest += bench.clocks_per_volt()[0] == formats.DUTY.raw_max
    assert min(whole, parts, largest) > 5


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def the_settings_hold_until_the_first_quotient(dut: object) -> None:
    bench = ScaleBench(dut)
    await bench.begin()
    u_max = [TOP_U - n for n in range(N)]
    bench.set(6144, 1, u_max)
    await bench.step(rst=1)
    bench.drive(rst=0)
    for _ in range(WORDS_CLOCKS - 1):
        assert bench.clocks_per_volt() == FIXED
        assert bench.limits() == u_max
        await bench.step()
    await bench.step()
    assert bench.clocks_per_volt() == [bus_scale.clocks_per_volt(48, 6144)] * N
    await bench.check()
    await bench.step(rst=1)
    assert (bench.clocks_per_volt(), bench.limits()) == (FIXED, u_max)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def one_bus_makes_a_quotient(dut: object) -> None:
    """A bus that changes in every clock never mixes two of its words in one quotient."""
    bench, rng = ScaleBench(dut), random_source("mixed")
    await bench.begin()
    seen = {bus_scale.clocks_per_volt(48, bus): bus for bus in (0, 5000, 6000, 7000)}
    shown = set()
    bench.set(5000, 0, [0] * N)
    await bench.check()
    for _ in range(4000):
        await bench.step(bus_i=rng.choice((5000, 6000, 7000)))
        (word,) = set(bench.clocks_per_volt())
        shown.add(seen[word])
    assert shown == {5000, 6000, 7000}


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def another_limit_is_scaled_in_time(dut: object) -> None:
    """With a bus that is high enough another u_max is let through at once."""
    bench, rng = ScaleBench(dut), random_source("limits")
    await bench.begin()
    for bus, scaled in ((3000, True), (6144, False)):
        bench.set(bus, (1 << formats.BUS_SHARE.fraction) // 10, [TOP_U] * N)
        await bench.check()
        for _ in range(60):
            await bench.step(rng.randint(1, 50))
            bench.set(bus, bench.bus_share, [rng.randint(0, TOP_U) for _ in range(N)])
            await bench.settle()
            if not scaled:
                assert bench.limits() == bench.u_max
            await bench.step(CHANGE_CLOCKS)
            assert bench.limits() == bench.wanted_limits()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def words_wait_for_a_clock_without_hold(dut: object) -> None:
    """All words of a bus come in one clock, never behind one with hold, and no bus is mixed."""
    bench, rng = ScaleBench(dut), random_source("hold")
    await bench.begin()
    share = bus_scale.bus_share_word(12.0, 1.0)
    u_max = [TOP_U - rng.randint(0, TOP_U // 2) for _ in range(N)]
    buses = [rng.randint(1 << 10, 1 << 13) for _ in range(6)]
    words = {
        (
            bus_scale.clocks_per_volt(48, bus),
            *(bus_scale.limited(limit, bus_scale.share(bus, share)) for limit in u_max),
        )
        for bus in buses
    }
    bench.set(buses[0], share, u_max)
    await bench.check()
    seen, waits = set(), 0
    before = (bench.clocks_per_volt()[0], *bench.limits())
    for period, low in ((24, 1), (60, 1), (61, 1), (59, 7), (60, 59), (200, 3)):
        unchanged = 0
        for clock in range(60 * period):
            held = clock % period >= low
            await bench.step(hold_i=held, bus_i=rng.choice(buses))
            (clocks_per_volt,) = set(bench.clocks_per_volt())
            after = (clocks_per_volt, *bench.limits())
            assert after == before or not held
            unchanged = 0 if after != before else unchanged + 1
            seen.add(after)
            before, waits = after, max(waits, unchanged)
    assert seen == words
    assert waits > 150
