# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_axes.v`` with W and without anchors: every step is the integers of two ports.

Contact, the wall's kind, words of W, currents and pauses are random; each port has its own states.
"""

from __future__ import annotations

import os
import random

import cocotb
import numpy as np
from bench import Bench, pack, random_source, unpack
from simulators import parameters

os.environ["NUMBA_DISABLE_JIT"] = "1"  # compiling would take longer than it saves

from wavehaptics.controller import wave_core
from wavehaptics.controller.normalised import losses, quantise, realise
from wavehaptics.controller.pins_timing import CORE_CLOCKS, SECTION_CLOCKS
from wavehaptics.laws.reflection import Wish, reflection
from wavehaptics.words import formats, table
from wavehaptics.words.table import AXES, Sizes

SHAPER = parameters().get("SHAPER", 0)
STEP_CLOCKS = AXES * (CORE_CLOCKS + SECTION_CLOCKS * SHAPER)
EXTRA, HOLD = 2, 1
ROOT = formats.ROOT.to_raw(3.066)
A = formats.A.to_raw(0.99)
FRONT, B_R = 1.117, 2.28e-4
"""A gimbal's motor, N·m/rad and N·m·s/rad."""


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

    async def begin(self, u_max: int) -> None:
        self.u_max = u_max
        self.ports = [wave_core.new_state() for _ in range(AXES)]
        self.lines = [wave_core.new_line(EXTRA) for _ in range(AXES)]
        self.states = [wave_core.new_shaper_state(SHAPER) for _ in range(AXES)]
        await self.start(
            damp_i=0, start_i=0, current_i=0, eta_i=0, root_i=ROOT, a_i=A, u_max_i=u_max,
            extra_ticks_i=EXTRA, hold_ticks_i=HOLD, shape_words_i=0, shaped_i=0, position_i=0,
            place_i=0, cell_i=0, contact_i=0, anchor_words_i=0, angle_rst_i=0, find_magnet_i=0,
            count_angle_i=0, turned_i=0, grant_i=0, done_i=0, product_i=0,
        )  # fmt: skip

    async def tick(
        self, currents: list[int], eta: int, contact: int, shaped: int, words: np.ndarray,
        damp: int = 0,
    ) -> None:  # fmt: skip
        """A step of both ports, checked."""
        # What says the mode may still be another in a step's first clock.
        self.drive(
            start_i=1, current_i=pack(currents, formats.DATA_W), shape_words_i=port_of(words),
            contact_i=1 - contact, shaped_i=1 - shaped, eta_i=eta, damp_i=damp,
        )  # fmt: skip
        await self.step()
        self.drive(start_i=0, contact_i=contact, shaped_i=shaped)
        for _ in range(STEP_CLOCKS - 1):
            assert self.word("busy_o")
            assert not self.word("valid_o")
            await self.step()
        assert self.word("valid_o")
        mode = wave_core.SHAPE if contact and shaped else int(contact)
        assert mode == wave_core.shaper_mode(0 if contact else -1, np.array([bool(shaped)]))
        found = [
            unpack(self.word(f"{name}_o"), formats.DATA_W, AXES) for name in ("voltage", "u", "v")
        ]
        for n in range(AXES):
            wanted = wave_core.shaped_core_step(
                self.ports[n], self.lines[n], words, self.states[n], mode, currents[n],
                0 if damp else eta, 0, ROOT, A, self.u_max, EXTRA, HOLD,
            )  # fmt: skip
            assert tuple(outputs[n] for outputs in found) == wanted, (n, mode)
            saturated = self.ports[n][wave_core.STATE_SATURATED]
            assert self.word("saturated_o") >> n & 1 == saturated
        assert unpack(self.word("current_o"), formats.DATA_W, AXES) == currents
        assert not self.word("overrun_o")


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def equals_the_integers_of_two_ports(dut: object) -> None:
    """Every word of every step, through walls that are soft, rigid and none."""
    rng = random_source("axes")
    bench = AxesBench(dut)
    modes, apart, limited = set(), 0, 0
    for _ in range(4 if "Icarus" in cocotb.SIM_NAME else 20):
        await bench.begin(formats.WAVE.to_raw(rng.choice((2.0, 100.0))))
        words = any_words(rng)
        contact = shaped = 0
        size = formats.CURRENT.to_raw(rng.choice((0.2, 1.0, 20.0)))
        eta = -(1 << formats.ETA.fraction)
        for _ in range(150):
            if rng.random() < 0.05:
                contact, shaped = rng.choice(((0, 0), (0, 1), (1, 0), (1, 1), (1, 1)))
                eta = rng.choice((-1, 1)) * (1 << formats.ETA.fraction)
            if rng.random() < 0.02:
                words = any_words(rng)
            currents = [rng.randint(-size, size) for _ in range(AXES)]
            await bench.tick(currents, eta, contact, shaped, words, int(rng.random() < 0.05))
            modes.add((contact, shaped))
            apart += not np.array_equal(*bench.states)
            limited += bench.word("saturated_o") != 0
            if rng.random() < 0.2:
                await bench.step(rng.randint(1, 9))
    assert modes == {(0, 0), (0, 1), (1, 0), (1, 1)}
    assert limited > 5
    assert (apart > 100) == (SHAPER > 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def a_pause_keeps_each_port_its_states(dut: object) -> None:
    """Rigid in between: the states of both stand still; out of contact they are gone."""
    if not SHAPER:
        return
    rng = random_source("pause")
    bench = AxesBench(dut)
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
    assert not any(states.any() for states in bench.states)
    await ticks(20, 1, 1)
