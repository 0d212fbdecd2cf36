# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_device.v`` with a brushless motor whose axes take turns."""

from __future__ import annotations

import cocotb
from settings_bus import DONE, NOT_NOW
from tb_device import DeviceBench
from wavehaptics.words.table import AXES, WORDS

HALF = 150


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def its_pins_are_a_brushless_motors(dut: object) -> None:
    """Three legs switch, both axes have values, and the encoder is the motor's."""
    bench = DeviceBench(dut)
    await bench.begin(enable=1)
    bench.drive(enable_i=0)
    await bench.step(4)
    await bench.set({"find_magnet": 0, "count_angle": 1 << 24, "zero_angle": 1 << 30})
    assert await bench.write(WORDS["magnet_start"].at(), 1) == DONE
    await bench.step(4)
    bench.drive(enable_i=1, adc_sdata_i=0b01)  # phase a at the one end, b at the other
    seen: set[int] = set()
    position = 0
    for clock in range(40 * HALF):
        if clock % HALF == 0 and position < 5:
            position += 1
            phase = position & 3
            bench.drive(enc_a_i=phase in (1, 2), enc_b_i=phase in (2, 3))
        await bench.step()
        ports_a, ports_b = bench.word("gate_ah_o"), bench.word("gate_bh_o")
        seen.add(ports_a & 1 | (ports_b & 1) << 1 | (ports_a & 2) << 1)
        assert not ports_b & 2
    assert bench.word("running_o") == 1
    assert await bench.write(WORDS["magnet_start"].at(), 1) == NOT_NOW
    assert {0, 7} <= seen
    # Each leg goes on by itself as well.
    assert all(any(bool(legs & leg) != bool(legs & ~leg) for legs in seen) for leg in (1, 2, 4))
    for axis in range(AXES):
        for name in ("voltage", "u", "current"):
            assert await bench.value(WORDS[name].at(axis)), name
        assert await bench.value(WORDS["position"].at(axis)) == position
    assert await bench.value(WORDS["magnet_angle"].at()) == (1 << 30) + position * (1 << 24)
