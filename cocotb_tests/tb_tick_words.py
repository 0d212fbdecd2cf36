# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_tick_words.v``: who is given which tick, each word at its address."""

from __future__ import annotations

import random

import cocotb
from bench import Bench, pack, random_source
from simulators import parameters
from tb_capture import DATA_W, MEANS, WIDTHS
from wavehaptics.words.table import WORDS

N = {"N": 2, **parameters()}["N"]
CODES = {WORDS[name].at(motor): (name, motor) for name in WIDTHS for motor in range(N)}
CODES |= {WORDS[name].at(): (name, 0) for name in ("bus", "faults")}
NONE = (0, WORDS["wall_min"].at(), WORDS["current"].at(N), 0xFFF)
SIGNED = (*MEANS, "position")
Words = dict[tuple[str, int], int]


def bits_of(name: str) -> int:
    return {"bus": 16, "faults": 16, **WIDTHS}[name]


def word_of(code: int, words: Words) -> tuple[int, bool, bool]:
    """The 32 bits at an address, whether it is a mean's, and whether any tick's bits count."""
    if code not in CODES:
        return 0, False, False
    name, _ = CODES[code]
    means = name in MEANS or name == "bus"
    return words[CODES[code]] & 0xFFFFFFFF, means, name in ("flags", "faults")


class TickWordsBench(Bench):
    """The block with two readers, each of which chooses for some clocks when it was given words."""

    async def begin(self, rng: random.Random) -> None:
        self.rng = rng
        self.given = [0, 0]  # ticks, for each reader
        self.chooses = [0, 0]  # clocks that are left
        self.waits = False  # reader 1, for reader 0
        self.kept: Words | None = None
        self.missed = self.stepped = False
        self.codes = [0, 0]  # of the clock before
        self.words = self._other_words()
        await self.start(tick_i=0, valid_i=0, want_i=0, reads_i=0, code_i=0,
                         **self._inputs(self.words))  # fmt: skip

    def _other_words(self) -> Words:
        rng = self.rng
        return {
            (name, motor): rng.getrandbits(bits_of(name)) - (1 << bits_of(name) - 1)
            if name in SIGNED
            else rng.getrandbits(bits_of(name))
            for name, motor in CODES.values()
        }

    def _inputs(self, words: Words) -> dict[str, int]:
        found = {
            f"{name}_i": pack((words[name, motor] for motor in range(N)), bits)
            for name, bits in WIDTHS.items()
        }
        return {**found, "bus_i": words["bus", 0], "faults_i": words["faults", 0]}

    async def clock(self, tick: bool, valid: bool, wants: tuple[bool, bool]) -> bool:
        """A clock with other words at the block; whether it was a strobe."""
        rng = self.rng
        self.words = self._other_words()
        codes = [rng.choice([*CODES]) if rng.random() < 0.9 else rng.choice(NONE) for _ in range(2)]
        self.drive(
            tick_i=int(tick), valid_i=int(valid), want_i=wants[0] + 2 * wants[1],
            reads_i=(self.chooses[0] > 0) + 2 * (self.chooses[1] > 0), code_i=pack(codes, 12),
            **self._inputs(self.words),
        )  # fmt: skip
        await self.settle()
        strobe = valid or self.missed
        assert self.word("strobe_o") == strobe
        free = strobe and not self.waits and not any(self.chooses)
        takes = (
            free and wants[0],
            wants[1] and ((free and not wants[0]) or (self.waits and not self.chooses[0])),
        )
        assert self.word("take_o") == takes[0] + 2 * takes[1]
        if any(self.chooses):
            wanted, mean, any_ = word_of(self.codes[0 if self.chooses[0] else 1], self.kept)
            assert self.word("word_o") == wanted
            if wanted:
                assert (self.word("mean_o"), self.word("any_o")) == (mean, any_)
        self.codes = codes
        if free and any(takes):
            self.kept = dict(self.words)
        self.waits = bool(takes[0] and wants[1]) or (self.waits and self.chooses[0] > 0)
        for n in range(2):
            self.chooses[n] = rng.randint(1, 8) if takes[n] else max(0, self.chooses[n] - 1)
            self.given[n] += takes[n]
        self.missed = tick and not valid and not self.stepped
        self.stepped = not tick and (valid or self.stepped)
        await self.step()
        return strobe


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def who_chooses_has_one_tick(dut: object) -> None:
    """Ticks of any length, with steps and without; words that are others in each clock."""
    bench, rng = TickWordsBench(dut), random_source("turns")
    assert DATA_W <= 32
    for likes in (0.9, 0.5, 0.2):
        await bench.begin(rng)
        strobes = 0
        for _ in range(300):
            clocks = rng.choice((1, 2, 3, 9, 14, 20))
            step = rng.randrange(clocks) if rng.random() < 0.7 else None
            for n in range(clocks):
                wants = (rng.random() < likes and not bench.chooses[0], rng.random() < likes
                         and not bench.chooses[1])  # fmt: skip
                strobes += await bench.clock(n == clocks - 1, n == step, wants)
        assert strobes > 200
        assert min(bench.given) > 20


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_reset_gives_nobody_anything(dut: object) -> None:
    """Not who waited, and not for a tick that was without a step."""
    bench, rng = TickWordsBench(dut), random_source("reset")
    for _ in range(20):
        await bench.begin(rng)
        await bench.clock(False, True, (True, True))
        assert bench.waits
        await bench.clock(True, False, (False, True))
        await bench.begin(rng)
        for _ in range(3):
            assert not await bench.clock(False, False, (True, True))
        assert bench.given == [0, 0]
