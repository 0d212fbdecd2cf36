# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_axes.v``: every step is the integers of two ports, and of their anchors.

Contact, the wall's kind, words of W, currents and pauses are random, and so are the anchors' words
and the rotor's way; each port has its own states. The rotor's flux is its model's, turned as the
axes ask for.
"""

from __future__ import annotations

import os
import random

import cocotb
import numpy as np
from bench import Bench, pack, random_source, unpack
from simulators import parameters
from tb_anchor import motor_settings, random_settings

os.environ["NUMBA_DISABLE_JIT"] = "1"  # compiling would take longer than it saves

from wavehaptics.controller import anchor, magnet_angle, rotor_flux, wave_core
from wavehaptics.controller.normalised import losses, quantise, realise
from wavehaptics.controller.pins_timing import CORE_CLOCKS, SECTION_CLOCKS
from wavehaptics.laws.reflection import Wish, reflection
from wavehaptics.words import formats, table
from wavehaptics.words.table import AXES, Sizes

SHAPER = parameters().get("SHAPER", 0)
ANCHOR = parameters().get("ANCHOR", 0)
STEP_CLOCKS = AXES * (CORE_CLOCKS + SECTION_CLOCKS * SHAPER)
CORE_GOAL_CLOCKS = 5
GOAL_CLOCKS = [
    n * STEP_CLOCKS // AXES + CORE_GOAL_CLOCKS + SECTION_CLOCKS * SHAPER for n in range(AXES)
]
"""Clocks of a step in which η is read."""
OTHERS = 5
"""Products of others while a step goes on: the legs' of the one before."""
EXTRA, HOLD = 2, 1
ROOT = formats.ROOT.to_raw(3.066)
A = formats.A.to_raw(0.99)
FRONT, B_R = 1.117, 2.28e-4
"""A gimbal's motor, N·m/rad and N·m·s/rad."""
SINES = rotor_flux.sine_table()
PLACE_W = formats.LONG.width - rotor_flux.SHIFT
CELL_W = rotor_flux.SINE_Q + 2
COUNT_ANGLE = rotor_flux.angle_word(1.0 / 90.0)


def any_words(rng: random.Random) -> np.ndarray:
    """Words of SHAPER sections: a soft wall's, or whatever fits."""
    sections = []
    for _ in range(SHAPER):
        if rng.random() < 0.7:
            wish = Wish(0.0, rng.uniform(0.0, 1e-3), rng.uniform(0.05, 2.0), FRONT)
            sections.append(quantise(realise(*reflection(wish, B_R), rng.choice((1e-6, 1e-4)))))
            continue
        words = [rng.randint(formats.SHAPE.raw_min, formats.SHAPE.raw_max) for _ in range(9)]
        most = (1 << formats.SHAPE_LOSS_W) - 1
        sections.append(np.array([*words, *(min(loss, most) for loss in losses(words))]))
    return np.array(sections, dtype=np.int64).reshape(SHAPER, wave_core.SECTION_WORDS)


def port_of(words: np.ndarray) -> int:
    """Words of W as the port takes them."""
    values = {
        "shape_coefficient": words[:, : wave_core.LOSS1].ravel().tolist(),
        "shape_loss": words[:, wave_core.LOSS1 :].ravel().tolist(),
    }
    return table.inputs(values if SHAPER else {}, Sizes(1, 4, SHAPER))["shape_words_i"]


