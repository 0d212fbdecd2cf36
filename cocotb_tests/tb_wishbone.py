# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_wishbone.v`` in front of ``rtl/wh_device.v``: classic Wishbone cycles."""

from __future__ import annotations

import cocotb
from bench import Bench, random_source
from settings_bus import BUSY, COMMIT, DISCARD, STAGED
from simulators import parameters
from wavehaptics.runtime.repository import ROOT as ROOT_DIR
from wavehaptics.words.places import places
from wavehaptics.words.table import WORDS, Sizes

SIZES = Sizes(walls={"WALLS": 1, **parameters()}["WALLS"])
SETTINGS = list(places(SIZES, "setting"))
MASK = 0xFFFFFFFF
WHOLE = 0b1111
ROOT, A = WORDS["root"].at(), WORDS["a"].at()
UNKNOWN = 0xFF0
READY_CLOCKS = 20_000
ANSWER_CLOCKS = 6
"""From the clock in which a cycle begins to that of its answer, with nothing being copied."""
COPY_CLOCKS = 3


class WishboneBench(Bench):
    """A master that counts what it gets, and checks the rules of each answer."""

    answers = 0
    read_data: int | None = None
    """Of the last ack of a read."""

    async def begin(self) -> None:
        await self.start(cyc_i=0, stb_i=0, we_i=0, adr_i=0, dat_i=0, sel_i=WHOLE)
        await self.read(BUSY, READY_CLOCKS)
        await self.rests()

    def idle(self) -> None:
        self.drive(cyc_i=0, stb_i=0)

    async def clock(self) -> tuple[int, int]:
        """(ack, err) of the coming clock, before its end."""
        await self.settle()
        found = self.word("ack_o"), self.word("err_o")
        if found[0]:
            self.read_data = self.word("dat_o") if not self.word("we_i") else None
        assert found != (1, 1)
        self.answers += sum(found)
        await self.step()
        return found

    async def cycle(
        self, address: int, data: int | None = None, sel: int = WHOLE, most: int = ANSWER_CLOCKS,
    ) -> tuple[int, int]:  # fmt: skip
        """(1 if it ended with err, clocks from its beginning to the answer); stb_i stays high."""
        self.drive(
            cyc_i=1, stb_i=1, we_i=data is not None, adr_i=address, dat_i=data or 0, sel_i=sel
        )
        for clocks in range(most + 1):
            ack, err = await self.clock()
            if ack or err:
                return err, clocks
        raise AssertionError(f"no answer from 0x{address:03x} in {most} clocks")

    async def read(self, address: int, most: int = ANSWER_CLOCKS) -> int:
        err, _ = await self.cycle(address, most=most)
        data = self.read_data
        assert not err, hex(address)
        assert data is not None
        self.idle()
        assert await self.clock() == (0, 0)
        return data

    async def rests(self) -> None:
        for _ in range(READY_CLOCKS):
            if not await self.read(BUSY, ANSWER_CLOCKS + COPY_CLOCKS):
                return
        raise AssertionError("the settings are busy")

    async def commit(self) -> None:
        err, _ = await self.cycle(COMMIT, 1)
        assert not err
        self.idle()
        await self.step()
        await self.rests()


@cocotb.test()
async def every_setting_is_written_and_read(dut: object) -> None:
    """The ends of its range, back to back; beyond them err, and what stood there stays."""
    bench = WishboneBench(dut)
    await bench.begin()
    written = {}
    for place in SETTINGS:
        for raw in place.outside:
            assert await bench.cycle(place.address, raw & MASK) == (1, ANSWER_CLOCKS)
        raw = place.limits[len(written) % 2] & MASK
        assert await bench.cycle(place.address, raw) == (0, ANSWER_CLOCKS)
        written[place.address] = raw
    await bench.commit()
    for address, raw in written.items():
        assert await bench.read(address) == raw, hex(address)
    assert len(written) > 80


