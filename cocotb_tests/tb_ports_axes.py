# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_ports.v`` with brushless motors: two ports equal the integers, word for word.

As :mod:`tb_ports`, with random settings, faults, commits and resets. What the anchors have found of
the magnets goes on where the bridges go off; a period in which they do has no values to compare.
"""

from __future__ import annotations

import os

import cocotb
import numpy as np
from bench import pack, random_source, unpack
from cocotb.triggers import FallingEdge
from simulators import parameters

os.environ["NUMBA_DISABLE_JIT"] = "1"  # compiling would take longer than it saves

import tb_ports
from axes_model import BrushlessMotor, Drive, Legs, Settings, Step
from lost_encoder import LostEncoder
from tb_guard import CALM, warmer
from tb_ports import AXES, FRAME_CLOCKS, LAST_SLOT, MID, OVERRUN, N, Port, PortsBench, joined
from wavehaptics.controller import anchor, clarke, guard
from wavehaptics.controller.guard import Fault
from wavehaptics.controller.pins_timing import HOLD_CLOCKS, turns_latency_clocks
from wavehaptics.words import formats
from wavehaptics.words.table import AXES as TWO

SHAPER = parameters().get("SHAPER", 0)
MIN_PULSE = parameters().get("MIN_PULSE", 0)
ALPHAS = [n for n in range(N) if AXES >> n & 1]
TRACE = 1024
FRAMES = 4
"""Codes that the bench keeps of each line."""
SHIFT = formats.SAMPLE_W - 12
VOLTAGE, U, V, CURRENT, POSITION, FLAGS, _, _, CORRECTION, OFFSET, FLUX, LAG = range(12)
LIVE = 16
CONTACT, CLIPPED = 0, 8
EVERY_FAULT = 0x00FFFF & ~(OVERRUN | 1 << Fault.SETTING | 1 << Fault.ZERO)
"""No period is too short, every setting has a meaning, and an axis has no energies."""
tb_ports.ILLEGAL = 0.0


def signed(word: int) -> int:
    return unpack(word, formats.DATA_W, 1)[0]


class AxesBench(PortsBench):
    """Periods of brushless motors, each compared whole."""

    hold = False
    """The magnets are to be found: the flux stands still, and nothing disturbs."""
    zero_chance = 0.0

    def random_guard(self) -> int:
        guard = super().random_guard()
        return guard & ~0xFFFFFF if self.hold else guard

    async def board(self) -> None:
        await super().board()
        rng = self.rng
        self.way = rng.choice((1, -1))
        angle = rng.choice((1, -1)) * rng.randrange(1 << 24, 1 << 29)
        self.finds = self.hold or rng.random() < 0.3
        self.magnets = (int(self.finds), rng.getrandbits(32), angle & 0xFFFFFFFF)
        self.drive(
            magnets_i=joined((self.magnets[2], 32), (self.magnets[1], 32), (self.finds, 1)),
            magnet_start_i=0,
            hold_flux_i=self.hold,
        )
        if self.hold:
            self.parked = self.quiet = False

    def random_ports(self) -> list[Port]:
        ports = super().random_ports()
        for alpha in ALPHAS:
            if self.hold and alpha == ALPHAS[0]:
                self._easy(ports[alpha])
        return ports

    def _easy(self, port: Port) -> None:
        """Settings with which χ hardly jumps, and counts are quick."""
        port.anchor[anchor.FLUX_GAIN] = port.anchor[anchor.OWED_GAIN] = 1
        port.anchor[anchor.CELLS_GAIN] = formats.CELLS.to_raw(0.002)
        port.anchor[anchor.SLOW_TICKS] = 100
        port.walls = [(low, high, 0, shaped) for low, high, _, shaped in port.walls]
        port.__post_init__()

    async def write(self, ports: list[Port], bank: int) -> None:
        """Both axes of a motor have alpha's settings, but zero and gain."""
        both = []
        for n, port in enumerate(ports):
            words = dict(port.words)
            if n - 1 in ALPHAS:
                words = ports[n - 1].words | {0x00: port.zero, 0x01: port.gain}
            both.append(words)
        for part, words in enumerate(both, 1):
            for place, word in words.items():
                address = part << 8 | place
                self.drive(write_i=1, write_bank_i=bank, address_i=address, data_i=word)
                await FallingEdge(self.dut.clk)
        self.drive(write_i=0)

    def commit(self, ports: list[Port]) -> None:
        self.bank ^= 1
        self.drive(force_i=self.bank)
        self.next_ports = ports
        self.waiting, self.written = None, False

    async def begin(self) -> None:
        await super().begin()
        self.ports = self.summed = self.next_ports
        dut = self.dut
        sense, delay, bridge = (
            int(handle.value) for handle in (dut.sense_i, dut.delay_i, dut.bridge_i)
        )
        self.range = sense >> 16 & 0xFFFF
        delays = (delay & 3, delay >> 2 & 3)
        self.motors = {n: BrushlessMotor(delays, SHAPER, self.magnets) for n in ALPHAS}
        self.bridge = Drive(
            self.half_clocks, bridge >> 10 & 0xFF, bridge >> 2 & 0xFF if MIN_PULSE else 0,
            bool(bridge >> 27 & 1), bool(bridge >> 18 & 1), bridge >> 19 & 0xFF,
        )  # fmt: skip

    def first_tick(self) -> None:
        """The end of the first tick, which has had no step."""
        self.legs: dict[int, Legs] | None = None
        if self.word("enable_i") and self.word("running_o"):
            self.legs = {n: Legs(self.bridge) for n in ALPHAS}
        self.skip = True  # its gates are not told from those before the carrier began
        self._gates(dict.fromkeys(ALPHAS))

    def settings_of(self, alpha: int) -> Settings:
        """The settings of a motor in this round."""
        own = self.ports[alpha]
        zeros = [port.zero for port in self.summed[alpha : alpha + 2]]
        sections = np.array(own.shapes[:SHAPER], dtype=np.int64).reshape(SHAPER, 12)
        return Settings(
            zeros, (own.gain, self.ports[alpha + 1].gain), *own.etas, own.root, own.a, own.u_max,
            own.anchor, own.walls, own.hysteresis, sections, self.range,
        )  # fmt: skip

    def move(self, *, still: bool = False) -> None:
        if not self.hold:
            super().move(still=still)
            return
        for n in range(N):
            self.places[n] += 0 if still else self.way * self.rng.choice((0, 1, 1))
        self.parked = True
        super().move(still=still)

    def words_of(self, line: int) -> list[int]:
        """The samples of the round, of a line."""
        codes = self.word("frames_o") >> 12 * FRAMES * line
        return [((codes >> 12 * n & 0xFFF) - MID) << SHIFT for n in range(self.samples)]

    def live(self, port: int, word: int) -> int:
        return self.shown >> 32 * (LIVE * port + word) & 0xFFFFFFFF

    def position_of(self, alpha: int) -> int:
        return unpack(self.live(alpha, POSITION), 32, 1)[0]

    def compare(self) -> None:
        faults, running = self.word("faults_o"), self.word("running_o")
        self.shown = self.word("live_o")
        whole = self.word("steps_o") == N and not self.word("broken_o")
        damp = bool(self.word("damp_o"))
        steps: dict[int, Step | None] = {}
        for n, motor in self.motors.items():
            set_ = self.settings_of(n)
            words = [self.words_of(line) for line in (n, n + 1)]
            if whole:
                step = motor.step(set_, words, self.position_of(n), damp=damp, still=self.hold)
                self._equal(n, step)
                steps[n] = step
                self.note_step(step)
            else:
                motor.look(set_, self.position_of(n))
                motor.stop()
                steps[n] = None
                # A step that was made in part may have turned the magnets.
                self.apart |= not motor.known and self.word("steps_o") != 0
            if self.apart:
                return
            assert self.word("found_o") >> n & 3 == 3 * motor.known, f"period {self.periods}"
            assert self.word("angles_o") >> 32 * n & 0xFFFFFFFF == motor.angle, (
                f"period {self.periods}"
            )
        assert not self.word("met_o")
        assert not self.word("lit_o")
        if not whole or not running:
            self.legs = None
        self._gates(steps)
        # A sum has the zero of its first word, which comes before a commit if another follows it.
        self.summed = self.ports if self.samples > 1 else self.next_ports
        self.ports = self.next_ports
        self.was_running = bool(running)
        self.periods += 1
        self.on_periods += whole
        self.faults |= faults
        self._told(faults, steps)

    def _told(self, faults: int, steps: dict[int, Step | None]) -> None:
        """The guard has what the newest words and steps show, of the third phase as well."""
        mask = int(self.dut.guard_i.value) & 0xFFFFFF
        if faults:
            self.seen.add("fault")
        for n, step in steps.items():
            a, b = (self.words_of(line)[0] for line in (n, n + 1))
            most = max(abs(a), abs(b), min(abs(a + b), 1 << formats.SAMPLE_W - 1))
            for fault, low in ((Fault.CURRENT, 50), (Fault.ADC_RANGE, 66)):
                if most > int(self.dut.guard_i.value) >> low & 0xFFFF and mask >> fault & 1:
                    assert faults >> fault & 1, (fault, a, b, f"period {self.periods}")
                    self.seen.add("third" if most == abs(a + b) else "limit")
            if step is not None and any(step.faults) and mask >> Fault.ANCHOR & 1:
                assert faults >> Fault.ANCHOR & 1, f"period {self.periods}"

    def _equal(self, alpha: int, step: Step) -> None:
        """What is shown of a step is the integers'."""
        place = f"of motor {alpha}, period {self.periods}"
        lost = int(self.dut.ports.anchor_faults.value) >> alpha
        for n in range(TWO):
            flags = self.live(alpha + n, FLAGS)
            assert (flags >> CONTACT & 1, flags >> CLIPPED & 1) == (
                step.contact,
                step.clipped[n],
            ), place
            assert self.live(alpha + n, POSITION) == step.position & 0xFFFFFFFF, place
            words = {
                "current": (CURRENT, step.current), "u": (U, step.u), "v": (V, step.v),
                "e": (VOLTAGE, step.voltage), "c": (CORRECTION, step.correction),
                "offset": (OFFSET, step.offset), "χ": (FLUX, step.flux), "ω̂": (LAG, step.lag),
            }  # fmt: skip
            for name, (word, wanted) in words.items():
                found = signed(self.live(alpha + n, word))
                assert found == wanted[n], (name, n, place, found, wanted[n])
            assert lost >> n & 1 == (step.faults[n] and not step.found), place

    def _gates(self, steps: dict[int, Step | None]) -> None:
        """Every gate of the clocks since the tick's end before, and the next period's widths."""
        if self.legs is None:
            return
        trace = self.word("trace_o")

        def level(port: int, gate: int, clock: int) -> int:
            return trace >> TRACE * (4 * port + gate) + clock & 1

        for n, legs in self.legs.items():
            # From a tick's last clock on; the first period begins a clock later.
            clocks = self.tick_clocks - self.skip
            wanted = [leg.gates(clocks) for leg in legs.each]
            for number, (port, gate) in enumerate(((n, 0), (n, 2), (n + 1, 0))):
                found = [
                    (level(port, gate, clock), level(port, gate + 1, clock))
                    for clock in reversed(range(clocks))
                ]
                begun = 0
                if self.skip:  # the dead time after the reset is over before the carrier begins
                    begun = 2 + self.bridge.dead_clocks
                assert found[begun:] == wanted[number][begun:], (number, n, self.periods)
            own = self.ports[n]
            legs.drive_by(steps[n], own.scale, own.side)
        self.skip = False

    def note_step(self, step: Step) -> None:
        for name, values in (
            ("contact", [step.contact]), ("clipped", step.clipped), ("anchor_fault", step.faults),
            ("correction", step.correction), ("voltage", step.voltage), ("offset", step.offset),
            ("saturated", step.saturated), ("found", [step.found]),
        ):  # fmt: skip
            if any(values):
                self.seen.add(name)