class AxesBench(Bench):
    """Gives both ports a step at a time, and compares all that comes out."""

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut)
        self.rng = rng
        self.seen: set[str] = set()

    async def begin(self, u_max: int, gains: np.ndarray | None = None, find: bool = False) -> None:
        """Reset; ``gains`` are the anchors' words, ``find`` says that the magnets aren't known."""
        self.u_max = u_max
        self.gains = np.zeros(anchor.SETTINGS, dtype=np.int64) if gains is None else gains
        self.rotor = rotor_flux.new_state(0, rotor_flux.angle_word(0.1))
        self.magnet = magnet_angle.new_state(not find, 0)
        self._forget()
        await self.start(
            damp_i=0, start_i=0, current_i=0, ends_i=0, eta_i=0, root_i=ROOT, a_i=A, u_max_i=u_max,
            extra_ticks_i=EXTRA, hold_ticks_i=HOLD, shape_words_i=0, shaped_i=0, position_i=0,
            place_i=0, cell_i=0, contact_i=0, anchor_words_i=anchor.packed(self.gains),
            angle_rst_i=1, find_magnet_i=find, count_angle_i=COUNT_ANGLE, turned_i=0, other_i=0,
        )  # fmt: skip
        self.drive(angle_rst_i=0)
        assert self.word("magnet_found_o") == self.known

    def _forget(self) -> None:
        """All but the magnets."""
        self.ports = [wave_core.new_state() for _ in range(AXES)]
        self.lines = [wave_core.new_line(EXTRA) for _ in range(AXES)]
        self.states = [wave_core.new_shaper_state(SHAPER) for _ in range(AXES)]
        self.anchors = [anchor.new_state() for _ in range(AXES)]
        self.waves = [0] * AXES
        """e_id of the step before."""

    async def stop(self) -> None:
        """A reset that isn't the magnets'."""
        self._forget()
        await self.step(rst=1)
        self.drive(rst=0)
        assert self.word("magnet_found_o") == self.known

    @property
    def known(self) -> bool:
        """Whether the anchors have a say."""
        return ANCHOR == 1 and self.magnet[magnet_angle.KNOWN] != 0

    def words(self, name: str) -> list[int]:
        """An output's words of both ports."""
        return unpack(self.word(f"{name}_o"), formats.DATA_W, AXES)

    def _move(self, moved: int, still: bool) -> None:
        """The rotor goes on by some counts; ``still``: nothing of its flux is seen to change."""
        places = self.rotor[rotor_flux.PLACE_A : rotor_flux.PLACE_B + 1].copy()
        position = int(self.rotor[rotor_flux.POSITION]) + moved
        rotor_flux.rotor_flux_step(self.rotor, COUNT_ANGLE, SINES, position)
        if still:
            self.rotor[rotor_flux.PLACE_A : rotor_flux.PLACE_B + 1] = places

    def _rotor(self, first: int, width: int) -> int:
        """Words of both axes from a place in the rotor's state on."""
        return pack((int(self.rotor[first + n]) >> rotor_flux.SHIFT for n in range(AXES)), width)

    async def tick(
        self, currents: list[int], eta: int, contact: int, shaped: int, words: np.ndarray,
        damp: int = 0, moved: int = 0, still: bool = False, others: int = 0,
    ) -> None:  # fmt: skip
        """A step of both ports and their anchors, checked, with the rotor some counts farther.

        In so many clocks at most ``others`` have the multiplier.
        """
        self._move(moved, still)
        rotor = {
            "position_i": int(self.rotor[rotor_flux.POSITION]),
            "place_i": self._rotor(rotor_flux.PLACE_A, PLACE_W),
            "cell_i": self._rotor(rotor_flux.CELL_A, CELL_W),
            "current_i": pack(currents, formats.DATA_W),
            "ends_i": (ends := self.rng.choice((0, 0, 0, 0, self.rng.getrandbits(4)))),
        }
        # What says the mode may still be another in a step's first clock; currents and rotor are
        # others in all that follow.
        self.drive(
            start_i=1, shape_words_i=port_of(words), contact_i=1 - contact, shaped_i=1 - shaped,
            eta_i=eta, damp_i=damp, **rotor,
        )  # fmt: skip
        await self.step()
        self.drive(
            start_i=0, contact_i=contact, shaped_i=shaped,
            **{name: ~word for name, word in rotor.items()},
        )  # fmt: skip
        lost = []
        for clock in range(1, STEP_CLOCKS):
            assert self.word("busy_o")
            assert not self.word("valid_o")
            if clock in GOAL_CLOCKS:
                lost.append(self.word("anchor_fault_o"))
            others = self._crowd(others)
            await self.step()
        assert self.word("valid_o")
        mode = wave_core.SHAPE if contact and shaped else int(contact)
        assert mode == wave_core.shaper_mode(0 if contact else -1, np.array([bool(shaped)]))
        gives = [held.copy() for held in self.anchors]
        """What the anchors left from the step before."""
        if damp:
            for held in self.anchors:
                anchor.reset(held)
        assert lost[0] == any(held[anchor.FAULT] for held in self.anchors)
        gains = self.gains.copy()
        gains[anchor.ENABLE] &= self.known
        found = [self.words(name) for name in ("voltage", "u", "v", "current", "correction")]
        for n, held in enumerate(self.anchors):
            port = self.ports[n]
            withheld, saturated = port[wave_core.STATE_WITHHELD], port[wave_core.STATE_SATURATED]
            current = wave_core.saturate(currents[n] - int(gives[n][anchor.OFFSET]))
            correction = int(held[anchor.CORRECTION])
            e, u, v = wave_core.shaped_core_step(
                port, self.lines[n], words, self.states[n], mode, current,
                0 if damp or lost[n] else eta, 0, ROOT, A, anchor.left(self.u_max, gives[n]),
                EXTRA, HOLD, ends >> 2 * n & 3,
            )  # fmt: skip
            wanted = (wave_core.saturate(e + correction), u, v, current, correction)
            assert tuple(outputs[n] for outputs in found) == wanted, (n, mode)
            assert self.word("saturated_o") >> n & 1 == port[wave_core.STATE_SATURATED]
            clipped = bool(port[wave_core.STATE_CLIPPED])
            assert self.word("clipped_o") >> n & 1 == clipped
            self.seen |= {f"clipped {n}"} if clipped else set()
            if ANCHOR and not damp:
                anchor.anchor_axis_step(
                    held, gains, int(self.rotor[rotor_flux.POSITION]),
                    int(self.rotor[rotor_flux.PLACE_A + n]), int(self.rotor[rotor_flux.CELL_A + n]),
                    bool(contact), current, u, v, withheld, self.waves[n], bool(saturated),
                    clipped,
                )  # fmt: skip
            self.waves[n] = e
            self._note(n)
            # What the anchor of alpha finds acts on beta's goal as soon as it is there.
            assert n or lost[1] <= (lost[0] or held[anchor.FAULT])
        if ANCHOR:
            await self._magnets(contact, others)
        self.check()

    def _crowd(self, others: int) -> int:
        """Whether the multiplier is another's in this clock; how often it may still be."""
        takes = others > 0 and self.rng.random() < 0.3
        self.drive(other_i=takes)
        return others - takes

    async def _magnets(self, contact: int, others: int) -> None:
        """The anchors come to an end, and the angle is turned as far as the magnets' model says."""
        before = self.known
        by = magnet_angle.magnet_angle_step(
            self.magnet, COUNT_ANGLE, int(self.gains[anchor.SLOW_TICKS]),
            int(self.rotor[rotor_flux.POSITION]), bool(contact),
            int(self.rotor[rotor_flux.CELL_A]), int(self.rotor[rotor_flux.CELL_B]),
            *(int(held[anchor.CHI]) >> formats.LONG_GUARD for held in self.anchors),
        )  # fmt: skip
        turned = 0
        for _ in range(400):
            if not self.word("anchor_busy_o"):
                break
            turns = self.word("turn_o") and self.rng.random() < 0.5
            if turns:
                assert self.word("by_o") == by
                rotor_flux.turn_by(self.rotor, by)
                turned += 1
                self.seen |= {"turned"} if by else set()
            others = self._crowd(others)
            self.drive(turned_i=turns)
            await self.step()
        self.drive(other_i=0, turned_i=0)
        assert not self.word("anchor_busy_o"), "the anchors don't come to an end"
        assert turned <= 1
        assert turned or by == 0
        if self.known and not before:
            self.seen.add("found")
            for held in self.anchors:
                anchor.reset(held)

    def check(self) -> None:
        """What is there between two steps."""
        for name, place, shift in (
            ("next", anchor.CORRECTION, 0), ("offset", anchor.OFFSET, 0),
            ("flux", anchor.CHI, formats.LONG_GUARD), ("lag", anchor.LAG, formats.LONG_GUARD),
        ):  # fmt: skip
            assert self.words(name) == [int(held[place]) >> shift for held in self.anchors], name
        assert self.word("anchor_fault_o") == any(held[anchor.FAULT] for held in self.anchors)
        assert self.word("magnet_found_o") == self.known
        assert not self.word("anchor_busy_o")
        assert not self.word("turn_o")
        assert not self.word("overrun_o")

    def _note(self, axis: int) -> None:
        """What an anchor does."""
        places = {
            "correction": anchor.CORRECTION, "offset": anchor.OFFSET, "room": anchor.ROOM,
            "fault": anchor.FAULT,
        }  # fmt: skip
        self.seen |= {
            f"{name} {axis}" for name, place in places.items() if self.anchors[axis][place]
        }


