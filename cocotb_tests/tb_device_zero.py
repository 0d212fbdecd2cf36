# SPDX-License-Identifier: Apache-2.0
"""Bench of what measures the zero of the currents: arming, clear and zero_start (bench_zero.v)."""

from __future__ import annotations

import cocotb
from bench import pack
from settings_bus import COMMIT, DONE, NOT_NOW, BusBench
from simulators import parameters
from wavehaptics.controller.guard import Fault
from wavehaptics.words import formats
from wavehaptics.words.faults import ARM_REFUSALS
from wavehaptics.words.table import WORDS

_P = {"AXES": 0, "N": 1, "ARM": 1, "ZERO_LOG2": 3, **parameters()}
BRUSHLESS = _P["AXES"] != 0
LINES = _P["N"]
ARM = _P["ARM"]
HALVES = 2 if BRUSHLESS else 1
TICK = 96
ZERO_CLOCKS = ((1 << _P["ZERO_LOG2"]) + 6) * TICK
MIDDLE = 1 << 11
UNIT = 1 << (formats.SAMPLE_W - 12)
"""Of a sum, one step of the ADC."""
LIMIT = 60 * UNIT
GOOD, BAD = 50, 100
"""Offsets in steps of the ADC."""
ZERO_REFUSED = 1 << ARM_REFUSALS.index("no permitted zero of the currents was found")


class ZeroBench(BusBench):
    """A device whose currents have an offset."""

    async def begin(self, mask: int = 1 << Fault.ZERO, **guard: int) -> None:
        self.drive(code_i=self.codes(0))
        await super().begin(enable_i=0, clear_i=0, zero_start_i=0, press_i=0)
        await self.request(0, WORDS["settings_busy"].at(), 0, 20_000)
        await self.rests()
        words = {
            "half_clocks": TICK // HALVES, "tick_halves": HALVES, "sample_clocks": TICK,
            "zero_limit": LIMIT, "guard_mask": mask, "guard_zero": 0xFFFF, **guard,
        }  # fmt: skip
        for line in range(LINES):
            words_of = {"gain": 1 << 14}
            if not (line and BRUSHLESS):
                words_of |= {"root": 1 << 22, "a": 1 << 24, "u_max": 1 << 24,
                             "clocks_per_volt": 1 << 16}  # fmt: skip
            words_of |= {} if line else words
            for name, raw in words_of.items():
                assert await self.write(WORDS[name].at(line), raw) == DONE, name
        assert await self.write(COMMIT, 1) == DONE
        await self.rests()
        # The mask came before the limits.
        assert await self.command("clear") == DONE
        self.drive(enable_i=1)
        await self.step(ZERO_CLOCKS)

    @staticmethod
    def codes(offset: int, others: int | None = None) -> int:
        """Of all lines; ``others`` is that of the lines before the last."""
        rest = offset if others is None else others
        return pack([MIDDLE + rest] * (LINES - 1) + [MIDDLE + offset], 12)

    async def offset(self, steps: int, others: int | None = None) -> None:
        self.drive(code_i=self.codes(steps, others))
        await self.step(3 * TICK)

    async def word_of(self, name: str) -> int:
        return await self.value(WORDS[name].at())

    async def command(self, name: str, value: int = 1) -> int:
        return await self.write(WORDS[name].at(), value)

    async def arm(self, button: bool = False) -> None:
        if button:
            await self.step(press_i=1)
            self.drive(press_i=0)
        else:
            assert await self.command("arm") == DONE
        await self.step(ZERO_CLOCKS)

    async def expect_armed(self) -> None:
        assert await self.word_of("arm_refused") == 0
        assert (await self.word_of("armed"), await self.word_of("faults")) == (1, 0)
        assert self.word("running_o") == 1
        assert self.word("zero_fault_o") == 0
        assert self.word("fault_o") == 0

    async def expect_refused(self, reasons: int = ZERO_REFUSED) -> None:
        assert await self.word_of("arm_refused") == reasons, hex(await self.word_of("faults"))
        assert (await self.word_of("armed"), self.word("running_o")) == (0, 0)


@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not ARM)
async def arming_measures_anew(dut: object) -> None:
    """After a zero that was none: with a good sensor the next 1, or press, arms."""
    bench = ZeroBench(dut)
    for mask in (1 << Fault.ZERO, 0, 0xFFFF & ~(1 << Fault.STOP | 1 << Fault.DRIVER)):
        calm = {
            "guard_current": 0xFFFF, "guard_range": 0xFFFF, "guard_bus_max": 0xFFFF,
            "guard_heat": 0xFFFFFFFF, "guard_lost_ticks": 0xFFFF, "guard_host": 0xFFFFFF,
        }  # fmt: skip
        for button in (False, True):
            await bench.begin(mask & ~(1 << Fault.ADC_STUCK), **(calm if mask >> 8 else {}))
            others = 0 if LINES > 1 else None  # one of two phases is enough
            for _ in range(2):
                await bench.offset(BAD, others)
                await bench.arm(button)
                await bench.expect_refused()
                assert bench.word("zero_fault_o") == 1 << (LINES - 1)
                assert await bench.word_of("faults") == mask & 1 << Fault.ZERO
                assert not bench.word("fault_lasts_o")
            await bench.offset(GOOD)
            await bench.arm(button)
            await bench.expect_armed()
            assert abs(await bench.word_of("current")) < 1 << 20
            assert await bench.command("arm", 0) == DONE


