# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_anchor.v``: equal to its model, word for word.

The model is :func:`wavehaptics.controller.anchor.anchor_step`, with AXIS = 1 ``anchor_axis_step``.
"""

from __future__ import annotations

import math
import os
import random
from dataclasses import dataclass

import cocotb
import numpy as np
from bench import Bench, random_source

os.environ["NUMBA_DISABLE_JIT"] = "1"  # compiling would take longer than it saves

from wavehaptics.controller import anchor, rotor_flux
from wavehaptics.controller.pins_timing import ANCHOR_CLOCKS
from wavehaptics.words import formats

# Clocks since waves_i of a step whose multiplier never makes it wait; with it, since the last of
# its products was granted.
STEP_CLOCKS = ANCHOR_CLOCKS - 1
FROM_LAST_GRANT = 5
GRANTS = ("v_i", "u_i", "withheld_i", "c", "current_i", "learn", "pull", "held")

COUNT = formats.Fixed(formats.COUNT_W, 0)
DATA, COEF = formats.CURRENT, formats.ROOT
PLACE = formats.Fixed(formats.LONG.width - formats.LONG.fraction + rotor_flux.SINE_Q, 0)
CELL = 1 << rotor_flux.SINE_Q
GAINS = range(anchor.FLUX_GAIN, anchor.ROOM_GAIN + 1)
LIMITS = range(anchor.REACH, anchor.STRANGE + 1)
MOST = {
    anchor.REACH: 1 << (formats.DATA_W - 2),
    anchor.STRANGE: DATA.raw_max,
    anchor.LEARN_MAX: COEF.raw_max,
    anchor.BRUSH: 1 << (formats.DATA_W - 2),
}
"""Settings that are 0 or more, and the largest word of each."""


@dataclass
class Tick:
    """What the anchor gets in a tick, raw words."""

    position: int = 0
    contact: int = 0
    current: int = 0
    u: int = 0
    v: int = 0
    withheld: int = 0
    voltage: int = 0
    saturated: int = 0
    blind: int = 0
    cell: int = CELL
    """Of an axis: what the last count changed of its flux."""
    turned: int = 0
    """By how much its place is not that of so many counts."""

    @property
    def place(self) -> int:
        """Its flux by the encoder."""
        return wrapped(self.position * CELL + self.turned, PLACE)


def wrapped(value: int, format_: formats.Fixed) -> int:
    """``value`` as a word holds it."""
    return (value - format_.raw_min) % (1 << format_.width) + format_.raw_min


class AnchorBench(Bench):
    """Steps the anchor, and compares every word with the model's.

    A word is only held as long as the anchor's header asks for; then it is noise.
    """

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut)
        self.rng = rng
        self.axis = bool(dut.AXIS.value)
        self.settings = np.zeros(anchor.SETTINGS, dtype=np.int64)
        self.state = anchor.new_state()
        self.correction = self.last_next = 0
        self.overrun = 0
        self.steps = 0
        self.seen: set[str] = set()

    def noise(self, width: int = formats.DATA_W) -> int:
        return self.rng.getrandbits(width)

    async def power_up(self) -> None:
        await self.start(
            rst_multiplier=1, position_i=0, place_i=0, cell_i=0, contact_i=0, waves_i=0,
            current_i=0, u_i=0, v_i=0, withheld_i=0, voltage_i=0, saturated_i=0, blind_i=0,
            words_i=0, other_i=0, other_data_i=0, other_coef_i=0,
        )  # fmt: skip
        self.drive(rst_multiplier=0)

    async def begin(self, settings: np.ndarray, clocks: int = 1, *, products: bool = False) -> None:
        """Reset with settings, after which nothing of before matters.

        With ``products``, those that the anchor asked for before still come. Strobes in reset are
        not for it.
        """
        self.settings = settings
        self.state = anchor.new_state()
        self.correction = self.overrun = self.last_next = 0
        self.drive(rst=1, rst_multiplier=not products, words_i=anchor.packed(settings))
        for _ in range(clocks):
            await self.step(
                waves_i=self.rng.random() < 0.3, position_i=self.noise(),
                contact_i=self.noise(1), other_i=self.noise(1),
            )  # fmt: skip
        self.drive(rst=0, rst_multiplier=0, waves_i=0, other_i=0)
        assert not self.word("busy_o")
        self.check()

    def want(self) -> dict[str, int]:
        """The words that are shown at the end of a step."""
        state = self.state
        return {
            "correction": self.correction,
            "next": state[anchor.CORRECTION],
            "room": state[anchor.ROOM],
            "offset": state[anchor.OFFSET],
            "flux": state[anchor.CHI] >> formats.LONG_GUARD,
            "lag": state[anchor.LAG] >> formats.LONG_GUARD,
        }

    def check(self) -> None:
        state = self.state
        for name, value in self.want().items():
            assert self.signed(f"{name}_o") == value, f"{name} of step {self.steps}"
        assert self.word("fault_o") == state[anchor.FAULT], f"step {self.steps}"
        assert self.word("overrun_o") == self.overrun, f"step {self.steps}"

    def give(self, tick: Tick) -> None:
        """A tick's words."""
        self.drive(
            waves_i=1, position_i=tick.position, place_i=tick.place, cell_i=tick.cell,
            contact_i=tick.contact, current_i=tick.current, u_i=tick.u, v_i=tick.v,
            withheld_i=tick.withheld, voltage_i=tick.voltage, saturated_i=tick.saturated,
            blind_i=tick.blind,
        )  # fmt: skip

    async def take(self) -> None:
        """The clock in which they are taken."""
        await self.step()
        self.drive(
            waves_i=0, position_i=self.noise(), place_i=self.noise(PLACE.width),
            cell_i=self.noise(rotor_flux.SINE_Q + 2), contact_i=self.noise(1),
            voltage_i=self.noise(), saturated_i=self.noise(1), blind_i=self.noise(1),
        )  # fmt: skip
        assert self.word("busy_o")

    async def tick(
        self, tick: Tick, *, crowd: float = 0.0, following: Tick | None = None,
        given: bool = False, poke: int = 0,
    ) -> None:  # fmt: skip
        """One step of the anchor.

        Another user has the multiplier in a share ``crowd`` of all clocks. The words of the tick
        ``following`` come in the step's last clock; its own call has ``given`` set. At clock
        ``poke`` there is another waves_i.
        """
        if not given:
            self.check()
            self.give(tick)
        await self.take()
        earlier = self.correction
        self.correction = int(self.state[anchor.CORRECTION])
        before, shown = self.state.copy(), self.want()
        words = (
            bool(tick.contact), tick.current, tick.u, tick.v, tick.withheld, tick.voltage,
            bool(tick.saturated), bool(tick.blind),
        )  # fmt: skip
        if self.axis:
            flux, cell = (word << rotor_flux.SHIFT for word in (tick.place, tick.cell))
            anchor.anchor_axis_step(self.state, self.settings, tick.position, flux, cell, *words)
        else:
            anchor.anchor_step(self.state, self.settings, tick.position, *words)
        self.steps += 1
        self._note(tick, before)
        either = {name: (old, self.want()[name]) for name, old in shown.items()}
        either["correction"] = earlier, self.correction
        either["next"] = self.last_next, either["next"][0]
        clock, grants, last = 1, 0, 0
        while self.word("busy_o"):
            assert clock < 400, "the anchor doesn't come to an end"
            for name, words in either.items():  # nothing in between
                assert self.signed(f"{name}_o") in words, f"{name} within step {self.steps}"
            other = self.rng.random() < crowd
            granted = GRANTS[grants] if self.word("request_o") and not other else ""
            if granted:
                grants, last = grants + 1, clock
            to_go = last + FROM_LAST_GRANT - clock if grants == len(GRANTS) else STEP_CLOCKS
            self.drive(
                other_i=other, other_data_i=self.noise(), other_coef_i=self.noise(),
                waves_i=clock == poke,
            )  # fmt: skip
            self.overrun |= clock == poke
            if following and to_go == 0:
                self.last_next = shown["next"]
                self.give(following)
                return
            await self.step()
            clock += 1
            if granted.endswith("_i"):
                self.drive(**{granted: self.noise()})
        assert grants == len(GRANTS)
        assert clock == last + FROM_LAST_GRANT + 1
        assert crowd or clock == STEP_CLOCKS + 1
        self.drive(waves_i=0, other_i=0)
        assert self.signed("next_o") == shown["next"]
        await self.step()
        self.last_next = int(self.state[anchor.CORRECTION])
        self.check()

    async def ticks(self, ticks: list[Tick]) -> None:
        """Ticks at random distances, the next one's start often before the end of a step."""
        given = False
        for place, tick in enumerate(ticks):
            early = place + 1 < len(ticks) and self.rng.random() < 0.5
            await self.tick(
                tick,
                given=given,
                crowd=self.rng.choice((0.0, 0.0, 0.3, 0.7, 0.9)),
                following=ticks[place + 1] if early else None,
            )
            given = early
            if not early:
                await self.step(self.rng.choice((0, 0, 1, 5)))

    def _note(self, tick: Tick, before: np.ndarray) -> None:
        state, words = self.state, self.settings
        gone = {place: int(state[place] - before[place]) for place in range(anchor.STATES)}
        half = 1 << (formats.LONG.fraction - 1)
        if self.axis:
            half = abs(tick.cell) << rotor_flux.SHIFT >> 1
        theta = int(before[anchor.THETA])
        begins = tick.contact and not before[anchor.TOUCHING]
        sinks = state[anchor.SINKS]
        bound = tick.contact and state[anchor.KNOWS_UP if sinks else anchor.KNOWS_DOWN]
        moved = gone[anchor.POSITION] if before[anchor.STARTED] else 0
        strange = words[anchor.ENABLE] and state[anchor.CLIPPED] and not before[anchor.FAULT]
        self.seen |= {
            name
            for name, happened in {
                "begins up": begins and moved > 0,
                "begins down": begins and moved < 0,
                "begins late": begins and moved == 0 and state[anchor.FRESH] > 0,
                "begins unmoved": begins and state[anchor.FRESH] == 0,
                "correction": state[anchor.CORRECTION] != 0,
                "disabled": not words[anchor.ENABLE],
                "outside above": state[anchor.CHI] >= half,
                "outside below": state[anchor.CHI] < -half,
                "inside": -half <= state[anchor.CHI] < half,
                "clipped above": state[anchor.CLIPPED] and state[anchor.CORRECTION] > 0,
                "clipped below": state[anchor.CLIPPED] and state[anchor.CORRECTION] < 0,
                "not clipped": not state[anchor.CLIPPED] and state[anchor.CORRECTION],
                "clipped with the waves": strange and tick.saturated,
                "room": state[anchor.ROOM] != 0,
                "fault": gone[anchor.FAULT],
                "mean": gone[anchor.MEAN],
                "offset": gone[anchor.OFFSET],
                "learned": gone[anchor.THETA],
                "θ above all": state[anchor.FULL] and state[anchor.THETA] > 0,
                "θ halves": theta > 1 and gone[anchor.THETA] == -theta >> anchor.FADE_SHIFT,
                "θ below 0": state[anchor.THETA] < 0,
                "held": tick.contact and before[anchor.COEFFICIENT] and state[anchor.MEAN],
                "brushes shrink": gone[anchor.BRUSH_LEFT] < 0 and state[anchor.BRUSH_LEFT] > 0,
                "brushes gone": gone[anchor.BRUSH_LEFT] < 0 and state[anchor.BRUSH_LEFT] == 0,
                "travels": gone[anchor.TRAVELS] > 0 and state[anchor.TRAVELS] == 1 and not begins,
                "turns": gone[anchor.TRAVELS] < 0,
                "slow": gone[anchor.QUIET] < 0 and state[anchor.QUIET] == 0,
                "bound below": bound and sinks,
                "bound above": bound and not sinks,
                "bound at the other end": bound
                and state[anchor.UP_ALL if sinks else anchor.DOWN_ALL],
                "withheld": tick.withheld and tick.contact,
                "blind": tick.blind and state[anchor.CLIPPED] and words[anchor.ENABLE],
                "excused": not tick.blind and state[anchor.EXCUSES],
                "far": gone[anchor.FAULT] and not state[anchor.CLIPPED],
            }.items()
            if happened
        }