def any_gains(rng: random.Random) -> np.ndarray:
    """Any words of the anchors, or a motor's, which never takes what it sees for another's."""
    if rng.random() < 0.5:
        return random_settings(rng)
    gains = motor_settings()
    gains[anchor.STRANGE] = formats.VOLTAGE.raw_max
    return gains


EVERYTHING = {
    f"{name} {axis}"
    for name in ("correction", "offset", "room", "fault", "clipped")
    for axis in range(AXES)
}


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def equals_the_integers_of_two_ports(dut: object) -> None:
    """Every word of every step, through walls that are soft, rigid and none."""
    rng = random_source("axes")
    bench = AxesBench(dut, rng)
    modes, apart, limited = set(), 0, 0
    runs = 4 if "Icarus" in cocotb.SIM_NAME else 20
    for run in range(runs):
        u_max = formats.WAVE.to_raw((2.0, 100.0)[run % 2])
        await bench.begin(u_max, any_gains(rng) if ANCHOR else None)
        words = any_words(rng)
        contact = shaped = 0
        size = formats.CURRENT.to_raw((20.0, 20.0, 1.0, 0.2)[run % 4])
        eta = -(1 << formats.ETA.fraction)
        for _ in range(150):
            if rng.random() < 0.05:
                contact, shaped = rng.choice(((0, 0), (0, 1), (1, 0), (1, 1), (1, 1)))
                eta = rng.choice((-1, 1)) * (1 << formats.ETA.fraction)
            if rng.random() < 0.02:
                words = any_words(rng)
            currents = [rng.randint(-size, size) for _ in range(AXES)]
            await bench.tick(
                currents, eta, contact, shaped, words, int(rng.random() < 0.05),
                rng.choice((0, 0, 0, 0, 1, 1, -1, 3)), others=rng.choice((0, OTHERS)),
            )  # fmt: skip
            modes.add((contact, shaped))
            apart += not np.array_equal(*bench.states)
            limited += bench.word("saturated_o") != 0
            if rng.random() < 0.2:
                await bench.step(rng.randint(1, 9))
    assert modes == {(0, 0), (0, 1), (1, 0), (1, 1)}
    assert limited > 5
    assert (apart > 100) == (SHAPER > 0)
    assert not ANCHOR or runs < 20 or bench.seen >= EVERYTHING, EVERYTHING - bench.seen


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def the_next_step_comes_too_early(dut: object) -> None:
    """While the core or an anchor works a start is told, until the reset; behind them it isn't."""
    rng = random_source("early")
    bench = AxesBench(dut, rng)
    told = 0
    for clock in range(1, STEP_CLOCKS + 40, 1 + (SHAPER > 0)):
        await bench.begin(formats.WAVE.to_raw(100.0))
        await bench.step(start_i=1)
        await bench.step(clock - 1, start_i=0)
        early = bench.word("busy_o") or bench.word("anchor_busy_o")
        assert early or clock >= STEP_CLOCKS
        await bench.step(start_i=1)
        await bench.step(start_i=0)
        assert bench.word("overrun_o") == early, clock
        await bench.step(200)
        assert bench.word("overrun_o") == early, clock
        await bench.stop()
        assert not bench.word("overrun_o")
        told += early
    assert told >= STEP_CLOCKS // 2