@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not ARM)
async def clear_measures_anew(dut: object) -> None:
    """By its word and by its pin, with the bridges off; a zero that is none is a fault again."""
    bench = ZeroBench(dut)
    await bench.begin()

    async def clear(pin: bool) -> None:
        if pin:
            await bench.step(clear_i=1)
            bench.drive(clear_i=0)
        else:
            assert await bench.command("clear") == DONE
            await bench.step(3)
        assert bench.word("zero_busy_o") == 1
        assert bench.word("zero_fault_o") == 0
        await bench.step(ZERO_CLOCKS)
        assert bench.word("zero_busy_o") == 0

    for pin in (False, True):
        await bench.offset(BAD)
        await bench.arm()
        await bench.expect_refused()
        await clear(pin)
        assert await bench.word_of("faults") == 1 << Fault.ZERO
        await bench.offset(GOOD)
        await clear(pin)
        assert (await bench.word_of("faults"), bench.word("zero_fault_o")) == (0, 0)
        await bench.expect_refused()  # it is armed by a new 1 alone
        await bench.arm()
        await bench.expect_armed()
        # While the bridges are on nothing is measured.
        await bench.step(clear_i=1)
        bench.drive(clear_i=0)
        assert await bench.command("clear") == DONE
        await bench.step(TICK)
        assert bench.word("zero_busy_o") == 0
        await bench.expect_armed()
        assert await bench.command("arm", 0) == DONE
    # One that is held, as a board does while it wakes up, measures once.
    await bench.step(clear_i=1)
    await bench.step(ZERO_CLOCKS)
    assert bench.word("zero_busy_o") == 0
    bench.drive(clear_i=0)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def no_zero_is_measured_while_the_bridges_are_on(dut: object) -> None:
    """The command is refused, the pin does nothing, and the bridges stay on."""
    bench = ZeroBench(dut)
    await bench.begin()
    if ARM:
        await bench.arm()
    assert bench.word("running_o")
    for name in ("zero_start", "restart", *(("magnet_start",) if BRUSHLESS else ())):
        ticks = await bench.word_of("ticks")
        assert await bench.command(name) == NOT_NOW, name
        await bench.step(3 * TICK)
        assert (await bench.word_of("ticks") - ticks) * TICK >= 3 * TICK
    await bench.step(zero_start_i=1)
    bench.drive(zero_start_i=0)
    await bench.step(TICK)
    assert (bench.word("zero_busy_o"), bench.word("zero_fault_o")) == (0, 0)
    assert (bench.word("running_o"), await bench.word_of("faults")) == (1, 0)
    bench.drive(enable_i=0)
    await bench.step(4)
    for name in ("zero_start", "restart"):
        assert await bench.command(name) == DONE, name
    await bench.step(3)
    assert bench.word("zero_busy_o") == 1
    await bench.offset(BAD)
    await bench.step(ZERO_CLOCKS)
    assert await bench.word_of("faults") == 1 << Fault.ZERO
    await bench.offset(GOOD)
    assert await bench.command("zero_start") == DONE
    await bench.step(ZERO_CLOCKS)
    assert (bench.word("zero_fault_o"), await bench.word_of("faults")) == (0, 0)


@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not ARM)
async def a_current_at_rest_is_judged_by_the_new_zero(dut: object) -> None:
    """An offset that the guard takes for a current: arming measures it, and then it is none."""
    bench = ZeroBench(dut)
    await bench.begin(guard_zero=1, guard_zero_ticks=0)
    for line in range(LINES):
        assert await bench.write(WORDS["gain"].at(line), 1 << 22) == DONE
    assert await bench.write(COMMIT, 1) == DONE
    await bench.rests()
    for steps in (GOOD, -GOOD):
        await bench.offset(steps)
        assert await bench.word_of("faults") == 1 << Fault.ZERO
        assert (bench.word("fault_o"), bench.word("fault_lasts_o")) == (1, 0)
        await bench.arm()
        await bench.expect_armed()
        assert await bench.command("arm", 0) == DONE
        await bench.step(4 * TICK)
        assert await bench.word_of("faults") == 0
    # What then is there is a current: the bridges don't go on, or go off.
    await bench.offset(GOOD)
    assert await bench.word_of("faults") == 1 << Fault.ZERO
    assert await bench.command("clear") == DONE
    await bench.step(ZERO_CLOCKS)
    assert await bench.word_of("faults") == 0