async def runs(bench: AxesBench, number: int, periods: int) -> None:
    """Random boards, each for some periods."""
    for _ in range(number):
        await bench.begin()
        await bench.tick()
        bench.first_tick()
        await bench.compared(periods)
        bench.apart = False


@cocotb.test(timeout_time=10, timeout_unit="sec")
async def equals_the_integers(dut: object) -> None:
    """Every value in every period, and the gates in every clock."""
    rng = random_source("ports_axes")
    bench = AxesBench(dut, rng)
    await bench.power_up()
    short = "Icarus" in cocotb.SIM_NAME
    number, periods = (3, 50) if short else (40, 150)
    await runs(bench, number, periods)
    cocotb.log.info(
        "%d periods, %d on, faults %06x, %s",
        bench.periods, bench.on_periods, bench.faults, bench.seen,
    )  # fmt: skip
    assert bench.periods > 0.8 * number * periods
    assert bench.on_periods > bench.periods // 4
    if not short:
        wanted = {"contact", "clipped", "anchor_fault", "correction", "voltage", "offset", "fault",
                  "commit", "saturated"}  # fmt: skip
        assert bench.seen >= wanted, wanted - bench.seen


@cocotb.test(timeout_time=10, timeout_unit="sec")
async def the_magnets_are_found(dut: object) -> None:
    """The same angle, turned by the same, and in the same period the anchors begin anew."""
    rng = random_source("magnets")
    bench = AxesBench(dut, rng)
    bench.hold = True
    await bench.power_up()
    found = 0
    for _ in range(1 if "Icarus" in cocotb.SIM_NAME else 6):
        await bench.begin()
        await bench.tick()
        bench.first_tick()
        assert not bench.word("found_o") >> ALPHAS[0] & 1
        bench.drive(enable_i=1)
        for _ in range(700):
            await bench.period()
            if bench.apart:
                break
            if bench.motors[ALPHAS[0]].known:
                found += 1
                for _ in range(20):
                    await bench.period()
                break
        bench.apart = False
    cocotb.log.info("found in %d runs, %d periods", found, bench.periods)
    assert found


