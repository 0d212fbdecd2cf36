# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_ports.v``: N ports in turn equal a ``wh_controller``, value for value.

Both have the same pins. Settings, walls, currents and encoder edges are each port's own and random;
there are faults, commits, zeros that are measured, the bridges off and on, and resets at any clock.
Edges come when neither looks at positions: the two don't look in the same clock. Both damp from the
same step on; a period in which the bridges go off has no values to compare but the faults.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field
from itertools import product

import cocotb
import numpy as np
from bench import Bench, pack, random_source
from cocotb.triggers import FallingEdge, RisingEdge, with_timeout
from random_anchor import random_anchor
from simulators import parameters
from tb_core import packed_section, section
from wavehaptics.controller import anchor, guard
from wavehaptics.controller.pins_timing import turns_latency_clocks
from wavehaptics.words import formats

N = parameters()["N"]
WALLS = parameters().get("WALLS", 4)
SHAPER = parameters().get("SHAPER", 0)
HOST = parameters().get("HOST", 0)
MODES = parameters().get("MODES", 0)
AXES = parameters().get("AXES", 0)
"""Ports of brushless motors, of :mod:`tb_ports_axes`."""
SHAPE_BITS = 9 * formats.SHAPE.width + 3 * formats.SHAPE_LOSS_W
SUM_W = formats.SUM_W
CONVERSION = 33
"""Clocks from a sample's strobe to its word, of the frame below."""
LAST_SLOT = (36 if SHAPER == 2 else 32) * (N - 1)
EDGES = LAST_SLOT + (90 if AXES else 50)
"""Clocks from a round's begin until positions have been looked at, and no step is under way."""
FRAME_CLOCKS = 29
"""Clocks from a sample's strobe to its word."""
BUS_V = 24.0
FEEDBACK_CLOCKS = 4
"""By how much widths of one voltage may differ, at most."""
RESULTS = (
    "u", "v", "i", "position", "flags", "e", "c", "offset", "χ", "ω̂", "energy", "most energy",
    "host",
)  # fmt: skip
MID = 1 << 11
DAMPABLE = 0x0080E0
"""Faults that may damp."""
ENERGY = 1 << 16
SATURATED = 1 << 17
MOTION = 0x0C0000
"""OVERSPEED, WINDOW."""
FOUND_IN_A_TURN = 0x039040 | MOTION
"""Faults that are found in a port's turn: LOST, HEAT, ANCHOR, ENERGY, SATURATED, and of motion."""
OVERRUN = 1 << 14


ILLEGAL = 0.03 / N
"""Chance of a setting without a meaning, of a port."""
NO_MEANING = (
    ("gain", 0), ("gain", -1), ("root", 0), ("root", -5), ("u_max", -1), ("scale", 0),
    ("scale", -9), ("a", 0), ("a", formats.A.to_raw(1.0) + 1), ("a", -1),
    ("etas", (formats.ETA.to_raw(1.0) + 1, 0)), ("etas", (0, -formats.ETA.to_raw(1.0) - 1)),
)  # fmt: skip


@dataclass
class Port:
    """The settings of one port, and where its motor is."""

    zero: int
    gain: int
    etas: tuple[int, int]
    root: int
    a: int
    u_max: int
    scale: int
    side: int
    anchor: np.ndarray
    hysteresis: int
    walls: list[tuple[int, int, int, int]]
    shapes: list[list[int]]
    motion: tuple[int, int, int]
    """Limits of speed and position."""
    words: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.words = {
            0x00: self.zero, 0x01: self.gain, 0x08: self.etas[0], 0x09: self.etas[1],
            0x10: self.root, 0x11: self.a, 0x12: self.u_max, 0x18: self.scale, 0x1A: self.side,
            0x30: self.hysteresis,
        }  # fmt: skip
        self.words |= {0x31 + place: word for place, word in enumerate(self.motion)}
        self.words |= {0x20 + place: int(word) for place, word in enumerate(self.anchor)}
        for number, words in enumerate(self.shapes):
            first, loss = 0x80 + 9 * number, 0x92 + 3 * number
            self.words |= {first + place: word for place, word in enumerate(words[:9])}
            self.words |= {loss + place: word for place, word in enumerate(words[9:])}
        for place, (low, high, enable, shaped) in enumerate(self.walls):
            self.words |= {
                0x40 + place: low,
                0x50 + place: high,
                0x60 + place: enable,
                0x70 + place: shaped,
            }


