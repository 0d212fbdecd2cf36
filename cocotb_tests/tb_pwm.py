# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_pwm.v``: the legs' pattern in every half of the carrier."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import cocotb
from bench import Bench, random_source
from simulators import parameters
from wavehaptics.words.bridge_modes import HALF_BRIDGE, LOCKED, MODE_WORDS, SIGN_MAGNITUDE, UNIPOLAR

MODES = parameters().get("MODES", 0)


@dataclass
class Half:
    """The legs in one half of the carrier, a level a clock."""

    width: int
    parity: int
    leg_a: list[int]
    leg_b: list[int]

    def check(self) -> None:
        """Mean, symmetry and zero vector of the unipolar mode."""
        clocks = len(self.leg_a)
        bridge = [a - b for a, b in zip(self.leg_a, self.leg_b, strict=True)]
        assert sum(bridge) == 2 * self.width
        assert bridge == bridge[::-1]
        assert self.leg_a == self.leg_a[::-1]
        assert self.leg_b == self.leg_b[::-1]
        assert set(bridge) <= {0, 1 if self.width > 0 else -1}
        for n in range(abs(self.width), clocks - abs(self.width)):
            assert self.leg_a[n] == self.leg_b[n] == self.parity


def switches(levels: list[int]) -> int:
    return sum(a != b for a, b in pairwise(levels))


@dataclass
class Period:
    """The legs in a period of the carrier, in the modes with one pulse."""

    mode: str
    width: int
    leg_a: list[int]
    leg_b: list[int]

    def check(self) -> None:
        """Mean voltage, symmetry, and what the legs may do."""
        half_clocks = len(self.leg_a) // 2
        if self.mode == HALF_BRIDGE:
            bridge = [2 * a - 1 for a in self.leg_a]
        else:
            bridge = [a - b for a, b in zip(self.leg_a, self.leg_b, strict=True)]
        assert sum(bridge) == 4 * self.width
        # An odd clock is the period's last.
        odd = self.mode != SIGN_MAGNITUDE and half_clocks % 2
        whole = bridge[:-1] if odd else bridge
        assert whole == whole[::-1]
        assert switches(bridge) <= 2
        if self.mode == SIGN_MAGNITUDE:
            assert set(bridge) <= {0, 1 if self.width > 0 else -1}
            assert len(set(self.leg_b)) == 1
        elif self.mode == LOCKED:
            assert all(a != b for a, b in zip(self.leg_a, self.leg_b, strict=True))


class PwmBench(Bench):
    """Plays the carrier."""

    mode = UNIPOLAR

    async def half(self, clocks: int, parity: int, width: int, next_width: int) -> Half:
        """One half with ``width``; the legs are read one clock after their phase."""
        shown = Half(width, parity, [], [])
        for phase in range(clocks):
            await self.step(
                phase_i=phase,
                remaining_i=clocks - 1 - phase,
                half_i=parity,
                update_i=int(phase == clocks - 1),
                width_i=next_width,
            )
            shown.leg_a.append(self.word("leg_a_o"))
            shown.leg_b.append(self.word("leg_b_o"))
        if self.mode == UNIPOLAR:
            shown.check()
        return shown

    async def run(self, clocks: int, widths: list[int]) -> list[Half]:
        """Halves of ``clocks`` clocks with the given widths, after one of width 0 from reset."""
        idle = {"phase_i": 0, "remaining_i": 1, "half_i": 0, "update_i": 0, "width_i": 0}
        await self.start(mode_i=MODE_WORDS[self.mode], half_clocks_i=clocks, **idle)
        widths = [0, *widths]
        halves = []
        for n, width in enumerate(widths):
            following = widths[n + 1] if n + 1 < len(widths) else 0
            halves.append(await self.half(clocks, n % 2, width, following))
        return halves


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def mean_is_the_width(dut: object) -> None:
    """Every width of a carrier, even and odd: the mean is right and the half symmetric."""
    bench = PwmBench(dut)
    for clocks in (4, 24, 25):
        limit = clocks // 2
        halves = await bench.run(clocks, [w for w in range(-limit, limit + 1) for _ in range(2)])
        assert len(halves) == 2 * (2 * limit + 1) + 1


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def switches_twice_in_a_period(dut: object) -> None:
    """While the width keeps its sign, a leg switches at most twice in a carrier period."""
    bench = PwmBench(dut)
    rng = random_source("widths")
    clocks = 20
    for sign in (1, -1):
        halves = await bench.run(clocks, [sign * rng.randint(0, 10) for _ in range(120)])
        for leg, busy_half in (("leg_a", int(sign < 0)), ("leg_b", int(sign > 0))):
            # A leg's period runs between the middles of the halves in which it leaves its rail.
            levels = [level for half in halves for level in getattr(half, leg)]
            middle = busy_half * clocks + clocks // 2
            counts = [
                switches(levels[start : start + 2 * clocks + 1])
                for start in range(middle, len(levels) - 2 * clocks, 2 * clocks)
            ]
            assert max(counts) == 2
            assert len(counts) > 50


