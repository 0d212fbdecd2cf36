# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_energy.v``: equal to :class:`wavehaptics.controller.energy.ContactEnergy`."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source
from wavehaptics.controller.energy import ContactEnergy
from wavehaptics.words import formats

LATENCY = 4
"""Clocks from a period's words until its first count is in everything, less one for each count."""
MOST, LEAST = formats.CURRENT.raw_max, formats.CURRENT.raw_min
TOP = formats.ENERGY_LIMIT.raw_max
LEAP = (1 << (formats.HEADER_VALUES["MOVE_W"] - 1)) - 1
AMPERE = formats.CURRENT.to_raw(1.0)
ONE = formats.ENERGY.to_raw(1.0)


class EnergyBench(Bench):
    """Gives periods, and compares after each of them."""

    async def begin(self, limit: int = TOP) -> None:
        self.model = ContactEnergy(limit)
        await self.start(run_i=1, start_i=0, contact_i=0, position_i=0, current_i=0, limit_i=limit)
        self.check()

    def shown(self) -> tuple[int, int, int]:
        return self.signed("energy_o"), self.signed("peak_o"), self.word("over_o")

    def check(self) -> None:
        model = self.model
        assert self.shown() == (model.energy, model.peak, model.over)

    async def period(self, contact: bool, moved: int, current: int, rest: int = 0) -> None:
        """One of as many clocks as the counts need, and ``rest`` more."""
        position = self.model.position + moved
        self.model.period(contact, position, current)
        await self.step(start_i=1, contact_i=contact, position_i=position, current_i=current)
        # What comes of the words with the strobe is taken with it, but the current.
        await self.step(LATENCY - 1 + abs(moved) + rest, start_i=0, contact_i=not contact)
        self.check()


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def random_contacts(dut: object) -> None:
    """Contacts of any length with any current and any way, bridges off and resets in between."""
    bench = EnergyBench(dut)
    rng = random_source("contacts")
    contacts = over = off = resets = full = 0
    for _ in range(30):
        size = formats.DATA_W - 1 if rng.random() < 0.3 else rng.randint(10, formats.DATA_W - 1)
        await bench.begin(rng.getrandbits(rng.randint(1, 16)))
        contact = False
        for _ in range(60):
            if rng.random() < 0.2:
                contact = not contact
            contacts += contact and not bench.model.contact
            moved = rng.choice((0, 1, -1, 1, -1, rng.randint(-9, 9), rng.randint(-300, 300)))
            current = rng.choice((1, -1)) * rng.getrandbits(size)
            await bench.period(contact, moved, current, rng.randint(0, 3))
            over += bench.model.over
            full += bench.model.full
            if rng.random() < 0.04:
                off += bench.model.contact
                bench.model.off()
                await bench.step(rng.randint(1, 3), run_i=0)
                bench.check()
                bench.drive(run_i=1)
            if rng.random() < 0.04:
                resets += bench.model.contact
                bench.model = ContactEnergy(bench.model.limit)
                await bench.step(rst=1, position_i=0)
                bench.drive(rst=0)
                bench.check()
    assert contacts > 100
    assert over > 20
    assert off > 10
    assert resets > 10
    assert full > 10


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def sign_begin_and_end(dut: object) -> None:
    """Force along the motion is positive; what begins and ends a contact, and turns in it."""
    bench = EnergyBench(dut)
    for way in (1, -1):
        for amperes in (1, -1):
            await bench.begin()
            await bench.period(False, way, amperes * AMPERE)
            assert bench.shown() == (0, 0, 0), "free"
            await bench.period(True, way, amperes * AMPERE)
            assert bench.shown() == (0, 0, 0), "the count that begins a contact is none of it"
            await bench.period(True, 3 * way, amperes * AMPERE)
            energy = 3 * way * amperes * ONE
            assert bench.shown() == (energy, max(energy, 0), 0)
            await bench.period(True, -way, 9 * AMPERE)
            await bench.period(True, way, -9 * AMPERE)
            await bench.period(True, -2 * way, 0)
            assert bench.shown() == (energy, max(energy, 0), 0), "no way after a turn"
            peak = max(0, energy, energy - 2 * way * amperes * ONE)
            energy -= 2 * way * amperes * ONE
            await bench.period(False, -way, 2 * amperes * AMPERE)
            assert bench.shown() == (energy, peak, 0), "the count that ends it is"
            await bench.period(False, -way, amperes * AMPERE)
            assert bench.shown() == (energy, peak, 0), "the last contact's stays"
            # A new one after a single period without, by a leap that ends it as well.
            await bench.period(True, way, amperes * AMPERE)
            assert bench.shown() == (0, 0, 0)
            await bench.period(False, 2 * way, amperes * AMPERE)
            assert bench.shown()[0] == 2 * way * amperes * ONE
            await bench.period(True, -way, amperes * AMPERE)
            await bench.period(False, 2 * way, amperes * AMPERE)
            assert bench.shown()[0] == way * amperes * ONE, "the first of them is a turn"
            await bench.period(True, 0, 0)
            assert bench.shown() == (0, 0, 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def leaps_and_ends_of_the_word(dut: object) -> None:
    """The longest leap, currents at their ends, and sums that would leave their word."""
    bench = EnergyBench(dut)
    for current in (MOST, LEAST, 1, -1, 0):
        for moved in (LEAP, -LEAP, 1, -1):
            await bench.begin()
            await bench.period(True, 0, 0)
            await bench.period(True, moved, current)
            await bench.period(True, -moved // 2, current)
            await bench.period(False, -moved // 2, current)
            cut = current >> (formats.CURRENT.fraction - formats.ENERGY.fraction)
            assert bench.model.full == (abs(cut * LEAP) > formats.ENERGY.raw_max and abs(moved) > 1)
    # The last count that fits, either way, and one place beyond.
    for sign, end in ((1, formats.ENERGY.raw_max), (-1, formats.ENERGY.raw_min)):
        cut = formats.CURRENT.fraction - formats.ENERGY.fraction
        whole, rest = divmod(abs(end), 1000)
        await bench.begin(0)
        await bench.period(True, 0, 0)
        await bench.period(True, 1000, sign * whole << cut)
        await bench.period(True, rest, sign << cut)
        assert (bench.model.energy, bench.model.full) == (end, False)
        assert bench.model.over == (sign > 0)
        await bench.period(True, 1, sign << cut)
        assert bench.shown()[0] == end
        assert bench.model.full
        assert not bench.model.over, "not judged any more"
        await bench.period(True, -1000, -whole << cut)
        await bench.period(False, 0, 0)
        await bench.period(True, 0, 0)
        await bench.period(True, 2, AMPERE)
        assert bench.model.over, "the next contact is"


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def over_the_limit(dut: object) -> None:
    """From one place beyond the limit on, for as long as the contact lasts and the bridge is on."""
    bench = EnergyBench(dut)
    rng = random_source("limit")
    cut = formats.ENERGY.fraction - formats.ENERGY_LIMIT.fraction
    down = formats.CURRENT.fraction - formats.ENERGY.fraction
    for limit in (0, 1, TOP - 1, *(rng.getrandbits(rng.randint(2, 15)) for _ in range(12))):
        most = ((limit + 1) << cut) - 1  # the largest that is cut to the limit
        whole, rest = divmod(most, 600)
        await bench.begin(limit)
        await bench.period(True, 0, 0)
        await bench.period(True, 600, whole << down)
        await bench.period(True, rest, 1 << down)
        assert bench.shown() == (most, most, 0)
        await bench.period(True, 1, 1 << down)
        assert bench.shown() == (most + 1, most + 1, 1)
        await bench.period(True, 5, -whole << down)
        assert bench.shown()[2] == 1, "what was delivered before counts"
        bench.model.off()
        await bench.step(run_i=0)
        assert bench.shown()[1:] == (most + 1, 0), "over with the bridges off, and still shown"
        await bench.step(run_i=1)
        await bench.period(True, 0, 0)
        assert bench.shown() == (0, 0, 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def reset_at_any_clock(dut: object) -> None:
    """A reset of one clock, between any two counts of a leap: nothing of it is left."""
    bench = EnergyBench(dut)
    for clock in range(14):
        await bench.begin(0)
        await bench.period(True, 0, 0)
        await bench.step(start_i=1, contact_i=1, position_i=7, current_i=AMPERE)
        await bench.step(clock, start_i=0)
        await bench.step(rst=1)
        bench.drive(rst=0)
        bench.model = ContactEnergy(0)
        bench.check()
        await bench.step(9)
        bench.check()
        await bench.period(True, 2, AMPERE)
        await bench.period(True, 2, AMPERE)
        assert bench.shown() == (2 * ONE, 2 * ONE, 1)