@cocotb.test()
async def what_is_not_there_ends_with_err(dut: object) -> None:
    bench = WishboneBench(dut)
    await bench.begin()
    assert await bench.cycle(UNKNOWN) == (1, ANSWER_CLOCKS)
    assert await bench.cycle(UNKNOWN, 1) == (1, ANSWER_CLOCKS)
    assert await bench.cycle(COMMIT) == (1, ANSWER_CLOCKS)  # a command can't be read
    assert await bench.cycle(BUSY, 1) == (1, ANSWER_CLOCKS)  # nor a live value written


@cocotb.test()
async def a_partial_write_is_refused(dut: object) -> None:
    """By err, a clock after it began, with nothing written; a partial read returns it all."""
    bench = WishboneBench(dut)
    await bench.begin()
    before = await bench.read(ROOT)
    for sel in range(WHOLE):
        assert await bench.cycle(ROOT, before + 1, sel) == (1, 1)
        assert await bench.cycle(ROOT, sel=sel) == (0, ANSWER_CLOCKS)
        assert bench.read_data == before
    await bench.commit()
    assert await bench.read(ROOT) == before


@cocotb.test()
async def stb_or_cyc_alone_is_no_cycle(dut: object) -> None:
    bench = WishboneBench(dut)
    await bench.begin()
    before = bench.answers
    for cyc, stb in ((0, 1), (1, 0)):
        bench.drive(cyc_i=cyc, stb_i=stb, we_i=1, adr_i=ROOT, dat_i=1)
        for _ in range(2 * ANSWER_CLOCKS):
            assert await bench.clock() == (0, 0)
    assert bench.answers == before


@cocotb.test()
async def a_cycle_that_is_given_up_writes_nothing(dut: object) -> None:
    """After each number of clocks, by cyc or stb; what follows at once has its own answer."""
    bench = WishboneBench(dut)
    await bench.begin()
    value, other = await bench.read(ROOT), await bench.read(A)
    assert value != other
    for pin in ("cyc_i", "stb_i"):
        for held in range(1, ANSWER_CLOCKS):
            for pause in (1, 3, 2 * ANSWER_CLOCKS):
                bench.drive(cyc_i=1, stb_i=1, we_i=1, adr_i=ROOT, dat_i=value + 1, sel_i=WHOLE)
                for _ in range(held):
                    assert await bench.clock() == (0, 0)
                bench.drive(**{pin: 0})
                for _ in range(pause):
                    assert await bench.clock() == (0, 0)
                err, _ = await bench.cycle(A, most=2 * ANSWER_CLOCKS)
                assert (err, bench.read_data) == (0, other), (pin, held, pause)
                assert await bench.read(STAGED) == 0, (pin, held, pause)
    await bench.commit()
    assert await bench.read(ROOT) == value
    bench.drive(cyc_i=1, stb_i=1, we_i=1, adr_i=ROOT, dat_i=value + 1, sel_i=WHOLE)
    for _ in range(ANSWER_CLOCKS):
        assert await bench.clock() == (0, 0)
    bench.idle()  # in the very clock of the answer
    assert await bench.clock() == (0, 0)
    await bench.commit()
    assert await bench.read(ROOT) == value + 1


@cocotb.test()
async def a_reset_ends_a_cycle(dut: object) -> None:
    """In any clock of it; the first one after it waits until the device is ready."""
    bench = WishboneBench(dut)
    await bench.begin()
    value = await bench.read(ROOT)
    for held in range(1, ANSWER_CLOCKS + 1):
        bench.drive(cyc_i=1, stb_i=1, we_i=1, adr_i=ROOT, dat_i=value + 1, sel_i=WHOLE)
        for _ in range(held):
            assert await bench.clock() == (0, 0)
        bench.idle()
        await bench.step(rst=1)
        bench.drive(rst=0)
        assert not bench.word("ready_o")
        err, clocks = await bench.cycle(ROOT, most=READY_CLOCKS)
        assert (err, bench.read_data) == (0, value)
        assert clocks > 2 * ANSWER_CLOCKS


