# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_motor_device.v``: each word of the table from the bus to its port, and back."""

from __future__ import annotations

import random
from typing import Any

import cocotb
from bench import random_source
from settings_bus import (
    BUSY,
    COMMIT,
    DISCARD,
    DONE,
    NOT_NOW,
    RANGE,
    REQUEST_CLOCKS,
    UNKNOWN,
    BusBench,
)  # fmt: skip
from simulators import parameters
from wavehaptics.controller.guard import Fault
from wavehaptics.controller.modulator import width_bounds
from wavehaptics.words import table
from wavehaptics.words.bridge_modes import HALF_BRIDGE as HALF_BRIDGE_NAME
from wavehaptics.words.bridge_modes import MODE_WORDS
from wavehaptics.words.bridge_modes import UNIPOLAR as UNIPOLAR_NAME
from wavehaptics.words.places import places
from wavehaptics.words.table import AXES, LEGS, THREE_PHASE_LEGS, WORDS, Sizes, Word

_P = {"N": 1, "WALLS": 4, "SHAPER": 0, "DELAY_LOG2": 2, "GUARD": 0, "CAPTURE": 0, "MIN_PULSE": 0,
      "LEGS": LEGS, **parameters()}  # fmt: skip
SIZES = Sizes(_P["N"], _P["WALLS"], _P["SHAPER"], _P["DELAY_LOG2"], _P["LEGS"])
BRUSHLESS = _P["LEGS"] == THREE_PHASE_LEGS
LINES = AXES if BRUSHLESS else SIZES.motors
"""Of ADCs."""
HALVES = 2 if BRUSHLESS else 1
"""Carrier halves in a tick, at least."""
MASK = 0xFFFFFFFF
SETTINGS = list(places(SIZES, "setting"))
BESIDE = {
    port: words
    for port, words in table.ports(beside=True).items()
    if words[0].row.kind == "setting"
}
"""Settings that are no ports of the controller, but wires of the device."""
GATES = ("gate_ah_o", "gate_al_o", "gate_bh_o", "gate_bl_o")
SAFE = {"half_clocks": 150, "tick_halves": HALVES, "sample_clocks": 100, "samples": 1,
        "guard_mask": 0, "guard_damp": 0, "guard_levels": 0}  # fmt: skip
"""Words with which ticks go on and no fault is found."""
OF = (SIZES.motors, SIZES.legs)


class DeviceBench(BusBench):
    """The device, with an ADC that says 0."""

    async def begin(self, enable: int = 0) -> None:
        more = {"anchor_fault_i": 0} if hasattr(self.dut, "anchor_fault_i") else {}
        await super().begin(
            enable_i=0, adc_sdata_i=0, enc_a_i=0, enc_b_i=0, bus_i=0x1234, stop_i=1,
            driver_fault_i=(1 << SIZES.motors) - 1, press_i=0, **more,
        )  # fmt: skip
        assert await self.write(BUSY, 1, 20_000) == UNKNOWN
        await self.rests()
        if enable:
            names = ("a", "gain", "root", "u_max", "clocks_per_volt")
            for motor in range(LINES):
                there = [name for name in names if motor < WORDS[name].parts(*OF)]
                await self.set(dict.fromkeys(there, 1 << 20), motor)
            await self.set(SAFE)
            self.drive(enable_i=1)

    async def set(self, values: dict[str, int], motor: int = 0) -> None:
        """Words of the board or of a motor, given while the bridges are off."""
        for name, raw in values.items():
            assert await self.write(WORDS[name].at(motor), raw & MASK) == DONE, name
        assert await self.write(COMMIT, 1) == DONE
        await self.rests()

    async def begin_ticks(self) -> None:
        """Wait for a tick to begin."""
        for _ in range(10_000):
            if self.word("tick_o"):
                return
            await self.step()
        raise AssertionError("no ticks")

    async def signed(self, address: int) -> int:
        """A word that can be read and has a sign."""
        raw = await self.value(address)
        return raw - (raw >> 31 << 32)

    def port(self, name: str) -> int:
        if name[:-2] in BESIDE:
            return int(getattr(self.dut, f"set_{name[:-2]}").value)
        return int(getattr(self.controller, name).value)

    @property
    def controller(self) -> Any:
        """What stands in the device."""
        return (self.dut.brushless if BRUSHLESS else self.dut.of_motors).controller

    def told(self, word: Word) -> int:
        """What a live word's port says, of the controller or of the device itself."""
        if word.block in table.BESIDE:
            return int(getattr(self.dut, word.port[:-2]).value)
        return self.port(word.port if word.name == "bus" else f"{word.port[:-2]}_o")

    def has(self, wanted: dict[str, int]) -> bool:
        """Whether the controller's inputs are these."""
        return {name: self.port(f"{name}_i") for name in wanted} == wanted


