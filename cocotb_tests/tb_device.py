# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_device.v``: what the bus may ask for, and what the bridges make of it."""

from __future__ import annotations

import random

import cocotb
from bench import random_source
from settings_bus import BUSY, COMMIT, DISCARD, DONE, NOT_NOW, RANGE, UNKNOWN, BusBench  # fmt: skip
from simulators import parameters
from wavehaptics.controller.guard import Fault
from wavehaptics.controller.modulator import width_bounds
from wavehaptics.words import table
from wavehaptics.words.bridge_modes import HALF_BRIDGE as HALF_BRIDGE_NAME
from wavehaptics.words.bridge_modes import MODE_WORDS
from wavehaptics.words.bridge_modes import UNIPOLAR as UNIPOLAR_NAME
from wavehaptics.words.places import places
from wavehaptics.words.table import AXES, LEGS, THREE_PHASE_LEGS, WORDS, Sizes

_P = {"N": 1, "WALLS": 4, "SHAPER": 0, "DELAY_LOG2": 2, "MIN_PULSE": 0, "AXES": 0,
      **parameters()}  # fmt: skip
BRUSHLESS = _P["AXES"] != 0
LINES = _P["N"]
SIZES = Sizes(
    LINES // AXES if BRUSHLESS else LINES, _P["WALLS"], _P["SHAPER"], _P["DELAY_LOG2"],
    THREE_PHASE_LEGS if BRUSHLESS else LEGS,
)  # fmt: skip
"""Of ADCs."""
HALVES = 2 if BRUSHLESS else 1
"""Carrier halves in a tick, at least."""
MASK = 0xFFFFFFFF
SETTINGS = list(places(SIZES, "setting"))
GATES = ("gate_ah_o", "gate_al_o", "gate_bh_o", "gate_bl_o")
SAFE = {"half_clocks": 150, "tick_halves": HALVES, "sample_clocks": 100, "samples": 1,
        "guard_mask": 0, "guard_damp": 0, "guard_levels": 0}  # fmt: skip
"""Words with which ticks go on and no fault is found."""
OF = (SIZES.motors, SIZES.legs)


class DeviceBench(BusBench):
    """The device, with an ADC that says 0."""

    async def begin(self, enable: int = 0) -> None:
        await super().begin(
            enable_i=0, adc_sdata_i=0, enc_a_i=0, enc_b_i=0, bus_i=0x1234, stop_i=1,
            driver_fault_i=(1 << LINES) - 1, press_i=0,
        )  # fmt: skip
        assert await self.write(BUSY, 1, 20_000) == UNKNOWN
        await self.rests()
        if enable:
            names = ("a", "gain", "root", "u_max", "clocks_per_volt")
            for motor in range(LINES):
                there = [name for name in names if motor in WORDS[name].port_numbers(*OF)]
                await self.set(dict.fromkeys(there, 1 << 20), motor)
            await self.set(SAFE)
            self.drive(enable_i=1)

    async def set(self, values: dict[str, int], motor: int = 0) -> None:
        """Words of the board or of a motor, given while the bridges are off."""
        for name, raw in values.items():
            assert await self.write(WORDS[name].at(motor), raw & MASK) == DONE, name
        assert await self.write(COMMIT, 1) == DONE
        await self.rests()


@cocotb.test(timeout_time=500, timeout_unit="ms", skip=BRUSHLESS)
async def what_the_motor_has_not(dut: object) -> None:
    """No word at any other address, in this motor's places and in the next one's."""
    bench = DeviceBench(dut)
    await bench.begin()
    kinds = {
        place.address: kind
        for kind in ("setting", "command", "live")
        for place in places(SIZES, kind)
    }
    own = {word.at() for word in WORDS.values() if word.block == table.MEMORY}
    missing = 0
    # What is in a capture's memory before anything was written there is undefined.
    for word in (word for word in WORDS.values() if word.name != "capture_data"):
        for part in range(1 if word.row.per == "board" else LINES + 1):
            for index in range(table.MOST[word.row.per] * word.row.count):
                at = word.at(part, index)
                kind = kinds.get(at)
                missing += kind is None
                _, error = await bench.read(at)
                assert error == (DONE if kind in ("setting", "live") else UNKNOWN), word.name
                if kind != "command" and at not in own:
                    # Of a setting it may be out of range.
                    found = await bench.write(at, 1)
                    assert (found == UNKNOWN) == (kind != "setting"), word.name
    assert missing > 40


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def nothing_on_the_bus_lets_the_bridges_on(dut: object) -> None:
    """Any requests at all, a thousand and more: with enable_i low every gate is off."""
    bench, rng = DeviceBench(dut), random_source("bus")
    await bench.begin()
    answers = dict.fromkeys((DONE, UNKNOWN, RANGE, NOT_NOW), 0)

    async def watch() -> None:
        while True:
            await bench._falling
            if bench.word("bus_ready_o"):
                answers[bench.word("bus_error_o")] += 1
            assert not bench.word("running_o")
            assert not any(bench.word(gate) for gate in GATES)

    watching = cocotb.start_soon(watch())
    known = [place.address for kind in ("setting", "command") for place in places(SIZES, kind)]
    known += [COMMIT, DISCARD] * 20
    for _ in range(1500):
        address = rng.choice(known) if rng.random() < 0.9 else rng.randrange(1 << 12)
        raw = random_word(rng)
        # What is in a capture's memory before anything was written there is undefined.
        write = int(rng.random() < 0.9 or address >> 6 == WORDS["capture_data"].at() >> 6)
        await bench.request(write, address, raw, 20)
    assert not watching.done()
    watching.cancel()
    assert min(answers.values()) > 20


