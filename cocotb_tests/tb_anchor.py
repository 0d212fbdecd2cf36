# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_anchor.v``: equal to :func:`wavehaptics.anchor.anchor_step`, word for word."""

from __future__ import annotations

import random

import cocotb
import numpy as np
from bench import Bench, random_source
from wavehaptics import anchor, formats

STEP_CLOCKS = 24
LOWEST, HIGHEST = -(1 << (formats.COUNT_W - 1)), (1 << (formats.COUNT_W - 1)) - 1
DATA, COEF = formats.CURRENT, formats.ROOT
ROOT_SHIFT = formats.ROOT_SUM_Q - formats.ROOT.fraction


class AnchorBench(Bench):
    """Steps the anchor, and compares every word with the model's."""

    def __init__(self, dut: object) -> None:
        super().__init__(dut)
        self.settings = np.zeros(anchor.SETTINGS, dtype=np.int64)
        self.state = anchor.new_state(self.settings)
        self.steps = 0
        self.seen: set[str] = set()

    async def begin(self, settings: np.ndarray) -> None:
        """Reset with new settings."""
        self.settings = settings
        self.state = anchor.new_state(settings)
        await self.start(
            start_i=0, update_i=0, busy_i=0, position_i=0, contact_i=0, depth_i=0, current_i=0,
            saturated_i=0, coef_i=-5, words_i=anchor.packed(settings),
        )  # fmt: skip
        self.check()

    def check(self) -> None:
        got = {name: self.signed(f"{name}_o") for name in ("wave", "root", "limit")}
        got |= {name: self.word(f"{name}_o") for name in ("pulled", "fault")}
        places = (anchor.WAVE, anchor.ROOT, anchor.LIMIT, anchor.PULLED, anchor.FAULT)
        want = dict(zip(got, (int(self.state[place]) for place in places), strict=True))
        assert got == want, f"step {self.steps}"
        assert self.signed("tracked_o") == self.state[anchor.ROOT_SUM] >> ROOT_SHIFT

    async def tick(
        self, rng: random.Random, position: int, contact: int, depth: int, current: int,
        saturated: int = 0,
    ) -> None:  # fmt: skip
        """One step, with the core's valid before, at or after the anchor's end."""
        before = self.state.copy()
        anchor.anchor_step.py_func(
            self.state, self.settings, position, bool(contact), depth, current, saturated
        )
        update_at = rng.choice((3, STEP_CLOCKS - 1, STEP_CLOCKS, STEP_CLOCKS + 9))
        crowded = rng.random() < 0.3
        self.drive(
            start_i=1, position_i=position, contact_i=contact, depth_i=depth, current_i=current,
            saturated_i=saturated,
        )  # fmt: skip
        await self.step()
        # What the core may change during the step must not matter.
        self.drive(start_i=0, position_i=rng.getrandbits(30), depth_i=rng.getrandbits(30))
        clocks = 1
        while self.word("busy_o"):
            assert clocks < 200, "the anchor never came to an end"
            self.drive(update_i=clocks == update_at, busy_i=crowded and rng.random() < 0.5)
            await self.step()
            clocks += 1
        if not crowded:
            assert clocks == max(STEP_CLOCKS, update_at + 1), clocks
        self.drive(update_i=0, busy_i=0)
        self.steps += 1
        self.check()
        self._note(before)

    def _note(self, before: np.ndarray) -> None:
        state = self.state
        self.seen |= {
            name
            for name, happened in {
                "wave": state[anchor.WAVE] != 0,
                "no wave": state[anchor.WAVE] == 0,
                "pulled": state[anchor.PULLED] > before[anchor.PULLED],
                "back": state[anchor.PULLED] < before[anchor.PULLED],
                "fault": state[anchor.FAULT] > before[anchor.FAULT],
                "tracked up": state[anchor.ROOT_SUM] > before[anchor.ROOT_SUM],
                "tracked down": state[anchor.ROOT_SUM] < before[anchor.ROOT_SUM],
                "limit": state[anchor.LIMIT] != before[anchor.LIMIT],
                "largest wave": abs(int(state[anchor.WAVE])) >= formats.WAVE.raw_max,
            }.items()
            if happened
        }


