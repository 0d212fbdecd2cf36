# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_energy_ports.v``: N ports in turn equal N of the model of ``wh_energy``.

But for a contact whose energy leaves its word: the period that would do it is left out as a whole.
"""

from __future__ import annotations

import cocotb
from bench import Bench, random_source
from cocotb.triggers import FallingEdge
from simulators import parameters
from wavehaptics.controller.energy import ContactEnergy
from wavehaptics.words import formats

N = parameters()["N"]
TURN = 9
"""Clocks from a turn's begin to the next one's, or more."""
MOST, LEAST = formats.CURRENT.raw_max, formats.CURRENT.raw_min
TOP = formats.ENERGY_LIMIT.raw_max
MOVES = 1 << formats.HEADER_VALUES["MOVE_W"]
LEAP = MOVES // 2 - 1
CUT = formats.CURRENT.fraction - formats.ENERGY.fraction
AMPERE = formats.CURRENT.to_raw(1.0)


class PortEnergy(ContactEnergy):
    """The model with one product for all counts of a period."""

    def period(self, contact: bool, position: int, current: int) -> None:
        moved = (position - self.position + MOVES // 2) % MOVES - MOVES // 2
        if contact and not self.contact:
            self.energy = self.peak = 0
            self.full = False
        elif self.contact and moved:
            back = moved < 0
            counts = moved + (back != self.back) * (1 if back else -1)
            energy = self.energy + counts * (current >> CUT)
            if formats.ENERGY.holds(energy):
                self.energy, self.peak = energy, max(self.peak, energy)
            else:
                self.full = True
        self.contact, self.position = contact, position
        if moved:
            self.back = moved < 0


class EnergyBench(Bench):
    """Gives turns, and compares after each of them."""

    def begin_models(self, limit: int) -> None:
        self.models = [PortEnergy(limit) for _ in range(N)]
        self.of_wh_energy = [ContactEnergy(limit) for _ in range(N)]

    async def begin(self, limit: int = TOP) -> None:
        self.begin_models(limit)
        await self.start(
            run_i=1, valid_i=0, port_i=0, contact_i=0, position_i=0, current_i=0, limit_i=limit,
            product_i=0,
        )  # fmt: skip

    async def multiply(self) -> None:
        """Products of what is asked for, three clocks later; of nothing in other clocks."""
        rng = random_source("products")
        line = [0, 0, 0]
        while True:
            await FallingEdge(self.dut.clk)
            product = rng.getrandbits(57)
            if self.word("request_o"):
                product = self.signed("factor_o") * self.signed("coefficient_o")
            line.append(product)
            self.drive(product_i=line.pop(0))

    def check_over(self) -> None:
        over = self.word("over_o")
        assert over == sum(model.over << port for port, model in enumerate(self.models))
        for model, alone in zip(self.models, self.of_wh_energy, strict=True):
            if not alone.full:
                assert (model.energy, model.peak) == (alone.energy, alone.peak)
            assert model.over == alone.over

    async def turn(self, port: int, contact: bool, moved: int, current: int, rest: int = 0) -> None:
        model = self.models[port]
        position = model.position + moved
        model.period(contact, position, current)
        self.of_wh_energy[port].period(contact, position, current)
        await self.step(
            valid_i=1, port_i=port, contact_i=contact, position_i=position, current_i=current
        )
        # What comes of the words with the strobe is taken with it, but port and current.
        self.drive(valid_i=0, contact_i=not contact, position_i=~position)
        for clock in range(1, TURN):
            assert self.word("energy_valid_o") == (clock == 7)
            assert self.word("peak_valid_o") == (clock == 8)
            if clock == 7:
                assert self.signed("energy_o") == model.energy
            if clock == 8:
                assert self.signed("peak_o") == model.peak
                self.check_over()
            await self.step(1)
        await self.step(rest)

    async def period(self, contact: bool, moved: int, current: int) -> None:
        """The same of all ports."""
        for port in range(N):
            await self.turn(port, contact, moved, current)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def random_contacts(dut: object) -> None:
    """Contacts of any length with any current and any way, bridges off and resets in between."""
    bench = EnergyBench(dut)
    rng = random_source("contacts")
    await bench.begin()
    cocotb.start_soon(bench.multiply())
    contacts = over = off = resets = full = 0
    for _ in range(40):
        size = formats.DATA_W - 1 if rng.random() < 0.3 else rng.randint(10, formats.DATA_W - 1)
        await bench.begin(rng.getrandbits(rng.randint(1, 16)))
        contact = [False] * N
        for _ in range(60):
            for port, model in enumerate(bench.models):
                if rng.random() < 0.2:
                    contact[port] = not contact[port]
                contacts += contact[port] and not model.contact
                moved = rng.choice((0, 1, -1, 1, -1, rng.randint(-9, 9), rng.randint(-300, 300)))
                current = rng.choice((1, -1)) * rng.getrandbits(size)
                await bench.turn(port, contact[port], moved, current, rng.randint(0, 3))
                over += model.over
                full += model.full
            if rng.random() < 0.04:
                off += bench.models[-1].contact
                for model in (*bench.models, *bench.of_wh_energy):
                    model.off()
                await bench.step(rng.randint(1, 3), run_i=0)
                bench.check_over()
                bench.drive(run_i=1)
            if rng.random() < 0.04:
                resets += bench.models[-1].contact
                bench.begin_models(bench.models[0].limit)
                await bench.step(rst=1)
                bench.drive(rst=0)
                bench.check_over()
    assert contacts > 100
    assert over > 20
    assert off > 10
    assert resets > 10
    assert full > 10


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def leaps_and_ends_of_the_word(dut: object) -> None:
    """The longest leap, currents at their ends, and sums that would leave their word."""
    bench = EnergyBench(dut)
    await bench.begin()
    cocotb.start_soon(bench.multiply())
    for current in (MOST, LEAST, 1, -1, 0):
        for moved in (LEAP, -LEAP, 1, -1):
            await bench.begin()
            await bench.period(True, 0, 0)
            await bench.period(True, moved, current)
            await bench.period(True, -moved // 2, current)
            await bench.period(False, -moved // 2, current)
            full = abs((current >> CUT) * LEAP) > formats.ENERGY.raw_max and abs(moved) > 1
            assert all(model.full == full for model in bench.models)
    # The last count that fits, either way, and one beyond.
    for sign, end in ((1, formats.ENERGY.raw_max), (-1, formats.ENERGY.raw_min)):
        whole, rest = divmod(abs(end), 1000)
        await bench.begin(0)
        await bench.period(True, 0, 0)
        await bench.period(True, 1000, sign * whole << CUT)
        await bench.period(True, rest, sign << CUT)
        assert [(model.energy, model.full) for model in bench.models] == [(end, False)] * N
        assert all(model.over == (sign > 0) for model in bench.models)
        await bench.period(True, 1, sign << CUT)
        assert [(model.energy, model.full) for model in bench.models] == [(end, True)] * N
        assert not any(model.over for model in bench.models), "not judged any more"
        await bench.period(False, 0, 0)
        await bench.period(True, 0, 0)
        await bench.period(True, 2, AMPERE)
        assert all(model.over for model in bench.models), "the next contact is"


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_turn_that_ends_early(dut: object) -> None:
    """A reset, or the bridges off, in any clock of a turn: it ends, and the next one is whole."""
    bench = EnergyBench(dut)
    await bench.begin()
    cocotb.start_soon(bench.multiply())
    for clock in range(TURN):
        for name, level in (("rst", 1), ("run_i", 0)):
            await bench.begin(0)
            await bench.period(True, 0, 0)
            await bench.period(True, 3, AMPERE)
            last = N - 1
            await bench.step(valid_i=1, port_i=last, contact_i=1, position_i=7, current_i=AMPERE)
            await bench.step(clock, valid_i=0)
            await bench.step(1, **{name: level})
            bench.drive(**{name: 1 - level})
            assert bench.word("over_o") == 0
            await bench.step(TURN)
            assert bench.word("over_o") == 0
            # A new contact, from wherever the rotor is.
            bench.begin_models(0)
            for port, model in enumerate((*bench.models, *bench.of_wh_energy)):
                model.position = 3 if name == "run_i" else 0
                if name == "run_i" and port % N == last:
                    model.position = 7
            await bench.period(True, 0, 0)
            await bench.period(True, 2, AMPERE)
            assert all(model.over for model in bench.models)
