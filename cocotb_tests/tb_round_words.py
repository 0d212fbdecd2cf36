# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_round_words.v``: what is read is of one round, that which ended last.

Values come in the order and at the clocks of ``rtl/wh_ports.v``, whose bench compares these with
:data:`WHEN`. Rounds follow each other as soon as ``wh_slots`` permits, or later.
"""

from __future__ import annotations

import random

import cocotb
from bench import Bench, pack, random_source
from tb_capture import CODES, MEANS, NONE, N
from tb_registers import FLAG_WORD, LIVE_WORDS, STEPPED

PITCH, TAIL = (32, 32, 36), (38, 38, 42)
"""Clocks from a slot to the next one of its round, and to that of the next round, by SHAPER."""
WHEN = {
    "current": 9, "position": 10, "u": 14, "v": 15, "flags": 16, "contact_energy": 20,
    "contact_energy_peak": 21, "offset": 28, "flux": 30, "voltage": 33, "correction": 34, "lag": 37,
}  # fmt: skip
"""Clock of its port's slot in which a live value comes; voltage and correction 5 later for each
section of W.
"""
DAMPED = {"offset": 17, "flux": 18, "lag": 19}
"""The same of what a damped round has as 0; the offset of others as well, before a new one."""
ALWAYS = ("current", "position", "flags")
"""Values of a round without a step."""
LIVE = {**LIVE_WORDS, "flags": FLAG_WORD}
ENDS = 29
"""Clocks from the last port's flags to the end of the round."""
LONGEST = 9
"""Clocks in which a reader may choose."""
Words = dict[tuple[str, int], int]


def values_of_a_round(shaper: int, *, on: bool, damped: bool) -> dict[int, tuple[str, int]]:
    """Port and name of each value of a round by their clocks."""
    later = {"voltage": 5 * shaper, "correction": 5 * shaper}
    when = {**WHEN, **(DAMPED if damped else {})}
    each = [*when.items(), ("offset", DAMPED["offset"])]
    return {
        port * PITCH[shaper] + clock + later.get(name, 0): (name, port)
        for port in range(N)
        for name, clock in each
        if on or name in ALWAYS
    }


def words_of_a_round(live: Words) -> Words:
    """What is read of a round whose values are these: none of a step that wasn't whole."""
    whole = sum(name in STEPPED for name, _ in live) == len(STEPPED) * N
    return {
        key: live[key] if whole or key[0] not in STEPPED else 0
        for key in CODES.values()
        if key[0] not in ("bus", "faults")
    }


def word_of(code: int, words: Words) -> tuple[int, bool, bool]:
    """The 32 bits at an address, whether it is a mean's, and whether any tick's bits count."""
    if code not in CODES:
        return 0, False, False
    name, _ = CODES[code]
    means = name in MEANS or name == "bus"
    return words[CODES[code]] & 0xFFFFFFFF, means, name in ("flags", "faults")


