# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_registers.v``: what a round reads is of one commit, whatever the bus does.

bench_registers.v has the stations' memories and ``wh_slots``. Of each slot it adds up all that is
read in it; the model here has that sum for each commit and port. Requests, live values, rounds and
the pin that lets the bridges on are random, each at any clock.
"""

from __future__ import annotations

import random

import cocotb
from bench import Bench, random_source
from cocotb.triggers import RisingEdge
from settings_bus import BUSY, COMMIT, DISCARD, DONE, NOT_NOW, RANGE, STAGED, UNKNOWN, BusBench
from simulators import parameters
from wavehaptics.words import formats
from wavehaptics.words.places import Place, places
from wavehaptics.words.table import THREE_PHASE_LEGS, WORDS, Sizes

_P = {"N": 1, "WALLS": 4, "SHAPER": 0, "DELAY_LOG2": 2, "AXES": 0, **parameters()}
N, AXES = _P["N"], _P["AXES"]
SIZES = Sizes(N, _P["WALLS"], _P["SHAPER"], _P["DELAY_LOG2"])


def all_places(kind: str) -> list[Place]:
    """Every copy of the words of a kind; with a brushless motor those that it alone has, too."""
    found = list(places(SIZES, kind))
    if AXES:
        of_one = Sizes(1, _P["WALLS"], _P["SHAPER"], _P["DELAY_LOG2"], THREE_PHASE_LEGS)
        found += [place for place in places(of_one, kind) if place.word.row.brushless == "only"]
    return found


SETTINGS = all_places("setting")
AT = {place.address: place for place in SETTINGS}
LIVE = {place.address for place in all_places("live")}
COMMANDS = {place.address: place for place in all_places("command")}
MASK = 0xFFFFFFFF

FIRST_CLOCKS = 3000
ANSWER_CLOCKS = 5
COPIED = 96 + N * (152 if _P["SHAPER"] else 128)
SETTLE = 27 + 36 * N
LEAST_CLOCKS = COPIED + 2 + SETTLE
"""Clocks of ``busy_o`` without a request in the meantime."""
MOST_CLOCKS = COPIED + COPIED // 5 + 3 + SETTLE

FACTOR, SUM_MASK = 0x9E3779B97F4A7C15, (1 << 64) - 1
DATA, COEF = formats.DATA_W, formats.COEF_W
MEMORIES = (
    (0x00, 1, formats.SUM_W), (0x01, 1, COEF), (0x08, 2, COEF), (0x10, 4, DATA), (0x18, 1, COEF),
    (0x1A, 1, DATA), (0x20, 16, DATA), (0x30, 1, 1), (0x40, 8, formats.COUNT_W),
    (0x50, 8, formats.COUNT_W), (0x60, 8, 1), (0x70, 8, 1), (0x80, 32, 31), (0x90, 8, 12),
)[: 14 if _P["SHAPER"] else 12]  # fmt: skip
"""First address, words and bits of the stations' memories."""
WINDOW = 32
"""Reads of each in a slot."""
GROUPS = (
    ("half_clocks", 6), ("sclk_half_clocks", 10), ("trip", 1), ("range", 3), ("filter_clocks", 1),
    ("extra_ticks", 2), ("mode", 6), ("guard_mask", 16),
    ("guard_saturated", 1), ("host_period_log2", 2), *((("count_angle", 3),) if AXES else ()),
)  # fmt: skip
"""Settings of all ports as they are packed: the first of each group, and how many it has."""
STROBES = {"clear": 1, "host_alive": 2, "zero_start": 4, "restart": 8, "magnet_start": 32}
STEPPED = ("voltage", "u", "v", "correction", "offset", "flux", "lag")
HELD = ("current", "position", "contact_energy", "contact_energy_peak", "host_packet_sequence",
        "host_v")  # fmt: skip
LIVE_WORDS = {
    "voltage": 0, "u": 1, "v": 2, "current": 3, "position": 4, "contact_energy": 6,
    "contact_energy_peak": 7, "correction": 8, "offset": 9, "flux": 10, "lag": 11,
    "host_v": 12, "host_packet_sequence": 13,
}  # fmt: skip
FLAGS = {
    "contact": 0, "saturated": 1, "clipped": 8, "anchor_fault": 6, "adc_range": 4,
    "encoder_fault": 5, "overcurrent": 3, "adc_stuck": 10, "host_active": 7,
}  # fmt: skip
FLAG_WORD, CORRECTION = 5, 8