TAIL = (42, 58, 63)[SHAPER]
"""Clocks from the last slot's begin to the next round: ``wh_slots``."""
SERIES = {VOLTAGE: "voltage", U: "u", V: "v", CURRENT: "current", FLUX: "flux", LAG: "lag"}


class ShortBench(AxesBench):
    """The shortest period, whose steps end in another one: all values in turn."""

    end = 0
    """Clocks from a sample's strobe to a tick's end; 0: any."""

    def random_guard(self) -> int:
        return super().random_guard() & ~0xFFFFFF | OVERRUN

    async def board(self) -> None:
        await super().board()
        tick = LAST_SLOT + TAIL + self.rng.choice((0, 0, self.rng.randrange(40)))
        self.tick_clocks = tick = tick + tick % 2
        self.half_clocks, self.samples = tick // 2, 1
        # Clocks from a tick's end to its word.
        lead = FRAME_CLOCKS - self.rng.randrange(-20, 26) - tick // 2
        if self.end:
            self.tick_clocks = tick = 2 * max(self.end // 3, (LAST_SLOT + TAIL + 1) // 2)
            self.half_clocks = tick // 2
            lead = self.end + 1 - 3 * tick // 2
        self.drive(
            carrier_i=joined(
                (tick // 2, 16), (2, 16), (tick, 16), (1, 9), (lead, 8), (0, 1)
            ),
            bridge_i=joined((0, 2), (0, 8), (2, 8), (0, 1), (0, 8), (1, 1)),
            enable_i=1,
        )  # fmt: skip
        self.parked, self.quiet = True, False

    async def collect(self, clocks: int) -> None:
        """What is shown, and the gates, in each clock."""
        self.shown_of: dict[tuple[int, int], list[int]] = {}
        self.strobes: list[int] = []
        self.codes: list[int] = []
        self.ticks: list[int] = []
        self.levels: list[list[tuple[int, int]]] = []
        before = 1
        for clock in range(clocks):
            if clock % self.tick_clocks == 0:
                self.move()
            if self.word("live_valid"):
                place = self.word("live_port"), self.word("live_word")
                self.shown_of.setdefault(place, []).append(signed(self.word("live_data")))
            cs_n = self.word("cs_n")
            if before and not cs_n:
                self.strobes.append(clock - HOLD_CLOCKS)
            elif len(self.codes) < len(self.strobes):
                self.codes.append(self.word("codes_q"))  # a clock later
            before = cs_n
            if self.word("tick_o"):
                self.ticks.append(clock)
            gates = {name: self.word(name) for name in ("ah", "al", "bh", "bl")}
            self.levels.append(
                [
                    (gates[leg + "h"] >> port & 1, gates[leg + "l"] >> port & 1)
                    for port, leg in ((0, "a"), (0, "b"), (1, "a"))
                ]
            )
            await self.step()

    def words_at(self, n: int) -> list[list[int]]:
        """The sample of a tick, of each line."""
        codes = self.codes[n]
        return [[((codes >> 12 * FRAMES * line & 0xFFF) - MID) << SHIFT] for line in range(2)]

    def steps_now(self) -> list[Step]:
        """What was collected, by the integers."""
        motor, set_ = self.motors[0], self.settings_of(0)
        return [motor.step(set_, self.words_at(n), 0) for n in range(len(self.codes))]

    def legs_are(self, steps: list[Step], latency: int) -> bool:
        """Whether every gate in every clock is as it is with this latency."""
        legs = Legs(self.bridge)
        first = self.ticks[0] - self.tick_clocks + 1
        for end in self.ticks:
            made = sum(strobe + latency <= end for strobe in self.strobes)
            legs.drive_by(steps[made - 1] if made else None, self.ports[0].scale, 0)
        wanted = [leg.gates((len(self.ticks) + 1) * self.tick_clocks) for leg in legs.each]
        return all(
            self.levels[clock] == [gates[clock - first] for gates in wanted]
            for clock in range(self.ticks[0], self.ticks[-1])
        )


LATENCY = turns_latency_clocks(FRAME_CLOCKS, 1, SHAPER, brushless=True)


@cocotb.test(timeout_time=10, timeout_unit="sec", skip=N > 2)
async def the_shortest_period(dut: object) -> None:
    """No step is lost, no two ask for a product at once, whenever in a period its words come."""
    bench = ShortBench(dut, random_source("shortest"))
    await bench.power_up()
    different = 0
    for _ in range(2 if "Icarus" in cocotb.SIM_NAME else 12):
        await bench.begin()
        bench.drive(enable_i=1)
        await bench.collect(60 * bench.tick_clocks)
        assert not bench.word("met_o")
        assert not bench.word("faults_o")
        assert bench.word("running_o")
        steps = bench.steps_now()
        assert len(steps) > 50
        for word, name in SERIES.items():
            for axis in range(TWO):
                shown = bench.shown_of[axis, word]
                wanted = [getattr(step, name)[axis] for step in steps]
                assert len(steps) - 3 <= len(shown) <= len(steps)
                assert shown == wanted[: len(shown)], (name, axis)
                different += len(set(shown)) > 10
        assert bench.legs_are(steps, LATENCY)
    assert different > 5


@cocotb.test(timeout_time=10, timeout_unit="sec", skip=N > 2)
async def latency_is_what_it_says(dut: object) -> None:
    """The tick that ends so many clocks after a sample's strobe drives its voltage, none before."""
    bench = ShortBench(dut, random_source("latency"))
    await bench.power_up()
    for late in (-1, 0, 1):
        bench.end = LATENCY + late
        await bench.begin()
        bench.drive(enable_i=1)
        await bench.collect(12 * bench.tick_clocks)
        assert bench.end in [end - bench.strobes[0] for end in bench.ticks]
        steps = bench.steps_now()
        assert bench.legs_are(steps, LATENCY), late
        # Another latency would show.
        assert bench.legs_are(steps, LATENCY - 1) == (late != -1)
        assert bench.legs_are(steps, LATENCY + 1) == (late != 0)


# ---- What the guard, the zeros and the checks see of a motor of three phases.

GUARD_SHIFT = formats.DATA_W - 16


class CalmBench(AxesBench):
    """A motor whose codes are a test's, with anchors that have no say and no walls."""

    fields: dict[str, int]
    """Of the guard, beside limits that nothing reaches."""
    codes = (0, 0)
    zero_limit = 0x7FFFFF
    stuck = 0

    def random_guard(self) -> int:
        return guard.pack({**CALM, "ENERGY": 0, **self.fields})

    def random_ports(self) -> list[Port]:
        ports = super().random_ports()
        for port in ports:
            port.zero, port.anchor[anchor.ENABLE] = 0, 0
            port.walls = [(low, high, 0, 0) for low, high, *_ in port.walls]
            port.__post_init__()
        return ports

    async def board(self) -> None:
        await super().board()
        self.parked, self.still = True, False
        limit = self.zero_limit
        self.drive(
            sense_i=joined((0xFFFF, 16), (0xFFFF, 16), (self.stuck, 16), (limit, 23)),
            magnets_i=0,
        )  # fmt: skip
        self.magnets = (0, 0, 0)

    def move(self, *, still: bool = False) -> None:
        codes = [0] * N
        codes[ALPHAS[0]], codes[ALPHAS[0] + 1] = self.codes
        self.drive(code_i=pack([MID + code for code in codes], 12), noise_i=0)

    async def power_up_with(self, fields: dict[str, int]) -> None:
        self.fields = fields
        await self.power_up()

    async def calm(self, enable: int = 1, **fields: int) -> None:
        """Reset, with these fields of the guard, and the first tick."""
        self.fields = fields
        self.codes = (0, 0)
        await self.begin()
        self.drive(enable_i=enable)
        await self.tick()
        self.first_tick()

    async def ticks(self, number: int, **inputs: int) -> None:
        for _ in range(number):
            self.move()
            await self.step(**inputs)
            await self.tick()

    @property
    def step_now(self) -> Step:
        """The newest step, which must be whole, by the integers."""
        self.shown = self.word("live_o")
        assert self.word("steps_o") == N
        assert not self.word("broken_o")
        alpha = ALPHAS[0]
        words = [self.words_of(line) for line in (alpha, alpha + 1)]
        step = self.motors[alpha].step(self.settings_of(alpha), words, self.position_of(alpha))
        self._equal(alpha, step)
        return step


@cocotb.test(timeout_time=10, timeout_unit="sec", skip=N > 2)
async def each_phase_has_its_limit(dut: object) -> None:
    """The third as well, whose current is what the other two leave: all gates off, latched."""
    bench = CalmBench(dut, random_source("limits"))
    await bench.power_up_with({})
    limit = 12_000
    code = limit >> SHIFT
    for a, b, trips in (
        (code, 0, False), (code + 2, 0, True), (-code - 2, code, True), (0, -code - 2, True),
        (code - 2, -code + 2, False), (code // 2, code // 2, False),
        (code // 2 + 2, code // 2 + 2, True), (-code // 2 - 2, -code // 2 - 2, True),
        (2000, 2000, True),
    ):  # fmt: skip
        await bench.calm(MASK=1 << Fault.CURRENT, CURRENT=limit)
        await bench.ticks(4)
        assert bench.word("running_o")
        bench.codes = (a, b)
        await bench.ticks(3)
        bench.codes = (0, 0)
        await bench.ticks(3)
        assert bench.word("running_o") == int(not trips)
        assert bench.word("faults_o") == int(trips) << Fault.CURRENT
        on = any(bench.word(gates) for gates in ("ah", "al", "bh", "bl"))
        assert on != trips
        if trips:
            await bench.step(clear_i=1)
            await bench.step(clear_i=0)
            await bench.ticks(3)
            assert bench.word("running_o")


@cocotb.test(timeout_time=10, timeout_unit="sec", skip=N > 2)
async def each_phase_has_its_heat(dut: object) -> None:
    """A fault in the tick in which the hottest winding's integers have it; the third's is one."""
    rng = random_source("heat")
    bench = CalmBench(dut, rng)
    await bench.power_up_with({})
    behind, hottest = set(), set()
    for trial in range(6):
        x = rng.randint(500, 900) * rng.choice((1, -1))
        codes = ((x, x), (x, 0), (-x, x))[trial % 3]
        await bench.calm(MASK=1 << Fault.HEAT)
        motor, alpha = bench.motors[ALPHAS[0]], ALPHAS[0]
        words = [[code << SHIFT] * bench.samples for code in codes]
        (a, b), _ = motor.currents(bench.settings_of(alpha), words)
        most = max(abs(one) for one in (a, b, a + b)) >> GUARD_SHIFT
        limit = 30 * most * most // guard.HEAT_SQUARES
        bench.drive(guard_i=guard.pack({**CALM, "MASK": 1 << Fault.HEAT, "HEAT": limit}))
        bench.codes = codes
        totals, told = [0, 0, 0], None
        for tick in range(60):
            await bench.ticks(1)
            words = [bench.words_of(line) for line in (alpha, alpha + 1)]
            (a, b), _ = motor.currents(bench.settings_of(alpha), words)
            totals = [
                warmer(total, phase >> GUARD_SHIFT)
                for total, phase in zip(totals, (a, b, -a - b), strict=True)
            ]
            if told is None and max(totals) // guard.HEAT_SQUARES > limit:
                told = tick
                hottest.add(totals.index(max(totals)))
            if bench.word("faults_o"):
                behind.add(tick - told)
                break
        assert bench.word("faults_o") == 1 << Fault.HEAT
    assert len(behind) == 1, behind
    assert hottest >= {0, 2}


@cocotb.test(timeout_time=10, timeout_unit="sec", skip=N > 2)
async def each_axis_tells_that_the_encoder_is_lost(dut: object) -> None:
    """Waves that turn and no counts: told in the tick in which integers have it."""
    rng = random_source("lost")
    bench = CalmBench(dut, rng)
    await bench.power_up_with({})
    behind, axes = set(), set()
    for trial in range(6):
        limit, enough = rng.randint(20, 100), rng.randint(1, 8)
        await bench.calm(MASK=1 << Fault.LOST, LOST=limit, LOST_TICKS=enough)
        models = [LostEncoder(limit, enough) for _ in range(TWO)]
        current = rng.choice((1, -1)) * rng.randint(200, 900)
        told = None
        for tick in range(400):
            # Either only alpha has a current, or only beta.
            bench.codes = (current, -current // 2) if trial % 2 else (0, current)
            await bench.ticks(1)
            if bench.word("faults_o"):
                break
            step = bench.step_now
            for axis, model in enumerate(models):
                u, v = step.u[axis] >> GUARD_SHIFT, step.v[axis] >> GUARD_SHIFT
                if model.tick(u, v) and told is None:
                    told = tick
                    axes.add(axis)
        assert bench.word("faults_o") == 1 << Fault.LOST
        assert told is not None
        behind.add(tick - told)
    assert len(behind) == 1, behind
    assert axes == {0, 1}


@cocotb.test(timeout_time=10, timeout_unit="sec", skip=N > 2)
async def each_phase_has_its_own_zero(dut: object) -> None:
    """What it measures with the gates off comes on top of the zero that it was given."""
    bench = CalmBench(dut, random_source("zero"))
    await bench.power_up_with({})
    for codes, limit, good in (((31, -57), 1 << 20, 0), ((41, 0), 40, 1), ((0, -41), 40, 2)):
        bench.zero_limit = limit << SHIFT if good else limit
        await bench.calm(enable=0, MASK=1 << Fault.ZERO, ZERO_TICKS=0xFFFF)
        bench.codes = codes
        await bench.ticks(3)
        await bench.step(zero_start_i=1)
        await bench.step(zero_start_i=0)
        for _ in range(40):
            await bench.ticks(1)
            if not bench.word("zero_busy_o"):
                break
        assert not bench.word("zero_busy_o")
        assert bench.word("zero_faults_o") == good
        assert bench.word("faults_o") == (1 << Fault.ZERO if good else 0)
        # A phase whose zero isn't permitted keeps the one that it had.
        zeros = [
            0 if good >> n & 1 else code * bench.samples << SHIFT for n, code in enumerate(codes)
        ]
        ports = bench.ports
        assert bench.summed is ports
        for port, zero in zip(ports, zeros, strict=True):
            port.zero = zero  # of the integers: what was measured is added
        bench.codes = (400, -300)
        await bench.step(clear_i=1, enable_i=1)
        bench.drive(clear_i=0)
        if not good:
            await bench.ticks(4)
            bench.motors[0].stop()
            own, other = ports
            words = [bench.words_of(line) for line in range(2)]
            phases, _ = bench.motors[0].currents(bench.settings_of(0), words)
            bench.shown = bench.word("live_o")
            wanted = clarke.currents(*phases)
            assert tuple(signed(bench.live(axis, CURRENT)) for axis in range(TWO)) == wanted
            assert own.zero != other.zero


@cocotb.test(timeout_time=10, timeout_unit="sec", skip=N > 2)
async def settings_that_mean_nothing(dut: object) -> None:
    """Periods of half a carrier period keep the gates off: a leg's width is of a whole one."""
    bench = CalmBench(dut, random_source("settings"))
    await bench.power_up_with({})
    for halves, faulty in ((2, 0), (3, 1)):
        await bench.calm(MASK=1 << Fault.SETTING)
        carrier = bench.word("carrier_i")
        bench.drive(rst=1, carrier_i=carrier & ~(0xFFFF << 16) | halves << 16)
        await bench.step(3)
        bench.drive(rst=0, enable_i=1)
        await bench.tick()
        await bench.ticks(3)
        assert bench.word("faults_o") == faulty << Fault.SETTING
        assert bench.word("running_o") == 1 - faulty
