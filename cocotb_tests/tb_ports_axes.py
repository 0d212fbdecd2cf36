# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_ports.v`` with brushless motors: two ports equal a ``wh_brushless``.

As :mod:`tb_ports`, with the same pins and random settings; a brushed motor beside it equals a
``wh_controller``. Then no fault is masked in, as those of the one are the other's only here.
"""

from __future__ import annotations

import random
from itertools import product

import cocotb
from bench import random_source
from simulators import parameters
from tb_ports import (
    AXES,
    ENERGY,
    FOUND_IN_A_TURN,
    LAST_SLOT,
    OVERRUN,
    RESULTS,
    N,
    Port,
    PortsBench,
    joined,
)
from wavehaptics.controller import anchor
from wavehaptics.words import formats

MIXED = AXES | AXES << 1 != (1 << N) - 1
ALPHA = next(n for n in range(N) if AXES >> n & 1)
EVERY_FAULT = 0x00FFFF & ~OVERRUN
"""No period is too short, and an axis has no energies."""
SHAPER = parameters().get("SHAPER", 0)


class AxesBench(PortsBench):
    """Periods of a brushless motor, each compared whole."""

    hold = False
    """The magnets are to be found: the flux stands still, and nothing disturbs."""

    def random_guard(self) -> int:
        guard = super().random_guard()
        return guard & ~0xFFFFFF if MIXED or self.hold else guard

    async def board(self) -> None:
        await super().board()
        rng = self.rng
        self.way = rng.choice((1, -1))
        angle = rng.choice((1, -1)) * rng.randrange(1 << 24, 1 << 29)
        find = self.hold or rng.random() < 0.3
        self.drive(
            magnets_i=find << 64 | rng.getrandbits(32) << 32 | angle & 0xFFFFFFFF,
            magnet_start_i=0,
            hold_flux_i=self.hold,
        )
        if self.hold:
            self.parked = self.quiet = False

    def random_ports(self) -> list[Port]:
        ports = super().random_ports()
        for n, port in enumerate(ports):
            if AXES >> n & 1:
                if self.hold:
                    self._easy(port)
                zero, gain = ports[n + 1].zero, ports[n + 1].gain
                ports[n + 1] = Port(
                    **{
                        name: getattr(port, name)
                        for name in Port.__dataclass_fields__
                        if name != "words"
                    }
                    | {"zero": zero, "gain": gain}
                )
        return ports

    def _easy(self, port: Port) -> None:
        """Settings with which χ hardly jumps, and counts are quick."""
        port.anchor[anchor.FLUX_GAIN] = port.anchor[anchor.OWED_GAIN] = 1
        port.anchor[anchor.CELLS_GAIN] = formats.CELLS.to_raw(0.002)
        port.anchor[anchor.SLOW_TICKS] = 100
        port.walls = [(low, high, 0, shaped) for low, high, _, shaped in port.walls]
        port.__post_init__()

    def move(self, *, still: bool = False) -> None:
        if not self.hold:
            super().move(still=still)
            return
        for n in range(N):
            self.places[n] += 0 if still else self.way * self.rng.choice((0, 1, 1))
        self.parked = True
        super().move(still=still)

    def compare(self) -> None:
        faults, wanted = self.word("faults_o"), self.word("controller_faults_o")
        running = self.word("running_o")
        assert running in (0, 3), f"{faults:06x}, {wanted:06x}, period {self.periods}"
        begins = running == 0 and self.was_running
        self.was_running = running == 3
        if begins and self.word("energy_unknown_o"):
            self.not_found = (faults ^ wanted) & FOUND_IN_A_TURN
        self.not_found &= faults ^ wanted
        assert faults ^ wanted == (0 if running else self.not_found), (
            f"{faults:06x}, wh_brushless {wanted:06x}, period {self.periods}"
        )
        # A step that only one of the two has made leaves magnets that aren't known.
        if self.word("energy_unknown_o") and self.word("angle_differs_o"):
            self.apart = True
            return
        assert not self.word("angle_differs_o"), f"period {self.periods}"
        differs = 0 if begins else self.word("differs_o")
        assert not differs, [
            f"{name} of port {port}, period {self.periods}"
            for place, (port, name) in enumerate(product(range(N), RESULTS[:-1]))
            if differs >> place & 1
        ]
        assert not self.word("frames_differ_o")
        assert not self.word("gates_differ_o"), f"period {self.periods}"
        assert not self.word("met_o")
        self.periods += 1
        self.on_periods += running == 3
        self.faults |= faults
        self.note(faults)

    def note(self, faults: int) -> None:
        self.known_energies += not self.word("energy_unknown_o")
        for name in ("contact", "clipped", "anchor_fault", "energy"):
            if self.word(f"{name}_o") >> ALPHA & 3:
                self.seen.add(name)
        for name in ("correction", "voltage", "offset"):
            if self.word(f"{name}_o") >> ALPHA * formats.DATA_W & (1 << 2 * formats.DATA_W) - 1:
                self.seen.add(name)
        if self.word("found_o"):
            self.seen.add("found")
        if faults:
            self.seen.add("fault")


async def runs(bench: AxesBench, rng: random.Random, number: int, periods: int) -> None:
    """Random boards, each for some periods."""
    for _ in range(number):
        await bench.begin()
        await bench.tick()
        for _ in range(periods):
            await bench.period()
            if bench.apart:
                break
        bench.apart = False
        await bench.step(rng.randrange(bench.tick_clocks))


@cocotb.test(timeout_time=10, timeout_unit="sec")
async def equals_wh_brushless(dut: object) -> None:
    """Every value in every period, and the gates in every clock."""
    rng = random_source("ports_axes")
    bench = AxesBench(dut, rng)
    await bench.power_up()
    short = "Icarus" in cocotb.SIM_NAME
    number, periods = (2, 60) if short else (40 if MIXED else 100, 150)
    await runs(bench, rng, number, periods)
    cocotb.log.info(
        "%d periods, %d on, faults %06x, %s",
        bench.periods, bench.on_periods, bench.faults, bench.seen,
    )  # fmt: skip
    assert bench.periods > 0.9 * number * periods
    assert bench.on_periods > bench.periods // 4
    assert not bench.faults & ENERGY
    if not short:
        assert bench.faults == (0 if MIXED else EVERY_FAULT)
        wanted = {"contact", "clipped", "anchor_fault", "correction", "voltage", "offset", "found"}
        wanted |= {"commit"} | (set() if MIXED else {"fault"})
        assert bench.seen >= wanted


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
        assert not bench.word("found_o")
        bench.drive(enable_i=1)
        for _ in range(700):
            await bench.period()
            if bench.apart:
                break
            if bench.word("found_o"):
                found += 1
                bench.hold_done = True
                for _ in range(20):
                    await bench.period()
                break
        bench.apart = False
    cocotb.log.info("found in %d runs, %d periods", found, bench.periods)
    assert found


TAIL = (42, 58, 63)[SHAPER]
"""Clocks from the last slot's begin to the next round: ``wh_slots``."""
LEGS_CLOCKS = (59, 75, 80)[SHAPER]
"""Clocks from the last slot's begin to the soonest end of a tick that drives the legs."""
WORD_CLOCKS = 28
"""Clocks from a sample's strobe to its word."""
LIVE = {0: "voltage", 1: "u", 2: "v", 3: "current", 10: "flux", 11: "lag"}