Settings = dict[int, int]
KINDS = ("write",) * 6 + ("read",) * 3 + ("command",) * 3 + ("commit", "discard", "any")
"""Requests, of which one is drawn."""


def port_sum(settings: Settings, port: int) -> int:
    """What a slot of the port adds up."""
    total = 0
    for first, words, bits in MEMORIES:
        for place in range(words):
            word = settings.get((port + 1) << 8 | first + place, 0) & (1 << bits) - 1
            total += WINDOW // words * word * FACTOR * (first + place + 1)
    return total & SUM_MASK


def in_common(settings: Settings) -> Settings:
    """As they are committed: what both axes have in common is alpha's."""
    found = dict(settings)
    for place in SETTINGS:
        part, own = place.address >> 8, place.address & 0xFF
        if part > 1 and AXES >> part - 2 & 1 and own > WORDS["gain"].at() & 0xFF:
            found[place.address] = settings[place.address - 0x100]
    return found


def packed(settings: Settings) -> int:
    """The settings of all ports, side by side."""
    total = place = 0
    for name, count in GROUPS:
        for address in range(WORDS[name].at(), WORDS[name].at() + count):
            bits = AT[address].bits
            total |= (settings[address] & (1 << bits) - 1) << place
            place += bits
    return total


def wants_off(place: Place) -> bool:
    return place.word.change == "off"