EVERYTHING = frozenset(
    (
        "begins up", "begins down", "begins late", "begins unmoved", "correction", "disabled",
        "outside above", "outside below", "inside", "clipped above", "clipped below",
        "not clipped", "clipped with the waves", "room", "fault", "mean", "offset", "learned",
        "θ above all", "θ below 0", "held", "brushes shrink", "brushes gone", "travels", "turns",
        "θ halves", "slow", "bound below", "bound above", "bound at the other end", "withheld",
        "blind", "excused", "far",
    )
)  # fmt: skip

AXIS_NEVER = frozenset(("θ halves",))


def any_word(rng: random.Random, format_: formats.Fixed) -> int:
    """A corner, or any word; all magnitudes alike."""
    if rng.random() < 0.25:
        return rng.choice((format_.raw_min, format_.raw_max, 0, 1, -1))
    return rng.getrandbits(rng.randint(1, format_.width - 1)) * rng.choice((-1, 1))


def random_settings(rng: random.Random) -> np.ndarray:
    """Any words that are legal, or gains so small and limits so wide that little is clipped."""
    words = np.zeros(anchor.SETTINGS, dtype=np.int64)
    words[anchor.ENABLE] = rng.random() < 0.85
    calm = rng.random() < 0.5
    for place in GAINS:
        words[place] = any_word(rng, COEF)
        if calm and place == anchor.PULL_GAIN:
            words[place] >>= 8
    for place, most in MOST.items():
        words[place] = most if calm and place in LIMITS else min(abs(any_word(rng, DATA)), most)
    words[anchor.FOLLOW_TICKS] = rng.choice((0, 1, 2, 5, (1 << formats.FOLLOW_W) - 1))
    words[anchor.SLOW_TICKS] = rng.choice((0, 1, 2, 5, (1 << formats.REST_W) - 1))
    return words


