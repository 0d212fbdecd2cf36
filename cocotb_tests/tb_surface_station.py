# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_surfaces.v`` and ``rtl/wh_surface_words.v``: the law of surfaces, every bit.

The model is :mod:`wavehaptics.controller.surfaces`. The sums of energy are the bench's own.
"""

from __future__ import annotations

import math
import os
import random
from collections import Counter
from collections.abc import Iterable

import cocotb
import numpy as np
from bench import Bench, random_source
from simulators import parameters
from wavehaptics.controller import surfaces
from wavehaptics.controller.pins_timing import surface_clocks
from wavehaptics.controller.planes import PLANE_ROW, VELOCITY_MAX, as_registers
from wavehaptics.words import formats

PORTS = parameters().get("PORTS") or parameters()["N"]
SURFACES = parameters()["SURFACES"]
ROUNDS = int(os.environ.get("WH_ROUNDS", 20000 if "Verilator" in cocotb.SIM_NAME else 400))
"""Random rounds; as many as you like with WH_ROUNDS, which is the soak of docs/reliability.md."""
ONE = 1 << formats.SURFACE.fraction
MIX_ONE = 1 << formats.MIX.fraction
WAVE_MAX, WAVE_MIN = formats.WAVE.raw_max, formats.WAVE.raw_min
WORD = 1 << 26
"""A word of a coefficient is less than this, or as much below zero."""

TURN = 4
"""Clocks from one port's words to the next one's, or more."""
SQUARES = 32
"""Clocks that a component of a vector takes at most, with the storing of all three."""


def clocks_of(acting: int, lossy: bool) -> int:
    """Clocks of a round from the last port's words to the last port's answer."""
    return surface_clocks(PORTS, SURFACES, acting, lossy)


def squares(waves: np.ndarray) -> int:
    return sum(int(wave) ** 2 for wave in waves)


class Words:
    """A frame of a host: planes, vectors, the largest ξ."""

    def __init__(self) -> None:
        self.planes, self.vectors = surfaces.new_planes(), surfaces.new_vectors()
        self.most = 0

    @classmethod
    def random(cls, rng: random.Random) -> Words:
        """Most of them senseless; of any third the vectors are as long as accepted."""
        words, numbers = cls(), np.random.default_rng(rng.getrandbits(32))
        dense = rng.random() < 0.5
        for plane in words.planes[:SURFACES]:
            plane[:] = numbers.integers(-WORD, WORD, surfaces.PLANE_WORDS)
            plane[surfaces.PRESENT] = dense or rng.random() < 0.5
            if rng.random() < 0.5:  # one that is touched, or nearly
                plane[surfaces.D] = rng.randint(-300, 300)
            else:
                plane[surfaces.D] = rng.randint(-(1 << 39), (1 << 39) - 1) >> rng.randint(0, 39)
            if rng.random() < 0.5:
                plane[surfaces.C : surfaces.GAIN] >>= rng.randint(0, 26)
                plane[surfaces.GAIN] >>= rng.randint(0, 26)
            if rng.random() < 0.1:
                plane[surfaces.G : surfaces.D] = rng.choice((-WORD, WORD - 1, 0))
                plane[surfaces.C : surfaces.A] = rng.choice((-WORD, WORD - 1, 0))
            plane[surfaces.ETA] = rng.choice((-ONE, ONE, -ONE // 2, 0, rng.randint(-ONE, ONE)))
            plane[surfaces.ACROSS] = rng.choice((ONE, ONE - 1, 0, rng.randint(0, ONE)))
            plane[surfaces.A] = rng.choice(
                (ONE, ONE - 1, ONE // 3, ONE // 1000, 1, 0, rng.randint(0, ONE))
            )
        words.vectors[:] = numbers.integers(-WORD, WORD, words.vectors.shape)
        words.vectors[:, surfaces.MIX :] >>= rng.randint(0, 20)
        unit = numbers.normal(size=(surfaces.VECTORS, surfaces.PORTS))
        unit *= numbers.random(unit.shape) < 0.8
        unit /= np.maximum(np.linalg.norm(unit, axis=1), 1e-9)[:, None]
        if rng.random() < 0.3:  # orthogonal sets
            axes, _ = np.linalg.qr(numbers.normal(size=(3, 3)))
            sizes = (surfaces.MOST_SURFACES, 28, 56)
            unit = np.repeat(axes, sizes, axis=0)
        length = numbers.choice([1.0, 1.0, 0.7, 0.0], (surfaces.VECTORS, 1))
        words.vectors[:, :3] = np.trunc(unit * length * ONE * (1.0 - 2.0**-30))
        for vector in words.vectors:
            while squares(vector[:3]) > ONE**2:
                vector[:3] -= np.sign(vector[:3])
        if rng.random() < 0.2:
            words.vectors[:, :3] = np.roll([rng.choice((ONE, -ONE)), 0, 0], rng.randint(0, 2))
        words.most = rng.choice((0, 1, WAVE_MAX, rng.getrandbits(25)))
        words.planes[:, surfaces.G + PORTS : surfaces.D] = 0
        words.planes[:, surfaces.C + PORTS : surfaces.GAIN] = 0
        words.vectors[:, PORTS:3] = 0
        assert surfaces.accepts(words.planes, words.vectors)
        return words


class SurfacesBench(Bench):
    """Writes frames, gives rounds, and compares after each of them."""

    looks = False
    """Whether the states inside are compared, too."""

    async def begin(self, budget: int) -> None:
        await self.start(
            write_i=0, address_i=0, data_i=0, commit_i=0, valid_i=0, port_i=0, position_i=0,
            current_i=0, wave_i=0, free_i=ONE, budget_i=budget,
        )  # fmt: skip
        self.state, self.spent = surfaces.new_state(), np.zeros(1, dtype=np.int64)
        self.active = np.zeros(surfaces.MOST_ACTIVE, dtype=np.int64)
        self.limits = np.array([0, budget], dtype=np.int64)
        self.words, self.coming = Words(), None
        self.taken = self.given = 0
        self.most_budget = budget
        self.seen: Counter[object] = Counter()

    def set_budget(self, budget: int) -> None:
        """It may change between any two rounds."""
        self.drive(budget_i=budget)
        self.limits[surfaces.BUDGET] = budget
        self.most_budget = max(self.most_budget, budget)

    async def write(self, address: int, word: int) -> None:
        await self.step(write_i=1, address_i=address, data_i=word)
        self.drive(write_i=0)
        for _ in range(SQUARES):
            if not self.word("busy_o"):
                return
            await self.step()
        raise AssertionError("busy for too long")

    async def frame(self, words: Words) -> None:
        for address, word in as_registers(words.planes, words.vectors, words.most, SURFACES):
            await self.write(address, word)

    async def commit(self, words: Words | None, why: object = None) -> None:
        """Commit; None: it has to be refused."""
        await self.step(commit_i=1)
        self.drive(commit_i=0)
        assert self.word("refused_o") == (words is None), why
        assert self.word("busy_o") == (words is not None)
        self.coming = words

    async def round(
        self, positions: np.ndarray, currents: np.ndarray, waves: np.ndarray, free: int
    ) -> np.ndarray:
        if self.coming is not None:
            self.words, self.coming = self.coming, None
            self.limits[surfaces.VELOCITY_MAX] = self.words.most
        for port in range(PORTS):
            await self.step(
                1, valid_i=1, port_i=port, position_i=int(positions[port]),
                current_i=int(currents[port]), wave_i=int(waves[port]), free_i=free,
            )  # fmt: skip
            if port < PORTS - 1:
                await self.step(TURN - 1, valid_i=0)
        wanted, before = waves.copy(), self.spent[0]
        touched = self.state[:, surfaces.TOUCHING].copy()
        acting = surfaces.surfaces_step(
            self.state, self.spent, self.active, self.words.planes, self.words.vectors, self.limits,
            positions, currents, free, wanted,
        )  # fmt: skip
        eta = min(free, self.words.planes[self.active[0], surfaces.ACROSS]) if acting == 1 else free
        clocks = clocks_of(acting, eta < ONE)
        # The words go when their three clocks are over.
        await self.step(2, valid_i=0)
        self.drive(position_i=-1, current_i=-1, wave_i=-1)
        await self.step(clocks - PORTS - 3)
        assert self.word("valid_o") == 0
        for port in range(PORTS):
            await self.step(1)
            assert (self.word("valid_o"), self.word("port_o")) == (1, port)
            assert self.signed("wave_o") == wanted[port], self.seen
        assert self.word("acting_o") == acting
        self.taken += squares(waves)
        self.given += squares(wanted)
        assert self.given <= self.taken + self.most_budget
        self.seen["leaves"] += int((touched > self.state[:, surfaces.TOUCHING]).sum())
        if self.looks:
            self.check_states()
        self.seen[acting] += 1
        self.seen["lossy", acting] += eta < ONE
        self.seen["paid"] += before < self.spent[0]
        return wanted

    def check_states(self) -> None:
        inside = self.dut.surfaces
        assert int(inside.spent_q.value) == self.spent[0]
        touching = int(inside.touching_q.value)
        for n, (touches, f, account, rest) in enumerate(self.state):
            assert touching >> n & 1 == touches
            if touches:
                assert inside.filters[n].value.to_signed() == f
                assert int(inside.accounts[n].value) == account
                assert inside.rests[n].value.to_signed() == rest


def of_ports(words: Iterable[int]) -> np.ndarray:
    """A word of each port, and 0 where a group has no port."""
    placed = np.zeros(surfaces.PORTS, dtype=np.int64)
    placed[:PORTS] = list(words)
    return placed


def random_round(rng: random.Random, kind: str, before: np.ndarray) -> tuple[np.ndarray, ...]:
    """Positions, currents and waves, and the least η of free space."""

    def three(low: int, high: int, shift: int = 0) -> np.ndarray:
        words = [rng.randint(low, high) >> rng.randint(0, shift) for _ in range(PORTS)]
        return of_ports(words)

    if kind == "ends":
        ends = [WAVE_MIN, WAVE_MAX, 0, 1, -1, rng.randint(WAVE_MIN, WAVE_MAX)]
        waves = of_ports(rng.choice(ends) for _ in range(PORTS))
        currents = of_ports(rng.choice(ends) for _ in range(PORTS))
    elif kind == "echo":
        waves, currents = -np.maximum(before, -WAVE_MAX), three(-(1 << 24), 1 << 24, 24)
    elif kind == "small":
        waves, currents = three(-3, 3), three(-3, 3)
    else:
        waves, currents = three(WAVE_MIN, WAVE_MAX, 30), three(WAVE_MIN, WAVE_MAX, 30)
    if rng.random() < 0.1:
        positions = three(-(1 << 31), (1 << 31) - 1, 31)
        if rng.random() < 0.2:
            positions[0] = rng.choice((-(1 << 31), (1 << 31) - 1))
    else:
        positions = three(-5, 5)
    free = rng.choice((ONE, ONE, ONE - 3, 0, -ONE, rng.randint(0, ONE)))
    return positions, currents, waves, free


def random_budget(rng: random.Random) -> int:
    return rng.choice((0, 1 << 50, rng.getrandbits(40), surfaces.ACCOUNT_MAX))


async def run_rounds(
    bench: SurfacesBench, rng: random.Random, rounds: int, of_a_frame: int
) -> Counter[object]:
    """Random frames and rounds, with words at their ends; counts what was seen."""
    acting: Counter[object] = Counter()
    frames = 0
    while frames * of_a_frame < rounds:
        if frames % 6 == 0:
            if frames:
                acting += bench.seen
            await bench.begin(random_budget(rng))
        words = Words.random(rng)
        await bench.frame(words)
        await bench.commit(words)
        frames += 1
        echo = np.zeros(3, dtype=np.int64)
        kind = "full"
        for _ in range(of_a_frame):
            if rng.random() < 0.2:
                kind = rng.choice(("ends", "echo", "echo", "small", "full"))
            if rng.random() < 0.02:
                bench.set_budget(random_budget(rng))
            positions, currents, waves, free = random_round(rng, kind, echo)
            echo = await bench.round(positions, currents, waves, free)
    acting += bench.seen
    cocotb.log.info("seen: %s", acting)
    return acting


@cocotb.test(timeout_time=max(4000, ROUNDS // 50), timeout_unit="ms")
async def random_rounds(dut: object) -> None:
    """Rounds of which each wave is compared."""
    seen = await run_rounds(SurfacesBench(dut), random_source("rounds"), ROUNDS, 50)
    for n in range(min(SURFACES, surfaces.MOST_ACTIVE) + 1):
        assert seen[n] > ROUNDS / 100, n
        assert seen["lossy", n] > ROUNDS / 200, n
    assert seen["leaves"] > ROUNDS / 50
    assert seen["paid"] > ROUNDS / 50


@cocotb.test(timeout_time=400, timeout_unit="ms")
async def states_inside(dut: object) -> None:
    """Rounds of which each state is compared: touched, filter, account, rest, budget."""
    bench = SurfacesBench(dut)
    bench.looks = True
    seen = await run_rounds(bench, random_source("states"), ROUNDS // 4, 10)
    for n in range(min(SURFACES, surfaces.MOST_ACTIVE) + 1):
        assert seen[n], n
    assert seen["leaves"]


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def words_that_are_refused(dut: object) -> None:
    """Each word that could give out energy, and what is written at the wrong time or elsewhere."""
    bench = SurfacesBench(dut)
    rng = random_source("refused")
    await bench.begin(0)
    good = Words()
    good.planes[0, [surfaces.PRESENT, surfaces.A, surfaces.ACROSS]] = 1, ONE, ONE
    good.planes[0, surfaces.ETA], good.vectors[0, 0] = -ONE, ONE
    plane = 8 * PLANE_ROW
    component = 27380416
    longest = math.isqrt(ONE**2 - component**2)
    ends = [
        [(plane + 9, -1)], [(plane + 9, ONE + 1)], [(plane + 10, ONE + 1)],
        [(plane + 10, -ONE - 1)], [(plane + 11, -1)], [(plane + 11, ONE + 1)],
        [(plane + 2, WORD)], [(plane + 2, -WORD - 1)],
        [(8 * VELOCITY_MAX[0], -1)], [(8 * VELOCITY_MAX[0], 1 << 30)], [(plane + 12, 0)],
        [(8 * VELOCITY_MAX[0] + 1, 0)], [(8 * 127, 0)], [(6, 0)], [(0, ONE + 1)],
        [(0, -ONE - 1)], [(0, -(1 << 31))], [(1, 5)], [(0, 0), (2, 0)], [(0, 0), (9, 0)],
        [(0, 0), (1, 0), (1, 0)],
        [(8 * 91, longest + 1), (8 * 91 + 1, -component), (8 * 91 + 2, 0)],
        [(8 * 91, ONE), (8 * 91 + 1, 0), (8 * 91 + 2, 1)],
        [(8 * 91, -ONE), (8 * 91 + 1, 1), (8 * 91 + 2, 0)],
    ]  # fmt: skip
    zeros, waves = of_ports([0] * PORTS), of_ports([5, 7, 9][:PORTS])
    reflected = waves * [-1, 1, 1]
    for bad in ends:
        await bench.frame(good)
        await bench.commit(good)
        assert (await bench.round(zeros, zeros, waves, ONE) == reflected).all()
        await bench.frame(good)
        for address, word in bad:
            await bench.write(address, word)
        await bench.commit(None, bad)
        # What was in force is, whatever part of the frame was good.
        assert (await bench.round(zeros, zeros, waves, ONE) == reflected).all(), bad
    accepted = [
        [(plane + 9, 0)], [(plane + 10, ONE)], [(plane + 10, -ONE)], [(plane + 11, 0)],
        [(plane + 2, WORD - 1)], [(plane + 2, -WORD)], [(plane + 7, -(1 << 31))],
        [(8 * VELOCITY_MAX[0], WAVE_MAX)], [(plane, -(1 << 31))],
        [(8 * 91, ONE), (8 * 91 + 1, 0), (8 * 91 + 2, 0)],
        [(8 * 91, 0), (8 * 91 + 1, 0), (8 * 91 + 2, -ONE)],
        [(8 * 91, longest), (8 * 91 + 1, -component), (8 * 91 + 2, 0)],
    ]  # fmt: skip
    for fine in accepted:
        for address, word in fine:
            await bench.write(address, word)
        await bench.commit(Words(), fine)
        await bench.round(zeros, zeros, waves, ONE)
    # A frame that names no surface has none; a late word, or a commit while busy, spoils the next.
    await bench.frame(good)
    await bench.commit(good)
    await bench.step(write_i=1, address_i=8 * PLANE_ROW, data_i=1)
    bench.drive(write_i=0)
    await bench.round(zeros, zeros, waves, ONE)
    await bench.commit(None)
    for clocks in (0, 3, 26):
        await bench.step(write_i=1, address_i=8 * 3, data_i=rng.randint(-ONE, ONE))
        await bench.step(clocks, write_i=0)
        await bench.step(write_i=1, address_i=8 * PLANE_ROW, data_i=1)
        bench.drive(write_i=0)
        await bench.step(SQUARES)
        await bench.commit(None)
    await bench.commit(Words())
    assert (await bench.round(zeros, zeros, waves, ONE) == waves).all()


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def a_round_that_ends_early(dut: object) -> None:
    """A reset in any clock of a round: it ends, nothing is touched, and the next one is whole."""
    bench = SurfacesBench(dut)
    rng = random_source("early")
    await bench.begin(1 << 40)
    for clock in range(0, clocks_of(min(SURFACES, 3), True) + 3, 7):
        words = Words.random(rng)
        words.planes[:, surfaces.D] = -1000
        words.planes[3:, surfaces.PRESENT] = 0
        await bench.frame(words)
        await bench.commit(words)
        for _ in range(2):
            positions, currents, waves, free = random_round(rng, "full", np.zeros(3))
            await bench.round(np.zeros(3, dtype=np.int64), currents, waves, free)
        for port in range(PORTS):
            await bench.step(1, valid_i=1, port_i=port, position_i=0, current_i=0, wave_i=5)
            await bench.step(TURN - 1 if port < PORTS - 1 else 0, valid_i=0)
        await bench.step(clock, valid_i=0)
        await bench.begin(1 << 40)
        assert bench.word("acting_o") == 0
        await bench.round(positions, currents, waves, free)
        assert bench.seen[0] == 1, "no surface is there after a reset"


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def a_commit_in_every_clock(dut: object) -> None:
    """A frame that is committed in whatever clock of a round is in force with the next one.

    So a round has words of one frame alone. Only before its first clock, the last port's strobe,
    is there a commit that counts for it.
    """
    bench = SurfacesBench(dut)
    rng = random_source("commits")
    await bench.begin(1 << 40)
    zeros = np.zeros(surfaces.PORTS, dtype=np.int64)
    longest = TURN * (PORTS - 1) + clocks_of(min(SURFACES, 3), True)
    acted: Counter[int] = Counter()
    for clock in range(1, longest + 1, 1 if SURFACES < 4 else 17):
        words = Words.random(rng)
        words.planes[:, surfaces.D] = -1000
        words.planes[: min(2, SURFACES), surfaces.PRESENT] = 1
        words.planes[3:, surfaces.PRESENT] = 0
        await bench.frame(words)
        _, currents, waves, _ = random_round(rng, "full", zeros)
        is_early = clock < TURN * (PORTS - 1)
        if is_early:
            bench.coming = words

        async def commit(clock: int = clock) -> None:
            await Bench(dut).step(clock)
            bench.drive(commit_i=1)
            await Bench(dut).step(1)
            bench.drive(commit_i=0)

        committed = cocotb.start_soon(commit())
        before = bench.clocks
        await bench.round(zeros, currents, waves, ONE)
        acted[int(bench.word("acting_o"))] += 1
        await committed
        assert bench.clocks - before <= longest
        assert not bench.word("refused_o"), clock
        bench.coming = None if is_early else words
        # The bank that has just come into force, or the one that waits, is whole.
        await bench.round(zeros, currents, -waves, ONE)
    assert acted[min(SURFACES, 2)] + acted[3] > longest // 40