class RegistersBench(BusBench):
    """The registers, their model, and what goes on beside the bus."""

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut)
        self.rng = rng
        self.live_rate = self.round_rate = 0.0
        self.in_reset = True
        self.slots = 0
        self.model_reset()
        self.watch = cocotb.start_soon(self.watch_slots())

    def model_reset(self) -> None:
        self.written = {place.address: place.word.default & MASK for place in SETTINGS}
        self.commits = [dict(self.written)]
        self.sums: dict[tuple[int, int], int] = {}
        self.staged = self.staged_off = False
        self.strobes = self.ticks = 0
        self.live = [[0] * 16 for _ in range(N)]
        self.stepped = [False] * N
        self.running = self.busy = self.enabled = 0

    def enable(self, enabled: int) -> None:
        """The pin that lets the bridges on."""
        self.enabled = enabled
        self.drive(enable_i=enabled)

    async def power_up(self) -> None:
        """Reset at any clock, until the defaults are there."""
        self.drive(
            enable_i=0, adc_ready_i=0, tick_i=0, faults_i=0, live_valid_i=0, live_port_i=0,
            live_word_i=0, live_data_i=0, other_i=0, summed_i=0,
        )  # fmt: skip
        self.handle("rst").value = 1
        self.in_reset = True
        await BusBench.begin(self)
        self.in_reset = False
        self.model_reset()
        for clock in range(FIRST_CLOCKS):
            if self.word("ready_o"):
                break
            assert self.word("loading_o"), clock
            await Bench.step(self)
        else:
            raise AssertionError("no defaults")
        assert clock <= MOST_CLOCKS
        assert self.word("all_o") == packed(self.commits[0])
        self.live_rate, self.round_rate = 0.2, 1 / (16 * N)

    async def watch_slots(self) -> None:
        """Each slot's words are of the commit that was in force as its round began."""
        while True:
            await RisingEdge(self.dut.sum_valid_o)
            await cocotb.triggers.FallingEdge(self.dut.clk)
            commit, port = self.word("sum_generation_o"), self.word("sum_port_o")
            key = commit, port
            if key not in self.sums:
                self.sums[key] = port_sum(self.commits[commit], port)
            assert self.word("sum_o") == self.sums[key], f"slot of port {port}, commit {commit}"
            self.slots += 1

    async def step(self, clocks: int = 1, **inputs: int) -> None:
        """One clock after another, with all that goes on beside the bus."""
        rng = self.rng
        if self.in_reset:
            await Bench.step(self, clocks, **inputs)
            return
        for _ in range(clocks):
            inputs.setdefault("summed_i", rng.random() < self.round_rate)
            inputs.setdefault("tick_i", rng.random() < self.round_rate)
            tells = rng.random() < self.live_rate
            port, word, data = rng.randrange(N), rng.randrange(12), rng.getrandbits(32)
            inputs |= {"live_valid_i": tells, "live_port_i": port, "live_word_i": word}
            self.busy = self.word("busy_o")
            self.running = int(self.enabled and not self.word("loading_o"))
            await Bench.step(self, **inputs, live_data_i=data)
            self.ticks = self.ticks + inputs["tick_i"] & MASK
            if tells:
                self.live[port][word] = data
            if not self.running:
                self.stepped = [False] * N
            elif tells and word == CORRECTION:
                self.stepped[port] = True
            inputs = {}

    def live_value(self, word: str, port: int) -> int:
        """What a live register reads now."""
        live = self.live[port]
        if word in FLAGS:
            return live[FLAG_WORD] >> FLAGS[word] & 1
        if word == "flags":
            return live[FLAG_WORD] & 0xFF
        value = live[LIVE_WORDS[word]]
        return value if word in HELD or self.stepped[port] else 0

    def verdict(self, write: int, address: int, data: int) -> int:
        """The error of a request, as of the clock in which it is judged."""
        if not write:
            return DONE if address in AT or address in LIVE else UNKNOWN
        place = AT.get(address) or COMMANDS.get(address)
        if place is None:
            return UNKNOWN
        low, high = place.limits
        value = data - (1 << 32) if place.word.fixed.signed and data >> 31 else data
        if not low <= value <= high:
            return RANGE
        if self.busy and (address in AT or address in (COMMIT, DISCARD)):
            return NOT_NOW
        off = place.word.row.off or (address in AT and wants_off(place))
        off = off or (address == COMMIT and self.staged_off)
        return NOT_NOW if off and self.running else DONE

    async def ask(self, write: int, address: int, data: int = 0, check: int = 0) -> int:
        """A request, whose answer, time and effect are the model's."""
        self.drive(
            bus_valid_i=1, bus_write_i=write, bus_check_i=check, bus_address_i=address,
            bus_data_i=data,
        )  # fmt: skip
        for _ in range(ANSWER_CLOCKS):
            assert not self.word("bus_ready_o")
            await self.step()
            assert self.word("strobes_o") == self.strobes & 0xFFFF
        assert self.word("bus_ready_o"), hex(address)
        error, expected = self.word("bus_error_o"), self.verdict(write, address, data)
        assert error == expected, f"0x{address:03x} {data:x}: {error}, not {expected}"
        read = self.word("bus_data_o")
        if not write and address in AT:
            assert read == self.written[address], AT[address].word.name
        elif not write and error:
            assert read == 0
        takes = write and not check and error == DONE
        strobe = int(takes and address in COMMANDS and address not in (COMMIT, DISCARD))
        self.drive(bus_valid_i=0, bus_check_i=0)
        if takes and address in AT:
            self.written[address] = data
            self.staged = True
            self.staged_off |= wants_off(AT[address])
        begins = takes and address in (COMMIT, DISCARD) and data & 1
        if begins:
            if address == COMMIT:
                self.commits.append(in_common(self.written))
            else:
                self.commits.append(dict(self.commits[-1]))
                self.written = dict(self.commits[-1])
            loads = address == COMMIT and self.staged_off
            self.staged = self.staged_off = False
        await self.step()
        assert not self.word("bus_ready_o")
        if begins:
            assert self.word("busy_o")
            assert self.word("loading_o") or not loads
        # A command's strobe is there in the clock after the answer, whatever is under way.
        self.expect_strobe(strobe, address, data)
        self.strobes += strobe
        return error

    def expect_strobe(self, strobe: int, address: int, data: int) -> None:
        found = self.word("commands_o")
        assert found >> 4 & 1 == strobe
        if strobe:
            assert self.word("command_address_o") == address
            assert self.word("command_data_o") == data
        for name, bit in STROBES.items():
            own = strobe and address == WORDS[name].at() and data & 1
            own = own and (AXES or name != "magnet_start")
            held = name == "restart" and self.word("loading_o")
            assert bool(found & bit) == bool(own or held), name

    async def expect_rest(self) -> None:
        """Each commit of the model was made, once, and what was written is in force."""
        for _ in range(MOST_CLOCKS):
            if not self.word("busy_o"):
                break
            await self.step()
        await self.step()
        assert not self.word("busy_o")
        assert self.word("generation_o") == len(self.commits) - 1
        assert self.word("all_o") == packed(self.commits[-1])
        assert not self.word("mixed_o")
        assert self.word("busy_clocks_o") <= MOST_CLOCKS

    def some_setting(self) -> tuple[int, int]:
        """A setting and a value, which may be outside its range."""
        place = self.rng.choice(SETTINGS)
        low, high = place.limits
        raw = self.rng.choice((low, high, self.rng.randint(low, high), self.rng.randint(low, high)))
        if self.rng.random() < 0.1 and place.outside:
            raw = self.rng.choice(place.outside)
        return place.address, raw & MASK


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def random_requests(dut: object) -> None:
    """Writes, reads, commits, discards and commands at any clock, and resets amid them."""
    rng = random_source("random")
    bench = RegistersBench(dut, rng)
    seen: dict[str, int] = {}
    commits = 0
    commands = sorted(COMMANDS.keys() - {COMMIT, DISCARD})
    for _ in range(3):
        await bench.power_up()
        for _ in range(500):
            if rng.random() < 0.3:
                await bench.step(rng.choice((1, 1, 2, 5, 30, 200)))
            if rng.random() < 0.25:
                bench.enable(int(rng.random() < 0.5))
                await bench.step()
            kind = rng.choice(KINDS)
            if kind == "write":
                error = await bench.ask(1, *bench.some_setting(), int(rng.random() < 0.1))
            elif kind == "read":
                error = await bench.ask(0, rng.choice(SETTINGS).address)
            elif kind == "command":
                error = await bench.ask(1, rng.choice(commands), rng.choice((0, 1, 1, 1, 2)))
            elif kind == "any":
                address, data = rng.randrange(1 << 12), rng.getrandbits(32)
                error = await bench.ask(rng.randrange(2), address, data)
            else:
                address = COMMIT if kind == "commit" else DISCARD
                error = await bench.ask(1, address, int(rng.random() < 0.9))
            key = f"{kind} {error}" + (" busy" if bench.busy else "")
            seen[key] = seen.get(key, 0) + 1
            if rng.random() < 0.08:
                await bench.expect_rest()
        await bench.expect_rest()
        commits += len(bench.commits) - 1
        # The next reset comes amid a commit.
        bench.enable(0)
        await bench.step(2)
        await bench.ask(1, *bench.some_setting())
        await bench.ask(1, COMMIT, 1)
        await bench.step(rng.randrange(COPIED))
    cocotb.log.info("%d commits, %d slots, %s", commits, bench.slots, seen)
    assert commits > 25
    assert bench.slots > 500
    for key in (
        "write 0", "write 2", "write 3", "read 0", "read 0 busy", "command 0", "command 0 busy",
        "commit 0", "commit 3 busy", "discard 0", "discard 3 busy", "any 1",
    ):  # fmt: skip
        assert seen.get(key, 0) > 0, key


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def every_setting_arrives(dut: object) -> None:
    """Each is written with both ends of its range, and all together with something between."""
    rng = random_source("every")
    bench = RegistersBench(dut, rng)
    await bench.power_up()
    for turn in range(3):
        for place in SETTINGS:
            low, high = place.limits
            raw = (low, high, rng.randint(low, high))[turn] & MASK
            assert await bench.ask(1, place.address, raw) == DONE, place.word.name
        assert await bench.value(STAGED) == 1
        assert await bench.ask(1, COMMIT, 1) == DONE
        assert await bench.value(BUSY) == 1
        await bench.expect_rest()
        assert await bench.value(STAGED) == await bench.value(BUSY) == 0
        before = bench.slots
        await bench.step(100 * N)
        assert bench.slots > before
    for place in SETTINGS:
        await bench.ask(0, place.address)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def some_need_the_bridges_off(dut: object) -> None:
    """Neither written nor committed while these are on; their commit keeps the bridges off."""
    rng = random_source("off")
    bench = RegistersBench(dut, rng)
    await bench.power_up()
    off = [place for place in SETTINGS if wants_off(place)]
    on = [place for place in SETTINGS if not wants_off(place)]
    for _ in range(20):
        bench.enable(0)
        await bench.step()
        place, other = rng.choice(off), rng.choice(on)
        assert await bench.ask(1, place.address, rng.randint(*place.limits) & MASK) == DONE
        bench.enable(1)
        await bench.step()
        assert await bench.ask(1, rng.choice(off).address, 1) in (NOT_NOW, RANGE)
        assert await bench.ask(1, other.address, rng.randint(*other.limits) & MASK) == DONE
        assert await bench.ask(1, COMMIT, 1) == NOT_NOW
        if rng.random() < 0.3:
            assert await bench.ask(1, DISCARD, 1) == DONE
            assert not bench.word("loading_o")
        else:
            bench.enable(0)
            await bench.step()
            assert await bench.ask(1, COMMIT, 1) == DONE
            bench.enable(1)
            while bench.word("busy_o"):
                assert bench.word("loading_o")
                assert not bench.word("running_o")
                await bench.step()
        await bench.expect_rest()
        assert bench.word("running_o")


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def a_commit_takes_its_clocks(dut: object) -> None:
    """Without requests the least, with one after another no more than the header has."""
    rng = random_source("clocks")
    bench = RegistersBench(dut, rng)
    await bench.power_up()
    place = next(place for place in SETTINGS if not wants_off(place))
    for turn in range(4):
        bench.enable(turn & 1)
        await bench.step()
        assert await bench.ask(1, place.address, place.limits[turn & 1] & MASK) == DONE
        assert await bench.ask(1, COMMIT, 1) == DONE
        clocks = 0
        while bench.word("busy_o"):
            if turn > 1:
                bench.drive(bus_valid_i=1, bus_write_i=0, bus_address_i=place.address)
            await bench.step()
            clocks += 1
        while turn > 1 and not bench.word("bus_ready_o"):
            await bench.step()
        bench.drive(bus_valid_i=0)
        await bench.step()
        if turn < 2:
            assert clocks == LEAST_CLOCKS
        else:
            assert LEAST_CLOCKS + COPIED // 6 - 2 <= clocks <= MOST_CLOCKS
        cocotb.log.info("a commit of %d ports: %d clocks", N, clocks)
    await bench.expect_rest()
    assert LEAST_CLOCKS < bench.word("busy_clocks_o") <= MOST_CLOCKS


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def live_values_are_the_last(dut: object) -> None:
    """Of each port and word; those of a step are 0 with the bridges off, until the next step."""
    rng = random_source("live")
    bench = RegistersBench(dut, rng)
    await bench.power_up()
    names = (*STEPPED, *HELD, *FLAGS, "flags")
    seen = set()
    for _ in range(300):
        if rng.random() < 0.25:
            bench.enable(rng.randrange(2))
        bench.live_rate = 0.5
        await bench.step(rng.choice((1, 5, 30, 60)))
        bench.live_rate = 0.0
        await bench.step(2)
        name, port = rng.choice(names), rng.randrange(N)
        faults, other, ready = rng.getrandbits(24), rng.getrandbits(32), rng.randrange(2)
        bench.drive(faults_i=faults, other_i=other, adc_ready_i=ready)
        assert await bench.value(WORDS[name].at(port)) == bench.live_value(name, port), name
        seen.add((name, bench.stepped[port]))
        assert await bench.value(WORDS["faults"].at()) == faults
        assert await bench.value(WORDS["overrun"].at()) == faults >> 14 & 1
        assert await bench.value(WORDS["running"].at()) == bench.running
        assert await bench.value(WORDS["adc_ready"].at()) == ready
        assert await bench.value(WORDS["arm_refused"].at()) == other
        bench.round_rate = 0.0
        await bench.step()
        assert await bench.value(WORDS["ticks"].at()) == bench.ticks
        bench.round_rate = 1 / (16 * N)
    assert len(seen) > len(names) + 5