@cocotb.test()
async def any_master(dut: object) -> None:
    """Random cycles, held, given up, partial: what reads back is what got ack last."""
    rng, bench = random_source("wishbone"), WishboneBench(dut)
    await bench.begin()
    places_ = [place for place in SETTINGS if place.word.change != "off"]
    held = {place.address: await bench.read(place.address) for place in places_}
    staged = dict(held)
    counts = dict.fromkeys(("ack", "err", "given up", "commit"), 0)
    for _ in range(1_000):
        place, sel = rng.choice(places_), rng.choice((WHOLE, WHOLE, WHOLE, rng.randrange(WHOLE)))
        kind = rng.random()
        if kind < 0.1:
            bench.drive(cyc_i=1, stb_i=1, we_i=1, adr_i=place.address, dat_i=0, sel_i=WHOLE)
            for _ in range(rng.randrange(1, ANSWER_CLOCKS)):
                assert await bench.clock() == (0, 0)
            bench.idle()
            for _ in range(rng.randrange(1, ANSWER_CLOCKS)):
                assert await bench.clock() == (0, 0)
            counts["given up"] += 1
        elif kind < 0.6:
            low, high = place.limits
            raw = rng.choice((*place.outside, low, high, rng.randint(low, high)))
            err, _ = await bench.cycle(place.address, raw & MASK, sel, 2 * ANSWER_CLOCKS)
            assert err == (sel != WHOLE or not low <= raw <= high)
            if not err:
                staged[place.address] = raw & MASK
            counts["err" if err else "ack"] += 1
        elif kind < 0.98:
            err, _ = await bench.cycle(place.address, sel=sel, most=2 * ANSWER_CLOCKS)
            assert (err, bench.read_data) == (0, staged[place.address])
        else:
            await bench.cycle(*rng.choice(((COMMIT, 1), (DISCARD, 1))), most=2 * ANSWER_CLOCKS)
            committed = bench.word("adr_i") == COMMIT
            held = dict(staged) if committed else held
            staged = dict(held)
            bench.idle()
            await bench.step()
            await bench.rests()
            counts["commit"] += 1
        if rng.random() < 0.3:
            bench.idle()
            await bench.step(rng.randrange(1, 4))
    assert min(counts.values()) > 10, counts


WAVE = ("cyc_i", "we_i", "ack_o", "err_o", "valid", "ready")


@cocotb.test()
async def the_page_shows_these_cycles(dut: object) -> None:
    """``docs/use_in_your_design.md``: a write, a read right after it, a pause, a partial write."""
    bench = WishboneBench(dut)
    await bench.begin()
    levels: dict[str, list[int]] = {name: [] for name in WAVE}

    async def clocks(count: int, **inputs: int) -> None:
        bench.drive(**inputs)
        for _ in range(count):
            await bench.settle()
            for name in WAVE:
                levels[name].append(bench.word(name))
            await bench.step()

    on = {"cyc_i": 1, "stb_i": 1, "sel_i": WHOLE}
    off = {"cyc_i": 0, "stb_i": 0, "we_i": 0}
    await clocks(1, **off)
    await clocks(ANSWER_CLOCKS + 1, **on, we_i=1, adr_i=ROOT, dat_i=1 << 20)
    await clocks(ANSWER_CLOCKS + 1, **on, we_i=0)
    await clocks(2, **off)
    await clocks(2, **{**on, "sel_i": 1}, we_i=1)
    await clocks(1, **off)
    count = len(levels["cyc_i"])
    shown = {"cyc_i": "cyc_i, stb_i", "valid": "bus_valid_o", "ready": "bus_ready_i"}
    lines = ["clock".ljust(14) + "".join(f"{n:<3}" for n in range(count)).rstrip()]
    for name, row in levels.items():
        bits = "".join("‾‾‾" if level else "___" for level in row)
        lines.append(shown.get(name, name).ljust(14) + bits)
    wave = "\n".join(lines)
    page = (ROOT_DIR / "docs" / "use_in_your_design.md").read_text(encoding="utf-8")
    assert f"```\n{wave}\n```\n" in page, f"the page's waveform is another; this is it:\n{wave}"