def expected_ports(raw: dict[int, int]) -> dict[str, int]:
    """Every input port of settings as the words at these addresses make it."""
    values: dict[str, list[int]] = {}
    for place in SETTINGS:
        word = raw[place.address]
        if place.word.fixed.signed and word >> 31:
            word -= 1 << 32
        if place.word.port[:-2] not in BESIDE:
            values.setdefault(place.word.name, []).append(word)
    commands = {w.port[:-2] for w in WORDS.values() if w.row.kind != "setting"}
    if not SIZES.sections:
        commands.add("shape_words")
    made = table.inputs(values, SIZES)
    found = {name[:-2]: bits for name, bits in made.items() if name[:-2] not in commands}
    for port, words in BESIDE.items():
        each = [(raw[w.at(0, n)], w.width(SIZES)) for w in words for n in range(w.row.count)]
        found[port] = table.side_by_side(each)
    return found


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def words_come_to_their_ports(dut: object) -> None:
    """Defaults, then any words in all ports at once, bridges off."""
    bench, rng = DeviceBench(dut), random_source("ports")
    await bench.begin()
    raw = {place.address: place.word.default & MASK for place in SETTINGS}
    for _ in range(3):
        wanted = expected_ports(raw)
        assert bench.has(wanted)
        for place in SETTINGS:
            raw[place.address] = rng.randint(*place.limits) & MASK
            assert await bench.write(place.address, raw[place.address]) == DONE
        assert bench.has(wanted)
        assert await bench.write(COMMIT, 1) == DONE
        await bench.rests()
    assert bench.has(expected_ports(raw))
    assert len(wanted) > 40


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def words_while_the_bridges_run(dut: object) -> None:
    """What may change does with the next commit; what may not is refused, and stays."""
    bench, rng = DeviceBench(dut), random_source("running")
    await bench.begin(enable=1)
    await bench.step(200)
    assert bench.word("running_o")
    raw = {place.address: await bench.value(place.address) for place in SETTINGS}
    before = expected_ports(raw)
    assert bench.has(before)
    changes = 0
    for place in SETTINGS:
        value = rng.randint(*place.limits) & MASK
        off = place.word.change == "off"
        assert await bench.write(place.address, value) == (NOT_NOW if off else DONE)
        if not off:
            raw[place.address] = value
            changes += 1
    assert bench.has(before)
    assert await bench.write(COMMIT, 1) == DONE
    await bench.rests()
    assert bench.has(expected_ports(raw))
    assert bench.word("running_o")
    assert changes > 10


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def live_words_and_commands(dut: object) -> None:
    """Each live word is its port's, with its sign; each command reaches its port for a clock."""
    bench, rng = DeviceBench(dut), random_source("live")
    await bench.begin(enable=1)
    await bench.step(300)
    bench.drive(enc_a_i=1)
    seen = set()
    own = ("settings_busy", "settings_staged", "tick", "core_valid", "words_hold", "capture_data")

    def told(word: Word, motor: int, bits: int) -> int:
        part = bench.told(word) >> motor * bits & (1 << bits) - 1
        if word.fixed.signed and part >> bits - 1:
            part -= 1 << bits
        return part & MASK

    # A packet's words are those that stood when the first of them was read, or two clocks before.
    packet = ("host_packet_sequence", "host_v")
    for _ in range(4):
        of_packet: dict[tuple[str, int], set[int]] = {}
        await bench.step(rng.randint(1, 100))
        for place in places(SIZES, "live"):
            word = place.word
            if word.name in own or word.block == "wh_surface_frame":  # of wh_ports_device alone
                continue
            motor = max(0, (place.address >> 8) - 1)
            lead = 2 if word.name == "host_packet" else 0
            stood = of_packet.get((word.name, motor), set())
            for clock in range(lead + 8):
                if clock == lead:
                    bench.drive(bus_valid_i=1, bus_write_i=0, bus_address_i=place.address)
                if word.name not in packet:
                    stood.add(told(word, motor, place.bits))
                if word.name == "host_packet":
                    for name in packet:
                        other = WORDS[name]
                        seen_of = of_packet.setdefault((name, motor), set())
                        seen_of.add(told(other, motor, other.fixed.width))
                await bench.step()
                if clock >= lead and bench.word("bus_ready_o"):
                    break
            assert bench.word("bus_error_o") == DONE
            raw = bench.word("bus_data_o")
            assert raw in stood, (word.name, raw, stood)
            seen.add(raw)
            bench.drive(bus_valid_i=0)
            await bench.step()
    assert len(seen) > 3
    for place in places(SIZES, "command"):
        word = place.word
        if word.block in (table.MEMORY, *table.BESIDE) or word.name == "restart":
            continue
        motor = max(0, (place.address >> 8) - 1)
        value = rng.randint(max(1, place.limits[0]), place.limits[1])
        mask = (1 << place.bits) - 1
        clocks = 0
        if word.row.off:
            assert await bench.write(place.address, value & MASK) == NOT_NOW, word.name
            bench.drive(enable_i=0)
            await bench.step(2)
        bench.drive(
            bus_valid_i=1, bus_write_i=1, bus_address_i=place.address, bus_data_i=value & MASK
        )
        for _ in range(12):
            await bench.step()
            if bench.word("bus_ready_o"):
                bench.drive(bus_valid_i=0)
            # As text: other motors' data are undefined until they are first written.
            shown = str(getattr(bench.controller, word.port).value)
            end = len(shown) - motor * place.bits
            clocks += shown[end - place.bits : end] == f"{value & mask:0{place.bits}b}"
        assert clocks == 1 if place.bits == 1 else clocks > 4, word.name
        bench.drive(enable_i=1)
        await bench.step(2)


