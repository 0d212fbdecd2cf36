# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_anchor_ports.v``: N ports in turn equal N ``wh_anchor``, and the model."""

from __future__ import annotations

import os
import random

import cocotb
import numpy as np
from bench import Bench, pack, random_source, unpack
from cocotb.triggers import RisingEdge
from tb_anchor import (
    AXIS_NEVER,
    EVERYTHING,
    PLACE,
    AnchorBench,
    Tick,
    random_settings,
    random_ticks,
    slow_ticks_of,
)

os.environ["NUMBA_DISABLE_JIT"] = "1"  # compiling would take longer than it saves

from simulators import parameters
from wavehaptics.controller import anchor, rotor_flux
from wavehaptics.words import formats

N = parameters()["N"]
AXES = parameters().get("AXES", 0)
OF_MOTORS = AXES | AXES << 1
"""Ports that are axes of brushless motors."""
FIRST = 0x120
"""Address of the first setting of port 0, as ``rtl/words.toml`` has it."""
NAMES = ("correction", "room", "offset", "flux", "lag")
RESULTS = ("c", "room", "offset", "χ", "ω̂", "fault")


class PortsBench(Bench):
    """Periods of all ports, each compared with ``wh_anchor`` and with the model."""

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut)
        self.rng = rng
        self.bank = 0
        self.settings = [np.zeros(anchor.SETTINGS, dtype=np.int64)] * N
        self.states = [anchor.new_state() for _ in range(N)]
        self.periods = 0
        self.seen: set[str] = set()

    async def power_up(self) -> None:
        await self.start(
            go_i=0, position_i=0, contact_i=0, blind_i=0, current_i=0, u_i=0, v_i=0, withheld_i=0,
            voltage_i=0, saturated_i=0, words_i=0, bank_i=0, write_i=0, write_bank_i=0,
            address_i=0, data_i=0, place_i=0, cell_i=0, forget_i=0,
        )  # fmt: skip

    async def commit(self, settings: list[np.ndarray]) -> None:
        """Write the other bank, and take it from the next turn on."""
        self.bank ^= 1
        for port, words in enumerate(settings):
            for place, word in enumerate(words):
                address = FIRST + 0x100 * port + place
                await self.step(
                    write_i=1, write_bank_i=self.bank, address_i=address, data_i=int(word)
                )
        self.settings = settings
        packed = [anchor.packed(words) for words in settings]
        self.drive(write_i=0, bank_i=self.bank, words_i=pack(packed, formats.ANCHOR_W))

    async def restart(self, clocks: int = 1) -> None:
        await self.step(clocks, rst=1)
        self.drive(rst=0)
        self.states = [anchor.new_state() for _ in range(N)]

    async def forget(self) -> None:
        """Some axes, between two periods."""
        some = self.rng.getrandbits(N) & OF_MOTORS
        await self.step(forget_i=some)
        self.drive(forget_i=0)
        for port in range(N):
            if some >> port & 1:
                self.states[port] = anchor.new_state()

    def give(self, ticks: list[Tick]) -> None:
        def words(name: str, width: int = formats.DATA_W) -> int:
            return pack([int(getattr(tick, name)) for tick in ticks], width)

        self.drive(
            go_i=1, position_i=words("position", formats.COUNT_W), contact_i=words("contact", 1),
            blind_i=words("blind", 1), current_i=words("current"), u_i=words("u"), v_i=words("v"),
            withheld_i=words("withheld"), voltage_i=words("voltage"),
            saturated_i=words("saturated", 1), place_i=words("place", PLACE.width),
            cell_i=words("cell", rotor_flux.SINE_Q + 2),
        )  # fmt: skip

    async def period(self, ticks: list[Tick]) -> None:
        self.give(ticks)
        await self.step()
        self.drive(go_i=0)
        await RisingEdge(self.dut.done_o)
        await self.step(3)
        self.periods += 1
        differs = self.word("differs_o")
        assert not differs, [
            f"{RESULTS[place % 6]} of port {place // 6}, period {self.periods}"
            for place in range(6 * N)
            if differs >> place & 1
        ]
        found = {name: unpack(self.word(f"{name}_o"), formats.DATA_W, N) for name in NAMES}
        for port, (tick, state) in enumerate(zip(ticks, self.states, strict=True)):
            judge = AnchorBench.__new__(AnchorBench)
            judge.axis, judge.seen, judge.state = bool(OF_MOTORS >> port & 1), self.seen, state
            judge.settings = self.settings[port]
            before = state.copy()
            words = (
                bool(tick.contact), tick.current, tick.u, tick.v, tick.withheld, tick.voltage,
                bool(tick.saturated), bool(tick.blind),
            )  # fmt: skip
            if judge.axis:
                place, cell = tick.place << rotor_flux.SHIFT, tick.cell << rotor_flux.SHIFT
                anchor.anchor_axis_step(
                    state, self.settings[port], tick.position, place, cell, *words
                )
            else:
                anchor.anchor_step(state, self.settings[port], tick.position, *words)
            judge._note(tick, before)
            wanted = {
                "correction": state[anchor.CORRECTION],
                "room": state[anchor.ROOM],
                "offset": state[anchor.OFFSET],
                "flux": state[anchor.CHI] >> formats.LONG_GUARD,
                "lag": state[anchor.LAG] >> formats.LONG_GUARD,
            }
            for name, value in wanted.items():
                assert found[name][port] == value, f"{name} of port {port}, period {self.periods}"


@cocotb.test(timeout_time=1, timeout_unit="sec")
async def any_words(dut: object) -> None:
    """Corners and any words, each port's own; commits between turns, resets at any clock."""
    rng = random_source("ports")
    bench = PortsBench(dut, rng)
    await bench.power_up()
    runs, periods = (3, 20) if "Icarus" in cocotb.SIM_NAME else (60 if N == 1 else 30, 60)
    for _ in range(runs):
        await bench.commit([random_settings(rng) for _ in range(N)])
        walks = [random_ticks(rng, periods) for _ in range(N)]
        if rng.random() < 0.5:  # in the middle of a turn
            bench.give([walk[0] for walk in walks])
            await bench.step()
            bench.drive(go_i=0)
            await bench.step(rng.randrange(1, 32 * N))
        await bench.restart(rng.choice((1, 1, 2, 5)))
        for ticks in zip(*walks, strict=True):
            if rng.random() < 0.05:
                await bench.commit([random_settings(rng) for _ in range(N)])
            if AXES and rng.random() < 0.03:
                await bench.forget()
            await bench.period(list(ticks))
    assert bench.periods == runs * periods
    wanted = EVERYTHING - AXIS_NEVER if OF_MOTORS == (1 << N) - 1 else EVERYTHING
    assert runs < 30 or bench.seen == wanted, wanted ^ bench.seen


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def each_place_of_slow_ticks(dut: object) -> None:
    bench = PortsBench(dut, random_source("slow"))
    await bench.power_up()
    for place in range(formats.REST_W):
        words, ticks = slow_ticks_of(place)
        await bench.commit([words] * N)
        await bench.restart()
        for tick in ticks:
            await bench.period([tick] * N)
