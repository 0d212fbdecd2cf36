# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_sense_check.v``."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source

LOW, TOP = -(1 << 15), (1 << 15) - 1


class CheckBench(Bench):
    """Feeds words and keeps what must be said of them."""

    async def begin(self, range_word: int, stuck_words: int) -> None:
        self.range_word, self.stuck_words = range_word, stuck_words
        self.words: list[int] = []
        self.stuck_seen = 0
        await self.start(valid_i=0, sample_i=0, range_i=range_word, stuck_words_i=stuck_words)
        assert (self.word("range_o"), self.word("stuck_o")) == (0, 0)

    async def show(self, sample: int, idle: int = 0) -> None:
        self.words.append(sample)
        await self.step(valid_i=1, sample_i=sample)
        last = self.words[-self.stuck_words :] if self.stuck_words else []
        stuck = self.stuck_words > 1 and len(last) == self.stuck_words and len(set(last)) == 1
        self.stuck_seen += stuck
        for n in range(idle + 1):
            assert self.word("range_o") == int(abs(sample) >= self.range_word)
            assert self.word("stuck_o") == int(stuck)
            if n < idle:
                await self.step(valid_i=0, sample_i=LOW)


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def random_words(dut: object) -> None:
    """Words that often repeat, each length of the run, with idle gaps."""
    bench = CheckBench(dut)
    rng = random_source("words")
    for stuck_words in (0, 1, 2, 3, 7):
        await bench.begin(rng.choice((TOP, 1000, 0xFFFF)), stuck_words)
        word = 0
        for _ in range(300):
            if rng.random() < 0.4:
                word = rng.choice((LOW, TOP, 0, 1, -1, rng.randint(LOW, TOP)))
            await bench.show(word, rng.choice((0, 0, 2)))
        assert (bench.stuck_seen > 20) == (stuck_words > 1)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def long_runs(dut: object) -> None:
    """The counter stays at its end: a word that never changes stays stuck."""
    bench = CheckBench(dut)
    await bench.begin(0xFFFF, 0xFFFF)
    await bench.step(valid_i=1, sample_i=5)
    await bench.step(0xFFFD)
    assert bench.word("stuck_o") == 0
    await bench.step()
    for _ in range(5):
        assert bench.word("stuck_o") == 1
        await bench.step()
    await bench.step(sample_i=6)
    assert bench.word("stuck_o") == 0


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def reset_forgets(dut: object) -> None:
    """The first word after a reset is the first of its run, also if it is 0."""
    bench = CheckBench(dut)
    for word in (0, 9):
        await bench.begin(5, 3)
        for _ in range(2):
            await bench.show(word)
        await bench.step(rst=1, valid_i=0)
        bench.drive(rst=0)
        assert (bench.word("range_o"), bench.word("stuck_o")) == (0, 0)
        bench.words.clear()
        for _ in range(3):
            await bench.show(word)
        assert bench.word("stuck_o") == 1