def magnitude(rng: random.Random, bits: int) -> int:
    """Any number of at most ``bits`` bits; all magnitudes alike."""
    return rng.getrandbits(rng.randint(1, bits))


def random_settings(rng: random.Random) -> np.ndarray:
    """Settings from ordinary to the corners of their words."""
    words = np.zeros(anchor.SETTINGS, dtype=np.int64)
    coef_max, data_max = COEF.raw_max, DATA.raw_max
    words[anchor.ENABLE] = rng.random() < 0.9
    words[anchor.PUSH_ONLY] = rng.random() < 0.7
    for place in (anchor.HALF_CELL, anchor.ANCHOR_GAIN, anchor.RELEASE_GAIN, anchor.SURFACE_GAIN,
                  anchor.TRACK_GAIN, anchor.LOST_ROOT, anchor.WARM_ROOT):  # fmt: skip
        words[place] = rng.choice((0, coef_max, magnitude(rng, COEF.width - 1)))
    for place in (anchor.DEAD_ZONE, anchor.LIMIT_FREE, anchor.LIMIT_BASE, anchor.LIMIT_SLOPE,
                  anchor.LOST_CURRENT):  # fmt: skip
        words[place] = rng.choice((0, data_max, magnitude(rng, DATA.width - 1)))
    roots = sorted(magnitude(rng, COEF.width - 1) for _ in range(3))
    words[anchor.ROOT_MIN], words[anchor.ROOT_START], words[anchor.ROOT_MAX] = roots
    words[anchor.ROOT_FREE] = magnitude(rng, COEF.width - 1)
    words[anchor.RELEASE_TICKS] = rng.choice((1, 5, 20))
    words[anchor.LOST_TICKS] = rng.choice((1, 8, 40))
    return words


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def random_motion(dut: object) -> None:
    """Walks through both sides of a wall, jumps, corners of every word, resets in between."""
    bench = AnchorBench(dut)
    rng = random_source("anchor")
    for _ in range(30):
        await bench.begin(random_settings(rng))
        position, edge = rng.choice((0, LOWEST, HIGHEST)), rng.randint(-3, 3)
        for _ in range(25):
            step = rng.choice((0, 0, 0, 1, 1, -1, -1, 2, -5, magnitude(rng, 32)))
            position = (position + step - LOWEST) % (1 << formats.COUNT_W) + LOWEST
            contact = rng.random() < 0.8
            depth = rng.choice((position - edge, 0, -1, 2, -3, LOWEST, HIGHEST, magnitude(rng, 20)))
            depth = min(max(depth, LOWEST), HIGHEST) if contact else 0
            current = rng.choice((DATA.raw_min, DATA.raw_max, 0, 1, -1))
            if rng.random() < 0.7:
                current = magnitude(rng, DATA.width - 1) * rng.choice((-1, 1))
            await bench.tick(rng, position, contact, depth, current, rng.random() < 0.1)
    assert bench.steps == 30 * 25
    assert bench.seen == {
        "wave", "no wave", "pulled", "back", "fault", "tracked up", "tracked down", "limit",
        "largest wave",
    }  # fmt: skip