@cocotb.test(timeout_time=500, timeout_unit="ms")
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


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def a_restart_forgets_the_samples_before_it(dut: object) -> None:
    """Wherever in a tick it comes, the first step has a current that was sampled after it."""
    bench = DeviceBench(dut)
    await bench.begin(enable=1)
    tick, steps = SAFE["half_clocks"] * HALVES, 0
    for phase in range(0, tick, 2):
        bench.drive(enable_i=0)
        await bench.begin_ticks()
        await bench.step(phase)
        bench.drive(bus_valid_i=1, bus_write_i=1, bus_address_i=WORDS["restart"].at(), bus_data_i=1)
        for _ in range(REQUEST_CLOCKS):
            await bench.step()
            if bench.word("bus_ready_o"):
                bench.drive(bus_valid_i=0)
            if bench.word("set_restart"):
                break
        assert bench.word("set_restart")
        await bench.step(bus_valid_i=0)
        bench.drive(enable_i=1)
        frames, selected = 0, bench.word("adc_cs_n_o")
        for _ in range(2 * tick):
            if bench.word("core_valid"):
                assert frames > 0, phase
                steps += 1
                break
            await bench.step()
            before, selected = selected, bench.word("adc_cs_n_o")
            frames += before and not selected
    assert steps == tick // 2


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


@cocotb.test(timeout_time=500, timeout_unit="ms", skip=not (_P["GUARD"] and _P["MIN_PULSE"]))
async def no_voltage_where_none_is_asked_for(dut: object) -> None:
    """At 0 V the bridge gives none, in each mode; settings that leave it no pulse are a fault."""
    bench = DeviceBench(dut)
    await bench.begin(enable=1)
    for motor in range(LINES):  # all that the waves ask for is less than a microvolt
        there = [name for name in ("root", "gain", "u_max") if motor < WORDS[name].parts(*OF)]
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
                    bench.word(f"gate_b{side}_o") << 1 | bench.word(f"gate_a{side}_o")
                    for side in "hl"
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


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def words_at_the_pins(dut: object) -> None:
    """Ticks and frames as long as the words say; each live word with its width, its bits moving."""
    bench, rng = DeviceBench(dut), random_source("pins")
    await bench.begin()
    carrier, halves = 12, 130
    timing = {"half_clocks": carrier, "tick_halves": halves, "sample_clocks": carrier * halves}
    await bench.set(timing)
    await bench.begin_ticks()
    frames = rises = clocks = 0
    chosen = bench.word("adc_cs_n_o")
    while not (clocks and bench.word("tick_o")):
        before = bench.word("adc_sclk_o")
        await bench.step()
        rises += bench.word("adc_sclk_o") > before
        frames += bench.word("adc_cs_n_o") < chosen
        chosen, clocks = bench.word("adc_cs_n_o"), clocks + 1
    assert clocks == carrier * halves
    assert (frames, rises) == (1, WORDS["frame_bits"].default)
    # A shift of the zero is one of the current, which is the same from tick to tick.
    motor, current = SIZES.motors - 1, WORDS["current"]
    await bench.set({"gain": 1 << 20}, motor)
    found = {}
    for zero in (0, 8, 16, 24):
        await bench.set({"zero": zero}, motor)
        await bench.step(3 * clocks)
        found[zero] = await bench.signed(current.at(motor))
    shift = found[0] - found[8]
    assert shift != 0
    assert [found[0] - found[zero] for zero in (8, 16, 24)] == [shift, 2 * shift, 3 * shift]
    # Beyond a word's width there is its sign, or nothing; of those that move the lowest bits do.
    await bench.set(SAFE | {"tick_halves": 4, "sample_clocks": 600})
    odd = {"gain": 0x2345, "root": 0x165432, "a": 0x123457, "u_max": 1 << 24}
    odd |= {"clocks_per_volt": 1 << 20, "bus_share": 1 << 20}
    await bench.set({name: raw for name, raw in odd.items() if WORDS[name].parts(*OF)}, motor)
    bench.drive(enable_i=1)
    told = [p for p in places(SIZES, "live") if p.word.name != "capture_data"]
    moving = {name: [0, MASK] for name in ("voltage", "u", "v", "current")}
    for _ in range(40):
        for _ in range(rng.randint(300, 600)):
            bench.drive(adc_sdata_i=rng.getrandbits(LINES))
            await bench.step(2)
        for place in told:
            raw = await bench.value(place.address)
            sign = place.word.fixed.signed and raw >> place.bits - 1 & 1
            assert raw >> place.bits == (MASK >> place.bits if sign else 0), place.word.name
            if place.word.name in moving and place.address >> 8 == motor + 1:
                ones, zeros = moving[place.word.name]
                moving[place.word.name] = [ones | raw, zeros & raw]
    for name, (ones, zeros) in moving.items():
        assert (ones & 0xFF, zeros & 0xFF) == (0xFF, 0), name


