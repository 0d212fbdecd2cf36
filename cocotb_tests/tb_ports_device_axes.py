# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_device.v`` with a brushless motor: its registers, and its three legs."""

from __future__ import annotations

import cocotb
from bench import random_source
from settings_bus import DONE, NOT_NOW
from simulators import parameters
from tb_device import DeviceBench
from tb_ports_device import MOST_ZERO, ZERO_CLOCKS, PortsDeviceBench
from wavehaptics.words.places import places
from wavehaptics.words.table import WORDS, Sizes

ALPHA = next(n for n in range(parameters()["N"]) if parameters()["AXES"] >> n & 1)
LIVE_PLACES = list(places(Sizes(parameters()["N"], 1), "live"))
ANGLE, ZERO_ANGLE = 0x0123_4567, 0x89AB_CDEF
HALF = 150


class AxesDeviceBench(PortsDeviceBench):
    """The device; a tick is a whole period of the carrier, and alpha has the motor's settings."""

    async def set(self, values: dict[str, int], motor: int = 0) -> None:
        if "tick_halves" in values:
            values = values | {"tick_halves": 2, "sample_clocks": 2 * HALF}
        await DeviceBench.set(self, values, motor)

    async def arm(self) -> None:
        await self.command("arm")
        await self.step(2 * ZERO_CLOCKS)
        await self.expect_armed()

    def legs(self) -> int:
        """High gates of the legs a, b and c."""
        highs = self.word("gate_ah_o") >> ALPHA, self.word("gate_bh_o") >> ALPHA
        return highs[0] & 1 | (highs[1] & 1) << 1 | (highs[0] >> 1 & 1) << 2


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def a_brushless_motor_has_its_registers(dut: object) -> None:
    """Those of the magnets, alpha's settings for both axes, live values of each, three legs."""
    bench = AxesDeviceBench(dut, random_source("brushless"))
    await bench.begin(zero_limit=MOST_ZERO, count_angle=ANGLE, zero_angle=ZERO_ANGLE, find_magnet=1)
    magnets = int(dut.magnets.value)
    assert magnets == 1 << 64 | ZERO_ANGLE << 32 | ANGLE
    start, found, angle = (WORDS[f"magnet_{name}"].at() for name in ("start", "found", "angle"))
    assert await bench.write(start, 1) == DONE
    await bench.step(20)
    assert await bench.value(found) == 0
    assert await bench.value(angle) == ZERO_ANGLE
    # An angle that is known is found.
    await bench.set({"find_magnet": 0})
    assert await bench.write(start, 1) == DONE
    await bench.step(20)
    assert await bench.value(found) == 1
    # Both axes have what alpha has, and beta's own gain.
    await bench.set({"u_max": 3 << 20, "root": 3 << 20, "gain": 5 << 20}, ALPHA)
    await bench.set({"u_max": 1 << 10, "gain": 7 << 20}, ALPHA + 1)
    bank = int(dut.in_force.value)
    core = dut.ports.core.settings.in_block_ram.words
    for axis in range(2):
        assert int(core[bank * len(core) // 2 + 4 * (ALPHA + axis) + 2].value) == 3 << 20
    gains = dut.ports.sense.gain_settings.in_luts.words
    lines = len(gains) // 2
    assert [int(gains[bank * lines + ALPHA + axis].value) for axis in range(2)] == [
        5 << 20,
        7 << 20,
    ]
    # On, the legs switch; then nothing begins anew.
    bench.moving = True
    await bench.arm()
    assert await bench.write(start, 1) == NOT_NOW
    seen = set()
    for _ in range(6 * HALF):
        await bench.step()
        seen.add(bench.legs())
    assert {0, 7} <= seen
    names = ("voltage", "u", "v", "current", "position")
    for axis in range(2):
        while bench.now != bench.ends + 1:
            await bench.step()
        for place in LIVE_PLACES:
            if place.word.name in names and place.address >> 8 == ALPHA + axis + 1:
                assert await bench.value(place.address) == bench.told(place), place.word.name
                assert bench.last[place.word.name, ALPHA + axis] or place.word.name == "position"