def hold_settings(track: float) -> np.ndarray:
    """An ordinary anchor, whose s starts at 2 √Ω and moves by ``track`` √Ω/A a tick."""
    words = np.zeros(anchor.SETTINGS, dtype=np.int64)
    words[anchor.ENABLE] = 1
    words[anchor.HALF_CELL] = formats.CELL_CURRENT.to_raw(0.03)
    words[anchor.DEAD_ZONE] = formats.CURRENT.to_raw(0.03)
    words[anchor.ANCHOR_GAIN] = formats.PULL.to_raw(1.9)
    words[anchor.TRACK_GAIN] = formats.TRACK.to_raw(track)
    for place, root in ((anchor.ROOT_MIN, 1.8), (anchor.ROOT_START, 2.0),
                        (anchor.ROOT_MAX, 2.2), (anchor.ROOT_FREE, 1.6)):  # fmt: skip
        words[place] = formats.ROOT.to_raw(root)
    words[anchor.LIMIT_BASE] = words[anchor.LIMIT_FREE] = formats.WAVE.to_raw(5.0)
    words[anchor.LOST_CURRENT] = formats.CURRENT.to_raw(1.0)
    words[anchor.LOST_TICKS] = 100
    words[anchor.RELEASE_TICKS] = 5
    return words


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_hold_with_an_error_of_r(dut: object) -> None:
    """An ordinary hold: the error beyond the dead zone moves s, slowly and to the right side."""
    bench = AnchorBench(dut)
    rng = random_source("hold")
    for side in (1, -1):
        words = hold_settings(1e-5)
        await bench.begin(words)
        depth = 10 if side > 0 else -11
        weak = -side * formats.CURRENT.to_raw(0.5)  # i* is 0.63 A
        for _ in range(60):
            await bench.tick(rng, depth, 1, depth, weak)
        gained = bench.signed("tracked_o") - words[anchor.ROOT_START]
        expected = 60 * 1e-5 * (0.63 - 0.5 - 0.03 + 0.13 / 256)
        assert abs(formats.ROOT.to_value(gained) / expected - 1) < 0.01
        assert bench.state[anchor.WAVE] * side < 0
        assert bench.signed("root_o") == words[anchor.ROOT_START] + gained


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_rotor_that_moves_unseen(dut: object) -> None:
    """Once s has settled, an error goes on with edges and ends in a fault without; s goes back."""
    bench = AnchorBench(dut)
    rng = random_source("unseen")
    words = hold_settings(1e-3)
    words[anchor.LOST_ROOT] = formats.ROOT.to_raw(0.01)
    await bench.begin(words)
    right, weak = (formats.CURRENT.to_raw(-current) for current in (0.63, 0.5))
    for n in range(300):  # a rotor that goes to and fro between two cells
        depth = 10 + n // 8 % 2
        await bench.tick(rng, depth, 1, depth, weak)
    assert not bench.word("fault_o")
    assert bench.signed("tracked_o") - words[anchor.ROOT_START] > 2 * words[anchor.LOST_ROOT]
    for _ in range(30):
        await bench.tick(rng, 10, 1, 10, right)
    assert bench.state[anchor.QUIET] >= words[anchor.LOST_TICKS] >> anchor.SETTLED_SHIFT
    known = bench.state[anchor.KNOWN]
    gone = (bench.state[anchor.ROOT_SUM] - known) / 2**formats.ROOT_SUM_Q
    ticks = 0
    while not bench.word("fault_o"):
        await bench.tick(rng, 10, 1, 10, weak)
        ticks += 1
        assert ticks < 200
    # The current is 0.1 A beyond the dead zone, and 1/256 of the error counts within; a change is
    # judged in the tick after.
    assert abs(ticks - 1.5 - (0.01 - gone) / (1e-3 * (0.1 + 0.13 / 256))) < 1
    assert bench.signed("tracked_o") == known >> ROOT_SHIFT


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def an_s_that_never_settles(dut: object) -> None:
    """A rotor that swings unseen: a fault after 2^3 LOST_TICKS, and s as at the start."""
    bench = AnchorBench(dut)
    rng = random_source("unsettled")
    words = hold_settings(1.5e-2)
    words[anchor.LOST_ROOT] = formats.ROOT.to_raw(0.01)
    words[anchor.LOST_TICKS] = 16
    await bench.begin(words)
    ticks = 0
    while not bench.word("fault_o"):
        current = -0.5 if ticks // 6 % 2 else -0.76
        await bench.tick(rng, 10, 1, 10, formats.CURRENT.to_raw(current))
        ticks += 1
        assert ticks < 200
    assert ticks == 1 + (16 << anchor.UNSETTLED_SHIFT)
    assert bench.signed("tracked_o") == words[anchor.ROOT_START]


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_start_while_busy_is_told(dut: object) -> None:
    """overrun_o rises, stays until reset, and the step under way is not disturbed."""
    bench = AnchorBench(dut)
    rng = random_source("overrun")
    await bench.begin(random_settings(rng))
    await bench.tick(rng, 1, 1, 1, 1000)
    assert not bench.word("overrun_o")
    bench.drive(start_i=1)
    await bench.step(2)
    assert bench.word("overrun_o")
    await bench.begin(random_settings(rng))
    assert not bench.word("overrun_o")