def random_port(rng: random.Random, half_clocks: int, samples: int) -> Port:
    ohm = rng.uniform(0.5, 10.0)
    walls = []
    for _ in range(WALLS):
        low = rng.randint(-6, 4)
        walls.append((low, low + rng.randint(0, 6), rng.random() < 0.8, rng.random() < 0.6))
    port = Port(
        zero=rng.randint(-3000, 3000),
        gain=formats.GAIN.to_raw(rng.uniform(0.5, 15.0) / ((1 << 15) * samples)),
        etas=(
            formats.ETA.to_raw(rng.choice((-1.0, -0.9))),
            formats.ETA.to_raw(rng.choice((1.0, 0.5))),
        ),
        root=formats.ROOT.to_raw(math.sqrt(2 * ohm)),
        a=formats.A.to_raw(rng.choice((1.0, rng.uniform(0.001, 1.0)))),
        u_max=formats.WAVE.to_raw(rng.uniform(0.3, 1.1) * BUS_V / math.sqrt(2 * ohm)),
        scale=formats.DUTY.to_raw(half_clocks / (2 * BUS_V)),
        side=formats.CURRENT.to_raw(rng.uniform(0.0, 1.0)),
        anchor=random_anchor(rng, ohm, (5.0, 100.0)),
        hysteresis=rng.randrange(2),
        walls=walls,
        shapes=[section(rng) for _ in range(max(1, SHAPER))],
        motion=rng.choice(
            (
                (0, -(1 << 31), (1 << 31) - 1),
                (rng.randint(1, 9), -rng.randint(0, 9), rng.randint(0, 9)),
            )
        ),
    )
    if rng.random() < ILLEGAL:
        name, value = rng.choice(NO_MEANING)
        setattr(port, name, value)
        port.__post_init__()
    return port


def joined(*fields: tuple[int, int]) -> int:
    """Words and their widths, the first one lowest."""
    packed, place = 0, 0
    for word, width in fields:
        packed |= (word & ((1 << width) - 1)) << place
        place += width
    return packed


EVERY_FAULT = 0x01FFFF & ~OVERRUN | MOTION
"""No period is too short, and no motor swings."""