class ShortBench(AxesBench):
    """The shortest period, in which the two are done at different times: all values in turn."""

    def random_guard(self) -> int:
        return super().random_guard() & ~0xFFFFFF | OVERRUN

    async def board(self) -> None:
        await super().board()
        tick = LAST_SLOT + TAIL + self.rng.choice((0, 0, self.rng.randrange(40)))
        self.tick_clocks = tick = tick + tick % 2
        self.half_clocks, self.samples = tick // 2, 1
        # Clocks after the tick's end; but not where wh_brushless takes some legs of a step only.
        self.word_at = self.rng.choice(
            [
                clock
                for clock in range(-20, WORD_CLOCKS - 2)
                if 3 < -self.soonest(clock) % tick < tick - 5
            ]
        )
        lead = WORD_CLOCKS - self.word_at - tick // 2
        self.drive(
            carrier_i=joined(
                (tick // 2, 16), (2, 16), (tick, 16), (1, 9), (lead, 8), (0, 1)
            ),
            # A dead time is compensated by currents, which the one has sooner.
            bridge_i=joined((0, 2), (0, 8), (2, 8), (0, 1), (0, 8), (1, 1)),
        )  # fmt: skip
        self.parked, self.quiet = True, False

    async def collect(self, clocks: int) -> None:
        """What both show, and their gates, in each clock."""
        self.shown: dict[tuple[int, str], list[int]] = {}
        self.wanted: dict[tuple[int, str], list[int]] = {}
        self.gates: list[tuple[int, int]] = []
        for clock in range(clocks):
            if clock % self.tick_clocks == 0:
                self.move()
            if self.word("live_valid") and (name := LIVE.get(self.word("live_word"))):
                word = self.word("live_data") & (1 << formats.DATA_W) - 1
                self.shown.setdefault((self.word("live_port"), name), []).append(word)
            strobes = {
                "core_valid": ("voltage", "u", "v"),
                "core_start": ("current", "flux", "lag"),
            }
            for strobe, names in strobes.items():
                if self.word(strobe):
                    for name in names:
                        word = self.word(name)
                        for axis in range(2):
                            one = word >> axis * formats.DATA_W & (1 << formats.DATA_W) - 1
                            self.wanted.setdefault((ALPHA + axis, name), []).append(one)
            self.gates.append((self.word("legs"), self.word("ports_legs")))
            await self.step()

    @property
    def later(self) -> int:
        """Ticks by which the gates of ``wh_ports`` come later, as the headers of both say."""
        ready = self.word_at + LAST_SLOT + LEGS_CLOCKS
        return -(-ready // self.tick_clocks) + self.soonest(self.word_at) // -self.tick_clocks

    @staticmethod
    def soonest(word_at: int) -> int:
        """When ``wh_brushless`` drives what it makes of a word."""
        return word_at + 80 + 10 * SHAPER

    def legs_equal(self, later: int) -> bool:
        """Whether the legs of ``wh_ports`` are the other ones' so many clocks later."""
        half = len(self.gates) // 2
        wanted = [gates for gates, _ in self.gates[half - later : len(self.gates) - later]]
        return wanted == [gates for _, gates in self.gates[half:]]


@cocotb.test(timeout_time=10, timeout_unit="sec", skip=MIXED)
async def the_shortest_period(dut: object) -> None:
    """No step is lost, no two ask for a product at once, and gates come a tick later at most."""
    rng = random_source("shortest")
    bench = ShortBench(dut, rng)
    await bench.power_up()
    found = shifted = 0
    for _ in range(2 if "Icarus" in cocotb.SIM_NAME else 24):
        await bench.begin()
        await bench.tick()
        # Before a word, so that both begin with the same one.
        await bench.step((bench.word_at - 4) % bench.tick_clocks)
        bench.drive(enable_i=1)
        await bench.collect(60 * bench.tick_clocks)
        assert not bench.word("met_o")
        assert not bench.word("faults_o") & OVERRUN
        if bench.word("controller_faults_o") & OVERRUN:
            continue  # wh_brushless isn't so fast
        for place, wanted in bench.wanted.items():
            shown = bench.shown[place]
            # What the one shows before its first step, the other doesn't.
            starts = [n for n in range(3) if wanted[n : n + 50] == shown[:50]]
            starts += [n for n in range(3) if shown[n : n + 50] == wanted[:50]]
            assert starts, (place, wanted[:5], shown[:5])
            found += len(set(shown)) > 10
        assert bench.legs_equal(bench.later * bench.tick_clocks), (bench.word_at, bench.later)
        shifted += bench.later
    cocotb.log.info("%d series of values, %d gates a tick later", found, shifted)
    assert found > 5
