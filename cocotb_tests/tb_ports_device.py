# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_device.v``: what the bus says is what ``wh_ports`` did, in each round.

Beside the bus the bench listens to the live values of ``wh_ports``, in each clock, and answers as
ADCs and encoders do.
"""

from __future__ import annotations

import random
from collections import Counter

import cocotb
from bench import pack, random_source
from cobs_frames import packet
from settings_bus import COMMIT, DONE, NOT_NOW
from simulators import parameters
from tb_capture import CODES, Model, N, Settings, Tick, word32
from tb_capture import DONE as STOPPED
from tb_device import GATES, MASK, SAFE, SETTINGS, SIZES, DeviceBench
from tb_registers import FLAGS, HELD, STEPPED
from tb_round_words import DAMPED, ENDS, LIVE, WHEN, words_of_a_round
from tb_stream import row
from wavehaptics.controller.guard import Fault
from wavehaptics.words.faults import ARM_REFUSALS
from wavehaptics.words.places import Place, places
from wavehaptics.words.table import WORDS

SHAPER, CREDIT = parameters()["SHAPER"], parameters()["ARM_CLOCKS"]
PERIOD = SAFE["half_clocks"]
NAMES = {code: name for name, code in LIVE.items()}
MIDDLE = 1 << 11
MOST_ZERO = (1 << 23) - 1
ANCHOR = {
    "anchor_enable": 1, "anchor_flux_gain": 1 << 14, "anchor_cells_gain": 1 << 10,
    "anchor_pull_gain": 1 << 14, "anchor_zero_gain": 1 << 20, "anchor_reach": 1 << 22,
    "anchor_strange": (1 << 30) - 1, "anchor_follow_ticks": 1, "anchor_slow_ticks": 1,
}  # fmt: skip
ZERO_CLOCKS = ((1 << parameters()["ZERO_LOG2"]) + 6) * PERIOD
ORDERS = {"start": 1, "trigger": 2, "stop": 0}
FLAGS_8 = 0xFF


class PortsDeviceBench(DeviceBench):
    """The device, its pins, and all that its ports tell."""

    def __init__(self, dut: object, rng: random.Random) -> None:
        super().__init__(dut)
        self.rng = rng
        self.moving = False
        self.codes = [MIDDLE] * N
        self.counts = [0] * N
        self.bus = 0x1234

    async def begin(self, **settings: int) -> None:
        """Reset, settings of :data:`SAFE`; the switch permits the bridges."""
        self.now = self.ends = -1
        self.began: dict[int, int] = {}  # clock of each port's slot
        self.live: dict[tuple[str, int], int] = {}  # of the round
        self.last: dict[tuple[str, int], int] = {}  # of all
        self.seen: Counter[str] = Counter()
        self.rounds: list[dict[tuple[str, int], int]] = []
        self.contact = 0
        self.model = Model()
        self.given = Settings()
        self.streamed: list[dict[tuple[str, int], int]] = []
        self.bytes, self.packets = bytearray(), []
        self.drive(clear_i=0, zero_start_i=0, stream_room_i=1, rst=1)
        await super().begin(enable=1)
        self.drive(stop_i=0, driver_fault_i=0)
        self.watching = cocotb.start_soon(self.watch())
        self.drive(enable_i=0)
        await self.set({"zero_limit": MOST_ZERO, **settings})
        for motor in range(N):
            await self.set({"wall_max": 1000, "wall_enable": 1}, motor)
        assert await self.write(WORDS["clear"].at(), 1) == DONE
        self.drive(enable_i=1)
        await self.step(ZERO_CLOCKS)

    async def command(self, name: str, value: int = 1) -> None:
        assert await self.write(WORDS[name].at(), value) == DONE, name

    async def arm(self) -> None:
        await self.command("arm")
        await self.step(ZERO_CLOCKS)
        await self.expect_armed()

    async def expect_armed(self) -> None:
        assert self.word("running_o") == 1
        assert await self.value(WORDS["armed"].at()) == 1
        assert await self.value(WORDS["arm_refused"].at()) == 0

    async def expect_off(self, *reasons: int) -> None:
        refused = sum(1 << reason for reason in reasons)
        assert self.word("running_o") == 0
        assert await self.value(WORDS["armed"].at()) == 0
        assert await self.value(WORDS["arm_refused"].at()) == refused
        assert not any(self.word(gate) for gate in GATES)

    # ---- What goes on beside the bus, in each clock.

    async def watch(self) -> None:
        dut, place, sclk_before, turn = self.dut, 0, 0, 0
        capture, stream = dut.captures.recorder, dut.streams.stream
        while True:
            await self._falling
            self.now += 1
            turn += 1
            if self.word("adc_cs_n_o"):
                place = 0
                frames = [code << 2 for code in self.codes]
            else:
                sclk = self.word("adc_sclk_o")
                place += sclk and not sclk_before
                sclk_before = sclk
            bits = [frame >> max(0, 15 - place) & 1 for frame in frames]
            self.drive(adc_sdata_i=pack(bits, 1))
            if turn % 32 == 0 and self.moving:
                self.move()
            self.listen()
            if self.now == self.ends:
                self.end()
            else:
                assert not int(dut.round.value)
            self.obey(capture)
            if int(stream.starts.value):
                self.streamed = []
            if int(dut.take.value) & 2:
                self.streamed.append(self.rounds[-1])
            if self.word("stream_valid_o"):
                if self.word("stream_first_o"):
                    self.bytes.clear()
                self.bytes.append(self.word("stream_byte_o"))
            if self.word("stream_packet_o"):
                self.packets.append(bytes(self.bytes))

    def move(self) -> None:
        """Other currents, another bus, rotors a count further."""
        rng, a, b = self.rng, 0, 0
        self.bus = rng.getrandbits(15)
        for n in range(N):
            self.codes[n] = min(4095, max(0, round(rng.gauss(MIDDLE, 300))))
            self.counts[n] += rng.choice((0, 0, 1, 1, -1) if self.counts[n] < 5 else (0, -1, -1, 1))
            phase = self.counts[n] & 3
            a |= (phase in (1, 2)) << n
            b |= (phase in (2, 3)) << n
        self.drive(bus_i=self.bus, enc_a_i=a, enc_b_i=b)

    def listen(self) -> None:
        """A live value, and the clock of its port's slot in which it came."""
        ports = self.dut.ports
        if int(ports.slot_valid.value):
            port = int(ports.slot_port.value)
            self.began[port] = self.now
            if port == 0:
                self.live = self.live if self.ends > self.now else {}
                self.seen["damped"] += int(ports.damp_wanted.value)
        if not self.word("live_valid") or 0 not in self.began:
            return
        name, port = NAMES[self.word("live_word")], self.word("live_port")
        data = self.word("live_data")
        when = self.now - self.began[port]
        later = 5 * SHAPER if name in ("voltage", "correction") else 0
        assert when in (WHEN[name] + later, DAMPED.get(name)), (name, when)
        value = data if name == "flags" else word32(data)
        assert (name, port) not in self.live or when == WHEN["offset"]
        self.last[name, port] = value
        self.live[name, port] = value & FLAGS_8 if name == "flags" else value
        if name == "flags":
            self.contact = self.contact & ~(1 << port) | (data & 1) << port
            if port == N - 1:
                self.ends = self.now + ENDS

    def end(self) -> None:
        """A round ends, and who wants it is given it."""
        dut = self.dut
        assert int(dut.round.value)
        faults = int(dut.faults.value)
        words = words_of_a_round(self.live)
        words |= {("bus", 0): self.bus, ("faults", 0): faults}
        self.live = {}
        self.rounds.append(words)
        takes = int(dut.take.value) & 1
        assert takes == self.model.active
        self.model.tick(Tick(words, self.contact, bool(faults)), bool(takes))

    def obey(self, capture: object) -> None:
        """The capture begins to do what it was told."""
        if int(capture.starts.value):
            self.model.obey(ORDERS["start"], self.given)
        elif int(capture.obeys.value):
            for name in ("trigger", "stop"):
                if int(getattr(capture, f"{name}s_q").value):
                    self.model.obey(ORDERS[name], self.given)

    # ---- Captures and streams.

    async def give(self, given: Settings) -> None:
        """Settings of a capture, committed while all goes on."""
        words = {f"capture_{name}": getattr(given, name) for name in (
            "channels", "rows", "pre", "decimation", "trigger", "level")}  # fmt: skip
        for n, code in enumerate(given.codes):
            assert await self.write(WORDS["capture_channel"].at(0, n), code) == DONE
        for name, raw in words.items():
            assert await self.write(WORDS[name].at(), raw & MASK) == DONE
        self.given = given
        assert await self.write(COMMIT, 1) == DONE

    async def expect_rows(self) -> None:
        """What the bus reads of the capture is the model's."""
        told = self.model.told_state
        found = {name: await self.value(WORDS[f"capture_{name[:-2]}"].at()) for name in told}
        assert found == told
        for place, value in self.model.memory().items():
            offset = self.rng.randint(max(0, place - 63), place)
            await self.command("capture_offset", offset)
            raw = await self.value(WORDS["capture_data"].at(0, place - offset))
            assert raw == value & MASK, (place, offset)

    def told(self, place: Place) -> int:
        """What a live register should read."""
        name, port = place.word.name, (place.address >> 8) - 1
        flags = self.last.get(("flags", port), 0)
        if name in FLAGS:
            return flags >> FLAGS[name] & 1
        if name == "flags":
            return flags & FLAGS_8
        if name in HELD or name in STEPPED:
            on = name in HELD or self.word("running_o")
            return self.last.get((name, port), 0) & MASK if on else 0
        inside = {"bus": "bus_i", "faults": "faults", "running": "running_o", "armed": "armed",
                  "zero_busy": "zero_busy_o", "arm_refused": "arm_refused",
                  "adc_ready": "adc_ready", "settings_busy": "busy"}  # fmt: skip
        if name in inside:
            return self.word(inside[name])
        if name == "zero_fault":
            return self.word("zero_fault_o") >> port & 1
        if name.startswith(("capture_", "stream_")):
            return self.word(name)
        return int(self.dut.registers.ticks_q.value) if name == "ticks" else 0


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def the_bridges_wait_to_be_armed(dut: object) -> None:
    """Off from reset on; a zero first; then until something ends it, whose reason is told."""
    bench = PortsDeviceBench(dut, random_source("arm"))
    mask = 1 << Fault.DRIVER | 1 << Fault.ZERO | 1 << Fault.ENCODER
    pin, fault, loading, zero, credit = range(len(ARM_REFUSALS))
    await bench.begin(guard_mask=mask, guard_damp=1 << Fault.ENCODER, guard_levels=3,
                      guard_zero=0xFFFF)  # fmt: skip
    await bench.expect_off()
    # The offset that is there is taken off.
    bench.codes = [MIDDLE + 50 + n for n in range(N)]
    await bench.step(2 * PERIOD)
    await bench.command("arm")
    await bench.step(9)
    assert await bench.value(WORDS["zero_busy"].at(N - 1)) == 1
    await bench.step(ZERO_CLOCKS)
    await bench.expect_armed()
    assert [bench.last["current", port] for port in range(N)] == [0] * N
    await bench.command("arm", 0)
    await bench.step(3)
    await bench.expect_off()
    await bench.step(press_i=1)
    await bench.step(ZERO_CLOCKS, press_i=0)
    await bench.expect_armed()
    bench.drive(enable_i=0)
    await bench.step(4)
    await bench.expect_off(pin)
    await bench.command("arm")
    await bench.step(4)
    await bench.expect_off(pin)
    bench.drive(enable_i=1)
    # A fault of any motor ends it, and refuses it as long as it is latched.
    await bench.arm()
    bench.drive(driver_fault_i=1 << N - 1)
    await bench.step(9)
    bench.drive(driver_fault_i=0)
    await bench.expect_off(fault)
    await bench.command("arm")
    await bench.step(4)
    await bench.expect_off(fault)
    assert await bench.value(WORDS["faults"].at()) == 1 << Fault.DRIVER
    # To clear it measures a zero, which is none: neither does arming permit.
    await bench.set({"zero_limit": 0})
    await bench.command("clear")
    await bench.step(4)
    assert await bench.value(WORDS["zero_busy"].at()) == 1
    await bench.step(ZERO_CLOCKS)
    assert [await bench.value(WORDS["zero_fault"].at(n)) for n in range(N)] == [1] * N
    await bench.command("arm")
    await bench.step(ZERO_CLOCKS)
    await bench.expect_off(zero)
    await bench.set({"zero_limit": MOST_ZERO})
    await bench.arm()
    # Settings that need the bridges off are refused, and the commit of one that waits.
    for place in SETTINGS:
        if place.word.change == "off":
            assert await bench.write(place.address, place.limits[0] & MASK) == NOT_NOW
    await bench.command("arm", 0)
    await bench.step(3)
    assert await bench.write(WORDS["guard_bus_min"].at(), 1) == DONE
    await bench.arm()
    assert await bench.write(COMMIT, 1) == NOT_NOW
    await bench.command("arm", 0)
    await bench.step(3)
    assert await bench.write(COMMIT, 1) == DONE
    await bench.command("arm")
    await bench.step(3)
    await bench.expect_off(loading)
    await bench.rests()
    # Damped it stays on. The credit is renewed, and then it isn't.
    await bench.arm()
    bench.drive(enc_a_i=MASK, enc_b_i=MASK)
    await bench.step(2 * PERIOD)
    await bench.command("arm", 2)
    await bench.step(CREDIT - 2 * PERIOD)
    await bench.expect_armed()
    assert bench.seen["damped"] > 1
    await bench.step(2 * PERIOD)
    await bench.expect_off(credit)
    assert not bench.watching.done()


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def a_commit_is_in_force_from_a_round_on(dut: object) -> None:
    """Gains of all ports, with the bridges on: each round has those of one commit."""
    bench, rng = PortsDeviceBench(dut, random_source("commit")), random_source("phases")
    await bench.begin()
    await bench.arm()
    bench.codes = [MIDDLE + 100] * N
    await bench.step(3 * PERIOD)
    gains, first = [1 << 20], len(bench.rounds)
    for number in range(1, 25):
        gains.append((number + 4) << 18)
        for motor in range(N):
            assert await bench.write(WORDS["gain"].at(motor), gains[-1]) == DONE
        await bench.step(rng.randrange(PERIOD))
        assert await bench.write(COMMIT, 1) == DONE
        await bench.rests()
        await bench.command("arm", 2)
    await bench.step(2 * PERIOD)
    one = bench.rounds[first]["current", 0]
    assert one > 0
    expected = [one * gain // gains[0] for gain in gains]
    found = [[words["current", n] for n in range(N)] for words in bench.rounds[first:]]
    numbers = [[expected.index(current) for current in each] for each in found]
    mixed = [each for each in numbers if len(set(each)) > 1]
    assert not mixed
    assert [each[0] for each in numbers] == sorted(each[0] for each in numbers)
    assert {each[0] for each in numbers} == set(range(25))
    assert not bench.watching.done()


@cocotb.test(timeout_time=400, timeout_unit="ms")
async def rows_and_packets_are_of_the_rounds(dut: object) -> None:
    """Captures with each trigger beside a stream, bridges on and off, damped, in contact."""
    rng = random_source("rows")
    bench = PortsDeviceBench(dut, rng)
    await bench.begin(guard_mask=1 << Fault.ENCODER, guard_damp=1 << Fault.ENCODER)
    for motor in range(N):
        await bench.set(ANCHOR, motor)
    bench.moving = True
    await bench.arm()
    found, pool = Counter(), [*CODES]
    for trigger in (*range(8), 0, 6, 7):
        codes, shifts = [rng.choice(pool) for _ in range(4)], [rng.choice((0, 8, 15))] * 4
        for n in range(4):
            assert await bench.write(WORDS["stream_channel"].at(0, n), codes[n]) == DONE
            assert await bench.write(WORDS["stream_shift"].at(0, n), shifts[n]) == DONE
        assert await bench.write(WORDS["stream_last"].at(), 3) == DONE
        channels = rng.randint(1, 8)
        rows = rng.randint(2, 64 // channels)
        await bench.give(Settings(
            [WORDS["position"].at()] + [rng.choice(pool) for _ in range(7)], channels, rows,
            rng.randrange(rows), rng.choice((0, 0, 1, 2)), trigger, rng.randint(3, 6),
        ))  # fmt: skip
        bench.packets = []
        await bench.command("stream")
        await bench.command("capture")
        await bench.command("arm", 1)
        waits = 0
        while await bench.value(WORDS["capture_state"].at()) != STOPPED:
            await bench.step(rng.randrange(4 * PERIOD))
            waits += 1
            await bench.command("arm", 2)
            if waits == 40 or trigger == 7:
                bench.drive(enc_a_i=MASK, enc_b_i=MASK)
                await bench.step(5)
            elif waits > 99:
                await bench.command("capture", ORDERS["trigger"])
        assert bench.model.state == STOPPED
        found[trigger] += waits <= 99
        await bench.expect_rows()
        while not bench.packets:
            await bench.step(PERIOD)
        for each in (packet(data) for data in bench.packets):
            ticks = bench.streamed[15 * each.number : 15 * each.number + 15]
            assert each.rows == [row(codes, shifts, [tick]) for tick in ticks]
        found["packets"] += len(bench.packets)
        await bench.command("stream", 0)
        if rng.random() < 0.3:
            await bench.command("arm", 0)
            await bench.command("clear")
            await bench.step(ZERO_CLOCKS)
    assert not bench.watching.done()
    cocotb.log.info("%s, %s, %d rounds", found, bench.seen, len(bench.rounds))
    assert min(found[trigger] for trigger in (1, 2, 3, 4, 5, 6, 7)) > 0
    assert bench.seen["damped"] > 10
    for name in {*STEPPED} - {"offset"}:
        assert sum(words[name, 0] != 0 for words in bench.rounds) > 100, name


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def every_live_register(dut: object) -> None:
    """What the device has in the request's clocks, or had in the clock before."""
    rng = random_source("live")
    bench = PortsDeviceBench(dut, rng)
    await bench.begin(guard_mask=1 << Fault.ENCODER, guard_damp=1 << Fault.ENCODER)
    bench.moving = True
    registers = [p for p in places(SIZES, "live") if p.word.name != "capture_data"]
    moved = Counter()
    for on in (1, 0, 1):
        await bench.command("arm", on)
        await bench.command("stream", 1)
        bench.drive(stream_room_i=0)
        await bench.give(Settings([WORDS["u"].at()] * 8, 1, 60, 20))
        await bench.command("capture")
        await bench.step(ZERO_CLOCKS)
        assert bench.word("running_o") == on
        for place in rng.sample(registers, len(registers)) * 2:
            before = bench.told(place)
            raw = await bench.value(place.address)
            told = {before, bench.told(place)} | (
                {before + 1} if place.word.name == "ticks" else set())  # fmt: skip
            assert raw in told, f"{place.word.name} 0x{place.address:03x}: {raw:x}, {told}"
            moved[place.word.name] += raw != 0
        await bench.step(30 * PERIOD)
        bench.drive(enc_a_i=MASK, enc_b_i=MASK)
        await bench.step(9)
    still = {place.word.name for place in registers} - {name for name, n in moved.items() if n}
    cocotb.log.info("always 0: %s", sorted(still))
    assert {"u", "position", "bus", "capture_count", "stream_lost", "armed"} & still == set()
    assert not bench.watching.done()