if ANCHOR:

    @cocotb.test(timeout_time=20, timeout_unit="ms")
    async def the_magnets_are_found(dut: object) -> None:
        """The angle is turned by what the anchors see, who have no say until it is found.

        It stays found through a reset that isn't its own.
        """
        rng = random_source("magnets")
        bench = AxesBench(dut, rng)
        words = any_words(rng)
        gains = motor_settings()
        gains[anchor.SLOW_TICKS] = 100
        largest = formats.CURRENT.to_raw(0.05)

        async def ticks(number: int, way: int, still: bool, largest: int) -> None:
            for _ in range(number):
                currents = [rng.randint(-largest, largest) for _ in range(AXES)]
                moved = way * rng.choice((0, 1, 1))
                await bench.tick(currents, 0, 0, 0, words, moved=moved, still=still)

        for way in (1, -1):
            await bench.begin(formats.WAVE.to_raw(100.0), gains, find=True)
            await ticks(40, way, False, largest)
            assert "turned" in bench.seen
            assert not bench.known
            assert not bench.seen & {"correction 0", "correction 1"}
            # The waves and the encoder say the same: it is right.
            for _ in range(400):
                if bench.known:
                    break
                await ticks(1, way, True, 0)
            assert bench.known
            await ticks(40, way, False, largest)
            assert bench.seen >= {"correction 0", "correction 1"}
            await bench.stop()
            await ticks(10, way, False, largest)
            bench.seen.clear()


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_pause_keeps_each_port_its_states(dut: object) -> None:
    """Rigid in between: the states of both stand still; out of contact they are gone."""
    if not SHAPER:
        return
    rng = random_source("pause")
    bench = AxesBench(dut, rng)
    await bench.begin(formats.WAVE.to_raw(100.0))
    wish = Wish(0.0, 1e-4, 0.3, FRONT)
    words = np.stack([quantise(realise(*reflection(wish, B_R), 1e-4))] * SHAPER)
    eta = -(1 << formats.ETA.fraction)
    largest = formats.CURRENT.to_raw(0.5)

    async def ticks(number: int, contact: int, shaped: int) -> None:
        for _ in range(number):
            currents = [rng.randint(0, largest), rng.randint(-largest, 0)]
            await bench.tick(currents, eta, contact, shaped, words)

    await ticks(20, 1, 1)
    kept = [states.copy() for states in bench.states]
    assert all(states.any() for states in kept)
    await ticks(20, 1, 0)
    assert all(np.array_equal(*pair) for pair in zip(kept, bench.states, strict=True))
    await ticks(20, 1, 1)
    await ticks(2, 0, 1)
    assert not any(states[:SHAPER].any() for states in bench.states)  # their budgets stay
    await ticks(20, 1, 1)