@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not MODES)
async def one_pulse_a_period(dut: object) -> None:
    """The other modes: every width, and random ones; what comes in a period's middle is ignored."""
    bench = PwmBench(dut)
    rng = random_source("modes")
    for bench.mode in (LOCKED, SIGN_MAGNITUDE, HALF_BRIDGE):
        for clocks in (6, 24, 25, 1023):
            limit = clocks // 2
            widths = list(range(-limit, limit + 1))
            if clocks > 100:
                widths = [-limit, -limit // 3, 0, limit // 5, limit]
            widths += [rng.choice((0, *widths)) for _ in range(60 if clocks < 100 else 8)]
            await bench.run(clocks, [])
            await bench.step(rst=1)
            bench.drive(rst=0)
            levels_a, levels_b, sign = [], [], 0
            for n, width in enumerate(widths[:-1]):
                # Before the first update_i the width is 0.
                now = width if n else 0
                stray = rng.randint(-limit, limit)
                halves = [
                    await bench.half(clocks, 0, now, stray),
                    await bench.half(clocks, 1, now, widths[n + 1]),
                ]
                period = Period(
                    bench.mode, now, halves[0].leg_a + halves[1].leg_a,
                    halves[0].leg_b + halves[1].leg_b,
                )  # fmt: skip
                period.check()
                if bench.mode == SIGN_MAGNITUDE:
                    # The sign rests through widths of 0.
                    sign = int(now < 0) if now else sign
                    assert period.leg_b[0] == sign
                levels_a += period.leg_a
                levels_b += period.leg_b
            # From the middle of a pulse to that of the next: twice each leg, the signs' changes
            # aside.
            for leg in (levels_a, levels_b):
                for start in range(0, len(leg) - 2 * clocks, 2 * clocks):
                    count = switches(leg[start : start + 2 * clocks])
                    assert count <= 2


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def random_widths_and_reset(dut: object) -> None:
    """Signs that change from half to half; a reset in mid-stream puts both legs low at once."""
    bench = PwmBench(dut)
    rng = random_source("signs")
    for _ in range(3):
        clocks = rng.randint(4, 60)
        limit = clocks // 2
        await bench.run(clocks, [rng.randint(-limit, limit) for _ in range(60)] + [limit])
        await bench.step(rst=1)
        assert (bench.word("leg_a_o"), bench.word("leg_b_o")) == (0, 0)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def widest_half(dut: object) -> None:
    """The longest half and the most negative width stay in their words."""
    bench = PwmBench(dut)
    clocks = 65535
    await bench.start(
        mode_i=0, half_clocks_i=clocks, phase_i=0, remaining_i=clocks - 1, half_i=0, update_i=1,
        width_i=-32767,
    )  # fmt: skip
    await bench.step(1)
    for phase, active in ((0, 1), (32766, 1), (32767, 0), (32768, 1), (65534, 1)):
        await bench.step(phase_i=phase, remaining_i=clocks - 1 - phase, update_i=0)
        assert (bench.word("leg_a_o"), bench.word("leg_b_o")) == (0, active)
