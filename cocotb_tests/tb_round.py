# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_round.v``: every word of a short format."""

from __future__ import annotations

import cocotb
from cocotb.triggers import Timer
from simulators import parameters


def nearest(value: int, shift: int) -> int:
    """``value / 2**shift`` rounded to nearest, halves away from zero."""
    magnitude = (abs(value) + (1 << (shift - 1))) >> shift
    return magnitude if value >= 0 else -magnitude


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def every_word(dut: object) -> None:
    width, shift = parameters()["IN_W"], parameters()["SHIFT"]
    for value in range(-(1 << (width - 1)), 1 << (width - 1)):
        dut.value_i.value = value & ((1 << width) - 1)
        await Timer(1, unit="ns")
        assert dut.value_o.value.to_signed() == nearest(value, shift), value