def random_word(rng: random.Random) -> int:
    return rng.choice((0, 1, rng.getrandbits(rng.randint(1, 32)), -rng.getrandbits(25) & MASK))


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def enable_waits_while_words_are_loaded(dut: object) -> None:
    """Words that want the bridges off: from the commit to the last of them the bridges are off."""
    bench = DeviceBench(dut)
    await bench.begin(enable=1)
    await bench.step(100)
    assert bench.word("running_o")
    bench.drive(enable_i=0)
    assert await bench.write(WORDS["half_clocks"].at(), 30) == DONE
    assert await bench.write(COMMIT, 1) == DONE
    bench.drive(enable_i=1)
    clocks = 0
    while not bench.word("running_o"):
        assert not bench.word("tick_o")
        assert not any(bench.word(gate) for gate in GATES)
        await bench.step()
        clocks += 1
        assert clocks < 10_000
    assert clocks > 100
    # Halves of 30 clocks, those of the words that came.
    ticks, tick = [], 30 * HALVES
    for clock in range(100 * HALVES):
        if bench.word("tick_o"):
            ticks.append(clock)
        await bench.step()
    assert len(ticks) >= 3
    assert ticks == list(range(ticks[0], 100 * HALVES, tick))


PULSES: list[dict[str, int]] = [
    {"min_pulse": 12}, {"min_pulse": 16}, {"min_pulse": 17}, {"min_pulse": 40}, {"min_pulse": 46},
    {"min_pulse": 47}, {"min_pulse": 100}, {"min_pulse": 255},
    {"dead_clocks": 10}, {"dead_clocks": 47}, {"dead_clocks": 48}, {"dead_clocks": 255},
    {"dead_clocks": 10, "compensate": 1}, {"dead_clocks": 38, "compensate": 1},
    {"dead_clocks": 39, "compensate": 1}, {"dead_clocks": 60, "compensate": 1},
    {"dead_clocks": 100, "min_pulse": 100, "compensate": 1},
    {"dead_clocks": 20, "min_pulse": 24, "compensate": 1},
]  # fmt: skip
"""What the bridge may be told; some of it leaves no pulse."""
HALF_CLOCKS = 48
HALF_BRIDGE, UNIPOLAR = (MODE_WORDS[name] for name in (HALF_BRIDGE_NAME, UNIPOLAR_NAME))


def drives(mode: int, words: dict[str, int]) -> bool:
    """Whether these words leave the bridge a pulse for every voltage."""
    name = next(name for name, word in MODE_WORDS.items() if word == mode)
    least, spare = width_bounds(name, words["min_pulse"])
    widest, dead = HALF_CLOCKS // 2 - spare, words["dead_clocks"]
    fits = widest >= max(1, least) and dead < HALF_CLOCKS
    if words["compensate"] and (5 * dead >= 8 * widest or (mode != UNIPOLAR and not BRUSHLESS)):
        return False
    return fits


@cocotb.test(timeout_time=500, timeout_unit="ms", skip=not _P["MIN_PULSE"])
async def no_voltage_where_none_is_asked_for(dut: object) -> None:
    """At 0 V the bridge gives none, in each mode; settings that leave it no pulse are a fault."""
    bench = DeviceBench(dut)
    await bench.begin(enable=1)
    for motor in range(LINES):  # all that the waves ask for is less than a microvolt
        there = [
            name for name in ("root", "gain", "u_max") if motor in WORDS[name].port_numbers(*OF)
        ]
        bench.drive(enable_i=0)
        await bench.set(dict.fromkeys(there, 1), motor)
    found = {True: 0, False: 0}
    for mode in (HALF_BRIDGE,) if BRUSHLESS else MODE_WORDS.values():
        for pulse in PULSES:
            words = {"min_pulse": 0, "dead_clocks": 0, "compensate": 0} | pulse
            bench.drive(enable_i=0)
            await bench.set(words | ({} if BRUSHLESS else {"mode": mode}) | {
                "half_clocks": HALF_CLOCKS, "tick_halves": 2, "sample_clocks": 2 * HALF_CLOCKS,
                "guard_mask": 1 << Fault.SETTING,
            })  # fmt: skip
            assert await bench.write(WORDS["clear"].at(), 1) == DONE
            bench.drive(enable_i=1)
            await bench.step(400)
            legs = [0] * 3
            for _ in range(20 * 2 * HALF_CLOCKS):
                await bench.step()
                high, low = (
                    bench.word(f"gate_b{side}_o") << 1 | a & 1 | a << 1 & 4
                    for side, a in ((side, bench.word(f"gate_a{side}_o")) for side in "hl")
                )
                legs = [leg + (high >> n & 1) - (low >> n & 1) for n, leg in enumerate(legs)]
            fits = drives(mode, words)
            found[fits] += 1
            assert await bench.value(WORDS["faults"].at()) == (not fits) << Fault.SETTING
            assert bench.word("running_o") == fits, (mode, words)
            if mode == HALF_BRIDGE and not BRUSHLESS:
                legs[1] = 0
            others = legs[: 3 if BRUSHLESS else 2]
            if words["compensate"] and fits:  # the half pulse that the dead time takes away again
                assert max(others) - min(others) <= 20 * 2 * 5 * words["dead_clocks"] // 2, words
            else:
                assert max(others) == min(others), (mode, words, legs)
    assert min(found.values()) > 3
