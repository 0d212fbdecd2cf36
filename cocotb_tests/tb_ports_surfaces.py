# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_ports.v`` with surfaces across its ports: each period equals the models.

Currents and positions of a period are taken as the design tells them. Waves, voltages and
corrections of all ports follow from the models of wave core, surfaces, walls and anchor, which
:mod:`wavehaptics.ladder.joint` has in the same order. Settings, walls, frames, currents and edges
are random.
"""

from __future__ import annotations

import random

import cocotb
import numpy as np
import tb_ports
from bench import random_source, unpack
from cocotb.task import Task
from cocotb.triggers import FallingEdge, RisingEdge, with_timeout
from simulators import parameters
from tb_ports import LAST_SLOT, N, Port, PortsBench, joined
from tb_surface_station import Words, clocks_of
from wavehaptics.controller import anchor, surfaces, wave_core
from wavehaptics.controller.planes import as_registers
from wavehaptics.words import formats

SURFACES = parameters()["SURFACES"]
ETA_ONE = 1 << formats.ETA.fraction
VOLTAGE, U, V, CURRENT, POSITION, CORRECTION = 0, 1, 2, 3, 4, 8
"""Places of live values."""

FIRST_PASS = 32 * (N - 1) + 38
LONGEST = max(clocks_of(2, True), clocks_of(3, False)) if SURFACES > 1 else clocks_of(1, True)
tb_ports.EDGES = FIRST_PASS + LONGEST + LAST_SLOT + 50
tb_ports.ILLEGAL = 0.0


class Model:
    """The ports, their anchors and the group of surfaces."""

    def __init__(self, ports: list[Port], extra: int, hold: int, budget: int) -> None:
        self.ports, self.extra, self.hold = ports, extra, hold
        self.cores = [wave_core.new_state() for _ in ports]
        self.lines = [wave_core.new_line(3) for _ in ports]
        self.contacts = np.array([[-1, 0]] * N, dtype=np.int64)
        self.anchors = [anchor.new_state() for _ in ports]
        self.before = [0] * N
        self.state, self.spent = surfaces.new_state(), np.zeros(1, dtype=np.int64)
        self.active = np.zeros(surfaces.MOST_ACTIVE, dtype=np.int64)
        self.limits = np.array([0, budget], dtype=np.int64)
        self.words = Words()
        self.acting, self.faulty = 0, False

    def step(self, positions: np.ndarray, currents: np.ndarray) -> list[dict[int, int]]:
        """One period: the live values of each port."""
        seen: list[dict[int, int]] = []
        walled, waves = [], np.zeros(3, dtype=np.int64)
        for n, port in enumerate(self.ports):
            edges = np.array([wall[:2] for wall in port.walls if wall[2]] or [(0, 0)])
            inside, _ = wave_core.contact_step(
                self.contacts[n], int(positions[n]), edges[:, 0], edges[:, 1],
                bool(port.hysteresis),
            )  # fmt: skip
            walled.append(bool(inside))
            u, v = wave_core.incoming(
                self.cores[n], self.lines[n], int(currents[n]), port.root, self.extra, 0
            )
            waves[n] = v
            if inside:
                waves[n] = wave_core.saturate(
                    wave_core.truncate(port.etas[0] * v, formats.ETA.fraction)
                )
            seen.append({U: u, V: v})
        self.faulty = any(
            port.anchor[anchor.ENABLE] and held[anchor.FAULT]
            for port, held in zip(self.ports, self.anchors, strict=True)
        )
        self.acting, self.clocks = 0, 0
        if not self.faulty:
            free = min(port.etas[1] for port in self.ports)
            self.acting = surfaces.surfaces_step(
                self.state, self.spent, self.active, self.words.planes, self.words.vectors,
                self.limits, positions, currents, free, waves,
            )  # fmt: skip
            if self.acting == 1:
                free = min(free, self.words.planes[self.active[0], surfaces.ACROSS])
            self.clocks = clocks_of(self.acting, free < ETA_ONE)
        for n, port in enumerate(self.ports):
            core, held = self.cores[n], self.anchors[n]
            eta, outside = port.etas[0] if walled[n] else port.etas[1], 0
            if self.faulty:
                eta = 0
            elif self.acting:
                eta, outside = 0, int(waves[n])
            withheld, saturated = core[wave_core.STATE_WITHHELD], core[wave_core.STATE_SATURATED]
            anchored = bool(port.anchor[anchor.ENABLE])
            u, v = seen[n][U], seen[n][V]
            e = wave_core.outgoing(
                core, self.lines[n], v, eta, outside, port.root, port.a,
                anchor.left(port.u_max, held) if anchored else port.u_max, self.hold,
            )  # fmt: skip
            correction = held[anchor.CORRECTION] if anchored else 0
            if anchored:
                anchor.anchor_step(
                    held, port.anchor, int(positions[n]), walled[n] or self.acting > 0,
                    int(currents[n]), u, v, withheld, self.before[n], bool(saturated),
                    bool(core[wave_core.STATE_CLIPPED]),
                )  # fmt: skip
            self.before[n] = e
            seen[n] |= {VOLTAGE: wave_core.saturate(e + correction), CORRECTION: int(correction)}
        return seen


class SurfacesBench(PortsBench):
    """Periods, each compared whole."""

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut, rng)
        self.frame: Words | None = None
        self.writer: Task[None] | None = None
        self.is_written = False
        self.acted = dict.fromkeys(range(4), 0)
        self.walled = self.lost = self.corrected = self.frames = 0

    async def board(self) -> None:
        await super().board()
        self.extra, self.hold = self.rng.randrange(4), self.rng.choice((0, 0, 1, 2))
        self.drive(
            sense_i=joined((0xFFFF, 16), (0xFFFF, 16), (0, 16), (0x7FFFFF, 23)),
            delay_i=joined((self.extra, 2), (self.hold, 2)), guard_i=0,
        )  # fmt: skip

    def random_ports(self) -> list[Port]:
        ports = super().random_ports()
        lively = self.rng.random() < 0.6
        for port in ports:
            port.anchor[anchor.ENABLE] &= lively
            port.a = max(port.a, 1)
            port.walls = [
                (low, high, enable and self.rng.random() < 0.5, 0)
                for low, high, enable, _ in port.walls
            ]
            port.__post_init__()
        return ports

    def commit(self, ports: list[Port]) -> None:
        self.bank ^= 1
        budget = self.rng.choice((0, 1 << 40, surfaces.ACCOUNT_MAX))
        self.drive(force_i=self.bank, budget_i=budget)
        self.model = Model(ports, self.extra, self.hold, budget)
        self.waiting, self.written = None, False

    async def write_frame(self) -> None:
        words = Words.random(self.rng)
        for plane in words.planes[:SURFACES]:
            plane[surfaces.D] = self.rng.randint(-700, 500)
            plane[surfaces.PRESENT] = self.rng.random() < 0.85
        words.planes[4:, surfaces.PRESENT] = 0
        self.frame, self.is_written = words, False
        falling = FallingEdge(self.dut.clk)
        for address, word in as_registers(words.planes, words.vectors, words.most, SURFACES):
            self.drive(surface_write_i=1, surface_address_i=address, data_i=word)
            await falling
            self.drive(surface_write_i=0)
            while self.word("surface_busy_o"):
                await falling
        self.is_written = True

    def forget_frame(self) -> None:
        """Stop writing: with an anchor that is lost no frame is taken, and the next one waits."""
        if self.writer is not None:
            self.writer.cancel()
        self.drive(surface_write_i=0)
        self.writer = self.frame = self.model_words = None

    def live(self, port: int, word: int) -> int:
        return self.words_now[16 * port + word]

    def compare(self) -> None:
        self.words_now = unpack(self.word("live_o"), 32, 16 * N)
        assert not self.word("faults_o"), f"{self.word('faults_o'):06x}, period {self.periods}"
        assert self.word("running_o")
        assert not self.word("met_o")
        steps = self.word("steps_o")
        if steps == self.steps:
            assert self.periods == 0, "a period without a step"
            return
        assert steps == self.steps + N
        self.steps = steps
        self.periods += 1
        positions, currents = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
        for n in range(N):
            positions[n], currents[n] = self.live(n, POSITION), self.live(n, CURRENT)
        wanted = self.model.step(positions, currents)
        assert self.word("acting_o") == self.model.acting or self.model.faulty
        for n, words in enumerate(wanted):
            found = {word: self.live(n, word) for word in words}
            assert found == words, f"port {n}, period {self.periods}, {self.model.acting} act"
        # The last slot of the first pass, or what begins in its clock 17, ends the pass.
        clocks = 32 * (N - 1) + max(38, 18 + self.model.clocks)
        assert self.word("pass_clocks_o") == clocks, self.model.acting
        self.acted[self.model.acting] += 1
        self.walled += bool((self.model.contacts[:, 0] >= 0).any())
        self.lost += self.model.faulty
        self.corrected += any(words[CORRECTION] for words in wanted)

    async def period(self) -> None:
        await self.step()
        await with_timeout(RisingEdge(self.dut.round_o), 100, "us")
        await FallingEdge(self.dut.clk)
        await self.step(tb_ports.EDGES)
        self.move()
        if self.frame is None and self.rng.random() < 0.1:
            self.writer = cocotb.start_soon(self.write_frame())
        elif self.frame is not None and self.is_written:
            await self.step(surface_commit_i=1)
            self.drive(surface_commit_i=0)
            assert not self.word("surface_refused_o")
            self.model_words, self.frame = self.frame, None
            self.frames += 1
        else:
            self.model_words = None
        await self.tick()
        self.compare()
        if self.model_words is not None:
            self.model.words = self.model_words
            self.model.limits[surfaces.VELOCITY_MAX] = self.model_words.most
            self.model_words = None


@cocotb.test(timeout_time=10, timeout_unit="sec")
async def equals_the_models(dut: object) -> None:
    """Waves, voltages and corrections of every port in every period."""
    rng = random_source("ports in space")
    bench = SurfacesBench(dut, rng)
    await bench.power_up()
    runs, periods = (5, 40) if "Icarus" in cocotb.SIM_NAME else (12, 50)
    total = 0
    for _ in range(runs):
        bench.forget_frame()
        bench.steps = bench.periods = 0
        await bench.begin()
        bench.drive(enable_i=1)
        await bench.tick()
        for _ in range(periods):
            await bench.period()
        assert bench.periods > 0.9 * periods
        total += bench.periods
    cocotb.log.info(
        "%d periods, %s act, %d with walls, %d lost, %d corrected, %d frames", total, bench.acted,
        bench.walled, bench.lost, bench.corrected, bench.frames,
    )  # fmt: skip
    assert bench.acted[0] > total // 50
    assert bench.acted[min(SURFACES, 3)] > total // 50
    assert bench.frames
    if runs > 2:
        assert bench.walled > total // 50
        assert bench.lost > total // 50
        assert bench.corrected > total // 50