class PortsBench(Bench):
    """Periods, each compared whole."""

    zero_chance = 0.01
    """Of a zero that is asked for, of a period."""

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut)
        self.rng = rng
        self.bank = 0
        self.waiting: list[Port] | None = None
        self.written = False
        self.places = [0] * N
        self.base = [0.0] * N
        self.periods = self.on_periods = self.known_energies = 0
        self.was_running = False
        self.apart = False
        self.not_found = 0
        self.seen: set[str] = set()
        self.faults = 0

    async def power_up(self) -> None:
        names = [name for name in dir(self.dut) if name.endswith("_i") and not name.startswith("_")]
        await self.start(**dict.fromkeys(names, 0))

    # ---- Settings.

    async def board(self) -> None:
        """Other settings of all ports, in reset."""
        rng = self.rng
        # One sample of a long period can't be so late that its word comes after the tick's end.
        self.samples = rng.choice((1, 1, 2) if EDGES < 200 else (2, 2, 4))
        mode = rng.randrange(4) if MODES else 0
        self.halves = 2 if mode or AXES else rng.choice((1, 1, 2))
        unit = self.samples * self.halves * 2
        # What a host answers has its square made, and is halved, before the next period ends.
        least = max(
            EDGES + 30 + 90 * HOST,
            self.halves * (LAST_SLOT + 30),
            self.samples * (CONVERSION + 4 + N + (N // 2 if AXES else 0)),
        )
        self.tick_clocks = -(-(least + rng.randrange(40)) // unit) * unit
        sample_clocks = self.tick_clocks // self.samples
        # The period's last word comes some clocks after a tick's end.
        lead = CONVERSION - rng.randint(4, 9) - sample_clocks // 2
        assert lead >= -128
        half_clocks = self.tick_clocks // self.halves
        self.half_clocks = half_clocks
        compensate = rng.random() < (0.03 if mode else 0.5)
        self.host_alive = rng.choice((0.1, 0.1, 0.01))
        self.quiet = rng.random() < 0.2  # currents that stay, without noise
        self.answers = rng.choice((0.05, 0.5, 1.0))
        self.parked = rng.random() < 0.4  # rotors that don't move
        self.drive(
            carrier_i=joined(
                (half_clocks, 16), (self.halves, 16), (sample_clocks, 16), (self.samples, 9),
                (lead, 8), (0, 1),
            ),
            frame_i=joined(
                (1, 8), (14, 6), (2, 6), (12, 5), (2, 8), (1, 8), (0, 8), (0, 6), (1, 1), (1, 1)
            ),
            sense_i=joined(
                (rng.choice((0xFFFF, 0x6000)), 16), (rng.choice((0xFFFF, 0x7000)), 16),
                (rng.choice((0, 40)), 16), (rng.choice((0x7FFFFF, 3000)), 23),
            ),
            filter_clocks_i=2,
            delay_i=joined((rng.randrange(4), 2), (rng.choice((0, 0, 1, 2)), 2)),
            bridge_i=joined(
                (mode, 2), (rng.choice((0, 3, 8, 9, 40)), 8),
                (0xFF if rng.random() < 0.03 else rng.choice((0, 2, 5)), 8), (compensate, 1),
                (rng.randrange(6), 8), (rng.randrange(2), 1),
            ),
            guard_i=self.random_guard(),
            host_i=joined((rng.choice((0, 1, 3)), 4), (rng.choice((1, 3, 200)), 8)),
        )  # fmt: skip

    def random_guard(self) -> int:
        rng = self.rng
        some = rng.random() < 0.6
        masked = rng.getrandbits(24) if some else 0
        return joined(
            (masked, 24), (rng.getrandbits(24) & DAMPABLE, 24), (0b11, 2),
            (rng.choice((0x7000, 0xFFFF)), 16), (rng.choice((0x7400, 0xFFFF)), 16),
            (rng.choice((60, 0xFFFF)), 16), (rng.choice((200, 0xFFFF)), 16),
            (rng.choice((2, 9)), 16),
            (rng.choice((1, 1, 30, 3000)), 16), (rng.choice((3, 10, 5000)), 16),
            (rng.choice((90, 0xFFFFFF)), 24),
            (0x1000, 16), (0x4000, 16), (rng.choice((0, 3)), 16),
            (rng.choice((1 << 12, 0xFFFFFFFF)), 32), (rng.choice((0, 1, 5)), 16),
            (0, 16),
        )  # fmt: skip

    def random_ports(self) -> list[Port]:
        return [random_port(self.rng, self.half_clocks, self.samples) for _ in range(N)]

    async def write(self, ports: list[Port], bank: int) -> None:
        for part, port in enumerate(ports, 1):
            for place, word in port.words.items():
                address = part << 8 | place
                self.drive(write_i=1, write_bank_i=bank, address_i=address, data_i=word)
                await FallingEdge(self.dut.clk)
        self.drive(write_i=0)

    async def prepare(self) -> None:
        """Write the settings that wait into the other bank, beside all else."""
        assert self.waiting is not None
        await self.write(self.waiting, self.bank ^ 1)
        self.written = True

    def commit(self, ports: list[Port]) -> None:
        self.bank ^= 1
        each_wall = [wall for port in ports for wall in port.walls]
        each_section = [words for port in ports for words in port.shapes]
        coef, data = formats.COEF_W, formats.DATA_W
        self.drive(
            force_i=self.bank,
            zero_i=pack([port.zero for port in ports], SUM_W),
            gain_i=pack([port.gain for port in ports], coef),
            wall_min_i=pack([wall[0] for wall in each_wall], formats.COUNT_W),
            wall_max_i=pack([wall[1] for wall in each_wall], formats.COUNT_W),
            wall_enable_i=pack([wall[2] for wall in each_wall], 1),
            wall_shaped_i=pack([wall[3] for wall in each_wall], 1),
            shape_words_i=pack([packed_section(words) for words in each_section], SHAPE_BITS),
            edge_hysteresis_i=pack([port.hysteresis for port in ports], 1),
            overspeed_i=pack([port.motion[0] for port in ports], 16),
            window_low_i=pack([port.motion[1] for port in ports], formats.COUNT_W),
            window_high_i=pack([port.motion[2] for port in ports], formats.COUNT_W),
            eta_contact_i=pack([port.etas[0] for port in ports], coef),
            eta_free_i=pack([port.etas[1] for port in ports], coef),
            root_i=pack([port.root for port in ports], coef),
            a_i=pack([port.a for port in ports], coef),
            u_max_i=pack([port.u_max for port in ports], data),
            anchor_words_i=pack([anchor.packed(port.anchor) for port in ports], formats.ANCHOR_W),
            clocks_per_volt_i=pack([port.scale for port in ports], coef),
            side_current_i=pack([port.side for port in ports], data),
        )
        self.waiting, self.written = None, False

    async def begin(self) -> None:
        """Reset, at any clock, with other settings."""
        while self.waiting is not None and not self.written:
            await self.step()
        self.waiting = None
        self.written = False
        self.drive(
            rst=1, enable_i=0, stop_i=0, driver_fault_i=0, bus_i=0x2000, clear_i=0, zero_start_i=0,
            host_alive_i=0,
        )  # fmt: skip
        await self.step(self.rng.choice((1, 1, 3)))
        await self.board()
        ports = self.random_ports()
        await self.write(ports, self.bank ^ 1)
        self.commit(ports)
        self.move(still=True)
        await self.step(2)
        self.drive(rst=0)
        self.drive(enable_i=self.rng.random() < 0.8)

    # ---- Pins.

    def move(self, *, still: bool = False) -> None:
        """Encoders by a count or none, some currents by a walk."""
        rng = self.rng
        codes, noise, a, b = [], [], 0, 0
        for n in range(N):
            if not still and not self.parked:
                illegal = rng.random() < 0.005
                self.places[n] += 2 if illegal else self.count(n)
            phase = self.places[n] & 3
            a |= (phase in (1, 2)) << n
            b |= (phase in (2, 3)) << n
            if not self.quiet:
                self.base[n] = 0.9 * self.base[n] + rng.gauss(0, 0.08)
            code = MID + round(MID * self.base[n])
            if rng.random() < 0.005:
                code = rng.choice((0, 4095, MID + 1800, MID - 1800))
            codes.append(min(4095, max(0, code)))
            noise.append(0 if self.quiet else 7)
        self.drive(code_i=pack(codes, 12), noise_i=pack(noise, 12), enc_a_i=a, enc_b_i=b)

    def count(self, port: int) -> int:
        return self.rng.choice((0, 0, 0, 1, 1, -1, -1))

    # ---- Periods.

    def compare(self) -> None:
        faults, wanted = self.word("faults_o"), self.word("controller_faults_o")
        running = self.word("running_o")
        # Energies that are unknown may be a fault of one of the two.
        self.apart = self.word("energy_unknown_o") == 1 and (faults ^ wanted) == ENERGY
        if self.apart:
            return
        assert running in (0, 3), f"{faults:06x}, {wanted:06x}, period {self.periods}"
        # Off comes at once, and a port's turn finds a fault earlier or later in a step of all. What
        # others would have found after it, they don't.
        begins = running == 0 and self.was_running
        self.was_running = running == 3
        if begins and self.word("energy_unknown_o"):
            self.not_found = (faults ^ wanted) & FOUND_IN_A_TURN
        self.not_found &= faults ^ wanted
        assert faults ^ wanted == (0 if running else self.not_found), (
            f"{faults:06x}, controller {wanted:06x}, period {self.periods}"
        )
        differs = 0 if begins else self.word("differs_o")
        assert not differs, [
            f"{name} of port {port}, period {self.periods}"
            for place, (port, name) in enumerate(product(range(N), RESULTS))
            if differs >> place & 1
        ]
        assert not self.word("frames_differ_o")
        assert not self.word("gates_differ_o"), f"period {self.periods}"
        assert not self.word("met_o")
        self.periods += 1
        self.on_periods += running == 3
        self.faults |= faults
        self.note(faults)

    async def period(self) -> None:
        """From a tick's end, at which bridges go on and off, to the next one."""
        rng, dut = self.rng, self.dut
        strobes = {
            "clear_i": 0.15,
            "host_alive_i": self.host_alive,
            "zero_start_i": self.zero_chance,
        }
        self.drive(**{name: rng.random() < chance for name, chance in strobes.items()})
        chance = rng.random()
        if chance < 0.01:
            self.drive(enable_i=0)
        elif chance < 0.06:
            self.drive(enable_i=1)
        if rng.random() < 0.005:
            self.drive(bus_i=rng.choice((0x500, 0x5000)))
        elif rng.random() < 0.2:
            self.drive(bus_i=0x2000)
        stops, drivers = rng.random() < 0.006, (rng.random() < 0.006) << rng.randrange(N)
        self.drive(stop_i=stops, driver_fault_i=drivers)
        await self.step()
        self.drive(**dict.fromkeys(strobes, 0))
        await with_timeout(RisingEdge(dut.round_o), 100, "us")
        await FallingEdge(dut.clk)
        self.was_running |= self.word("running_o") == 3  # a clear may have let them on
        await self.step(EDGES)
        if HOST and rng.random() < self.answers:
            await self.answer()
        # The controller looks at its walls all the time, and would see new ones with an old place.
        self.move(still=self.written)
        if self.waiting is None and rng.random() < 0.02:
            self.waiting = self.random_ports()
            cocotb.start_soon(self.prepare())
        elif self.written:
            self.commit(self.waiting)
            self.seen.add("commit")
        await self.tick()
        self.compare()

    async def compared(self, periods: int) -> None:
        """So many periods, or until both may differ, and a part of one more."""
        for _ in range(periods):
            await self.period()
            if self.apart:
                break
        await self.step(self.rng.randrange(self.tick_clocks))

    async def answer(self) -> None:
        """A host's answer for some ports, to a packet of them or an older one."""
        rng = self.rng
        u = rng.choice((1, -1)) * rng.getrandbits(rng.randint(1, formats.WAVE.width - 1))
        sequence = self.word("host_sequence_o") >> 8 * rng.randrange(N)
        await self.step(
            host_strobe_i=rng.getrandbits(N), host_u_i=u,
            host_sequence_i=(sequence - rng.choice((0, 0, 0, 1, 130))) & 0xFF,
        )  # fmt: skip
        self.drive(host_strobe_i=0)

    async def tick(self) -> None:
        """A tick's last clock, the next edge of which what is driven then counts for."""
        await with_timeout(RisingEdge(self.dut.tick_o), 100, "us")
        await FallingEdge(self.dut.clk)

    def note(self, faults: int) -> None:
        self.known_energies += not self.word("energy_unknown_o")
        for name in (
            "contact", "clipped", "anchor_fault", "correction", "voltage", "offset", "energy",
            "host_active",
        ):  # fmt: skip
            if self.word(f"{name}_o"):
                self.seen.add(name)
        if faults:
            self.seen.add("fault")


@cocotb.test(timeout_time=10, timeout_unit="sec")
async def equals_the_controller(dut: object) -> None:
    """Every value in every period, and the gates in every clock."""
    rng = random_source("ports")
    bench = PortsBench(dut, rng)
    await bench.power_up()
    runs, periods = (2, 60) if "Icarus" in cocotb.SIM_NAME else (60, 150)
    for _ in range(runs):
        await bench.begin()
        await bench.tick()
        await bench.compared(periods)
    assert bench.periods > 0.95 * runs * periods
    assert bench.on_periods > bench.periods // 4
    cocotb.log.info(
        "%d periods, %d on, %d with energies, faults %06x, %s",
        bench.periods, bench.on_periods, bench.known_energies, bench.faults, bench.seen,
    )  # fmt: skip
    if runs > 10:
        assert bench.faults == EVERY_FAULT
        assert bench.seen == ({"host_active"} if HOST else set()) | {
            "contact", "clipped", "anchor_fault", "correction", "voltage", "offset", "energy",
            "fault", "commit",
        }  # fmt: skip
        assert bench.known_energies > bench.periods // 3


class SwingingBench(PortsBench):
    """Rotors that swing in walls, with a limit of 0 V, which acts at once."""

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut, rng)
        self.swings: list[list[int]] = [[] for _ in range(N)]
        self.way = [1] * N

    def random_guard(self) -> int:
        rng = self.rng
        fields = {"MASK": SATURATED, "LEVELS": 0b11, "HOST": 0xFFFFFF, "BUS_MAX": 0xFFFF}
        return guard.pack({**fields, "SATURATED": rng.choice((0, 2, 3, 5, 0xFFFF))})

    def random_ports(self) -> list[Port]:
        ports = super().random_ports()
        for port in ports:
            port.u_max = 0
            port.walls = [(-1000, 1000, True, False)] * WALLS
            port.__post_init__()
        return ports

    def count(self, port: int) -> int:
        if not self.swings[port]:
            rng = self.rng
            self.way[port] *= -1
            counts = rng.choice((1, *[2] * 40, 3))
            self.swings[port] = [self.way[port]] * counts + [0] * rng.choice((*[0] * 12, 1, 3))
        return self.swings[port].pop(0)


@cocotb.test(timeout_time=10, timeout_unit="sec")
async def swings_as_the_controller_does(dut: object) -> None:
    """Rotors that swing at the limit, in every port: the fault comes in the same period."""
    rng = random_source("swings")
    bench = SwingingBench(dut, rng)
    await bench.power_up()
    runs, periods, found = (2, 70, 0) if "Icarus" in cocotb.SIM_NAME else (30, 100, 0)
    for _ in range(runs):
        await bench.begin()
        bench.parked = False
        await bench.tick()
        bench.faults = 0
        await bench.compared(periods)
        found += bench.faults == SATURATED
    cocotb.log.info("%d of %d runs with a fault, %d periods on", found, runs, bench.on_periods)
    if runs > 10:
        assert runs // 4 < found < runs


async def ticks_until_the_gates_tell(bench: PortsBench, tick_clocks: int, lead: int) -> int:
    """Ticks from the end of the one with a sample until the last port's gates have its voltage."""
    dut, last = bench.dut, N - 1
    bench.drive(rst=1, enable_i=1)
    await bench.step()
    await bench.board()
    ports = [random_port(random.Random(1), tick_clocks, 1) for _ in range(N)]
    for port in ports:
        port.anchor[anchor.ENABLE] = 0
        port.zero, port.walls, port.a = 0, [(0, 0, False, False)] * WALLS, formats.A.to_raw(1.0)
        port.gain, port.root = formats.GAIN.to_raw(1.0 / (8 * MID)), formats.ROOT.to_raw(2.0)
        port.u_max = formats.WAVE.to_raw(0.45 * BUS_V)
        port.scale = formats.DUTY.to_raw(tick_clocks / 8)
        port.etas = (0, formats.ETA.to_raw(0.5))
        port.__post_init__()
    bench.drive(
        carrier_i=joined((tick_clocks, 16), (1, 16), (tick_clocks, 16), (1, 9), (lead, 8), (0, 1)),
        sense_i=joined((0xFFFF, 16), (0xFFFF, 16), (0, 16), (0x7FFFFF, 23)),
        delay_i=0, bridge_i=0, guard_i=0, host_alive_i=1, code_i=pack([MID] * N, 12), noise_i=0,
    )  # fmt: skip
    await bench.write(ports, bench.bank ^ 1)
    bench.commit(ports)
    await bench.step(2, rst=0)

    async def widths(ticks: int) -> list[int]:
        """The last port's width of each tick, as it is when the tick before ends."""
        found, width = [], 0
        while len(found) < ticks:
            await bench.step()
            if int(dut.ports.width_valid.value) and int(dut.ports.width_leg.value) == last:
                width = dut.ports.width.value.to_signed()
            if bench.word("tick_o"):
                found.append(width)
        return found

    await bench.tick()
    before = (await widths(8))[-1]
    assert bench.word("running_o") == 3
    assert before
    bench.drive(code_i=pack([MID + (MID >> 1)] * N, 12))
    return [abs(width - before) > FEEDBACK_CLOCKS for width in await widths(6)].index(True)


@cocotb.test(timeout_time=10, timeout_unit="sec")
async def latency_is_what_it_says(dut: object) -> None:
    """The tick that ends so many clocks after a sample's strobe drives its voltage, none before."""
    bench = PortsBench(dut, random_source("latency"))
    await bench.power_up()
    latency = turns_latency_clocks(FRAME_CLOCKS, N, SHAPER)
    tick_clocks = 2 * max(LAST_SLOT // 2 + 30, latency // 3 + 10)
    for late, ticks in ((-1, 1), (0, 1), (1, 2), (2, 2)):
        # The strobe comes half a tick and -lead after the tick's begin, tick_o in its last clock.
        lead = latency + 1 - 3 * tick_clocks // 2 - late
        assert await ticks_until_the_gates_tell(bench, tick_clocks, lead) == ticks, late