def random_ticks(rng: random.Random, count: int) -> list[Tick]:
    """Walks and jumps in and out of contact, with any words as currents, waves and voltages."""
    ticks = []
    position = any_word(rng, COUNT)
    contact, loud, changes = 0, rng.random(), rng.choice((0.2, 0.2, 0.01))
    swings = rng.random() < 0.3  # three counts either way
    for place in range(count):
        move = rng.choice((0, 0, 0, 0, 0, 0, 1, 1, -1, -1, 2, -2, 5, any_word(rng, COUNT)))
        if swings:
            move = (0, 1, -1)[place % 2 * (1 + place // 6 % 2)]
        position = wrapped(position + move, COUNT)
        contact ^= rng.random() < changes
        tick = Tick(position, contact, saturated=rng.random() < 0.1, blind=rng.random() < 0.1)
        tick.cell = rng.choice((CELL, -CELL, 0, 1, -1, rng.randint(-CELL, CELL)))
        tick.turned = rng.choice((0, 0, rng.randint(-CELL, CELL), rng.getrandbits(PLACE.width)))
        if rng.random() < loud:
            tick.current, tick.u, tick.v, tick.withheld, tick.voltage = (
                any_word(rng, DATA) for _ in range(5)
            )
        ticks.append(tick)
    return ticks


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def any_words(dut: object) -> None:
    """Corners and any words of settings and inputs, at any distances, with resets in between."""
    rng = random_source("any words")
    bench = AnchorBench(dut, rng)
    await bench.power_up()
    runs = 6 if "Icarus" in cocotb.SIM_NAME else 50  # enough to see what it sees otherwise
    for _ in range(runs):
        await bench.begin(random_settings(rng), products=rng.random() < 0.5)
        await bench.ticks(random_ticks(rng, 70))
    assert bench.steps == runs * 70
    wanted = EVERYTHING - AXIS_NEVER if bench.axis else EVERYTHING
    assert runs < 50 or bench.seen == wanted, wanted ^ bench.seen


R_OHM, L_H, KT_NM_A, COUNTS, TICK_S = 2.18, 0.24e-3, 0.0234, 10_000, 1e-6
CELL_VS = KT_NM_A * 2 * math.pi / COUNTS
ROOT = math.sqrt(2 * 0.9 * R_OHM)


def motor_settings() -> np.ndarray:
    """The anchor of a small motor (RE 25, 1 MHz)."""
    words = np.zeros(anchor.SETTINGS, dtype=np.int64)
    flux = ROOT * TICK_S / (2 * CELL_VS)
    words[anchor.ENABLE] = 1
    words[anchor.FLUX_GAIN] = formats.FLUX.to_raw(flux)
    words[anchor.OWED_GAIN] = formats.FLUX.to_raw(flux / 0.99)
    words[anchor.CELLS_GAIN] = formats.CELLS.to_raw(L_H / CELL_VS)
    words[anchor.PULL_GAIN] = formats.PULL.to_raw(4 * CELL_VS / L_H)
    cells_per_a = L_H / CELL_VS
    words[anchor.LEARN_GAIN] = formats.LEARN.to_raw(100 * TICK_S / cells_per_a**2)
    words[anchor.LEARN_MAX] = formats.PULL.to_raw(3 / cells_per_a)
    words[anchor.BRUSH] = round(0.3 * cells_per_a / anchor.SEEN_CELLS)
    words[anchor.ZERO_GAIN] = formats.LEARN.to_raw(2000 * TICK_S / R_OHM)
    words[anchor.REACH] = formats.VOLTAGE.to_raw(1.0)
    words[anchor.ROOM_GAIN] = formats.FLUX.to_raw(1 / ROOT)
    words[anchor.STRANGE] = formats.VOLTAGE.to_raw(0.8)
    words[anchor.FOLLOW_TICKS] = 2
    words[anchor.SLOW_TICKS] = 60
    return words


class Motor:
    """A winding, and a rotor that somebody turns, between averaged words."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.current = self.cells = 0.0
        self.before = 0.0  # e_id of the tick before

    def tick(self, e: float, correction: float, speed: float, brush: float, contact: int) -> Tick:
        """The tick in which ``e`` is worked out; ``speed`` in cells a tick, ``brush`` in V."""
        v_back = speed * CELL_VS / TICK_S
        drop = self.before + correction - R_OHM * self.current - v_back - brush
        mean = self.current + drop * TICK_S / L_H / 2
        self.current += drop * TICK_S / L_H
        self.cells += speed
        seen = formats.CURRENT.to_raw(mean + self.rng.gauss(0, 2e-3))
        u = self.before / ROOT
        tick = Tick(
            math.floor(self.cells), contact, seen, formats.WAVE.to_raw(u),
            formats.WAVE.to_raw(u - ROOT * formats.CURRENT.to_value(seen)),
            voltage=formats.VOLTAGE.to_raw(self.before),
        )  # fmt: skip
        self.before = e
        return tick


@cocotb.test(timeout_time=100, timeout_unit="ms")
@cocotb.parametrize(side=(1, -1))
async def a_motor(dut: object, side: int) -> None:
    """A hold with a brush, a spin, a hold beyond the voltage limit, free space; then a lost rotor.

    The words are those of a motor, and stay so.
    """
    rng = random_source("motor")
    bench = AnchorBench(dut, rng)
    await bench.power_up()
    await bench.begin(motor_settings())
    motor = Motor(rng)
    corrections = []
    for n in range(1400):
        contact = n < 500 or 600 <= n < 1000
        e = side * (3.0 * min(1.0, n / 300) if contact else 0.1)
        speed = side * (0.05 if n < 20 or 500 <= n < 600 else 0.0)
        speed += 2 * side if n >= 1350 else 0.0
        tick = motor.tick(e, formats.VOLTAGE.to_value(bench.correction), speed, 0.3 * side, contact)
        if 700 <= n < 800:
            tick.withheld, tick.saturated = formats.WAVE.to_raw(0.01 * side), 1
        await bench.tick(tick, crowd=rng.choice((0.0, 0.2)))
        corrections.append(formats.VOLTAGE.to_value(bench.correction))
        if n < 1000:
            assert abs(bench.state[anchor.CHI]) < 20 << formats.LONG.fraction
    assert max(map(abs, corrections)) > 0.1
    assert bench.seen >= {"learned", "held", "inside", "mean", "offset"}


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def edges_about_the_zone(dut: object) -> None:
    """Single edges, χ anywhere within two counts: each bound, and where there is none."""
    rng = random_source("edges")
    bench = AnchorBench(dut, rng)
    await bench.power_up()
    words = motor_settings()
    words[anchor.REACH] = MOST[anchor.REACH]  # every p shows in c
    await bench.begin(words)
    count = 1 << formats.LONG.fraction
    gain = formats.FLUX.to_value(words[anchor.FLUX_GAIN])
    position, kept, ahead = 0, set(), set()
    for _ in range(300 if "Icarus" in cocotb.SIM_NAME else 2000):
        moved = rng.choice((0, 0, 0, 1, -1))
        position += moved
        chi = bench.state[anchor.CHI] / count + moved
        tick = Tick(position, contact=rng.random() < 0.99)
        tick.u = formats.WAVE.to_raw((chi - rng.uniform(-2.0, 2.0)) / gain)
        goes_on = tick.contact and bench.state[anchor.TOUCHING]
        await bench.tick(tick)
        state = bench.state
        if moved and goes_on:
            up = state[anchor.SINKS]  # which of the two bounds is asked for
            (kept if state[anchor.KNOWS_UP if up else anchor.KNOWS_DOWN] else ahead).add(int(up))
    assert kept == ahead == {0, 1}


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_contacts_beginning_is_excused(dut: object) -> None:
    """An anchor that asks for too much from a contact's first steps on is lost 2 ms later."""
    rng = random_source("excused")
    bench = AnchorBench(dut, rng)
    await bench.power_up()
    for follow in (1, 2, 5):
        words = motor_settings()
        words[anchor.FOLLOW_TICKS] = follow
        words[anchor.REACH], words[anchor.STRANGE] = 1 << anchor.FREE_SHIFT, 0
        await bench.begin(words)
        await bench.tick(Tick())
        lasted = 0
        while not bench.word("fault_o"):
            assert lasted < 40 * follow
            await bench.tick(Tick(3 if lasted else 0, contact=1))
            lasted += 1
        assert abs(lasted - anchor.EXCUSED * follow) <= follow


def slow_ticks_of(place: int) -> tuple[np.ndarray, list[Tick]]:
    """Two edges the same way in free space, after which a rotor isn't slow for 2^place periods.

    Until then its current isn't taken for the offset.
    """
    words = motor_settings()
    words[anchor.SLOW_TICKS] = 1 << place
    current = formats.CURRENT.to_raw(0.1)
    return words, [Tick(position, current=current) for position in (0, 1, 2, 2, 2, 2)]


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def each_place_of_slow_ticks(dut: object) -> None:
    bench = AnchorBench(dut, random_source("slow"))
    await bench.power_up()
    learned = []
    for place in range(formats.REST_W):
        words, ticks = slow_ticks_of(place)
        await bench.begin(words)
        await bench.ticks(ticks[:3])
        before = bench.state[anchor.ZERO]
        await bench.ticks(ticks[3:])
        learned.append(bench.state[anchor.ZERO] != before)
    assert learned == [place < 2 for place in range(formats.REST_W)]


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def each_place_of_strange(dut: object) -> None:
    """A c that wants to be a quarter of it beyond its limit is fine, five quarters are a fault."""
    bench = AnchorBench(dut, random_source("strange"))
    await bench.power_up()
    limit, most = 1 << anchor.FREE_SHIFT, COEF.raw_max
    words = motor_settings()
    for place in (*GAINS, *MOST):
        if place not in (anchor.FLUX_GAIN, anchor.OWED_GAIN, anchor.CELLS_GAIN):
            words[place] = 0
    words[anchor.FOLLOW_TICKS] = 1

    async def touch(gain: int, reach: int, strange: int) -> None:
        words[anchor.PULL_GAIN], words[anchor.REACH], words[anchor.STRANGE] = gain, reach, strange
        await bench.begin(words)
        await bench.ticks([Tick(), Tick(contact=1), *[Tick(3, contact=1)] * (anchor.EXCUSED + 5)])

    gain = 1 << 20
    await touch(gain, MOST[anchor.REACH], 0)
    unlimited = abs(bench.correction)
    assert unlimited > 1 << 16
    assert not bench.word("fault_o")
    tried = 0
    for place in range(0, formats.DATA_W - 1, 4 if "Icarus" in cocotb.SIM_NAME else 1):
        for quarters in (1, 5):
            beyond = (quarters << place) // 4
            wanted = round(gain * (limit + beyond) / unlimited)
            if 16 * unlimited > beyond * gain or not 0 < wanted <= most:
                continue  # the gain's steps are too coarse, or it ends
            await touch(wanted, limit, 1 << place)
            assert bool(bench.word("fault_o")) == (quarters == 5)
            tried += 1
    assert tried > 8


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_reset_at_any_clock(dut: object) -> None:
    """After a reset of any length it is as after power-up, also if its products still come."""
    rng = random_source("reset")
    bench = AnchorBench(dut, rng)
    await bench.power_up()
    for clocks in (1, 3) if "Icarus" in cocotb.SIM_NAME else (1, 2, 3, 4, 7):
        for clock in range(STEP_CLOCKS + 4):
            for products in (False, True):
                settings = random_settings(rng)
                ticks = random_ticks(rng, 4)
                await bench.begin(settings)
                for tick in ticks[: rng.randint(0, 2)]:
                    await bench.tick(tick)
                bench.give(ticks[2])
                await bench.take()
                for _ in range(clock):
                    await bench.step(other_i=rng.random() < rng.choice((0.0, 0.5)))
                if rng.random() < 0.5:
                    settings = random_settings(rng)
                await bench.begin(settings, clocks, products=products)
                for tick in ticks[2:]:
                    await bench.tick(tick)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def waves_while_busy(dut: object) -> None:
    """They are reported and otherwise ignored at every clock."""
    rng = random_source("busy")
    bench = AnchorBench(dut, rng)
    await bench.power_up()
    for clock in range(1, STEP_CLOCKS):
        await bench.begin(random_settings(rng))
        await bench.tick(random_ticks(rng, 1)[0])
        assert not bench.word("overrun_o")
        await bench.tick(random_ticks(rng, 1)[0], poke=clock)
        assert bench.word("overrun_o")
        await bench.tick(random_ticks(rng, 1)[0])
        assert bench.word("overrun_o")