class RoundWordsBench(Bench):
    """The block, rounds, two readers, and the model of what they read."""

    async def begin(self, rng: random.Random) -> None:
        self.rng = rng
        self.chooses = [0, 0]  # clocks that are left
        self.given = [0, 0]  # rounds
        self.waits = False  # reader 1, for reader 0
        self.codes = [0, 0]
        self.live: Words = {}  # of the round that is under way
        self.kept: Words = {}
        self.ends: int | None = None  # clocks until the round does
        self.contact = 0
        self.damped = False
        self.rounds = {"step": 0, "none": 0, "half": 0}
        await self.start(live_valid_i=0, live_port_i=0, live_word_i=0, live_data_i=0, bus_i=0,
                         faults_i=0, want_i=0, reads_i=0, code_i=0)  # fmt: skip

    def _end(self) -> None:
        """What readers have of the round that ends now."""
        came = sum(name in STEPPED for name, _ in self.live)
        self.rounds["none" if not came else "half" if came < len(STEPPED) * N else "step"] += 1
        self.kept = words_of_a_round(self.live)
        self.live = {}

    async def clock(self, value: tuple[str, int] | None, likes: float) -> None:
        """A clock, with a value of a port or none."""
        rng = self.rng
        codes = [rng.choice([*CODES] if rng.random() < 0.9 else NONE) for _ in range(2)]
        wants = [rng.random() < likes and not left for left in self.chooses]
        bus, faults, data = rng.getrandbits(16), rng.getrandbits(24), rng.getrandbits(32)
        name, port = value or (rng.choice([*LIVE]), rng.randrange(N))
        if name in DAMPED and self.damped:
            data = 0
        self.drive(
            live_valid_i=int(value is not None), live_port_i=port, live_word_i=LIVE[name],
            live_data_i=data, bus_i=bus, faults_i=faults, code_i=pack(codes, 12),
            want_i=pack(wants, 1), reads_i=pack([left > 0 for left in self.chooses], 1),
        )  # fmt: skip
        await self.settle()
        strobe = self.ends == 0
        assert self.word("strobe_o") == strobe
        assert self.word("contact_o") == self.contact
        free = strobe and not self.waits and not any(self.chooses)
        takes = (
            free and wants[0],
            wants[1] and ((free and not wants[0]) or (self.waits and not self.chooses[0])),
        )
        assert self.word("take_o") == takes[0] + 2 * takes[1]
        if any(self.chooses):
            code = self.codes[0 if self.chooses[0] else 1]
            wanted, mean, any_ = word_of(code, self.kept)
            assert self.word("word_o") == wanted, CODES.get(code)
            if wanted:
                assert (self.word("mean_o"), self.word("any_o")) == (mean, any_)
        if strobe:
            self._end()
            self.kept |= {("bus", 0): bus, ("faults", 0): faults}
        self.ends = self.ends - 1 if self.ends else None
        if value:
            self.live[value] = data & 0xFF if name == "flags" else data
            if name == "flags":
                self.contact = self.contact & ~(1 << port) | (data & 1) << port
                self.ends = ENDS - 1 if port == N - 1 else self.ends
        self.codes = codes
        self.waits = bool(takes[0] and wants[1]) or (self.waits and self.chooses[0] > 0)
        for n in range(2):
            self.chooses[n] = rng.randint(1, LONGEST) if takes[n] else max(0, self.chooses[n] - 1)
            self.given[n] += takes[n]
        await self.step()

    async def run(self, rounds: int, shaper: int, likes: float) -> None:
        """Rounds with a step or without, or one that the bridges or a restart cut off."""
        rng, later = self.rng, {}
        for _ in range(rounds):
            self.damped = rng.random() < 0.2
            values = values_of_a_round(shaper, on=rng.random() < 0.8, damped=self.damped)
            length = (N - 1) * PITCH[shaper] + TAIL[shaper]
            # Any clock, or just before the last value.
            last = max(values)
            cut = rng.choice((last + 1, last + 1, rng.randrange(length), last - rng.randrange(4)))
            restarts = cut <= last and rng.random() < 0.2
            values = {
                clock: value
                for clock, value in values.items()
                if clock < cut or (value[0] in ALWAYS and not restarts)
            }
            length += rng.choice((0, 0, 0, 1, 9, 60))
            for clock in range(length):
                await self.clock(values.get(clock) or later.get(clock), likes)
            later = {clock - length: value for clock, value in values.items() if clock >= length}
            if restarts:
                for clock in range(30):
                    await self.clock(later.get(clock), likes)
                self.live, later = ({}, {}) if self.ends is None else (self.live, {})


@cocotb.test(timeout_time=200, timeout_unit="ms")
@cocotb.parametrize(shaper=(0, 1, 2))
async def what_is_read_is_of_one_round(dut: object, shaper: int) -> None:
    """Rounds of every kind, readers that want each of them or few."""
    bench, rng = RoundWordsBench(dut), random_source(f"rounds {shaper}")
    for likes in (1.0, 0.9, 0.3):
        await bench.begin(rng)
        await bench.run(60, shaper, likes)
        assert min(bench.rounds.values()) > 5, bench.rounds
        assert min(bench.given) > 5


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_reset_forgets_the_round(dut: object) -> None:
    """None ends, nobody is given anything, and a step before it is none of the next round."""
    bench, rng = RoundWordsBench(dut), random_source("reset")
    for _ in range(20):
        await bench.begin(rng)
        values = values_of_a_round(0, on=True, damped=False)
        least = (N - 1) * PITCH[0] + WHEN["flags"]
        for clock in range(rng.randrange(least, least + ENDS)):
            await bench.clock(values.get(clock), 0.5)
        await bench.begin(rng)
        values = values_of_a_round(0, on=False, damped=False)
        for clock in range(least + ENDS + 2 * LONGEST + 9):
            await bench.clock(values.get(clock), 1.0)
        assert bench.rounds == {"step": 0, "none": 1, "half": 0}
        assert bench.given == [1, 1]