@cocotb.test(timeout_time=500, timeout_unit="ms", skip=not _P["CAPTURE"])
async def a_capture_over_the_bus(dut: object) -> None:
    """Rows of the words that stood at the steps, with the bridges on and without."""
    bench, rng = DeviceBench(dut), random_source("capture")
    await bench.begin(enable=1)
    names = ("position", "current", "u", "v", "voltage", "flags")
    motor = SIZES.motors - 1
    codes = [WORDS[name].at(motor) for name in names] + [WORDS["faults"].at()]
    told = [WORDS[name] for name in (*names, "faults")]
    steps: list[list[int]] = []
    stepped = missed = False
    strobes = [getattr(bench.controller, name) for name in ("core_valid_o", "tick_o")]

    def part(word: Word) -> int:
        shift = 0 if word.row.per == "board" else motor * word.width(SIZES)
        raw = bench.told(word) >> shift & (1 << word.width(SIZES)) - 1
        return raw - (word.fixed.signed and raw >> word.width(SIZES) - 1) * (1 << word.width(SIZES))

    async def listen() -> None:
        nonlocal stepped, missed
        turn = 0
        while True:
            await bench._falling
            valid, tick = int(strobes[0].value), int(strobes[1].value)
            if valid or missed:
                steps.append([part(word) & MASK for word in told])
            missed = bool(tick and not valid and not stepped)
            stepped = not tick and (stepped or bool(valid))
            turn += 1
            bench.drive(adc_sdata_i=rng.getrandbits(LINES), enc_a_i=turn >> 6 & 1,
                        enc_b_i=turn + 32 >> 6 & 1)  # fmt: skip

    listening = cocotb.start_soon(listen())
    rows, each = (1 << _P["CAPTURE"]) // len(codes), len(codes)
    for running in (1, 0):
        bench.drive(enable_i=running)
        given = {"capture_channels": each, "capture_rows": rows, "capture_pre": rows // 2}
        requests = [(WORDS["capture_channel"].at(0, n), code) for n, code in enumerate(codes)]
        requests += [(WORDS[name].at(), raw) for name, raw in given.items()]
        for address, raw in [*requests, (COMMIT, 1)]:
            assert await bench.write(address, raw) == DONE
        # It waits until the settings are there.
        assert await bench.write(WORDS["capture"].at(), 1) == DONE
        await bench.rests()
        steps.clear()
        await bench.step(rng.randint(1, 200))
        assert await bench.write(WORDS["capture"].at(), 2) == DONE
        while await bench.value(WORDS["capture_state"].at()) != 4:
            assert len(steps) < 20 * rows
        assert bench.word("running_o") == running
        await bench.step(350)
        first = await bench.value(WORDS["capture_first"].at())
        assert await bench.value(WORDS["capture_count"].at()) == rows
        assert await bench.value(WORDS["capture_left"].at()) == 0
        found = []
        for n in range(rows * each):
            offset = n // 10 * 10
            assert n % 10 or await bench.write(WORDS["capture_offset"].at(), offset) == DONE
            found.append(await bench.value(WORDS["capture_data"].at(0, n - offset)))
        ring = [found[n * each : (n + 1) * each] for n in range(rows)]
        in_order = ring[first:] + ring[:first]
        assert any(steps[n : n + rows] == in_order for n in range(len(steps)))
        assert len({row[1] for row in in_order}) > 1
    assert not listening.done()
    listening.cancel()
