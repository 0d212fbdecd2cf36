# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_core.v``: N ports in turn equal N ``wh_wave_core``, word for word."""

from __future__ import annotations

import random

import cocotb
from bench import Bench, pack, random_source
from cocotb.triggers import RisingEdge
from simulators import parameters
from wavehaptics.words import formats

N = parameters()["N"]
SHAPER = parameters().get("SHAPER", 0)
SHAPE_BITS = 9 * formats.SHAPE.width + 3 * formats.SHAPE_LOSS_W
DATA, COEF = formats.CURRENT, formats.ROOT
FIRST, SHAPE = 0x110, 0x180
"""Addresses of the first setting of port 0, and of the first one of W, in ``rtl/words.toml``."""
RESULTS = ("u", "v", "e", "clipped", "saturated", "before")


def any_word(rng: random.Random, format_: formats.Fixed) -> int:
    """A corner, or any word; all magnitudes alike."""
    if rng.random() < 0.1:
        return rng.choice((format_.raw_min, format_.raw_max, 0, 1, -1))
    return rng.getrandbits(rng.randint(1, format_.width - 1)) * rng.choice((-1, 1))


def size(rng: random.Random) -> int:
    """Any word that isn't below 0."""
    return abs(any_word(rng, DATA) + 1)


def section(rng: random.Random) -> list[int]:
    """Nine coefficients of a section of W and three losses: any, eighths, or of a passive W."""
    format_ = formats.SHAPE
    kind = rng.randrange(3)
    if kind == 0:
        words = [any_word(rng, format_) for _ in range(9)]
    elif kind == 1:
        words = [
            (rng.randint(-7, 7) << (format_.fraction - 3)) - rng.randrange(2) for _ in range(9)
        ]
    else:
        # Each row's squares are 0.3 or less.
        words = [format_.to_raw(rng.uniform(-0.3, 0.3) - (place in (0, 3))) for place in range(9)]
    losses = [rng.getrandbits(rng.randint(1, formats.SHAPE_LOSS_W)) for _ in range(3)]
    return [*words, *losses]


def packed_section(words: list[int]) -> int:
    """The words of a section side by side, as ``wh_shaper`` has them."""
    losses = pack(words[9:], formats.SHAPE_LOSS_W)
    return pack(words[:9], formats.SHAPE.width) | losses << 9 * formats.SHAPE.width


class CoreBench(Bench):
    """Periods of all ports, each compared with ``wh_wave_core``."""

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut)
        self.rng = rng
        self.bank = 0
        self.periods = 0
        self.seen: set[str] = set()

    async def power_up(self) -> None:
        await self.start(
            go_i=0, current_i=0, ends_i=0, eta_i=0, outside_i=0, extra_ticks_i=0, hold_ticks_i=0,
            room_valid_i=0, room_port_i=0, room_i=0, root_i=0, a_i=0, u_max_i=0, bank_i=0,
            write_i=0, write_bank_i=0, address_i=0, data_i=0, shape_mode_i=0, shape_words_i=0,
        )  # fmt: skip

    async def commit(self) -> None:
        """Other settings for every port, in the other bank, from the next turn on."""
        rng = self.rng
        self.bank ^= 1
        calm = rng.random() < 0.7
        ports, sections = [], []
        for port in range(N):
            words = (
                formats.ROOT.to_raw(rng.uniform(0.5, 5)) if calm else any_word(rng, COEF),
                formats.A.to_raw(rng.random()) if calm else any_word(rng, COEF),
                formats.WAVE.to_raw(rng.choice((5, 50, 127))) if calm else size(rng),
            )
            for place, word in enumerate(words):
                address = FIRST + 0x100 * port + place
                await self.step(write_i=1, write_bank_i=self.bank, address_i=address, data_i=word)
            ports.append(words)
            for number in range(max(1, SHAPER)):
                words = section(rng)
                for place, word in enumerate(words):
                    address = SHAPE + 0x100 * port
                    address += 9 * number + place if place < 9 else 18 + 3 * number + place - 9
                    await self.step(address_i=address, data_i=word)
                sections.append(packed_section(words))
        root, a, u_max = zip(*ports, strict=True)
        self.drive(
            write_i=0, bank_i=self.bank, root_i=pack(root, COEF.width), a_i=pack(a, COEF.width),
            u_max_i=pack(u_max, DATA.width), shape_words_i=pack(sections, SHAPE_BITS),
        )  # fmt: skip

    def give(self) -> None:
        rng = self.rng

        def current() -> int:
            if rng.random() < 0.8:
                return formats.CURRENT.to_raw(rng.uniform(-3, 3))
            return any_word(rng, DATA)

        def eta() -> int:
            inner = formats.ETA.to_raw(rng.uniform(-1, 1))
            return rng.choice((inner, 1 << formats.ETA.fraction, any_word(rng, COEF)))

        self.drive(
            go_i=1,
            current_i=pack([current() for _ in range(N)], DATA.width),
            ends_i=pack([rng.choice((0, 0, 0, 1, 2, 3)) for _ in range(N)], 2),
            eta_i=pack([eta() for _ in range(N)], COEF.width),
            outside_i=pack([any_word(rng, DATA) >> 3 for _ in range(N)], DATA.width),
            shape_mode_i=pack([rng.choice((0, 1, 2, 2, 2, 2, 2)) for _ in range(N)], 2),
        )

    async def period(self) -> None:
        rng = self.rng
        if rng.random() < 0.5:
            room = size(rng) >> rng.randrange(8)
            await self.step(room_valid_i=1, room_port_i=rng.randrange(N), room_i=room)
            self.drive(room_valid_i=0)
        self.give()
        await self.step()
        self.drive(go_i=0)
        await RisingEdge(self.dut.done_o)
        await self.step(2)
        self.periods += 1
        differs = self.word("differs_o")
        assert not differs, [
            f"{RESULTS[place % 6]} of port {place // 6}, period {self.periods}"
            for place in range(6 * N)
            if differs >> place & 1
        ]
        everybody = (1 << N) - 1
        saturated, clipped = self.word("saturated_o"), self.word("clipped_o")
        self.seen |= {
            name
            for name, happened in {
                "saturated": saturated,
                "not saturated": saturated != everybody,
                "clipped": clipped,
                "not clipped": clipped != everybody,
                "voltage": self.word("voltage_o"),
            }.items()
            if happened
        }


@cocotb.test(timeout_time=1, timeout_unit="sec")
async def any_words(dut: object) -> None:
    """Any words of settings and inputs, each port's own; commits and resets at any time."""
    rng = random_source("core")
    bench = CoreBench(dut, rng)
    await bench.power_up()
    runs, periods = (4, 30) if "Icarus" in cocotb.SIM_NAME else (60, 100)
    length = 1 << parameters().get("DELAY_LOG2", 2)
    for _ in range(runs):
        bench.drive(extra_ticks_i=rng.randrange(length), hold_ticks_i=rng.randrange(length))
        if rng.random() < 0.5:  # in the middle of a turn
            bench.give()
            await bench.step()
            bench.drive(go_i=0)
            await bench.step(rng.randrange(1, 32 * N))
        await bench.step(rng.choice((1, 1, 2, 5)), rst=1)
        bench.drive(rst=0)
        await bench.commit()
        for _ in range(periods):
            if rng.random() < 0.05:
                await bench.commit()
            await bench.period()
    assert bench.periods == runs * periods
    assert bench.seen == {"saturated", "not saturated", "clipped", "not clipped", "voltage"}
